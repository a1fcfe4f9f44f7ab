//! Range of material stability of a fitted law, mode by mode: [`material_stability()`] of the law of scenes.
//!
//! The law is made nearly incompressible, with κ = 1e5 times the neo-Hookean modulus of the data, which shifts the loss of stability by about 1e-5.
//! The examined range: tension up to L = 1.5 times the largest stretch of the table and at least 3, compression until a principal stretch reaches L
//! or 1/L, simple shear with principal stretches L and 1/L.

use crate::calibrate::{FittableLaw, Mode, Sample};
use crate::material::{Law, LoadCase, StabilityLimit, material_stability};
use serde::{Deserialize, Serialize};

/// Range of one mode of deformation in which the law is stable (Drucker).
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct StableRange {
    pub mode: Mode,
    /// Examined range: λ \[–\], in simple shear γ \[–\]
    pub looked: [f64; 2],
    /// First amount below rest at which stability is lost; `None` if it is kept throughout the range
    pub below: Option<f64>,
    /// First amount above rest at which stability is lost; `None` if it is kept throughout the range
    pub above: Option<f64>,
}

impl StableRange {
    /// Whether the law is stable in all of this range.
    pub fn covers(&self, [low, high]: [f64; 2]) -> bool {
        self.below.is_none_or(|b| b < low) && self.above.is_none_or(|a| a > high)
    }
}

/// The load cases, each with its mode.
pub const CASES: [(LoadCase, Mode); 4] = [
    (LoadCase::Uniaxial, Mode::Uniaxial),
    (LoadCase::Equibiaxial, Mode::Equibiaxial),
    (LoadCase::Planar, Mode::Planar),
    (LoadCase::SimpleShear, Mode::SimpleShear),
];

/// Amounts of a load case at which the principal stretches stay below L in tension, and between 1/L and L in compression.
pub fn range(case: LoadCase, l: f64) -> [f64; 2] {
    match case {
        LoadCase::Uniaxial | LoadCase::Planar => [1.0 / l, l],
        LoadCase::Equibiaxial => [l.sqrt().recip(), l],
        LoadCase::SimpleShear => [1.0 / l - l, l - 1.0 / l],
    }
}

/// The stable ranges of all load cases. `modulus`: the neo-Hookean modulus of the data \[Pa\]. Empty if the constants do not form a law (a shear
/// modulus that is not positive).
pub fn certificate(model: FittableLaw, values: &[f64], modulus: f64, largest: f64) -> Vec<StableRange> {
    model.law(values, 1e5 * modulus).map_or(vec![], |law| ranges(law.as_ref(), largest))
}

/// The stable ranges of all load cases of a given law. `largest`: largest stretch of the data.
pub fn ranges(law: &dyn Law, largest: f64) -> Vec<StableRange> {
    let top = (1.5 * largest).max(3.0);
    let one = |(case, mode): (LoadCase, Mode)| {
        let looked = range(case, top);
        let found = material_stability(law, case, looked).ok()?;
        let amount = |limit: Option<StabilityLimit>| limit.map(|l| l.amount);
        Some(StableRange { mode, looked, below: amount(found.below), above: amount(found.above) })
    };
    CASES.into_iter().filter_map(one).collect()
}

/// The reach of data points: their largest principal stretch, and their λ in each mode.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Reach {
    /// Largest principal stretch \[–\]; in compression the stretch across the load
    pub principal: f64,
    /// Smallest and largest λ of each mode \[–\], 1 in modes without data
    own: [[f64; 2]; Mode::ALL.len()],
}

impl Reach {
    /// The reach of data points whose lateral stretches follow this Poisson's ratio.
    pub fn of(samples: &[Sample], nu: f64) -> Self {
        let mut found = Self { principal: 1.0, own: [[1.0; 2]; Mode::ALL.len()] };
        for s in samples {
            found.principal = s.stretches(nu).into_iter().fold(found.principal, f64::max);
            let [low, high] = &mut found.own[s.mode as usize];
            (*low, *high) = (low.min(s.stretch), high.max(s.stretch));
        }
        found
    }

    /// The largest principal stretch, or the reciprocal of the smallest λ.
    pub fn largest(&self) -> f64 {
        self.own.iter().map(|[low, _]| 1.0 / low).fold(self.principal, f64::max)
    }

    /// Amounts of a load case whose principal stretches do not exceed those of the data points, or that are amounts of data points.
    fn amounts(&self, case: LoadCase, mode: Mode) -> [f64; 2] {
        let amount = |l: f64| if mode == Mode::SimpleShear { mode.strain(l) } else { l };
        let ([low, high], [from, to]) = (range(case, self.principal), self.own[mode as usize].map(amount));
        [low.min(from), high.max(to)]
    }
}

/// Modes in which material stability ends within the principal stretches that the fitted data points reach, and the amounts at which it ends.
pub fn lost(stability: &[StableRange], reach: Reach) -> Vec<(Mode, f64)> {
    let of = |r: &StableRange| {
        let (case, mode) = CASES.into_iter().find(|(_, mode)| *mode == r.mode)?;
        let [low, high] = reach.amounts(case, mode);
        let above = r.above.filter(|a| *a <= high);
        above.or(r.below.filter(|b| *b >= low)).map(|at| (r.mode, at))
    };
    stability.iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compression to λ = 0.4 stretches by 0.4^-½ across the load. Checked independently: σ = 2W′(λ² − 1/λ) with W′ = C10 + 2C20(I₁ − 3) has its
    /// extremum at 0.4395 in compression and 2.015 in tension for C10 = 20 kPa and C20 = −2 kPa, and at 0.295 and 2.56 for C20 = −1 kPa.
    #[test]
    fn compression_reaches_its_own_stretches() {
        let row =
            |stretch: f64| Sample { mode: Mode::Uniaxial, stretch, second: 1.0, stress: -1.0, line: 2, specimen: 0 };
        let pressed = Reach::of(&[0.9, 0.6, 0.4].map(row), 0.5);
        assert!((pressed.principal - 0.4_f64.powf(-0.5)).abs() < 1e-12 && pressed.largest() == 2.5, "{pressed:?}");
        let yeoh = FittableLaw::new("yeoh", Some(2)).expect("registered");
        let of = |c20: f64, reach: Reach| lost(&certificate(yeoh, &[20e3, c20], 40e3, reach.largest()), reach);
        assert!(of(-1e3, pressed).is_empty());
        let early = of(-2e3, pressed);
        let at = early.iter().find(|(mode, _)| *mode == Mode::Uniaxial).map(|(_, at)| *at);
        assert!(at.is_some_and(|at| (at - 0.4395).abs() < 1e-3), "{early:?}");
        let pulled = Reach::of(&[1.2, 2.5].map(row), 0.5);
        assert!((pulled.principal, pulled.largest()) == (2.5, 2.5) && !of(-1e3, pulled).is_empty());
    }
}
