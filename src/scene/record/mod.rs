//! Records of a run: rows, fields, and the measured curves with which they are compared.

pub mod column;
pub(super) mod compare;
pub(super) mod extreme;
pub(super) mod extreme_rows;
pub(super) mod features;
pub(super) mod fields;
pub(super) mod frame_motion;
pub(super) mod measured_curve;
pub mod output;
pub(super) mod recorded;
pub(super) mod recorder;
mod stress_recovery;
pub mod stretch;
pub(super) mod winding;
