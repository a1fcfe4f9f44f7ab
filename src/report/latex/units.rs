//! Units and numbers in the syntax of siunitx.

use super::widths::width;

/// Unit symbols with their macros; prefixes are listed in [`PREFIXES`].
const SYMBOLS: [(&str, &str); 19] = [
    ("m", "\\metre"),
    ("s", "\\second"),
    ("g", "\\gram"),
    ("N", "\\newton"),
    ("Pa", "\\pascal"),
    ("J", "\\joule"),
    ("W", "\\watt"),
    ("V", "\\volt"),
    ("A", "\\ampere"),
    ("K", "\\kelvin"),
    ("Hz", "\\hertz"),
    ("B", "\\byte"),
    ("rad", "\\radian"),
    ("min", "\\minute"),
    ("h", "\\hour"),
    ("d", "\\day"),
    ("%", "\\percent"),
    ("°", "\\degree"),
    ("°C", "\\degreeCelsius"),
];

const PREFIXES: [(&str, &str); 7] = [
    ("n", "\\nano"),
    ("µ", "\\micro"),
    ("μ", "\\micro"),
    ("m", "\\milli"),
    ("k", "\\kilo"),
    ("M", "\\mega"),
    ("G", "\\giga"),
];

const POWERS: [(&str, &str); 3] = [("²", "\\squared"), ("³", "\\cubed"), ("⁴", "\\tothe{4}")];

/// Returns `\unit{\kilo\pascal}` for `kPa`; `None` if the text is not an SI unit.
pub fn unit(text: &str) -> Option<String> {
    Some(format!("\\unit{{{}}}", macros(text)?))
}

/// Returns `\qty{18}{\kilo\pascal}` for `18` and `kPa`; `None` if the first is not a number or the second not a unit.
pub fn quantity(value: &str, unit: &str) -> Option<String> {
    Some(format!("\\qty{{{}}}{{{}}}", number(value)?, macros(unit)?))
}

/// Returns `\num{1e-8}` for a number with an exponent.
pub fn power_of_ten(text: &str) -> Option<String> {
    number(text).filter(|n| n.contains('e')).map(|n| format!("\\num{{{n}}}"))
}

fn macros(text: &str) -> Option<String> {
    let mut macros = String::new();
    for (k, factor) in text.split('/').enumerate() {
        for one in factor.split('·') {
            if k > 0 {
                macros += "\\per";
            }
            if !(k == 0 && one == "1" && text.contains('/')) {
                macros += &power(one)?;
            }
        }
    }
    Some(macros)
}

fn power(text: &str) -> Option<String> {
    let raised = POWERS.iter().find_map(|(sign, power)| Some((text.strip_suffix(sign)?, *power)));
    let (base, power) = raised.unwrap_or((text, ""));
    let symbol = |s: &str| SYMBOLS.iter().find(|(symbol, _)| *symbol == s).map(|(_, name)| name.to_string());
    let prefixed = || {
        let of = |(sign, prefix): &(&str, &str)| Some(format!("{prefix}{}", symbol(base.strip_prefix(sign)?)?));
        PREFIXES.iter().find_map(of)
    };
    Some(symbol(base).or_else(prefixed)? + power)
}

/// Returns the number in the syntax of siunitx, if the cell is a number.
pub fn number(cell: &str) -> Option<String> {
    let plain: String = cell.replace('−', "-").chars().filter(|c| *c != '\u{2009}').collect();
    let (mantissa, exponent) = plain.split_once('e').unwrap_or((&plain, "0"));
    let unsigned = mantissa.strip_prefix(['-', '+']).unwrap_or(mantissa);
    let (whole, decimals) = unsigned.split_once('.').unwrap_or((unsigned, "0"));
    let digits = |s: &str| !s.is_empty() && s.chars().all(|c| c.is_ascii_digit());
    let power = exponent.strip_prefix(['-', '+']).unwrap_or(exponent);
    (digits(whole) && digits(decimals) && digits(power) && plain.len() <= LONGEST).then_some(plain)
}

/// Largest number of characters of a number; longer ones are text.
const LONGEST: usize = 24;

/// Digits before and after the point and of the exponent, and whether there is a sign: the room that `table-format` of a column reserves.
#[derive(Clone, Copy, Default)]
pub struct Room {
    negative: bool,
    whole: usize,
    decimals: usize,
    exponent: usize,
    negative_exponent: bool,
}

impl Room {
    /// Extends the room to include `number`, in the form written by [`number`].
    pub fn with(self, number: &str) -> Self {
        let (mantissa, exponent) = number.split_once('e').unwrap_or((number, ""));
        let (whole, decimals) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits = |s: &str| s.chars().filter(char::is_ascii_digit).count();
        Self {
            negative: self.negative || whole.starts_with('-'),
            whole: self.whole.max(digits(whole)),
            decimals: self.decimals.max(decimals.len()),
            exponent: self.exponent.max(digits(exponent)),
            negative_exponent: self.negative_exponent || exponent.starts_with('-'),
        }
    }

    /// Returns the width of the column \[pt\].
    pub fn width(self) -> f64 {
        let sign = |negative: bool| if negative { "−" } else { "" };
        let decimals = if self.decimals > 0 { format!(".{}", "0".repeat(self.decimals)) } else { String::new() };
        let exponent = match self.exponent {
            0 => String::new(),
            n => format!(" ×10{}{}", sign(self.negative_exponent), "0".repeat(n)),
        };
        width(&format!("{}{}{decimals}{exponent}", sign(self.negative), "0".repeat(self.whole)))
    }

    /// Returns the column specifier, such as `S[table-format=-2.3]`.
    pub fn column(self) -> String {
        let sign = |negative: bool| if negative { "-" } else { "" };
        let decimals = if self.decimals > 0 { format!(".{}", self.decimals) } else { String::new() };
        let exponent = match self.exponent {
            0 => String::new(),
            n => format!("e{}{n}", sign(self.negative_exponent)),
        };
        format!("S[table-format={}{}{decimals}{exponent}]", sign(self.negative), self.whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_their_macros() {
        let of = |text| unit(text).unwrap_or_default();
        assert_eq!(of("kPa"), "\\unit{\\kilo\\pascal}");
        assert_eq!(of("m³"), "\\unit{\\metre\\cubed}");
        assert_eq!(of("mN·m"), "\\unit{\\milli\\newton\\metre}");
        assert_eq!(of("kg/m³"), "\\unit{\\kilo\\gram\\per\\metre\\cubed}");
        assert_eq!(of("1/s"), "\\unit{\\per\\second}");
        assert_eq!(of("min"), "\\unit{\\minute}", "not a milli-inch");
        for words in ["% of truth", "cells", "SI", "", "1", "–"] {
            assert_eq!(unit(words), None, "{words}");
        }
    }

    #[test]
    fn numbers_are_told_from_words() {
        for (cell, is) in [("-0.051", "-0.051"), ("−3", "-3"), ("36\u{2009}600", "36600"), ("1.46e9", "1.46e9")] {
            assert_eq!(number(cell).as_deref(), Some(is));
        }
        for cell in ["", "–", "1.2 s", "≈ 3", "4.", ".5", "e5", "1e", "nan", "inf", "1.2.3", "--1", "1_000"] {
            assert_eq!(number(cell), None, "{cell}");
        }
        let room = ["-1.25", "300", "1.5e-12"].iter().fold(Room::default(), |room, n| room.with(n));
        assert_eq!(room.column(), "S[table-format=-3.2e-2]");
    }
}
