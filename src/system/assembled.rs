//! The sums that an assembly fills.

use super::{Caches, EnergyRole};
use crate::math::low_rank::Pattern;
use crate::math::sparse::{FewEntries, SkewMatrix};
use std::sync::Arc;
use std::time::Duration;

/// Time spent in the evaluations of one effect or constraint.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    pub name: String,
    /// Role of an effect; `None` for a constraint
    pub role: Option<EnergyRole>,
    pub time: Duration,
    pub evaluations: usize,
}

/// Sums over all effects and constraints at one state, with the workspace of the run.
#[derive(Debug)]
pub struct Assembled {
    /// \[unknowns\] r(x) + λ ∂c/∂x \[N\]; at a prescribed dof, the reaction
    pub r: Vec<f64>,
    /// Values of K in `pattern` \[N/m\]
    pub k: Vec<f64>,
    /// Pattern of the system, extended by the pairs that transient blocks couple
    pub pattern: Arc<Pattern>,
    /// Slot in `pattern` of each entry of the system's pattern; empty while the two are the same
    pub(crate) widened: Vec<u32>,
    /// Skew part of the tangent, on the equations \[N/m\]; empty if no effect declares one
    pub skew: SkewMatrix,
    /// The tangent minus K and the skew part, on the equations \[N/m\]: the unsymmetric parts of
    /// [`Capabilities::unsymmetric`](super::Capabilities::unsymmetric). Filled only if `descending`
    pub remainder: FewEntries,
    /// \[equations\] Σ K_e d of the prescribed increment d, if one was given \[N\]
    pub increment_force: Vec<f64>,
    /// Per constraint: g = target + compliance λ − c
    pub g: Vec<f64>,
    /// Per constraint: ∂c/∂x · d of the prescribed increment d, if one was given
    pub increment_gap: Vec<f64>,
    /// Per constraint: \[equations\] ∂c/∂x on the free dofs
    pub gradient: Vec<Vec<f64>>,
    /// Largest sum Σ_e ‖r_e‖ of any effect \[N\]: the scale of the convergence test
    pub scale: f64,
    /// Per effect: its energy \[J\]
    pub energy: Vec<f64>,
    /// Per effect: dissipation of the step \[J\], in addition to the energy if the effect is dissipative
    pub dissipated: Vec<f64>,
    /// Whether the blocks of all tangents are projected to positive semidefinite ones
    pub projected: bool,
    /// Whether the blocks of effects that ask for it are projected, [`Capabilities::semidefinite`](super::Capabilities::semidefinite)
    pub descending: bool,
    /// Whether effects are left out whose forces on contact points are solved for by corrections,
    /// [`Capabilities::on_contact_points`](super::Capabilities::on_contact_points)
    pub without_contact_points: bool,
    /// Costs per effect, then per constraint
    pub costs: Vec<Cost>,
    /// Caches and counters of the run
    pub caches: Caches,
}

impl Assembled {
    /// Zero-filled sums for a system with this pattern.
    pub(super) fn new(unknowns: usize, equations: usize, pattern: Arc<Pattern>, costs: Vec<Cost>) -> Self {
        let effects = costs.iter().filter(|cost| cost.role.is_some()).count();
        let constraints = costs.len() - effects;
        Self {
            r: vec![0.0; unknowns],
            k: vec![0.0; pattern.nnz()],
            pattern,
            widened: Vec::new(),
            skew: SkewMatrix::default(),
            remainder: FewEntries::default(),
            increment_force: vec![0.0; equations],
            g: vec![0.0; constraints],
            increment_gap: vec![0.0; constraints],
            gradient: vec![vec![0.0; equations]; constraints],
            scale: 0.0,
            energy: vec![0.0; effects],
            dissipated: vec![0.0; effects],
            projected: false,
            descending: false,
            without_contact_points: false,
            costs,
            caches: Caches::default(),
        }
    }

    /// Zeroes the sums before an assembly; `nnz` is the size of the system's pattern if the tangent is wanted.
    pub(super) fn clear(&mut self, nnz: Option<usize>) {
        self.r.fill(0.0);
        self.increment_force.fill(0.0);
        self.increment_gap.fill(0.0);
        self.gradient.iter_mut().for_each(|gradient| gradient.fill(0.0));
        self.energy.fill(0.0);
        self.dissipated.fill(0.0);
        self.scale = 0.0;
        if let Some(nnz) = nnz {
            self.k.clear();
            self.k.resize(nnz, 0.0);
            self.skew.entries.clear();
            self.remainder.entries.clear();
        }
    }

    /// Restores the pattern of the system, so that the next tangent includes only the transient pairs of its own state.
    pub fn reset_pattern(&mut self, pattern: &Arc<Pattern>) {
        if !self.widened.is_empty() {
            self.pattern = pattern.clone();
            self.widened.clear();
        }
    }
}
