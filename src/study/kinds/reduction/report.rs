//! Report of a reduction study: what each model costs and how far it is off, and whether its bars hold.

use crate::report::figure::drawn;
use crate::report::numbers::significant;
use crate::report::table::{Table, headings};
use crate::study::analysis::Analysis;
use crate::study::content::Content;
use crate::study::kinds::reduction::analysis::{ReductionFindings, relative, time};
use crate::study::kinds::reduction::figures;
use crate::study::store::results::Results;
use crate::study::tables;
use serde_json::{Map, json};

pub fn content(store: &Results, a: &Analysis<ReductionFindings>) -> Content {
    let mut analysis = Map::new();
    analysis.insert("derived".into(), json!(a.derived));
    analysis.insert("chosen".into(), json!(a.chosen.map(|k| a.models()[k].file.clone())));
    analysis.insert("incomplete".into(), json!(a.incomplete));
    let figures = [
        drawn("work-precision", || figures::precision(a)),
        drawn("bars", || figures::bars(a)),
        drawn("singular-values", || figures::decay(a)),
    ];
    Content {
        facts: facts(a),
        sentences: sentences(a),
        analysis,
        tables: vec![errors(a)],
        folded: vec![("Every case", tables::cases(store))],
        figures: figures.into_iter().flatten().collect(),
        ..Content::new(a, a.chosen.is_some() && a.incomplete.is_empty(), ("Models", models(a)))
    }
}

fn facts(a: &ReductionFindings) -> Vec<(String, String)> {
    let Some((derived, k)) = a.derived.as_ref().zip(a.chosen) else { return vec![] };
    let model = &derived.models[k];
    let mut out = vec![
        (time(model.step_s[0]), "a step of the reduced model".into()),
        (format!("{}×", significant(model.gain(derived.full_step_s), 2)), "faster than the full model".into()),
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
    vec![
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
    ]
}

/// Confidence of the bars of so many states, or runs.
fn confidence(states: usize) -> String {
    let least = 1.0 - crate::reduction::train::COVERED.powi(i32::try_from(states).unwrap_or(i32::MAX));
    format!("{:.0} %", 100.0 * least.min(crate::reduction::train::COVERED))
}

fn models(a: &ReductionFindings) -> Table {
    let full = a.derived.as_ref().map_or(f64::NAN, |d| d.full_step_s);
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
                 estimate. Steps are those of the runs that were held back, median and 99th percentile, the estimate included. The full model takes {} a step, \
                 in the median.",
                time(full)
            )
        } else {
            format!(
                "Reduced models. Displacements include supremisers; points are those from which forces are summed, and those of the error estimate. Steps of a \
             fiftieth of the way between two states, median and 99th percentile, and their iterations; leaps from state to state. The full \
             model takes {} from one training state to the next, in the median.",
                time(full)
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
                format!("{:.1}", q.bar_over_error),
            ]
        })
    });
    Table {
        name: "errors",
        caption: "Errors at the states that were held back, as shares of the largest value: the distance from the full model on the same mesh. The bar is \
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
