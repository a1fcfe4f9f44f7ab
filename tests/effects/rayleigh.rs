//! Stiffness-proportional damping: modal damping ratios by free decay, the tangents it takes, what it costs to turn a body,
//! the energy it books.

use crate::common;
use crate::common::{Random, body, column, elastic, hold, law, newton, nodes, run, scene};
use durometer::effect::{
    Cable, CableTension, Elastic, Guide, Inertia, Lumping, Mass, MassDamping, Stiffness, StiffnessDamping, Undamped,
};
use durometer::material::Law;
use durometer::math::signal::Signal;
use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::solve::{AcceptedStep, Driver, Integrator, Status, StepSettings, TimeSpan, initial_acceleration};
use durometer::system::{At, BlockValues, Effect, EnergyRole, Rates, State, System, Want};
use std::sync::Arc;

const DENSITY: f64 = 1000.0;
const TRAPEZOID: Integrator = Integrator::Newmark { beta: 0.25, gamma: 0.5 };

fn damping(mesh: &TetMesh, law: Box<dyn Law>, beta: f64, stiffness: Stiffness) -> StiffnessDamping {
    let damped: Arc<dyn Effect> = Arc::new(Elastic::new("elastic".into(), mesh, &body(mesh), law));
    StiffnessDamping::new(vec![damped], beta, stiffness, &mesh.points).expect("no second field")
}

/// A clamped bar of 0.1 m with c = √(E/ρ) = 10 m/s, ν = 0, that moves along its axis only, and Rayleigh damping.
fn bar(alpha: f64, beta: f64, stiffness: Stiffness) -> (TetMesh, System) {
    let mesh = block(8, 1, 1, 0.1, 0.01, 0.01, Order::Linear);
    let material = || law("linear", 1e5, 0.0);
    let mass = || Mass::new(&mesh, &body(&mesh), DENSITY, Lumping::Consistent);
    let effects: Vec<Box<dyn Effect>> = vec![
        elastic(&mesh, material()),
        Box::new(Inertia { mass: mass() }),
        Box::new(MassDamping { alpha, mass: mass() }),
        Box::new(damping(&mesh, material(), beta, stiffness)),
    ];
    let all: Vec<u32> = (0..mesh.points.len() as u32).collect();
    let held = [hold(&nodes(&mesh, "xmin"), &[0]), hold(&all, &[1, 2])].concat();
    let system = System::new(mesh.points.len(), effects, vec![], held).unwrap();
    (mesh, system)
}

/// Runs `steps` steps of the trapezoidal rule; the axial displacement of a node of the free end at start and after each.
fn decay((mesh, system): &(TetMesh, System), state: &mut State, steps: usize, dt: f64) -> Vec<f64> {
    let dof = 3 * nodes(mesh, "xmax")[0] as usize;
    state.a = initial_acceleration(system, state).expect("the mass is regular");
    let mut all = vec![state.x[dof]];
    let mut driver = Driver::new(system, newton(system, 1e-12, mesh.diagonal()), StepSettings::default());
    let span = TimeSpan { integrator: TRAPEZOID, start: state.t, end: state.t + steps as f64 * dt, dt };
    let status = driver.run(span, state, &mut |step: &AcceptedStep| {
        let AcceptedStep { now, .. } = *step;
        all.push(now.x[dof]);
        true
    });
    assert_eq!((status, driver.totals.steps), (Status::Converged, steps));
    all
}

/// Damping ratio and angular frequency of a decaying oscillation that the trapezoidal rule made: q_{n+2m} − 2 R cos Φ
/// q_{n+m} + R² q_n = 0 for samples m steps apart (the logarithmic decrement is −ln R), z = (R e^{iΦ})^{1/m} = (1 + ½sΔt)/(1
/// − ½sΔt), s = −ζω ± iω√(1 − ζ²).
fn ratio(q: &[f64], m: usize, dt: f64) -> (f64, f64) {
    let at = |k: usize| q[q.len() - 1 - (3 - k) * m];
    let (q0, q1, q2, q3) = (at(0), at(1), at(2), at(3));
    let determinant = q1 * q1 - q0 * q2;
    let (twice, square) = ((q1 * q2 - q0 * q3) / determinant, (q2 * q2 - q1 * q3) / determinant);
    let (decrement, angle) = (0.5 * square.ln() / m as f64, (0.5 * twice / square.sqrt()).acos() / m as f64);
    // (z − 1)/(z + 1) = tanh(½ ln z) of a complex number
    let (x, y) = (decrement, angle);
    let below = x.cosh() + y.cos();
    let (re, im) = (2.0 / dt * x.sinh() / below, 2.0 / dt * y.sin() / below);
    let omega = re.hypot(im);
    (-re / omega, omega)
}

/// ζ = α/2ω + βω/2 of the first axial mode, ω = πc/2L. A run with β first lets the higher modes die: their rate is nine times
/// that of the first and more, after ten periods they are below e⁻²⁴ of it. Then the decay of the mode is that of one
/// oscillator, whatever α and β, for the semidiscrete ω (0.2 % above πc/2L on 8 linear cells); the trapezoidal rule is
/// inverted exactly. Residuals of 1e-12 leave about 1e-10.
#[test]
fn modal_damping_ratio_of_a_bar() {
    let omega = std::f64::consts::PI * 10.0 / 0.2;
    let (alpha, beta) = (2.0 * omega * 0.03, 2.0 / omega * 0.05);
    let dt = std::f64::consts::TAU / omega / 40.0;
    let first = bar(0.0, beta, Stiffness::Initial);
    let mut pure = State::rest(first.0.points.len(), 0);
    for (k, p) in first.0.points.iter().enumerate() {
        pure.v[3 * k] = 0.1 * (std::f64::consts::PI * p.x / 0.2).sin();
    }
    decay(&first, &mut pure, 400, dt);
    for (alpha, beta, stiffness) in [
        (alpha, 0.0, Stiffness::Initial),
        (0.0, beta, Stiffness::Initial),
        (alpha, beta, Stiffness::Initial),
        (alpha, beta, Stiffness::Last),
    ] {
        let q = decay(&bar(alpha, beta, stiffness), &mut pure.clone(), 60, dt);
        let (found, at) = ratio(&q, 10, dt);
        let theory = alpha / (2.0 * at) + beta * at / 2.0;
        println!(
            "α = {alpha:.3} 1/s, β = {beta:.2e} s, {stiffness:?}: ζ = {found:.6}, theory {theory:.6}, ω/ω₁ = {:.5}",
            at / omega
        );
        assert!((at / omega - 1.0).abs() <= 0.005, "ω = {at}");
        assert!((found / theory - 1.0).abs() <= 1e-7, "ζ = {found}, theory {theory}");
    }
}

/// A bar that starts in its first mode, after `steps` steps over a quarter of a period in so many stages.
fn swung(integrator: Integrator, steps: usize, stages: usize) -> Vec<f64> {
    let omega = std::f64::consts::PI * 10.0 / 0.2;
    let (mesh, system) = bar(0.0, 2.0 / omega * 0.05, Stiffness::Initial);
    let mut state = State::rest(mesh.points.len(), 0);
    for (k, p) in mesh.points.iter().enumerate() {
        state.v[3 * k] = 0.1 * (std::f64::consts::PI * p.x / 0.2).sin();
    }
    let length = std::f64::consts::FRAC_PI_2 / omega / stages as f64;
    let span = |k: usize| TimeSpan {
        integrator,
        start: k as f64 * length,
        end: (k + 1) as f64 * length,
        dt: length / (steps / stages) as f64,
    };
    let spans: Vec<TimeSpan> = (0..stages).map(span).collect();
    let mut driver = Driver::new(&system, newton(&system, 1e-12, mesh.diagonal()), StepSettings::default());
    let status = driver.run_spans(&spans, None, &mut state, &mut ());
    assert_eq!((status, driver.totals.steps), (Status::Converged, steps));
    state.x
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// The acceleration at the start of a stage has the damping of its velocities. The trapezoidal rule ends each step with M a = −r, so stages
/// that follow each other change nothing but what 1e-12 of the forces leaves; without the damping at their starts it is some
/// ζωΔt = 1e-3 of the motion.
#[test]
fn stages_that_follow_each_other_are_one() {
    let (one, four) = (swung(TRAPEZOID, 80, 1), swung(TRAPEZOID, 80, 4));
    let off = distance(&one, &four) / distance(&one, &vec![0.0; one.len()]);
    assert!(off <= 1e-8, "{off:e}");
}

/// The order in time of a bar that is damped and starts with a velocity: 2, where an acceleration at the start without damping leaves 1. The
/// second term of the error series is a share ωΔt < 0.004 of the first.
#[test]
fn a_damped_start_has_the_order_of_the_integrator() {
    for integrator in [TRAPEZOID, Integrator::GeneralisedAlpha { rho: 0.8 }, Integrator::Bdf2] {
        let [a, b, c] = [400, 800, 1600].map(|steps| swung(integrator, steps, 1));
        let order = (distance(&a, &b) / distance(&b, &c)).log2();
        println!("{integrator:?}: order {order:.3}");
        assert!((order - 2.0).abs() <= 0.1, "{integrator:?}: order {order}");
    }
}

/// r of all blocks [3 × nodes].
fn residual(effect: &dyn Effect, at: &At) -> Vec<f64> {
    let mut r = vec![0.0; at.x.len()];
    for b in 0..effect.blocks().len() {
        let mut out = BlockValues::new(effect.blocks().size(b));
        effect.eval(at, b, Want::Residual, &mut out).expect("defined");
        effect.blocks().dofs(b).zip(&out.r).for_each(|(dof, f)| r[dof as usize] += f);
    }
    r
}

fn moving<'a>(x: &'a [f64], v: &'a [f64], old: &'a [f64]) -> At<'a> {
    At { t: 0.0, dt: 0.1, x, v, a: v, old, history: &[], inputs: &[], rates: Rates { cv: 10.0, ca: 100.0 } }
}

/// r = β d/ds r_elastic(x* + s v) by central differences of the elastic forces, at rest or at the start of the step. Steps of
/// 1e-5 with displacements of order 0.03 on cells of ½: truncation (1e-5/0.05)² = 4e-8, rounding ε/1e-5 = 2e-11.
#[test]
fn force_is_beta_times_the_slope_of_the_elastic_forces() {
    let mut random = Random::seed(8);
    for order in common::ORDERS {
        let mesh = common::distorted_cube(2, order, 0.1, 3);
        let n = 3 * mesh.points.len();
        let [x, v, old] = [0.03, 1.0, 0.03].map(|size| random.vector(n, size));
        let zero = vec![0.0; n];
        let material = elastic(&mesh, law("neo_hookean", 1e5, 0.4));
        for (stiffness, base) in [(Stiffness::Initial, &zero), (Stiffness::Last, &old)] {
            let found = residual(&damping(&mesh, law("neo_hookean", 1e5, 0.4), 0.02, stiffness), &moving(&x, &v, &old));
            let elastic = |s: f64| {
                let x: Vec<f64> = base.iter().zip(&v).map(|(x, v)| x + s * v).collect();
                residual(&*material, &moving(&x, &v, &x))
            };
            let (plus, minus) = (elastic(1e-5), elastic(-1e-5));
            let slope: Vec<f64> = plus.iter().zip(&minus).map(|(p, m)| 0.02 * (p - m) / 2e-5).collect();
            let size = common::largest(&slope);
            for (found, slope) in found.iter().zip(&slope) {
                assert!((found - slope).abs() <= 1e-6 * size, "{stiffness:?}: {found}, differences say {slope}");
            }
        }
    }
}

/// What the theory page says of rotations: a body that starts to turn is not resisted; one that was turned by 60° and turns
/// on is, by βK₀, and is not, free of stress, by βK(xₙ). Against the resistance to a random motion of the same speed.
#[test]
fn turning_costs_with_the_first_stiffness_only() {
    let mesh = block(2, 1, 1, 0.2, 0.1, 0.1, Order::Linear);
    let turned = |angle: f64| {
        let (s, c) = f64::sin_cos(angle);
        let q = Mat3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
        let x: Vec<f64> = mesh.points.iter().flat_map(|p| (q * p - p).data.0[0]).collect();
        let v: Vec<f64> = mesh.points.iter().flat_map(|p| Vec3::z().cross(&(q * p)).data.0[0]).collect();
        (x, v)
    };
    let force = |stiffness: Stiffness, x: &[f64], v: &[f64]| {
        let effect = damping(&mesh, law("neo_hookean", 1e5, 0.4), 0.02, stiffness);
        common::largest(&residual(&effect, &moving(x, v, x)))
    };
    let random = Random::seed(3).vector(3 * mesh.points.len(), 0.1);
    for stiffness in [Stiffness::Initial, Stiffness::Last] {
        let (start, later) = (turned(0.0), turned(std::f64::consts::FRAC_PI_3));
        let size = force(stiffness, &start.0, &random);
        assert!(force(stiffness, &start.0, &start.1) <= 1e-12 * size, "{stiffness:?} resists the start");
        let resistance = force(stiffness, &later.0, &later.1) / size;
        println!("turning on after 60°, {stiffness:?}: {resistance:.2e} of a random motion");
        assert_eq!(resistance > 0.05, stiffness == Stiffness::Initial, "{stiffness:?}: {resistance}");
        assert!(stiffness == Stiffness::Initial || resistance <= 1e-12);
    }
}

/// Elastic + kinetic + dissipated = work for elastic and spring bodies under gravity with every damping that has a stiffness;
/// the mismatch shrinks with Δt as in `dynamics.rs`.
#[test]
fn dissipation_balances_to_first_order() {
    let elastic = "kind = \"elastic\"\nlaw = \"rubber\"";
    let springs = "kind = \"edge_springs\"\nE = \"100 kPa\"";
    let lagged = "kind = \"stiffness_damping\"\nbeta = \"5 ms\"\nstiffness = \"last\"";
    let initial = "kind = \"stiffness_damping\"\nbeta = \"5 ms\"\nstiffness = \"initial\"";
    let dampers = "kind = \"edge_dampers\"\ndamping = \"1 N s/m\"";
    for (body, damping) in [(elastic, lagged), (elastic, initial), (springs, lagged), (springs, dampers)] {
        let mismatch = |dt: f64| {
            let text = format!(
                r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.4
[[effect]]
region = "body"
{damping}
[[effect]]
region = "body"
{body}
[[effect]]
kind = "inertia"
region = "body"
density = "1000 kg/m^3"
mass = "uniform"
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
integrator = "implicit_euler"
duration = "0.2 s"
dt = "{dt} s"
[[probe]]
kind = "energy"
"#
            );
            let scene = scene(block(6, 2, 2, 0.06, 0.01, 0.01, Order::Linear), &text);
            assert!(scene.system.effects.iter().any(|e| e.role() == EnergyRole::Dissipative));
            let result = run(&scene);
            assert_eq!(result.status, Status::Converged);
            let [e, k, d, w] = ["elastic_J", "kinetic_J", "dissipated_J", "work_J"].map(|name| column(&result, name));
            let size = common::largest(&w);
            let share = d.last().unwrap() / size;
            assert!(share > 0.05, "the damping matters: {share}");
            (0..w.len()).map(|i| (e[i] + k[i] + d[i] - w[i]).abs()).fold(0.0, larger) / size
        };
        let (coarse, fine) = (mismatch(0.001), mismatch(0.0005));
        println!("energy balance, {body:?}, {damping:?}: {coarse:.2e} of the work at 1 ms, {fine:.2e} at 0.5 ms");
        assert!(coarse <= 0.05 && coarse / fine >= 1.8, "{coarse:e}, {fine:e}");
    }
}

/// The blocks of a cable are lists of its guides, which the damping would take for nodes.
#[test]
fn an_effect_on_means_is_not_damped() {
    let mesh = block(1, 1, 1, 0.1, 0.1, 0.1, Order::Linear);
    let guides = [0, 1].map(|k| Guide { point: mesh.points[k], weights: vec![(k as u32, 1.0)] });
    let cable = Arc::new(Cable::through("pull".into(), None, guides.into()));
    let damped: Arc<dyn Effect> = Arc::new(CableTension { cable, tension: Signal::Constant(1.0) });
    let refused = StiffnessDamping::new(vec![damped], 0.02, Stiffness::Initial, &mesh.points).err();
    assert_eq!(refused, Some(Undamped::OnMeans { effect: "pull".into() }));
}
