//! Inverse analysis: answers that do not depend on where the search starts, constants that it leaves there, and those next to the end of what a scene
//! allows.

use crate::common::{Random, largest};
use crate::inverse_keys::{model, recorded, scene};
use durometer::calibrate::Weighting;
use durometer::calibrate::inverse::{
    Bounds, Calibration, Failure, Measured, ObservedCurve, SceneModel, Settings, calibrate,
};
use durometer::scene::overrides::apply;
use durometer::scene::{ParameterKey, Progress};
use toml::Table;

/// A bar that relaxes while it is pulled.
const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["30 mm", "6 mm", "6 mm"], divisions = [3, 1, 1] }
element = "tet10"
[laws.rubber]
law = "mooney_rivlin"
C10 = "40 kPa"
C01 = "10 kPa"
volumetric = "quadratic"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "long_term"
prony = [{ g = 0.25, tau = "0.1 s" }]
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = { kind = "ramp", from = "0 mm", to = "20 mm", end = "0.4 s" }
[[constraint]]
kind = "fixed"
region = "xmax"
components = "yz"
[[stage]]
integrator = "implicit_euler"
duration = "0.4 s"
dt = "20 ms"
[[probe]]
kind = "reaction"
region = "xmax"
"#;

const FORCE: &str = "xmax_reaction_x_N";
const STIFFNESS: &str = "laws.rubber.C10";
const SHARE: &str = "effect.viscoelastic.prony.0.g";
const TIME: &str = "effect.viscoelastic.prony.0.tau";

/// The scene with these values of its keys \[SI\].
fn with(text: &str, values: &[(&str, f64)]) -> Table {
    let mut table: Table = text.parse().expect("valid TOML");
    for (key, value) in values {
        let written = key.parse::<ParameterKey>().expect("a path").value(&table).expect("a number").written_si(*value);
        apply(&mut table, key, written).expect("the key is there");
    }
    table
}

/// What a scene records, with independent errors of this share of the largest value.
fn measured(table: &Table, noise: f64) -> Measured {
    let mut made = recorded(table, FORCE);
    let (size, mut random) = (noise * largest(&made.y), Random::seed(7));
    made.y.iter_mut().for_each(|y| *y += size * random.normal());
    made
}

fn modelled(start: &Table, keys: &[&str]) -> SceneModel {
    model(start, keys, &Bounds::new(), FORCE).unwrap_or_else(|e| panic!("{e}"))
}

fn found(start: &Table, keys: &[&str], measured: &Measured, accuracy: f64) -> Calibration {
    let model = modelled(start, keys);
    let curve =
        ObservedCurve { name: "made".into(), model, measured: measured.clone(), specimen: None, offsets: vec![] };
    let settings = Settings { accuracy, ..Settings::new(Weighting::Absolute) };
    match calibrate(vec![curve], &settings, None, &mut |_: Progress| true) {
        Ok((found, _)) => found,
        Err(Failure::Input(why)) => panic!("{why}"),
        Err(Failure::Constants(why)) => panic!("{why}"),
        Err(_) => panic!("no answer"),
    }
}

/// A stiffness, a share and a time of one curve with errors of 0.1 %. An error of 1 % would leave the time open, so that no interval is stated; the scatter
/// does not, and the search finds it from everywhere. It ends where a step changes the constants by less than 1e-3 √n = 5e-3 of their
/// standard deviation, which of the time is some per cent.
#[test]
fn the_answer_does_not_depend_on_the_start() {
    let keys = [STIFFNESS, SHARE, TIME];
    let data = measured(&with(SCENE, &[]), 1e-3);
    let of = |values: [f64; 3]| {
        let start = with(SCENE, &[(STIFFNESS, values[0]), (SHARE, values[1]), (TIME, values[2])]);
        let c = found(&start, &keys, &data, 0.01);
        let values: Vec<f64> = c.constants.iter().map(|f| f.value).collect();
        println!("{values:?}, misfit {:.2e}, {} solves, {:?}", c.curves[0].rms_relative, c.solves, c.end);
        assert!(c.settled() && c.left().is_empty(), "{:?}", c.unidentified);
        assert!(c.constants.iter().all(|f| f.interval.is_none()), "{:?}", c.constants);
        assert!(c.unidentified[0].contains("state its `accuracy`"), "{:?}", c.unidentified);
        values
    };
    let best = of([40e3, 0.25, 0.1]);
    for (k, truth) in [40e3, 0.25, 0.1].into_iter().enumerate() {
        assert!((best[k] / truth - 1.0).abs() < 0.2, "{k}: {} for {truth}", best[k]);
    }
    for start in [[25e3, 0.1, 0.3], [25e3, 0.25, 0.3], [60e3, 0.4, 0.05]] {
        for (own, best) in of(start).iter().zip(&best) {
            assert!((own / best - 1.0).abs() < 2e-3, "{start:?}: {own} for {best}");
        }
    }
}

/// A time of 10 µs in steps of 20 ms: data with errors of 0.5 % are silent about it. It stays where it started, and that is said.
#[test]
fn a_constant_that_the_data_are_silent_about_stays_and_is_named() {
    let data = measured(&with(SCENE, &[(TIME, 1e-5)]), 5e-3);
    let start = with(SCENE, &[(STIFFNESS, 30e3), (TIME, 2e-5)]);
    let c = found(&start, &[STIFFNESS, TIME], &data, 0.01);
    println!("{:?}\n{:?}", c.constants, c.unidentified);
    assert_eq!(c.left(), [TIME]);
    assert!(c.settled() && (c.constants[1].value / 2e-5 - 1.0).abs() < 1e-2 && c.constants[1].interval.is_none());
    let words = c.unidentified.join("\n");
    assert!(
        words.contains(&format!("{TIME}: the search left it at its starting value, 0.00002 in SI units")),
        "{words}"
    );
    assert!(c.constants[0].interval.is_some_and(|[a, b]| a < 40e3 && 40e3 < b), "{:?}", c.constants[0]);
}

/// Shares that add up to one less 1e-12: the scene has them, and no derivative by either, as the least step leads beyond. Constants as
/// these are to be stepped back from; as a start they are no mistake in the input either.
#[test]
fn constants_without_a_derivative_are_no_wrong_input() {
    let text = two_shares();
    let second = "effect.viscoelastic.prony.1.g";
    let edge = [(SHARE, 0.5), (second, 0.5 - 1e-12)];
    for start in [with(&text, &[]), with(&text, &edge)] {
        let model = modelled(&start, &[SHARE, second]);
        match model.answer(&edge.map(|(_, value)| value), &[0.1, 0.2], 0.0, &mut |_| true) {
            Err(Failure::Constants(why)) => assert!(why.contains(SHARE) && why.contains("derivative"), "{why}"),
            Err(Failure::Input(why)) => panic!("it counts as wrong input: {why}"),
            _ => panic!("it has a derivative"),
        }
    }
}

/// All three directions from the first step on, far from the answer: trial shares next to 1, where there is no derivative, are steps to take back, and the
/// search comes to the constants that the other starts lead to.
#[test]
fn a_search_steps_back_from_shares_of_almost_one() {
    let start = with(SCENE, &[(STIFFNESS, 35e3), (SHARE, 0.1), (TIME, 0.4)]);
    let c = found(&start, &[STIFFNESS, SHARE, TIME], &measured(&with(SCENE, &[]), 1e-3), 1e-4);
    println!("{:?}: {} solves, {} failed", c.constants, c.solves, c.failed);
    assert!(c.failed > 0, "the start is too near");
    assert!(c.settled(), "{:?} after {} refused steps", c.end, c.failed);
    for (f, truth) in c.constants.iter().zip([40e3, 0.25, 0.1]) {
        assert!(f.interval.is_some() && (f.value / truth - 1.0).abs() < 0.1, "{}: {} for {truth}", f.key, f.value);
    }
}

/// The scene with a second term, and constants of the instant, which a sum of shares near one does not raise.
fn two_shares() -> String {
    let two = "prony = [{ g = 0.25, tau = \"0.1 s\" }, { g = 0.2, tau = \"0.4 s\" }]";
    SCENE.replace("prony = [{ g = 0.25, tau = \"0.1 s\" }]", two).replace("\"long_term\"", "\"instantaneous\"")
}

/// A scene next to the end of what it allows is checked on the other side of its value: a thousandth more than 0.3 and 0.6999 is beyond 1.
#[test]
fn a_start_next_to_the_end_is_checked_on_the_other_side() {
    let text = two_shares();
    let near = with(&text, &[(SHARE, 0.3), ("effect.viscoelastic.prony.1.g", 0.6999)]);
    assert!(scene(&near).run().column("t_s").is_some());
    let data = recorded(&near, FORCE);
    let reached = modelled(&near, &[SHARE]).reached(&data);
    assert!(reached.is_ok_and(|reached| reached.iter().all(|r| *r)));
}

/// Starts of half the stiffness and up to four times the time lead to the constants that the data tell, also by way of times that are too short for the
/// data to say anything: 1e-3 of the values, a third of the standard deviation of the stiffness, and 1e-2 of the others, a fifth of that of the time.
#[test]
fn far_starts_of_three_unknowns_lead_to_the_same_constants() {
    let data = measured(&with(SCENE, &[]), 1e-3);
    let near = found(&with(SCENE, &[]), &[STIFFNESS, SHARE, TIME], &data, 1e-4);
    for (stiffness, time) in [(20e3, 0.3), (25e3, 0.4), (30e3, 0.3), (30e3, 0.4), (35e3, 0.3)] {
        let start = with(SCENE, &[(STIFFNESS, stiffness), (SHARE, 0.1), (TIME, time)]);
        let c = found(&start, &[STIFFNESS, SHARE, TIME], &data, 1e-4);
        let values: Vec<f64> = c.constants.iter().map(|f| f.value).collect();
        println!("{stiffness} Pa, {time} s: {:?} at {values:?}, {} solves, {} failed", c.end, c.solves, c.failed);
        assert!(c.settled(), "{stiffness} Pa, {time} s: {:?}", c.end);
        for ((f, truth), bound) in c.constants.iter().zip(&near.constants).zip([1e-3, 1e-2, 1e-2]) {
            assert!(f.interval.is_some(), "{}: no interval", f.key);
            assert!((f.value / truth.value - 1.0).abs() < bound, "{}: {} for {}", f.key, f.value, truth.value);
        }
    }
}

/// A search that goes on from values about which the data are silent, where an earlier one was interrupted, leaves them as the whole search does.
#[test]
fn a_search_that_goes_on_leaves_silent_values() {
    let data = measured(&with(SCENE, &[]), 1e-3);
    let start = with(SCENE, &[(STIFFNESS, 30e3), (SHARE, 0.1), (TIME, 0.3)]);
    let model = modelled(&start, &[STIFFNESS, SHARE, TIME]);
    let curve = ObservedCurve { name: "made".into(), model, measured: data, specimen: None, offsets: vec![] };
    let settings = Settings { accuracy: 1e-4, ..Settings::new(Weighting::Absolute) };
    let silent = [44.19e3, 0.01, 2e-4];
    let (c, _) = calibrate(vec![curve], &settings, Some(&silent), &mut |_: Progress| true)
        .unwrap_or_else(|_| panic!("no answer"));
    println!("{:?}: {:?}", c.end, c.constants);
    for (f, truth) in c.constants.iter().zip([40e3, 0.25, 0.1]) {
        assert!(f.interval.is_some() && (f.value / truth - 1.0).abs() < 0.05, "{}: {} for {truth}", f.key, f.value);
    }
}

/// A beam under its weight, whose sag hardly tells the compressibility.
const SAG: &str = r#"
[mesh]
grid = { kind = "box", size = ["100 mm", "10 mm", "10 mm"], divisions = [8, 2, 2] }
element = "tet10"
[laws.rubber]
law = "neo_hookean_split"
E = "300 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = { kind = "ramp", from = "0 m/s^2", to = "6 m/s^2", end = "1 s" }
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.1 s"
[[probe]]
kind = "position"
region = "xmax"
"#;

/// A stiffness that is too small drives the compressibility to the end of what the scene allows, where the body locks. The search goes on from its start, and
/// the misfit is that of the truth.
#[test]
fn a_bound_far_from_the_minimum_is_left() {
    let column = "xmax_z_m";
    let (truth, keys) = (with(SAG, &[]), ["laws.rubber.E", "laws.rubber.nu"]);
    let (mut data, mut random) = (recorded(&truth, column), Random::seed(5));
    data.y.iter_mut().for_each(|y| *y += 5e-5 * random.normal());
    let rms = |e: f64| {
        let model = model(&with(SAG, &[(keys[0], e)]), &keys, &Bounds::new(), column).unwrap_or_else(|e| panic!("{e}"));
        let curve =
            ObservedCurve { name: "sag".into(), model, measured: data.clone(), specimen: None, offsets: vec![] };
        match calibrate(vec![curve], &Settings::new(Weighting::Absolute), None, &mut |_: Progress| true) {
            Ok((found, _)) => {
                println!("from {e}: {:?}, {} solves", found.constants, found.solves);
                found.curves[0].rms
            }
            Err(_) => panic!("no answer"),
        }
    };
    let least = rms(300e3);
    for start in [200e3, 400e3] {
        let found = rms(start);
        assert!(found < 1.1 * least, "from {start}: {found:e} m, and {least:e} m from the truth");
    }
}
