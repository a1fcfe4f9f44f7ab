//! Viscous damping in the bulk.

use super::cell::{CellPoints, MOST_NODES};
use super::damping_work::work;
use crate::material::LaneResponse;
use crate::math::lanes::{Kernel, Lanes, Real, widest};
use crate::math::tensor::{Mat3, ZERO9, rows};
use crate::mesh::TetMesh;
use crate::system::{
    At, Batch, Batched, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Needs, PastDerivative,
    Perturbation, Want,
};

/// Kelvin–Voigt damping S_v = η Ė with Ė = (E − Eₙ)/Δt, E = ½(FᵀF − I), η \[Pa s\].
///
/// Objective, with an exact symmetric tangent (it derives from the incremental potential ½ηΔt ‖Ė‖²); first-order accurate in Δt with every
/// integrator. At the start of a stage, when no time has passed, Ė = sym(FₙᵀḞ) with Ḟ = ∂v/∂X, and F is Fₙ.
pub struct ViscousDamping {
    eta: f64,
    points: CellPoints,
}

impl ViscousDamping {
    /// Builds the damping on the cells of a region, with η in Pa s.
    pub fn new(mesh: &TetMesh, cells: &[u32], eta: f64) -> Self {
        Self { eta, points: CellPoints::new(mesh, cells) }
    }

    /// η \[Pa s\].
    pub fn eta(&self) -> f64 {
        self.eta
    }

    /// Cells on which it acts.
    pub fn cells(&self) -> &[u32] {
        &self.points.cells
    }
}

impl Effect for ViscousDamping {
    fn name(&self) -> &str {
        "viscous_damping"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Dissipative
    }

    fn blocks(&self) -> &Blocks {
        &self.points.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        if at.is_static() {
            return Ok(());
        }
        let c = self.eta / at.dt;
        for q in 0..self.points.points() {
            let by_rows = |x: &[f64]| rows(&self.points.deformation_gradient(x, b, q));
            let (mut p, mut a) = ([0.0; 9], ZERO9);
            if at.is_start() {
                p = starting_stress(&by_rows(at.old), &by_rows(at.v), 0.5 * self.eta);
            } else {
                viscous_stress(&by_rows(at.x), &by_rows(at.old), 0.5 * c, want, &mut p, &mut a);
            }
            self.points.scatter(b, q, self.points.blocks.size(b), &Mat3::from_row_slice(&p), &a, want, out);
        }
        out.energy = work(&self.points.blocks, at, b, out);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            needs: Needs { velocity: true, acceleration: false },
            past: Some(self),
            batched: Some(self),
            ..Capabilities::default()
        }
    }
}

impl Batched for ViscousDamping {
    fn eval(&self, at: &At, first: usize, want: Want, out: &mut Batch) -> Result<(), EvalError> {
        let points = &self.points;
        let stride = points.blocks.size(first);
        if want == Want::Tangent && (at.is_static() || at.is_start()) {
            out.clear_rows(stride, 0..stride);
        }
        if at.is_static() {
            return Ok(());
        }
        let [u, old] = [at.x, at.old].map(|x| points.displacements::<MOST_NODES>(x, first));
        if at.is_start() {
            let v = points.displacements::<MOST_NODES>(at.v, first);
            return points.each_point(first, stride, want.min(Want::Residual), out, |q, _, _, response| {
                let [f, rate] = [&old, &v].map(|u| points.deformation_gradients(u, first, q));
                response.p = starting_stress(&f, &rate, 0.5 * self.eta);
                Ok(())
            });
        }
        points.each_point(first, stride, want, out, |q, _, _, response| {
            let f = &points.deformation_gradients(&u, first, q);
            let old = &points.deformation_gradients(&old, first, q);
            widest(Stress { f, old, c: 0.5 * self.eta / at.dt, want, response });
            Ok(())
        })?;
        let moved = u.iter().zip(&old).flat_map(|(u, old)| u.iter().zip(old)).map(|(u, old)| *u - *old);
        out.energy = moved.zip(&out.r[..stride]).fold(Lanes::ZERO, |sum, (d, r)| sum + *r * d);
        Ok(())
    }
}

struct Stress<'a> {
    f: &'a [Lanes; 9],
    old: &'a [Lanes; 9],
    c: f64,
    want: Want,
    response: &'a mut LaneResponse,
}

impl Kernel for Stress<'_> {
    #[inline(always)]
    fn run(self) {
        let LaneResponse { p, a, .. } = self.response;
        viscous_stress(self.f, self.old, self.c, self.want, p, a);
    }
}

/// Computes P = F S with S = c (FᵀF − FₙᵀFₙ), and A_iJkL = δ_ik S_LJ + c (F_iL F_kJ + δ_LJ F_iM F_kM), row by row.
#[inline(always)]
pub fn viscous_stress<S: Real>(f: &[S; 9], old: &[S; 9], c: f64, want: Want, p: &mut [S; 9], a: &mut [[S; 9]; 9]) {
    let (c, zero) = (S::of(c), S::of(0.0));
    let columns = |f: &[S; 9], i: usize, j: usize| f[i] * f[j] + f[3 + i] * f[3 + j] + f[6 + i] * f[6 + j];
    let rows = |i: usize, k: usize| f[3 * i] * f[3 * k] + f[3 * i + 1] * f[3 * k + 1] + f[3 * i + 2] * f[3 * k + 2];
    let mut s = [zero; 9];
    for i in 0..3 {
        for j in 0..3 {
            s[3 * i + j] = c * (columns(f, i, j) - columns(old, i, j));
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            p[3 * i + j] = f[3 * i] * s[j] + f[3 * i + 1] * s[3 + j] + f[3 * i + 2] * s[6 + j];
        }
    }
    if want < Want::Tangent {
        return;
    }
    for (row, a) in a.iter_mut().enumerate() {
        let (i, j) = (row / 3, row % 3);
        for (column, a) in a.iter_mut().enumerate() {
            let (k, l) = (column / 3, column % 3);
            let geometric = if i == k { s[3 * l + j] } else { zero };
            let diagonal = if l == j { rows(i, k) } else { zero };
            *a = geometric + c * (f[3 * i + l] * f[3 * k + j] + diagonal);
        }
    }
}

/// Computes P = F S with S = c (FᵀḞ + ḞᵀF), row by row, from F and I + Ḟ.
#[inline(always)]
fn starting_stress<S: Real>(f: &[S; 9], with_rate: &[S; 9], c: f64) -> [S; 9] {
    let mut rate = *with_rate;
    [0, 4, 8].into_iter().for_each(|n| rate[n] = rate[n] - S::of(1.0));
    let half = |i: usize, j: usize| f[i] * rate[j] + f[3 + i] * rate[3 + j] + f[6 + i] * rate[6 + j];
    let s = |i: usize, j: usize| S::of(c) * (half(i, j) + half(j, i));
    std::array::from_fn(|n| {
        f[3 * (n / 3)] * s(0, n % 3) + f[3 * (n / 3) + 1] * s(1, n % 3) + f[3 * (n / 3) + 2] * s(2, n % 3)
    })
}

impl PastDerivative for ViscousDamping {
    /// S_v changes by −(η/Δt) sym(FₙᵀdFₙ); at the start of a stage P by dFₙ S_v + η Fₙ sym(dFₙᵀḞ + FₙᵀdḞ).
    fn along(&self, at: &At, direction: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        if at.is_static() {
            return Ok(());
        }
        for q in 0..self.points.points() {
            let [f, old] = [at.x, at.old].map(|x| self.points.deformation_gradient(x, b, q));
            let slope = |u: &[f64]| self.points.deformation_gradient(u, b, q) - Mat3::identity();
            let twice = |m: Mat3| m + m.transpose();
            let change = slope(direction.old);
            let p = if at.is_start() {
                let (rate, faster) = (slope(at.v), slope(direction.v));
                let ds = twice(change.tr_mul(&rate) + old.tr_mul(&faster));
                (change * twice(old.tr_mul(&rate)) + old * ds) * (0.5 * self.eta)
            } else {
                f * (-0.5 * self.eta / at.dt * twice(old.tr_mul(&change)))
            };
            self.points.scatter(b, q, self.points.blocks.size(b), &p, &ZERO9, Want::Residual, out);
        }
        Ok(())
    }
}
