//! Keywords of Abaqus and CalculiX with their lines of numbers.

use super::error::KeywordError;
use super::numbers::numbers;
use super::program::Program;
use std::collections::BTreeMap;

/// Numbers per line
pub const LINE: usize = 8;
/// Keywords that define a law
const LAWS: [&str; 2] = ["*HYPERELASTIC", "*HYPERFOAM"];
/// Keywords of a material that change its response and are not read
const PASSED_OVER: [&str; 15] = [
    "*ELASTIC",
    "*HYPOELASTIC",
    "*ANISOTROPIC HYPERELASTIC",
    "*USER MATERIAL",
    "*MULLINS EFFECT",
    "*HYSTERESIS",
    "*PLASTIC",
    "*CREEP",
    "*VISCOUS",
    "*TRS",
    "*EXPANSION",
    "*DAMPING",
    "*SWELLING",
    "*DAMAGE INITIATION",
    "*DAMAGE EVOLUTION",
];

/// A keyword with the lines below it.
pub struct Card<'a> {
    /// The keyword with its options, joined to one line if it continues after a trailing comma
    pub head: String,
    lines: Vec<&'a str>,
}

impl Card<'_> {
    /// Whether the card has this keyword, given in upper case with its asterisk.
    pub fn is(&self, keyword: &str) -> bool {
        self.head.split(',').next().unwrap_or("").trim().eq_ignore_ascii_case(keyword)
    }

    /// The numbers of every line.
    pub fn rows(&self, program: Program) -> Result<Vec<Vec<f64>>, KeywordError> {
        self.lines.iter().map(|l| numbers(program, &l.split(',').collect::<Vec<_>>())).collect()
    }

    /// The constants below it, at most `count`: a temperature may follow them; constants for several temperatures or for fields are refused.
    pub fn constants(&self, program: Program, count: usize) -> Result<Vec<f64>, KeywordError> {
        let refuse = |what: String| Err(KeywordError::Unreadable { program, what });
        if options(&self.head).contains_key("DEPENDENCIES") {
            return refuse(format!("\"{}\" depends on fields; keep the constants of one state", self.head));
        }
        let rows = self.rows(program)?;
        let own = count.div_ceil(LINE);
        if rows.len() > own {
            return refuse(format!(
                "{} lines below \"{}\" where its constants take {own}: they depend on temperature; keep those of one temperature",
                rows.len(),
                self.head
            ));
        }
        let mut values = rows.concat();
        if values.len() > count + 1 {
            return refuse(format!("{} numbers below \"{}\", which has {count} constants", values.len(), self.head));
        }
        values.truncate(count);
        Ok(values)
    }
}

/// Keywords of the material that has the first law, and the index of that law among them.
pub fn of_first_law(text: &str) -> Option<(Vec<Card<'_>>, usize)> {
    let mut cards: Vec<Card> = vec![];
    for line in text.lines().map(str::trim).filter(|l| !l.starts_with("**") && !l.is_empty()) {
        match cards.last_mut() {
            _ if line.starts_with('*') => cards.push(Card { head: line.into(), lines: vec![] }),
            Some(card) if card.head.ends_with(',') => card.head += line,
            Some(card) => card.lines.push(line),
            None => {}
        }
    }
    let at = cards.iter().position(|c| LAWS.iter().any(|l| c.is(l)))?;
    let begins = |c: &Card| c.is("*MATERIAL");
    let from = cards[..at].iter().rposition(begins).unwrap_or(0);
    let to = cards[at..].iter().position(begins).map_or(cards.len(), |k| at + k);
    Some((cards.drain(from..to).collect(), at - from))
}

/// The keywords that change the response of the material and are not read.
pub fn passed_over(material: &[Card]) -> Vec<String> {
    PASSED_OVER.into_iter().filter(|k| material.iter().any(|c| c.is(k))).map(String::from).collect()
}

/// Options of a keyword by name, in upper case.
pub fn options(line: &str) -> BTreeMap<String, String> {
    let pair = |o: &str| {
        let (key, value) = o.split_once('=').unwrap_or((o, ""));
        (key.trim().to_uppercase(), value.trim().to_string())
    };
    line.split(',').map(pair).collect()
}
