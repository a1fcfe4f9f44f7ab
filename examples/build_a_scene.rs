//! Builds a scene in Rust, without a file, and compares its force with the closed-form solution of uniaxial tension.
//!
//! A bar of Neo-Hookean rubber with Poisson's ratio 0 is pulled to twice its length. It does not contract, so its stretch
//! λ is uniform although one end is clamped, and ψ = ½μ(I₁ − 3) − μ ln J gives the force F = A μ (λ − 1/λ) with μ = ½E.
//! Run with `cargo run --release --example build_a_scene`.

use durometer::prelude::*;
use durometer::scene::spec::*;

/// Length, width and height \[m\]
const SIZE: [f64; 3] = [0.03, 0.01, 0.01];
/// Young's modulus \[Pa\]
const E: f64 = 1e6;

/// Builds the scene from the types into which a scene file is read: a list for each of its tables, quantities in SI.
fn bar() -> Result<SceneSpec, Box<dyn std::error::Error>> {
    let law = format!("law = 'neo_hookean'\nE = '{E} Pa'\nnu = 0").parse()?;
    Ok(SceneSpec {
        mesh: MeshSpec {
            // A grid has the regions body, xmin, xmax, ymin, ymax, zmin and zmax.
            grid: Some(GridSpec::Box { size: SIZE.map(Length::metres), divisions: [3, 1, 1] }),
            ..MeshSpec::default()
        },
        laws: [("rubber".to_string(), law)].into(),
        effects: vec![
            ElasticSpec {
                region: "body".into(),
                law: "rubber".into(),
                formulation: FormulationSpec::Displacement,
                overlap: None,
            }
            .into(),
        ],
        constraints: vec![
            FixedSpec { region: "xmin".into(), components: "xyz".into() }.into(),
            PrescribedSpec {
                region: "xmax".into(),
                components: "x".into(),
                // From 0 at t = 0 s to the length of the bar at t = 1 s
                displacement: Some(SignalSpec::ramp(0.0, SIZE[0], 0.0, 1.0)),
                ..PrescribedSpec::default()
            }
            .into(),
        ],
        stages: vec![StageSpec::new(IntegratorSpec::Static, Time::seconds(1.0), Time::seconds(0.1))],
        probes: vec![Reaction { region: "xmax".into() }.into()],
        ..SceneSpec::default()
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::new(bar()?)?;
    let run = scene.run();
    assert_eq!(run.status, Status::Converged);

    let time = run.column("t_s").expect("always recorded");
    let force = run.column("xmax_reaction_x_N").expect("the probe records it");
    let (area, mu) = (SIZE[1] * SIZE[2], 0.5 * E);
    for (t, force) in time.iter().zip(&force) {
        let stretch = 1.0 + t;
        let exact = area * mu * (stretch - 1.0 / stretch);
        println!("λ = {stretch:.1}   force {force:8.4} N   closed form {exact:8.4} N");
        assert!((force - exact).abs() < 1e-8 * area * mu, "{force} N instead of {exact} N");
    }
    Ok(())
}
