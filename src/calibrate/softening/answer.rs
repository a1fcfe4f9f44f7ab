//! From a request to a law and its softening, with all their errors.

use super::error::SofteningFitError;
use super::fit::of_data;
use super::result::SofteningFit;
use super::stated::widened;
use crate::calibrate::intake::tables;
use crate::calibrate::{Experiment, FitOptions, FitRequest, FitResult, FittableLaw, SlackChoice};

/// Reads the table of a request, fits its law to the rows of the first loading, and softening to the others. Holds at the peaks and rows after a
/// rupture are left out and logged.
pub fn fit_softening(request: &FitRequest) -> Result<(FitResult, SofteningFit), SofteningFitError> {
    check_law(&request.options)?;
    let parts = tables::read(request)?;
    for part in &parts {
        let own = part.card.as_ref().map(|c| &c.preparation);
        for asked in own.into_iter().chain([&request.preparation]) {
            let treatments = [
                ("a cycle", asked.cycle.is_some()),
                ("zeroing", asked.zero.is_some()),
                ("toe compensation", asked.toe.is_some()),
            ];
            let slack = ("slack", request.options.slack == SlackChoice::Yes);
            if let Some((what, _)) = treatments.into_iter().chain([slack]).find(|t| t.1) {
                return Err(SofteningFitError::Treated { file: part.file.clone(), what });
            }
        }
    }
    let parts = parts.into_iter().map(Experiment::prepare_cycles).collect::<Result<_, _>>()?;
    let experiment = Experiment::pool(parts)?;
    fit_softening_experiment(&experiment, &request.options)
}

/// Fits a law and its softening, as [`fit_softening`] does, to a table that has already been read.
pub fn fit_softening_experiment(
    experiment: &Experiment,
    options: &FitOptions,
) -> Result<(FitResult, SofteningFit), SofteningFitError> {
    check_law(options)?;
    let (law, softening, sets) = of_data(experiment, options)?;
    let (softening, stated) = widened(softening, experiment, options)?;
    let softening = softening.with_words(&law, &stated, sets);
    Ok((law, softening))
}

/// Refuses a foam law, because it has no isochoric part.
fn check_law(options: &FitOptions) -> Result<(), SofteningFitError> {
    let model = FittableLaw::new(&options.law, options.terms)?;
    if model.form.compressible { Err(SofteningFitError::NotIsochoric { law: model.name() }) } else { Ok(()) }
}
