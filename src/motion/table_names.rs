//! Names of the columns of a table of marker positions.

use crate::calibrate::intake::names;
use crate::math::units::Dimension;

/// Meaning of a column.
#[derive(Clone, PartialEq, Debug)]
pub enum Cell {
    Time,
    /// Number of the frame
    Frame,
    /// Number of samples averaged in the row
    Samples,
    /// Name of the marker of the row
    Marker,
    /// Name of the record of the row
    Record,
    /// Coordinate 0, 1 or 2; the marker is empty if the row names it
    Coordinate {
        marker: String,
        axis: usize,
    },
    Other,
}

/// Returns the meaning of a name such as `t_s`, `Time (s)`, `tip_x_mm`, `tip X [mm]`, `tip:X`.
pub fn meaning(name: &str) -> Cell {
    let (bare, _) = without_unit(name);
    let lower = bare.to_lowercase();
    match lower.as_str() {
        "t" | "time" | "timestamp" | "zeit" | "temps" => return Cell::Time,
        "frame" | "frame#" | "frame number" | "frame_number" => return Cell::Frame,
        "n_avg" | "n_samples" | "samples" => return Cell::Samples,
        "marker" | "label" | "point" => return Cell::Marker,
        "record" | "experiment" | "trial" | "run" => return Cell::Record,
        _ => {}
    }
    let axis = |c: char| "xyz".find(c.to_ascii_lowercase());
    let mut rest = bare.chars();
    let Some(axis) = rest.next_back().and_then(axis) else { return Cell::Other };
    let rest = rest.as_str();
    let marker = rest.trim_end_matches(['_', '.', ':', '-', ' ']);
    // A letter that belongs to the word does not name an axis: "matrix"
    if rest.is_empty() || marker.len() < rest.len() {
        return Cell::Coordinate { marker: marker.to_string(), axis };
    }
    Cell::Other
}

/// Returns the unit that a name states.
pub fn unit(name: &str) -> Option<String> {
    without_unit(name).1
}

/// Splits a name into the name without its unit, and the unit: in brackets, or as a last word, as in `tip_x_mm`.
fn without_unit(name: &str) -> (&str, Option<String>) {
    let name = name.trim();
    let in_brackets = |open: char, close: char| {
        let (before, unit) = name.strip_suffix(close)?.rsplit_once(open)?;
        Some((before.trim(), Some(unit.trim().to_string()).filter(|u| !u.is_empty())))
    };
    let is_unit = |word: &str| [Dimension::LENGTH, Dimension::TIME].iter().any(|d| names::factor(word, *d).is_some());
    let last = || {
        let (before, word) = name.rsplit_once(['_', ' '])?;
        is_unit(word).then(|| (before.trim(), Some(word.to_string())))
    };
    in_brackets('(', ')').or_else(|| in_brackets('[', ']')).or_else(last).unwrap_or((name, None))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_columns_are_understood() {
        let at = |marker: &str, axis| Cell::Coordinate { marker: marker.into(), axis };
        for (name, cell, of) in [
            ("t_s", Cell::Time, Some("s")),
            ("Time (ms)", Cell::Time, Some("ms")),
            ("time", Cell::Time, None),
            ("n_avg", Cell::Samples, None),
            ("Frame#", Cell::Frame, None),
            ("frame_x_mm", at("frame", 0), Some("mm")),
            ("tip1_x_m", at("tip1", 0), Some("m")),
            ("tip 1 Y [mm]", at("tip 1", 1), Some("mm")),
            ("tip:Z", at("tip", 2), None),
            ("x_mm", at("", 0), Some("mm")),
            ("m_z", at("m", 2), None),
            ("matrix", Cell::Other, None),
            ("held_sd_mm", Cell::Other, Some("mm")),
            ("experiment", Cell::Record, None),
        ] {
            assert_eq!(meaning(name), cell, "{name}");
            assert_eq!(unit(name).as_deref(), of, "{name}");
        }
    }
}
