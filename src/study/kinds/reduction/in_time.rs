//! Runs in time of a reduction study: inputs that are piecewise linear over time, with corners drawn from their ranges.

use super::path::random;
use super::record::{ReductionInputRecord, ReductionMotionRecord};
use crate::math::units::{self, Dimension};
use crate::study::spec::Mistake;
use crate::wording::first;
use schemars::JsonSchema;
use serde::Deserialize;

/// Runs in time instead of equilibria; the scene says with which integrator and step.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionSpec {
    /// Length of each run
    pub duration: String,
    /// Time from one corner of an input to the next; in between it changes linearly
    pub corner: String,
}

/// Parses the times, in seconds.
pub fn motion(spec: &MotionSpec) -> Result<ReductionMotionRecord, Mistake> {
    let time = |key: &str, text: &str| {
        let wrong = |fact: String| {
            ("motion".to_string(), format!("{key} = \"{text}\" {fact}"), format!("write {key} = \"0.5 s\""))
        };
        match units::parse(text, Dimension::TIME) {
            Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
            Ok(_) => Err(wrong("is no length of time".into())),
            Err(why) => Err(wrong(format!("is no time: {why}"))),
        }
    };
    let record =
        ReductionMotionRecord { duration: time("duration", &spec.duration)?, corner: time("corner", &spec.corner)? };
    if record.corner > record.duration {
        let fact = format!("corner = \"{}\" is longer than a run of {}", spec.corner, spec.duration);
        return Err(("motion".into(), fact, "give a shorter time between corners, or longer runs".into()));
    }
    Ok(record)
}

/// Returns the inputs at the corners of each run as fractions of their ranges, each drawn independently.
pub fn corners(inputs: usize, runs: usize, motion: ReductionMotionRecord, seed: u64) -> Vec<Vec<Vec<f64>>> {
    let each = (motion.duration / motion.corner - 1e-9).ceil().max(1.0) as usize;
    random(inputs, runs * each, seed).chunks(each).map(<[Vec<f64>]>::to_vec).collect()
}

/// Refuses runs with cut steps, because the model made from them has steps of one length, `dt` \[s\]. Each run comes with its number of cuts.
pub fn uncut<'a>(dt: f64, runs: impl Iterator<Item = (&'a str, usize)>) -> Result<(), String> {
    let cut: Vec<&str> = runs.filter(|(_, cuts)| *cuts > 0).map(|(id, _)| id).collect();
    if cut.is_empty() {
        return Ok(());
    }
    Err(format!(
        "a model that moves has steps of one length, and steps of dt = {dt} s were cut in {}; give the stage of the scene a shorter dt, or [numerics] more \
         max_iterations, and run the study again",
        first(&cut)
    ))
}

/// Returns the inputs at time `t` of a run with these corners, in the units of the inputs.
pub fn at(inputs: &[ReductionInputRecord], corners: &[Vec<f64>], motion: ReductionMotionRecord, t: f64) -> Vec<f64> {
    let place = t / motion.corner;
    let before = (place.floor() as usize).min(corners.len());
    let share = place - before as f64;
    let value = |corner: usize, k: usize| match corner {
        0 => inputs[k].at_rest(),
        corner => corners[corner.min(corners.len()) - 1][k],
    };
    let between = |k: usize| {
        let (from, to) = (value(before, k), value(before + 1, k));
        from + share * (to - from)
    };
    (0..inputs.len()).map(between).collect()
}

/// Returns the changes of a run: each input starts at rest and is linear between these corners.
pub fn run(inputs: &[ReductionInputRecord], corners: &[Vec<f64>], motion: ReductionMotionRecord) -> toml::Table {
    let mut changes = super::runs::polygons(inputs, corners, motion.corner);
    changes.insert("stage.0.duration".into(), format!("{} s", motion.duration).into());
    changes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs with cuts are named, with the step that they should have had.
    #[test]
    fn runs_with_cut_steps_are_refused() {
        assert_eq!(uncut(0.02, [("training-1", 0), ("training-2", 0)].into_iter()), Ok(()));
        let why = uncut(0.02, [("training-1", 3), ("training-2", 0), ("held-back-1", 1)].into_iter());
        let why = why.expect_err("steps of other lengths");
        assert!(why.contains("dt = 0.02 s were cut in training-1, held-back-1;"), "{why}");
    }

    /// From rest to the first corner, at it, between two corners, and at the last one.
    #[test]
    fn inputs_are_polygons_from_rest() {
        let (start, held) = (None, false);
        let input = ReductionInputRecord {
            name: "pull".into(),
            key: "k".into(),
            unit: "mm".into(),
            range: [1.0, 5.0],
            start,
            held,
        };
        let motion = ReductionMotionRecord { duration: 0.2, corner: 0.1 };
        let value = |t: f64| at(std::slice::from_ref(&input), &[vec![3.0], vec![4.0]], motion, t)[0];
        for (t, expected) in [(0.0, 1.0), (0.05, 2.0), (0.1, 3.0), (0.15, 3.5), (0.2, 4.0)] {
            assert!((value(t) - expected).abs() < 1e-12, "{t}: {}", value(t));
        }
        let drawn = corners(2, 3, motion, 7);
        assert!(drawn.len() == 3 && drawn.iter().flatten().all(|c| c.iter().all(|s| (0.0..1.0).contains(s))));
        assert_eq!(drawn, corners(2, 3, motion, 7));
    }
}
