//! The cost of a step as effects are added one by one.

use crate::report::canvas::{AREAS, At, INK, REMAINDER, RGB, SMALL, block, figure, mm, text};
use crate::report::figure::{Figure, LINE, Sample, legend};
use crate::report::numbers::digits;
use crate::report::panels::{Panels, letter};
use crate::report::plot::{Axis, Plot};
use crate::study::kinds::comparison::sequence::{Addition, Sequence, milliseconds};
use crate::study::store::record::StudyRecord;
use crate::wording::count;

const ROW: f64 = 7.0;
const TOP: f64 = 6.0;

/// Draws (a) the parts of a step and (b) the evaluations of the effects alone. `None` for fewer than two members.
pub fn draw(study: &StudyRecord, l: &Sequence) -> Option<Figure> {
    if l.additions.len() < 2 {
        return None;
    }
    let mut effects: Vec<&str> = vec![];
    for (name, _) in l.additions.iter().flat_map(|r| &r.evaluation_s) {
        if !effects.contains(&name.as_str()) {
            effects.push(name);
        }
    }
    // Effects beyond the available colours share one
    let color =
        |name: &str| effects.iter().position(|e| *e == name).and_then(|k| AREAS.get(k)).copied().unwrap_or(REMAINDER);
    let (named, others) = effects.split_at(effects.len().min(AREAS.len()));
    let others = (!others.is_empty()).then(|| (Sample::Block(REMAINDER), count(others.len(), "other effect")));
    let evaluations = |r: &Addition| r.evaluation_s.iter().map(|(n, s)| (*s, color(n))).collect::<Vec<_>>();
    let whole = |r: &Addition| {
        let all: f64 = r.evaluation_s.iter().map(|e| e.1).sum();
        let parts = [all, r.factorisation_s, r.solve_s];
        let mut out: Vec<(f64, RGB)> = parts.into_iter().zip(AREAS).collect();
        out.push(((r.step_s - parts.iter().sum::<f64>()).max(0.0), REMAINDER));
        out
    };
    // Leaves room on the right for the number behind the longest bar
    let panels = Panels::new(2, (34.0, 20.0, 9.0), (48.0, 70.0));
    let tall = ROW * l.additions.len() as f64;
    let rows = (named.len() + usize::from(others.is_some())).max(4).div_ceil(2) as f64;
    let step = TOP + tall + 14.0 + LINE * rows;
    let svg = figure(panels.width(), step * panels.rows(), "", |area| {
        let place = |k: usize| panels.frame(k, (TOP, step), tall);
        let panel = |number: usize, title: &str, parts: &dyn Fn(&Addition) -> Vec<(f64, RGB)>| {
            let [x, top, ..] = place(number);
            let sum = |r: &Addition| parts(r).iter().map(|p| 1e3 * p.0).sum::<f64>();
            let longest =
                Axis::linear([0.0, l.additions.iter().map(sum).fold(0.0, f64::max)].into_iter(), "a step [ms]");
            let frame = place(number).map(mm);
            let plot = Plot { area, frame, x: longest, y: Axis::exact(l.additions.len() as f64, 0.0, "") };
            plot.grid_x();
            for (k, r) in l.additions.iter().enumerate() {
                let mut from = 0.0;
                for (s, color) in parts(r) {
                    let to = from + 1e3 * s;
                    block(area, plot.at(from, k as f64 + 0.17), plot.at(to, k as f64 + 0.83), color);
                    from = to;
                }
                let end = (plot.at(from, 0.0).0 + mm(1.0), plot.at(0.0, k as f64 + 0.5).1);
                text(area, &format!("{from:.*}", digits(from)), end, At::Left, SMALL, INK);
            }
            plot.axis_x();
            plot.title(letter(number, 2), title);
            if panels.begins_row(number) {
                for (k, r) in l.additions.iter().enumerate() {
                    let at = (mm(x - 2.0), mm(top + ROW * (k as f64 + 0.5)));
                    text(area, &study.member(&r.member), at, At::Right, SMALL, INK);
                }
            }
        };
        panel(0, "A step by its parts", &whole);
        panel(1, "Evaluation of the effects", &evaluations);
        let put = |number: usize, entries: Vec<(Sample, String)>| {
            let [x, .., bottom] = place(number);
            for (k, entry) in entries.into_iter().enumerate() {
                // Starts at the left edge of the page, so that the second name fits on a narrow page
                let left = x - if panels.begins_row(number) { 10.0 } else { 0.0 };
                let at = (mm(left + 30.0 * (k % 2) as f64), mm(bottom + 14.5 + LINE * (k / 2) as f64));
                legend(area, at, &[entry]);
            }
        };
        let parts = ["evaluations", "factorisation", "solve"].iter().zip(AREAS);
        let parts = parts.map(|(n, c)| (Sample::Block(c), n.to_string()));
        put(0, parts.chain([(Sample::Block(REMAINDER), "rest".into())]).collect());
        let named = named.iter().map(|n| (Sample::Block(color(n)), n.replace('_', " ")));
        put(1, named.chain(others).collect());
    });
    Some(Figure { name: format!("sequence-{}", l.variant), svg, caption: caption(study, l) })
}

/// The caption, with the costs of a step of the first and of the last addition.
fn caption(study: &StudyRecord, l: &Sequence) -> String {
    let (first, last) = (&l.additions[0], &l.additions[l.additions.len() - 1]);
    let alone = if first.with.is_empty() { " alone" } else { "" };
    format!(
        "What a step costs with effects added one by one, {}, in CPU time: {} with {}{alone}, {} with {}. A row has no part of an effect that is not declared in it.",
        l.variant_label,
        milliseconds(first.step_s),
        first.words(study),
        milliseconds(last.step_s),
        l.extent(study)
    )
}
