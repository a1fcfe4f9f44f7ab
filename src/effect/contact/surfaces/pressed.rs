//! The barrier between surfaces: energy, forces and tangent of its [`Term`]s.
//!
//! Π = w m(c) b(d): r = w (m b′ ∂d + b m′ ∂c), K = w (m (b″ ∂d ∂dᵀ + b′ ∂²d) + m′ b′ (∂c ∂dᵀ + ∂d ∂cᵀ) + b (m″ ∂c ∂cᵀ + m′ ∂²c)), with
//! c = |u × v|² = |u|²|v|² − (u·v)² of the edges u and v, and m = 1 for a point.

use super::motion;
use super::pair::Surfaces;
use super::terms::Term;
use crate::effect::contact::NormalForce;
use crate::effect::contact::barrier::Barrier;
use crate::math::tensor::{Mat3, Vec3};
use crate::system::{
    At, BlockValues, Blocks, Caches, Capabilities, ContactPotential, Effect, EnergyRole, EvalError, MotionLimit,
    StepLimit, TransientBlocks, TransientCoupling, Want,
};
use std::sync::Arc;

pub struct PressedSurfaces {
    pub surfaces: Surfaces,
    pub barrier: Barrier,
    /// Empty: no block persists from one state to the next
    blocks: Blocks,
}

/// The terms in one state as blocks.
struct BarrierTerms<'a> {
    of: &'a PressedSurfaces,
    terms: Arc<Vec<Term>>,
    blocks: Blocks,
}

impl PressedSurfaces {
    pub fn new(surfaces: Surfaces, barrier: Barrier) -> Self {
        Self { surfaces, barrier, blocks: Blocks::new(std::iter::empty()) }
    }

    /// Returns w (b, b′, b″) of a term, without the factor m of two edges, which is 1 for a point.
    fn potential(&self, term: &Term) -> Result<[f64; 3], EvalError> {
        let gap = term.distance.gap();
        let crossed =
            || EvalError::Crossed { effect: self.surfaces.name.clone(), node: term.distance.nodes[0], gap: -gap };
        Ok(self.barrier.potential(gap).ok_or_else(crossed)?.map(|v| v * term.weight))
    }

    /// Adds energy, r and K of a term to a block of its nodes.
    pub fn add(&self, x: &[f64], term: &Term, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let [energy, first, second] = self.potential(term)?;
        let Some(blunt) = term.blunt else {
            out.energy += energy;
            term.distance.add((first, second), want, out);
            return Ok(());
        };
        let cross = self.cross(x, term);
        let [m, dm, ddm] = cross.bluntness(blunt);
        out.energy += m * energy;
        term.distance.add((m * first, m * second), want, out);
        if dm == 0.0 {
            return Ok(());
        }
        let dc = cross.slopes();
        for (k, dc) in dc.iter().enumerate() {
            (0..3).for_each(|i| out.r[3 * k + i] += energy * dm * dc[i]);
        }
        if want < Want::Tangent {
            return Ok(());
        }
        let normal = term.distance.normal();
        let dd = [0, 1, 2, 3].map(|k| normal * term.distance.shares[k]);
        for k in 0..4 {
            for l in 0..=k {
                let mixed = dc[k] * dd[l].transpose() + dd[k] * dc[l].transpose();
                let entry = mixed * (dm * first)
                    + dc[k] * dc[l].transpose() * (ddm * energy)
                    + cross.second(k, l) * (dm * energy);
                for (i, j) in (0..9).map(|e| (e / 3, e % 3)) {
                    out.k[(3 * k + i) * 12 + 3 * l + j] += entry[(i, j)];
                }
            }
        }
        Ok(())
    }

    /// Returns the force of a term in the form that friction needs.
    pub fn normal_force(&self, x: &[f64], term: &Term) -> Option<NormalForce> {
        let [_, first, second] = self.potential(term).ok()?;
        let bluntness = term.blunt.map_or(1.0, |blunt| self.cross(x, term).bluntness(blunt)[0]);
        let force = -first * bluntness;
        (force != 0.0).then(|| NormalForce {
            force,
            stiffness: second * bluntness,
            normal: term.distance.normal(),
            shares: term.distance.shares.clone(),
            spot: term.distance.shares.clone(),
            sliding: term.distance.shares.clone(),
            slip: 0,
        })
    }

    fn cross(&self, x: &[f64], term: &Term) -> Cross {
        let n = [0, 1, 2, 3].map(|k| self.surfaces.node(x, term.distance.nodes[k]));
        Cross { u: n[1] - n[0], v: n[3] - n[2] }
    }
}

/// c = |u × v|² of two edges, from node 0 to 1 and from node 2 to 3.
struct Cross {
    u: Vec3,
    v: Vec3,
}

impl Cross {
    fn value(&self) -> f64 {
        self.u.cross(&self.v).norm_squared()
    }

    /// Returns m, m′ and m″ at c.
    fn bluntness(&self, blunt: f64) -> [f64; 3] {
        let y = self.value() / blunt;
        if y < 1.0 { [2.0 * y - y * y, (2.0 - 2.0 * y) / blunt, -2.0 / (blunt * blunt)] } else { [1.0, 0.0, 0.0] }
    }

    /// Returns the derivatives of c with respect to the four nodes.
    fn slopes(&self) -> [Vec3; 4] {
        let Self { u, v } = self;
        let by_u = (u * v.norm_squared() - v * u.dot(v)) * 2.0;
        let by_v = (v * u.norm_squared() - u * u.dot(v)) * 2.0;
        [-by_u, by_u, -by_v, by_v]
    }

    fn second(&self, k: usize, l: usize) -> Mat3 {
        let Self { u, v } = self;
        let own = |w: &Vec3| (Mat3::identity() * w.norm_squared() - w * w.transpose()) * 2.0;
        let mixed =
            |u: &Vec3, v: &Vec3| (u * v.transpose() * 2.0 - v * u.transpose() - Mat3::identity() * u.dot(v)) * 2.0;
        let sign = if (k + l).is_multiple_of(2) { 1.0 } else { -1.0 };
        let block = match (k < 2, l < 2) {
            (true, true) => own(v),
            (false, false) => own(u),
            (true, false) => mixed(u, v),
            (false, true) => mixed(v, u),
        };
        block * sign
    }
}

impl Effect for PressedSurfaces {
    fn name(&self) -> &str {
        &self.surfaces.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Contact
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, _: &At, _: usize, _: Want, _: &mut BlockValues) -> Result<(), EvalError> {
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            // As for points: a pressure on surfaces that rotate or slide has negative curvature somewhere.
            semidefinite: true,
            transient: Some(self),
            step_limit: Some(self),
            ..Capabilities::default()
        }
    }
}

impl StepLimit for PressedSurfaces {
    fn max_step(&self, x: &[f64], dx: &[f64], caches: &mut Caches) -> Option<MotionLimit> {
        motion::max_step(&self.surfaces, x, dx, caches)
    }
}

impl TransientCoupling for PressedSurfaces {
    fn blocks_at<'a>(&'a self, at: &At, caches: &mut Caches) -> Box<dyn TransientBlocks + 'a> {
        let terms = self.surfaces.terms(at.x, caches);
        let blocks = Blocks::new(terms.iter().map(|t| &t.distance.nodes[..]));
        Box::new(BarrierTerms { of: self, terms, blocks })
    }

    fn candidates(&self, x: &[f64], caches: &mut Caches) -> Vec<Vec<u32>> {
        self.surfaces.coupled_nodes(x, caches)
    }

    fn may_have(&self, node: u32) -> bool {
        self.surfaces.have(node)
    }
}

impl TransientBlocks for BarrierTerms<'_> {
    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.of.add(at.x, &self.terms[b], want, out)
    }
}
