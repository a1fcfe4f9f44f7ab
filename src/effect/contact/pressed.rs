//! Contact by a pressure that is a function of the distance: Π = Σ_q W_q φ(d_q), p_q = −φ′(d_q).
//!
//! r_k = Σ_q W_q φ′ s_k m, K_kl = Σ_q W_q (φ″ s_k s_l m mᵀ + φ′ ∂²d/∂z_k∂z_l) with s, m of [`super::placement`].

use super::friction::Coulomb;
use super::placement::Pair;
use super::shape::{Shape, Witness};
use super::{Contact, NormalForce, NormalForces};
use crate::math::tensor::{Mat3, Vec3};
use crate::system::friction::HISTORY;
use crate::system::{
    ActiveBlocks, At, BlockValues, Blocks, Caches, Capabilities, ContactPoint, ContactPoints, ContactPotential, Effect,
    EnergyRole, EvalError, MotionLimit, NormalLaw, StepLimit, Want,
};
use std::sync::Arc;

/// Law of the pressure against the distance.
pub trait Response: ContactPotential {
    /// Returns the witnesses of a point at y in the frame of the shape, with a ball of this radius about it, each with the index of its elastic slip.
    fn witnesses(&self, shape: &Shape, y: &Vec3, radius: f64) -> Vec<(usize, Witness)>;
    /// Number of elastic slips of a point.
    fn slips(&self, shape: &Shape) -> usize;
    /// Whether no point may pass through the obstacle, so that motions are limited.
    fn limits_motion(&self) -> bool;
    /// Depth inside the obstacle over which the kink between two of its sides is rounded \[m\].
    fn rounding(&self) -> f64 {
        0.0
    }
}

pub struct Pressed<R> {
    pub contact: Arc<Contact>,
    pub response: R,
    /// Friction for contact corrections; in the equilibrium, friction is a separate effect
    pub friction: Option<Coulomb>,
}

impl<R: Response> Pressed<R> {
    /// Returns the pairs of point `b` at displacement x, each with the index of its elastic slip, and with φ, φ′, φ″ times W.
    fn pairs(&self, x: &[f64], b: usize) -> Result<Vec<(usize, Pair, [f64; 3])>, EvalError> {
        let point = &self.contact.points[b];
        let at = self.contact.position(x, b);
        let placed = self.contact.obstacle.at(x);
        let local = placed.local(&at);
        let crossed = |gap: f64| EvalError::Crossed { effect: self.contact.name.clone(), node: point.nodes[0], gap };
        let witnesses = self.response.witnesses(&self.contact.obstacle.shape, &local, point.radius);
        let pair = |(slip, w): &(usize, Witness)| {
            let pair = placed.pair(&at, w, point.radius);
            let potential = self.response.potential(pair.gap).ok_or_else(|| crossed(pair.gap))?;
            Ok((*slip, pair, potential.map(|v| v * point.area)))
        };
        witnesses.iter().map(pair).collect()
    }
}

impl<R: Response> Effect for Pressed<R> {
    fn name(&self) -> &str {
        &self.contact.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Contact
    }

    fn blocks(&self) -> &Blocks {
        self.contact.blocks()
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        for (_, pair, [energy, first, second]) in self.pairs(at.x, b)? {
            out.energy += energy;
            pair.add(&self.contact.points[b].weights, (first, second), self.contact.blocks().size(b), want, out);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            // A pressure on a round or sharp side rotates as a point slides along it: −p W ∂²d/∂y² is negative wherever there is contact.
            semidefinite: true,
            active: Some(self),
            contact_points: Some(self),
            on_contact_points: true,
            step_limit: self.response.limits_motion().then_some(self),
            ..Capabilities::default()
        }
    }
}

impl<R: Response> ActiveBlocks for Pressed<R> {
    fn active(&self, at: &At, caches: &mut Caches) -> Vec<u32> {
        self.contact.near(at.x, self.response.reach(), caches)
    }
}

impl<R: Response> StepLimit for Pressed<R> {
    fn max_step(&self, x: &[f64], dx: &[f64], caches: &mut Caches) -> Option<MotionLimit> {
        self.contact.max_step(x, dx, caches)
    }
}

impl<R: Response> ContactPoints for Pressed<R> {
    fn has_friction(&self) -> bool {
        self.friction.is_some()
    }

    fn points(&self, [x, old]: [&[f64]; 2], dt: f64, margin: f64, caches: &mut Caches) -> Vec<ContactPoint<'_>> {
        let Contact { points, obstacle, .. } = &*self.contact;
        let (placed, turn, slips) = (obstacle.at(x), obstacle.turn([x, old]), self.slips());
        let mut found = Vec::new();
        for b in self.contact.near(x, self.response.reach() + margin, caches) {
            let (at, point) = (self.contact.position(x, b as usize), &points[b as usize]);
            let local = placed.local(&at);
            let mut witnesses = self.response.witnesses(&obstacle.shape, &local, point.radius);
            if witnesses.is_empty() {
                witnesses.push((0, obstacle.shape.nearest(&local)));
            }
            found.extend(witnesses.iter().map(|(slip, witness)| {
                let pair = placed.pair(&at, witness, point.radius);
                let shares = pair.shares(&point.weights);
                let [spot, sliding] = self.contact.contact_shares([x, old], b as usize, &pair.normal, &shares);
                ContactPoint {
                    nodes: self.contact.blocks().nodes(b as usize).to_vec(),
                    spot,
                    sliding,
                    shares,
                    gap: pair.gap,
                    normal: pair.normal,
                    force: self.response.potential(pair.gap).map_or(0.0, |[_, first, _]| -first * point.area),
                    friction: self.friction.map(|law| (law.coefficient, law.threshold(dt))),
                    history: HISTORY * (slips * b as usize + slip),
                    turn,
                    law: NormalLaw::Potential(&self.response, point.area),
                }
            }));
        }
        found
    }

    fn passed(&self, [x, old]: [&[f64]; 2], caches: &mut Caches) -> Option<(u32, f64)> {
        if self.response.limits_motion() {
            return None;
        }
        self.contact.passed([old, x], self.response.rounding(), caches)
    }
}

impl<R: Response> NormalForces for Pressed<R> {
    fn contact(&self) -> &Contact {
        &self.contact
    }

    fn reach(&self) -> f64 {
        self.response.reach()
    }

    fn slips(&self) -> usize {
        self.response.slips(&self.contact.obstacle.shape)
    }

    fn normal_forces(&self, x: &[f64], b: usize) -> Vec<NormalForce> {
        let own = &self.contact.points[b].weights;
        let press = |(slip, pair, [_, first, second]): (usize, Pair, [f64; 3])| {
            NormalForce::new(&pair, own, (-first, second), slip)
        };
        self.pairs(x, b).into_iter().flatten().map(press).filter(|p| p.force > 0.0).collect()
    }
}

impl Pair {
    /// Adds the residual and tangent of a function of the distance with the derivatives φ′ and φ″ to a block of `n` unknowns.
    pub(super) fn add(&self, own: &[f64], (first, second): (f64, f64), n: usize, want: Want, out: &mut BlockValues) {
        let s = self.shares(own);
        for (k, share) in s.iter().enumerate() {
            let r = self.normal * (first * share);
            out.r[3 * k..3 * k + 3].iter_mut().zip(r.iter()).for_each(|(sum, r)| *sum += r);
        }
        if want < Want::Tangent {
            return;
        }
        let stiff: Mat3 = self.normal * self.normal.transpose() * second;
        for k in 0..s.len() {
            for l in 0..=k {
                let entry = stiff * (s[k] * s[l]) + self.second(&s, own.len(), k, l) * first;
                for (i, j) in (0..9).map(|e| (e / 3, e % 3)) {
                    out.k[(3 * k + i) * n + 3 * l + j] += entry[(i, j)];
                }
            }
        }
    }
}
