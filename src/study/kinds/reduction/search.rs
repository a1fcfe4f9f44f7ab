//! The greedy search of a study: from the existing states to the next ones.

use crate::reduction::ReductionError;
use crate::reduction::training::greedy::Search;
use crate::study::kinds::reduction::path::{ordered, random};
use crate::study::kinds::reduction::prepared::{Prepared, converged};
use crate::study::kinds::reduction::record::{GreedyRecord, ReductionRecord, SearchStep};
use crate::study::kinds::reduction::runs::{at_rest, in_units, members};
use crate::study::kinds::reduction::spec::TRAINING;
use crate::study::rounds::{Round, Rounds};
use crate::study::store::record::Role;
use crate::study::store::results::Results;
use std::collections::BTreeMap;
use std::path::Path;

/// Seed of the candidates, different from those of the training and held-back points.
const SEED: u64 = 3;

/// Returns the next states of a greedy plan; a round without members if the search has ended, `None` if it must wait for results or if there is no
/// such plan.
pub fn round(results: &Results, record: &ReductionRecord, dir: &Path) -> Result<Option<Round>, String> {
    let Some(plan) = &record.greedy else { return Ok(None) };
    let Some(cases) = converged(results, Role::Training) else { return Ok(None) };
    let prepared = Prepared::of(results, record, &cases, dir).map_err(|e| e.to_string())?;
    let states = prepared.runs(&cases, record, dir)?.concat();
    let shares = candidates(record, plan, &states_in_shares(record, &prepared, &states));
    let inputs: Vec<Vec<f64>> = shares.iter().map(|share| prepared.inputs(&in_units(&record.inputs, share))).collect();
    let left = plan.states.saturating_sub(states.len());
    let modes = record.modes.iter().max().copied().unwrap_or(1).min(states.len());
    let search = Search { modes, sampling: Some(record.sampling), batch: plan.batch.min(left.max(1)) };
    let training = prepared.training(&states)?;
    let (mut step, mut chosen) = (SearchStep { states: states.len(), largest: None, median: None }, vec![]);
    match search.choose(&training, &inputs) {
        Ok(choice) => {
            let finite = |value: f64| value.is_finite().then_some(value);
            (step.largest, step.median) = (finite(choice.largest), finite(choice.median));
            if choice.largest > plan.tolerance {
                chosen = choice.chosen;
            }
        }
        // Too few states for a model: the candidates are drawn uniformly, so that the first of them fill the ranges
        Err(ReductionError::Sampling { .. } | ReductionError::NoEquilibrium { .. }) => chosen.extend(0..plan.batch),
        Err(why) => return Err(why.to_string()),
    }
    chosen.truncate(left);
    let start: Vec<f64> = record.inputs.iter().map(at_rest).collect();
    let points = ordered(chosen.iter().map(|&k| shares[k].clone()).collect(), &start);
    let number = Rounds::read(dir).rounds.len() + 1;
    let label = |k: usize| format!("greedy-{number:03}-{:02}", k + 1);
    // Each state is a case of its own, so that the states of a batch are computed in parallel
    let values: Vec<Vec<f64>> = points.iter().map(|share| in_units(&record.inputs, share)).collect();
    let members: BTreeMap<String, toml::Table> = values
        .iter()
        .enumerate()
        .map(|(k, point)| {
            (label(k), members(&record.inputs, std::slice::from_ref(point), prepared.names.iter().map(String::as_str)))
        })
        .collect();
    let record = serde_json::to_value(step).map_err(|e| e.to_string())?;
    Ok(Some(Round { family: TRAINING.into(), members, record }))
}

/// The inputs of the states as fractions of their ranges.
fn states_in_shares(
    record: &ReductionRecord,
    prepared: &Prepared,
    states: &[crate::reduction::FullState],
) -> Vec<Vec<f64>> {
    let share = |state: &crate::reduction::FullState| {
        let values = prepared.in_units(&state.inputs);
        values.iter().zip(&record.inputs).map(|(u, i)| (u - i.range[0]) / (i.range[1] - i.range[0])).collect()
    };
    states.iter().map(share).collect()
}

/// Distance relative to the ranges within which a candidate counts as an existing state.
const SAME: f64 = 1e-9;

/// The corners of the ranges and points drawn uniformly in them, except existing states.
fn candidates(record: &ReductionRecord, plan: &GreedyRecord, known: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = record.inputs.len();
    let corners = if n < 8 { 1_usize << n } else { 0 };
    let corner = |c: usize| (0..n).map(|k| (c >> k & 1) as f64).collect::<Vec<f64>>();
    let all = random(n, plan.candidates, SEED).into_iter().chain((0..corners).map(corner));
    let is_new = |p: &Vec<f64>| !known.iter().any(|k| k.iter().zip(p).all(|(a, b)| (a - b).abs() < SAME));
    all.filter(is_new).collect()
}
