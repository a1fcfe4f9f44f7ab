//! Nodes that follow other nodes, u = Σ_k w_k u_k, as the nodes of a rigid part follow the four nodes that carry it.
//!
//! They have no equations. An effect or a constraint on them becomes one on the nodes that they follow: with the map T of its block, r → Tᵀ r and K →
//! Tᵀ K T. Fields are completed where they leave the equations ([`System::expand`](super::System::expand)), so that every displacement, velocity and
//! direction of a run obeys the map exactly.

use super::{
    At, BlockValues, Blocks, Capabilities, Constraint, ConstraintKind, ConstraintValues, Effect, EnergyRole, EvalError,
    LawPiece, Means, PastDerivative, Perturbation, Want,
};
use crate::math::signal::Clock;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Nodes that follow others, with their weights; a followed node does not follow any node.
#[derive(Clone, Debug, Default)]
pub struct Ties {
    weights: BTreeMap<u32, Vec<(u32, f64)>>,
}

impl Ties {
    /// Builds ties from each node and its (followed node, weight) pairs.
    pub fn new(ties: impl IntoIterator<Item = (u32, Vec<(u32, f64)>)>) -> Self {
        Self { weights: ties.into_iter().collect() }
    }

    pub fn is_empty(&self) -> bool {
        self.weights.is_empty()
    }

    /// Whether a node follows others.
    pub fn has(&self, node: u32) -> bool {
        self.weights.contains_key(&node)
    }

    /// Nodes that follow others, ascending.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.weights.keys().copied()
    }

    /// Computes the values of the nodes that follow others in a field \[unknowns\].
    pub fn complete(&self, x: &mut [f64]) {
        for (&node, followed) in &self.weights {
            for i in 0..3 {
                x[3 * node as usize + i] = followed.iter().map(|&(k, w)| w * x[3 * k as usize + i]).sum();
            }
        }
    }

    /// Returns a field \[unknowns\] in which the nodes that follow others have their values.
    pub fn completed<'f>(&self, field: &'f [f64]) -> Cow<'f, [f64]> {
        let mut field = Cow::Borrowed(field);
        if !self.is_empty() {
            self.complete(field.to_mut());
        }
        field
    }

    /// Transfers an effect to the nodes that are followed.
    pub fn effect(&self, effect: Box<dyn Effect>) -> Box<dyn Effect> {
        match self.changed(effect.blocks(), effect.capabilities().means) {
            Some(part) => Box::new(TiedEffect { inner: effect, part }),
            None => effect,
        }
    }

    /// Transfers a constraint to the nodes that are followed.
    pub fn constraint(&self, constraint: Box<dyn Constraint>) -> Box<dyn Constraint> {
        match self.changed(constraint.blocks(), constraint.means()) {
            Some(part) => Box::new(TiedConstraint { inner: constraint, part }),
            None => constraint,
        }
    }

    /// The transferred blocks and their maps; `None` if no block has a node that follows others.
    fn changed(&self, blocks: &Blocks, means: Option<&Arc<Means>>) -> Option<Tied> {
        if let Some(means) = means {
            let lists = || means.lists().iter();
            let is_free = |list: &Vec<(u32, f64)>| list.iter().all(|(node, _)| !self.has(*node));
            if self.is_empty() || lists().all(is_free) {
                return None;
            }
            let followed = |&(node, w): &(u32, f64)| match self.weights.get(&node) {
                Some(of) => of.iter().map(|&(k, v)| (k, v * w)).collect(),
                None => vec![(node, w)],
            };
            let lists: Vec<Vec<(u32, f64)>> = lists().map(|list| list.iter().flat_map(followed).collect()).collect();
            let means = Means::new(lists.iter().map(Vec::as_slice));
            return Some(Tied { blocks: blocks.clone(), maps: Vec::new(), means: Some(means.into()) });
        }
        let maps: Vec<Option<BlockMap>> = (0..blocks.len()).map(|b| self.map(blocks.nodes(b))).collect();
        if maps.iter().all(Option::is_none) {
            return None;
        }
        let lists = maps.iter().enumerate().map(|(b, map)| {
            let nodes = map.as_ref().map_or(blocks.nodes(b), |map| &map.nodes);
            (nodes, blocks.scalars(b))
        });
        Some(Tied { blocks: Blocks::with_scalars(lists), maps, means: None })
    }

    fn map(&self, nodes: &[u32]) -> Option<BlockMap> {
        if nodes.iter().all(|&node| !self.has(node)) {
            return None;
        }
        let mut map = BlockMap { nodes: Vec::new(), parts: Vec::new() };
        for &node in nodes {
            let own = [(node, 1.0)];
            let followed = self.weights.get(&node).map_or(&own[..], Vec::as_slice);
            let part = followed.iter().map(|&(k, w)| {
                let place = map.nodes.iter().position(|&known| known == k).unwrap_or_else(|| {
                    map.nodes.push(k);
                    map.nodes.len() - 1
                });
                (place, w)
            });
            let part = part.collect();
            map.parts.push(part);
        }
        Some(map)
    }
}

/// The map T of one block.
struct BlockMap {
    /// Nodes of the block without those that follow others, and the followed ones
    nodes: Vec<u32>,
    /// \[nodes of the original block\] (index in `nodes`, weight)
    parts: Vec<Vec<(usize, f64)>>,
}

impl BlockMap {
    /// The original unknown `p` in terms of the new ones; scalars come after the nodes.
    fn unknown(&self, p: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (node, component) = (p / 3, p % 3);
        let of_node = self.parts.get(node).map_or(&[][..], Vec::as_slice).iter();
        let scalar = p.checked_sub(3 * self.parts.len()).map(|k| (3 * self.nodes.len() + k, 1.0));
        of_node.map(move |&(place, w)| (3 * place + component, w)).chain(scalar)
    }

    /// Adds Tᵀ r and Tᵀ K T of the original block of `n` unknowns.
    fn add(&self, own: &BlockValues, n: usize, want: Want, out: &mut BlockValues) {
        out.energy += own.energy;
        out.dissipated += own.dissipated;
        if want == Want::Energy {
            return;
        }
        let size = 3 * self.nodes.len() + n - 3 * self.parts.len();
        for p in 0..n {
            self.unknown(p).for_each(|(row, w)| out.r[row] += w * own.r[p]);
            if want < Want::Tangent {
                continue;
            }
            for q in 0..n {
                let k = own.k[p.max(q) * n + p.min(q)];
                for (row, w) in self.unknown(p) {
                    let columns = self.unknown(q).filter(|(column, _)| *column <= row);
                    columns.for_each(|(column, v)| out.k[row * size + column] += w * v * k);
                }
            }
        }
    }
}

/// Blocks transferred to the nodes that are followed.
struct Tied {
    blocks: Blocks,
    /// \[blocks\] `None` if the block is unchanged; empty if everything depends on means
    maps: Vec<Option<BlockMap>>,
    means: Option<Arc<Means>>,
}

impl Tied {
    fn eval(
        &self,
        (b, n): (usize, usize),
        want: Want,
        out: &mut BlockValues,
        eval: impl FnOnce(&mut BlockValues) -> Result<(), EvalError>,
    ) -> Result<(), EvalError> {
        match self.maps.get(b).and_then(Option::as_ref) {
            None => eval(out),
            Some(map) => {
                let mut own = BlockValues::new(n);
                eval(&mut own)?;
                map.add(&own, n, want, out);
                Ok(())
            }
        }
    }
}

struct TiedEffect {
    inner: Box<dyn Effect>,
    part: Tied,
}

impl Effect for TiedEffect {
    fn name(&self) -> &str {
        self.inner.name()
    }
    fn role(&self) -> EnergyRole {
        self.inner.role()
    }
    fn blocks(&self) -> &Blocks {
        &self.part.blocks
    }
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let n = self.inner.blocks().size(b);
        self.part.eval((b, n), want, out, |own| self.inner.eval(at, b, want, own))
    }
    fn intensity(&self, now: Clock) -> f64 {
        self.inner.intensity(now)
    }
    /// Blocks of several sizes are not evaluated together.
    fn capabilities(&self) -> Capabilities<'_> {
        let inner = self.inner.capabilities();
        let past = inner.past.map(|_| self as &dyn PastDerivative);
        Capabilities { means: self.part.means.as_ref(), batched: None, past, ..inner }
    }
}

impl PastDerivative for TiedEffect {
    /// Tᵀ times the derivative of the effect, for directions that are completed.
    fn along(&self, at: &At, by: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        let Some(past) = self.inner.capabilities().past else { return Ok(()) };
        let n = self.inner.blocks().size(b);
        self.part.eval((b, n), Want::Residual, out, |own| past.along(at, by, b, own))
    }
    fn advance_along(&self, at: &At, by: &Perturbation, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        self.inner.capabilities().past.map_or(Ok(()), |past| past.advance_along(at, by, b, new))
    }
}

struct TiedConstraint {
    inner: Box<dyn Constraint>,
    part: Tied,
}

impl Constraint for TiedConstraint {
    fn name(&self) -> &str {
        self.inner.name()
    }
    fn kind(&self) -> ConstraintKind {
        self.inner.kind()
    }
    fn scale(&self) -> f64 {
        self.inner.scale()
    }
    fn target(&self, now: Clock) -> f64 {
        self.inner.target(now)
    }
    fn compliance(&self) -> f64 {
        self.inner.compliance()
    }
    fn blocks(&self) -> &Blocks {
        &self.part.blocks
    }
    fn means(&self) -> Option<&Arc<Means>> {
        self.part.means.as_ref()
    }
    fn eval(&self, x: &[f64], b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let n = self.inner.blocks().size(b);
        self.part.eval((b, n), want, out, |own| self.inner.eval(x, b, want, own))
    }
    fn linked_law(&self, c: usize, all: &ConstraintValues) -> Vec<LawPiece> {
        self.inner.linked_law(c, all)
    }
    fn dissipated(&self, c: usize, g: [&[f64]; 2], lambda: [&[f64]; 2]) -> f64 {
        self.inner.dissipated(c, g, lambda)
    }
}
