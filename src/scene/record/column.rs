//! The unit at the end of the name of a recorded column or a signal: `tip_x_m`, `grip_moment_z_Nm`.

use crate::math::units::{Dimension, UnitError};
use crate::scene::text::quantity::Quantity;

/// The suffix of a name, its unit as printed, and the dimension of its numbers.
struct ColumnUnit {
    suffix: &'static str,
    printed: &'static str,
    dimension: Dimension,
}

const fn unit_of(suffix: &'static str, printed: &'static str, dimension: Dimension) -> ColumnUnit {
    ColumnUnit { suffix, printed, dimension }
}

/// The units by suffix. The first match counts: a longer suffix precedes the suffix that it ends in.
const UNITS: [ColumnUnit; 16] = [
    unit_of("_per_m", "1/m", Dimension::CURVATURE),
    unit_of("_N_m", "N/m", Dimension::STIFFNESS),
    unit_of("_m_s", "m/s", Dimension::VELOCITY),
    unit_of("_m_s2", "m/s2", Dimension::ACCELERATION),
    unit_of("_rad_s", "rad/s", Dimension::ANGULAR_VELOCITY),
    unit_of("_Hz", "Hz", Dimension::FREQUENCY),
    unit_of("_s", "s", Dimension::TIME),
    unit_of("_m", "m", Dimension::LENGTH),
    unit_of("_m2", "m2", Dimension::AREA),
    unit_of("_m3", "m3", Dimension::VOLUME),
    unit_of("_N", "N", Dimension::FORCE),
    unit_of("_Nm", "N m", Dimension::ENERGY),
    unit_of("_Pa", "Pa", Dimension::PRESSURE),
    unit_of("_J", "J", Dimension::ENERGY),
    unit_of("_deg", "deg", Dimension::ANGLE),
    unit_of("_rad", "rad", Dimension::ANGLE),
];

fn find(column: &str) -> Option<&'static ColumnUnit> {
    UNITS.iter().find(|unit| column.ends_with(unit.suffix))
}

/// The unit of a column; `1` for a number without a unit.
pub fn unit_of_column(column: &str) -> &'static str {
    find(column).map_or("1", |unit| unit.printed)
}

/// The dimension of a column, and the size of its unit in SI.
pub fn dimension(column: &str) -> (Dimension, f64) {
    let Some(ColumnUnit { printed, dimension, .. }) = find(column) else { return (Dimension::NONE, 1.0) };
    (*dimension, if *printed == "deg" { 1.0_f64.to_radians() } else { 1.0 })
}

/// Whether a column is an angle.
pub fn is_angle(column: &str) -> bool {
    dimension(column).0 == Dimension::ANGLE
}

/// Whether a column is a result, unlike the time and the iterations of the solver.
pub fn is_result(column: &str) -> bool {
    !["t_s", "newton_iterations"].contains(&column)
}

/// Whether two columns are results in the same unit, so that the magnitude of one is a scale for the other.
pub fn comparable(a: &str, b: &str) -> bool {
    is_result(a) && is_result(b) && unit_of_column(a) == unit_of_column(b)
}

/// Largest magnitude over the rows of all columns that are comparable with this one; missing values do not count.
pub fn largest_of_unit(columns: &[String], rows: &[impl AsRef<[f64]>], column: &str) -> f64 {
    let alike = (0..columns.len()).filter(|&c| comparable(&columns[c], column));
    alike.flat_map(|c| rows.iter().map(move |row| row.as_ref()[c].abs())).fold(0.0, f64::max)
}

/// A readable name of a column or field, and its unit; the unit is empty if the name has none.
pub fn words(column: &str) -> (String, &'static str) {
    let Some(ColumnUnit { suffix, printed, .. }) = find(column) else { return (column.replace('_', " "), "") };
    let printed = match *printed {
        "deg" => "°",
        "m2" => "m²",
        "m3" => "m³",
        "m/s2" => "m/s²",
        unit => unit,
    };
    (column[..column.len() - suffix.len()].replace('_', " "), printed)
}

/// A readable name of a column with its unit in brackets.
pub fn label(column: &str) -> String {
    let (words, unit) = words(column);
    if unit.is_empty() { words } else { format!("{words} [{unit}]") }
}

/// The value of a quantity in the unit of a column.
pub(crate) fn in_unit_of(column: &str, quantity: &Quantity) -> Result<f64, UnitError> {
    let (dimension, si) = dimension(column);
    Ok(quantity.value(dimension)? / si)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_end_in_their_unit() {
        for (column, printed, shown) in [
            ("t_s", "s", "t [s]"),
            ("tip_x_m", "m", "tip x [m]"),
            ("line_1_curvature_per_m", "1/m", "line 1 curvature [1/m]"),
            ("grip_moment_z_Nm", "N m", "grip moment z [N m]"),
            ("velocity_m_s", "m/s", "velocity [m/s]"),
            ("body_acceleration_m_s2", "m/s2", "body acceleration [m/s²]"),
            ("horn_speed_rad_s", "rad/s", "horn speed [rad/s]"),
            ("joint_stiffness_N_m", "N/m", "joint stiffness [N/m]"),
            ("sole_area_m2", "m2", "sole area [m²]"),
            ("air_volume_m3", "m3", "air volume [m³]"),
            ("bending_angle_deg", "deg", "bending angle [°]"),
            ("horn_rotation_rad", "rad", "horn rotation [rad]"),
            ("stretch_p95", "1", "stretch p95"),
        ] {
            assert_eq!((unit_of_column(column), label(column).as_str()), (printed, shown));
        }
    }

    /// A curvature of 20 1/m is no scale for positions, a torque none for forces, and ten iterations none for stretches.
    #[test]
    fn sizes_are_those_of_columns_in_the_same_unit() {
        let columns =
            ["t_s", "tip_x_m", "tip_y_m", "line_1_curvature_per_m", "tip_reaction_x_N", "moment_z_Nm", "stretch_p95"];
        let columns: Vec<String> = columns.into_iter().chain(["newton_iterations"]).map(String::from).collect();
        let rows =
            [vec![0.0, 0.01, -0.03, 15.0, 0.5, 7.0, 1.0, 4.0], vec![1.0, 0.02, -0.04, -20.0, 0.25, 9.0, 1.5, 10.0]];
        let sizes: Vec<f64> = columns.iter().map(|column| largest_of_unit(&columns, &rows, column)).collect();
        assert_eq!(sizes, [0.0, 0.04, 0.04, 20.0, 0.5, 9.0, 1.5, 0.0]);
    }

    #[test]
    fn a_threshold_has_the_unit_of_its_column() {
        for (column, text, value) in [
            ("bending_angle_deg", "30 deg", 30.0),
            ("cable_tension_N", "200 mN", 0.2),
            ("tip_x_m", "12 mm", 0.012),
            ("air_volume_m3", "3 ml", 3e-6),
            ("elastic_J", "2 mN m", 2e-3),
            ("grip_moment_z_Nm", "5 mN m", 5e-3),
            ("line_1_curvature_per_m", "0.02 1/mm", 20.0),
            ("sole_area_m2", "3 mm^2", 3e-6),
            ("horn_rotation_rad", "180 deg", std::f64::consts::PI),
            ("stretch_p95", "1.4", 1.4),
        ] {
            let read = in_unit_of(column, &text.into()).unwrap_or_else(|e| panic!("{e}"));
            assert!((read - value).abs() <= 4.0 * f64::EPSILON * value, "{column}: {read}");
        }
        for (column, text) in [
            ("bending_angle_deg", "30"),
            ("cable_tension_N", "3 mm"),
            ("grip_moment_z_Nm", "0.005"),
            ("grip_moment_z_Nm", "5 mN"),
            ("line_1_curvature_per_m", "20 mm"),
            ("line_1_curvature_per_m", "20"),
        ] {
            assert!(in_unit_of(column, &text.into()).is_err(), "{column}: {text}");
        }
    }
}
