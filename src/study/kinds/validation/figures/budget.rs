//! Error budgets: one panel per prediction, one bar per group, largest first, on as many sheets as the height requires.

use crate::report::canvas::{
    Area, At, INK, PALETTE, RGB, SMALL, block, figure, italic, line, mm, page_height, page_width, text,
};
use crate::report::figure::{Drawn, Figure, drawn, numbered};
use crate::report::measure::{shortened, width_in_mm};
use crate::report::names::with_symbol;
use crate::report::numbers::{capital, digits, space};
use crate::report::panels::{Panels, headed, letter};
use crate::report::unit;
use crate::study::analysis::Analysis;
use crate::study::figures::{PANELS, first_of};
use crate::study::kinds::validation::budget::{COVERAGE, half_width};
use crate::study::kinds::validation::findings::{Prediction, ValidationFindings};

/// Largest number of bars of a prediction; if there are more groups, the last ones share a bar.
const BARS: usize = 9;
/// Smallest and largest width of the bars, and width of the numbers to their right \[mm\]
const LEAST: f64 = 20.0;
const WIDE: f64 = 62.0;
const RIGHT: f64 = 22.0;
const ROW: f64 = 5.0;
const HEAD: f64 = 9.0;
const GAP: f64 = 6.0;
/// Name of the bar for all groups together
const ALL: &str = "all together";
const TOTAL: RGB = RGB(0x55, 0x55, 0x55);

/// Name, half-width and colour of each bar: all groups together, the largest ones, and the rest in one bar if there are too many.
fn bars(p: &Prediction) -> Vec<(String, f64, RGB)> {
    let own = if p.budget.len() > BARS { BARS - 1 } else { p.budget.len() };
    let (largest, others) = p.budget.split_at(own);
    let mut bars = vec![(ALL.to_string(), half_width(&p.budget), TOTAL)];
    bars.extend(largest.iter().map(|c| (c.group.clone(), COVERAGE * c.deviation, PALETTE[0])));
    if !others.is_empty() {
        bars.push((format!("{} other groups", others.len()), half_width(others), PALETTE[0]));
    }
    bars
}

/// The height of a row of panels \[mm\].
fn height(row: &[&Prediction]) -> f64 {
    let bars = row.iter().map(|p| bars(p).len()).max().unwrap_or(0);
    HEAD + ROW * bars as f64 + GAP
}

/// Draws panels side by side if the page has room for two, with no sheet taller than a page; nothing without a prediction.
pub fn draw(a: &Analysis<ValidationFindings>) -> Vec<Drawn> {
    let mut shown: Vec<&Prediction> = a.predictions.iter().filter(|p| !p.budget.is_empty()).collect();
    let more = first_of(shown.len(), PANELS, "predictions");
    shown.truncate(PANELS);
    let names = shown.iter().flat_map(|p| bars(p)).map(|(name, ..)| width_in_mm(&name, SMALL));
    let left = (names.fold(0.0, f64::max) + 6.0).min(page_width() - RIGHT - LEAST);
    let places = |count: usize| Panels::new(count, (left, left + RIGHT, RIGHT), (LEAST, WIDE));
    let columns = places(shown.len()).columns;
    let mut sheets: Vec<Vec<&Prediction>> = vec![];
    let mut tall = f64::INFINITY;
    for row in shown.chunks(columns) {
        if tall + height(row) > page_height() {
            sheets.push(vec![]);
            tall = 0.0;
        }
        tall += height(row);
        sheets.last_mut().expect("a sheet").extend(row);
    }
    let of = |(k, predictions): (usize, &Vec<&Prediction>)| {
        drawn("budget", || {
            let (name, part) = numbered("budget", k, sheets.len());
            let caption = format!(
                "Half-width of the 95 % interval of each prediction that every group of errors alone would give{part}, largest first; groups add as squares.{more}"
            );
            Figure { name, svg: sheet(predictions, &places(predictions.len().max(columns)), left), caption }
        })
    };
    sheets.iter().enumerate().filter_map(of).collect()
}

fn sheet(predictions: &[&Prediction], places: &Panels, left: f64) -> String {
    let rows: Vec<f64> = predictions.chunks(places.columns).map(height).collect();
    figure(places.width(), rows.iter().sum(), "", |area| {
        for (k, p) in predictions.iter().enumerate() {
            let top = rows[..k / places.columns].iter().sum::<f64>();
            let words =
                format!("{}, {}", capital(&with_symbol(&p.label, &p.symbol, &italic(&p.symbol))), p.record_label);
            let from = places.x(k) - left + 1.0;
            let wide = left + places.each + RIGHT - 4.0;
            headed(area, (mm(from), mm(top + HEAD - 1.0)), mm(wide), letter(k, predictions.len()), &words);
            panel(area, p, (places.x(k), top + HEAD), places.each, left);
        }
    })
}

/// Draws the bars of a prediction with their names and numbers.
fn panel(area: &Area, p: &Prediction, (x, top): (f64, f64), wide: f64, left: f64) {
    let total = half_width(&p.budget);
    let (power, unit) = unit::with_power(&p.unit, total, total);
    let unit = if unit.starts_with("10") { format!("· {unit}") } else { unit };
    let factor = 10f64.powi(power);
    let n = digits(0.1 * factor * total);
    let mut bottom = top;
    for (j, (name, half, color)) in bars(p).into_iter().enumerate() {
        let y = top + ROW * (j as f64 + 0.5);
        let long = wide * half / total;
        text(area, &shortened(&name, SMALL, mm(left - 3.0)), (mm(x - 1.5), mm(y)), At::Right, SMALL, INK);
        block(area, (mm(x), mm(y - 1.6)), (mm(x + long), mm(y + 1.6)), color);
        let (least, shown) = (0.5 * 10f64.powi(-(n as i32)), factor * half);
        let number = match shown < least {
            true => format!("< {least:.*}{}", n + 1, space(&unit)),
            false => format!("± {shown:.n$}{}", space(&unit)),
        };
        text(area, &number, (mm(x + long + 1.2), mm(y)), At::Left, SMALL, INK);
        bottom = top + ROW * (j as f64 + 1.0);
    }
    line(area, &[(mm(x), mm(top)), (mm(x), mm(bottom))], INK, 4);
}
