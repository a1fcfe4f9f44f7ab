//! Units with the prefix that gives short numbers, as shown by axes and maps; tables keep SI units.

use crate::report::numbers::raised;

/// A unit with the units that replace it: smallest magnitude, power of ten and name of each, largest first.
type Replaced = (&'static str, &'static [(f64, i32, &'static str)]);

const UNITS: [Replaced; 12] = [
    ("m", &[(0.5, 0, "m"), (1e-3, 3, "mm"), (1e-6, 6, "µm"), (1e-10, 9, "nm")]),
    ("mm", &[(1e3, -3, "m"), (1e-2, 0, "mm"), (1e-4, 3, "µm"), (1e-7, 6, "nm")]),
    ("m²", &[(0.1, 0, "m²"), (1e-5, 4, "cm²"), (1e-8, 6, "mm²")]),
    ("m³", &[(0.1, 0, "m³"), (1e-7, 6, "cm³"), (1e-12, 9, "mm³")]),
    ("m/s", &[(0.1, 0, "m/s"), (1e-4, 3, "mm/s"), (1e-7, 6, "µm/s")]),
    ("Pa", &[(1e9, -9, "GPa"), (1e6, -6, "MPa"), (1e3, -3, "kPa"), (0.1, 0, "Pa"), (1e-4, 3, "mPa")]),
    ("N", &[(1e3, -3, "kN"), (0.1, 0, "N"), (1e-4, 3, "mN"), (1e-7, 6, "µN")]),
    ("N·m", &[(1e3, -3, "kN·m"), (0.1, 0, "N·m"), (1e-4, 3, "mN·m"), (1e-7, 6, "µN·m")]),
    ("J", &[(1e3, -3, "kJ"), (0.1, 0, "J"), (1e-4, 3, "mJ"), (1e-7, 6, "µJ"), (1e-10, 9, "nJ")]),
    ("s", &[(0.1, 0, "s"), (1e-4, 3, "ms"), (1e-7, 6, "µs")]),
    ("deg", &[(0.0, 0, "°")]),
    ("1", &[(0.0, 0, "–")]),
];
/// Sizes of numbers on an axis or a map from which on, and below which, their unit gets a power of ten.
const LONG: f64 = 1e5;
const SHORT: f64 = 1e-3;
/// Smallest number below 1 that four decimals can show.
const FINE: f64 = 0.999e-4;

/// Returns the power of ten by which numbers in `unit` are to be multiplied, and their unit then, for numbers up to `largest`.
pub fn shown(unit: &str, largest: f64) -> (i32, &str) {
    let spelled = match unit {
        "m3" | "m^3" => "m³",
        "m2" | "m^2" => "m²",
        "N m" => "N·m",
        own => own,
    };
    let known = UNITS.iter().find(|(own, _)| *own == spelled);
    let best = known.and_then(|(_, all)| all.iter().find(|(least, ..)| largest > 0.0 && largest >= *least));
    let renamed = || known.map_or(unit, |(own, all)| if all.len() == 1 { all[0].2 } else { own });
    best.map_or_else(|| (0, renamed()), |(_, power, name)| (*power, *name))
}

/// Returns the power of ten and the unit of [`shown`], with a power of ten before the unit if numbers that differ by `step` would still be long:
/// `10⁻⁶ N`.
pub fn with_power(unit: &str, largest: f64, step: f64) -> (i32, String) {
    let (power, name) = shown(unit, largest);
    let size = largest * 10f64.powi(power);
    if size == 0.0
        || !size.is_finite()
        || ((SHORT..LONG).contains(&size) && (size >= 1.0 || step * 10f64.powi(power) >= FINE))
    {
        return (power, name.into());
    }
    let ten = (size.log10() + 1e-9).floor() as i32;
    (power - ten, times(ten, name))
}

/// Returns the power of ten and the unit of [`with_power`] for which numbers up to `largest` have `digits` digits before the point.
pub fn with_digits(unit: &str, largest: f64, digits: i32) -> (i32, String) {
    let (power, name) = shown(unit, largest);
    let size = largest * 10f64.powi(power);
    let ten = if size > 0.0 { (size.log10() + 1e-9).floor() as i32 + 1 - digits } else { 0 };
    (power - ten, times(ten, name))
}

/// Formats a power and a unit, `10⁻⁶ N`; either of them alone if the other is missing.
fn times(ten: i32, name: &str) -> String {
    match name {
        _ if ten == 0 => name.into(),
        "" | "–" => raised(ten),
        name => format!("{} {name}", raised(ten)),
    }
}

/// Returns the words of a label and the unit in its brackets, which may be missing.
pub fn parts(label: &str) -> (&str, &str) {
    label
        .strip_suffix(']')
        .and_then(|l| l.rsplit_once('['))
        .map_or((label, ""), |(words, unit)| (words.trim_end(), unit))
}

/// Returns words followed by their unit in brackets, if they have one: `shift x [m]`.
pub fn labelled(words: &str, unit: &str) -> String {
    if unit.is_empty() { words.into() } else { format!("{words} [{unit}]") }
}

/// Returns a readable label with its power of ten: `shift x [m]` becomes `shift x [mm]` with the power 3, and `cells` becomes `cells [10⁶]` with −6.
pub fn readable(label: &str, largest: f64, step: f64) -> (i32, String) {
    let (words, own) = parts(label);
    let (power, unit) = with_power(own, largest, step);
    (power, labelled(words, &unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_an_axis_are_short() {
        let ten = |e: i32| raised(e);
        for (label, largest, power, shown) in [
            ("shift x [m]", 0.015, 3, "shift x [mm]".to_string()),
            ("shift x [m]", 2e-5, 6, "shift x [µm]".into()),
            ("shift x [m]", 8e-11, 11, format!("shift x [{} m]", ten(-11))),
            ("shift x [m]", 1.2, 0, "shift x [m]".into()),
            ("shift x [m]", 0.0, 0, "shift x [m]".into()),
            ("V [m³]", 1.2e-5, 6, "V [cm³]".into()),
            ("V [m3]", 2e-9, 9, "V [mm³]".into()),
            ("p [Pa]", 3.5e4, -3, "p [kPa]".into()),
            ("W [J]", 1.9e-5, 6, "W [µJ]".into()),
            ("F [N]", 2e-2, 3, "F [mN]".into()),
            ("β [deg]", 90.0, 0, "β [°]".into()),
            ("s [1]", 0.5, 0, "s [–]".into()),
            ("x [mm]", 0.02, 0, "x [mm]".into()),
            ("cells", 0.02, 0, "cells".into()),
            ("cells", 3e6, -6, format!("cells [{}]", ten(6))),
        ] {
            assert_eq!(readable(label, largest, largest), (power, shown));
        }
    }
}
