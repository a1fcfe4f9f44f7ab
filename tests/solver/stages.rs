//! Stages: rows and events at late times, rules that need short steps, signals faster than the steps.

use crate::common::{run, scene};
use durometer::math::stopwatch::Spent;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::Scene;
use durometer::study::store::finished_run::record;

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

/// 1000 Hz with steps of 1 ms moves nothing, and the scene says so, also of a signal to which an event switches, in the time of that signal.
#[test]
fn signals_faster_than_the_steps_are_noted() {
    let fast = "{ kind = \"sine\", amplitude = \"1 mm\", frequency = \"1000 Hz\" }";
    let event = format!(
        "[[event]]\nwhen = {{ kind = \"at\", t = \"2 ms\" }}\n\
         then = [{{ kind = \"switch\", signal = \"xmax_x_displacement_m\", to = {fast} }}]\n"
    );
    for (dt, motion, event, noted) in [
        ("1 ms", fast, "", true),
        ("0.05 ms", fast, "", false),
        ("1 ms", "\"0 mm\"", event.as_str(), true),
        ("0.05 ms", "\"0 mm\"", event.as_str(), false),
    ] {
        let text = format!(
            r#"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = {motion}
{event}[[stage]]
integrator = "bdf2"
duration = "5 ms"
dt = "{dt}"
"#
        );
        let scene = bar(&text);
        let is_noted = scene.notes.iter().any(|note| note.contains("between two points of the time grid"));
        assert_eq!(is_noted, noted, "{dt} {event}: {:?}", scene.notes);
        let of_its_own = scene.notes.iter().any(|note| note.contains("of its own time"));
        assert_eq!(of_its_own, noted && !event.is_empty(), "{dt} {event}: {:?}", scene.notes);
    }
}

/// A sine of 1 Hz on a grid of 0.2 s until 0.4 s: its top is 1 − sin 0.4π = 4.9 % of its range above its values at the points, of which samples in a step find all but (0.04π)²/2.
/// A record has that share for all columns where no mass moves, be the stage static or not, and for forces where masses do; an event that never happens changes nothing.
#[test]
fn peaks_of_loads_between_the_points_of_the_grid_are_recorded() {
    let rest = r#"
[mesh]
body = "bar"
[laws.rubber]
law = "neo_hookean_split"
E = "1 MPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "traction"
region = "xmax"
direction = [1, 0, 0]
traction = { kind = "sine", amplitude = "30 Pa", frequency = "1 Hz" }
[[constraint]]
kind = "fixed"
region = "xmin"
[[probe]]
kind = "position"
region = "xmax"
[[probe]]
kind = "reaction"
region = "xmin"
"#;
    let never = r#"
[[event]]
when = { kind = "above", column = "xmax_x_m", value = "900 mm" }
then = [{ kind = "switch", signal = "traction_imposed_Pa", to = "0 Pa" }]
"#;
    let relaxing = r#"
[[effect]]
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "long_term"
prony = [{ g = 0.1, tau = "0.5 s" }]
"#;
    let inertia = "[[effect]]\nkind = \"inertia\"\nregion = \"body\"\ndensity = \"1000 kg/m^3\"\nmass = \"lumped\"\n";
    let missed = 1.0 - (0.4 * std::f64::consts::PI).sin();
    let is_found = |share: f64| share <= missed && share > missed - 0.008;
    for (integrator, effects, of_place) in [
        ("static", String::new(), true),
        ("bdf2", relaxing.into(), true),
        ("bdf2", format!("{relaxing}{inertia}"), false),
    ] {
        for event in ["", never] {
            let stage = format!("[[stage]]\nintegrator = \"{integrator}\"\nduration = \"0.4 s\"\ndt = \"0.2 s\"\n");
            let mesh = block(2, 1, 1, 0.02, 0.01, 0.01, Order::Linear);
            let scene = scene(mesh, &format!("{rest}{effects}{event}{stage}"));
            let record = record(&scene, &run(&scene), Spent::default());
            let [place, force] = ["xmax_x_m", "xmin_reaction_x_N"].map(|column| record.unseen(column));
            assert!(is_found(force), "{integrator}{effects}{event}: {force} of {missed}");
            assert_eq!(place, if of_place { force } else { 0.0 }, "{integrator}{effects}{event}");
        }
    }
    // A later stage of which one point lies on the top sees the peak of a force, whatever the static one before it misses; nothing looks at places in that one
    let stages = "[[stage]]\nintegrator = \"static\"\nduration = \"0.4 s\"\ndt = \"0.2 s\"\n\
                  [[stage]]\nintegrator = \"bdf2\"\nduration = \"0.85 s\"\ndt = \"0.05 s\"\n";
    let scene = scene(block(2, 1, 1, 0.02, 0.01, 0.01, Order::Linear), &format!("{rest}{inertia}{stages}"));
    let record = record(&scene, &run(&scene), Spent::default());
    let [place, force] = ["xmax_x_m", "xmin_reaction_x_N"].map(|column| record.unseen(column));
    assert!(is_found(place) && force == 0.0, "{place} and {force}");
}
