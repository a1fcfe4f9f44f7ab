//! The error of a derivative by differences on a deformed state, from which the step of the differences is chosen.

use super::build::Scene;
use crate::math::random::SplitMix;
use crate::math::tensor::{Mat3, Vec3};
use crate::solve::Step;
use crate::system::{EquationChange, State, SystemDifference};

/// Displacement gradient of the state.
const STRAIN: f64 = 0.05;

/// Largest error of the derivative of the equations at the end of each stage, relative to the derivative; infinite where no state can be evaluated.
pub(super) fn error(scene: &Scene, difference: &mut Box<SystemDifference>) -> f64 {
    let mut state = deformed(scene);
    let past = State { x: state.x.iter().map(|x| 0.5 * x).collect(), ..scene.system.rest() };
    let mut worst = 0.0_f64;
    for span in &scene.spans {
        state.t = span.end;
        let step = Step { system: &scene.system, integrator: span.integrator, past: &past, dt: span.dt };
        let (mut v, mut a) = (past.v.clone(), past.a.clone());
        let mut begun = past.clone();
        span.integrator.begin(&mut begun);
        span.integrator.kinematics(&begun, span.dt, &state.x, &mut v, &mut a);
        (state.v, state.a) = (v, a);
        match difference.change(&step.at(&state), &state.lambda) {
            Ok(changes) => worst = worst.max(relative(&changes)),
            Err(_) => return f64::INFINITY,
        }
    }
    worst
}

/// Largest difference of two changes, relative.
fn relative([central, other]: &[EquationChange; 2]) -> f64 {
    let of = |a: &[f64], b: &[f64]| {
        let size = a.iter().chain(b).fold(0.0_f64, |m, v| m.max(v.abs()));
        let error = a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        if size > 0.0 { error / size } else { 0.0 }
    };
    let pairs = [
        (&central.residual, &other.residual),
        (&central.gaps, &other.gaps),
        (&central.limits, &other.limits),
        (&central.motion, &other.motion),
    ];
    pairs.into_iter().map(|(a, b)| of(a, b)).fold(0.0, f64::max)
}

/// A body that is stretched, sheared and bent, with unit multipliers.
fn deformed(scene: &Scene) -> State {
    let mut random = SplitMix(7);
    let mut draw = || 2.0 * random.unit() - 1.0;
    let gradient = Mat3::from_fn(|_, _| STRAIN * draw());
    let (turn, wave) = (Vec3::from_fn(|_, _| draw()), Vec3::from_fn(|_, _| draw()));
    let across = scene.body.mesh.diagonal();
    let mut state = scene.system.rest();
    for (k, p) in scene.points.iter().enumerate() {
        let bent = STRAIN * across / 4.0 * (2.0 * wave.dot(p) / across).sin();
        let u = gradient * p + bent * turn;
        state.x[3 * k..3 * k + 3].copy_from_slice(u.as_slice());
    }
    let pressures = 3 * scene.points.len();
    let size = STRAIN * scene.body.mesh.h();
    state.x[pressures..].iter_mut().for_each(|x| *x = size * draw());
    scene.system.ties.complete(&mut state.x);
    state.lambda.fill(1.0);
    state
}
