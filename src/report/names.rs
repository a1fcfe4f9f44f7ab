//! Names as a paper writes them.

use crate::{material, solve};

/// A law, an integrator, an element or another word of a file as a paper writes it: `Neo-Hookean`, `implicit Euler`, `tet10 mixed`; a name
/// without one has blanks.
pub fn title(name: &str) -> String {
    let known = solve::integrator_title(name).or_else(|| element_title(name));
    known.map_or_else(|| material::title(name), String::from)
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
    }
}
