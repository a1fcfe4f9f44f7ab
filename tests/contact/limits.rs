//! What contact costs far away, and how it says what it cannot do.

use crate::common::{run, scene};
use crate::setup::{CUBE, last};
use durometer::effect::contact::Counts;
use durometer::mesh::Order;
use durometer::mesh::curved::octant;
use durometer::mesh::structured::block;
use durometer::scene::SensitivityRecorder;
use durometer::solve::Status;

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

/// A plate is driven into nodes that are held: no step however small lets it pass, and the status says who is pressed on whom.
#[test]
fn a_plate_on_held_nodes_jams() {
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
response = "barrier"
friction = 0
[[stage]]
integrator = "bdf2"
duration = "1 s"
dt = "0.1 s"
"#
    );
    let scene = scene(block(2, 2, 2, 0.01, 0.01, 0.01, Order::Linear), &text);
    let run = run(&scene);
    let Status::ContactJammed { t, .. } = run.status else { panic!("{}", run.status) };
    assert!((0.4..=0.5).contains(&t), "the plate is there at 0.5 s: {t}");
    let culprit = run.status.culprit();
    let node = culprit.node.expect("it names one") as usize;
    assert_eq!((culprit.effect.as_deref(), scene.points[node].z), (Some("plate"), 0.0));
    assert!(run.status.to_string().contains("reduce the load or the motion of the obstacle"), "{}", run.status);
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
