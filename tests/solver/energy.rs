//! Energy from nothing: stated where an integrator makes it up, and nowhere else.

use crate::common::{column, run, scene};
use durometer::math::statistics::larger;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{Checkpoint, EnergyFromNothing, Run, RunOptions, Scene};
use durometer::solve::Status;

const BAR: &str = r#"
[mesh]
body = "bar"
[laws.rubber]
law = "neo_hookean_split"
mu = "60 kPa"
nu = 0.4
volumetric = "quadratic"
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "inertia"
region = "body"
density = "1 g/cm^3"
mass = "consistent"
[[probe]]
kind = "energy"
"#;

const HELD: &str = "[[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n";

/// A bar of 40 mm along x.
fn bar(text: &str) -> Scene {
    scene(block(4, 1, 1, 0.04, 0.01, 0.01, Order::Linear), &format!("{BAR}{text}"))
}

fn stage(integrator: &str, duration: &str, dt: &str) -> String {
    format!("[[stage]]\nintegrator = {integrator}\nduration = \"{duration}\"\ndt = \"{dt}\"\n")
}

/// A free rigid box that spins at 10 rad/s about the axis of its largest moment of inertia, next to a bar at rest.
fn spinning(integrator: &str, dt_ms: u32) -> Scene {
    let body = r#"
[[rigid]]
name = "top"
shape = { kind = "box", min = ["100 mm", "0 mm", "0 mm"], max = ["130 mm", "20 mm", "10 mm"] }
density = "1000 kg/m^3"
spin = ["0 rad/s", "0 rad/s", "10 rad/s"]
"#;
    bar(&format!("{HELD}{body}{}", stage(integrator, "3 s", &format!("{dt_ms} ms"))))
}

/// The motion is a steady rotation, whose kinetic energy stays. Where the rule of a run makes it grow, the run says so; where it does not, it says
/// nothing.
#[test]
fn a_spinning_body_grows_with_a_warning_or_not_at_all() {
    let rho = |rho: f64| format!("{{ kind = \"generalised_alpha\", rho = {rho} }}");
    let bdf2 = || "\"bdf2\"".to_string();
    let grown = [(rho(0.9), 10), (rho(0.8), 20), (rho(0.7), 30)];
    let kept = [(rho(0.9), 5), (rho(0.8), 10), (rho(0.5), 30), (bdf2(), 10), (bdf2(), 30)];
    let share = |(integrator, dt): &(String, u32)| {
        let run = run(&spinning(integrator, *dt));
        assert_eq!(run.status, Status::Converged, "{integrator}, {dt} ms");
        let kinetic = column(&run, "kinetic_J");
        let most = kinetic.iter().fold(0.0, |most, k| larger(most, *k));
        (most / kinetic[0], run.energy_from_nothing.map_or(0.0, |found| found.share()))
    };
    for case in &grown {
        let (growth, share) = share(case);
        assert!(growth > 2.0 && share > 0.5, "{case:?}: energy times {growth}, stated {share}");
    }
    for case in &kept {
        let (growth, share) = share(case);
        assert!(growth < 1.01 && share == 0.0, "{case:?}: energy times {growth}, stated {share}");
    }
}

/// Elastic and kinetic energy between two times beyond that at the first one, the work, and what relaxing parts give back, as shares of the largest energy: the most in a step, and
/// the most that three steps have. None for a body at rest.
fn excess(run: &Run, [from, to]: [f64; 2]) -> Option<[f64; 2]> {
    let columns = ["t_s", "elastic_J", "kinetic_J", "work_J", "dissipated_J"].map(|name| column(run, name));
    let inside = (0..run.rows.len()).filter(|&k| (from - 1e-9..to + 1e-9).contains(&columns[0][k]));
    let states: Vec<[f64; 4]> = inside.map(|k| [1, 2, 3, 4].map(|c| columns[c][k])).collect();
    let ([elastic, kinetic, work, dissipated], steps) = (states[0], &states[1..]);
    let largest = steps.iter().map(|s| larger(s[0] + s[1], (s[2] - work).abs())).fold(0.0, larger);
    let beyond = |s: &[f64; 4]| s[0] + s[1] - elastic - kinetic - (s[2] - work) - (dissipated - s[3]).max(0.0);
    let mut all: Vec<f64> = steps.iter().map(|s| beyond(s) / largest).collect();
    all.sort_by(|a, b| b.total_cmp(a));
    (largest > 1e-20).then(|| [all[0], all[2]])
}

/// Loads that are switched within a step, motions that are given, drives, relaxation with damping, contact with a driven obstacle, and changes of
/// stage: no energy comes from nothing. In the step in which a load is switched or a cable goes slack the sum of the work is off by up to 1.1e-3, and no three steps have more than rounding.
#[test]
fn sound_runs_are_without_it() {
    let gravity = r#"
[[effect]]
kind = "gravity"
region = "body"
density = "1 g/cm^3"
direction = [0, 0, -1]
acceleration = { kind = "points", of = [[0, 0], [0.1, 0], [0.101, 9.81], [0.2, 9.81], [0.201, 0]], unit = "m/s^2" }
"#;
    let moved = r#"
[[constraint]]
kind = "prescribed"
region = "xmin"
components = "z"
displacement = { kind = "sine", amplitude = "3 mm", frequency = "4 Hz" }
[[constraint]]
kind = "fixed"
region = "xmin"
components = "xy"
[[effect]]
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "instantaneous"
prony = [{ g = 0.4, tau = "20 ms" }]
[[effect]]
kind = "mass_damping"
region = "body"
density = "1 g/cm^3"
mass = "consistent"
alpha = "5 1/s"
"#;
    let cable = r#"
[[constraint]]
kind = "cable"
guides = [["15 mm", "5 mm", "2 mm"], ["35 mm", "5 mm", "2 mm"]]
pull_point = ["-10 mm", "5 mm", "2 mm"]
guide_radius = "5 mm"
drive = { kind = "length", signal = { kind = "points", of = [[0, 0], [0.1, 3], [0.15, 3], [0.16, 0], [0.3, 0]], unit = "mm" } }
"#;
    let ball = r#"
[[contact]]
name = "ball"
region = "zmin"
obstacle = { kind = "sphere", center = ["30 mm", "5 mm", "-10.1 mm"], radius = "10 mm" }
motion = { direction = [0.6, 0, 0.8], displacement = { kind = "raised_cosine", amplitude = "2.5 mm", frequency = "5 Hz" } }
response = "multiplier"
friction = 0.3
"#;
    let alpha = "{ kind = \"generalised_alpha\", rho = 0.8 }";
    let (bdf2, euler) = ("\"bdf2\"", "\"implicit_euler\"");
    let held = |more: &str| format!("{HELD}{more}");
    let scenes = [("gravity", held(gravity)), ("moved", moved.into()), ("cable", held(cable)), ("ball", held(ball))];
    for (name, text) in &scenes {
        for integrator in [bdf2, euler, alpha] {
            let settle = stage("\"static\"", "100 ms", "20 ms");
            let [long, short] = ["200 ms", "50 ms"].map(|duration| stage(integrator, duration, "2 ms"));
            let run = run(&bar(&format!("{text}{settle}{long}{settle}{short}")));
            assert_eq!(run.status, Status::Converged, "{name}, {integrator}: {}", run.status);
            assert_eq!(run.energy_from_nothing, None, "{name}, {integrator}");
            let found: Vec<[f64; 2]> =
                [[0.1, 0.3], [0.4, 0.45]].into_iter().filter_map(|span| excess(&run, span)).collect();
            println!("{name}, {integrator}: {found:?}");
            assert!(!found.is_empty(), "{name}, {integrator}: it moves");
            assert!(found.iter().all(|[one, three]| *one < 5e-3 && *three < 1e-4), "{name}, {integrator}: {found:?}");
        }
    }
}

/// A run that goes on from a saved state states what the whole run states.
#[test]
fn a_restart_states_the_same() {
    let scene = spinning("{ kind = \"generalised_alpha\", rho = 0.9 }", 10);
    let whole: Option<EnergyFromNothing> = run(&scene).energy_from_nothing;
    assert!(whole.is_some());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("last.state");
    let mut save = |checkpoint: &Checkpoint, _: &str| checkpoint.write(&file).expect("writable");
    scene.run_with(RunOptions { save_at: vec![2.9], on_save: Some(&mut save), ..RunOptions::default() });
    let restart = Some(Checkpoint::read(&file, &scene).unwrap_or_else(|e| panic!("{e}")));
    let rest = scene.run_with(RunOptions { restart, ..RunOptions::default() });
    assert_eq!(rest.energy_from_nothing, whole);
}
