//! The steps of a stage: how many there are late in a run, how often one is cut, and what stops them that is no number.

use crate::common::{DeadLoad, column, elastic, hold, law, newton, nodes, ramp, run, scene};
use durometer::math::tensor::Vec3;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::solve::{Driver, Integrator, MOST_CUTS, Status, StepSettings, TimeSpan};
use durometer::system::{Effect, Prescribed, State, System};

/// An hour of rest, then 0.3 s in steps of 0.1 ms: 3000 of them, although (end − start)/dt carries the rounding of 3600.3 s, 2e-9 steps.
#[test]
fn a_late_stage_has_the_steps_of_an_early_one() {
    let text = r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "inertia"
region = "body"
density = "1000 kg/m^3"
mass = "lumped"
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "60 min"
dt = "60 min"
[[stage]]
integrator = { kind = "generalised_alpha", rho = 0.8 }
duration = "0.3 s"
dt = "0.1 ms"
[[probe]]
kind = "position"
region = "xmax"
"#;
    let run = run(&scene(block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear), text));
    assert_eq!((&run.status, run.totals.steps), (&Status::Converged, 3001));
    let times = column(&run, "t_s");
    assert_eq!(times.len(), 3002, "the start, the rest, and every step");
    // Both times of a step are rounded to ε t.
    let rounding = 2.0 * f64::EPSILON * 3600.3;
    assert!(times[1..].windows(2).all(|t| (t[1] - t[0] - 1e-4).abs() <= rounding));
}

fn cube() -> TetMesh {
    block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear)
}

/// A clamped cube with further motions and loads.
fn system(mesh: &TetMesh, motion: Vec<Prescribed>, load: Option<Box<dyn Effect>>) -> System {
    let effects = std::iter::once(elastic(mesh, law("neo_hookean", 1e5, 0.3))).chain(load).collect();
    let held = [hold(&nodes(mesh, "xmin"), &[0, 1, 2]), motion].concat();
    System::new(mesh.points.len(), effects, vec![], held).expect("a system")
}

/// The status of one step from `start` to `end`, and its cuts.
fn one_step(system: &System, integrator: Integrator, [start, end]: [f64; 2], cuts: u32) -> (Status, usize) {
    let settings = StepSettings { cuts, ..StepSettings::default() };
    let mut driver = Driver::new(system, newton(system, 1e-8, 0.01), settings);
    let mut state = State { t: start, ..system.rest() };
    let span = TimeSpan { integrator, start, end, dt: end - start };
    let status = driver.run(span, &mut state, &mut ());
    (status, driver.totals.cuts)
}

/// A step that never succeeds is halved as often as is asked for, at most 40 times, and late in a run only as long as its parts are
/// longer than 16 times the rounding ε t of the time.
#[test]
fn cuts_end_where_nothing_is_left_of_a_step() {
    let mesh = cube();
    let corner = nodes(&mesh, "xmax")[0];
    let system = system(&mesh, vec![Prescribed { dof: 3 * corner, signal: ramp(f64::NAN) }], None);
    let cuts = |start: f64, asked: u32| one_step(&system, Integrator::Static, [start, start + 1e-3], asked).1;
    assert_eq!(cuts(1.0, 3), 3);
    assert_eq!(cuts(1.0, 64), (1e-3 / (16.0 * f64::EPSILON * 1.001_f64)).log2() as usize);
    assert_eq!(cuts(86400.0, 64), (1e-3 / (16.0 * f64::EPSILON * 86400.001_f64)).log2() as usize);
    assert_eq!(one_step(&system, Integrator::Static, [0.0, 1e-3], 64).1, MOST_CUTS as usize);
}

/// A motion or a load that is no number between two points of the time grid is named, by every way through time; it is no buckling and no
/// matter of stiffnesses.
#[test]
fn inputs_that_are_no_numbers_are_named() {
    let mesh = cube();
    let corner = nodes(&mesh, "xmax")[0];
    let moved = system(&mesh, vec![Prescribed { dof: 3 * corner, signal: ramp(f64::NAN) }], None);
    let forces = vec![Vec3::new(1.0, 0.0, 0.0); mesh.points.len()];
    let loaded = system(&mesh, vec![], Some(Box::new(DeadLoad::new(&forces, ramp(f64::NAN)))));
    let integrators = [
        Integrator::Static,
        Integrator::ArcLength { max_steps: 5 },
        Integrator::ImplicitEuler { linearised: true },
        Integrator::FreeMotion { integration_steps: 1 },
        Integrator::Bdf2,
    ];
    for integrator in integrators {
        for (system, column) in [(&moved, format!("the displacement of node {corner}")), (&loaded, "dead_load".into())]
        {
            let (status, _) = one_step(system, integrator, [0.0, 1.0], 3);
            assert_eq!(status, Status::NotFinite { t: 0.0, column }, "{integrator:?}");
            assert!(status.to_string().contains("is not a finite number"), "{status}");
        }
    }
}
