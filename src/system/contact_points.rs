//! Contact points, for corrections: these solve the equilibrium without contact, and then the forces of the points on planes.

use super::Caches;
use super::friction::HISTORY;
use crate::math::tensor::{Mat3, Vec3, perpendicular};

/// A potential of a contact point per area, which decreases with the distance from the obstacle.
pub trait ContactPotential: Send + Sync {
    /// No potential beyond this distance \[m\]
    fn reach(&self) -> f64;
    /// φ \[J/m²\], φ′, φ″ at the distance d \[m\]; None where it is not defined
    fn potential(&self, d: f64) -> Option<[f64; 3]>;
}

/// The law of the normal force on a contact point.
#[derive(Clone, Copy)]
pub enum NormalLaw<'a> {
    /// 0 ≤ d ⟂ N ≥ 0, but for a small `yielding` −d/N \[m/N\] of a point that is pressed
    Unilateral { yielding: f64 },
    /// N = −A φ′(d) with the area A \[m²\]
    Potential(&'a dyn ContactPotential, f64),
}

/// A contact point, and the tangent plane of its obstacle at the state of the search.
#[derive(Clone)]
pub struct ContactPoint<'a> {
    /// Nodes of the point, then those of the obstacle
    pub nodes: Vec<u32>,
    /// s: the distance changes by Σ_k s_k m·dz_k
    pub shares: Vec<f64>,
    /// s of the material in contact: friction acts on it, and it slides on by Σ_k s_k dz_k across the normal
    pub spot: Vec<f64>,
    /// s of it over the step so far
    pub sliding: Vec<f64>,
    /// d \[m\]
    pub gap: f64,
    /// m = ∂d/∂x
    pub normal: Vec3,
    /// N at this state \[N\]
    pub force: f64,
    /// μ \[–\] and ε \[m\], where there is friction
    pub friction: Option<(f64, f64)>,
    /// Place of its elastic slip in the history of the friction; from [`System::contact_points`](super::System::contact_points), in that of the state
    pub history: usize,
    /// How the obstacle has turned since the start of the step, and the elastic slip with it
    pub turn: Mat3,
    pub law: NormalLaw<'a>,
}

impl ContactPoint<'_> {
    /// No normal force beyond this distance \[m\].
    pub fn reach(&self) -> f64 {
        match self.law {
            NormalLaw::Unilateral { .. } => 0.0,
            NormalLaw::Potential(potential, _) => potential.reach(),
        }
    }

    /// Two directions across the normal, and across each other.
    pub fn across(&self) -> [Vec3; 2] {
        let normal = self.normal.normalize();
        let one = perpendicular(&normal);
        [one, normal.cross(&one)]
    }

    /// Its elastic slip \[m\] by the history of a state.
    pub fn elastic_slip(&self, history: &[f64]) -> Vec3 {
        let epsilon = self.friction.map_or(0.0, |(_, epsilon)| epsilon);
        if epsilon == 0.0 {
            return Vec3::zeros();
        }
        self.turn * Vec3::from_column_slice(&history[self.history..][..HISTORY]) * epsilon
    }

    /// Σ_k s_k z_k of displacements \[m\], with shares of the nodes: its `shares`, its `spot` or its `sliding`.
    pub fn motion(&self, shares: &[f64], z: &[f64]) -> Vec3 {
        let of_node = |n: u32| Vec3::from_column_slice(&z[3 * n as usize..][..3]);
        self.nodes.iter().zip(shares).map(|(&n, s)| of_node(n) * *s).sum()
    }
}

/// An effect whose forces on its points corrections solve for.
pub trait ContactPoints {
    /// Whether the points have friction.
    fn has_friction(&self) -> bool;
    /// The points at displacement x, for a step of `dt` \[s\], which is infinite in statics, from the displacement `old`. A unilateral contact has all of its points; one
    /// with a potential those whose distance is less than its reach and the `margin` \[m\].
    fn points(&self, x_old: [&[f64]; 2], dt: f64, margin: f64, caches: &mut Caches) -> Vec<ContactPoint<'_>>;
    /// Changes x so that the contact forces of these points are these \[N\]. Forces that have a potential follow from x.
    fn set_forces(&self, _x: &mut [f64], _forces: &[f64], _caches: &mut Caches) {}
    /// A node and its distance \[m\] at x where the straight motion from displacement `old` to x takes a point through its obstacle.
    fn passed(&self, x_old: [&[f64]; 2], caches: &mut Caches) -> Option<(u32, f64)>;
    /// The points of a unilateral contact that are deeper inside than `depth` \[m\] at displacement x.
    fn inside(&self, _x: &[f64], _depth: f64) -> Vec<ContactPoint<'_>> {
        Vec::new()
    }
}
