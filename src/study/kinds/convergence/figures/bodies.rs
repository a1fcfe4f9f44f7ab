//! The meshes side by side, and the body at the peak of the protocol.

use crate::math::tensor::Vec3;
use crate::report::canvas::{At, INK, LABEL, PALETTE, RGB, figure, italic, line, mm, page_height, page_width, text};
use crate::report::color_bar::color_bar;
use crate::report::figure::Figure;
use crate::report::measure::shortened;
use crate::report::numbers::{percent, thousands};
use crate::report::panels::{heading, letter};
use crate::report::plot::Axis;
use crate::report::surface::{Fit, Look, View, extent, ghost, surface, viridis};
use crate::study::kinds::convergence::findings::ConvergenceFindings;
use crate::study::store::record::{CaseRecord, Role};
use crate::study::store::results::Results;
use crate::study::store::skin::Skin;

/// Direction of view for the meshes: from the front, slightly towards the tip and from above.
const MESH_EYE: [f64; 3] = [0.55, -1.0, 0.45];
/// Direction of view for the bent body: almost along the axis of bending, so that the angle is visible.
const BENT_EYE: [f64; 3] = [0.18, -1.0, 0.22];
/// Largest height of a drawn body \[mm\]; a slender upright one is drawn smaller.
const TALLEST: f64 = 110.0;
/// Height that every mesh is given at least \[mm\]
const LEAST: f64 = 15.0;
const BODY: RGB = RGB(0xdd, 0xe6, 0xee);
const EDGE: RGB = RGB(0x33, 0x44, 0x55);
/// Colour of rigid bodies and obstacles
const RIGID: RGB = RGB(0xe8, 0xd9, 0xc0);

/// Draws the surfaces of the sizes at rest, coarsest first.
pub fn meshes(store: &Results) -> Option<Figure> {
    let family = store.study.families.iter().find(|f| f.role == Role::Sizes)?;
    let mut shown: Vec<(&CaseRecord, &Skin)> = vec![];
    for c in store.cases.iter().map(|c| &c.record).filter(|r| family.cases.contains(&r.id)) {
        if let Some(skin) = store.skins.get(&c.id).filter(|_| shown.iter().all(|(r, _)| r.mesh.cells != c.mesh.cells)) {
            shown.push((c, skin));
        }
    }
    shown.sort_by_key(|(r, _)| r.mesh.cells);
    let view = View::from(MESH_EYE);
    let from = extent(shown.iter().flat_map(|(_, s)| &s.points).map(|x| view.project(*x)));
    if shown.is_empty() || !from.iter().all(|v| v.is_finite()) {
        return None;
    }
    let (gap, head) = (6.0, 5.5);
    // A page has no room for more rows
    let most = (page_height() / (LEAST + head + 3.0)).floor().max(1.0) as usize;
    let columns = shown.len().div_ceil(most).max(2.min(shown.len()));
    let wide = (page_width() - gap * (columns as f64 - 1.0) - 2.0) / columns as f64;
    let rows = shown.len().div_ceil(columns);
    let room = (page_height() / rows as f64 - head - 3.0).min(TALLEST);
    let tall = (wide * (from[3] - from[1]) / (from[2] - from[0])).min(room);
    let height = rows as f64 * (tall + head + 3.0);
    let corner = |k: usize| {
        let (i, j) = (k % columns, k / columns);
        (1.0 + i as f64 * (wide + gap), j as f64 * (tall + head + 3.0))
    };
    let mut under = String::new();
    for (k, (_, skin)) in shown.iter().enumerate() {
        let (x, y) = corner(k);
        let fit = Fit::new(from, [mm(x), mm(y + head), mm(x + wide), mm(y + head + tall)]);
        let look = Look { color: &|_| BODY, edge: Some((EDGE, 2.0)), outline: None, shade: 0.8 };
        under += &surface(&skin.points, &skin.facets(), &view, &fit, &look);
    }
    let svg = figure(page_width(), height, &under, |area| {
        for (k, (r, _)) in shown.iter().enumerate() {
            let (x, y) = corner(k);
            let cells = thousands(r.mesh.cells);
            let words = format!("{cells} cells, {} = {:.2} mm", italic("h"), 1e3 * r.mesh.h_m);
            let words = shortened(&heading(letter(k, shown.len()), &words), LABEL, mm(wide));
            text(area, &words, (mm(x), mm(y + 3.0)), At::Left, LABEL, INK);
        }
    });
    let caption = format!("Meshes of family {} in the reference state.", family.name);
    Some(Figure { name: "meshes".into(), svg, caption })
}

/// Draws the recommended case at its peak, or the finest of the sizes.
pub fn bent(store: &Results, analysis: &ConvergenceFindings) -> Option<Figure> {
    let record = |id: &str| store.cases.iter().map(|c| &c.record).find(|r| r.id == id);
    let chosen = analysis.recommended.as_ref().and_then(|r| Some((record(&r.case)?, store.skins.get(&r.case)?)));
    let sizes = store.study.families.iter().find(|f| f.role == Role::Sizes);
    let finest = || {
        let ids = sizes.iter().flat_map(|f| &f.cases).chain(store.skins.keys());
        let all = ids.filter_map(|id| Some((record(id)?, store.skins.get(id)?)));
        all.max_by_key(|(r, _)| (sizes.is_some_and(|f| f.cases.contains(&r.id)), r.mesh.cells))
    };
    let (r, skin) = chosen.or_else(finest)?;
    let view = View::from(BENT_EYE);
    let moved: Vec<[f64; 3]> =
        (skin.points.iter().zip(&skin.displacement)).map(|(x, u)| std::array::from_fn(|k| x[k] + u[k])).collect();
    let cable = skin.cables.iter().flatten();
    let rigid = skin.rigids.iter().flat_map(|r| &r.points);
    let from = extent(skin.points.iter().chain(&moved).chain(cable).chain(rigid).map(|x| view.project(*x)));
    let bar = 20.0;
    let wide = 104.0_f64.min(page_width() - bar - 6.0);
    let tall = (wide * (from[3] - from[1]) / (from[2] - from[0])).min(TALLEST);
    if !tall.is_finite() || skin.triangles.is_empty() {
        return None;
    }
    let fit = Fit::new(from, [mm(2.0), mm(2.0), mm(2.0 + wide), mm(2.0 + tall)]);
    // The scale leaves out the top two per cent of the nodes, so that a notch corner does not take all of it
    let mut sorted: Vec<f64> = skin.stretch.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let top = sorted.get(sorted.len() * 98 / 100).copied().unwrap_or(2.0).max(1.001);
    let value = |k: usize| skin.triangles[k].iter().map(|i| skin.stretch[*i as usize]).sum::<f64>() / 3.0;
    let color = |k: usize| viridis((value(k) - 1.0) / (top - 1.0));
    let (grey, pale, dark) = (RGB(0xb4, 0xb4, 0xb4), RGB(0xf6, 0xf6, 0xf6), RGB(0x30, 0x30, 0x30));
    let mut under = ghost(&skin.points, &skin.facets(), &view, &fit, (grey, pale), "rest");
    for r in &skin.rigids {
        let look = Look { color: &|_| RIGID, edge: None, outline: Some((dark, 6.0)), shade: 0.8 };
        under += &surface(&r.points, &r.triangles, &view, &fit, &look);
    }
    let look = Look { color: &color, edge: None, outline: Some((dark, 6.0)), shade: 0.45 };
    under += &surface(&moved, &skin.facets(), &view, &fit, &look);
    let total = tall.max(40.0) + 4.0;
    let svg = figure(wide + bar + 6.0, total, &under, |area| {
        for polyline in &skin.cables {
            let path: Vec<_> = polyline.iter().map(|x| fit.at(view.project(*x))).collect();
            line(area, &path, RGB(255, 255, 255), 22);
            line(area, &path, PALETTE[1], 12);
        }
        let tall = (total - 16.0).min(50.0);
        let span = (0.5 * (total - tall) + 2.0, 0.5 * (total + tall) + 2.0);
        let at = (mm(wide + 5.0), mm(span.0 - 3.5));
        text(area, &format!("{}₁ [–]", italic("λ")), at, At::Left, LABEL, INK);
        color_bar(area, wide + 5.0, span, &Axis::exact(1.0, top, ""));
    });
    let clipped = above(skin, value, top).map_or(String::new(), |(share, largest)| {
        format!(" ({} of the surface is above {top:.2}, up to {largest:.2})", percent(share))
    });
    let cables = match skin.cables.len() {
        0 => "",
        1 => " cable in orange,",
        _ => " cables in orange,",
    };
    let rigid = if skin.rigids.is_empty() { "" } else { " rigid bodies behind in beige," };
    let caption = format!(
        "Case {} at t = {:.2} s: largest principal stretch λ₁{clipped},{cables}{rigid} reference outline in grey.",
        r.id, skin.t_s
    );
    Some(Figure { name: "bent".into(), svg, caption })
}

/// Share of the surface at rest whose facets have a value beyond the end of the scale, and the largest value; `None` if that is within a hundredth of
/// the end.
fn above(skin: &Skin, value: impl Fn(usize) -> f64, top: f64) -> Option<(f64, f64)> {
    let area = |k: usize| {
        let [a, b, c] = skin.triangles[k].map(|i| Vec3::from(skin.points[i as usize]));
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    let all = 0..skin.triangles.len();
    let beyond = || all.clone().filter(|k| value(*k) > top);
    let largest = beyond().map(&value).reduce(f64::max).filter(|most| *most > 1.01 * top)?;
    let [beyond, all] = [beyond().map(area).sum::<f64>(), all.clone().map(area).sum()];
    Some((beyond / all, largest))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of four facets, of which the smallest has an eighth of the area and the only value beyond the scale: the share is by area, not by
    /// number of nodes.
    #[test]
    fn the_share_beyond_the_scale_is_one_of_the_surface() {
        let skin = Skin {
            points: vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.25, 0.0]],
            triangles: vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
            middles: vec![],
            t_s: 0.0,
            displacement: vec![[0.0; 3]; 5],
            stretch: vec![1.0; 5],
            cables: vec![],
            rigids: vec![],
        };
        let value = |k: usize| if k == 0 { 1.5 } else { 1.0 };
        assert_eq!(above(&skin, value, 1.2), Some((0.125, 1.5)));
        assert_eq!(above(&skin, value, 1.495), None);
    }
}
