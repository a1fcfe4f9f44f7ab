//! Inverse analysis: constants of laws and other numbers of a scene from curves measured on whole specimens or robots, by simulating them.
//!
//! min ½Σ wᵢ²(ŷ(xᵢ; θ) − yᵢ)² with ŷ from a scene and weights that follow the answer, ∂ŷ/∂θ exact ([`crate::scene::Scene::run_with`]). The specimen
//! is modelled as a whole: its wide ends stretch too, and the travel of the crosshead needs no gauge length. Several curves, each with its own scene,
//! share the constants.
//!
//! Intervals: the linearised problem with the model of the errors that the residuals show, as in a direct fit. Curves of one test on several
//! specimens (the same scene file, x and y) count by the scatter between the specimens.

mod answer;
mod bound;
mod determined;
mod error;
mod gauge;
mod measured;
mod model;
mod objective;
mod observed;
mod offset;
mod profile;
mod rounds;
mod scatter;
mod search;
mod unknown;
mod weights;

pub use answer::{Calibration, FittedConstant, FittedCurve, Gauge, Stable};
pub use bound::Bound;
pub use error::InverseError;
pub use measured::{ColumnSpec, Measured, MeasuredSpec};
pub use model::{Failure, SceneModel};
pub use objective::SearchWatch;
pub use observed::ObservedCurve;
pub use offset::OffsetAxis;
pub use search::End;
pub use unknown::{Bounds, Unknown};

use super::judgement::certificate::{CASES, range};
use super::judgement::correlation::Correlation;
use super::judgement::errors::Errors;
use super::judgement::identify::{self, Identified};
use super::solve::error_rows::ErrorRows;
use super::{Direction, ErrorModel, Estimate, FitWarning, Loss, Mode, Weighting};
use crate::material::{Parameter, StabilityLimit, material_stability};
use crate::math::statistics;
use crate::scene::stretch::stretches;
use crate::scene::{Scene, unit_of_column};
use determined::{Coordinates, Searched};
use model::ModelAnswer;
use nalgebra::DVector;
use objective::{Objective, Point};
use rounds::{rounds, search_again};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// Relative difference below which differences are errors of the forward solve: Newton's method stops at 1e-8 \[–\]
const ROUNDING: f64 = 1e-7;
/// Largest number of searches with weights from the previous answer, and the change of a weight below which they end
const REWEIGHTED: usize = 12;
const SAME: f64 = 1e-3;
/// Unknowns whose change alone was never searched: the unsearched part of it, times the number of unknowns, from which on an unknown counts as left
/// at its start. For one direction that was not searched these parts add up to 1 \[–\]
const LEFT: f64 = 0.9;

/// Options in addition to scenes and curves.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Settings {
    pub weighting: Weighting,
    pub loss: Loss,
    /// Length and cross-section of a homogeneous piece \[m, m²\], from which the search starts and whose error it corrects
    pub gauge: Option<[f64; 2]>,
    /// Whether intervals by profile likelihood are computed too, at the cost of more forward solves
    pub profile: bool,
    /// Accuracy to which the scenes can reproduce the curves \[–\]; it decides which directions count as determined
    pub accuracy: f64,
    /// Wall time after which no forward solve begins \[s\]
    pub time_budget: Option<f64>,
}

impl Settings {
    /// Settings of a plain search with this weighting: one per cent of accuracy, no time budget.
    pub fn new(weighting: Weighting) -> Self {
        Self { weighting, loss: Loss::Squares, gauge: None, profile: false, accuracy: 0.01, time_budget: None }
    }
}

/// A finished search, with the data that its judgement needs.
struct Answered {
    found: search::SearchResult,
    coordinates: Coordinates,
    start: Vec<f64>,
    gauge: Option<Gauge>,
    /// Descriptions of the open directions
    open: Vec<String>,
    /// For each unknown, whether the search left it at its start
    left: Vec<bool>,
}

/// Finds the constants that all curves share. `from`: values of all unknowns from which a search continues ([`Calibration::values`], or the last
/// values passed to [`SearchWatch::better`]). Also returns the scene of the first curve at the answer.
pub fn calibrate(
    mut curves: Vec<ObservedCurve>,
    settings: &Settings,
    from: Option<&[f64]>,
    watch: &mut dyn SearchWatch,
) -> Result<(Calibration, Scene), Failure> {
    let begin = Instant::now();
    // All curves start with the constants of the first one
    let starts: Vec<f64> = curves[0].model.unknown.iter().map(|u| u.start).collect();
    for curve in &mut curves {
        curve.model.unknown.iter_mut().zip(&starts).for_each(|(u, start)| u.start = *start);
        let reached = curve.model.reached(&curve.measured)?;
        keep(&mut curve.measured, &reached, &curve.model.x);
    }
    let unknown = curves[0].model.unknown.clone();
    let mut objective = Objective::new(&curves, settings.weighting, watch).map_err(Failure::Input)?;
    let (rows, unknowns) = (objective.weights.iter().map(Vec::len).sum(), unknown.len() + objective.offsets.len());
    if rows <= unknowns {
        return Err(Failure::Input(InverseError::TooFew { rows, unknowns }));
    }
    let until = settings.time_budget.map(|s| begin + Duration::from_secs_f64(s));
    let Answered { found, coordinates, start, gauge, open, left } =
        find(&mut objective, &unknown, settings, from, until)?;
    let (solves, failed) = (objective.solves, objective.failed);
    let search::SearchResult { point, bound, end } = found;
    let Judged { errors, identified, places, pattern } = judge(&objective, &unknown, &point, &bound);
    let is_sound = |k: usize| {
        places[k].is_some_and(|i| identified.estimates[i].std_error.is_finite())
            && !coordinates.is_open(k, settings.accuracy)
    };
    objective.end_telling();
    let ends = match settings.profile && end == End::Settled {
        true => {
            let spread = |v: &[f64]| places.iter().map(|i| i.map_or(f64::INFINITY, |i| v[i])).collect();
            let errors =
                Errors { deviations: spread(&errors.deviations), plain: spread(&errors.plain), ..errors.clone() };
            Some(profile::ends(&mut objective, &unknown, &point, &errors, &is_sound)?)
        }
        false => None,
    };
    let found = |k: usize| {
        let estimate = places[k].map(|i| &identified.estimates[i]).filter(|_| is_sound(k));
        let key = unknown.get(k).map_or_else(|| "offset".into(), |u| u.key.to_string());
        let profile = ends.as_ref().and_then(|ends| ends.get(k).copied());
        let found = (start[k], point.values[k], bound[k]);
        FittedConstant {
            left: left[k] && bound[k].is_free() && end != End::OutOfTime,
            ..one(&key, parameter(&objective, &unknown, k), found, estimate, profile)
        }
    };
    let all: Vec<FittedConstant> = (0..point.values.len()).map(found).collect();
    let constants = all[..unknown.len()].to_vec();
    let directions = identified.directions.iter().filter(|_| open.is_empty());
    let unidentified = doubts(open.iter().cloned().chain(words(directions)), &constants, &unknown);
    let covariance = (0..unknown.len()).all(is_sound).then(|| {
        let of = |a: usize, b: usize| errors.covariance[(places[a].expect("sound"), places[b].expect("sound"))];
        (0..unknown.len()).map(|a| (0..unknown.len()).map(|b| of(a, b)).collect()).collect()
    });
    let sum = |of: fn(&ModelAnswer) -> f64| point.answers.iter().map(of).sum::<f64>();
    let calibration = Calibration {
        unidentified,
        covariance,
        errors: errors.model,
        free: errors.free,
        curves: fitted(&objective, &point, (&errors, &pattern), &all[unknown.len()..]),
        constants,
        gauge,
        solves,
        profile_solves: objective.solves - solves,
        failed,
        end,
        forward_s: sum(|a| a.forward),
        gradient_s: sum(|a| a.gradient),
        wall_s: begin.elapsed().as_secs_f64(),
    };
    let scene = point.answers.into_iter().next().expect("there is a curve").scene;
    Ok((calibration, scene))
}

/// Searches from the start in the file, from the fit with a gauge length, or from an earlier search.
fn find(
    objective: &mut Objective,
    unknown: &[Unknown],
    settings: &Settings,
    from: Option<&[f64]>,
    until: Option<Instant>,
) -> Result<Answered, Failure> {
    let curve = &objective.curves[0];
    let mut stated: Vec<f64> = unknown.iter().map(|u| u.start).collect();
    stated.resize(unknown.len() + objective.offsets.len(), 0.0);
    let gauge = settings.gauge.map(|g| gauge::fit(&curve.model, &curve.measured, settings.weighting, g));
    let of_gauge = gauge.iter().flat_map(|g| &g.values).chain(std::iter::repeat(&None));
    let mut first: Vec<f64> = stated.iter().zip(of_gauge).map(|(value, found)| found.unwrap_or(*value)).collect();
    let within = |values: &mut [f64]| {
        values.iter_mut().zip(unknown).for_each(|(value, u)| *value = value.clamp(u.bounds[0], u.bounds[1]));
    };
    within(&mut first);
    let kept = from.filter(|v| v.len() == stated.len() && v.iter().all(|x| x.is_finite()));
    let mut start = kept.map_or(first.clone(), <[f64]>::to_vec);
    within(&mut start);
    let point = match objective.at(&start) {
        // The scene cannot have the constants of the fit with a gauge length
        Err(Failure::Constants(_) | Failure::Run(_)) if start != stated => {
            (start, first) = (stated.clone(), stated);
            objective.at(&start)?
        }
        point => point?,
    };
    objective.check_signs(&point).map_err(Failure::Input)?;
    let accuracy = settings.accuracy.max(ROUNDING);
    let mut point = with_offsets(objective, point)?;
    if kept.is_some() {
        (point, _) = reweighed(objective, Loss::Squares, point);
    }
    let mut shares = vec![0.0; start.len()];
    let mut found = search_again(objective, unknown, accuracy, (point, &first), until, &mut shares)?;
    for _ in 0..REWEIGHTED {
        let change;
        (found.point, change) = reweighed(objective, settings.loss, found.point);
        if change < SAME || found.end == End::OutOfTime {
            break;
        }
        found = rounds(objective, unknown, accuracy, found.point, until, &mut shares)?;
    }
    let (spec, curves) = (&objective.curves[0].model.spec, &objective.origin.curves);
    let which = Searched::Told { accuracy, curves };
    let coordinates = Coordinates::new(unknown, spec, &found.point, objective.size(), which);
    let open = coordinates.words(unknown, spec, &found.point.values, accuracy);
    let left = shares.iter().map(|share| (1.0 - share) * shares.len() as f64 > LEFT).collect();
    Ok(Answered { found, coordinates, start: first, gauge, open, left })
}

/// The same answer with weights recomputed from it, and their largest change.
fn reweighed(objective: &mut Objective, loss: Loss, point: Point) -> (Point, f64) {
    let change = objective.reweigh(loss, &point);
    (objective.point(point.values, point.answers), change)
}

/// The start with the offsets that describe its curves best, each curve up to its own factor; the curve of one forward solve serves all offsets.
fn with_offsets(objective: &mut Objective, point: Point) -> Result<Point, Failure> {
    let mut values = point.values.clone();
    for of in 0..objective.curves.len() {
        objective.guess_offsets(of, &point.answers[of], &mut values);
    }
    if values == point.values {
        return Ok(point);
    }
    let point = objective.at(&values)?;
    objective.weigh(&values, &point.answers);
    Ok(objective.point(values, point.answers))
}

/// Errors and estimates of the unknowns that are not held at a bound.
struct Judged {
    errors: Errors,
    identified: Identified,
    /// Index of each unknown among them
    places: Vec<Option<usize>>,
    /// Residual divided by the sizes of its errors, which is tested for a pattern
    pattern: DVector<f64>,
}

fn judge(objective: &Objective, unknown: &[Unknown], point: &Point, bound: &[Bound]) -> Judged {
    let free: Vec<usize> = (0..bound.len()).filter(|k| bound[*k].is_free()).collect();
    let places = (0..bound.len()).map(|k| free.iter().position(|f| *f == k)).collect();
    let jacobian = point.jacobian.select_columns(&free);
    let size = objective.size();
    let (origin, rounding) = (&objective.origin, point.residual.norm() <= ROUNDING * size);
    let [weight, share] = [&objective.weights, &objective.shares].map(|rows| rows.concat());
    let rows = ErrorRows::of(jacobian.clone(), &point.residual, &point.changes(), &weight, &share);
    let errors = rows.errors(&jacobian, origin, rounding);
    let parameters: Vec<Parameter> = free.iter().map(|k| parameter(objective, unknown, *k)).collect();
    let values: Vec<f64> = free.iter().map(|k| point.values[*k]).collect();
    // An offset may be zero: the interval that remains open is compared with the curve instead
    let bases: Vec<f64> = free.iter().map(|k| if *k < unknown.len() { point.values[*k] } else { 0.0 }).collect();
    let values = (values.as_slice(), bases.as_slice());
    let identified = identify::identify(&parameters, values, &jacobian, &point.residual, size, ROUNDING, Some(&errors));
    let pattern = rows.over(errors.sizes.as_ref()).unlimited;
    Judged { errors, identified, places, pattern }
}

fn parameter(objective: &Objective, unknown: &[Unknown], k: usize) -> Parameter {
    unknown.get(k).map_or_else(|| objective.offsets[k - unknown.len()].axis.parameter(), |u| u.parameter)
}

/// An unknown with its interval; without an estimate it has no interval.
fn one(
    key: &str,
    parameter: Parameter,
    (start, value, bound): (f64, f64, Bound),
    estimate: Option<&Estimate>,
    profile: Option<[Option<f64>; 2]>,
) -> FittedConstant {
    FittedConstant {
        key: key.into(),
        symbol: parameter.symbol.into(),
        unit: super::fittable_law::unit(&parameter).into(),
        start,
        value,
        std_error: estimate.map(|e| e.std_error),
        interval: estimate.map(|e| e.interval).filter(|ends| ends.iter().all(|x| x.is_finite())),
        profile: profile.filter(|_| estimate.is_some()),
        bound,
        left: false,
    }
}

/// Every curve with its scene at the answer.
fn fitted(
    objective: &Objective,
    point: &Point,
    (errors, pattern): (&Errors, &DVector<f64>),
    offsets: &[FittedConstant],
) -> Vec<FittedCurve> {
    // Each specimen has its own level, which is not a pattern
    let is_apart = matches!(errors.model, ErrorModel::Specimens { .. } | ErrorModel::Levels { .. });
    let one = |(of, curve): (usize, &ObservedCurve)| {
        let (answer, m) = (&point.answers[of], &curve.measured);
        let own: Vec<(&objective::Offset, &FittedConstant)> =
            objective.offsets.iter().zip(offsets).filter(|(o, _)| o.of == of).collect();
        let zero = own.iter().find(|(o, _)| o.axis == OffsetAxis::Zero).map_or(0.0, |(_, f)| f.value);
        let predicted: Vec<f64> = answer.y.iter().map(|y| y + zero).collect();
        let square = |v: &mut dyn Iterator<Item = f64>| v.map(|r| r * r).sum::<f64>();
        let r2 = square(&mut m.y.iter().zip(&predicted).map(|(a, b)| a - b));
        let changes = square(&mut m.y.iter().map(|y| y - zero - answer.at_rest()));
        let y2 = if changes > 0.0 { changes } else { square(&mut m.y.iter().copied()) };
        let [median, p95, largest, _] = stretches(&answer.scene.elastic, &answer.run.last.x)[..] else {
            unreachable!("the probe has four columns")
        };
        let mut measured = m.clone();
        if let Some(share) = model::jump(&answer.curve).filter(|_| curve.model.x != "t_s") {
            let remedy =
                "let it act in a stage of its own before x moves, or leave out the first data points by `range`";
            let fact = "off the curve of the next ones, as by a load that acts from the beginning";
            let share = 100.0 * share;
            measured.notes.push(format!(
                "the first {} of the scene is {share:.0} % of its range {fact}: {remedy}",
                curve.model.y
            ));
        }
        let name = |f: &FittedConstant, axis| {
            let (key, column) = match axis {
                OffsetAxis::Slack => ("slack", &curve.model.x),
                OffsetAxis::Zero => ("zero", &curve.model.y),
            };
            FittedConstant { key: format!("{key} of {}", curve.name), unit: unit_of_column(column).into(), ..f.clone() }
        };
        FittedCurve {
            name: curve.name.clone(),
            x: curve.model.x.clone(),
            y: curve.model.y.clone(),
            measured,
            curve: answer.curve.clone(),
            rms_relative: (r2 / y2).sqrt(),
            rms: (r2 / m.y.len() as f64).sqrt(),
            runs_p: if is_apart { None } else { few_runs(pattern, &objective.origin.curves[of], errors.correlation) },
            offsets: own.iter().map(|(o, f)| name(f, o.axis)).collect(),
            stretch: [median, p95, largest],
            stability: certificate(&answer.scene, largest),
            predicted,
        }
    };
    objective.curves.iter().enumerate().map(one).collect()
}

/// p of the runs test on the signs of the residuals in the order of x, with the correlation of neighbours removed.
fn few_runs(residual: &DVector<f64>, rows: &[usize], correlation: Correlation) -> Option<f64> {
    let left = correlation.whitened(residual, std::slice::from_ref(&rows.to_vec()));
    let signs: Vec<bool> = left.iter().filter(|r| **r != 0.0).map(|r| *r > 0.0).collect();
    statistics::few_runs(&signs).map(|(_, p)| p)
}

/// Leaves out the data points that the protocol does not reach.
fn keep(measured: &mut Measured, reached: &[bool], name: &str) {
    let lost = reached.iter().filter(|r| !**r).count();
    if lost == 0 {
        return;
    }
    let chosen: Vec<usize> = (0..reached.len()).filter(|k| reached[*k]).collect();
    measured.x = chosen.iter().map(|k| measured.x[*k]).collect();
    measured.y = chosen.iter().map(|k| measured.y[*k]).collect();
    measured.lines = chosen.iter().map(|k| measured.lines[*k]).collect();
    measured
        .notes
        .push(format!("of {} data points {lost} beyond the range of the protocol in {name} left out", reached.len()));
}

/// Describes the directions in the same words as a direct fit.
fn words<'a>(directions: impl Iterator<Item = &'a Direction>) -> Vec<String> {
    directions.map(|d| FitWarning::Unidentifiable { directions: vec![d.clone()] }.to_string()).collect()
}

/// Everything that the curves do not determine: these directions, and for the constants open ends, impossible values, values left at the start, and
/// bounds.
fn doubts(directions: impl Iterator<Item = String>, constants: &[FittedConstant], unknown: &[Unknown]) -> Vec<String> {
    let beyond = constants.iter().zip(unknown).filter_map(|(f, u)| f.beyond(u.parameter.bounds));
    let of = |words: fn(&FittedConstant) -> Option<String>| constants.iter().filter_map(words);
    let ends = of(FittedConstant::open_end).chain(beyond);
    directions.chain(ends).chain(of(FittedConstant::left_at_start)).chain(of(FittedConstant::held)).collect()
}

/// Ranges of material stability of the laws of the scene, up to 1.5 times the largest stretch in it.
fn certificate(scene: &Scene, largest: f64) -> Vec<Stable> {
    let top = (1.5 * largest).max(2.0);
    let of = |(name, table): (&String, &toml::Table)| {
        let law = scene.spec.known_laws.law(table).ok()?;
        let one = |(case, mode): (crate::material::LoadCase, Mode)| {
            let looked = range(case, top);
            let found = material_stability(law.as_ref(), case, looked).ok()?;
            let amount = |limit: Option<StabilityLimit>| limit.map(|l| l.amount);
            let (below, above) = (amount(found.below), amount(found.above));
            Some(Stable { law: name.clone(), mode: mode.name().into(), looked, below, above })
        };
        Some(CASES.into_iter().filter_map(one).collect::<Vec<_>>())
    };
    scene.spec.laws.iter().filter_map(of).flatten().collect()
}
