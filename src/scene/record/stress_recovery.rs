//! Cauchy stress at nodes, recovered from the stress at the quadrature points of the surrounding cells.
//!
//! At each corner of a cell a polynomial is fitted by least squares to the stress at the points of a patch of cells (Zienkiewicz & Zhu, Int. J. Numer. Methods
//! Eng. 33, 1992): linear on tet4, quadratic on tet10. The patch consists of the cells that share the corner; where these are few, at the boundary, rings of
//! neighbours are added. The value at a corner is that of its polynomial; the value at a mid-node is the mean of the values at the two ends of its edge. A
//! field of the degree of the polynomial is reproduced exactly, including on the surface, where a mean over the cells would give a value from inside the body.
//!
//! A patch has cells of one material; at an interface a node has the mean over the materials, weighted with the volume of their
//! A patch has cells of one material; at an interface a node has the mean over the materials, weighted by the volume of their cells there.

use crate::effect::PointStress;
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::element::CELL_EDGES;
use crate::mesh::{Order, TetMesh};
use nalgebra::{DMatrix, SymmetricEigen};
use std::collections::BTreeSet;

/// Number of cells of a patch for each term of the polynomial.
const CELLS_PER_TERM: usize = 2;
/// Largest number of rings of cells around a corner.
const RINGS: usize = 3;
/// Ratio to the largest eigenvalue of the normal equations below which a polynomial is not determined \[–\].
const DETERMINED: f64 = 1e-10;

/// Stress of one cell.
#[derive(Clone, Default)]
struct CellStress {
    /// X \[m\], weight \[m³\] and σ \[Pa\] at the quadrature points; empty if no effect has stress there
    points: Vec<(Vec3, f64, Mat3)>,
    /// Effects that contribute to the stress
    effects: Vec<usize>,
}

impl CellStress {
    fn volume(&self) -> f64 {
        self.points.iter().map(|p| p.1).sum()
    }
}

/// Cauchy stress of a state at the quadrature points of a mesh.
pub(super) struct StressField<'a> {
    mesh: &'a TetMesh,
    cells: Vec<CellStress>,
}

impl<'a> StressField<'a> {
    /// Computes σ = P Fᵀ/J of the effects at the displacements `x`, or σ = P for a law of small strains; the stresses of effects that share a cell add up.
    pub fn new(mesh: &'a TetMesh, effects: &[&dyn PointStress], x: &[f64]) -> Self {
        let mut cells = vec![CellStress::default(); mesh.cell_count()];
        for (number, effect) in effects.iter().enumerate() {
            let points = effect.points();
            for (b, &c) in points.cells.iter().enumerate() {
                // Every law is defined at an accepted state.
                let Ok(stress) = effect.stress(x, b) else { continue };
                let cell = &mut cells[c as usize];
                cell.effects.push(number);
                for (q, p) in stress.iter().enumerate() {
                    let f = points.deformation_gradient(x, b, q);
                    let sigma = if effect.has_small_strains() { *p } else { p * f.transpose() / f.determinant() };
                    match cell.points.get_mut(q) {
                        Some(point) => point.2 += sigma,
                        None => {
                            let at = mesh.position(c as usize, points.reference()[q]);
                            cell.points.push((at, points.weight(b, q), sigma));
                        }
                    }
                }
            }
        }
        Self { mesh, cells }
    }

    /// Mean stress of each cell \[cells\] \[Pa\].
    pub fn means(&self) -> Vec<Mat3> {
        let mean = |cell: &CellStress| {
            let sum: Mat3 = cell.points.iter().map(|(_, weight, sigma)| sigma * *weight).sum();
            if cell.points.is_empty() { sum } else { sum / cell.volume() }
        };
        self.cells.iter().map(mean).collect()
    }

    /// Recovered stress of each node \[nodes\] \[Pa\]; zero where no effect has stress.
    pub fn nodal(&self) -> Vec<Mat3> {
        let materials: BTreeSet<&[usize]> = self.cells.iter().map(|c| c.effects.as_slice()).collect();
        let mut sums = vec![(Mat3::zeros(), 0.0); self.mesh.points.len()];
        for material in materials.into_iter().filter(|m| !m.is_empty()) {
            for (sum, (sigma, volume)) in sums.iter_mut().zip(Recovery::new(self, material).nodal()) {
                *sum = (sum.0 + sigma * volume, sum.1 + volume);
            }
        }
        sums.into_iter().map(|(sum, volume)| if volume > 0.0 { sum / volume } else { sum }).collect()
    }
}

/// Recovery in the cells of one material.
struct Recovery<'a> {
    field: &'a StressField<'a>,
    /// Cells of the material
    own: Vec<usize>,
    /// Cells of the material at each corner \[nodes\]
    around: Vec<Vec<usize>>,
    /// Number of terms of the polynomials
    terms: usize,
}

impl<'a> Recovery<'a> {
    fn new(field: &'a StressField<'a>, material: &[usize]) -> Self {
        let own: Vec<usize> = (0..field.cells.len()).filter(|&c| field.cells[c].effects == material).collect();
        let mut around = vec![Vec::new(); field.mesh.points.len()];
        for &c in &own {
            field.mesh.cell(c)[..4].iter().for_each(|&corner| around[corner as usize].push(c));
        }
        let terms = if field.mesh.order == Order::Linear { 4 } else { 10 };
        Self { field, own, around, terms }
    }

    /// Stress \[Pa\] of each node \[nodes\], and the volume of the cells there \[m³\], which is 0 without cells.
    fn nodal(&self) -> Vec<(Mat3, f64)> {
        let mesh = self.field.mesh;
        let corners: Vec<Option<Polynomial>> =
            (0..mesh.points.len()).map(|k| (!self.around[k].is_empty()).then(|| self.fit(k))).collect();
        let mut values: Vec<(Mat3, f64)> = vec![(Mat3::zeros(), 0.0); mesh.points.len()];
        for &c in &self.own {
            let (nodes, volume) = (mesh.cell(c), self.field.cells[c].volume());
            let at = |corner: usize, node: u32| {
                let fitted = corners[nodes[corner] as usize].as_ref().expect("a corner of a cell has a patch");
                fitted.at(mesh.points[node as usize])
            };
            for (a, &node) in nodes.iter().enumerate() {
                let sigma = match a.checked_sub(4) {
                    None => at(a, node),
                    Some(e) => CELL_EDGES[e].into_iter().map(|end| at(end, node)).sum::<Mat3>() / 2.0,
                };
                let value = &mut values[node as usize];
                *value = (sigma, value.1 + volume);
            }
        }
        values
    }

    /// The polynomial at a corner, of the highest degree that its patch can determine.
    fn fit(&self, corner: usize) -> Polynomial {
        let center = self.field.mesh.points[corner];
        let mut patch: BTreeSet<usize> = self.around[corner].iter().copied().collect();
        for _ in 1..RINGS {
            if patch.len() >= CELLS_PER_TERM * self.terms
                && let Some(found) = Polynomial::fit(center, self.terms, self.samples(&patch))
            {
                return found;
            }
            let corners: BTreeSet<u32> = patch.iter().flat_map(|&c| self.field.mesh.cell(c)[..4].to_vec()).collect();
            patch = corners.iter().flat_map(|&k| self.around[k as usize].iter().copied()).collect();
        }
        let degrees = [10, 4, 1].into_iter().filter(|terms| *terms <= self.terms);
        let mut found = degrees.filter_map(|terms| Polynomial::fit(center, terms, self.samples(&patch)));
        found.next().expect("a patch has a mean")
    }

    fn samples<'b>(&'b self, patch: &'b BTreeSet<usize>) -> impl Iterator<Item = (Vec3, Mat3)> + Clone + 'b {
        patch.iter().flat_map(|&c| self.field.cells[c].points.iter().map(|(at, _, sigma)| (*at, *sigma)))
    }
}

/// A polynomial of the position with values of stress.
struct Polynomial {
    center: Vec3,
    /// Length by which positions are scaled \[m\]
    size: f64,
    /// Coefficients \[terms\] \[Pa\]
    coefficients: Vec<Mat3>,
}

impl Polynomial {
    /// The least-squares fit of a polynomial with `terms` terms to the samples; `None` if they do not determine it.
    fn fit(center: Vec3, terms: usize, samples: impl Iterator<Item = (Vec3, Mat3)> + Clone) -> Option<Self> {
        let size = samples.clone().map(|(at, _)| (at - center).norm()).fold(0.0, f64::max);
        let (mut normal, mut right) = (DMatrix::<f64>::zeros(terms, terms), vec![Mat3::zeros(); terms]);
        for (at, sigma) in samples {
            let row = monomials((at - center) / size);
            for i in 0..terms {
                right[i] += sigma * row[i];
                (0..terms).for_each(|j| normal[(i, j)] += row[i] * row[j]);
            }
        }
        let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(normal);
        if eigenvalues.min() <= DETERMINED * eigenvalues.max() {
            return None;
        }
        let along = |k: usize| -> Mat3 { (0..terms).map(|i| right[i] * eigenvectors[(i, k)]).sum::<Mat3>() };
        let scaled: Vec<Mat3> = (0..terms).map(|k| along(k) / eigenvalues[k]).collect();
        let coefficient = |i: usize| (0..terms).map(|k| scaled[k] * eigenvectors[(i, k)]).sum();
        Some(Self { center, size, coefficients: (0..terms).map(coefficient).collect() })
    }

    fn at(&self, place: Vec3) -> Mat3 {
        let row = monomials((place - self.center) / self.size);
        self.coefficients.iter().zip(row).map(|(coefficient, m)| coefficient * m).sum()
    }
}

/// The monomials 1, x, y, z, and those of degree 2.
fn monomials(p: Vec3) -> [f64; 10] {
    [1.0, p.x, p.y, p.z, p.x * p.x, p.y * p.y, p.z * p.z, p.x * p.y, p.y * p.z, p.z * p.x]
}
