//! Notes on the start of a contact, and on obstacles that the points of a rigid body do not resolve.

use crate::effect::contact::NormalForces;
use crate::effect::contact::surfaces::pressed::PressedSurfaces;
use crate::math::tensor::Vec3;
use crate::mesh::{Order, TetMesh};
use crate::scene::build::builder::Builder;
use crate::scene::build::shape::ShapeSpec;
use crate::scene::parts::contact::motion::start;
use crate::scene::parts::rigid::{RIM, RigidBody};
use crate::system::Caches;

/// Adds a note if the points of a contact with a barrier start under pressure.
pub(super) fn note_start(builder: &mut Builder, pressing: &dyn NormalForces) {
    let start = start(builder);
    let (contact, reach) = (pressing.contact(), pressing.reach());
    let Some((_, gap)) = contact.deepest(&start).filter(|(_, gap)| *gap < reach) else { return };
    let presses = (0..contact.points.len()).flat_map(|b| pressing.normal_forces(&start, b));
    builder.notes.push(begins_within(&contact.name, [gap, reach], presses.map(|press| press.force).sum()));
}

/// Adds a note if deformable surfaces start under pressure.
pub(super) fn note_start_of_surfaces(builder: &mut Builder, pressing: &PressedSurfaces, reach: f64) {
    let start = start(builder);
    let surfaces = &pressing.surfaces;
    let gap = surfaces.gap(&start);
    if gap < reach {
        let terms = surfaces.terms(&start, &mut Caches::default());
        let presses = terms.iter().filter_map(|term| pressing.normal_force(&start, term));
        let force = presses.map(|press| press.force).sum();
        builder.notes.push(begins_within(&surfaces.name, [gap, reach], force));
    }
}

/// The note that a contact starts with a gap \[m\] that is within the reach of its barrier \[m\], with a force \[N\].
fn begins_within(name: &str, [gap, reach]: [f64; 2], force: f64) -> String {
    format!(
        "{name}: it starts within the reach of the barrier: gap {:.4} mm, distance {:.4} mm; it begins with a force of {force:.3e} N",
        gap * 1e3,
        reach * 1e3
    )
}

/// Smallest ratio of the width of an obstacle to the distance of contact points that resolve it: a ball as wide as this distance is pressed in by an eighth of
/// its width before it presses on three points.
const SEEN: f64 = 2.0;

/// Depth, relative to the width of an obstacle, to which it is pressed in to find the facets that it then reaches \[–\].
const PRESSED_IN: f64 = 0.125;

/// Adds a note if an obstacle is narrow compared with the nearest facets: between their points there is no contact.
pub(super) fn note_facets(builder: &mut Builder, region: &str, facets: &[u32], pressing: &dyn NormalForces) {
    let contact = pressing.contact();
    let Some([low, high]) = contact.obstacle.shape.bounds() else { return };
    let mut widths = high - low;
    widths.as_mut_slice().sort_by(f64::total_cmp);
    let mesh = &builder.body.mesh;
    let parts = if mesh.order == Order::Quadratic { 2.0 } else { 1.0 };
    let is_seen = |spacing: f64| widths[1] >= SEEN * spacing / parts;
    if is_seen(facets.iter().map(|&f| longest_edge(mesh, f)).fold(0.0, f64::max)) {
        return;
    }
    let nearest = nearest(mesh, facets, contact.distance(&start(builder)), PRESSED_IN * widths[1]);
    let spacing = mean_edge(mesh, &nearest);
    if !is_seen(spacing) {
        builder.notes.push(format!(
            "{}: the obstacle, {:.4} mm wide, is narrow against the distance of the contact points of {region}, {:.4} mm in the mean of the area that is nearest to it: it sinks in \
             between them without a force; refine the mesh there",
            contact.name,
            widths[1] * 1e3,
            spacing / parts * 1e3
        ));
    }
}

/// The facets whose distance from an obstacle exceeds that of the nearest facet by at most `farther` \[m\], measured at their corners and the centroids of
/// their edges and of the facet.
fn nearest(mesh: &TetMesh, facets: &[u32], distance: impl Fn(&Vec3) -> f64, farther: f64) -> Vec<u32> {
    let gap = |&f: &u32| {
        let [a, b, c] = corners(mesh, f);
        let places = [a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0];
        places.iter().map(&distance).fold(f64::INFINITY, f64::min)
    };
    let gaps: Vec<f64> = facets.iter().map(gap).collect();
    let least = gaps.iter().copied().fold(f64::INFINITY, f64::min);
    facets.iter().zip(gaps).filter(|(_, gap)| *gap <= least + farther).map(|(&f, _)| f).collect()
}

/// The longest edge of a facet, averaged over the area of the facets \[m\]: many small facets do not hide large ones.
fn mean_edge(mesh: &TetMesh, facets: &[u32]) -> f64 {
    let (sum, area) = facets.iter().fold((0.0, 0.0), |(sum, all), &f| {
        let area = mesh.facet_area(f as usize);
        (sum + area * longest_edge(mesh, f), all + area)
    });
    sum / area
}

/// The longest edge of a facet \[m\].
fn longest_edge(mesh: &TetMesh, facet: u32) -> f64 {
    let [a, b, c] = corners(mesh, facet);
    (b - a).norm().max((c - b).norm()).max((a - c).norm())
}

fn corners(mesh: &TetMesh, facet: u32) -> [Vec3; 3] {
    [0, 1, 2].map(|k| mesh.points[mesh.facet(facet as usize)[k] as usize])
}

/// Adds a note if an obstacle is so narrow that it can pass between the points of a body, and one if a flat cylinder does not roll as a round one.
pub(super) fn note_points(builder: &mut Builder, body: &RigidBody, pressing: &dyn NormalForces) {
    let contact = pressing.contact();
    if matches!(body.shape, ShapeSpec::Cylinder { .. }) && !body.has_balls() {
        builder.notes.push(format!(
            "{}: the cylinder {} is shorter than it is wide, and each of its rims is {RIM} points: on its side it rolls as a prism, which loses energy",
            contact.name, body.name
        ));
    }
    let Some([low, high]) = contact.obstacle.shape.bounds() else { return };
    let mut widths = high - low;
    widths.as_mut_slice().sort_by(f64::total_cmp);
    // An obstacle that is wider in two directions offers a face to the points.
    if widths[1] < body.spacing {
        builder.notes.push(format!(
            "{}: the obstacle, {:.4} mm wide, fits between the contact points of {}, which are up to {:.4} mm apart: it may pass through the body",
            contact.name,
            widths[1] * 1e3,
            body.name,
            body.spacing * 1e3
        ));
    }
}
