//! Difference between the law of a scene, which is compressible, and the curve that was fitted with J = 1.
//!
//! Both are evaluated in closed form up to the lateral stretch ([`LoadCase`]), at stretches spread evenly over the fitted data of each mode. Near
//! rest the stiffness in uniaxial tension changes by 2(1 + ν)/3 − 1; at large stretches, where stiffening laws turn small changes of volume into
//! large changes of stress, the difference is many times larger.

use super::certificate::CASES;
use super::misfit::Residual;
use crate::calibrate::{FittableLaw, Mode, Partner};
use crate::material::Moduli;
use crate::math::statistics::extent;
use serde::Serialize;

/// Number of stretches of each mode at which the stresses are compared.
const PLACES: usize = 25;
/// Share of the largest stress of the mode below which stresses are not compared: near rest both vanish \[–\].
const SMALL: f64 = 0.05;
/// Relative change of the stress below which nothing is reported \[–\]
pub const UNNOTICED: f64 = 0.01;
/// Poisson's ratios that are suggested \[–\]
const OFFERED: [f64; 7] = [0.49, 0.495, 0.499, 0.4995, 0.4999, 0.49995, 0.49999];

/// Change of the stress over the fitted data due to compressibility.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Change {
    /// Largest change relative to the fitted stress at its stretch \[–\]
    pub relative: f64,
    /// Mode and stretch of the largest change; simple shear keeps the volume and is left out
    pub mode: Mode,
    pub stretch: f64,
}

/// A fit with J = 1 in the form of a scene's law.
pub struct Written<'a> {
    pub model: FittableLaw,
    pub values: Vec<f64>,
    pub fitted: &'a [Residual],
    /// The volumetric part, quadratic if it is not chosen
    pub volumetric: Option<&'a str>,
}

impl Written<'_> {
    /// The largest change with this ν or κ; `None` if the law cannot be built. If no mode has a closed form, as between two unequal stretches, it is
    /// the change at rest.
    pub fn change(&self, partner: Partner) -> Option<Change> {
        let law = self.model.law_with(&self.values, partner, self.volumetric).ok()?;
        let mut largest: Option<Change> = None;
        for (case, mode) in CASES {
            let [low, high] = extent(self.fitted.iter().filter(|r| r.mode == mode).map(|r| r.stretch));
            let places = (0..PLACES).map(|k| low + (high - low) * k as f64 / (PLACES - 1) as f64);
            let stress = |s: f64| case.incompressible(law.as_ref(), s).ok().map(|stress| (s, stress));
            let stresses: Vec<(f64, f64)> = places.filter_map(stress).collect();
            let most = stresses.iter().fold(0.0, |m: f64, (_, stress)| m.max(stress.abs()));
            for (stretch, stress) in stresses.into_iter().filter(|(_, stress)| stress.abs() > SMALL * most) {
                // A law that has no equilibrium there carries no stress.
                let own = case.state(law.as_ref(), stretch).map_or(0.0, |state| state.stress);
                let relative = own / stress - 1.0;
                if largest.is_none_or(|l| relative.abs() > l.relative.abs()) {
                    largest = Some(Change { relative, mode, stretch });
                }
            }
        }
        largest.or_else(|| {
            let Moduli { e, mu, .. } = law.small_strain();
            Some(Change { relative: e / (3.0 * mu) - 1.0, mode: Mode::Uniaxial, stretch: 1.0 })
        })
    }

    /// The smallest of the suggested Poisson's ratios whose change is negligible over the fitted data.
    pub fn enough(&self) -> Option<f64> {
        let unnoticed = |nu: &f64| self.change(Partner::Nu(*nu)).is_some_and(|c| c.relative.abs() <= UNNOTICED);
        OFFERED.into_iter().find(unnoticed)
    }
}
