//! Evaluation of a motion record: held and final states, time of the release, motion of a body, and ring-down.

use super::audit_log;
use super::body::{self, Pose};
use super::curve::Curve;
use super::curve_states::{EvaluatedCurve, with_states};
use super::error::MotionError;
use super::knock;
use super::plateau::{Plateau, held_and_final};
use super::registration::{Registration, rigid};
use super::release::{Release, release};
use super::request::{BodyRequest, MotionRequest};
use super::ring_down::ring_down;
use super::track::{ReadOptions, Track};
use super::tracks::Tracks;
use super::vibration::RingDown;
use crate::math::tensor::Vec3;
use std::path::Path;

/// Evaluated motion of one record.
#[derive(Clone, Debug)]
pub struct Evaluation {
    pub source: String,
    /// In the frame of the body if there is a reference
    pub tracks: Tracks,
    pub registration: Option<Registration>,
    pub release: Option<Release>,
    pub poses: Vec<Pose>,
    pub curves: Vec<EvaluatedCurve>,
    /// Index of the curve, and its vibration
    pub ring_down: Option<(usize, RingDown)>,
    /// Audit log: all decisions, in sentences
    pub log: Vec<String>,
    /// Reasons to doubt the numbers
    pub doubts: Vec<String>,
}

/// Windows of the held and the final state, with the release between them.
struct States {
    held: Option<[f64; 2]>,
    last: Option<[f64; 2]>,
    release: Option<Release>,
    /// Reason why there are no states
    missing: Option<MotionError>,
}

/// Reads and evaluates a record.
///
/// # Errors
/// The errors of [`Tracks::read`], which name the file, and of [`evaluate_tracks`].
pub fn evaluate(request: &MotionRequest) -> Result<Evaluation, MotionError> {
    evaluate_tracks(Tracks::read(&request.file, &request.read)?, request)
}

/// Evaluates tracks that have already been read; the file of the request is not read.
///
/// # Errors
/// All refusals of the individual steps: see [`body::pose`], [`rigid`], [`held_and_final`] and [`ring_down`].
pub fn evaluate_tracks(mut tracks: Tracks, request: &MotionRequest) -> Result<Evaluation, MotionError> {
    let mut log = tracks.log.clone();
    let guide = guide(&tracks, request)?;
    let mut states = states(&guide, request, &mut log)?;
    let mut doubts: Vec<String> = audit_log::ends_early(&guide, &tracks.time_s).into_iter().collect();
    doubts.extend(audit_log::without_held(states.held, states.last, request));
    let registration = match (&request.reference, states.missing.take()) {
        // The mean position of a body in motion is not one of its positions
        (Some(_), Some(why)) => return Err(why),
        (Some(path), None) => Some(register(&mut tracks, path, states.held.or(states.last), &mut log)?),
        (None, why) => {
            doubts.extend(why.map(|e| e.to_string()));
            None
        }
    };
    let (poses, curves) = match &request.body {
        Some(body) => body_curves(&tracks, body, states.held.or(states.last), &mut log, &mut doubts)?,
        None => (vec![], marker_curves(&tracks, |_| true)?),
    };
    let curves = with_states(curves, [states.held, states.last], &mut doubts)?;
    let ring_down = match &request.ring_down {
        None => None,
        Some((name, [from, to])) => {
            let known = || curves.iter().map(|c| c.curve.name.clone()).collect();
            let absent = || MotionError::NoCurve { asked: name.clone(), known: known() };
            let at = curves.iter().position(|c| c.curve.name == *name).ok_or_else(absent)?;
            let origin = states.release.as_ref().ok_or(MotionError::Unreleased)?.time_s;
            let found = ring_down(&curves[at].curve, [origin + from, origin + to], origin, request.creep)?;
            log.extend(audit_log::ring_down(name, &found));
            Some((at, found))
        }
    };
    for EvaluatedCurve { curve, held, last, .. } in &curves {
        for (state, plateau) in [("held", held), ("final", last)] {
            doubts.extend(plateau.as_ref().and_then(Plateau::doubt).map(|d| audit_log::doubt(&curve.name, state, &d)));
        }
    }
    let source = tracks.source.clone();
    Ok(Evaluation { source, tracks, registration, release: states.release, poses, curves, ring_down, log, doubts })
}

/// Share of the rows of the marker seen most below which a marker does not tell the states of a record \[–\]
const SEEN: f64 = 0.5;

/// Returns the coordinate with the largest range, from which the states of the record are found: of the markers requested for it, of the body, or else
/// of all; a marker that is seen in few rows, such as a reflection, does not count.
fn guide(tracks: &Tracks, request: &MotionRequest) -> Result<Curve, MotionError> {
    let body = request.body.as_ref().map_or(&[][..], |b| &b.markers);
    let of = |names: &[String]| marker_curves(tracks, |m| names.contains(&m.name));
    let mut curves = of(&request.guides)?;
    if curves.is_empty() {
        curves = of(body)?;
    }
    if curves.is_empty() {
        curves = marker_curves(tracks, |_| true)?;
    }
    let most = curves.iter().map(|c| c.value.len()).max().unwrap_or(0);
    let seen = curves.into_iter().filter(|c| c.value.len() as f64 >= SEEN * most as f64);
    let widest = seen.max_by(|a, b| a.range().total_cmp(&b.range()));
    widest.ok_or_else(|| MotionError::NoMarkers { file: tracks.source.clone() })
}

/// Returns a curve for each coordinate of each of these markers that is ever visible.
fn marker_curves(tracks: &Tracks, is_wanted: impl Fn(&Track) -> bool) -> Result<Vec<Curve>, MotionError> {
    let mut curves = vec![];
    for marker in tracks.markers.iter().filter(|m| is_wanted(m) && m.points.iter().any(Option::is_some)) {
        for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
            let rows = marker.points.iter().enumerate().filter_map(|(i, p)| Some((i, (*p)?[k])));
            let (at, value): (Vec<usize>, Vec<f64>) = rows.unzip();
            let of = |v: &[f64]| at.iter().map(|i| v[*i]).collect();
            let name = format!("{}_{axis}_m", marker.name);
            curves.push(Curve::weighted(&name, of(&tracks.time_s), value, of(&tracks.samples))?);
        }
    }
    Ok(curves)
}

/// Returns the states as requested or as found in the guide curve.
fn states(guide: &Curve, request: &MotionRequest, log: &mut Vec<String>) -> Result<States, MotionError> {
    let rule = &request.plateau;
    let (held, last, missing) = match (request.held_s, request.final_s) {
        (Some(held), Some(last)) => (Some(held), Some(last), None),
        (held, last) => match held_and_final(guide, rule) {
            Ok([a, b]) => (held.or(a.map(|p| p.window_s)), last.or(b.map(|p| p.window_s)), None),
            Err(_) if guide.value.len() < 2 => (held, last, None),
            // A body that never rests still has poses and curves
            Err(e) => (held, last, held.or(last).is_none().then_some(e)),
        },
    };
    log.push(audit_log::states(guide, rule));
    let release = match held {
        None => None,
        Some(window) => {
            let found = release(guide, &Plateau::over(guide, window)?, &request.release)?;
            log.push(audit_log::release(&guide.name, &found, &request.release));
            Some(found)
        }
    };
    // The tolerance extends the plateau into the first rows of the motion
    let end = release.as_ref().filter(|_| request.held_s.is_none()).map(|r| r.time_s);
    let held = held.map(|[from, to]| [from, end.map_or(to, |end| to.min(end))]);
    log.extend(audit_log::windows(held, last));
    Ok(States { held, last, release, missing })
}

/// Registers the state in a window onto the reference positions and transforms all tracks accordingly.
fn register(
    tracks: &mut Tracks,
    path: &Path,
    window: Option<[f64; 2]>,
    log: &mut Vec<String>,
) -> Result<Registration, MotionError> {
    // The reference states its unit itself, which may differ from that of the record
    let reference = Tracks::read(path, &ReadOptions::default())?;
    let window = window.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let shared: Vec<String> = reference
        .markers
        .iter()
        .map(|m| m.name.clone())
        .filter(|n| tracks.markers.iter().any(|m| m.name == *n))
        .collect();
    let measured = tracks.mean(&shared, window)?;
    let known = reference.mean(&shared, [f64::NEG_INFINITY, f64::INFINITY])?;
    let both = measured.iter().zip(&known).zip(&shared);
    let seen: Vec<(Vec3, Vec3, String)> =
        both.filter_map(|((a, b), name)| Some((Vec3::from((*a)?), Vec3::from((*b)?), name.clone()))).collect();
    let used: Vec<String> = seen.iter().map(|s| s.2.clone()).collect();
    if seen.len() < 3 {
        return Err(MotionError::TooFew { found: seen.len(), names: used });
    }
    let (from, to): (Vec<Vec3>, Vec<Vec3>) = seen.iter().map(|s| (s.0, s.1)).unzip();
    let found = rigid(&from, &to, None)?;
    if let Some(mirrored_rms) = found.mirrored_rms {
        return Err(MotionError::Mirrored { reference: reference.source, rms: found.rms, mirrored_rms });
    }
    for point in tracks.markers.iter_mut().flat_map(|m: &mut Track| m.points.iter_mut()).flatten() {
        *point = found.apply(Vec3::from(*point)).into();
    }
    log.extend(audit_log::registration(&found, &used, &reference.source));
    Ok(found)
}

/// Returns curves of the displacement of the point from its held position and of the rotations about the axes.
fn body_curves(
    tracks: &Tracks,
    request: &BodyRequest,
    window: Option<[f64; 2]>,
    log: &mut Vec<String>,
    doubts: &mut Vec<String>,
) -> Result<(Vec<Pose>, Vec<Curve>), MotionError> {
    let names = &request.markers;
    let group = tracks.select(names)?;
    let all_seen = |k: &usize| group.iter().all(|m| m.points[*k].is_some());
    // Without a state, the first row in which the whole group is visible is the reference
    let first = || (0..tracks.time_s.len()).find(all_seen).map(|k| [tracks.time_s[k]; 2]);
    let window = window.or_else(first).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let means = tracks.mean(names, window)?;
    let known: Vec<Vec3> = means.iter().copied().flatten().map(Vec3::from).collect();
    if known.len() < names.len() {
        let unseen = names.iter().zip(&means).filter(|m| m.1.is_none()).map(|m| m.0.clone()).collect();
        return Err(MotionError::NeverSeen { names: unseen });
    }
    let at = request.at.unwrap_or_else(|| known.iter().sum::<Vec3>() / known.len() as f64);
    let poses = body::pose(tracks, names, &known)?;
    log.extend(audit_log::body(names, at, &poses));
    doubts.extend(knock::knocks(&tracks.time_s, &group).iter().map(ToString::to_string));
    doubts.extend(audit_log::deformation(&known, &poses));
    let curve = |name: String, value: &dyn Fn(&Pose) -> f64| {
        let column = |f: &dyn Fn(&Pose) -> f64| poses.iter().map(f).collect::<Vec<f64>>();
        Curve::weighted(&name, column(&|p| p.time_s), column(value), column(&|p| p.samples))
    };
    let axes = [("x", Vec3::x()), ("y", Vec3::y()), ("z", Vec3::z())];
    let mut curves = vec![];
    for (k, (axis, _)) in axes.iter().enumerate() {
        curves.push(curve(format!("displacement_{axis}_m"), &|p| p.displacement(at)[k])?);
    }
    // Rotations are near zero in the reference, and turns are counted from there
    let at_rest = poses.iter().position(|p| p.time_s >= window[0]).unwrap_or(poses.len() - 1);
    for (axis, direction) in axes {
        let name = format!("rotation_{axis}_deg");
        let Curve { time_s, samples, .. } = &curves[0];
        let turns = body::turns_about(&poses, direction, at_rest).into_iter().map(f64::to_degrees).collect();
        let turned = Curve::weighted(&name, time_s.clone(), turns, samples.clone())?;
        curves.push(turned);
    }
    Ok((poses, curves))
}
