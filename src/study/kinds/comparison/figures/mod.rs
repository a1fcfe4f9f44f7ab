//! Figures of a comparison.

pub mod curves;
pub mod sequence;
