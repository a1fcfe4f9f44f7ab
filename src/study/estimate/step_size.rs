//! Sizes of the time steps of runs that differ in them.
//!
//! A run has one step for each stage, or those that a permitted error sets, of which the mean counts. Runs of a family differ in some stages only: the hold before a movement keeps its step, which says nothing of
//! their errors.

use crate::study::store::record::CaseRecord;

/// Relative difference of steps that are the same but for rounding.
const ROUNDING: f64 = 1e-6;

/// One size for each run \[s\]: its step in the stage in which the runs differ, the geometric mean where they differ in several stages, and its longest
/// step where they differ in none.
pub fn step_sizes(runs: &[&CaseRecord]) -> Vec<f64> {
    if runs.iter().any(|r| r.time_error_m.is_some()) {
        return runs.iter().map(|r| r.mean_dt_s.unwrap_or(r.dt_s)).collect();
    }
    let longest = || runs.iter().map(|r| r.dt_s).collect();
    let Some(first) = runs.first().map(|r| r.steps_s()) else { return vec![] };
    if runs.iter().any(|r| r.steps_s().len() != first.len()) {
        return longest();
    }
    let differs = |k: &usize| runs.iter().any(|r| !is_same(r.steps_s()[*k], first[*k]));
    let stages: Vec<usize> = (0..first.len()).filter(differs).collect();
    let Some(&leading) = stages.first() else { return longest() };
    let mean = |r: &&CaseRecord| {
        let steps = r.steps_s();
        let product: f64 = stages.iter().map(|k| steps[*k] / steps[leading]).product();
        steps[leading] * product.powf(1.0 / stages.len() as f64)
    };
    runs.iter().map(mean).collect()
}

/// Whether two runs have the same time step in every stage, and the same permitted error where one sets them.
pub fn has_steps_of(run: &CaseRecord, other: &CaseRecord) -> bool {
    if run.time_error_m != other.time_error_m {
        return false;
    }
    let (a, b) = (run.steps_s(), other.steps_s());
    match a.len() == b.len() {
        true => a.iter().zip(b).all(|(a, b)| is_same(*a, *b)),
        // One of them is of an earlier version
        false => is_same(run.dt_s, other.dt_s),
    }
}

fn is_same(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < ROUNDING
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(stage_dt_s: &[f64]) -> CaseRecord {
        let dt_s = stage_dt_s.iter().copied().fold(0.0, f64::max);
        CaseRecord { dt_s, stage_dt_s: stage_dt_s.to_vec(), ..CaseRecord::default() }
    }

    fn sizes(runs: &[&[f64]]) -> Vec<f64> {
        let runs: Vec<CaseRecord> = runs.iter().map(|steps| run(steps)).collect();
        step_sizes(&runs.iter().collect::<Vec<_>>())
    }

    #[test]
    fn the_size_of_a_step_is_that_of_the_stage_in_which_runs_differ() {
        assert_eq!(sizes(&[&[1.0, 0.05], &[1.0, 0.025], &[1.0, 0.0125]]), [0.05, 0.025, 0.0125]);
        assert_eq!(sizes(&[&[0.01, 0.05], &[0.01, 0.025]]), [0.05, 0.025]);
        assert_eq!(sizes(&[&[0.05, 0.05], &[0.025, 0.025]]), [0.05, 0.025]);
        assert_eq!(sizes(&[&[1.0, 0.05], &[1.0, 0.05]]), [1.0, 1.0]);
        let [a, b] = sizes(&[&[0.4, 3.0, 0.1], &[0.2, 3.0, 0.05]])[..] else { panic!("two runs") };
        assert!((a - 0.2).abs() < 1e-15 && (b - 0.1).abs() < 1e-15, "{a} {b}");
    }

    /// Two runs with steps of 40 ms at most after a static hold of one step, and one with all steps of that length.
    #[test]
    fn steps_that_an_error_sets_have_their_mean_length() {
        let of = |error: Option<f64>, mean: f64| CaseRecord {
            time_error_m: error,
            mean_dt_s: Some(mean),
            ..run(&[1.0, 0.04])
        };
        let (rough, fine, other_mesh) = (of(Some(1e-3), 0.031), of(Some(1e-4), 0.019), of(Some(1e-4), 0.018));
        let of_one_length = of(None, 0.04);
        assert_eq!(step_sizes(&[&rough, &fine, &of_one_length]), [0.031, 0.019, 0.04]);
        assert!(has_steps_of(&fine, &other_mesh) && !has_steps_of(&rough, &fine));
        assert!(!has_steps_of(&fine, &of_one_length));
    }

    #[test]
    fn records_without_steps_of_stages_are_compared_by_their_longest_step() {
        let old = CaseRecord { dt_s: 0.05, ..CaseRecord::default() };
        assert!(has_steps_of(&old, &run(&[0.01, 0.05])) && !has_steps_of(&run(&[0.01, 0.05]), &run(&[0.02, 0.05])));
        assert_eq!(step_sizes(&[&old, &run(&[0.01, 0.025])]), [0.05, 0.025]);
    }
}
