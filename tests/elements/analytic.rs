//! Closed forms: uniaxial block, elastica, own weight, stiffness ratio.

use crate::common;
use crate::common::{DeadLoad, ORDERS, elastic, hold, law, nodes, ramp, reaction, statics};
use durometer::effect::{Elastic, Gravity};
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::disturb::distort;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::solve::{Driver, Integrator, Status, StepSettings, TimeSpan};
use durometer::system::{Prescribed, State, System};

/// Nominal stress over μ and lateral stretch of ψ = ½μ(I₁ − 3) − μ ln J + ½λ(ln J)² at axial stretch s with free sides:
/// μ(l − 1/l) + λ ln(s l²)/l = 0 by bisection, then P = μ(s − 1/s) + λ ln(s l²)/s.
fn uniaxial(nu: f64, s: f64) -> (f64, f64) {
    let ratio = 2.0 * nu / (1.0 - 2.0 * nu);
    let side = |l: f64| (l - 1.0 / l) + ratio * (s * l * l).ln() / l;
    let (mut low, mut high) = (0.2, 3.0);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if side(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    (s - 1.0 / s + ratio * (s * low * low).ln() / s, low)
}

/// The state is homogeneous, so the elements hold it exactly; what remains is the tolerance of the solve
/// (1e-11 of the internal forces, times λ/μ ≤ 500 in the pressure): 1e-8.
#[test]
fn uniaxial_block_meets_the_closed_form() {
    for (nu, s, stress, lateral) in [
        (0.45, 2.0, 1.736509, 0.725935),
        (0.45, 0.5, -3.149698, 1.35087),
        (0.499, 2.0, 1.749750, 0.707461),
        (0.499, 0.5, -3.492024, 1.412803),
    ] {
        let (p, l) = uniaxial(nu, s);
        assert!((p - stress).abs() < 1e-6 && (l - lateral).abs() < 1e-5, "the table says {stress}, {lateral}");
        for order in ORDERS {
            let mut mesh = block(2, 2, 2, 1.0, 1.0, 1.0, order);
            distort(&mut mesh, 11, 0.2);
            let mu = 1e5 / (2.0 * (1.0 + nu));
            let end = nodes(&mesh, "xmax");
            let mut prescribed = Vec::new();
            for (component, side) in [(0, "xmin"), (1, "ymin"), (2, "zmin")] {
                prescribed.extend(hold(&nodes(&mesh, side), &[component]));
            }
            prescribed.extend(end.iter().map(|n| Prescribed { dof: 3 * n, signal: ramp(s - 1.0) }));
            let effects = vec![elastic(&mesh, law("neo_hookean", 1e5, nu))];
            let system = System::new(mesh.points.len(), effects, vec![], prescribed).unwrap();
            let (state, sums) = statics(&mesh, &system, 1e-11, 5);
            let force = reaction(&sums, &end).x / mu;
            let error = (force / p - 1.0).abs();
            let off = |&n: &u32| (state.x[3 * n as usize + 1] + 1.0 - l).abs();
            let side = nodes(&mesh, "ymax").iter().map(off).fold(0.0, larger);
            println!("uniaxial nu {nu}, stretch {s}, {order:?}: stress {error:.1e}, side {side:.1e}");
            assert!(error <= 1e-8, "nu {nu}, stretch {s}, {order:?}: P/μ = {force}, closed form {p}");
            assert!(side <= 1e-8, "nu {nu}, stretch {s}, {order:?}: lateral stretch off by {side:e}");
        }
    }
}

/// Tip of an inextensible rod of length 1 and EI = 1 clamped at s = 0 under a transverse dead load with the shear force
/// w(s) beyond s: θ″ = −w cos θ, θ(0) = 0, θ′(1) = 0. Runge–Kutta with 2000 steps and bisection on θ′(0): 1e-10.
/// Returns the deflection and the shortening along the rod.
fn elastica(w: impl Fn(f64) -> f64) -> (f64, f64) {
    let steps = 2000;
    let shoot = |k0: f64| {
        let h = 1.0 / steps as f64;
        let f = |s: f64, y: [f64; 4]| [y[1], -w(s) * y[0].cos(), y[0].sin(), y[0].cos()];
        let add = |y: [f64; 4], k: [f64; 4], c: f64| -> [f64; 4] { std::array::from_fn(|i| y[i] + c * k[i]) };
        let mut y = [0.0, k0, 0.0, 0.0];
        for n in 0..steps {
            let s = n as f64 * h;
            let k1 = f(s, y);
            let k2 = f(s + 0.5 * h, add(y, k1, 0.5 * h));
            let k3 = f(s + 0.5 * h, add(y, k2, 0.5 * h));
            let k4 = f(s + h, add(y, k3, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        }
        y
    };
    // θ′(1) grows with θ′(0) up to the first solution.
    let (mut low, mut high) = (0.0, 10.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if shoot(middle)[1] < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let [_, _, deflection, along] = shoot(low);
    (deflection, 1.0 - along)
}

#[test]
fn the_rod_equation_reproduces_the_published_digits() {
    // Mattiasson, IJNME 17 (1981), table I; own weight: digits of this integration with twice the steps.
    for (load, deflection) in [(1.0, 0.30172), (2.0, 0.49346), (5.0, 0.71379), (10.0, 0.81061)] {
        assert!((elastica(|_| load).0 - deflection).abs() < 6e-6, "PL²/EI = {load}");
    }
    for (load, deflection) in [(1.0, 0.12347), (5.0, 0.49591), (10.0, 0.70020)] {
        assert!((elastica(|s| load * (1.0 - s)).0 - deflection).abs() < 6e-6, "qL³/EI = {load}");
    }
}

/// A beam along x, L/h = 50, of square section, one box of six tet10 cells per section, ν = 0 (no anticlastic bending at the
/// clamp). Length 1 m, E = 1 MPa.
fn beam() -> (TetMesh, f64) {
    let h = 0.02;
    (block(50, 1, 1, 1.0, h, h, Order::Quadratic), 1e6 * h.powi(4) / 12.0)
}

fn tip(mesh: &TetMesh, x: &[f64]) -> (f64, f64) {
    let end = nodes(mesh, "xmax");
    let mean = |c: usize| end.iter().map(|&n| x[3 * n as usize + c]).sum::<f64>() / end.len() as f64;
    (-mean(2), -mean(0))
}

/// Deflection and shortening against the rod, to 1 % of each: shear is (h/L)² = 4e-4 of the deflection, the strain of the
/// surface at the clamp (κh/2 ≤ 4.5 %, St Venant–Kirchhoff) changes the moment by its square, and 50 elements turn by
/// 5° at most.
fn compare(label: &str, got: (f64, f64), rod: (f64, f64)) {
    let errors = (got.0 / rod.0 - 1.0, got.1 / rod.1 - 1.0);
    println!("{label}: deflection {:.6} (rod {:.6}), errors {:.2e}, {:.2e}", got.0, rod.0, errors.0, errors.1);
    assert!(errors.0.abs() <= 0.01 && errors.1.abs() <= 0.01, "{label}: {got:?}, rod {rod:?}");
}

/// A dead load over the end face (Mattiasson 1981).
#[test]
fn cantilever_under_an_end_load_follows_the_elastica() {
    for load in [1.0, 10.0] {
        let (mesh, ei) = beam();
        let force = Vec3::new(0.0, 0.0, -load * ei);
        let effects = vec![
            elastic(&mesh, law("st_venant_kirchhoff", 1e6, 0.0)),
            Box::new(DeadLoad::traction(&mesh, "xmax", ramp(1.0), force)) as _,
        ];
        let prescribed = hold(&nodes(&mesh, "xmin"), &[0, 1, 2]);
        let system = System::new(mesh.points.len(), effects, vec![], prescribed).unwrap();
        let (state, sums) = statics(&mesh, &system, 1e-8, 5);
        compare(&format!("elastica PL²/EI = {load}"), tip(&mesh, &state.x), elastica(|_| load));
        let held = reaction(&sums, &nodes(&mesh, "xmin"));
        assert!((held + force).norm() <= 1e-5 * force.norm(), "the clamp carries {held}, the load is {force}");
    }
}

/// Gravity switched on as a ramp.
#[test]
fn cantilever_under_its_own_weight_follows_the_elastica() {
    for load in [1.0, 5.0, 10.0] {
        let (mesh, ei) = beam();
        let acceleration = load * ei / (1000.0 * 0.02 * 0.02);
        let weight = Gravity::new(&mesh, &common::body(&mesh), 1000.0, Vec3::new(0.0, 0.0, -1.0), ramp(acceleration));
        let effects = vec![elastic(&mesh, law("st_venant_kirchhoff", 1e6, 0.0)), Box::new(weight) as _];
        let prescribed = hold(&nodes(&mesh, "xmin"), &[0, 1, 2]);
        let system = System::new(mesh.points.len(), effects, vec![], prescribed).unwrap();
        let (state, _) = statics(&mesh, &system, 1e-8, 5);
        compare(&format!("own weight qL³/EI = {load}"), tip(&mesh, &state.x), elastica(|s| load * (1.0 - s)));
    }
}

/// Two halves in series, one stiffer by 1e3 to 1e8; u = F Σ L/(E A), to 1e-6.
///
/// Where the stiff half hangs on the soft one, it moves as a rigid body, and the entries of its stiffness (of the size
/// ratio · E) sum to zero only up to ε: it gets a spurious stiffness of ε · ratio relative to the soft half, times the
/// number of entries in a sum, 2.5e-6 here at 1e8 after one iteration. Every iteration multiplies the error by that.
#[test]
fn stiffness_ratio_leaves_the_series_bar_exact() {
    for ratio in [1e3, 1e5, 1e7, 1e8] {
        for (order, stiff_first) in ORDERS.into_iter().flat_map(|order| [(order, true), (order, false)]) {
            // Not distorted: the face between the halves must stay plane.
            let mesh = block(4, 2, 2, 0.4, 0.1, 0.1, order);
            let first = |c: &u32| mesh.position(*c as usize, [0.25; 3]).x < 0.2;
            let (near, far): (Vec<u32>, Vec<u32>) = common::body(&mesh).into_iter().partition(first);
            let (e, force) = (1e4, Vec3::new(0.5, 0.0, 0.0));
            let (e_near, e_far) = if stiff_first { (e * ratio, e) } else { (e, e * ratio) };
            let effects = vec![
                Box::new(Elastic::new("near".into(), &mesh, &near, law("linear", e_near, 0.0))) as _,
                Box::new(Elastic::new("far".into(), &mesh, &far, law("linear", e_far, 0.0))) as _,
                Box::new(DeadLoad::traction(&mesh, "xmax", ramp(1.0), force)) as _,
            ];
            let prescribed = hold(&nodes(&mesh, "xmin"), &[0, 1, 2]);
            let system = System::new(mesh.points.len(), effects, vec![], prescribed).unwrap();
            let (state, _) = statics(&mesh, &system, 1e-8, 1);
            let wanted = force.x / 0.01 * (0.2 / e + 0.2 / (e * ratio));
            let error = |&n: &u32| (state.x[3 * n as usize] / wanted - 1.0).abs();
            let worst = nodes(&mesh, "xmax").iter().map(error).fold(0.0, larger);
            println!("stiffness ratio {ratio:.0e} {order:?}, stiff half at the clamp {stiff_first}: {worst:.1e}");
            assert!(worst <= 1e-6, "ratio {ratio:e}, {order:?}, stiff half at the clamp {stiff_first}: {worst:e}");
        }
    }
}

/// A body that nothing holds has no equilibrium under its weight: the status says that it can move, and does not blame the
/// size of the load.
#[test]
fn a_free_body_is_reported_as_such() {
    for (held, free) in [(vec![], "everything"), (vec![0], "y and z and rotations")] {
        for order in ORDERS {
            let mesh = block(3, 1, 1, 0.03, 0.01, 0.01, order);
            let weight = Gravity::new(&mesh, &common::body(&mesh), 1000.0, Vec3::new(0.0, 0.0, -1.0), ramp(9.81));
            let effects = vec![elastic(&mesh, law("neo_hookean", 1e5, 0.45)), Box::new(weight) as _];
            let prescribed = hold(&nodes(&mesh, "xmin"), &held);
            let system = System::new(mesh.points.len(), effects, vec![], prescribed).unwrap();
            let mut driver =
                Driver::new(&system, common::newton(&system, 1e-8, mesh.diagonal()), StepSettings::default());
            let mut state = State::rest(mesh.points.len(), 0);
            let span = TimeSpan { integrator: Integrator::Static, start: 0.0, end: 1.0, dt: 0.5 };
            let status = driver.run(span, &mut state, &mut ());
            println!("free: {free}, {order:?}: {status:?}");
            assert!(matches!(status, Status::Singular { .. }), "free: {free}, {order:?}: {status:?}");
            assert!(state.x.iter().all(|x| x.is_finite()));
            assert!(status.culprit().node.is_some(), "{status}");
        }
    }
}
