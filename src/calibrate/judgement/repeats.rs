//! Modes of a test that several specimens repeat, and those of a single one.

use crate::calibrate::{Mode, Sample};
use std::collections::BTreeSet;

/// Modes of some samples by the number of their specimens.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Repeats {
    /// With two specimens or more
    pub repeated: Vec<Mode>,
    /// With one
    pub single: Vec<Mode>,
}

impl Repeats {
    /// Counts the specimens of each mode.
    pub fn of(samples: &[Sample]) -> Self {
        let specimens = |mode: Mode| {
            let own = samples.iter().filter(|s| s.mode == mode).map(|s| s.specimen);
            own.collect::<BTreeSet<usize>>().len()
        };
        let with = |wanted: fn(usize) -> bool| Mode::ALL.into_iter().filter(|m| wanted(specimens(*m))).collect();
        Self { repeated: with(|k| k > 1), single: with(|k| k == 1) }
    }
}
