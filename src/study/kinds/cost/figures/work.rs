//! Work–precision diagrams: error against cost, and against the quantities that determine the cost.

use crate::report::canvas::{Area, At, GREY, Mark, RGB, SMALL, italic, mm, text};
use crate::report::figure::{Figure, Sample, style};
use crate::report::names;
use crate::report::numbers::{capital, raised};
use crate::report::panels::Letter;
use crate::report::plot::{Axis, BELOW, Plot, without_panel};
use crate::study::analysis::{Analysis, ByQuantity};
use crate::study::figures::sheet::Sheet;
use crate::study::figures::work_precision::{self, CostPoint, levels};
use crate::study::kinds::cost::findings::{CostFindings, CostOfAccuracy, CostedCase, MEASURES, Measure};
use crate::study::store::record::Role;
use crate::study::store::results::Results;

const SHEET: Sheet = Sheet { left: 15.0, gap: 18.0, least: 60.0, tall: 44.0, legend: 13.0, foot: 14.0 };

/// A quantity along the x axis.
struct Amount {
    label: String,
    title: &'static str,
    /// Name in the caption
    words: &'static str,
    of: fn(&CostedCase) -> Option<f64>,
}

/// Draws the error of the peak and of the curve of every quantity of a variant against its cost.
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
    let panel = panels.iter().map(|p| Panel { q: p.0, measure: p.1, amount: &cost, title: name(p) });
    let svg = sheet(store, a, &shown, &panel.collect::<Vec<Panel>>());
    let caption = format!(
        "Work and precision, {}: error of the peak and of the whole curve (mark) and its error bar (whisker) over the CPU time of \
         a case. In the grey zone errors are smaller than the uncertainty of the reference; {BELOW}.{unknown}{}",
        store.study.label(variant),
        without_panel(&small)
    );
    Some(Figure { name: format!("work-precision-{variant}"), svg, caption })
}

/// The largest error of a measure \[%\], if all errors are below any axis.
fn below(a: &Analysis<CostFindings>, q: &ByQuantity<CostOfAccuracy>, measure: Measure) -> Option<f64> {
    Axis::below(q.settings.iter().map(|s| 100.0 * s.errors[measure as usize]), 100.0 * a.tolerance)
}

/// Draws the error of the first quantity of a variant against unknowns, entries of the factor, operations and memory, as far as these differ between
/// cases.
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
    // On a single mesh, memory differs only by what other cases have left allocated
    let meshes = differ(&all[0]);
    let amounts: Vec<&Amount> = all.iter().filter(|x| differ(x) && (meshes || x.title != "memory")).collect();
    if amounts.is_empty() {
        return None;
    }
    let panel = amounts.iter().map(|x| Panel { q, measure: Measure::Peak, amount: x, title: x.title.into() });
    let svg = sheet(store, a, &[q], &panel.collect::<Vec<Panel>>());
    let over: Vec<&str> = amounts.iter().map(|x| x.words).collect();
    let caption = format!(
        "Error of the peak {}, {}, over what a case consists of: {}.",
        q.quantity.label,
        q.variant_label,
        over.join("; ")
    );
    Some(Figure { name: format!("work-amounts-{variant}"), svg, caption })
}

/// The panels, with the legend of the families of all quantities that are shown.
fn sheet(
    store: &Results,
    a: &Analysis<CostFindings>,
    shown: &[&ByQuantity<CostOfAccuracy>],
    panels: &[Panel],
) -> String {
    let used = |f: &str| shown.iter().any(|q| q.settings.iter().any(|s| s.family == f));
    let mut entries: Vec<(Sample, String)> = (store.study.families.iter())
        .filter(|f| f.role != Role::Reference && used(&f.name))
        .map(|f| {
            let (m, c) = look(store, &f.name);
            (Sample::Mark(m, c), names::family(&f.name))
        })
        .collect();
    entries.extend(work_precision::entries());
    SHEET.draw(panels, entries, |panel, area, frame, letter| {
        panel.draw(store, 100.0 * a.tolerance, area, frame, letter);
    })
}

/// The mark and colour of a family. Families of one variant have marks of their own; those of the reference are not drawn.
fn look(store: &Results, family: &str) -> (Mark, RGB) {
    let runs = |name: &str, variant: &String| store.cases.iter().any(|c| c.is_in(name, variant));
    let own: Vec<&String> = store.study.variants.iter().filter(|v| runs(family, v)).collect();
    let shown_together = |name: &str| own.iter().any(|v| runs(name, v));
    let drawn = store.study.families.iter().filter(|f| f.role != Role::Reference && shown_together(&f.name));
    style(drawn.map(|f| f.name.as_str()).position(|name| name == family).unwrap_or(0))
}

/// A panel with the errors of a quantity over an amount.
struct Panel<'a> {
    q: &'a ByQuantity<CostOfAccuracy>,
    measure: Measure,
    amount: &'a Amount,
    title: String,
}

impl Panel<'_> {
    fn draw(&self, store: &Results, tolerance: f64, area: &Area, frame: [i32; 4], letter: Option<Letter>) {
        let (q, measure) = (self.q, self.measure);
        let unknown = 100.0 * q.uncertainty(measure);
        let ends = |s: &CostedCase| {
            let error = 100.0 * s.errors[measure as usize];
            [error, error + unknown]
        };
        let setting = |s: &CostedCase| {
            let (cost, [error, bar]) = ((self.amount.of)(s)?, ends(s));
            Some(CostPoint { cost, error, bar, look: look(store, &s.family), may_be_chosen: true })
        };
        let placed: Vec<CostPoint> = q.settings.iter().filter_map(setting).collect();
        let x = Axis::log(placed.iter().map(|s| s.cost), &self.amount.label);
        let label = format!("error of the {} [%]", measure.words());
        let y = Axis::of_errors(q.settings.iter().flat_map(ends), tolerance, 0.0, &label);
        let plot = Plot { area, frame, x, y };
        levels(&plot, Some(unknown), tolerance);
        work_precision::draw(&plot, &placed);
        plot.axes(true);
        plot.title(letter, &capital(&self.title));
        if placed.len() < q.settings.len() {
            let missing = format!("{} of {} not measured", q.settings.len() - placed.len(), q.settings.len());
            text(area, &missing, (frame[2] - mm(1.0), frame[1] + mm(2.5)), At::Right, SMALL, GREY);
        }
    }
}
