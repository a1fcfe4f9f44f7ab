//! Springs and dampers on edges against sums by hand: a tetrahedron, a lattice, a truss that snaps through, a damped edge.

use crate::common;
use crate::common::{
    Random, body, distorted_cube, hold, move_to, newton, nodes, ramp, reaction, run, scene, statics, surface,
};
use durometer::effect::{EdgeDampers, EdgeSprings};
use durometer::math::statistics::{larger, smaller};
use durometer::math::stopwatch::Spent;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::solve::{AcceptedStep, Driver, Integrator, Status, StepSettings, TimeSpan};
use durometer::system::{At, BlockValues, Effect, EnergyRole, EvalError, Prescribed, Rates, State, System, Want};
use std::collections::BTreeMap;

/// Effect at displacement x, not moving.
fn eval(effect: &dyn Effect, x: &[f64], b: usize, want: Want) -> Result<BlockValues, EvalError> {
    let zero = vec![0.0; x.len()];
    let at = At { t: 0.0, dt: 1.0, x, v: &zero, a: &zero, old: x, history: &[], inputs: &[], rates: Rates::default() };
    let mut out = BlockValues::new(effect.blocks().size(b));
    effect.eval(&at, b, want, &mut out)?;
    Ok(out)
}

fn energy(effect: &dyn Effect, x: &[f64]) -> f64 {
    (0..effect.blocks().len()).map(|b| eval(effect, x, b, Want::Energy).expect("defined").energy).sum()
}

/// u = (F − I) X at every node.
fn affine(mesh: &TetMesh, gradient: &Mat3) -> Vec<f64> {
    mesh.points.iter().flat_map(|p| (gradient * p).iter().copied().collect::<Vec<_>>()).collect()
}

/// A regular tetrahedron of side a with its base in the plane z = 0 and its apex, node 3, above the middle of the base.
fn regular(a: f64) -> TetMesh {
    let (r, h) = (a / 3f64.sqrt(), a * (2.0 / 3.0_f64).sqrt());
    let base = [0.0, 1.0, 2.0].map(|k: f64| {
        let angle = std::f64::consts::TAU * k / 3.0;
        Vec3::new(r * angle.cos(), r * angle.sin(), 0.0)
    });
    let points = vec![base[0], base[1], base[2], Vec3::new(0.0, 0.0, h)];
    TetMesh { order: Order::Linear, points, cells: vec![0, 1, 2, 3], facets: vec![], regions: BTreeMap::new() }
}

/// The apex of a regular tetrahedron hangs on three edges with τ_z² = ⅔ and Σ τ_x² = Σ τ_y² = ½: K = k diag(½, ½, 2).
/// With k = E V/a², V = a³/6√2, that is E a/6√2 times the same. To rounding of a few products.
#[test]
fn apex_of_a_tetrahedron_by_hand() {
    let (a, e) = (0.03, 2e5);
    let mesh = regular(a);
    let of_modulus = e * a / (6.0 * 2f64.sqrt());
    for (springs, k) in
        [(EdgeSprings::uniform(&mesh, &[0], 7.0), 7.0), (EdgeSprings::of_modulus(&mesh, &[0], e), of_modulus)]
    {
        assert_eq!(springs.blocks().len(), 6);
        let mut stiffness = Mat3::zeros();
        for b in (0..6).filter(|&b| springs.blocks().nodes(b)[1] == 3) {
            let local = eval(&springs, &[0.0; 12], b, Want::Tangent).unwrap();
            stiffness += Mat3::from_fn(|i, j| local.k[6 * (3 + i.max(j)) + 3 + i.min(j)]);
        }
        let expected = Mat3::from_diagonal(&Vec3::new(0.5 * k, 0.5 * k, 2.0 * k));
        assert!((stiffness - expected).norm() <= 1e-14 * k, "{stiffness}");
    }
}

/// n springs of k in a row are one of k/n: displacement of the end by the force of its reaction, to the tolerance of the
/// solver.
#[test]
fn springs_in_a_row_add_their_compliance() {
    let n = 7;
    let points: Vec<Vec3> = (0..=n).map(|i| Vec3::new(0.01 * i as f64, 0.0, 0.0)).collect();
    let pairs: Vec<[u32; 2]> = (0..n).map(|i| [i, i + 1]).collect();
    let mesh = TetMesh { order: Order::Linear, points, cells: vec![], facets: vec![], regions: BTreeMap::new() };
    let springs: Box<dyn Effect> = Box::new(EdgeSprings::between(&mesh.points, &pairs, 40.0));
    let inner: Vec<u32> = (1..n).collect();
    let mut held = hold(&[0, n], &[1, 2]);
    held.extend(hold(&[0], &[0]));
    held.extend(hold(&inner, &[1, 2]));
    held.push(Prescribed { dof: 3 * n, signal: ramp(0.02) });
    let system = System::new(mesh.points.len(), vec![springs], vec![], held).unwrap();
    let (_, sums) = statics(&mesh, &system, 1e-12, 1);
    let force = reaction(&sums, &[n]).x;
    assert!((force / (40.0 / f64::from(n) * 0.02) - 1.0).abs() <= 1e-10, "{force} N");
}

/// A block of boxes under u = (F − I) X on its surface. Every inner node is a centre of symmetry of its edges, so it
/// follows; then the energy is Σ N ½ k (‖F e‖ − ‖e‖)² over the seven edges e of a box and their numbers N in the block,
/// and the reaction on the face x = l the sum of forces of the edges that arrive there. Solved to 1e-12.
#[test]
fn block_of_equal_springs_by_hand() {
    let (n, a, k) = ([3, 2, 2], 0.01, 50.0);
    let size = n.map(|n| a * n as f64);
    let mesh = block(n[0], n[1], n[2], size[0], size[1], size[2], Order::Linear);
    let gradient = Mat3::new(0.3, 0.2, 0.0, 0.0, -0.1, 0.0, 0.1, 0.0, 0.15);
    let springs: Box<dyn Effect> = Box::new(EdgeSprings::uniform(&mesh, &body(&mesh), k));
    let held = move_to(&mesh, &surface(&mesh), |p| gradient * p);
    let system = System::new(mesh.points.len(), vec![springs], vec![], held).unwrap();
    let (state, sums) = statics(&mesh, &system, 1e-12, 4);
    let moved = state.x.iter().zip(affine(&mesh, &gradient)).map(|(x, u)| (x - u).abs()).fold(0.0, larger);
    assert!(moved <= 1e-11 * a, "the inner nodes follow: {moved:e} m");
    let (mut total, mut pull) = (0.0, Vec3::zeros());
    for corner in 1..8 {
        let goes = [0, 1, 2].map(|i| corner >> i & 1);
        let e = Vec3::from(goes.map(|g| a * f64::from(g)));
        let d = e + gradient * e;
        let elongation = d.norm() - e.norm();
        // Along an axis that the edge does not go, it is on every layer of nodes.
        let layers = |i: usize| n[i] + 1 - goes[i] as usize;
        total += (layers(0) * layers(1) * layers(2)) as f64 * 0.5 * k * elongation * elongation;
        if goes[0] == 1 {
            pull += (layers(1) * layers(2)) as f64 * k * elongation * d / d.norm();
        }
    }
    assert!((sums.energy[0] / total - 1.0).abs() <= 1e-11, "{} J, by hand {total} J", sums.energy[0]);
    // Edges within the face pull on it from both ends.
    let force = reaction(&sums, &nodes(&mesh, "xmax"));
    assert!((force - pull).norm() <= 1e-11 * pull.norm(), "{force}, by hand {pull}");
}

/// ½ ε:C:ε of the lattice of a block with k = E Σ V/l²: C = E Σ w n⊗n⊗n⊗n with w = Σ k l²/(E a³), 1 for an axis, ⅔ for a
/// diagonal of a face, 1 for the one of a box (6, 4 and 6 cells of a³/6 around them).
fn lattice(strain: &Mat3) -> f64 {
    let directions = (1..8).map(|corner: u32| {
        let n = Vec3::from([0, 1, 2].map(|i| f64::from(corner >> i & 1)));
        (if corner.count_ones() == 2 { 2.0 / 3.0 } else { 1.0 }, n.normalize())
    });
    directions.map(|(w, n)| 0.5 * w * (n.dot(&(strain * n))).powi(2)).sum()
}

/// Orthonormal basis of the symmetric tensors.
fn strains() -> Vec<Mat3> {
    let mut basis = Vec::new();
    for i in 0..3 {
        for j in 0..=i {
            let mut b = Mat3::zeros();
            let value = if i == j { 1.0 } else { 0.5f64.sqrt() };
            (b[(i, j)], b[(j, i)]) = (value, value);
            basis.push(b);
        }
    }
    basis
}

/// Strains of 1e-6: what is not linear in them is 1e-6 of the energy.
#[test]
fn springs_of_a_modulus_have_the_tensor_of_their_lattice() {
    let e = 3e4;
    let mesh = block(3, 2, 2, 0.03, 0.02, 0.02, Order::Linear);
    let springs = EdgeSprings::of_modulus(&mesh, &body(&mesh), e);
    let mut random = Random::seed(5);
    for _ in 0..20 {
        let b = Mat3::from_fn(|_, _| random.around(1.0));
        let strain = b + b.transpose();
        let found = energy(&springs, &affine(&mesh, &(1e-6 * strain))) / (1e-12 * e * mesh.volume());
        assert!((found / lattice(&strain) - 1.0).abs() <= 1e-5, "{found}, by hand {}", lattice(&strain));
    }
}

/// On every mesh the isotropic part of the tensor is Hooke's with λ = μ = ⅖ E: both invariants C_iijj = 9λ + 6μ and C_ijij =
/// 3λ + 12μ are Σ k l²/V = 6 E. So Young's modulus is E and ν = ¼ where the edges have no preferred direction.
#[test]
fn springs_of_a_modulus_are_those_of_hooke_in_the_mean_over_directions() {
    let e = 3e4;
    let mesh = distorted_cube(3, Order::Linear, 0.25, 11);
    let springs = EdgeSprings::of_modulus(&mesh, &body(&mesh), e);
    let twice = |strain: &Mat3| 2.0 * energy(&springs, &affine(&mesh, &(1e-6 * strain))) / (1e-12 * e * mesh.volume());
    let (dilatation, sum) = (twice(&Mat3::identity()), strains().iter().map(twice).sum::<f64>());
    assert!((dilatation / 6.0 - 1.0).abs() <= 1e-5 && (sum / 6.0 - 1.0).abs() <= 1e-5, "{dilatation}, {sum}");
}

/// Young's modulus of a free bar of this lattice, over E, by the reaction to a small pull along x.
fn pulled(n: usize) -> f64 {
    let mesh = block(3 * n, n, n, 0.03, 0.01, 0.01, Order::Linear);
    let springs: Box<dyn Effect> = Box::new(EdgeSprings::of_modulus(&mesh, &body(&mesh), 1e5));
    let corner = |p: Vec3| mesh.points.iter().position(|q| (q - p).norm() < 1e-9).expect("a corner") as u32;
    let mut held = hold(&nodes(&mesh, "xmin"), &[0]);
    held.extend(hold(&[corner(Vec3::zeros())], &[1, 2]));
    held.extend(hold(&[corner(Vec3::new(0.0, 0.01, 0.0))], &[2]));
    let ends = nodes(&mesh, "xmax");
    held.extend(ends.iter().map(|&k| Prescribed { dof: 3 * k, signal: ramp(0.03e-5) }));
    let system = System::new(mesh.points.len(), vec![springs], vec![], held).unwrap();
    let (_, sums) = statics(&mesh, &system, 1e-10, 1);
    reaction(&sums, &ends).x / 1e-4 / 1e-5 / 1e5
}

/// 1/(n⊗n : C⁻¹ : n⊗n) of the homogeneous lattice. A bar of it has free sides with other springs than the inside, a layer of
/// one box of 2, 4, 8: it approaches the lattice, from 0.1 % at first. The lattice is no isotropic body.
#[test]
fn young_modulus_of_a_lattice() {
    let basis = strains();
    let c = |a: &Mat3, b: &Mat3| lattice(&(a + b)) - lattice(a) - lattice(b);
    let matrix = nalgebra::SMatrix::<f64, 6, 6>::from_fn(|i, j| c(&basis[i], &basis[j]));
    let compliance = matrix.try_inverse().expect("a stable lattice");
    let modulus = |n: Vec3| {
        let pull = nalgebra::SVector::<f64, 6>::from_fn(|i, _| n.dot(&(basis[i] * n)));
        1.0 / pull.dot(&(compliance * pull))
    };
    let along = modulus(Vec3::x());
    let found = [2, 4, 8].map(pulled);
    println!("Young's modulus of the lattice along x over E: {along:.4}; bars of 2, 4, 8 boxes across: {found:.4?}");
    let error = found.map(|f| (f / along - 1.0).abs());
    assert!(error[0] <= 1e-3 && error[0] > error[1] && error[1] > error[2], "{error:?}");
    let mut random = Random::seed(12);
    let all: Vec<f64> = (0..20_000).map(|_| modulus(Vec3::from_fn(|_, _| random.around(1.0)).normalize())).collect();
    let (low, high) = all.iter().fold((f64::INFINITY, 0.0), |(l, h), m| (smaller(l, *m), larger(h, *m)));
    println!("over all directions {low:.3} to {high:.3}");
    assert!(low < 1.0 && high > 1.0 && high / low > 1.2, "{low} to {high}");
}

/// Two bars of length l₀ over a half-span a and a height h, pushed down by w: P = 2EA(h − w)(1/l − 1/l₀), with
/// EA = k l₀, through both limit points to the mirrored state. Relative to the largest P; solved to 1e-12.
#[test]
fn two_bar_truss_snaps_through() {
    let (a, h, k) = (0.1, 0.015, 2e3);
    let points = vec![Vec3::new(-a, 0.0, 0.0), Vec3::new(a, 0.0, 0.0), Vec3::new(0.0, 0.0, h)];
    let mesh = TetMesh { order: Order::Linear, points, cells: vec![], facets: vec![], regions: BTreeMap::new() };
    let springs: Box<dyn Effect> = Box::new(EdgeSprings::between(&mesh.points, &[[0, 2], [1, 2]], k));
    let mut held = hold(&[0, 1], &[0, 1, 2]);
    held.extend(hold(&[2], &[1]));
    held.push(Prescribed { dof: 8, signal: ramp(-2.0 * h) });
    let system = System::new(3, vec![springs], vec![], held).unwrap();
    let mut driver = Driver::new(&system, newton(&system, 1e-12, mesh.diagonal()), StepSettings::default());
    let (mut state, mut curve) = (system.rest(), Vec::new());
    let span = TimeSpan { integrator: Integrator::Static, start: 0.0, end: 1.0, dt: 0.025 };
    let status = driver.run(span, &mut state, &mut |step: &AcceptedStep| {
        let AcceptedStep { now, sums, .. } = *step;
        curve.push((-now.x[8], -sums.r[8]));
        true
    });
    assert_eq!(status, Status::Converged);
    let rest = a.hypot(h);
    let by_hand = |w: f64| 2.0 * k * rest * (h - w) * (1.0 / a.hypot(h - w) - 1.0 / rest);
    let largest = curve.iter().map(|(w, _)| by_hand(*w)).fold(0.0, larger);
    assert_eq!(curve.len(), 40);
    for (w, p) in &curve {
        assert!((p - by_hand(*w)).abs() <= 1e-9 * largest, "P({w}) = {p} N, by hand {}", by_hand(*w));
    }
    let (up, down) = (&curve[..20], &curve[20..]);
    assert!(up.iter().all(|(_, p)| *p > -1e-9 * largest) && down.iter().any(|(_, p)| *p < -0.9 * largest));
    assert!(curve.last().unwrap().1.abs() <= 1e-9 * largest, "free of force where it is mirrored");
}

/// Springs know lengths only: a mirrored body is at rest, an inverted cell no error. Coincident nodes are one.
#[test]
fn inversion_is_no_error_and_coincident_nodes_are() {
    let mesh = regular(0.02);
    let springs = EdgeSprings::uniform(&mesh, &[0], 10.0);
    let dampers = EdgeDampers::new(&mesh, &[0], 1.0);
    let mirrored = affine(&mesh, &Mat3::from_diagonal(&Vec3::new(0.0, 0.0, -2.0)));
    for b in 0..6 {
        let local = eval(&springs, &mirrored, b, Want::Tangent).expect("springs survive inversion");
        // Rounding of l − l₀ times k.
        assert!(common::largest(&local.r) <= 10.0 * 0.02 * 4.0 * f64::EPSILON, "{:?}", local.r);
    }
    let collapsed = affine(&mesh, &-Mat3::identity());
    assert!((energy(&springs, &collapsed) / (6.0 * 0.5 * 10.0 * 0.02 * 0.02) - 1.0).abs() <= 1e-14);
    let error = eval(&springs, &collapsed, 4, Want::Residual).err().expect("no direction");
    assert_eq!(error, EvalError::Coincident { effect: "edge_springs".into(), nodes: [1, 3] });
    assert_eq!(error.to_string(), "edge_springs: nodes 1 and 3 coincide");
    let zero = vec![0.0; 12];
    let rates = Rates { cv: 1.0, ca: 0.0 };
    let at = At { t: 0.0, dt: 1.0, x: &collapsed, v: &zero, a: &zero, old: &zero, history: &[], inputs: &[], rates };
    let error = dampers.eval(&at, 0, Want::Residual, &mut BlockValues::new(6)).expect_err("no direction");
    assert_eq!(error, EvalError::Coincident { effect: "edge_dampers".into(), nodes: [0, 1] });
}

/// A regular tetrahedron that was blown up and let go, without inertia: every edge obeys k (l − l₀) + c l̇ = 0, and implicit
/// Euler takes l − l₀ to the (1 + kΔt/c)-th part a step, at any amplitude. The dampers dissipate Σ c l̇² Δt, the springs
/// lose ½ k of the squares. Solved to 1e-12 in 10 steps.
#[test]
fn springs_and_dampers_relax_as_one_edge_does() {
    let (a, k, c, dt, blown) = (0.02, 30.0, 6.0, 0.02, 0.3);
    let mesh = regular(a);
    let effects: Vec<Box<dyn Effect>> =
        vec![Box::new(EdgeSprings::uniform(&mesh, &[0], k)), Box::new(EdgeDampers::new(&mesh, &[0], c))];
    assert_eq!(effects[1].role(), EnergyRole::Dissipative);
    // The middle of the base stays: node 0 moves along x, the others where symmetry takes them.
    let system = System::new(4, effects, vec![], hold(&[0, 1, 2, 3], &[2])[..3].to_vec()).unwrap();
    let mut state = State::rest(4, 0);
    state.x = affine(&mesh, &(blown * Mat3::identity()));
    let (mut elongation, mut worst) = (blown * a, 0.0_f64);
    let mut driver = Driver::new(&system, newton(&system, 1e-12, a), StepSettings::default());
    let integrator = Integrator::ImplicitEuler { linearised: false };
    let span = TimeSpan { integrator, start: 0.0, end: 10.0 * dt, dt };
    let status = driver.run(span, &mut state, &mut |step: &AcceptedStep| {
        let AcceptedStep { past, now, sums, .. } = *step;
        let next = elongation / (1.0 + k * dt / c);
        let l = (mesh.points[3] - mesh.points[0] + Vec3::from_column_slice(&now.x[9..])
            - Vec3::from_column_slice(&now.x[..3]))
        .norm();
        worst = larger(worst, (l - a - next).abs() / elongation);
        let stored = 6.0 * 0.5 * k * next * next;
        let lost = 6.0 * c * (next - elongation).powi(2) / (now.t - past.t);
        worst = larger(worst, (sums.energy[0] - stored).abs() / stored);
        worst = larger(worst, (sums.energy[1] - lost).abs() / lost);
        elongation = next;
        true
    });
    assert_eq!(status, Status::Converged);
    assert!(worst <= 1e-9, "{worst:e}");
}

/// A scene of springs alone has everything but a law.
#[test]
fn scene_of_springs_alone() {
    let text = |springs: &str| {
        format!(
            r#"
[mesh]
body = "block"
[[effect]]
kind = "edge_springs"
region = "body"
{springs}
[[effect]]
kind = "edge_dampers"
region = "body"
damping = "0.01 N s/m"
[[effect]]
kind = "inertia"
region = "body"
density = "1000 kg/m^3"
mass = "uniform"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["20 mm", "5 mm", "2 mm"], ["38 mm", "5 mm", "2 mm"]]
pull_point = ["-1 mm", "5 mm", "2 mm"]
guide_radius = "3 mm"
drive = {{ kind = "length", signal = {{ kind = "ramp", from = "0 mm", to = "4 mm", end = "0.2 s" }} }}
[[stage]]
integrator = "bdf2"
duration = "0.2 s"
dt = "20 ms"
[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
[[probe]]
kind = "stretch"
[[probe]]
kind = "energy"
"#
        )
    };
    let mesh = || block(8, 2, 2, 0.04, 0.01, 0.01, Order::Linear);
    let springs = scene(mesh(), &text("E = \"100 kPa\""));
    assert_eq!((springs.spec.formulation().as_str(), springs.law.is_none()), ("mass_spring", true));
    assert!(springs.no_limit.as_ref().is_some_and(|why| why.contains("ν = 1/4")), "{:?}", springs.no_limit);
    let result = run(&springs);
    assert_eq!(result.status, Status::Converged);
    let last = |name: &str| *common::column(&result, name).last().unwrap();
    assert!(last("bending_angle_deg") > 5.0 && last("cable_tension_N") > 0.0 && last("dissipated_J") > 0.0);
    assert!(last("stretch_max") > 1.0 && last("min_j") < 1.0 && last("elastic_J") > 0.0);
    let record = durometer::study::store::finished_run::record(&springs, &result, Spent::default());
    assert_eq!((record.law, record.formulation.as_str()), (None, "mass_spring"));
    let equal = scene(mesh(), &text("stiffness = \"20 N/m\""));
    assert!(equal.no_limit.is_some_and(|why| why.contains("1/h")));
}
