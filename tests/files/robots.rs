//! Robots from files (`studies/trunk` and others): each is still read from its file, meshed where it has to be, and built.

use crate::common::program::{ROOT, durometer};
use crate::common::tools;
use std::path::Path;

/// The study and its scene are not refused, and these things are said about the scene.
#[track_caller]
fn check(study: &str, said: &[&str]) {
    if tools::is_missing(durometer(ROOT, &["doctor"]).is_success(), "the mesher (durometer doctor --setup)") {
        return;
    }
    let read = |name: &str| {
        let file = Path::new("studies").join(study).join(name);
        let output = durometer(ROOT, &["check", &file.to_string_lossy()]);
        assert!(output.is_success(), "{study}: {}", output.err);
        output.out
    };
    read("study.toml");
    let out = read("scene.toml");
    let missing: Vec<&&str> = said.iter().filter(|words| !out.contains(**words)).collect();
    assert!(missing.is_empty(), "{study} does not say {missing:?}:\n{out}");
}

/// From STEP: eight cables, four of them through the first five discs only.
#[test]
fn trunk() {
    check("trunk", &["40.0000 × 40.0000 × 180.0000 mm", "long_south (11 blocks)", "short_south (5 blocks)"]);
}

/// From STEP: the hollow is found as the inner component of the surface.
#[test]
fn bellows() {
    check("bellows", &["× 50.0000 mm", "formulation mixed", "cavity_imposed_pressure_Pa"]);
}

/// From VTU: the cells of another mesher, unchanged.
#[test]
fn parallel_robot() {
    check(
        "parallel-robot",
        &["4032 cells, 8400 nodes", "load (248 blocks)", "east (exact row with multiplier, 1 blocks)"],
    );
}

/// From Abaqus input: its node sets are regions.
#[test]
fn tripod() {
    check("tripod", &["1919 cells, 4082 nodes", "HORN_3", "HORN_1_rotation_rad"]);
}

/// From STEP, with threads in the wall.
#[test]
fn wound_actuator() {
    check("wound-actuator", &["90.0000 × ", "2 helices of each hand", "along 3 polyline(s)"]);
}

/// From a hollow surface: two shells, of which the inner one is the hollow, and a membrane on the palm.
#[test]
fn pneunet_gripper() {
    check("pneunet-gripper", &["96.0000 × 16.0000 × 20.0000 mm", "cloth (", "0.1000 mm thick", "bar_force_z_N"]);
}
