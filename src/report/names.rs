//! Names as written in a paper.

use crate::math::units;
use crate::{material, solve};

/// Returns a law, an integrator, an element or another word of a file as written in a paper: `Neo-Hookean`, `implicit Euler`, `tet10 mixed`; other
/// names get spaces, and a quantity one before its unit.
pub fn title(name: &str) -> String {
    without_law(name).unwrap_or_else(|| material::title(name))
}

/// Returns the name of a family of cases for figures, tables and verdicts: the title of the integrator or element that it is named after, or its name
/// with spaces; never the title of a law, because its scenes state their law.
pub fn family(name: &str) -> String {
    without_law(name).unwrap_or_else(|| name.replace('_', " "))
}

fn without_law(name: &str) -> Option<String> {
    let known = solve::integrator_title(name).or_else(|| element_title(name)).map(String::from);
    known.or_else(|| units::spaced(name))
}

/// Returns the symbol of a constant by its key in files: `mu` is μ, `tau1` is τ₁, `C10` is C₁₀; other names and symbols are unchanged.
pub fn symbol(key: &str) -> String {
    const GREEK: [(&str, &str); 7] =
        [("alpha", "α"), ("beta", "β"), ("kappa", "κ"), ("mu", "μ"), ("nu", "ν"), ("rho", "ρ"), ("tau", "τ")];
    let word = key.trim_end_matches(|c: char| c.is_ascii_digit());
    let letter = GREEK.iter().find(|(name, _)| *name == word).map_or(word, |(_, letter)| letter);
    if letter.chars().count() != 1 {
        return key.into();
    }
    let below = key[word.len()..].bytes().map(|b| char::from_u32(0x2080 + u32::from(b - b'0')).unwrap_or('₀'));
    letter.chars().chain(below).collect()
}

/// Names a constant of a law by its key in a scene: `laws.rubber.mu` is μ of rubber; other keys are unchanged.
pub fn constant(key: &str) -> String {
    match key.strip_prefix("laws.").and_then(|rest| rest.split_once('.')) {
        Some((law, name)) => format!("{} of {}", symbol(name), law.replace('_', " ")),
        None => key.into(),
    }
}

/// Returns a label followed by `shown`, the printed form of its symbol; a label that begins with the symbol is unchanged: `x of m1`.
pub fn with_symbol(label: &str, symbol: &str, shown: &str) -> String {
    if label.split_whitespace().next() == Some(symbol) { label.into() } else { format!("{label} {shown}") }
}

fn element_title(name: &str) -> Option<&'static str> {
    match name {
        "tet4_up" => Some("tet4 mixed"),
        "tet10_up" => Some("tet10 mixed"),
        "tet10_p0" => Some("tet10 mean dilatation"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::Integrator;

    #[test]
    fn keys_of_constants_have_symbols() {
        let keys = ["mu", "tau1", "C10", "kappa", "g2", "r", "J_m", "μ₁", "alpha12", "set"];
        assert_eq!(keys.map(symbol), ["μ", "τ₁", "C₁₀", "κ", "g₂", "r", "J_m", "μ₁", "α₁₂", "set"]);
        assert_eq!(constant("laws.soft_rubber.mu"), "μ of soft rubber");
        assert_eq!(constant("stage.0.dt"), "stage.0.dt");
    }

    #[test]
    fn a_symbol_is_written_once() {
        let labels = [("x of m1", "x"), ("cable tension", "T"), ("xylem height", "x")];
        let shown = ["x of m1", "cable tension T", "xylem height x"];
        assert_eq!(labels.map(|(label, symbol)| with_symbol(label, symbol, symbol)), shown);
    }

    #[test]
    fn a_family_has_no_title_of_a_law() {
        let names = ["linear", "ogden", "neo_hookean", "tet10_up", "generalised_alpha", "one_length"];
        let shown = ["linear", "ogden", "neo hookean", "tet10 mixed", "generalised-α", "one length"];
        assert_eq!(names.map(family), shown);
    }

    #[test]
    fn every_integrator_has_a_title() {
        let all = [
            Integrator::Static,
            Integrator::ArcLength { max_steps: 1 },
            Integrator::ImplicitEuler { linearised: false },
            Integrator::ImplicitEuler { linearised: true },
            Integrator::Bdf2,
        ];
        let titles = all.map(|i| title(i.name()));
        assert_eq!(titles, ["static", "arc length", "implicit Euler", "implicit Euler (linearised)", "BDF2"]);
        assert_eq!(title("generalised_alpha"), "generalised-α");
        assert_eq!(title("neo_hookean"), "Neo-Hookean");
        assert_eq!(title("tet10_up"), "tet10 mixed");
        assert_eq!(title("a_word"), "a word");
        assert_eq!(["65mm", "0.5 kPa", "2x", "n4", "3d_body"].map(title), ["65 mm", "0.5 kPa", "2x", "n4", "3d body"]);
    }
}
