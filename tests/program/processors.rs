//! Processors without wide vectors: the program runs on one (emulated by QEMU), and gives the same answer.

#![cfg(target_arch = "x86_64")]

use crate::common::tools;
use durometer::math::statistics::larger;
use std::path::Path;
use std::process::Command;

const PROGRAM: &str = env!("CARGO_BIN_EXE_durometer");

/// A beam under its own weight, of quadratic cells with pressures, whose tangents and factors use every kernel.
const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [4, 2, 2] }
element = "tet10"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.49
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "mixed"
[[effect]]
kind = "gravity"
region = "body"
density = "1070 kg/m^3"
direction = [0, 0, -1]
acceleration = "9.81 m/s^2"
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
[[probe]]
kind = "position"
region = "xmax"
[[probe]]
kind = "energy"
"#;

/// Kernels of this program have the same bits with any vectors (`math::lanes`). The factorisation by faer uses fused products and sums where the
/// processor has them: rounding of 1e-16, times the condition of the tangent, 1e5 here, times 100.
const TOLERANCE: f64 = 1e-9;

#[test]
fn a_processor_without_avx2_gives_the_same_answer() {
    let emulator = "qemu-x86_64";
    let found = Command::new(emulator).arg("--version").output().is_ok_and(|output| output.status.success());
    if tools::is_missing(found, "qemu-x86_64 (Debian package qemu-user)") {
        return;
    }
    let keep = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(keep.path().join("scene.toml"), SCENE).expect("room");
    let arguments = ["simulate", "scene.toml", "--no-view", "--out"];
    let rows = |mut command: Command, folder: &str| {
        let output = command.args(arguments).arg(folder).current_dir(keep.path()).output().expect("it starts");
        assert!(output.status.success(), "{folder}: {}", String::from_utf8_lossy(&output.stderr));
        last_row(&keep.path().join(folder).join("scene.csv"))
    };
    let here = rows(Command::new(PROGRAM), "here");
    for processor in ["Westmere", "Haswell"] {
        let mut emulated = Command::new(emulator);
        emulated.args(["-cpu", processor, PROGRAM]);
        let there = rows(emulated, processor);
        let far = here.iter().zip(&there).map(|(a, b)| (a - b).abs() / a.abs().max(1e-12)).fold(0.0, larger);
        println!("{processor}: {far:.1e}");
        assert!(here.len() == there.len() && far < TOLERANCE, "{processor}: {here:?} {there:?}");
    }
}

fn last_row(file: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(file).expect("a table");
    let row = text.lines().last().expect("a row");
    row.split(',').map(|value| value.parse().expect("a number")).collect()
}
