//! Time steps of runs that differ only in their steps, and the error of one of these steps.
//!
//! A run has one step for each stage, or the mean of steps that are chosen from a permitted error. Runs of a family may differ in some stages only: the
//! hold before a movement keeps its step, which says nothing about the errors.

use crate::study::estimate::richardson::CAUTIOUS_FACTOR;
use crate::study::store::record::CaseRecord;

/// Relative difference below which steps are equal except for rounding.
const ROUNDING: f64 = 1e-6;

/// Returns one size for each run \[s\]: its step in the stage in which the runs differ, the geometric mean if they differ in several stages, and its
/// longest step if they differ in none.
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

/// Whether two runs have the same time step in every stage, and the same permitted error if one sets the steps.
pub fn has_steps_of(run: &CaseRecord, other: &CaseRecord) -> bool {
    if run.time_error_m != other.time_error_m {
        return false;
    }
    let (a, b) = (run.steps_s(), other.steps_s());
    match a.len() == b.len() {
        true => a.iter().zip(b).all(|(a, b)| is_same(*a, *b)),
        // One of them was written by an earlier version
        false => is_same(run.dt_s, other.dt_s),
    }
}

fn is_same(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < ROUNDING
}

/// A run: its time step \[s\], its value, and whether its step is the judged one.
pub type Timed = (f64, f64, bool);

/// Error of the step of run `at`, from runs with other steps, sorted by step: the difference from the run with the shortest step Δt₁, plus the
/// remainder s Δt₁. The change per unit of time step, s, is the larger of the mean over these two runs and that between the two shortest steps. If the
/// latter is larger than that between the next two by some factor, it may grow by this factor again, by at most three: the error of a rule with
/// numerical damping is largest where its steps begin to resolve the motion.
pub fn first_order(runs: &[Timed], at: usize) -> Option<f64> {
    let (dt, a, _) = runs[at];
    // If the step of the run is itself the shortest, the difference to the next longer one bounds its error
    let (other, b, _) = *runs.iter().find(|run| !is_same(run.0, dt))?;
    let slope = |w: &[Timed]| ((w[1].1 - w[0].1) / (w[1].0 - w[0].0)).abs();
    let slopes: Vec<f64> = runs.windows(2).filter(|w| !is_same(w[0].0, w[1].0)).take(2).map(slope).collect();
    let (difference, mean) = ((a - b).abs(), ((a - b) / (dt - other)).abs());
    let change = match slopes[..] {
        [finest, next] => mean.max(finest * (finest / next).clamp(1.0, CAUTIOUS_FACTOR)),
        _ => mean,
    };
    Some(if dt < other { change * dt } else { difference + change * other })
}

/// Error of a value of a run caused by its time steps, from runs on one mesh with other steps and their values; `None` if no run has its steps, or all
/// have.
pub fn error_of_steps(run: &CaseRecord, others: &[(&CaseRecord, f64)]) -> Option<f64> {
    let records: Vec<&CaseRecord> = others.iter().map(|(r, _)| *r).collect();
    let timed = |((r, value), dt): (&(&CaseRecord, f64), f64)| (dt, *value, has_steps_of(r, run));
    let mut runs: Vec<Timed> = others.iter().zip(step_sizes(&records)).map(timed).collect();
    runs.sort_by(|a, b| a.0.total_cmp(&b.0));
    first_order(&runs, runs.iter().position(|run| run.2)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::larger;

    fn run(stage_dt_s: &[f64]) -> CaseRecord {
        let dt_s = stage_dt_s.iter().copied().fold(0.0, larger);
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

    /// Two runs with steps of at most 40 ms after a static hold of one step, and one in which all steps have that length.
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

    /// Peak of the oscillator x″ + ω²x = ω² with ω = 1, starting at rest, by implicit Euler with steps Δt; the exact peak is 2.
    fn oscillator(dt: f64) -> f64 {
        let (mut x, mut v, mut peak) = (0.0, 0.0, 0.0_f64);
        for _ in 0..(6.0 / dt).ceil() as usize {
            v = (v + dt * (1.0 - x)) / (1.0 + dt * dt);
            x += dt * v;
            peak = larger(peak, x);
        }
        peak
    }

    /// The change of implicit Euler per unit of time step is largest where its steps begin to resolve the motion. For steps that cover less than a
    /// third of the motion, a first-order estimate from two steps gives as little as 0.27 of the error; with the growth between three of them the bound
    /// is at least 0.8 of it, and at least 0.95 from ten steps per period on.
    #[test]
    fn steps_that_resolve_a_motion_bound_its_error() {
        let (mut two, mut three, mut ten) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
        for k in 0..84 {
            let finest = 0.0125 * 1.05_f64.powi(k);
            let runs = [finest, 2.0 * finest, 4.0 * finest].map(|dt| (dt, oscillator(dt), false));
            for at in (0..3).filter(|at| runs[*at].0 < 0.72) {
                let (dt, value, _) = runs[at];
                let share = first_order(&runs, at).expect("other steps") / (2.0 - value);
                three = three.min(share);
                ten = if dt < std::f64::consts::TAU / 10.0 { ten.min(share) } else { ten };
                let pair = [runs[at.min(1)], runs[at.min(1) + 1]];
                two = two.min(first_order(&pair, at - at.min(1)).expect("another step") / (2.0 - value));
            }
        }
        println!("{two} {three} {ten}");
        assert!(two < 0.3 && three > 0.8 && ten > 0.95, "{two} {three} {ten}");
    }

    /// With second order in the steps the differences shrink, and the first-order bound is at least twice the error.
    #[test]
    fn steps_of_second_order_keep_their_bound() {
        let runs = [0.1, 0.2, 0.4].map(|dt: f64| (dt, 1.0 + dt * dt, false));
        let shares = [0, 1, 2].map(|at| first_order(&runs, at).expect("other steps") / (runs[at].1 - 1.0));
        assert!(
            (shares[0] - 3.0).abs() < 1e-12 && (shares[1] - 1.5).abs() < 1e-12 && (shares[2] - 1.25).abs() < 1e-12,
            "{shares:?}"
        );
    }

    /// 9 ms given in seconds and in milliseconds differ by rounding: the two runs have the same step, whichever is judged.
    #[test]
    fn a_step_in_another_unit_is_the_same_step() {
        let (seconds, milliseconds) = (0.009, 9.0 * 1e-3);
        assert_ne!(seconds, milliseconds);
        let runs = [(seconds, 3.0, true), (milliseconds, 3.0, false), (0.018, 4.0, false)];
        for at in [0, 1] {
            let error = first_order(&runs, at).expect("another step");
            assert!((error - 1.0).abs() < 1e-9, "{error}");
        }
        assert!((first_order(&runs, 2).expect("another step") - 2.0).abs() < 1e-9);
        assert_eq!(first_order(&runs[..2], 0), None);
    }

    /// The first-order error of implicit Euler is half of that of twice the step: the bound from two runs is the error, and without a run with its own
    /// steps there is no bound.
    #[test]
    fn the_error_of_a_run_is_that_of_its_steps() {
        let runs = [run(&[0.004]), run(&[0.002])];
        let others = [(&runs[0], 629.0), (&runs[1], 813.0)];
        let error = |of: &CaseRecord, others| error_of_steps(of, others);
        assert_eq!(error(&runs[0], &others), Some(368.0));
        assert_eq!(error(&runs[1], &others), Some(184.0));
        assert_eq!(error(&run(&[0.001]), &others), None);
        assert_eq!(error(&runs[0], &others[..1]), None);
    }
}
