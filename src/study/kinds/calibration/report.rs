//! Report of a calibration, and the law files: the laws of the scene with the constants that were found.

use crate::calibrate::correlation_key;
use crate::calibrate::inverse::{Calibration, FittedCurve};
use crate::report::figure::drawn;
use crate::report::names::constant;
use crate::report::numbers::{percent, percent_cell};
use crate::report::table::{Table, headings};
use crate::study::analysis::Analysis;
use crate::study::claim::Claim;
use crate::study::content::Content;
use crate::study::kinds::calibration::band::{Band, band as around};
use crate::study::kinds::calibration::figures::band;
use crate::study::kinds::calibration::figures::curves as figures;
use crate::study::kinds::calibration::findings::{CalibratedConstant, CalibratedVariant, CalibrationFindings};
use crate::study::kinds::calibration::methods;
use crate::study::kinds::calibration::words::{mesh_is_doubtful, scaled, warnings_of};
use crate::study::store::results::Results;
use crate::study::tables;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

pub fn content(store: &Results, a: &Analysis<CalibrationFindings>) -> Content {
    let of = |v: &CalibratedVariant| around(&store.study, &store.cases, &store.found, &store.sensitivities, v);
    let bands: Vec<Band> = a.variants.iter().filter_map(of).collect();
    let constants_found = a.variants.iter().flat_map(|v| v.constants.iter().map(|c| c.sentence(&v.label)));
    let sheets = a.variants.iter().flat_map(|v| (0..figures::sheets(store, v)).map(move |k| (v, k)));
    let figures = sheets.filter_map(|(v, k)| drawn("curves", || figures::draw(store, v, k)));
    let of_bands = bands.iter().filter_map(|b| drawn("band", || band::draw(b)));
    let supported =
        !a.variants.is_empty() && a.variants.iter().flat_map(|v| &v.constants).all(|c| c.interval.is_some());
    Content {
        facts: facts(a),
        sentences: constants_found.chain(bands.iter().map(Band::sentence)).collect(),
        analysis: analysis(a, &bands),
        tables: vec![by_case(a), stability(store, a)],
        folded: vec![("Every case", tables::cases(store))],
        figures: figures.chain(of_bands).collect(),
        claims: a.variants.iter().flat_map(claims).collect(),
        decisions: a.variants.iter().flat_map(|v| decisions(v, a.tolerance)).collect(),
        files: law_files(store, a),
        search: methods::search(store, a),
        ..Content::new(a, supported, ("Which constants, how far to believe them", constants(a)))
    }
}

/// The constants with their intervals.
fn claims(v: &CalibratedVariant) -> impl Iterator<Item = Claim> + '_ {
    let of = |c: &CalibratedConstant| {
        let what = format!("{}, {}", c.key, v.variant);
        Some(Claim { what, value: c.value, interval: c.interval?, unit: c.unit.clone() })
    };
    v.constants.iter().filter_map(of)
}

/// Whether each constant has an interval, and whether the mesh is fine enough for all of them.
fn decisions(v: &CalibratedVariant, tolerance: f64) -> impl Iterator<Item = (String, String)> + '_ {
    let word = |is: bool| if is { "yes" } else { "no" }.to_string();
    let of =
        move |c: &CalibratedConstant| (format!("{}, {} has an interval", c.key, v.variant), word(c.interval.is_some()));
    let mesh = (format!("the mesh of {} is in doubt", v.variant), word(mesh_is_doubtful(v, tolerance)));
    v.constants.iter().map(of).chain([mesh])
}

fn facts(a: &CalibrationFindings) -> Vec<(String, String)> {
    let of = |c: &CalibratedConstant| {
        let (f, unit, n) = scaled(c);
        let mut out = vec![(format!("{:.n$} {unit}", f * c.value), constant(&c.key))];
        out.extend(c.interval.map(|[a, b]| (format!("{:.n$} to {:.n$} {unit}", f * a, f * b), "95 % interval".into())));
        out.extend(
            c.bias.map(|b| (format!("{:+.0} %", 100.0 * b).replace('-', "−"), "error of the gauge length".into())),
        );
        out
    };
    a.variants.iter().flat_map(|v| &v.constants).flat_map(of).collect()
}

fn analysis(a: &Analysis<CalibrationFindings>, bands: &[Band]) -> Map<String, Value> {
    let mut out = Map::new();
    for v in &a.variants {
        out.insert(v.variant.clone(), json!(v));
    }
    out.insert("incomplete".into(), json!(a.incomplete));
    out.insert("use".into(), json!(bands));
    out
}

fn constants(a: &CalibrationFindings) -> Table {
    let row = |(v, c): (&CalibratedVariant, &CalibratedConstant)| {
        let (f, unit, n) = scaled(c);
        let part = |x: Option<f64>| x.map_or("–".into(), |x| percent_cell(x.abs()));
        let pair = |x: Option<[f64; 2]>| x.map_or("–".into(), |[a, b]| format!("{:.n$} to {:.n$}", f * a, f * b));
        vec![
            format!("{}, {}", constant(&c.key), v.variant),
            format!("{:.n$}", f * c.value),
            unit.to_string(),
            pair(c.interval),
            part(c.rows),
            part(c.mesh),
            part(c.steps),
            pair(c.nuisance),
            c.gauge.map_or("–".into(), |g| format!("{:.n$}", f * g)),
            c.bias.map_or("–".into(), |b| format!("{:+.1}", 100.0 * b)),
        ]
    };
    Table {
        name: "constants",
        caption: "Constants from the finest mesh. Interval: 95 %, from the data, the errors of the mesh and of the time steps and the dimensions not known exactly, all at their worst ends; data: half-width from the data alone; mesh: uncertainty of the finest one by the meshes of its family; time steps: their error by runs with others; gauge: what the same law gives if all travel stretches the gauge length, where that tells the constant.".into(),
        columns: headings(&[
            ("Constant, curve", "", false),
            ("Value", "", true),
            ("Unit", "", false),
            ("Interval", "", true),
            ("Data", "± %", true),
            ("Mesh", "± %", true),
            ("Time steps", "± %", true),
            ("Dimensions", "", true),
            ("Gauge", "", true),
            ("Its error", "%", true),
        ]),
        rows: a.variants.iter().flat_map(|v| v.constants.iter().map(move |c| (v, c))).map(row).collect(),
        pick: None,
    }
}

fn by_case(a: &CalibrationFindings) -> Table {
    let mut rows = vec![];
    for c in a.variants.iter().flat_map(|v| &v.constants) {
        let (f, unit, n) = scaled(c);
        for o in &c.cases {
            let interval = o.interval.map_or("–".into(), |[a, b]| format!("{:.n$} to {:.n$}", f * a, f * b));
            rows.push(vec![
                o.case.clone(),
                o.role.words().into(),
                o.cells.to_string(),
                c.key.clone(),
                format!("{:.n$} {unit}", f * o.value),
                interval,
                percent_cell(o.rms_relative),
            ]);
        }
    }
    Table {
        name: "cases-constants",
        caption: "Every case with its own interval (data alone) and its misfit √(Σr²/Σy²).".into(),
        columns: headings(&[
            ("Case", "", false),
            ("Role", "", false),
            ("Cells", "", true),
            ("Constant", "", false),
            ("Value", "", true),
            ("Interval", "", true),
            ("Misfit", "%", true),
        ]),
        rows,
        pick: a.variants.first().map(|v| v.case.clone()),
    }
}

/// The certified range of the law next to the stretches of the specimen.
fn stability(store: &Results, a: &CalibrationFindings) -> Table {
    let mut rows = vec![];
    for v in &a.variants {
        for (c, s) in store.found[&v.case].curves.iter().flat_map(|c| c.stability.iter().map(move |s| (c, s))) {
            let end = |x: Option<f64>, far: f64| x.map_or(format!("beyond {far:.3}"), |x| format!("{x:.3}"));
            rows.push(vec![
                c.name.clone(),
                format!("laws.{}", s.law),
                s.mode.replace('_', " "),
                end(s.below, s.looked[0]),
                end(s.above, s.looked[1]),
                format!("{:.3}", c.stretch[2]),
            ]);
        }
    }
    Table {
        name: "robustness",
        caption: "Stretch (in simple shear γ) at which the law with these constants stops being stable (Drucker), and the largest principal stretch in the specimen.".into(),
        columns: headings(&[
            ("Curve", "", false),
            ("Law", "", false),
            ("Mode", "", false),
            ("Stable from", "", true),
            ("to", "", true),
            ("Reached", "", true),
        ]),
        rows,
        pick: None,
    }
}

/// One file for each variant and each of its laws. A single law and variant make `law.toml`; otherwise the names include them.
fn law_files(store: &Results, a: &Analysis<CalibrationFindings>) -> Vec<(String, String)> {
    let several = a.variants.len() > 1;
    let of = |v: &CalibratedVariant| -> Vec<(String, String)> {
        let laws: BTreeSet<&str> = v.constants.iter().filter_map(law_of).collect();
        let parts = |law: &str| {
            let names = [several.then_some(v.variant.as_str()), (laws.len() > 1).then_some(law)];
            std::iter::once("law").chain(names.into_iter().flatten()).collect::<Vec<_>>().join("-")
        };
        laws.iter()
            .copied()
            .filter_map(|law| Some((as_file_name(&format!("{}.toml", parts(law))), law_file(store, a, (v, law))?)))
            .collect()
    };
    a.variants.iter().flat_map(of).collect()
}

/// Replaces every character that a file name may not contain by an underscore.
fn as_file_name(name: &str) -> String {
    name.chars().map(|c| if c.is_alphanumeric() || "._-".contains(c) { c } else { '_' }).collect()
}

/// The law that a constant belongs to; `None` for other numbers of the scene.
fn law_of(c: &CalibratedConstant) -> Option<&str> {
    c.key.strip_prefix("laws.")?.split('.').next()
}

/// A law with its provenance, ready to be included by a scene.
fn law_file(
    store: &Results,
    a: &Analysis<CalibrationFindings>,
    (v, name): (&CalibratedVariant, &str),
) -> Option<String> {
    let case = store.cases.iter().find(|c| c.record.id == v.case)?;
    let found = store.found.get(&v.case)?;
    let scene: toml::Table = case.record.provenance.scene.parse().ok()?;
    let mut law = scene.get("laws")?.get(name)?.as_table()?.clone();
    law.remove("provenance");
    let number = |c: &CalibratedConstant, x: f64| -> toml::Value {
        if c.unit == "Pa" { format!("{x} Pa").into() } else { x.into() }
    };
    let mut p = toml::Table::new();
    p.insert("method".into(), "inverse analysis of the specimen".into());
    p.insert("study".into(), store.study.study.clone().into());
    p.insert("case".into(), v.case.clone().into());
    let each = |of: &dyn Fn(&FittedCurve) -> toml::Value| -> toml::Value {
        match &found.curves[..] {
            [one] => of(one),
            all => all.iter().map(of).collect::<Vec<_>>().into(),
        }
    };
    p.insert("data".into(), each(&|c| c.measured.file.clone().into()));
    p.insert("sha256".into(), each(&|c| c.measured.sha256.clone().into()));
    p.insert("rows".into(), each(&|c| i64::try_from(c.measured.y.len()).unwrap_or(i64::MAX).into()));
    p.insert("largest_stretch".into(), each(&|c| c.stretch[2].into()));
    p.insert("misfit_relative".into(), each(&|c| c.rms_relative.into()));
    p.insert("errors".into(), v.errors.clone().into());
    p.insert("element".into(), v.formulation.clone().into());
    p.insert("cells".into(), i64::try_from(v.cells).ok()?.into());
    p.insert("mesh".into(), v.mesh_verdict.clone().into());
    p.insert("locking".into(), v.locking.is_some().into());
    let constants = || v.constants.iter().filter(|c| law_of(c) == Some(name));
    for c in constants() {
        let key = c.key.rsplit('.').next()?;
        law.insert(key.into(), number(c, c.value));
        if let Some([low, high]) = c.interval {
            p.insert(format!("{key}_interval"), vec![number(c, low), number(c, high)].into());
        }
        if let Some(why) = &c.open {
            p.insert(format!("{key}_without_interval"), why.clone().into());
        }
        if let Some(mesh) = c.mesh {
            p.insert(format!("{key}_mesh_error_relative"), mesh.into());
        }
        if let Some(steps) = c.steps {
            p.insert(format!("{key}_step_error_relative"), steps.into());
        }
    }
    let warnings: Vec<toml::Value> = warnings_of(a, v, case, found).into_iter().map(Into::into).collect();
    if constants().any(|c| c.interval.is_some()) {
        let steps = if constants().any(|c| c.steps.is_some()) { ", time steps" } else { "" };
        let words = format!("95 % from data, mesh{steps} and dimensions not known exactly; tolerance of the study");
        p.insert("interval".into(), format!("{words} {}", percent(a.tolerance)).into());
    }
    p.insert("warnings".into(), warnings.into());
    p.insert("durometer".into(), store.study.version.clone().into());
    let correlation = correlations(v, found, &|c| law_of(c) == Some(name));
    if !correlation.is_empty() {
        p.insert("correlation".into(), correlation.into());
    }
    law.insert("provenance".into(), p.into());
    toml::to_string(&law).ok()
}

/// Correlations of those constants of a law that have intervals, by pairs of names: the correlations from the data points, times the shares of these
/// in the intervals. The rest of an interval counts as independent of those of other constants.
fn correlations(
    v: &CalibratedVariant,
    found: &Calibration,
    is_own: &dyn Fn(&CalibratedConstant) -> bool,
) -> toml::Table {
    let Some(covariance) = &found.covariance else { return toml::Table::new() };
    let share = |k: usize| {
        let c = &v.constants[k];
        let [low, high] = c.interval?;
        Some((k, c.key.rsplit('.').next()?, c.rows? * c.value.abs() / (0.5 * (high - low)) / covariance[k][k].sqrt()))
    };
    let own: Vec<(usize, &str, f64)> =
        (0..v.constants.len()).filter(|k| is_own(&v.constants[*k])).filter_map(share).collect();
    by_pairs(&own, covariance)
}

/// Covariances of these constants, each given by an index, a name and a factor, multiplied by their factors.
fn by_pairs(own: &[(usize, &str, f64)], covariance: &[Vec<f64>]) -> toml::Table {
    let pairs = own.iter().enumerate().flat_map(|(n, a)| own[n + 1..].iter().map(move |b| (a, b)));
    let of = |((a, first, x), (b, second, y)): (&(usize, &str, f64), &(usize, &str, f64))| {
        let r = covariance[*a][*b] * x * y;
        r.is_finite().then(|| (correlation_key(first, second), toml::Value::from(r)))
    };
    pairs.filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::correlation_of;

    /// Two of three constants belong to one law: deviations 2 and 5, correlation −0.9, and half of the interval of the second comes from errors other
    /// than those of the data.
    #[test]
    fn a_law_file_has_the_correlation_of_its_own_constants() {
        let covariance = [vec![4.0, 0.1, -9.0], vec![0.1, 1.0, 0.1], vec![-9.0, 0.1, 25.0]];
        let table = by_pairs(&[(0, "C10", 1.0 / 2.0), (2, "C01", 0.5 / 5.0)], &covariance);
        assert_eq!(table.keys().collect::<Vec<_>>(), ["C10_C01"]);
        let provenance = toml::Table::from_iter([("correlation".to_string(), toml::Value::Table(table))]);
        assert!((correlation_of(&provenance, "C01", "C10") + 0.45).abs() < 1e-12, "{provenance}");
    }
}
