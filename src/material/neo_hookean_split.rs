//! Neo-Hookean law split into an isochoric and a volumetric part.
//!
//! ψ = ½μ(J^{−2/3} I₁ − 3) + U(J), I₁ = F:F
//!
//! U(J) = ½κ(J − 1)² by default: the name usually means this pair.
//!
//! Source: Simo & Hughes, *Computational Inelasticity*, 1998, ch. 9 for the split; U(J) = ½κ(J − 1)² as in Bonet & Wood, 2nd ed. 2008, ch. 6.
//!
//! Limits: J > 0 only. U = ½κ(J − 1)² stays finite at J = 0: the barrier there comes from J^{−2/3} alone, and a purely volumetric collapse meets no
//! barrier. Near incompressibility (κ ≫ μ) use a mixed formulation.

use super::entry::LawEntry;
use super::isochoric::{InvariantEnergy, Partials};
use super::law::{Law, LawInfo};
use super::moduli::Moduli;
use super::parameter::Choice;
use super::response::{LaneResponse, LawError, Response, Want};
use super::volumetric::{CHOICE, Volumetric, VolumetricKind};
use super::{isochoric, moduli};
use crate::math::lanes::Lanes;
use crate::math::tensor::Mat3;

pub static INFO: LawInfo = LawInfo {
    name: "neo_hookean_split",
    title: "split Neo-Hookean",
    formula: "ψ = ½μ(J^{−2/3} I₁ − 3) + U(J)",
    source: "Simo & Hughes 1998, ch. 9; U(J) of Bonet & Wood 2008, ch. 6",
    limits: "J > 0; no barrier against uniform collapse with the quadratic U",
    parameters: moduli::PAIR,
    optional: 0,
    choices: &[Choice { default: Some("quadratic"), ..CHOICE }],
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

/// The law in the registry.
pub const ENTRY: LawEntry = LawEntry::elastic(&INFO, |v, c| {
    Ok(Box::new(NeoHookeanSplit { hooke: Moduli::from_map(v)?, volumetric: VolumetricKind::chosen(c) }))
});

/// Neo-Hookean law with an isochoric and a volumetric part.
#[derive(Clone, Copy, Debug)]
pub struct NeoHookeanSplit {
    pub hooke: Moduli,
    pub volumetric: VolumetricKind,
}

impl NeoHookeanSplit {
    fn u(&self) -> Volumetric {
        Volumetric { kind: self.volumetric, kappa: self.hooke.kappa }
    }
}

impl Law for NeoHookeanSplit {
    fn info(&self) -> &'static LawInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.hooke.e, self.hooke.nu]
    }

    fn choices(&self) -> Vec<&'static str> {
        vec![self.volumetric.name()]
    }

    fn small_strain(&self) -> Moduli {
        self.hooke
    }

    /// ψ is linear in μ and κ.
    fn along(&self, rates: &[f64]) -> Box<dyn Law> {
        Box::new(Self { hooke: self.hooke.along(rates), ..*self })
    }

    fn split(&self) -> Option<(Box<dyn Law>, Volumetric)> {
        Some((Box::new(Self { hooke: Moduli { kappa: 0.0, ..self.hooke }, ..*self }), self.u()))
    }

    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        isochoric::response(&NeoHooke { mu: self.hooke.mu }, &self.u(), f, want)
    }

    fn eval_lanes(&self, f: &[Lanes; 9], want: Want, out: &mut LaneResponse) -> Result<(), (usize, LawError)> {
        isochoric::lanes(&NeoHooke { mu: self.hooke.mu }, &self.u(), f, want, out)
    }
}

/// W = ½μ(Ī₁ − 3).
struct NeoHooke {
    mu: f64,
}

impl InvariantEnergy for NeoHooke {
    const SECOND: bool = false;

    #[inline(always)]
    fn partials(&self, i: f64, _: f64) -> Result<Partials, LawError> {
        Ok(Partials { w: 0.5 * self.mu * i, w1: 0.5 * self.mu, ..Partials::default() })
    }
}
