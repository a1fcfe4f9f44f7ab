//! Bodies and obstacles that begin inside of each other between the contact points, which alone feel an obstacle.

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

/// Share of the diagonal of the mesh by which surfaces in contact are inside of each other by rounding \[–\].
const ROUNDING: f64 = 1e-9;
/// Share of the distance of the vertices of a rigid surface by which a ball is inside of it where it fits a hollow of this surface \[–\].
const HOLLOW: f64 = 0.125;

/// Refuses an obstacle that begins inside of the rigid body whose points meet it.
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

/// Refuses an obstacle that begins inside of the deformable body, deeper than its contact points may let it be, and facets that begin inside of the obstacle.
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
    // Where more than two facets have an edge in common, no inside is known.
    let Ok(boundary) = Shape::surface(&boundary) else { return Ok(()) };
    let inside = deepest(places, |at| boundary.gap(at)).filter(|(_, depth)| *depth > facets.most());
    refuse(builder, place, inside, "of the body")
}

/// The place with the least distance, and how deep it is \[m\].
fn deepest(places: Vec<Vec3>, gap: impl Fn(&Vec3) -> f64) -> Option<(Vec3, f64)> {
    places.into_iter().map(|at| (at, -gap(&at))).max_by(|a, b| a.1.total_cmp(&b.1))
}

fn refuse(builder: &Builder, place: &str, inside: Option<(Vec3, f64)>, of: &str) -> Result<(), SceneError> {
    let Some((at, depth)) = inside else { return Ok(()) };
    let fact = format!("the obstacle is {:.4} mm inside {of} at {}", depth * 1e3, point(&at));
    Err(builder.content(place, fact, "move one of the two apart"))
}
