//! Which constants of a fitted law the data leave open, and why.
//!
//! A constant is determined if it has a finite interval, a sign, a value inside the range of the search, and an interval that excludes zero, so that
//! its half-width is smaller than the value. The interval of a constant is taken with all others free: constants of which only a combination is
//! determined, such as two large terms that cancel each other, have wide intervals.

use super::estimate::Estimate;
use crate::calibrate::FittableLaw;
use crate::calibrate::solve::LawFit;
use crate::material::FitTerms;

/// Relative position in the searched interval from which on a constant counts as being at its end \[–\]
const NEAR_WALL: f64 = 0.99;

/// The reasons why constants are not determined, each with the symbols of its constants: `α₄ at an end of the search`. Empty if all are determined.
pub fn undetermined(
    parameters: &[Estimate],
    open_signs: &[&'static str],
    answer: &LawFit,
    model: FittableLaw,
) -> Vec<String> {
    let limits: Vec<&str> = limits(answer, model).into_iter().map(|(symbol, _)| symbol).collect();
    let mut left: Vec<&Estimate> = parameters.iter().collect();
    let mut found = Vec::new();
    let mut take = |applies: &dyn Fn(&Estimate) -> bool, words: &str| {
        let symbols: Vec<_> = left.extract_if(.., |e| applies(e)).map(|e| e.symbol).collect();
        if !symbols.is_empty() {
            found.push(format!("{} {words}", symbols.join(", ")));
        }
    };
    take(&|e| !e.is_bounded(), "without a finite interval");
    take(&|e| open_signs.contains(&e.symbol), "with either sign");
    take(&|e| limits.contains(&e.symbol), "at an end of the search");
    take(&Estimate::may_be_zero, "not distinguished from zero");
    found
}

/// Shape constants at an end of the searched interval, with their values.
pub fn limits(answer: &LawFit, model: FittableLaw) -> Vec<(&'static str, f64)> {
    let FitTerms::Separable(family) = &model.form.terms else { return vec![] };
    let wall = family.wall();
    let at_wall = |(k, x): (usize, &f64)| {
        let e = &answer.identified.estimates[2 * k + 1];
        (x.abs() >= NEAR_WALL * wall && answer.values[2 * k] != 0.0).then_some((e.symbol, e.value))
    };
    answer.at.iter().enumerate().filter_map(at_wall).collect()
}
