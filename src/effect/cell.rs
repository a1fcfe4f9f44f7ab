//! Integrals over cells: the deformation gradient at the quadrature points, and r_e and K_e from stress and tangent there, for one cell at a time or
//! for [`LANES`] cells side by side by the same formulae.

use crate::material::{LaneResponse, Law};
use crate::math::lanes::{Kernel, LANES, Lanes, Real, widest};
use crate::math::tensor::{Mat3, Mat9, Vec3, rows};
use crate::mesh::{Order, TetMesh, element, quadrature};
use crate::system::{Batch, BlockValues, Blocks, EvalError, Want};
use std::ops::Range;

/// Nodes of the largest cell.
pub(super) const MOST_NODES: usize = 10;
/// Quadrature points of a tet10.
const MOST_POINTS: usize = 4;

/// Gradients and weights at the quadrature points of some cells, [`LANES`] cells side by side.
pub struct CellPoints {
    pub blocks: Blocks,
    /// \[cells\] index in the mesh, for messages
    pub cells: Vec<u32>,
    nodes: usize,
    points: usize,
    /// \[points\] reference coordinates
    reference: Vec<[f64; 3]>,
    /// \[groups of cells × points × nodes\] ∂N_a/∂X \[1/m\]
    gradients: Vec<[Lanes; 3]>,
    /// \[groups of cells × points\] w det ∂X/∂ξ \[m³\]
    weights: Vec<Lanes>,
}

impl CellPoints {
    /// Builds the points of the cells: one per tet4, four per tet10, which is exact for the linear elastic stiffness of straight-sided cells.
    pub fn new(mesh: &TetMesh, cells: &[u32]) -> Self {
        let rule = quadrature::tet(if mesh.order == Order::Linear { 1 } else { 2 });
        let (nodes, points) = (mesh.order.cell_nodes(), rule.points.len());
        let groups = cells.len().div_ceil(LANES);
        let mut gradients = vec![[Lanes::ZERO; 3]; groups * points * nodes];
        let mut weights = vec![Lanes::ZERO; groups * points];
        for (b, &c) in cells.iter().enumerate() {
            let (group, lane) = (b / LANES, b % LANES);
            for (q, (&xi, w)) in rule.points.iter().zip(&rule.weights).enumerate() {
                let jacobian = mesh.jacobian(c as usize, xi);
                let inverse = jacobian.try_inverse().expect("a valid mesh has no degenerate cell");
                weights[group * points + q].0[lane] = w * jacobian.determinant();
                let local = element::cell_gradients(mesh.order, xi);
                let place = &mut gradients[(group * points + q) * nodes..][..nodes];
                for (to, from) in place.iter_mut().zip(local) {
                    let g = inverse.tr_mul(&Vec3::from(from));
                    to.iter_mut().zip(g.iter()).for_each(|(to, g)| to.0[lane] = *g);
                }
            }
        }
        let blocks = Blocks::new(cells.iter().map(|&c| mesh.cell(c as usize)));
        Self { blocks, cells: cells.to_vec(), nodes, points, reference: rule.points, gradients, weights }
    }

    pub fn points(&self) -> usize {
        self.points
    }

    /// Returns, for each of these cells of the region, its index in the mesh and, at each of its points, the weight \[m³\] and F.
    pub fn deformation<'a>(
        &'a self,
        x: &'a [f64],
        cells: Range<usize>,
    ) -> impl Iterator<Item = (u32, Vec<(f64, Mat3)>)> + 'a {
        cells.map(move |b| {
            let at = |q| (self.weight(b, q), self.deformation_gradient(x, b, q));
            (self.cells[b], (0..self.points).map(at).collect())
        })
    }

    /// \[points\] reference coordinates of the points.
    pub fn reference(&self) -> &[[f64; 3]] {
        &self.reference
    }

    /// Returns T ∂N_a/∂X for each node at point `q` of block `b`.
    pub fn contract<'a>(&'a self, b: usize, q: usize, t: &'a Mat3) -> impl Iterator<Item = [f64; 3]> + 'a {
        let times = |g: [f64; 3]| std::array::from_fn(|i| t[(i, 0)] * g[0] + t[(i, 1)] * g[1] + t[(i, 2)] * g[2]);
        self.gradients(b, q).map(times)
    }

    /// w det ∂X/∂ξ of point `q` of block `b` \[m³\].
    pub fn weight(&self, b: usize, q: usize) -> f64 {
        self.weights[b / LANES * self.points + q].0[b % LANES]
    }

    /// ∂N_a/∂X of each node at point `q` of block `b` \[1/m\].
    fn gradients(&self, b: usize, q: usize) -> impl Iterator<Item = [f64; 3]> + '_ {
        let lane = b % LANES;
        self.gradients_of_group(b / LANES, q).iter().map(move |g| [g[0].0[lane], g[1].0[lane], g[2].0[lane]])
    }

    fn gradients_of_group(&self, group: usize, q: usize) -> &[[Lanes; 3]] {
        &self.gradients[(group * self.points + q) * self.nodes..][..self.nodes]
    }

    /// F = I + Σ_a x_a ⊗ ∂N_a/∂X for a nodal displacement x.
    pub fn deformation_gradient(&self, x: &[f64], b: usize, q: usize) -> Mat3 {
        let mut f = IDENTITY;
        for (&node, g) in self.blocks.nodes(b).iter().zip(self.gradients(b, q)) {
            let u = &x[3 * node as usize..3 * node as usize + 3];
            add_gradient(&mut f, [u[0], u[1], u[2]], g);
        }
        Mat3::from_row_slice(&f)
    }

    /// Adds ∫ ψ(F) dV of block `b`, with r_e and K_e, where a row of K_e has `stride` entries; `name` is the name of the effect, for its errors.
    #[expect(clippy::too_many_arguments, reason = "a law, a place, and where they go")]
    pub fn integrate(
        &self,
        law: &dyn Law,
        name: &str,
        x: &[f64],
        b: usize,
        stride: usize,
        want: Want,
        out: &mut BlockValues,
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

    /// Adds ∫ ψ(F) dV with r_e and K_e of the [`LANES`] blocks from `first` on, a multiple of [`LANES`].
    pub fn integrate_batch(
        &self,
        law: &dyn Law,
        name: &str,
        x: &[f64],
        first: usize,
        want: Want,
        out: &mut Batch,
    ) -> Result<(), EvalError> {
        let (of_four, of_ten);
        let u: &[[Lanes; 3]] = if self.nodes == 4 {
            of_four = self.displacements::<4>(x, first);
            &of_four
        } else {
            of_ten = self.displacements::<MOST_NODES>(x, first);
            &of_ten
        };
        self.each_point(first, 3 * self.nodes, want, out, |q, w, out, response| {
            let f = self.deformation_gradients(u, first, q);
            let fail = |(lane, e)| EvalError::of_law(name, self.cells[first + lane] as usize, e);
            law.eval_lanes(&f, want, response).map_err(fail)?;
            out.energy += w * response.psi;
            Ok(())
        })
    }

    /// Adds the forces of the [`LANES`] blocks from `first` on and sets K_e on their nodes, where a row of K_e has `stride` entries; `respond`
    /// computes P and A at a point, given its index and its weights.
    pub fn each_point(
        &self,
        first: usize,
        stride: usize,
        want: Want,
        out: &mut Batch,
        mut respond: impl FnMut(usize, Lanes, &mut Batch, &mut LaneResponse) -> Result<(), EvalError>,
    ) -> Result<(), EvalError> {
        let mut responses = std::mem::take(&mut out.responses);
        responses.resize_with(self.points, LaneResponse::default);
        let weights = &self.weights[first / LANES * self.points..][..self.points];
        for (q, (response, &w)) in responses.iter_mut().zip(weights).enumerate() {
            respond(q, w, out, response)?;
        }
        if want > Want::Energy {
            let gradients = &self.gradients[first / LANES * self.points * self.nodes..][..self.points * self.nodes];
            widest(Forces { gradients, weights, responses: &responses, stride, want, out });
        }
        out.responses = responses;
        Ok(())
    }

    /// Displacements of the nodes, at most N, of the [`LANES`] blocks from `first` on.
    pub fn displacements<const N: usize>(&self, x: &[f64], first: usize) -> [[Lanes; 3]; N] {
        let mut u = [[Lanes::ZERO; 3]; N];
        for lane in 0..LANES {
            for (u, &node) in u.iter_mut().zip(self.blocks.nodes(first + lane)) {
                let of_node = &x[3 * node as usize..][..3];
                u.iter_mut().zip(of_node).for_each(|(u, x)| u.0[lane] = *x);
            }
        }
        u
    }

    /// Returns F at point `q` of the [`LANES`] blocks from `first` on, row by row.
    pub fn deformation_gradients(&self, u: &[[Lanes; 3]], first: usize, q: usize) -> [Lanes; 9] {
        let mut f = IDENTITY.map(Lanes::of);
        widest(Deformation { u, gradients: self.gradients_of_batch(first, q), f: &mut f });
        f
    }

    /// ∂N_a/∂X of each node at point `q` of the [`LANES`] blocks from `first` on \[1/m\].
    pub fn gradients_of_batch(&self, first: usize, q: usize) -> &[[Lanes; 3]] {
        self.gradients_of_group(first / LANES, q)
    }

    /// Adds r_e += w P ∂N/∂X and K_e += w ∂N/∂X A ∂N/∂X (column ≤ row), where a row of K_e has `stride` entries.
    #[expect(clippy::too_many_arguments, reason = "place, two tensors, and where they go")]
    pub fn scatter(&self, b: usize, q: usize, stride: usize, p: &Mat3, a: &Mat9, want: Want, out: &mut BlockValues) {
        let weights = [self.weight(b, q)];
        let p = rows(p);
        let mut gradients = [[0.0; 3]; MOST_NODES];
        gradients.iter_mut().zip(self.gradients(b, q)).for_each(|(to, from)| *to = from);
        let place = Place { gradients: &gradients[..self.nodes], weights: &weights, stride, want };
        match self.nodes {
            4 => scatter::<_, 4, 1>(&place, [(&p, a)], &mut out.r, &mut out.k, |to, sum| *to += sum),
            _ => scatter::<_, MOST_NODES, 1>(&place, [(&p, a)], &mut out.r, &mut out.k, |to, sum| *to += sum),
        }
    }
}

/// The identity tensor, row by row.
const IDENTITY: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

/// Adds u ⊗ ∂N/∂X to F, given row by row.
#[inline(always)]
fn add_gradient<S: Real>(f: &mut [S; 9], u: [S; 3], g: [S; 3]) {
    for i in 0..3 {
        for j in 0..3 {
            f[3 * i + j] += u[i] * g[j];
        }
    }
}

struct Deformation<'a> {
    u: &'a [[Lanes; 3]],
    gradients: &'a [[Lanes; 3]],
    f: &'a mut [Lanes; 9],
}

impl Kernel for Deformation<'_> {
    #[inline(always)]
    fn run(self) {
        for (&u, &g) in self.u.iter().zip(self.gradients) {
            add_gradient(self.f, u, g);
        }
    }
}

/// The kernel that computes r_e += Σ_q w P ∂N/∂X and K_e = Σ_q w ∂N/∂X A ∂N/∂X (column ≤ row) of [`LANES`] blocks, where a row of K_e has `stride`
/// entries.
struct Forces<'a> {
    /// \[points × nodes\]
    gradients: &'a [[Lanes; 3]],
    /// \[points\]
    weights: &'a [Lanes],
    /// \[points\]
    responses: &'a [LaneResponse],
    stride: usize,
    want: Want,
    out: &'a mut Batch,
}

impl Kernel for Forces<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { gradients, weights, responses, stride, want, out } = self;
        let place = Place { gradients, weights, stride, want };
        let set = |to: &mut Lanes, sum| *to = sum;
        match responses {
            [one] => scatter::<_, 4, 1>(&place, [(&one.p, &one.a)], &mut out.r, &mut out.k, set),
            [a, b, c, d] => {
                let of = [(&a.p, &a.a), (&b.p, &b.a), (&c.p, &c.a), (&d.p, &d.a)];
                scatter::<_, MOST_NODES, MOST_POINTS>(&place, of, &mut out.r, &mut out.k, set);
            }
            _ => unreachable!("a cell has 1 or 4 points"),
        }
    }
}

/// Points of one block, or of several side by side, and the layout of K_e.
struct Place<'a, S> {
    /// \[points × nodes\] ∂N_a/∂X \[1/m\]
    gradients: &'a [[S; 3]],
    /// \[points\] w det ∂X/∂ξ \[m³\]
    weights: &'a [S],
    /// Entries of a row of K_e
    stride: usize,
    want: Want,
}

/// Adds the forces on N nodes from P and A at Q points; `put` receives each entry of K and its sum over the points.
#[inline(always)]
fn scatter<S: Real, const N: usize, const Q: usize>(
    place: &Place<S>,
    of: [(&[S; 9], &[[S; 9]; 9]); Q],
    r: &mut [S],
    k: &mut [S],
    put: impl Fn(&mut S, S),
) {
    let Place { gradients, weights, stride, want } = *place;
    for ((g, &w), (p, _)) in gradients.chunks_exact(N).zip(weights).zip(&of) {
        for (n, g) in g.iter().enumerate() {
            for i in 0..3 {
                r[3 * n + i] += w * (p[3 * i] * g[0] + p[3 * i + 1] * g[1] + p[3 * i + 2] * g[2]);
            }
        }
    }
    if want < Want::Tangent {
        return;
    }
    for column in 0..N {
        // T_iJk = w Σ_L A_iJkL ∂N_b/∂X_L
        let mut t = [[[S::of(0.0); 3]; 9]; Q];
        for q in 0..Q {
            let (gb, w) = (&gradients[q * N + column], weights[q]);
            let h = [w * gb[0], w * gb[1], w * gb[2]];
            for (t, a) in t[q].iter_mut().zip(of[q].1) {
                for k in 0..3 {
                    t[k] = a[3 * k] * h[0] + a[3 * k + 1] * h[1] + a[3 * k + 2] * h[2];
                }
            }
        }
        for row in column..N {
            for i in 0..3 {
                let mut sum = [S::of(0.0); 3];
                for q in 0..Q {
                    let (ga, t) = (&gradients[q * N + row], &t[q][3 * i..3 * i + 3]);
                    for k in 0..3 {
                        sum[k] += ga[0] * t[0][k] + ga[1] * t[1][k] + ga[2] * t[2][k];
                    }
                }
                let target = &mut k[(3 * row + i) * stride + 3 * column..][..3];
                target.iter_mut().zip(sum).for_each(|(to, sum)| put(to, sum));
            }
        }
    }
}
