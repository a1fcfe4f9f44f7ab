//! Checks of the balls through which cables and forces act on a body.

use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::Decimals;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::wording::few;

/// Refuses a radius \[m\] that is not positive, or that is larger than the body; `key`: its name in the file.
pub(super) fn check_radius(builder: &Builder, place: &str, key: &str, radius: f64) -> Result<(), SceneError> {
    let fact = format!("{key} is {} mm", radius * 1e3);
    if radius <= 0.0 {
        return Err(builder.content(place, fact, "give a positive length, at least the size of a cell"));
    }
    let diagonal = builder.body.mesh.diagonal();
    if radius > diagonal {
        let fact = format!("{fact}, and the body is {:.4} mm from corner to corner", Decimals(diagonal * 1e3));
        return Err(builder.content(place, fact, "it would be the mean of the whole body; check the unit"));
    }
    Ok(())
}

/// Adds a note on a radius \[m\] below the cell size, and on one above half of the middle extent of the body; `what`: a name for it, such as `the guide
/// radius`.
pub(super) fn note_radius(builder: &mut Builder, name: &str, what: &str, radius: f64) {
    let (radius, h) = (radius * 1e3, builder.body.mesh.h() * 1e3);
    let (low, high) = builder.body.mesh.bounding_box();
    let mut sizes: [f64; 3] = (1e3 * (high - low)).into();
    sizes.sort_by(f64::total_cmp);
    let half = 0.5 * sizes[1];
    if radius < h {
        builder.notes.push(format!("{name}: {what} {radius:.3} mm is below h = {h:.3} mm"));
    } else if radius > half {
        builder.notes.push(format!(
            "{name}: {what} {radius:.3} mm is above half of the width of the body, {half:.3} mm: it acts on whole sections, and less sharply than a place on the surface"
        ));
    }
}

/// Adds a note on balls of a radius \[m\] that are cut by a plane on which only one component is held, as in a model of one half; `key`: the name of the
/// radius in the file, `balls`: names and centres.
pub(super) fn note_cut(builder: &mut Builder, name: &str, key: &str, radius: f64, balls: &[(String, Vec3)]) {
    let cut = |(ball, at): &(String, Vec3)| Some(format!("{ball} by {}", held_plane(builder, *at, radius)?));
    let cut: Vec<String> = balls.iter().filter_map(cut).collect();
    if !cut.is_empty() {
        builder.notes.push(format!(
            "{name}: patches that are cut by a plane on which one component is held: {}; their weights are not those of half of a whole patch, and where this is a plane of \
             symmetry, forces differ from half of those of the whole body, by about a tenth; with {key} = \"point\" they are half: take it in both, or model it whole",
            few(&cut)
        ));
    }
}

/// A description of the plane on which only the normal component is held, if the ball reaches it.
fn held_plane(builder: &Builder, at: Vec3, radius: f64) -> Option<String> {
    let mesh = &builder.body.mesh;
    let patch = builder.body.patches.weights(mesh, at, radius).ok()?;
    let place = |node: u32| mesh.points[node as usize];
    let extent = |nodes: &[u32], d: usize| {
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        nodes.iter().fold(start, |(low, high), &i| (low.min(place(i)[d]), high.max(place(i)[d])))
    };
    let nodes: Vec<u32> = patch.iter().map(|(node, _)| *node).collect();
    let slack = 1e-9 * mesh.diagonal();
    let is_held = |node: u32, d: usize| builder.motion(3 * node + d as u32) == Some(&Signal::Constant(0.0));
    let is_plane = |d: usize, p: f64| {
        let on: Vec<u32> = nodes.iter().copied().filter(|&i| (place(i)[d] - p).abs() <= slack).collect();
        let (e, f) = ((d + 1) % 3, (d + 2) % 3);
        let spread = |d: usize| extent(&on, d).1 - extent(&on, d).0 > slack;
        let is_free = |&i: &u32| [e, f].iter().all(|&other| builder.motion(3 * i + other as u32).is_none());
        spread(e) && spread(f) && on.iter().all(|&i| is_held(i, d)) && on.iter().any(is_free)
    };
    let ends = (0..3).flat_map(|d| [(d, extent(&nodes, d).0), (d, extent(&nodes, d).1)]);
    let mut near = ends.filter(|&(d, p)| (p - at[d]).abs() < radius);
    let (d, p) = near.find(|&(d, p)| is_plane(d, p))?;
    Some(format!("{} = {:.4} mm", ["x", "y", "z"][d], Decimals(p * 1e3)))
}
