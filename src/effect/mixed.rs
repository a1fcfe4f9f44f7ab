//! Mixed displacement–pressure formulations, free of volumetric locking.
//!
//! A law with the split ψ = ψ̃(F) + ½κ G(J)² enters by the perturbed Lagrangian (de Borst, Simo, Taylor & Pister 1985)
//!
//! Π(u, p) = ∫ ψ̃(F) + p G(J) − p²/2κ dV − ½ Σ_cells (α/μ) ∫ (p − Πp)² dV,
//!
//! with p linear in each cell and continuous within groups of cells ([`PressureHosts`]). On tet10 this is the Taylor–Hood element, stable without the
//! last term (α = 0). On tet4 the pair is not stable, and the last term, the polynomial pressure projection of Dohrmann & Bochev (2004) with the cell
//! mean Πp, stabilises it.
//!
//! The unknown is π = p ℓ/μ \[m\], with ℓ the mean cell size, so that all unknowns have the same dimension. The tangent is symmetric and indefinite,
//! with one negative eigenvalue per pressure.

use super::cell::{CellPoints, MOST_NODES};
use super::constitution::{Constitution, PressureField};
use super::mixed_along::MixedAlong;
use super::pressure_hosts::PressureHosts;
use super::stress::{PointStress, Stressed};
use crate::material::{LaneResponse, Law, LawCard, LawError, Moduli, Volumetric};
use crate::math::lanes::{Kernel, LANES, Lanes, Real, widest};
use crate::math::tensor::{Mat3, Mat9, cofactor, det_minus_one, rows};
use crate::mesh::{Order, TetMesh, element, quadrature};
use crate::system::{At, Batch, Batched, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Want};
use std::sync::Arc;

/// Constant α of the stabilisation on tet4.
const STABILISATION: f64 = 1.0;

/// A law with a split on the cells of a region, with an independent pressure field.
pub struct MixedElastic {
    name: String,
    whole: LawCard,
    /// The law without its volumetric part
    rest: Box<dyn Law>,
    volumetric: Volumetric,
    /// Hooke's constants of the whole law at F = I
    hooke: Moduli,
    points: Arc<CellPoints>,
    blocks: Blocks,
    /// \[points × 4\] N_c at the points
    shape: Vec<[f64; 4]>,
    /// \[cells\] ∫ N_c N_d /κ + (α/μ)(N_c − ΠN_c)(N_d − ΠN_d) dV \[m³/Pa\], times s²
    compliance: Vec<[[f64; 4]; 4]>,
    /// p = s π, s = μ/ℓ \[Pa/m\]
    s: f64,
}

impl MixedElastic {
    /// Builds the effect. `first` is the index in `State::x` of the first of the pressures of `hosts`, which belong to these cells. `None` for laws
    /// without a split.
    pub fn new(
        name: String,
        mesh: &TetMesh,
        cells: &[u32],
        law: &dyn Law,
        hosts: &PressureHosts,
        first: u32,
    ) -> Option<Self> {
        let (rest, volumetric) = law.split()?;
        let kappa = volumetric.kappa;
        let hooke = law.small_strain();
        let mu = hooke.mu;
        let s = mu / mesh.h();
        let scalars: Vec<[u32; 4]> = hosts.of_cells.iter().map(|own| own.map(|number| first + number)).collect();
        let lists = cells.iter().zip(&scalars).map(|(&c, p)| (mesh.cell(c as usize), &p[..]));
        let alpha = if mesh.order == Order::Linear { STABILISATION } else { 0.0 };
        let compliance = cells.iter().map(|&c| compliance(mesh, c as usize, 1.0 / kappa, alpha / mu, s)).collect();
        let blocks = Blocks::with_scalars(lists);
        let points = Arc::new(CellPoints::new(mesh, cells));
        let shape = points.reference().iter().map(|&xi| corner_shape(xi)).collect();
        let whole = LawCard::of(law);
        Some(Self { name, whole, rest, volumetric, hooke, points, blocks, shape, compliance, s })
    }

    /// Corner pressures p \[Pa\] of block `b`.
    fn pressures(&self, x: &[f64], b: usize) -> [f64; 4] {
        std::array::from_fn(|k| self.s * x[self.blocks.scalars(b)[k] as usize])
    }
}

fn corner_shape(xi: [f64; 3]) -> [f64; 4] {
    let n = element::cell_shape(Order::Linear, xi);
    [n[0], n[1], n[2], n[3]]
}

fn compliance(mesh: &TetMesh, c: usize, bulk: f64, shear: f64, s: f64) -> [[f64; 4]; 4] {
    let rule = quadrature::tet(if mesh.order == Order::Linear { 2 } else { 5 });
    let (mut mass, mut mean, mut volume) = ([[0.0; 4]; 4], [0.0; 4], 0.0);
    for (&xi, w) in rule.points.iter().zip(&rule.weights) {
        let dv = w * mesh.jacobian(c, xi).determinant();
        let n = corner_shape(xi);
        volume += dv;
        for a in 0..4 {
            mean[a] += dv * n[a];
            for b in 0..4 {
                mass[a][b] += dv * n[a] * n[b];
            }
        }
    }
    let entry = |a: usize, b: usize| bulk * mass[a][b] + shear * (mass[a][b] - mean[a] * mean[b] / volume);
    std::array::from_fn(|a| std::array::from_fn(|b| s * s * entry(a, b)))
}

impl Effect for MixedElastic {
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
        let pressures = self.pressures(at.x, b);
        let n = self.blocks.size(b);
        let first = n - 4;
        for q in 0..self.points.points() {
            let f = self.points.deformation_gradient(at.x, b, q);
            let undefined = |e| EvalError::of_law(&self.name, self.points.cells[b] as usize, e);
            let response = self.rest.eval(&f, want).map_err(undefined)?;
            let x = det_minus_one(&(f - Mat3::identity()));
            let (g, dg, d2g) = self.volumetric.gap(x).map_err(undefined)?;
            let (w, shape) = (self.points.weight(b, q), &self.shape[q]);
            let p: f64 = shape.iter().zip(&pressures).map(|(n, p)| n * p).sum();
            out.energy += w * (response.psi + p * g);
            if want < Want::Residual {
                continue;
            }
            let cof = cofactor(&f);
            let mut a = response.a;
            if want == Want::Tangent {
                add_pressure_tangent(&mut a, &f, &cof, p * dg, p * d2g);
            }
            self.points.scatter(b, q, n, &(response.p + p * dg * cof), &a, want, out);
            for (r, n) in out.r[first..].iter_mut().zip(shape) {
                *r += w * self.s * n * g;
            }
            if want == Want::Tangent {
                // ∂r_π/∂u = w s N_c G' cof F ∂N/∂X
                for (node, coupling) in self.points.contract(b, q, &cof).enumerate() {
                    for (c, shape) in shape.iter().enumerate() {
                        let row = &mut out.k[(first + c) * n + 3 * node..][..3];
                        row.iter_mut().zip(coupling).for_each(|(k, b)| *k += w * self.s * shape * dg * b);
                    }
                }
            }
        }
        for (c, compliance) in self.compliance[b].iter().enumerate() {
            let row: f64 = compliance.iter().zip(&pressures).map(|(k, p)| k * p / self.s).sum();
            out.energy -= 0.5 * row * pressures[c] / self.s;
            out.r[first + c] -= row;
            if want == Want::Tangent {
                let entries = &mut out.k[(first + c) * n + first..][..4];
                entries.iter_mut().zip(compliance).for_each(|(k, c)| *k -= c);
            }
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { batched: Some(self), ..Capabilities::default() }
    }
}

impl Batched for MixedElastic {
    fn eval(&self, at: &At, first: usize, want: Want, out: &mut Batch) -> Result<(), EvalError> {
        let mut pressures = [Lanes::ZERO; 4];
        for lane in 0..LANES {
            let of_block = self.pressures(at.x, first + lane);
            pressures.iter_mut().zip(of_block).for_each(|(to, p)| to.0[lane] = p);
        }
        let n = self.blocks.size(first);
        if want == Want::Tangent {
            out.clear_rows(n, n - 4..n);
        }
        let u = self.points.displacements::<MOST_NODES>(at.x, first);
        self.points.each_point(first, n, want, out, |q, w, out, response| {
            let f = self.points.deformation_gradients(&u, first, q);
            let undefined = |(lane, e)| EvalError::of_law(&self.name, self.points.cells[first + lane] as usize, e);
            self.rest.eval_lanes(&f, want, response).map_err(undefined)?;
            let (mut g, mut dg, mut d2g) = (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
            for lane in 0..LANES {
                let f = Mat3::from_fn(|i, j| f[3 * i + j].0[lane]);
                let gap = self.volumetric.gap(det_minus_one(&(f - Mat3::identity())));
                (g.0[lane], dg.0[lane], d2g.0[lane]) = gap.map_err(|e| undefined((lane, e)))?;
            }
            let shape = &self.shape[q];
            let p = shape.iter().zip(&pressures).fold(Lanes::ZERO, |sum, (n, p)| sum + Lanes::of(*n) * *p);
            out.energy += w * (response.psi + p * g);
            if want > Want::Energy {
                let gradients = self.points.gradients_of_batch(first, q);
                widest(AddPressure { f: &f, p, dg, d2g, want, response });
                widest(Coupling { gradients, f: &f, ws: w * Lanes::of(self.s), g, dg, shape, n, want, out });
            }
            Ok(())
        })?;
        for lane in 0..LANES {
            for (c, compliance) in self.compliance[first + lane].iter().enumerate() {
                let row: f64 = compliance.iter().zip(&pressures).map(|(k, p)| k * p.0[lane] / self.s).sum();
                out.energy.0[lane] -= 0.5 * row * pressures[c].0[lane] / self.s;
                out.r[n - 4 + c].0[lane] -= row;
                if want == Want::Tangent {
                    let entries = &mut out.k[(n - 4 + c) * n + n - 4..][..4];
                    entries.iter_mut().zip(compliance).for_each(|(k, c)| k.0[lane] -= c);
                }
            }
        }
        Ok(())
    }
}

/// Kernel that computes P += p G' cof F and A += p G' ∂cof F/∂F + p G'' cof F ⊗ cof F.
pub struct AddPressure<'a> {
    pub f: &'a [Lanes; 9],
    pub p: Lanes,
    pub dg: Lanes,
    pub d2g: Lanes,
    pub want: Want,
    pub response: &'a mut LaneResponse,
}

impl Kernel for AddPressure<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { f, p, dg, d2g, want, response } = self;
        let cof = cofactor_by_rows(f);
        for (to, cof) in response.p.iter_mut().zip(cof) {
            *to += p * dg * cof;
        }
        if want == Want::Tangent {
            add_pressure_tangent_by_rows(&mut response.a, f, &cof, p * dg, p * d2g);
        }
    }
}

/// Kernel that computes r_π += w s N_c G and ∂r_π/∂u += w s N_c G' cof F ∂N/∂X.
struct Coupling<'a> {
    gradients: &'a [[Lanes; 3]],
    f: &'a [Lanes; 9],
    ws: Lanes,
    g: Lanes,
    dg: Lanes,
    shape: &'a [f64; 4],
    n: usize,
    want: Want,
    out: &'a mut Batch,
}

impl Kernel for Coupling<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { gradients, f, ws, g, dg, shape, n, want, out } = self;
        for (r, shape) in out.r[n - 4..n].iter_mut().zip(shape) {
            *r += ws * Lanes::of(*shape) * g;
        }
        if want < Want::Tangent {
            return;
        }
        let cof = cofactor_by_rows(f);
        for (node, gradient) in gradients.iter().enumerate() {
            for i in 0..3 {
                let [a, b, c] = [cof[3 * i] * gradient[0], cof[3 * i + 1] * gradient[1], cof[3 * i + 2] * gradient[2]];
                let row = ws * dg * (a + b + c);
                for (c, shape) in shape.iter().enumerate() {
                    out.k[(n - 4 + c) * n + 3 * node + i] += Lanes::of(*shape) * row;
                }
            }
        }
    }
}

impl PointStress for MixedElastic {
    fn points(&self) -> &Arc<CellPoints> {
        &self.points
    }

    fn stress(&self, x: &[f64], b: usize) -> Result<Vec<Mat3>, LawError> {
        let pressures = self.pressures(x, b);
        let at = |(q, shape): (usize, &[f64; 4])| {
            let f = self.points.deformation_gradient(x, b, q);
            let (_, dg, _) = self.volumetric.gap(det_minus_one(&(f - Mat3::identity())))?;
            let p: f64 = shape.iter().zip(&pressures).map(|(n, p)| n * p).sum();
            Ok(self.rest.eval(&f, Want::Residual)?.p + p * dg * cofactor(&f))
        };
        self.shape.iter().enumerate().map(at).collect()
    }
}

impl Stressed for MixedElastic {
    fn displacement_only(&self) -> bool {
        false
    }

    fn moduli(&self) -> Moduli {
        self.hooke
    }

    fn volume_gaps(&self, x: &[f64], b: usize) -> Option<Vec<(f64, f64)>> {
        let pressures = self.pressures(x, b);
        let at = |(q, shape): (usize, &[f64; 4])| {
            let dilatation = det_minus_one(&(self.points.deformation_gradient(x, b, q) - Mat3::identity()));
            let p: f64 = shape.iter().zip(&pressures).map(|(n, p)| n * p).sum();
            let (g, ..) = self.volumetric.gap(dilatation).ok()?;
            Some((1.0 + dilatation, g - p / self.volumetric.kappa))
        };
        self.shape.iter().enumerate().map(at).collect()
    }

    fn constitution(&self) -> Option<Constitution<'_>> {
        let pressure = PressureField { scale: self.s, shape: &self.shape, compliance: &self.compliance };
        let law = self.whole.clone();
        Some(Constitution { law, points: &self.points, blocks: &self.blocks, pressure: Some(pressure) })
    }

    fn along(&self, mesh: &TetMesh, law: Box<dyn Law>) -> Box<dyn Effect> {
        let (rest, volumetric) = law.split().expect("the derivative of a law splits where the law does");
        let (kappa, mu) = (self.volumetric.kappa, self.hooke.mu);
        let (bulk, shear) = (-volumetric.kappa / (kappa * kappa), -law.small_strain().mu / (mu * mu));
        let alpha = if mesh.order == Order::Linear { STABILISATION } else { 0.0 };
        let cells = self.points.cells.iter();
        let compliance = cells.map(|&c| compliance(mesh, c as usize, bulk, alpha * shear, self.s)).collect();
        let (name, points, blocks) = (self.name.clone(), self.points.clone(), self.blocks.clone());
        Box::new(MixedAlong { name, rest, points, blocks, compliance })
    }
}

/// Adds a ∂cof F/∂F + b cof F ⊗ cof F to A.
pub(super) fn add_pressure_tangent(out: &mut Mat9, f: &Mat3, cof: &Mat3, a: f64, b: f64) {
    add_pressure_tangent_by_rows(out, &rows(f), &rows(cof), a, b);
}

/// Adds a ∂cof F/∂F + b cof F ⊗ cof F to A, with tensors given row by row; ∂cof F_iJ/∂F_kL = ε_ikm ε_JLN F_mN.
#[inline(always)]
fn add_pressure_tangent_by_rows<S: Real>(out: &mut [[S; 9]; 9], f: &[S; 9], cof: &[S; 9], a: S, b: S) {
    for (row, out) in out.iter_mut().enumerate() {
        let outer = b * cof[row];
        out.iter_mut().zip(cof).for_each(|(out, cof)| *out += outer * *cof);
        let (i, j) = (row / 3, row % 3);
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        let minus = S::of(-1.0) * a;
        out[3 * i1 + j1] += a * f[3 * i2 + j2];
        out[3 * i1 + j2] += minus * f[3 * i2 + j1];
        out[3 * i2 + j1] += minus * f[3 * i1 + j2];
        out[3 * i2 + j2] += a * f[3 * i1 + j1];
    }
}

/// Returns cof F row by row.
#[inline(always)]
pub fn cofactor_by_rows<S: Real>(f: &[S; 9]) -> [S; 9] {
    let minor = |a: usize, b: usize, c: usize, d: usize| f[a] * f[d] - f[b] * f[c];
    [
        minor(4, 5, 7, 8),
        minor(5, 3, 8, 6),
        minor(3, 4, 6, 7),
        minor(7, 8, 1, 2),
        minor(8, 6, 2, 0),
        minor(6, 7, 0, 1),
        minor(1, 2, 4, 5),
        minor(2, 0, 5, 3),
        minor(0, 1, 3, 4),
    ]
}
