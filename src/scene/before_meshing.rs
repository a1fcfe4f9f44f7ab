//! The laws that the effects of a scene use, before there is a mesh.

use super::error::{SceneError, part};
use super::spec::SceneSpec;
use crate::material;
use std::path::Path;

/// Refuses a scene with an effect whose law has constants without a meaning. `text` is the scene as it was read.
pub fn check_laws(file: &Path, spec: &SceneSpec, text: &str) -> Result<(), SceneError> {
    // A text that is no scene in TOML is that of a caller, who gives the specification
    let scene: toml::Table = text.parse().unwrap_or_default();
    let effects = scene.get("effect").and_then(toml::Value::as_array).into_iter().flatten();
    for name in effects.filter_map(|effect| effect.get("law")?.as_str()) {
        if let Some(table) = spec.laws.get(name) {
            material::law_from_table(table).map_err(|e| part(file, format!("laws.{name}"), e))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::read::from_text;

    /// A law that no effect uses may be wrong, as in a file of laws that several scenes include.
    #[test]
    fn laws_in_use_are_checked_without_a_mesh() {
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
        let check = |text: &str| check_laws(file, &from_text(file, text, "").expect("a scene"), text);
        assert!(check(&text("good")).is_ok());
        let why = check(&text("bad")).expect_err("a negative modulus").to_string();
        assert!(why.contains("laws.bad") && why.contains('E'), "{why}");
    }
}
