//! Mistakes in a scene that can be found without a mesh: in its stages and settings, in combinations of its parts, and in the laws of its effects.

use super::rules;
use crate::scene::error::{SceneError, content, hint, part};
use crate::scene::numerics::check_numerics;
use crate::scene::record::output::check_output;
use crate::scene::spec::SceneSpec;
use crate::scene::stages::build_spans;
use std::path::Path;

/// All such mistakes of a scene that was read from `file`.
pub fn mistakes_before_meshing(file: &Path, spec: &SceneSpec) -> Vec<SceneError> {
    let mut found: Vec<SceneError> = of_laws(file, spec);
    found.extend(check_numerics(file, &spec.numerics).err());
    match build_spans(file, &spec.stages) {
        Ok(spans) => {
            found.extend(rules::check(file, spec, &spans).err());
            found.extend(check_output(file, &spans, &spec.output).err());
        }
        Err(mistake) => found.push(mistake),
    }
    found
}

/// Mistakes in the laws in use. A law that no effect uses may be wrong, for example in a file of laws that several scenes include.
fn of_laws(file: &Path, spec: &SceneSpec) -> Vec<SceneError> {
    let known: Vec<&String> = spec.laws.keys().collect();
    let mistake = |name: &str| {
        let place = format!("laws.{name}");
        match spec.laws.get(name) {
            Some(table) => spec.known_laws.law(table).err().map(|e| part(file, place, e)),
            None => {
                Some(content(file, &place, "an effect takes this law, and there is no such table", hint(name, &known)))
            }
        }
    };
    spec.laws_in_use().into_iter().filter_map(mistake).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::read::from_text;

    #[test]
    fn mistakes_are_found_together_without_a_mesh() {
        let text = |used: &str| {
            format!(
                "[mesh]\ngrid = {{ kind = 'box', size = ['20 mm', '10 mm', '10 mm'], divisions = [2, 1, 1] }}\n\
                 [laws.good]\nlaw = 'neo_hookean'\nE = '100 kPa'\nnu = 0.3\n\
                 [laws.bad]\nlaw = 'neo_hookean'\nE = '-100 kPa'\nnu = 0.3\n\
                 [[effect]]\nkind = 'elastic'\nregion = 'body'\nlaw = '{used}'\n\
                 [[stage]]\nintegrator = 'static'\nduration = '1 s'\ndt = '1 s'\n"
            )
        };
        let file = Path::new("scene.toml");
        let check = |text: &str| -> Vec<String> {
            let spec = from_text(file, text, "").expect("a scene");
            mistakes_before_meshing(file, &spec).iter().map(ToString::to_string).collect()
        };
        assert_eq!(check(&text("good")), [""; 0]);
        let why = check(&text("bad"));
        assert!(matches!(&why[..], [why] if why.contains("laws.bad") && why.contains('E')), "{why:?}");
        let why = check(&text("god"));
        assert!(
            matches!(&why[..], [why] if why.contains("laws.god") && why.contains("did you mean `good`")),
            "{why:?}"
        );
        // All mistakes at once: in the law, the settings, the combination of stage and effect, and the output
        let worse = text("bad")
            + "[[effect]]\nkind = 'gravity'\nregion = 'body'\ndensity = '1 g/cm^3'\ndirection = [0, 0, -1]\n\
               acceleration = { kind = 'ramp', from = '0 m/s^2', to = '9 m/s^2', end = '1 s' }\n\
               [[effect]]\nkind = 'inertia'\nregion = 'body'\ndensity = '1 g/cm^3'\nmass = 'lumped'\n\
               [numerics]\ncuts = 1000\n[output.series]\ntimes = ['2 s']\n";
        let why = check(&worse);
        for (why, place) in why.iter().zip(["laws.bad", "numerics: cuts", "inertia", "output.series"]) {
            assert!(why.contains(place), "{why}");
        }
        assert_eq!(why.len(), 4, "{why:?}");
        let why = check(&text("good").replace("dt = '1 s'", "dt = '-1 s'"));
        assert!(matches!(&why[..], [why] if why.contains("stage 1: dt = -1 s")), "{why:?}");
    }
}
