//! Cells across walls, and studies through the program whose evidence supports no verdict: a wall of one row of cells at every size, and one mesh too few.
//! The report says which mesh is missing, and `run --extend` adds it.

use crate::common::program::{ROOT, ended, without_mesher};
use durometer::math::statistics::smaller;
use durometer::math::tensor::Vec3;
use durometer::mesh::Order;
use durometer::mesh::curved::mapped_block;
use durometer::mesh::disturb::distort;
use durometer::mesh::notch::thinnest_below_notches;
use durometer::mesh::structured::block;
use durometer::mesh::wall::thinnest;
use durometer::scene::limits_of_mesh;
use serde_json::Value;
use std::path::Path;

const THIN: &str = "tests/thin_wall/study.toml";

/// `summary.json` and what was said during the run.
fn run(study: &str, out: &str, more: &[&str]) -> (Value, String) {
    let output = ended(without_mesher(ROOT, &[&["run", study, "--out", out, "--json"], more].concat()));
    let errors = output.err;
    assert_eq!(output.code, Some(0), "{errors}");
    (serde_json::from_str(&output.out).expect("JSON"), errors)
}

fn folder() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().to_str().expect("UTF-8").to_string();
    (folder, path)
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_else(|| panic!("{key} in {value}"))
}

/// The three meshes claim a deflection with a bar of 33 %, of which beam theory has four times as much: w = 3 q l⁴/(2 E h³).
#[test]
fn a_wall_of_one_row_of_cells_gets_no_verdict() {
    let (_keep, out) = folder();
    let (summary, _) = run(THIN, &out, &[]);
    let found = &summary["analysis"]["xmax_z_m"]["load"]["families"]["sizes"];
    let (f, u) = (found["extrapolated"].as_f64().expect("f*"), found["uncertainty"].as_f64().expect("U"));
    let truth = -1.5 * 2.0 * 0.04f64.powi(4) / (1e6 * 0.002f64.powi(3));
    println!("f* = {f:.4e} ± {u:.1e} m, beam theory {truth:.4e} m; {}", text(&summary, "verdict"));
    assert!(
        (f - truth).abs() > 3.0 * u,
        "without the count of cells the claim would be wrong: {f} ± {u}, truth {truth}"
    );
    let errors = summary["analysis"]["xmax_z_m"]["load"]["errors"].as_array().expect("errors");
    let best = errors.iter().filter_map(|e| e["bar"].as_f64()).fold(f64::INFINITY, smaller);
    assert!(best < 0.4, "and within the tolerance: {best}");
    assert!(text(&summary, "verdict").starts_with("No verdict"), "{}", text(&summary, "verdict"));
    assert!(text(&summary, "verdict").contains("1.0, 1.0, 1.0 cells across the thinnest wall"));
    let mesh = &summary["cases"][0]["mesh"];
    assert_eq!(mesh["wall_cells"], 1.0);
    assert!((mesh["wall_m"].as_f64().expect("a thickness") - 0.002).abs() < 1e-8);
    // The mesh that is asked for has more cells across the wall, too
    let asked = &summary["extension"]["set"]["mesh.grid.divisions"];
    assert_eq!(asked[2], 2, "{}", summary["extension"]);
}

/// Three meshes of a pneumatic chamber, 4, 2.9 and 2 mm, agree within 3 % with each other, as if they converged; 25 776 cells of 0.75 mm, two across
/// the wall, give 7.843°, 4 % more than the finest.
#[test]
fn a_chamber_whose_walls_are_one_cell_thick_gets_no_verdict() {
    let (_keep, out) = folder();
    let (summary, _) = run("tests/thin_wall/chamber-study.toml", &out, &[]);
    let found = &summary["analysis"]["bending_angle_deg"]["pressure"]["families"]["sizes"];
    let (f, u) = (found["extrapolated"].as_f64().expect("f*"), found["uncertainty"].as_f64().expect("U"));
    println!("f* = {f:.4}° ± {u:.2}°; {}", text(&summary, "verdict"));
    assert!((f - 7.843).abs() < u, "{f} ± {u}");
    assert!(text(&summary, "verdict").starts_with("No verdict"), "{}", text(&summary, "verdict"));
    let wall = "1.0, 1.0, 1.0 cells across the thinnest wall";
    assert!(text(&summary, "verdict").contains(wall), "{}", text(&summary, "verdict"));
}

#[test]
fn a_refused_study_is_extended_by_the_mesh_that_it_asks_for() {
    let (keep, _) = folder();
    let study = keep.path().join("study.toml");
    let scene = Path::new(ROOT).join("tests/thin_wall/scene.toml");
    let thick = std::fs::read_to_string(scene).expect("the scene").replace("\"2 mm\"]", "\"10 mm\"]");
    std::fs::write(keep.path().join("scene.toml"), thick).expect("writable");
    let two = std::fs::read_to_string(Path::new(ROOT).join(THIN)).expect("the study");
    let (head, _) = two.split_once("a = {").expect("members");
    let members = "a = { \"mesh.grid.divisions\" = [4, 2, 2] }\nb = { \"mesh.grid.divisions\" = [8, 4, 4] }\n";
    std::fs::write(&study, format!("{head}{members}").replace("40 %", "8 %")).expect("writable");
    let (study, results) = (study.to_str().expect("UTF-8"), keep.path().join("results"));
    let results_text = results.to_str().expect("UTF-8");

    let (before, _) = run(study, results_text, &[]);
    assert!(text(&before, "verdict").starts_with("No verdict"), "{}", text(&before, "verdict"));
    assert!(text(&before, "verdict").contains("durometer run STUDY --extend"), "{}", text(&before, "verdict"));
    // In a terminal it is the command for this study
    let said = ended(without_mesher(ROOT, &["run", study, "--out", results_text])).out;
    assert!(said.contains(&format!("`durometer run {study} --extend`")), "{said}");
    let stamp = |id: &str| std::fs::read_to_string(results.join(format!("cases/{id}.json"))).expect("a record");
    let kept = stamp("sizes-load-b");
    let (after, said) = run(study, results_text, &["--extend"]);
    println!("{said}{}\n{}", text(&before, "verdict"), text(&after, "verdict"));
    let member = text(&before["extension"], "member");
    assert!(said.contains("added: ") && said.contains(member), "{said}");
    let id = format!("sizes-load-{member}");
    let case = after["cases"].as_array().expect("cases").iter().find(|c| c["id"] == id.as_str()).expect("the new case");
    let (asked, has) = (before["extension"]["cells"].as_f64(), case["mesh"]["cells"].as_f64());
    assert!(
        (asked.expect("cells") / has.expect("cells") - 1.0).abs() < 0.01,
        "{asked:?} cells were announced, {has:?} are there"
    );
    assert_eq!(stamp("sizes-load-b"), kept, "results that were there are kept");
    let file = std::fs::read_to_string(results.join("extension.toml")).expect("what was added");
    assert!(file.contains("[family.sizes") && file.contains("mesh.grid.divisions"), "{file}");

    // A later report and a later run have it, and run nothing again
    let report = ended(without_mesher(ROOT, &["report", results_text, "--json"]));
    let drawn: Value = serde_json::from_str(&report.out).expect("JSON");
    assert_eq!(drawn, after);
    let (again, _) = run(study, results_text, &[]);
    assert_eq!(again, after);
    // A family that the study does not have is a typed error
    std::fs::write(results.join("extension.toml"), "[family.size]\na = {}\n").expect("writable");
    let wrong = ended(without_mesher(ROOT, &["run", study, "--out", results_text]));
    let said = wrong.err;
    assert_eq!(wrong.code, Some(2), "{said}");
    assert!(said.contains("the study has no such family") && said.contains("did you mean `sizes`"), "{said}");
    let place = |line: usize, family: &str| {
        format!("{}: line {line}: family {family}", results.join("extension.toml").display())
    };
    assert!(said.contains(&place(1, "size")), "{said}");
    // What is wrong with an added member is said of the file that has it
    for (member, fact) in [
        ("a = {}\nnew = { \"mesh.cellls\" = 5 }", "cellls"),
        ("a = {}\nnew = 3", "it is not a table"),
        ("a = {}\n\"x y\" = {}", "cannot be part of a file name"),
    ] {
        std::fs::write(results.join("extension.toml"), format!("[family.sizes]\n{member}\n")).expect("writable");
        let wrong = ended(without_mesher(ROOT, &["run", study, "--out", results_text]));
        let said = wrong.err;
        assert_eq!(wrong.code, Some(2), "{said}");
        assert!(said.contains(&place(3, "sizes")) && said.contains(fact), "{said}");
    }
}

const FREE: fn(u32, usize) -> bool = |_, _| false;

#[test]
fn the_layers_of_a_grid_are_counted() {
    for layers in 1..=4 {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(8, 6, layers, 0.08, 0.06, 0.002, order);
            let wall = thinnest(&mesh, FREE).expect("a plate");
            assert!((wall.thickness - 0.002).abs() < 1e-8, "{wall:?}");
            assert!((wall.cells - layers as f64).abs() < 1e-9, "{order:?}: {wall:?}");
            distort(&mut mesh, 3, 0.1);
            let moved = thinnest(&mesh, FREE).expect("a plate");
            assert!((moved.cells - layers as f64).abs() < 1e-9, "moved inner nodes: {moved:?}");
        }
    }
}

/// A slab between planes of symmetry has its walls elsewhere.
#[test]
fn held_faces_are_no_sides_of_a_wall() {
    let mesh = block(8, 6, 1, 0.08, 0.06, 0.001, Order::Linear);
    let wall = thinnest(&mesh, |_, axis| axis == 2);
    // The four narrow sides are less than a twentieth of the surface
    assert!(wall.is_none(), "{wall:?}");
    let bar = block(8, 6, 4, 0.08, 0.06, 0.04, Order::Linear);
    let wall = thinnest(&bar, |_, axis| axis == 2).expect("two pairs of sides are free");
    assert!((wall.thickness - 0.06).abs() < 1e-7 && (wall.cells - 6.0).abs() < 1e-9, "{wall:?}");
}

/// A bar of 60 × 15 × 15 mm with a V-shaped notch, 10 mm deep and 10 mm wide, down to a hinge of 5 mm: its sides are steep and face nothing, and the wall of a
/// twentieth of the surface is the bar. The hinge is found by its edge, with its layers of cells.
#[test]
fn a_hinge_below_a_notch_is_found() {
    let notched = |width: usize, layers: usize, order: Order| {
        mapped_block([12, width, layers], order, |p| {
            let x = 60.0 * p.x;
            let height = 15.0 - (10.0 - 2.0 * (x - 30.0).abs()).max(0.0);
            Vec3::new(x, 5.0 * width as f64 * p.y, height * p.z) * 1e-3
        })
    };
    for (layers, order) in [(1, Order::Linear), (2, Order::Quadratic), (3, Order::Linear)] {
        let mesh = notched(3, layers, order);
        let wall = thinnest(&mesh, FREE).expect("a bar");
        assert!((wall.thickness - 0.015).abs() < 1e-7, "{wall:?}");
        let hinge = thinnest_below_notches(&mesh, FREE).expect("a hinge");
        assert!((hinge.wall.thickness - 0.005).abs() < 1e-7, "{hinge:?}");
        assert!((hinge.wall.cells - layers as f64).abs() < 1e-9, "{hinge:?}");
        assert!((hinge.at.x - 0.03).abs() < 1e-9 && (hinge.at.z - 0.005).abs() < 1e-9, "{hinge:?}");
        // Held along the normal of the side below, it is the half of another hinge
        assert_eq!(thinnest_below_notches(&mesh, |_, axis| axis == 2), None);
    }
    assert_eq!(thinnest_below_notches(&block(6, 3, 3, 0.06, 0.015, 0.015, Order::Linear), FREE), None);
    // A rib, whose edges turn outward
    let rib = mapped_block([12, 3, 3], Order::Linear, |p| {
        let x = 60.0 * p.x;
        Vec3::new(x, 15.0 * p.y, (5.0 + (10.0 - 2.0 * (x - 30.0).abs()).max(0.0)) * p.z) * 1e-3
    });
    let foot = thinnest_below_notches(&rib, FREE).expect("the feet of the rib");
    assert!(foot.wall.thickness > 0.005 && foot.wall.thickness < 0.007, "{foot:?}");
}

/// The hinges are a warning of `check`, next to that of the wall.
#[test]
fn few_cells_across_a_hinge_are_told() {
    let mesh = mapped_block([12, 3, 1], Order::Linear, |p| {
        let x = 60.0 * p.x;
        Vec3::new(x, 15.0 * p.y, (15.0 - (10.0 - 2.0 * (x - 30.0).abs()).max(0.0)) * p.z) * 1e-3
    });
    let spec = toml::from_str("file = 'bar.vtk'\nunit = 'mm'").expect("a mesh table");
    let told = limits_of_mesh(&mesh, &spec);
    let hinge = "1.0 cells across the body below a notch at (30, ";
    let is_told = told.iter().any(|(kind, text)| {
        *kind == "warning" && text.starts_with(hinge) && text.contains("where it is 5.0000 mm thick")
    });
    assert!(is_told, "{told:?}");
}
