//! Responses of all records and quantities from the runs of their designs, with their measured values and errors.

use crate::study::kinds::validation::evaluate::evaluate;
use crate::study::kinds::validation::joint::{Estimated, Response};
use crate::study::kinds::validation::plan::{ErrorPlan, QuantityPlan, RecordPlan, ValidationPlan};
use crate::study::kinds::validation::scatter::{Repeats, Scatter};
use crate::study::kinds::validation::surface::{Sample, Surface};
use crate::study::store::results::Results;

/// A record and a quantity with their response.
pub struct Target<'a> {
    pub record: &'a RecordPlan,
    pub quantity: &'a QuantityPlan,
    pub response: Response,
    pub measured: &'a [f64],
    /// Group of each independent error of the response
    pub groups: Vec<String>,
    /// Constants of law files whose uncertainty it lacks
    pub lacks: Vec<String>,
}

/// Change of the quantity of a record elsewhere, such as on another mesh; `None` if the record has no run there.
pub type Shift<'f> = dyn Fn(&RecordPlan, &QuantityPlan) -> Option<f64> + 'f;

impl Target<'_> {
    /// Returns the response with its surface shifted.
    pub fn moved(&self, shift: &Shift) -> Option<Response> {
        let surface = self.response.surface.clone().moved(shift(self.record, self.quantity)?);
        Some(Response { surface, ..self.response.clone() })
    }
}

/// Returns the responses of all records and quantities, from the cases of their designs. `repeats` gives the scatter of each quantity.
pub fn targets<'a>(
    results: &Results,
    plan: &'a ValidationPlan,
    repeats: &[Repeats],
) -> Result<Vec<Target<'a>>, String> {
    let shared = shared_errors(plan);
    let mut all = vec![];
    for record in &plan.records {
        for (place, (quantity, repeats)) in plan.quantities.iter().zip(repeats).enumerate() {
            let Some(measured) = quantity.records.get(&record.name) else { continue };
            let (samples, without) = samples(results, plan, record, quantity);
            let surface = Surface::fit(record.unknowns.len(), &samples)
                .map_err(|e| format!("{} of {}: {e}", quantity.label, record.label))?;
            let (mut noise, mut groups) = (vec![], vec![]);
            for e in quantity.errors_of(&record.name).filter(|e| e.shared.is_none()) {
                noise.push(e.deviation);
                groups.push(e.group.clone());
            }
            let scatter = repeats.in_record(&record.name);
            if let Some((_, s)) = scatter {
                noise.push(s.of_mean(measured.len()));
                groups.push("repeats".into());
            }
            let estimated =
                |(k, s): (usize, Scatter)| Estimated { pool: (place, k), freedom: s.freedom, factor: s.factor() };
            let amount = |e: &ErrorPlan| {
                let place = shared.iter().position(|(name, _)| e.shared.as_ref() == Some(name))?;
                Some((plan.inputs.len() + place, e.deviation))
            };
            let response = Response {
                surface,
                constants: record.unknowns.clone(),
                inputs: record.inputs.iter().map(|(k, _)| *k).collect(),
                noise,
                scatter: scatter.map(estimated),
                shared: quantity.errors_of(&record.name).filter_map(amount).collect(),
            };
            let lacks = record.open.iter().cloned().chain(without).collect();
            all.push(Target { record, quantity, response, measured, groups, lacks });
        }
    }
    Ok(all)
}

/// The runs of a design, and the inputs of law files by which they lack derivatives.
fn samples(
    results: &Results,
    plan: &ValidationPlan,
    record: &RecordPlan,
    q: &QuantityPlan,
) -> (Vec<Sample>, Vec<String>) {
    let keys = record.keys(&plan.unknowns);
    let of_law_file = |(k, _): &&(usize, Vec<(String, f64)>)| plan.inputs[*k].of_law_file;
    let stated = record.inputs.iter().filter(|input| !of_law_file(input)).cloned().collect();
    let stated = RecordPlan { inputs: stated, ..record.clone() }.keys(&plan.unknowns);
    let mut without: Vec<String> = vec![];
    let mut one = |(case, at): (&String, &Vec<f64>)| {
        let stored = results.cases.iter().find(|c| c.record.id == *case && c.is_of(&record.name))?;
        let derivatives = results.sensitivities.get(case);
        let by = |keys: &[String]| evaluate(q, &stored.series, derivatives, keys).filter(|_| stored.record.converged());
        let ((value, by), known) = if let Some(found) = by(&keys) {
            (found, &keys)
        } else {
            let found = by(&stated)?;
            let lost = record.inputs.iter().filter(of_law_file).map(|(k, _)| plan.inputs[*k].name.clone());
            without = lost.collect();
            (found, &stated)
        };
        let of = |key: &String| known.iter().position(|k| k == key).map_or(0.0, |k| by[k]);
        let by_constants =
            record.unknowns.iter().map(|k| &plan.unknowns[*k]).map(|u| of(&u.key) * u.half() * u.factor).collect();
        let along = |(_, keys): &(usize, Vec<(String, f64)>)| keys.iter().map(|(key, d)| of(key) * d).sum();
        Some(Sample { at: at.clone(), value, by_constants, by_inputs: record.inputs.iter().map(along).collect() })
    };
    let samples = plan.points.iter().filter_map(&mut one).collect();
    (samples, without)
}

/// Returns the sources that several data share, as name and group, each once.
pub fn shared_errors(plan: &ValidationPlan) -> Vec<(String, String)> {
    let mut all: Vec<(String, String)> = vec![];
    for e in plan.quantities.iter().flat_map(|q| q.errors.iter().chain(q.by_record.values().flatten())) {
        if let Some(name) = e.shared.as_ref().filter(|name| !all.iter().any(|(known, _)| known == *name)) {
            all.push((name.clone(), e.group.clone()));
        }
    }
    all
}

/// Returns the independent errors of a datum as shares of its variance.
pub fn shares(t: &Target) -> Vec<(String, f64)> {
    let total: f64 = t.response.noise.iter().map(|s| s * s).sum();
    t.groups.iter().cloned().zip(t.response.noise.iter().map(|s| s * s / total)).collect()
}
