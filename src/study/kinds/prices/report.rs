//! Report of a price list of effects.

use crate::report::table::Table;
use crate::report::words::digits;
use crate::study::content::Content;
use crate::study::kinds::prices::figures;
use crate::study::kinds::prices::{Analysis, Ladder, analyse, milliseconds};
use crate::study::results::Results;
use crate::study::tables;
use serde_json::{Map, Value, json};

pub fn content(store: &Results) -> Content {
    let a = analyse(&store.study, &store.cases);
    Content {
        verdict: a.verdict.clone(),
        supported: a.ladders.iter().any(|l| l.rungs.len() > 1),
        facts: a.ladders.iter().filter_map(fact).collect(),
        sentences: a.ladders.iter().map(|l| l.sentence.clone()).collect(),
        warnings: a.warnings.clone(),
        analysis: analysis(&a),
        answer: ("The price list", list(&a)),
        tables: vec![evaluations(&a), answers(store, &a)],
        folded: vec![("Every case", tables::cases(store)), ("Time per effect", tables::effects(store))],
        files: vec![],
        outcomes: Default::default(),
        figures: a.ladders.iter().filter_map(figures::draw).collect(),
    }
}

/// The lowest and the highest rung.
fn fact(l: &Ladder) -> Option<(String, String)> {
    let (first, last) = (l.rungs.first()?, l.rungs.last()?);
    let range = format!("{} to {}", milliseconds(first.step_s), milliseconds(last.step_s));
    Some((range, format!("a step, {} to {}, {}", first.member, last.member, l.variant_label)))
}

fn analysis(a: &Analysis) -> Map<String, Value> {
    let mut out = Map::new();
    out.insert("incomplete".into(), json!(a.incomplete));
    a.ladders.iter().for_each(|l| drop(out.insert(l.variant.clone(), json!(l))));
    out
}

/// Milliseconds with their sign.
fn ms(s: f64) -> String {
    let ms = 1e3 * s;
    format!("{ms:.*}", digits(ms) + 1)
}

fn list(a: &Analysis) -> Table {
    let mut rows = vec![];
    for l in &a.ladders {
        for r in &l.rungs {
            rows.push(vec![
                r.member.clone(),
                l.variant.clone(),
                r.new.join(", "),
                ms(r.step_s),
                r.added_s.map_or("–".into(), ms),
                ms(r.new_evaluation_s()),
                ms(r.factorisation_s),
                format!("{:.2}", r.newton_iterations as f64 / r.steps as f64),
                ms(r.step_s * r.steps as f64 / r.newton_iterations.max(1) as f64),
                r.dofs.to_string(),
            ]);
        }
    }
    Table {
        name: "prices",
        caption: "Each row has the effects of the rows above and its own. Added: the step less that of the row above, with the iterations and factorisations that follow from the effect; evaluation: the time in the new effect itself. CPU time.".into(),
        columns: vec![
            ("Scene with", "", false),
            ("Control", "", false),
            ("New", "", false),
            ("Step", "ms", true),
            ("Added", "ms", true),
            ("Evaluation", "ms", true),
            ("Factorisation", "ms", true),
            ("Iterations per step", "", true),
            ("Iteration", "ms", true),
            ("DOFs", "", true),
        ],
        rows,
        pick: None,
    }
}

fn evaluations(a: &Analysis) -> Table {
    let mut rows = vec![];
    for l in &a.ladders {
        for r in &l.rungs {
            for (name, s) in &r.evaluation_s {
                let share = format!("{:.2}", 100.0 * s / r.step_s);
                rows.push(vec![r.member.clone(), l.variant.clone(), name.clone(), ms(*s), share]);
            }
        }
    }
    Table {
        name: "evaluations",
        caption: "CPU time in the evaluations of each effect and constraint that is assembled, per step. What is not \
                  declared has no row."
            .into(),
        columns: vec![
            ("Scene with", "", false),
            ("Control", "", false),
            ("Effect", "", false),
            ("Evaluation", "ms", true),
            ("Share of the step", "%", true),
        ],
        rows,
        pick: None,
    }
}

fn answers(store: &Results, a: &Analysis) -> Table {
    let mut rows = vec![];
    for l in &a.ladders {
        let own = store.study.quantities.get(&l.variant);
        for r in &l.rungs {
            for (column, peak, change) in &r.quantities {
                let label = own.into_iter().flatten().find(|q| q.name == *column);
                rows.push(vec![
                    r.member.clone(),
                    l.variant.clone(),
                    label.map_or(column.clone(), |q| format!("{} [{}]", q.label, q.unit)),
                    format!("{peak:.*}", digits(1e-2 * peak)),
                    change.map_or("–".into(), |c| format!("{:.3}", 100.0 * c)),
                ]);
            }
        }
    }
    Table {
        name: "answers",
        caption: "What each addition does to the answer: peaks, and their change from the row above.".into(),
        columns: vec![
            ("Scene with", "", false),
            ("Control", "", false),
            ("Quantity", "", false),
            ("Peak", "", true),
            ("Change", "%", true),
        ],
        rows,
        pick: None,
    }
}
