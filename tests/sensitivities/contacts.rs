//! Derivatives through contact with rigid obstacles, against differences of whole runs: by the place and the motion of an obstacle, by what the response
//! acts with, and by the constants of laws, which contacts and rigid bodies without a modulus of their own follow.
//!
//! A contact changes over the depth of its surfaces, here 1e-7 m of a key of 2 mm, and has a kink where a point opens. The differences of runs
//! have a step of 1e-4 of the key: the body moves with the obstacle, so that the contact itself changes by less than a hundredth of that.

use crate::to_keys::{check_by, refusal};
use toml::Table;

const STEP: f64 = 1e-4;
const FLOOR: &str = "{ kind = \"floor\", point = [\"0 mm\", \"0 mm\", \"-2 mm\"], normal = [0, 0, 1] }";
const SPHERE: &str = "{ kind = \"sphere\", center = [\"45 mm\", \"5 mm\", \"-12 mm\"], radius = \"10 mm\" }";
const BODY: &str = r#"
[[effect]]
kind = "elastic"
region = "body"
law = "silicone"
"#;
const AT_REST: &str = "[[stage]]\nintegrator = \"static\"\nduration = \"10 ms\"\ndt = \"2.5 ms\"\n";

/// A beam of 60 mm under its weight, with these tables.
fn beam(tables: &[&str]) -> Table {
    let text = r#"
[mesh.grid]
kind = "box"
size = ["60 mm", "10 mm", "10 mm"]
divisions = [12, 2, 2]
[laws.silicone]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45
[[effect]]
kind = "gravity"
region = "body"
density = "1070 kg/m^3"
direction = [0, 0, -1]
acceleration = { kind = "ramp", from = "0 m/s^2", to = "9.81 m/s^2", end = "10 ms" }
[[constraint]]
kind = "fixed"
region = "xmin"
[[probe]]
kind = "position"
region = "xmax"
[[probe]]
kind = "reaction"
region = "xmin"
[numerics]
tolerance = 1e-12
reuse_factor = false
"#;
    [text, &tables.concat()].concat().parse().unwrap_or_else(|e| panic!("{e}"))
}

/// The contact of its lower side, with more lines.
fn contact(response: &str, obstacle: &str, more: &str) -> String {
    format!(
        "[[contact]]\nname = \"ground\"\nregion = \"zmin\"\nobstacle = {obstacle}\nresponse = \"{response}\"\nfriction = 0\n{more}\n"
    )
}

/// Places of obstacles, which move the body by their own motion, and constants of the law, by a hundredth of which the contact changes too.
#[test]
fn places_of_obstacles_and_constants_of_laws() {
    for response in ["penalty", "barrier", "multiplier"] {
        for (obstacle, place) in [(FLOOR, "point.2"), (SPHERE, "center.0"), (SPHERE, "radius")] {
            let key = format!("contact.ground.obstacle.{place}");
            let table = beam(&[BODY, &contact(response, obstacle, ""), AT_REST]);
            let label = format!("{response} {place}");
            check_by(&label, &table, &[&key, "laws.silicone.E", "laws.silicone.nu", "effect.gravity.density"], STEP);
        }
    }
}

/// The numbers of the response itself, and a modulus that is given, which no law changes.
#[test]
fn numbers_of_the_response() {
    for response in ["penalty", "barrier"] {
        let given = contact(response, FLOOR, "modulus = \"20 kPa\"\ndistance = \"0.2 mm\"");
        let keys =
            ["contact.ground.modulus", "contact.ground.distance", "contact.ground.obstacle.point.2", "laws.silicone.E"];
        check_by(response, &beam(&[BODY, &given, AT_REST]), &keys, STEP);
    }
}

/// An obstacle that moves, statically and in time.
#[test]
fn motions_of_obstacles() {
    let lifted = "motion = { direction = [0, 0, 1], displacement = { kind = \"sine\", amplitude = \"1.2 mm\", frequency = \"8 Hz\" } }";
    let inertia =
        "[[effect]]\nkind = \"inertia\"\nregion = \"body\"\ndensity = \"1070 kg/m^3\"\nmass = \"consistent\"\n";
    for (integrator, inertia) in [("static", ""), ("bdf2", inertia)] {
        let stage = format!("[[stage]]\nintegrator = \"{integrator}\"\nduration = \"30 ms\"\ndt = \"10 ms\"\n");
        let table = beam(&[BODY, inertia, &contact("barrier", SPHERE, lifted), &stage]);
        let keys =
            ["contact.ground.motion.displacement.amplitude", "contact.ground.obstacle.center.0", "laws.silicone.E"];
        check_by(integrator, &table, &keys, STEP);
    }
}

/// The contact follows the stiffer of two laws, and not the other one.
#[test]
fn the_stiffest_of_two_laws() {
    let halves = r#"
[[effect]]
kind = "elastic"
region = "near"
law = "silicone"
[[effect]]
kind = "elastic"
region = "far"
law = "rubber"
[laws.rubber]
law = "neo_hookean"
mu = "60 kPa"
kappa = "500 kPa"
[mesh.regions.near]
pick = "cells"
rule = "centroid"
kind = "box"
min = ["-1 mm", "-1 mm", "-1 mm"]
max = ["30.1 mm", "11 mm", "11 mm"]
[mesh.regions.far]
pick = "cells"
rule = "centroid"
kind = "box"
min = ["29.9 mm", "-1 mm", "-1 mm"]
max = ["61 mm", "11 mm", "11 mm"]
"#;
    for response in ["penalty", "barrier"] {
        let table = beam(&[halves, &contact(response, FLOOR, ""), AT_REST]);
        check_by(response, &table, &["laws.rubber.mu", "laws.rubber.kappa", "laws.silicone.E"], STEP);
    }
}

/// A rigid body that lies on the beam: its stiffness, and that of its contact, are those of the law.
#[test]
fn a_rigid_body_follows_the_law() {
    let brick = r#"
[[rigid]]
name = "brick"
shape = { kind = "box", min = ["48 mm", "2 mm", "10.03 mm"], max = ["56 mm", "8 mm", "16 mm"] }
density = "2000 kg/m^3"
gravity = { direction = [0, 0, -1], acceleration = "9.81 m/s^2" }
[[contact]]
name = "top"
region = "zmax"
obstacle = { kind = "rigid", body = "brick" }
response = "barrier"
friction = 0
[[effect]]
kind = "inertia"
region = "body"
density = "1070 kg/m^3"
mass = "consistent"
[[stage]]
integrator = "bdf2"
duration = "6 ms"
dt = "2 ms"
"#;
    check_by("rigid", &beam(&[BODY, brick]), &["laws.silicone.E", "laws.silicone.nu"], STEP);
}

/// A rigid ball hits a floor in its third step, where BDF2 begins anew, and carries the beam that falls on it.
#[test]
fn an_impact_of_a_rigid_body() {
    let ball = r#"
[[rigid]]
name = "ball"
shape = { kind = "sphere", center = ["50 mm", "5 mm", "-10.5 mm"], radius = "10 mm" }
density = "1000 kg/m^3"
gravity = { direction = [0, 0, -1], acceleration = "9.81 m/s^2" }
velocity = ["0 m/s", "0 m/s", "-0.1 m/s"]
[[contact]]
name = "ground"
region = "ball"
obstacle = { kind = "floor", point = ["0 mm", "0 mm", "-21 mm"], normal = [0, 0, 1] }
response = "barrier"
friction = 0
[[contact]]
name = "top"
region = "zmin"
obstacle = { kind = "rigid", body = "ball" }
response = "barrier"
friction = 0
[[effect]]
kind = "inertia"
region = "body"
density = "1070 kg/m^3"
mass = "consistent"
[[stage]]
integrator = "bdf2"
duration = "40 ms"
dt = "2 ms"
"#;
    check_by("impact", &beam(&[BODY, ball]), &["contact.ground.obstacle.point.2"], 2.0 * STEP);
}

/// Friction depends on the path, and has no derivative yet.
#[test]
fn friction_is_refused() {
    let table = beam(&[BODY, &contact("penalty", FLOOR, "").replace("friction = 0", "friction = 0.3"), AT_REST]);
    for path in ["contact.ground.friction", "contact.ground.obstacle.point.2"] {
        let message = refusal(&table, path);
        assert!(message.contains("the contact ground has friction"), "{path}: {message}");
    }
}
