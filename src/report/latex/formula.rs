//! Formulae of laws in LaTeX: Unicode letters with `_` and `^`, and words and commas between formulae.

use super::commands::Command::{Math, Text};
use super::commands::command;
use super::letters::{accented, escape, is_accent};

/// Function names with their commands.
const FUNCTIONS: [(&str, &str); 3] =
    [("ln", "\\ln"), ("sym", "\\mathop{\\mathrm{sym}}\\nolimits"), ("tr", "\\mathop{\\mathrm{tr}}\\nolimits")];
/// Number of consecutive letters from which they are a word; fewer are a product.
const WORD: usize = 3;

/// Sets a formula such as `ψ = Σ (μ_n/α_n) λ̄₁^{α_n} + U(J), n = 1 … 5` in LaTeX; a text that is not a formula is printed unchanged.
pub fn formula(text: &str) -> String {
    let mut set = Setting { scripts: vec![String::new()], ..Setting::default() };
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        rest = set.next(c, rest);
    }
    set.end();
    let is_sound = !set.broken && set.scripts.len() == 1 && text.chars().all(is_mathematical);
    if is_sound { set.out } else { escape(text) }
}

/// Whether a formula may contain this character.
fn is_mathematical(c: char) -> bool {
    let is_letter = |c: char| c.is_ascii_alphanumeric() || "_^{} ()[]+-*/=:;,.!<>|…".contains(c);
    let has_accent = accented(c.encode_utf8(&mut [0; 4])).is_some();
    is_letter(c) || is_accent(c) || has_accent || matches!(command(c), Some(Math(_)))
}

/// The part of a formula that has been set so far.
#[derive(Default)]
struct Setting {
    out: String,
    /// The formula that is being set
    math: String,
    /// Number of open brackets in it
    depth: usize,
    /// The signs `_` and `^` that the last letter already has, for each level of open braces
    scripts: Vec<String>,
    /// Whether a letter has two exponents or indices, a sign is followed by nothing, or a brace was never opened
    broken: bool,
    /// Sign and content of the exponent or index in progress, which further raised or lowered letters may continue
    script: Option<(char, String)>,
}

impl Setting {
    /// Sets the beginning of the remaining text, whose first character is `c`, and returns what is left.
    fn next<'a>(&mut self, c: char, rest: &'a str) -> &'a str {
        let after = &rest[c.len_utf8()..];
        if let Some((sign, content)) = script(c) {
            let so_far = self.script.take_if(|(own, _)| *own == sign).map_or(String::new(), |(_, so_far)| so_far);
            self.close();
            self.script = Some((sign, joined(so_far, content)));
            return after;
        }
        self.close();
        if !"_^{} ".contains(c) {
            self.scripts.last_mut().expect("one level").clear();
        }
        if let Some((set, left)) = accented(rest) {
            self.push(&set);
            return left;
        }
        match c {
            '_' | '^' => {
                self.sign(c);
                // A group has its own braces
                let Some(one) = after.chars().next().filter(|one| *one != '{') else {
                    self.broken |= after.is_empty();
                    return after;
                };
                self.broken |= !one.is_alphanumeric();
                let (set, left) = accented(after).unwrap_or_else(|| (letter(one), &after[one.len_utf8()..]));
                self.push(&format!("{{{set}}}"));
                left
            }
            'a'..='z' | 'A'..='Z' => self.letters(rest),
            ',' | ';' if self.depth == 0 && self.scripts.len() == 1 => {
                self.end();
                self.out.push(c);
                after
            }
            // A numeric fraction ends before the letters
            ' ' if self.math.ends_with(|c: char| c.is_ascii_digit()) && after.starts_with(char::is_alphabetic) => {
                self.math += "\\,";
                after
            }
            ' ' => {
                if self.math.is_empty() { &mut self.out } else { &mut self.math }.push(c);
                after
            }
            _ => {
                match c {
                    '(' | '[' | '{' => self.depth += 1,
                    ')' | ']' | '}' => self.depth = self.depth.saturating_sub(1),
                    _ => {}
                }
                self.brace(c);
                // An accent belongs over a letter
                self.broken |= is_accent(c);
                self.push(&letter(c));
                after
            }
        }
    }

    /// Sets a function name, a word, or letters; a letter followed by digits is a constant: `C10`.
    fn letters<'a>(&mut self, rest: &'a str) -> &'a str {
        let (run, left) = rest.split_at(rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len()));
        if let Some((_, command)) = FUNCTIONS.iter().find(|(name, _)| *name == run) {
            self.push(command);
            return left;
        }
        if run.len() >= WORD && self.scripts.len() > 1 {
            self.push(&format!("\\mathrm{{{run}}}"));
            return left;
        }
        if run.len() >= WORD {
            self.end();
            self.out += run;
            return left;
        }
        let (digits, left) = left.split_at(left.find(|c: char| !c.is_ascii_digit()).unwrap_or(left.len()));
        self.push(run);
        self.script = (!digits.is_empty()).then(|| ('_', digits.into()));
        left
    }

    /// Appends to the formula.
    fn push(&mut self, set: &str) {
        self.math = joined(std::mem::take(&mut self.math), set);
    }

    /// Starts an exponent or an index.
    fn sign(&mut self, sign: char) {
        let own = self.scripts.last_mut().expect("one level");
        self.broken |= own.contains(sign);
        own.push(sign);
        self.push(&sign.to_string());
    }

    /// Opens or closes a level of braces, each with its own letters; the first level is never closed.
    fn brace(&mut self, c: char) {
        match c {
            '{' => self.scripts.push(String::new()),
            '}' if self.scripts.len() > 1 => _ = self.scripts.pop(),
            '}' => self.broken = true,
            _ => {}
        }
    }

    /// Sets the exponent or index that has ended.
    fn close(&mut self) {
        if let Some((sign, content)) = self.script.take() {
            self.sign(sign);
            self.push(&format!("{{{content}}}"));
        }
    }

    /// Ends the current formula; text follows.
    fn end(&mut self) {
        self.close();
        let math = self.math.trim_end();
        if !math.is_empty() {
            let blank = if self.math.ends_with(' ') { " " } else { "" };
            self.out += &format!("\\ensuremath{{{math}}}{blank}");
        }
        self.math.clear();
    }
}

/// Joins two parts of a formula; a space separates a command at the end of the first part from letters that follow.
fn joined(mut first: String, second: &str) -> String {
    let is_name = |name: &str| !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphabetic());
    let is_command = first.rsplit_once('\\').is_some_and(|(_, name)| is_name(name));
    if is_command && second.starts_with(|c: char| c.is_ascii_alphabetic()) {
        first.push(' ');
    }
    first + second
}

/// A character within a formula.
fn letter(c: char) -> String {
    match (c, command(c)) {
        ('{' | '}', _) => c.into(),
        ('Σ', _) => "\\sum".into(),
        (_, Some(Math(set) | Text(set))) => set.into(),
        (c, None) => escape(&c.to_string()),
    }
}

/// Sign and content of a raised or lowered character: `^` and `2` for `²`.
fn script(c: char) -> Option<(char, &'static str)> {
    let Some(Math(set)) = command(c) else { return None };
    let sign = set.chars().next().filter(|sign| matches!(sign, '^' | '_'))?;
    Some((sign, set[1..].strip_prefix('{')?.strip_suffix('}')?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{VolumetricKind, laws};

    #[test]
    fn formulae_have_commands_exponents_and_words() {
        for (text, tex) in [
            ("μ_n λ̄₁^{α_n}", "\\ensuremath{\\mu_{n} \\bar{\\lambda}_{1}^{\\alpha_{n}}}"),
            ("−½μJ_m ln(1 − Ī₁)", "\\ensuremath{-\\frac{1}{2}\\mu J_{m} \\ln(1 - \\bar{I}_{1})}"),
            ("C10 i + C01 ik", "\\ensuremath{C_{10} i + C_{01} ik}"),
            (
                "λ − λ⁻² uniaxial, tr²(RᵀF) planar",
                "\\ensuremath{\\lambda - \\lambda^{-2}} uniaxial, \\ensuremath{\\mathop{\\mathrm{tr}}\\nolimits^{2}(R^{T}F)} planar",
            ),
            ("Σ f(a, b)", "\\ensuremath{\\sum f(a, b)}"),
            ("μ = 4/3 μ_L", "\\ensuremath{\\mu = 4/3\\,\\mu_{L}}"),
        ] {
            assert_eq!(formula(text), tex);
        }
    }

    #[test]
    fn what_is_no_formula_is_text() {
        for text in ["a_b_c", "x²^{b}", "{a) , b}}", "{", "}{", "a^", "50 % of $x", "\\input{x}", "a_^b"] {
            assert_eq!(formula(text), escape(text));
        }
        assert_eq!(formula("e^{slow, t}"), "\\ensuremath{e^{\\mathrm{slow}, t}}");
    }

    #[test]
    fn no_formula_of_a_law_is_printed_as_it_is_read() {
        let of_fits = laws().into_iter().filter_map(|entry| Some(entry.fit.as_ref()?.formula));
        let all = laws().into_iter().map(|entry| entry.info.formula).chain(of_fits);
        for text in all.chain(VolumetricKind::ALL.map(VolumetricKind::formula)) {
            let tex = formula(text);
            let count = |c: char| tex.matches(c).count();
            assert!(tex.is_ascii() && count('{') == count('}'), "{tex}");
            assert!(!tex.contains("\\_") && !tex.contains("\\{") && !tex.contains("textascii"), "{tex}");
        }
    }
}
