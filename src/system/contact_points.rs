//! Points that may touch, each as a plane, and whose forces can be given from outside: for corrections, which take contact out of the
//! equilibrium and put its forces back.

use super::System;
use crate::math::tensor::Vec3;

/// A point and the plane that its obstacle is for it, where it was looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPoint {
    /// Nodes of the point, then those of what it meets
    pub nodes: Vec<u32>,
    /// s: the distance changes by Σ_k s_k m·dz_k
    pub shares: Vec<f64>,
    /// d \[m\]
    pub gap: f64,
    /// m = ∂d/∂x
    pub normal: Vec3,
    /// N that it has at this state \[N\]
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

/// An effect whose forces on its points can be given from outside.
pub trait ContactPoints {
    /// Number of its points
    fn count(&self) -> usize;
    /// Has any of them friction?
    fn slides(&self) -> bool;
    /// All of them at displacement x, those that are far too, for a step of `dt` \[s\], which is infinite in statics
    fn touches(&self, x: &[f64], dt: f64) -> Vec<ContactPoint>;
    /// Makes x a state in which its points are pressed with these forces \[N\]
    fn press(&self, x: &mut [f64], forces: &[f64]);
}

impl System {
    fn touching(&self) -> impl Iterator<Item = &dyn ContactPoints> {
        self.effects.iter().filter_map(|e| e.touching())
    }

    /// All points of all effects whose forces can be given.
    pub fn touches_at(&self, x: &[f64], dt: f64) -> Vec<ContactPoint> {
        self.touching().flat_map(|effect| effect.touches(x, dt)).collect()
    }

    /// Presses these points, in their order, with forces N \[N\].
    pub fn press(&self, x: &mut [f64], mut forces: &[f64]) {
        for effect in self.touching() {
            let (own, rest) = forces.split_at(effect.count());
            effect.press(x, own);
            forces = rest;
        }
    }
}
