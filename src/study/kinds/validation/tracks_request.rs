//! How the tracks of a record are read, and why they may give no measured value.

use crate::math::tensor::Vec3;
use crate::math::units::{self, Dimension};
use crate::motion::release::ReleaseRule;
use crate::motion::{BodyRequest, MotionError, MotionRequest, ReadOptions, amount};
use crate::study::kinds::validation::spec::TracksSpec;
use std::path::Path;

/// Reason why tracks give no measured value.
#[derive(Debug, thiserror::Error)]
pub enum TracksError {
    #[error("tracks: there is no file; list one or more in `files`")]
    NoFile,
    #[error("tracks: {key}: {why}")]
    Key { key: &'static str, why: String },
    #[error("tracks {file}: {source} (options of the program are keys of the tracks here)")]
    Motion { file: String, source: MotionError },
    #[error(
        "tracks {file}: {curve} has no {state} state, by which \"{value}\" is measured; state its window with `{state}`"
    )]
    NoState { file: String, curve: String, state: &'static str, value: &'static str },
    #[error(
        "tracks {file}: the {state} state of {curve} drifts by {} in {duration_s:.3} s, which is more than a plateau may change by ({}); state a window in which it rests with `{state}`, or record longer",
        amount(*.change, .curve),
        amount(*.limit, .curve)
    )]
    Drifts { file: String, curve: String, state: &'static str, change: f64, duration_s: f64, limit: f64 },
    #[error(
        "tracks {file}: the {state} state of {curve} does not rest: its values deviate by {} from their mean (rms), which is more than those of a plateau may ({}); state a window in which it rests with `{state}`",
        amount(*.deviation, .curve),
        amount(*.limit, .curve)
    )]
    Moves { file: String, curve: String, state: &'static str, deviation: f64, limit: f64 },
    #[error("tracks: {0}")]
    Repeats(MotionError),
    #[error("tracks {file}: there was no release, from which the window of a ring-down counts")]
    NoRelease { file: String },
    #[error("curve {curve}: {why}")]
    Unit { curve: String, why: String },
}

/// Returns the request for the evaluation, without the file.
pub fn request(base: &Path, spec: &TracksSpec) -> Result<MotionRequest, TracksError> {
    let read = |key: &'static str, text: &String, dimension| {
        units::parse(text, dimension).map_err(|e| TracksError::Key { key, why: e.to_string() })
    };
    let window = |key: &'static str, texts: &Option<[String; 2]>| {
        let Some([a, b]) = texts else { return Ok(None) };
        match (read(key, a, Dimension::TIME)?, read(key, b, Dimension::TIME)?) {
            (a, b) if a < b => Ok(Some([a, b])),
            _ => Err(TracksError::Key { key, why: "it ends before it begins".into() }),
        }
    };
    let at = match &spec.at {
        None => None,
        Some(texts) => {
            let all = texts.iter().map(|t| read("at", t, Dimension::LENGTH)).collect::<Result<Vec<_>, _>>()?;
            Some(Vec3::from_vec(all))
        }
    };
    if at.is_some() && spec.body.is_none() {
        return Err(TracksError::Key { key: "at", why: "it is a point of a `body`; name its markers".into() });
    }
    let release = match spec.threshold.as_ref().map(|t| read("threshold", t, Dimension::LENGTH)).transpose()? {
        None => ReleaseRule::default(),
        Some(threshold) if threshold > 0.0 => ReleaseRule { factor: 0.0, threshold, ..ReleaseRule::default() },
        Some(_) => return Err(TracksError::Key { key: "threshold", why: "a departure is above zero".into() }),
    };
    Ok(MotionRequest {
        read: ReadOptions {
            unit: spec.unit.clone(),
            time_unit: spec.time_unit.clone(),
            rate_hz: spec.rate.as_ref().map(|t| read("rate", t, Dimension::FREQUENCY)).transpose()?,
            record: spec.record.clone(),
        },
        body: spec.body.clone().map(|markers| BodyRequest { markers, at }),
        reference: spec.reference.as_ref().map(|path| base.join(path)),
        held_s: window("held", &spec.held)?,
        final_s: window("final", &spec.last)?,
        release,
        ..MotionRequest::default()
    })
}
