//! Range of material stability of a fitted law, mode by mode: [`material_stability()`] of the law of scenes.
//!
//! The law is made nearly incompressible, κ = 1e5 of the Neo-Hookean modulus of the data, which moves the loss of stability by about
//! 1e-5. The range examined: tension up to L = 1.5 times the largest stretch of the table and at least 3, compression until a principal stretch
//! reaches L or 1/L, simple shear with principal stretches L and 1/L.

use crate::calibrate::{Mode, Model};
use crate::material::{Law, LoadCase, StabilityLimit, material_stability};
use serde::{Deserialize, Serialize};

/// Range of one mode of deformation in which the law is stable (Drucker).
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct StableRange {
    pub mode: Mode,
    /// Range that was examined: λ \[–\], in simple shear γ \[–\]
    pub looked: [f64; 2],
    /// First amount below rest at which stability is lost; `None`: none in the range
    pub below: Option<f64>,
    /// First amount above rest at which stability is lost; `None`: none in the range
    pub above: Option<f64>,
}

impl StableRange {
    /// Whether the law is stable in all of this range.
    pub fn covers(&self, [low, high]: [f64; 2]) -> bool {
        self.below.is_none_or(|b| b < low) && self.above.is_none_or(|a| a > high)
    }
}

/// The modes that are load cases.
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

/// The stable ranges of all load cases. `modulus`: the Neo-Hookean modulus of the data \[Pa\]. Empty where the constants make no law (a shear modulus that is not positive).
pub fn certificate(model: Model, values: &[f64], modulus: f64, largest: f64) -> Vec<StableRange> {
    model.law(values, 1e5 * modulus).map_or(vec![], |law| ranges(law.as_ref(), largest))
}

/// The stable ranges of all load cases of a law, as it is. `largest`: stretch of the data.
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

/// Modes in which material stability ends within the principal stretches that the fitted data points reach, and where.
pub fn lost(stability: &[StableRange], stretch: [f64; 2]) -> Vec<(Mode, f64)> {
    let reach = stretch[1].max(1.0 / stretch[0]);
    let of = |r: &StableRange| {
        let (case, _) = CASES.into_iter().find(|(_, mode)| *mode == r.mode)?;
        let [low, high] = range(case, reach);
        let above = r.above.filter(|a| *a <= high);
        above.or(r.below.filter(|b| *b >= low)).map(|at| (r.mode, at))
    };
    stability.iter().filter_map(of).collect()
}
