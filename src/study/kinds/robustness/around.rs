//! Maps around a scene of one's own: time step, mesh, Poisson's ratio, load and start state are varied, the rest stays.
//!
//! | varied | how |
//! |---|---|
//! | time step | every `dt` times ¼ to 4 |
//! | load | every signal times ½ to 3 |
//! | ν | every law that has `nu` |
//! | mesh | `cells` times ½ to 2; divisions of a grid once and twice |
//! | start | twisted; anywhere, where every law survives inversion |

use crate::material::registry;
use crate::math::units;
use crate::scene::Headline;
use crate::scene::{SceneError, SceneSpec, read_scene};
use crate::study::axis::AxisSpec;
use crate::study::kind::{Around, StoredExpansion, stored};
use crate::study::kinds::robustness::check::{Bound, CheckSpec, Moment};
use crate::study::kinds::robustness::spec::{self, MapSpec, SuiteSpec};
use crate::study::spec::{VariantSpec, refuse};
use crate::study::store::record::Quantity;
use std::path::Path;
use toml::{Table, Value};

/// Factors of the time step; the first is the reference of its row.
const STEPS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];
const LOADS: [f64; 5] = [0.5, 1.0, 1.5, 2.0, 3.0];
const RATIOS: [f64; 5] = [0.3, 0.4, 0.45, 0.49, 0.499];
const MESHES: [f64; 3] = [2.0, 1.0, 0.5];
/// Keys whose values are signals.
const SIGNALS: [&str; 5] = ["displacement", "acceleration", "force", "traction", "signal"];

/// The study around a scene of one's own.
pub const AROUND: Around = Around {
    question: "Where does this scene hold?",
    expectation: "Wherever the scene converges, its answer agrees with that of the smallest time step.",
    tolerance: "2 %",
    expand: around,
};

/// Maps and starts around the scene in `file`.
fn around(file: &Path, changes: &[(String, Value)]) -> Result<StoredExpansion, SceneError> {
    let (scene, text) = read_scene(file, changes)?;
    let table: Table = text.parse().expect("a scene that was read is TOML");
    let quantity = quantity(&scene).ok_or_else(|| SceneError::Content {
        file: file.into(),
        place: "probe".into(),
        fact: "the scene records nothing that could be compared".into(),
        remedy: "add a [[probe]], for example kind = \"position\" with a region".into(),
    })?;
    let own = variant("converged", "the scene's own step", Table::new());
    let mut variants = vec![own];
    if let Some(set) = linearised(&table) {
        variants.push(variant("linearised", "one linearised step", set));
    }
    let names: Vec<String> = variants.iter().map(|v| v.name.clone()).collect();
    let of = |name: &str, setup: &str, x: AxisSpec, y: AxisSpec, variants: &[String]| MapSpec {
        name: name.into(),
        setup: setup.into(),
        scene: Some(file.into()),
        variants: Some(variants.to_vec()),
        set: Table::new(),
        quantity: quantity.clone(),
        axes: vec![x, y],
        reference: None,
    };
    let dt = || axis("dt", "time step", "Δt/Δt₀", &STEPS, &|f| steps(&table, f));
    let load = || axis("load", "load", "s/s₀", &LOADS, &|f| loads(&table, f));
    // Nothing can be said of a load that the scene has not, or of a ν that its laws do not take
    let varies = |axis: &AxisSpec| !axis.values[0].as_table().is_none_or(Table::is_empty);
    let mut maps = vec![];
    if varies(&load()) {
        maps.push(of("dt-load", "Time step against load.", dt(), load(), &names));
    }
    let nu = axis("nu", "Poisson's ratio", "ν", &RATIOS, &|nu| ratios(&table, nu));
    if varies(&nu) {
        maps.push(of("dt-nu", "Time step against Poisson's ratio.", dt(), nu, &names));
    }
    let cells = axis("mesh", "cells", "N/N₀", &MESHES, &|f| cells(&table, f));
    if varies(&cells) && varies(&load()) {
        maps.push(of("mesh-load", "Mesh against load.", cells, load(), &names[..1]));
    }
    let suites = [starts(file, &scene, &quantity)];
    spec::expand(variants, &suites, &maps).map(stored).map_err(|mistake| refuse(file, mistake))
}

fn variant(name: &str, label: &str, set: Table) -> VariantSpec {
    VariantSpec { name: name.into(), label: Some(label.into()), group: None, set, quantities: vec![], scene: None }
}

/// Values that are tables of changes: each point changes keys of its own.
fn axis(name: &str, label: &str, symbol: &str, factors: &[f64], changes: &dyn Fn(f64) -> Table) -> AxisSpec {
    AxisSpec {
        name: name.into(),
        keys: vec![],
        label: label.into(),
        symbol: symbol.into(),
        unit: String::new(),
        values: factors.iter().map(|f| changes(*f).into()).collect(),
        names: Some(factors.iter().map(f64::to_string).collect()),
    }
}

/// The first recorded quantity in this order: bending angle, position, markers, reaction, cable, cavity.
fn quantity(spec: &SceneSpec) -> Option<Quantity> {
    let Headline { column, label, symbol, unit } = spec.headline()?;
    Some(Quantity {
        name: column,
        label: label.into(),
        symbol: symbol.into(),
        unit: unit.into(),
        ..Quantity::default()
    })
}

fn list<'a>(table: &'a Table, key: &str) -> impl Iterator<Item = (usize, &'a Table)> {
    let entries = table.get(key).and_then(Value::as_array);
    entries.into_iter().flatten().filter_map(Value::as_table).enumerate()
}

/// The same scene with one linearised step per dt; `None` if a stage is static, or has a loop that linearises once anyway.
fn linearised(table: &Table) -> Option<Table> {
    let iterates = |s: &Table| {
        let integrator = s.get("integrator");
        let name = integrator.and_then(|i| i.as_str().or_else(|| i.get("kind")?.as_str()));
        !name.is_some_and(|name| ["static", "implicit_euler_corrected"].contains(&name))
    };
    let dynamic = list(table, "stage").all(|(_, stage)| iterates(stage));
    let key = |(k, _): (usize, &Table)| (format!("stage.{k}.integrator"), "implicit_euler_linearised".into());
    dynamic.then(|| list(table, "stage").map(key).collect())
}

fn steps(table: &Table, factor: f64) -> Table {
    let one = |(k, stage): (usize, &Table)| {
        let (dt, _) = units::quantity(stage.get("dt")?.as_str()?).ok()?;
        Some((format!("stage.{k}.dt"), format!("{} s", factor * dt).into()))
    };
    list(table, "stage").filter_map(one).collect()
}

/// Every signal as a product with the factor.
fn loads(table: &Table, factor: f64) -> Table {
    let mut out = Table::new();
    for kind in ["effect", "constraint"] {
        for (k, entry) in list(table, kind) {
            let inner = entry.get("drive").and_then(Value::as_table);
            let places = [("", Some(entry)), ("drive.", inner)];
            for (below, keys) in places {
                for (key, signal) in keys.into_iter().flatten().filter(|(key, _)| SIGNALS.contains(&key.as_str())) {
                    let mut product = Table::new();
                    product.insert("kind".into(), "product".into());
                    product.insert("of".into(), vec![signal.clone(), factor.into()].into());
                    out.insert(format!("{kind}.{k}.{below}{key}"), product.into());
                }
            }
        }
    }
    out
}

fn ratios(table: &Table, nu: f64) -> Table {
    let laws = table.get("laws").and_then(Value::as_table).into_iter().flatten();
    let with = laws.filter(|(_, law)| law.get("nu").is_some());
    with.map(|(name, _)| (format!("laws.{name}.nu"), nu.into())).collect()
}

fn cells(table: &Table, factor: f64) -> Table {
    let mut out = Table::new();
    let Some(mesh) = table.get("mesh") else { return out };
    if let Some(cells) = mesh.get("cells").and_then(Value::as_integer) {
        out.insert("mesh.cells".into(), ((cells as f64 * factor).round() as i64).into());
    }
    if let Some(grid) = mesh.get("grid") {
        let divisions = grid.get("divisions").and_then(Value::as_array).into_iter().flatten();
        let scaled = divisions.filter_map(Value::as_integer).map(|n| Value::from(((n as f64 * factor) as i64).max(1)));
        out.insert("mesh.grid.divisions".into(), Value::Array(scaled.collect()));
    }
    out
}

/// Starts that are not rest; they end where the run from rest ends.
fn starts(file: &Path, spec: &SceneSpec, quantity: &Quantity) -> SuiteSpec {
    let law = |table: &Table| table.get("law").and_then(Value::as_str).and_then(|name| registry::find(name).ok());
    let survives = spec.laws.values().all(|table| law(table).is_some_and(|l| l.info.survives_inversion));
    let mut all =
        vec![("rest", "{}"), ("twisted-90", "start = { kind = \"twisted\", axis = [1, 0, 0], angle = \"90 deg\" }")];
    if survives {
        all.extend([
            ("twisted-4pi", "start = { kind = \"twisted\", axis = [1, 0, 0], angle = \"720 deg\" }"),
            ("random", "start = { kind = \"random\", size = \"10 mm\", seed = 1 }"),
            ("collapsed", "start = { kind = \"collapsed\", keep = \"\", perturbation = \"1 mm\", seed = 1 }"),
        ]);
    }
    let table = |text: &str| if text == "{}" { Table::new() } else { text.parse().expect("valid TOML") };
    let check = CheckSpec {
        what: format!("{} at the end", quantity.label),
        measured: quantity.name.clone(),
        reference: None,
        like: Some("rest".into()),
        first: false,
        at: Moment::End,
        bound: Bound::Both,
        accept: "1 %".into(),
        scale: None,
        source: "the run from rest".into(),
        members: None,
        variants: None,
    };
    SuiteSpec {
        name: "start".into(),
        setup: "The scene from a start that is not rest.".into(),
        scene: Some(file.into()),
        variants: Some(vec!["converged".into()]),
        set: Table::new(),
        members: all.into_iter().map(|(name, text)| (name.to_string(), Value::from(table(text)))).collect(),
        ends: Some(
            ["Converged", "StepTooSmall", "Inverted", "NoEquilibrium", "ContactJammed"].map(String::from).to_vec(),
        ),
        checks: vec![check],
        quick: false,
    }
}
