//! Signals that are determined during the run: states to restart from, formulas of recorded columns, events, controllers.

use crate::common::tools;
use crate::common::{column, run, scene};
use durometer::material::law_from_table;
use durometer::math::statistics::larger;
use durometer::mesh::Order;
use durometer::mesh::generate::CablePath;
use durometer::mesh::structured::block;
use durometer::scene::control::{ControlError, Controller, Observation, Opening, Reply};
use durometer::scene::{
    Body, Checkpoint, CheckpointError, Moment, Progress, Recorder, Run, RunOptions, Scene, SceneBuilder, SceneSpec,
};
use durometer::solve::Status;
use durometer::system::{At, BlockValues, Blocks, Effect, EnergyRole, EvalError, State, Want};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Duration;

const LAW: &str = r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
mu = "60 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[probe]]
kind = "position"
region = "xmax"
"#;

const CABLE: &str = r#"
[[constraint]]
kind = "cable"
guides = [["15 mm", "5 mm", "2 mm"], ["35 mm", "5 mm", "2 mm"]]
pull_point = ["-10 mm", "5 mm", "2 mm"]
guide_radius = "5 mm"
"#;

const STATIC: &str = "[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.1 s\"\n";

/// A bar of 40 mm along x.
fn bar(text: &str) -> Scene {
    scene(block(4, 1, 1, 0.04, 0.01, 0.01, Order::Linear), text)
}

/// A bar whose cable is driven in this way.
fn pulled(drive: &str, more: &str) -> Scene {
    bar(&format!("{LAW}{CABLE}drive = {drive}\n{STATIC}{more}"))
}

/// Everything that can be remembered: history, two fields, rows, rates of three integrators, an input, an event.
fn rich() -> Scene {
    bar(&format!(
        r#"{}
[[effect]]
kind = "inertia"
region = "body"
density = "1 g/cm^3"
mass = "lumped"
[[effect]]
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "long_term"
prony = [{{ g = 0.3, tau = "50 ms" }}]
[[effect]]
kind = "mullins"
region = "body"
law = "rubber"
softening = {{ r = 2, m = "20 Pa", beta = 0.1 }}
{CABLE}
drive = {{ kind = "length", signal = {{ kind = "expression", formula = "4 * t + 100 * max(xmax_z_m - 0.004, 0)", unit = "mm" }} }}
[[stage]]
integrator = "static"
duration = "0.6 s"
dt = "0.1 s"
[[stage]]
integrator = "bdf2"
duration = "30 ms"
dt = "5 ms"
[[stage]]
integrator = {{ kind = "generalised_alpha", rho = 0.8 }}
duration = "30 ms"
dt = "5 ms"
[[probe]]
kind = "energy"
[[probe]]
kind = "reaction"
region = "xmin"
[[event]]
name = "let go"
when = {{ kind = "at", t = "0.62 s" }}
then = [{{ kind = "switch", signal = "cable_shortening_m", to = "0 mm", over = "20 ms" }}]
[numerics]
time_error = "20 um"
"#,
        LAW.replace("law = \"rubber\"", "law = \"rubber\"\nformulation = \"mixed\"")
            .replace("\"neo_hookean\"", "\"neo_hookean_split\"")
    ))
}

fn bits(run: &Run) -> Vec<u64> {
    let rows = run.rows.iter().chain(&run.signals).flatten();
    rows.chain(&run.last.x).chain(&run.last.v).chain(&run.last.history).map(|v| v.to_bits()).collect()
}

/// The run goes on from a state saved at every point of the grid, through its file, with the bits of the whole run.
#[test]
fn a_restart_has_the_bits_of_the_whole_run() {
    let scene = rich();
    let whole = restarted_everywhere(&scene);
    assert!(whole.last.history.iter().any(|h| *h != 0.0) && whole.last.lambda.len() == 1);
    assert_eq!(whole.events.len(), 1);
    assert!(whole.totals.repeated > 0 && whole.totals.steps > 18, "{:?}", whole.totals);
    assert!(whole.rows.len() > 19 && column(&whole, "cable_tension_N").iter().any(|t| *t > 0.0));
}

/// The slip of a cable with friction and the history of its slackness go on too: over a guide that it wraps, there and back.
#[test]
fn a_cable_with_friction_goes_on_with_its_bits() {
    let cable = CABLE.replace("[\"35 mm\", \"5 mm\", \"2 mm\"]", "[\"35 mm\", \"5 mm\", \"8 mm\"]");
    let drive =
        r#"{ kind = "length", signal = { kind = "expression", formula = "3 * sin(2.5 * PI * t)", unit = "mm" } }"#;
    let event =
        "[[event]]\nname = \"loose\"\nwhen = { kind = \"slack\", cable = \"cable\" }\nthen = [{ kind = \"save\" }]\n";
    let more = "friction = 0.3\nEA = \"2 kN\"\n";
    let scene = bar(&format!("{LAW}{cable}{more}drive = {drive}\n{STATIC}{event}[[probe]]\nkind = \"energy\"\n"));
    let whole = restarted_everywhere(&scene);
    let slip = column(&whole, "cable_slip_1_m");
    assert!(slip.iter().any(|a| a.abs() > 1e-6) && whole.cable_events.len() >= 2, "{slip:?} {:?}", whole.cable_events);
    // An event of the scene comes at the grid, one of the cable at the first accepted step: here they are the same.
    let [fired] = &whole.events[..] else { panic!("{:?}", whole.events) };
    let loose = whole.cable_events.iter().find(|e| e.what.name() == "slack").expect("it is let out");
    assert!(whole.totals.cuts > 0 || fired.t_s == loose.t, "{fired:?} {loose:?}");
}

/// All grids here have multiples of 5 ms.
fn on_grid(t: f64) -> bool {
    (t / 0.005 - (t / 0.005).round()).abs() < 1e-6
}

/// The run, the same from every point of its grid.
fn restarted_everywhere(scene: &Scene) -> Run {
    let whole = run(scene);
    assert_eq!(whole.status, Status::Converged, "{}", whole.status);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut files: Vec<PathBuf> = Vec::new();
    let mut saved = |checkpoint: &Checkpoint, label: &str| {
        let file = folder.path().join(format!("{label}.state"));
        checkpoint.write(&file).expect("writable");
        files.push(file);
    };
    let at: Vec<f64> = whole.rows.iter().map(|row| row[0]).filter(|t| on_grid(*t)).collect();
    let (points, mut count) = (at.len(), 0);
    let mut on_state = |_: &State| count += 1;
    let options = RunOptions {
        save_at: at,
        save_end: true,
        on_save: Some(&mut saved),
        on_state: Some(&mut on_state),
        ..RunOptions::default()
    };
    // To save a state changes nothing.
    assert_eq!(bits(&scene.run_with(options)), bits(&whole));
    assert_eq!(count, points);
    assert_eq!(files.len(), points + 1, "each point of the grid, and the end");
    for file in &files {
        let from = Checkpoint::read(file, scene).unwrap_or_else(|e| panic!("{e}"));
        let mut seen = whole.rows[..from.recorded()].iter().filter(|row| on_grid(row[0])).count();
        let mut on_state = |_: &State| seen += 1;
        let options = RunOptions { restart: Some(from), on_state: Some(&mut on_state), ..RunOptions::default() };
        let again = scene.run_with(options);
        assert_eq!(again.status, Status::Converged);
        assert!(bits(&again) == bits(&whole), "{}", file.display());
        assert_eq!((again.events, again.totals, again.peak), (whole.events.clone(), whole.totals, whole.peak.clone()));
        assert_eq!(again.cable_events, whole.cable_events);
        assert_eq!(seen, points, "only new states are handed out");
    }
    whole
}

/// A run that was cut between two points of the grid goes on from the last one.
#[test]
fn an_interrupted_run_can_be_continued() {
    let scene =
        pulled(r#"{ kind = "length", signal = { kind = "ramp", from = "0 mm", to = "4 mm", end = "1 s" } }"#, "");
    let whole = run(&scene);
    let mut kept = None;
    let mut saved = |checkpoint: &Checkpoint, label: &str| {
        assert_eq!(label, "end");
        kept = Some(checkpoint.clone());
    };
    let mut on_progress = |progress: Progress| progress.t < 0.55;
    let options = RunOptions {
        save_end: true,
        on_save: Some(&mut saved),
        on_progress: Some(&mut on_progress),
        ..RunOptions::default()
    };
    let cut = scene.run_with(options);
    assert_eq!(cut.status.name(), "Interrupted");
    let options = RunOptions { restart: kept, ..RunOptions::default() };
    let again = scene.run_with(options);
    assert!(again.status == Status::Converged && bits(&again) == bits(&whole));
}

/// A run that is asked for states keeps them where nothing receives them, with the labels that a receiver gets, those of its events included. Of the
/// states that are saved again and again it keeps the last one, and of a run that is asked for none there are none.
#[test]
fn saved_states_are_in_the_result_where_nothing_receives_them() {
    let event = "[[event]]\nname = \"early\"\nwhen = { kind = \"at\", t = \"0.2 s\" }\nthen = [{ kind = \"save\" }]\n";
    let drive = r#"{ kind = "length", signal = { kind = "ramp", from = "0 mm", to = "4 mm", end = "1 s" } }"#;
    let scene = pulled(drive, event);
    let mut received = Vec::new();
    let mut saved = |checkpoint: &Checkpoint, label: &str| received.push((label.to_string(), checkpoint.state.clone()));
    fn asked<'a>() -> RunOptions<'a> {
        RunOptions { save_at: vec![0.5], save_end: true, ..RunOptions::default() }
    }
    assert!(scene.run_with(RunOptions { on_save: Some(&mut saved), ..asked() }).saved.is_empty());
    let whole = scene.run_with(asked());
    assert!(whole.saved.iter().map(|(label, kept)| (label, &kept.state)).eq(received.iter().map(|(l, s)| (l, s))));
    assert_eq!(received.iter().map(|(label, _)| label.as_str()).collect::<Vec<_>>(), ["0.2s", "0.5s", "end"]);
    assert!(whole.checkpoint("0.4s").is_none());
    for label in ["0.2s", "0.5s", "end"] {
        let again = scene.run_with(RunOptions { restart: whole.checkpoint(label).cloned(), ..RunOptions::default() });
        assert!(bits(&again) == bits(&whole), "{label}");
    }
    assert!(run(&scene).saved.is_empty());
    let often = pulled(drive, "").run_with(RunOptions { save_every: Some(Duration::ZERO), ..RunOptions::default() });
    let [(label, last)] = &often.saved[..] else { panic!("{} states", often.saved.len()) };
    assert_eq!((label.as_str(), &last.state), ("partial", &often.last));
}

#[test]
fn a_state_of_another_scene_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("a.state");
    let scene = pulled("{ kind = \"length\", signal = \"1 mm\" }", "");
    let mut saved = |checkpoint: &Checkpoint, _: &str| checkpoint.write(&file).expect("writable");
    let options = RunOptions { save_at: vec![0.5], on_save: Some(&mut saved), ..RunOptions::default() };
    scene.run_with(options);
    let other = pulled("{ kind = \"length\", signal = \"2 mm\" }", "");
    let error = Checkpoint::read(&file, &other).expect_err("another scene").to_string();
    assert!(error.contains("saved from another scene; restart it with the one it belongs to"), "{error}");
    // Numerics may differ: a run that was stuck goes on with more patience.
    let patient = pulled("{ kind = \"length\", signal = \"1 mm\" }", "[numerics]\ncuts = 20\n");
    assert!(Checkpoint::read(&file, &patient).is_ok());
    let bytes = std::fs::read(&file).expect("just written");
    let mut flipped = bytes.clone();
    *flipped.last_mut().expect("bytes") ^= 1;
    for (broken, says) in
        [(flipped.as_slice(), "damaged"), (&bytes[..bytes.len() - 8], "damaged"), (b"{}\n", "no saved state")]
    {
        std::fs::write(&file, broken).expect("writable");
        let error = Checkpoint::read(&file, &scene).expect_err(says).to_string();
        assert!(error.contains(says), "{error}");
    }
    assert!(matches!(Checkpoint::read(&folder.path().join("none"), &scene), Err(CheckpointError::Unreadable { .. })));
}

/// The paths of a body are no part of its mesh file, and a cable may follow one.
#[test]
fn a_state_of_a_body_with_other_cable_paths_is_refused() {
    let text = LAW.replace(
        "body = \"block\"",
        "grid = { kind = \"box\", size = [\"40 mm\", \"10 mm\", \"10 mm\"], divisions = [4, 1, 1] }",
    );
    let text = format!("{text}{STATIC}");
    let with_path = |z: f64| {
        let file = Path::new("scene.toml");
        let spec = SceneSpec::from_text(file, &text, "").expect("a scene");
        let mut body = Body::load(file, &spec.mesh, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
        let guides = vec![[0.015, 0.005, z], [0.035, 0.005, z]];
        body.paths.insert("tendon".into(), CablePath { guides, pull_point: [-0.01, 0.005, z], guide_radius: 0.005 });
        Scene::build(file, spec, text.clone(), body.into()).unwrap_or_else(|e| panic!("{e}"))
    };
    let scene = with_path(0.002);
    let whole = scene.run_with(RunOptions { save_at: vec![0.5], ..RunOptions::default() });
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("a.state");
    whole.saved[0].1.write(&file).expect("writable");
    let error = Checkpoint::read(&file, &with_path(0.004)).expect_err("another path").to_string();
    assert!(error.contains("saved from another mesh"), "{error}");
    assert!(Checkpoint::read(&file, &with_path(0.002)).is_ok());
}

/// A force on all nodes of the tip, from Rust.
struct Push {
    blocks: Blocks,
    force: f64,
}

impl Effect for Push {
    fn name(&self) -> &str {
        "push"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Load
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, b: usize, _: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let dof = 3 * self.blocks.nodes(b)[0] as usize + 2;
        (out.energy, out.r[2]) = (-self.force * at.x[dof], -self.force);
        Ok(())
    }
}

/// The largest displacement in z, from Rust.
struct Lift(&'static str);

impl Recorder for Lift {
    fn columns(&self) -> Vec<String> {
        vec![self.0.into()]
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        vec![now.state.x.iter().skip(2).step_by(3).fold(0.0, |most, z| larger(most, *z))]
    }
}

/// A state belongs to what is simulated: a change of the specification or of a constant of what was added in Rust makes another scene of the same
/// text. A run does not go on from such a state, and the state itself keeps the scene that it is of.
#[test]
fn a_state_belongs_to_what_is_simulated_and_not_to_its_text() {
    type Change = fn(SceneBuilder) -> SceneBuilder;
    let text = format!("{LAW}{CABLE}drive = {{ kind = \"length\", signal = \"1 mm\" }}\n{STATIC}");
    let mesh = || block(4, 1, 1, 0.04, 0.01, 0.01, Order::Linear);
    let spec = || SceneSpec::from_text(Path::new("scene.toml"), &text, "").expect("a scene");
    let of_spec = |spec: SceneSpec| SceneBuilder::new(spec).text(&text).mesh(mesh());
    let built = |change: Change| change(of_spec(spec())).build().unwrap_or_else(|e| panic!("{e}"));
    fn push(builder: SceneBuilder, force: f64) -> SceneBuilder {
        builder.effect(Box::new(Push { blocks: Blocks::new([[9_u32]].iter().map(|nodes| &nodes[..])), force }))
    }
    fn rubber(builder: SceneBuilder, nu: f64) -> SceneBuilder {
        let table = format!("law = \"neo_hookean\"\nmu = \"60 kPa\"\nnu = {nu}").parse().expect("a table");
        builder.law("rubber", move || law_from_table(&table).expect("a law"))
    }
    let others: [(Change, Change); 4] = [
        (|b| push(b, 1e-3), |b| push(b, 2e-3)),
        (|b| rubber(b, 0.45), |b| rubber(b, 0.4)),
        (|b| b.recorder(Box::new(Lift("lift_m"))), |b| b.recorder(Box::new(Lift("rise_m")))),
        (|b| b, |b| push(b, 1e-3)),
    ];
    let state_of = |scene: &Scene| {
        let mut kept = None;
        let mut saved = |checkpoint: &Checkpoint, _: &str| kept = Some(checkpoint.clone());
        let options = RunOptions { save_at: vec![0.5], on_save: Some(&mut saved), ..RunOptions::default() };
        let whole = scene.run_with(options);
        (kept.expect("saved"), whole)
    };
    let refused = |scene: &Scene, state: &Checkpoint| {
        let run = scene.run_with(RunOptions { restart: Some(state.clone()), ..RunOptions::default() });
        assert_eq!((run.status, run.rows.len()), (Status::Interrupted { t: 0.0 }, 1));
        let why = run.failure.expect("it is refused").to_string();
        assert!(why.contains("saved from another scene; restart it with the one it belongs to"), "{why}");
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("a.state");
        state.write(&file).expect("writable");
        assert!(matches!(Checkpoint::read(&file, scene), Err(CheckpointError::Elsewhere { what: "scene", .. })));
    };
    for (one, other) in others {
        let (state, whole) = state_of(&built(one));
        refused(&built(other), &state);
        let again = built(one).run_with(RunOptions { restart: Some(state), ..RunOptions::default() });
        assert!(again.status == Status::Converged && bits(&again) == bits(&whole));
    }
    let (state, whole) = state_of(&built(|b| b));
    let mut changed = spec();
    changed.laws.get_mut("rubber").expect("the law").insert("nu".into(), 0.4.into());
    refused(&of_spec(changed).build().expect("a scene"), &state);
    // The same specification in other words, and other numerics
    let mut patient = spec();
    patient.numerics.cuts += 1;
    let patient = of_spec(patient).text(format!("# in other words\n{text}")).build().expect("a scene");
    let again = patient.run_with(RunOptions { restart: Some(state), ..RunOptions::default() });
    assert!(again.status == Status::Converged && bits(&again) == bits(&whole));
}

/// Guides in a file belong to the scene, also to one that was written in Rust; a table that only `compare` reads does not. The files count as they were
/// when the scene was read.
#[test]
fn a_state_is_refused_after_a_file_of_its_scene_changed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let text = format!(
        "{LAW}{}drive = {{ kind = \"length\", signal = \"1 mm\" }}\n{STATIC}[[compare]]\ncolumn = \"cable_tension_N\"\n\
         file = \"measured.csv\"\nx = {{ column = \"t\", unit = \"s\" }}\ny = {{ column = \"F\", unit = \"N\" }}\n",
        CABLE.replace(
            r#"[["15 mm", "5 mm", "2 mm"], ["35 mm", "5 mm", "2 mm"]]"#,
            r#"{ file = "guides.csv", unit = "mm" }"#
        )
    );
    let spec = || SceneSpec::from_text(Path::new("scene.toml"), &text, "").expect("a scene");
    let parsed = || SceneBuilder::parse(&text).expect("a scene").text(&text);
    let written = || SceneBuilder::new(spec());
    for start in [&parsed as &dyn Fn() -> SceneBuilder, &written] {
        let read = || {
            let builder = start().file(folder.path().join("scene.toml"));
            builder.mesh(block(4, 1, 1, 0.04, 0.01, 0.01, Order::Linear)).build().unwrap_or_else(|e| panic!("{e}"))
        };
        is_refused_after_a_change(folder.path(), &read);
    }
}

/// With other guides, and not with another table to compare with.
fn is_refused_after_a_change(folder: &Path, read: &dyn Fn() -> Scene) {
    let put = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("writable");
    put("guides.csv", "15,5,2\n35,5,2\n");
    put("measured.csv", "t,F\n0,0\n1,1\n");
    let scene = read();
    put("guides.csv", "15,5,2\n35,5,4\n");
    put("measured.csv", "t,F\n0,0\n1,2\n");
    let file = folder.join("a.state");
    let mut saved = |checkpoint: &Checkpoint, _: &str| checkpoint.write(&file).expect("writable");
    let options = RunOptions { save_at: vec![0.5], on_save: Some(&mut saved), ..RunOptions::default() };
    scene.run_with(options);
    let error = Checkpoint::read(&file, &read()).expect_err("other guides").to_string();
    assert!(
        error.contains("saved from another scene") && error.contains("no file that the other keys name"),
        "{error}"
    );
    put("guides.csv", "15,5,2\n35,5,2\n");
    assert!(Checkpoint::read(&file, &read()).is_ok());
}

/// A formula in t is the function that it says; one in a column is that of the row before, and t that of the row itself.
#[test]
fn a_formula_follows_time_and_recorded_columns() {
    let scene = pulled(
        r#"{ kind = "tension", signal = { kind = "expression", formula = "0.1 * sin(PI * t) ^ 2", unit = "N" } }"#,
        "",
    );
    let plain = run(&scene);
    for (t, tension) in column(&plain, "t_s").into_iter().zip(column(&plain, "cable_tension_N")) {
        let exact = 0.1 * (std::f64::consts::PI * t).sin().powi(2);
        // A handful of roundings of 0.1.
        assert!((tension - exact).abs() <= 1e-16, "{t}");
    }
    let scene = pulled(
        r#"{ kind = "tension", signal = { kind = "expression", formula = "20 * t - 1000 * (xmax_z_m - 0.005)", unit = "mN" } }"#,
        "",
    );
    let fed = run(&scene);
    assert_eq!(fed.status, Status::Converged);
    let (t, z, tension) = (column(&fed, "t_s"), column(&fed, "xmax_z_m"), column(&fed, "cable_tension_N"));
    assert!((z[10] - z[0]).abs() > 1e-6, "the column moves");
    for k in 1..t.len() {
        let said = 1e-3 * (20.0 * t[k] - 1000.0 * (z[k - 1] - 0.005));
        assert_eq!(tension[k], said.max(0.0), "row {k}");
    }
}

/// Loads and cables with friction take signals that are determined during the run, as cables without and cavities do.
#[test]
fn loads_and_friction_cables_follow_inputs() {
    let formula = |gain: f64, unit: &str| {
        format!(r#"{{ kind = "expression", formula = "{gain} * (1 + 100 * (0.04 - xmax_x_m)) * t", unit = "{unit}" }}"#)
    };
    let loads = format!(
        r#"{CABLE}
friction = 0.2
drive = {{ kind = "tension", signal = {} }}
[[effect]]
kind = "point_force"
point = ["35 mm", "5 mm", "5 mm"]
radius = "5 mm"
direction = [0, 1, 0]
force = {}
[[effect]]
kind = "traction"
region = "xmax"
direction = [0, 0, 1]
traction = {}
"#,
        formula(20.0, "mN"),
        formula(3.0, "mN"),
        formula(20.0, "Pa")
    );
    let result = run(&bar(&format!("{LAW}{loads}{STATIC}")));
    assert_eq!(result.status, Status::Converged, "{}", result.status);
    let (t, x) = (column(&result, "t_s"), column(&result, "xmax_x_m"));
    assert!((x[10] - x[0]).abs() > 1e-6, "the column moves");
    let mut gains = [0.02, 0.003, 20.0];
    gains.sort_by(f64::total_cmp);
    for k in 1..t.len() {
        let mut signals = result.signals[k].clone();
        signals.sort_by(f64::total_cmp);
        for (s, gain) in signals.iter().zip(gains) {
            let said = gain * (1.0 + 100.0 * (0.04 - x[k - 1])) * t[k];
            // A handful of roundings.
            assert!((s - said).abs() <= 8.0 * f64::EPSILON * said, "row {k}: {s} is not {said}");
        }
        let pull = column(&result, "cable_tension_N")[k];
        assert!((pull - signals[1]).abs() <= 1e-8 * signals[1], "row {k}: the tolerance of Newton's method");
    }
}

/// A threshold is crossed once; from then on the other signal holds, its time counted from there.
#[test]
fn an_event_switches_a_signal() {
    let event = r#"
[[event]]
name = "enough"
when = { kind = "above", column = "cable_tension_N", value = "1 mN" }
then = [{ kind = "switch", signal = "cable_shortening_m", to = { kind = "ramp", from = "1 mm", to = "0 mm", end = "0.2 s" } }]
"#;
    let ramp = r#"{ kind = "length", signal = { kind = "ramp", from = "0 mm", to = "4 mm", end = "1 s" } }"#;
    let scene = pulled(ramp, event);
    let result = run(&scene);
    let tension = column(&result, "cable_tension_N");
    let k = tension.iter().position(|t| *t >= 1e-3).expect("it is reached");
    assert!(k > 0 && k < 7, "{k}: there is time for what follows");
    let [fired] = &result.events[..] else { panic!("{:?}", result.events) };
    assert_eq!((fired.event.as_str(), fired.t_s, fired.value), ("enough", result.rows[k][0], Some(tension[k])));
    assert_eq!(fired.did, ["switch cable_shortening_m"]);
    let d: Vec<f64> = result.signals.iter().map(|row| row[0]).collect();
    for (i, d) in d.iter().enumerate() {
        let t = result.rows[i][0];
        let exact = if i <= k { 4e-3 * t } else { 1e-3 * (1.0 - (t - fired.t_s) / 0.2).max(0.0) };
        assert!((d - exact).abs() < 1e-17, "row {i}: {d} is not {exact}");
    }
    // The rows up to the event are those of the scene without it.
    let without = run(&pulled(ramp, ""));
    for i in 0..=k {
        let close = |a: &f64, b: &f64| (a - b).abs() <= 1e-6 * b.abs().max(1e-6);
        let last = result.columns.len() - 1;
        assert!(result.rows[i][..last].iter().zip(&without.rows[i][..last]).all(|(a, b)| close(a, b)), "row {i}");
    }
}

/// Slack comes again and again; `repeat` counts each time, without it the first one only.
#[test]
fn slack_and_time_repeat_as_they_are_told() {
    let event = |name: &str, when: &str, more: &str| {
        format!("[[event]]\nname = \"{name}\"\nwhen = {when}\nthen = [{{ kind = \"save\" }}]\n{more}")
    };
    let drive =
        r#"{ kind = "length", signal = { kind = "expression", formula = "2 * sin(2 * TAU * t + 0.3)", unit = "mm" } }"#;
    let slack = "{ kind = \"slack\", cable = \"cable\" }";
    let events = [
        event("once", slack, ""),
        event("each", slack, "repeat = true\n"),
        event("clock", "{ kind = \"at\", t = \"0.25 s\", every = \"0.3 s\" }", ""),
    ]
    .concat();
    let mut labels = Vec::new();
    let mut saved = |_: &Checkpoint, label: &str| labels.push(label.to_string());
    let options = RunOptions { on_save: Some(&mut saved), ..RunOptions::default() };
    let scene = pulled(drive, &events);
    let result = scene.run_with(options);
    let tension = column(&result, "cable_tension_N");
    let becomes_slack: Vec<f64> =
        (1..tension.len()).filter(|&k| tension[k] <= 0.0 && tension[k - 1] > 0.0).map(|k| result.rows[k][0]).collect();
    let times = |name: &str| -> Vec<f64> { result.events.iter().filter(|f| f.event == name).map(|f| f.t_s).collect() };
    assert!(becomes_slack.len() >= 2, "{tension:?}");
    assert_eq!(times("each"), becomes_slack);
    assert_eq!(times("once"), becomes_slack[..1]);
    let t = column(&result, "t_s");
    // 0.25, 0.55 and 0.85 s lie within steps: their ends.
    assert_eq!(times("clock"), [t[3], t[6], t[9]]);
    let mut all: Vec<f64> = result.events.iter().map(|f| f.t_s).collect();
    all.dedup();
    // The third step ends at 0.30000000000000004 s
    let short = |t: &f64| format!("{}s", (1e9 * t).round() / 1e9);
    assert_eq!(labels, all.iter().map(short).collect::<Vec<_>>(), "one state a point");
}

/// Where steps are longer than the interval, an event is at every point; shorter ones have it at the multiples of the interval again.
#[test]
fn an_interval_that_steps_have_skipped_is_not_made_up_for() {
    let event = "[[event]]\nname = \"clock\"\nwhen = { kind = \"at\", t = \"0 s\", every = \"40 ms\" }\nthen = [{ kind = \"save\" }]\n\
                 [[stage]]\nintegrator = \"static\"\nduration = \"0.2 s\"\ndt = \"20 ms\"\n";
    let scene =
        pulled(r#"{ kind = "length", signal = { kind = "ramp", from = "0 mm", to = "2 mm", end = "1 s" } }"#, event);
    let result = run(&scene);
    let times: Vec<f64> = result.events.iter().map(|f| (1e6 * f.t_s).round() / 1e6).collect();
    let expected = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.04, 1.08, 1.12, 1.16, 1.2];
    assert_eq!(times, expected);
}

#[test]
fn an_event_stops_the_run_as_planned() {
    let event = "[[event]]\nwhen = { kind = \"below\", column = \"xmax_x_m\", value = \"39.5 mm\" }\nthen = [{ kind = \"stop\" }]\n";
    let scene =
        pulled(r#"{ kind = "length", signal = { kind = "ramp", from = "0 mm", to = "8 mm", end = "1 s" } }"#, event);
    let result = run(&scene);
    let x = column(&result, "xmax_x_m");
    let (last, before) = x.split_last().expect("rows");
    assert!(result.status == Status::Converged && *last <= 0.0395 && before.iter().all(|x| *x > 0.0395), "{x:?}");
    assert!(result.rows.len() < 11 && result.events[0].did == ["stop"]);
}

/// A constant tension crosses no threshold, and the time ends with the last stage: that is said before the run.
#[test]
fn an_event_that_cannot_happen_is_noted() {
    for (when, says) in [
        ("{ kind = \"above\", column = \"cable_tension_N\", value = \"2 N\" }", "stays between 1 and 1"),
        ("{ kind = \"below\", column = \"cable_tension_N\", value = \"2 N\" }", "stays between 1 and 1"),
        ("{ kind = \"slack\", cable = \"cable\" }", "stays between 1 and 1"),
        ("{ kind = \"above\", column = \"t_s\", value = \"2 s\" }", "t_s stays between 0 and 1"),
    ] {
        let event = format!("[[event]]\nname = \"never\"\nwhen = {when}\nthen = [{{ kind = \"stop\" }}]\n");
        let scene = pulled("{ kind = \"tension\", signal = \"1 N\" }", &event);
        let note = scene.notes.iter().find(|r| r.contains("the event \"never\" cannot happen"));
        assert!(note.is_some_and(|r| r.contains(says)), "{when}: {:?}", scene.notes);
    }
}

/// A formula without a value ends the run; what was recorded stays.
#[test]
fn a_formula_without_a_value_is_an_error_with_partial_results() {
    let formula = r#"{ kind = "length", signal = { kind = "expression", formula = "sqrt(0.0405 - xmax_x_m - 0.001 * t)", unit = "mm" } }"#;
    let result = run(&pulled(formula, ""));
    assert!(matches!(result.failure, Some(ControlError::NotFinite { .. })), "{:?}", result.failure);
    assert!(result.rows.len() > 1 && result.rows.len() < 11 && result.status.name() == "Interrupted");
    assert_eq!(result.rows.len(), result.signals.len());
}

/// The formula before an event has no value after it, and the one that follows none before: each is looked at only where it is in force.
#[test]
fn a_formula_needs_a_value_only_while_it_is_in_force() {
    let own = r#"{ kind = "expression", formula = "0.1 * t + 0 * sqrt(0.45 - t) + 0 * xmax_z_m", unit = "N" }"#;
    let other = r#"{ kind = "expression", formula = "0.02 + 0 * ln(t) + 0 * xmax_z_m", unit = "N" }"#;
    let event = |to: &str| {
        format!(
            "[[event]]\nname = \"go\"\nwhen = {{ kind = \"at\", t = \"0.4 s\" }}\n\
             then = [{{ kind = \"switch\", signal = \"cable_imposed_tension_N\", to = {to} }}]\n"
        )
    };
    let drive = format!("{{ kind = \"tension\", signal = {own} }}");
    let result = run(&pulled(&drive, &event(other)));
    assert_eq!((&result.status, &result.failure), (&Status::Converged, &None));
    let tension: Vec<f64> = result.signals.iter().map(|row| row[0]).collect();
    assert!((tension[4] - 0.04).abs() < 1e-15 && tension[5..].iter().all(|t| *t == 0.02), "{tension:?}");
    // What is in force and has no value ends the run still
    let result = run(&pulled(&drive, ""));
    assert!(matches!(result.failure, Some(ControlError::NotFinite { .. })), "{:?}", result.failure);
}

/// A cut step sees a part of the change: the input is linear within a step.
#[test]
fn a_jump_is_spread_over_the_parts_of_a_cut_step() {
    let event = r#"
[[event]]
when = { kind = "at", t = "0.5 s" }
then = [{ kind = "switch", signal = "xmax_x_displacement_m", to = "40 mm" }]
"#;
    let held = r#"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = "0 mm"
[numerics]
max_iterations = 4
line_search = false
"#;
    let scene = bar(&format!("{LAW}{STATIC}{event}{held}"));
    let result = run(&scene);
    assert_eq!(result.status, Status::Converged, "{}", result.status);
    assert!(result.totals.cuts > 0, "the jump does not pass in one step");
    let x = column(&result, "xmax_x_m");
    assert!(x[..=5].iter().all(|x| (x - 0.04).abs() < 1e-15) && (x[6] - 0.08).abs() < 1e-15, "{x:?}");
}

/// u = kp e + Σ ki e Δt in code, with its sum kept in the memory.
#[derive(Default)]
struct Pi {
    column: usize,
    sum: f64,
    begun_at: f64,
    ended: Option<String>,
}

impl Controller for Pi {
    fn begin(&mut self, opening: &Opening) -> Result<(), ControlError> {
        assert_eq!(opening.signals, ["cable_shortening_m"]);
        self.column = opening.columns.iter().position(|c| c == "xmax_x_m").expect("recorded");
        (self.begun_at, self.sum) = (opening.t, opening.memory.as_f64().unwrap_or(0.0));
        Ok(())
    }

    fn step(&mut self, observation: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        let error = observation.row[self.column] - 0.0394;
        self.sum += error * (observation.next - observation.row[0]);
        signals[0] = (0.3 * error + 8.0 * self.sum).max(0.0);
        Ok(Reply { memory: json!(self.sum), ..Reply::default() })
    }

    fn end(&mut self, row: &[f64], status: &str) {
        self.ended = Some(format!("{status} at {}", row[0]));
    }
}

#[test]
fn a_controller_reaches_its_goal_and_survives_a_restart() {
    let text = format!(
        "{LAW}{CABLE}drive = {{ kind = \"length\", signal = {{ kind = \"controlled\", initial = \"0 mm\" }} }}\n{STATIC}"
    );
    let scene = bar(&text.replace("duration = \"1 s\"", "duration = \"4 s\""));
    let mut pi = Pi::default();
    let mut middle = None;
    let mut saved = |checkpoint: &Checkpoint, _: &str| middle = Some(checkpoint.clone());
    let options = RunOptions {
        controller: Some(&mut pi),
        save_at: vec![1.5],
        on_save: Some(&mut saved),
        ..RunOptions::default()
    };
    let whole = scene.run_with(options);
    let x = column(&whole, "xmax_x_m");
    assert!((x[0] - 0.04).abs() < 1e-12 && (x[40] - 0.0394).abs() < 2e-5, "{x:?}");
    assert_eq!(pi.ended.as_deref(), Some("Converged at 4"));
    let mut pi = Pi::default();
    let options = RunOptions { restart: middle, controller: Some(&mut pi), ..RunOptions::default() };
    let again = scene.run_with(options);
    assert_eq!(pi.begun_at, whole.rows[15][0]);
    assert!(bits(&again) == bits(&whole));
}

/// Gives a memory at the first point alone.
#[derive(Default)]
struct Once {
    known: Value,
}

impl Controller for Once {
    fn begin(&mut self, opening: &Opening) -> Result<(), ControlError> {
        self.known = opening.memory.clone();
        Ok(())
    }

    fn step(&mut self, observation: &Observation, _: &mut [f64]) -> Result<Reply, ControlError> {
        let memory = if observation.row[0] == 0.0 { json!(42) } else { Value::Null };
        Ok(Reply { memory, ..Reply::default() })
    }
}

#[test]
fn a_memory_stays_until_there_is_another() {
    let text = format!(
        "{LAW}{CABLE}drive = {{ kind = \"length\", signal = {{ kind = \"controlled\", initial = \"0 mm\" }} }}\n{STATIC}"
    );
    let scene = bar(&text);
    let (mut once, mut middle) = (Once::default(), None);
    let mut saved = |checkpoint: &Checkpoint, _: &str| middle = Some(checkpoint.clone());
    let options = RunOptions {
        controller: Some(&mut once),
        save_at: vec![0.5],
        on_save: Some(&mut saved),
        ..RunOptions::default()
    };
    scene.run_with(options);
    let mut once = Once::default();
    scene.run_with(RunOptions { restart: middle, controller: Some(&mut once), ..RunOptions::default() });
    assert_eq!(once.known, json!(42));
}

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const CONTROLLED: &str =
    r#"constraint.cable.drive={ kind = "length", signal = { kind = "controlled", initial = "0 mm" } }"#;

/// `simulate` of the small scene into `out`: exit code, standard output and error.
fn simulate(out: &std::path::Path, more: &[&str]) -> (Option<i32>, String, String) {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_durometer"));
    command.args(["simulate", "tests/cli/scene.toml", "--out"]).arg(out).args(more).current_dir(ROOT);
    let output = command.output().expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

fn python_is_missing() -> bool {
    let version = std::process::Command::new("python3").arg("--version").output();
    tools::is_missing(version.is_ok_and(|o| o.status.success()), "python3")
}

#[test]
fn the_command_line_saves_and_restarts() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (whole, again) = (folder.path().join("whole"), folder.path().join("again"));
    let (code, said, error) = simulate(&whole, &["--save-state", "0.3 s", "--save-state", "end"]);
    assert_eq!(code, Some(0), "{error}");
    let state = whole.join("scene-0.5s.state");
    assert!(said.contains("scene-0.5s.state") && whole.join("scene-end.state").is_file(), "{said}");
    let (code, _, error) = simulate(&again, &["--restart", state.to_str().expect("UTF-8")]);
    assert_eq!(code, Some(0), "{error}");
    for file in ["scene.csv", "scene.signals.csv"] {
        let read = |dir: &std::path::Path| std::fs::read_to_string(dir.join(file)).expect("written");
        assert_eq!(read(&whole), read(&again), "{file}");
    }
    let (code, _, error) =
        simulate(&again, &["--restart", state.to_str().expect("UTF-8"), "--set", "laws.rubber.nu=0.4"]);
    assert!(code == Some(2) && error.contains("saved from another scene"), "{error}");
    for when in ["2 s", "0.3", "soon"] {
        let (code, _, error) = simulate(&again, &["--save-state", when]);
        assert!(code == Some(2) && error.contains("--save-state"), "{error}");
    }
}

/// The PI controller in Python that the guide shows, and its continuation from a saved state.
#[test]
fn the_python_controller_reaches_its_goal() {
    if python_is_missing() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let controller = "python3 studies/finger-control/pi.py 8 --kp 3e-5 --ki 4e-4";
    let longer = "stage.0.duration=\"6 s\"";
    let arguments = ["--set", CONTROLLED, "--set", longer, "--controller", controller];
    let whole = folder.path().join("whole");
    let (code, _, error) = simulate(&whole, &[&arguments[..], &["--save-state", "2 s"]].concat());
    assert_eq!(code, Some(0), "{error}");
    let csv = std::fs::read_to_string(whole.join("scene.csv")).expect("written");
    let last = csv.lines().last().expect("rows").split(',').nth(1).expect("the angle").parse::<f64>();
    let angle = last.expect("a number");
    println!("{angle}° of 8°");
    assert!((angle - 8.0).abs() < 0.08, "{csv}");
    let again = folder.path().join("again");
    let state = whole.join("scene-2s.state");
    let restart = ["--restart", state.to_str().expect("UTF-8")];
    let (code, _, error) = simulate(&again, &[&arguments[..], &restart].concat());
    assert_eq!(code, Some(0), "{error}");
    assert_eq!(csv, std::fs::read_to_string(again.join("scene.csv")).expect("written"));
}

/// A restart goes on under the same program alone, or under a recording that sets the same values up to there; the record names a change that was asked for.
#[test]
#[cfg(unix)]
fn a_restart_tells_controllers_apart() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let program = |value: &str| {
        let answer = format!("{{\"signals\": {{\"cable_shortening_m\": {value}}}}}");
        let text = format!("read hello\necho '{{\"ready\": true}}'\nwhile read line; do echo '{answer}'; done\n");
        std::fs::write(at("hold.sh"), text).expect("writable");
    };
    let recording = |name: &str, rows: &str| {
        std::fs::write(at(name), format!("t_s,cable_shortening_m\n{rows}")).expect("writable");
        at(name)
    };
    let command = format!("sh {}", at("hold.sh"));
    let (out, state) = (folder.path().join("out"), at("out/scene-0.5s.state"));
    let fixed = ["--set", CONTROLLED, "--no-view"];
    let by_program = ["--controller", command.as_str()];
    let restart = |more: &[&str]| simulate(&out, &[&fixed[..], &["--restart", &state], more].concat());
    let record = || {
        let text = std::fs::read_to_string(out.join("scene.json")).expect("written");
        let record: Value = serde_json::from_str(&text).expect("JSON");
        let times = record["controllers"].as_array().expect("a list").iter();
        let times: Vec<f64> = times.map(|c| c["from_t_s"].as_f64().expect("a time")).collect();
        (times, record["notes"].to_string())
    };
    program("0.001");
    let (code, _, error) = simulate(&out, &[&fixed[..], &by_program, &["--save-state", "0.5 s"]].concat());
    assert!(code == Some(0) && record().0 == [0.0], "{error}");
    let (code, _, error) = restart(&by_program);
    assert!(code == Some(0) && record().0 == [0.0], "{error}");
    let refused = |(code, _, error): (Option<i32>, String, String)| {
        assert!(code == Some(2) && error.contains("another controller has set the signals"), "{code:?} {error}");
    };
    let other = recording("other.csv", "0,0.002\n");
    let same = recording("same.csv", "0,0.001\n0.75,0.0015\n");
    let late = recording("late.csv", "0.25,0.001\n");
    [&other, &late].into_iter().for_each(|file| refused(restart(&["--replay", file.as_str()])));
    let (code, _, error) = restart(&["--replay", same.as_str()]);
    assert!(code == Some(0) && record().0 == [0.0, 0.5], "{error}");
    program("0.002");
    refused(restart(&by_program));
    for (changed, note) in [
        (&by_program[..], "from t = 0.5 s on the controlled signals are set by another controller than before"),
        (
            &["--replay", other.as_str()][..],
            "from t = 0.5 s on the controlled signals have the values of a recording of 1 row",
        ),
    ] {
        let (code, _, error) = restart(&[changed, &["--other-controller"]].concat());
        let (times, notes) = record();
        assert!(code == Some(0) && times == [0.0, 0.5] && notes.contains(note), "{error} {notes}");
    }
}

/// Garbage, silence, death, a wrong name, two answers: a message with the line, and the rows so far.
#[test]
fn a_controller_that_fails_leaves_the_rows_so_far() {
    if python_is_missing() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (k, (does, says)) in [
        ("print('hum')", "wrote at t = 0.250000 s: hum"),
        ("time.sleep(60)", "no answer within 3 s at t = 0.250000 s"),
        ("sys.exit(3)", "the controller ended (exit status: 3) before it answered at t = 0.250000 s"),
        ("print('{\"signals\": {\"cable\": 1}}')", "it may not set \"cable\"; did you mean `cable_shortening_m`?"),
        ("print('{\"signals\": {\"cable_shortening_m\": \"much\"}}')", "\"cable_shortening_m\" is \"much\""),
        ("print('{\"signal\": {}}')", "unknown field `signal`"),
        ("print('[]')", "that is no answer: it is no object"),
        (
            "print('{\"signals\": {\"cable_shortening_m\": 0.001, \"cable_shortening_m\": 0.002}}')",
            "that is no answer: the key \"cable_shortening_m\" occurs twice",
        ),
        (
            "print('{}\\n{\"signals\": {}}', flush=True)\nsys.stdin.readline()",
            "wrote at t = 0.500000 s: {\"signals\": {}}\n  nothing had asked for this line",
        ),
    ]
    .into_iter()
    .enumerate()
    {
        let script = folder.path().join("ctrl.py");
        let text = format!(
            "import sys, time\nsys.stdin.readline()\nprint('{{\"ready\": true}}', flush=True)\nsys.stdin.readline()\n\
             print('{{}}', flush=True)\nsys.stdin.readline()\n{does}\nsys.stdout.flush()\n"
        );
        std::fs::write(&script, text).expect("writable");
        let out = folder.path().join(k.to_string());
        let command = format!("python3 -S '{}'", script.display());
        let (code, _, error) =
            simulate(&out, &["--set", CONTROLLED, "--controller", &command, "--controller-timeout", "3 s"]);
        assert_eq!(code, Some(3), "{does}: {error}");
        assert!(error.contains(says), "{does}: {error}");
        let csv = std::fs::read_to_string(out.join("scene.csv")).expect("partial results");
        let steps = 1 + usize::from(does.contains("\\n{"));
        assert_eq!(csv.lines().count(), 2 + steps, "{does}: header, the state at rest and the steps");
    }
    for (arguments, says) in [
        (&["--set", CONTROLLED][..], "waits for a controller"),
        (&["--set", CONTROLLED, "--controller", "no-such-program-here"], "cannot be started"),
        (&["--set", CONTROLLED, "--controller", "python3 'a"], "its quotes do not close"),
        (&["--set", CONTROLLED, "--controller", "cat", "--controller-timeout", "soon"], "is no time"),
        (&["--controller", "cat"], "leaves no signal to a controller"),
    ] {
        let (code, _, error) = simulate(folder.path(), arguments);
        assert!(code == Some(2) && error.contains(says), "{arguments:?}: {error}");
    }
}

/// Uniaxial tension with free sides: one stress everywhere, in closed form for the law.
#[test]
fn fields_hold_the_stress_of_the_closed_form() {
    use durometer::scene::output::FieldSpec;
    let text = format!(
        "{}{STATIC}{}",
        LAW.replace("kind = \"fixed\"\nregion = \"xmin\"", "kind = \"fixed\"\nregion = \"xmin\"\ncomponents = \"x\""),
        r#"
[[constraint]]
kind = "fixed"
region = "ymin"
components = "y"
[[constraint]]
kind = "fixed"
region = "zmin"
components = "z"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = { kind = "ramp", from = "0 mm", to = "20 mm", end = "1 s" }
"#
    );
    let scene = bar(&text);
    let result = run(&scene);
    let fields = scene.fields(&result.last, &[FieldSpec::Stress, FieldSpec::VonMises, FieldSpec::Pressure]);
    // λ = 1.5; the lateral stretch l from zero lateral stress: μ (l² − 1) + λ_L ln J = 0, then σ = μ (λ² − 1)/J + λ_L ln J/J.
    let (mu, nu, stretch) = (60e3, 0.45, 1.5f64);
    let lame = 2.0 * mu * nu / (1.0 - 2.0 * nu);
    let (mut low, mut high) = (0.5f64, 1.0f64);
    for _ in 0..80 {
        let l = 0.5 * (low + high);
        if mu * (l * l - 1.0) + lame * (stretch * l * l).ln() > 0.0 { high = l } else { low = l }
    }
    let j = stretch * low * low;
    let sigma = (mu * (stretch * stretch - 1.0) + lame * j.ln()) / j;
    for field in &fields {
        let exact = |component: usize| match field.name {
            "stress_Pa" => {
                if component == 0 {
                    sigma
                } else {
                    0.0
                }
            }
            "von_mises_Pa" => sigma,
            _ => -sigma / 3.0,
        };
        assert!(field.components == if field.name == "stress_Pa" { 9 } else { 1 });
        for (i, value) in field.values.iter().enumerate() {
            // Newton's tolerance is 1e-8 of the forces; K is conditioned by 1/(1 − 2ν) and the mesh, a hundred at most.
            assert!((value - exact(i % field.components)).abs() < 1e-6 * sigma, "{}: {value}", field.name);
        }
    }
    assert_eq!(fields.len(), 6, "at the nodes and in the cells");
}

/// The table that the run itself recorded lies on its curve; 5 % more of it is 5 % off in both norms.
#[test]
fn a_measured_curve_is_compared() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (code, _, error) = simulate(folder.path(), &[]);
    assert_eq!(code, Some(0), "{error}");
    let csv = std::fs::read_to_string(folder.path().join("scene.csv")).expect("written");
    let mut rows = csv.lines();
    let names: Vec<&str> = rows.next().expect("a header").split(',').collect();
    let place = names.iter().position(|n| *n == "cable_tension_N").expect("recorded");
    let mut table = "time,force\n".to_string();
    for row in rows {
        let cells: Vec<f64> = row.split(',').map(|v| v.parse().expect("a number")).collect();
        table += &format!("{},{}\n", 1e3 * cells[0], 1.05 * 1e3 * cells[place]);
    }
    let measured = folder.path().join("measured.csv");
    std::fs::write(&measured, table).expect("writable");
    let compare = format!(
        "compare=[{{ column = \"cable_tension_N\", file = '{}', x = {{ column = \"time\", unit = \"ms\" }}, \
         y = {{ column = \"force\", unit = \"mN\" }} }}]",
        measured.display()
    );
    let (code, said, error) = simulate(folder.path(), &["--set", &compare]);
    assert_eq!(code, Some(0), "{error}");
    // 1/1.05 − 1 = −4.76 %
    assert!(said.contains("4.76 % (L2), 4.76 % (largest) at ") && said.contains(" points, 0 to "), "{said}");
    for extension in ["svg", "png", "pdf"] {
        assert!(folder.path().join(format!("scene-compare-1.{extension}")).is_file());
    }
}
