//! Viscoelastic overstress: relaxation, creep, storage and loss moduli, order in time, rotation, energy, cut steps.
//!
//! Closed forms for G(t) = G∞ + Σ β_α G∞ e^{−t/τ_α}. The recursion treats a jump within a step of length Δt as one at the
//! middle of the step, exactly: e^{−(t − Δt/2)/τ}.

use crate::common;
use crate::common::{DeadLoad, body, column, example, hold, newton, nodes, run, scene, surface};
use durometer::effect::{Elastic, Inertia, Lumping, Mass, Viscoelastic};
use durometer::material::{Arm, Constants, Prony, Want};
use durometer::math::signal::Signal;
use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::solve::{
    AcceptedStep, Driver, Integrator, NewtonSettings, Status, StepSettings, TimeSpan, initial_acceleration,
};
use durometer::system::{Effect, Prescribed, System};
use std::f64::consts::TAU;

const EULER: Integrator = Integrator::ImplicitEuler { linearised: false };
/// g, τ [s]
const ARMS: [(f64, f64); 2] = [(0.3, 0.05), (0.2, 0.4)];
/// β of long-term constants: g/(1 − Σg)
const BETA: [f64; 2] = [0.6, 0.4];

/// Elastic and viscoelastic effect of an example law on a whole body, with long-term constants.
fn effects(mesh: &TetMesh, law: &str) -> Vec<Box<dyn Effect>> {
    let arms: Vec<Arm> = ARMS.iter().map(|&(g, tau)| Arm { g, tau }).collect();
    let prony = Prony::new(&arms, Constants::LongTerm).expect("a series");
    let cells = body(mesh);
    vec![
        Box::new(Elastic::new("elastic".into(), mesh, &cells, example(law))),
        Box::new(Viscoelastic::new(mesh, &cells, &*example(law), prony).expect("an isochoric law")),
    ]
}

/// Moves the surface by x ↦ F(t)X at the times k Δt, from a body at F(0) on, and gives there the mean of P over the body, Σ r ⊗ X/V [Pa], and
/// what the step dissipated [J].
fn drive(mesh: &TetMesh, law: &str, (steps, dt): (usize, f64), f: impl Fn(f64) -> Mat3) -> Vec<(f64, Mat3, f64)> {
    let mut prescribed = Vec::new();
    for &k in &surface(mesh) {
        let p = mesh.points[k as usize];
        for c in 0..3u32 {
            let row = |t: f64| (t, ((f(t) - Mat3::identity()) * p)[c as usize]);
            let signal = Signal::Table((0..=steps).map(|n| row(n as f64 * dt)).collect());
            prescribed.push(Prescribed { dof: 3 * k + c, signal });
        }
    }
    let system = System::new(mesh.points.len(), effects(mesh, law), vec![], prescribed).expect("a system");
    let mut driver = Driver::new(&system, newton(&system, 1e-11, mesh.diagonal()), StepSettings::default());
    let (mut state, mut rows) = (system.rest(), Vec::new());
    for (u, p) in state.x.chunks_exact_mut(3).zip(&mesh.points) {
        u.copy_from_slice(((f(0.0) - Mat3::identity()) * p).as_slice());
    }
    system.begin(&mut state);
    let span = TimeSpan { integrator: EULER, start: 0.0, end: steps as f64 * dt, dt };
    let status = driver.run(span, &mut state, &mut |step: &AcceptedStep| {
        let AcceptedStep { now, sums, .. } = *step;
        let force = |k: usize| Vec3::from_column_slice(&sums.r[3 * k..3 * k + 3]);
        let virial: Mat3 = mesh.points.iter().enumerate().map(|(k, p)| force(k) * p.transpose()).sum();
        rows.push((now.t, virial / mesh.volume(), sums.dissipated[1]));
        true
    });
    assert_eq!((status, driver.totals.cuts), (Status::Converged, 0));
    rows
}

/// A block of 1 cm stretched to diag(λ, λ^{−½}, λ^{−½}) in the first step of `dt` and held: 20 steps, then two static
/// ones, then two dynamic ones. Times and P_xx [Pa].
fn relaxation(
    order: Order,
    formulation: &str,
    integrator: &str,
    moduli: &str,
    dt: f64,
    stretch: f64,
) -> Vec<(f64, f64)> {
    let lateral = stretch.powf(-0.5);
    let faces = [("x", stretch), ("y", lateral), ("z", lateral)].map(|(c, l)| {
        format!(
            "[[constraint]]\nkind = \"fixed\"\nregion = \"{c}min\"\ncomponents = \"{c}\"\n\
             [[constraint]]\nkind = \"prescribed\"\nregion = \"{c}max\"\ncomponents = \"{c}\"\n\
             displacement = {{ kind = \"ramp\", from = \"0 mm\", to = \"{} mm\", end = \"{dt} s\" }}\n",
            10.0 * (l - 1.0)
        )
    });
    let stage = |integrator: &str, steps: f64| {
        format!("[[stage]]\nintegrator = {integrator}\nduration = \"{} s\"\ndt = \"{dt} s\"\n", steps * dt)
    };
    let text = format!(
        r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean_split"
mu = "50 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "{formulation}"
[[effect]]
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "{moduli}"
prony = [{{ g = 0.3, tau = "50 ms" }}, {{ g = 0.2, tau = "0.4 s" }}]
{}{}{}{}
[[probe]]
kind = "reaction"
region = "xmax"
[numerics]
tolerance = 1e-11
"#,
        faces.concat(),
        stage(integrator, 20.0),
        stage("\"static\"", 2.0),
        stage(integrator, 2.0),
    );
    let result = run(&scene(block(2, 2, 2, 0.01, 0.01, 0.01, order), &text));
    assert_eq!((&result.status, result.totals.cuts), (&Status::Converged, 0), "{formulation} {integrator}");
    let force = column(&result, "xmax_reaction_x_N");
    column(&result, "t_s").into_iter().zip(force).map(|(t, f)| (t, f / 1e-4)).collect()
}

/// Stress of the incompressible motion in closed form: P_xx = μ(λ − I₁/3λ), I₁ = λ² + 2/λ, as J = 1 and U′ = 0. Then the
/// jump, its relaxation, the long-term answer of statics, and no memory of anything after it. Solved to 1e-11.
#[test]
fn a_held_stretch_relaxes_as_the_series_says_in_every_formulation() {
    let stretch = 1.3_f64;
    let elastic = 50e3 * (stretch - (stretch * stretch + 2.0 / stretch) / (3.0 * stretch));
    let cases = [
        (Order::Linear, "displacement", "\"implicit_euler\""),
        (Order::Linear, "mixed", "\"bdf2\""),
        (Order::Quadratic, "displacement", "\"bdf2\""),
        (Order::Quadratic, "mixed", "\"implicit_euler\""),
        (Order::Quadratic, "mean_dilatation", "\"implicit_euler\""),
    ];
    for (order, formulation, integrator) in cases {
        for (moduli, long_term) in [("long_term", elastic), ("instantaneous", 0.5 * elastic)] {
            let dt = 0.01;
            for (k, (t, p)) in relaxation(order, formulation, integrator, moduli, dt, stretch).into_iter().enumerate() {
                let left: f64 =
                    ARMS.iter().zip(BETA).map(|((_, tau), beta)| beta * (-(t - 0.5 * dt) / tau).exp()).sum();
                let expected = match k {
                    0 => 0.0,
                    1..=20 => long_term * (1.0 + left),
                    _ => long_term,
                };
                let error = (p - expected).abs() / elastic;
                assert!(error <= 1e-9, "{order:?} {formulation} {moduli}: P({t}) = {p}, not {expected}");
            }
        }
    }
}

/// Δt → 0: a jump meets G₀ = G∞/(1 − Σg) = 2 G∞, with the share Δt/2τ lost. Δt ≫ τ: a step ends at G∞.
#[test]
fn fast_and_slow_motions_meet_the_two_moduli() {
    let after_one_step =
        |dt: f64, moduli: &str| relaxation(Order::Linear, "displacement", "\"implicit_euler\"", moduli, dt, 1.2)[1].1;
    let (fast, slow) = (after_one_step(1e-6, "long_term"), after_one_step(100.0, "long_term"));
    // Σ β Δt/2τ = .6·1e-5 + .4·1.25e-6 = 6.5e-6 of G∞, so 3.3e-6 of G₀.
    assert!((fast / slow - 2.0).abs() <= 1e-5, "{}", fast / slow);
    let instantaneous = after_one_step(1e-6, "instantaneous");
    assert!((instantaneous / slow - 1.0).abs() <= 1e-5, "the law's own stress at once: {instantaneous}, {slow}");
}

/// Shear γ₀ sin ωt, γ₀ = 1e-4: G′ = G∞[1 + Σ β ω²τ²/(1 + ω²τ²)], G″ = G∞ Σ β ωτ/(1 + ω²τ²), and πG″γ₀²V dissipated a
/// period. With x = Δt/2τ and y = ωΔt/2 the recursion has β i sin y/sinh(x + iy) for β iy/(x + iy): relative error
/// |y² + (x + iy)²|/6 to leading order. The transient has gone to e^{−16} after the first seven periods of ωτ = 2.8.
#[test]
fn shear_shows_storage_and_loss_moduli() {
    let mesh = block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear);
    let (omega, amplitude, periods, per_period) = (7.0, 1e-4, 8, 200);
    let dt = TAU / omega / per_period as f64;
    let rows = drive(&mesh, "neo_hookean_split", (periods * per_period, dt), |t| {
        let mut f = Mat3::identity();
        f[(0, 1)] = amplitude * (omega * t).sin();
        f
    });
    let last = &rows[(periods - 1) * per_period..];
    let part = |phase: f64| {
        last.iter().map(|(t, p, _)| p[(0, 1)] * (omega * t + phase).sin()).sum::<f64>() * 2.0
            / per_period as f64
            / amplitude
    };
    let (storage, loss) = (part(0.0), part(0.25 * TAU));
    let mu = example("neo_hookean_split").small_strain().mu;
    let (mut g1, mut g2, mut bound) = (mu, 0.0, 0.0);
    for ((_, tau), beta) in ARMS.into_iter().zip(BETA) {
        let (w, y, x) = (omega * tau, 0.5 * omega * dt, 0.5 * dt / tau);
        g1 += mu * beta * w * w / (1.0 + w * w);
        g2 += mu * beta * w / (1.0 + w * w);
        bound += mu * beta * (2.0 * y * y + x * x) / 6.0;
    }
    println!("G′ {storage:.3} of {g1:.3} Pa, G″ {loss:.3} of {g2:.3} Pa, bound {bound:.3} Pa");
    assert!((storage - g1).abs() <= 1.1 * bound && (loss - g2).abs() <= 1.1 * bound);
    let dissipated: f64 = last.iter().map(|row| row.2).sum();
    let expected = 0.5 * TAU * loss * amplitude * amplitude * mesh.volume();
    // The trapezoidal rule gives sin(2y)/2y of the area of an ellipse: 1.6e-4 less here; γ₀² is far below.
    assert!((dissipated / expected - 1.0).abs() <= 2e-4, "{dissipated:e} J, not {expected:e}");
}

/// Error of P at the end of a smooth finite motion against the finest run: second order in Δt, from rest and from a strain that is there at the start.
#[test]
fn the_recursion_is_of_second_order() {
    let mesh = block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear);
    for begins_at in [0.0, 0.06] {
        let end = |steps: usize| {
            let rows = drive(&mesh, "mooney_rivlin", (steps, 0.3 / steps as f64), |t| {
                let (s, t) = ((5.0 * (t + begins_at)).sin(), t + begins_at);
                Mat3::new(1.0 + 0.4 * s, 0.3 * t, 0.0, 0.0, 1.0 - 0.2 * s, 0.2 * s, 0.0, 0.0, 1.0 - 0.1 * s)
            });
            rows.last().expect("steps").1
        };
        let [a, b, c] = [20, 40, 80].map(end);
        let order = ((a - b).norm() / (b - c).norm()).log2();
        println!("order of the recursion: {order:.3}");
        // Next term of the error series: (Δt/τ)² = .09 of the first at 20 steps.
        assert!((order - 2.0).abs() <= 0.1, "{order}");
    }
}

/// A strain that is there at the start has the overstress Σ β_α e^{−t/τ_α} ∂W/∂F in addition to P of the law, whatever the step, as the recursion is exact for a constant
/// strain. Solved to 1e-11.
#[test]
fn a_strain_that_is_there_at_the_start_relaxes_from_the_start_on() {
    let mesh = block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear);
    let f = Mat3::new(1.2, 0.3, 0.0, -0.1, 0.9, 0.2, 0.0, 0.1, 0.95);
    for name in ["neo_hookean_split", "mooney_rivlin", "ogden"] {
        let law = example(name);
        let whole = law.eval(&f, Want::Residual).expect("defined").p;
        let part = law.split().expect("a split law").0.eval(&f, Want::Residual).expect("defined").p;
        for dt in [0.2, 0.05, 0.0125] {
            for (t, p, dissipated) in drive(&mesh, name, (5, dt), |_| f) {
                let left: f64 = BETA.iter().zip(ARMS).map(|(beta, (_, tau))| beta * (-t / tau).exp()).sum();
                let expected = whole + left * part;
                let error = (p - expected).norm() / expected.norm();
                let rounding = 1e-9 * expected.norm() * mesh.volume();
                assert!(
                    error <= 1e-9 && dissipated.abs() <= rounding,
                    "{name}, Δt = {dt}, t = {t}: {error:e}, {dissipated:e} J"
                );
            }
        }
    }
}

/// A twist that is let go has W of the arms in `dissipated_J` at the start, of β = 1 as much as there is in the law but for what resists a change of volume, and they give
/// back no more. Elastic, kinetic and dissipated energy together keep their sum but for what the rule damps, and for the trapezoids of 0.05 ms, ωΔt = 0.2 of the
/// fastest motions that have energy.
#[test]
fn what_the_arms_hold_at_the_start_is_booked() {
    for tau in ["1 s", "10 ms"] {
        let text = format!(
            r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean_split"
mu = "100 kPa"
nu = 0.45
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
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "long_term"
prony = [{{ g = 0.5, tau = "{tau}" }}]
[start]
kind = "twisted"
axis = [1, 0, 0]
angle = "10 deg"
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = {{ kind = "generalised_alpha", rho = 0.9 }}
duration = "20 ms"
dt = "0.05 ms"
[[probe]]
kind = "energy"
"#
        );
        let result = run(&scene(block(4, 1, 1, 0.04, 0.01, 0.01, Order::Linear), &text));
        assert_eq!((&result.status, result.energy_from_nothing), (&Status::Converged, None), "{tau}");
        let [elastic, kinetic, dissipated] =
            ["elastic_J", "kinetic_J", "dissipated_J"].map(|name| column(&result, name));
        let held = dissipated[0];
        assert!(held > 0.5 * elastic[0] && held <= elastic[0], "{tau}: {held:e} of {:e} J", elastic[0]);
        for (k, booked) in dissipated.iter().enumerate() {
            let sum = elastic[k] + kinetic[k] + booked;
            assert!(sum <= 1.02 * (elastic[0] + held), "{tau}, row {k}: {sum:e} of {:e} J", elastic[0] + held);
            assert!(*booked >= -0.02 * held, "{tau}, row {k}: {booked:e} of {held:e} J");
        }
    }
}

/// P of the motion Q(t) F(t) is Q(t) P: the history does not see a rotation in time. Solved to 1e-11.
#[test]
fn a_superposed_rotation_turns_the_stress_with_it() {
    let mesh = block(2, 2, 2, 0.01, 0.01, 0.01, Order::Quadratic);
    let f = |t: f64| Mat3::identity() + t * Mat3::new(0.5, 0.2, 0.0, -0.1, -0.2, 0.3, 0.0, 0.1, -0.1);
    let q = |t: f64| *nalgebra::Rotation3::new(Vec3::new(0.5, -1.0, 2.0) * t).matrix();
    let still = drive(&mesh, "yeoh", (10, 0.1), f);
    let turned = drive(&mesh, "yeoh", (10, 0.1), |t| q(t) * f(t));
    for ((t, p, _), (_, rotated, _)) in still.into_iter().zip(turned) {
        let error = (rotated - q(t) * p).norm() / p.norm();
        assert!(error <= 1e-9, "t = {t}: {error:e}");
    }
}

/// Small-strain creep under a traction σ that jumps: ε = σ[1/9κ + J(t)/3], J(t) = (1/G∞)[1 − β/(1 + β) e^{−t/τ(1+β)}] for one
/// arm, quasi-static under implicit Euler. σ = 1e-5 E; Δt = τ/100, jump at Δt/2: (Δt/τ)² and σ/E are below 1e-4.
#[test]
fn a_loaded_block_creeps() {
    let mesh = block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear);
    let law = || example("neo_hookean_split");
    let (g, tau) = (0.4, 0.2);
    let (beta, dt) = (g / (1.0 - g), tau / 100.0);
    let hooke = law().small_strain();
    let sigma = 1e-5 * hooke.e;
    let prony = Prony::new(&[Arm { g, tau }], Constants::LongTerm).expect("a series");
    let jump = Signal::Ramp { from: 0.0, to: 1.0, start: 0.0, end: dt };
    let effects: Vec<Box<dyn Effect>> = vec![
        Box::new(Elastic::new("elastic".into(), &mesh, &body(&mesh), law())),
        Box::new(Viscoelastic::new(&mesh, &body(&mesh), &*law(), prony).expect("isochoric")),
        Box::new(DeadLoad::traction(&mesh, "xmax", jump, Vec3::new(sigma * 1e-4, 0.0, 0.0))),
    ];
    let symmetry = [("xmin", 0), ("ymin", 1), ("zmin", 2)];
    let held = symmetry.iter().flat_map(|(face, c)| hold(&nodes(&mesh, face), &[*c])).collect();
    let system = System::new(mesh.points.len(), effects, vec![], held).expect("a system");
    let mut driver = Driver::new(&system, newton(&system, 1e-10, mesh.diagonal()), StepSettings::default());
    let mut state = system.rest();
    let tip = 3 * nodes(&mesh, "xmax")[0] as usize;
    let span = TimeSpan { integrator: EULER, start: 0.0, end: 300.0 * dt, dt };
    let mut worst = 0.0_f64;
    let status = driver.run(span, &mut state, &mut |step: &AcceptedStep| {
        let AcceptedStep { now, .. } = *step;
        let left = beta / (1.0 + beta) * (-(now.t - 0.5 * dt) / (tau * (1.0 + beta))).exp();
        let expected = sigma * (1.0 / (9.0 * hooke.kappa) + (1.0 - left) / (3.0 * hooke.mu));
        worst = larger(worst, (now.x[tip] / 0.01 / expected - 1.0).abs());
        true
    });
    assert_eq!(status, Status::Converged);
    println!("creep: off by {worst:.1e} at most");
    assert!(worst <= 2e-4, "{worst:e}");
}

/// A block of finite strain, pulled to and fro: what was put in beyond the elastic energy is in `dissipated_J`, to the
/// second order of the trapezoidal rule; a steady cycle dissipates the area of its loop, which is positive.
#[test]
fn a_cycle_dissipates_the_area_of_its_loop() {
    let cycle = |dt: f64| {
        let text = format!(
            r#"
[mesh]
body = "block"
[laws.rubber]
law = "yeoh"
C10 = "18 kPa"
C20 = "-1 kPa"
C30 = "0.3 kPa"
volumetric = "quadratic"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "instantaneous"
prony = [{{ g = 0.3, tau = "50 ms" }}, {{ g = 0.2, tau = "0.2 s" }}]
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "xyz"
displacement = {{ kind = "sine", amplitude = "3 mm", frequency = "1 Hz" }}
[[stage]]
integrator = "bdf2"
duration = "3 s"
dt = "{dt} s"
[[probe]]
kind = "energy"
[[probe]]
kind = "reaction"
region = "xmax"
[[probe]]
kind = "position"
region = "xmax"
"#
        );
        let result = run(&scene(block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear), &text));
        assert_eq!(result.status, Status::Converged);
        let [e, d, w] = ["elastic_J", "dissipated_J", "work_J"].map(|name| column(&result, name));
        let balance = (0..w.len()).map(|i| (e[i] + d[i] - w[i]).abs()).fold(0.0, larger) / common::largest(&w);
        let start = w.len() - 1 - (1.0 / dt).round() as usize;
        let mut area = 0.0;
        for c in ["x", "y", "z"] {
            let f = column(&result, &format!("xmax_reaction_{c}_N"));
            let x = column(&result, &format!("xmax_{c}_m"));
            area += (start + 1..w.len()).map(|i| 0.5 * (f[i] + f[i - 1]) * (x[i] - x[i - 1])).sum::<f64>();
        }
        (balance, d[w.len() - 1] - d[start], area)
    };
    let ((coarse, ..), (fine, dissipated, area)) = (cycle(0.02), cycle(0.01));
    println!("energy balance {coarse:.1e} at 20 ms, {fine:.1e} at 10 ms; {dissipated:.4e} J of {area:.4e} J a cycle");
    assert!(coarse / fine > 3.5 && fine < 2e-3, "{coarse:e}, {fine:e}");
    assert!(dissipated > 0.0);
    // τ = .2 s leaves e^{−10} of the start after two periods; the rest is the error of the trapezoidal rule.
    assert!((dissipated / area - 1.0).abs() <= 1e-2, "{dissipated:e}, {area:e}");
}

/// A step that does not converge leaves no trace: state and history are those of a run that took the shorter steps at
/// once, to the last bit.
#[test]
fn cut_steps_leave_no_trace() {
    let mesh = block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear);
    let pull = Signal::Ramp { from: 0.0, to: 0.012, start: 0.0, end: 0.2 };
    let pulled = nodes(&mesh, "xmax").into_iter().map(|k| Prescribed { dof: 3 * k, signal: pull.clone() });
    let held = hold(&nodes(&mesh, "xmin"), &[0, 1, 2]);
    let prescribed = held.into_iter().chain(pulled).collect();
    let system = System::new(mesh.points.len(), effects(&mesh, "gent"), vec![], prescribed).expect("a system");
    // Few iterations, so that the whole step fails.
    let settings = NewtonSettings { max_iterations: 4, ..NewtonSettings::default() };
    let steps = StepSettings { extrapolate: false, ..StepSettings::default() };
    let driver =
        || Driver::new(&system, durometer::solve::NonlinearSolver::new(&system, settings, mesh.diagonal()), steps);
    let mut cut = driver();
    let (mut state, mut times) = (system.rest(), vec![0.0]);
    let span = TimeSpan { integrator: EULER, start: 0.0, end: 0.2, dt: 0.1 };
    let status = cut.run(span, &mut state, &mut |step: &AcceptedStep| {
        let AcceptedStep { now, .. } = *step;
        times.push(now.t);
        true
    });
    assert_eq!(status, Status::Converged);
    assert!(cut.totals.cuts > 0, "nothing was cut");
    let (mut again, mut direct) = (system.rest(), driver());
    for pair in times.windows(2) {
        let span = TimeSpan { integrator: EULER, start: pair[0], end: pair[1], dt: pair[1] - pair[0] };
        assert_eq!(direct.run(span, &mut again, &mut ()), Status::Converged);
    }
    assert_eq!(direct.totals.cuts, 0);
    assert!(state.history.iter().any(|h| *h != 0.0));
    assert_eq!((state.x, state.history), (again.x, again.history));
}

/// A stage that needs an acceleration at its start finds the one of the last step: M a = −r with the history as it is, no
/// time passed. The step was solved to 1e-11 of the forces, which are 1e3 times those of the inertia that is left.
#[test]
fn the_next_stage_starts_with_the_overstress_of_the_last() {
    let mesh = block(2, 1, 1, 0.02, 0.01, 0.01, Order::Linear);
    let mut effects = effects(&mesh, "neo_hookean_split");
    effects.push(Box::new(Inertia { mass: Mass::new(&mesh, &body(&mesh), 1000.0, Lumping::Consistent) }));
    let pull = Signal::Ramp { from: 0.0, to: 0.004, start: 0.0, end: 0.01 };
    let pulled = nodes(&mesh, "xmax").into_iter().map(|k| Prescribed { dof: 3 * k, signal: pull.clone() });
    let prescribed = hold(&nodes(&mesh, "xmin"), &[0, 1, 2]).into_iter().chain(pulled).collect();
    let system = System::new(mesh.points.len(), effects, vec![], prescribed).expect("a system");
    let mut driver = Driver::new(&system, newton(&system, 1e-11, mesh.diagonal()), StepSettings::default());
    let mut state = system.rest();
    let span = TimeSpan { integrator: EULER, start: 0.0, end: 0.02, dt: 0.001 };
    assert_eq!(driver.run(span, &mut state, &mut ()), Status::Converged);
    let a = system.restrict(&initial_acceleration(&system, &state).expect("the mass is regular"));
    let before = system.restrict(&state.a);
    let size = common::largest(&before);
    let error = a.iter().zip(&before).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
    println!("acceleration at the start of a stage: {error:.1e} of {size:.1e} m/s²");
    assert!(size > 0.0 && error <= 1e-6 * size, "{error:e} of {size:e}");
}

/// The bulk does not relax and is not affected: the overstress of every isochoric law has no mean stress, P:F = 0, at any
/// history. One tet4 cell gives P by its virial; rounding of a few dozen terms.
#[test]
fn the_overstress_has_no_pressure() {
    let mesh = block(1, 1, 1, 1.0, 1.0, 1.0, Order::Linear);
    let mut random = common::Random::seed(11);
    for entry in durometer::material::LAWS.iter().filter(|l| l.info.isochoric) {
        let effect = effects(&mesh, entry.info.name).remove(1);
        let history = random.vector(effect.capabilities().history_size() * effect.blocks().len(), 5e3);
        let (x, old) = (random.vector(3 * mesh.points.len(), 0.1), random.vector(3 * mesh.points.len(), 0.1));
        let zero = vec![0.0; x.len()];
        let at = durometer::system::At {
            t: 0.0,
            dt: 0.1,
            x: &x,
            v: &zero,
            a: &zero,
            old: &old,
            history: &history,
            inputs: &[],
            rates: Default::default(),
        };
        for b in 0..effect.blocks().len() {
            let mut out = durometer::system::BlockValues::new(12);
            effect.eval(&at, b, durometer::material::Want::Residual, &mut out).expect("regular");
            let (mut pressure, mut size) = (0.0, 0.0);
            for (k, &node) in effect.blocks().nodes(b).iter().enumerate() {
                for c in 0..3 {
                    let place = mesh.points[node as usize][c] + x[3 * node as usize + c];
                    pressure += out.r[3 * k + c] * place;
                    size += (out.r[3 * k + c] * place).abs();
                }
            }
            assert!(size > 0.0 && pressure.abs() <= 1e-13 * size, "{}: {pressure:e} of {size:e}", entry.info.name);
        }
    }
}

#[test]
fn a_scene_without_memory_has_no_history() {
    let mesh = block(1, 1, 1, 1.0, 1.0, 1.0, Order::Linear);
    let elastic = effects(&mesh, "yeoh").remove(0);
    let system = System::new(mesh.points.len(), vec![elastic], vec![], vec![]).expect("a system");
    assert_eq!(system.rest().history.capacity(), 0);
}
