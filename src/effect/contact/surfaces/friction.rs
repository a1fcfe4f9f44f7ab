//! Coulomb friction between surfaces: that of [`friction`](crate::effect::contact::friction) on every term.

use super::Term;
use super::pressed::PressedSurfaces;
use crate::effect::contact::friction::Coulomb;
use crate::system::{At, Blocks, Effect, EvalError, Local, Role, TransientCoupling, Want};
use std::sync::Arc;

pub struct SurfaceFriction {
    name: String,
    pub pressing: Arc<PressedSurfaces>,
    law: Coulomb,
    blocks: Blocks,
}

struct TransientBlocks<'a> {
    of: &'a SurfaceFriction,
    terms: Arc<Vec<Term>>,
    blocks: Blocks,
}

impl SurfaceFriction {
    pub fn new(name: String, pressing: Arc<PressedSurfaces>, law: Coulomb) -> Self {
        Self { name, pressing, law, blocks: Blocks::new(std::iter::empty()) }
    }

    /// Adds the friction of a term to a block of its nodes.
    pub fn add(&self, at: &At, term: &Term, want: Want, out: &mut Local) {
        // A term that is taken away again, beside a concave edge, takes its friction away too.
        let Some(press) = self.pressing.press(at.x, term) else { return };
        self.law.add(at, &term.touch.nodes, &press, 3 * term.touch.nodes.len(), want, out);
    }
}

impl Effect for SurfaceFriction {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> Role {
        Role::Dissipative
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, _: &At, _: usize, _: Want, _: &mut Local) -> Result<(), EvalError> {
        Ok(())
    }

    fn meets(&self) -> bool {
        true
    }

    fn meeting<'a>(&'a self, at: &At) -> Option<Box<dyn TransientCoupling + 'a>> {
        let terms = self.pressing.surfaces.terms(at.x);
        let blocks = Blocks::new(terms.iter().map(|t| &t.touch.nodes[..]));
        Some(Box::new(TransientBlocks { of: self, terms, blocks }))
    }

    fn semidefinite(&self) -> bool {
        true
    }
}

impl TransientCoupling for TransientBlocks<'_> {
    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn room(&self, x: &[f64]) -> Vec<Vec<u32>> {
        self.of.pressing.surfaces.room(x)
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut Local) -> Result<(), EvalError> {
        self.of.add(at, &self.terms[b], want, out);
        Ok(())
    }
}
