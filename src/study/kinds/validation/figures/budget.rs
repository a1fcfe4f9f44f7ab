//! Error budgets: one panel per prediction, one bar per group, largest first.

use crate::report::canvas::{At, INK, LABEL, PALETTE, RGB, SMALL, block, figure, italic, line, mm, page_width, text};
use crate::report::figure::Figure;
use crate::report::measure::width;
use crate::report::numbers::{capital, digits, space};
use crate::report::panels::{heading, letter};
use crate::report::unit;
use crate::study::analysis::Analysis;
use crate::study::figures::{PANELS, first_of};
use crate::study::kinds::validation::budget::{COVERAGE, half_width};
use crate::study::kinds::validation::findings::{Prediction, ValidationFindings};

/// Predictions and groups that are drawn.
const BARS: usize = 9;
const WIDE: f64 = 62.0;
const ROW: f64 = 5.0;
const HEAD: f64 = 9.0;
const GAP: f64 = 6.0;
const RIGHT: f64 = 22.0;
const TOTAL: RGB = RGB(0x55, 0x55, 0x55);

/// `None` without a prediction.
pub fn draw(a: &Analysis<ValidationFindings>) -> Option<Figure> {
    let shown: Vec<&Prediction> = a.predictions.iter().filter(|p| !p.budget.is_empty()).take(PANELS).collect();
    let rows = |p: &Prediction| 1 + p.budget.len().min(BARS);
    let names = shown.iter().flat_map(|p| p.budget.iter().take(BARS)).map(|c| width(&c.group, SMALL));
    let left = f64::from(names.max().unwrap_or(0)) / f64::from(mm(1.0)) + 6.0;
    let wide = WIDE.min(page_width() - left - RIGHT).max(20.0);
    let height = shown.iter().map(|p| HEAD + ROW * rows(p) as f64 + GAP).sum::<f64>();
    let svg = figure(left + wide + RIGHT, height, "", |area| {
        let mut top = 0.0;
        for (k, p) in shown.iter().enumerate() {
            let total = half_width(&p.budget);
            let title = format!("{} {}, {}", capital(&p.label), italic(&p.symbol), p.record_label);
            let title = heading(letter(k, shown.len()), &title);
            text(area, &title, (mm(1.0), mm(top + 4.0)), At::Left, LABEL, INK);
            let (power, unit) = unit::shown(&p.unit, total);
            let factor = 10f64.powi(power);
            let n = digits(0.1 * factor * total);
            let bars = std::iter::once(("all together", total, TOTAL))
                .chain(p.budget.iter().take(BARS).map(|c| (c.group.as_str(), COVERAGE * c.deviation, PALETTE[0])));
            for (j, (name, half, color)) in bars.enumerate() {
                let y = top + HEAD + ROW * (j as f64 + 0.5);
                let long = wide * half / total;
                text(area, name, (mm(left - 1.5), mm(y)), At::Right, SMALL, INK);
                block(area, (mm(left), mm(y - 1.6)), (mm(left + long), mm(y + 1.6)), color);
                let (least, shown) = (0.5 * 10f64.powi(-(n as i32)), factor * half);
                let number = match shown < least {
                    true => format!("< {least:.*}{}", n + 1, space(unit)),
                    false => format!("± {shown:.n$}{}", space(unit)),
                };
                text(area, &number, (mm(left + long + 1.2), mm(y)), At::Left, SMALL, INK);
            }
            let bottom = top + HEAD + ROW * rows(p) as f64;
            line(area, &[(mm(left), mm(top + HEAD)), (mm(left), mm(bottom))], INK, 4);
            top = bottom + GAP;
        }
    });
    let more = first_of(a.predictions.len());
    let caption = format!(
        "Half-width of the 95 % interval of each prediction that every group of errors alone would give, largest first; groups add as squares.{more}"
    );
    (!shown.is_empty()).then(|| Figure { name: "budget".into(), svg, caption })
}
