//! Distances, forces and friction of single points: against differences, in balance, by Coulomb.

use crate::common::{Random, largest};
use crate::concave::groove;
use durometer::effect::contact::barrier::Barrier;
use durometer::effect::contact::friction::{ContactFriction, Coulomb};
use durometer::effect::contact::multiplier::Multiplier;
use durometer::effect::contact::penalty::Penalty;
use durometer::effect::contact::placement::{AffineFrame, Obstacle};
use durometer::effect::contact::pressed::Pressed;
use durometer::effect::contact::shape::Shape;
use durometer::effect::contact::{Contact, NormalForces, SurfacePoint};
use durometer::material::Want;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::surface_file::Surface;
use durometer::system::{At, BlockValues, Effect, Rates};
use std::sync::Arc;

/// A tetrahedron with its faces outward.
fn wedge() -> Surface {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.2, 0.9]].map(Vec3::from);
    Surface { points: points.into(), triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] }
}

fn shapes() -> [Shape; 5] {
    let surface = Shape::surface(&wedge()).expect("closed and outward");
    [Shape::floor(), Shape::sphere(0.7), Shape::cuboid(Vec3::new(0.5, 0.4, 0.6)), Shape::cylinder(0.5, 0.4), surface]
}

/// d by its normal and its curvature, at random points outside: central differences, whose error is h²/6 of the third
/// derivative, at most 3/d³, and rounding 1e-16/h.
#[test]
fn distances_have_the_derivatives_of_their_witnesses() {
    let mut random = Random::seed(1);
    for (k, shape) in shapes().iter().enumerate() {
        let (mut slopes, mut bends) = (0, 0);
        while slopes < 300 {
            let y = Vec3::from_fn(|_, _| random.around(1.5));
            let w = shape.nearest(&y);
            assert!((w.gap - shape.gap(&y)).abs() < 1e-14, "shape {k}");
            if w.gap < 0.05 {
                continue;
            }
            let h = 1e-6;
            for i in 0..3 {
                let (low, high) = (y - Vec3::ith(i, h), y + Vec3::ith(i, h));
                let slope = (shape.gap(&high) - shape.gap(&low)) / (2.0 * h);
                assert!((slope - w.normal[i]).abs() < 1e-8, "shape {k} at {y:?}");
                slopes += 1;
                let (a, b) = (shape.nearest(&low), shape.nearest(&high));
                // Between two features the curvature jumps, which a central difference does not see.
                if (a.curvature - b.curvature).norm() > 1e-3 {
                    continue;
                }
                let bend = (b.normal - a.normal) / (2.0 * h);
                assert!((bend - w.curvature.column(i)).norm() < 1e-6, "shape {k} at {y:?}");
                bends += 1;
            }
        }
        assert!(
            10 * bends >= 9 * slopes,
            "shape {k}: the curvature was compared {bends} times, the normal {slopes} times"
        );
    }
}

/// The rounded distance inside of a surface: its derivatives by central differences (h²/6 of the third derivative, which is of the order of
/// 1/width² at most, and 0 but at the borders of the kinks), no more than half the width above d, and exactly d away from kinks.
#[test]
fn rounded_distances_have_the_derivatives_of_their_witnesses() {
    let (width, h, mut random) = (0.02, 1e-6, Random::seed(7));
    let shape = Shape::surface(&wedge()).expect("closed and outward");
    let (mut flat, mut rounded, mut bends) = (0, 0, 0);
    while flat < 50 || rounded < 200 {
        let y = Vec3::new(0.3, 0.3, 0.2) + Vec3::from_fn(|_, _| random.around(0.3));
        let (exact, w) = (shape.gap(&y), shape.rounded(&y, width));
        if exact > -1e-3 {
            continue;
        }
        assert!(w.gap >= exact - 1e-14 && w.gap <= exact + 0.5 * width, "{} for {exact}", w.gap);
        if w.curvature == Mat3::zeros() {
            assert!((w.gap - exact).abs() < 1e-14 && (w.normal.norm() - 1.0).abs() < 1e-14);
            flat += 1;
            continue;
        }
        rounded += 1;
        for i in 0..3 {
            let [a, b] = [-h, h].map(|h| shape.rounded(&(y + Vec3::ith(i, h)), width));
            assert!(((b.gap - a.gap) / (2.0 * h) - w.normal[i]).abs() < 1e-4, "at {y:?}");
            // The curvature jumps where a plane comes in.
            if (a.curvature - b.curvature).norm() < 1e-9 {
                let bend = (b.normal - a.normal) / (2.0 * h);
                assert!((bend - w.curvature.column(i)).norm() < 1e-6 * (1.0 + w.curvature.norm()), "at {y:?}");
                bends += 1;
            }
        }
    }
    assert!(10 * bends >= 9 * 3 * rounded, "the curvature was compared {bends} times at {rounded} points");
}

/// A point of three nodes against an obstacle in an affine frame, or a fixed one.
fn pair(shape: Shape, moving: bool, scalars: bool) -> Arc<Contact> {
    let (nodes, weights) = (vec![0, 1, 2], vec![0.2, 0.3, 0.5]);
    let point = SurfacePoint {
        at: Vec3::new(0.1, -0.2, 1.4),
        nodes,
        weights,
        area: 0.7,
        sides: vec![],
        radius: 0.1,
        carrier: None,
    };
    let frame = AffineFrame { nodes: [3, 4, 5, 6], center: Vec3::new(0.1, 0.2, -0.1), length: 0.8 };
    let axes = nalgebra::Rotation3::from_euler_angles(0.3, -0.2, 0.5).into_inner();
    let body = moving.then_some(frame);
    let obstacle = Obstacle { shape, origin: Vec3::new(0.05, 0.1, 0.0), axes, body };
    Arc::new(Contact::with_scalars("c".into(), vec![point], obstacle, scalars.then_some(21)))
}

fn eval(effect: &dyn Effect, x: &[f64], want: Want) -> BlockValues {
    let rest = vec![0.0; x.len()];
    let history = vec![0.0; effect.capabilities().history_size()];
    let rates = Rates::default();
    let at = At { t: 0.0, dt: 1.0, x, v: &rest, a: &rest, old: &rest, history: &history, inputs: &[], rates };
    let mut out = BlockValues::new(effect.blocks().size(0));
    effect.eval(&at, 0, want, &mut out).expect("outside");
    out
}

/// r is the derivative of the energy and K that of r: central differences, with h²/6 of the third derivative as their error.
fn check(effect: &dyn Effect, x: &[f64], label: &str) -> bool {
    let n = effect.blocks().size(0);
    let dofs: Vec<usize> = effect.blocks().dofs(0).map(|d| d as usize).collect();
    let here = eval(effect, x, Want::Tangent);
    let h = 1e-6;
    for (j, &dof) in dofs.iter().enumerate() {
        let at = |s: f64| {
            let mut moved = x.to_vec();
            moved[dof] += s;
            eval(effect, &moved, Want::Residual)
        };
        let (low, high) = (at(-h), at(h));
        let slope = (high.energy - low.energy) / (2.0 * h);
        let scale = 1.0 + largest(&here.r);
        assert!((slope - here.r[j]).abs() < 1e-7 * scale, "{label}, r[{j}]: {slope} and {}", here.r[j]);
        for i in j..n {
            let slope = (high.r[i] - low.r[i]) / (2.0 * h);
            let (k, scale) = (here.k[i * n + j], 1.0 + largest(&here.k));
            assert!((slope - k).abs() < 1e-6 * scale, "{label}, K[{i}, {j}]: {slope} and {k}");
        }
    }
    largest(&here.r) > 0.0
}

#[test]
fn forces_are_derivatives_of_energies_and_balance() {
    let mut random = Random::seed(7);
    let mut felt = 0;
    for k in 0..5 {
        for moving in [false, true] {
            for case in 0..12 {
                let shape = |k: usize| shapes().into_iter().nth(k).expect("five");
                let x = random.vector(22, 0.12);
                let label = format!("shape {k}, moving {moving}, case {case}");
                let barrier = Pressed {
                    contact: pair(shape(k), moving, false),
                    response: Barrier { distance: 1.5, stiffness: 3.0 },
                    friction: None,
                };
                if barrier.contact.gap(&x, 0) > 0.05 {
                    felt += usize::from(check(&barrier, &x, &format!("barrier, {label}")));
                    let r = eval(&barrier, &x, Want::Residual).r;
                    if moving {
                        balance(&barrier, &x, &r, &label);
                    }
                    let multiplier =
                        Multiplier { contact: pair(shape(k), moving, true), stiffness: 2.0, friction: None };
                    let mut pressed = x.clone();
                    pressed[21] = multiplier.contact.gap(&x, 0) + 0.3 * (case as f64 - 4.5);
                    check(&multiplier, &pressed, &format!("multiplier, {label}"));
                }
            }
        }
    }
    // A random point is near enough in half of the cases at least.
    assert!(felt > 40, "{felt}");
}

/// The same for a point that has two contacts, each with a multiplier of its own, in front of both sides of a groove.
#[test]
fn forces_of_two_contacts_are_derivatives_of_energies() {
    let mut random = Random::seed(9);
    let mut wide = groove(1.0);
    wide.points.iter_mut().for_each(|point| *point *= 100.0);
    for case in 0..24 {
        let contact = pair(Shape::surface(&wide).expect("closed and outward"), case % 2 == 0, true);
        let mut x = random.vector(21 + contact.obstacle.shape.sheets(), 0.12);
        let multiplier = Multiplier { contact, stiffness: 2.0, friction: None };
        // Both distances are about 1, others larger.
        [x[21], x[22]] = [2.0 + random.around(0.1), if case % 3 == 0 { 0.0 } else { 2.0 }];
        let pressed = multiplier.normal_forces(&x, 0).len();
        assert_eq!(pressed, if case % 3 == 0 { 1 } else { 2 });
        check(&multiplier, &x, &format!("case {case}"));
    }
}

/// Forces and moments about the origin cancel to rounding, whatever the frame has become.
fn balance(effect: &Pressed<Barrier>, x: &[f64], r: &[f64], label: &str) {
    let contact = &effect.contact;
    let body = contact.obstacle.body.as_ref().expect("it moves");
    let places = body.positions(x);
    let point = contact.position(x, 0);
    let force = |k: usize| Vec3::from_column_slice(&r[3 * k..3 * k + 3]);
    let total: Vec3 = (0..7).map(force).sum();
    let on_point: Vec3 = (0..3).map(force).sum();
    let moment = point.cross(&on_point) + (0..4).map(|a| places[a].cross(&force(3 + a))).sum::<Vec3>();
    let size = 1.0 + on_point.norm();
    assert!(total.norm() < 1e-13 * size && moment.norm() < 1e-12 * size, "{label}: {total:?} {moment:?}");
}

/// |F_t| = μ N where the point slides, less where it sticks, opposite to the sliding; what it dissipates is F_t·u.
#[test]
fn friction_obeys_coulomb() {
    let contact = pair(Shape::floor(), false, false);
    let response = Penalty { stiffness: 5.0, rounding: 0.0 };
    let pressing = Arc::new(Pressed { contact: contact.clone(), response, friction: None });
    let friction = |stick_velocity| ContactFriction {
        name: "f".into(),
        pressing: pressing.clone(),
        law: Coulomb { coefficient: 0.4, stick_velocity, slip: 1.0, most: f64::INFINITY },
    };
    let mut random = Random::seed(3);
    let (mut slid, mut stuck) = (0, 0);
    for _ in 0..100 {
        let mut x = random.vector(9, 0.3);
        let down = contact.obstacle.axes * Vec3::new(0.0, 0.0, -1.4);
        (0..9).for_each(|i| x[i] += down[i % 3]);
        let normal = eval(&*pressing, &x, Want::Residual);
        let push = (0..3).map(|k| Vec3::from_column_slice(&normal.r[3 * k..3 * k + 3])).sum::<Vec3>();
        if push.norm() == 0.0 {
            continue;
        }
        let n = -push.normalize();
        let u: Vec3 = (0..3).map(|k| Vec3::from_column_slice(&x[3 * k..3 * k + 3]) * [0.2, 0.3, 0.5][k]).sum();
        let u = u - n * n.dot(&u);
        for stick_velocity in [1e-3, 10.0] {
            let local = eval(&friction(stick_velocity), &x, Want::Tangent);
            let force: Vec3 = (0..3).map(|k| -Vec3::from_column_slice(&local.r[3 * k..3 * k + 3])).sum();
            let limit = 0.4 * push.norm();
            assert!(
                (force.norm()
                    - limit
                        * if u.norm() > stick_velocity {
                            1.0
                        } else {
                            2.0 * u.norm() / stick_velocity - (u.norm() / stick_velocity).powi(2)
                        })
                .abs()
                    < 1e-12
            );
            assert!((force.dot(&u) + force.norm() * u.norm()).abs() < 1e-12, "not opposite");
            assert!((local.energy - force.norm() * u.norm()).abs() < 1e-12);
            if u.norm() > stick_velocity {
                slid += 1
            } else {
                stuck += 1
            }
            // K is symmetric and positive semidefinite.
            let k = nalgebra::DMatrix::from_fn(9, 9, |i, j| local.k[i.max(j) * 9 + i.min(j)]);
            let least = k.symmetric_eigenvalues().min();
            assert!(least > -1e-12, "{least}");
        }
    }
    assert!(slid > 20 && stuck > 20, "{slid} {stuck}");
}

/// Friction of a ball acts on the spot in contact: its moment about the centre is that of its force there. It is opposite to the sliding of the spot as it is
/// turned in the mean over the step.
#[test]
fn friction_of_a_ball_has_a_moment() {
    let frame = AffineFrame { nodes: [0, 1, 2, 3], center: Vec3::new(0.2, -0.1, 0.95), length: 0.8 };
    let (nodes, weights) = (frame.nodes.to_vec(), vec![1.0, 0.0, 0.0, 0.0]);
    let carrier = Some(frame.clone());
    let ball = SurfacePoint { at: frame.center, nodes, weights, area: 0.7, sides: vec![], radius: 1.0, carrier };
    let obstacle = Obstacle { shape: Shape::floor(), origin: Vec3::zeros(), axes: Mat3::identity(), body: None };
    let contact = Arc::new(Contact::new("c".into(), vec![ball], obstacle));
    let response = Penalty { stiffness: 5.0, rounding: 0.0 };
    let pressing = Arc::new(Pressed { contact, response, friction: None });
    let law = Coulomb { coefficient: 0.4, stick_velocity: 1e-3, slip: 1.0, most: f64::INFINITY };
    let friction = ContactFriction { name: "f".into(), pressing, law };
    let mut random = Random::seed(5);
    let mut felt = 0;
    for _ in 0..40 {
        let x = random.vector(12, 0.1);
        let local = eval(&friction, &x, Want::Residual);
        let forces = [0, 1, 2, 3].map(|k| -Vec3::from_column_slice(&local.r[3 * k..3 * k + 3]));
        let force: Vec3 = forces.iter().sum();
        if force.norm() == 0.0 {
            continue;
        }
        felt += 1;
        let p = frame.positions(&x);
        let a = frame.gradient(&p);
        let spot = 0.5 * (Mat3::identity() + a.try_inverse().expect("it is a body")) * Vec3::new(0.0, 0.0, -1.0);
        let arm = Vec3::new(0.0, 0.0, -1.0);
        let moment: Vec3 = (0..4).map(|k| (p[k] - p[0]).cross(&forces[k])).sum();
        assert!((moment - arm.cross(&force)).norm() < 1e-12, "{moment:?}");
        let slid = p[0] + a * spot - frame.center - spot;
        let slid = Vec3::new(slid.x, slid.y, 0.0);
        assert!((force.dot(&slid) + force.norm() * slid.norm()).abs() < 1e-12, "{force:?} against {slid:?}");
    }
    assert!(felt > 10, "{felt}");
}
