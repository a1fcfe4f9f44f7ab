//! Dampers at the start of a stage, where no time has passed and the forces are those of the velocities: against short steps, and their
//! derivatives against differences.

use crate::common::{Random, body, distorted_cube, largest, law};
use durometer::effect::{EdgeDampers, Elastic, Stiffness, StiffnessDamping, ViscousDamping};
use durometer::math::statistics::larger;
use durometer::mesh::{Order, TetMesh};
use durometer::system::{At, BlockValues, Effect, Perturbation, Rates, Want};
use std::sync::Arc;

/// Every damper but that by the mass, which reads v alone in every step.
fn dampers(mesh: &TetMesh) -> Vec<(&'static str, Box<dyn Effect>)> {
    let cells = body(mesh);
    let stiff = |stiffness| {
        let damped: Arc<dyn Effect> =
            Arc::new(Elastic::new("elastic".into(), mesh, &cells, law("neo_hookean", 1e5, 0.4)));
        StiffnessDamping::new(vec![damped], 0.02, stiffness, &mesh.points).expect("no second field")
    };
    vec![
        ("viscous", Box::new(ViscousDamping::new(mesh, &cells, 300.0))),
        ("edges", Box::new(EdgeDampers::new(mesh, &cells, 2.0))),
        ("initial stiffness", Box::new(stiff(Stiffness::Initial))),
        ("last stiffness", Box::new(stiff(Stiffness::Last))),
    ]
}

/// What is seen at the start of a stage.
fn start<'a>(x: &'a [f64], v: &'a [f64]) -> At<'a> {
    At { t: 0.0, dt: 0.0, x, v, a: v, old: x, history: &[], inputs: &[], rates: Rates::default() }
}

/// \[unknowns\] Σ of the blocks.
fn sum(effect: &dyn Effect, n: usize, of_block: impl Fn(usize, &mut BlockValues)) -> Vec<f64> {
    let mut r = vec![0.0; n];
    for b in 0..effect.blocks().len() {
        let mut out = BlockValues::new(effect.blocks().size(b));
        of_block(b, &mut out);
        effect.blocks().dofs(b).zip(&out.r).for_each(|(dof, force)| r[dof as usize] += force);
    }
    r
}

fn forces(effect: &dyn Effect, at: &At) -> Vec<f64> {
    sum(effect, at.x.len(), |b, out| effect.eval(at, b, Want::Residual, out).expect("defined"))
}

fn along(x: &[f64], d: &[f64], s: f64) -> Vec<f64> {
    x.iter().zip(d).map(|(x, d)| x + s * d).collect()
}

/// The forces at the start are those of a step that is short: with v of order 1 on cells of ½ a step of 1e-6 is wrong by 4e-6, and the
/// difference of the strains by ε/1e-6 = 2e-10.
#[test]
fn dampers_begin_with_the_velocities() {
    let mesh = distorted_cube(2, Order::Quadratic, 0.1, 5);
    let (mut random, n) = (Random::seed(6), 3 * mesh.points.len());
    let [x, v] = [0.03, 1.0].map(|size| random.vector(n, size));
    let dt = 1e-6;
    let later = along(&x, &v, dt);
    let rates = Rates { cv: 1.0 / dt, ca: 1.0 / (dt * dt) };
    let step = At { t: dt, dt, x: &later, v: &v, a: &v, old: &x, history: &[], inputs: &[], rates };
    for (name, effect) in dampers(&mesh) {
        let (begun, short) = (forces(&*effect, &start(&x, &v)), forces(&*effect, &step));
        let size = largest(&short);
        let off = begun.iter().zip(&short).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
        assert!(size > 0.0 && off <= 1e-4 * size, "{name}: off by {off:e} of {size:e} N");
        let still = forces(&*effect, &start(&x, &vec![0.0; n]));
        assert_eq!(largest(&still), 0.0, "{name}: nothing moves");
        let statics = At { dt: f64::INFINITY, ..start(&x, &v) };
        assert_eq!(largest(&forces(&*effect, &statics)), 0.0, "{name}: statics have no rates");
    }
}

/// Their derivative along a change of the state and of its velocities, by central differences: steps of 1e-5 with displacements of order 0.03
/// on cells of ½ leave 4e-8 of truncation and 2e-11 of rounding.
#[test]
fn forces_at_the_start_have_their_derivatives() {
    for order in [Order::Linear, Order::Quadratic] {
        let mesh = distorted_cube(2, order, 0.1, 7);
        let (mut random, n) = (Random::seed(9), 3 * mesh.points.len());
        let [x, v, dx, dv] = [0.03, 1.0, 1.0, 3.0].map(|size| random.vector(n, size));
        let still = vec![0.0; n];
        for (name, effect) in dampers(&mesh) {
            let moved = |s: f64| forces(&*effect, &start(&along(&x, &dx, s), &along(&v, &dv, s)));
            let (plus, minus) = (moved(1e-5), moved(-1e-5));
            let slope: Vec<f64> = plus.iter().zip(&minus).map(|(p, m)| (p - m) / 2e-5).collect();
            let (at, past) = (start(&x, &v), effect.capabilities().past.expect("it has one"));
            let direction = Perturbation { x: &dx, v: &dv, a: &still, old: &dx, history: &[] };
            let found = sum(&*effect, n, |b, out| past.along(&at, &direction, b, out).expect("defined"));
            let off = found.iter().zip(&slope).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
            assert!(off <= 1e-6 * largest(&slope), "{name}, {order:?}: off by {off:e} of {:e}", largest(&slope));
        }
    }
}
