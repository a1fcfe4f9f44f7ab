//! What contact costs far away, and how it says what it cannot do.

use crate::common::{column, run, scene};
use crate::setup::{CUBE, last};
use durometer::effect::contact::placement::Obstacle;
use durometer::effect::contact::shape::Shape;
use durometer::effect::contact::{Contact, Counts, SurfacePoint};
use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::Order;
use durometer::mesh::curved::octant;
use durometer::mesh::structured::block;
use durometer::scene::{RunOptions, SensitivityRecorder};
use durometer::solve::{Failure, Status};
use durometer::system::Caches;

/// What is far away is not looked at twice: each point has its distance computed once, and nothing is added to the tangent.
#[test]
fn contact_far_away_costs_nothing_to_speak_of() {
    let text = |contact: &str| {
        format!(
            r#"{CUBE}
[[constraint]]
kind = "fixed"
region = "xmin"
[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = "9.81 m/s^2"
{contact}
[[stage]]
integrator = "bdf2"
duration = "0.1 s"
dt = "5 ms"
"#
        )
    };
    let far = r#"
[[contact]]
region = "skin"
obstacle = { kind = "box", min = ["0 mm", "0 mm", "-60 mm"], max = ["10 mm", "10 mm", "-40 mm"] }
response = "barrier"
friction = 0.3
"#;
    let mesh = || block(3, 3, 3, 0.01, 0.01, 0.01, Order::Linear);
    let (with, without) = (scene(mesh(), &text(far)), scene(mesh(), &text("")));
    let (a, b) = (run(&with), run(&without));
    let (_, counts) = &a.contacts[0];
    assert_eq!((counts.tested, counts.active), (with.contacts[0].points().expect("points").points.len(), 0));
    let again = &run(&with).contacts[0].1;
    let numbers = |c: &Counts| [c.points, c.tested, c.active];
    assert_eq!(numbers(again), numbers(counts), "counts belong to a run");
    assert_eq!(with.system.pattern.nnz(), without.system.pattern.nnz());
    assert_eq!(a.last.x, b.last.x, "the same bits");
}

/// Friction has no derivative by what came before a step: a derivative is refused, and with friction = 0 it is not.
#[test]
fn friction_has_no_derivatives() {
    for (friction, refused) in [("0.2", true), ("0", false)] {
        let text = format!(
            r#"{CUBE}
[[contact]]
name = "floor"
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-1 mm"], normal = [0, 0, 1] }}
response = "barrier"
friction = {friction}
[[stage]]
integrator = "bdf2"
duration = "10 ms"
dt = "5 ms"
"#
        );
        let scene = scene(block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear), &text);
        let constants = vec!["laws.rubber.E".parse().expect("a constant")];
        let outcome = SensitivityRecorder::new(&scene, &constants);
        assert_eq!(outcome.is_err(), refused);
        if let Err(why) = outcome {
            assert!(why.to_string().contains("contact floor has friction"), "{why}");
        }
    }
}

/// A block that flies at 0.1 m/s hits a floor 1.05 mm away in its eleventh step of 1 ms. Its velocities jump there, and derivatives by parameters end.
#[test]
fn derivatives_end_where_points_land() {
    let text = format!(
        r#"{CUBE}
[start]
kind = "moving"
velocity = ["0 m/s", "0 m/s", "-0.1 m/s"]
[[contact]]
name = "floor"
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-1.05 mm"], normal = [0, 0, 1] }}
response = "multiplier"
friction = 0
[[stage]]
integrator = {{ kind = "generalised_alpha", rho = 0.8 }}
duration = "15 ms"
dt = "1 ms"
"#
    );
    let scene = scene(block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear), &text);
    let constants = vec!["laws.rubber.E".parse().expect("a constant")];
    let recorder = SensitivityRecorder::new(&scene, &constants).unwrap_or_else(|e| panic!("{e}"));
    let run = scene.run_with(RunOptions { sensitivities: Some(recorder), ..RunOptions::default() });
    assert_eq!(run.status, Status::Converged);
    let found = run.sensitivities.expect("they are asked for");
    let Some((t, Failure::Landing)) = found.stopped else { panic!("{:?}", found.stopped) };
    assert!((t - 0.011).abs() < 1e-9 && found.rows.len() == 11, "{t} s, {} rows", found.rows.len());
}

/// A plate is driven into nodes that are held: no step however small lets it pass, and the status says who is pressed on whom.
#[test]
fn a_plate_on_held_nodes_jams() {
    for (response, integrator) in [("barrier", "bdf2"), ("multiplier", "bdf2"), ("multiplier", "implicit_euler")] {
        let text = format!(
            r#"{CUBE}
[[constraint]]
kind = "fixed"
region = "zmin"
[[contact]]
name = "plate"
region = "zmin"
obstacle = {{ kind = "box", min = ["-5 mm", "-5 mm", "-2 mm"], max = ["15 mm", "15 mm", "-1 mm"] }}
motion = {{ direction = [0, 0, 1], displacement = {{ kind = "ramp", from = "0 mm", to = "2 mm", end = "1 s" }} }}
response = "{response}"
friction = 0
[[stage]]
integrator = "{integrator}"
duration = "1 s"
dt = "0.1 s"
"#
        );
        let scene = scene(block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear), &text);
        let run = run(&scene);
        let Status::ContactJammed { t, .. } = run.status else { panic!("{response} {integrator}: {}", run.status) };
        // Two of the smallest steps, 0.1 s/2¹⁰
        assert!((t - 0.5).abs() < 2e-4, "{response} {integrator}: the plate is there at 0.5 s: {t}");
        let culprit = run.status.culprit();
        let node = culprit.node.expect("it names one") as usize;
        assert_eq!((culprit.effect.as_deref(), scene.points[node].z), (Some("plate"), 0.0));
        assert!(run.status.to_string().contains("reduce the load or the motion of the obstacle"), "{}", run.status);
    }
}

/// A block that is clamped at one end; a floor rises into its lower side, the clamped edge of which belongs to the contact. The multiplier of a
/// node that cannot move has no finite value: the run ends where the floor would enter, and the forces until then are those of no contact.
#[test]
fn a_floor_that_rises_into_a_clamped_edge_jams() {
    for friction in ["0", "0.3"] {
        let text = format!(
            r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "1 MPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[contact]]
name = "plate"
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-0.5 mm"], normal = [0, 0, 1] }}
motion = {{ direction = [0, 0, 1], displacement = {{ kind = "ramp", from = "0 mm", to = "1 mm", end = "1 s" }} }}
response = "multiplier"
friction = {friction}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.125 s"
"#
        );
        let scene = scene(block(8, 2, 2, 0.04, 0.01, 0.01, Order::Linear), &text);
        let run = run(&scene);
        let Status::ContactJammed { t, .. } = run.status else { panic!("{friction}: {}", run.status) };
        assert!((0.375..=0.5).contains(&t), "{friction}: the floor is there at 0.5 s: {t}");
        let node = run.status.culprit().node.expect("it names one") as usize;
        assert_eq!((scene.points[node].x, scene.points[node].z), (0.0, 0.0), "{friction}");
        let most = column(&run, "plate_force_z_N").into_iter().fold(0.0, |m, f| larger(m, f.abs()));
        assert!(most < 1e-6, "{friction}: {most:.1e} N");
    }
}

/// A bar of nodes 2 mm apart, which a cable bends over a cylinder of 10 mm under a light pressure on its top. Whatever ends the run, no step takes the bar
/// through the cylinder, where its tip would be 12 mm lower, and no force points into it.
#[test]
fn no_step_takes_a_bar_through_a_cylinder() {
    for response in ["multiplier", "penalty"] {
        let text = format!(
            r#"
[mesh]
body = "bar"
[laws.rubber]
law = "neo_hookean"
E = "300 kPa"
nu = 0.4
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
pull_point = ["-10 mm", "5 mm", "3 mm"]
guides = [["10 mm", "5 mm", "3 mm"], ["40 mm", "5 mm", "3 mm"], ["75 mm", "5 mm", "3 mm"]]
guide_radius = "3 mm"
drive = {{ kind = "length", signal = {{ kind = "ramp", from = "0 mm", to = "4 mm", end = "1 s" }} }}
[[constraint]]
kind = "cavity"
region = "zmax"
open = true
drive = {{ kind = "pressure", signal = {{ kind = "ramp", from = "0 kPa", to = "0.3 kPa", end = "1 s" }} }}
[[contact]]
name = "rod"
region = "zmin"
obstacle = {{ kind = "cylinder", from = ["65 mm", "-30 mm", "-9 mm"], to = ["65 mm", "40 mm", "-9 mm"], radius = "5 mm" }}
response = "{response}"
friction = 0
[[stage]]
integrator = "static"
duration = "0.6 s"
dt = "0.1 s"
[[probe]]
kind = "position"
region = "xmax"
"#
        );
        let run = run(&scene(block(40, 2, 2, 0.08, 0.01, 0.01, Order::Linear), &text));
        println!("{response}: {}", run.status);
        let (tip, force) = (column(&run, "xmax_z_m"), column(&run, "rod_force_z_N"));
        assert!(tip.len() > 3, "{response}: {} rows, {}", tip.len(), run.status);
        assert!(tip.iter().all(|z| *z > -8e-3), "{response}: {tip:?}");
        assert!(force.iter().all(|f| *f > -1e-9), "{response}: {force:?}");
    }
}

/// Motions of one point past a sphere of 5 mm, or through a sheet of a thousandth of that.
#[test]
fn a_motion_through_an_obstacle_is_seen() {
    let passed = |shape: Shape, from: [f64; 3], to: [f64; 3]| {
        let at = |p: [f64; 3]| Vec3::from(p) * 1e-3;
        let points = vec![SurfacePoint::flat(at(from), vec![0], vec![1.0], 1.0)];
        let obstacle = Obstacle { shape, origin: Vec3::zeros(), axes: Mat3::identity(), body: None };
        let contact = Contact::new("obstacle".into(), points, obstacle);
        let end: Vec<f64> = (at(to) - at(from)).iter().copied().collect();
        contact.passed([&[0.0; 3], &end], 0.0, &mut Caches::default()).is_some()
    };
    let sphere = |from, to| passed(Shape::sphere(5e-3), from, to);
    assert!(sphere([1.0, 0.0, 6.0], [1.0, 0.0, -9.0]) && sphere([0.0, 0.0, 5.0], [0.0, 1.0, -5.0]));
    assert!(sphere([1.0, 0.0, 4.5], [1.0, 0.0, -4.8]), "from inside on one side to inside on the other");
    let slid = |angle: f64| [5.0 * angle.sin(), 0.0, 5.0 * angle.cos()];
    assert!(!sphere(slid(0.0), slid(1.5)), "it slides around");
    assert!(!sphere([5.1, 0.0, 90.0], [5.1, 0.0, -90.0]), "it passes by");
    assert!(!sphere([0.0, 0.0, 6.0], [0.0, 0.0, 4.0]) && !sphere([0.0, 0.0, 4.0], [0.0, 0.0, 9.0]));
    let sheet = |from, to| passed(Shape::cuboid(Vec3::new(1.0, 1.0, 2.5e-6)), from, to);
    assert!(sheet([0.0, 0.0, 500.0], [3.0, 0.0, -100.0]) && !sheet([0.0, 0.0, 500.0], [3.0, 0.0, 0.1]));
}

/// A balloon, one octant of B/A = 2, bursts at P = 0.816 μ, with a floor far below it: the remedy names no continuation, which is refused with contact.
#[test]
fn a_limit_point_with_contact_has_a_remedy_that_can_be_taken() {
    let text = r#"
[mesh]
body = "octant"
[laws.rubber]
law = "neo_hookean_split"
E = "3 Pa"
nu = 0.49
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
components = "x"
[[constraint]]
kind = "fixed"
region = "ymin"
components = "y"
[[constraint]]
kind = "fixed"
region = "zmin"
components = "z"
[[constraint]]
kind = "cavity"
region = "inner"
drive = { kind = "pressure", signal = { kind = "ramp", from = "0 Pa", to = "1 Pa", end = "1 s" } }
[[contact]]
region = "outer"
obstacle = { kind = "floor", point = ["0 m", "0 m", "-100 m"], normal = [0, 0, 1] }
response = "penalty"
friction = 0
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.125 s"
"#;
    let run = run(&scene(octant(1.0, 2.0, 3, 1, Order::Quadratic), text));
    let Status::NoEquilibrium { in_contact: true, .. } = run.status else { panic!("{}", run.status) };
    assert!(!run.status.remedy().contains("arc_length"), "{}", run.status);
}

/// A sole with more points than corrections take comes down on a plate within one step. Corrections would solve for three directions of each of
/// its 729 points, with a dense matrix between them; Newton's method does not. The force is that of a wide layer, M ε A = 2.69 N with the modulus M of
/// uniaxial strain, less some per cent at the free edges; a barrier keeps a distance of up to h/100, a fifth of the compression.
#[test]
fn a_sole_of_many_points_is_left_to_newtons_method() {
    for response in ["multiplier", "barrier"] {
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
[[constraint]]
kind = "fixed"
region = "zmax"
[[contact]]
name = "plate"
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-0.05 mm"], normal = [0, 0, 1] }}
motion = {{ direction = [0, 0, 1], displacement = {{ kind = "ramp", from = "0 mm", to = "0.1 mm", end = "1 s" }} }}
response = "{response}"
friction = 0.3
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#
        );
        let scene = scene(block(26, 26, 2, 0.04, 0.04, 0.004, Order::Linear), &text);
        let points = scene.contacts[0].points().expect("points").points.len();
        let run = run(&scene);
        assert_eq!(run.status, Status::Converged, "{response}");
        assert_eq!(points, 27 * 27);
        assert!(run.solves < 500, "{response}: {} right sides", run.solves);
        let share = last(&run, "plate_force_z_N").abs() / (134.6e3 * (0.05 / 4.0) * 1.6e-3);
        let most = if response == "multiplier" { 1.0 } else { 1.2 };
        assert!((0.95..most).contains(&share), "{response}: {share} of the force of a wide layer");
    }
}
