//! Settings of the steps: how often a step is cut, where it starts, and its time error.

/// Largest number of cuts that can be set. Forty halvings leave 1e-12 of a step; a larger number is a mistake.
pub const MOST_CUTS: u32 = 40;

/// Step control, which the [`Driver`](super::Driver) passes to the step strategies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSettings {
    /// Largest number of cuts of a step, each of which halves it, before the run stops; limited to [`MOST_CUTS`]. Used by the strategy of nominal
    /// steps (`cut_steps`), by arc length (`arc_length`), and by the search for the limit point that stopped a static run (`limit_points`)
    pub cuts: u32,
    /// Whether each step starts from the extrapolation of the last ones
    pub extrapolate: bool,
    /// Largest error \[m\] that one dynamic step may make; without it all steps are nominal
    pub time_error: Option<f64>,
    /// Whether the reason is searched for when no step is possible, which may take longer than the run so far; otherwise the status is that of the
    /// last attempt
    pub diagnosis: bool,
}

impl Default for StepSettings {
    fn default() -> Self {
        Self { cuts: 10, extrapolate: true, time_error: None, diagnosis: true }
    }
}
