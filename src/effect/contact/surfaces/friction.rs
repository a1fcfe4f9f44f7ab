//! Coulomb friction between surfaces: the law of [`friction`](crate::effect::contact::friction) applied to every term.
//!
//! Each point of either surface has one elastic slip, which all its terms share. Limits: terms of two edges have no elastic slip.

use super::pressed::PressedSurfaces;
use super::terms::Term;
use crate::effect::contact::NormalForce;
use crate::effect::contact::friction::{Coulomb, elastic_slip};
use crate::math::tensor::Vec3;
use crate::system::friction::HISTORY;
use crate::system::{
    ActiveBlocks, At, BlockValues, Blocks, Caches, Capabilities, Effect, EnergyRole, EvalError, HistoryVariables,
    TransientBlocks, TransientCoupling, Want,
};
use std::collections::BTreeMap;
use std::sync::Arc;

pub struct SurfaceFriction {
    name: String,
    pub pressing: Arc<PressedSurfaces>,
    law: Coulomb,
    /// One block without unknowns per point, which has the history of the point
    blocks: Blocks,
}

/// The terms in one state as blocks.
struct FrictionTerms<'a> {
    of: &'a SurfaceFriction,
    terms: Arc<Vec<Term>>,
    blocks: Blocks,
}

impl SurfaceFriction {
    pub fn new(name: String, pressing: Arc<PressedSurfaces>, law: Coulomb) -> Self {
        let points = pressing.surfaces.point_count();
        Self { name, pressing, law, blocks: Blocks::new(std::iter::repeat_n(&[][..], points)) }
    }

    /// The block of the point of a term; `None` for a term of two edges.
    fn block(&self, term: &Term) -> Option<usize> {
        let (pass, point) = term.point?;
        Some(if pass == 0 { 0 } else { self.pressing.surfaces.first().points.len() } + point as usize)
    }

    /// Adds the friction of a term to a block of its nodes.
    pub fn add(&self, at: &At, term: &Term, want: Want, out: &mut BlockValues) {
        // A term with negative weight, next to a concave edge, also subtracts its friction.
        let Some(press) = self.pressing.normal_force(at.x, term) else { return };
        let (nodes, slip) = (&term.distance.nodes[..], self.block(term).map_or(Vec3::zeros(), |b| elastic_slip(at, b)));
        self.law.add(at, (nodes, slip), &press, 3 * nodes.len(), want, out);
    }

    /// Returns the terms of points in a state, block by block, with the forces that they exert.
    fn presses<'a>(&self, at: &At, terms: &'a [Term]) -> BTreeMap<usize, Vec<(&'a [u32], NormalForce)>> {
        let mut of_blocks = BTreeMap::<usize, Vec<(&[u32], NormalForce)>>::new();
        for term in terms {
            let (Some(b), Some(press)) = (self.block(term), self.pressing.normal_force(at.x, term)) else { continue };
            of_blocks.entry(b).or_default().push((&term.distance.nodes, press));
        }
        of_blocks
    }
}

impl Effect for SurfaceFriction {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Friction
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, _: &At, _: usize, _: Want, _: &mut BlockValues) -> Result<(), EvalError> {
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            semidefinite: true,
            transient: Some(self),
            active: Some(self),
            history: Some(self),
            friction_of: Some(&self.pressing.surfaces.name),
            ..Capabilities::default()
        }
    }
}

impl ActiveBlocks for SurfaceFriction {
    /// Empty: the blocks of points have no unknowns.
    fn active(&self, _: &At, _: &mut Caches) -> Vec<u32> {
        Vec::new()
    }
}

impl HistoryVariables for SurfaceFriction {
    fn size(&self) -> usize {
        HISTORY
    }

    /// Advances all blocks and returns the values of this one: the terms of a point are known only once all terms are.
    fn advance(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        let mut all = vec![0.0; HISTORY * self.blocks.len()];
        self.advance_all(at, &mut all, &mut Caches::default())?;
        new.copy_from_slice(&all[HISTORY * b..][..HISTORY]);
        Ok(())
    }

    fn advance_all(&self, at: &At, new: &mut [f64], caches: &mut Caches) -> Result<(), EvalError> {
        let terms = self.pressing.surfaces.terms(at.x, caches);
        new.fill(0.0);
        for (b, presses) in self.presses(at, &terms) {
            let slip = self.law.advance(at, presses.iter().map(|(nodes, press)| (*nodes, press)), elastic_slip(at, b));
            new[HISTORY * b..][..HISTORY].copy_from_slice(slip.as_slice());
        }
        Ok(())
    }
}

impl TransientCoupling for SurfaceFriction {
    fn blocks_at<'a>(&'a self, at: &At, caches: &mut Caches) -> Box<dyn TransientBlocks + 'a> {
        let terms = self.pressing.surfaces.terms(at.x, caches);
        let blocks = Blocks::new(terms.iter().map(|t| &t.distance.nodes[..]));
        Box::new(FrictionTerms { of: self, terms, blocks })
    }

    fn candidates(&self, x: &[f64], caches: &mut Caches) -> Vec<Vec<u32>> {
        self.pressing.surfaces.coupled_nodes(x, caches)
    }

    fn may_have(&self, node: u32) -> bool {
        self.pressing.surfaces.have(node)
    }
}

impl TransientBlocks for FrictionTerms<'_> {
    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.of.add(at, &self.terms[b], want, out);
        Ok(())
    }
}
