//! Rigid motions without resistance.
//!
//! A part (the nodes that stored energy connects) has the six motions u = e_i and u = e_i × (x − c)/ℓ, where c is its centre and ℓ its size. Free are
//! those combinations with u = 0 at every prescribed dof, K u = 0 and ∂c/∂x·u = 0 up to rounding: null vectors of the six columns, found from their
//! singular values.

use crate::math::disjoint_sets::DisjointSets;
use crate::math::tensor::Vec3;
use crate::math::vector::{dot, norm};
use crate::system::{Assembled, Dofs, EnergyRole, System};
use nalgebra::{DMatrix, DVector};

/// Size, relative to a motion, that counts as zero \[–\]: positions in a mesh file have at least seven digits.
pub(super) const NONE: f64 = 1e-6;
/// Size of ‖K u‖ relative to ‖|K||u|‖ below which it is rounding: K u of a rigid motion is a sum of about a hundred terms.
pub(in crate::solve) const ROUNDING: f64 = 1e-12;

/// The nodes that stored energy connects, part by part.
pub(in crate::solve) fn parts(system: &System, nodes: usize) -> Vec<Vec<u32>> {
    let mut sets = DisjointSets::new(nodes);
    let mut stored = vec![false; nodes];
    for effect in system.effects.iter().filter(|e| matches!(e.role(), EnergyRole::Stored | EnergyRole::Relaxing)) {
        for b in 0..effect.blocks().len() {
            let list = effect.blocks().nodes(b);
            sets.join(list);
            list.iter().for_each(|node| stored[*node as usize] = true);
        }
    }
    let mut found: std::collections::BTreeMap<u32, Vec<u32>> = Default::default();
    for node in (0..nodes as u32).filter(|k| stored[*k as usize]) {
        found.entry(sets.first(node)).or_default().push(node);
    }
    found.into_values().collect()
}

/// Holds the rigid motions without resistance at a state near equilibrium, to which the sums belong, by a spring on one equation for each motion, as
/// stiff as the stiffest diagonal entry. For a basis N of these motions K N = 0, so that K on the other equations has as many eigenvalues of each
/// sign as K, apart from the zeros (Sylvester's law of inertia), and a step under balanced loads is one that leaves the held equations unchanged.
/// Returns the number of held motions: 0 if `points` \[nodes\] is empty.
pub(in crate::solve) fn hold(system: &System, sums: &mut Assembled, points: &[Vec3], x: &[f64]) -> usize {
    if points.is_empty() {
        return 0;
    }
    let unbalanced = norm(&system.restrict(&sums.r));
    let mut held = Vec::new();
    for nodes in parts(system, points.len()) {
        let part = RigidPartMotions::new(&nodes, points, x);
        held.extend(part.equations(system, &part.unresisted(system, sums, unbalanced)));
    }
    let largest = sums.pattern.diagonal(&sums.k).iter().fold(0.0, |m: f64, d| m.max(d.abs()));
    for &e in &held {
        sums.k[sums.pattern.on_diagonal(e)] += largest;
    }
    held.len()
}

/// The six rigid motions of a part: \[nodes\] positions relative to its centre, divided by its size \[m\].
pub(in crate::solve) struct RigidPartMotions<'a> {
    pub nodes: &'a [u32],
    arms: Vec<Vec3>,
    size: f64,
}

impl<'a> RigidPartMotions<'a> {
    pub fn new(nodes: &'a [u32], points: &[Vec3], x: &[f64]) -> Self {
        let at = |k: &u32| points[*k as usize] + Vec3::from_column_slice(&x[3 * *k as usize..][..3]);
        let middle = nodes.iter().map(at).sum::<Vec3>() / nodes.len() as f64;
        let size = nodes.iter().map(|k| (at(k) - middle).norm()).fold(f64::MIN_POSITIVE, f64::max);
        Self { nodes, arms: nodes.iter().map(|k| (at(k) - middle) / size).collect(), size }
    }

    /// The displacement u of node `i` of the part: c\[..3\] + c\[3..\] × arm.
    pub fn motion(&self, i: usize, c: &DVector<f64>) -> Vec3 {
        Vec3::new(c[0], c[1], c[2]) + Vec3::new(c[3], c[4], c[5]).cross(&self.arms[i])
    }

    /// Chooses as many equations as there are motions in the basis \[6 × motions\], such that the motions are independent on them: rows of the
    /// motions, each with the largest component orthogonal to the rows before it.
    fn equations(&self, system: &System, basis: &DMatrix<f64>) -> Vec<usize> {
        let dofs = self.nodes.iter().flat_map(|node| 3 * node..3 * node + 3);
        let equations: Vec<u32> = dofs.map(|dof| system.dofs.equation[dof as usize]).collect();
        let mut moved = DMatrix::zeros(equations.len(), basis.ncols());
        for (j, c) in basis.column_iter().enumerate() {
            for i in 0..self.nodes.len() {
                moved.fixed_view_mut::<3, 1>(3 * i, j).copy_from(&self.motion(i, &c.into_owned()));
            }
        }
        let mut chosen = Vec::new();
        for _ in 0..basis.ncols() {
            let free = (0..equations.len()).filter(|row| equations[*row] != Dofs::FIXED);
            let Some(most) = free.max_by(|a, b| moved.row(*a).norm().total_cmp(&moved.row(*b).norm())) else { break };
            let along = moved.row(most).normalize();
            let shares = &moved * along.transpose();
            moved -= shares * along;
            chosen.push(equations[most] as usize);
        }
        chosen
    }

    /// \[6 × free motions\] basis of the motions without resistance. Forces of the size `unbalanced` \[N\] rotate with the body and do not count as
    /// resistance.
    pub fn unresisted(&self, system: &System, sums: &Assembled, unbalanced: f64) -> DMatrix<f64> {
        let (pattern, k, rows) = (&sums.pattern, &sums.k, &sums.gradient);
        let unit = |j: usize| DVector::from_fn(6, |i, _| f64::from(u8::from(i == j)));
        let mut all = DMatrix::zeros(3 * self.nodes.len(), 6);
        for j in 0..6 {
            for i in 0..self.nodes.len() {
                all.fixed_view_mut::<3, 1>(3 * i, j).copy_from(&self.motion(i, &unit(j)));
            }
        }
        // A straight chain does not move when it rotates about itself: zero motions do not count
        let moving = row_space(&all, NONE);
        let held = |row: &usize| system.dofs.equation[3 * self.nodes[row / 3] as usize + row % 3] == Dofs::FIXED;
        let fixed: Vec<usize> = (0..all.nrows()).filter(held).collect();
        let admissible = &moving * null_space(&(all.select_rows(&fixed) * &moving), NONE);
        let n = pattern.n;
        let mut resistance = DMatrix::zeros(n + rows.len(), admissible.ncols());
        for (j, c) in admissible.column_iter().enumerate() {
            let (mut u, mut force) = (vec![0.0; n], vec![0.0; n]);
            for (i, &node) in self.nodes.iter().enumerate() {
                for (dof, value) in (3 * node..).zip(self.motion(i, &c.into_owned()).iter()) {
                    if let Some(u) = u.get_mut(system.dofs.equation[dof as usize] as usize) {
                        *u = *value;
                    }
                }
            }
            pattern.multiply(k, &u, &mut force);
            let turned = unbalanced / self.size;
            let yardstick = (norm(&pattern.multiply_abs(k, &u)) + turned / ROUNDING).max(f64::MIN_POSITIVE);
            for (i, f) in force.iter().enumerate() {
                resistance[(i, j)] = f / yardstick;
            }
            for (i, h) in rows.iter().enumerate() {
                resistance[(n + i, j)] = dot(h, &u) / (norm(h) * norm(&u)).max(f64::MIN_POSITIVE);
            }
        }
        &admissible * null_space(&resistance, ROUNDING)
    }
}

/// Orthonormal columns y with ‖A y‖ ≤ `small`.
pub(super) fn null_space(a: &DMatrix<f64>, small: f64) -> DMatrix<f64> {
    right_vectors(a, |s| s <= small)
}

/// Orthonormal columns y with ‖A y‖ above `small` times the largest singular value.
fn row_space(a: &DMatrix<f64>, small: f64) -> DMatrix<f64> {
    let largest = a.clone().singular_values().max();
    right_vectors(a, |s| s > small * largest)
}

/// Right singular vectors whose singular values are `wanted`, including those with the value 0.
pub(super) fn right_vectors(a: &DMatrix<f64>, wanted: impl Fn(f64) -> bool) -> DMatrix<f64> {
    // Rows of zeros are added so that there are right singular vectors for all columns
    let tall = a.clone().resize_vertically(a.nrows().max(a.ncols()), 0.0);
    let n = tall.ncols();
    if n == 0 {
        return DMatrix::zeros(0, 0);
    }
    let svd = tall.svd(false, true);
    let v = svd.v_t.expect("asked for").transpose();
    let columns: Vec<usize> = (0..n).filter(|&j| wanted(svd.singular_values[j])).collect();
    v.select_columns(&columns)
}
