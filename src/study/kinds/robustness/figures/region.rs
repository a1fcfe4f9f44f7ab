//! Where a scene can be solved: a map of grades over two axes, one panel for each variant.

use crate::report::canvas::{Area, At, GREY, INK, PALETTE, RGB, SMALL, block, figure, italic, mm, text};
use crate::report::figure::{Figure, LINE, Sample, legend_below, legend_lines};
use crate::report::measure::wrapped;
use crate::report::panels::{Panels, headed, letter};
use crate::study::axis::AxisRecord;
use crate::study::figures::grid::{MapNumbers, sides};
use crate::study::kinds::robustness::map::{Grade, Map, Panel};
use std::collections::BTreeSet;

const LEFT: f64 = 22.0;
const GAP: f64 = 8.0;
const TOP: f64 = 7.0;
const TALL: f64 = 44.0;
/// Distance between two rows of panels \[mm\]
const BETWEEN: f64 = 20.0;

fn look(grade: Grade) -> (RGB, &'static str) {
    match grade {
        Grade::Right => (PALETTE[0], "right"),
        Grade::Reference => (RGB(0x9c, 0xc9, 0xe6), "reference"),
        Grade::Unjudged => (RGB(0xf0, 0xe4, 0x42), "no reference"),
        Grade::Poor => (PALETTE[5], "poor (within 10 %)"),
        Grade::Wrong => (PALETTE[1], "silently wrong"),
        Grade::Stated => (RGB(0xc8, 0xc8, 0xc8), "stopped, with a status"),
        Grade::Broken => (RGB(0, 0, 0), "not finite"),
    }
}

pub fn draw(map: &Map) -> Figure {
    let panels = Panels::new(map.panels.len(), (LEFT, GAP, 3.0), (44.0, 64.0));
    let grades =
        [Grade::Right, Grade::Reference, Grade::Unjudged, Grade::Poor, Grade::Wrong, Grade::Stated, Grade::Broken];
    let used = |g: &Grade| map.panels.iter().flat_map(|p| &p.points).any(|p| p.grade == *g);
    let entries: Vec<_> =
        grades.into_iter().filter(used).map(|g| (Sample::Block(look(g).0), look(g).1.to_string())).collect();
    let across = panels.width() - LEFT;
    let lines = legend_lines(&entries, across);
    let key = |numbers: &MapNumbers| key(map, numbers, mm(across));
    let legend = |words: &[String]| LINE * (lines + words.len() as f64);
    let usual = key(&numbers(map, (panels.each, TALL)));
    let tall = panels.tall(TALL, (BETWEEN, TOP + 16.0 + legend(&usual)));
    let row = tall + BETWEEN;
    // Numbers of the panels below may have another unit, or no room
    let numbers = numbers(map, (panels.each, tall));
    let words = key(&numbers);
    let bottom = TOP + row * panels.rows() - 4.0;
    let svg = figure(panels.width(), bottom + legend(&words), "", |area| {
        for (k, panel) in map.panels.iter().enumerate() {
            let frame = panels.frame(k, (TOP, row), tall);
            let [left, top, ..] = frame.map(mm);
            squares(area, map, (panel, &numbers), frame, panels.begins_row(k));
            headed(area, (left, top), mm(panels.each), letter(k, map.panels.len()), &panel.label);
        }
        legend_below(area, (LEFT, bottom), across, entries);
        for (k, words) in words.iter().enumerate() {
            text(area, words, (mm(LEFT), mm(bottom + LINE * (lines + k as f64))), At::Left, SMALL, INK);
        }
    });
    let meaning = match numbers.have_room() {
        true => format!("Numbers are the {} {}; a", map.peak_is, map.quantity.label),
        false => "A".into(),
    };
    let caption = format!(
        "{} {meaning} right answer is within the tolerance of the study of the reference in its row.",
        map.setup
    );
    Figure { name: format!("map-{}", map.family), svg, caption }
}

/// The numbers of all panels, each `wide` by `tall` \[mm\], in one unit.
fn numbers(map: &Map, (wide, tall): (f64, f64)) -> MapNumbers {
    let [columns, rows] = [0, 1].map(|k| map.axes[k].values.len() as f64);
    let peaks = map.panels.iter().flat_map(|p| &p.points).filter_map(|p| p.peak);
    MapNumbers::of(peaks, &map.quantity.unit, (mm(wide / columns), mm(tall / rows)))
}

/// The meaning of the numbers in the squares, with their unit, and of the abbreviations, in lines at most `room` wide \[units\].
fn key(map: &Map, numbers: &MapNumbers, room: i32) -> Vec<String> {
    let symbol = italic(&map.quantity.symbol);
    let meaning = format!("number: {} {} {symbol}{}", map.peak_is, map.quantity.label, numbers.brackets());
    let mut words = if numbers.have_room() { wrapped(&meaning, SMALL, room, 2) } else { vec![] };
    let without = map.panels.iter().flat_map(|p| &p.points).filter(|p| !p.peak.is_some_and(f64::is_finite));
    let statuses: BTreeSet<&str> = without.map(|p| p.status.as_str()).collect();
    words.extend(statuses.into_iter().map(|s| format!("{}: {s}", abbreviated(s))));
    words
}

fn squares(
    area: &Area,
    map: &Map,
    (panel, numbers): (&Panel, &MapNumbers),
    [left, top, right, bottom]: [f64; 4],
    names: bool,
) {
    let (first, second): (&AxisRecord, &AxisRecord) = (&map.axes[0], &map.axes[1]);
    let (w, h) = ((right - left) / first.values.len() as f64, (bottom - top) / second.values.len() as f64);
    for p in &panel.points {
        let (x, y) = (left + w * p.at[0] as f64, bottom - h * (p.at[1] + 1) as f64);
        let (color, _) = look(p.grade);
        block(area, (mm(x) + 3, mm(y) + 3), (mm(x + w) - 3, mm(y + h) - 3), color);
        let dark = matches!(p.grade, Grade::Right | Grade::Wrong | Grade::Broken);
        let ink = if dark { RGB(0xff, 0xff, 0xff) } else { INK };
        let words = match p.peak.filter(|peak| peak.is_finite()) {
            Some(peak) => numbers.written(peak).unwrap_or_default(),
            None => abbreviated(&p.status),
        };
        text(area, &words, (mm(x + 0.5 * w), mm(y + 0.5 * h)), At::Middle, SMALL, ink);
    }
    sides(area, (first, second), [left, top, right, bottom].map(mm), (names, mm(LEFT)));
    if !names {
        crate::report::canvas::line(area, &[(mm(left), mm(top)), (mm(left), mm(bottom))], GREY, 3);
    }
}

/// Abbreviates a status to its capitals: `SS` for `StepTooSmall`.
fn abbreviated(status: &str) -> String {
    status.chars().filter(|c| c.is_uppercase()).collect()
}
