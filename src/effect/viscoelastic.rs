//! Viscoelastic overstress of a law with an isochoric part W(C̄), C̄ = J^{−2/3} FᵀF: arms of a Prony series.
//!
//! With S̃ = J^{2/3} F⁻¹ ∂W/∂F, the law's isochoric stress without its factor J^{−2/3}, arm α has the internal variable h_α,
//!
//! ḣ_α + h_α/τ_α = dS̃/dt, S = −ρ S_iso + J^{−2/3} Σ β_α DEV\[h_α\], DEV\[h\] = h − ⅓(h:C) C⁻¹,
//!
//! with β_α and ρ from [`Prony`]. Over a step, by the exponential midpoint rule with d_α = e^{−Δt/2τ_α},
//!
//! h_α = d_α (d_α hₙ_α + S̃ − S̃ₙ).
//!
//! It is second-order accurate in Δt and exact for constant strain. As a function of x it is the gradient of
//!
//! Π = (Σ β_α d_α − ρ) W + ½ H:C̄, H = Σ β_α d_α (d_α hₙ_α − S̃ₙ),
//!
//! so that the tangent is exact and symmetric, and no part of the overstress is volumetric:
//!
//! ∂/∂F (½ H:C̄) = m(FH − ⅓q G), m = J^{−2/3}, q = H:C, G = F⁻ᵀ, and the second derivative is
//!
//! m\[δ_ik H_LJ − ⅔((FH)_iJ G_kL + G_iJ (FH)_kL) + (2/9) q G_iJ G_kL + ⅓q G_iL G_kJ\].
//!
//! Sources: Simo, CMAME 60, 1987; Simo & Hughes, *Computational Inelasticity*, 1998, ch. 10. Holzapfel, *Nonlinear Solid
//! Mechanics*, 2000, ch. 6, adds his Q_α without DEV: they become volumetric once the strain has changed.
//!
//! Limits: linear in the overstress, so that the arms relax at the same rates at every strain. Only W relaxes, never U(J). In statics Δt is infinite:
//! h = 0, the long-term response.

use super::cell::CellPoints;
use super::remembered::Remembered;
use super::stress::HistoryStress;
use crate::material::{LAWS, Law, LawError, Prony, Want};
use crate::math::tensor::{Mat3, ZERO9, cofactor};
use crate::mesh::TetMesh;
use crate::system::{
    At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, HistoryVariables, PastDerivative,
    Perturbation,
};
use std::sync::Arc;

/// Error for a law whose stress has no isochoric part to relax.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error(
    "the law {law} has no isochoric part, and to relax all of its stress would relax its bulk modulus too; take one of {}",
    isochoric().join(", ")
)]
pub struct NotIsochoric {
    pub law: &'static str,
}

fn isochoric() -> Vec<&'static str> {
    LAWS.iter().filter(|l| l.info.isochoric).map(|l| l.info.name).collect()
}

/// Components of a symmetric tensor, in this order.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];

/// A Prony series on the cells of a region.
pub struct Viscoelastic {
    /// W
    part: Box<dyn Law>,
    prony: Prony,
    points: Arc<CellPoints>,
}

/// The history of one point \[6 + 6 × arms\]: S̃ₙ, then h of each arm \[Pa\].
#[derive(Clone, Copy)]
struct Memory<'a>(&'a [f64]);

impl Memory<'_> {
    fn stress(&self) -> Mat3 {
        symmetric(&self.0[..6])
    }

    fn arms(&self) -> impl Iterator<Item = Mat3> + '_ {
        self.0[6..].chunks_exact(6).map(symmetric)
    }
}

fn symmetric(six: &[f64]) -> Mat3 {
    let [xx, yy, zz, yz, xz, xy] = std::array::from_fn(|k| six[k]);
    Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

impl Viscoelastic {
    pub fn new(mesh: &TetMesh, cells: &[u32], law: &dyn Law, prony: Prony) -> Result<Self, NotIsochoric> {
        let info = law.info();
        let (part, _) = law.split().filter(|_| info.isochoric).ok_or(NotIsochoric { law: info.name })?;
        Ok(Self { part, prony, points: Arc::new(CellPoints::new(mesh, cells)) })
    }

    /// Cells on which it acts.
    pub fn cells(&self) -> &[u32] {
        &self.points.cells
    }

    /// The Prony series, relative to the constants of the law.
    pub fn prony(&self) -> &Prony {
        &self.prony
    }

    /// Returns ρ, the share of the isochoric stress of the law that relaxes in the long term \[–\].
    pub fn relaxed_share(&self) -> f64 {
        self.prony.relaxed
    }

    fn memory<'a>(&self, history: &'a [f64], q: usize) -> Memory<'a> {
        let n = 6 * (1 + self.prony.arms.len());
        Memory(&history[q * n..(q + 1) * n])
    }

    /// (β, d) of each arm for a step of length `dt`.
    fn decays(&self, dt: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.prony.arms.iter().map(move |&(beta, tau)| (beta, (-0.5 * dt / tau).exp()))
    }

    /// Writes S̃ and h_α = d_α (d_α hₙ_α + S̃ − S̃ₙ) of a point to `new`.
    fn remember(&self, dt: f64, memory: Memory, stress: &Mat3, new: &mut [f64]) {
        let change = stress - memory.stress();
        let (first, arms) = new.split_at_mut(6);
        let store = |to: &mut [f64], t: &Mat3| {
            to.iter_mut().zip(PAIRS).for_each(|(to, (i, j))| *to = 0.5 * (t[(i, j)] + t[(j, i)]));
        };
        store(first, stress);
        for ((to, (_, d)), arm) in arms.chunks_exact_mut(6).zip(self.decays(dt)).zip(memory.arms()) {
            store(to, &(d * (d * arm + change)));
        }
    }

    /// Returns ∂/∂θ of this effect at fixed x and history, from ∂/∂θ of its law.
    pub fn along(&self, law: &dyn Law) -> Box<dyn Effect> {
        let (part, _) = law.split().expect("the derivative of a law splits where the law does");
        let (prony, points) = (self.prony.clone(), self.points.clone());
        Box::new(RelaxingAlong(Self { part, prony, points }))
    }

    fn undefined(&self, b: usize) -> impl Fn(LawError) -> EvalError + '_ {
        move |e| EvalError::of_law(self.name(), self.points.cells[b] as usize, e)
    }
}

impl Effect for Viscoelastic {
    fn name(&self) -> &str {
        "viscoelastic"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Relaxing
    }

    fn blocks(&self) -> &Blocks {
        &self.points.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let history = &at.history[b * self.size()..][..self.size()];
        for q in 0..self.points.points() {
            let memory = self.memory(history, q);
            let (mut c, mut h, mut old) = (0.0, Mat3::zeros(), Mat3::zeros());
            for ((beta, d), arm) in self.decays(at.dt).zip(memory.arms()) {
                c += beta * d;
                h += beta * d * (d * arm - memory.stress());
                old += beta * arm;
            }
            let f = self.points.deformation_gradient(at.x, b, q);
            // The dissipation needs the stress, whatever is requested.
            let law = self.part.eval(&f, want.max(Want::Residual)).map_err(self.undefined(b))?;
            let remembered = Remembered::new(&f, &h);
            let before = self.points.deformation_gradient(at.old, b, q);
            let mean = 0.5 * (c * law.p + remembered.p() + Remembered::new(&before, &old).p());
            let w = self.points.weight(b, q);
            // At a start: the energy held by the arms, see `begin`
            out.dissipated += w * if at.is_start() { c * law.psi } else { mean.dot(&(f - before)) };
            out.energy -= w * self.prony.relaxed * law.psi;
            if want < Want::Residual {
                continue;
            }
            c -= self.prony.relaxed;
            let mut a = ZERO9;
            if want == Want::Tangent {
                a = remembered.a();
                for (a, law) in a.as_flattened_mut().iter_mut().zip(law.a.as_flattened()) {
                    *a += c * law;
                }
            }
            let p = c * law.p + remembered.p();
            self.points.scatter(b, q, self.points.blocks.size(b), &p, &a, want, out);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { history: Some(self), past: Some(self), ..Capabilities::default() }
    }
}

impl HistoryStress for Viscoelastic {
    fn points(&self) -> &Arc<CellPoints> {
        &self.points
    }

    /// The stress after a step of zero length from the state: (Σ β_α − ρ) ∂W/∂F and the gradient of ½ Σ β_α (h_α − S̃):C̄.
    fn stress(&self, x: &[f64], history: &[f64], b: usize) -> Result<Vec<Mat3>, LawError> {
        let history = &history[b * self.size()..][..self.size()];
        let at = |q| {
            let memory = self.memory(history, q);
            let (mut c, mut h) = (-self.prony.relaxed, Mat3::zeros());
            for ((beta, _), arm) in self.decays(0.0).zip(memory.arms()) {
                c += beta;
                h += beta * (arm - memory.stress());
            }
            let f = self.points.deformation_gradient(x, b, q);
            Ok(c * self.part.eval(&f, Want::Residual)?.p + Remembered::new(&f, &h).p())
        };
        (0..self.points.points()).map(at).collect()
    }
}

impl HistoryVariables for Viscoelastic {
    fn size(&self) -> usize {
        6 * (1 + self.prony.arms.len()) * self.points.points()
    }

    fn advance(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        let history = &at.history[b * self.size()..][..self.size()];
        let n = new.len() / self.points.points();
        for (q, new) in new.chunks_exact_mut(n).enumerate() {
            let f = self.points.deformation_gradient(at.x, b, q);
            let p = self.part.eval(&f, Want::Residual).map_err(self.undefined(b))?.p;
            self.remember(at.dt, self.memory(history, q), &unscaled(&f, &p), new);
        }
        Ok(())
    }

    /// Sets h_α = S̃: the strain of the first state was applied instantaneously, in a step of zero length from rest. The arms store the work, Σ β_α
    /// W.
    fn begin(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        let none = vec![0.0; at.history.len()];
        self.advance(&At { dt: 0.0, history: &none, ..*at }, b, new)
    }
}

impl PastDerivative for Viscoelastic {
    /// r is linear in the history.
    fn along(&self, at: &At, direction: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        let history = &direction.history[b * self.size()..][..self.size()];
        for q in 0..self.points.points() {
            let memory = self.memory(history, q);
            let mut h = Mat3::zeros();
            for ((beta, d), arm) in self.decays(at.dt).zip(memory.arms()) {
                h += beta * d * (d * arm - memory.stress());
            }
            let f = self.points.deformation_gradient(at.x, b, q);
            let p = Remembered::new(&f, &h).p();
            self.points.scatter(b, q, self.points.blocks.size(b), &p, &ZERO9, Want::Residual, out);
        }
        Ok(())
    }

    /// dS̃ = ⅔(G:dF) S̃ − F⁻¹dF S̃ + J^{2/3} F⁻¹ dP, dP = ∂²W/∂F² dF.
    fn advance_along(&self, at: &At, direction: &Perturbation, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        let history = &direction.history[b * self.size()..][..self.size()];
        let n = new.len() / self.points.points();
        for (q, new) in new.chunks_exact_mut(n).enumerate() {
            let f = self.points.deformation_gradient(at.x, b, q);
            let df = self.points.deformation_gradient(direction.x, b, q) - Mat3::identity();
            let law = self.part.eval(&f, Want::Tangent).map_err(self.undefined(b))?;
            let dp = Mat3::from_fn(|i, j| {
                let row = law.a[3 * i + j].iter().enumerate();
                row.map(|(n, a)| a * df[(n / 3, n % 3)]).sum()
            });
            let (g, stress) = (cofactor(&f) / f.determinant(), unscaled(&f, &law.p));
            let change = 2.0 / 3.0 * g.dot(&df) * stress - g.tr_mul(&df) * stress + unscaled(&f, &dp);
            self.remember(at.dt, self.memory(history, q), &change, new);
        }
        Ok(())
    }
}

/// The derivative ∂/∂θ of a [`Viscoelastic`] with respect to a constant of its law: ∂r/∂θ = (Σ β_α d_α − ρ) ∂²W/∂F∂θ, ∂h_α/∂θ = d_α ∂S̃/∂θ.
struct RelaxingAlong(Viscoelastic);

impl Effect for RelaxingAlong {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Relaxing
    }

    fn blocks(&self) -> &Blocks {
        &self.0.points.blocks
    }

    /// Evaluates the effect of ∂W/∂θ with a zero history.
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.0.eval(&At { history: &vec![0.0; at.history.len()], ..*at }, b, want, out)
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { history: Some(self), ..Capabilities::default() }
    }
}

impl HistoryVariables for RelaxingAlong {
    fn size(&self) -> usize {
        self.0.size()
    }

    fn advance(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        self.0.advance(&At { history: &vec![0.0; at.history.len()], ..*at }, b, new)
    }
}

/// Returns J^{2/3} F⁻¹ P; requires J > 0.
fn unscaled(f: &Mat3, p: &Mat3) -> Mat3 {
    f.determinant().powf(-1.0 / 3.0) * cofactor(f).tr_mul(p)
}
