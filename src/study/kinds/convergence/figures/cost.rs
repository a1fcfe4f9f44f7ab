//! Cost of a mesh: CPU seconds against unknowns and against entries of the factor, with the exponent of growth.

use crate::report::canvas::{Area, At, SMALL, columns, figure, italic, line, mark, mm, page_width, text};
use crate::report::figure::{Figure, Sample, legend_below, legend_lines};
use crate::report::names::title;
use crate::report::numbers::with_error;
use crate::report::panels::letter;
use crate::report::plot::{Axis, Plot};
use crate::study::estimate::power_law::{PowerLaw, power_law};
use crate::study::kinds::convergence::figures::look::{Look, looks};
use crate::study::store::record::{CaseRecord, Role};
use crate::study::store::results::Results;
use std::collections::BTreeMap;

const LEFT: f64 = 15.0;
const GAP: f64 = 18.0;
const TOP: f64 = 6.0;
const TALL: f64 = 50.0;
/// Height from one row of panels to the next \[mm\]
const ROW: f64 = TALL + 19.0;
/// Smallest width of a panel \[mm\]
const LEAST: f64 = 60.0;

/// Offset of the first line of text from the top of a panel, and of each further line \[units\].
const FIRST: i32 = 60;
const NEXT: i32 = 85;

/// The cost of one mesh of one formulation, over its variants.
struct MeshCost {
    formulation: usize,
    dofs: f64,
    nnz: f64,
    /// Smallest, mean and largest time \[s\]
    seconds: [f64; 3],
}

/// A measure of size.
type Size = fn(&MeshCost) -> f64;

/// Draws the costs; `None` unless some formulation was run on two meshes.
pub fn draw(store: &Results) -> Option<Figure> {
    let mut formulations: Vec<&str> = vec![];
    // One mesh in several variants has one mark
    let mut meshes: BTreeMap<(usize, usize, usize, &str), Vec<&CaseRecord>> = BTreeMap::new();
    for c in &store.cases {
        let r = &c.record;
        let is_of_steps = store.study.family_of(c, None).is_some_and(|f| f.role == Role::TimeStep);
        if !r.converged() || r.cpu_s <= 0.0 || r.factor_nnz == 0 || is_of_steps {
            continue;
        }
        let k = formulations.iter().position(|f| *f == r.formulation).unwrap_or_else(|| {
            formulations.push(&r.formulation);
            formulations.len() - 1
        });
        meshes.entry((k, r.dofs, r.factor_nnz, &r.family)).or_default().push(r);
    }
    let dots: Vec<MeshCost> = (meshes.into_iter())
        .map(|((formulation, dofs, nnz, _), records)| {
            let s: Vec<f64> = records.iter().map(|r| r.cpu_s).collect();
            let mean = s.iter().sum::<f64>() / s.len() as f64;
            let (lo, hi) = s.iter().fold((f64::INFINITY, 0.0f64), |(a, b), v| (a.min(*v), b.max(*v)));
            MeshCost { formulation, dofs: dofs as f64, nnz: nnz as f64, seconds: [lo, mean, hi] }
        })
        .collect();
    let fits = |k: usize, x: Size| {
        power_law(&dots.iter().filter(|d| d.formulation == k).map(|d| (x(d), d.seconds[1])).collect::<Vec<_>>())
    };
    if !(0..formulations.len()).any(|k| fits(k, |d| d.dofs).is_some()) {
        return None;
    }
    let columns = columns(2, (LEFT + 3.0, GAP, LEAST));
    let each = (page_width() - LEFT - GAP * (columns - 1) as f64 - 3.0) / columns as f64;
    let bottom = TOP + TALL + ROW * (2 / columns - 1) as f64 + 13.5;
    let across = page_width() - LEFT;
    let names = formulations.iter().map(|name| title(name));
    let named: Vec<(String, Look)> = names.zip(looks(&store.study.families, &formulations)).collect();
    let entries: Vec<(Sample, String)> =
        named.iter().map(|(name, (m, c))| (Sample::Mark(*m, *c), name.clone())).collect();
    let svg = figure(page_width(), bottom - 0.7 + 4.2 * legend_lines(&entries, across), "", |area| {
        let size: [(&str, Size); 2] = [("free degrees of freedom", |d| d.dofs), ("entries of the factor", |d| d.nnz)];
        for (k, (name, x)) in size.into_iter().enumerate() {
            let (left, top) = (LEFT + (k % columns) as f64 * (each + GAP), TOP + ROW * (k / columns) as f64);
            let frame = [mm(left), mm(top), mm(left + each), mm(top + TALL)];
            let label = if k == 0 { format!("{name} {}", italic("n")) } else { format!("{name} nnz({})", italic("L")) };
            let symbol = if k == 0 { italic("n") } else { "nnz".into() };
            let lines: Vec<Option<PowerLaw>> = (0..formulations.len()).map(|k| fits(k, x)).collect();
            let head = f64::from(FIRST + NEXT * lines.iter().flatten().count() as i32) / f64::from(mm(TALL));
            let y = Axis::log_below(dots.iter().flat_map(|d| d.seconds), head, "CPU time [s]");
            let plot = Plot { area, frame, x: Axis::log(dots.iter().map(x), &label), y };
            panel(&plot, &dots, x, &lines, &named, &symbol);
            plot.axes(true);
            plot.title(letter(k, 2), if k == 0 { "Unknowns" } else { "Cholesky factor" });
        }
        legend_below(area, (LEFT, bottom), across, entries);
    });
    let caption = "CPU time of a case over its size, per formulation, with the fitted exponent of growth and its 95 % interval (Student's t, with as many degrees of freedom as there are meshes more than two). A mark is the mean over the variants of one mesh, its bar the range.".into();
    Some(Figure { name: "cost-size".into(), svg, caption })
}

fn panel(plot: &Plot, dots: &[MeshCost], x: Size, lines: &[Option<PowerLaw>], named: &[(String, Look)], symbol: &str) {
    plot.grid();
    let area: &Area = plot.area;
    let mut written = 0;
    for (k, law) in lines.iter().enumerate() {
        let Some(g) = law else { continue };
        let (name, (_, color)) = &named[k];
        let own = || dots.iter().filter(|d| d.formulation == k).map(x);
        let (a, b) = (own().fold(f64::INFINITY, f64::min), own().fold(0.0, f64::max));
        let at = |n: f64| plot.at(n, g.at(n));
        line(area, &[at(a), at(b)], *color, 7);
        let words = format!("{name}: exponent of {symbol} {}", with_error(g.q, g.half));
        let [l, t, ..] = plot.frame;
        text(area, &words, (l + 40, t + FIRST + NEXT * written), At::Left, SMALL, *color);
        written += 1;
    }
    for d in dots {
        let (m, c) = named[d.formulation].1;
        let (low, high) = (plot.at(x(d), d.seconds[0]), plot.at(x(d), d.seconds[2]));
        if low.1 - high.1 > 4 {
            line(area, &[low, high], c, 4);
            for end in [low, high] {
                line(area, &[(end.0 - 14, end.1), (end.0 + 14, end.1)], c, 4);
            }
        }
        mark(area, m, plot.at(x(d), d.seconds[1]), 24, c);
    }
}
