//! The usual evaluation of a tensile test: the whole displacement stretches a gauge length of one cross-section, λ = 1 + x/L, P = y/A, fitted
//! with the closed form of the same law. What the search holds is held here too. It starts the search, and its error is what the specimen corrects.

use super::answer::Gauge;
use super::unknown::Unknown;
use super::{Measured, SceneModel};
use crate::calibrate::fit::choose;
use crate::calibrate::judgement::misfit::{Misfit, residuals};
use crate::calibrate::solve::refit::Held;
use crate::calibrate::solve::{LawSetting, constants};
use crate::calibrate::{
    Experiment, FitError, FitOptions, Mode, Model, Partner, Sample, Weighting, fit_experiment, poisson,
};
use crate::material::Parameter;
use crate::material::registry::given;

/// `None` where the law has no closed form here, or none of its constants is looked for.
pub fn fit(
    model: &SceneModel,
    measured: &Measured,
    weighting: Weighting,
    [length, section]: [f64; 2],
) -> Option<Gauge> {
    let law = model.unknown.first()?.key.law_constant()?.law;
    let (entry, values, _) = given(model.spec.laws.get(law)?).ok()?;
    let fitted = Model::new(entry.info.name, None).ok()?;
    let own = fitted.form.parameters.iter().filter(|p| values.contains_key(p.name)).count();
    let form = fitted.form.term_counts.iter().map(|terms| Model { terms: *terms, ..fitted }).find(|form| {
        let parameters = form.parameters();
        parameters.len() == own && parameters.iter().all(|p| values.contains_key(p.name))
    })?;
    let parameters = form.parameters();
    let place = |u: &Unknown| {
        let constant = u.key.law_constant().filter(|c| c.law == law)?;
        parameters.iter().position(|p| p.name == constant.key)
    };
    let places: Vec<Option<usize>> = model.unknown.iter().map(place).collect();
    let held = Held {
        values: parameters.iter().map(|p| values[p.name]).collect(),
        free: places.iter().flatten().copied().collect(),
    };
    (!held.free.is_empty()).then_some(())?;
    let sample = |((x, y), line): ((&f64, &f64), &u64)| Sample {
        mode: Mode::Uniaxial,
        second: 1.0,
        stretch: 1.0 + x / length,
        stress: y / section,
        line: *line,
        specimen: 0,
    };
    let samples = measured.x.iter().zip(&measured.y).zip(&measured.lines).map(sample).collect();
    let experiment = Experiment::of_samples(&measured.file, &measured.sha256, samples);
    let nu = form.poisson_keys().find_map(|k| values.get(&k).copied());
    let (terms, partner) = (Some(form.terms), nu.map(Partner::Nu));
    let options = FitOptions { terms, weighting, partner, ranges: 0, ..FitOptions::new(entry.info.name) };
    let found = if held.free.len() == parameters.len() {
        let answer = fit_experiment(&experiment, &options).ok()?;
        let of = |p: &Parameter| answer.parameters.iter().find(|e| e.name == p.name).map(|e| e.value);
        (parameters.iter().map(of).collect::<Option<Vec<f64>>>()?, answer.misfit.rms_relative)
    } else {
        some(&experiment, &options, form, held).ok()?
    };
    let (values, rms_relative) = found;
    let values = places.iter().map(|place| place.map(|k| values[k])).collect();
    Some(Gauge { length_m: length, section_m2: section, values, rms_relative })
}

/// The constants of a law of which only some are fitted, and their relative misfit.
fn some(experiment: &Experiment, options: &FitOptions, form: Model, held: Held) -> Result<(Vec<f64>, f64), FitError> {
    let (form, _) = poisson::of_options(options, form)?;
    let choice = choose(experiment, options)?;
    let setting = LawSetting { held: Some(held), ..choice.setting(options, form)? };
    let values = constants(&setting, &choice.fitted, None)?.values;
    let own = residuals(&choice.fitted, |s| form.at(&values, s));
    let misfit = Misfit::of(&own).expect("the data points were counted");
    Ok((values, misfit.rms_relative))
}
