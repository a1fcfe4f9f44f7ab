//! Tables of a fit.

use crate::calibrate::{Band, Contribution, Misfit, PredictionKind, Printed, stretch_text, within};
use crate::report::fit::stored::{Scatter, Specimen, StoredConstant, StoredFit};
use crate::report::table::{Table, headings};

/// Largest number of rows of the table of ranges
const RANGES: usize = 14;

pub fn all(fit: &StoredFit) -> Vec<Table> {
    let mut out = vec![parameters(fit)];
    if !fit.measurement.is_empty() {
        out.push(measurement(fit));
    }
    if !fit.otherwise.is_empty() {
        out.push(otherwise(fit));
    }
    out.extend(fit.scatter.as_ref().map(|s| specimens(fit, s)));
    out.extend(fit.scatter.as_ref().and_then(next));
    out.push(misfits(fit));
    if !fit.stability.is_empty() {
        out.push(stability(fit));
    }
    if fit.range_dependence.len() > 1 {
        out.push(ranges(fit));
    }
    out
}

fn parameters(fit: &StoredFit) -> Table {
    let printed = fit.printed();
    let mut rows: Vec<Vec<String>> = (fit.parameters.iter().enumerate())
        .map(|(k, p)| {
            let number = |v: f64| printed[k].number(v);
            let known = |v: Option<f64>| v.map_or("not determined".into(), number);
            let [low, high] = fit.range_spread.get(k).copied().unwrap_or([p.value; 2]);
            let end = |v: f64| printed[k].end(v);
            let wide = fit.in_use.get(k).copied().unwrap_or_default().map(|v| v.map_or("open".into(), end));
            let end = |v: Option<f64>| if p.std_error.is_some() { v.map_or("open".into(), end) } else { known(v) };
            vec![
                p.symbol.clone(),
                p.name.clone(),
                printed[k].unit.into(),
                number(p.value),
                known(p.std_error),
                end(p.interval[0]),
                end(p.interval[1]),
                wide.join(" to "),
                if low < high { format!("{} to {}", number(low), number(high)) } else { "–".into() },
            ]
        })
        .collect();
    for (name, value) in fit.partner.iter().flatten() {
        let (symbol, unit) = if name == "nu" { ("ν", "–") } else { ("κ", "Pa") };
        // The last digits of a Poisson's ratio near ½ are significant
        let (unit, number) = match within(*value, unit, None) {
            Printed { unit: "–", .. } => ("–", value.to_string()),
            printed => (printed.unit, printed.number(*value)),
        };
        let dash = || String::from("–");
        let given = "given, not fitted".to_string();
        rows.push(vec![symbol.into(), name.clone(), unit.into(), number, dash(), dash(), dash(), dash(), given]);
    }
    Table {
        name: "parameters",
        caption: format!(
            "Constants of {}. The interval is {}. The interval for use over the fitted range has the misfit of the law in it. The last column is what fitted ranges that end earlier give, where the errors do not explain the difference (5 % over all ranges and constants).",
            fit.label, fit.interval_assumption
        ),
        columns: headings(&[
            ("Symbol", "", false),
            ("Name", "", false),
            ("Unit", "", false),
            ("Value", "", true),
            ("Std error", "", true),
            ("95 % from", "", true),
            ("95 % to", "", true),
            ("95 % in use", "", true),
            ("Over shorter ranges", "", true),
        ]),
        rows,
        pick: None,
    }
}

/// Lists constants as `μ₁ = 12 kPa, α₁ = 3.1`.
fn list(parameters: &[StoredConstant], printed: &[Printed]) -> String {
    let one = |(p, printed): (&StoredConstant, &Printed)| format!("{} = {}", p.symbol, printed.text(p.value));
    parameters.iter().zip(printed).map(one).collect::<Vec<_>>().join(", ")
}

/// A table of the parts of the shared errors of the measurement.
fn measurement(fit: &StoredFit) -> Table {
    let printed = fit.printed();
    let row = |c: &Contribution| {
        let moves = printed.iter().zip(&c.moves).map(|(p, by)| p.width(*by));
        let stated = [c.error.to_string(), format!("{:.3e}", c.half_width), c.error.unit().into()];
        stated.into_iter().chain(moves).collect()
    };
    let constants: Vec<String> = fit.parameters.iter().map(|p| format!("± {}", p.symbol)).collect();
    let head = [("Error", "", false), ("Half-width", "", true), ("Unit", "", false)];
    let constants = constants.iter().map(|name| (name.as_str(), "", true));
    Table {
        name: "measurement",
        caption: "Errors of the measurement that all data points share, stated or by the scatter of a correction, as half-widths of 95 % intervals, and what each adds in quadrature to the half-widths of the constants.".into(),
        columns: headings(&head.into_iter().chain(constants).collect::<Vec<_>>()),
        rows: fit.measurement.iter().map(row).collect(),
        pick: None,
    }
}

/// A table of the range in which the stress of another specimen is expected.
fn next(s: &Scatter) -> Option<Table> {
    let row = |b: &Band| {
        let [low, high] = b.interval.map(|v| format!("{:.4}", 1e-3 * v));
        vec![b.mode.words(), stretch_text(b.stretch), format!("{:.4}", 1e-3 * b.mean), low, high]
    };
    (!s.next.is_empty()).then(|| Table {
        name: "next-specimen",
        caption:
            "Stress of the next specimen: mean of the measured curves, smoothed along the stretch, and the 95 % prediction interval of one more."
                .into(),
        columns: headings(&[
            ("Mode", "", false),
            ("Stretch", "", true),
            ("Mean", "kPa", true),
            ("95 % from", "kPa", true),
            ("95 % to", "kPa", true),
        ]),
        rows: s.next.iter().map(row).collect(),
        pick: None,
    })
}

/// A table of the effect of the treatment of the data on the fitted constants.
fn otherwise(fit: &StoredFit) -> Table {
    let printed = fit.printed();
    let constants = |parameters: &[StoredConstant]| list(parameters, &printed);
    let mut rows = vec![vec!["as fitted".into(), fit.rows.to_string(), constants(&fit.parameters), "–".into()]];
    rows.extend(fit.otherwise.iter().map(|o| {
        let change = format!("{:.1}", 100.0 * o.change);
        vec![o.treatment.words().into(), o.rows.to_string(), constants(&o.parameters), change]
    }));
    Table {
        name: "treatments",
        caption: "Effect of the choice and treatment of the data points on the answer: the constants with and without it, and the distance between the stresses of the two laws over the fitted data points.".into(),
        columns: headings(&[("Data points", "", false), ("Number", "", true), ("Constants", "", true), ("Difference of stresses", "%", true)]),
        rows,
        pick: Some("as fitted".into()),
    }
}

/// A table of each specimen alone, followed by their mean.
fn specimens(fit: &StoredFit, s: &Scatter) -> Table {
    let constants = |value: &dyn Fn(usize) -> String| {
        let one = |(k, p): (usize, &StoredConstant)| format!("{} = {}", p.symbol, value(k));
        fit.parameters.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
    };
    let printed = fit.printed();
    let row = |one: &Specimen| {
        let level = one.level.map_or("–".into(), |level| format!("{level:.3}"));
        vec![one.file.clone(), one.rows.to_string(), level, list(&one.parameters, &printed)]
    };
    let mut rows: Vec<Vec<String>> = s.specimens.iter().map(row).collect();
    let dash = || String::from("–");
    let summary = |name: &str, value: &dyn Fn(usize) -> String| vec![name.into(), dash(), dash(), constants(value)];
    rows.push(summary("mean", &|k| printed[k].text(s.means[k])));
    rows.push(summary("standard deviation", &|k| printed[k].width(s.deviations[k])));
    Table {
        name: "specimens",
        caption: "Each specimen fitted alone. The level is its stresses over those of the fit to all data points, at the stretches that all specimens have."
            .into(),
        columns: headings(&[
            ("Specimen", "", false),
            ("Data points", "", true),
            ("Level", "", true),
            ("Constants", "", true),
        ]),
        rows,
        pick: None,
    }
}

fn misfits(fit: &StoredFit) -> Table {
    let row = |what: &str, mode: String, [a, b]: [f64; 2], m: &Misfit| {
        vec![
            mode,
            what.into(),
            m.rows.to_string(),
            format!("{} to {}", stretch_text(a), stretch_text(b)),
            format!("{:.1}", 100.0 * m.rms_relative),
            format!("{:+.1}", 100.0 * m.bias_relative),
            format!("{:.1}", 100.0 * m.max_relative),
        ]
    };
    let mut rows = vec![row("fitted", fit.modes.join(" + "), fit.stretch, &fit.misfit)];
    rows.extend(fit.predictions.iter().map(|p| row(kind(p.kind), p.mode.to_string(), p.stretch, &p.misfit)));
    Table {
        name: "predictions",
        caption: "The law against the data points that were fitted, and as a prediction of those that were not. Rms and bias are shares of the root mean square of the measured stresses; the largest misfit is that of a single data point, as a share of its own stress. Bias below zero: the law is too soft.".into(),
        columns: headings(&[
            ("Mode", "", false),
            ("Data points", "", false),
            ("Number", "", true),
            ("Stretch", "", true),
            ("Rms, of the rms stress", "%", true),
            ("Bias, of the rms stress", "%", true),
            ("Largest, of its own stress", "%", true),
        ]),
        rows,
        pick: None,
    }
}

fn stability(fit: &StoredFit) -> Table {
    let rows = fit.stability.iter().map(|r| {
        let end = |lost: Option<f64>, to: &str, looked: f64| match lost {
            Some(at) => format!("{at:.4}"),
            None => format!("not {to} to {}", stretch_text(looked)),
        };
        vec![r.mode.words(), end(r.below, "down", r.looked[0]), end(r.above, "up", r.looked[1])]
    });
    Table {
        name: "stability",
        caption:
            "Where the law stops being stable (Drucker), nearly incompressible: stretches, in simple shear the shear."
                .into(),
        columns: headings(&[("Mode", "", false), ("Lost below", "", true), ("Lost above", "", true)]),
        rows: rows.collect(),
        pick: None,
    }
}

/// Describes a kind of prediction.
fn kind(kind: PredictionKind) -> &'static str {
    match kind {
        PredictionKind::OutsideRange => "predicted, outside the range",
        PredictionKind::OtherModeInRange => "predicted, same range",
        PredictionKind::OtherMode => "predicted, every data point",
    }
}

fn ranges(fit: &StoredFit) -> Table {
    let n = fit.range_dependence.len();
    let count = n.min(RANGES);
    // Evenly spread, including the first and the last
    let mut picked: Vec<usize> = (0..count).map(|k| k * (n - 1) / (count - 1)).collect();
    let [low, high] = fit.stretch;
    let end = if low.ln().abs() > high.ln().abs() { low } else { high };
    let own = |k: &usize| (fit.range_dependence[*k].to - end).abs() < 1e-9;
    picked.extend((0..n).find(own));
    picked.sort_unstable();
    picked.dedup();
    let printed = fit.printed();
    let rows = (picked.iter())
        .map(|k| {
            let r = &fit.range_dependence[*k];
            let mark = if own(k) { " (fitted)" } else { "" };
            let mut cells = vec![format!("{}{mark}", stretch_text(r.to)), r.rows.to_string()];
            cells.push(list(&r.parameters, &printed));
            // Intervals of several constants would hide the values
            if let ([p], [printed]) = (&r.parameters[..], &printed[..]) {
                let ends = |[a, b]: [f64; 2]| format!("{} to {}", printed.end(a), printed.end(b));
                cells.push(p.ends().map_or("–".into(), ends));
            }
            cells.push(format!("{:.1}", 100.0 * r.rms_relative));
            cells
        })
        .collect();
    let all =
        if picked.len() < n { format!(" {} of {n} ranges; all are in fit.json.", picked.len()) } else { String::new() };
    let mut columns = vec![("End of the range λ", "", true), ("Data points", "", true), ("Value", "", true)];
    if printed.len() == 1 {
        columns.push(("95 % interval", "", true));
    }
    columns.push(("Rms", "%", true));
    Table {
        name: "ranges",
        caption: format!("The same fit over a range that ends earlier or later.{all}"),
        columns: headings(&columns),
        rows,
        pick: Some(format!("{} (fitted)", stretch_text(end))),
    }
}
