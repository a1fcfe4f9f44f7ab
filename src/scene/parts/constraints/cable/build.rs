//! Construction of a cable: its path through guides and rings, and its drive.

use crate::effect::{Cable, CableLength, CableTension, Guide, Pull, cable_friction};
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::mesh::embed::{ball_weights, embed};
use crate::mesh::error::point;
use crate::scene::builder::Builder;
use crate::scene::error::{SceneError, hint, part};
use crate::scene::parts::constraints::cable::record::NamedCable;
use crate::scene::parts::constraints::cable::spec::{CableDriveSpec, CableSpec};
use crate::scene::parts::constraints::drive::Drive;
use crate::scene::protocol::extremes;
use crate::scene::quantity::{Force, GuideRadius, Length};
use std::sync::Arc;

/// Rounding of a sum of signals, as a share of the largest value.
const ROUNDING: f64 = 1e-12;

/// A point on the path of a cable: its name in messages, and whether it is fixed in space.
struct Stop {
    name: String,
    fixed: bool,
    guide: Guide,
}

/// A cable with its rows, or its load.
pub(in crate::scene) fn build_cable(
    builder: &mut Builder,
    place: &str,
    spec: &CableSpec,
) -> Result<NamedCable, SceneError> {
    check_values(builder, place, spec)?;
    let (pull_point, stops) = find_stops(builder, place, spec)?;
    let fixed = fixed_length(pull_point, &stops);
    let guides = stops.into_iter().map(|s| s.guide).collect();
    let cable = Arc::new(Cable::new(spec.name.clone(), pull_point, guides));
    let lengths = cable.lengths_at_rest();
    let rest: f64 = lengths.iter().sum();
    let softness = spec.axial.as_ref().map_or(0.0, |ea| 1.0 / ea.0);
    let most = spec.max_tension.as_ref().map_or(f64::INFINITY, |t| t.0);
    let row = builder.constraints.len();
    let drive = match &spec.drive {
        CableDriveSpec::Length { signal } => {
            let named = format!("{}_shortening_m", spec.name);
            let shortening = builder.signal(place, named, signal, Dimension::LENGTH)?;
            if softness == 0.0 && most == f64::INFINITY {
                check_shortening(builder, place, &shortening, rest - fixed)?;
            }
            note_let_out(builder, &spec.name, &shortening);
            match spec.friction {
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
            let named = format!("{}_imposed_tension_N", spec.name);
            let tension = builder.signal(place, named, signal, Dimension::FORCE)?;
            check_tension(builder, place, &tension)?;
            match spec.friction {
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
    let friction = spec.friction.is_some();
    Ok(NamedCable { name: spec.name.clone(), cable, drive, by_length, friction, softness, most })
}

fn check_values(builder: &Builder, place: &str, spec: &CableSpec) -> Result<(), SceneError> {
    if let GuideRadius::Ball(radius) = spec.guide_radius {
        let fact = format!("guide_radius is {} mm", radius * 1e3);
        if radius <= 0.0 {
            return Err(builder.content(place, fact, "give a positive length, at least the size of a cell"));
        }
        let diagonal = builder.body.mesh.diagonal();
        if radius > diagonal {
            let fact = format!("{fact}, and the body is {:.4} mm from corner to corner", diagonal * 1e3);
            return Err(builder.content(place, fact, "a guide would be the mean of the whole body; check the unit"));
        }
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
    if let CableDriveSpec::Tension { .. } = spec.drive {
        if spec.max_tension.is_some() {
            let fact = "max_tension limits a drive by length, and this one is a tension";
            return Err(builder.content(place, fact, "remove it, or take drive = { kind = \"length\", signal = … }"));
        }
        if spec.axial.is_some() && spec.friction.is_none() {
            let fact = "under a prescribed tension without friction the body does not feel EA";
            return Err(builder.content(place, fact, "remove it, or take drive = { kind = \"length\", signal = … }"));
        }
    }
    Ok(())
}

/// The pull point and the places from there to the end.
fn find_stops(builder: &Builder, place: &str, spec: &CableSpec) -> Result<(Vec3, Vec<Stop>), SceneError> {
    let (points, pull) = match (&spec.path, &spec.guides, &spec.pull_point) {
        (Some(path), None, None) => {
            let Some(known) = builder.body.paths.get(path) else {
                let names: Vec<&String> = builder.body.paths.keys().collect();
                let remedy = format!("{}; or give `guides` and `pull_point`", hint(path, &names));
                return Err(builder.content(place, format!("the mesh has no path \"{path}\""), remedy));
            };
            (known.guides.iter().map(|p| Vec3::from(*p)).collect::<Vec<_>>(), Vec3::from(known.pull_point))
        }
        (None, Some(guides), Some(pull)) => (guides.iter().map(vector).collect(), vector(pull)),
        _ => {
            let fact = "a cable runs along a path";
            return Err(builder.content(place, fact, "give either `path`, or both `guides` and `pull_point`"));
        }
    };
    if points.is_empty() {
        return Err(builder.content(place, "the cable has no guide", "give at least one point inside the body"));
    }
    if let Some((k, ring)) = spec.rings.iter().enumerate().find(|(_, r)| r.after >= points.len()) {
        let fact =
            format!("ring {} is after guide {}, and the cable ends at guide {}", k + 1, ring.after, points.len());
        return Err(builder.content(place, fact, "a cable ends in the body: place its rings before the last guide"));
    }
    let mut stops = Vec::new();
    for (k, &at) in points.iter().enumerate() {
        for (r, ring) in spec.rings.iter().enumerate().filter(|(_, ring)| ring.after == k) {
            let guide = Guide { point: vector(&ring.at), weights: Vec::new() };
            stops.push(Stop { name: format!("ring {}", r + 1), fixed: true, guide });
        }
        let guide = build_guide(builder, &format!("{place}: guide {}", k + 1), at, spec.guide_radius)?;
        stops.push(Stop { name: format!("guide {}", k + 1), fixed: false, guide });
    }
    let mut before = (pull, "the pull point".to_string());
    for stop in &stops {
        if (stop.guide.point - before.0).norm() <= 1e-9 * builder.body.mesh.diagonal() {
            let fact = format!("{} coincides with {} at {}", stop.name, before.1, point(&before.0));
            return Err(builder.content(place, fact, "the cable has no direction between them: move or remove one"));
        }
        before = (stop.guide.point, stop.name.clone());
    }
    Ok((pull, stops))
}

/// A guide point must lie inside the body, also where a ball would still find some of it.
fn build_guide(builder: &Builder, place: &str, at: Vec3, radius: GuideRadius) -> Result<Guide, SceneError> {
    let mesh = &builder.body.mesh;
    let embedded = embed(mesh, at).map_err(|e| part(builder.file, place, e))?;
    let weights = match radius {
        GuideRadius::Point => embedded.weights,
        GuideRadius::Ball(radius) => ball_weights(mesh, at, radius).map_err(|e| part(builder.file, place, e))?,
    };
    Ok(Guide { point: at, weights })
}

/// Refuses a shortening by more than the length inside the body. A signal that is decided during the run is not checked here.
fn check_shortening(builder: &Builder, place: &str, shortening: &Signal, free: f64) -> Result<(), SceneError> {
    if shortening.has_inputs() {
        return Ok(());
    }
    let (_, (t, most)) = extremes(shortening, &builder.spans);
    // A signal without a value is refused with its formula.
    if most < free || !most.is_finite() {
        return Ok(());
    }
    let (mm, free) = (most * 1e3, free * 1e3);
    let fact =
        format!("the cable is shortened by {mm:.4} mm at t = {t:.4} s, and only {free:.4} mm of it can get shorter");
    Err(builder.content(place, fact, "pull less, or let the drive yield with max_tension"))
}

/// Length between points that are fixed in space \[m\].
fn fixed_length(pull_point: Vec3, stops: &[Stop]) -> f64 {
    let mut before = (pull_point, true);
    let mut sum = 0.0;
    for stop in stops {
        if before.1 && stop.fixed {
            sum += (stop.guide.point - before.0).norm();
        }
        before = (stop.guide.point, stop.fixed);
    }
    sum
}

fn vector(p: &[Length; 3]) -> Vec3 {
    Vec3::new(p[0].0, p[1].0, p[2].0)
}

/// A cable cannot push: T(t) ≥ 0. A signal that is decided during the run is cut at 0.
fn check_tension(builder: &Builder, place: &str, tension: &Signal) -> Result<(), SceneError> {
    if tension.has_inputs() {
        return Ok(());
    }
    let ((t, least), (_, most)) = extremes(tension, &builder.spans);
    if least >= -ROUNDING * most.abs() {
        return Ok(());
    }
    let fact = format!("the tension is {least:.4} N at t = {t:.4} s, and a cable cannot push");
    Err(builder.content(place, fact, "take a signal that is never negative, such as raised_cosine"))
}

/// Notes where a cable is let out.
fn note_let_out(builder: &mut Builder, name: &str, shortening: &Signal) {
    if shortening.has_inputs() {
        return;
    }
    let ((t, least), (_, most)) = extremes(shortening, &builder.spans);
    if least < -ROUNDING * most.abs() {
        let mm = -least * 1e3;
        builder.notes.push(format!("{name} is let out by up to {mm:.4} mm (t = {t:.4} s): it may be slack there"));
    }
}
