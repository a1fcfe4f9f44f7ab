//! Adaptive meshes: the error of one quantity falls to its tolerance, the error bars of all meshes hold, and what cannot be refined is refused.

use crate::common::tools;
use std::path::Path;
use std::process::{Command, Output};

/// A cantilever of mixed quadratic cells that bends by its tip.
fn scene(mesh: &str, refine: &str) -> String {
    format!(
        "[mesh]\n{mesh}\nelement = \"tet10\"\nrefine = {{ {refine} }}\n[laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\nformulation = \"mixed\"\n\
         [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n[[constraint]]\nkind = \"prescribed\"\nregion = \"xmax\"\n\
         components = \"z\"\ndisplacement = {{ kind = \"ramp\", from = \"0 mm\", to = \"8 mm\", start = \"0 s\", end = \"1 s\" }}\n\
         [[probe]]\nkind = \"reaction\"\nregion = \"xmax\"\n[[probe]]\nkind = \"position\"\nregion = \"xmin\"\n\
         [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.5 s\"\n"
    )
}

const BLOCK: &str =
    "body = \"block\"\nparameters = { lx = \"40 mm\", ly = \"10 mm\", lz = \"10 mm\" }\nsize = \"8 mm\"";
const REACTION: &str = "quantity = \"xmax_reaction_z_N\"";

fn simulate(folder: &Path, text: &str) -> Output {
    simulate_with(folder, text, &[])
}

fn simulate_with(folder: &Path, text: &str, flags: &[&str]) -> Output {
    let file = folder.join("beam.toml");
    std::fs::write(&file, text).expect("writable");
    let mut command = Command::new(env!("CARGO_BIN_EXE_durometer"));
    command.arg("simulate").arg(&file).arg("--out").arg(folder).args(flags).output().expect("the program starts")
}

fn has_mesher() -> bool {
    let check = Command::new(env!("CARGO_BIN_EXE_durometer")).arg("doctor").output().expect("the program starts");
    check.status.success()
}

/// The tolerance is met with a rising number of cells. Every bar contains the best value, that of the last mesh corrected by its own
/// estimate, whose uncertainty is added; and the value of the run is that of the last mesh.
#[test]
fn the_tolerance_is_met_and_bars_hold() {
    if tools::is_missing(has_mesher(), "the mesher (durometer doctor --setup)") {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let done = simulate(folder.path(), &scene(BLOCK, &format!("{REACTION}, tolerance = \"0.8 %\"")));
    let said = String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(0), "{said}");
    let csv = std::fs::read_to_string(folder.path().join("beam.refinement.csv")).expect("written");
    let rows: Vec<Vec<f64>> =
        csv.lines().skip(1).map(|line| line.split(',').map(|n| n.parse().expect("a number")).collect()).collect();
    println!("{csv}");
    let [cells, value, corrected, uncertainty, bar, tolerance] = [0, 3, 5, 6, 7, 8];
    assert!(rows.len() >= 2, "{csv}");
    let last = rows.last().expect("rows");
    assert!(last[bar] <= last[tolerance] && rows[rows.len() - 2][bar] > last[tolerance], "{csv}");
    for (before, after) in rows.iter().zip(&rows[1..]) {
        assert!(after[cells] > before[cells] && after[bar] < before[bar], "{csv}");
        assert!((before[value] - last[corrected]).abs() <= before[bar] + last[uncertainty], "{csv}");
    }
    let run = std::fs::read_to_string(folder.path().join("beam.csv")).expect("written");
    assert!(run.contains(&last[value].to_string()), "{run}");
}

/// A number of meshes that is too small ends with exit code 3, and the results of the last mesh stay.
#[test]
fn too_few_meshes_are_a_status() {
    if tools::is_missing(has_mesher(), "the mesher (durometer doctor --setup)") {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let done = simulate(folder.path(), &scene(BLOCK, &format!("{REACTION}, tolerance = \"0.001 %\", meshes = 1")));
    let said = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(done.status.code() == Some(3) && said.contains("allow more `meshes`"), "{said}");
    assert!(folder.path().join("beam.csv").exists() && folder.path().join("beam.refinement.csv").exists());
}

/// A cylinder of so few edges that the smooth surface through its nodes is another one has another volume than its CAD: no bar on it is within a tolerance, and
/// all say that they are without that surface.
#[test]
fn a_mesh_of_another_body_is_within_no_tolerance() {
    if tools::is_missing(has_mesher(), "the mesher (durometer doctor --setup)") {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let quantity = "quantity = \"xmax_reaction_z_N\", tolerance = \"90 %\", meshes = 1";
    let text = scene("body = \"cylinder\"\nsize = \"30 mm\"", quantity);
    let text = text.replace("tet10", "tet4").replace("xmin", "bottom").replace("xmax", "top");
    let done = simulate_with(folder.path(), &text, &["--error", "top_reaction_z_N"]);
    let [said, told] = [done.stdout, done.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(done.status.code() == Some(3) && told.contains("on every mesh, or without curved facets, and"), "{told}");
    assert!(told.contains("warning: the error bars do not contain the error of the surface"), "{told}");
    let without = "(without curved facets, which are not estimated here)";
    assert_eq!(said.matches(without).count(), 2, "{said}");
}

/// A clamp of facets that ends within cells ends so on every mesh: its extent is in no bar, none is within a tolerance, and no second mesh is made.
#[test]
fn a_bar_without_the_extent_of_a_region_ends_the_refinement() {
    if tools::is_missing(has_mesher(), "the mesher (durometer doctor --setup)") {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = scene(BLOCK, &format!("{REACTION}, tolerance = \"90 %\"")).replace(
        "[laws.rubber]",
        "[mesh.regions]\nclamp = { kind = \"box\", min = [\"-1 mm\", \"-1 mm\", \"-1 mm\"], max = [\"7 mm\", \"11 mm\", \"11 mm\"], \
         pick = \"facets\", rule = \"all\" }\n[laws.rubber]",
    );
    let done = simulate(
        folder.path(),
        &text.replace("kind = \"fixed\"\nregion = \"xmin\"", "kind = \"fixed\"\nregion = \"clamp\""),
    );
    let [said, told] = [done.stdout, done.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
    assert!(
        done.status.code() == Some(3) && told.contains("on every mesh, or without the extent of clamp, and"),
        "{told}"
    );
    assert!(told.contains("let the border of these regions run along edges of the cells"), "{told}");
    assert_eq!(said.matches("(without the extent of clamp)").count(), 1, "{said}");
}

/// A position that is zero needs an absolute tolerance.
#[test]
fn a_quantity_near_zero_asks_for_an_absolute_tolerance() {
    if tools::is_missing(has_mesher(), "the mesher (durometer doctor --setup)") {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let of = |tolerance: &str| {
        let done = simulate(folder.path(), &scene(BLOCK, &format!("quantity = \"xmin_x_m\", {tolerance}")));
        (done.status.code(), String::from_utf8_lossy(&done.stderr).into_owned())
    };
    let (code, said) = of("tolerance = \"1 %\"");
    assert!(code == Some(2) && said.contains("give an absolute_tolerance"), "{said}");
    let (code, said) = of("absolute_tolerance = 1e-6");
    assert_eq!(code, Some(0), "{said}");
}

/// Refusals that need no mesher name the fact and the remedy, with exit code 2.
#[test]
fn what_cannot_be_refined_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let grid = "grid = { kind = \"box\", size = [\"40 mm\", \"10 mm\", \"10 mm\"], divisions = [4, 1, 1] }";
    let good = format!("{REACTION}, tolerance = \"1 %\"");
    let cases = [
        (grid.to_string(), good.clone(), "a grid is not refined"),
        (format!("{BLOCK}\ngenerator = \"cgal\""), good.clone(), "CGAL takes no size field"),
        (BLOCK.to_string(), REACTION.to_string(), "give either tolerance"),
        (BLOCK.to_string(), format!("{good}, absolute_tolerance = 1.0"), "give either tolerance"),
        (BLOCK.to_string(), format!("{REACTION}, tolerance = \"-1 %\""), "must be positive"),
        (BLOCK.to_string(), format!("{good}, meshes = 0"), "at least 1"),
        (format!("{BLOCK}\ndisturb = {{ nodes = 0.1 }}"), good.clone(), "a disturbed mesh is not refined"),
    ];
    for (mesh, refine, words) in cases {
        let done = simulate(folder.path(), &scene(&mesh, &refine));
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(done.status.code() == Some(2) && said.contains(words), "{mesh}, {refine}: {said}");
    }
}
