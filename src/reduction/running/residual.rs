//! The error estimate of a running model: residual forces of the full model along adjoint solutions.
//!
//! A functional J of the equilibrium differs between the full model and a state with residual forces ρ by −z·ρ, up to second order in the distance,
//! with K z + H μ = ∂J/∂x, Hᵀ z − C μ = ∂J/∂λ (Becker & Rannacher, *Acta Numerica* 10, 2001, section 2; the constraints hold exactly). The full ρ is
//! summed over a separate set of points, and z is a combination of a few fields whose coefficients are polynomials of the inputs.

use super::cable::RunningCable;
use super::equations::Position;
use super::laws::RunningLaws;
use crate::material::LawSpecError;
use crate::reduction::forces::CableDrive;
use crate::reduction::model::{AdjointEstimate, ReducedModel};
use crate::reduction::points::{Points, Sizes, Sums, total};

/// The estimate with the workspace of its evaluations.
pub struct Residual {
    points: Vec<Points>,
    laws: RunningLaws,
    sums: Sums,
    /// \[tests\]
    forces: Vec<f64>,
    /// \[terms\] of the regime with the most terms
    terms: Vec<f64>,
}

impl Residual {
    pub fn new(of: &AdjointEstimate, sizes: Sizes) -> Result<Self, LawSpecError> {
        let points = of.points.iter().map(|p| Points::new(p, sizes)).collect::<Result<_, _>>()?;
        let most = of.regimes.iter().map(|r| r.exponents.len()).max().unwrap_or(0);
        let laws = RunningLaws::new(&of.compliance, of.centres.len());
        Ok(Self { points, laws, sums: Sums::new(sizes), forces: vec![0.0; sizes.tests], terms: vec![0.0; most] })
    }

    /// Computes the estimated error of each quantity at an equilibrium; false if a law is undefined, or if no training state had the same taut
    /// cables.
    pub fn estimate(
        &mut self,
        (model, of): (&ReducedModel, &AdjointEstimate),
        cables: &[RunningCable],
        (inputs, at): (&[f64], &Position),
        out: &mut [f64],
    ) -> bool {
        let Some(regime) = of.regimes.iter().find(|r| r.taut == at.taut) else { return false };
        if !self.forces_left((model, of), cables, (inputs, at)) {
            return false;
        }
        let of_inputs = &mut self.terms[..regime.exponents.len()];
        terms(&of.centres, &regime.exponents, inputs, of_inputs);
        for (out, adjoint) in out.iter_mut().zip(&regime.adjoints) {
            let coefficients = adjoint.chunks_exact(of_inputs.len());
            let product = |row: &[f64]| row.iter().zip(&*of_inputs).map(|(a, t)| a * t).sum::<f64>();
            *out = -coefficients.zip(&self.forces).map(|(row, force)| product(row) * force).sum::<f64>();
        }
        true
    }

    /// Computes the residual forces along the tests \[tests\]; `cables` must have been evaluated at this position.
    fn forces_left(
        &mut self,
        (model, of): (&ReducedModel, &AdjointEstimate),
        cables: &[RunningCable],
        (inputs, at): (&[f64], &Position),
    ) -> bool {
        let Self { points, laws, sums, forces, .. } = self;
        if !laws.bring(&model.constants, points, inputs, |part| &part.tests) {
            return false;
        }
        sums.clear(crate::material::Want::Residual);
        if points.iter().any(|points| points.add_tests(&at.y, sums).is_err()) {
            return false;
        }
        forces.iter_mut().zip(&sums.r).for_each(|(force, sum)| *force = total(sum));
        let (q, pi) = at.y.split_at(model.sizes.displacements);
        for (force, row) in forces.iter_mut().zip(laws.compliance.chunks_exact(pi.len().max(1))) {
            *force -= row.iter().zip(pi).map(|(c, p)| c * p).sum::<f64>();
        }
        for (load, of_load) in model.loads.iter().zip(&of.loads) {
            of_load.add(q, load.intensity.at(inputs), forces);
        }
        for ((cable, motions), tension) in cables.iter().zip(&of.cables).zip(&at.tensions) {
            let tension = match &cable.drive {
                CableDrive::Tension(tension) => tension.at(inputs).max(0.0),
                CableDrive::Length { .. } => *tension,
            };
            cable.add_along(motions, tension, forces);
        }
        true
    }
}

/// Computes products of powers of the inputs, each relative to its centre and in units of its half-width.
pub fn terms(centres: &[[f64; 2]], exponents: &[Vec<u32>], inputs: &[f64], out: &mut [f64]) {
    for (out, powers) in out.iter_mut().zip(exponents) {
        let factor = |((u, [centre, half]), power): ((&f64, &[f64; 2]), &u32)| {
            ((u - centre) / half).powi(i32::try_from(*power).unwrap_or(i32::MAX))
        };
        *out = inputs.iter().zip(centres).zip(powers).map(factor).product();
    }
}
