//! Coulomb friction of the points of a contact: |F_t| ≤ μ N, opposite to the sliding.
//!
//! As in plasticity, sliding is split into an elastic part, which the friction holds, and a permanent part (Simo & Laursen, Comput. Struct. 42, 1992;
//! Wriggers, Computational Contact Mechanics, 2nd ed. 2006, ch. 5). With u the elastic slip at the end of the step if no part of it became permanent,
//!
//! ```text
//! u = (I − nnᵀ) (ε e + Σ_k s_k (z_k − z_k^old))      F_t = −μ N f(|u|/ε) u/|u|      e' = u/max(ε, |u|)
//! ```
//!
//! with f of [`friction`](crate::system::friction). A point sticks while f < 1: under a constant load it is displaced by less than ε, and it returns
//! when the load is removed. e is stored relative to ε, so that the force does not change when ε changes with the step. It rotates with the obstacle,
//! and is zero without a normal force.
//!
//! s are the shares of the material in contact. For a ball this is the spot −r n: the force acts where the spot is at the end of the step, with a
//! moment about the centre, so that the ball rolls; sliding is computed with the mean rotation over the step, with an error of second order in the
//! rotation per step. ε = stick velocity · Δt in dynamics, up to a bound, and a given length in statics. A sticking point oscillates on its elastic
//! slip: if ε decreases with Δt, time integration damps this oscillation; if it does not, a body slides further with each oscillation.
//!
//! N and n are those of the current state, so that friction satisfies Coulomb's law at the end of every step. The tangent is taken at fixed N and n:
//! symmetric and positive semidefinite, at the cost of linear convergence (∂N/∂x is left out). Energy: F_t·Δu of the step, with the force at its end;
//! at most μ N ε of the elastically stored energy of a point counts as dissipated in each cycle. A point with several contacts with an obstacle by
//! multipliers or a penalty has a separate elastic slip and friction for each. Limits: if several sides of an obstacle press on a point by a barrier,
//! it has one elastic slip, perpendicular to the sum of their forces; isotropic; no viscosity.

use super::placement::displacement;
use super::{Contact, NormalForce, NormalForces};
use crate::math::tensor::{Mat3, Vec3};
use crate::system::friction::{HISTORY, regularised};
use crate::system::{
    ActiveBlocks, At, BlockValues, Blocks, Caches, Capabilities, Effect, EnergyRole, EvalError, HistoryVariables,
    UnsymmetricTangent, Want,
};
use std::sync::Arc;

/// Coulomb's law with a regularised onset of sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    /// μ \[–\]
    pub coefficient: f64,
    /// Largest elastic slip of a point in dynamics, divided by the length of the step \[m/s\]
    pub stick_velocity: f64,
    /// Largest elastic slip of a point in statics \[m\]
    pub slip: f64,
    /// Largest elastic slip of a point in dynamics, for steps of any length \[m\]
    pub most: f64,
}

impl Coulomb {
    /// Returns ε \[m\] for a step of length `dt` \[s\], which is infinite in statics.
    pub fn threshold(&self, dt: f64) -> f64 {
        if dt.is_finite() { (self.stick_velocity * dt).min(self.most) } else { self.slip }
    }

    /// Adds ∂F_t/∂N ∂N/∂x of a point under pressure, which is unsymmetric, to a block of `n` unknowns that begins with `nodes`.
    fn add_unsymmetric(
        &self,
        at: &At,
        (nodes, slip): (&[u32], Vec3),
        press: &NormalForce,
        n: usize,
        out: &mut BlockValues,
    ) {
        if at.is_start() {
            return;
        }
        let epsilon = self.threshold(at.dt);
        let u = press.across(&(slip * epsilon + sliding(at, nodes, press)));
        let (ratio, _) = regularised(u.norm(), epsilon);
        let part = u * press.normal.transpose() * (-self.coefficient * ratio * press.stiffness);
        for (k, sk) in press.spot.iter().enumerate() {
            for (l, sl) in press.shares.iter().enumerate() {
                for (i, j) in (0..9).map(|e| (e / 3, e % 3)) {
                    out.k[(3 * k + i) * n + 3 * l + j] += sk * sl * part[(i, j)];
                }
            }
        }
    }

    /// Adds the friction force on a point under pressure to a block of `n` unknowns that begins with `nodes`; `slip` is its elastic slip relative to
    /// ε at the start of the step.
    pub fn add(
        &self,
        at: &At,
        (nodes, slip): (&[u32], Vec3),
        press: &NormalForce,
        n: usize,
        want: Want,
        out: &mut BlockValues,
    ) {
        // When no time has passed nothing slides, and the force is that of the elastic slip, whatever ε will be.
        let epsilon = if at.is_start() { 1.0 } else { self.threshold(at.dt) };
        let sliding = press.across(&sliding(at, nodes, press));
        let u = press.across(&slip) * epsilon + sliding;
        let (limit, size) = (self.coefficient * press.force, u.norm());
        let (ratio, slope) = regularised(size, epsilon);
        out.energy += limit * ratio * u.dot(&sliding);
        for (k, s) in press.spot.iter().enumerate() {
            (0..3).for_each(|i| out.r[3 * k + i] += limit * ratio * s * u[i]);
        }
        if want < Want::Tangent || at.is_start() {
            return;
        }
        let along = u.try_normalize(0.0).unwrap_or(Vec3::zeros());
        let plane = Mat3::identity() - press.normal * press.normal.transpose();
        let stiff = (plane * ratio + along * along.transpose() * (slope - ratio)) * limit;
        for (k, sk) in press.spot.iter().enumerate() {
            for (l, sl) in press.spot[..=k].iter().enumerate() {
                for (i, j) in (0..9).map(|e| (e / 3, e % 3)) {
                    out.k[(3 * k + i) * n + 3 * l + j] += sk * sl * stiff[(i, j)];
                }
            }
        }
    }

    /// Returns the elastic slip relative to ε of a point at the end of a step, given `slip` at its start: perpendicular to the sum of the forces,
    /// with the sliding along the largest of them. Zero if there is no normal force.
    pub fn advance<'a>(
        &self,
        at: &At,
        presses: impl Iterator<Item = (&'a [u32], &'a NormalForce)>,
        slip: Vec3,
    ) -> Vec3 {
        let (mut sum, mut largest) = (Vec3::zeros(), None::<(&[u32], &NormalForce)>);
        for (nodes, press) in presses {
            sum += press.normal * press.force;
            if largest.is_none_or(|(_, other)| press.force.abs() > other.force.abs()) {
                largest = Some((nodes, press));
            }
        }
        let (Some((nodes, press)), Some(normal)) = (largest, sum.try_normalize(0.0)) else { return Vec3::zeros() };
        let u = slip + sliding(at, nodes, press) / self.threshold(at.dt);
        let u = u - normal * normal.dot(&u);
        u / u.norm().max(1.0)
    }
}

/// Returns the elastic slip with this index at the start of a step, relative to ε, from the history of the friction.
pub fn elastic_slip(at: &At, number: usize) -> Vec3 {
    Vec3::from_column_slice(&at.history[HISTORY * number..][..HISTORY])
}

/// Returns Σ_k s_k (z_k − z_k^old).
fn sliding(at: &At, nodes: &[u32], press: &NormalForce) -> Vec3 {
    nodes.iter().zip(&press.sliding).map(|(&k, s)| (displacement(at.x, k) - displacement(at.old, k)) * *s).sum()
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

    /// An elastic slip of point `b` at the start of a step, relative to ε and rotated with the obstacle.
    fn slip(&self, at: &At, b: usize, number: usize) -> Vec3 {
        self.contact().obstacle.turn([at.x, at.old]) * elastic_slip(at, self.pressing.slips() * b + number)
    }

    /// The normal forces on point `b`, with the shares of the material in contact.
    fn presses(&self, at: &At, b: usize) -> Vec<NormalForce> {
        let mut presses = self.pressing.normal_forces(at.x, b);
        for press in &mut presses {
            [press.spot, press.sliding] =
                self.contact().contact_shares([at.x, at.old], b, &press.normal, &press.shares);
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
            self.law.add(at, (nodes, self.slip(at, b, press.slip)), &press, n, want, out);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        let active: Option<&dyn ActiveBlocks> = if self.pressing.reach() < f64::INFINITY { Some(self) } else { None };
        Capabilities {
            active,
            unsymmetric: Some(self),
            on_contact_points: true,
            history: Some(self),
            friction_of: Some(&self.contact().name),
            ..Capabilities::default()
        }
    }
}

impl HistoryVariables for ContactFriction {
    fn size(&self) -> usize {
        HISTORY * self.pressing.slips()
    }

    fn advance(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        let (presses, nodes) = (self.presses(at, b), self.blocks().nodes(b));
        for (number, new) in new.chunks_exact_mut(HISTORY).enumerate() {
            let own = presses.iter().filter(|press| press.slip == number).map(|press| (nodes, press));
            new.copy_from_slice(self.law.advance(at, own, self.slip(at, b, number)).as_slice());
        }
        Ok(())
    }

    fn advance_all(&self, at: &At, new: &mut [f64], caches: &mut Caches) -> Result<(), EvalError> {
        let (near, size) = (self.active(at, caches), self.size());
        new.fill(0.0);
        near.into_iter().try_for_each(|b| self.advance(at, b as usize, &mut new[size * b as usize..][..size]))
    }
}

impl UnsymmetricTangent for ContactFriction {
    fn eval(&self, at: &At, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        let (nodes, n) = (self.blocks().nodes(b), self.blocks().size(b));
        for press in self.presses(at, b) {
            self.law.add_unsymmetric(at, (nodes, self.slip(at, b, press.slip)), &press, n, out);
        }
        Ok(())
    }
}

impl ActiveBlocks for ContactFriction {
    fn active(&self, at: &At, caches: &mut Caches) -> Vec<u32> {
        self.contact().near(at.x, self.pressing.reach(), caches)
    }
}
