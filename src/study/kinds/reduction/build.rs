//! The models of a study: made once from the states of its runs, and kept in `models/` with their record, `derived.json`.

use crate::math::statistics::median;
use crate::math::stopwatch::Stopwatch;
use crate::reduction::training::train::EXACT;
use crate::reduction::{ReducedModel, Twin};
use crate::report::files;
use crate::storage::{self, DATA_LIMIT, sha256, writing};
use crate::study::kind::Underived;
use crate::study::kinds::reduction::in_time;
use crate::study::kinds::reduction::meshes::{compare, step};
use crate::study::kinds::reduction::prepared::{Prepared, converged};
use crate::study::kinds::reduction::record::{DerivedRecord, ModelRecord, QuantityRecord, ReductionRecord};
use crate::study::kinds::reduction::search::round;
use crate::study::kinds::reduction::trained::{Runs, all_errors, begin, timed_steps};
use crate::study::rounds::Rounds;
use crate::study::store::identity::Build;
use crate::study::store::record::{Role, StoredCase};
use crate::study::store::results::Results;
use serde_json::Value;
use std::path::Path;
use std::time::Instant;

/// File with the record of the models.
const DERIVED: &str = "derived.json";

/// Returns the record of the models, which are made again if the states, the choices or the program have changed; if another build cannot make them
/// because the files or the mesh of the scene have changed, the existing models are kept. `None` as long as a run is missing.
pub fn build(results: &Results, record: &ReductionRecord, dir: &Path) -> Result<Option<Value>, Underived> {
    let (Some(training), Some(held_back)) = (converged(results, Role::Training), converged(results, Role::HeldBack))
    else {
        return Ok(None);
    };
    let rounds = Rounds::read(dir);
    if record.greedy.is_some() && !rounds.has_ended() {
        // If the search cannot continue, it says why
        round(results, record, dir)?;
        return Err("the search for training states has not ended; run the study again to go on".to_string().into());
    }
    let compared = [Role::Reference, Role::Sizes].map(|role| converged(results, role).unwrap_or_default()).concat();
    let cases = training.iter().chain(&held_back).chain(&compared).copied();
    let sources = Sources::of(record, &results.study.columns(), cases);
    if let Some(known) = kept(dir).filter(|known| known.sources_sha256 == sources.all) {
        return Ok(again(&known, dir));
    }
    let derived = match make(results, record, (&training, &held_back), &sources, dir) {
        Ok(derived) => derived,
        Err(why) => return Ok(again(&of_another_build(why, &sources.states, dir)?, dir)),
    };
    let value = serde_json::to_value(derived).map_err(|e| e.to_string())?;
    let text = serde_json::to_string_pretty(&value).map_err(|e| e.to_string())? + "\n";
    files::write(&dir.join(DERIVED), text.as_bytes()).map_err(|e| e.to_string())?;
    Ok(Some(value))
}

/// The record of the models, if their files are unchanged since it was written.
fn kept(dir: &Path) -> Option<DerivedRecord> {
    let known: DerivedRecord = files::json(&dir.join(DERIVED)).ok().flatten()?;
    let is_own = |m: &ModelRecord| storage::read(&dir.join(&m.file), DATA_LIMIT).is_ok_and(|b| sha256(b) == m.sha256);
    known.models.iter().all(is_own).then_some(known)
}

/// The record of models that another build has made from these states, if the only reason not to make them again is that the files or the mesh of the
/// scene have changed.
fn of_another_build(why: Underived, states: &str, dir: &Path) -> Result<DerivedRecord, Underived> {
    let stays = matches!(why, Underived::NotAsComputed(_));
    let Some(mut known) = kept(dir).filter(|known| stays && known.states_sha256 == states) else { return Err(why) };
    known.left_out.push(format!("The models are those of another build of the program, not made anew: {why}."));
    Ok(known)
}

/// The record of models that are not made again; their files are registered as part of the report.
fn again(known: &DerivedRecord, dir: &Path) -> Option<Value> {
    let models = known.models.iter().map(|model| model.file.as_str());
    models.chain([DERIVED]).for_each(|file| writing::note(&dir.join(file)));
    serde_json::to_value(known).ok()
}

/// Digests of everything that the models are made of.
struct Sources {
    /// Digest of the states and the choices
    states: String,
    /// Digest that also includes the program
    all: String,
}

impl Sources {
    fn of<'a>(record: &ReductionRecord, columns: &[&str], cases: impl Iterator<Item = &'a StoredCase>) -> Self {
        let mut text = serde_json::to_string(&(record, columns)).expect("numbers, strings and string keys only");
        for case in cases {
            case.record.provenance.results.iter().for_each(|file| text += &file.sha256);
        }
        let states = sha256(text);
        let all = sha256(format!("{states}{:?}", Build::this()));
        Self { states, all }
    }
}

fn make(
    results: &Results,
    record: &ReductionRecord,
    (training, held_back): (&[&StoredCase], &[&StoredCase]),
    sources: &Sources,
    dir: &Path,
) -> Result<DerivedRecord, Underived> {
    if record.motion.is_some() {
        let runs = training.iter().chain(held_back).map(|case| (&*case.record.id, case.record.cuts));
        in_time::uncut(training[0].record.dt_s, runs)?;
    }
    let prepared = Prepared::of(results, record, &[training, held_back].concat(), dir)?;
    let states = |cases| Ok::<_, String>(Runs::new(prepared.runs(cases, record, dir)?));
    let (known, others) = (states(training)?, states(held_back)?);
    let start = Instant::now();
    let trained = prepared.trained(record, &known)?;
    let (singular_values, pressure_values) = trained.singular_values().map_err(|e| e.to_string())?;
    let offline_s = start.elapsed().as_secs_f64();
    let (mut models, mut left_out, mut made) = (vec![], vec![], vec![]);
    for &modes in &record.modes {
        let start = Instant::now();
        let mut model = match trained.model(modes, record.sampling, &others) {
            Ok(model) => model,
            // The other models are still made
            Err(why) => {
                left_out.push(format!("No model with {modes} modes could be made: {why}."));
                continue;
            }
        };
        let offline_s = start.elapsed().as_secs_f64();
        prepared.complete(&mut model);
        let file = format!("models/{}-{modes}.durom", results.study.study);
        models.push(describe(modes, (file, offline_s), &model, &others)?);
        made.push(model);
    }
    let comparison = compare(results, record, (&prepared, &made));
    files::folder(&dir.join("models")).map_err(|e| e.to_string())?;
    for (of, model) in models.iter().zip(&made) {
        model.write(&dir.join(&of.file)).map_err(|e| e.to_string())?;
    }
    let steps: Vec<f64> = held_back.iter().zip(&others.runs).map(|(case, run)| step(case, run.len())).collect();
    Ok(DerivedRecord {
        sources_sha256: sources.all.clone(),
        states_sha256: sources.states.clone(),
        dt: record.motion.and_then(|_| prepared.scene.spans.first().map(|s| s.dt)),
        training: known.count(record),
        held_back: others.count(record),
        singular_values,
        pressure_values,
        full_step_s: median(&steps),
        full_from_rest: record.motion.is_none() && others.runs.iter().all(|run| run.len() == 1),
        offline_s,
        search: Rounds::read(dir).rounds.iter().filter_map(|r| serde_json::from_value(r.record.clone()).ok()).collect(),
        comparison,
        models,
        left_out,
    })
}

/// Number of steps into which the path between two points is divided to time a step.
const PARTS: usize = 50;
/// Number of paths that are timed in this way.
const WAYS: usize = 40;

fn describe(
    modes: usize,
    (file, offline_s): (String, f64),
    model: &ReducedModel,
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
    // The steps of a model that moves all have one length
    let small = if twin.dt().is_some() { None } else { Some(times(&mut twin, ways.map(|u| (false, u)))) };
    let (step_s, steps) = small.unwrap_or((leap_s, leaps));
    let all = all_errors(model, others).map_err(|e| e.to_string())?;
    let in_time = model.estimate_in_time.as_ref().map(|e| &e.enriched.points);
    let estimate_points = in_time.or(model.estimate.as_ref().map(|e| &e.points));
    let count = |points: &[crate::reduction::points::StoredPoints]| points.iter().map(|p| p.weights.len()).sum();
    let quantity = |k: usize| quantity(model, k, &all);
    let content = model.to_bytes();
    Ok(ModelRecord {
        modes,
        file,
        bytes: content.len(),
        sha256: sha256(content),
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

/// Median and 99th percentile of the CPU times of steps to these inputs \[s\], and their mean number of iterations. Steps without a result do not
/// count.
fn times(twin: &mut Twin, inputs: impl Iterator<Item = (bool, Vec<f64>)>) -> ([f64; 2], f64) {
    let (mut all, mut iterations) = (vec![], 0.0);
    for (at_rest, u) in inputs {
        begin(twin, at_rest);
        let stopwatch = Stopwatch::start();
        if let Ok(report) = twin.step(&u) {
            // On some systems the CPU clock is too coarse for a single step
            let spent = stopwatch.spent();
            all.push(if spent.cpu_s > 0.0 { spent.cpu_s } else { spent.wall_s });
            iterations += report.iterations as f64;
        }
    }
    if all.is_empty() {
        return ([0.0; 2], 0.0);
    }
    all.sort_by(f64::total_cmp);
    let last = all[((all.len() as f64 * 0.99) as usize).min(all.len() - 1)];
    ([median(&all), last], iterations / all.len() as f64)
}

fn quantity(model: &ReducedModel, k: usize, all: &[Vec<(f64, f64)>]) -> QuantityRecord {
    let bar = model.bars().map_or((f64::INFINITY, 0.0), |bars| (bars[k].factor, bars[k].floor));
    let errors: Vec<Option<[f64; 2]>> =
        all.iter().map(|row| row[k].0.is_finite().then_some([row[k].0, row[k].1])).collect();
    let sizes: Vec<f64> = errors.iter().flatten().map(|e| e[0].abs()).collect();
    let ratio = |e: &[f64; 2]| bar.0 * (e[1].abs() + bar.1) / e[0].abs();
    let is_more = |e: &&[f64; 2]| e[0].abs() > EXACT * model.largest_changes[k];
    let ratios: Vec<f64> = errors.iter().flatten().filter(is_more).map(ratio).collect();
    QuantityRecord {
        name: model.quantities[k].name.clone(),
        size: model.largest_changes[k],
        largest: sizes.iter().copied().reduce(f64::max).unwrap_or(f64::NAN),
        median: median(&sizes),
        factor: bar.0,
        floor: bar.1,
        bar_over_error: median(&ratios),
        errors,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::kinds::reduction::analysis::tests::found;

    /// Models of another build are kept if only the files of the scene have changed, but not if this build refuses the states that they were made of.
    #[test]
    fn models_of_states_that_are_refused_do_not_stay() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let derived = found(0.01, Some(0)).derived.expect("models");
        let known = DerivedRecord { states_sha256: "of the states".into(), models: vec![], ..derived };
        let text = serde_json::to_string(&known).expect("numbers and strings");
        std::fs::write(folder.path().join(DERIVED), text).expect("room");
        let of = |why, states| of_another_build(why, states, folder.path());
        let other_file = || Underived::NotAsComputed("a.csv has other contents now".into());
        let kept = of(other_file(), "of the states").expect("they stay");
        assert!(kept.left_out[0].contains("a.csv has other contents now"), "{:?}", kept.left_out);
        assert!(of(other_file(), "of others").is_err());
        assert!(of("steps were cut in a".to_string().into(), "of the states").is_err());
    }
}
