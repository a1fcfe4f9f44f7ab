//! Scatter of the pressures, an indicator of volumetric locking: their deviation from a smooth field.
//!
//! With τ = P Fᵀ, p = tr τ/3 and p* the lumped L2 projection of p on continuous linear functions (Oden & Brauchli 1971, the
//! recovery of Zienkiewicz & Zhu 1987), p*_a = ∫ N_a p dV / ∫ N_a dV:
//!
//! scatter = ‖p − p*‖/‖dev τ‖, share = W_p/(W_p + W_s), W_p = ∫ p²/2κ dV, W_s = ∫ |dev τ|²/4μ dV,
//!
//! with norms over the volume and Hooke's energies with the constants of the law at F = I. A locked element responds with pressures that change sign
//! from cell to cell and outweigh the deviatoric stress that carries the load.

use super::stress::Stressed;
use crate::material::Moduli;
use crate::math::tensor::Mat3;
use crate::mesh::{Order, element};

/// Scatter above which a displacement-only element is considered locked \[–\]; calibrated in `docs/explanation/elements.md`.
pub const ALARM: f64 = 0.5;

/// Poisson's ratio below which volumetric locking is excluded \[–\]: κ < 4.7 μ, and scatter is due to bending that linear cells cannot represent.
const COMPRESSIBLE: f64 = 0.4;

/// Scatter of the pressure field at a state, and whether it raises the locking alarm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressureScatter {
    /// ‖p − p*‖/‖dev τ‖ \[–\]
    pub scatter: f64,
    /// Volumetric share of the energy \[–\]
    pub share: f64,
    pub alarm: bool,
}

/// Stress relative to the moduli below which deviatoric stresses are rounding of strains \[–\], as in rigid motion.
const ROUNDING: f64 = 1e-12;
/// Deviatoric stress relative to the pressures below which it is the residue of Newton's method \[–\], as in hydrostatic compression.
const LEFT: f64 = 1e-6;

/// Computes the scatter at a state; `None` if there is no shear, or if the law is undefined.
pub fn pressure_scatter(effect: &dyn Stressed, x: &[f64]) -> Option<PressureScatter> {
    let points = effect.points();
    let shape: Vec<[f64; 10]> = points.reference().iter().map(|&xi| element::cell_shape(Order::Linear, xi)).collect();
    let corners = |b: usize| points.blocks.nodes(b)[..4].iter().map(|&k| k as usize);
    // Per node: ∫ N_a p dV, ∫ N_a dV
    let mut nodes = vec![(0.0, 0.0); x.len() / 3];
    let mut pressures = Vec::with_capacity(points.blocks.len() * shape.len());
    let (mut deviator, mut size, mut volume) = (0.0, 0.0, 0.0);
    for b in 0..points.blocks.len() {
        for (q, stress) in effect.stress(x, b).ok()?.into_iter().enumerate() {
            let tau = stress * points.deformation_gradient(x, b, q).transpose();
            let (p, w) = (tau.trace() / 3.0, points.weight(b, q));
            deviator += w * (tau - Mat3::identity() * p).norm_squared();
            size += w * p * p;
            volume += w;
            for (k, n) in corners(b).zip(shape[q]) {
                nodes[k].0 += w * n * p;
                nodes[k].1 += w * n;
            }
            pressures.push((w, p));
        }
    }
    let smooth = |b: usize, q: usize| corners(b).zip(shape[q]).map(|(k, n)| n * nodes[k].0 / nodes[k].1).sum::<f64>();
    let places = (0..points.blocks.len()).flat_map(|b| (0..shape.len()).map(move |q| (b, q)));
    let scatter: f64 = places.zip(&pressures).map(|((b, q), (w, p))| w * (p - smooth(b, q)).powi(2)).sum();
    let Moduli { mu, kappa, nu, .. } = effect.moduli();
    let (volumetric, shear) = (size / (2.0 * kappa), deviator / (4.0 * mu));
    let (scatter, share) = ((scatter / deviator).sqrt(), volumetric / (volumetric + shear));
    let alarm = effect.displacement_only() && nu >= COMPRESSIBLE && scatter > ALARM;
    let rounding = (ROUNDING * (kappa + mu)).powi(2) * volume + LEFT.powi(2) * size;
    (deviator > rounding).then_some(PressureScatter { scatter, share, alarm })
}
