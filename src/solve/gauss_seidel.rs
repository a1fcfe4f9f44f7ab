//! Forces p of points on planes under complementarity and friction, by Gauss–Seidel over the points (Jourdan, Alart & Jean, Comput. Methods
//! Appl. Mech. Eng. 155, 1998), with all constraints of the system as one more block, whose multipliers are solved for exactly.
//!
//! ```text
//! g = g_free + W p      W = H K⁻¹ Hᵀ      0 ≤ g_n ⟂ p_n ≥ 0      p_t = −μ p_n f(|g_t|/ε) g_t/|g_t|
//! ```
//!
//! The friction law f is in [`friction`](crate::system::friction).
//!
//! Limits: W is dense, so it is for some hundreds of points. Where more points hold a body than it needs, the sum of p is unique, p is not.

use super::Failure;
use super::multipliers::Schur;
use crate::math::tensor::{Vec3, perpendicular};
use crate::math::vector::dot;
use crate::system::{ContactPoint, Dofs, System, friction};

const SWEEPS: usize = 20_000;
/// Change of a gap over the last sweep, as a share of the largest gap \[–\].
const EXACT: f64 = 1e-10;

/// A point under pressure.
pub(super) struct Pressed {
    /// Place in the list of all
    pub place: usize,
    /// Index of its normal component; those of two directions of sliding follow where there is friction
    pub first: usize,
    /// μ |m| \[–\] and ε \[m\]
    friction: Option<(f64, f64)>,
}

/// Points under pressure, and the response to their forces; one entry for each component of a force.
#[derive(Default)]
pub(super) struct Contacts {
    pub points: Vec<Pressed>,
    /// H as (equation, entry)
    h: Vec<Vec<(usize, f64)>>,
    /// \[equations\] K⁻¹ Hᵀ
    pub z: Vec<Vec<f64>>,
    /// g or sliding without p and λ' − λ \[m\]
    free: Vec<f64>,
    /// \[rows\] W
    w: Vec<Vec<f64>>,
    /// \[constraints\] ∂c/∂x K⁻¹ Hᵀ, and H K⁻¹ ∂c/∂x
    cross: Vec<Vec<f64>>,
    back: Vec<Vec<f64>>,
    /// p \[N\]
    pub p: Vec<f64>,
}

impl Contacts {
    /// Adds a point with its gap and its displacement since the start of the step \[m\], both without those of the solution.
    pub fn add(&mut self, system: &System, place: usize, point: &ContactPoint, (gap, displacement): (f64, Vec3)) {
        let row = |direction: &Vec3| -> Vec<(usize, f64)> {
            let entries = point.nodes.iter().zip(&point.shares).flat_map(|(&node, share)| {
                (0..3).map(move |i| (system.dofs.equation[3 * node as usize + i], share * direction[i]))
            });
            let free = entries.filter(|(equation, _)| *equation != Dofs::FIXED);
            free.map(|(equation, entry)| (equation as usize, entry)).collect()
        };
        let normal = row(&point.normal);
        // A point that is prescribed altogether cannot be corrected.
        if normal.is_empty() {
            return;
        }
        let first = self.h.len();
        self.h.push(normal);
        self.free.push(gap);
        let size = point.normal.norm();
        if point.friction.is_some() {
            let one = perpendicular(&(point.normal / size));
            for along in [one, point.normal.cross(&one) / size] {
                self.h.push(row(&along));
                self.free.push(along.dot(&displacement));
            }
        }
        let friction = point.friction.map(|(coefficient, epsilon)| (coefficient * size, epsilon));
        self.points.push(Pressed { place, first, friction });
    }

    /// Hᵀ of the components that were added last, column after column.
    pub fn columns(&self, equations: usize) -> Vec<f64> {
        let fresh = &self.h[self.z.len()..];
        let mut columns = vec![0.0; fresh.len() * equations];
        for (column, row) in columns.chunks_exact_mut(equations).zip(fresh) {
            row.iter().for_each(|&(equation, entry)| column[equation] += entry);
        }
        columns
    }

    /// Takes the response to these components, `columns` = K⁻¹ Hᵀ; y = K⁻¹ (−r).
    pub fn respond(&mut self, columns: &[f64], y: &[f64], schur: &Schur, gradient: &[Vec<f64>]) {
        let along = |row: &[(usize, f64)], v: &[f64]| row.iter().map(|&(e, entry)| entry * v[e]).sum::<f64>();
        let known = self.z.len();
        self.z.extend(columns.chunks_exact(y.len()).map(<[f64]>::to_vec));
        self.p.resize(self.z.len(), 0.0);
        for i in known..self.z.len() {
            self.free[i] += along(&self.h[i], y);
            self.cross.push(gradient.iter().map(|h| dot(h, &self.z[i])).collect());
            self.back.push(schur.z.chunks_exact(y.len()).map(|z| along(&self.h[i], z)).collect());
        }
        self.w = self.h.iter().map(|row| self.z.iter().map(|z| along(row, z)).collect()).collect();
    }

    /// Gauss–Seidel for p; `multipliers` gives λ' under p. Returns λ'.
    pub fn settle(
        &mut self,
        multipliers: impl Fn(&[f64], &[Vec<f64>]) -> Result<Vec<f64>, Failure>,
        old: &[f64],
    ) -> Result<Vec<f64>, Failure> {
        let size = self.free.iter().fold(0.0, |m: f64, g| m.max(g.abs()));
        for _ in 0..SWEEPS {
            let lambda = multipliers(&self.p, &self.cross)?;
            let mut change = 0.0;
            for k in 0..self.points.len() {
                let before = self.p.clone();
                self.press(k, &lambda, old);
                let gap_change = |i: usize| self.w[i][i] * (self.p[i] - before[i]).abs();
                change = (0..self.p.len()).map(gap_change).fold(change, f64::max);
            }
            if change <= EXACT * size {
                return multipliers(&self.p, &self.cross);
            }
        }
        Err(Failure::Complementarity)
    }

    /// The force on point `k` under those on all others.
    fn press(&mut self, k: usize, lambda: &[f64], old: &[f64]) {
        let Pressed { first: n, friction, .. } = self.points[k];
        let value = |p: &[f64], i: usize| {
            let by_rows: f64 =
                self.back[i].iter().zip(lambda.iter().zip(old)).map(|(b, (new, old))| b * (new - old)).sum();
            self.free[i] - by_rows + dot(&self.w[i], p)
        };
        let pressed = (self.p[n] - value(&self.p, n) / self.w[n][n]).max(0.0);
        let mut p = std::mem::take(&mut self.p);
        p[n] = pressed;
        if let Some((coefficient, epsilon)) = friction {
            let w = |i: usize, j: usize| self.w[n + i][n + j];
            // The larger eigenvalue takes both directions for one.
            let w = 0.5 * (w(1, 1) + w(2, 2)) + (0.25 * (w(1, 1) - w(2, 2)).powi(2) + w(1, 2) * w(2, 1)).sqrt();
            let free = [1, 2].map(|i| value(&p, n + i) - w * p[n + i]);
            let force = friction::resistance(free[0].hypot(free[1]), w, coefficient * pressed, epsilon);
            [1, 2].iter().zip(free).for_each(|(i, free)| p[n + i] = -force * free);
        }
        self.p = p;
    }
}
