//! Contact points whose forces can be prescribed. Corrections solve the equilibrium without contact, with every obstacle as a plane, and
//! then set the contact forces.

use super::Caches;
use crate::math::tensor::Vec3;

/// A contact point, and the tangent plane of its obstacle at the state of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPoint {
    /// Nodes of the point, then those of the obstacle
    pub nodes: Vec<u32>,
    /// s: the distance changes by Σ_k s_k m·dz_k
    pub shares: Vec<f64>,
    /// d \[m\]
    pub gap: f64,
    /// m = ∂d/∂x
    pub normal: Vec3,
    /// N at this state \[N\]
    pub force: f64,
    /// μ \[–\] and ε \[m\], where there is friction
    pub friction: Option<(f64, f64)>,
}

impl ContactPoint {
    /// Σ_k s_k z_k of displacements \[m\].
    pub fn motion(&self, z: &[f64]) -> Vec3 {
        let of_node = |n: u32| Vec3::from_column_slice(&z[3 * n as usize..][..3]);
        self.nodes.iter().zip(&self.shares).map(|(&n, s)| of_node(n) * *s).sum()
    }
}

/// An effect whose forces on its points can be prescribed.
pub trait ContactPoints {
    /// Number of points.
    fn count(&self) -> usize;
    /// Whether the points have friction.
    fn has_friction(&self) -> bool;
    /// All points at displacement x, including distant ones, for a step of `dt` \[s\], which is infinite in statics.
    fn points(&self, x: &[f64], dt: f64, caches: &mut Caches) -> Vec<ContactPoint>;
    /// Changes x so that the contact forces of the points are these \[N\].
    fn set_forces(&self, x: &mut [f64], forces: &[f64], caches: &mut Caches);
}
