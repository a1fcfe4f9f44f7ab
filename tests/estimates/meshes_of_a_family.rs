//! Families whose meshes do not show their error, through studies that are run: a direction that no mesh refines, a region whose border runs through
//! cells, and members of other problems.

use crate::common::studies::run_folder;
use crate::common::synthetic::{SIZES, size, study};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::study::analysis::Analysis;
use durometer::study::estimate::family::{Level, estimate};
use durometer::study::estimate::method::Method;
use durometer::study::kinds::convergence::analysis::analyse;
use durometer::study::kinds::convergence::findings::ConvergenceFindings;
use durometer::study::store::record::{Role, StoredCase};
use durometer::study::store::results::read;

/// A cantilever of 40 × 10 × 10 mm that a traction bends, held by a region.
const SCENE: &str = r#"
title = "A beam"
[mesh]
grid = { kind = "box", size = ["40 mm", "10 mm", "10 mm"], divisions = [4, 1, 1] }
[mesh.regions]
clamp = { kind = "box", min = ["-1 mm", "-1 mm", "-1 mm"], max = ["DEPTH", "11 mm", "11 mm"] }
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "mixed"
[[effect]]
kind = "traction"
region = "xmax"
direction = [0, 0, -1]
traction = { kind = "ramp", from = "0 kPa", to = "0.1 kPa", end = "1 s" }
[[constraint]]
kind = "fixed"
region = "clamp"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[[probe]]
kind = "position"
region = "xmax"
"#;

/// The analysis of a family of these members.
fn family(depth: &str, members: &str) -> Analysis<ConvergenceFindings> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let study = format!(
        "kind = \"convergence\"\nquestion = \"How far does the end sink?\"\nexpectation = \"As a beam does.\"\nscene = \"scene.toml\"\n\
         tolerance = \"10 %\"\n[[variant]]\nname = \"load\"\n\
         quantity = [{{ name = \"xmax_z_m\", label = \"height of the end\", symbol = \"z\", unit = \"m\" }}]\n\
         [[family]]\nname = \"sizes\"\nrole = \"sizes\"\n[family.members]\n{members}"
    );
    for (name, text) in [("scene.toml", SCENE.replace("DEPTH", depth)), ("study.toml", study)] {
        std::fs::write(folder.path().join(name), text).expect("writable");
    }
    run_folder(folder.path());
    let results = read(&folder.path().join("results")).unwrap_or_else(|e| panic!("{e}"));
    analyse(&results.study, &results.cases)
}

fn grids(divisions: &[[usize; 3]]) -> String {
    let line = |(k, d): (usize, &[usize; 3])| format!("m{k} = {{ \"mesh.grid.divisions\" = {d:?} }}\n");
    divisions.iter().enumerate().map(line).collect()
}

/// Two boxes along a beam whose end sinks by bending along them: finer sections agree with each other, several tenths away from the answer. The mesh to
/// add has more boxes along it.
#[test]
fn a_direction_that_stays_coarse_gets_no_verdict() {
    let a = family("0.01 mm", &grids(&[[2, 2, 2], [2, 3, 3], [2, 4, 4]]));
    println!("{}", a.verdict);
    assert!(
        a.recommended.is_none() && a.verdict.contains("extents of the cells along x hardly shrink"),
        "{}",
        a.verdict
    );
    let set = &a.extension.as_ref().expect("a mesh to add").set;
    let along = set["mesh.grid.divisions"][0].as_integer().expect("a number");
    assert!(along > 2, "{set:?}");
    let similar = family("0.01 mm", &grids(&[[4, 1, 1], [8, 2, 2], [12, 3, 3]]));
    assert!(!similar.verdict.contains("hardly shrink"), "{}", similar.verdict);
}

/// The rule itself, on blocks: orders over meshes of 3 × n × n boxes are refused, those over similar meshes are not, and a direction along which
/// the body is held is no direction.
#[test]
fn extents_decide_by_direction() {
    let meshes = |grid: &dyn Fn(usize) -> [usize; 3], counted| {
        let level = |n: usize| {
            let [x, y, z] = grid(n);
            let mesh = block(x, y, z, 0.02, 0.01, 0.01, Order::Linear);
            let (h, extents) = (mesh.h(), Some(mesh.mean_extents(counted)));
            Level { id: n.to_string(), h, extents, f: 1.0 + 100.0 * h * h, ..Level::default() }
        };
        estimate(("sizes", Role::Sizes, "tet4"), [2, 3, 4, 5].map(level).to_vec(), None, 0.5).expect("four meshes")
    };
    let all = [true; 3];
    let similar = meshes(&|n| [2 * n, n, n], all);
    assert!(similar.defensible && !similar.keeps_length, "{:?}", similar.reasons);
    let frozen: [&dyn Fn(usize) -> [usize; 3]; 3] = [&|n| [3, n, n], &|n| [2 * n, n, 1], &|n| [n, 2, n]];
    for grid in frozen {
        let frozen = meshes(grid, all);
        assert!(frozen.refused && frozen.reasons.iter().any(|r| r.contains("hardly shrink")), "{:?}", frozen.reasons);
    }
    assert!(meshes(&|n| [2 * n, n, 1], [true, true, false]).defensible);
}

/// A clamp of 6.2 mm ends within cells of every mesh; one of 10 mm ends between them.
#[test]
fn a_region_that_ends_within_cells_gets_no_verdict() {
    let divisions = [[4, 1, 1], [8, 2, 2], [12, 3, 3]];
    let [within, between] = ["6.2 mm", "10 mm"].map(|depth| family(depth, &grids(&divisions)));
    println!("{}\n{}", within.verdict, between.verdict);
    assert!(within.recommended.is_none() && within.verdict.contains("border of clamp runs through cells"));
    assert!(within.extension.is_none(), "no mesh removes the reason: {:?}", within.extension);
    assert!(!between.verdict.contains("runs through cells"), "{}", between.verdict);
}

/// A bracket that is held at the inner face of its corner, which ends at the re-entrant edge: two meshes assume the first order there, and 2 on one that is held at
/// the end of an arm.
#[test]
fn two_meshes_at_a_glued_edge_assume_the_first_order() {
    let orders = ["inner", "ymax"].map(|held| {
        let scene = format!(
            "[mesh]\nelement = \"tet10\"\ngrid = {{ kind = \"bracket\", edge = \"20 mm\", thickness = \"10 mm\", divisions = [2, 1] }}\n\
             [mesh.regions]\ninner = {{ kind = \"plane\", point = [\"10 mm\", \"0 mm\", \"0 mm\"], normal = [1, 0, 0], \
             tolerance = \"0.01 mm\", pick = \"facets\", rule = \"all\" }}\n[laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\n\
             nu = 0.3\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n[[constraint]]\nkind = \"fixed\"\n\
             region = \"{held}\"\n[[effect]]\nkind = \"traction\"\nregion = \"xmax\"\ndirection = [0, -1, 0]\ntraction = {{ kind = \"ramp\", \
             from = \"0 kPa\", to = \"1 kPa\", end = \"1 s\" }}\n[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.5 s\"\n\
             [[probe]]\nkind = \"position\"\nregion = \"xmax\"\n"
        );
        let study = "kind = \"convergence\"\nquestion = \"q\"\nexpectation = \"e\"\nscene = \"scene.toml\"\ntolerance = \"10 %\"\n\
             [[variant]]\nname = \"sag\"\nquantity = [{ name = \"xmax_y_m\", label = \"sag\", symbol = \"y\", unit = \"m\" }]\n\
             [[family]]\nname = \"sizes\"\nrole = \"sizes\"\n[family.members]\n\
             a = { \"mesh.grid.divisions\" = [2, 1] }\nb = { \"mesh.grid.divisions\" = [4, 2] }\n";
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in [("scene.toml", scene.as_str()), ("study.toml", study)] {
            std::fs::write(folder.path().join(name), text).expect("writable");
        }
        run_folder(folder.path());
        let results = read(&folder.path().join("results")).unwrap_or_else(|e| panic!("{e}"));
        let a = analyse(&results.study, &results.cases);
        let q = a.find("sag", "xmax_y_m").expect("listed");
        println!("{held}: {}", a.verdict);
        q.estimate("sizes").expect("two meshes").method.clone()
    });
    assert_eq!(orders, [1.0, 2.0].map(|p| Method::TwoMeshes { p }));
}

/// Members with other moduli or dimensions are other bodies: the report says so. Members of one size are named.
#[test]
fn members_of_other_problems_are_named() {
    let (study, mut cases) = study();
    let warned = |cases: &[_]| -> Vec<String> {
        let all = analyse(&study, cases).warnings;
        all.into_iter().filter(|w| w.contains("differ in") || w.contains("the same size")).collect()
    };
    assert!(warned(&cases).is_empty(), "{:?}", warned(&cases));
    for (key, [of_coarsest, of_others]) in [
        ("laws.rubber.E", ["E = \"100 kPa\"", "E = \"105 kPa\""]),
        ("mesh.parameters.length", ["[mesh.parameters]\nlength = \"42 mm\"", "[mesh.parameters]\nlength = \"40 mm\""]),
    ] {
        for c in cases.iter_mut().filter(|c| c.record.family == "sizes") {
            let (cells, coarsest) = (c.record.mesh.cells, c.record.mesh.cells == SIZES[3]);
            let own = if coarsest { of_coarsest } else { of_others };
            c.record.provenance.scene =
                format!("[mesh]\ncells = {cells}\n[laws.rubber]\nlaw = \"neo_hookean\"\n{own}\n");
        }
        let found = warned(&cases);
        let says = format!("Family sizes: its members differ in {key} too");
        assert!(found.len() == 1 && found[0].starts_with(&says), "{found:?}");
    }
    for c in cases.iter_mut().filter(|c| c.record.family == "nested" && c.record.member == "600") {
        c.record.mesh.h_m = size(4_800);
    }
    let found = warned(&cases);
    assert!(found.iter().any(|w| w.starts_with("Family nested: no estimate uses nested-")), "{found:?}");
}

/// Variants of one family may differ in the element, and each estimate has the order of its own meshes; members of one variant that do have none in common.
#[test]
fn an_estimate_has_the_order_of_its_meshes() {
    let (study, mut cases) = study();
    let quadratic = |c: &&mut StoredCase| c.record.family == "sizes" && c.record.variant == "tension";
    cases.iter_mut().filter(quadratic).for_each(|c| c.record.formulation = "tet10".into());
    let analysed = analyse(&study, &cases);
    let order = |variant: &str| {
        let estimate = analysed.find(variant, "bending_angle_deg").and_then(|q| q.estimate("sizes"));
        estimate.map(|e| (e.formal_order, e.formulation.clone()))
    };
    assert_eq!(order("length"), Some((2.0, "tet4".into())));
    assert_eq!(order("tension"), Some((4.0, "tet10".into())));
    let mixed = |warnings: &[String]| warnings.iter().filter(|w| w.contains("formal orders differ")).count();
    assert_eq!(mixed(&analysed.warnings), 0, "{:?}", analysed.warnings);
    let coarsest = |c: &&mut StoredCase| quadratic(c) && c.record.mesh.cells == SIZES[3];
    cases.iter_mut().filter(coarsest).for_each(|c| c.record.formulation = "tet4".into());
    let warnings = analyse(&study, &cases).warnings;
    assert!(
        mixed(&warnings) == 1 && warnings.iter().any(|w| w.starts_with("Family sizes: its members are of tet")),
        "{warnings:?}"
    );
}

/// Facets on a curved surface miss its volume by c h², and are not reported. Another body has another volume, whichever place it has in the family.
#[test]
fn meshes_of_another_body_are_named() {
    let (study, cases) = study();
    let warned = |volume: &dyn Fn(f64, usize) -> f64| -> Vec<String> {
        let mut cases = cases.clone();
        let of_sizes = cases.iter_mut().filter(|c| c.record.family == "sizes");
        let mut meshes: Vec<_> = of_sizes.map(|c| &mut c.record.mesh).collect();
        meshes.sort_by_key(|m| m.cells);
        meshes.iter_mut().enumerate().for_each(|(k, m)| m.volume_m3 = volume(m.h_m, k));
        let all = analyse(&study, &cases).warnings;
        all.into_iter().filter(|w| w.contains("volumes of its meshes")).collect()
    };
    assert!(warned(&|_, _| 1e-6).is_empty());
    let faceted = |h: f64| 1e-6 * (1.0 - 0.05 * (h / size(SIZES[0])).powi(2));
    assert!(warned(&|h, k| faceted(h) * (1.0 + 2e-4 * (k as f64).cos())).is_empty());
    for other in 0..SIZES.len() {
        let found = warned(&|h, k| faceted(h) * if k == other { 1.08 } else { 1.0 });
        assert!(found.len() == 1 && found[0].starts_with("Family sizes: the volumes"), "{other}: {found:?}");
    }
}
