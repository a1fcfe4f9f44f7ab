//! Construction of a cable: its path through guides and rings, and its drive.

use crate::effect::{Cable, CableLength, CableTension, Guide, Pull, cable_friction};
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::{self, Decimals, Dimension};
use crate::mesh::TetMesh;
use crate::mesh::attach::{attach_each, is_beyond};
use crate::mesh::ball::is_surrounded;
use crate::mesh::embed::{embed, nearest_on_surface};
use crate::mesh::error::point;
use crate::scene::build::builder::Builder;
use crate::scene::build::drive::Drive;
use crate::scene::error::{SceneError, hint, part};
use crate::scene::notes::jump::{Impact, note_jump};
use crate::scene::parts::constraints::cable::guides::read_guides;
use crate::scene::parts::constraints::cable::record::NamedCable;
use crate::scene::parts::constraints::cable::spec::{CableDriveSpec, CableSpec, GuideFile, GuidesSpec, PullPointSpec};
use crate::scene::parts::patch::check_radius;
use crate::scene::signal::protocol::extremes;
use crate::scene::text::quantity::{Force, GuideRadius, Length};
use crate::wording;
use std::sync::Arc;

/// Relative rounding of a sum of signals, with respect to the largest value.
const ROUNDING: f64 = 1e-12;

/// A point on the path of a cable, with its name in messages.
struct Stop {
    name: String,
    guide: Guide,
}

/// Points of one cable in order from the pull point.
struct Route {
    name: String,
    /// Prefix of the name of a guide in messages, if there are several cables
    of: String,
    /// Pull point; `None` if the cable is pulled at its first guide, which moves with the body
    pull: Option<Vec3>,
    points: Vec<Vec3>,
}

/// The cables of an entry, whose names must differ from those of the `known` ones.
pub(in crate::scene) fn build_cables(
    builder: &mut Builder,
    place: &str,
    spec: &CableSpec,
    known: &[NamedCable],
) -> Result<Vec<NamedCable>, SceneError> {
    check_values(builder, place, spec)?;
    let mut routes = find_routes(builder, place, spec)?;
    for (k, route) in routes.iter().enumerate() {
        let name = &route.name;
        builder.check_name(place, name)?;
        if known.iter().map(|c| &c.name).chain(routes[..k].iter().map(|r| &r.name)).any(|other| other == name) {
            let fact = format!("another cable is called \"{name}\" too");
            return Err(builder.content(place, fact, "give each cable a `name` of its own"));
        }
    }
    reach_guides(builder, place, spec, &mut routes)?;
    routes.into_iter().map(|route| build_cable(builder, place, spec, route)).collect()
}

/// A cable with its constraint equations, or its load.
fn build_cable(builder: &mut Builder, place: &str, spec: &CableSpec, route: Route) -> Result<NamedCable, SceneError> {
    let stops = find_stops(builder, place, spec, &route)?;
    let Route { name, pull: pull_point, .. } = route;
    let guides = stops.into_iter().map(|s| s.guide).collect();
    let cable = Arc::new(Cable::through(name.clone(), pull_point, guides));
    let lengths = cable.lengths_at_rest();
    let rest: f64 = lengths.iter().sum();
    let softness = spec.axial.as_ref().map_or(0.0, |ea| 1.0 / ea.0);
    let most = spec.max_tension.as_ref().map_or(f64::INFINITY, |t| t.0);
    let row = builder.constraints.len();
    let drive = match &spec.drive {
        CableDriveSpec::Length { signal } => {
            let named = format!("{name}_shortening_m");
            let shortening = builder.signal(place, named.clone(), signal, Dimension::LENGTH)?;
            if softness == 0.0 && most == f64::INFINITY {
                note_jump(builder, &named, &shortening, Impact::Growing);
            }
            note_let_out(builder, &name, &shortening);
            match spec.capstan() {
                Some(mu) => {
                    let pull = Pull::Length { shortening, most };
                    builder.constraints.extend(cable_friction::constraints(cable.clone(), pull, mu, softness));
                }
                None => {
                    let compliance = softness * rest;
                    let row = CableLength { cable: cable.clone(), shortening, rest, compliance, most };
                    builder.constraints.push(Box::new(row));
                }
            }
            Drive::Multiplier(row)
        }
        CableDriveSpec::Tension { signal } => {
            let named = format!("{name}_imposed_tension_N");
            let tension = builder.signal(place, named, signal, Dimension::FORCE)?;
            check_tension(builder, place, &tension)?;
            match spec.capstan() {
                Some(mu) => {
                    builder.constraints.extend(cable_friction::constraints(
                        cable.clone(),
                        Pull::Tension(tension),
                        mu,
                        softness,
                    ));
                    Drive::Multiplier(row)
                }
                None => {
                    builder.effects.push(Box::new(CableTension { cable: cable.clone(), tension: tension.clone() }));
                    Drive::Prescribed(tension)
                }
            }
        }
    };
    let by_length = spec.drive.is_by_length();
    let (by_segment, friction) = (spec.friction.is_some(), spec.capstan().is_some());
    let guide_radius = match spec.guide_radius {
        GuideRadius::Point => None,
        GuideRadius::Ball(radius) => Some(radius),
    };
    Ok(NamedCable { name, cable, guide_radius, drive, by_length, by_segment, friction, softness, most })
}

fn check_values(builder: &Builder, place: &str, spec: &CableSpec) -> Result<(), SceneError> {
    if let GuideRadius::Ball(radius) = spec.guide_radius {
        check_radius(builder, place, "guide_radius", radius)?;
    }
    let positive = |key: &str, value: &Option<Force>, remedy: &str| match value {
        Some(v) if v.0 <= 0.0 => Err(builder.content(place, format!("{key} is {} N", v.0), remedy)),
        _ => Ok(()),
    };
    positive("EA", &spec.axial, "give a positive one, or none for a cable that does not stretch")?;
    positive("max_tension", &spec.max_tension, "give a positive one, or none for a drive that never yields")?;
    if let Some(mu) = spec.friction
        && !(mu >= 0.0 && mu.is_finite())
    {
        return Err(builder.content(place, format!("friction is {mu}"), "a coefficient of friction is not negative"));
    }
    if matches!(spec.drive, CableDriveSpec::Tension { .. }) && spec.max_tension.is_some() {
        let fact = "max_tension limits a drive by length, and this one is a tension";
        return Err(builder.content(place, fact, "remove it, or take drive = { kind = \"length\", signal = … }"));
    }
    if let Some(Length(reach)) = &spec.reach
        && *reach < 0.0
    {
        let fact = format!("reach is {} mm", reach * 1e3);
        return Err(builder.content(place, fact, "give zero or a positive length"));
    }
    Ok(())
}

/// The routes of the cables of an entry: along a path of the body, through a list of guides, or through the guides of a file.
fn find_routes(builder: &Builder, place: &str, spec: &CableSpec) -> Result<Vec<Route>, SceneError> {
    let (guides, pull) = match (&spec.path, &spec.guides, &spec.pull_point) {
        (Some(path), None, None) => {
            let Some(known) = builder.body.paths.get(path) else {
                let names: Vec<&String> = builder.body.paths.keys().collect();
                let remedy = format!("{}; or give `guides` and `pull_point`", hint(path, &names));
                return Err(builder.content(place, format!("the mesh has no path \"{path}\""), remedy));
            };
            let points = known.guides.iter().map(|p| Vec3::from(*p)).collect();
            let pull = Some(Vec3::from(known.pull_point));
            return Ok(vec![Route { name: spec.name.clone(), of: String::new(), pull, points }]);
        }
        (None, Some(guides), Some(pull)) => (guides, pull),
        _ => {
            let fact = "a cable runs along a path";
            return Err(builder.content(place, fact, "give either `path`, or both `guides` and `pull_point`"));
        }
    };
    let lists = match guides {
        GuidesSpec::List(points) => vec![(None, points.iter().map(vector).collect())],
        GuidesSpec::File(GuideFile { file, unit, cable }) => {
            let fail = |e| part(builder.file, place, e);
            let size =
                units::parse(&format!("1 {unit}"), Dimension::LENGTH).map_err(|e| part(builder.file, place, e))?;
            let read = read_guides(&builder.base.join(file), unit, cable.as_deref()).map_err(fail)?;
            read.into_iter().map(|c| (c.name, c.points.into_iter().map(|p| p * size).collect())).collect()
        }
    };
    let several = lists.len() > 1;
    let route = |(k, (named, mut points)): (usize, (Option<String>, Vec<Vec3>))| {
        let name = match named {
            Some(name) => name,
            None if several => format!("{}_{}", spec.name, k + 1),
            None => spec.name.clone(),
        };
        let of = if several { format!("{name}, ") } else { String::new() };
        let pull = match pull {
            PullPointSpec::At(at) => Some(vector(at)),
            PullPointSpec::First if points.is_empty() => Some(Vec3::zeros()),
            PullPointSpec::First => Some(points.remove(0)),
            PullPointSpec::Moving => None,
        };
        Route { name, of, pull, points }
    };
    Ok(lists.into_iter().enumerate().map(route).collect())
}

/// Moves guides that lie outside of the body by at most `reach` to its surface; all guides that are farther out are refused together. A guide in a bore whose
/// ball overlaps the body on all sides is not moved.
fn reach_guides(builder: &mut Builder, place: &str, spec: &CableSpec, routes: &mut [Route]) -> Result<(), SceneError> {
    let (mesh, reach) = (builder.body.clone(), spec.reach.as_ref().map_or(0.0, |l| l.0));
    let (mut moved, mut between, mut kept, mut largest, mut refused) = (0, 0, 0, 0.0_f64, Vec::new());
    for route in routes.iter_mut() {
        for (k, at) in route.points.iter_mut().enumerate() {
            if embed(&mesh.mesh, *at).is_ok() {
                continue;
            }
            if matches!(spec.guide_radius, GuideRadius::Ball(radius) if is_surrounded(&mesh.mesh, *at, radius)) {
                kept += 1;
                continue;
            }
            let nearest = nearest_on_surface(&mesh.mesh, *at);
            let distance = (nearest - *at).norm();
            if is_beyond(&mesh.mesh, distance, reach) {
                refused.push((
                    distance,
                    format!("{}guide {} at {} by {:.4} mm", route.of, k + 1, point(at), Decimals(distance * 1e3)),
                ));
                continue;
            }
            (moved, largest) = (moved + 1, largest.max(distance));
            between += usize::from(is_between(&mesh.mesh, *at, nearest));
            *at = nearest;
        }
    }
    let all: usize = routes.iter().map(|r| r.points.len()).sum();
    if refused.is_empty() {
        let names: Vec<&str> = routes.iter().map(|r| r.name.as_str()).collect();
        if kept > 0 {
            builder.notes.push(format!(
                "{}: {kept} of {all} guides are in a bore or a gap of the body, and follow the mean motion of its walls within the guide radius",
                wording::few(&names)
            ));
        }
        if moved > 0 {
            let largest = Decimals(largest * 1e3);
            builder.notes.push(format!(
                "{}: {moved} of {all} guides are outside of the body, by up to {largest:.4} mm, and were moved to its surface",
                wording::few(&names)
            ));
            if between > 0 {
                builder.notes.push(format!(
                    "{}: {between} of these guides are as near to an opposite wall, as on the axis of a bore, and the mesh decides to which they go; \
                     give them on the wall where the cable lies, give a guide_radius well beyond the walls, or mesh the body without the bore",
                    wording::few(&names)
                ));
            }
        }
        return Ok(());
    }
    // Rounded up, so that the advice can be followed
    let most = Decimals((refused.iter().map(|r| r.0).fold(0.0, f64::max) * 1e7).ceil() / 1e4);
    let which: Vec<String> = refused.into_iter().map(|r| r.1).collect();
    let by =
        if reach > 0.0 { format!(" by more than the reach of {:.4} mm", Decimals(reach * 1e3)) } else { String::new() };
    let fact = format!("{} of {all} guides are outside of the body{by}: {}", which.len(), which.join(", "));
    let remedy = format!(
        "move them inside, or give a `reach` of at least {most:.4} mm to move them to the surface; those on the axis of a bore stay there with a guide_radius well \
         beyond its walls"
    );
    Err(builder.content(place, fact, remedy))
}

/// Whether a point outside of the body lies between two walls at about the same distance: slightly farther from the `nearest` point, a different point is
/// nearest.
fn is_between(mesh: &TetMesh, at: Vec3, nearest: Vec3) -> bool {
    let away = at - nearest;
    let other = nearest_on_surface(mesh, at + 0.25 * away);
    (other - nearest).norm() > away.norm() && (other - at).norm() < 1.5 * away.norm()
}

/// The points of a cable from the pull point to the end.
fn find_stops(builder: &Builder, place: &str, spec: &CableSpec, route: &Route) -> Result<Vec<Stop>, SceneError> {
    let (points, of) = (&route.points, &route.of);
    if points.is_empty() {
        return Err(builder.content(
            place,
            format!("{of}the cable has no guide"),
            "give at least one point inside the body",
        ));
    }
    if route.pull.is_none() {
        if points.len() == 1 {
            let fact = format!("{of}the cable has one guide, at which it is pulled");
            return Err(builder.content(place, fact, "give a second one: it runs from guide to guide"));
        }
        if let Some(k) = spec.rings.iter().position(|r| r.after == 0) {
            let fact = format!("{of}ring {} is before the first guide, at which the cable is pulled", k + 1);
            return Err(builder.content(place, fact, "place it after a guide, or give a `pull_point` in space"));
        }
    }
    if let Some((k, ring)) = spec.rings.iter().enumerate().find(|(_, r)| r.after >= points.len()) {
        let fact =
            format!("{of}ring {} is after guide {}, and the cable ends at guide {}", k + 1, ring.after, points.len());
        return Err(builder.content(place, fact, "a cable ends in the body: place its rings before the last guide"));
    }
    let mut stops = Vec::new();
    for (k, &at) in points.iter().enumerate() {
        for (r, ring) in spec.rings.iter().enumerate().filter(|(_, ring)| ring.after == k) {
            let guide = Guide { point: vector(&ring.at), weights: Vec::new() };
            stops.push(Stop { name: format!("ring {}", r + 1), guide });
        }
        let guide = build_guide(builder, &format!("{place}: {of}guide {}", k + 1), at, spec.guide_radius)?;
        stops.push(Stop { name: format!("guide {}", k + 1), guide });
    }
    let mut before = route.pull.map(|at| (at, "the pull point"));
    for stop in &stops {
        let close = |at: &Vec3| (stop.guide.point - at).norm() <= 1e-9 * builder.body.mesh.diagonal();
        if let Some((at, other)) = before.filter(|(at, _)| close(at)) {
            let fact = format!("{of}{} coincides with {other} at {}", stop.name, point(&at));
            return Err(builder.content(place, fact, "the cable has no direction between them: move or remove one"));
        }
        before = Some((stop.guide.point, &stop.name));
    }
    Ok(stops)
}

/// The weights of a guide in the body or on its surface; the surface of curved cells is taken as that of flat triangles.
fn build_guide(builder: &Builder, place: &str, at: Vec3, radius: GuideRadius) -> Result<Guide, SceneError> {
    let mesh = &builder.body.mesh;
    let fail = |e| part(builder.file, place, e);
    let weights = match radius {
        GuideRadius::Point => attach_each(mesh, &[at], mesh.diagonal()).remove(0).map_err(fail)?,
        GuideRadius::Ball(radius) => builder.body.patches.weights(mesh, at, radius).map_err(fail)?,
    };
    Ok(Guide { point: at, weights })
}

/// Refuses a shortening by more than the part of the cable that can get shorter, which excludes the length between points that are held. To be called when
/// everything that is held is known. A signal that is decided during the run is not checked here.
pub(in crate::scene) fn check_shortening(builder: &Builder, place: &str, named: &NamedCable) -> Result<(), SceneError> {
    let NamedCable { name, cable, by_length, softness, most: limit, .. } = named;
    let free = free_length(builder, cable);
    if !by_length || *softness > 0.0 || limit.is_finite() && free > 0.0 {
        return Ok(());
    }
    let column = format!("{name}_shortening_m");
    let Some(shortening) = builder.signals.iter().find(|s| s.name == column && !s.signal.has_inputs()) else {
        return Ok(());
    };
    let (_, (t, most)) = extremes(&shortening.signal, &builder.spans);
    // A signal without a finite value is refused with its formula.
    if most < free || most <= 0.0 || !most.is_finite() {
        return Ok(());
    }
    let fact = format!(
        "the cable is shortened by {:.4} mm at t = {:.4} s, and only {:.4} mm of it can get shorter",
        Decimals(most * 1e3),
        Decimals(t),
        Decimals(free * 1e3)
    );
    if free > 0.0 {
        return Err(builder.content(place, fact, "pull less, or let the drive yield with max_tension"));
    }
    let fact = format!("{fact}: all of its guides are held, or in one rigid part");
    Err(builder.content(place, fact, "give guides where the body moves, or EA, with which the cable stretches"))
}

/// Total length at rest of the segments whose ends can move relative to each other \[m\]: not if both are held, or both belong to one rigid part.
fn free_length(builder: &Builder, cable: &Cable) -> f64 {
    let nodes = |guide: &u32| cable.means().lists()[*guide as usize].iter().map(|(node, _)| *node);
    let is_held = |guide: &u32| nodes(guide).all(|node| builder.is_held(node));
    let frame = |node: u32| builder.tied.get(&node).map(|carriers| carriers[0].0);
    let is_one_part = |[a, b]: [u32; 2]| {
        let first = nodes(&a).next().and_then(frame);
        first.is_some() && nodes(&b).next().is_some() && nodes(&a).chain(nodes(&b)).all(|node| frame(node) == first)
    };
    let is_fixed = |ends: &[u32]| ends.iter().all(is_held) || <[u32; 2]>::try_from(ends).is_ok_and(is_one_part);
    let lengths = cable.lengths_at_rest();
    // The fold starts from +0, because an empty sum is −0
    (0..cable.segments()).filter(|s| !is_fixed(cable.ends(*s))).fold(0.0, |sum, s| sum + lengths[s])
}

fn vector(p: &[Length; 3]) -> Vec3 {
    Vec3::new(p[0].0, p[1].0, p[2].0)
}

/// Refuses a negative tension, because a cable cannot push: T(t) ≥ 0. A signal that is decided during the run is cut off at 0.
fn check_tension(builder: &Builder, place: &str, tension: &Signal) -> Result<(), SceneError> {
    if tension.has_inputs() {
        return Ok(());
    }
    let ((t, least), (_, most)) = extremes(tension, &builder.spans);
    if least >= -ROUNDING * most.abs() {
        return Ok(());
    }
    let fact = format!("the tension is {:.4} N at t = {:.4} s, and a cable cannot push", Decimals(least), Decimals(t));
    Err(builder.content(place, fact, "take a signal that is never negative, such as raised_cosine"))
}

/// Adds a note if a cable is let out.
fn note_let_out(builder: &mut Builder, name: &str, shortening: &Signal) {
    if shortening.has_inputs() {
        return;
    }
    let ((t, least), (_, most)) = extremes(shortening, &builder.spans);
    if least < -ROUNDING * most.abs() {
        let (mm, t) = (Decimals(-least * 1e3), Decimals(t));
        builder.notes.push(format!("{name} is let out by up to {mm:.4} mm (t = {t:.4} s): it may be slack there"));
    }
}
