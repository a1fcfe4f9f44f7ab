//! Work and precision: error against cost, and against what the cost is made of.

use crate::report::canvas::{
    Area, At, GREY, INK, Mark, RGB, SMALL, dashed, figure, fill, italic, line, mark, mm, text,
};
use crate::report::figure::{Figure, Sample, UNRESOLVED, legend_below, legend_lines, style};
use crate::report::names;
use crate::report::numbers::{capital, raised};
use crate::report::panels::{Panels, letter};
use crate::report::plot::{Axis, BELOW, Plot, without_panel};
use crate::study::analysis::{Analysis, ByQuantity};
use crate::study::kinds::cost::findings::{CostFindings, CostOfAccuracy, CostedCase, MEASURES, Measure};
use crate::study::store::record::Role;
use crate::study::store::results::Results;
use plotters::style::Color;

const LEFT: f64 = 15.0;
const EACH: f64 = 70.0;
const GAP: f64 = 18.0;
const TOP: f64 = 6.0;
const TALL: f64 = 44.0;
/// Least width of a panel \[mm\]
const LEAST: f64 = 60.0;
/// Between two rows of panels \[mm\]
const BETWEEN: f64 = 19.0;

/// The amount along the x axis.
struct Amount {
    label: String,
    title: &'static str,
    /// In the caption
    words: &'static str,
    of: fn(&CostedCase) -> Option<f64>,
}

/// Error of the peak and of the curve of every quantity of a variant over its cost.
pub fn precision(store: &Results, a: &Analysis<CostFindings>, variant: &str) -> Option<Figure> {
    let is_refused = |q: &CostOfAccuracy| q.reference.as_ref().is_some_and(|r| r.refused);
    let own = a.quantities.iter().filter(|q| q.variant == variant);
    let shown: Vec<&ByQuantity<CostOfAccuracy>> = own.filter(|q| q.settings.len() > 1 || is_refused(q)).collect();
    let cost = Amount { label: "CPU time [s]".into(), title: "", words: "", of: |s| Some(s.cost_s) };
    let (panels, others): (Vec<(&ByQuantity<CostOfAccuracy>, Measure)>, Vec<_>) =
        shown.iter().flat_map(|q| MEASURES.map(|m| (*q, m))).partition(|(q, m)| q.uncertainty(*m).is_finite());
    let name = |(q, m): &(&ByQuantity<CostOfAccuracy>, Measure)| format!("{} of the {}", m.words(), q.quantity.label);
    let (small, panels): (Vec<_>, Vec<_>) = panels.into_iter().partition(|(q, m)| below(a, q, *m).is_some());
    if panels.is_empty() {
        return None;
    }
    let small: Vec<(String, f64)> =
        small.iter().filter_map(|p| Some((format!("the {}", name(p)), below(a, p.0, p.1)?))).collect();
    let unknown: Vec<String> = others.iter().map(name).collect();
    let unknown = match &unknown[..] {
        [] => String::new(),
        some => format!(" Without a reference, so that no error is known: {}.", some.join(", ")),
    };
    let svg = sheet(store, &shown, panels.len(), |k, area, frame| {
        let (q, measure) = panels[k];
        panel(store, a, q, measure, &cost, &name(&panels[k]), area, frame, letter(k, panels.len()));
    });
    let caption = format!(
        "Work and precision, {}: error of the peak and of the whole curve (mark) and its error bar (whisker) over the CPU time of \
         a case. In the grey zone errors are smaller than the uncertainty of the reference; {BELOW}.{unknown}{}",
        store.study.label(variant),
        without_panel(&small)
    );
    Some(Figure { name: format!("work-precision-{variant}"), svg, caption })
}

/// The largest error of a measure \[%\], where all are below any axis.
fn below(a: &Analysis<CostFindings>, q: &ByQuantity<CostOfAccuracy>, measure: Measure) -> Option<f64> {
    Axis::below(q.settings.iter().map(|s| 100.0 * s.errors[measure as usize]), 100.0 * a.tolerance)
}

/// Error of the first quantity of a variant over unknowns, entries of the factor, operations and memory, as far as they differ.
pub fn amounts(store: &Results, a: &Analysis<CostFindings>, variant: &str) -> Option<Figure> {
    let is_drawn = |q: &&ByQuantity<CostOfAccuracy>| {
        q.uncertainty(Measure::Peak).is_finite() && below(a, q, Measure::Peak).is_none()
    };
    let q = a.quantities.iter().filter(is_drawn).find(|q| q.variant == variant && q.settings.len() > 1)?;
    let all = [
        Amount {
            label: format!("free degrees of freedom {}", italic("n")),
            title: "unknowns",
            words: "unknowns",
            of: |s| Some(s.dofs as f64),
        },
        Amount {
            label: format!("entries of the factor nnz({})", italic("L")),
            title: "Cholesky factor",
            words: "entries of the factor",
            of: |s| Some(s.factor_nnz as f64),
        },
        Amount {
            label: format!("operations in all factorisations [{}]", raised(9)),
            title: "operations",
            words: "additions and multiplications of all its factorisations",
            of: |s| Some(1e-9 * s.flops).filter(|f| *f > 0.0),
        },
        Amount {
            label: "largest resident set [MB]".into(),
            title: "memory",
            words: "largest resident set of the process",
            of: |s| s.memory_bytes.map(|b| 1e-6 * b as f64),
        },
    ];
    let differ = |x: &Amount| {
        let values = || q.settings.iter().filter_map(x.of);
        values().fold(0.0, f64::max) > 1.5 * values().fold(f64::INFINITY, f64::min)
    };
    // On one mesh memory differs by what other cases have left only
    let meshes = differ(&all[0]);
    let amounts: Vec<&Amount> = all.iter().filter(|x| differ(x) && (meshes || x.title != "memory")).collect();
    if amounts.is_empty() {
        return None;
    }
    let svg = sheet(store, &[q], amounts.len(), |k, area, frame| {
        panel(store, a, q, Measure::Peak, amounts[k], amounts[k].title, area, frame, letter(k, amounts.len()));
    });
    let over: Vec<&str> = amounts.iter().map(|x| x.words).collect();
    let caption = format!(
        "Error of the peak {}, {}, over what a case consists of: {}.",
        q.quantity.label,
        q.variant_label,
        over.join("; ")
    );
    Some(Figure { name: format!("work-amounts-{variant}"), svg, caption })
}

/// Panels in two columns with the legend of the families below.
fn sheet(
    store: &Results,
    shown: &[&ByQuantity<CostOfAccuracy>],
    count: usize,
    paint: impl Fn(usize, &Area, [i32; 4]),
) -> String {
    let used = |f: &str| shown.iter().any(|q| q.settings.iter().any(|s| s.family == f));
    let mut entries: Vec<(Sample, String)> = (store.study.families.iter())
        .filter(|f| f.role != Role::Reference && used(&f.name))
        .map(|f| {
            let (m, c) = look(store, &f.name);
            (Sample::Mark(m, c), names::family(&f.name))
        })
        .collect();
    entries.push((Sample::Line(GREY), "Pareto front".into()));
    entries.push((Sample::Dashed(INK), "tolerance".into()));
    entries.push((Sample::Block(UNRESOLVED), format!("below U({})", italic("f*"))));
    let panels = Panels::new(count, (LEFT, GAP, 5.0), (LEAST, EACH));
    let wide = panels.width();
    let foot = 14.0 + 4.2 * legend_lines(&entries, wide - LEFT);
    let tall = panels.tall(TALL, (BETWEEN, TOP + foot));
    let row = tall + BETWEEN;
    let below = TOP + panels.rows() * row - BETWEEN;
    figure(wide, below + foot, "", |area| {
        for k in 0..count {
            let (x, y) = (panels.x(k), TOP + panels.row(k) * row);
            paint(k, area, [mm(x), mm(y), mm(x + panels.each), mm(y + tall)]);
        }
        legend_below(area, (LEFT, below + 13.0), wide - LEFT, entries);
    })
}

/// Families of one variant have marks of their own; those of the reference are not drawn.
fn look(store: &Results, family: &str) -> (Mark, RGB) {
    let runs = |name: &str, variant: &String| store.cases.iter().any(|c| c.is_in(name, variant));
    let own: Vec<&String> = store.study.variants.iter().filter(|v| runs(family, v)).collect();
    let shown_together = |name: &str| own.iter().any(|v| runs(name, v));
    let drawn = store.study.families.iter().filter(|f| f.role != Role::Reference && shown_together(&f.name));
    style(drawn.map(|f| f.name.as_str()).position(|name| name == family).unwrap_or(0))
}

#[expect(clippy::too_many_arguments)]
fn panel(
    store: &Results,
    a: &Analysis<CostFindings>,
    q: &ByQuantity<CostOfAccuracy>,
    measure: Measure,
    amount: &Amount,
    title: &str,
    area: &Area,
    frame: [i32; 4],
    letter: Option<char>,
) {
    let error = |s: &CostedCase| 100.0 * s.errors[measure as usize];
    let (tolerance, unknown) = (100.0 * a.tolerance, 100.0 * q.uncertainty(measure));
    let x = Axis::log(q.settings.iter().filter_map(amount.of), &amount.label);
    let label = format!("error of the {} [%]", measure.words());
    let values = q.settings.iter().flat_map(|s| [error(s), error(s) + unknown]);
    let plot = Plot { area, frame, x, y: Axis::of_errors(values, tolerance, 0.0, &label) };
    if unknown > plot.y.lo {
        let (p, r) = (plot.at(plot.x.lo, unknown.min(plot.y.hi)), plot.at(plot.x.hi, plot.y.lo));
        fill(area, &[p, (r.0, p.1), r, (p.0, r.1)], UNRESOLVED.to_rgba());
    }
    plot.grid();
    dashed(area, &[plot.at(plot.x.lo, tolerance), plot.at(plot.x.hi, tolerance)], INK, 7, 25.0);
    let placed: Vec<(&CostedCase, f64)> = q.settings.iter().filter_map(|s| Some((s, (amount.of)(s)?))).collect();
    let mut order = placed.clone();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (mut front, mut best): (Vec<(i32, i32)>, f64) = (vec![], f64::INFINITY);
    for (s, x) in order {
        if error(s) < best {
            best = error(s);
            let p = plot.floored(x, best);
            front.extend(front.last().map(|last| (p.0, last.1)));
            front.push(p);
        }
    }
    front.extend(front.last().map(|last| (frame[2], last.1)));
    line(area, &front, GREY, 8);
    // A bar below the axis is not drawn
    for (s, x) in placed.iter().filter(|(s, _)| error(s) + unknown > plot.y.lo) {
        let color = look(store, &s.family).1;
        let (p, bar) = (plot.floored(*x, error(s)), plot.at(*x, error(s) + unknown));
        line(area, &[p, bar], color, 4);
        line(area, &[(bar.0 - 14, bar.1), (bar.0 + 14, bar.1)], color, 4);
    }
    for (s, x) in &placed {
        let (shape, color) = look(store, &s.family);
        mark(area, shape, plot.floored(*x, error(s)), 26, color);
    }
    plot.axes(true);
    plot.title(letter, &capital(title));
    if placed.len() < q.settings.len() {
        let missing = format!("{} of {} not measured", q.settings.len() - placed.len(), q.settings.len());
        text(area, &missing, (frame[2] - mm(1.0), frame[1] + mm(2.5)), At::Right, SMALL, GREY);
    }
}
