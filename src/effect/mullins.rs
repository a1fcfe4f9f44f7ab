//! Stress softening of a law with an isochoric part W by the largest W that a point has experienced: the part of the elastic stress that is lost.
//!
//! Acts in addition to the elastic effect of the same law; with η, W_m and the constants of [`Softening`]:
//!
//! P = (η(W, W_m) − 1) ∂W/∂F, A = (η − 1) ∂²W/∂F² + ∂η/∂W ∂W/∂F ⊗ ∂W/∂F, W_m = max(W_mₙ, W)
//!
//! W_mₙ is the largest W at the end of the previous steps and is updated once a step is accepted. While W > W_mₙ the effect is zero. For smaller W, P
//! is the gradient of a function of W, so that A is symmetric; at W = W_mₙ A is discontinuous. Differences with respect to the quantities on which W
//! depends are taken on one side of that kink, the side of the state: above it with W_mₙ = 0, below it with a mark on W_mₙ, which continues η beyond
//! the kink.
//!
//! Energy: −∫₀^W (1 − η) dW is stored in addition to W. ∫₀^{W_m} (1 − η) dW, which never decreases, is dissipated as W_m grows.
//!
//! Source: Ogden & Roxburgh, Proc. R. Soc. Lond. A 455, 1999. Limits: isotropic, no permanent set, no recovery; U(J) does not soften.

use super::cell::CellPoints;
use super::stress::HistoryStress;
use super::viscoelastic::NotIsochoric;
use crate::material::{Law, LawError, Response, Softening, Want};
use crate::math::tensor::{Mat3, ZERO9, rows};
use crate::mesh::TetMesh;
use crate::system::{
    At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, HistoryVariables, PastDerivative,
    Perturbation,
};
use std::sync::Arc;

/// −2⁶⁰⁰: W_m times this factor marks, without rounding, a W_m beyond which η is continued; no energy density is of that size.
const MARK: f64 = -4.149_515_568_880_993e180;

/// Returns the W_m behind a mark, `None` if it is not marked.
fn marked(peak: f64) -> Option<f64> {
    (peak < -1e100).then_some(peak / MARK)
}

/// Returns W_m after the energy W; a marked one is unchanged.
fn after(peak: f64, energy: f64) -> f64 {
    if marked(peak).is_some() { peak } else { peak.max(energy) }
}

/// Softening on the cells of a region.
pub struct Mullins {
    /// W
    part: Box<dyn Law>,
    softening: Softening,
    points: Arc<CellPoints>,
}

impl Mullins {
    pub fn new(mesh: &TetMesh, cells: &[u32], law: &dyn Law, softening: Softening) -> Result<Self, NotIsochoric> {
        let info = law.info();
        let (part, _) = law.split().filter(|_| info.isochoric).ok_or(NotIsochoric { law: info.name })?;
        Ok(Self { part, softening, points: Arc::new(CellPoints::new(mesh, cells)) })
    }

    /// Evaluates W and its derivatives at a point, with its deformation gradient.
    fn law(&self, x: &[f64], (b, q): (usize, usize), want: Want) -> Result<(Mat3, Response), EvalError> {
        let f = self.points.deformation_gradient(x, b, q);
        Ok((f, self.part.eval(&f, want).map_err(self.undefined(b))?))
    }

    fn undefined(&self, b: usize) -> impl Fn(LawError) -> EvalError + '_ {
        move |e| EvalError::of_law(self.name(), self.points.cells[b] as usize, e)
    }

    /// The W_mₙ of the points of a block.
    fn peaks<'a>(&self, history: &'a [f64], b: usize) -> &'a [f64] {
        &history[b * self.size()..][..self.size()]
    }

    /// Returns ∂/∂θ of this effect at fixed x and history, from ∂/∂θ of its law.
    pub fn along(self: &Arc<Self>, law: &dyn Law) -> Box<dyn Effect> {
        let (part, _) = law.split().expect("the derivative of a law splits where the law does");
        Box::new(MullinsAlong { of: self.clone(), part })
    }
}

impl Effect for Mullins {
    fn name(&self) -> &str {
        "mullins"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Relaxing
    }

    fn blocks(&self) -> &Blocks {
        &self.points.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        for (q, peak) in self.peaks(at.history, b).iter().copied().enumerate() {
            let (_, law) = self.law(at.x, (b, q), want)?;
            let (w, soft) = (self.points.weight(b, q), &self.softening);
            let next = after(peak, law.psi);
            out.energy -= w * soft.missing(law.psi, next);
            out.dissipated += w * (soft.lost(next) - soft.lost(peak));
            if want < Want::Residual {
                continue;
            }
            let factor = marked(peak).map_or_else(|| soft.at(law.psi, peak), |peak| soft.continued(law.psi, peak));
            let mut a = ZERO9;
            if want == Want::Tangent {
                let p = rows(&law.p);
                for (i, row) in a.iter_mut().enumerate() {
                    for (j, a) in row.iter_mut().enumerate() {
                        *a = (factor.eta - 1.0) * law.a[i][j] + factor.by_energy * p[i] * p[j];
                    }
                }
            }
            let p = (factor.eta - 1.0) * law.p;
            self.points.scatter(b, q, self.points.blocks.size(b), &p, &a, want, out);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { history: Some(self), past: Some(self), ..Capabilities::default() }
    }
}

impl HistoryStress for Mullins {
    fn points(&self) -> &Arc<CellPoints> {
        &self.points
    }

    /// Returns (η(W, W_m) − 1) ∂W/∂F at each point.
    fn stress(&self, x: &[f64], history: &[f64], b: usize) -> Result<Vec<Mat3>, LawError> {
        let at = |(q, peak): (usize, &f64)| {
            let law = self.part.eval(&self.points.deformation_gradient(x, b, q), Want::Residual)?;
            Ok((self.softening.at(law.psi, *peak).eta - 1.0) * law.p)
        };
        self.peaks(history, b).iter().enumerate().map(at).collect()
    }
}

impl HistoryVariables for Mullins {
    /// Size of the history of a block: W_m \[J/m³\] at each point.
    fn size(&self) -> usize {
        self.points.points()
    }

    fn advance(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        for (q, peak) in new.iter_mut().enumerate() {
            *peak = after(*peak, self.law(at.x, (b, q), Want::Energy)?.1.psi);
        }
        Ok(())
    }

    /// The energy of the first state is the largest so far; any loss before it is not dissipated in the run.
    fn begin(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        self.advance(at, b, new)
    }

    fn take_side(&self, at: &At, b: usize, history: &mut [f64]) -> Result<(), EvalError> {
        for (q, peak) in history.iter_mut().enumerate() {
            *peak = if self.law(at.x, (b, q), Want::Energy)?.1.psi >= *peak { 0.0 } else { MARK * *peak };
        }
        Ok(())
    }
}

impl PastDerivative for Mullins {
    /// Adds ∂η/∂W_m ∂W/∂F times the change of W_m.
    fn along(&self, at: &At, direction: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        let changes = self.peaks(direction.history, b);
        for (q, (peak, change)) in self.peaks(at.history, b).iter().zip(changes).enumerate() {
            let (_, law) = self.law(at.x, (b, q), Want::Residual)?;
            let p = self.softening.at(law.psi, *peak).by_peak * change * law.p;
            self.points.scatter(b, q, self.points.blocks.size(b), &p, &ZERO9, Want::Residual, out);
        }
        Ok(())
    }

    /// The change of W_m is ∂W/∂F:dF where W is currently the largest.
    fn advance_along(&self, at: &At, direction: &Perturbation, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        for (q, (peak, change)) in self.peaks(at.history, b).iter().zip(new).enumerate() {
            let (_, law) = self.law(at.x, (b, q), Want::Residual)?;
            if law.psi > *peak {
                let df = self.points.deformation_gradient(direction.x, b, q) - Mat3::identity();
                *change = law.p.dot(&df);
            }
        }
        Ok(())
    }
}

/// The derivative ∂/∂θ of [`Mullins`] with respect to a constant of its law: ∂r/∂θ = (η − 1) ∂²W/∂F∂θ + ∂η/∂W ∂W/∂θ ∂W/∂F, ∂W_m/∂θ = ∂W/∂θ where W is
/// currently the largest.
struct MullinsAlong {
    of: Arc<Mullins>,
    /// ∂W/∂θ
    part: Box<dyn Law>,
}

impl MullinsAlong {
    /// Returns ∂W/∂θ and its derivative with respect to F.
    fn rate(&self, f: &Mat3, b: usize) -> Result<Response, EvalError> {
        self.part.eval(f, Want::Residual).map_err(self.of.undefined(b))
    }
}

impl Effect for MullinsAlong {
    fn name(&self) -> &str {
        self.of.name()
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Relaxing
    }

    fn blocks(&self) -> &Blocks {
        self.of.blocks()
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        for (q, peak) in self.of.peaks(at.history, b).iter().enumerate() {
            let (f, law) = self.of.law(at.x, (b, q), Want::Residual)?;
            let rate = self.rate(&f, b)?;
            let factor = self.of.softening.at(law.psi, *peak);
            let p = (factor.eta - 1.0) * rate.p + factor.by_energy * rate.psi * law.p;
            self.of.points.scatter(b, q, self.of.points.blocks.size(b), &p, &ZERO9, want, out);
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { history: Some(self), ..Capabilities::default() }
    }
}

impl HistoryVariables for MullinsAlong {
    fn size(&self) -> usize {
        self.of.size()
    }

    fn advance(&self, at: &At, b: usize, new: &mut [f64]) -> Result<(), EvalError> {
        for (q, (peak, change)) in self.of.peaks(at.history, b).iter().zip(new).enumerate() {
            let (f, law) = self.of.law(at.x, (b, q), Want::Energy)?;
            *change = if law.psi > *peak { self.rate(&f, b)?.psi } else { 0.0 };
        }
        Ok(())
    }
}
