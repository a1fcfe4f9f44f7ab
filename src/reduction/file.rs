//! The file of a reduced model, `.durom`: a line with the format and the SHA-256 of all that follows, then the model as CBOR (RFC 8949).

use super::error::ModelFileError;
use super::model::ReducedModel;
use crate::storage::{self, DATA_LIMIT, sha256};
use std::path::Path;

const NAME: &str = "durometer reduced model";
const FORMAT: &str = "4";

impl ReducedModel {
    /// Returns the content of the model's file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut payload = Vec::new();
        ciborium::into_writer(self, &mut payload).expect("memory accepts every write");
        let mut bytes = format!("{NAME} {FORMAT} {}\n", sha256(&payload)).into_bytes();
        bytes.append(&mut payload);
        bytes
    }

    /// Writes the file whole or not at all, and refuses a model that could not be read back; returns its size in bytes.
    pub fn write(&self, file: &Path) -> Result<usize, ModelFileError> {
        if let Some(fact) = self.fault() {
            return Err(ModelFileError::Faulty { file: file.into(), fact });
        }
        let bytes = self.to_bytes();
        let unwritable = |e: std::io::Error| ModelFileError::Unwritable { file: file.into(), reason: e.to_string() };
        storage::write(file, &bytes).map_err(unwritable)?;
        Ok(bytes.len())
    }

    /// Reads a model from a file.
    pub fn read(file: &Path) -> Result<Self, ModelFileError> {
        let unreadable = |e: std::io::Error| ModelFileError::Unreadable { file: file.into(), reason: e.to_string() };
        Self::from_bytes(file, &storage::read(file, DATA_LIMIT).map_err(unreadable)?)
    }

    /// Reads a model from bytes; `file` is used in messages.
    pub fn from_bytes(file: &Path, bytes: &[u8]) -> Result<Self, ModelFileError> {
        let none = |fact: &str| ModelFileError::NotAModel { file: file.into(), fact: fact.into() };
        let damaged = |fact: String| ModelFileError::Damaged { file: file.into(), fact };
        let end =
            bytes.iter().take(200).position(|b| *b == b'\n').ok_or_else(|| none("it has no line with a format"))?;
        let head = std::str::from_utf8(&bytes[..end]).map_err(|_| none("its first line is not text"))?;
        let rest = head.strip_prefix(NAME).ok_or_else(|| none("its first line names another format"))?;
        let Some((found, digest)) = rest.trim().split_once(' ') else { return Err(none("its first line is cut off")) };
        if found != FORMAT {
            let (found, known) = (found.into(), FORMAT.into());
            return Err(ModelFileError::OtherFormat { file: file.into(), found, known });
        }
        let payload = &bytes[end + 1..];
        if sha256(payload) != digest {
            return Err(damaged("its contents are not those that were written".into()));
        }
        let model: Self = ciborium::from_reader(payload).map_err(|e| damaged(e.to_string()))?;
        model.fault().map_or(Ok(model), |fact| Err(damaged(fact.into())))
    }
}
