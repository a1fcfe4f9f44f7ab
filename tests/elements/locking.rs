//! Formulations in the soft limit: what locks, and what does not.

use crate::common::cook::{bent, rubber, tip};
use crate::common::formulation::{Formulation, formulated, solid, stressed};
use crate::common::*;
use durometer::effect::pressure_scatter::pressure_scatter;
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::system::{At, Rates, System, Want};

/// Three formulations converge to 6.93 ± .02 (`cook.rs`); at n = 32 locking-free tet4 within 3 %, tet10 within .5 %, and within 1 % with one pressure a cell at n = 16; the
/// displacement formulation on tet4 stays more than 25 % low, and only there the alarm rings. Measured scatters: 14 to 18
/// locked, at most 0.3 else; the threshold is 0.5.
#[test]
fn cooks_membrane() {
    check_cooks_membrane(32, false);
}

/// The same with the diagonals of the cells the other way round, which is accurate at n = 16 already.
#[test]
fn cooks_membrane_mirrored() {
    check_cooks_membrane(16, true);
}

fn check_cooks_membrane(n: usize, mirrored: bool) {
    for (order, formulation, n, accept) in [
        (Order::Linear, Formulation::Mixed, n, 0.03),
        (Order::Quadratic, Formulation::Mixed, n, 0.005),
        (Order::Quadratic, Formulation::MeanDilatation, 16, 0.01),
    ] {
        let (mesh, x) = bent(n, order, formulation, mirrored);
        let (u, found) =
            (tip(&mesh, &x), pressure_scatter(&*stressed(&mesh, rubber(), formulation), &x).expect("a sheared body"));
        assert!((u / 6.93 - 1.0).abs() < accept, "{order:?} {formulation:?} mirrored {mirrored}: {u}");
        assert!(found.scatter < 0.5 && !found.alarm, "{order:?} {formulation:?} mirrored {mirrored}: {found:?}");
    }
    let (mesh, x) = bent(n, Order::Linear, Formulation::Displacement, mirrored);
    let found = pressure_scatter(&*stressed(&mesh, rubber(), Formulation::Displacement), &x).expect("a sheared body");
    let locked = tip(&mesh, &x);
    assert!(locked < 0.75 * 6.93, "tet4 displacement gives {locked}: no lock?");
    assert!(found.alarm && found.scatter > 5.0, "the alarm is silent: {found:?}");
}

/// Uniaxial tension: one pressure everywhere, so no scatter (rounding over the strain of 1e-6); of Hooke's energy σ²/2E the
/// part p²/2κ with p = σ/3 is volumetric, (1 − 2ν)/3, up to terms of the order of the strain.
#[test]
fn uniaxial_tension_has_no_scatter() {
    let (nu, strain) = (0.45, 1e-6);
    for order in ORDERS {
        let mesh = distorted_cube(2, order, 0.1, 3);
        let stressed = stressed(&mesh, law("neo_hookean", 3.0, nu), Formulation::Displacement);
        let stretch = Vec3::new(1.0, -nu, -nu) * strain;
        let x: Vec<f64> = mesh.points.iter().flat_map(|p| [0, 1, 2].map(|i| stretch[i] * p[i])).collect();
        let found = pressure_scatter(&*stressed, &x).expect("a sheared body");
        assert!(found.scatter < 1e-8 && !found.alarm, "{order:?}: {found:?}");
        assert!((found.share / ((1.0 - 2.0 * nu) / 3.0) - 1.0).abs() < 1e-4, "{order:?}: {found:?}");
        assert!(pressure_scatter(&*stressed, &vec![0.0; x.len()]).is_none(), "nothing is sheared at rest");
        let moved: Vec<f64> = mesh.points.iter().flat_map(|_| [0.3, -2.0, 0.7]).collect();
        assert!(pressure_scatter(&*stressed, &moved).is_none(), "{order:?}: rounding of a body that is only moved");
        let pressed: Vec<f64> = mesh.points.iter().flat_map(|p| [0, 1, 2].map(|i| -0.01 * p[i])).collect();
        assert!(pressure_scatter(&*stressed, &pressed).is_none(), "{order:?}: hydrostatic compression");
    }
}

/// A compressible cantilever of tet4, two cells high, is silent: its bending is not resolved and its pressures scatter by 0.56,
/// but no volume locks. The same bar of nearly incompressible rubber rings.
#[test]
fn compressible_bending_is_silent() {
    let mesh = block(16, 2, 2, 8.0, 1.0, 1.0, Order::Linear);
    for (nu, alarm) in [(0.3, false), (0.49, true)] {
        let rubber = || law("neo_hookean", 1.0, nu);
        let load = DeadLoad::traction(&mesh, "xmax", ramp(1.0), Vec3::new(0.0, 1e-4, 0.0));
        let held = hold(&nodes(&mesh, "xmin"), &[0, 1, 2]);
        let system = solid(&mesh, rubber(), Formulation::Displacement, vec![Box::new(load)], held);
        let (state, _) = statics(&mesh, &system, 1e-8, 1);
        let stressed = stressed(&mesh, rubber(), Formulation::Displacement);
        let found = pressure_scatter(&*stressed, &state.x).expect("a sheared body");
        assert_eq!(found.alarm, alarm, "ν = {nu}: {found:?}");
    }
}

/// Every formulation with every split law on both elements: energy ↔ r and r ↔ K by central differences at a random state
/// of displacements and pressures.
///
/// Central differences of step d have the error d²|r‴|/6 + ε|r|/d. With strains of 0.05, cells of size 1 and stresses of
/// order μ = 1 all derivatives are of order one, κ = 100 times that in the volumetric part: d = 1e-5 leaves about
/// 1e-10·κ and 1e-11·κ, and 1e-7 of the largest entry is a bound with room.
#[test]
fn second_fields_have_exact_derivatives() {
    let mut random = Random::seed(7);
    for order in ORDERS {
        for formulation in [Formulation::Mixed, Formulation::MeanDilatation] {
            if order == Order::Linear && formulation == Formulation::MeanDilatation {
                continue;
            }
            for name in ["neo_hookean", "neo_hookean_split"] {
                let mesh = distorted_cube(1, order, 0.1, 3);
                let (effect, hosts) = formulated(&mesh, law(name, 3.0, 0.495), formulation);
                let system =
                    System::with_scalars(mesh.points.len(), &hosts, vec![effect], vec![], vec![]).expect("a system");
                let rest = system.rest();
                let x = random.vector(rest.x.len(), 0.05);
                let at = |x: &[f64]| {
                    let mut sums = system.workspace();
                    let (v, rates) = (&rest.v, Rates::default());
                    let at = At { t: 0.0, dt: f64::INFINITY, x, v, a: v, old: x, history: &[], inputs: &[], rates };
                    system.assemble(&at, &[], Want::Tangent, None, &mut sums).expect("not inverted");
                    sums
                };
                let here = at(&x);
                let size = largest(&here.k);
                let d = 1e-5;
                for _ in 0..5 {
                    let direction = random.vector(x.len(), 1.0);
                    let moved = |s: f64| at(&x.iter().zip(&direction).map(|(x, d)| x + s * d).collect::<Vec<_>>());
                    let (plus, minus) = (moved(d), moved(-d));
                    let slope = (plus.energy[0] - minus.energy[0]) / (2.0 * d);
                    let exact: f64 = here.r.iter().zip(&direction).map(|(r, d)| r * d).sum();
                    assert!((slope - exact).abs() < 1e-7 * size, "{name} {order:?} {formulation:?}: {slope} {exact}");
                    let mut product = vec![0.0; x.len()];
                    system.pattern.multiply(&here.k, &system.restrict(&direction), &mut product);
                    let difference: Vec<f64> = plus.r.iter().zip(&minus.r).map(|(a, b)| (a - b) / (2.0 * d)).collect();
                    for (exact, difference) in product.iter().zip(system.restrict(&difference)) {
                        let error = (exact - difference).abs();
                        assert!(error < 1e-6 * size, "{name} {order:?} {formulation:?}: {exact} {difference}");
                    }
                }
            }
        }
    }
}

/// Patch test: an affine displacement of the surface is followed inside, at ν = 0.4999, with one pressure everywhere.
/// Newton stops at 1e-12 of the forces; the compliance of the constrained block is of order one.
#[test]
fn affine_fields_are_exact() {
    for order in ORDERS {
        let mesh = distorted_cube(2, order, 0.1, 5);
        let (effect, hosts) = formulated(&mesh, law("neo_hookean_split", 3.0, 0.4999), Formulation::Mixed);
        let affine = |p: Vec3| Vec3::new(0.02 * p.x + 0.03 * p.y, -0.01 * p.y + 0.02 * p.z, 0.015 * p.x - 0.01 * p.z);
        let prescribed = move_to(&mesh, &surface(&mesh), affine);
        let system =
            System::with_scalars(mesh.points.len(), &hosts, vec![effect], vec![], prescribed).expect("a system");
        let (state, _) = statics(&mesh, &system, 1e-12, 1);
        for (k, point) in mesh.points.iter().enumerate() {
            let error = Vec3::from_column_slice(&state.x[3 * k..3 * k + 3]) - affine(*point);
            assert!(error.norm() < 1e-10, "{order:?}: node {k} is off by {}", error.norm());
        }
        let pressures = &state.x[3 * mesh.points.len()..];
        let spread = pressures.iter().map(|p| (p - pressures[0]).abs()).fold(0.0, larger);
        assert!(spread < 1e-8 * pressures[0].abs(), "{order:?}: pressures scatter by {spread}");
    }
}
