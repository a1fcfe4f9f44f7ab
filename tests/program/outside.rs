//! One of a kind that is written outside of the library: a body, a figure, a kind of study. Laws are in `own_law.rs`,
//! effects and probes in `examples/`. That a kind in `src/` is one file or folder and one line is a test of
//! `tests/structure`.

use crate::common::tools;
use durometer::mesh::generate::MeshStore;
use durometer::mesh::generate::body::ParametricBody;
use durometer::prelude::*;
use durometer::report::canvas::{INK, figure, line, mm};
use durometer::report::export::save;
use durometer::report::figure::Figure;
use durometer::report::plot::{Axis, Plot};
use durometer::report::table::{Table, headings};
use durometer::study::analysis::Analysis;
use durometer::study::content::Content;
use durometer::study::kind::{Expansion, Kind, StudyKind, StudyScope};
use durometer::study::spec::{FamilySpec, VariantSpec};
use durometer::study::store::results::{self, Results};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;

const BODY: &str = r#"
version = 1
summary = "Wedge with its base on y = 0."
[parameters]
base = { default = "30 mm", meaning = "length of the base" }
top = { default = "15 mm", meaning = "length of the top" }
[regions]
body = { dim = 3, meaning = "the whole wedge" }
root = { dim = 2, meaning = "the face x = 0" }
other = { dim = 2, meaning = "the other faces" }
"#;

const GEOMETRY: &str = r#"
import gmsh
from meshgen.geometry import Geometry, plane_rules, sort_faces

def build(params):
    volume = gmsh.model.occ.addWedge(0, 0, 0, params["base"], 20.0, 20.0, ltx=params["top"])
    gmsh.model.occ.synchronize()
    regions = sort_faces([volume], plane_rules({"root": (0, 0.0)}), rest="other")
    return Geometry([volume], {"body": (3, [volume]), "root": regions["root"], "other": regions["other"]})
"#;

/// A folder with a body of its own next to the mesher of the project.
fn home_with_a_wedge() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let meshes = folder.path().join("meshes");
    std::fs::create_dir_all(meshes.join("wedge")).expect("writable");
    std::fs::write(meshes.join("wedge/body.toml"), BODY).expect("writable");
    std::fs::write(meshes.join("wedge/geometry.py"), GEOMETRY).expect("writable");
    let project = Path::new(env!("CARGO_MANIFEST_DIR"));
    std::os::unix::fs::symlink(project.join("meshes/meshgen"), meshes.join("meshgen")).expect("writable");
    std::os::unix::fs::symlink(project.join(".venv"), folder.path().join(".venv")).expect("writable");
    folder
}

const WEDGE_SCENE: &str = r#"
[mesh]
body = "wedge"
size = "5 mm"
parameters = { top = "10 mm" }
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "root"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#;

/// A folder with `body.toml` and `geometry.py` is a body: no other file names it.
#[test]
fn a_body_is_a_folder() {
    let folder = home_with_a_wedge();
    let home = folder.path().to_path_buf();
    let declared = ParametricBody::load(&home, "wedge").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(declared.parameters.len(), 2);

    let project = MeshStore::find().unwrap_or_else(|e| panic!("{e}"));
    let store = MeshStore::of_project(home, project.python);
    let is_sound = store.mesher().diagnose().iter().all(|check| check.ok || check.optional);
    if tools::is_missing(is_sound, "the mesher (durometer doctor --setup)") {
        return;
    }
    let builder = SceneBuilder::parse(WEDGE_SCENE).unwrap_or_else(|e| panic!("{e}"));
    let scene = builder.store(store).build().unwrap_or_else(|e| panic!("{e}"));
    // Mean of the edges 30 mm and 10 mm, times 20 mm times 20 mm
    let volume = scene.body.mesh.volume();
    assert!((volume / 8e-6 - 1.0).abs() < 1e-9, "{volume} m³");
    assert_eq!(scene.run().status, Status::Converged);
}

/// A parabola with its axes.
fn parabola() -> Figure {
    let x: Vec<f64> = (0..=20).map(|k| 0.1 * f64::from(k)).collect();
    let y: Vec<f64> = x.iter().map(|x| x * x).collect();
    let svg = figure(80.0, 60.0, "", |area| {
        let frame = [mm(15.0), mm(5.0), mm(75.0), mm(48.0)];
        let axis = |values: &[f64], label| Axis::linear(values.iter().copied(), label);
        let plot = Plot { area, frame, x: axis(&x, "stretch"), y: axis(&y, "energy") };
        plot.grid();
        line(area, &plot.path(&x, &y), INK, 10);
        plot.axes(true);
    });
    Figure { name: "parabola".into(), svg, caption: "Energy against stretch.".into() }
}

/// A figure is a function: the toolkit writes it in every format.
#[test]
fn a_figure_is_a_function() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let figure = parabola();
    save(folder.path(), &figure).unwrap_or_else(|e| panic!("{e}"));
    let bytes = |ending: &str| std::fs::read(folder.path().join(format!("parabola.{ending}"))).expect("written");
    assert!(String::from_utf8_lossy(&bytes("svg")).contains("stretch"));
    assert!(bytes("png").starts_with(b"\x89PNG") && bytes("pdf").starts_with(b"%PDF"));
}

/// A kind of study that counts its cases and draws a parabola.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct Count {
    #[serde(rename = "variant")]
    variants: Vec<VariantSpec>,
    #[serde(rename = "family")]
    families: Vec<FamilySpec>,
}

impl StudyKind for Count {
    const NAME: &'static str = "count";
    type Details = ();
    type Findings = usize;

    fn expand(self, _: &Path, _: &Path) -> Result<Expansion<()>, SceneError> {
        Ok(Expansion::new(self.variants, self.families, ()))
    }

    fn analyse(results: &Results, (): &()) -> Analysis<usize> {
        Analysis {
            tolerance: results.study.tolerance,
            found: results.cases.len(),
            incomplete: vec![],
            warnings: vec![],
            verdict: String::new(),
        }
    }

    fn report(_: &Results, analysis: &Analysis<usize>) -> Content {
        let count = analysis.found;
        let answer = Table {
            name: "count",
            caption: "Number of cases.".into(),
            columns: headings(&[("Cases", "", true)]),
            rows: vec![vec![count.to_string()]],
            pick: None,
        };
        Content {
            verdict: format!("{count} cases."),
            supported: true,
            facts: vec![],
            sentences: vec![],
            warnings: vec![],
            analysis: serde_json::Map::new(),
            answer: ("Count", answer),
            tables: vec![],
            folded: vec![],
            extension: None,
            figures: vec![Ok(parabola())],
            claims: vec![],
            decisions: BTreeMap::new(),
            files: vec![],
            outcomes: BTreeMap::new(),
            without_result: None,
            errors: String::new(),
            search: vec![],
        }
    }
}

const COUNT_SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [2, 1, 1] }
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
[[probe]]
kind = "energy"
"#;

const COUNT_STUDY: &str = r#"
question = "How many?"
expectation = "Two."
scene = "scene.toml"
tolerance = "5 %"
[[variant]]
name = "one"
label = "one"
quantity = [{ name = "elastic_J", label = "elastic energy", symbol = "W", unit = "J" }]
[[family]]
name = "sizes"
role = "sizes"
[family.members]
coarse = {}
fine = { "mesh.grid.divisions" = [4, 2, 2] }
"#;

/// A type that implements `StudyKind` reads its keys, analyses stored cases and reports them; `KINDS` has one line for it.
#[test]
fn a_kind_of_study_is_a_type() {
    let kind = Kind::of::<Count>();
    let file = Path::new("study.toml");
    let expansion = (kind.expand)(file, COUNT_STUDY, StudyScope::Whole).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((expansion.variants.len(), expansion.families.len()), (1, 1));
    let mistake =
        (kind.expand)(file, &format!("colour = 1\n{COUNT_STUDY}"), StudyScope::Whole).err().expect("an unknown key");
    assert!(mistake.to_string().contains("colour"), "{mistake}");

    // Cases that a kind of the registry has run
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("scene.toml"), COUNT_SCENE).expect("writable");
    let file = folder.path().join("study.toml");
    std::fs::write(&file, format!("kind = \"cost\"\n{COUNT_STUDY}")).expect("writable");
    let study = Study::read(&file, &[]).unwrap_or_else(|e| panic!("{e}"));
    let stop = AtomicBool::new(false);
    let options = StudyOptions { jobs: 1, ..StudyOptions::new(&stop) };
    let out = folder.path().join("results");
    run_study(&study, &out, &options, &()).unwrap_or_else(|e| panic!("{e}"));
    let stored = results::read(&out).unwrap_or_else(|e| panic!("{e}"));
    let content = (kind.report)(&stored).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(content.verdict, "2 cases.");
    assert_eq!(content.figures.len(), 1);
}
