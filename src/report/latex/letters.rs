//! Text in LaTeX: characters that are commands, and characters outside ASCII.
//!
//! Both engines know the commands of the table in any font encoding. A letter with an accent becomes the accent over its base. A character with
//! neither a command nor an accent is printed as its code point, `[U+4E2D]`: it is replaced, never lost, and never stops a compilation. Consecutive
//! spaces become one; control characters and zero-width marks are removed.

use super::commands::Command::{Math, Text};
use super::commands::command;
use unicode_normalization::char::{compose, decompose_canonical};

const CEDILLA: char = '\u{327}';

/// Returns text escaped for LaTeX.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len() + 16);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        if let Some(space) = fixed_space(c) {
            out += space;
            continue;
        }
        if c.is_whitespace() {
            if !out.ends_with(' ') {
                out.push(' ');
            }
            continue;
        }
        // A cedilla is part of its letter, not an accent available in every font
        let c = match rest.peek().filter(|mark| **mark == CEDILLA).and_then(|mark| compose(c, *mark)) {
            Some(joined) => {
                rest.next();
                joined
            }
            None => c,
        };
        let mut marks = vec![];
        while let Some(mark) = rest.next_if(|c| accent(*c).is_some()) {
            marks.push(mark);
        }
        let opens = out.is_empty() || out.ends_with([' ', '(', '[', '}', '-']);
        out += &with_accents(c, &marks, opens, out.chars().next_back());
    }
    out
}

/// Non-breaking spaces.
fn fixed_space(c: char) -> Option<&'static str> {
    match c {
        '\u{a0}' => Some("~"),
        '\u{2009}' | '\u{202f}' => Some("\\,"),
        _ => None,
    }
}

/// One character with the accents that follow it. An accent that cannot be set over it follows as its code point.
fn with_accents(c: char, marks: &[char], opens: bool, before: Option<char>) -> String {
    let (mut base, mut own) = (c, vec![]);
    if command(c).is_none() {
        let mut parts = vec![];
        decompose_canonical(c, |part| parts.push(part));
        if parts.iter().skip(1).all(|m| accent(*m).is_some()) {
            base = parts.first().copied().unwrap_or(c);
            own.extend(parts.into_iter().skip(1));
        }
    }
    own.extend(marks);
    let accents: Vec<Accent> = own.iter().filter_map(|m| accent(*m)).collect();
    let left = |set: usize| own.iter().skip(set).map(|m| code_point(*m)).collect::<String>();
    match (command(base), accents.first()) {
        (Some(Math(math)), _) => {
            format!("\\ensuremath{{{}}}", over(math.to_string(), &accents))
        }
        (None, Some(first)) if base.is_ascii_alphabetic() => format!("{}{{{base}}}{}", first.text, left(1)),
        (Some(Text(words)), _) => format!("{words}{}", left(0)),
        (None, _) => plain(base, opens, before) + &left(0),
    }
}

/// Returns the first letter of a text, as set in a formula with its accents, and the rest; `None` if it has no accent.
pub(super) fn accented(text: &str) -> Option<(String, &str)> {
    let mut rest = text.chars();
    let mut parts = vec![];
    decompose_canonical(rest.next()?, |part| parts.push(part));
    let (base, own) = parts.split_first()?;
    let mut accents: Vec<Accent> = own.iter().map(|mark| accent(*mark)).collect::<Option<_>>()?;
    while let Some(next) = rest.clone().next().and_then(accent) {
        accents.push(next);
        rest.next();
    }
    let inner = match command(*base) {
        Some(Math(math)) => math.to_string(),
        _ if base.is_ascii_alphanumeric() => base.to_string(),
        _ => return None,
    };
    (!accents.is_empty()).then(|| (over(inner, &accents), rest.as_str()))
}

/// Whether a character is an accent over the previous one.
pub(super) fn is_accent(c: char) -> bool {
    accent(c).is_some()
}

/// A letter in a formula with accents over it.
fn over(letter: String, accents: &[Accent]) -> String {
    accents.iter().fold(letter, |inner, a| format!("{}{{{inner}}}", a.math))
}

/// A character without a command.
fn plain(c: char, opens: bool, before: Option<char>) -> String {
    match c {
        '"' => if opens { "``" } else { "''" }.into(),
        // Two in a row would become a dash or a quotation mark
        '-' | ',' | '\'' if before == Some(c) => format!("{{}}{c}"),
        ' '..='~' => c.into(),
        c if c.is_control() || is_unseen(c) => String::new(),
        c => code_point(c),
    }
}

/// Whether a character has no width: joiners, directions, soft hyphens, variation selectors, and the marks of italics in figures.
fn is_unseen(c: char) -> bool {
    matches!(c, '\u{ad}' | '\u{34f}' | '\u{61c}' | '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
        || matches!(c, '\u{fe00}'..='\u{fe0f}' | '\u{e000}'..='\u{e006}' | '\u{e0100}'..='\u{e01ef}')
}

fn code_point(c: char) -> String {
    format!("{{[}}U+{:04X}]", u32::from(c))
}

/// The commands of an accent in text and in formulae.
#[derive(Clone, Copy)]
struct Accent {
    text: &'static str,
    math: &'static str,
}

fn accent(c: char) -> Option<Accent> {
    let (text, math) = match c {
        '\u{300}' => ("\\`", "\\grave"),
        '\u{301}' => ("\\'", "\\acute"),
        '\u{302}' => ("\\^", "\\hat"),
        '\u{303}' => ("\\~", "\\tilde"),
        '\u{304}' => ("\\=", "\\bar"),
        '\u{306}' => ("\\u", "\\breve"),
        '\u{307}' => ("\\.", "\\dot"),
        '\u{308}' => ("\\\"", "\\ddot"),
        '\u{30a}' => ("\\r", "\\mathring"),
        '\u{30b}' => ("\\H", "\\ddot"),
        '\u{30c}' => ("\\v", "\\check"),
        _ => return None,
    };
    Some(Accent { text, math })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_printed_whatever_it_is() {
        let texts = [
            ("50 % of a_1 & ~b", "50 \\% of a\\_1 \\& \\textasciitilde{}b"),
            ("\\input{x}", "\\textbackslash{}input\\{x\\}"),
            ("ν ≤ ½, m³", "\\ensuremath{\\nu} \\ensuremath{\\leq} \\ensuremath{\\frac{1}{2}}, m\\ensuremath{^{3}}"),
            ("Géradin, Eça, Hölder", "G\\'{e}radin, E\\c{c}a, H\\\"{o}lder"),
            ("ψ̄ and q\u{304}", "\\ensuremath{\\bar{\\psi}} and \\={q}"),
            ("say \"so\" -- [1]", "say ``so'' -{}- {[}1]"),
            ("中 🦀", "{[}U+4E2D] {[}U+1F980]"),
            ("a\n\n b\u{200b}c\u{7}", "a bc"),
            ("36\u{2009}600\u{a0}N", "36\\,600~N"),
            ("<|>", "\\ensuremath{<}\\ensuremath{|}\\ensuremath{>}"),
        ];
        for (text, tex) in texts {
            assert_eq!(escape(text), tex);
        }
    }
}
