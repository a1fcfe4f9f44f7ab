//! Report of a comparison.

use crate::report::figure::drawn;
use crate::report::names::title;
use crate::report::numbers::{digits, percent, percent_cell, readable, space, span};
use crate::report::table::{Table, headings};
use crate::report::unit::labelled;
use crate::scene::column;
use crate::study::analysis::{Analysis, ByQuantity};
use crate::study::content::Content;
use crate::study::kinds::comparison::analysis::{decisions, signed};
use crate::study::kinds::comparison::figures::{curves, sequence};
use crate::study::kinds::comparison::findings::{ComparisonFindings, MemberDifferences};
use crate::study::kinds::comparison::finer;
use crate::study::kinds::comparison::sequence::{Sequence, milliseconds};
use crate::study::store::record::StudyRecord;
use crate::study::store::results::Results;
use crate::study::tables;
use serde_json::{Map, Value, json};

pub fn content(store: &Results, a: &Analysis<ComparisonFindings>) -> Content {
    let variants = store.study.variants.iter();
    let cumulative = !a.sequences.is_empty();
    let sentences = a.quantities.iter().map(|q| &q.sentence).chain(a.sequences.iter().map(|s| &s.sentence));
    let (mut shown, answer) = match cumulative {
        true => {
            (vec![evaluations(store, a), answers(store, a)], ("What each addition costs", sequence_costs(store, a)))
        }
        false => (vec![], ("Which member, at what cost", member_costs(store, a))),
    };
    if !a.quantities.is_empty() || !cumulative {
        shown.insert(0, comparison(store, a));
    }
    let of_variant = |v: &String| {
        let over_time = drawn("curves", || curves::over_time(store, a, v));
        [over_time, drawn("loops", || curves::loops(store, a, v))]
    };
    let figures = variants.flat_map(of_variant).flatten();
    let sequences = a.sequences.iter().filter_map(|s| drawn("sequence", || sequence::draw(&store.study, s)));
    let supported =
        a.quantities.iter().any(|q| q.members.len() > 1) || a.sequences.iter().any(|s| s.additions.len() > 1);
    Content {
        facts: facts(&store.study, a).into_iter().chain(a.sequences.iter().filter_map(range_of_step)).collect(),
        sentences: sentences.cloned().collect(),
        analysis: analysis(a),
        decisions: decisions(a),
        tables: shown,
        folded: vec![("Every case", tables::cases(store)), ("Time per effect", tables::effects(store))],
        figures: figures.chain(sequences).collect(),
        ..Content::new(a, supported, answer)
    }
}

/// The widest spread of a peak among the members.
fn facts(study: &StudyRecord, a: &Analysis<ComparisonFindings>) -> Vec<(String, String)> {
    let fact = |q: &ByQuantity<MemberDifferences>| {
        let others = q.members.iter().filter(|c| c.member != a.reference);
        let range = span(others.map(|c| c.peak_difference), |share| signed(q, share, a.tolerance))?;
        Some((range, format!("{}, against {}", q.peak_title(), study.member(&a.reference))))
    };
    a.quantities.iter().filter_map(fact).collect()
}

/// The quantities of every variant under their names, as in the other kinds of study.
fn analysis(a: &Analysis<ComparisonFindings>) -> Map<String, Value> {
    let mut out = Map::new();
    out.insert("reference".into(), json!(a.reference));
    out.insert("costs".into(), json!(a.costs));
    out.insert("incomparable".into(), json!(a.incomparable));
    out.insert("incomplete".into(), json!(a.incomplete));
    a.sequences.iter().for_each(|s| drop(out.insert(s.variant.clone(), json!(s))));
    out.extend(ByQuantity::as_json(&a.quantities));
    out
}

fn member_costs(store: &Results, a: &ComparisonFindings) -> Table {
    let rows = (a.costs.iter())
        .map(|p| {
            vec![
                store.study.member(&p.member),
                title(&p.formulation),
                p.cells.to_string(),
                p.dofs.to_string(),
                format!("{:.*}", digits(p.cpu_s), p.cpu_s),
                p.ratio.map_or("–".into(), |ratio| format!("{ratio:.2}")),
                format!("{:.2}", p.newton_iterations as f64 / p.steps.max(1) as f64),
                format!("{:.1}", 1e3 * p.cpu_s / p.newton_iterations.max(1) as f64),
            ]
        })
        .collect();
    Table {
        name: "costs",
        caption: "Cost of every member under the same protocol, mean over the variants; in bold the reference.".into(),
        columns: headings(&[
            ("Member", "", false),
            ("Element", "", false),
            ("Cells", "", true),
            ("DOFs", "", true),
            ("CPU", "s", true),
            ("Relative", "", true),
            ("Iterations per step", "", true),
            ("CPU per iteration", "ms", true),
        ]),
        rows,
        pick: Some(store.study.member(&a.reference)),
    }
}

fn comparison(store: &Results, a: &Analysis<ComparisonFindings>) -> Table {
    let mut rows = vec![];
    for q in &a.quantities {
        for c in &q.members {
            let optional = |v: Option<f64>| v.map_or("–".into(), percent_cell);
            rows.push(vec![
                format!("{}, {}", q.peak_label(), q.variant),
                store.study.member(&c.member),
                readable(c.peak, digits(1e-2 * q.peak)) + &space(&q.quantity.unit),
                percent_cell(c.peak_difference),
                optional(c.mesh_drift),
                percent_cell(c.distance),
                percent_cell(c.largest),
                c.lag_s.map_or("–".into(), |lag| format!("{:.1}", 1e3 * lag)),
                optional(c.loop_share),
            ]);
        }
    }
    let is_judged = a.quantities.iter().any(|q| finer::is_judged(q, &a.reference));
    let mesh = if is_judged { "what a finer mesh changes in the difference, " } else { "" };
    Table {
        name: "comparison",
        caption: format!(
            "Every member against {}: peak and its difference (f̂ − ĝ)/ĝ, negative where the magnitude is smaller, {mesh}distance of the curves (‖f − g‖₂ over ‖g − g₀‖₂, the changes of g from its start g₀, and ‖f − g‖∞ over the peak), lag, hysteresis as the share of the box around a cycle. Tolerance {}.",
            store.study.member(&a.reference),
            percent(a.tolerance)
        ),
        columns: headings(&[
            ("Quantity, variant", "", false),
            ("Member", "", false),
            ("Peak", "", true),
            ("Difference", "%", true),
            ("Mesh", "%", true),
            ("L2", "%", true),
            ("L∞", "%", true),
            ("Lag", "ms", true),
            ("Loop", "%", true),
        ]),
        rows,
        pick: None,
    }
}

/// The time of a step with the first effects and with all of them.
fn range_of_step(l: &Sequence) -> Option<(String, String)> {
    let (first, last) = (l.additions.first()?, l.additions.last()?);
    let range = format!("{} to {}", milliseconds(first.step_s), milliseconds(last.step_s));
    Some((range, format!("a step, {} to {}, {}", first.member, last.member, l.variant_label)))
}

/// Formats a time in milliseconds, with its sign.
fn ms(s: f64) -> String {
    let ms = 1e3 * s;
    format!("{ms:.*}", digits(ms) + 1)
}

fn sequence_costs(store: &Results, a: &ComparisonFindings) -> Table {
    let mut rows = vec![];
    for l in &a.sequences {
        for r in &l.additions {
            rows.push(vec![
                r.words(&store.study),
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
        name: "sequence-costs",
        caption: "Each row has the effects of the rows above and its own. Added: the step less that of the row above, with the iterations and factorisations that follow from the effect; evaluation: the time in the new effect itself. CPU time.".into(),
        columns: headings(&[
            ("Scene with", "", false),
            ("Variant", "", false),
            ("New", "", false),
            ("Step", "ms", true),
            ("Added", "ms", true),
            ("Evaluation", "ms", true),
            ("Factorisation", "ms", true),
            ("Iterations per step", "", true),
            ("Iteration", "ms", true),
            ("DOFs", "", true),
        ]),
        rows,
        pick: None,
    }
}

fn evaluations(store: &Results, a: &ComparisonFindings) -> Table {
    let mut rows = vec![];
    for l in &a.sequences {
        for r in &l.additions {
            for (name, s) in &r.evaluation_s {
                let share = percent_cell(s / r.step_s);
                rows.push(vec![store.study.member(&r.member), l.variant.clone(), name.clone(), ms(*s), share]);
            }
        }
    }
    Table {
        name: "evaluations",
        caption: "CPU time in the evaluations of each effect and constraint that is assembled, per step. An effect that is not \
                  declared has none."
            .into(),
        columns: headings(&[
            ("Scene with", "", false),
            ("Variant", "", false),
            ("Effect", "", false),
            ("Evaluation", "ms", true),
            ("Share of the step", "%", true),
        ]),
        rows,
        pick: None,
    }
}

fn answers(store: &Results, a: &ComparisonFindings) -> Table {
    let mut rows = vec![];
    for l in &a.sequences {
        let own = store.study.quantities.get(&l.variant);
        for r in &l.additions {
            for (column, peak, change) in &r.quantities {
                let label = own.into_iter().flatten().find(|q| q.name == *column);
                rows.push(vec![
                    store.study.member(&r.member),
                    l.variant.clone(),
                    label.map_or_else(|| column::label(column), |q| labelled(&q.label, &q.unit)),
                    readable(*peak, digits(1e-2 * peak)),
                    change.map_or("–".into(), |c| format!("{:.3}", 100.0 * c)),
                ]);
            }
        }
    }
    Table {
        name: "answers",
        caption: "What each addition does to the answer: peaks, and their change from the row above.".into(),
        columns: headings(&[
            ("Scene with", "", false),
            ("Variant", "", false),
            ("Quantity", "", false),
            ("Peak", "", true),
            ("Change", "%", true),
        ]),
        rows,
        pick: None,
    }
}
