//! Position of an obstacle: fixed in space, or in the frame of an affine body (four nodes that carry it).
//!
//! An affine body maps X to x = Σ_a w_a(X) p_a, with w_i = (X − C)_i/ℓ, w_0 = 1 − Σ w_i and A = ∂x/∂X; it is rigid where
//! AᵀA = I. A point x has the position X = C + A⁻¹(x − p_0) in it. With z = (x, p_0 … p_3) and s = (1, −w_0 … −w_3):
//!
//! ```text
//! dX = A⁻¹ Σ_k s_k dz_k        d²X = −A⁻¹(dA δX + δA dX)
//! ```
//!
//! so that a function d(X) has ∂d/∂z_k = s_k m with m = A⁻ᵀ ∂d/∂X, and Σ_k s_k z_k = 0: its forces and their moments are in balance.

use super::shape::{Shape, Witness};
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::surface_file::Surface;

/// Number of triangles around a round obstacle, and number of positions on an obstacle of few triangles.
const AROUND: u32 = 24;
const PLACES: f64 = 2000.0;

/// The four nodes of an affine body, at rest at C and C + ℓ e_i.
#[derive(Clone, Debug, PartialEq)]
pub struct AffineFrame {
    pub nodes: [u32; 4],
    /// C \[m\]
    pub center: Vec3,
    /// ℓ \[m\]
    pub length: f64,
}

impl AffineFrame {
    /// Positions of the four nodes at rest \[m\].
    pub fn rest(&self) -> [Vec3; 4] {
        [0, 1, 2, 3].map(|a| self.center + if a == 0 { Vec3::zeros() } else { Vec3::ith(a - 1, self.length) })
    }

    /// Positions of the four nodes at displacement x \[m\].
    pub fn positions(&self, x: &[f64]) -> [Vec3; 4] {
        let rest = self.rest();
        [0, 1, 2, 3].map(|a| rest[a] + displacement(x, self.nodes[a]))
    }

    /// The gradient A for the node positions `p`.
    pub fn gradient(&self, p: &[Vec3; 4]) -> Mat3 {
        Mat3::from_columns(&[1, 2, 3].map(|i| (p[i] - p[0]) / self.length))
    }

    /// The gradient A at displacement x, computed from displacements alone, so that a position far from the origin adds no rounding.
    pub fn gradient_of(&self, x: &[f64]) -> Mat3 {
        let u = self.nodes.map(|node| displacement(x, node));
        Mat3::identity() + Mat3::from_columns(&[1, 2, 3].map(|i| (u[i] - u[0]) / self.length))
    }

    /// The weights w_a(X).
    pub fn weights(&self, place: &Vec3) -> [f64; 4] {
        let w = (place - self.center) / self.length;
        [1.0 - w.sum(), w.x, w.y, w.z]
    }
}

/// Displacement of a node.
pub(in crate::effect) fn displacement(x: &[f64], node: u32) -> Vec3 {
    Vec3::from_column_slice(&x[3 * node as usize..][..3])
}

/// A shape in space, with the origin and axes of its frame at rest.
pub struct Obstacle {
    pub shape: Shape,
    pub origin: Vec3,
    /// Axes of the frame of the shape in its columns
    pub axes: Mat3,
    /// The affine body that moves it; `None` if it is fixed
    pub body: Option<AffineFrame>,
}

/// An obstacle in one state: the map from space into the frame of its shape.
pub(super) struct Placed<'a> {
    pub obstacle: &'a Obstacle,
    p0: Vec3,
    /// A⁻¹
    inverse: Mat3,
    /// Smallest singular value of A
    shrink: f64,
}

/// Distance of one point, and its dependence on the motion of the point and of the four nodes.
pub(super) struct Pair {
    pub gap: f64,
    /// m = ∂d/∂x
    pub normal: Vec3,
    /// A⁻ᵀ ∂²d/∂X² A⁻¹
    curvature: Mat3,
    /// w_a; `None` for a fixed obstacle
    pub carried: Option<[f64; 4]>,
    /// A⁻ᵀ ∂w_a/∂X
    turning: [Vec3; 4],
}

impl Obstacle {
    pub(super) fn at(&self, x: &[f64]) -> Placed<'_> {
        self.along(x, x, 0.0)
    }

    /// The obstacle as placed at x + share dx.
    pub(super) fn along(&self, x: &[f64], dx: &[f64], share: f64) -> Placed<'_> {
        let Some(body) = &self.body else {
            return Placed { obstacle: self, p0: Vec3::zeros(), inverse: Mat3::identity(), shrink: 1.0 };
        };
        let mut p = body.positions(x);
        p.iter_mut().zip(body.nodes).for_each(|(p, node)| *p += displacement(dx, node) * share);
        let a = body.gradient(&p);
        // A collapsed body has no interior: the distance 0 stops the step.
        let (inverse, shrink) = a.try_inverse().map_or((Mat3::identity(), 0.0), |i| (i, a.singular_values().min()));
        Placed { obstacle: self, p0: p[0], inverse, shrink }
    }

    /// Positions distributed over its surface at displacement x \[m\], including all vertices; empty for a floor.
    pub fn places(&self, x: &[f64]) -> Vec<Vec3> {
        let Some(Surface { points, triangles }) = self.shape.triangles(AROUND) else { return Vec::new() };
        let parts = (PLACES / triangles.len() as f64).sqrt().ceil() as usize;
        let weight = |i: usize| i as f64 / parts as f64;
        let grid = || (0..=parts).flat_map(|i| (0..=parts - i).map(move |j| [weight(i), weight(j)]));
        let in_triangle = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|k| points[k as usize]);
            grid().map(move |[i, j]| a + (b - a) * i + (c - a) * j)
        };
        let in_space = |local: Vec3| {
            let place = self.origin + self.axes * local;
            let moved =
                |body: &AffineFrame| body.weights(&place).iter().zip(body.positions(x)).map(|(w, p)| p * *w).sum();
            self.body.as_ref().map_or(place, moved)
        };
        triangles.iter().flat_map(in_triangle).map(in_space).collect()
    }

    /// A A_old⁻¹: the rotation of the obstacle from displacement `old` to x.
    pub(super) fn turn(&self, [x, old]: [&[f64]; 2]) -> Mat3 {
        let back = self.body.as_ref().and_then(|body| Some((body, body.gradient_of(old).try_inverse()?)));
        back.map_or(Mat3::identity(), |(body, back)| body.gradient_of(x) * back)
    }

    /// Upper bound of the displacement of any point of the obstacle due to dx \[m\].
    pub(super) fn speed(&self, dx: &[f64]) -> f64 {
        let Some(body) = &self.body else { return 0.0 };
        let d = body.nodes.map(|n| displacement(dx, n));
        let Some([low, high]) = self.shape.bounds() else { return d[0].norm() };
        let corner = |k: usize| Vec3::from_fn(|i, _| if k >> i & 1 == 0 { low[i] } else { high[i] });
        let place = |k: usize| body.weights(&(self.origin + self.axes * corner(k)));
        (0..8).map(|k| place(k).iter().zip(&d).map(|(w, d)| *w * d).sum::<Vec3>().norm()).fold(0.0, f64::max)
    }
}

impl Placed<'_> {
    /// Position X in the affine body of a point in space.
    pub fn place(&self, x: &Vec3) -> Vec3 {
        match &self.obstacle.body {
            None => *x,
            Some(body) => body.center + self.inverse * (x - self.p0),
        }
    }

    /// The point in the frame of the shape.
    pub fn local(&self, x: &Vec3) -> Vec3 {
        self.obstacle.axes.tr_mul(&(self.place(x) - self.obstacle.origin))
    }

    /// Smallest ratio of a distance in space to the distance in the frame \[–\].
    pub fn shrink(&self) -> f64 {
        self.shrink
    }

    /// Returns the derivatives of a witness at the point x in space.
    pub fn pair(&self, x: &Vec3, witness: &Witness, offset: f64) -> Pair {
        let axes = &self.obstacle.axes;
        let back = self.inverse.transpose() * axes;
        let (normal, curvature) = (back * witness.normal, back * witness.curvature * back.transpose());
        let mut turning = [Vec3::zeros(); 4];
        let carried = self.obstacle.body.as_ref().map(|body| {
            for i in 0..3 {
                turning[i + 1] = self.inverse.row(i).transpose() / body.length;
                turning[0] -= self.inverse.row(i).transpose() / body.length;
            }
            body.weights(&self.place(x))
        });
        Pair { gap: witness.gap - offset, normal, curvature, carried, turning }
    }
}

impl Pair {
    /// Returns s of a point with the weights `own` of its nodes, followed by those of the four nodes.
    pub fn shares(&self, own: &[f64]) -> Vec<f64> {
        own.iter().copied().chain(self.carried.iter().flatten().map(|w| -w)).collect()
    }

    /// Returns ∂²d/∂z_k∂z_l; the first `own` indices belong to the point.
    pub fn second(&self, s: &[f64], own: usize, k: usize, l: usize) -> Mat3 {
        let mut sum = self.curvature * (s[k] * s[l]);
        if k >= own {
            sum -= self.normal * self.turning[k - own].transpose() * s[l];
        }
        if l >= own {
            sum -= self.turning[l - own] * self.normal.transpose() * s[k];
        }
        sum
    }
}
