//! A delimited text file as lines of cells: byte-order mark, delimiter, decimal comma. No meaning yet.

/// One line of a file.
#[derive(Clone, Debug)]
pub struct Line {
    /// Counted from 1
    pub number: u64,
    pub cells: Vec<String>,
}

/// Delimiters that are tried, the ones that cannot be a decimal mark first.
pub const DELIMITERS: [char; 3] = [';', '\t', ','];

/// Text of a file: UTF-8 without its byte-order mark. The flag tells that bytes had to be replaced.
pub fn decode(bytes: &[u8]) -> (String, bool) {
    let text = String::from_utf8_lossy(bytes);
    let replaced = matches!(text, std::borrow::Cow::Owned(_));
    (text.trim_start_matches('\u{feff}').to_string(), replaced)
}

/// Splits a text at a delimiter; quotes protect it. Empty lines are skipped.
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

/// A cell as a finite number, or what is wrong with it.
pub fn number(cell: &str, decimal_comma: bool) -> Result<f64, String> {
    if cell.is_empty() {
        return Err("is empty".into());
    }
    let parsed = if decimal_comma { cell.replace(',', ".").parse::<f64>() } else { cell.parse::<f64>() };
    match parsed {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("holds \"{cell}\", which is not finite")),
        Err(_) => Err(format!("holds \"{cell}\", which is not a number")),
    }
}

/// True when the cells are numbers only if their comma is a decimal mark.
pub fn has_decimal_comma<'a>(cells: impl Iterator<Item = &'a str>) -> bool {
    let mut commas = 0;
    for cell in cells {
        if cell.contains('.') && number(cell, false).is_ok() {
            return false;
        }
        commas += usize::from(cell.contains(',') && number(cell, true).is_ok());
    }
    commas > 0
}
