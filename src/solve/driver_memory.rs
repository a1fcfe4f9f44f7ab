//! The memory of a run between steps, which a checkpoint stores.

use super::{LaggedFactorRecord, Prediction, Totals};

/// The data that a driver keeps between steps in addition to the state.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct DriverMemory {
    pub prediction: Prediction,
    /// Current number of cuts of the nominal step
    pub cuts: u32,
    /// ‖diag K‖ of the last tangent \[N/m\]; entries with displacements longer than the body are scaled by displacement over body length
    pub stiffness: f64,
    pub lagged_factor: LaggedFactorRecord,
    pub totals: Totals,
}
