//! The same body in CalculiX (Dhondt, *The Finite Element Method for Three-Dimensional Thermomechanical Applications*, 2004):
//! C3D4 and C3D10 have one and four points as tet4 and tet10 here, and its `NEO HOOKE` is ψ = C₁₀(J^{−2/3}I₁ − 3) + (J − 1)²/D₁,
//! `neo_hookean_split` with C₁₀ = ½μ and D₁ = 2/κ. So the two discrete problems are one, and every displacement and reaction
//! must agree. Skipped, with a line that says so, where `ccx` is not installed.
//!
//! ccx prints seven digits: half a unit of the last one is 5·10⁻⁷ of a number at worst. Its Newton iteration is made to end at
//! 10⁻⁷ of the mean force.

use crate::common::tools;
use crate::common::{DeadLoad, ORDERS, elastic, hold, law, nodes, ramp, statics};
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::disturb::distort;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::system::System;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

const MODULUS: f64 = 3e5;
const NU: f64 = 0.45;

/// The input of ccx: 1-based nodes and cells, the node order is the same.
fn input(mesh: &TetMesh, held: &[u32], load: &DeadLoad, (modulus, nu): (f64, f64)) -> String {
    let hooke = law("neo_hookean_split", modulus, nu).small_strain();
    let element = if mesh.order == Order::Linear { "C3D4" } else { "C3D10" };
    let mut text = String::from("*NODE, NSET=ALL\n");
    for (k, p) in mesh.points.iter().enumerate() {
        writeln!(text, "{}, {:.11e}, {:.11e}, {:.11e}", k + 1, p.x, p.y, p.z).unwrap();
    }
    writeln!(text, "*ELEMENT, TYPE={element}, ELSET=BODY").unwrap();
    for c in 0..mesh.cell_count() {
        let nodes: Vec<String> = mesh.cell(c).iter().map(|n| (n + 1).to_string()).collect();
        writeln!(text, "{}, {}", c + 1, nodes.join(", ")).unwrap();
    }
    writeln!(text, "*NSET, NSET=HELD").unwrap();
    held.iter().for_each(|k| writeln!(text, "{},", k + 1).unwrap());
    let (c10, d1) = (0.5 * hooke.mu, 2.0 / hooke.kappa);
    writeln!(text, "*MATERIAL, NAME=RUBBER\n*HYPERELASTIC, NEO HOOKE\n{c10:.11e}, {d1:.11e}").unwrap();
    writeln!(text, "*SOLID SECTION, ELSET=BODY, MATERIAL=RUBBER\n*BOUNDARY\nHELD, 1, 3").unwrap();
    writeln!(text, "*STEP, NLGEOM, INC=100\n*STATIC, DIRECT\n0.1, 1.0").unwrap();
    writeln!(text, "*CONTROLS, PARAMETERS=FIELD\n1e-7, 1e-7, , , 1e-7, 1e-7\n*CLOAD").unwrap();
    for (k, f) in load.forces() {
        (0..3).filter(|&i| f[i] != 0.0).for_each(|i| writeln!(text, "{}, {}, {:.11e}", k + 1, i + 1, f[i]).unwrap());
    }
    writeln!(text, "*NODE PRINT, NSET=ALL, FREQUENCY=100\nU\n*NODE PRINT, NSET=HELD, FREQUENCY=100\nRF\n*END STEP")
        .unwrap();
    text
}

/// Displacements of all nodes and reactions of the held ones at the end of the step.
fn results(file: &Path, count: usize) -> [Vec<Vec3>; 2] {
    let text = std::fs::read_to_string(file).expect("ccx writes its results");
    let mut out = [vec![Vec3::zeros(); count], vec![Vec3::zeros(); count]];
    let mut kind = None;
    for line in text.lines() {
        if line.contains("displacements") {
            kind = Some(0);
        } else if line.contains("forces") {
            kind = Some(1);
        }
        let numbers: Vec<f64> = line.split_whitespace().map_while(|w| w.parse().ok()).collect();
        if let (Some(kind), &[node, x, y, z]) = (kind, &numbers[..]) {
            out[kind][node as usize - 1] = Vec3::new(x, y, z);
        }
    }
    out
}

#[test]
fn calculix_gives_the_same_displacements_and_forces() {
    if tools::is_missing(Command::new("ccx").arg("-v").output().is_ok(), "ccx (Debian: calculix-ccx)") {
        return;
    }
    for order in ORDERS {
        // A beam of 60 × 12 × 10 mm, bent sideways by a dead load at its end, cells distorted.
        let mut mesh = block(12, 3, 3, 0.06, 0.012, 0.01, order);
        distort(&mut mesh, 9, 0.1);
        let load = DeadLoad::traction(&mesh, "xmax", ramp(1.0), Vec3::new(0.03, 0.07, 0.2));
        let largest = compare(&mesh, load, (MODULUS, NU));
        assert!(largest > 0.015, "the load bends the beam far: {largest} m");
    }
}

/// The silicone beam of the validation benchmark with the modulus that its records give, ν = 0.49, and 0.51 N spread over its free end.
#[test]
fn beam_of_the_validation() {
    if tools::is_missing(Command::new("ccx").arg("-v").output().is_ok(), "ccx (Debian: calculix-ccx)") {
        return;
    }
    let mesh = block(10, 3, 3, 0.1, 0.03, 0.03, Order::Quadratic);
    let load = DeadLoad::traction(&mesh, "xmax", ramp(1.0), Vec3::new(0.0, 0.0, -0.51012));
    let largest = compare(&mesh, load, (270e3, 0.49));
    assert!((0.005..0.02).contains(&largest), "{largest} m");
}

/// Solves the problem with both programs, which must agree to 1e-5; the largest displacement \[m\].
fn compare(mesh: &TetMesh, load: DeadLoad, constants: (f64, f64)) -> f64 {
    let held = nodes(mesh, "xmin");
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("beam.inp"), input(mesh, &held, &load, constants)).expect("a file is written");
    let run = Command::new("ccx").arg("beam").current_dir(folder.path()).env("OMP_NUM_THREADS", "1").output();
    let run = run.expect("ccx runs");
    // Its exit code does not tell: 201 after a job that ended well.
    let log = String::from_utf8_lossy(&run.stdout);
    assert!(log.contains("Job finished"), "{log}");
    let [u, rf] = results(&folder.path().join("beam.dat"), mesh.points.len());
    let effects = vec![elastic(mesh, law("neo_hookean_split", constants.0, constants.1)), Box::new(load) as _];
    let system = System::new(mesh.points.len(), effects, vec![], hold(&held, &[0, 1, 2])).expect("a system");
    let (state, sums) = statics(mesh, &system, 1e-10, 5);
    let vector = |v: &[f64], k: usize| Vec3::from_column_slice(&v[3 * k..][..3]);
    let worst = |ours: &[f64], theirs: &[Vec3], nodes: &[u32]| {
        let size = nodes.iter().map(|&k| theirs[k as usize].norm()).fold(0.0, larger);
        let error = |&k: &u32| (vector(ours, k as usize) - theirs[k as usize]).norm() / size;
        nodes.iter().map(error).fold(0.0, larger)
    };
    let all: Vec<u32> = (0..mesh.points.len() as u32).collect();
    let (displacement, reaction) = (worst(&state.x, &u, &all), worst(&sums.r, &rf, &held));
    let largest = u.iter().map(|u| u.norm()).fold(0.0, larger);
    let order = mesh.order;
    println!(
        "calculix {order:?}: largest displacement {:.3} mm, displacements {displacement:.1e}, reactions {reaction:.1e}",
        1e3 * largest
    );
    assert!(displacement <= 1e-5 && reaction <= 1e-5, "{order:?}: {displacement:e}, {reaction:e}");
    largest
}
