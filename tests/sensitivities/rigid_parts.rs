//! Derivatives of a beam with a rigid end in time, by constants of the law and by other keys, against differences of whole runs.
//!
//! The nodes of the rigid part follow four others with weights that depend on the shape of the body: what has mass, damps or remembers there reads their
//! past. Differences, their errors and what is accepted are those of `to_keys.rs`.

use crate::to_keys::check_by;
use toml::Table;

const BEAM: &str = r#"
[mesh]
element = "ELEMENT"
[mesh.grid]
kind = "box"
size = ["30 mm", "10 mm", "10 mm"]
divisions = [3, 1, 1]
[mesh.regions.hard]
kind = "box"
pick = "cells"
rule = "centroid"
min = ["20 mm", "-1 mm", "-1 mm"]
max = ["31 mm", "11 mm", "11 mm"]
[mesh.regions.soft]
kind = "box"
pick = "cells"
rule = "centroid"
min = ["-1 mm", "-1 mm", "-1 mm"]
max = ["20 mm", "11 mm", "11 mm"]
[laws.rubber]
law = "neo_hookean_split"
mu = "20 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "soft"
law = "rubber"
formulation = "FORMULATION"
[[effect]]
kind = "gravity"
region = "body"
density = "1100 kg/m^3"
direction = [0.3, 0.8, -2]
acceleration = "9.81 m/s^2"
[[effect]]
kind = "inertia"
region = "body"
density = "1100 kg/m^3"
mass = "MASS"
EFFECTS
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "rigid"
region = "hard"
[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
[[probe]]
kind = "position"
region = "xmax"
[[probe]]
kind = "reaction"
region = "xmin"
[numerics]
tolerance = 1e-12
reuse_factor = false
STAGES
"#;
const DAMPING: &str = r#"
[[effect]]
kind = "viscous_damping"
region = "body"
eta = "100 Pa s"
[[effect]]
kind = "mass_damping"
region = "body"
density = "1100 kg/m^3"
mass = "lumped"
alpha = "20 /s"
[[effect]]
kind = "edge_dampers"
region = "body"
damping = "0.02 N s/m"
"#;
const RELAXING: &str = r#"
[[effect]]
kind = "viscoelastic"
region = "soft"
law = "rubber"
moduli = "long_term"
prony = [{ g = 0.3, tau = "8 ms" }, { g = 0.2, tau = "60 ms" }]
[[effect]]
kind = "viscous_damping"
region = "soft"
eta = "50 Pa s"
"#;
const STATIC: (&str, usize) = ("\"static\"", 1);
const EULER: &str = "\"implicit_euler\"";
const BDF2: &str = "\"bdf2\"";
const ALPHA: &str = "{ kind = \"generalised_alpha\", rho = 0.7 }";
const KEYS: [&str; 8] = [
    "laws.rubber.mu",
    "laws.rubber.nu",
    "effect.inertia.density",
    "effect.viscous_damping.eta",
    "effect.mass_damping.alpha",
    "effect.edge_dampers.damping",
    "mesh.grid.size.0",
    "mesh.grid.size.2",
];

/// The beam with an element, a formulation, a mass, effects in addition, and stages of (integrator, steps of 5 ms).
fn beam([element, formulation, mass, effects]: [&str; 4], stages: &[(&str, usize)]) -> Table {
    let stage = |(integrator, steps): &(&str, usize)| {
        format!("[[stage]]\nintegrator = {integrator}\nduration = \"{} ms\"\ndt = \"5 ms\"\n", 5 * steps)
    };
    BEAM.replace("ELEMENT", element)
        .replace("FORMULATION", formulation)
        .replace("MASS", mass)
        .replace("EFFECTS", effects)
        .replace("STAGES", &stages.iter().map(stage).collect::<String>())
        .parse()
        .unwrap_or_else(|e| panic!("{e}"))
}

/// Mass and every kind of damping, of the rigid part too, by every integrator from rest: by the constants of the law, which are exact, by densities and
/// damping, and by dimensions, which change the weights.
#[test]
fn masses_and_dampers_of_a_rigid_part() {
    for integrator in [EULER, BDF2, ALPHA] {
        for mass in ["consistent", "lumped"] {
            let table = beam(["tet4", "displacement", mass, DAMPING], &[(integrator, 3)]);
            check_by(&format!("{integrator}, {mass}"), &table, &KEYS, 1e-3);
        }
    }
}

/// Effects that remember next to a rigid part, and a start from a state that is not at rest in its reference.
#[test]
fn what_remembers_next_to_a_rigid_part() {
    let keys = ["laws.rubber.mu", "effect.viscoelastic.prony.0.tau", "mesh.grid.size.0", "mesh.grid.size.2"];
    for integrator in [EULER, BDF2, ALPHA] {
        let table = beam(["tet10", "mixed", "consistent", RELAXING], &[(BDF2, 2), STATIC, (integrator, 2)]);
        check_by(&format!("remembering, {integrator}"), &table, &keys, 1e-3);
    }
}
