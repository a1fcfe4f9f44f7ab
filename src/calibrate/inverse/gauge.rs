//! The usual evaluation of a tensile test: the whole displacement stretches a gauge length of one cross-section, λ = 1 + x/L, P = y/A, fitted
//! with the closed form of the same law. It starts the search, and its error is what the specimen corrects.

use super::answer::Gauge;
use super::{Measured, SceneModel};
use crate::calibrate::{Experiment, FitOptions, Mode, Model, Partner, Sample, Weighting, fit_experiment};
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
    let terms = fitted.form.term_counts.iter().copied().find(|t| {
        let parameters = Model { terms: *t, ..fitted }.parameters();
        parameters.len() == own && parameters.iter().all(|p| values.contains_key(p.name))
    })?;
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
    let nu = Model { terms, ..fitted }.poisson_keys().find_map(|k| values.get(&k).copied());
    let (terms, partner) = (Some(terms), nu.map(Partner::Nu));
    let options = FitOptions { terms, weighting, partner, ranges: 0, ..FitOptions::new(entry.info.name) };
    let answer = fit_experiment(&experiment, &options).ok()?;
    let of = |key: &str| answer.parameters.iter().find(|e| e.name == key).map(|e| e.value);
    let values = model.unknown.iter().map(|u| of(u.key.law_constant().filter(|c| c.law == law)?.key)).collect();
    Some(Gauge { length_m: length, section_m2: section, values, rms_relative: answer.misfit.rms_relative })
}
