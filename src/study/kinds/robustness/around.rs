//! Maps around a user's own scene: time step, mesh, Poisson's ratio, load and start state are varied, the rest is kept.
//!
//! | varied | how |
//! |---|---|
//! | time step | every `dt` times ¼ to 4 |
//! | load | every signal times ½ to 3, those that a controller sets apart |
//! | ν | every law that has `nu` |
//! | mesh | number of cells times ½ to 2: `cells`, `size`, or divisions of a grid |
//! | start | twisted; anywhere, where every law survives inversion; only of a scene that ends static |

use crate::material::registry;
use crate::math::units;
use crate::scene::spec::{GridSpec, IntegratorSpec};
use crate::scene::{Headline, Length, MeshSpec, SceneError, SceneSpec, read_scene};
use crate::scene::{cells_of_grid, divisions_value, scaled_grid};
use crate::study::axis::AxisSpec;
use crate::study::kind::{Around, StoredExpansion, stored};
use crate::study::kinds::robustness::check::{Bound, CheckSpec, Moment};
use crate::study::kinds::robustness::loads::Loads;
use crate::study::kinds::robustness::spec::{self, MapSpec, SuiteSpec};
use crate::study::spec::{VariantSpec, refuse};
use crate::study::store::record::{REFUSED, StudyQuantity};
use crate::wording::few;
use std::path::Path;
use toml::{Table, Value};

/// Factors of the time step; the first is the reference of its row.
const STEPS: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];
const LOADS: [f64; 5] = [0.5, 1.0, 1.5, 2.0, 3.0];
const RATIOS: [f64; 5] = [0.3, 0.4, 0.45, 0.49, 0.499];
/// Factors of the number of cells, finest first.
const MESHES: [f64; 3] = [2.0, 1.0, 0.5];

/// The study around a user's own scene.
pub const AROUND: Around = Around {
    question: "Where does this scene hold?",
    expectation: "Wherever the scene converges, its answer agrees with that of the smallest time step.",
    tolerance: "2 %",
    expand: around,
};

/// Maps and start states around the scene in `file`.
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
    let signals = Loads::new(&table);
    let dt = || axis("dt", "time step", "Δt/Δt₀", &STEPS, &|f| steps(&table, f));
    let load = || axis("load", "load", "s/s₀", &LOADS, &|f| signals.times(f));
    let (mut maps, mut left_out) = (vec![], vec![]);
    // No map is possible of a load that the scene lacks, of a ν that its laws do not take, or of a mesh that is given
    if signals.is_empty() {
        left_out.push(format!("There is no map of the load: {}.", without_load(&signals)));
    } else {
        let setup = format!("Time step against load.{}", stays(&signals));
        maps.push(of("dt-load", &setup, dt(), load(), &names));
    }
    let nu = axis("nu", "Poisson's ratio", "ν", &RATIOS, &|nu| ratios(&table, nu));
    if nu.values[0].as_table().is_none_or(Table::is_empty) {
        left_out.push("There is no map of Poisson's ratio: no law of the scene has a `nu`.".into());
    } else {
        maps.push(of("dt-nu", "Time step against Poisson's ratio.", dt(), nu, &names));
    }
    match meshes(&scene.mesh) {
        None => left_out.push(format!("There is no map of the mesh: {}.", without_sizes(&scene.mesh))),
        Some(_) if signals.is_empty() => {}
        Some(mesh) => {
            let setup = format!("Mesh against load.{}", stays(&signals));
            maps.push(of("mesh-load", &setup, mesh, load(), &names[..1]));
        }
    }
    let mut suites = vec![];
    if scene.stages.last().is_some_and(|last| last.integrator == IntegratorSpec::Static) {
        suites.push(starts(file, &scene, &quantity));
    } else {
        left_out
            .push("There is no suite of starts: the last stage is dynamic, and its end depends on the start.".into());
    }
    if maps.is_empty() && suites.is_empty() {
        let remedy = "run a scene with a signal, a law with a `nu`, or a static last stage".into();
        return Err(refuse(file, ("robustness".into(), left_out.join(" "), remedy)));
    }
    let mut expansion = spec::expand(variants, &suites, &maps).map_err(|mistake| refuse(file, mistake))?;
    expansion.details.left_out = left_out;
    Ok(stored(expansion))
}

/// The reason why a scene has no load that can be scaled.
fn without_load(signals: &Loads) -> String {
    match &signals.controlled[..] {
        [] => "the scene has no signal".into(),
        controlled => format!("a controller sets {}", few(controlled)),
    }
}

/// The loads that are not scaled, as a sentence that follows another.
fn stays(signals: &Loads) -> String {
    match &signals.controlled[..] {
        [] => String::new(),
        controlled => format!(" Not scaled: {}, which a controller sets.", few(controlled)),
    }
}

fn variant(name: &str, label: &str, set: Table) -> VariantSpec {
    VariantSpec { name: name.into(), label: Some(label.into()), group: None, set, quantities: vec![], scene: None }
}

/// An axis whose values are tables of changes, so that each point sets its own keys.
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
fn quantity(spec: &SceneSpec) -> Option<StudyQuantity> {
    let Headline { column, label, symbol, unit } = spec.headline()?;
    Some(StudyQuantity {
        name: column,
        label: label.into(),
        symbol: symbol.into(),
        unit: unit.into(),
        ..StudyQuantity::default()
    })
}

fn list<'a>(table: &'a Table, key: &str) -> impl Iterator<Item = (usize, &'a Table)> {
    let entries = table.get(key).and_then(Value::as_array);
    entries.into_iter().flatten().filter_map(Value::as_table).enumerate()
}

/// The scene with one linearised step per dt; `None` if a stage is static, or has a loop that linearises only once anyway.
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

fn ratios(table: &Table, nu: f64) -> Table {
    let laws = table.get("laws").and_then(Value::as_table).into_iter().flatten();
    let with = laws.filter(|(_, law)| law.get("nu").is_some());
    with.map(|(name, _)| (format!("laws.{name}.nu"), nu.into())).collect()
}

/// Meshes with more and fewer cells; `None` if fewer than two of them differ.
fn meshes(mesh: &MeshSpec) -> Option<AxisSpec> {
    let mut points: Vec<(String, Value)> = vec![];
    for factor in MESHES {
        let set = sizes(mesh, factor);
        let name = ratio(mesh, factor).to_string();
        if !set.is_empty() && points.iter().all(|(other, _)| *other != name) {
            points.push((name, set.into()));
        }
    }
    let (names, values): (Vec<String>, Vec<Value>) = points.into_iter().unzip();
    let mesh = AxisSpec { values, names: Some(names), ..axis("mesh", "cells", "N/N₀", &[], &|_| Table::new()) };
    (mesh.values.len() > 1).then_some(mesh)
}

/// The keys that set the size of the mesh and of its parts, with the path of their table.
fn sources(mesh: &MeshSpec) -> impl Iterator<Item = (String, Option<usize>, Option<Length>, Option<&GridSpec>)> {
    let parts = mesh.parts.iter().enumerate();
    let parts = parts.map(|(k, p)| (format!("mesh.part.{k}"), p.cells, p.size, p.grid.as_ref()));
    std::iter::once(("mesh".into(), mesh.cells, mesh.size, mesh.grid.as_ref())).chain(parts)
}

/// The changes that give a mesh `factor` times as many cells.
fn sizes(mesh: &MeshSpec, factor: f64) -> Table {
    let (mut out, finer) = (Table::new(), factor.cbrt());
    let shorter = |length: Length| Value::from(format!("{} m", length.0 / finer));
    for (path, cells, size, grid) in sources(mesh) {
        if let Some(cells) = cells {
            out.insert(format!("{path}.cells"), ((cells as f64 * factor).round() as i64).into());
        }
        if let Some(size) = size {
            out.insert(format!("{path}.size"), shorter(size));
        }
        if let Some(grid) = grid.and_then(|grid| scaled_grid(grid, finer)) {
            out.insert(format!("{path}.grid.divisions"), divisions_value(&grid));
        }
    }
    if mesh.size.is_some() {
        let grading = mesh.grading.iter().enumerate();
        out.extend(grading.map(|(k, place)| (format!("mesh.grading.{k}.length"), shorter(place.length))));
    }
    out
}

/// Number of cells relative to that of the scene; for grids, which need whole divisions, computed from the divisions.
fn ratio(mesh: &MeshSpec, factor: f64) -> f64 {
    if sources(mesh).any(|(_, cells, size, _)| cells.is_some() || size.is_some()) {
        return factor;
    }
    let count = |factor: f64| -> f64 {
        let grids = sources(mesh).filter_map(|source| source.3);
        grids.map(|grid| scaled_grid(grid, factor.cbrt()).map_or(0.0, |scaled| cells_of_grid(&scaled))).sum()
    };
    (100.0 * count(factor) / count(1.0)).round() / 100.0
}

/// The reason why a mesh cannot have other sizes.
fn without_sizes(mesh: &MeshSpec) -> &'static str {
    match sources(mesh).any(|source| source.3.is_some()) {
        true => "the divisions of its grid are too few for another number of cells, or its cells grow from a place",
        false => "it is given, without `cells`, `size` or a grid",
    }
}

/// Start states other than rest: a scene that ends static must end where the run from rest ends.
fn starts(file: &Path, spec: &SceneSpec, quantity: &StudyQuantity) -> SuiteSpec {
    let law = |table: &Table| table.get("law").and_then(Value::as_str).and_then(|name| registry::find(name).ok());
    let survives = spec.laws.values().all(|table| law(table).is_some_and(|l| l.info.survives_inversion));
    let mut all = vec![
        // A twist of zero replaces the start that the scene has
        ("rest", if spec.start.is_some() { "start = { kind = \"twisted\", angle = \"0 deg\" }" } else { "" }),
        ("twisted-90", "start = { kind = \"twisted\", angle = \"90 deg\" }"),
    ];
    if survives {
        all.extend([
            ("twisted-4pi", "start = { kind = \"twisted\", angle = \"720 deg\" }"),
            ("random", "start = { kind = \"random\", size = \"10 mm\", seed = 1 }"),
            ("collapsed", "start = { kind = \"collapsed\", keep = \"\", perturbation = \"1 mm\", seed = 1 }"),
        ]);
    }
    let table = |text: &str| text.parse::<Table>().expect("valid TOML");
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
            ["Converged", "StepTooSmall", "Inverted", "NoEquilibrium", "ContactJammed", REFUSED]
                .map(String::from)
                .to_vec(),
        ),
        checks: vec![check],
        quick: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::from_text;

    fn mesh(text: &str) -> MeshSpec {
        from_text(Path::new("mesh.toml"), text, "").unwrap_or_else(|e| panic!("{e}"))
    }

    fn names(mesh: &MeshSpec) -> Vec<String> {
        meshes(mesh).and_then(|axis| axis.names).unwrap_or_default()
    }

    /// Twice the cells means 1.26 times the divisions, and the axis has the number of cells that whole divisions give.
    #[test]
    fn cells_of_a_grid_are_those_of_its_divisions() {
        let fine = mesh("grid = { kind = \"box\", size = [\"40 mm\", \"20 mm\", \"20 mm\"], divisions = [16, 8, 8] }");
        let divisions = |factor| sizes(&fine, factor)["mesh.grid.divisions"].clone();
        assert_eq!(divisions(2.0), Value::from(vec![20, 10, 10]));
        assert_eq!(divisions(0.5), Value::from(vec![13, 6, 6]));
        assert_eq!(names(&fine), ["1.95", "1", "0.46"]);
        let one = mesh("grid = { kind = \"box\", size = [\"40 mm\", \"20 mm\", \"20 mm\"], divisions = [1, 1, 1] }");
        assert!(meshes(&one).is_none());
    }

    #[test]
    fn edge_lengths_and_parts_are_scaled_too() {
        let sized = mesh(
            "body = \"beam\"\nsize = \"8 mm\"\n\
             [[grading]]\nfeature = \"tip\"\nlength = \"4 mm\"\ndistance = \"10 mm\"\n\
             [[part]]\nname = \"a\"\nbody = \"block\"\ncells = 600\n",
        );
        let set = sizes(&sized, 8.0);
        assert_eq!(set["mesh.size"].as_str(), Some("0.004 m"));
        assert_eq!(set["mesh.grading.0.length"].as_str(), Some("0.002 m"));
        assert_eq!(set["mesh.part.0.cells"].as_integer(), Some(4800));
        assert_eq!(names(&sized), ["2", "1", "0.5"]);
        assert!(meshes(&mesh("file = \"beam.vtk\"\nunit = \"m\"")).is_none());
    }
}
