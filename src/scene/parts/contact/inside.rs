//! Bodies and obstacles that overlap at the start between the contact points, at which alone contact acts.

use super::sunk::PressingFacets;
use crate::effect::contact::Contact;
use crate::effect::contact::shape::Shape;
use crate::math::tensor::Vec3;
use crate::mesh::boundary::boundary_facets;
use crate::mesh::error::point;
use crate::mesh::flat::flat_triangles;
use crate::mesh::surface_file::Surface;
use crate::scene::build::builder::Builder;
use crate::scene::build::shape::ShapeSpec;
use crate::scene::error::SceneError;
use crate::scene::parts::contact::motion::start;
use crate::scene::parts::rigid::RigidBody;

/// Overlap of surfaces in contact, relative to the diagonal of the mesh, that counts as rounding \[–\].
const ROUNDING: f64 = 1e-9;
/// Overlap of a ball with a rigid surface that it fits, relative to the distance of the vertices of the surface \[–\].
const HOLLOW: f64 = 0.125;

/// Refuses an obstacle that starts inside the rigid body whose points are in contact with it.
pub(super) fn check_rigid(
    builder: &Builder,
    place: &str,
    contact: &Contact,
    body: &RigidBody,
) -> Result<(), SceneError> {
    let (shape, origin, axes) = builder.shape(place, &body.shape)?;
    let most = match body.shape {
        ShapeSpec::Surface { .. } => HOLLOW * body.spacing,
        _ => ROUNDING * builder.body.mesh.diagonal(),
    };
    let gap = |at: &Vec3| shape.gap(&axes.tr_mul(&(at - origin)));
    let inside = deepest(contact.obstacle.places(&start(builder)), gap).filter(|(_, depth)| *depth > most);
    refuse(builder, place, inside, &format!("of \"{}\"", body.name))
}

/// Refuses an obstacle that starts inside the deformable body, deeper than its contact points allow, and facets that start inside the obstacle.
pub(super) fn check_deformable(
    builder: &Builder,
    place: &str,
    contact: &Contact,
    facets: &PressingFacets,
) -> Result<(), SceneError> {
    let (mesh, start) = (&builder.body.mesh, start(builder));
    if let Some((at, depth)) = facets.deepest(mesh, contact, &start) {
        let fact = format!(
            "a facet is {:.4} mm inside of the obstacle at {}, between contact points that are not",
            depth * 1e3,
            point(&at)
        );
        return Err(builder.content(place, fact, "move one of the two apart, or refine the mesh there"));
    }
    let (low, high) = mesh.bounding_box();
    let mut places = contact.obstacle.places(&start);
    places.retain(|at| (0..3).all(|i| low[i] < at[i] && at[i] < high[i]));
    if places.is_empty() {
        return Ok(());
    }
    let boundary = Surface { points: mesh.points.clone(), triangles: flat_triangles(mesh, &boundary_facets(mesh)) };
    // If more than two facets share an edge, the inside is not defined.
    let Ok(boundary) = Shape::surface(&boundary) else { return Ok(()) };
    let inside = deepest(places, |at| boundary.gap(at)).filter(|(_, depth)| *depth > facets.most());
    refuse(builder, place, inside, "of the body")
}

/// The point with the smallest distance, and its depth \[m\].
fn deepest(places: Vec<Vec3>, gap: impl Fn(&Vec3) -> f64) -> Option<(Vec3, f64)> {
    places.into_iter().map(|at| (at, -gap(&at))).max_by(|a, b| a.1.total_cmp(&b.1))
}

fn refuse(builder: &Builder, place: &str, inside: Option<(Vec3, f64)>, of: &str) -> Result<(), SceneError> {
    let Some((at, depth)) = inside else { return Ok(()) };
    let fact = format!("the obstacle is {:.4} mm inside {of} at {}", depth * 1e3, point(&at));
    Err(builder.content(place, fact, "move one of the two apart"))
}
