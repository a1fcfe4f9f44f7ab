//! Counts of a run, and findings about the equilibria along it.

use super::{Solution, Stability, TurningPoint};

/// Counts over a run.
#[derive(Clone, Copy, Debug, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Totals {
    pub steps: usize,
    /// Number of steps in stages in which masses move or viscous forces act
    #[serde(default)]
    pub in_time: usize,
    pub iterations: usize,
    /// Largest estimated correction of an accepted state, relative to its largest displacement \[–\]
    #[serde(default)]
    pub correction: f64,
    /// Accepted steps with iterations whose correction is not estimated: arc length, contact corrections, linearised steps
    #[serde(default)]
    pub without_correction: usize,
    /// Cuts of steps that did not converge
    pub cuts: usize,
    /// Steps that were solved but repeated in parts, because their time error was too large
    pub repeated: usize,
    /// Steps whose time error was too large but that could not be cut any further
    pub coarse: usize,
    /// Steps whose tangent had to be shifted towards positive definiteness
    pub regularised: usize,
    /// Steps that converged only with projected blocks
    pub projected: usize,
    /// Accepted states whose tangent had negative eigenvalues: beyond a bifurcation or a limit point
    pub unstable: usize,
    /// Accepted states where negative eigenvalues were not counted: the iterative method finds them only by chance
    #[serde(default)]
    pub uncounted: usize,
}

impl Totals {
    /// Adds an accepted step.
    pub(super) fn add(&mut self, solution: &Solution) {
        self.steps += 1;
        self.iterations += solution.iterations;
        self.correction = self.correction.max(solution.correction.unwrap_or(0.0));
        self.without_correction += usize::from(solution.correction.is_none() && solution.iterations > 0);
        self.regularised += usize::from(solution.regularised);
        self.projected += usize::from(solution.projected);
    }
}

/// Turning points and changes of stability along the path of equilibria.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Findings {
    /// Arc length: states at which the loads are largest or smallest
    pub turning_points: Vec<TurningPoint>,
    /// Static stages: time \[s\] and number of negative eigenvalues of the constrained tangent, wherever the number changes
    pub unstable: Vec<(f64, usize)>,
}

impl Findings {
    /// Records the stability of the accepted state at time `t` \[s\].
    pub(super) fn note(&mut self, totals: &mut Totals, is_static: bool, t: f64, stability: Stability) {
        match stability {
            Stability::NotJudged => {}
            Stability::NotCounted => totals.uncounted += 1,
            Stability::UnstableModes(modes) => {
                totals.unstable += usize::from(modes > 0);
                let known = self.unstable.last().map_or(0, |last| last.1);
                if is_static && modes != known {
                    self.unstable.push((t, modes));
                }
            }
        }
    }
}
