//! Stages: rows and events at late times, rules that need short steps, signals faster than the steps.

use crate::common::{run, scene};
use durometer::math::stopwatch::Spent;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::Scene;
use durometer::study::store::outcome::record;

/// A bar along x with mass that is held at one end.
fn bar(more: &str) -> Scene {
    let text = format!(
        r#"
[mesh]
body = "bar"
[laws.rubber]
law = "neo_hookean"
E = "1 MPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "inertia"
region = "body"
density = "1000 kg/m^3"
mass = "consistent"
[[constraint]]
kind = "fixed"
region = "xmin"
[[probe]]
kind = "energy"
{more}"#
    );
    scene(block(2, 1, 1, 0.02, 0.01, 0.01, Order::Linear), &text)
}

/// After a day of settling, steps of 10 µs have all their rows, and an event comes at its time.
#[test]
fn rows_and_events_are_in_time_after_a_day() {
    let text = r#"
[[stage]]
integrator = "static"
duration = "1440 min"
dt = "1440 min"
[[stage]]
integrator = "bdf2"
duration = "3 ms"
dt = "0.01 ms"
[output]
series = { every = "0.01 ms" }
[[event]]
name = "over"
when = { kind = "at", t = "86400.002 s" }
then = [{ kind = "stop" }]
"#;
    let run = run(&bar(text));
    let [event] = &run.events[..] else { panic!("{:?}", run.events) };
    assert!((event.t_s - 86_400.002).abs() < 1e-9, "{}", event.t_s);
    // The first state, the end of the settling, and 200 steps
    assert_eq!((run.rows.len(), run.written.len()), (202, 202));
}

/// The rules with β ≥ ¼(½ + γ)² are stable for all steps.
#[test]
fn rules_that_need_short_steps_are_noted() {
    for (beta, gamma, noted) in
        [(1e-300, 0.5, true), (0.1, 0.5, true), (0.25, 0.6, true), (0.25, 0.5, false), (0.3025, 0.6, false)]
    {
        let integrator = format!("{{ kind = \"newmark\", beta = {beta}, gamma = {gamma} }}");
        let scene = bar(&format!("[[stage]]\nintegrator = {integrator}\nduration = \"1 ms\"\ndt = \"1 ms\"\n"));
        assert_eq!(scene.notes.iter().any(|note| note.contains("newmark")), noted, "{beta} {gamma}: {:?}", scene.notes);
        assert!(scene.notes.iter().all(|note| note.len() < 300), "{beta}: a number of some digits: {:?}", scene.notes);
    }
}

/// Newmark's method is of second order with γ = ½ only, and its record says so.
#[test]
fn the_order_of_newmark_is_that_of_its_gamma() {
    for (integrator, order) in [
        ("{ kind = \"newmark\", beta = 0.25, gamma = 0.5 }", 2.0),
        ("{ kind = \"newmark\", beta = 0.3025, gamma = 0.6 }", 1.0),
        ("\"implicit_euler\"", 1.0),
        ("\"bdf2\"", 2.0),
    ] {
        let scene = bar(&format!("[[stage]]\nintegrator = {integrator}\nduration = \"2 ms\"\ndt = \"1 ms\"\n"));
        assert_eq!(record(&scene, &run(&scene), Spent::default()).order_in_time(), order, "{integrator}");
    }
}

/// 1000 Hz with steps of 1 ms moves nothing, and the scene says so.
#[test]
fn signals_faster_than_the_steps_are_noted() {
    for (dt, noted) in [("1 ms", true), ("0.05 ms", false)] {
        let text = format!(
            r#"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = {{ kind = "sine", amplitude = "1 mm", frequency = "1000 Hz" }}
[[stage]]
integrator = "bdf2"
duration = "5 ms"
dt = "{dt}"
"#
        );
        let scene = bar(&text);
        let is_noted = scene.notes.iter().any(|note| note.contains("between two points of the time grid"));
        assert_eq!(is_noted, noted, "{dt}: {:?}", scene.notes);
    }
}
