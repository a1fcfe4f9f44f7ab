//! Steps of transient runs whose states are used for training: each run is divided into equal parts, and one step is drawn at random from each.
//!
//! Equidistant steps could be in phase with the runs, and would then miss the same times in all of them.

use crate::math::random::SplitMix;

/// Seed of the random steps.
const SEED: u64 = 0;

/// Returns the chosen steps of runs with these lengths, in ascending order \[runs\], `most` in total or all: in proportion to the lengths, and
/// anywhere within a run.
pub fn steps_of_runs(lengths: impl Iterator<Item = usize> + Clone, most: usize) -> Vec<Vec<usize>> {
    let total: usize = lengths.clone().sum();
    let (most, mut before, mut random) = (most.min(total), 0, SplitMix(SEED));
    let of_run = |length: usize| {
        let parts = most * (before + length) / total.max(1) - most * before / total.max(1);
        before += length;
        let within = |k: usize| {
            let (first, end) = (k * length / parts, (k + 1) * length / parts);
            first + random.below(end - first)
        };
        (0..parts).map(within).collect()
    };
    lengths.map(of_run).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For any number of runs of any length: as many steps as requested, some from each run if there are enough, and at all times of the runs taken
    /// together. The largest gap between n uniformly drawn times is about (ln n)/n of their range; here it is at most 8.4/n.
    #[test]
    fn every_run_and_every_time_is_taken() {
        for most in [30, 60, 100, 240] {
            for length in [1, 10, 30, 100] {
                for runs in 1..400 {
                    let taken = steps_of_runs(std::iter::repeat_n(length, runs), most);
                    let count = most.min(runs * length);
                    assert_eq!(taken.iter().map(Vec::len).sum::<usize>(), count, "{runs} runs of {length}");
                    assert!(runs > count || taken.iter().all(|steps| !steps.is_empty()), "{runs} runs of {length}");
                    let mut times: Vec<usize> = taken.iter().flatten().map(|k| k + 1).chain([0, length + 1]).collect();
                    assert!(taken.iter().all(|steps| steps.is_sorted_by(|a, b| a < b)), "{runs} runs of {length}");
                    times.sort_unstable();
                    let gap = times.windows(2).map(|w| w[1] - w[0]).max().unwrap_or(0);
                    let bound = 1.0 + 10.0 * length as f64 / count as f64;
                    assert!(gap as f64 <= bound, "{runs} runs of {length}: no step for {gap}");
                }
            }
        }
    }

    /// Longer runs contribute more steps, and all steps are used if there are no more than requested.
    #[test]
    fn runs_of_other_lengths_have_their_share() {
        let count =
            |most: usize| steps_of_runs([10, 30, 0, 60].into_iter(), most).iter().map(Vec::len).collect::<Vec<_>>();
        assert_eq!((count(10), count(100), count(1000)), (vec![1, 3, 0, 6], vec![10, 30, 0, 60], vec![10, 30, 0, 60]));
    }
}
