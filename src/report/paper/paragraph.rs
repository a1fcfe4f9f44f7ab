//! Sentences with citations, printed as Markdown and as LaTeX.
//!
//! A number and its unit are joined by a no-break space, so that LaTeX sets them with siunitx.

use crate::report::latex::{escape, formula, power_of_ten, quantity};
use crate::report::numbers::minus_signs;
use crate::report::paper::references::{Reference, program};

/// A part of a text.
#[derive(Clone, Debug, PartialEq)]
enum Piece {
    Text(String),
    Formula(String),
    Cite(Vec<&'static Reference>),
}

/// A paragraph with its own heading.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Paragraph {
    pub heading: &'static str,
    pieces: Vec<Piece>,
}

impl Paragraph {
    pub fn new(heading: &'static str) -> Self {
        Self { heading, pieces: vec![] }
    }

    /// Adds text that is printed unchanged, because names and sources come from files.
    #[must_use]
    pub fn text(mut self, text: impl Into<String>) -> Self {
        self.pieces.push(Piece::Text(text.into()));
        self
    }

    /// Adds a formula in the notation of the laws: `ψ = C10 (Ī₁ − 3) + U(J)`.
    #[must_use]
    pub fn formula(mut self, formula: impl Into<String>) -> Self {
        self.pieces.push(Piece::Formula(formula.into()));
        self
    }

    /// Adds a text of the program, in which `[@key]` and `[@one; @another]` are citations.
    #[must_use]
    pub fn marked(mut self, text: &str) -> Self {
        let mut rest = text;
        while let Some((before, (keys, after))) =
            rest.split_once("[@").and_then(|(before, rest)| Some((before, rest.split_once(']')?)))
        {
            let before = before.strip_suffix(' ').unwrap_or(before);
            self.pieces.push(Piece::Text(before.into()));
            let keys = keys.split(';').map(|key| key.trim().trim_start_matches('@'));
            self = self.cite(keys.filter_map(Reference::of_key).collect());
            rest = after;
        }
        self.text(rest)
    }

    /// Adds a citation, unless the list is empty.
    #[must_use]
    pub fn cite(mut self, references: Vec<&'static Reference>) -> Self {
        if !references.is_empty() {
            self.pieces.push(Piece::Cite(references));
        }
        self
    }

    /// Adds the citation of the program itself.
    #[must_use]
    pub fn cite_program(self) -> Self {
        self.cite(vec![program()])
    }

    /// Returns the references that the paragraph cites, including repetitions.
    pub fn references(&self) -> impl Iterator<Item = &'static Reference> + '_ {
        self.pieces.iter().flat_map(|piece| match piece {
            Piece::Text(_) | Piece::Formula(_) => vec![],
            Piece::Cite(references) => references.clone(),
        })
    }

    /// Returns `\paragraph{heading}` with citations by `\cite`.
    pub fn latex(&self) -> String {
        let mut out = format!("\\paragraph{{{}.}} ", escape(self.heading));
        for piece in &self.pieces {
            match piece {
                Piece::Text(text) => out += &latex_text(&minus_signs(text)),
                Piece::Formula(text) => out += &formula(text),
                Piece::Cite(references) => {
                    let keys: Vec<&str> = references.iter().map(|r| r.key).collect();
                    out += &format!("~\\cite{{{}}}", keys.join(","));
                }
            }
        }
        out + "\n"
    }

    /// Returns a Markdown paragraph with Pandoc citations.
    pub fn markdown(&self) -> String {
        let mut out = format!("**{}.** ", self.heading);
        for piece in &self.pieces {
            match piece {
                Piece::Text(text) | Piece::Formula(text) => out += &markdown_text(&minus_signs(text)),
                Piece::Cite(references) => {
                    let keys: Vec<String> = references.iter().map(|r| format!("@{}", r.key)).collect();
                    out += &format!(" [{}]", keys.join("; "));
                }
            }
        }
        out + "\n"
    }
}

/// Text in LaTeX that may break after each `_`, as within the names of cases.
fn breakable(text: &str) -> String {
    escape(text).replace("\\_", "\\_\\allowbreak{}")
}

/// Text in LaTeX, with quantities set by siunitx.
fn latex_text(text: &str) -> String {
    let mut out = String::new();
    let mut from = 0;
    for (start, word) in words(text) {
        let formula = word.trim_end_matches([',', '.', ';']);
        if let Some(set) = raised(formula) {
            out += &breakable(&text[from..start]);
            out += &set;
            from = start + formula.len();
            continue;
        }
        let end = word.trim_end_matches([',', '.', ';', ')']);
        let open = end.trim_start_matches('(');
        let set = open.split_once('\u{a0}').map_or_else(|| power_of_ten(open), |(n, unit)| quantity(n, unit));
        if let Some(set) = set {
            let begin = start + end.len() - open.len();
            out += &breakable(&text[from..begin]);
            out += &set;
            from = start + end.len();
        }
    }
    out + &breakable(&text[from..])
}

/// Sets `(V/N)^(1/3)` as the formula `(V/N)^{1/3}`; `None` if the text is not a power.
fn raised(text: &str) -> Option<String> {
    let (base, exponent) = text.strip_suffix(')')?.split_once("^(")?;
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "()/+-".contains(c);
    let is_formula = |part: &str| !part.is_empty() && part.chars().all(is_plain);
    (is_formula(base) && is_formula(exponent)).then(|| format!("\\ensuremath{{{base}^{{{exponent}}}}}"))
}

/// The words between spaces, with their offsets in the text.
fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.split(' ').scan(0, |at, word| {
        let start = *at;
        *at += word.len() + 1;
        Some((start, word))
    })
}

/// Text in Markdown with special characters escaped.
fn markdown_text(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\\' | '`' | '*' | '_' | '{' | '}' | '[' | ']' | '<' | '>' | '#' | '|' | '~' | '$' | '^' | '@' => {
                out.push('\\');
                out.push(c);
            }
            '&' => out += "&amp;",
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sentence_has_citations_and_quantities_in_both_forms() {
        let p = Paragraph::new("Law").marked("Yeoh's law [@yeoh1993] with C10 = 18\u{a0}kPa.").text(" From a_b [x].");
        let tex = "\\paragraph{Law.} Yeoh's law~\\cite{yeoh1993} with C10 = \\qty{18}{\\kilo\\pascal}. From a\\_\\allowbreak{}b {[}x].\n";
        assert_eq!(p.latex(), tex);
        let markdown = "**Law.** Yeoh's law [@yeoh1993] with C10 = 18\u{a0}kPa. From a\\_b \\[x\\].\n";
        assert_eq!(p.markdown(), markdown);
        assert_eq!(p.references().map(|r| r.key).collect::<Vec<_>>(), ["yeoh1993"]);
    }

    #[test]
    fn formulae_and_signs_are_set() {
        let p = Paragraph::new("Law").text("Of Ogden, ").formula("ψ = Σ λ^{α_n}").text(" with -857.1 to -1.0 of a-1");
        let tex = "\\paragraph{Law.} Of Ogden, \\ensuremath{\\psi = \\sum \\lambda^{\\alpha_{n}}} with \\ensuremath{-}857.1 to \\ensuremath{-}1.0 of a-1\n";
        assert_eq!(p.latex(), tex);
        assert_eq!(p.markdown(), "**Law.** Of Ogden, ψ = Σ λ\\^\\{α\\_n\\} with −857.1 to −1.0 of a-1\n");
    }

    #[test]
    fn a_power_is_a_formula() {
        let tex = latex_text("with h = (V/N)^(1/3), the mean, and a^b");
        assert!(tex.starts_with("with h = \\ensuremath{(V/N)^{1/3}}, the mean, and a"), "{tex}");
        assert!(!tex.ends_with("^b"), "{tex}");
    }
}
