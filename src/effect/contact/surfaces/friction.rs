//! Coulomb friction between surfaces: that of [`friction`](crate::effect::contact::friction) on every term.

use super::pressed::PressedSurfaces;
use super::terms::Term;
use crate::effect::contact::friction::Coulomb;
use crate::system::{
    At, BlockValues, Blocks, Caches, Capabilities, Effect, EnergyRole, EvalError, TransientBlocks, TransientCoupling,
    Want,
};
use std::sync::Arc;

pub struct SurfaceFriction {
    name: String,
    pub pressing: Arc<PressedSurfaces>,
    law: Coulomb,
    blocks: Blocks,
}

/// The terms at one state as blocks.
struct FrictionTerms<'a> {
    of: &'a SurfaceFriction,
    terms: Arc<Vec<Term>>,
    blocks: Blocks,
}

impl SurfaceFriction {
    pub fn new(name: String, pressing: Arc<PressedSurfaces>, law: Coulomb) -> Self {
        Self { name, pressing, law, blocks: Blocks::new(std::iter::empty()) }
    }

    /// Adds the friction of a term to a block of its nodes.
    pub fn add(&self, at: &At, term: &Term, want: Want, out: &mut BlockValues) {
        // A term that is taken away again, next to a concave edge, takes its friction away too.
        let Some(press) = self.pressing.normal_force(at.x, term) else { return };
        self.law.add(at, &term.distance.nodes, &press, 3 * term.distance.nodes.len(), want, out);
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
        Capabilities { semidefinite: true, transient: Some(self), ..Capabilities::default() }
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
