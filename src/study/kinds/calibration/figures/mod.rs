//! Figures of a calibration.

pub mod band;
pub mod curves;
