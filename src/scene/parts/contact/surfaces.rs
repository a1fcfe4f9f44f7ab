//! Contact of two deformable surfaces of a scene, or of a surface with itself.

use crate::effect::contact::barrier::Barrier;
use crate::effect::contact::friction::Coulomb;
use crate::effect::contact::surfaces::Surfaces;
use crate::effect::contact::surfaces::friction::SurfaceFriction;
use crate::effect::contact::surfaces::pressed::PressedSurfaces;
use crate::effect::contact::surfaces::surface::Surface;
use crate::mesh::error::point;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::parts::contact::notes::note_start_of_surfaces;
use crate::scene::parts::contact::record::ContactSides;
use crate::scene::parts::contact::spec::{ContactSpec, ResponseSpec};
use std::sync::Arc;

/// Builds the sides of a contact with their effects; the normal one comes first.
pub(in crate::scene) fn build_surfaces(
    builder: &mut Builder,
    place: &str,
    spec: &ContactSpec,
    region: &str,
    (barrier, law): (Barrier, Coulomb),
) -> Result<ContactSides, SceneError> {
    if spec.response != ResponseSpec::Barrier {
        let fact = format!("deformable surfaces meet by a barrier, and the response is \"{}\"", spec.response.name());
        return Err(builder.content(place, fact, "take response = \"barrier\""));
    }
    if spec.motion.is_some() {
        let fact = format!("\"{region}\" is a part of the surface, and has a motion");
        return Err(builder.content(place, fact, "remove `motion`: the body moves it"));
    }
    let mesh = &builder.body.mesh;
    let surface = |name: &str| Ok::<_, SceneError>(Surface::new(mesh, builder.contact_facets(place, name)?));
    let itself = region == spec.region;
    let (first, second) = (surface(&spec.region)?, if itself { None } else { Some(surface(region)?) });
    let surfaces = Surfaces::new(spec.name.clone(), first, second, mesh.points.clone(), barrier.distance);
    check_surfaces(builder, place, &surfaces, barrier.distance)?;
    let pressing = Arc::new(PressedSurfaces::new(surfaces, barrier));
    builder.effects.push(Box::new(pressing.clone()));
    note_start_of_surfaces(builder, &pressing, barrier.distance);
    let friction = (law.coefficient > 0.0).then(|| {
        let friction = Arc::new(SurfaceFriction::new(format!("{}_friction", spec.name), pressing.clone(), law));
        builder.effects.push(Box::new(friction.clone()));
        friction
    });
    Ok(ContactSides::Surfaces { pressing, friction })
}

/// Refuses surfaces that cross or have no gap at rest, and parts of one surface that are nearer to each other than the reach of the barrier.
fn check_surfaces(builder: &Builder, place: &str, surfaces: &Surfaces, distance: f64) -> Result<(), SceneError> {
    let rest = vec![0.0; 3 * builder.nodes];
    if let Some(at) = surfaces.crossing(&rest) {
        let fact = format!("the surfaces cross at {}", point(&at));
        return Err(builder.content(place, fact, "move one of the two apart"));
    }
    let gap = surfaces.gap(&rest);
    if gap <= 1e-9 * builder.body.mesh.diagonal() {
        let fact = "the surfaces touch at rest, and a barrier keeps them apart";
        return Err(builder.content(place, fact, "leave a gap, for example of `distance`"));
    }
    if surfaces.is_joined() && gap < distance {
        let fact = format!(
            "parts of the surface that share no node are {:.4} mm from each other at rest, and feel each other from {:.4} mm",
            gap * 1e3,
            distance * 1e3
        );
        return Err(builder.content(place, fact, "give a smaller `distance`, or take the regions apart"));
    }
    Ok(())
}
