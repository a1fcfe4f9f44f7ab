//! From the text of a file to typed values, with every mistake at its line.

pub(crate) mod changes;
pub(super) mod kind;
pub(crate) mod name;
pub mod overrides;
pub(super) mod quantity;
pub(super) mod reader;
