//! Settings of the steps: how often one is cut, where it starts, and its time error.

/// Halvings of a step that leave a millionth of a millionth of it: more are a slip.
pub const MOST_CUTS: u32 = 40;

/// Step control. The [`Driver`](super::Driver) hands it to the step strategies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSettings {
    /// A step is cut, which halves it, at most this often before the run stops, and not more often than [`MOST_CUTS`]. Read by the strategy of nominal steps (`cut_steps`),
    /// by arc length (`arc_length`), and by the search for the limit point that stopped a static run (`limit_points`)
    pub cuts: u32,
    /// Start each step from the extrapolation of the last ones
    pub extrapolate: bool,
    /// Largest error \[m\] that a dynamic step may make by itself; without it all steps are the nominal ones
    pub time_error: Option<f64>,
    /// Look for the reason why no step is possible, which may take longer than the run did so far; else the status is that of the last try
    pub diagnosis: bool,
}

impl Default for StepSettings {
    fn default() -> Self {
        Self { cuts: 10, extrapolate: true, time_error: None, diagnosis: true }
    }
}
