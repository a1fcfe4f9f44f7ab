//! Tables of `durometer motion`: states of the curves, ring-downs, repeats, and the curves themselves.

use durometer::calibrate::Bounded;
use durometer::motion::repeats::pooled;
use durometer::motion::{Evaluation, MotionError};
use durometer::report::numbers::digits;
use durometer::report::table::{Table, headings, quoted};

/// Returns the unit in which a curve is printed, and the factor that converts to it.
fn printed(name: &str) -> (f64, &'static str) {
    if name.ends_with("_m") { (1e3, "mm") } else { (1.0, "deg") }
}

/// Formats a number with `digits` decimals; zero has no sign.
fn decimals(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    if text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.')) { text.replace('-', "") } else { text }
}

/// Builds the table of the held and final mean of every curve, the change between them, and the drift of the final state.
pub fn states(found: &[Evaluation]) -> Table {
    let mut rows = vec![];
    for evaluation in found {
        // A curve without a state has no row
        for c in evaluation.curves.iter().filter(|c| c.held.is_some() || c.last.is_some()) {
            let (factor, unit) = printed(&c.curve.name);
            let half = c.change.as_ref().map(Bounded::half_width);
            let shown = half.or(c.last.as_ref().map(|p| p.deviation)).map_or(4, |error| digits(factor * error).max(4));
            let number = |value: Option<f64>| value.map_or("–".into(), |v| decimals(factor * v, shown));
            let drift = c.last.as_ref().map(|p| p.drift.value * p.duration_s());
            rows.push(vec![
                evaluation.source.clone(),
                c.curve.name.clone(),
                unit.into(),
                number(c.held.as_ref().map(|p| p.mean.value)),
                number(c.last.as_ref().map(|p| p.mean.value)),
                number(c.change.map(|b| b.value)),
                number(half),
                number(c.last.as_ref().map(|p| p.deviation)),
                number(drift),
            ]);
        }
    }
    Table {
        name: "states",
        caption:
            "Mean of the held and of the final state, and the change with the 95 % interval of the noise of the record"
                .into(),
        columns: headings(&[
            ("Record", "", false),
            ("Curve", "", false),
            ("Unit", "", false),
            ("Held", "", true),
            ("Final", "", true),
            ("Change", "", true),
            ("± 95 %", "", true),
            ("Deviation", "", true),
            ("Drift", "", true),
        ]),
        rows,
        pick: None,
    }
}

/// Builds the table of frequency and decay with their intervals.
pub fn ring_downs(found: &[Evaluation]) -> Table {
    let row = |e: &Evaluation| {
        let (at, r) = e.ring_down.as_ref()?;
        let (factor, unit) = printed(&e.curves[*at].curve.name);
        let pair = |b: &Bounded, f: f64, least: usize| {
            let shown = digits(f * b.half_width()).max(least);
            [format!("{:.shown$}", f * b.value), format!("{:.shown$}", f * b.half_width())]
        };
        let window = format!("{:.3}–{:.3}", r.window_s[0], r.window_s[1]);
        let numbers = [
            pair(&r.frequency_hz, 1.0, 4),
            pair(&r.decay_per_s, 1.0, 3),
            pair(&r.amplitude, factor, 4),
            pair(&r.offset, factor, 4),
        ];
        let lead = [e.source.clone(), e.curves[*at].curve.name.clone(), window, unit.into()];
        Some(lead.into_iter().chain(numbers.into_iter().flatten()).collect())
    };
    Table {
        name: "ring_down",
        caption: "Frequency, decay, amplitude at the release and offset, with half the 95 % intervals".into(),
        columns: headings(&[
            ("Record", "", false),
            ("Curve", "", false),
            ("Window", "s", true),
            ("Unit", "", false),
            ("Frequency", "Hz", true),
            ("± frequency", "Hz", true),
            ("Decay", "1/s", true),
            ("± decay", "1/s", true),
            ("Amplitude", "", true),
            ("± amplitude", "", true),
            ("Offset", "", true),
            ("± offset", "", true),
        ]),
        rows: found.iter().filter_map(row).collect(),
        pick: None,
    }
}

/// Builds the table of changes, frequency and decay, pooled over the files that have them; it has no rows if there is only one file.
pub fn repeats(found: &[Evaluation]) -> Result<Table, MotionError> {
    let mut rows = vec![];
    let mut add = |name: &str, unit: &str, values: Vec<f64>| -> Result<(), MotionError> {
        if found.len() > 1 && !values.is_empty() {
            let p = pooled(&values)?;
            let half = p.deviation.map(|_| p.mean.half_width());
            let shown = half.map_or(4, |half| digits(half).max(4));
            let number = |value: Option<f64>| value.map_or("–".into(), |v| format!("{v:.shown$}"));
            let range = p.deviation.map(|_| p.half_range);
            let files = format!("{} of {}", p.repeats, found.len());
            let lead = [name.to_string(), unit.into(), files];
            rows.push(lead.into_iter().chain([Some(p.mean.value), half, p.deviation, range].map(number)).collect());
        }
        Ok(())
    };
    let mut names: Vec<&String> = vec![];
    for c in found.iter().flat_map(|e| &e.curves) {
        let name = &c.curve.name;
        if names.contains(&name) {
            continue;
        }
        names.push(name);
        let (factor, unit) = printed(name);
        let of = |e: &Evaluation| e.curves.iter().find(|c| c.curve.name == *name)?.change.map(|b| factor * b.value);
        add(name, unit, found.iter().filter_map(of).collect())?;
    }
    let rings = || found.iter().filter_map(|e| e.ring_down.as_ref());
    add("frequency", "Hz", rings().map(|(_, r)| r.frequency_hz.value).collect())?;
    add("decay", "1/s", rings().map(|(_, r)| r.decay_per_s.value).collect())?;
    Ok(Table {
        name: "repeats",
        caption: "Mean over the files that have the quantity, with its 95 % interval by Student's t, the standard deviation between files and half their range".into(),
        columns: headings(&[
            ("Quantity", "", false),
            ("Unit", "", false),
            ("Files", "", false),
            ("Mean", "", true),
            ("± 95 %", "", true),
            ("Deviation", "", true),
            ("Half range", "", true),
        ]),
        rows,
        pick: None,
    })
}

/// Writes all curves into one CSV table, one row per time and curve.
pub fn curves(evaluation: &Evaluation) -> String {
    let mut out = String::from("curve,t_s,value,samples\n");
    for c in &evaluation.curves {
        let name = quoted(&c.curve.name);
        for ((t, v), n) in c.curve.time_s.iter().zip(&c.curve.value).zip(&c.curve.samples) {
            out += &format!("{name},{t},{v},{n}\n");
        }
    }
    out
}

/// Formats a table as text with aligned columns.
pub fn text(table: &Table) -> String {
    let heading = |(name, unit, _): &(String, String, bool)| {
        if unit.is_empty() { name.clone() } else { format!("{name} [{unit}]") }
    };
    let head: Vec<String> = table.columns.iter().map(heading).collect();
    let wide = |k: usize| {
        let cells = table.rows.iter().map(|r| &r[k]).chain([&head[k]]);
        cells.map(|c| c.chars().count()).max().unwrap_or(0)
    };
    let line = |row: &[String]| {
        let cell = |(k, c): (usize, &String)| {
            if table.columns[k].2 { format!("{c:>0$}", wide(k)) } else { format!("{c:<0$}", wide(k)) }
        };
        row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ").trim_end().to_string() + "\n"
    };
    let rows: String = table.rows.iter().map(|r| line(r)).collect();
    format!("{}\n{}{rows}", table.caption, line(&head))
}
