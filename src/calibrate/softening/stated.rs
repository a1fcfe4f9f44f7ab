//! Errors of the measurement that all data points share, in the intervals of softening.
//!
//! The data are moved by each of them, there and back, and law and softening are fitted anew: half of the difference is by how much the error moves a constant. The half-widths of independent errors
//! are added in quadrature to the one of the scatter, as in fits of a law ([`crate::calibrate::judgement::measurement`]). Zeros are those of each specimen.

use super::fit::of_data;
use super::result::SofteningFit;
use crate::calibrate::intake::accuracy::SharedError;
use crate::calibrate::intake::dimensions::Dimensions;
use crate::calibrate::{Accuracy, Bounded, Experiment, FitError, FitOptions, Sample};
use std::collections::BTreeSet;

/// The constants with wider intervals, and a message for each error that could not be followed.
pub fn widened(
    mut fit: SofteningFit,
    experiment: &Experiment,
    options: &FitOptions,
    accuracy: &Accuracy,
) -> Result<SofteningFit, FitError> {
    if accuracy.0.is_empty() {
        return Ok(fit);
    }
    let specimens: BTreeSet<usize> = experiment.samples.iter().map(|s| s.specimen).collect();
    let mut squares = [0.0; 5];
    for (kind, half_width) in &accuracy.0 {
        let of: Vec<Option<usize>> = match kind.is_of_a_curve() {
            true => specimens.iter().copied().map(Some).collect(),
            false => vec![None],
        };
        for specimen in of {
            let end = |by: f64| moved_fit(experiment, options, (*kind, by), specimen);
            match (end(*half_width)?, end(-half_width)?) {
                (Some(a), Some(b)) => (0..5).for_each(|k| squares[k] += (0.5 * (a[k] - b[k])).powi(2)),
                _ => fit.summary.messages.push(format!("the intervals do not hold the stated error of the {kind}")),
            }
        }
    }
    let wide = |b: Bounded, k: usize| {
        let [low, high] = b.interval.map(|end| (end - b.value).hypot(squares[k].sqrt()));
        Bounded { interval: [b.value - low, b.value + high], ..b }
    };
    (fit.r, fit.m) = (wide(fit.r, 0).within(1.0, f64::INFINITY), wide(fit.m, 1).within(0.0, f64::INFINITY));
    (fit.beta, fit.set) = (wide(fit.beta, 2).within(0.0, f64::INFINITY), wide(fit.set, 3).within(0.0, 1.0));
    fit.scale = fit.scale.map(|scale| wide(scale, 4).within(0.0, f64::INFINITY));
    Ok(fit)
}

/// r, m, β, the set and m + βW_m from the data with an error, of one specimen or of all; none where they cannot be had.
fn moved_fit(
    experiment: &Experiment,
    options: &FitOptions,
    (kind, by): (SharedError, f64),
    specimen: Option<usize>,
) -> Result<Option<[f64; 5]>, FitError> {
    let one = |s: &Sample| match specimen.is_none_or(|own| s.specimen == own) {
        true => moved(s, kind, by, &experiment.dimensions),
        false => Ok(Some(*s)),
    };
    let samples: Result<Option<Vec<Sample>>, FitError> =
        experiment.samples.iter().map(one).collect::<Result<Vec<_>, _>>().map(|all| all.into_iter().collect());
    let Some(samples) = samples? else { return Ok(None) };
    let none = Accuracy::default;
    let data = Experiment { samples, alternatives: vec![], accuracy: none(), ..experiment.clone() };
    let fit = of_data(&data, &FitOptions { accuracy: none(), ..options.clone() });
    Ok(fit.ok().map(|(_, s, _)| {
        let scale = s.scale.map_or(s.m.value + s.beta.value * s.largest_energy, |scale| scale.value);
        [s.r.value, s.m.value, s.beta.value, s.set.value, scale]
    }))
}

/// A data point as it would be measured with an error; none of an error that is in no data point.
fn moved(s: &Sample, kind: SharedError, by: f64, dimensions: &Dimensions) -> Result<Option<Sample>, FitError> {
    let stressed = |stress: f64| Some(Sample { stress, ..*s });
    let strained = |strain: f64| Some(Sample { stretch: s.mode.stretch(strain), ..*s });
    let strain = s.mode.strain(s.stretch);
    Ok(match kind {
        SharedError::StressZero => stressed(s.stress + by),
        SharedError::ForceZero => stressed(s.stress + by / dimensions.needed_section(kind)?),
        SharedError::StressScale => stressed(s.stress * (1.0 + by)),
        SharedError::StrainZero => strained(strain + by),
        SharedError::StrainScale => strained(strain * (1.0 + by)),
        SharedError::Compliance => {
            let per_stress = dimensions.needed_section(kind)? / dimensions.needed_length(kind)?;
            strained(strain - by * s.stress * per_stress)
        }
        SharedError::Poisson => None,
    })
}
