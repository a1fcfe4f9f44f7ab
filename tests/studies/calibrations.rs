//! The inputs of stored results of calibrations: the body of a further curve, and the constants that a case of `[use]` waits for.

use crate::common::program::call;
use crate::common::stores::write_rod;
use flate2::{Compression, write::GzEncoder};
use serde_json::Value;
use std::io::Write;
use std::path::Path;

/// A bar that is pulled.
pub const SCENE: &str = r#"
[laws.rubber]
law = "neo_hookean"
mu = "80 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
displacement = { kind = "ramp", from = "0 mm", to = "6 mm", end = "1 s" }
components = "x"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"
[[probe]]
kind = "reaction"
region = "xmax"
"#;
pub const GRID: &str = r#"
[mesh]
grid = { kind = "box", size = ["30 mm", "10 mm", "10 mm"], divisions = [3, 1, 1] }
"#;
pub const ROD: &str = r#"
[mesh]
body = "rod"
size = "10 mm"
[mesh.regions]
xmin = { kind = "plane", point = ["0 mm", "0 mm", "0 mm"], normal = [1, 0, 0], tolerance = "0.1 mm" }
xmax = { kind = "plane", point = ["30 mm", "0 mm", "0 mm"], normal = [1, 0, 0], tolerance = "0.1 mm" }
"#;
pub const STUDY: &str = r#"
kind = "calibration"
question = "How stiff is the rubber?"
expectation = "100 kPa."
scene = "scene.toml"
tolerance = "5 %"
[calibration]
unknown = ["laws.rubber.mu"]
weighting = "absolute"
[[variant]]
name = "pull"
quantity = [{ name = "xmax_reaction_x_N", label = "force", symbol = "F", unit = "N" }]
[variant.measured]
file = "pull.csv"
x = { column = "u (mm)", unit = "mm", is = "xmax_x_displacement_m" }
y = { column = "F (N)", unit = "N", is = "xmax_reaction_x_N" }
"#;
/// A second curve, of a body that a mesher makes.
pub const CURVE: &str = r#"
[[variant.curve]]
name = "rod"
scene = "rod.toml"
members = { coarse = {}, fine = {} }
[variant.curve.measured]
file = "rod.csv"
x = { column = "u (mm)", unit = "mm", is = "xmax_x_displacement_m" }
y = { column = "F (N)", unit = "N", is = "xmax_reaction_x_N" }
"#;
pub const SIZES: &str = r#"
[[family]]
name = "mesh"
role = "sizes"
[family.members]
coarse = {}
fine = { "mesh.grid.divisions" = [6, 2, 2] }
"#;
/// The scene of the study as one that takes the law.
const USE: &str = r#"
[use]
scene = "scene.toml"
law = "rubber"
quantity = { name = "xmax_reaction_x_N", label = "force", symbol = "F", unit = "N" }
[use.members]
coarse = {}
fine = { "mesh.grid.divisions" = [6, 2, 2] }
"#;
/// The forces of a bar of about 100 kPa.
pub const PULL: &str = "u (mm),F (N)\n1.5,1.45\n3,2.84\n4.5,4.14\n6,5.40\n";
/// A mesher that copies a mesh which is there.
pub const MESHER: &str = r#"out=$(sed 's/.*"output":"\([^"]*\)".*/\1/')
cp "$DUROMETER_HOME/rod.msh.gz" "$out"
cat <<'END'
{"request":{"body":"rod","output":"x"},"cells":6,"nodes":8,"facets":12,"order":1,"h_m":0.008,
"regions":{"body":{"dim":3,"count":6}},"quality":{"sicn_min":0.5},"volume_m3":3e-6,"volume_cad_m3":null,"volume_error":null,
"edge_error_m":0.0,"paths":{},"versions":{"gmsh":"4.15.2","cgal":null},"wall_s":0.1,"length_m":0.0039}
END"#;

/// A mesh of a rod of 30 mm × `width` × 10 mm in six cells.
pub fn write_mesh(file: &Path, width: f64) {
    let place = |k: usize| {
        let along = |bit: usize, length: f64| if k >> bit & 1 == 0 { 0.0 } else { length };
        format!("{} {} {}\n", along(0, 0.03), along(1, width), along(2, 0.01))
    };
    let nodes: String = (1..=8).map(|n| format!("{n}\n")).chain((0..8).map(place)).collect();
    let cells = [[1, 2, 4], [1, 4, 3], [1, 3, 7], [1, 7, 5], [1, 5, 6], [1, 6, 2]];
    let cells: String = cells.iter().enumerate().map(|(k, [a, b, c])| format!("{} {a} {b} {c} 8\n", k + 1)).collect();
    let text = format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 8 1 8\n3 1 0 8\n{nodes}$EndNodes\n\
         $Elements\n1 6 1 6\n3 1 4 6\n{cells}$EndElements\n"
    );
    let mut packed = GzEncoder::new(vec![], Compression::default());
    packed.write_all(text.as_bytes()).expect("memory");
    std::fs::write(file, packed.finish().expect("memory")).expect("room");
}

/// Where the mesh of the second curve becomes another one, no case is kept, and the constants are those of a new folder.
#[test]
fn another_mesh_of_a_further_curve_makes_other_results() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    write_rod(at, MESHER);
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).expect("room");
    write("scene.toml", &format!("{GRID}{SCENE}"));
    write("rod.toml", &format!("{ROD}{SCENE}"));
    write("study.toml", &format!("{STUDY}{CURVE}{SIZES}"));
    write("pull.csv", PULL);
    write("rod.csv", "u (mm),F (N)\n1.5,1.50\n3,2.90\n4.5,4.25\n6,5.50\n");
    write_mesh(&at.join("rod.msh.gz"), 0.01);
    let run = |out: &str| call(at, &["run", "study.toml", "--out", out, "--jobs", "1"], 0).1;
    let listed = || call(at, &["cases", "study.toml", "--out", "r"], 0).0;
    let first = run("r");
    assert_eq!(first.lines().filter(|l| l.starts_with("done")).count(), 2, "{first}");
    assert!(listed().contains("2 cases: 2 stored"), "{}", listed());
    let law = |out: &str| std::fs::read_to_string(at.join(out).join("law.toml")).expect("a law");
    let of_first = law("r");
    let again = run("r");
    assert_eq!(again.lines().filter(|l| l.starts_with("kept")).count(), 2, "{again}");

    let made = std::fs::read_dir(at.join("meshes/cache")).expect("it was made").flatten().map(|entry| entry.path());
    let made: Vec<_> = made.filter(|path| path.extension().is_some_and(|end| end == "gz")).collect();
    assert_eq!(made.len(), 1, "{made:?}");
    write_mesh(&made[0], 0.02);
    assert!(listed().contains("2 cases: 2 outdated"), "{}", listed());
    let anew = run("r");
    assert_eq!(anew.lines().filter(|l| l.starts_with("done")).count(), 2, "{anew}");
    run("fresh");
    assert_eq!(law("r"), law("fresh"));
    assert!(law("r") != of_first, "{of_first}");

    // A mesh that is not there leaves open whether its results count
    std::fs::remove_file(&made[0]).expect("it was made");
    assert!(listed().contains("2 cases: 2 unmeshed"), "{}", listed());
    let meshed = call(at, &["mesh", "study.toml"], 0).0;
    assert_eq!(meshed.matches("radius ratio min").count(), 3, "{meshed}");
    assert!(listed().contains("2 cases: 2 outdated"), "{}", listed());
}

/// An archive of other constants takes the place of those of a folder, but does not bring the results that wait for them: those of the folder count no more, and its report is
/// marked.
#[test]
fn results_of_replaced_constants_do_not_count() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let write = |name: &str, text: &str| std::fs::write(at.join(name), text).expect("room");
    write("scene.toml", &format!("{GRID}{SCENE}"));
    write("study.toml", &format!("{STUDY}{SIZES}{USE}"));
    write("pull.csv", PULL);
    let run = |arguments: &[&str]| call(at, &[&["run", "study.toml", "--jobs", "1"], arguments].concat(), 0).1;
    run(&["--out", "a", "--only", "mesh"]);
    call(at, &["store", "export", "a", "a.tar.gz"], 0);
    write(
        "pull.csv",
        &PULL.replace("1.45", "2.9").replace("2.84", "5.68").replace("4.14", "8.28").replace("5.40", "10.8"),
    );
    run(&["--out", "r"]);
    call(at, &["store", "export", "r", "r.tar.gz"], 0);
    let summary = || -> Value { serde_json::from_str(&call(at, &["report", "r", "--json"], 0).0).expect("JSON") };
    let counted = || ["cases", "outdated"].map(|key| summary()[key].as_array().map_or(0, Vec::len));
    let marked = || {
        let has_mark = |name: &str| {
            std::fs::read_to_string(at.join("r").join(name)).expect("a report").contains("have changed since")
        };
        ["index.html", "summary.json"].map(has_mark)
    };
    assert_eq!(counted(), [4, 0]);
    // The same results change nothing
    call(at, &["store", "import", "r.tar.gz", "r", "--replace"], 0);
    assert_eq!((marked(), counted()), ([false; 2], [4, 0]));

    call(at, &["store", "import", "a.tar.gz", "r", "--replace"], 0);
    assert_eq!(marked(), [true; 2]);
    assert_eq!((counted(), marked()), ([2, 2], [false; 2]));
    // They come back with their constants, or are computed from the other ones
    call(at, &["store", "import", "r.tar.gz", "r", "--replace"], 0);
    assert_eq!((marked(), counted()), ([true; 2], [4, 0]));
    call(at, &["store", "import", "a.tar.gz", "r", "--replace"], 0);
    write("pull.csv", PULL);
    let anew = run(&["--out", "r"]);
    let computed = anew.lines().filter(|line| line.starts_with("done use-")).count();
    assert_eq!((computed, counted()), (2, [4, 0]), "{anew}");
}
