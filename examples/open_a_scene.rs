//! Opens a scene file, changes some values, runs it, reads columns and a field, and continues from a saved state.
//!
//! The bar of the file does not contract, as its Poisson's ratio is 0: at the stretch λ its force is F = A μ (λ − 1/λ) with μ = ½E, and its
//! stress F/A. Run with `cargo run --release --example open_a_scene`.

use durometer::prelude::*;
use std::path::Path;

/// Cross-section of the bar \[m²\]
const AREA: f64 = 1e-4;
/// Young's modulus after the change \[Pa\]
const E: f64 = 2e6;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = Path::new("examples/bar.toml");

    // Paths as for `--set`: keys, and names, kinds or indices of entries of a list.
    let changed = SceneBuilder::open(file)?.set("laws.rubber.E", "2 MPa")?.set("mesh.grid.divisions", vec![3, 1, 1])?;
    let scene = changed.build()?;
    let run = scene.run_with(RunOptions { save_at: vec![0.5], ..RunOptions::default() });
    assert_eq!(run.status, Status::Converged);

    let force = run.column("xmax_reaction_x_N").expect("the probe records it");
    let last = force[force.len() - 1];
    let exact = AREA * 0.5 * E * (2.0 - 0.5);
    println!("force at twice the length: {last:.4} N, closed form {exact:.4} N");
    assert!((last / exact - 1.0).abs() < 1e-8, "{last} N instead of {exact} N");

    // A stress is returned twice: recovered at the nodes, and as the mean of each cell. It has nine components, σ_xx first.
    let [nodal, cells] = &scene.fields(&run.last, &[FieldSpec::Stress])[..] else { panic!("two fields") };
    assert!(nodal.at_nodes && !cells.at_nodes && cells.name == "stress_Pa" && cells.components == 9);
    assert_eq!(nodal.values.len(), 9 * scene.body.mesh.points.len());
    for stress in nodal.values.chunks_exact(9).chain(cells.values.chunks_exact(9)) {
        assert!((stress[0] * AREA / exact - 1.0).abs() < 1e-6, "{} Pa", stress[0]);
    }

    // The state at 0.5 s is saved to a file; the run that continues from it ends with the same numbers.
    let saved = run.checkpoint("0.5s").expect("it was asked for");
    let folder = tempfile::tempdir()?;
    saved.write(&folder.path().join("half.state"))?;
    let restart = Checkpoint::read(&folder.path().join("half.state"), &scene)?;
    assert_eq!(restart.recorded(), 6);
    let rest = scene.run_with(RunOptions { restart: Some(restart), ..RunOptions::default() });
    assert_eq!(rest.rows, run.rows);

    // The state belongs to the changed scene: the unchanged scene of the file refuses it.
    let unchanged = open_scene(file)?;
    let refused = unchanged.run_with(RunOptions { restart: Some(saved.clone()), ..RunOptions::default() });
    println!("the scene of the file: {}", refused.failure.expect("its modulus and mesh are others"));
    Ok(())
}
