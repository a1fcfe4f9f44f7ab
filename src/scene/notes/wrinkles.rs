//! Membranes of a scene that wrinkle, or are close to it, at a state.

use crate::effect::wrinkling::{Wrinkling, wrinkling};
use crate::math::units::Decimals;
use crate::scene::build::Scene;
use crate::system::Effect;

/// Ratio h*/h from which a membrane is close to wrinkling: meshes with a quarter of the facet size would show it \[–\].
const CLOSE: f64 = 0.25;

fn wrinkles<'a>(scene: &'a Scene, x: &'a [f64]) -> impl Iterator<Item = (&'a str, Wrinkling)> {
    let bodies: Vec<_> = scene.stressed.iter().map(|effect| &**effect).collect();
    let each = move |sheet| Some((Effect::name(sheet), wrinkling(sheet, &bodies, x)?));
    scene.membranes.iter().map(|sheet| &**sheet).filter_map(each)
}

/// A note for each membrane of a scene that wrinkles, or is close to it, at displacement x.
pub fn wrinkle_notes(scene: &Scene, x: &[f64]) -> Vec<String> {
    let close = wrinkles(scene, x).filter(|(_, found)| found.ratio >= CLOSE);
    let words = |(name, Wrinkling { ratio, size, share }): (&str, Wrinkling)| {
        let size = Decimals(size * 1e3);
        let remedy = "give it the thickness of cells, which do bend, or keep it in tension";
        if ratio > 1.0 {
            let share = Decimals(share * 100.0);
            return format!(
                "{name}: compressed so that it wrinkles from facet to facet on {share:.1} % of its area, where facets are smaller than up to {size:.4} mm; such \
                 an answer depends on the mesh: {remedy}"
            );
        }
        format!(
            "{name}: compressed so that it wrinkles where facets are smaller than {size:.4} mm; on such meshes {remedy}"
        )
    };
    close.map(words).collect()
}

/// The reason why a solution of a scene with displacement x has no limit as h → 0: a property of the scene, or a membrane that wrinkles.
pub fn no_limit_at(scene: &Scene, x: &[f64]) -> Option<String> {
    let wrinkled = wrinkles(scene, x).filter(|(_, found)| found.ratio > 1.0);
    let wrinkled = wrinkled.map(|(name, _)| format!("the sheet {name} wrinkles at the size of its facets"));
    let causes: Vec<String> = scene.no_limit.iter().cloned().chain(wrinkled).collect();
    (!causes.is_empty()).then(|| causes.join(", "))
}
