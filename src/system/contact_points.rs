//! Contact points for contact corrections, which first solve the equilibrium without contact, and then for the forces of the points on tangent
//! planes.

use super::Caches;
use super::friction::HISTORY;
use crate::math::tensor::{Mat3, Vec3, perpendicular};

/// The potential of a contact point per unit area, which decreases with the distance from the obstacle.
pub trait ContactPotential: Send + Sync {
    /// Distance beyond which the potential is zero \[m\].
    fn reach(&self) -> f64;
    /// φ \[J/m²\], φ′ and φ″ at the distance d \[m\]; `None` where it is not defined.
    fn potential(&self, d: f64) -> Option<[f64; 3]>;
}

/// The law of the normal force on a contact point.
#[derive(Clone, Copy)]
pub enum NormalLaw<'a> {
    /// 0 ≤ d ⟂ N ≥ 0, softened by a small compliance `yielding` = −d/N \[m/N\] of a pressed point
    Unilateral { yielding: f64 },
    /// N = −A φ′(d) with the area A \[m²\]
    Potential(&'a dyn ContactPotential, f64),
}

/// A contact point, with the tangent plane of its obstacle at the state of the search.
#[derive(Clone)]
pub struct ContactPoint<'a> {
    /// Nodes of the point, then those of the obstacle
    pub nodes: Vec<u32>,
    /// Weights s of the nodes: the distance changes by Σ_k s_k m·dz_k
    pub shares: Vec<f64>,
    /// Weights s for the material point in contact, on which friction acts: it slides by the part of Σ_k s_k dz_k across the normal
    pub spot: Vec<f64>,
    /// Weights s of the material point for the sliding over the step so far
    pub sliding: Vec<f64>,
    /// Distance d \[m\]
    pub gap: f64,
    /// Normal m = ∂d/∂x
    pub normal: Vec3,
    /// Normal force N at this state \[N\]
    pub force: f64,
    /// μ \[–\] and ε \[m\] if there is friction
    pub friction: Option<(f64, f64)>,
    /// Index of its elastic slip in the history of the friction effect; for points from [`System::contact_points`](super::System::contact_points), in
    /// the history of the state
    pub history: usize,
    /// Rotation of the obstacle, and of the elastic slip with it, since the start of the step
    pub turn: Mat3,
    pub law: NormalLaw<'a>,
}

impl ContactPoint<'_> {
    /// Distance beyond which there is no normal force \[m\].
    pub fn reach(&self) -> f64 {
        match self.law {
            NormalLaw::Unilateral { .. } => 0.0,
            NormalLaw::Potential(potential, _) => potential.reach(),
        }
    }

    /// Two unit vectors perpendicular to the normal and to each other.
    pub fn across(&self) -> [Vec3; 2] {
        let normal = self.normal.normalize();
        let one = perpendicular(&normal);
        [one, normal.cross(&one)]
    }

    /// Elastic slip of the point \[m\], from the history of a state.
    pub fn elastic_slip(&self, history: &[f64]) -> Vec3 {
        let epsilon = self.friction.map_or(0.0, |(_, epsilon)| epsilon);
        if epsilon == 0.0 {
            return Vec3::zeros();
        }
        self.turn * Vec3::from_column_slice(&history[self.history..][..HISTORY]) * epsilon
    }

    /// Σ_k s_k z_k \[m\] of displacements z, with weights of the nodes: its `shares`, its `spot` or its `sliding`.
    pub fn motion(&self, shares: &[f64], z: &[f64]) -> Vec3 {
        let of_node = |n: u32| Vec3::from_column_slice(&z[3 * n as usize..][..3]);
        self.nodes.iter().zip(shares).map(|(&n, s)| of_node(n) * *s).sum()
    }
}

/// An effect with contact points whose forces are solved for by corrections.
pub trait ContactPoints {
    /// Whether the points have friction.
    fn has_friction(&self) -> bool;
    /// The points at displacement x, for a step of `dt` \[s\], infinite in statics, from the displacement `old`. A unilateral contact returns all of
    /// its points; a contact with a potential returns those at a distance less than its reach plus `margin` \[m\].
    fn points(&self, x_old: [&[f64]; 2], dt: f64, margin: f64, caches: &mut Caches) -> Vec<ContactPoint<'_>>;
    /// Changes x so that the contact forces of the points become `forces` \[N\]. Forces that have a potential follow from x.
    fn set_forces(&self, _x: &mut [f64], _forces: &[f64], _caches: &mut Caches) {}
    /// A node whose straight motion from displacement `old` to x passes through its obstacle, and its distance at x \[m\].
    fn passed(&self, x_old: [&[f64]; 2], caches: &mut Caches) -> Option<(u32, f64)>;
    /// The points of a unilateral contact that are more than `depth` \[m\] inside the obstacle at displacement x.
    fn inside(&self, _x: &[f64], _depth: f64) -> Vec<ContactPoint<'_>> {
        Vec::new()
    }
}
