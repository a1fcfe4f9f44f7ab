//! The distance d = |z| of two features that move with their nodes, and its derivatives, by one formula for all kinds of features.
//!
//! z = Σ_k s_k(β) x_k with the parameters β that minimise |z|: two in a triangle, one on each edge, none at a corner. With z_i = ∂z/∂β_i, s_k,i =
//! ∂s_k/∂β_i, H_ij = z_i·z_j and B_i,k = s_k z_i + s_k,i z, by the envelope theorem,
//!
//! ```text
//! ∂d/∂x_k = s_k n, n = z/d        ∂²d/∂x_k∂x_l = (s_k s_l (I − nnᵀ) − Σ_ij H⁻¹_ij B_i,k B_j,lᵀ)/d
//! ```
//!
//! Σ s_k = 0 and Σ s_k x_k = d n: forces and their moments are in balance. Limits: ∂²d is discontinuous where the nearest feature changes; H is
//! singular for parallel edges.

use crate::math::tensor::{Mat3, Vec3};
use crate::system::{BlockValues, Want};
use nalgebra::Matrix2;

/// A pair of features at their nearest points.
#[derive(Clone, Debug)]
pub struct PairDistance {
    pub nodes: Vec<u32>,
    /// \[nodes\] s_k
    pub shares: Vec<f64>,
    /// \[parameters\] s_k,i
    slopes: Vec<Vec<f64>>,
    /// z \[m\]
    apart: Vec3,
    /// \[parameters\] z_i \[m\]
    along: Vec<Vec3>,
}

impl PairDistance {
    /// Builds the pair for nodes at `x` \[m\], from the shares s and their derivatives with respect to each parameter.
    pub fn new(nodes: Vec<u32>, x: impl Fn(u32) -> Vec3, shares: Vec<f64>, slopes: Vec<Vec<f64>>) -> Self {
        let at: Vec<Vec3> = nodes.iter().map(|&k| x(k)).collect();
        let sum = |s: &Vec<f64>| s.iter().zip(&at).map(|(s, x)| *x * *s).sum::<Vec3>();
        let (apart, along) = (sum(&shares), slopes.iter().map(sum).collect());
        Self { nodes, shares, slopes, apart, along }
    }

    /// The distance d \[m\].
    pub fn gap(&self) -> f64 {
        self.apart.norm()
    }

    /// The normal n, from the second part to the first.
    pub fn normal(&self) -> Vec3 {
        self.apart / self.gap()
    }

    /// Returns ∂²d by blocks of two nodes; undefined for parallel edges.
    pub fn curvature(&self) -> impl Fn(usize, usize) -> Mat3 + '_ {
        let (d, n) = (self.gap(), self.normal());
        let plane = Mat3::identity() - n * n.transpose();
        let inverse = self.inverse();
        let mixed = move |i: usize, k: usize| self.along[i] * self.shares[k] + self.apart * self.slopes[i][k];
        move |k, l| {
            let mut sum = plane * (self.shares[k] * self.shares[l]);
            for i in 0..self.along.len() {
                for j in 0..self.along.len() {
                    sum -= mixed(i, k) * mixed(j, l).transpose() * inverse[(i, j)];
                }
            }
            sum / d
        }
    }

    /// Returns H⁻¹, in the upper left.
    fn inverse(&self) -> Matrix2<f64> {
        let h = |i: usize, j: usize| self.along[i].dot(&self.along[j]);
        match self.along.len() {
            0 => Matrix2::zeros(),
            1 => Matrix2::new(1.0 / h(0, 0), 0.0, 0.0, 0.0),
            _ => Matrix2::new(h(0, 0), h(0, 1), h(1, 0), h(1, 1)).try_inverse().unwrap_or(Matrix2::zeros()),
        }
    }

    /// Adds r and K of a function of d with the derivatives φ′ and φ″.
    pub fn add(&self, (first, second): (f64, f64), want: Want, out: &mut BlockValues) {
        let (n, size) = (self.normal(), 3 * self.nodes.len());
        for (k, share) in self.shares.iter().enumerate() {
            (0..3).for_each(|i| out.r[3 * k + i] += first * share * n[i]);
        }
        if want < Want::Tangent {
            return;
        }
        let (stiff, curvature) = (n * n.transpose() * second, self.curvature());
        for k in 0..self.nodes.len() {
            for l in 0..=k {
                let entry = stiff * (self.shares[k] * self.shares[l]) + curvature(k, l) * first;
                for (i, j) in (0..9).map(|e| (e / 3, e % 3)) {
                    out.k[(3 * k + i) * size + 3 * l + j] += entry[(i, j)];
                }
            }
        }
    }
}
