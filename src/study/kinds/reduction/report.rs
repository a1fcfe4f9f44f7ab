//! Report of a reduction study: the cost and error of each model, and whether its bars hold.

use crate::report::figure::drawn;
use crate::report::numbers::{percent, significant};
use crate::report::table::{Table, headings};
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kinds::reduction::analysis::{ReductionFindings, relative, time};
use crate::study::kinds::reduction::figures;
use crate::study::kinds::reduction::record::{DerivedRecord, ReductionInputRecord, SearchStep};
use crate::study::store::results::Results;
use crate::study::tables;
use serde_json::{Map, json};

pub fn content(store: &Results, a: &Analysis<ReductionFindings>) -> Content {
    let mut analysis = Map::new();
    analysis.insert("derived".into(), json!(a.derived));
    let chosen = a.chosen.map(|k| a.models()[k].file.clone());
    let decision = chosen.clone().unwrap_or_else(|| "none".into());
    analysis.insert("chosen".into(), json!(chosen));
    analysis.insert("incomplete".into(), json!(a.incomplete));
    let figures = [
        drawn("meshes", || figures::meshes::meshes(a)),
        drawn("work-precision", || figures::precision(a)),
        drawn("bars", || figures::bars(a)),
        drawn("search", || figures::search::search(a)),
        drawn("singular-values", || figures::decay(a)),
    ];
    Content {
        facts: facts(a),
        sentences: sentences(a),
        analysis,
        decisions: [("smallest model within the tolerance".into(), decision)].into(),
        tables: [Some(errors(a)), against_meshes(a), search(a)].into_iter().flatten().collect(),
        folded: vec![("Every case", tables::cases(store))],
        without_result: a.without_models(),
        figures: figures.into_iter().flatten().collect(),
        ..Content::new(a, a.chosen.is_some() && a.incomplete.is_empty(), ("Models", models(a)))
    }
}

fn facts(a: &ReductionFindings) -> Vec<(String, String)> {
    let Some((derived, k)) = a.derived.as_ref().zip(a.chosen) else { return vec![] };
    let model = &derived.models[k];
    let measured = if model.step_s[0] > 0.0 { model.step_s[0] } else { model.leap_s[0] };
    let mut out = vec![
        (time(measured), "a step of the reduced model".into()),
        (
            format!("{}×", significant(model.gain(derived.full_step_s), 2)),
            format!("less CPU time than {}", derived.full()),
        ),
    ];
    for (q, asked) in model.quantities.iter().zip(&a.quantities) {
        out.push((
            format!("{} %", significant(100.0 * relative(q), 2)),
            format!("largest error of the {}", asked.label),
        ));
    }
    out
}

fn sentences(a: &ReductionFindings) -> Vec<String> {
    let Some(derived) = &a.derived else { return vec![] };
    let offline = derived.offline_s + derived.models.iter().map(|m| m.offline_s).sum::<f64>();
    let full = derived.training + derived.held_back;
    if derived.dt.is_some() {
        return vec![
            format!(
                "Offline the models take {full} runs of the full model, {} of them held back, and {} of work after these.",
                derived.held_back,
                time(offline)
            ),
            format!(
                "The error bars are made of the {} runs that were held back: in at least 95 % of further runs of this length, with inputs drawn in the same \
                 way, the error is within its bar at every step, with {} confidence. The runs are independent of one another; their steps are not.",
                derived.held_back,
                confidence(derived.held_back)
            ),
        ];
    }
    let mut out = vec![
        format!(
            "Offline the models take {full} states of the full model, {} of them held back, and {} of work after these.",
            derived.held_back,
            time(offline)
        ),
        format!(
            "The error bars are made of the {} states that were held back: at least 95 % of the errors at further states of the ranges lie within them, \
             with {} confidence.",
            derived.held_back,
            confidence(derived.held_back)
        ),
    ];
    out.extend(of_search(a, derived));
    out.extend(of_meshes(a, derived));
    out
}

/// Describes the inputs with their ranges, and the runs that the models are made of.
pub fn made_of(a: &ReductionFindings) -> String {
    let range = |i: &ReductionInputRecord| {
        let [low, high] = i.range.map(|end| end.to_string().replace('-', "−"));
        format!("{} from {low} to {high} {}", i.name, i.unit).trim_end().to_string()
    };
    let inputs = a.inputs.iter().map(range).collect::<Vec<_>>().join(", ");
    let Some(derived) = &a.derived else { return format!("Inputs of the models: {inputs}.") };
    let states = if derived.dt.is_some() { "runs in time" } else { "states" };
    format!(
        "Inputs of the models: {inputs}. The models are made of {} {states} within these ranges, and their bars of {} that were held back.",
        derived.training, derived.held_back
    )
}

/// How the greedy search proceeded, in a sentence.
fn of_search(a: &ReductionFindings, derived: &DerivedRecord) -> Option<String> {
    let (first, last) = (derived.search.first()?, derived.search.last()?);
    let share = |step: &SearchStep| step.largest.map_or("unknown".into(), percent);
    let plan = a.plan.unwrap_or(derived.training);
    let saved = match plan.saturating_sub(derived.training) {
        0 => "as many as a plan in one shot".into(),
        n => format!("{n} fewer than the {plan} of a plan in one shot"),
    };
    Some(format!(
        "The search began with {} states and ended with {}: {saved}. The largest estimated error at its candidates went from {} to {} of the largest change.",
        first.states,
        last.states,
        share(first),
        share(last)
    ))
}

/// The errors of mesh and reduction, separately.
fn of_meshes(a: &ReductionFindings, derived: &DerivedRecord) -> Option<String> {
    let of = derived.comparison.as_ref()?;
    let own = of.meshes.first()?;
    let model = a.chosen.or(derived.models.len().checked_sub(1))?;
    let part = |k: usize| {
        let q = &a.quantities[k];
        let mesh = percent(own.errors[k] / of.sizes[k]);
        format!(
            "the {} {mesh} by the mesh and {} by the reduction",
            q.label,
            percent(relative(&derived.models[model].quantities[k]))
        )
    };
    let all: Vec<String> = (0..a.quantities.len()).map(part).collect();
    Some(format!(
        "Two errors, of the largest changes: {}. The first is the distance of the mesh of {} cells from a reference of {} cells at {} states, the second that of the model of {} modes from its own \
         mesh.",
        all.join(", "),
        own.cells,
        of.reference_cells,
        of.points,
        derived.models[model].modes
    ))
}

/// A table of meshes and models with their distances from the reference.
fn against_meshes(a: &ReductionFindings) -> Option<Table> {
    let derived = a.derived.as_ref()?;
    let of = derived.comparison.as_ref()?;
    let shares =
        |errors: &[f64]| errors.iter().zip(&of.sizes).map(|(e, size)| significant(100.0 * e / size, 2)).collect();
    let row =
        |name: String, cells: String, step: f64, errors: Vec<String>| [vec![name, cells, time(step)], errors].concat();
    let meshes = of.meshes.iter().map(|m| row(m.name.clone(), m.cells.to_string(), m.step_s, shares(&m.errors)));
    let models = derived.models.iter().zip(&of.models).map(|(m, errors)| {
        let errors = errors.as_ref().map_or(vec!["no equilibrium".into(); of.sizes.len()], |e| shares(e));
        row(format!("model of {} modes", m.modes), String::new(), m.leap_s[0], errors)
    });
    let names = a.quantities.iter().map(|q| (q.label.as_str(), "%", true));
    let columns: Vec<_> = [("", "", false), ("Cells", "", true), ("Step", "", true)].into_iter().chain(names).collect();
    Some(Table {
        name: "meshes",
        caption: format!(
            "Largest distances from the reference of {} cells at {} states, as shares of the largest change. Of a model they contain the error of its mesh. Steps in CPU time, those of \
             meshes on average over their run, those of models in the median; a step of the reference takes {}.",
            of.reference_cells,
            of.points,
            time(of.reference_step_s)
        ),
        columns: headings(&columns),
        rows: meshes.chain(models).collect(),
        pick: None,
    })
}

/// A table of the steps of a greedy search.
fn search(a: &ReductionFindings) -> Option<Table> {
    let derived = a.derived.as_ref().filter(|d| !d.search.is_empty())?;
    let share = |value: Option<f64>| value.map_or("unknown".into(), |v| significant(100.0 * v, 2));
    let row = |s: &SearchStep| vec![s.states.to_string(), share(s.largest), share(s.median)];
    Some(Table {
        name: "search",
        caption: "Estimated errors of the largest model of so many training states at the candidates of the greedy plan, as shares of the largest change; unknown where it has no equilibrium or no \
                  estimate at one of them."
            .into(),
        columns: headings(&[("States", "", true), ("Largest", "%", true), ("Median", "%", true)]),
        rows: derived.search.iter().map(row).collect(),
        pick: None,
    })
}

/// The confidence level of error bars from `states` states, or runs.
fn confidence(states: usize) -> String {
    format!("{:.0} %", 100.0 * crate::reduction::training::train::confidence(states))
}

fn models(a: &ReductionFindings) -> Table {
    let (full, from_rest) = a.derived.as_ref().map_or((f64::NAN, false), |d| (d.full_step_s, d.full_from_rest));
    let row = |m: &crate::study::kinds::reduction::record::ModelRecord| {
        vec![
            m.modes.to_string(),
            m.displacements.to_string(),
            m.pressures.to_string(),
            m.points.to_string(),
            m.estimate_points.to_string(),
            format!("{:.0}", 1e-3 * m.bytes as f64),
            time(m.step_s[0]),
            time(m.step_s[1]),
            format!("{:.1}", m.iterations[0]),
            time(m.leap_s[0]),
            significant(m.gain(full), 2),
            format!("{:.1}", m.offline_s),
        ]
    };
    Table {
        name: "models",
        caption: if a.derived.as_ref().is_some_and(|d| d.dt.is_some()) {
            format!(
                "Reduced models. Displacements include supremisers; points are those from which forces are summed, and those of the enriched model of the \
                 estimate. Steps are those of the runs that were held back, median and 99th percentile, the estimate included. The full model takes {} of \
                 CPU time a step, in the median.",
                time(full)
            )
        } else {
            format!(
                "Reduced models. Displacements include supremisers; points are those from which forces are summed, and those of the error estimate. Steps of a \
             fiftieth of the way between two states, median and 99th percentile, and their iterations; leaps from state to state. The full \
             model takes {} of CPU time {} that were held back, in the median.",
                time(full),
                if from_rest { "from rest to each of the states" } else { "from one to the next of the states" }
            )
        },
        columns: headings(&[
            ("Modes", "", true),
            ("Displacements", "", true),
            ("Pressures", "", true),
            ("Points", "", true),
            ("Of the estimate", "", true),
            ("File", "kB", true),
            ("Step", "", true),
            ("99 %", "", true),
            ("Iterations", "", true),
            ("Leap", "", true),
            ("Faster", "times", true),
            ("Offline", "s", true),
        ]),
        rows: a.models().iter().map(row).collect(),
        pick: a.chosen.map(|k| a.models()[k].modes.to_string()),
    }
}

fn errors(a: &ReductionFindings) -> Table {
    let rows = a.models().iter().flat_map(|m| {
        m.quantities.iter().zip(&a.quantities).map(|(q, asked)| {
            vec![
                m.modes.to_string(),
                asked.label.clone(),
                significant(100.0 * relative(q), 2),
                significant(100.0 * q.median / q.size, 2),
                format!("{:.2}", q.factor),
                if q.bar_over_error.is_nan() { "–".into() } else { format!("{:.1}", q.bar_over_error) },
            ]
        })
    });
    Table {
        name: "errors",
        caption: "Errors at the states that were held back, as shares of the largest change: the distance from the full model on the same mesh. The bar is \
                  its factor times the estimate."
            .into(),
        columns: headings(&[
            ("Modes", "", true),
            ("Quantity", "", false),
            ("Largest", "%", true),
            ("Median", "%", true),
            ("Factor of the bar", "", true),
            ("Median bar/error", "", true),
        ]),
        rows: rows.collect(),
        pick: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::kinds::reduction::analysis::tests::found;

    /// If no small step was measured, the time of a step is the time from state to state.
    #[test]
    fn the_first_fact_is_a_time_that_was_measured() {
        let mut a = found(0.01, Some(0));
        assert_eq!(facts(&a)[0], ("100 µs".to_string(), "a step of the reduced model".to_string()));
        a.derived.iter_mut().for_each(|derived| derived.models[0].step_s = [1e-5, 2e-5]);
        assert_eq!(facts(&a)[0].0, "10 µs");
        let gain = ("10000×".to_string(), "less CPU time than the full model".to_string());
        assert_eq!(facts(&a)[1], gain);
    }

    /// The inputs are described before there are models; models that move are made from runs.
    #[test]
    fn models_are_made_of_states_or_of_runs() {
        let (start, held) = (None, false);
        let (name, key, unit) = ("tension".into(), "k".into(), "mm".into());
        let mut a = found(0.01, Some(0));
        a.inputs = vec![ReductionInputRecord { name, key, unit, range: [-3.0, 1.0], start, held }];
        let states = "Inputs of the models: tension from −3 to 1 mm. The models are made of 24 states within these ranges, and their bars of 1 that were held back.";
        assert_eq!(made_of(&a), states);
        a.derived.iter_mut().for_each(|derived| derived.dt = Some(0.01));
        assert_eq!(made_of(&a), states.replace("24 states", "24 runs in time"));
        a.derived = None;
        assert_eq!(made_of(&a), "Inputs of the models: tension from −3 to 1 mm.");
    }
}
