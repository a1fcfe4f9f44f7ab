//! Where the time is spent: shares of the phases and of the effects, for each case.

use crate::report::canvas::{
    AREAS, Area, At, INK, REMAINDER, RGB, SMALL, block, figure, mm, page_height, page_width, text,
};
use crate::report::figure::{Drawn, Figure, LINE, Sample, drawn, family_label, legend, numbered};
use crate::report::measure::{shortened, width_in_mm};
use crate::report::numbers::{seconds, thousands};
use crate::report::panels::{Letter, Panels, letter};
use crate::report::plot::{Axis, Plot};
use crate::study::analysis::disturbed;
use crate::study::store::record::{CaseRecord, FamilyRecord, Role};
use crate::study::store::results::Results;
use crate::wording::count;

const PHASES: [&str; 3] = ["assembly", "factorisation", "solve"];
const ROW: f64 = 4.6;
const TOP: f64 = 6.0;

/// Draws the times of the meshes of a variant, on as many sheets as their height requires.
pub fn of_variant(store: &Results, variant: &str, name: &str) -> Vec<Drawn> {
    let of_meshes = |f: &&FamilyRecord| matches!(f.role, Role::Sizes | Role::Nested | Role::Remeshed | Role::Element);
    let families: Vec<&FamilyRecord> = store.study.families.iter().filter(of_meshes).collect();
    let mut rows: Vec<&CaseRecord> = (store.cases.iter())
        .filter(|c| families.iter().any(|f| c.is_in(&f.name, variant)))
        .map(|c| &c.record)
        .filter(|r| r.converged() && r.wall_s > 0.0)
        .collect();
    rows.sort_by(|a, b| (b.formulation.as_str(), a.mesh.cells).cmp(&(a.formulation.as_str(), b.mesh.cells)));
    let mut effects: Vec<&str> = rows.iter().flat_map(|r| r.effects.iter().map(|e| e.name.as_str())).collect();
    effects.sort_unstable();
    effects.dedup();
    let total =
        |name: &str| -> f64 { rows.iter().flat_map(|r| &r.effects).filter(|e| e.name == name).map(|e| e.wall_s).sum() };
    effects.sort_by(|a, b| total(b).total_cmp(&total(a)));
    let longest = rows.iter().map(|r| width_in_mm(&name_of(r), SMALL)).fold(0.0, f64::max);
    // A name takes at most half of the page
    let room = (longest + 5.0).clamp(41.0, (0.5 * page_width()).min(page_width() - 60.0).max(41.0));
    let panels = Panels::new(2, (room, 16.0, 14.0), (44.0, 70.0));
    let legends = legends(&effects);
    let below = 13.5 + LINE * legends[0].len().max(legends[1].len()).div_ceil(2) as f64;
    let most = ((page_height() / panels.rows() - TOP - below) / ROW).floor().max(1.0) as usize;
    let sheets = rows.len().div_ceil(most);
    let shared = if rows.iter().any(|r| r.shared) { " Cases ran at the same time." } else { "" };
    let busy = waiting(&rows);
    let of = |(k, rows): (usize, &[&CaseRecord])| {
        drawn(name, || {
            let (name, part) = numbered(name, k, sheets);
            let caption = format!(
                "Share of the wall time per case ({}){part}, total next to the bar: (a) by phase, (b) by effect, the rest being linear algebra. Output is not part of it.{shared}{busy}",
                store.study.label(variant)
            );
            Figure { name, svg: sheet(rows, &effects, &legends, &panels, (room, below)), caption }
        })
    };
    // Sheets of the same length
    rows.chunks(rows.len().div_ceil(sheets.max(1)).max(1)).enumerate().filter_map(of).collect()
}

/// Names and colours of the phases and of the effects; effects beyond the colours share one.
fn legends(effects: &[&str]) -> [Vec<(String, RGB)>; 2] {
    let coloured = |names: &[&str]| names.iter().map(ToString::to_string).zip(AREAS).collect::<Vec<_>>();
    let [mut of_phases, mut of_effects] = [coloured(&PHASES), coloured(effects)];
    of_phases.push(("rest".into(), REMAINDER));
    let others = effects.len() - of_effects.len();
    if others > 0 {
        of_effects.push((count(others, "other effect"), REMAINDER));
    }
    [of_phases, of_effects]
}

/// A sentence that the machine was busy, if cases waited for other programs; otherwise empty.
fn waiting(rows: &[&CaseRecord]) -> String {
    let most = disturbed(rows.iter().copied()).into_iter().reduce(f64::max);
    most.map_or_else(String::new, |most| {
        format!(" The machine was busy: wall time is up to {most:.1} times the CPU time, and shares hold waiting too.")
    })
}

/// Draws the panels of the cases, with room for their names at the left and for the legends below \[mm\].
fn sheet(
    rows: &[&CaseRecord],
    effects: &[&str],
    legends: &[Vec<(String, RGB)>; 2],
    panels: &Panels,
    (room, below): (f64, f64),
) -> String {
    let tall = ROW * rows.len() as f64;
    let step = TOP + tall + below;
    figure(panels.width(), step * panels.rows(), "", |area| {
        let phase = |r: &CaseRecord| {
            let p = &r.phases;
            let parts = [p.assembly_s, p.factorisation_s, p.solve_s];
            let mut out: Vec<(f64, RGB)> = parts.into_iter().zip(AREAS).collect();
            out.push(((r.wall_s - parts.iter().sum::<f64>()).max(0.0), REMAINDER));
            out
        };
        let effect = |r: &CaseRecord| {
            let of = |name: &&str| r.effects.iter().filter(|e| e.name == **name).map(|e| e.wall_s).sum::<f64>();
            let (named, others) = effects.split_at(effects.len().min(AREAS.len()));
            let mut out: Vec<(f64, RGB)> = named.iter().map(of).zip(AREAS).collect();
            out.push((others.iter().map(of).sum(), REMAINDER));
            out
        };
        let place = |k: usize| panels.frame(k, (TOP, step), tall);
        bars(area, place(0).map(mm), letter(0, 2), "Phases", rows, &phase);
        bars(area, place(1).map(mm), letter(1, 2), "Evaluation of the effects", rows, &effect);
        for [left, top, right, _] in [0, 1].into_iter().filter(|k| panels.begins_row(*k)).map(place) {
            names(area, (left, top, right), room, rows);
        }
        for (number, entries) in legends.iter().enumerate() {
            let [x, .., bottom] = place(number);
            for (k, (name, color)) in entries.iter().enumerate() {
                // Measured from the left edge of the page, so that the second name fits into a narrow panel
                let left = x - if panels.begins_row(number) { 10.0 } else { 0.0 };
                let at = (mm(left + 28.0 * (k % 2) as f64), mm(bottom + 13.5 + LINE * (k / 2) as f64));
                let words = shortened(&name.replace('_', " "), SMALL, mm(20.5));
                legend(area, at, &[(Sample::Block(*color), words)]);
            }
        }
    })
}

/// Family, element and cells of a case.
fn name_of(r: &CaseRecord) -> String {
    format!("{} {}", family_label(&r.family, &r.formulation), thousands(r.mesh.cells))
}

/// Writes the name of each case at the left of its bar, and its time at the right.
fn names(area: &Area, (left, top, right): (f64, f64, f64), room: f64, rows: &[&CaseRecord]) {
    for (k, r) in rows.iter().enumerate() {
        let y = mm(top + ROW * (k as f64 + 0.5));
        let words = shortened(&name_of(r), SMALL, mm(room - 3.0));
        text(area, &words, (mm(left - 2.0), y), At::Right, SMALL, INK);
        text(area, &seconds(r.wall_s), (mm(right + 1.2), y), At::Left, SMALL, INK);
    }
}

fn bars(
    area: &Area,
    frame: [i32; 4],
    letter: Option<Letter>,
    title: &str,
    rows: &[&CaseRecord],
    parts: &dyn Fn(&CaseRecord) -> Vec<(f64, RGB)>,
) {
    // Effects are a small part of the whole: their axis ends at the largest share
    let share = |r: &CaseRecord| parts(r).iter().map(|p| p.0).sum::<f64>() / r.wall_s;
    let most = rows.iter().map(|r| 100.0 * share(r)).fold(0.0, f64::max);
    let label = "share of the wall time [%]";
    // Clocks that are read one after the other may add up to slightly more than the whole
    let is_whole = (80.0..=100.5).contains(&most);
    let x =
        if is_whole { Axis::exact(0.0, most.max(100.0), label) } else { Axis::linear([0.0, most].into_iter(), label) };
    let plot = Plot { area, frame, x, y: Axis::exact(rows.len() as f64, 0.0, "") };
    plot.grid_x();
    for (k, r) in rows.iter().enumerate() {
        let mut from = 0.0;
        for (s, color) in parts(r) {
            let to = from + 100.0 * s / r.wall_s;
            let (a, b) = (plot.at(from, k as f64 + 0.17), plot.at(to, k as f64 + 0.83));
            block(area, a, b, color);
            from = to;
        }
    }
    plot.axis_x();
    plot.title(letter, title);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// There is a limited number of colours for effects; all others form one part, so that the rest of a bar is not an effect.
    #[test]
    fn effects_beyond_the_colours_share_one() {
        let names: Vec<String> = (0..AREAS.len() + 2).map(|k| format!("effect {k}")).collect();
        let of = |count: usize| {
            let [_, entries] = legends(&names[..count].iter().map(String::as_str).collect::<Vec<_>>());
            entries
        };
        assert!(of(AREAS.len()).iter().all(|(_, color)| *color != REMAINDER));
        assert_eq!(of(AREAS.len() + 2).last(), Some(&("2 other effects".to_string(), REMAINDER)));
    }

    #[test]
    fn cases_that_waited_are_told() {
        let of = |wall_s: f64| CaseRecord { wall_s, cpu_s: 2.0, ..CaseRecord::default() };
        let (quiet, busy) = (of(2.0), of(6.2));
        assert_eq!(waiting(&[&quiet]), "");
        assert!(waiting(&[&quiet, &busy]).contains("wall time is up to 3.1 times the CPU time"));
    }
}
