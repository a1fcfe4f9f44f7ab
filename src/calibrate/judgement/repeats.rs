//! Tests with several specimens, and tests with a single one.

use crate::calibrate::Sample;
use crate::calibrate::sample::{Test, tests};
use std::collections::{BTreeMap, BTreeSet};

/// Tests, grouped by the number of their specimens.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Repeats<T> {
    /// Tests with two or more specimens
    pub repeated: Vec<T>,
    /// Tests with one specimen
    pub single: Vec<T>,
}

impl<T: Ord> Repeats<T> {
    /// Counts the specimens of each test, given the test and the specimen of each data point.
    pub fn of(points: impl Iterator<Item = (T, usize)>) -> Self {
        let mut specimens: BTreeMap<T, BTreeSet<usize>> = BTreeMap::new();
        points.for_each(|(test, specimen)| {
            specimens.entry(test).or_default().insert(specimen);
        });
        let (repeated, single): (Vec<_>, Vec<_>) = specimens.into_iter().partition(|(_, all)| all.len() > 1);
        let tests = |all: Vec<(T, _)>| all.into_iter().map(|(test, _)| test).collect();
        Self { repeated: tests(repeated), single: tests(single) }
    }
}

impl Repeats<Test> {
    /// Counts the specimens of each test of the samples.
    pub fn of_samples(samples: &[Sample]) -> Self {
        Self::of(tests(samples).into_iter().zip(samples.iter().map(|s| s.specimen)))
    }
}
