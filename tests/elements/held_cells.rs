//! Cells that constraints alone deform: pressures next to them are those of the cells that the unknowns deform.

use crate::common::{column, nodes};
use durometer::scene::{ErrorEstimate, ErrorEstimator, RunOptions, Scene, parse_scene};
use durometer::system::State;

/// A column of 10 × 10 × 40 mm in boxes of 10 mm, with parts by nodes: `root` up to this height \[mm\], `stamp` from 20 mm up to this one.
fn tower([element, formulation]: [&str; 2], [root, stamp]: [f64; 2], rest: &str) -> Scene {
    let part = |name: &str, [from, to]: [f64; 2]| {
        format!(
            "[mesh.regions.{name}]\nkind = \"box\"\nmin = [\"-1 mm\", \"-1 mm\", \"{} mm\"]\nmax = [\"11 mm\", \"11 mm\", \"{} mm\"]\n",
            from - 0.01,
            to + 0.01
        )
    };
    let text = format!(
        r#"
[mesh]
grid = {{ kind = "box", size = ["10 mm", "10 mm", "40 mm"], divisions = [1, 1, 4] }}
element = "{element}"
{}{}
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.49
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "{formulation}"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
{rest}
"#,
        part("root", [0.0, root]),
        part("stamp", [20.0, stamp])
    );
    parse_scene(&text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Stress P = μ(λ − 1/λ) + Λ ln λ/λ \[Pa\] of this law where only the height changes, by the factor λ.
fn stress(stretch: f64) -> f64 {
    let (mu, lame) = (1e5 / 2.98, 1e5 * 0.49 / (1.49 * 0.02));
    mu * (stretch - 1.0 / stretch) + lame * stretch.ln() / stretch
}

/// All sides held, and the part from 20 mm on moved down by 0.4 mm.
const PRESSED: &str = r#"
[[constraint]]
kind = "fixed"
region = "body"
components = "xy"
[[constraint]]
kind = "fixed"
region = "root"
components = "z"
[[constraint]]
kind = "prescribed"
region = "stamp"
components = "z"
displacement = { kind = "ramp", from = "0 mm", to = "-0.4 mm", end = "1 s" }
[[probe]]
kind = "reaction"
region = "root"
"#;

const FORMULATIONS: [[&str; 2]; 5] = [
    ["tet4", "displacement"],
    ["tet4", "mixed"],
    ["tet10", "displacement"],
    ["tet10", "mixed"],
    ["tet10", "mean_dilatation"],
];

fn last(scene: &Scene, name: &str) -> f64 {
    let run = scene.run();
    let column = column(&run, name);
    assert_eq!(column.len(), 3, "{}", run.status);
    column[2]
}

/// An oedometer whose stamp consists of cells: strain and stress are the same in all cells below it, and the force is that of the closed form, whether these cells are free
/// in between, or lie between two parts whose motions are given and below a free part. One pressure for both sides of the border gave −3 to −31 %.
#[test]
fn cells_that_are_moved_do_not_soften_those_below() {
    for formulation in FORMULATIONS {
        for parts in [[0.0, 40.0], [10.0, 30.0]] {
            let force = last(&tower(formulation, parts, PRESSED), "root_reaction_z_N").abs();
            let exact = stress(1.0 - 0.4 / (20.0 - parts[0])).abs() * 1e-4;
            println!("{formulation:?} {parts:?}: {force} N, exact {exact} N");
            assert!((force / exact - 1.0).abs() < 1e-6, "{formulation:?} {parts:?}: {force} N, not {exact} N");
        }
    }
}

/// A rigid part of the region of an elastic effect moves as by the closed form P(λ) = t, which was 11 to 47 % further with its pressures at the border.
#[test]
fn cells_of_a_rigid_part_do_not_soften_those_below() {
    let rest = r#"
[mesh.regions.top]
kind = "box"
pick = "cells"
rule = "centroid"
min = ["0 mm", "0 mm", "20 mm"]
max = ["10 mm", "10 mm", "40 mm"]
[mesh.regions.low]
kind = "box"
min = ["-1 mm", "-1 mm", "-1 mm"]
max = ["11 mm", "11 mm", "19 mm"]
[[constraint]]
kind = "rigid"
region = "top"
[[constraint]]
kind = "fixed"
region = "low"
components = "xy"
[[constraint]]
kind = "fixed"
region = "zmin"
components = "z"
[[effect]]
kind = "traction"
region = "zmax"
direction = [0, 0, 1]
traction = { kind = "ramp", from = "0 kPa", to = "10 kPa", end = "1 s" }
[[probe]]
kind = "position"
region = "zmax"
"#;
    let mut bounds = [1.0, 1.1];
    for _ in 0..60 {
        let middle = 0.5 * (bounds[0] + bounds[1]);
        bounds[usize::from(stress(middle) > 1e4)] = middle;
    }
    let exact = 0.02 * (bounds[0] - 1.0);
    for formulation in FORMULATIONS {
        let moved = last(&tower(formulation, [0.0, 40.0], rest), "zmax_z_m") - 0.04;
        println!("{formulation:?}: {moved} m, exact {exact} m");
        assert!((moved / exact - 1.0).abs() < 1e-6, "{formulation:?}: {moved} m, not {exact} m");
    }
}

fn estimate(scene: &Scene, quantity: &str) -> ErrorEstimate {
    let mut estimator = ErrorEstimator::new(scene).and_then(ErrorEstimator::localised).expect("an estimate");
    let mut add = |state: &State| estimator.add(state);
    let run = scene.run_with(RunOptions { on_state: Some(&mut add), ..RunOptions::default() });
    estimator.estimate(&run, &[quantity.into()]).expect("solved")
}

/// Where the run is exact the enriched space, with pressures or without, has the same value.
#[test]
fn enriched_values_are_exact_next_to_cells_that_are_moved() {
    for formulation in FORMULATIONS {
        let found = estimate(&tower(formulation, [0.0, 40.0], PRESSED), "root_reaction_z_N");
        let [quantity] = &found.quantities[..] else { panic!("one quantity") };
        println!("{formulation:?}: {quantity:?}");
        assert!((quantity.enriched / quantity.value - 1.0).abs() < 1e-6, "{formulation:?}: {quantity:?}");
    }
}

/// The linear cells in a corner between held faces have no node that moves, and the quadratic ones of the enriched space do: their pressures begin with those next to them,
/// and the shares of the cells add up to the change.
#[test]
fn cells_in_a_corner_have_an_estimate() {
    let text = r#"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [4, 2, 2] }
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.49
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "mixed"
[[constraint]]
kind = "fixed"
region = "zmin"
[[constraint]]
kind = "fixed"
region = "xmax"
[[effect]]
kind = "traction"
region = "xmin"
direction = [0, 1, 0]
traction = { kind = "ramp", from = "0 kPa", to = "1 kPa", end = "1 s" }
[[probe]]
kind = "position"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#;
    let scene = parse_scene(text).expect("a scene");
    let mesh = &scene.body.mesh;
    let held = [nodes(mesh, "zmin"), nodes(mesh, "xmax")].concat();
    let corners = (0..mesh.cell_count()).filter(|&c| mesh.cell(c).iter().all(|node| held.contains(node)));
    assert_eq!(corners.count(), 6);
    let found = estimate(&scene, "xmin_y_m");
    let (quantity, cells) = (&found.quantities[0], &found.cells[0]);
    let change = quantity.enriched - quantity.value;
    println!("{quantity:?}, remainder {:.2} % of the change", 100.0 * cells.remainder / change);
    assert!(cells.remainder.abs() < change.abs() / 7.0, "{} of {change}", cells.remainder);
}
