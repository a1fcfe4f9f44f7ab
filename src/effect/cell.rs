//! Integrals over cells: deformation gradient at the quadrature points, and the way back to r_e and K_e.

use crate::material::Law;
use crate::math::tensor::{Mat3, Mat9, Vec3};
use crate::mesh::{Order, TetMesh, element, quadrature};
use crate::system::{Blocks, EvalError, Local, Want};

/// Gradients and weights at the quadrature points of some cells.
pub struct CellPoints {
    pub blocks: Blocks,
    /// [cells] index in the mesh, for messages
    pub cells: Vec<u32>,
    nodes: usize,
    points: usize,
    /// [points] reference coordinates
    reference: Vec<[f64; 3]>,
    /// [cells × points × nodes] ∂N_a/∂X [1/m]
    gradients: Vec<[f64; 3]>,
    /// [cells × points] w det ∂X/∂ξ [m³]
    weights: Vec<f64>,
}

impl CellPoints {
    /// One point for tet4, four for tet10: exact for the linear elastic stiffness of straight cells.
    pub fn new(mesh: &TetMesh, cells: &[u32]) -> Self {
        let rule = quadrature::tet(if mesh.order == Order::Linear { 1 } else { 2 });
        let nodes = mesh.order.cell_nodes();
        let (mut gradients, mut weights) = (Vec::new(), Vec::new());
        for &c in cells {
            for (&xi, w) in rule.points.iter().zip(&rule.weights) {
                let jacobian = mesh.jacobian(c as usize, xi);
                let inverse = jacobian.try_inverse().expect("a valid mesh has no degenerate cell");
                weights.push(w * jacobian.determinant());
                let local = element::cell_gradients(mesh.order, xi);
                gradients.extend(local[..nodes].iter().map(|g| {
                    let g = inverse.tr_mul(&Vec3::from(*g));
                    [g.x, g.y, g.z]
                }));
            }
        }
        let blocks = Blocks::new(cells.iter().map(|&c| mesh.cell(c as usize)));
        Self {
            blocks,
            cells: cells.to_vec(),
            nodes,
            points: rule.points.len(),
            reference: rule.points,
            gradients,
            weights,
        }
    }

    pub fn points(&self) -> usize {
        self.points
    }

    /// For each cell of the region: index in the mesh, and at each of its points the weight [m³] and F.
    pub fn deformation<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = (u32, Vec<(f64, Mat3)>)> + 'a {
        self.cells.iter().enumerate().map(move |(b, &c)| {
            let at = |q| (self.weight(b, q), self.deformation_gradient(x, b, q));
            (c, (0..self.points).map(at).collect())
        })
    }

    /// [points] reference coordinates of the points.
    pub fn reference(&self) -> &[[f64; 3]] {
        &self.reference
    }

    /// T ∂N_a/∂X of each node at point `q` of block `b`.
    pub fn contract<'a>(&'a self, b: usize, q: usize, t: &'a Mat3) -> impl Iterator<Item = [f64; 3]> + 'a {
        let times = |g: &[f64; 3]| std::array::from_fn(|i| t[(i, 0)] * g[0] + t[(i, 1)] * g[1] + t[(i, 2)] * g[2]);
        self.gradients(b, q).iter().map(times)
    }

    /// w det ∂X/∂ξ of point `q` of block `b` [m³].
    pub fn weight(&self, b: usize, q: usize) -> f64 {
        self.weights[b * self.points + q]
    }

    fn gradients(&self, b: usize, q: usize) -> &[[f64; 3]] {
        let start = (b * self.points + q) * self.nodes;
        &self.gradients[start..start + self.nodes]
    }

    /// F = I + Σ_a x_a ⊗ ∂N_a/∂X for a nodal displacement x.
    pub fn deformation_gradient(&self, x: &[f64], b: usize, q: usize) -> Mat3 {
        let mut f = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for (&node, g) in self.blocks.nodes(b).iter().zip(self.gradients(b, q)) {
            let u = &x[3 * node as usize..3 * node as usize + 3];
            for i in 0..3 {
                for j in 0..3 {
                    f[i][j] += u[i] * g[j];
                }
            }
        }
        Mat3::from_fn(|i, j| f[i][j])
    }

    /// ∫ ψ(F) dV of block `b` with r_e and K_e, where a row of K_e has `stride` entries; `name` is the effect's, for its errors.
    #[expect(clippy::too_many_arguments, reason = "a law, a place, and where they go")]
    pub fn integrate(
        &self,
        law: &dyn Law,
        name: &str,
        x: &[f64],
        b: usize,
        stride: usize,
        want: Want,
        out: &mut Local,
    ) -> Result<(), EvalError> {
        for q in 0..self.points {
            let f = self.deformation_gradient(x, b, q);
            let fail = |e| EvalError::of_law(name, self.cells[b] as usize, e);
            let response = law.eval(&f, want).map_err(fail)?;
            out.energy += self.weight(b, q) * response.psi;
            if want > Want::Energy {
                self.scatter(b, q, stride, &response.p, &response.a, want, out);
            }
        }
        Ok(())
    }

    /// r_e += w P ∂N/∂X, K_e += w ∂N/∂X A ∂N/∂X (column ≤ row), where a row of K_e has `stride` entries.
    #[expect(clippy::too_many_arguments, reason = "place, two tensors, and where they go")]
    pub fn scatter(&self, b: usize, q: usize, stride: usize, p: &Mat3, a: &Mat9, want: Want, out: &mut Local) {
        let (gradients, w) = (self.gradients(b, q), self.weight(b, q));
        match <&[[f64; 3]; 4]>::try_from(gradients) {
            Ok(g) => scatter(g, w, stride, p, a, want, out),
            Err(_) => scatter(gradients.try_into().unwrap_or(&[[0.0; 3]; 10]), w, stride, p, a, want, out),
        }
    }
}

fn scatter<const N: usize>(g: &[[f64; 3]; N], w: f64, stride: usize, p: &Mat3, a: &Mat9, want: Want, out: &mut Local) {
    for (n, g) in g.iter().enumerate() {
        for i in 0..3 {
            out.r[3 * n + i] += w * (p[(i, 0)] * g[0] + p[(i, 1)] * g[1] + p[(i, 2)] * g[2]);
        }
    }
    if want < Want::Tangent {
        return;
    }
    for (column, gb) in g.iter().enumerate() {
        // T_iJk = w Σ_L A_iJkL ∂N_b/∂X_L
        let h = [w * gb[0], w * gb[1], w * gb[2]];
        let mut t = [[0.0; 3]; 9];
        for (t, a) in t.iter_mut().zip(a) {
            for k in 0..3 {
                t[k] = a[3 * k] * h[0] + a[3 * k + 1] * h[1] + a[3 * k + 2] * h[2];
            }
        }
        for (row, ga) in g.iter().enumerate().skip(column) {
            for i in 0..3 {
                let target = &mut out.k[(3 * row + i) * stride + 3 * column..][..3];
                for k in 0..3 {
                    target[k] += ga[0] * t[3 * i][k] + ga[1] * t[3 * i + 1][k] + ga[2] * t[3 * i + 2][k];
                }
            }
        }
    }
}
