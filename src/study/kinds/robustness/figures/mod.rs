//! Figures of a robustness study.

pub mod failed;
pub mod matrix;
pub mod region;
