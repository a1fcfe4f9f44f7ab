//! Time: free fall, initial acceleration, energy, orders, rest, and constraints under the integrators.

use crate::common;
use crate::common::{body, column, elastic, hold, law, move_to, newton, nodes, ramp, reaction, run, scene, statics};
use durometer::effect::{Cable, CableLength, Gravity, Guide, Inertia, Lumping, Mass, MassDamping};
use durometer::math::signal::Signal;
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::ball::ball_weights;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::solve::{AcceptedStep, Driver, Integrator, Status, StepSettings, TimeSpan, initial_acceleration};
use durometer::system::{At, Constraint, Effect, State, System, Want};
use std::sync::Arc;

const EULER: Integrator = Integrator::ImplicitEuler { linearised: false };
const TRAPEZOID: Integrator = Integrator::Newmark { beta: 0.25, gamma: 0.5 };
const DENSITY: f64 = 1000.0;

fn inertia(mesh: &TetMesh, lumping: Lumping) -> Box<dyn Effect> {
    Box::new(Inertia { mass: Mass::new(mesh, &body(mesh), DENSITY, lumping) })
}

fn damping(mesh: &TetMesh, alpha: f64) -> Box<dyn Effect> {
    Box::new(MassDamping { alpha, mass: Mass::new(mesh, &body(mesh), DENSITY, Lumping::Consistent) })
}

fn gravity(mesh: &TetMesh, g: f64) -> Box<dyn Effect> {
    let direction = Vec3::new(0.0, 0.0, -1.0);
    Box::new(Gravity::new(mesh, &body(mesh), DENSITY, direction, Signal::Constant(g)))
}

/// Runs `steps` of length `dt` from `state`, in place; `watch(past, now, energies per effect)`.
fn march(
    mesh: &TetMesh,
    system: &System,
    integrator: Integrator,
    tolerance: f64,
    (steps, dt): (usize, f64),
    state: &mut State,
    mut watch: impl FnMut(&State, &State, &[f64]),
) -> usize {
    if integrator.needs_initial_acceleration() {
        state.a = initial_acceleration(system, state).expect("the mass is regular");
    }
    let mut driver = Driver::new(system, newton(system, tolerance, mesh.diagonal()), StepSettings::default());
    let span = TimeSpan { integrator, start: state.t, end: state.t + steps as f64 * dt, dt };
    let status = driver.run(span, state, &mut |step: &AcceptedStep| {
        let AcceptedStep { past, now, sums, .. } = *step;
        watch(past, now, &sums.energy);
        true
    });
    assert_eq!(status, Status::Converged, "{integrator:?}");
    assert_eq!(driver.totals.steps, steps, "{integrator:?}: a step was cut");
    driver.totals.iterations
}

/// Every node falls alike, without strain. Newmark and generalised-α are exact for a constant acceleration; implicit Euler
/// gives ½g Δt² n(n + 1), BDF2, started with one such step, ½g(nΔt)² + ¾gΔt²(1 − 3⁻ⁿ) (its error obeys
/// 3e_{n+1} − 4e_n + e_{n−1} = 0). Tolerance: the residual is 1e-12 of the weight, so the position 1e-11 of the fall.
#[test]
fn free_fall() {
    let (g, dt, steps) = (9.81, 0.01, 20);
    for integrator in [EULER, Integrator::Bdf2, TRAPEZOID, Integrator::GeneralisedAlpha { rho: 0.5 }] {
        for order in common::ORDERS {
            let mesh = block(2, 1, 1, 0.02, 0.01, 0.01, order);
            let effects = vec![
                elastic(&mesh, law("neo_hookean", 1e5, 0.45)),
                inertia(&mesh, Lumping::Consistent),
                gravity(&mesh, g),
            ];
            let system = System::new(mesh.points.len(), effects, vec![], vec![]).unwrap();
            let mut state = State::rest(mesh.points.len(), 0);
            march(&mesh, &system, integrator, 1e-12, (steps, dt), &mut state, |_, _, _| {});
            let n = steps as f64;
            let fall = g * dt * dt * fallen(integrator, n);
            for k in 0..mesh.points.len() {
                let u = Vec3::from_column_slice(&state.x[3 * k..3 * k + 3]);
                let v = Vec3::from_column_slice(&state.v[3 * k..3 * k + 3]);
                let error = (u + Vec3::new(0.0, 0.0, fall)).norm() / fall;
                assert!(error <= 1e-11, "{integrator:?} {order:?}: node {k} is at {u}, off by {error:e}");
                assert!((v.z / (-g * n * dt) - 1.0).abs() <= 1e-10, "{integrator:?}: v = {v}");
            }
        }
    }
}

/// The fall of a body from rest after `n` steps, as a multiple of g Δt² ([`free_fall`]).
fn fallen(integrator: Integrator, n: f64) -> f64 {
    match integrator {
        Integrator::ImplicitEuler { .. } => 0.5 * n * (n + 1.0),
        Integrator::Bdf2 => 0.5 * n * n + 0.75 * (1.0 - 3f64.powf(-n)),
        _ => 0.5 * n * n,
    }
}

/// A fall over 11 m, 450 times the size of the body. The noise of K u and of c_a M u is that of displacements of 11 m, and 20 times the floor
/// of a body that stays where it is; no step is cut for it. What it leaves: 4ε ‖k‖ |u| with ‖k‖ < 1.5e4 N/m over the 36 dofs is 1.5e-10 N, so
/// on 2 g, with all 36 signs alike, the acceleration is off by less than 4.5e-7 m/s², and the fall by 5e-8.
#[test]
fn a_long_fall_is_as_exact_as_a_short_one() {
    let (g, dt, steps) = (9.81, 0.01, 150);
    for integrator in [EULER, Integrator::Bdf2, TRAPEZOID, Integrator::GeneralisedAlpha { rho: 0.8 }] {
        let mesh = block(2, 1, 1, 0.02, 0.01, 0.01, Order::Linear);
        let law = law("neo_hookean", 1e5, 0.3);
        let effects = vec![elastic(&mesh, law), inertia(&mesh, Lumping::Consistent), gravity(&mesh, g)];
        let system = System::new(mesh.points.len(), effects, vec![], vec![]).expect("a system");
        let mut state = State::rest(mesh.points.len(), 0);
        march(&mesh, &system, integrator, 1e-12, (steps, dt), &mut state, |_, _, _| {});
        let fall = g * dt * dt * fallen(integrator, steps as f64);
        assert!(fall > 11.0);
        for u in state.x.chunks_exact(3) {
            let error = (Vec3::from_column_slice(u) + Vec3::new(0.0, 0.0, fall)).norm() / fall;
            assert!(error <= 1e-7, "{integrator:?}: {u:?} is off by {error:e}");
        }
    }
}

/// The same of a free rigid body, also where it begins 20 m from the origin: its stiffness against a change of length is the largest one there
/// is, with ‖k‖ < 1e8 N/m along the fall. 4ε ‖k‖ |u| is 1e-6 N for a weight of 0.059 N, so the fall is off by less than 4e-5.
#[test]
fn a_free_rigid_body_falls_as_far_as_time_goes() {
    for (integrator, name) in [
        (EULER, "\"implicit_euler\""),
        (Integrator::Bdf2, "\"bdf2\""),
        (Integrator::GeneralisedAlpha { rho: 0.8 }, "{ kind = \"generalised_alpha\", rho = 0.8 }"),
    ] {
        for start in [0.1, 20.0] {
            let text = format!(
                r#"
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
[[rigid]]
name = "brick"
shape = {{ kind = "box", min = ["{start} m", "0 mm", "0 mm"], max = ["{} m", "20 mm", "10 mm"] }}
density = "1000 kg/m^3"
gravity = {{ direction = [0, 0, -1], acceleration = "9.81 m/s^2" }}
[[stage]]
integrator = {name}
duration = "1.5 s"
dt = "10 ms"
"#,
                start + 0.03
            );
            let result = run(&scene(block(2, 1, 1, 0.02, 0.01, 0.01, Order::Linear), &text));
            assert_eq!((&result.status, result.totals.cuts), (&Status::Converged, 0), "{name} from {start} m");
            let height = *column(&result, "brick_z_m").last().expect("a row");
            let fall = 9.81 * 1e-4 * fallen(integrator, 150.0);
            assert!(
                ((0.005 - height) / fall - 1.0).abs() <= 1e-4,
                "{name} from {start} m: at {height} m, {fall} m below"
            );
        }
    }
}

/// A bar that is stretched by 1 % of its length at home, and 10 m away: the floor of rounding far away is not taken for equilibrium. The noise of
/// the forces there is some ε K |u| = 2e-16 · 4e3 N/m · 10 m = 1e-11 N of 0.1 N.
#[test]
fn a_body_far_away_has_the_forces_of_one_at_home() {
    let mesh = block(4, 1, 1, 0.1, 0.01, 0.01, Order::Linear);
    let pulled = |away: f64| {
        let end = |name: &str, more: f64| move_to(&mesh, &nodes(&mesh, name), |_| Vec3::new(away + more, 0.0, 0.0));
        let held = [end("xmin", 0.0), end("xmax", 1e-3)].concat();
        let system = System::new(mesh.points.len(), vec![elastic(&mesh, law("neo_hookean", 1e5, 0.3))], vec![], held);
        let (_, sums) = statics(&mesh, &system.expect("a system"), 1e-10, 4);
        reaction(&sums, &nodes(&mesh, "xmax")).x
    };
    let (home, away) = (pulled(0.0), pulled(10.0));
    assert!(home > 0.05 && (away / home - 1.0).abs() <= 1e-8, "{away} N far away, {home} N at home");
}

/// Gravity switched on at t = 0 on a free body: a = g at every node where mass and weight are distributed alike (always
/// with the consistent mass), and in the mean with every lumping.
#[test]
fn initial_acceleration_is_that_of_gravity() {
    for order in common::ORDERS {
        for lumping in [Lumping::Consistent, Lumping::Lumped, Lumping::Uniform] {
            let mesh = common::distorted_cube(2, order, 0.1, 41);
            let effects =
                vec![elastic(&mesh, law("neo_hookean", 1e5, 0.45)), inertia(&mesh, lumping), gravity(&mesh, 9.81)];
            let system = System::new(mesh.points.len(), effects, vec![], vec![]).unwrap();
            let state = State::rest(mesh.points.len(), 0);
            let a = initial_acceleration(&system, &state).unwrap();
            // Σ M a is the weight whatever the distribution.
            let mass = Mass::new(&mesh, &body(&mesh), DENSITY, lumping);
            let mut out = durometer::system::BlockValues::new(mass.blocks.largest());
            let mut force = 0.0;
            for b in 0..mass.blocks.len() {
                out.r.fill(0.0);
                mass.apply(&a, b, 1.0, 0.0, Want::Residual, &mut out);
                force += (0..mass.blocks.nodes(b).len()).map(|k| out.r[3 * k + 2]).sum::<f64>();
            }
            assert!((force / (-9.81 * DENSITY * mesh.volume()) - 1.0).abs() <= 1e-12, "{order:?} {lumping:?}: {force}");
            if lumping == Lumping::Consistent || (lumping == Lumping::Lumped && order == Order::Linear) {
                for a in a.chunks_exact(3) {
                    let error = (Vec3::from_column_slice(a) + Vec3::new(0.0, 0.0, 9.81)).norm();
                    assert!(error <= 1e-10, "{order:?} {lumping:?}: a = {a:?}");
                }
            }
        }
    }
}

/// A bar of 0.1 m along x clamped at x = 0 that starts with v = V sin(πx/2L), close to its first longitudinal mode.
fn bar(name: &str, nu: f64, more: impl FnOnce(&TetMesh) -> Vec<Box<dyn Effect>>) -> (TetMesh, System) {
    let mesh = block(8, 1, 1, 0.1, 0.01, 0.01, Order::Linear);
    let mut effects = vec![elastic(&mesh, law(name, 1e5, nu)), inertia(&mesh, Lumping::Consistent)];
    effects.extend(more(&mesh));
    let system = System::new(mesh.points.len(), effects, vec![], hold(&nodes(&mesh, "xmin"), &[0, 1, 2])).unwrap();
    (mesh, system)
}

fn struck(mesh: &TetMesh, speed: f64) -> State {
    let mut state = State::rest(mesh.points.len(), 0);
    for (k, p) in mesh.points.iter().enumerate() {
        state.v[3 * k] = speed * (std::f64::consts::PI * p.x / 0.2).sin();
    }
    state
}

/// Period of the first mode, 4L/c with c = √(E/ρ) [s].
const PERIOD: f64 = 4.0 * 0.1 / 10.0;

/// Elastic + kinetic energy after each step.
fn energies(
    integrator: Integrator,
    name: &str,
    nu: f64,
    speed: f64,
    (periods, per_period): (usize, usize),
) -> Vec<f64> {
    let (mesh, system) = bar(name, nu, |_| vec![]);
    let mut state = struck(&mesh, speed);
    let mut all = Vec::new();
    let steps = (periods * per_period, PERIOD / per_period as f64);
    march(&mesh, &system, integrator, 1e-12, steps, &mut state, |_, _, e| all.push(e[0] + e[1]));
    all
}

/// The trapezoidal rule conserves the energy of a linear system exactly; 2000 steps solved to 1e-12.
#[test]
fn trapezoidal_rule_keeps_the_energy_of_a_linear_bar() {
    let all = energies(TRAPEZOID, "linear", 0.3, 0.5, (100, 20));
    let drift = all.iter().map(|e| (e / all[0] - 1.0).abs()).fold(0.0, larger);
    println!("linear bar, 100 periods, trapezoid: drift {drift:.1e}");
    assert!(drift <= 1e-10, "{drift:e}");
}

/// Neo-Hookean, strain at the clamp up to V/c = 2 %, 80 steps a period. The energy of a nonlinear system
/// ripples within a period under the trapezoidal rule; the drift is that of its mean over ten periods.
#[test]
fn trapezoidal_rule_does_not_drift_on_a_neo_hookean_bar() {
    let all = energies(TRAPEZOID, "neo_hookean", 0.3, 0.2, (100, 80));
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let (first, last) = (mean(&all[..800]), mean(&all[all.len() - 800..]));
    let ripple = all.iter().map(|e| (e / first - 1.0).abs()).fold(0.0, larger);
    println!("Neo-Hookean bar, 100 periods, trapezoid: drift {:.1e}, ripple {ripple:.1e}", last / first - 1.0);
    assert!((last / first - 1.0).abs() < 1e-4, "drift {:e}", last / first - 1.0);
    assert!(ripple < 1e-3, "{ripple:e}");
}

/// Implicit Euler multiplies the energy of a mode by 1/(1 + (ωΔt)²) a step. Nearly all of the energy is in the first mode,
/// whose ω the mesh has to 1 %.
#[test]
fn implicit_euler_loses_what_theory_says() {
    let per_period = 100;
    let all = energies(EULER, "linear", 0.0, 0.5, (5, per_period));
    let x = std::f64::consts::TAU / per_period as f64;
    let steps = all.len() - 1;
    let (found, theory) = ((all[steps] / all[0]).ln(), -(steps as f64) * (x * x).ln_1p());
    println!("implicit Euler: ln(E/E0) = {found:.4} after 5 periods, theory {theory:.4}");
    assert!((found / theory - 1.0).abs() < 0.02);
}

/// Order in time on a finite element model (Neo-Hookean, mass damping, finite amplitude): x at the end with Δt, Δt/2, Δt/4.
#[test]
fn integrators_have_their_order_on_a_finite_element_model() {
    for (integrator, order) in [
        (EULER, 1.0),
        (Integrator::ImplicitEuler { linearised: true }, 1.0),
        (Integrator::Bdf2, 2.0),
        (Integrator::GeneralisedAlpha { rho: 0.5 }, 2.0),
        (TRAPEZOID, 2.0),
    ] {
        let end = |steps: usize| {
            let (mesh, system) = bar("neo_hookean", 0.0, |mesh| vec![damping(mesh, 20.0)]);
            let mut state = struck(&mesh, 0.5);
            let dt = 0.2 * PERIOD / steps as f64;
            march(&mesh, &system, integrator, 1e-12, (steps, dt), &mut state, |_, _, _| {});
            state.x
        };
        let base = if order == 1.0 { 800 } else { 400 };
        let [a, b, c] = [base, 2 * base, 4 * base].map(end);
        let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let found = (distance(&a, &b) / distance(&b, &c)).log2();
        println!("order of {integrator:?}: {found:.3}");
        // The second term of the error series, from the higher modes, is a few per cent of the first at these steps.
        assert!((found - order).abs() <= 0.1, "{integrator:?}: order {found}");
    }
}

/// The linearised step is one Newton iteration from the last state: r(xₙ) + K(xₙ)(x − xₙ) = 0, to the accuracy of the
/// linear solve (1e-9).
#[test]
fn linearised_steps_solve_the_equation_linearised_at_the_last_state() {
    let (mesh, system) = bar("neo_hookean", 0.45, |mesh| vec![damping(mesh, 20.0)]);
    let integrator = Integrator::ImplicitEuler { linearised: true };
    let mut state = struck(&mesh, 2.0);
    let iterations = march(&mesh, &system, integrator, 1e-12, (10, PERIOD / 20.0), &mut state, |past, now, _| {
        let (dt, n) = (now.t - past.t, past.x.len());
        let (mut v, mut a) = (vec![0.0; n], vec![0.0; n]);
        integrator.kinematics(past, dt, &past.x, &mut v, &mut a);
        let rates = integrator.rates(past, dt);
        let at = At { t: now.t, dt, x: &past.x, v: &v, a: &a, old: &past.x, history: &[], inputs: &[], rates };
        let mut sums = system.workspace();
        system.assemble(&at, &[], Want::Tangent, None, &mut sums).unwrap();
        let step: Vec<f64> = now.x.iter().zip(&past.x).map(|(x, old)| x - old).collect();
        let mut force = vec![0.0; system.dofs.free.len()];
        system.pattern.multiply(&sums.k, &system.restrict(&step), &mut force);
        let r = system.restrict(&sums.r);
        let error = force.iter().zip(&r).map(|(f, r)| (f + r).powi(2)).sum::<f64>().sqrt();
        let size = r.iter().map(|r| r * r).sum::<f64>().sqrt();
        assert!(error <= 1e-8 * size, "at {} s: {error:e} of {size:e} N", now.t);
    });
    assert_eq!(iterations, 10, "one iteration a step");
}

/// Elastic + kinetic + dissipated = work: gravity switched on, mass and viscous damping. What the integrator loses and the
/// first-order sums of dissipation both shrink with Δt.
#[test]
fn damped_runs_balance_their_energy_to_first_order() {
    let mismatch = |integrator: &str, dt: f64| {
        let text = format!(
            r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.4
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "inertia"
region = "body"
density = "1000 kg/m^3"
mass = "consistent"
[[effect]]
kind = "mass_damping"
region = "body"
density = "1000 kg/m^3"
mass = "consistent"
alpha = "5 /s"
[[effect]]
kind = "viscous_damping"
region = "body"
eta = "100 Pa s"
[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = "9.81 m/s^2"
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = {integrator}
duration = "0.2 s"
dt = "{dt} s"
[[probe]]
kind = "energy"
"#
        );
        let scene = scene(block(6, 1, 1, 0.06, 0.01, 0.01, Order::Quadratic), &text);
        let result = run(&scene);
        assert_eq!(result.status, Status::Converged);
        let [e, k, d, w] = ["elastic_J", "kinetic_J", "dissipated_J", "work_J"].map(|name| column(&result, name));
        let size = common::largest(&w);
        assert!(d.windows(2).all(|p| p[1] >= p[0]), "{integrator}: dissipation never turns back");
        assert!(d.last().unwrap() > &(0.2 * size), "{integrator}: the damping matters");
        (0..w.len()).map(|i| (e[i] + k[i] + d[i] - w[i]).abs()).fold(0.0, larger) / size
    };
    for integrator in [
        "\"implicit_euler\"",
        "\"bdf2\"",
        "{ kind = \"generalised_alpha\", rho = 0.5 }",
        "{ kind = \"newmark\", beta = 0.25, gamma = 0.5 }",
    ] {
        let (coarse, fine) = (mismatch(integrator, 0.001), mismatch(integrator, 0.0005));
        println!("energy balance, {integrator}: {coarse:.2e} of the work at 1 ms, {fine:.2e} at 0.5 ms");
        assert!(coarse <= 0.05, "{integrator}: {coarse:e}");
        // First order: the second term is a tenth of the first at these steps; schemes may do better.
        assert!(coarse / fine >= 1.8, "{integrator}: {coarse:e}, {fine:e}");
    }
}

/// A cantilever under gravity with mass damping α = 2ω₁ comes to rest at the static solution whatever dt.
/// ω₁ of the clamped rod is 3.516 √(EI/ρAL⁴); after 25/ω₁, or 25 steps where they are longer, e⁻²⁵ is left of the start.
#[test]
fn rest_does_not_depend_on_the_time_step() {
    let (l, h, e) = (0.02, 0.004, 1e6);
    let mesh = block(5, 1, 1, l, h, h, Order::Quadratic);
    let omega = 3.516 * h / (l * l) * (e / (12.0 * DENSITY)).sqrt();
    let held = || hold(&nodes(&mesh, "xmin"), &[0, 1, 2]);
    let g = 300.0;
    let material = || elastic(&mesh, law("neo_hookean", e, 0.45));
    let still = System::new(mesh.points.len(), vec![material(), gravity(&mesh, g)], vec![], held()).unwrap();
    let target = statics(&mesh, &still, 1e-10, 1).0.x;
    let sag = common::largest(&target);
    assert!(sag > 0.05 * l, "the load bends the rod: {sag}");
    let alpha = MassDamping { alpha: 2.0 * omega, mass: Mass::new(&mesh, &body(&mesh), DENSITY, Lumping::Consistent) };
    let effects = vec![material(), inertia(&mesh, Lumping::Consistent), Box::new(alpha) as _, gravity(&mesh, g)];
    let system = System::new(mesh.points.len(), effects, vec![], held()).unwrap();
    for (integrator, dts) in [
        (EULER, &[1e-4, 1e-3, 1e-2, 1e-1, 1.0][..]),
        (Integrator::Bdf2, &[1e-3, 1e-2, 1.0]),
        // It carries the acceleration of the start, here the one of a suddenly loaded rod, through its first steps: steps of
        // many periods overshoot before they damp, and only L-stable rules with no such memory take them.
        (Integrator::GeneralisedAlpha { rho: 0.5 }, &[1e-3, 1e-2]),
    ] {
        for &dt in dts {
            let steps = ((25.0 / omega / dt).ceil() as usize).max(25);
            let mut state = State::rest(mesh.points.len(), 0);
            march(&mesh, &system, integrator, 1e-8, (steps, dt), &mut state, |_, _, _| {});
            let error = state.x.iter().zip(&target).map(|(x, t)| (x - t).abs()).fold(0.0, larger) / l;
            println!("rest, {}, dt = {dt:.0e} s, {steps} steps: {error:.1e} L", integrator.name());
            assert!(error <= 1e-6, "{integrator:?}, dt = {dt}: {error:e} L from the static solution");
        }
    }
}

/// A body at its static equilibrium stays there when dynamics take over.
#[test]
fn dynamics_keep_a_static_equilibrium() {
    for integrator in [EULER, Integrator::Bdf2, TRAPEZOID, Integrator::GeneralisedAlpha { rho: 0.5 }] {
        let (mesh, system) = bar("neo_hookean", 0.45, |mesh| vec![gravity(mesh, 0.2)]);
        let mut driver = Driver::new(&system, newton(&system, 1e-12, 0.1), StepSettings::default());
        let mut state = State::rest(mesh.points.len(), 0);
        let span = TimeSpan { integrator: Integrator::Static, start: 0.0, end: 1.0, dt: 1.0 };
        assert_eq!(driver.run(span, &mut state, &mut ()), Status::Converged);
        let start = state.x.clone();
        march(&mesh, &system, integrator, 1e-12, (50, PERIOD / 10.0), &mut state, |_, _, _| {});
        let moved = state.x.iter().zip(&start).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
        // The static residual of 1e-12 of the forces pushes the bar by as much of its sag.
        assert!(moved <= 1e-9 * common::largest(&start), "{integrator:?}: moved by {moved:e} m");
    }
}

/// A beam whose cable is shortened at constant speed from rest: the tension of the trapezoidal rule alternates from step to
/// step (index-3 rows, Cardona & Géradin 1989), those of generalised-α with ρ < 1, of BDF2 and of implicit Euler settle.
/// The measure is the mean second difference |Tₙ₋₁ − 2Tₙ + Tₙ₊₁| over the last 20 of 100 steps against the mean tension:
/// of the smooth motion it is (ωΔt)² ≈ 0.01 and less.
#[test]
fn constraints_ring_only_where_refused() {
    let ringing = |integrator: Integrator| {
        let mesh = block(8, 1, 1, 0.1, 0.015, 0.015, Order::Linear);
        let guide = |x: f64| {
            let point = Vec3::new(x, 0.0075, 0.004);
            Guide { point, weights: ball_weights(&mesh, point, 0.006).unwrap() }
        };
        let cable = Cable::new("cable".into(), Vec3::new(-0.01, 0.0075, 0.004), [0.05, 0.09].map(guide).into());
        let rest = cable.lengths_at_rest().iter().sum::<f64>();
        let row =
            CableLength { cable: Arc::new(cable), shortening: ramp(0.05), rest, compliance: 0.0, most: f64::INFINITY };
        let effects = vec![
            elastic(&mesh, law("neo_hookean", 1e5, 0.4)),
            inertia(&mesh, Lumping::Consistent),
            damping(&mesh, 100.0),
        ];
        let rows = vec![Box::new(row) as Box<dyn Constraint>];
        let system = System::new(mesh.points.len(), effects, rows, hold(&nodes(&mesh, "xmin"), &[0, 1, 2])).unwrap();
        let mut state = State::rest(mesh.points.len(), 1);
        let mut tension = Vec::new();
        march(&mesh, &system, integrator, 1e-10, (100, 1e-3), &mut state, |_, now, _| tension.push(now.lambda[0]));
        assert!(tension.iter().all(|t| *t >= 0.0 && t.is_finite()));
        let late = &tension[80..];
        let mean = late.iter().sum::<f64>() / late.len() as f64;
        let second = late.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).sum::<f64>() / (late.len() - 2) as f64;
        println!("ringing of {integrator:?}: {:.1e} of the mean tension {mean:.3} N", second / mean);
        assert!(mean > 0.0);
        second / mean
    };
    for integrator in [
        EULER,
        Integrator::Bdf2,
        Integrator::GeneralisedAlpha { rho: 0.8 },
        Integrator::GeneralisedAlpha { rho: 0.5 },
        Integrator::GeneralisedAlpha { rho: 0.0 },
    ] {
        assert!(!integrator.rings_with_constraints());
        assert!(ringing(integrator) <= 0.05, "{integrator:?} rings");
    }
    assert!(TRAPEZOID.rings_with_constraints());
    assert!(ringing(TRAPEZOID) > 0.5, "the trapezoidal rule is refused for a reason");
}
