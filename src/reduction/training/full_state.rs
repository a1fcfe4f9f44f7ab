//! States of the full model.

/// An equilibrium of the full model.
#[derive(Clone, Debug, PartialEq)]
pub struct FullState {
    /// Inputs \[SI\]
    pub inputs: Vec<f64>,
    /// \[unknowns\]
    pub x: Vec<f64>,
    /// \[constraints\]
    pub lambda: Vec<f64>,
    /// Values of the quantities of the model
    pub values: Vec<f64>,
}
