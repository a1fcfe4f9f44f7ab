//! A delimited text file as lines of cells: encoding, delimiter and decimal mark, without interpreting the columns.

use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// One line of a file.
#[derive(Clone, Debug)]
pub struct Line {
    /// Number of the line in the file, counted from 1
    pub number: u64,
    pub cells: Vec<String>,
}

impl Line {
    /// Whether every cell is empty.
    pub fn is_empty(&self) -> bool {
        self.cells.iter().all(String::is_empty)
    }
}

/// Delimiters in the order in which they are tried: first those that cannot be a decimal mark.
pub const DELIMITERS: [char; 3] = [';', '\t', ','];

/// Characters that group thousands whatever the decimal mark: spaces of several widths and apostrophes (ISO 80000-1, 7.3.1, and Swiss usage).
const BLANK_GROUPS: [char; 6] = [' ', '\u{a0}', '\u{2009}', '\u{202f}', '\'', '\u{2019}'];

/// The decimal mark; the other character may group thousands.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Decimal {
    Point,
    Comma,
}

impl FromStr for Decimal {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "point" => Ok(Self::Point),
            "comma" => Ok(Self::Comma),
            _ => Err(format!("\"{word}\" is not a decimal mark; known: point, comma")),
        }
    }
}

impl Decimal {
    pub fn name(self) -> &'static str {
        if self == Self::Point { "point" } else { "comma" }
    }

    /// The mark, and the character that groups thousands.
    fn signs(self) -> (char, char) {
        if self == Self::Point { ('.', ',') } else { (',', '.') }
    }

    /// The decimal mark that these cells use; as an error, a cell such as `1,234` that is a number with either mark, if no other cell decides.
    pub fn of<'a>(cells: impl Iterator<Item = &'a str>) -> Result<Self, String> {
        let (mut certain, mut either) = (false, None);
        for cell in cells {
            match (cell.rfind('.'), cell.rfind(',')) {
                (Some(p), Some(c)) if number(cell, Self::Point).is_ok() || number(cell, Self::Comma).is_ok() => {
                    return Ok(if p > c { Self::Point } else { Self::Comma });
                }
                (Some(_), None) if number(cell, Self::Point).is_ok() => return Ok(Self::Point),
                (None, Some(_)) if number(cell, Self::Comma).is_ok() => {
                    if number(cell, Self::Point).is_ok() {
                        either = either.or(Some(cell));
                    } else {
                        certain = true;
                    }
                }
                _ => {}
            }
        }
        match either {
            Some(cell) if !certain => Err(cell.to_string()),
            _ => Ok(if certain { Self::Comma } else { Self::Point }),
        }
    }
}

/// The text of a file, and its encoding unless that is UTF-8. Refuses content that is not text, with the reason.
///
/// A byte-order mark decides; otherwise zeros in every second byte indicate UTF-16, and bytes that are not valid UTF-8 indicate Windows-1252, which
/// contains the printable characters of Latin-1. Every byte is decoded, so that nothing is lost.
pub fn decode(bytes: &[u8]) -> Result<(String, Option<&'static str>), String> {
    for (start, what) in
        [(&b"PK\x03\x04"[..], "an Excel workbook or a zip file"), (b"\xd0\xcf\x11\xe0", "an Excel or Office file")]
    {
        if bytes.starts_with(start) {
            return Err(format!("is {what}"));
        }
    }
    let encoding = Encoding::for_bom(bytes).map_or_else(|| without_mark(bytes), |(encoding, _)| encoding);
    let (text, broken) = encoding.decode_with_bom_removal(bytes);
    if broken && encoding != UTF_8 {
        return Err(format!("holds characters that are not {}", encoding.name()));
    }
    if text.contains('\0') {
        return Err("holds zero bytes, as only binary files do".into());
    }
    if broken {
        // The file has the byte-order mark of UTF-8 but is not UTF-8
        return Ok((WINDOWS_1252.decode_without_bom_handling(&bytes[3..]).0.into_owned(), Some(WINDOWS_1252.name())));
    }
    Ok((text.into_owned(), (encoding != UTF_8).then(|| encoding.name())))
}

/// Share of the bytes at even or odd positions that are zero in UTF-16 text of mostly Latin letters \[–\]
const ZEROS: f64 = 0.4;

fn without_mark(bytes: &[u8]) -> &'static Encoding {
    let start = &bytes[..bytes.len().min(4096) & !1];
    let zeros = |place: usize| start.iter().skip(place).step_by(2).filter(|b| **b == 0).count() as f64;
    let many = ZEROS * 0.5 * start.len() as f64;
    match () {
        () if !start.is_empty() && zeros(1) > many && zeros(0) < 0.1 * many => UTF_16LE,
        () if !start.is_empty() && zeros(0) > many && zeros(1) < 0.1 * many => UTF_16BE,
        () if std::str::from_utf8(bytes).is_ok() => UTF_8,
        () => WINDOWS_1252,
    }
}

/// Splits a text at a delimiter, except within quotation marks. Empty lines are skipped.
pub fn split(text: &str, delimiter: char) -> Vec<Line> {
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter as u8)
        .has_headers(false)
        .flexible(true)
        .from_reader(text.as_bytes());
    reader
        .records()
        .map(|record| {
            let record = record.expect("a flexible reader of UTF-8 in memory refuses nothing");
            let number = record.position().expect("a record that was read has a position").line();
            Line { number, cells: record.iter().map(|c| c.trim().to_string()).collect() }
        })
        .collect()
}

/// A cell without surrounding brackets.
pub(super) fn bare(cell: &str) -> &str {
    cell.trim_matches(['(', ')', '[', ']', ' '])
}

/// A cell as a finite number, or the reason why it is not one.
pub fn number(cell: &str, decimal: Decimal) -> Result<f64, String> {
    if cell.is_empty() {
        return Err("is empty".into());
    }
    let (mark, group) = decimal.signs();
    let (whole, rest) = cell.find(mark).map_or((cell, ""), |k| cell.split_at(k));
    // The usual cell needs no copy
    if mark == '.'
        && let Some(x) = plain_number(cell)
    {
        return Ok(x);
    }
    let grouping = BLANK_GROUPS.iter().chain([&group]).find(|g| is_grouped(whole, **g));
    let plain = grouping.map_or_else(|| cell.to_string(), |g| whole.replace(*g, "") + rest);
    let other = plain.contains(group);
    match plain.replace(mark, ".").replace('\u{2212}', "-").parse::<f64>() {
        Ok(x) if x.is_finite() && !other => Ok(x),
        Ok(x) if !x.is_finite() => Err(format!("holds \"{cell}\", which is not finite")),
        _ => Err(format!("holds \"{cell}\", which is not a number")),
    }
}

fn plain_number(cell: &str) -> Option<f64> {
    cell.parse().ok().filter(|x: &f64| x.is_finite())
}

/// Whether a cell is a number with one of the two marks.
pub fn is_number(cell: &str) -> bool {
    [Decimal::Point, Decimal::Comma].iter().any(|d| number(cell, *d).is_ok())
}

/// `1,234` or `12,345,678`, but not `0,123`: digits in groups of three, the first one not zero.
fn is_grouped(whole: &str, group: char) -> bool {
    let mut parts = whole.trim_start_matches(['-', '+']).split(group);
    let digits = |p: &str| p.chars().all(|c| c.is_ascii_digit());
    let first = parts.next().is_some_and(|p| (1..=3).contains(&p.len()) && digits(p) && !p.starts_with('0'));
    let rest: Vec<&str> = parts.collect();
    first && !rest.is_empty() && rest.iter().all(|p| p.len() == 3 && digits(p))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimal_marks_are_told_apart_or_not_at_all() {
        let of = |cells: &[&str]| Decimal::of(cells.iter().copied());
        for (cells, mark) in [
            (&["1.5", "2"][..], Decimal::Point),
            (&["1", "2"], Decimal::Point),
            (&["1,5", "1,234"], Decimal::Comma),
            (&["0,123", "0,456"], Decimal::Comma),
            (&["1,234.5", "0.5"], Decimal::Point),
            (&["1.234,5", "7"], Decimal::Comma),
            (&["1,2345"], Decimal::Comma),
            (&["1 234,5", "7"], Decimal::Comma),
            (&["1'234", "7"], Decimal::Point),
        ] {
            assert_eq!(of(cells), Ok(mark), "{cells:?}");
        }
        assert_eq!(of(&["1,234", "2", "12,345"]), Err("1,234".into()));
    }

    #[test]
    fn cells_are_numbers_with_one_mark() {
        for (cell, mark, value) in [
            ("1,234.5", Decimal::Point, 1234.5),
            ("-1.234,5", Decimal::Comma, -1234.5),
            ("1,5e-3", Decimal::Comma, 1.5e-3),
            ("1234.5", Decimal::Point, 1234.5),
            ("12,345,678", Decimal::Point, 12_345_678.0),
            ("1 234.5", Decimal::Point, 1234.5),
            ("-12\u{202f}345\u{202f}678,9", Decimal::Comma, -12_345_678.9),
            ("1'234.5", Decimal::Point, 1234.5),
        ] {
            assert_eq!(number(cell, mark), Ok(value), "{cell}");
        }
        for (cell, mark) in [
            ("1,5", Decimal::Point),
            ("1.5", Decimal::Comma),
            ("1,23,456", Decimal::Point),
            ("1 23", Decimal::Point),
            ("1.234 567", Decimal::Point),
            ("x", Decimal::Point),
        ] {
            assert!(number(cell, mark).is_err_and(|e| e.contains("not a number")), "{cell}");
        }
        assert!(number("inf", Decimal::Point).is_err_and(|e| e.contains("not finite")));
    }
}
