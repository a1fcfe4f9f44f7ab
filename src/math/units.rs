//! Quantities with units, as written in files: `"18 kPa"`, `"7.5 mm"`, `"1.07 g/cm^3"`. Inside the code everything is in SI units.

use crate::wording;
use std::fmt;

/// Physical dimension of a quantity, as exponents of m, kg, s and rad.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Dimension {
    m: i32,
    kg: i32,
    s: i32,
    rad: i32,
}

const fn dim(m: i32, kg: i32, s: i32, rad: i32) -> Dimension {
    Dimension { m, kg, s, rad }
}

impl Dimension {
    pub const NONE: Self = dim(0, 0, 0, 0);
    pub const LENGTH: Self = dim(1, 0, 0, 0);
    pub const AREA: Self = dim(2, 0, 0, 0);
    pub const VOLUME: Self = dim(3, 0, 0, 0);
    pub const TIME: Self = dim(0, 0, 1, 0);
    pub const FREQUENCY: Self = dim(0, 0, -1, 0);
    pub const ANGLE: Self = dim(0, 0, 0, 1);
    pub const FORCE: Self = dim(1, 1, -2, 0);
    pub const ENERGY: Self = dim(2, 1, -2, 0);
    pub const PRESSURE: Self = dim(-1, 1, -2, 0);
    pub const STIFFNESS: Self = dim(0, 1, -2, 0);
    pub const COMPLIANCE: Self = dim(0, -1, 2, 0);
    pub const DAMPING: Self = dim(0, 1, -1, 0);
    pub const VISCOSITY: Self = dim(-1, 1, -1, 0);
    pub const DENSITY: Self = dim(-3, 1, 0, 0);
    pub const CURVATURE: Self = dim(-1, 0, 0, 0);
    pub const ACCELERATION: Self = dim(1, 0, -2, 0);
    pub const VELOCITY: Self = dim(1, 0, -1, 0);
    pub const ANGULAR_VELOCITY: Self = dim(0, 0, -1, 1);

    /// A familiar unit of this dimension, for messages.
    pub fn example(self) -> &'static str {
        match self {
            Self::NONE => "a plain number",
            Self::LENGTH => "mm",
            Self::AREA => "mm^2",
            Self::VOLUME => "ml",
            Self::TIME => "s",
            Self::FREQUENCY => "Hz",
            Self::ANGLE => "deg",
            Self::FORCE => "N",
            Self::ENERGY => "mN m",
            Self::PRESSURE => "kPa",
            Self::STIFFNESS => "N/m",
            Self::DAMPING => "N s/m",
            Self::VISCOSITY => "Pa s",
            Self::DENSITY => "kg/m^3",
            Self::CURVATURE => "1/m",
            Self::ACCELERATION => "m/s^2",
            Self::VELOCITY => "mm/s",
            Self::ANGULAR_VELOCITY => "rad/s",
            _ => self.si_unit(),
        }
    }

    /// The SI unit of this dimension; `1` for a plain number.
    pub fn si_unit(self) -> &'static str {
        match self {
            Self::NONE => "1",
            Self::LENGTH => "m",
            Self::AREA => "m^2",
            Self::VOLUME => "m^3",
            Self::TIME => "s",
            Self::FREQUENCY => "1/s",
            Self::ANGLE => "rad",
            Self::FORCE => "N",
            Self::ENERGY => "J",
            Self::PRESSURE => "Pa",
            Self::STIFFNESS => "N/m",
            Self::COMPLIANCE => "m/N",
            Self::DAMPING => "N s/m",
            Self::VISCOSITY => "Pa s",
            Self::DENSITY => "kg/m^3",
            Self::CURVATURE => "1/m",
            Self::ACCELERATION => "m/s^2",
            Self::VELOCITY => "m/s",
            Self::ANGULAR_VELOCITY => "rad/s",
            _ => "SI",
        }
    }

    /// The dimension of this quantity times `o` to the power n.
    pub fn times(self, o: Self, n: i32) -> Self {
        dim(self.m + n * o.m, self.kg + n * o.kg, self.s + n * o.s, self.rad + n * o.rad)
    }
}

/// Reason why a quantity could not be read.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum UnitError {
    #[error("\"{text}\" does not begin with a finite number")]
    NotANumber { text: String },
    #[error("{text} has no unit; {}", with_unit(text, *.wanted))]
    Missing { text: String, wanted: Dimension },
    #[error("\"{text}\": {}", unknown(unit))]
    Unknown { text: String, unit: String },
    #[error("\"{text}\" has the wrong dimension; a unit such as {} is needed", .wanted.example())]
    Wrong { text: String, wanted: Dimension },
    /// The value in SI overflows, or underflows to zero
    #[error("\"{text}\" is too large or too small for a number in SI units; check the exponent")]
    Range { text: String },
    #[error("a quantity of {length} characters; write a number and a unit, at most {} characters", LONGEST)]
    Long { length: usize },
}

/// The number with the SI unit of its dimension and with a familiar unit: the units that may be meant.
fn with_unit(text: &str, wanted: Dimension) -> String {
    let (si, usual) = (wanted.si_unit(), wanted.example());
    match si == usual {
        true => format!("write for example \"{text} {si}\""),
        false => format!("write the unit that is meant, \"{text} {si}\" in SI or for example \"{text} {usual}\""),
    }
}

/// Fact and remedy for an unknown unit.
fn unknown(unit: &str) -> String {
    if let Some(rest) = unit.strip_prefix(',').filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit())) {
        let digits = rest.chars().take_while(char::is_ascii_digit).count();
        return match digits {
            3 => {
                "write no comma: leave it out where it marks thousands, and write a point where it is the decimal mark"
                    .into()
            }
            _ => "write a decimal point, not a comma".into(),
        };
    }
    let known: Vec<&str> = UNITS.iter().map(|unit| unit.0).collect();
    let near = match unit.to_lowercase().as_str() {
        "inch" | "inches" | "\"" => Some("in"),
        _ => wording::nearest(unit, &known),
    };
    match near {
        Some(near) => format!("unknown unit \"{unit}\"; did you mean {near}?"),
        None => format!("unknown unit \"{unit}\"; the units are {}", wording::joined(&known)),
    }
}

/// Largest length of a quantity \[bytes\].
const LONGEST: usize = 256;

/// Known units: symbol, factor to SI, dimension.
const UNITS: &[(&str, f64, Dimension)] = &[
    ("m", 1.0, Dimension::LENGTH),
    ("cm", 1e-2, Dimension::LENGTH),
    ("mm", 1e-3, Dimension::LENGTH),
    ("um", 1e-6, Dimension::LENGTH),
    ("µm", 1e-6, Dimension::LENGTH),
    ("in", 0.0254, Dimension::LENGTH),
    ("l", 1e-3, Dimension::VOLUME),
    ("ml", 1e-6, Dimension::VOLUME),
    ("s", 1.0, Dimension::TIME),
    ("ms", 1e-3, Dimension::TIME),
    ("min", 60.0, Dimension::TIME),
    ("h", 3600.0, Dimension::TIME),
    ("Hz", 1.0, Dimension::FREQUENCY),
    ("kg", 1.0, dim(0, 1, 0, 0)),
    ("g", 1e-3, dim(0, 1, 0, 0)),
    ("N", 1.0, Dimension::FORCE),
    ("mN", 1e-3, Dimension::FORCE),
    ("cN", 1e-2, Dimension::FORCE),
    ("kN", 1e3, Dimension::FORCE),
    ("gf", 9.80665e-3, Dimension::FORCE),
    ("kgf", 9.80665, Dimension::FORCE),
    ("lbf", 4.4482216152605, Dimension::FORCE),
    ("Pa", 1.0, Dimension::PRESSURE),
    ("hPa", 1e2, Dimension::PRESSURE),
    ("kPa", 1e3, Dimension::PRESSURE),
    ("MPa", 1e6, Dimension::PRESSURE),
    ("GPa", 1e9, Dimension::PRESSURE),
    ("bar", 1e5, Dimension::PRESSURE),
    ("mbar", 1e2, Dimension::PRESSURE),
    ("psi", 6894.757293168361, Dimension::PRESSURE),
    ("ksi", 6894757.293168361, Dimension::PRESSURE),
    ("rad", 1.0, Dimension::ANGLE),
    ("deg", std::f64::consts::PI / 180.0, Dimension::ANGLE),
    ("°", std::f64::consts::PI / 180.0, Dimension::ANGLE),
    ("%", 0.01, Dimension::NONE),
];

/// Parses `"18 kPa"`, `"1.07 g/cm^3"`, `"0.1 Pa s"` into SI \[unit of `wanted`\].
///
/// ```
/// use durometer::prelude::{Dimension, units};
///
/// assert_eq!(units::parse("18 kPa", Dimension::PRESSURE), Ok(18e3));
/// let message = units::parse("18", Dimension::PRESSURE).expect_err("no unit").to_string();
/// assert_eq!(message, "18 has no unit; write the unit that is meant, \"18 Pa\" in SI or for example \"18 kPa\"");
/// ```
///
/// # Errors
///
/// The text is not a number with a unit of this dimension, or its value in SI is out of range.
pub fn parse(text: &str, wanted: Dimension) -> Result<f64, UnitError> {
    let owned = || text.trim().to_string();
    match quantity(text)? {
        (value, dimension) if dimension == wanted => Ok(value),
        (_, Dimension::NONE) if text.trim().parse::<f64>().is_ok() => Err(UnitError::Missing { text: owned(), wanted }),
        _ => Err(UnitError::Wrong { text: owned(), wanted }),
    }
}

/// Parses a quantity into its value in SI and its dimension.
///
/// # Errors
///
/// The text is not a number with a known unit, or its value in SI is out of range.
pub fn quantity(text: &str) -> Result<(f64, Dimension), UnitError> {
    let (value, unit) = split(text)?;
    let owned = || text.trim().to_string();
    let (factor, dimension) = parse_unit(unit).map_err(|unit| UnitError::Unknown { text: owned(), unit })?;
    let si = value * factor;
    if !si.is_finite() || (si == 0.0 && value != 0.0) {
        return Err(UnitError::Range { text: owned() });
    }
    Ok((si, dimension))
}

/// Splits a quantity into its number, its unit, the factor of the unit to SI, and its dimension.
///
/// # Errors
///
/// The text is not a number with a known unit.
pub fn parts(text: &str) -> Result<(f64, &str, f64, Dimension), UnitError> {
    let (number, unit) = split(text)?;
    let unknown = |unit| UnitError::Unknown { text: text.trim().into(), unit };
    let (factor, dimension) = parse_unit(unit).map_err(unknown)?;
    Ok((number, unit, factor, dimension))
}

/// A quantity as a number of `unit`: `"0.2 MPa"` in kPa is 200. An empty unit is that of plain numbers.
///
/// # Errors
///
/// `unit` is unknown, or the text is not a number with a unit of the same dimension.
pub fn in_unit(text: &str, unit: &str) -> Result<f64, UnitError> {
    let unknown = |unit| UnitError::Unknown { text: text.trim().into(), unit };
    let (factor, dimension) = parse_unit(unit).map_err(unknown)?;
    let (value, own) = split(text)?;
    // The number as written, without rounding through SI
    if own == unit { Ok(value) } else { parse(text, dimension).map(|value| value / factor) }
}

/// Converts the spellings of test machines, such as `N/mm2`, `Mpa`, `inch` and `msec`, to that of the program. Ambiguous spellings such as `mpa` are
/// unchanged.
pub fn spelled(unit: &str) -> String {
    let one = |part: &str| {
        let part = part.trim().trim_end_matches('.').replace("**", "^");
        let name = part.trim_end_matches(|c: char| c.is_ascii_digit());
        let bare = name.chars().all(char::is_alphabetic) && !name.is_empty() && name.len() < part.len();
        let (name, power) =
            if bare { (name, format!("^{}", &part[name.len()..])) } else { (part.as_str(), String::new()) };
        let known = match name {
            "Mpa" | "MPA" => "MPa",
            "kpa" | "Kpa" | "KPa" | "KPA" => "kPa",
            "Gpa" | "GPA" => "GPa",
            "pa" | "PA" => "Pa",
            "Psi" | "PSI" => "psi",
            "Ksi" | "KSI" => "ksi",
            "kn" | "Kn" | "KN" => "kN",
            "Newton" | "Newtons" | "newton" => "N",
            "kp" => "kgf",
            "LBF" | "Lbf" => "lbf",
            "MM" => "mm",
            "μm" => "um",
            "inch" | "inches" | "IN" | "In" => "in",
            "sec" | "Sec" | "secs" | "second" | "seconds" => "s",
            "msec" | "msecs" | "millisecond" | "milliseconds" => "ms",
            "minute" | "minutes" => "min",
            other => other,
        };
        format!("{known}{power}")
    };
    unit.split('/').map(one).collect::<Vec<_>>().join("/")
}

/// Whether a unit is known, also in the spelling of test machines.
pub fn is_unit(text: &str) -> bool {
    quantity(&format!("1 {}", spelled(text))).is_ok()
}

/// Quotient of two units, also in the spelling of test machines; `None` if one of them is unknown or their dimensions differ.
pub fn ratio(unit: &str, other: &str) -> Option<f64> {
    let size = |unit: &str| quantity(&format!("1 {}", spelled(unit))).ok();
    let ((a, one), (b, two)) = (size(unit)?, size(other)?);
    (one == two).then_some(a / b)
}

/// A quantity with a space between number and unit: `65mm` becomes `65 mm`; `None` if the text is not a number with a unit.
pub fn spaced(text: &str) -> Option<String> {
    let (_, unit) = split(text).ok()?;
    parse_unit(unit).ok()?;
    let number = text.trim().strip_suffix(unit)?.trim_end();
    (!unit.is_empty()).then(|| format!("{number} {unit}"))
}

/// Relative rounding error of a number that was multiplied by the powers of a unit.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Whether a number is between two others up to the rounding of their units: 0.0041 is not beyond 4.1 mm, which is 0.0040999999999999995 m.
pub fn within(value: f64, (low, high): (f64, f64)) -> bool {
    let rounding = ROUNDING * low.abs().max(high.abs());
    low - rounding <= value && value <= high + rounding
}

/// A number rounded for display, to nine significant digits: 0.93 g/cm^3 is 930 kg/m^3, although the product of the factors is 929.9999999999999.
pub fn shown(x: f64) -> f64 {
    format!("{x:.8e}").parse().unwrap_or(x)
}

/// A number that is printed with the decimals of its format, or with four significant digits if the decimals would be off by more than half a per
/// cent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decimals(pub f64);

/// Largest error of the decimals, relative to the number.
const OFF: f64 = 0.005;

impl fmt::Display for Decimals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plain = format!("{:.*}", f.precision().unwrap_or(4), self.0);
        let off = plain.parse().map_or(0.0, |printed: f64| (printed - self.0).abs());
        if off > OFF * self.0.abs() { write!(f, "{:.3e}", self.0) } else { f.write_str(&plain) }
    }
}

/// A regular expression (ECMA 262) for a number that is followed by a product of known units, or by no unit.
pub fn pattern() -> String {
    let names: Vec<&str> = UNITS.iter().map(|unit| unit.0).collect();
    let factor = format!("(?:(?:{})(?:\\^-?[0-9]+|²|³)?)", names.join("|"));
    format!(
        r"^\s*[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?\s*(?:1|(?:1?\s*/)?\s*{factor}(?:[ *·/]+{factor})*)?\s*$"
    )
}

/// Splits a text into number and unit. The number is the longest prefix that parses as one: in "5 m" it must not include the "m", and in "1e3 Pa" it
/// must include the exponent.
fn split(text: &str) -> Result<(f64, &str), UnitError> {
    let trimmed = text.trim();
    if trimmed.len() > LONGEST {
        return Err(UnitError::Long { length: trimmed.len() });
    }
    let end = (1..=trimmed.len())
        .rev()
        .find(|&n| trimmed.is_char_boundary(n) && trimmed[..n].parse::<f64>().is_ok_and(f64::is_finite))
        .ok_or_else(|| UnitError::NotANumber { text: trimmed.into() })?;
    let value = trimmed[..end].parse().expect("the prefix was just parsed");
    Ok((value, trimmed[end..].trim()))
}

/// Parses a product of powers: `g/cm^3`, `Pa s`, `Pa·s`, `m/s^2`. Factors after a slash divide.
fn parse_unit(unit: &str) -> Result<(f64, Dimension), String> {
    let (mut factor, mut dimension) = (1.0, Dimension::NONE);
    for (k, part) in unit.split('/').enumerate() {
        let sign: i32 = if k == 0 { 1 } else { -1 };
        // The numerator of 1/s, or no unit
        if k == 0 && part.trim() == "1" {
            continue;
        }
        for token in part.split([' ', '*', '·']).filter(|t| !t.is_empty()) {
            let (name, power) = match token.split_once('^') {
                Some((name, p)) => (name, i32::from(p.parse::<i8>().map_err(|_| token.to_string())?)),
                None => match token.strip_suffix('²').map(|n| (n, 2)).or(token.strip_suffix('³').map(|n| (n, 3))) {
                    Some(pair) => pair,
                    None => (token, 1),
                },
            };
            let (_, f, d) = UNITS.iter().find(|(n, _, _)| *n == name).ok_or_else(|| name.to_string())?;
            factor *= f.powi(sign * power);
            dimension = dimension.times(*d, sign * power);
        }
    }
    Ok((factor, dimension))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One in twenty of the lengths with one decimal of a millimetre is rounded to a number different from the same length given in metres.
    #[test]
    fn the_end_of_a_range_is_within_it() {
        let metres = |text: &str| parse(text, Dimension::LENGTH).expect("a length");
        let ends = |text: &str| (metres("-40 mm"), metres(text));
        let mut rounded = 0;
        for tenths in 1..400_u32 {
            let (whole, tenth) = (tenths / 10, tenths % 10);
            let end: f64 = format!("{tenths}e-4").parse().expect("a number");
            let range = ends(&format!("{whole}.{tenth} mm"));
            rounded += u32::from(range.1 != end);
            assert!(within(end, range) && !within(end * (1.0 + 1e-12), range), "{tenths}");
        }
        assert!(rounded > 0, "0.0041 is not 4.1 times 0.001");
        assert!(!within(f64::NAN, (0.0, 1.0)) && within(-0.04, ends("4.1 mm")));
    }

    #[test]
    fn decimals_lose_no_number() {
        let told = |x: f64| format!("{:.4} mm", Decimals(x));
        assert_eq!(
            [7.5, 0.0123456, 0.001, 3.21e-5, -2e-9, 0.0, f64::INFINITY].map(told),
            ["7.5000 mm", "0.0123 mm", "0.0010 mm", "3.210e-5 mm", "-2.000e-9 mm", "0.0000 mm", "inf mm"]
        );
    }

    #[test]
    fn reads_compound_units() {
        for (text, wanted, si) in [
            ("18 kPa", Dimension::PRESSURE, 18e3),
            ("7.5mm", Dimension::LENGTH, 7.5e-3),
            ("1.07 g/cm^3", Dimension::DENSITY, 1070.0),
            ("9.81 m/s²", Dimension::ACCELERATION, 9.81),
            ("2 Pa s", Dimension::VISCOSITY, 2.0),
            ("0.5 N/mm^2", Dimension::PRESSURE, 0.5e6),
            ("0.5", Dimension::NONE, 0.5),
            ("1e3 Pa", Dimension::PRESSURE, 1e3),
            ("2 1/s", Dimension::FREQUENCY, 2.0),
            ("2 1 / s", Dimension::FREQUENCY, 2.0),
            ("2 /s", Dimension::FREQUENCY, 2.0),
            ("2 1", Dimension::NONE, 2.0),
            ("0.5 h", Dimension::TIME, 1800.0),
            ("2 min", Dimension::TIME, 120.0),
            ("2 %", Dimension::NONE, 0.02),
        ] {
            let got = parse(text, wanted).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!((got / si - 1.0).abs() < 1e-14, "{text} gave {got}, not {si}");
        }
    }

    #[test]
    fn changes_units() {
        assert_eq!(in_unit("50 kPa", "kPa"), Ok(50.0));
        let got = in_unit("0.2 MPa", "kPa").expect("a pressure");
        assert!((got / 200.0 - 1.0).abs() < 1e-14, "{got}");
        assert_eq!(in_unit("0.45", ""), Ok(0.45));
        assert!(in_unit("2 mm", "kPa").is_err() && in_unit("2", "kPa").is_err() && in_unit("2 kPa", "kpa").is_err());
    }

    #[test]
    fn units_are_known_as_machines_spell_them() {
        for (unit, other, size) in [("inch", "mm", 25.4), ("msec", "s", 1e-3), ("μm", "mm", 1e-3), ("mbar", "kPa", 0.1)]
        {
            assert!((ratio(unit, other).expect("known") / size - 1.0).abs() < 1e-12, "{unit}");
        }
        assert!(ratio("inch", "s").is_none() && ratio("furlong", "mm").is_none() && !is_unit("pull"));
    }

    #[test]
    fn shows_numbers_without_the_rounding_of_a_conversion() {
        let density = parse("0.93 g/cm^3", Dimension::DENSITY).expect("a density");
        assert!(density != 930.0 && shown(density) == 930.0, "{density}");
        assert_eq!(shown(1.0 / 3.0).to_string(), "0.333333333");
        assert_eq!([0.0, -2.5e-7, 1e300, f64::INFINITY].map(shown), [0.0, -2.5e-7, 1e300, f64::INFINITY]);
    }

    #[test]
    fn refuses_with_a_remedy() {
        let message = |t, d| parse(t, d).expect_err("must be refused").to_string();
        assert_eq!(
            message("18", Dimension::PRESSURE),
            "18 has no unit; write the unit that is meant, \"18 Pa\" in SI or for example \"18 kPa\""
        );
        assert!(message("18 mm", Dimension::PRESSURE).contains("wrong dimension"));
        assert!(message("18 kpa", Dimension::PRESSURE).ends_with("unknown unit \"kpa\"; did you mean kPa?"));
        assert!(message("1 inch", Dimension::LENGTH).ends_with("did you mean in?"));
        // A number that fell apart
        assert!(message("2 1 mm", Dimension::LENGTH).contains("unknown unit \"1\""));
        assert!(message("2·1·mm", Dimension::LENGTH).contains("unknown unit \"1\""));
        assert!(message("1 furlong", Dimension::LENGTH).contains("the units are m, cm, mm"));
        assert!(message("0,1 s", Dimension::TIME).ends_with("write a decimal point, not a comma"));
        assert!(message("100,000 Pa", Dimension::PRESSURE).contains("leave it out where it marks thousands"));
        assert!(message("soft", Dimension::PRESSURE).contains("finite number"));
        assert!(message("inf Pa", Dimension::PRESSURE).contains("finite number"));
        for text in ["1e308 MPa", "1e-320 mm^3", "1 GPa^99", "1 m^127 m^127 m^-127 m^-127 m^-127 um^127 um^127"] {
            assert!(matches!(quantity(text), Err(UnitError::Range { .. })), "{text}: {:?}", quantity(text));
        }
        assert!(message(&format!("1 {}", "m ".repeat(200)), Dimension::LENGTH).contains("at most 256"));
    }
}
