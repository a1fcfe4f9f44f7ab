//! Errors of an inverse analysis: the fact and the remedy.

use crate::math::units::UnitError;
use crate::scene::{SceneError, SensitivityError};
use crate::storage::columns::TableError;
use std::path::PathBuf;

#[derive(Debug, thiserror::Error)]
pub enum InverseError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Sensitivity(#[from] SensitivityError),
    #[error("{}: cannot be read: {source}; the path is relative to the study", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    #[error(transparent)]
    Table(#[from] TableError),
    #[error(
        "{}: column \"{column}\" cannot be {is}: {fact}; give `unit`, and `times` where a strain or a stress is meant",
        path.display()
    )]
    Unit { path: PathBuf, column: String, is: String, fact: UnitError },
    #[error("{}: no line holds both numbers: {reason}", path.display())]
    NoRows { path: PathBuf, reason: String },
    #[error("measured.x.is = \"{name}\": the scene prescribes no such signal; take one of: {known}, t_s")]
    NoSignal { name: String, known: String },
    #[error("measured.y.is = \"{name}\": {fact}")]
    NoColumn { name: String, fact: String },
    #[error(
        "measured.y.is = \"{name}\" has no derivative at t = {t} s, like the curvature of a straight line; let the data begin where it has one"
    )]
    NoDerivative { name: String, t: f64 },
    #[error(
        "{name} goes back and forth, so a curve over it is not unique; compare over t_s, or take a protocol that moves in one direction"
    )]
    NotMonotone { name: String },
    #[error("the protocol moves {name} from {from} to {to}, and {rows} data points lie there; widen the protocol")]
    NoOverlap { name: String, from: f64, to: f64, rows: usize },
    #[error(
        "{rows} data points of all curves do not determine {unknowns} unknowns; measure more, or look for fewer constants"
    )]
    TooFew { rows: usize, unknowns: usize },
    #[error("{curve}: every measured value is zero, and any constants would fit it; check the column and its unit")]
    Zero { curve: String },
    #[error(
        "{curve}: its noise cannot be estimated from {rows} data points (five of different x that scatter are needed); take weighting = \"absolute\" \
         or \"relative\", by which each curve counts by its relative misfit"
    )]
    NoNoise { curve: String, rows: usize },
    #[error("{why}")]
    Cycle { why: String },
    #[error("{first} and {second} hold the same numbers, and would count as two measurements; give each curve once")]
    SameData { first: String, second: String },
    #[error(
        "{curve}: the measured values change against {column} of the scene (cosine between both {cosine:.3}), and no constants of laws turn it; \
         give y the other sign, in a study by times = \"-1\", or check which column it is"
    )]
    Sign { curve: String, column: String, cosine: f64 },
    #[error("{key}: it moves {name}, over which the curve is compared; compare over t_s, or look for another number")]
    MovesX { key: String, name: String },
    #[error("{}", wrong.join("; "))]
    Unknowns { wrong: Vec<String> },
    #[error(
        "curve {curve} has another scene than the study, and does not say what the member \"{member}\" ({keys}) changes there; give it \
         members = {{ \"{member}\" = {{ … }} }} with the keys of its scene, an empty table where nothing changes"
    )]
    OtherScene { curve: String, member: String, keys: String },
    #[error("{key} = \"{text}\": {fact}")]
    Setting { key: &'static str, text: String, fact: String },
    #[error("gauge.{key} = \"{text}\": {fact}")]
    Gauge { key: &'static str, text: String, fact: UnitError },
}
