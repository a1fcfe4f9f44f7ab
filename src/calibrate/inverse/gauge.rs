//! The usual evaluation of a tensile test: the whole displacement stretches a gauge length of one cross-section, λ = 1 + x/L, P = y/A, fitted with
//! the closed form of the same law. Constants that the search holds are held here too. The result starts the search; simulating the whole specimen
//! corrects its error.

use super::answer::Gauge;
use super::unknown::Unknown;
use super::{Measured, SceneModel};
use crate::calibrate::fit::choose;
use crate::calibrate::judgement::misfit::{Misfit, residuals};
use crate::calibrate::solve::refit::Held;
use crate::calibrate::solve::{LawSetting, constants};
use crate::calibrate::{
    Experiment, FitError, FitOptions, FittableLaw, Mode, Partner, Sample, Weighting, fit_experiment, poisson,
};
use crate::material::parameter::Values;
use crate::material::{Moduli, Parameter};

/// The fit with a gauge length, or the reason why there is none.
pub fn fit(model: &SceneModel, measured: &Measured, weighting: Weighting, [length_m, section_m2]: [f64; 2]) -> Gauge {
    let (values, rms_relative, left_out) = match read(model, measured, weighting, [length_m, section_m2]) {
        Ok((values, rms_relative)) => (values, Some(rms_relative), None),
        Err(why) => (vec![None; model.unknown.len()], None, Some(why)),
    };
    Gauge { length_m, section_m2, values, rms_relative, left_out }
}

/// The value of each unknown, if the closed form has it, and the relative misfit.
fn read(
    model: &SceneModel,
    measured: &Measured,
    weighting: Weighting,
    [length, section]: [f64; 2],
) -> Result<(Vec<Option<f64>>, f64), String> {
    let constant = model.unknown.iter().find_map(|u| u.key.law_constant());
    let law = constant.ok_or("no constant of a law is looked for")?.law;
    let (entry, mut known, _) = model.spec.known_laws.given(&model.spec.laws[law]).map_err(|e| e.to_string())?;
    let title = entry.info.title;
    let fitted = FittableLaw::new(entry.info.name, None)
        .map_err(|_| format!("the law of {law}, {title}, has no closed form for a homogeneous piece"))?;
    let with_e = partner_of_e(&known);
    if let Some(Ok(moduli)) = with_e.map(|_| Moduli::from_map(&known)) {
        known.insert("mu".into(), moduli.mu);
    }
    let own = fitted.form.parameters.iter().filter(|p| known.contains_key(p.name)).count();
    let is_given = |form: &FittableLaw| {
        let parameters = form.parameters();
        parameters.len() == own && parameters.iter().all(|p| known.contains_key(p.name))
    };
    let mut forms = fitted.form.term_counts.iter().map(|terms| FittableLaw { terms: *terms, ..fitted });
    let form = forms.find(is_given).ok_or_else(|| {
        format!("the closed form of the law of {law}, {title}, has other constants than those that the scene gives")
    })?;
    let parameters = form.parameters();
    let is_e = |name: &str| name == "E" && with_e.is_some();
    let place = |u: &Unknown| {
        let constant = u.key.law_constant().filter(|c| c.law == law)?;
        let name = if is_e(constant.key) { "mu" } else { constant.key };
        parameters.iter().position(|p| p.name == name)
    };
    let places: Vec<Option<usize>> = model.unknown.iter().map(place).collect();
    let held = Held {
        values: parameters.iter().map(|p| known[p.name]).collect(),
        free: places.iter().flatten().copied().collect(),
    };
    if held.free.is_empty() {
        return Err(format!("none of the constants of {law} that are looked for is in the closed form of its law"));
    }
    let experiment = homogeneous(measured, length, section);
    let nu = form.poisson_keys().find_map(|k| known.get(&k).copied());
    let (terms, partner) = (Some(form.terms), nu.map(Partner::Nu));
    let options = FitOptions { terms, weighting, partner, ranges: 0, ..FitOptions::new(entry.info.name) };
    let found = if held.free.len() == parameters.len() {
        fit_experiment(&experiment, &options).map(|answer| {
            let of = |p: &Parameter| answer.parameters.iter().find(|e| e.name == p.name).map(|e| e.value);
            (parameters.iter().map(of).collect(), answer.misfit.rms_relative)
        })
    } else {
        some(&experiment, &options, form, held).map(|(values, misfit)| (values.into_iter().map(Some).collect(), misfit))
    };
    let (values, rms_relative): (Vec<Option<f64>>, f64) =
        found.map_err(|e| format!("the closed form of the law of {law} cannot be fitted: {e}"))?;
    let own = |(u, place): (&Unknown, &Option<usize>)| {
        let value = values[(*place)?]?;
        match is_e(u.parameter.name) {
            true => Moduli::from_pair(("mu", value), with_e?).ok().map(|moduli| moduli.e),
            false => Some(value),
        }
    };
    Ok((model.unknown.iter().zip(&places).map(own).collect(), rms_relative))
}

/// The other modulus of a law that is given by E instead of the μ of its closed form: it is held, so that E follows from μ.
fn partner_of_e(known: &Values) -> Option<(&'static str, f64)> {
    let value = |name: &'static str| known.get(name).map(|value| (name, *value));
    ["nu", "kappa", "lambda"].into_iter().find_map(value).filter(|_| known.contains_key("E"))
}

/// The curve as a test of a homogeneous piece.
fn homogeneous(measured: &Measured, length: f64, section: f64) -> Experiment {
    let sample = |((x, y), line): ((&f64, &f64), &u64)| Sample {
        mode: Mode::Uniaxial,
        second: 1.0,
        stretch: 1.0 + x / length,
        stress: y / section,
        line: *line,
        specimen: 0,
    };
    let samples = measured.x.iter().zip(&measured.y).zip(&measured.lines).map(sample).collect();
    Experiment::of_samples(&measured.file, &measured.sha256, samples)
}

/// Fits some of the constants of a law; returns them with their relative misfit.
fn some(
    experiment: &Experiment,
    options: &FitOptions,
    form: FittableLaw,
    held: Held,
) -> Result<(Vec<f64>, f64), FitError> {
    let (form, _) = poisson::of_options(options, form)?;
    let choice = choose(experiment, options)?;
    let setting = LawSetting { held: Some(held), ..choice.setting(options, form)? };
    let values = constants(&setting, &choice.fitted, None)?.values;
    let own = residuals(&choice.fitted, |s| form.at(&values, s));
    let misfit = Misfit::of(&own).expect("the data points were counted");
    Ok((values, misfit.rms_relative))
}
