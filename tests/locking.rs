//! Formulations in the soft limit: what locks, and what does not.

mod common;

use common::*;
use durometer::effect::locking::{Signs, signs};
use durometer::effect::{Elastic, MeanDilatation, MixedElastic, Stressed, pressure_hosts};
use durometer::material::Law;
use durometer::math::tensor::Vec3;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::system::{At, Effect, Prescribed, Rates, System, Want};
use std::sync::Arc;

/// The ways a law can meet the element.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Formulation {
    Displacement,
    Mixed,
    MeanDilatation,
}

/// The elastic effect of a formulation on the whole body, the same to be looked at, and the hosts of its second field.
struct Built {
    effect: Box<dyn Effect>,
    stressed: Arc<dyn Stressed>,
    hosts: Vec<u32>,
}

impl Built {
    fn new<E: Effect + Stressed + 'static>(effect: E, hosts: Vec<u32>) -> Self {
        let effect = Arc::new(effect);
        Self { stressed: effect.clone(), effect: Box::new(effect), hosts }
    }
}

fn elastic(mesh: &TetMesh, law: Box<dyn Law>, formulation: Formulation) -> Built {
    let cells = body(mesh);
    let name = "elastic".to_string();
    match formulation {
        Formulation::Displacement => Built::new(Elastic::new(name, mesh, &cells, law), vec![]),
        Formulation::MeanDilatation => {
            Built::new(MeanDilatation::new(name, mesh, &cells, &*law).expect("tet10 and a split law"), vec![])
        }
        Formulation::Mixed => {
            let first = 3 * mesh.points.len() as u32;
            let effect = MixedElastic::new(name, mesh, &cells, &*law, first).expect("a split law");
            Built::new(effect, pressure_hosts(mesh, &cells))
        }
    }
}

/// Cook's membrane (Cook 1974) as one layer of n × n boxes in plane strain; `mirrored` turns the diagonals round.
fn cook(n: usize, order: Order, mirrored: bool) -> TetMesh {
    let mut mesh = block(n, n, 1, 1.0, 1.0, 1.0 / n as f64, order);
    if mirrored {
        // A reflection y → 1 − y of the unit square, with the cells turned back to positive volume.
        mesh.points.iter_mut().for_each(|p| p.y = 1.0 - p.y);
        mesh = flipped(mesh);
    }
    for p in &mut mesh.points {
        let (s, t) = (p.x, p.y);
        *p = Vec3::new(48.0 * s, 44.0 * s + t * (44.0 - 28.0 * s), p.z * n as f64);
    }
    straighten(&mut mesh);
    mesh
}

/// Swaps two corners of every cell and facet, with the mid-nodes that go with them.
fn flipped(mut mesh: TetMesh) -> TetMesh {
    let (n, m) = (mesh.order.cell_nodes(), mesh.order.facet_nodes());
    for cell in mesh.cells.chunks_mut(n) {
        cell.swap(0, 1);
        if n == 10 {
            // Mid-edges (0,1) (1,2) (0,2) (0,3) (1,3) (2,3)
            cell.swap(5, 6);
            cell.swap(7, 8);
        }
    }
    for facet in mesh.facets.chunks_mut(m) {
        facet.swap(0, 1);
        if m == 6 {
            facet.swap(4, 5);
        }
    }
    let (ymin, ymax) = (mesh.regions["ymin"].clone(), mesh.regions["ymax"].clone());
    mesh.regions.insert("ymin".into(), ymax);
    mesh.regions.insert("ymax".into(), ymin);
    mesh
}

/// u_y at (48, 60) and the signs of locking under F = 100, μ = 80.194, κ = 400889.806, ψ = ½μ(J^{−2/3}I₁ − 3) + ½κ(J − 1)².
fn tip(n: usize, order: Order, formulation: Formulation, mirrored: bool) -> (f64, Signs) {
    let mesh = cook(n, order, mirrored);
    let (mu, kappa) = (80.194, 400_889.806);
    let e = 9.0 * kappa * mu / (3.0 * kappa + mu);
    let nu = (3.0 * kappa - 2.0 * mu) / (2.0 * (3.0 * kappa + mu));
    let Built { effect, stressed, hosts } = elastic(&mesh, law("neo_hookean_split", e, nu), formulation);
    let load = DeadLoad::traction(&mesh, "xmax", ramp(1.0), Vec3::new(0.0, 100.0, 0.0));
    let all: Vec<u32> = (0..mesh.points.len() as u32).collect();
    let mut prescribed: Vec<Prescribed> = hold(&all, &[2]);
    prescribed.extend(hold(&nodes(&mesh, "xmin"), &[0, 1]));
    let effects: Vec<Box<dyn Effect>> = vec![effect, Box::new(load)];
    let system = System::with_scalars(mesh.points.len(), &hosts, effects, vec![], prescribed).expect("a system");
    let (state, _) = statics(&mesh, &system, 1e-8, 2);
    let corner = (0..mesh.points.len())
        .find(|&k| (mesh.points[k] - Vec3::new(48.0, 60.0, 0.0)).norm() < 1e-9)
        .expect("the corner is a node");
    (state.x[3 * corner + 1], signs(&*stressed, &state.x).expect("a sheared body"))
}

/// Reference 6.93 ± .02; at n = 32 locking-free tet4 within 3 %, tet10 within .5 %, on both diagonal patterns; the
/// displacement formulation on tet4 stays more than 25 % low, and only there the alarm rings. Measured scatters: 15 and 18
/// locked, at most 0.3 else; the threshold is 0.5.
#[test]
fn cooks_membrane() {
    for mirrored in [false, true] {
        for (order, formulation, accept) in [
            (Order::Linear, Formulation::Mixed, 0.03),
            (Order::Quadratic, Formulation::Mixed, 0.005),
            (Order::Quadratic, Formulation::MeanDilatation, 0.01),
        ] {
            let (u, signs) = tip(32, order, formulation, mirrored);
            assert!((u / 6.93 - 1.0).abs() < accept, "{order:?} {formulation:?} mirrored {mirrored}: {u}");
            assert!(signs.scatter < 0.5 && !signs.alarm, "{order:?} {formulation:?} mirrored {mirrored}: {signs:?}");
        }
        let (locked, signs) = tip(32, Order::Linear, Formulation::Displacement, mirrored);
        assert!(locked < 0.75 * 6.93, "tet4 displacement gives {locked}: no lock?");
        assert!(signs.alarm && signs.scatter > 5.0, "the alarm is silent: {signs:?}");
    }
}

/// Uniaxial tension: one pressure everywhere, so no scatter (rounding over the strain of 1e-6); of Hooke's energy σ²/2E the
/// part p²/2κ with p = σ/3 is volumetric, (1 − 2ν)/3, up to terms of the order of the strain.
#[test]
fn uniaxial_tension_has_no_scatter() {
    let (nu, strain) = (0.45, 1e-6);
    for order in ORDERS {
        let mesh = distorted_cube(2, order, 0.1, 3);
        let Built { stressed, .. } = elastic(&mesh, law("neo_hookean", 3.0, nu), Formulation::Displacement);
        let stretch = Vec3::new(1.0, -nu, -nu) * strain;
        let x: Vec<f64> = mesh.points.iter().flat_map(|p| [0, 1, 2].map(|i| stretch[i] * p[i])).collect();
        let found = signs(&*stressed, &x).expect("a sheared body");
        assert!(found.scatter < 1e-8 && !found.alarm, "{order:?}: {found:?}");
        assert!((found.share / ((1.0 - 2.0 * nu) / 3.0) - 1.0).abs() < 1e-4, "{order:?}: {found:?}");
        assert!(signs(&*stressed, &vec![0.0; x.len()]).is_none(), "nothing is sheared at rest");
    }
}

/// A compressible cantilever of tet4, two cells high, is silent: its bending is not resolved and its pressures scatter by 0.56,
/// but no volume locks. The same bar of nearly incompressible rubber rings.
#[test]
fn compressible_bending_is_silent() {
    let mesh = block(16, 2, 2, 8.0, 1.0, 1.0, Order::Linear);
    for (nu, alarm) in [(0.3, false), (0.49, true)] {
        let Built { effect, stressed, hosts } = elastic(&mesh, law("neo_hookean", 1.0, nu), Formulation::Displacement);
        let load = DeadLoad::traction(&mesh, "xmax", ramp(1.0), Vec3::new(0.0, 1e-4, 0.0));
        let held = hold(&nodes(&mesh, "xmin"), &[0, 1, 2]);
        let effects: Vec<Box<dyn Effect>> = vec![effect, Box::new(load)];
        let system = System::with_scalars(mesh.points.len(), &hosts, effects, vec![], held).expect("a system");
        let (state, _) = statics(&mesh, &system, 1e-8, 1);
        let found = signs(&*stressed, &state.x).expect("a sheared body");
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
    let mut random = Random(7);
    for order in ORDERS {
        for formulation in [Formulation::Mixed, Formulation::MeanDilatation] {
            if order == Order::Linear && formulation == Formulation::MeanDilatation {
                continue;
            }
            for name in ["neo_hookean", "neo_hookean_split"] {
                let mesh = distorted_cube(1, order, 0.1, 3);
                let Built { effect, hosts, .. } = elastic(&mesh, law(name, 3.0, 0.495), formulation);
                let system =
                    System::with_scalars(mesh.points.len(), &hosts, vec![effect], vec![], vec![]).expect("a system");
                let rest = system.rest();
                let x = random.vector(rest.x.len(), 0.05);
                let at = |x: &[f64]| {
                    let mut sums = system.workspace();
                    let (v, rates) = (&rest.v, Rates::default());
                    let at = At { t: 0.0, dt: f64::INFINITY, x, v, a: v, old: x, rates };
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
        let built = elastic(&mesh, law("neo_hookean_split", 3.0, 0.4999), Formulation::Mixed);
        let Built { effect, hosts, .. } = built;
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
        let spread = pressures.iter().map(|p| (p - pressures[0]).abs()).fold(0.0, f64::max);
        assert!(spread < 1e-8 * pressures[0].abs(), "{order:?}: pressures scatter by {spread}");
    }
}
