//! Cables: duality of tension and length, slack, overpull, two at once, objectivity, work, and the mesh.

use crate::common;
use crate::common::{column, elastic, hold, law, newton, nodes, ramp, run, scene};
use durometer::effect::{Cable, CableLength, CableTension, Guide};
use durometer::math::linear::Factor;
use durometer::math::low_rank::{LowRank, Pattern};
use durometer::math::signal::Signal;
use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::math::vector::norm;
use durometer::mesh::ball::ball_weights;
use durometer::mesh::disturb::distort;
use durometer::mesh::embed::embed;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::scene::overrides::parse;
use durometer::scene::{Body, Scene, read_scene};
use durometer::solve::{
    AcceptedStep, Driver, Integrator, NewtonSettings, NonlinearSolver, Status, Step, StepSettings, TimeSpan,
};
use durometer::system::{Constraint, Effect, State, System, Want};
use std::sync::Arc;

/// 100 × 15 × 15 mm, clamped at x = 0.
fn beam(nx: usize, n: usize, order: Order) -> TetMesh {
    block(nx, n, n, 0.1, 0.015, 0.015, order)
}

/// A straight cable at height z through guides every 20 mm, `radius` None for points. Its pull point lies 10 mm behind the clamp.
fn cable(mesh: &TetMesh, z: f64, radius: Option<f64>) -> Arc<Cable> {
    let guide = |x: f64| {
        let point = Vec3::new(x, 0.0075, z);
        let weights = match radius {
            Some(r) => ball_weights(mesh, point, r).expect("inside"),
            None => embed(mesh, point).expect("inside").weights,
        };
        Guide { point, weights }
    };
    let guides = [0.015, 0.035, 0.055, 0.075, 0.095].map(guide);
    Arc::new(Cable::new("cable".into(), Vec3::new(-0.01, 0.0075, z), guides.into()))
}

/// L(x) \[m\]
fn length(cable: &Cable, x: &[f64]) -> f64 {
    cable.lengths(x).iter().sum()
}

fn by_length(mesh: &TetMesh, cable: &Arc<Cable>, shortening: Signal) -> Box<dyn Constraint> {
    let rest = length(cable, &vec![0.0; 3 * mesh.points.len()]);
    Box::new(CableLength { cable: cable.clone(), shortening, rest, compliance: 0.0, most: f64::INFINITY })
}

fn by_tension(cable: &Arc<Cable>, tension: Signal) -> Box<dyn Effect> {
    Box::new(CableTension { cable: cable.clone(), tension })
}

fn system(mesh: &TetMesh, loads: Vec<Box<dyn Effect>>, rows: Vec<Box<dyn Constraint>>) -> System {
    let mut effects = vec![elastic(mesh, law("neo_hookean", 1e5, 0.45))];
    effects.extend(loads);
    System::new(mesh.points.len(), effects, rows, hold(&nodes(mesh, "xmin"), &[0, 1, 2])).expect("a clamped beam")
}

/// Every accepted state of a quasi-static run over [0, 1].
fn states(mesh: &TetMesh, system: &System, tolerance: f64, steps: usize) -> (Vec<State>, Status) {
    let mut driver = Driver::new(system, newton(system, tolerance, mesh.diagonal()), StepSettings::default());
    let mut state = State::rest(mesh.points.len(), system.constraints.len());
    let span = TimeSpan { integrator: Integrator::Static, start: 0.0, end: 1.0, dt: 1.0 / steps as f64 };
    let mut all = Vec::new();
    let status = driver.run(span, &mut state, &mut |step: &AcceptedStep| {
        let AcceptedStep { now, .. } = *step;
        all.push(now.clone());
        true
    });
    (all, status)
}

fn last(mesh: &TetMesh, system: &System, tolerance: f64, steps: usize) -> State {
    let (mut all, status) = states(mesh, system, tolerance, steps);
    assert_eq!(status, Status::Converged);
    all.pop().expect("at least one step")
}

const RADIUS: f64 = 0.005;

/// Impose lengths of two cables, take the tensions, impose those, and get the lengths back; with one cable and with two.
/// Both runs solve to 1e-12 of the internal forces, and a beam bent by millimetres turns that into at most 1e-9 L.
#[test]
fn length_and_tension_are_dual() {
    for order in common::ORDERS {
        let mesh = beam(12, 2, order);
        for pulls in [&[0.006][..], &[0.006, 0.005]] {
            let cables: Vec<_> =
                [0.003, 0.012].iter().zip(pulls).map(|(z, _)| cable(&mesh, *z, Some(RADIUS))).collect();
            let rows = cables.iter().zip(pulls).map(|(c, d)| by_length(&mesh, c, ramp(*d))).collect();
            let first = last(&mesh, &system(&mesh, vec![], rows), 1e-12, 4);
            assert!(first.lambda.iter().all(|t| *t > 0.01), "both cables are taut: {:?}", first.lambda);
            let loads = cables.iter().zip(&first.lambda).map(|(c, t)| by_tension(c, ramp(*t))).collect();
            let second = last(&mesh, &system(&mesh, loads, vec![]), 1e-12, 4);
            for (c, pull) in cables.iter().zip(pulls) {
                let rest = length(c, &vec![0.0; first.x.len()]);
                let (a, b) = (length(c, &first.x), length(c, &second.x));
                println!("duality {order:?}: T = {:?} N, lengths differ by {:.1e}", first.lambda, (a - b) / rest);
                assert!((a - (rest - pull)).abs() <= 1e-8 * rest, "the length is imposed");
                assert!((a - b).abs() <= 1e-8 * rest, "{order:?}: {a} by length, {b} by tension");
            }
            // And back: the length that the tension gave needs that tension.
            let rows = cables
                .iter()
                .map(|c| by_length(&mesh, c, ramp(length(c, &vec![0.0; first.x.len()]) - length(c, &second.x))))
                .collect();
            let third = last(&mesh, &system(&mesh, vec![], rows), 1e-12, 4);
            for (a, b) in first.lambda.iter().zip(&third.lambda) {
                assert!((a / b - 1.0).abs() <= 1e-8, "{order:?}: tension {a} N came back as {b} N");
            }
        }
    }
}

/// Pulled, released beyond the free length, pulled again. T ≥ 0 always, T · gap ≤ 1e-8 of T L, and the body
/// is at rest while the cable is slack.
#[test]
fn a_released_cable_is_slack_and_never_pushes() {
    let mesh = beam(12, 2, Order::Quadratic);
    let cable = cable(&mesh, 0.003, Some(RADIUS));
    let shortening = Signal::Sine { amplitude: 0.005, frequency: 1.5, phase: 0.0 };
    let system = system(&mesh, vec![], vec![by_length(&mesh, &cable, shortening.clone())]);
    let (all, status) = states(&mesh, &system, 1e-8, 30);
    assert_eq!(status, Status::Converged);
    let rest = length(&cable, &vec![0.0; 3 * mesh.points.len()]);
    let strongest = all.iter().map(|s| s.lambda[0]).fold(0.0, larger);
    let (mut slack, mut taut) = (0, 0);
    for state in &all {
        let (tension, pull) = (state.lambda[0], shortening.at(state.t));
        let gap = rest - pull - length(&cable, &state.x);
        assert!(tension >= 0.0, "T = {tension} N at {} s", state.t);
        assert!(gap >= -1e-8 * rest, "the cable is {gap} m too long at {} s", state.t);
        assert!(tension * gap.abs() <= 1e-8 * strongest * rest, "T = {tension} N, gap {gap} m at {} s", state.t);
        if pull < -1e-6 {
            slack += 1;
            assert_eq!(tension, 0.0, "slack at {} s", state.t);
            assert!(common::largest(&state.x) <= 1e-8 * rest, "at rest while slack: {:e}", common::largest(&state.x));
        } else if pull > 1e-6 {
            taut += 1;
            assert!(tension > 0.0, "taut at {} s", state.t);
        }
    }
    println!("slack: {slack} states slack, {taut} taut, T up to {strongest} N");
    assert!(slack >= 8 && taut >= 16);
}

/// Shortened by more than its whole length. A status and the last good state, no NaN.
#[test]
fn overpull_ends_with_a_status_and_the_last_good_state() {
    for name in ["neo_hookean", "stable_neo_hookean"] {
        let mesh = beam(8, 1, Order::Linear);
        let cable = cable(&mesh, 0.003, Some(RADIUS));
        let rest = length(&cable, &vec![0.0; 3 * mesh.points.len()]);
        let effects = vec![elastic(&mesh, law(name, 1e5, 0.45))];
        let rows = vec![by_length(&mesh, &cable, ramp(1.2 * rest))];
        let system = System::new(mesh.points.len(), effects, rows, hold(&nodes(&mesh, "xmin"), &[0, 1, 2])).unwrap();
        let (all, status) = states(&mesh, &system, 1e-8, 24);
        let good = all.last().expect("the first pulls are possible");
        println!("overpull {name}: {} after {:.1} mm", status.name(), 1e3 * 1.2 * rest * good.t);
        let stopped =
            matches!(status, Status::StepTooSmall { .. } | Status::Inverted { .. } | Status::NoEquilibrium { .. });
        assert!(stopped, "{name}: {status:?}");
        assert!(good.x.iter().chain(&good.lambda).all(|v| v.is_finite()), "{name}");
        let gap = rest * (1.0 - 1.2 * good.t) - length(&cable, &good.x);
        assert!(gap.abs() <= 1e-8 * rest, "{name}: the last state keeps the length: {gap:e} m");
        assert!(good.t > 0.2 && good.lambda[0] > 0.0, "{name}: ended at {}", good.t);
    }
}

/// Σ w = 1 and Σ w X = X_k: a rigid motion of the body with its pull point leaves the length as it is.
#[test]
fn rigid_motion_leaves_the_length() {
    let q = nalgebra::Rotation3::from_euler_angles(0.4, -1.1, 2.0).into_inner();
    let shift = Vec3::new(0.3, -0.2, 0.1);
    for radius in [None, Some(RADIUS)] {
        let mut mesh = beam(10, 3, Order::Quadratic);
        distort(&mut mesh, 2, 0.1);
        let weights = |p: Vec3| match radius {
            Some(r) => ball_weights(&mesh, p, r).expect("inside"),
            None => embed(&mesh, p).expect("inside").weights,
        };
        let points = [Vec3::new(0.02, 0.004, 0.003), Vec3::new(0.06, 0.009, 0.012), Vec3::new(0.098, 0.001, 0.014)];
        let guides: Vec<_> = points.iter().map(|&point| Guide { point, weights: weights(point) }).collect();
        let pull = Vec3::new(-0.02, 0.01, 0.02);
        let before = Cable::new("at rest".into(), pull, guides.clone());
        let after = Cable::new("moved".into(), q * pull + shift, guides);
        let moved: Vec<f64> = mesh.points.iter().flat_map(|p| Vec::from((q * p + shift - p).as_slice())).collect();
        let (a, b) = (length(&before, &vec![0.0; moved.len()]), length(&after, &moved));
        // Coordinates of 0.5 m carry a rounding of 1e-16 m each, sums of a hundred of them.
        assert!((a - b).abs() <= 1e-13, "{radius:?}: {a} before, {b} after");
        // An affine motion is followed by the guides as by material points.
        let h = Mat3::new(0.1, 0.2, -0.1, 0.0, -0.2, 0.1, 0.3, 0.1, 0.1);
        let x: Vec<f64> = mesh.points.iter().flat_map(|p| Vec::from((h * p).as_slice())).collect();
        for (at, point) in before.polyline(&x)[1..].iter().zip(points) {
            assert!((at - (point + h * point)).norm() <= 1e-13, "{radius:?}");
        }
    }
}

/// A slow cycle with nothing that dissipates: the work of the cable is the elastic energy, and all of it comes back. The
/// work is summed by the trapezoidal rule over 2 × 40 steps: its error is T″ d²/12n² ≈ 1/(12·40²) of the work (half-sine:
/// at most π² times that), 1e-3 of the peak; halving the step must quarter it.
#[test]
fn work_of_the_cable_is_the_elastic_energy() {
    let mismatch = |dt: &str| {
        let text = format!(
            r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["35 mm", "7.5 mm", "3 mm"], ["65 mm", "7.5 mm", "3 mm"], ["95 mm", "7.5 mm", "3 mm"]]
pull_point = ["-10 mm", "7.5 mm", "3 mm"]
guide_radius = "5 mm"
drive = {{ kind = "length", signal = {{ kind = "raised_cosine", amplitude = "8 mm", frequency = "1 Hz" }} }}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "{dt}"
[[probe]]
kind = "energy"
"#
        );
        let scene = scene(beam(10, 2, Order::Quadratic), &text);
        let result = run(&scene);
        assert_eq!(result.status, Status::Converged);
        let (elastic, work) = (column(&result, "elastic_J"), column(&result, "work_J"));
        let peak = elastic.iter().copied().fold(0.0, larger);
        let tension = column(&result, "cable_tension_N");
        assert!(elastic.last().unwrap().abs() <= 1e-8 * peak && tension.last().unwrap().abs() < 1e-6, "back at rest");
        let worst = elastic.iter().zip(&work).map(|(e, w)| (e - w).abs()).fold(0.0, larger) / peak;
        println!("cable work, dt = {dt}: peak {peak:.4e} J, mismatch {worst:.1e}");
        worst
    };
    let (coarse, fine) = (mismatch("0.025 s"), mismatch("0.0125 s"));
    assert!(coarse <= 1e-3, "work and energy differ by {coarse:e} of the peak");
    assert!((coarse / fine - 4.0).abs() < 1.0, "second order in dt: {coarse:e}, {fine:e}");
}

/// Design §4: a point force in three dimensions has infinite compliance, so the bend per pull of a cable through points
/// keeps falling with h, while a patch has a limit. 2 mm of pull, tet10, h = 7.5, 5 and 3.75 mm.
#[test]
fn the_patch_converges_and_the_point_drifts() {
    let bend = |n: usize, radius| {
        let mesh = beam(20 * n / 3, n, Order::Quadratic);
        let rows = vec![by_length(&mesh, &cable(&mesh, 0.003, radius), ramp(0.002))];
        let state = last(&mesh, &system(&mesh, vec![], rows), 1e-8, 1);
        let end = nodes(&mesh, "xmax");
        end.iter().map(|&k| state.x[3 * k as usize + 2]).sum::<f64>() / end.len() as f64
    };
    let patch = [2, 3, 4].map(|n| bend(n, Some(RADIUS)));
    let point = [2, 3, 4].map(|n| bend(n, None));
    let changes = |v: [f64; 3]| [0, 1].map(|k| (v[k + 1] / v[k] - 1.0).abs());
    let (a, b) = (changes(patch), changes(point));
    println!("tip deflection [m]: patch {patch:?}, changes {a:?}; point {point:?}, changes {b:?}");
    assert!(a.iter().all(|c| *c < 0.001), "the patch moves by less than 0.1 %: {a:?}");
    assert!((point[2] / point[0] - 1.0).abs() > 5.0 * (patch[2] / patch[0] - 1.0).abs(), "{point:?} against {patch:?}");
    assert!(b[1] > 10.0 * a[1], "the point still drifts on the finest pair: {b:?} against {a:?}");
}

/// A clamp that moves carries the guides next to it: the first Newton iteration from rest already meets the length to
/// second order, δ²/l ≈ (1e-5)²/0.02 = 5e-4 δ.
#[test]
fn a_moving_clamp_carries_its_guides() {
    let mesh = beam(10, 2, Order::Linear);
    let delta = 1e-5;
    let weights = |x| ball_weights(&mesh, Vec3::new(x, 0.0075, 0.004), RADIUS).expect("inside");
    let guide = |x| Guide { point: Vec3::new(x, 0.0075, 0.004), weights: weights(x) };
    let cable = Arc::new(Cable::new("cable".into(), Vec3::new(-0.02, 0.0075, 0.004), [0.002, 0.09].map(guide).into()));
    let clamp = common::move_to(&mesh, &nodes(&mesh, "xmin"), |_| Vec3::new(delta, 0.0, 0.5 * delta));
    let effects = vec![elastic(&mesh, law("neo_hookean", 1e5, 0.45))];
    let system = System::new(mesh.points.len(), effects, vec![by_length(&mesh, &cable, ramp(delta))], clamp).unwrap();
    let settings = NewtonSettings {
        tolerance: 1e-14,
        max_iterations: 1,
        line_search: false,
        reuse_factor: false,
        ..NewtonSettings::default()
    };
    let mut once = NonlinearSolver::new(&system, settings, mesh.diagonal());
    let past = State::rest(mesh.points.len(), 1);
    let mut next = State { t: 1.0, ..past.clone() };
    let step = Step { system: &system, integrator: Integrator::Static, past: &past, dt: 1.0 };
    assert!(once.solve(&step, &mut next).is_err(), "one iteration is not enough for 1e-14");
    println!("gap after one iteration: {:e} m, T = {} N", once.equations.sums.g[0], next.lambda[0]);
    assert!(
        next.lambda[0] > 0.0 && once.equations.sums.g[0].abs() <= 2e-3 * delta,
        "gap {:e} m",
        once.equations.sums.g[0]
    );
}

/// A scene of the beam with one cable of these keys, pulled as `drive` says.
fn beam_scene(keys: &str, drive: &str, dt: &str) -> durometer::scene::Scene {
    let text = format!(
        r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
name = "tendon"
guides = [["35 mm", "7.5 mm", "3 mm"], ["65 mm", "7.5 mm", "3 mm"], ["95 mm", "7.5 mm", "3 mm"]]
pull_point = ["-10 mm", "7.5 mm", "3 mm"]
guide_radius = "5 mm"
drive = {drive}
{keys}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "{dt}"
[[probe]]
kind = "energy"
"#
    );
    scene(beam(10, 2, Order::Linear), &text)
}

fn ramp_to(quantity: &str, to: f64, unit: &str) -> String {
    format!(
        "{{ kind = \"{quantity}\", signal = {{ kind = \"ramp\", from = \"0 {unit}\", to = \"{to:.17e} {unit}\", end = \"1 s\" }} }}"
    )
}

/// An elastic cable pulled by d is a stiff one pulled by d − T L₀/EA: the same body, the same tension. Then the tension
/// alone gives the length back. All are solved to 1e-8 of forces some tens of the tension.
#[test]
fn an_elastic_cable_gives_way_by_its_stretch() {
    let (rest, ea, pull) = (0.105, 8.0, 0.01);
    let last = |keys: &str, drive: String| {
        let result = run(&beam_scene(keys, &drive, "0.25 s"));
        assert_eq!(result.status, Status::Converged);
        ["tendon_tension_N", "tendon_length_m"].map(|name| *column(&result, name).last().expect("rows"))
    };
    let [tension, length] = last(&format!("EA = \"{ea} N\""), ramp_to("length", pull, "m"));
    let stretch = tension * rest / ea;
    println!("elastic cable: T = {tension:.6} N, stretched by {:.3} mm", 1e3 * stretch);
    assert!(stretch > 1e-4, "it stretches by more than the tolerance: {stretch}");
    assert!((length - (rest - pull + stretch)).abs() <= 1e-8 * rest, "the row holds: {length}");
    let [stiff, _] = last("", ramp_to("length", pull - stretch, "m"));
    assert!((tension / stiff - 1.0).abs() <= 1e-6, "{tension} N elastic, {stiff} N stiff");
    let [_, back] = last("", ramp_to("tension", tension, "N"));
    assert!((back / length - 1.0).abs() <= 1e-6, "{length} m by length, {back} m by tension");
}

/// The energy of an elastic cable is in the balance: work = elastic_J, with ½T²L₀/EA in it, up to the trapezoidal rule (1e-3 of
/// the peak, as for the stiff cable above).
#[test]
fn the_stretch_of_a_cable_is_stored() {
    let drive = r#"{ kind = "length", signal = { kind = "raised_cosine", amplitude = "10 mm", frequency = "1 Hz" } }"#;
    let result = run(&beam_scene("EA = \"8 N\"", drive, "0.025 s"));
    assert_eq!(result.status, Status::Converged);
    let (elastic, work) = (column(&result, "elastic_J"), column(&result, "work_J"));
    let peak = elastic.iter().copied().fold(0.0, larger);
    let own = column(&result, "tendon_tension_N").iter().map(|t| 0.5 * t * t * 0.105 / 8.0).fold(0.0, larger);
    let worst = elastic.iter().zip(&work).map(|(e, w)| (e - w).abs()).fold(0.0, larger) / peak;
    println!("stored in the cable {:.1} % of the peak, mismatch {worst:.1e}", 100.0 * own / peak);
    assert!(own > 0.02 * peak && worst <= 1e-3, "{worst:e}");
    assert!(elastic[elastic.len() - 1].abs() <= 1e-8 * peak, "all of it comes back");
}

/// A drive that yields: T ≤ T_max; while it yields the body is that of the prescribed tension T_max, and what is drawn in is
/// less than what was asked for; before and after the length is imposed. Work and energy balance all the same (1e-3, as above).
#[test]
fn a_limited_drive_yields_and_follows_again() {
    let (limit, rest) = (0.5, 0.105);
    let drive = r#"{ kind = "length", signal = { kind = "raised_cosine", amplitude = "10 mm", frequency = "1 Hz" } }"#;
    let result = run(&beam_scene(&format!("max_tension = \"{limit} N\""), drive, "0.025 s"));
    assert_eq!(result.status, Status::Converged);
    let free = run(&beam_scene("", &ramp_to("tension", limit, "N"), "0.25 s"));
    let at_limit = *column(&free, "tendon_length_m").last().expect("rows");
    let [time, tension, length, drawn] =
        ["t_s", "tendon_tension_N", "tendon_length_m", "tendon_drawn_m"].map(|name| column(&result, name));
    let mut yielding = 0;
    for k in 1..time.len() {
        let asked = 0.01 * (std::f64::consts::PI * time[k]).sin().powi(2);
        assert!((0.0..=limit).contains(&tension[k]), "T = {} N", tension[k]);
        if tension[k] >= limit * (1.0 - 1e-9) {
            yielding += 1;
            assert!((length[k] / at_limit - 1.0).abs() <= 1e-6 && drawn[k] < asked, "t = {}", time[k]);
        } else {
            assert!((length[k] - (rest - asked)).abs() <= 1e-8 * rest, "t = {}: {} m", time[k], length[k]);
        }
        assert!((drawn[k] - (rest - length[k])).abs() <= 1e-12 * rest, "it does not stretch");
    }
    let kinds: Vec<&str> = result.cable_events.iter().map(|e| e.what.name()).collect();
    println!("yields in {yielding} of {} states, events {:?}", time.len(), result.cable_events);
    assert!(yielding > 5 && yielding < 35);
    assert_eq!(&kinds[..2], ["yielding", "taut"]);
    let (elastic, work) = (column(&result, "elastic_J"), column(&result, "work_J"));
    let peak = elastic.iter().copied().fold(0.0, larger);
    let worst = elastic.iter().zip(&work).map(|(e, w)| (e - w).abs()).fold(0.0, larger) / peak;
    assert!(worst <= 1e-3, "work and energy differ by {worst:e} of the peak");
}

/// Slack in and out of a sine are events at the first step after its zeros at 1/3 s and 2/3 s.
#[test]
fn slack_is_an_event() {
    let drive = r#"{ kind = "length", signal = { kind = "sine", amplitude = "5 mm", frequency = "1.5 Hz" } }"#;
    let result = run(&beam_scene("", drive, "0.05 s"));
    assert_eq!(result.status, Status::Converged);
    let told: Vec<(&str, f64)> = result.cable_events.iter().map(|e| (e.what.name(), e.t)).collect();
    println!("events {told:?}");
    assert_eq!(told.iter().map(|e| e.0).collect::<Vec<_>>()[..2], ["slack", "taut"]);
    for ((_, t), zero) in told.iter().zip([1.0 / 3.0, 2.0 / 3.0]) {
        assert!(*t > zero && *t <= zero + 0.05 + 1e-9, "{t} s after {zero} s");
    }
    assert!(result.cable_events.iter().all(|e| e.cable == "tendon"));
}

/// The same in a scene: a pull that is possible by its length and not for the body ends with the cable's name and a remedy.
#[test]
fn overpull_names_the_cable() {
    let result = run(&beam_scene("", &ramp_to("length", 0.1, "m"), "0.02 s"));
    assert_ne!(result.status, Status::Converged);
    let told = result.pulling.expect("the cable pulls");
    println!("{}: {told}", result.status);
    assert!(told.starts_with("tendon holds ") && told.contains("max_tension"), "{told}");
    assert!(result.last.x.iter().all(|v| v.is_finite()) && result.last.lambda[0] > 0.0);
}

/// Negative pivots of the tangent of a scene's blocks at the state `x`, with these multipliers.
fn negative_eigenvalues(scene: &Scene, past: &State, next: &State) -> usize {
    let system = &scene.system;
    let step = Step { system, integrator: Integrator::Static, past, dt: 1.0 };
    let mut sums = system.workspace();
    system.assemble(&step.at(next), &next.lambda, Want::Tangent, None, &mut sums).expect("an evaluation");
    let mut factor = Factor::new(system.pattern.clone());
    factor.factorise(&sums.k).expect("regular");
    factor.negative_eigenvalues
}

/// Where a cable bends the finger, the elastic tangent alone is indefinite; with λ ∂²L/∂x² of the cable the operator of the same
/// equilibrium is positive definite. A step that leaves the geometric stiffness of its cable out, as that of many simulators
/// does, solves with an indefinite matrix where nothing is unstable.
#[test]
fn the_geometric_stiffness_of_the_cable_makes_the_tangent_definite() {
    let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/hard-cases/scenes/finger.toml");
    let built = |changes: &[&str]| {
        let changes: Vec<_> = changes.iter().map(|c| parse(c).expect("key=value")).collect();
        let (spec, text) = read_scene(&file, &changes).unwrap_or_else(|e| panic!("{e}"));
        let body = Body::load(&file, &spec.mesh, &mut |_| {}).expect("a committed mesh");
        Scene::build(&file, spec, text, body.into()).unwrap_or_else(|e| panic!("{e}"))
    };
    for pull in [15, 45] {
        let cells = "mesh.cells=1770";
        let with = built(&[cells, &format!("constraint.cable.drive.signal.to=\"{pull} mm\"")]);
        let run = run(&with);
        assert_eq!(run.status, Status::Converged);
        let whole = negative_eigenvalues(&with, &run.last, &run.last);
        let without = built(&[cells, "constraint=[{ kind = \"fixed\", region = \"root\" }]"]);
        let bare = State { lambda: vec![], ..run.last.clone() };
        let elastic = negative_eigenvalues(&without, &bare, &bare);
        // No pair of nodes is coupled in K that no cell couples.
        assert_eq!(with.system.pattern.sparse.nnz(), without.system.pattern.sparse.nnz());
        println!("pull {pull} mm: negative pivots {elastic} of the elastic tangent, {whole} with the cable");
        assert!(elastic > 0 && whole == 0, "{pull} mm: {elastic}, {whole}");
    }
}

/// A free cube on three cables under tension: K has the six rigid motions, the whole tangent is positive definite. Rounding of sums of some
/// ten entries is 1e-14 of the largest eigenvalue; the elastic eigenvalues and those of the cables are within 1e-6 of it.
#[test]
fn a_body_that_only_its_cables_hold_is_stable() {
    let mesh = block(3, 3, 3, 0.03, 0.03, 0.03, Order::Linear);
    let cable = |k: usize| {
        let point = Vec3::repeat(0.015) + 0.01 * Vec3::ith((k + 1) % 3, 1.0);
        let guide = Guide { point, weights: ball_weights(&mesh, point, RADIUS).expect("inside") };
        Arc::new(Cable::new(format!("cable {k}"), point - 0.05 * Vec3::ith(k, 1.0), vec![guide]))
    };
    let loads = (0..3).map(|k| by_tension(&cable(k), Signal::Constant(1.0)));
    let effects = std::iter::once(elastic(&mesh, law("neo_hookean", 1e4, 0.3))).chain(loads).collect();
    let system = System::new(mesh.points.len(), effects, vec![], vec![]).expect("a free cube");
    let (rest, mut sums) = (system.rest(), system.workspace());
    let step = Step { system: &system, integrator: Integrator::Static, past: &rest, dt: 1.0 };
    system.assemble(&step.at(&rest), &[], Want::Tangent, None, &mut sums).expect("an evaluation");
    let (pattern, n) = (&system.pattern, system.pattern.n);
    let dense = |multiply: &dyn Fn(&[f64], &mut [f64])| {
        let mut a = nalgebra::DMatrix::zeros(n, n);
        for (j, mut column) in a.column_iter_mut().enumerate() {
            let unit: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == j))).collect();
            multiply(&unit, column.as_mut_slice());
        }
        a.symmetric_eigenvalues()
    };
    let alone = dense(&|x, y| pattern.sparse.multiply(&sums.k[..pattern.sparse.nnz()], x, y));
    let whole = dense(&|x, y| pattern.multiply(&sums.k, x, y));
    let small = |e: &&f64| e.abs() < 1e-12 * alone.amax();
    println!(
        "{} of {n} motions without the cables, {:e} to {:e} with",
        alone.iter().filter(small).count(),
        whole.min(),
        whole.amax()
    );
    assert!(alone.iter().filter(small).count() == 6 && whole.min() > 1e-6 * whole.amax());
    let x: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
    let mut b = vec![0.0; n];
    pattern.multiply(&sums.k, &x, &mut b);
    let left = |x: &[f64]| {
        let mut y = vec![0.0; n];
        pattern.multiply(&sums.k, x, &mut y);
        y.iter().zip(&b).map(|(y, b)| (y - b).powi(2)).sum::<f64>().sqrt() / norm(&b)
    };
    let solved = |pattern: &Arc<Pattern>| {
        let mut factor = Factor::new(pattern.clone());
        factor.factorise(&sums.k).expect("regular");
        assert_eq!(factor.negative_eigenvalues, 0);
        let (mut exact, mut roughly) = (b.clone(), b.clone());
        let accurate = factor.solve(&sums.k, &mut exact);
        factor.solve_roughly(&mut roughly);
        (accurate.map(|()| left(&exact)), left(&roughly))
    };
    let (exact, roughly) = solved(pattern);
    let exact = exact.expect("accurate");
    // After all nodes: K is eliminated by itself, with pivots that are rounding.
    let after = vec![n as u32; pattern.low_rank.after.len()];
    let low_rank = LowRank { after, ..(*pattern.low_rank).clone() };
    let (_, last) = solved(&Arc::new(Pattern::new((*pattern.sparse).clone(), low_rank)));
    println!("residuals {exact:e}, {roughly:e} in single precision, {last:e} with the cables last");
    // Rounding of single precision, 6e-8, times some hundred terms of the size of ‖A‖‖x‖, at most 100 ‖b‖ here.
    assert!(exact < 1e-9 && roughly < 1e-3 && last > 10.0 * roughly);
}

/// A bar with these guides.
fn guided(guides: &str) -> Scene {
    let text = format!(
        "[mesh]\ngrid = {{ kind = \"box\", size = [\"30 mm\", \"10 mm\", \"10 mm\"], divisions = [6, 2, 2] }}\n\
         [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
         [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n\
         [[constraint]]\nkind = \"cable\"\nguide_radius = \"point\"\n{guides}\n\
         drive = {{ kind = \"length\", signal = {{ kind = \"ramp\", from = \"0 mm\", to = \"1 mm\", end = \"1 s\" }} }}\n\
         [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n"
    );
    durometer::scene::parse_scene(&text).unwrap_or_else(|e| panic!("{e}"))
}

/// A file of two cables, each with its pull point and with guides up to 0.4 mm outside, is the two lists on the surface: they agree to 1e-9,
/// since a point that is moved is rounded. The guides that were moved are noted.
#[test]
fn a_file_of_guides_is_its_lists() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("guides.csv");
    let rows = "name,x,y,z\nlow,-5,5,1\nlow,10,5,1\nlow,25,5,-0.4\nhigh,-5,5,9\nhigh,10,5,9\nhigh,25,5,10.25\n";
    std::fs::write(&file, rows).expect("writable");
    let of_file = |more: &str| {
        guided(&format!(
            "pull_point = \"first\"\nreach = \"0.5 mm\"\nguides = {{ file = {:?}, unit = \"mm\"{more} }}",
            file.display().to_string()
        ))
    };
    let both = of_file("");
    let names: Vec<&str> = both.cables.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["low", "high"]);
    let note = |cables: &str, most: &str| {
        format!("{cables} guides are outside of the body, by up to {most} mm, and were moved to its surface")
    };
    assert!(both.notes.contains(&note("low and high: 2 of 4", "0.4000")), "{:?}", both.notes);
    for (name, z, end, most) in [("low", "1 mm", "0 mm", "0.4000"), ("high", "9 mm", "10 mm", "0.2500")] {
        let listed = guided(&format!(
            "name = \"{name}\"\npull_point = [\"-5 mm\", \"5 mm\", \"{z}\"]\n\
             guides = [[\"10 mm\", \"5 mm\", \"{z}\"], [\"25 mm\", \"5 mm\", \"{end}\"]]"
        ));
        let alone = of_file(&format!(", cable = \"{name}\""));
        assert!(alone.notes.contains(&note(&format!("{name}: 1 of 2"), most)), "{:?}", alone.notes);
        let (a, b) = (listed.run(), alone.run());
        assert!(a.columns == b.columns && b.status == durometer::solve::Status::Converged, "{name}");
        for (a, b) in a.rows.iter().flatten().zip(b.rows.iter().flatten()) {
            assert!((a - b).abs() <= 1e-9 * a.abs(), "{name}: {a} and {b}");
        }
    }
}

/// A guide in the middle of a gap between two blocks goes to one of both walls, and the mesh decides to which: that is said. One next to a wall goes there.
#[test]
fn a_guide_between_two_walls_is_doubted() {
    let notes = |z: &str| {
        let block = "grid = { kind = \"box\", size = [\"30 mm\", \"10 mm\", \"10 mm\"], divisions = [6, 2, 2] }";
        let text = format!(
            "[[mesh.part]]\nname = \"lower\"\n{block}\n[[mesh.part]]\nname = \"upper\"\n{block}\nshift = [\"0 mm\", \"0 mm\", \"12 mm\"]\n\
             [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n\
             [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
             [[constraint]]\nkind = \"cable\"\nguide_radius = \"point\"\nreach = \"1.5 mm\"\n\
             pull_point = [\"-5 mm\", \"5 mm\", \"5 mm\"]\nguides = [[\"10 mm\", \"5 mm\", \"5 mm\"], [\"20 mm\", \"5 mm\", \"{z}\"]]\n\
             drive = {{ kind = \"length\", signal = {{ kind = \"ramp\", from = \"0 mm\", to = \"1 mm\", end = \"1 s\" }} }}\n\
             [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n"
        );
        durometer::scene::parse_scene(&text).unwrap_or_else(|e| panic!("{e}")).notes
    };
    let doubted =
        |z: &str| notes(z).iter().any(|note| note.contains("1 of these guides are as near to an opposite wall"));
    assert_eq!(["11 mm", "11.01 mm", "10.3 mm", "-0.5 mm"].map(doubted), [true, true, false, false]);
}

/// Guides on the axis of the bore of a tube stay there with a ball that reaches the wall on all sides: two meshes whose nodes on the wall are at other angles
/// bend by the same, to their errors. With a ball that barely reaches the wall, or at a wall from outside, they are refused.
#[test]
fn guides_on_the_axis_of_a_bore_stay_there() {
    let scene = |divisions: &str, radius: &str, x: &str| {
        let text = format!(
            "[mesh]\nelement = \"tet10\"\n\
             grid = {{ kind = \"tube\", inner = \"2 mm\", outer = \"6 mm\", length = \"60 mm\", divisions = {divisions} }}\n\
             [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.4\n\
             [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
             [[constraint]]\nkind = \"fixed\"\nregion = \"zmin\"\n\
             [[constraint]]\nkind = \"cable\"\nguide_radius = \"{radius}\"\n\
             pull_point = [\"40 mm\", \"0 mm\", \"0 mm\"]\nguides = [[\"{x}\", \"0 mm\", \"30 mm\"], [\"{x}\", \"0 mm\", \"50 mm\"]]\n\
             drive = {{ kind = \"tension\", signal = {{ kind = \"ramp\", from = \"0 N\", to = \"0.1 N\", end = \"1 s\" }} }}\n\
             [[probe]]\nkind = \"position\"\nregion = \"zmax\"\n\
             [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.25 s\"\n"
        );
        durometer::scene::parse_scene(&text)
    };
    let bent = |divisions: &str| {
        let scene = scene(divisions, "5 mm", "0 mm").unwrap_or_else(|e| panic!("{e}"));
        assert!(scene.notes.iter().any(|note| note.contains("2 of 2 guides are in a bore")), "{:?}", scene.notes);
        let run = scene.run();
        assert_eq!(run.status, Status::Converged);
        let place = |column: &str| *run.column(column).expect("recorded").last().expect("rows");
        [place("zmax_x_m"), place("zmax_y_m")]
    };
    let [coarse, fine] = [bent("[1, 12, 12]"), bent("[2, 10, 12]")];
    assert!(fine[0] > 2e-3 && (coarse[0] / fine[0] - 1.0).abs() < 0.02, "{coarse:?} and {fine:?}");
    assert!(fine[1].abs() < 1e-2 * fine[0], "to the side by {fine:?}");
    for (radius, x) in [("2.05 mm", "0 mm"), ("5 mm", "6.5 mm"), ("5 mm", "-7 mm")] {
        let refused = scene("[1, 6, 8]", radius, x).map(|_| ()).expect_err("outside").to_string();
        assert!(refused.contains("2 of 2 guides are outside of the body"), "{refused}");
    }
}

/// A beam with a cable of these keys, driven to `to`.
fn pulled(keys: &str, kind: &str, to: &str) -> durometer::scene::Run {
    let text = format!(
        "[mesh]\nelement = \"tet10\"\n\
         grid = {{ kind = \"box\", size = [\"60 mm\", \"10 mm\", \"10 mm\"], divisions = [6, 1, 1] }}\n\
         [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.4\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
         [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n\
         [[constraint]]\nkind = \"cable\"\nguide_radius = \"point\"\n{keys}\n\
         drive = {{ kind = \"{kind}\", signal = {{ kind = \"ramp\", from = \"0 {}\", to = \"{to}\", end = \"1 s\" }} }}\n\
         [[probe]]\nkind = \"position\"\nregion = \"xmax\"\n[[probe]]\nkind = \"reaction\"\nregion = \"xmin\"\n\
         [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.25 s\"\n[numerics]\ntolerance = 1e-11\n",
        to.rsplit(' ').next().expect("a unit")
    );
    let run = durometer::scene::parse_scene(&text).unwrap_or_else(|e| panic!("{e}")).run();
    assert_eq!(run.status, Status::Converged);
    run
}

fn point_list(points: &[[f64; 3]]) -> String {
    let one = |p: &[f64; 3]| format!("[\"{} mm\", \"{} mm\", \"{} mm\"]", p[0], p[1], p[2]);
    format!("[{}]", points.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// A pull point that moves with the body: where the body is held it is one fixed in space, with friction and without; elsewhere
/// the forces of the cable add up to zero, and a drive by length reaches the state of one by the tension that it has.
#[test]
fn a_pull_point_can_move_with_the_body() {
    let last = |run: &durometer::scene::Run, name: &str| *column(run, name).last().expect("rows");
    let (held, others) = ([0.0, 5.0, 8.0], [[20.0, 5.0, 8.0], [40.0, 5.0, 9.0], [55.0, 5.0, 8.0]]);
    let all = point_list(&[&[held][..], &others[..]].concat());
    for friction in ["", "friction = 0.2\n"] {
        let in_space = "[\"0 mm\", \"5 mm\", \"8 mm\"]";
        let keys = format!("{friction}pull_point = {in_space}\nguides = {}", point_list(&others));
        let fixed = pulled(&keys, "length", "4 mm");
        let moving = pulled(&format!("{friction}pull_point = \"moving\"\nguides = {all}"), "length", "4 mm");
        for name in ["xmax_x_m", "xmax_z_m", "cable_length_m", "cable_tension_N"] {
            let (a, b) = (last(&fixed, name), last(&moving, name));
            assert!((a - b).abs() < 1e-8 * a.abs(), "{friction}{name}: {a} {b}");
        }
        assert!(last(&moving, "cable_tension_N") > 0.01);
    }
    let free = format!("pull_point = \"moving\"\nguides = {}", point_list(&others));
    let by_length = pulled(&free, "length", "3 mm");
    let tension = last(&by_length, "cable_tension_N");
    for i in ["x", "y", "z"] {
        let reaction = last(&by_length, &format!("xmin_reaction_{i}_N"));
        assert!(reaction.abs() < 1e-8 * tension, "{i}: {reaction} N of {tension} N");
    }
    let by_tension = pulled(&free, "tension", &format!("{tension} N"));
    for name in ["xmax_x_m", "xmax_z_m", "cable_length_m"] {
        let (a, b) = (last(&by_length, name), last(&by_tension, name));
        assert!((a - b).abs() < 1e-8 * a.abs(), "{name}: {a} {b}");
    }
}

/// A single guide, and a ring before the first guide, of a cable that is pulled at its first guide.
#[test]
fn a_moving_pull_point_has_a_guide_after_it() {
    let refused = |keys: &str| {
        let text = format!(
            "[mesh]\ngrid = {{ kind = \"box\", size = [\"60 mm\", \"10 mm\", \"10 mm\"], divisions = [6, 1, 1] }}\n\
             [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.4\n\
             [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
             [[constraint]]\nkind = \"cable\"\nguide_radius = \"point\"\npull_point = \"moving\"\n{keys}\n\
             drive = {{ kind = \"tension\", signal = \"1 N\" }}\n\
             [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.25 s\"\n"
        );
        durometer::scene::parse_scene(&text).err().expect("refused").to_string()
    };
    let one = refused(&format!("guides = {}", point_list(&[[20.0, 5.0, 5.0]])));
    assert!(one.contains("the cable has one guide, at which it is pulled"), "{one}");
    let guides = point_list(&[[20.0, 5.0, 5.0], [40.0, 5.0, 5.0]]);
    let ring = refused(&format!("guides = {guides}\nrings = [{{ at = [\"0 mm\", \"5 mm\", \"20 mm\"], after = 0 }}]"));
    assert!(ring.contains("ring 1 is before the first guide"), "{ring}");
}

/// Under a prescribed tension an elastic cable pulls the body as a stiff one does, and what is drawn in has its stretch T L₀/EA in it: the
/// same as by a drive of that length.
#[test]
fn a_drive_by_tension_takes_in_the_stretch() {
    let (rest, ea, tension) = (0.105, 8.0, 0.3);
    let last = |keys: &str, drive: String, name: &str| {
        let result = run(&beam_scene(keys, &drive, "0.25 s"));
        assert_eq!(result.status, Status::Converged);
        *column(&result, name).last().expect("rows")
    };
    let elastic = format!("EA = \"{ea} N\"");
    let by_tension = || ramp_to("tension", tension, "N");
    let [stretched, stiff] = [&elastic[..], ""].map(|keys| last(keys, by_tension(), "tendon_length_m"));
    assert_eq!(stretched, stiff, "the body feels the tension alone");
    let drawn = last(&elastic, by_tension(), "tendon_drawn_m");
    assert!((drawn - (rest - stiff + tension * rest / ea)).abs() <= 1e-12 * rest, "{drawn}");
    let back = last(&elastic, ramp_to("length", drawn, "m"), "tendon_tension_N");
    assert!((back / tension - 1.0).abs() <= 1e-6, "{tension} N took in {drawn} m, which takes {back} N");
}

/// A stretch of 10 %, from which on the tension is a matter of how strain is defined, is noted; half of it is not.
#[test]
fn a_large_strain_of_a_cable_is_noted() {
    for (ea, expected) in [(2.0, true), (4.5, false)] {
        for friction in ["", "friction = 0.1"] {
            let scene = beam_scene(&format!("EA = \"{ea} N\"\n{friction}"), &ramp_to("tension", 0.3, "N"), "0.25 s");
            let notes = durometer::study::store::solver_record::notes(&scene, &run(&scene));
            let found = notes.iter().any(|note| note.starts_with("tendon is stretched by 15.0 % at t = 1.000000 s"));
            assert_eq!(found, expected, "EA = {ea} N: {notes:?}");
        }
    }
}
