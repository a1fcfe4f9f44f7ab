//! Errors of the measurement that all data points share, in the intervals of softening.
//!
//! The data are shifted by each error in both directions, and law and softening are fitted again: half of the difference is the effect of the error
//! on a constant. The half-widths of independent errors are added in quadrature to that of the scatter, as in fits of a law
//! ([`crate::calibrate::judgement::measurement`]). Errors of zeros differ between specimens; with several specimens they are part of the scatter.

use super::fit::of_data;
use super::result::SofteningFit;
use crate::calibrate::intake::accuracy::SharedError;
use crate::calibrate::intake::dimensions::Dimensions;
use crate::calibrate::intake::piece::Piece;
use crate::calibrate::sample::{Test, tests};
use crate::calibrate::{Accuracy, Bounded, ErrorModel, Experiment, FitError, FitOptions, Sample};
use std::collections::BTreeSet;

/// Widens the intervals of the constants; lists the errors that they include, and adds a message for each error whose effect could not be computed.
pub fn widened(
    mut fit: SofteningFit,
    experiment: &Experiment,
    options: &FitOptions,
) -> Result<(SofteningFit, Vec<SharedError>), FitError> {
    let of_tests: BTreeSet<(Test, usize)> =
        tests(&experiment.samples).into_iter().zip(experiment.samples.iter().map(|s| s.specimen)).collect();
    let is_alone = |test: Test| of_tests.iter().filter(|other| other.0 == test).count() == 1;
    // Specimens whose errors of the zero are not part of a measured scatter
    let specimens: BTreeSet<usize> = match fit.errors {
        ErrorModel::Specimens { .. } => BTreeSet::new(),
        ErrorModel::Levels { .. } => of_tests.iter().filter(|one| is_alone(one.0)).map(|one| one.1).collect(),
        _ => of_tests.iter().map(|one| one.1).collect(),
    };
    let (mut squares, mut followed) = ([0.0; 5], vec![]);
    for kind in
        experiment.samples.iter().flat_map(|s| errors(experiment, options, s).0.into_keys()).collect::<BTreeSet<_>>()
    {
        let of: Vec<Option<usize>> = match kind.is_of_a_curve() {
            true => specimens.iter().copied().map(Some).collect(),
            false => vec![None],
        };
        if of.is_empty() {
            continue;
        }
        followed.push(kind);
        for specimen in of {
            let end = |side: f64| moved_fit(experiment, options, (kind, side), specimen);
            match (end(1.0)?, end(-1.0)?) {
                (Some(a), Some(b)) => (0..5).for_each(|k| squares[k] += (0.5 * (a[k] - b[k])).powi(2)),
                _ => {
                    followed.retain(|one| *one != kind);
                    fit.summary.messages.push(format!("the intervals do not hold the stated error of the {kind}"));
                    break;
                }
            }
        }
    }
    if followed.is_empty() {
        return Ok((fit, followed));
    }
    let wide = |b: Bounded, k: usize| {
        let [low, high] = b.interval.map(|end| (end - b.value).hypot(squares[k].sqrt()));
        Bounded { interval: [b.value - low, b.value + high], ..b }
    };
    (fit.r, fit.m) = (wide(fit.r, 0).within(1.0, f64::INFINITY), wide(fit.m, 1).within(0.0, f64::INFINITY));
    (fit.beta, fit.set) = (wide(fit.beta, 2).within(0.0, f64::INFINITY), wide(fit.set, 3).within(0.0, 1.0));
    fit.scale = fit.scale.map(|scale| wide(scale, 4).within(0.0, f64::INFINITY));
    Ok((fit, followed))
}

/// The errors that a data point shares with others.
fn errors(experiment: &Experiment, options: &FitOptions, s: &Sample) -> Accuracy {
    experiment.piece(s).errors(Test { mode: s.mode, compression: s.stretch < 1.0, both: false }, &options.accuracy)
}

/// r, m, β, the set and m + βW_m from data with an error of ± its half-width, in one specimen or in all; `None` if the fit fails.
fn moved_fit(
    experiment: &Experiment,
    options: &FitOptions,
    (kind, side): (SharedError, f64),
    specimen: Option<usize>,
) -> Result<Option<[f64; 5]>, FitError> {
    let one = |s: &Sample| match errors(experiment, options, s).0.get(&kind) {
        Some(half) if specimen.is_none_or(|own| s.specimen == own) => {
            moved(s, kind, side * half, &experiment.piece(s).dimensions)
        }
        _ => Ok(Some(*s)),
    };
    let samples: Result<Option<Vec<Sample>>, FitError> =
        experiment.samples.iter().map(one).collect::<Result<Vec<_>, _>>().map(|all| all.into_iter().collect());
    let Some(samples) = samples? else { return Ok(None) };
    let none = Accuracy::default;
    let pieces = experiment.pieces.iter().map(|p| Piece { accuracy: none(), ..p.clone() }).collect();
    let data = Experiment { samples, alternatives: vec![], pieces, ..experiment.clone() };
    let fit = of_data(&data, &FitOptions { accuracy: none(), ..options.clone() });
    Ok(fit.ok().map(|(_, s, _)| {
        let scale = s.scale.map_or(s.m.value + s.beta.value * s.largest_energy, |scale| scale.value);
        [s.r.value, s.m.value, s.beta.value, s.set.value, scale]
    }))
}

/// A data point as it would be measured with an error; `None` for an error that does not affect data points.
fn moved(s: &Sample, kind: SharedError, by: f64, dimensions: &Dimensions) -> Result<Option<Sample>, FitError> {
    let stressed = |stress: f64| Some(Sample { stress, ..*s });
    let strained = |strain: f64| Some(Sample { stretch: s.mode.stretch(strain), ..*s });
    let strain = s.mode.strain(s.stretch);
    Ok(match kind {
        SharedError::StressZero => stressed(s.stress + by),
        SharedError::ForceZero => stressed(s.stress + by / dimensions.needed_section(kind)?),
        SharedError::StressScale | SharedError::AreaScale => stressed(s.stress * (1.0 + by)),
        SharedError::StrainZero => strained(strain + by),
        SharedError::StrainScale => strained(strain * (1.0 + by)),
        SharedError::Compliance => {
            let per_stress = dimensions.needed_section(kind)? / dimensions.needed_length(kind)?;
            strained(strain - by * s.stress * per_stress)
        }
        // Rows of softening are not corrected
        SharedError::Poisson | SharedError::Zeroing | SharedError::Toe => None,
    })
}
