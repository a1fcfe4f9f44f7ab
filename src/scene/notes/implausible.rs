//! Notes on constants of an implausible order of magnitude, where the unit is the likely mistake.

use crate::material::Law;
use crate::math::units::shown;
use std::ops::RangeInclusive;

/// Plausible densities, from aerogel to the densest metals \[kg/m³\].
const DENSITIES: RangeInclusive<f64> = 1.0..=25_000.0;
/// Plausible values of Young's modulus at rest, from the softest gels to the stiffest solids \[Pa\].
const MODULI: RangeInclusive<f64> = 10.0..=1e12;

/// The note on the law of this name, by its stiffness at rest; `None` if it is plausible.
pub(in crate::scene) fn implausible_modulus(name: &str, law: &dyn Law) -> Option<String> {
    implausible(&format!("laws.{name}: E at rest"), law.small_strain().e, &MODULI, "Pa")
}

/// The note on a density \[kg/m³\] at a place of the scene; `None` if it is plausible.
pub(in crate::scene) fn implausible_density(place: &str, density: f64) -> Option<String> {
    implausible(&format!("{place}: the density"), density, &DENSITIES, "kg/m^3")
}

fn implausible(what: &str, value: f64, range: &RangeInclusive<f64>, unit: &str) -> Option<String> {
    let [low, high] = [range.start(), range.end()];
    let words = || {
        format!("{what} is {:e} {unit}, and bodies have from {low:e} to {high:e} {unit}: check the unit", shown(value))
    };
    (!range.contains(&value)).then(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_out_of_range_have_a_note() {
        let told = implausible_density("effect 2 (gravity)", 1.07e6);
        let note = "effect 2 (gravity): the density is 1.07e6 kg/m^3, and bodies have from 1e0 to 2.5e4 kg/m^3: check the unit";
        assert_eq!(told.as_deref(), Some(note));
        assert!(implausible_density("", 1.07e-3).is_some());
        for density in [1.2, 1070.0, 19_300.0] {
            assert_eq!(implausible_density("", density), None);
        }
        for (e, is_told) in [(6e-7, true), (3e3, false), (2e11, false), (6e14, true), (f64::NAN, true)] {
            assert_eq!(implausible("E", e, &MODULI, "Pa").is_some(), is_told, "{e}");
        }
    }
}
