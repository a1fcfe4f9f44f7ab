//! The memory of a run from step to step, which a checkpoint holds.

use super::{LaggedFactorRecord, Prediction, Totals};

/// Everything that a driver remembers from step to step in addition to the state.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct DriverMemory {
    pub prediction: Prediction,
    /// Cuts of the nominal step at present
    pub cuts: u32,
    /// ‖diag K‖ of the last tangent \[N/m\], with displacements longer than the body as multiples of it
    pub stiffness: f64,
    pub lagged_factor: LaggedFactorRecord,
    pub totals: Totals,
}
