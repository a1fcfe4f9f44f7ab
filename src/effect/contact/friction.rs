//! Coulomb friction of the points of a contact: |F_t| ≤ μ N, opposite to the sliding.
//!
//! With the sliding over the step u = (I − nnᵀ) Σ_k s_k (z_k − z_k^old) and a smooth start of it, F_t = −μ N f(|u|/ε) u/|u|
//! with f of [`friction`](crate::system::friction). A point sticks while f < 1: it creeps by less than ε in a step.
//! s are the shares of the material in contact. Of a ball this is the spot −r n, as it was turned at the start of the step: the force has
//! a moment about the centre, and a ball rolls, with an error of second order in the angle of a step.
//! ε = stick velocity · Δt in dynamics, and a length in statics.
//!
//! N and n are those of the state itself, so friction obeys Coulomb's law at the end of every step. The tangent is that of a
//! fixed N and n: symmetric and positive semidefinite, at the cost of linear convergence (∂N/∂x is left out).
//! Energy: what the step dissipates, Σ F_t·u. Limits: a load slowly moves what sticks; isotropic; no viscosity.

use super::placement::displacement;
use super::{Contact, NormalForce, NormalForces};
use crate::math::tensor::{Mat3, Vec3};
use crate::system::friction::regularised;
use crate::system::{
    ActiveBlocks, At, BlockValues, Blocks, Caches, Capabilities, Effect, EnergyRole, EvalError, UnsymmetricTangent,
    Want,
};
use std::sync::Arc;

/// The law, with the smooth start of sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    /// μ \[–\]
    pub coefficient: f64,
    /// Of a point that sticks, at most \[m/s\]
    pub stick_velocity: f64,
    /// The same over a static step \[m\]
    pub slip: f64,
}

impl Coulomb {
    /// ε of a step of `dt` \[s\], which is infinite in statics \[m\].
    pub fn threshold(&self, dt: f64) -> f64 {
        if dt.is_finite() { self.stick_velocity * dt } else { self.slip }
    }

    /// Adds ∂F_t/∂N ∂N/∂x of a point that is pressed, which is not symmetric, to a block of `n` unknowns that begins with `nodes`.
    fn add_unsymmetric(&self, at: &At, nodes: &[u32], press: &NormalForce, n: usize, out: &mut BlockValues) {
        let epsilon = self.threshold(at.dt);
        if epsilon == 0.0 {
            return;
        }
        let u = sliding(at, nodes, press);
        let (ratio, _) = regularised(u.norm(), epsilon);
        let part = u * press.normal.transpose() * (-self.coefficient * ratio * press.stiffness);
        for (k, sk) in press.sliding.iter().enumerate() {
            for (l, sl) in press.shares.iter().enumerate() {
                for (i, j) in (0..9).map(|e| (e / 3, e % 3)) {
                    out.k[(3 * k + i) * n + 3 * l + j] += sk * sl * part[(i, j)];
                }
            }
        }
    }

    /// Adds what resists the sliding of a point that is pressed, to a block of `n` unknowns that begins with `nodes`.
    pub fn add(&self, at: &At, nodes: &[u32], press: &NormalForce, n: usize, want: Want, out: &mut BlockValues) {
        let epsilon = self.threshold(at.dt);
        // No time has passed, and nothing slides.
        if epsilon == 0.0 {
            return;
        }
        let u = sliding(at, nodes, press);
        let (limit, size) = (self.coefficient * press.force, u.norm());
        let (ratio, slope) = regularised(size, epsilon);
        out.energy += limit * ratio * size * size;
        for (k, s) in press.sliding.iter().enumerate() {
            (0..3).for_each(|i| out.r[3 * k + i] += limit * ratio * s * u[i]);
        }
        if want < Want::Tangent {
            return;
        }
        let along = u.try_normalize(0.0).unwrap_or(Vec3::zeros());
        let plane = Mat3::identity() - press.normal * press.normal.transpose();
        let stiff = (plane * ratio + along * along.transpose() * (slope - ratio)) * limit;
        for (k, sk) in press.sliding.iter().enumerate() {
            for (l, sl) in press.sliding[..=k].iter().enumerate() {
                for (i, j) in (0..9).map(|e| (e / 3, e % 3)) {
                    out.k[(3 * k + i) * n + 3 * l + j] += sk * sl * stiff[(i, j)];
                }
            }
        }
    }
}

/// (I − nnᵀ) Σ_k s_k (z_k − z_k^old)
fn sliding(at: &At, nodes: &[u32], press: &NormalForce) -> Vec3 {
    let u: Vec3 =
        nodes.iter().zip(&press.sliding).map(|(&k, s)| (displacement(at.x, k) - displacement(at.old, k)) * *s).sum();
    u - press.normal * press.normal.dot(&u)
}

pub struct ContactFriction {
    pub name: String,
    pub pressing: Arc<dyn NormalForces>,
    pub law: Coulomb,
}

impl ContactFriction {
    fn contact(&self) -> &Contact {
        self.pressing.contact()
    }

    /// The normal forces on point `b`, with the shares of the material in contact.
    fn presses(&self, at: &At, b: usize) -> Vec<NormalForce> {
        let mut presses = self.pressing.normal_forces(at.x, b);
        for press in &mut presses {
            press.sliding = self.contact().contact_shares([at.x, at.old], b, &press.normal, &press.shares);
        }
        presses
    }
}

impl Effect for ContactFriction {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Friction
    }

    fn blocks(&self) -> &Blocks {
        self.contact().blocks()
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let (nodes, n) = (self.blocks().nodes(b), self.blocks().size(b));
        for press in self.presses(at, b) {
            self.law.add(at, nodes, &press, n, want, out);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        let active: Option<&dyn ActiveBlocks> = if self.pressing.reach() < f64::INFINITY { Some(self) } else { None };
        Capabilities { active, unsymmetric: Some(self), on_contact_points: true, ..Capabilities::default() }
    }
}

impl UnsymmetricTangent for ContactFriction {
    fn eval(&self, at: &At, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        let (nodes, n) = (self.blocks().nodes(b), self.blocks().size(b));
        for press in self.presses(at, b) {
            self.law.add_unsymmetric(at, nodes, &press, n, out);
        }
        Ok(())
    }
}

impl ActiveBlocks for ContactFriction {
    fn active(&self, at: &At, caches: &mut Caches) -> Vec<u32> {
        self.contact().near(at.x, self.pressing.reach(), caches)
    }
}
