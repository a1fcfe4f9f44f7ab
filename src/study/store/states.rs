//! The states of a case at the points of its time grid, `cases/<id>.states.cbor` (RFC 8949), for models that are built from them.

use crate::storage::{self, DATA_LIMIT};
use crate::study::store::case_files::STATES;
use crate::system::State;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// States; the first is that at the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KeptStates {
    /// \[states\] Time \[s\]
    pub t: Vec<f64>,
    /// \[states × unknowns\] Displacements and other unknowns
    pub x: Vec<Vec<f64>>,
    /// \[states × constraints\]
    pub lambda: Vec<Vec<f64>>,
}

impl KeptStates {
    pub fn add(&mut self, state: &State) {
        self.t.push(state.t);
        self.x.push(state.x.clone());
        self.lambda.push(state.lambda.clone());
    }

    /// Serialises the states to the bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        ciborium::into_writer(self, &mut bytes).expect("memory accepts every write");
        bytes
    }

    /// Reads the states of a case in a folder of results; the error says why there are none.
    pub fn read(dir: &Path, id: &str) -> Result<Self, String> {
        let path = dir.join("cases").join(format!("{id}.{STATES}"));
        let bytes = storage::read(&path, DATA_LIMIT).map_err(|e| format!("{}: {e}", path.display()))?;
        ciborium::from_reader(bytes.as_slice()).map_err(|e| format!("{}: {e}", path.display()))
    }
}
