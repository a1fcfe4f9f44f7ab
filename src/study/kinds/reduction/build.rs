//! The models of a study: made once from the states of its runs, and kept in `models/` with their record, `derived.json`.

use crate::reduction::{FullState, ReducedModel, Twin};
use crate::report::files;
use crate::scene::{Body, Scene, changed_scene};
use crate::storage::sha256;
use crate::study::kinds::reduction::in_time;
use crate::study::kinds::reduction::record::{
    DerivedRecord, InputRecord, ModelRecord, QuantityRecord, ReductionRecord,
};
use crate::study::kinds::reduction::trained::{Runs, Trained, all_errors, begin, timed_steps};
use crate::study::store::identity::Build;
use crate::study::store::record::{Role, StoredCase};
use crate::study::store::results::Results;
use crate::study::store::states::KeptStates;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// File with the record of the models.
const DERIVED: &str = "derived.json";

/// The record of the models, which are made where the states, the choices or the program have changed. None as long as a run is missing.
pub fn build(results: &Results, record: &ReductionRecord, dir: &Path) -> Result<Option<Value>, String> {
    let of_role = |role: Role| {
        let families = results.study.families.iter().filter(move |f| f.role == role);
        families.flat_map(|f| &f.cases).map(|id| results.cases.iter().find(|c| c.record.id == *id)).collect()
    };
    let [training, held_back]: [Option<Vec<&StoredCase>>; 2] = [of_role(Role::Training), of_role(Role::HeldBack)];
    let (Some(training), Some(held_back)) = (training, held_back) else { return Ok(None) };
    if training.iter().chain(&held_back).any(|c| !c.record.converged()) {
        return Ok(None);
    }
    let sources = sources(record, training.iter().chain(&held_back).copied());
    let path = dir.join(DERIVED);
    let known: Option<DerivedRecord> = files::json(&path).ok().flatten();
    if let Some(known) =
        known.filter(|k| k.sources_sha256 == sources && k.models.iter().all(|m| dir.join(&m.file).is_file()))
    {
        return Ok(serde_json::to_value(known).ok());
    }
    let derived = make(results, record, (&training, &held_back), sources, dir)?;
    let value = serde_json::to_value(derived).map_err(|e| e.to_string())?;
    let text = serde_json::to_string_pretty(&value).map_err(|e| e.to_string())? + "\n";
    files::write(&path, text.as_bytes()).map_err(|e| e.to_string())?;
    Ok(Some(value))
}

/// Digest of everything that the models are made of.
fn sources<'a>(record: &ReductionRecord, cases: impl Iterator<Item = &'a StoredCase>) -> String {
    let mut text = serde_json::to_string(&(record, Build::this())).expect("numbers, strings and string keys only");
    for case in cases {
        case.record.provenance.results.iter().for_each(|file| text += &file.sha256);
    }
    sha256(text)
}

fn make(
    results: &Results,
    record: &ReductionRecord,
    (training, held_back): (&[&StoredCase], &[&StoredCase]),
    sources_sha256: String,
    dir: &Path,
) -> Result<DerivedRecord, String> {
    let (scene, places) = scene(record, training[0])?;
    let quantities = results.study.quantities.values().next().cloned().unwrap_or_default();
    let names: Vec<String> = quantities.iter().map(|q| q.name.clone()).collect();
    let states = |cases: &[&StoredCase], points: &BTreeMap<String, Vec<Vec<f64>>>| {
        let of_case = |case: &&StoredCase| states(case, points, (record, &places), &names, dir);
        Ok::<_, String>(Runs::new(cases.iter().map(of_case).collect::<Result<Vec<_>, String>>()?))
    };
    let (known, others) = (states(training, &record.training)?, states(held_back, &record.held_back)?);
    let start = Instant::now();
    let trained = Trained::new(&scene, record, &known, &names).map_err(|e| e.to_string())?;
    let (singular_values, pressure_values) = trained.singular_values().map_err(|e| e.to_string())?;
    let offline_s = start.elapsed().as_secs_f64();
    files::folder(&dir.join("models")).map_err(|e| e.to_string())?;
    let (mut models, mut left_out) = (vec![], vec![]);
    for &modes in &record.modes {
        let start = Instant::now();
        let model = match trained.model(modes, record.sampling, &others) {
            Ok(model) => model,
            // The other models are not lost by it
            Err(why) => {
                left_out.push(format!("No model with {modes} modes could be made: {why}."));
                continue;
            }
        };
        let offline_s = start.elapsed().as_secs_f64();
        let file = format!("models/{}-{modes}.durom", results.study.study);
        let bytes = model.write(&dir.join(&file)).map_err(|e| e.to_string())?;
        models.push(describe(modes, (file, bytes, offline_s), &model, &known, &others)?);
    }
    let mut steps: Vec<f64> = training.iter().map(|c| c.record.wall_s / c.record.steps.max(1) as f64).collect();
    steps.sort_by(f64::total_cmp);
    Ok(DerivedRecord {
        sources_sha256,
        dt: record.motion.and_then(|_| scene.spans.first().map(|s| s.dt)),
        training: known.count(record),
        held_back: others.count(record),
        singular_values,
        pressure_values,
        full_step_s: steps[steps.len() / 2],
        offline_s,
        models,
        left_out,
    })
}

/// The scene with its inputs left to a controller, and the place of each input of the study among them.
fn scene(record: &ReductionRecord, case: &StoredCase) -> Result<(Scene, Vec<usize>), String> {
    // Different values at the start tell which is which
    let mark = |k: usize, input: &InputRecord| {
        let share = (k + 1) as f64 / (record.inputs.len() + 1) as f64;
        input.range[0] + share * (input.range[1] - input.range[0])
    };
    let change = |(k, input): (usize, &InputRecord)| {
        let text = |value: f64| toml::Value::from(format!("{value} {}", input.unit));
        let mut signal = toml::Table::new();
        signal.insert("kind".into(), "controlled".into());
        signal.insert("initial".into(), text(mark(k, input)));
        signal.insert("range".into(), vec![text(input.range[0]), text(input.range[1])].into());
        (input.key.clone(), signal.into())
    };
    let changes: Vec<(String, toml::Value)> = record.inputs.iter().enumerate().map(change).collect();
    let (spec, text) =
        changed_scene(&record.scene, &case.record.provenance.scene, &changes).map_err(|e| e.to_string())?;
    let body = Body::load(&record.scene, &spec.mesh, &mut |_| {}).map_err(|e| e.to_string())?;
    let scene = Scene::build(&record.scene, spec, text, body.into()).map_err(|e| e.to_string())?;
    let initial = scene.controls.values_from_outside(&scene.controls.memory());
    let place = |(k, input): (usize, &InputRecord)| {
        let factor = factor(&input.unit)?;
        let near =
            |value: &f64| (value - factor * mark(k, input)).abs() <= 1e-9 * factor * (input.range[1] - input.range[0]);
        initial.iter().position(near).ok_or_else(|| format!("input {} drives nothing in the scene", input.name))
    };
    let places = record.inputs.iter().enumerate().map(place).collect::<Result<_, String>>()?;
    Ok((scene, places))
}

/// One unit in SI.
fn factor(unit: &str) -> Result<f64, String> {
    crate::math::units::quantity(&format!("1 {unit}")).map(|q| q.0).map_err(|e| e.to_string())
}

/// The states of a run, but for the first, at rest.
fn states(
    case: &StoredCase,
    points: &BTreeMap<String, Vec<Vec<f64>>>,
    (record, places): (&ReductionRecord, &[usize]),
    names: &[String],
    dir: &Path,
) -> Result<Vec<FullState>, String> {
    let id = &case.record.id;
    let kept = KeptStates::read(dir, id)?;
    let points = points.get(&case.record.member).ok_or_else(|| format!("{id}: its points are not known"))?;
    let column = |name: &String| case.series.columns.get(name).ok_or_else(|| format!("{id}: it has no {name}"));
    let columns: Vec<&Vec<f64>> = names.iter().map(column).collect::<Result<_, _>>()?;
    let rows = kept.x.len();
    let expected = if record.motion.is_some() { rows } else { points.len() + 1 };
    if rows != expected || columns.iter().any(|c| c.len() != rows) || kept.lambda.len() != rows {
        return Err(format!("{id}: it has {rows} states in place of {expected}; run the study again"));
    }
    let factors: Vec<f64> = record.inputs.iter().map(|i| factor(&i.unit)).collect::<Result<_, _>>()?;
    let states = kept.x.into_iter().zip(kept.lambda).enumerate().skip(1).map(|(row, (x, lambda))| {
        let mut inputs = vec![0.0; places.len()];
        let values = match record.motion {
            Some(motion) => in_time::at(&record.inputs, points, motion, kept.t[row]),
            None => points[row - 1].clone(),
        };
        for (k, &place) in places.iter().enumerate() {
            inputs[place] = factors[k] * values[k];
        }
        FullState { inputs, x, lambda, values: columns.iter().map(|c| c[row]).collect() }
    });
    Ok(states.collect())
}

/// Parts that the way between two points is divided into, for the time of a step.
const PARTS: usize = 50;
/// Ways that are timed so.
const WAYS: usize = 40;

fn describe(
    modes: usize,
    (file, bytes, offline_s): (String, usize, f64),
    model: &ReducedModel,
    known: &Runs,
    others: &Runs,
) -> Result<ModelRecord, String> {
    let mut twin = Twin::new(model.clone()).map_err(|e| e.to_string())?;
    let (leap_s, leaps) = times(&mut twin, timed_steps(others).map(|(at_rest, u)| (at_rest, u.to_vec())));
    twin.reset();
    let ways = others.states.windows(2).take(WAYS).flat_map(|w| {
        let between = |k: usize| {
            let share = k as f64 / PARTS as f64;
            w[0].inputs.iter().zip(&w[1].inputs).map(|(a, b)| a + share * (b - a)).collect::<Vec<_>>()
        };
        (1..=PARTS).map(between).collect::<Vec<_>>()
    });
    // The steps of a model that moves have one length
    let small = if twin.dt().is_some() { None } else { Some(times(&mut twin, ways.map(|u| (false, u)))) };
    let (step_s, steps) = small.unwrap_or((leap_s, leaps));
    let all = all_errors(model, others).map_err(|e| e.to_string())?;
    let in_time = model.dynamics.as_ref().and_then(|d| d.estimate.as_ref()).map(|e| &e.enriched.points);
    let estimate_points = in_time.or(model.estimate.as_ref().map(|e| &e.points));
    let count = |points: &[crate::reduction::points::StoredPoints]| points.iter().map(|p| p.weights.len()).sum();
    let quantity = |k: usize| quantity(model, k, &known.states, &all);
    Ok(ModelRecord {
        modes,
        file,
        bytes,
        displacements: model.sizes.displacements,
        pressures: model.sizes.pressures,
        points: count(&model.points),
        estimate_points: estimate_points.map_or(0, |points| count(points)),
        offline_s,
        step_s,
        leap_s,
        iterations: [steps, leaps],
        quantities: (0..model.quantities.len()).map(quantity).collect(),
    })
}

/// Median and 99th percentile of the times of steps to these inputs \[s\], and their iterations on average.
fn times(twin: &mut Twin, inputs: impl Iterator<Item = (bool, Vec<f64>)>) -> ([f64; 2], f64) {
    let (mut all, mut iterations, mut steps) = (vec![], 0.0, 0.0);
    for (at_rest, u) in inputs {
        begin(twin, at_rest);
        let start = Instant::now();
        let done = twin.step(&u);
        all.push(start.elapsed().as_secs_f64());
        if let Ok(report) = done {
            iterations += report.iterations as f64;
            steps += 1.0;
        }
    }
    all.sort_by(f64::total_cmp);
    let at = |share: f64| all.get(((all.len() as f64 * share) as usize).min(all.len().saturating_sub(1))).copied();
    ([at(0.5).unwrap_or(0.0), at(0.99).unwrap_or(0.0)], iterations / f64::max(steps, 1.0))
}

fn quantity(model: &ReducedModel, k: usize, known: &[FullState], all: &[Vec<(f64, f64)>]) -> QuantityRecord {
    let bar = model.bars().map_or((f64::INFINITY, 0.0), |bars| (bars[k].factor, bars[k].floor));
    let errors: Vec<Option<[f64; 2]>> =
        all.iter().map(|row| row[k].0.is_finite().then_some([row[k].0, row[k].1])).collect();
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    };
    let mut sizes: Vec<f64> = errors.iter().flatten().map(|e| e[0].abs()).collect();
    let ratio = |e: &[f64; 2]| bar.0 * (e[1].abs() + bar.1) / e[0].abs();
    let mut ratios: Vec<f64> = errors.iter().flatten().filter(|e| e[0] != 0.0).map(ratio).collect();
    let median_error = median(&mut sizes);
    QuantityRecord {
        name: model.quantities[k].name.clone(),
        size: known.iter().map(|s| s.values[k].abs()).fold(0.0, f64::max),
        largest: sizes.last().copied().unwrap_or(f64::NAN),
        median: median_error,
        factor: bar.0,
        floor: bar.1,
        bar_over_error: median(&mut ratios),
        errors,
    }
}
