//! Where the time goes: shares of the phases and of the effects, per case.

use crate::report::canvas::{Area, At, INK, PALETTE, RGB, SMALL, block, figure, mm, text, wide_page};
use crate::report::figure::{Figure, Sample, legend};
use crate::report::numbers::digits;
use crate::report::numbers::thousands;
use crate::report::plot::{Axis, Plot};
use crate::study::store::record::{CaseRecord, Role};
use crate::study::store::results::Results;

const REST: RGB = RGB(0xd0, 0xd0, 0xd0);
const ROW: f64 = 4.6;

/// Of the meshes of a variant.
pub fn of_variant(store: &Results, variant: &str, name: String) -> Option<Figure> {
    let role = |r: &CaseRecord| store.study.families.iter().find(|f| f.name == r.family).map(|f| f.role);
    let mut rows: Vec<&CaseRecord> = (store.cases.iter().map(|c| &c.record))
        .filter(|r| r.variant == variant && r.converged() && r.wall_s > 0.0)
        .filter(|r| matches!(role(r), Some(Role::Sizes | Role::Nested | Role::Remeshed | Role::Element)))
        .collect();
    rows.sort_by(|a, b| (b.formulation.as_str(), a.mesh.cells).cmp(&(a.formulation.as_str(), b.mesh.cells)));
    if rows.is_empty() {
        return None;
    }
    let mut effects: Vec<&str> = rows.iter().flat_map(|r| r.effects.iter().map(|e| e.name.as_str())).collect();
    effects.sort_unstable();
    effects.dedup();
    let total =
        |name: &str| -> f64 { rows.iter().flat_map(|r| &r.effects).filter(|e| e.name == name).map(|e| e.wall_s).sum() };
    effects.sort_by(|a, b| total(b).total_cmp(&total(a)));
    effects.truncate(PALETTE.len());
    let phases = ["assembly", "factorisation", "solve", "output", "rest"];
    let (left, each, gap, top) = (41.0, 61.0, 14.0, 6.0);
    let tall = ROW * rows.len() as f64;
    let lines = phases.len().max(effects.len());
    let height = top + tall + 12.5 + 4.2 * lines.div_ceil(3) as f64;
    let svg = figure(wide_page(), height, "", |area| {
        let phase = |r: &CaseRecord| {
            let p = &r.phases;
            let parts = [p.assembly_s, p.factorisation_s, p.solve_s, p.output_s];
            let mut out: Vec<(f64, RGB)> = parts.into_iter().zip(PALETTE).collect();
            out.push(((r.wall_s - parts.iter().sum::<f64>()).max(0.0), REST));
            out
        };
        let effect = |r: &CaseRecord| {
            let of = |name: &&str| r.effects.iter().filter(|e| e.name == **name).map(|e| e.wall_s).sum::<f64>();
            effects.iter().map(of).zip(PALETTE).collect()
        };
        let frame = |x: f64| [mm(x), mm(top), mm(x + each), mm(top + tall)];
        bars(area, frame(left), 'a', "Phases", &rows, &phase);
        bars(area, frame(left + each + gap), 'b', "Evaluation of the effects", &rows, &effect);
        for (k, r) in rows.iter().enumerate() {
            let y = mm(top + ROW * (k as f64 + 0.5));
            let words = format!(
                "{} {}",
                crate::report::figure::family_label(&r.family, &r.formulation),
                thousands(r.mesh.cells)
            );
            text(area, &words, (mm(left - 2.0), y), At::Right, SMALL, INK);
            text(
                area,
                &format!("{:.*} s", digits(r.wall_s), r.wall_s),
                (mm(left + each + 1.2), y),
                At::Left,
                SMALL,
                INK,
            );
        }
        let put = |x: f64, wide: f64, names: &[&str]| {
            for (k, name) in names.iter().enumerate() {
                let color = if *name == "rest" { REST } else { PALETTE[k] };
                let at = (mm(x + wide * (k % 3) as f64), mm(top + tall + 13.5 + 4.2 * (k / 3) as f64));
                legend(area, at, &[(Sample::Block(color), name.to_string())]);
            }
        };
        put(left - 8.0, 27.0, &phases);
        put(left + each + gap, 22.0, &effects);
    });
    let shared = if rows.iter().any(|r| r.shared) { " Cases ran at the same time." } else { "" };
    let caption = format!(
        "Share of the wall time per case ({}), total next to the bar: (a) by phase, (b) by effect, the rest being linear algebra and output.{shared}",
        store.study.label(variant)
    );
    Some(Figure { name, svg, caption })
}

fn bars(
    area: &Area,
    frame: [i32; 4],
    letter: char,
    title: &str,
    rows: &[&CaseRecord],
    parts: &dyn Fn(&CaseRecord) -> Vec<(f64, RGB)>,
) {
    // Effects are a small part of the whole: their axis ends at their largest share
    let share = |r: &CaseRecord| parts(r).iter().map(|p| p.0).sum::<f64>() / r.wall_s;
    let most = rows.iter().map(|r| 100.0 * share(r)).fold(0.0, f64::max);
    let x = if most > 80.0 { Axis::exact(0.0, 100.0, "") } else { Axis::linear([0.0, most].into_iter(), "") };
    let x = Axis { label: "share of the wall time [%]".into(), ..x };
    let plot = Plot { area, frame, x, y: Axis::exact(rows.len() as f64, 0.0, "") };
    plot.grid_x();
    for (k, r) in rows.iter().enumerate() {
        let mut from = 0.0;
        for (s, color) in parts(r) {
            let to = (from + 100.0 * s / r.wall_s).min(plot.x.hi);
            let (a, b) = (plot.at(from, k as f64 + 0.17), plot.at(to, k as f64 + 0.83));
            block(area, a, b, color);
            from = to;
        }
    }
    plot.axis_x();
    plot.title(letter, title);
}
