//! Units with the prefix that leaves short numbers, as an axis or a map shows them; tables keep SI units.

/// A unit, the units that replace it with their power of ten, and the least magnitude for each, largest first.
type Replaced = (&'static str, &'static [(f64, i32, &'static str)]);

const UNITS: [Replaced; 4] = [
    ("m", &[(0.5, 0, "m"), (1e-3, 3, "mm"), (1e-9, 6, "µm")]),
    ("m³", &[(0.1, 0, "m³"), (1e-7, 6, "cm³"), (1e-12, 9, "mm³")]),
    ("Pa", &[(1e6, -6, "MPa"), (1e3, -3, "kPa"), (0.0, 0, "Pa")]),
    ("deg", &[(0.0, 0, "°")]),
];

/// The power of ten by which numbers in `unit` are to be multiplied, and the unit that they have then, for numbers up to `largest`.
pub fn shown(unit: &str, largest: f64) -> (i32, &str) {
    let spelled = if unit == "m3" { "m³" } else { unit };
    let known = UNITS.iter().find(|(own, _)| *own == spelled);
    let best = known.and_then(|(_, all)| all.iter().find(|(least, ..)| largest >= *least));
    best.map_or((0, unit), |(_, power, name)| (*power, name))
}

/// `shift x [m]` becomes `shift x [mm]` with the power 3; a label without a known unit in its brackets stays.
pub fn readable(label: &str, largest: f64) -> (i32, String) {
    let parts = label.strip_suffix(']').and_then(|l| l.rsplit_once('['));
    let Some((words, own)) = parts else { return (0, label.into()) };
    let (power, unit) = shown(own, largest);
    (power, format!("{words}[{unit}]"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_an_axis_are_short() {
        for (label, largest, power, shown) in [
            ("shift x [m]", 0.015, 3, "shift x [mm]"),
            ("shift x [m]", 2e-5, 6, "shift x [µm]"),
            ("shift x [m]", 1.2, 0, "shift x [m]"),
            ("shift x [m]", 0.0, 0, "shift x [m]"),
            ("V [m³]", 1.2e-5, 6, "V [cm³]"),
            ("V [m3]", 2e-9, 9, "V [mm³]"),
            ("p [Pa]", 3.5e4, -3, "p [kPa]"),
            ("β [deg]", 90.0, 0, "β [°]"),
            ("x [mm]", 0.02, 0, "x [mm]"),
            ("cells", 0.02, 0, "cells"),
        ] {
            assert_eq!(readable(label, largest), (power, shown.into()));
        }
    }
}
