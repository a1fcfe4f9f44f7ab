//! Contact of a scene: its points, its obstacle, its response, and the resulting effects.

use crate::effect::contact::barrier::Barrier;
use crate::effect::contact::friction::{ContactFriction, Coulomb};
use crate::effect::contact::multiplier::Multiplier;
use crate::effect::contact::penalty::Penalty;
use crate::effect::contact::placement::{AffineFrame, Obstacle};
use crate::effect::contact::pressed::{Pressed, Response};
use crate::effect::contact::{Contact, NormalForces, Sampling, SurfacePoint, points};
use crate::mesh::TetMesh;
use crate::mesh::error::point;
use crate::scene::build::builder::Builder;
use crate::scene::build::shape::ShapeSpec;
use crate::scene::error::{SceneError, hint};
use crate::scene::parts::contact::inside::{check_deformable, check_rigid};
use crate::scene::parts::contact::motion::{carry, start};
use crate::scene::parts::contact::notes::{note_facets, note_points, note_start};
use crate::scene::parts::contact::record::{ContactSides, NamedContact};
use crate::scene::parts::contact::scales::{ContactScales, modulus_at, stiffest};
use crate::scene::parts::contact::spec::{ContactSpec, ResponseSpec};
use crate::scene::parts::contact::sunk::PressingFacets;
use crate::scene::parts::contact::surfaces::build_surfaces;
use crate::scene::parts::rigid::{RigidBody, RigidSpec, build_rigid};
use crate::scene::rotation::check_in_contact;
use std::collections::HashSet;
use std::sync::Arc;

/// Builds all rigid bodies and contacts, with their effects.
pub(in crate::scene) fn build_contacts(
    builder: &mut Builder,
    rigids: &[RigidSpec],
    specs: &[ContactSpec],
) -> Result<(Vec<RigidBody>, Vec<NamedContact>), SceneError> {
    let mut next = builder.body.mesh.points.len() as u32;
    let mut four = || {
        next += 4;
        [next - 4, next - 3, next - 2, next - 1]
    };
    let stiffest = stiffest(builder);
    let mut bodies = Vec::<RigidBody>::new();
    for (k, rigid) in rigids.iter().enumerate() {
        let place = format!("rigid {} ({})", k + 1, rigid.name);
        if bodies.iter().any(|b| b.name == rigid.name) {
            let fact = format!("another rigid body is called \"{}\" too", rigid.name);
            return Err(builder.content(&place, fact, "give each a `name` of its own"));
        }
        bodies.push(build_rigid(builder, &place, rigid, four(), stiffest)?);
    }
    let mut contacts = Vec::<NamedContact>::new();
    for (k, contact) in specs.iter().enumerate() {
        let place = format!("contact {} ({})", k + 1, contact.name);
        if contacts.iter().any(|c| c.name == contact.name) {
            let fact = format!("another contact is called \"{}\" too", contact.name);
            return Err(builder.content(&place, fact, "give each a `name` of its own"));
        }
        check_pair(builder, &place, contact, &specs[..k])?;
        let carriers = contact.motion.as_ref().map(|_| four());
        contacts.push(build_contact(builder, &place, contact, (&bodies, carriers))?);
    }
    Ok((bodies, contacts))
}

/// Refuses a contact of two surfaces that share facets with those of an earlier contact, whichever of them is the obstacle: both contacts would act there,
/// each with its full force.
fn check_pair(builder: &Builder, place: &str, spec: &ContactSpec, earlier: &[ContactSpec]) -> Result<(), SceneError> {
    let sides = |spec: &ContactSpec| {
        let ShapeSpec::Region { region } = &spec.obstacle else { return None };
        let facets =
            |name: &String| builder.regions.get(name).map(|r| r.facets.iter().copied().collect::<HashSet<_>>());
        Some([facets(&spec.region)?, facets(region)?])
    };
    let Some([a, b]) = sides(spec) else { return Ok(()) };
    let is_same = |other: &ContactSpec| {
        sides(other).is_some_and(|[c, d]| {
            let meet = |one: &HashSet<u32>, other: &HashSet<u32>| !one.is_disjoint(other);
            meet(&a, &c) && meet(&b, &d) || meet(&a, &d) && meet(&b, &c)
        })
    };
    let Some(k) = earlier.iter().position(is_same) else { return Ok(()) };
    let fact =
        format!("it is of the same two surfaces as contact {} ({}), and the two would add up", k + 1, earlier[k].name);
    let remedy = "keep one of the two, whose force is that of the whole contact, or give regions without common facets";
    Err(builder.content(place, fact, remedy))
}

/// Builds a contact with its effects; the normal one comes first.
fn build_contact(
    builder: &mut Builder,
    place: &str,
    spec: &ContactSpec,
    (bodies, carriers): (&[RigidBody], Option<[u32; 4]>),
) -> Result<NamedContact, SceneError> {
    builder.check_name(place, &spec.name)?;
    if !(spec.friction >= 0.0 && spec.friction.is_finite()) {
        let fact = format!("friction = {}", spec.friction);
        return Err(builder.content(place, fact, "a coefficient of friction is not negative"));
    }
    check_sides(builder, place, spec, bodies)?;
    let sides = deformable_sides(builder, place, spec, bodies)?;
    check_turned(builder, &sides)?;
    let cell = cell_size(builder, &sides);
    let at_sides = || sides.iter().filter_map(|facets| modulus_at(builder, facets)).reduce(f64::max);
    let by_default = || at_sides().unwrap_or_else(|| stiffest(builder));
    // The default is computed only if it is needed, since it visits all faces of the mesh
    let stiffness = spec.modulus.as_ref().map_or_else(by_default, |modulus| modulus.0);
    let scales = ContactScales::new(builder, place, spec, (cell, stiffness))?;
    let ContactScales { distance, modulus, friction: coulomb, .. } = scales;
    let named =
        |of: ContactSides| NamedContact { name: spec.name.clone(), response: spec.response, scales, of, history: 0..0 };
    if let ShapeSpec::Region { region } = &spec.obstacle {
        let barrier = Barrier { distance, stiffness: modulus / distance };
        return build_surfaces(builder, place, spec, region, (barrier, coulomb)).map(named);
    }
    let sampling = if spec.response == ResponseSpec::Multiplier { Sampling::Nodes } else { Sampling::Pressures };
    let points = contact_points(builder, place, &spec.region, bodies, sampling)?;
    let obstacle = build_obstacle(builder, place, spec, bodies, carriers)?;
    let name = spec.name.clone();
    let scalars = (spec.response == ResponseSpec::Multiplier).then(|| {
        let first = (3 * builder.nodes + builder.gathered.hosts.len()) as u32;
        let contacts = obstacle.shape.sheets();
        builder.gathered.hosts.extend(points.iter().flat_map(|p| std::iter::repeat_n(p.nodes[0], contacts)));
        first
    });
    let contact = Arc::new(Contact::with_scalars(name.clone(), points, obstacle, scalars));
    check_apart(builder, place, &contact, spec.response)?;
    let coulomb = (spec.friction > 0.0).then_some(coulomb);
    let pressing: Arc<dyn NormalForces> = match spec.response {
        ResponseSpec::Barrier => press(&contact, Barrier { distance, stiffness: modulus / distance }, coulomb, builder),
        ResponseSpec::Penalty => {
            press(&contact, Penalty { stiffness: modulus / distance, rounding: distance }, coulomb, builder)
        }
        ResponseSpec::Multiplier => {
            let stiffness = modulus * builder.body.mesh.h();
            let shared = Arc::new(Multiplier { contact, stiffness, friction: coulomb });
            builder.effects.push(Box::new(shared.clone()));
            shared
        }
    };
    if spec.response == ResponseSpec::Barrier {
        note_start(builder, &*pressing);
    }
    let facets = match bodies.iter().find(|b| b.name == spec.region) {
        Some(body) => {
            check_rigid(builder, place, pressing.contact(), body)?;
            note_points(builder, body, &*pressing);
            PressingFacets::none()
        }
        None => {
            let facets = builder.contact_facets(place, &spec.region)?.to_vec();
            note_facets(builder, &spec.region, &facets, &*pressing);
            let facets = PressingFacets::new(facets, cell, pressing.contact());
            check_deformable(builder, place, pressing.contact(), &facets)?;
            facets
        }
    };
    let friction = coulomb.map(|law| {
        let (name, pressing) = (format!("{name}_friction"), pressing.clone());
        let shared = Arc::new(ContactFriction { name, pressing, law });
        builder.effects.push(Box::new(shared.clone()));
        shared
    });
    Ok(named(ContactSides::Points { pressing, moves: spec.motion.is_some(), friction, facets }))
}

/// Refuses a rigid body in place of facets if the obstacle is a region.
fn check_sides(builder: &Builder, place: &str, spec: &ContactSpec, bodies: &[RigidBody]) -> Result<(), SceneError> {
    let ShapeSpec::Region { region } = &spec.obstacle else { return Ok(()) };
    let is_rigid = |name: &String| bodies.iter().any(|b| b.name == *name) && !builder.regions.contains_key(name);
    let own = &spec.region;
    if is_rigid(region) {
        let fact = format!("the obstacle \"{region}\" is a rigid body, and no region");
        return Err(builder.content(
            place,
            fact,
            format!("write obstacle = {{ kind = \"rigid\", body = \"{region}\" }}"),
        ));
    }
    if is_rigid(own) {
        let fact = format!("\"{own}\" is a rigid body, and its obstacle \"{region}\" a part of a deformable surface");
        let remedy =
            format!("swap them: region = \"{region}\" and obstacle = {{ kind = \"rigid\", body = \"{own}\" }}");
        return Err(builder.content(place, fact, remedy));
    }
    Ok(())
}

/// The facets of each deformable side of a contact: those of its region, and those of its obstacle if it is a region.
fn deformable_sides(
    builder: &Builder,
    place: &str,
    spec: &ContactSpec,
    bodies: &[RigidBody],
) -> Result<Vec<Vec<u32>>, SceneError> {
    let other = match &spec.obstacle {
        ShapeSpec::Region { region } => Some(region),
        _ => None,
    };
    let own = Some(&spec.region).filter(|name| bodies.iter().all(|b| b.name != **name));
    own.into_iter().chain(other).map(|name| Ok(builder.contact_facets(place, name)?.to_vec())).collect()
}

/// Refuses facets in contact all of whose nodes rotate too far in one step.
fn check_turned(builder: &Builder, sides: &[Vec<u32>]) -> Result<(), SceneError> {
    let mesh = &builder.body.mesh;
    for turned in &builder.gathered.turned {
        let turns = |f: &u32| mesh.facet(*f as usize).iter().all(|node| turned.nodes.binary_search(node).is_ok());
        if sides.iter().flatten().any(turns) {
            check_in_contact(builder, &turned.place, &turned.angle)?;
        }
    }
    Ok(())
}

/// Mean size of the cells where a contact acts \[m\]: of those at its facets, on the finer of two sides, or of all cells for contacts between rigid bodies and
/// obstacles.
fn cell_size(builder: &Builder, sides: &[Vec<u32>]) -> f64 {
    let mesh = &builder.body.mesh;
    sides.iter().map(|facets| size_at(mesh, facets)).reduce(f64::min).unwrap_or_else(|| mesh.h())
}

/// (V/N)^{1/3} of the cells at facets \[m\].
fn size_at(mesh: &TetMesh, facets: &[u32]) -> f64 {
    let mut is_there = vec![false; mesh.points.len()];
    for &node in facets.iter().flat_map(|&f| mesh.facet(f as usize)) {
        is_there[node as usize] = true;
    }
    let cells = (0..mesh.cell_count()).filter(|&c| mesh.cell(c).iter().any(|&node| is_there[node as usize]));
    let (volume, count) = cells.fold((0.0, 0), |(volume, count), c| (volume + mesh.cell_volume(c), count + 1));
    (volume / f64::from(count)).cbrt()
}

fn contact_points(
    builder: &Builder,
    place: &str,
    region: &str,
    bodies: &[RigidBody],
    sampling: Sampling,
) -> Result<Vec<SurfacePoint>, SceneError> {
    if let Some(body) = bodies.iter().find(|b| b.name == region) {
        return Ok(body.points());
    }
    Ok(points(&builder.body.mesh, builder.contact_facets(place, region)?, sampling))
}

fn build_obstacle(
    builder: &mut Builder,
    place: &str,
    spec: &ContactSpec,
    bodies: &[RigidBody],
    carriers: Option<[u32; 4]>,
) -> Result<Obstacle, SceneError> {
    let shape = match &spec.obstacle {
        ShapeSpec::Rigid { body: name } => {
            let Some(body) = bodies.iter().find(|b| b.name == *name) else {
                let known: Vec<&str> = bodies.iter().map(|b| b.name.as_str()).collect();
                let fact = format!("there is no [[rigid]] \"{name}\"");
                return Err(builder.content(place, fact, hint(name, &known)));
            };
            if spec.region == *name {
                return Err(builder.content(place, format!("\"{name}\" is its own obstacle"), "take another obstacle"));
            }
            if spec.motion.is_some() {
                let fact = format!("\"{name}\" is free, and has a motion");
                return Err(builder.content(place, fact, "remove `motion`, or give a shape in space"));
            }
            let (shape, origin, axes) = builder.shape(place, &body.shape)?;
            return Ok(Obstacle { shape, origin, axes, body: Some(body.frame.clone()) });
        }
        shape => shape,
    };
    let (shape, origin, axes) = builder.shape(place, shape)?;
    let body: Option<AffineFrame> = match (&spec.motion, carriers) {
        (Some(motion), Some(_)) if motion.turn.is_some() && shape.bounds().is_none() => {
            let fact = "a floor that turns: it has no end, and no bound on how fast it moves";
            return Err(builder.content(place, fact, "take a box"));
        }
        (Some(motion), Some(nodes)) => Some(carry(builder, place, &spec.name, motion, origin, nodes)?),
        _ => None,
    };
    builder.draw(place, &spec.name, &shape, (origin, axes), body.as_ref())?;
    Ok(Obstacle { shape, origin, axes, body })
}

/// Refuses bodies that overlap at the start, or that have no gap although a barrier keeps them apart.
fn check_apart(builder: &Builder, place: &str, contact: &Contact, response: ResponseSpec) -> Result<(), SceneError> {
    let Some((b, gap)) = contact.deepest(&start(builder)) else { return Ok(()) };
    let is_static = builder.spans.first().is_some_and(|first| first.integrator.is_static());
    let given = if is_static && contact.obstacle.body.is_some() {
        ", at its given place, from which a static stage moves it"
    } else {
        ""
    };
    let rounding = 1e-9 * builder.body.mesh.diagonal();
    let at = point(&contact.points[b].at);
    if gap < -rounding {
        let fact = format!("the surface is {:.4} mm inside of the obstacle{given} at {at}", -gap * 1e3);
        return Err(builder.content(place, fact, "move one of the two apart"));
    }
    if gap <= rounding && response == ResponseSpec::Barrier {
        let fact =
            format!("the surface is in contact with the obstacle{given} at {at}, and a barrier keeps them apart");
        return Err(builder.content(place, fact, "leave a gap, for example of `distance`, or take another response"));
    }
    Ok(())
}

fn press<R: Response + 'static>(
    contact: &Arc<Contact>,
    response: R,
    friction: Option<Coulomb>,
    builder: &mut Builder,
) -> Arc<dyn NormalForces> {
    let shared = Arc::new(Pressed { contact: contact.clone(), response, friction });
    builder.effects.push(Box::new(shared.clone()));
    shared
}
