//! Threads within a case: runs on several of them have the bits of a run on one.

use crate::common::{run_with_states, shipped_scene, threads};
use durometer::solve::Status;

/// Every state of a run of a scene of the studies, with these changes.
fn states(scene: &str, changes: &[&str]) -> Vec<f64> {
    let mut states = Vec::new();
    let run = run_with_states(&shipped_scene(scene, changes), &mut |state| {
        states.extend(state.x.iter().chain(&state.v).chain(&state.lambda).chain(&state.history));
    });
    assert_eq!(run.status, Status::Converged);
    states
}

/// Also where a number of threads does not divide the parts, and where there are more threads than parts or processors.
const COUNTS: [usize; 3] = [2, 3, 8];
/// For runs that take seconds.
const ONE_COUNT: [usize; 1] = [3];

fn have_the_same_bits(scene: &str, changes: &[&str], counts: &[usize]) {
    let of_one = threads::on(1, || states(scene, changes));
    assert!(of_one.len() > 1000);
    for &count in counts {
        let of_more = threads::on(count, || states(scene, changes));
        let same =
            of_one.len() == of_more.len() && of_one.iter().zip(&of_more).all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(same, "{scene} {changes:?}: {count} threads");
    }
}

const TWO_STEPS: [&str; 2] = ["stage.0.duration=\"0.2 s\"", "stage.0.dt=\"0.1 s\""];

#[test]
fn with_a_cable_and_a_lagged_factor() {
    have_the_same_bits("finger-convergence", &[&TWO_STEPS[..], &["mesh.cells=16200"]].concat(), &COUNTS);
}

#[test]
fn with_pressures() {
    let changes = ["mesh.cells=1100", "mesh.element=tet10", "effect.elastic.formulation=mixed"];
    have_the_same_bits("finger-convergence", &[&TWO_STEPS[..], &changes].concat(), &COUNTS);
}

#[test]
fn with_the_iterative_method() {
    let changes = ["mesh.cells=16200", "numerics.linear=iterative"];
    have_the_same_bits("finger-convergence", &[&TWO_STEPS[..], &changes].concat(), &ONE_COUNT);
}

#[test]
fn with_pressures_and_the_iterative_method() {
    // 8 177 nodes: the finest level has several parts
    let changes =
        ["mesh.cells=4500", "mesh.element=tet10", "effect.elastic.formulation=mixed", "numerics.linear=iterative"];
    have_the_same_bits("finger-convergence", &[&TWO_STEPS[..], &changes].concat(), &ONE_COUNT);
}

#[test]
fn in_time_with_friction() {
    let changes = ["mesh.cells=1770", "stage.0.duration=\"0.05 s\""];
    have_the_same_bits("finger-cube", &changes, &COUNTS);
}
