//! Notes on the start of a contact, and on what the points of a rigid body do not see.

use crate::effect::contact::NormalForces;
use crate::effect::contact::surfaces::pressed::PressedSurfaces;
use crate::mesh::{Order, TetMesh};
use crate::scene::build::builder::Builder;
use crate::scene::build::shape::ShapeSpec;
use crate::scene::parts::contact::motion::start;
use crate::scene::parts::rigid::{RIM, RigidBody};
use crate::system::Caches;

/// Notes that the points of a contact with a barrier begin under pressure.
pub(super) fn note_start(builder: &mut Builder, pressing: &dyn NormalForces) {
    let start = start(builder);
    let (contact, reach) = (pressing.contact(), pressing.reach());
    let Some((_, gap)) = contact.deepest(&start).filter(|(_, gap)| *gap < reach) else { return };
    let presses = (0..contact.points.len()).flat_map(|b| pressing.normal_forces(&start, b));
    builder.notes.push(begins_within(&contact.name, [gap, reach], presses.map(|press| press.force).sum()));
}

/// Notes that deformable surfaces begin under pressure.
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

/// That a contact of this name has this gap in the reach of its barrier \[m\], and the force \[N\].
fn begins_within(name: &str, [gap, reach]: [f64; 2], force: f64) -> String {
    format!(
        "{name}: it starts within the reach of the barrier: gap {:.4} mm, distance {:.4} mm; it begins with a force of {force:.3e} N",
        gap * 1e3,
        reach * 1e3
    )
}

/// Distances between contact points below which a whole obstacle is seen too roughly: a ball as wide as this is pressed in by an eighth of its
/// width before three of them feel it.
const SEEN: f64 = 2.0;

/// Notes that an obstacle is narrow against the facets that press on it: between their points it meets nothing.
pub(super) fn note_facets(builder: &mut Builder, region: &str, facets: &[u32], pressing: &dyn NormalForces) {
    let contact = pressing.contact();
    let Some([low, high]) = contact.obstacle.shape.bounds() else { return };
    let mut widths = high - low;
    widths.as_mut_slice().sort_by(f64::total_cmp);
    let mesh = &builder.body.mesh;
    let parts = if mesh.order == Order::Quadratic { 2.0 } else { 1.0 };
    let spacing = longest_edge(mesh, facets) / parts;
    if widths[1] < SEEN * spacing {
        builder.notes.push(format!(
            "{}: the obstacle, {:.4} mm wide, is narrow against the distance of the contact points of {region}, {:.4} mm in the mean of its area: it sinks in between them \
             without a force; refine the mesh there",
            contact.name,
            widths[1] * 1e3,
            spacing * 1e3
        ));
    }
}

/// The longest edge of a facet in the mean over their area \[m\]: many small facets do not hide large ones.
fn longest_edge(mesh: &TetMesh, facets: &[u32]) -> f64 {
    let corner = |f: u32, k: usize| mesh.points[mesh.facet(f as usize)[k % 3] as usize];
    let longest = |f: u32| (0..3).map(|k| (corner(f, k + 1) - corner(f, k)).norm()).fold(0.0, f64::max);
    let (sum, area) = facets.iter().fold((0.0, 0.0), |(sum, all), &f| {
        let area = mesh.facet_area(f as usize);
        (sum + area * longest(f), all + area)
    });
    sum / area
}

/// Notes that an obstacle is so narrow that it may come between the points of a body, and that a flat cylinder does not roll as a round one.
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
    // An obstacle that is wider in two directions has a face for the points.
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
