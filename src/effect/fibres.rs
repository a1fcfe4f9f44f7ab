//! Elastic fibres: chains of truss segments between points that the body carries, p = Σ w_a x_a.
//!
//! ```text
//! Π = Σ ½ EA (λ − 1)² L    λ = l/L, l = ‖D + Σ_a c_a u_a‖, c = w_end − w_start    N = EA (λ − 1)
//! r_a = c_a N τ             K_ab = c_a c_b [EA/L ττᵀ + N/l (I − ττᵀ)]
//! ```
//!
//! The engineering strain λ − 1 makes the tension linear in the elongation, so that a tensile test gives EA directly (the truss of Crisfield,
//! *Non-linear Finite Element Analysis of Solids and Structures* 1, 1991, ch. 3). l depends on changes of length alone, so that the fibre is
//! objective. A fibre that does not resist compression has N = 0 for λ < 1; Π is then continuously differentiable, but K is discontinuous.
//!
//! Limits: no bending stiffness, no slip. A line has no volume: as h → 0 it cuts into the body without bound, as ln 1/h.

use super::edges::longer;
use crate::math::tensor::{Mat3, Vec3};
use crate::system::{At, BlockValues, Blocks, Effect, EnergyRole, EvalError, Want};
use std::collections::BTreeMap;

/// A point of a fibre: its position X at rest \[m\], and (node, weight) with Σ w = 1 and Σ w X_a = X.
pub type FibrePoint = (Vec3, Vec<(u32, f64)>);

/// Fibres of one axial stiffness; each block is a segment.
pub struct Fibres {
    name: String,
    blocks: Blocks,
    /// c of the nodes of all blocks, block by block
    weights: Vec<f64>,
    /// \[blocks\] index in `weights` of the first node
    first: Vec<usize>,
    /// \[blocks\] D \[m\]
    rest: Vec<Vec3>,
    /// EA \[N\]
    stiffness: f64,
    compression: bool,
}

impl Fibres {
    /// Builds fibres along polylines of distinct points. `compression` tells whether a segment pushes when it is shorter than at rest.
    pub fn new(name: String, lines: &[Vec<FibrePoint>], stiffness: f64, compression: bool) -> Self {
        let (mut nodes, mut weights, mut first, mut rest) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for pair in lines.iter().flat_map(|line| line.windows(2)) {
            let ((from, start), (to, end)) = (&pair[0], &pair[1]);
            let mut difference = BTreeMap::new();
            end.iter().for_each(|&(node, w)| *difference.entry(node).or_insert(0.0) += w);
            start.iter().for_each(|&(node, w)| *difference.entry(node).or_insert(0.0) -= w);
            difference.retain(|_, w| *w != 0.0);
            first.push(weights.len());
            rest.push(to - from);
            nodes.push(difference.keys().copied().collect::<Vec<u32>>());
            weights.extend(difference.values());
        }
        let blocks = Blocks::new(nodes.iter().map(Vec::as_slice));
        Self { name, blocks, weights, first, rest, stiffness, compression }
    }

    /// Lengths at rest of all segments \[m\].
    pub fn lengths(&self) -> impl Iterator<Item = f64> + '_ {
        self.rest.iter().map(|d| d.norm())
    }

    /// Stretches λ of all segments at displacement x.
    pub fn stretches<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let stretch = |b: usize| (self.rest[b] + self.stretching(x, b)).norm() / self.rest[b].norm();
        (0..self.rest.len()).map(stretch)
    }

    /// N \[N\] of a segment at the stretch λ.
    pub fn tension(&self, stretch: f64) -> f64 {
        if self.is_slack(stretch - 1.0) { 0.0 } else { self.stiffness * (stretch - 1.0) }
    }

    /// The change of the vector of segment `b` at displacement x \[m\].
    fn stretching(&self, x: &[f64], b: usize) -> Vec3 {
        let of_node = |(c, &node): (&f64, &u32)| *c * Vec3::from_column_slice(&x[3 * node as usize..][..3]);
        self.weights[self.first[b]..].iter().zip(self.blocks.nodes(b)).map(of_node).sum()
    }

    fn is_slack(&self, strain: f64) -> bool {
        !self.compression && strain < 0.0
    }
}

impl Effect for Fibres {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Stored
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let (rest, change) = (self.rest[b], self.stretching(at.x, b));
        let length = rest.norm();
        let strain = longer(rest, change) / length;
        if self.is_slack(strain) {
            return Ok(());
        }
        out.energy = 0.5 * self.stiffness * strain * strain * length;
        if want == Want::Energy {
            return Ok(());
        }
        let d = rest + change;
        let l = d.norm();
        if l == 0.0 {
            return Err(EvalError::Degenerate { effect: self.name.clone(), segment: b });
        }
        let (tau, force) = (d / l, self.stiffness * strain);
        let count = self.blocks.nodes(b).len();
        let weights = &self.weights[self.first[b]..][..count];
        let along = tau * tau.transpose();
        let stiffness = along * (self.stiffness / length) + (Mat3::identity() - along) * (force / l);
        for (a, ca) in weights.iter().enumerate() {
            (0..3).for_each(|i| out.r[3 * a + i] = ca * force * tau[i]);
            if want < Want::Tangent {
                continue;
            }
            for (c, cc) in weights[..=a].iter().enumerate() {
                for i in 0..3 {
                    (0..3).for_each(|j| out.k[(3 * a + i) * 3 * count + 3 * c + j] = ca * cc * stiffness[(i, j)]);
                }
            }
        }
        Ok(())
    }
}
