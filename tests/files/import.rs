//! `durometer import`: files of many formats, their tables and starter scenes.

use crate::common::program::{ROOT, durometer, ended};
use crate::common::tools;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::Order;
use durometer::mesh::disturb::add_slivers;
use durometer::mesh::generate::MeshStore;
use durometer::mesh::parts::{image, side_by_side};
use durometer::mesh::structured::block;
use durometer::scene::{Body, read_scene};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

fn mesher_is_missing() -> bool {
    let store = MeshStore::find().expect("the project");
    let works =
        Command::new(&store.python).args(["-c", "import gmsh, meshio"]).output().is_ok_and(|o| o.status.success());
    tools::is_missing(works, "the mesher (durometer doctor --setup)")
}

/// A folder with the same bar in many formats.
fn files() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let script = Path::new(ROOT).join("tests/files/import/make_files.py");
    let made = ended(Command::new(MeshStore::find().expect("the project").python).arg(script).arg(folder.path()));
    assert!(made.is_success(), "{}", made.err);
    folder
}

/// Rows of the table by file: format, cells, parts, regions, run.
fn rows(text: &str) -> BTreeMap<String, [String; 5]> {
    let field = |line: &str, from: usize, to: usize| {
        line.chars().skip(from).take(to - from).collect::<String>().trim().to_string()
    };
    let lines = text.lines().skip(1).filter(|l| l.chars().nth(32) == Some(' ') && !l.starts_with("refused: "));
    lines
        .map(|l| {
            let cells = [(33, 53), (54, 62), (63, 68), (69, 77), (78, 100)].map(|(a, b)| field(l, a, b));
            (field(l, 0, 32), cells)
        })
        .filter(|(_, row)| !row[1].is_empty())
        .collect()
}

/// Every file becomes a mesh of the same bar and runs under its own weight; damaged ones are refused with their reason.
#[test]
fn a_folder_of_files_in_many_formats_is_imported_and_run() {
    if mesher_is_missing() {
        return;
    }
    let folder = files();
    let output = durometer(ROOT, &["import", folder.path().to_str().expect("ASCII")]);
    let text = output.out;
    println!("{text}");
    assert_eq!(output.code, Some(3), "some files are bad: {}", output.err);
    let rows = rows(&text);
    let (bad, good): (Vec<_>, Vec<_>) = rows.iter().partition(|(name, _)| name.starts_with("bad-"));
    assert_eq!(bad.len(), 4);
    assert!(bad.iter().all(|(_, row)| row[4] == "refused"), "{bad:?}");
    let formats: std::collections::BTreeSet<&str> = good.iter().map(|(_, row)| row[0].as_str()).collect();
    assert!(good.len() >= 20 && formats.len() >= 8, "{} files of {formats:?}", good.len());
    for (name, row) in good {
        assert_eq!(row[4], "Converged", "{name}: {row:?}");
        assert_eq!(row[2], "1", "{name}: one body");
        assert!(row[1].parse::<usize>().is_ok_and(|cells| cells > 100), "{name}: {row:?}");
    }
    // 8 x 2 x 2 boxes: six tetrahedra of each hexahedron, three of each wedge, two of each pyramid
    for (name, cells) in [("bricks.vtk", 192), ("bricks.inp", 192), ("wedges.vtu", 192), ("pyramids.vtu", 384)] {
        assert_eq!(rows[name][1], cells.to_string(), "{name}");
    }
    let cells = &rows["new.msh"][1];
    for (name, row) in &rows {
        let same =
            ["new", "old", "between", "plain", "groups", "sets", "packed", "xml", "orphans", "doubled", "metres"];
        if same.iter().any(|start| name.starts_with(start)) {
            assert_eq!(&row[1], cells, "{name}");
        }
    }
    assert!(text.contains("passed over: notes.txt"), "{text}");
    for reason in
        ["this is text in UTF-16; save it as UTF-8", "its XML is not well formed", "the file is empty", "is inverted"]
    {
        assert!(text.contains(reason), "{reason}: {text}");
    }
}

/// One file in words, and the scene that is written for it.
#[test]
fn a_file_is_described_and_its_starter_scene_runs() {
    if mesher_is_missing() {
        return;
    }
    let folder = files();
    let at = |name: &str| folder.path().join(name).to_str().expect("ASCII").to_string();
    let describe = |name: &str, scene: &str| {
        let output = durometer(ROOT, &["import", &at(name), "--scene", &at(scene)]);
        assert_eq!(output.code, Some(0), "{name}: {}", output.err);
        (output.out, std::fs::read_to_string(at(scene)).expect("written"))
    };
    let (text, scene) = describe("sets.inp", "sets.toml");
    for line in [
        "format       Abaqus input",
        "bounds       (0, 0, 0) to (40, 10, 10) in units of the file",
        "unit         mm (guessed",
        "fixture      region root, by its name",
        "region       half: ",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
    assert!(scene.contains("region = \"root\"") && scene.contains("EXAMPLE"), "{scene}");
    let (text, scene) = describe("doubled.vtk", "doubled.toml");
    assert!(text.contains("nodes are at the place of another one") && scene.contains("merge = "), "{text}{scene}");
    let merge = "merge = \"1e-7 mm\"";
    assert!(text.contains(&format!("needs        {merge}")) && scene.contains(merge), "{text}{scene}");
    let (text, scene) = describe("wedges.vtu", "wedges.toml");
    assert!(text.contains("needs        split = true") && scene.contains("split = true"), "{text}{scene}");
    assert!(text.contains("fixture      the larger flat end along x"), "{text}");
    assert!(describe("metres.vtu", "metres.toml").1.contains("unit = \"m\""));
    assert!(describe("orphans.vtu", "orphans.toml").0.contains("defect       2 nodes belong to no cell"));
    assert!(describe("quadratic.msh", "quadratic.toml").1.contains("element = \"tet10\""));
    // The weight of the bar is what holds it.
    let out = at("out");
    let run = durometer(ROOT, &["simulate", &at("sets.toml"), "--out", &out, "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let record: serde_json::Value = serde_json::from_str(&run.out).expect("JSON");
    let force = record["probes"]["root_reaction_z_N"]["peak"].as_f64().expect("a number");
    let weight = 40e-3 * 10e-3 * 10e-3 * 1070.0 * 9.81;
    assert!((force.abs() / weight - 1.0).abs() < 1e-6, "{force} against {weight}");
    // A scene of a wrong unit is warned of.
    let scene = std::fs::read_to_string(at("sets.toml")).expect("there").replace("unit = \"mm\"", "unit = \"m\"");
    std::fs::write(at("huge.toml"), scene).expect("writable");
    let text = durometer(ROOT, &["check", &at("huge.toml")]).out;
    let warned =
        |text: &str| text.lines().any(|l| l.starts_with("warning ") && l.ends_with("unit = \"mm\" would be plausible"));
    assert!(warned(&text), "{text}");
    assert!(warned(&durometer(ROOT, &["import", &at("sets.inp"), "--unit", "m"]).out));
}

/// Two plates of 40 × 40 × 2 mm with one cell across, some of them nearly flat, one `above` the other \[m\].
fn plates(file: &Path, above: f64) {
    let mut plate = block(8, 8, 1, 0.04, 0.04, 0.002, Order::Linear);
    add_slivers(&mut plate, 1, 0.01, 0.5_f64.to_radians());
    let second = image(&plate, &Mat3::identity(), &Vec3::new(0.0, 0.0, above));
    let both = side_by_side(&[("a".into(), plate), ("b".into(), second)]).expect("two parts");
    let points: String =
        both.points.iter().map(|p| format!("{:e} {:e} {:e}\n", p.x * 1e3, p.y * 1e3, p.z * 1e3)).collect();
    let cells: String = both.cells.chunks(4).map(|c| format!("4 {} {} {} {}\n", c[0], c[1], c[2], c[3])).collect();
    let (nodes, count) = (both.points.len(), both.cell_count());
    let head = "# vtk DataFile Version 3.0\nplates\nASCII\nDATASET UNSTRUCTURED_GRID";
    let (values, kinds) = (5 * count, "10\n".repeat(count));
    let text =
        format!("{head}\nPOINTS {nodes} double\n{points}CELLS {count} {values}\n{cells}CELL_TYPES {count}\n{kinds}");
    std::fs::write(file, text).expect("writable");
}

/// One body in millimetres and in metres: every unit is guessed from the size, and the table is followed by a note that they differ.
#[test]
fn guessed_units_of_a_folder_that_differ_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bar = |name: &str, size: f64| {
        let points = [[0, 0, 0], [40, 0, 0], [0, 10, 0], [0, 0, 10]].map(|p| p.map(|c| size * f64::from(c)));
        let points: String = points.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
        let head = "# vtk DataFile Version 3.0\nbar\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n";
        let text = format!("{head}{points}CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n");
        std::fs::write(folder.path().join(name), text).expect("writable");
    };
    let note = |more: &[&str]| {
        let output = durometer(ROOT, &[&["import", folder.path().to_str().expect("ASCII")], more].concat());
        let said = output.err;
        said.lines().find(|line| line.starts_with("note: the guessed units")).map(String::from)
    };
    bar("one.vtk", 1.0);
    bar("two.vtk", 1.0);
    assert_eq!(note(&[]), None);
    bar("three.vtk", 1e-3);
    let said = note(&[]).expect("a note");
    assert!(said.contains("differ: m (three.vtk) and mm (one.vtk and two.vtk); ") && said.contains("--unit"), "{said}");
    assert_eq!(note(&["--unit", "mm"]), None, "nothing is guessed");
}

/// Nearly flat cells, a wall of one cell and a gap: every command that takes the mesh says the same of it, and a contact leaves no word of the gap.
#[test]
fn commands_agree_on_the_limits_of_a_mesh() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("ASCII").to_string();
    plates(&folder.path().join("plates.vtk"), 0.00201);
    let limits = |arguments: &[&str]| {
        let output = durometer(ROOT, arguments);
        let said = output.said();
        assert_eq!(output.code, Some(0), "{arguments:?}: {said}");
        let kinds = ["warning", "note"].map(|kind| {
            let of_kind = said.lines().filter_map(|line| line.strip_prefix(kind));
            let texts = of_kind.map(|text| text.trim_start_matches(':').trim().to_string());
            texts
                .filter(|text| {
                    ["nearly flat", "thinnest wall", "nothing joins", "both fill"].iter().any(|w| text.contains(w))
                })
                .collect()
        });
        kinds.map(|texts: Vec<String>| texts)
    };
    let [warnings, notes] = limits(&["import", &at("plates.vtk"), "--scene", &at("scene.toml")]);
    assert!(warnings[0].contains("nearly flat, with dihedral angles from 0.50 to "), "{warnings:?}");
    let wall = "1.0 cells across the thinnest wall, which is 2.0000 mm thick, are too few to show how it bends (at least 2); refine the walls: `levels = 1` splits each cell into eight";
    assert!(warnings.len() == 2 && warnings[1] == wall, "{warnings:?}");
    let gap = "two parts of the body face each other across a gap of up to 0.01 mm over 1600.0000 mm^2, at (";
    assert!(notes.len() == 1 && notes[0].starts_with(gap), "{notes:?}");
    let remedy = "have no common facet there: nothing joins them; merge = \"0.011 mm\" in [mesh] makes them one, or declare a contact between them";
    assert!(notes[0].ends_with(remedy), "{notes:?}");
    let scene = at("scene.toml");
    for arguments in
        [&["check", &scene][..], &["mesh", &scene], &["simulate", &scene, "--no-view", "--out", &at("out")]]
    {
        assert_eq!(limits(arguments), [warnings.clone(), notes.clone()], "{arguments:?}");
    }
    // The remedy is one
    assert!(limits(&["check", &scene, "--set", "mesh.merge=0.011 mm"])[1].is_empty());
    let contact = "\n[mesh.regions.low]\nkind = \"component\"\npick = \"facets\"\nwhich = 1\n[mesh.regions.high]\nkind = \"component\"\n\
                   pick = \"facets\"\nwhich = 2\n[[contact]]\nregion = \"low\"\nobstacle = { kind = \"region\", region = \"high\" }\n\
                   response = \"barrier\"\nfriction = 0.0\n";
    let text = std::fs::read_to_string(&scene).expect("written") + contact;
    std::fs::write(at("contact.toml"), text).expect("writable");
    assert_eq!(limits(&["check", &at("contact.toml")]), [warnings.clone(), vec![]]);
    plates(&folder.path().join("plates.vtk"), 0.0019);
    let [overlapping, _] = limits(&["check", &scene]);
    assert!(overlapping.iter().any(|w| w.contains("both fill")), "{overlapping:?}");
}

/// A box has meshes of 24 cells, and none of a few more: where less is asked for, the least number is taken.
#[test]
fn a_shape_without_a_mesh_above_the_least_becomes_a_project() {
    if mesher_is_missing() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("ASCII").to_string();
    let script = "import sys, gmsh\ngmsh.initialize()\ngmsh.model.occ.addBox(0, 0, 0, 20, 20, 20)\n\
                  gmsh.model.occ.synchronize()\ngmsh.write(sys.argv[1])\n";
    let python = MeshStore::find().expect("the project").python;
    assert!(Command::new(python).args(["-c", script, &at("box.step")]).output().is_ok_and(|o| o.status.success()));
    let made = durometer(ROOT, &["new", &at("box.step"), &at("project"), "--cells", "3"]);
    assert_eq!(made.code, Some(0), "{}", made.err);
    let scene: toml::Table = std::fs::read_to_string(at("project/scene.toml")).expect("written").parse().expect("TOML");
    assert_eq!(scene["mesh"]["cells"].as_integer(), Some(24));
}

/// Faces of a CAD file that bound no solid are told by every command that takes its mesh.
#[test]
fn faces_of_no_solid_are_told() {
    if mesher_is_missing() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("ASCII").to_string();
    let script = "import sys, gmsh\ngmsh.initialize()\ngmsh.model.occ.addBox(0, 0, 0, 10, 10, 10)\n\
                  gmsh.model.occ.addRectangle(0, 0, 20, 10, 10)\ngmsh.model.occ.synchronize()\ngmsh.write(sys.argv[1])\n";
    let python = MeshStore::find().expect("the project").python;
    assert!(Command::new(python).args(["-c", script, &at("a.step")]).output().is_ok_and(|o| o.status.success()));
    let told = "a face bounds no solid and is left out, one from (0, 0, 20) to (10, 10, 20) mm; only solids are meshed";
    for arguments in [&["import", &at("a.step"), "--scene", &at("a.toml")][..], &["check", &at("a.toml")]] {
        let text = durometer(ROOT, arguments).out;
        assert!(text.lines().any(|line| line.starts_with("note ") && line.ends_with(told)), "{arguments:?}: {text}");
    }
}

#[test]
fn what_cannot_be_imported_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("ASCII").to_string();
    std::fs::write(at("a.txt"), "hello").expect("writable");
    for (arguments, says) in [
        (vec!["import".to_string(), at("a.txt")], "neither the content nor the name is that of a known format"),
        (vec!["import".into(), at("absent.msh")], "cannot be read"),
        (vec!["import".into(), at(""), "--scene".into(), at("b.toml")], "--scene needs one file"),
        (vec!["mesh".into(), "tests/bad/good/boxes.msh".into()], "this is a mesh or a body (MSH), not a scene"),
        (vec!["check".into(), "tests/bad/good/boxes-order2-binary.vtk".into()], "durometer import"),
    ] {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let output = durometer(ROOT, &arguments);
        let said = output.err;
        assert_eq!(output.code, Some(2), "{arguments:?}: {said}");
        assert!(said.contains(says), "{arguments:?}: {said}");
        assert!(said.matches("a.txt").count() <= 1 && said.matches("absent.msh").count() <= 1, "{said}");
    }
    std::fs::write(
        at("cut.vtk"),
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n0 0\n",
    )
    .expect("writable");
    let said = durometer(ROOT, &["import", &at("cut.vtk")]).err;
    assert!(said.contains("the file ends where") && said.matches("cut.vtk").count() == 1, "{said}");
}

/// Counts the cells of a file in a box as SOFA's BoxROI does, with meshio alone: `strict` wants all corners inside, otherwise the mean of the corners.
const BOX_ROI: &str = "
import json, sys
import meshio, numpy as np
raw = meshio.read(sys.argv[1])
points, cells = raw.points.astype(float), np.concatenate([c.data[:, :4] for c in raw.cells if c.type in ('tetra', 'tetra10')])
corners = points[np.unique(cells)]
low, high = corners.min(axis=0), corners.max(axis=0)
least, most = low - 0.05 * (high - low), low + 0.61 * (high - low)
inside = lambda p: ((p >= least) & (p <= most)).all(axis=-1)
strict, centroid = inside(points[cells]).all(axis=1), inside(points[cells].mean(axis=1))
print(json.dumps([list(least), list(most), int(strict.sum()), int(centroid.sum())]))
";

/// The cells of a box by the rules `all` and `centroid` are those of SOFA's BoxROI with `strict` and without; the number by the second.
#[track_caller]
fn same_box_as_sofa(file: &Path, unit: &str) -> u64 {
    let python = MeshStore::find().expect("the project").python;
    let counted = ended(Command::new(python).args(["-c", BOX_ROI]).arg(file));
    assert!(counted.is_success(), "{}: {}", file.display(), counted.err);
    // meshio may say something before
    let line = counted.out.lines().last().unwrap_or_default().to_string();
    let (least, most, strict, centroid): ([f64; 3], [f64; 3], u64, u64) = serde_json::from_str(&line).expect("JSON");
    let corner = |p: [f64; 3]| p.map(|x| format!("\"{x:?} {unit}\"")).join(", ");
    let region = |name: &str, rule: &str| {
        let (least, most) = (corner(least), corner(most));
        format!("mesh.regions.{name}={{kind=\"box\",min=[{least}],max=[{most}],pick=\"cells\",rule=\"{rule}\"}}")
    };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("scene.toml").to_str().expect("ASCII").to_string();
    let made = durometer(ROOT, &["import", file.to_str().expect("UTF-8"), "--unit", unit, "--scene", &scene]);
    assert!(made.is_success(), "{}: {}", file.display(), made.err);
    let changes = [region("roi_strict", "all"), region("roi_middle", "centroid")];
    let text = durometer(ROOT, &["check", &scene, "--set", &changes[0], "--set", &changes[1]]).out;
    let cells = |name: &str| -> u64 {
        let line = text.lines().find(|l| l.trim_start().starts_with(name)).unwrap_or_else(|| panic!("{name}: {text}"));
        line.split_whitespace().nth(3).and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{line}"))
    };
    assert_eq!((cells("roi_strict"), cells("roi_middle")), (strict, centroid), "{}", file.display());
    centroid
}

/// In files of eight formats a box holds the same cells by the rules of this program and by those of SOFA.
#[test]
fn boxes_hold_the_cells_of_sofa() {
    if mesher_is_missing() {
        return;
    }
    let folder = files();
    let names = [
        "new.vtk",
        "plain.mesh",
        "plain.inp",
        "plain.bdf",
        "plain.vol",
        "plain.su2",
        "plain.avs",
        "plain.vtu",
        "quadratic.msh",
    ];
    for name in names {
        let count = same_box_as_sofa(&folder.path().join(name), "mm");
        println!("{name}: {count} cells");
        assert!(count > 10, "{name}: {count}");
    }
}

/// The robots of the SoftRobots examples: every file is imported, and the volume meshes run under their own weight.
#[test]
#[ignore = "reads public data outside of the project, from the folder that DUROMETER_SHARED names"]
fn public_robots_are_imported_and_run() {
    let output = durometer(ROOT, &["import", tools::shared("data/robots").to_str().expect("UTF-8")]);
    let text = output.out;
    println!("{text}");
    let rows = rows(&text);
    for (name, cells) in
        [("Springy.vtu", 2743), ("diamond.vtk", 4147), ("pneunetCut.vtk", 0), ("soft-finger-design.msh", 560)]
    {
        let row = &rows[name];
        assert!(cells == 0 || row[1] == cells.to_string(), "{name}: {row:?}");
        assert_eq!(row[4], "Converged", "{name}: {row:?}");
    }
    for name in ["Springy.vtu", "diamond.vtk", "pneunetCut.vtk"] {
        println!("{name}: {} cells in the box", same_box_as_sofa(&tools::shared("data/robots").join(name), "mm"));
    }
}

/// A comb of many thin teeth as STL: no mesh of it has so few cells as a project asks for at first. The project takes the number that comes nearest, and
/// its study finer ones.
#[test]
fn a_shape_that_needs_many_cells_becomes_a_project() {
    const TEETH: usize = 130;
    if mesher_is_missing() {
        return;
    }
    // Rectangles of the outline, [x, x + 1] × [0, 1] and every second [x, x + 1] × [1, 3], between z = 0 and z = 2
    let is_filled = |x: i64, y: i64| (0..2 * TEETH as i64 - 1).contains(&x) && (y == 0 || y == 1 && x % 2 == 0);
    let height = |y: i64| [0, 1, 3][y as usize];
    let mut text = "solid comb\n".to_string();
    let mut quad = |corners: [[i64; 3]; 4]| {
        for triangle in [[0, 1, 2], [0, 2, 3]] {
            text += "facet normal 0 0 0\nouter loop\n";
            triangle.map(|k| corners[k]).iter().for_each(|[x, y, z]| text += &format!("vertex {x} {y} {z}\n"));
            text += "endloop\nendfacet\n";
        }
    };
    for (x, y) in (0..2 * TEETH as i64 - 1).flat_map(|x| [(x, 0), (x, 1)]).filter(|&(x, y)| is_filled(x, y)) {
        let ([x0, x1], [y0, y1]) = ([x, x + 1], [height(y), height(y + 1)]);
        quad([[x0, y0, 0], [x0, y1, 0], [x1, y1, 0], [x1, y0, 0]]);
        quad([[x0, y0, 2], [x1, y0, 2], [x1, y1, 2], [x0, y1, 2]]);
        let sides = [
            ((x, y - 1), [[x0, y0], [x1, y0]]),
            ((x + 1, y), [[x1, y0], [x1, y1]]),
            ((x, y + 1), [[x1, y1], [x0, y1]]),
            ((x - 1, y), [[x0, y1], [x0, y0]]),
        ];
        for (_, [a, b]) in sides.into_iter().filter(|((x, y), _)| !is_filled(*x, *y)) {
            quad([[a[0], a[1], 0], [b[0], b[1], 0], [b[0], b[1], 2], [a[0], a[1], 2]]);
        }
    }
    text += "endsolid comb\n";
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (file, project) = (folder.path().join("comb.stl"), folder.path().join("comb"));
    std::fs::write(&file, text).expect("room");
    let [file, at] = [&file, &project].map(|path| path.to_str().expect("ASCII"));
    let made = durometer(ROOT, &["new", file, at, "--unit", "mm"]);
    assert_eq!(made.code, Some(0), "{}", made.err);
    let table = |name: &str| -> toml::Table {
        std::fs::read_to_string(project.join(name)).expect("written").parse().expect("TOML")
    };
    let cells = table("scene.toml")["mesh"]["cells"].as_integer().expect("a number");
    assert!(cells > 2200, "{cells}: the first number of cells would do");
    // What does not lock, as in the study, and no pressure, as the body is solid
    let scene = table("scene.toml");
    assert_eq!(scene["mesh"]["element"].as_str(), Some("tet10"));
    assert_eq!(scene["effect"][0]["formulation"].as_str(), Some("mixed"));
    let text = std::fs::read_to_string(project.join("scene.toml")).expect("written");
    assert!(!text.contains("mesh.regions.hollow"), "{text}");
    let members = &table("study.toml")["family"][0]["members"];
    let sizes: Vec<i64> =
        members.as_table().expect("sizes").values().filter_map(|set| set["mesh.cells"].as_integer()).collect();
    assert_eq!(sizes, [cells, 5 * cells / 2, 6 * cells]);
    let checked = durometer(ROOT, &["check", project.join("scene.toml").to_str().expect("ASCII")]);
    assert_eq!(checked.code, Some(0), "{}", checked.err);
}

/// `levels` splits the cells of a volume mesh within the facets that it has, and no more of them than fit.
#[test]
fn a_volume_mesh_is_refined_by_levels() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/scene.toml");
    let body = |levels: u32| {
        let (spec, _) = read_scene(&file, &[("mesh.levels".into(), i64::from(levels).into())]).expect("a scene");
        Body::load(&file, &spec.mesh, &mut |_| {})
    };
    let [given, fine] = [0, 2].map(|levels| body(levels).expect("a sound mesh"));
    assert_eq!(fine.mesh.cell_count(), 64 * given.mesh.cell_count());
    assert!((fine.mesh.volume() / given.mesh.volume() - 1.0).abs() < 1e-12);
    assert_ne!(fine.sha256, given.sha256);
    for (name, region) in &given.mesh.regions {
        let own = &fine.mesh.regions[name];
        let (area, before) = (fine.mesh.region_area(&own.facets), given.mesh.region_area(&region.facets));
        assert!((area - before).abs() <= 1e-12 * before, "{name}");
    }
    assert!(fine.notes.iter().any(|note| note.contains("is split into 64; the boundary stays")), "{:?}", fine.notes);
    assert!(body(8).expect_err("too many").to_string().contains("each makes eight cells of one, of "));
    assert!(body(9).expect_err("too many").to_string().contains("take at most 8"));
}

/// Rounding about zero is zero in the bounds, and the end that is held is told as in the scene.
#[test]
fn bounds_and_fixture_are_those_of_the_scene() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name).to_str().expect("ASCII").to_string();
    let head = "# vtk DataFile Version 3.0\nbar\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n";
    let points = "-1.77635684e-15 0 0\n40 0 0\n0 10 0\n0 -1e-15 10\n";
    std::fs::write(at("bar.vtk"), format!("{head}{points}CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n")).expect("room");
    let said = durometer(ROOT, &["import", &at("bar.vtk"), "--scene", &at("scene.toml")]).out;
    assert!(said.contains("bounds       (0, 0, 0) to (40, 10, 10) in units of the file"), "{said}");
    assert!(said.contains("fixture      the larger flat end along x\n"), "{said}");
    let scene = std::fs::read_to_string(at("scene.toml")).expect("a scene");
    assert!(scene.contains("# EXAMPLE: the larger flat end along x\n"), "{scene}");
    // A volume mesh has its cells
    let refused = durometer(ROOT, &["new", &at("bar.vtk"), &at("project"), "--cells", "5000"]);
    assert!(!refused.is_success(), "{}", refused.out);
    assert!(refused.err.contains("it is a volume mesh, which is taken over; leave"), "{}", refused.err);
}
