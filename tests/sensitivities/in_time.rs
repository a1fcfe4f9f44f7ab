//! Derivatives by the constants of laws through time steps: every law, formulation and integrator, cables, what relaxes and
//! what damps, on blocks of 18 cells, every row against differences of whole runs (`common/sensitivities.rs`). The beams bend easily
//! compared with the block forces that the residual is compared with, so the runs take full Newton steps, whose last one leaves far
//! less than the tolerance.

use crate::common;
use crate::common::sensitivities::{check, sensitivities};
use crate::common::{column, example_table};
use durometer::material::LAWS;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{ParameterKey, Progress, RunOptions, Scene, SensitivityRecorder};
use durometer::solve::Status;
use toml::Table;

/// What is pulled: shortened, let go beyond its length, shortened again.
const PULL_AND_RELEASE: &str = r#"{ kind = "length", signal = { kind = "sum", of = [
    { kind = "ramp", from = "0 mm", to = "2 mm", end = "10 ms" },
    { kind = "ramp", from = "0 mm", to = "-3.5 mm", start = "10 ms", end = "20 ms" },
    { kind = "ramp", from = "0 mm", to = "4 mm", start = "20 ms", end = "35 ms" }] } }"#;
const LENGTH: &str = r#"{ kind = "length", signal = { kind = "ramp", from = "0 mm", to = "3 mm", end = "20 ms" } }"#;
const TENSION: &str = r#"{ kind = "tension", signal = { kind = "ramp", from = "0 N", to = "0.3 N", end = "20 ms" } }"#;
const RELAXING: &str = r#"
[[effect]]
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "MODULI"
prony = [{ g = 0.3, tau = "8 ms" }, { g = 0.2, tau = "60 ms" }]
"#;
const SOFTENING: &str = r#"
[[effect]]
kind = "mullins"
region = "body"
law = "rubber"
softening = { r = 2, m = "50 Pa", beta = 0.1 }
"#;
/// Up to a peak and most of the way back.
const HALF_WAVE: &str =
    r#"{ kind = "length", signal = { kind = "raised_cosine", amplitude = "3 mm", frequency = "25 Hz" } }"#;
const STATIC: &str = "\"static\"";

/// A beam of 30 mm under gravity and a cable; stages of (integrator, steps of 5 ms).
struct Beam {
    order: Order,
    formulation: &'static str,
    drive: &'static str,
    stages: Vec<(&'static str, usize)>,
    /// Effects in addition to elasticity, inertia and gravity
    effects: String,
}

impl Beam {
    fn build(&self, law: &Table) -> Scene {
        let dynamic = self.stages.iter().any(|s| s.0 != STATIC);
        let inertia =
            "[[effect]]\nkind = \"inertia\"\nregion = \"body\"\ndensity = \"1100 kg/m^3\"\nmass = \"consistent\"\n";
        let stage = |(integrator, steps): &(&str, usize)| {
            format!("[[stage]]\nintegrator = {integrator}\nduration = \"{} ms\"\ndt = \"5 ms\"\n", 5 * steps)
        };
        let text = format!(
            r#"
[mesh]
body = "block"
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "{}"
[[effect]]
kind = "gravity"
region = "body"
density = "1100 kg/m^3"
direction = [0, 1, -2]
acceleration = "9.81 m/s^2"
{}{}
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["12 mm", "5 mm", "8 mm"], ["27 mm", "5 mm", "7 mm"]]
pull_point = ["-6 mm", "5 mm", "8 mm"]
guide_radius = "point"
drive = {}
{}
[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
[[probe]]
kind = "position"
region = "xmax"
[[probe]]
kind = "reaction"
region = "xmin"
[[probe]]
kind = "energy"
[numerics]
tolerance = 1e-12
reuse_factor = false
[laws.rubber]
{law}"#,
            self.formulation,
            if dynamic { inertia } else { "" },
            self.effects,
            self.drive,
            self.stages.iter().map(stage).collect::<String>(),
        );
        common::scene(block(3, 1, 1, 0.03, 0.01, 0.01, self.order), &text)
    }

    fn check(&self, law: &Table) -> f64 {
        let label = format!("{}, {:?} {}, {:?}", law["law"], self.order, self.formulation, self.stages);
        let worst = check(&label, law, &|law| self.build(law));
        println!("{label}: {worst:.1e}");
        worst
    }
}

fn beam(drive: &'static str, stages: &[(&'static str, usize)]) -> Beam {
    Beam { order: Order::Linear, formulation: "displacement", drive, stages: stages.to_vec(), effects: String::new() }
}

/// With ν in the place of κ.
fn by_nu(name: &str) -> Table {
    let mut table = example_table(name);
    if table.remove("kappa").is_some() {
        table.insert("nu".into(), 0.45.into());
    }
    table
}

/// Every constant of every law, in all effects that take it: elastic, viscoelastic where the law has an isochoric part, both
/// stiffness dampings.
#[test]
fn every_constant_of_every_law() {
    let damping = |kind: &str| {
        format!(
            "[[effect]]\nkind = \"stiffness_damping\"\nregion = \"body\"\nbeta = \"1 ms\"\nstiffness = \"{kind}\"\n"
        )
    };
    for entry in LAWS {
        let relaxing = if entry.info.isochoric { RELAXING.replace("MODULI", "long_term") } else { String::new() };
        let effects = relaxing + &damping("initial") + &damping("last");
        Beam { effects, ..beam(LENGTH, &[("\"bdf2\"", 4)]) }.check(&example_table(entry.info.name));
    }
}

/// Every formulation, statically and then with a start from rest under load: the initial acceleration has a derivative too.
#[test]
fn every_formulation() {
    let stages = [(STATIC, 2), ("{ kind = \"generalised_alpha\", rho = 0.7 }", 3)];
    for (order, formulation) in [
        (Order::Linear, "displacement"),
        (Order::Quadratic, "displacement"),
        (Order::Linear, "mixed"),
        (Order::Quadratic, "mixed"),
        (Order::Quadratic, "mean_dilatation"),
    ] {
        Beam { order, formulation, ..beam(LENGTH, &stages) }.check(&by_nu("yeoh"));
    }
}

/// What softens, with every constant of every law that can: loaded, unloaded and loaded again, in statics and in dynamics.
#[test]
fn what_softens() {
    for entry in LAWS.iter().filter(|entry| entry.info.isochoric) {
        Beam { effects: SOFTENING.into(), ..beam(HALF_WAVE, &[(STATIC, 9)]) }.check(&example_table(entry.info.name));
    }
    let (effects, stages) = (SOFTENING.to_string(), [("\"implicit_euler\"", 4), (STATIC, 3)]);
    Beam { order: Order::Quadratic, formulation: "mixed", effects, ..beam(HALF_WAVE, &stages) }.check(&by_nu("yeoh"));
}

/// Every integrator, by itself and after another one, whose rates it takes over; the cable by tension and by length.
#[test]
fn every_integrator() {
    for integrator in [
        STATIC,
        "\"implicit_euler\"",
        "\"bdf2\"",
        "{ kind = \"generalised_alpha\", rho = 0.8 }",
        "{ kind = \"newmark\", beta = 0.25, gamma = 0.5, force = true }",
    ] {
        for drive in [TENSION, LENGTH] {
            beam(drive, &[("\"implicit_euler\"", 2), (integrator, 4)]).check(&by_nu("neo_hookean"));
        }
    }
}

/// The cable goes slack in the middle of the run and is taut again at its end.
#[test]
fn a_cable_that_goes_slack() {
    for stages in [[("\"bdf2\"", 7)], [("\"implicit_euler\"", 7)]] {
        let beam = beam(PULL_AND_RELEASE, &stages);
        let tension = column(&common::run(&beam.build(&by_nu("neo_hookean"))), "cable_tension_N");
        assert!(tension[2] > 0.0 && tension[4] == 0.0 && tension[7] > 0.0, "{tension:?}");
        beam.check(&by_nu("neo_hookean"));
    }
}

/// What relaxes, under both meanings of the constants and through a static stage, in formulations with a pressure; every kind
/// of damping.
#[test]
fn what_remembers_and_what_damps() {
    let stages = [("\"bdf2\"", 3), (STATIC, 1), ("{ kind = \"generalised_alpha\", rho = 0.5 }", 3)];
    for (order, formulation) in [(Order::Linear, "displacement"), (Order::Quadratic, "mixed")] {
        for moduli in ["long_term", "instantaneous"] {
            let effects = RELAXING.replace("MODULI", moduli);
            Beam { order, formulation, effects, ..beam(LENGTH, &stages) }.check(&by_nu("mooney_rivlin"));
        }
    }
    // What relaxes from a strain on that is there at the start
    let bent =
        "[[constraint]]\nkind = \"prescribed\"\nregion = \"xmax\"\ncomponents = \"z\"\ndisplacement = \"-2 mm\"\n";
    let effects = format!("{}{bent}", RELAXING.replace("MODULI", "long_term"));
    let stages_in_time = [stages[0], stages[2]];
    Beam { effects, ..beam(LENGTH, &stages_in_time) }.check(&by_nu("mooney_rivlin"));
    let effects = r#"
[[effect]]
kind = "mass_damping"
region = "body"
density = "1100 kg/m^3"
mass = "lumped"
alpha = "20 /s"
[[effect]]
kind = "viscous_damping"
region = "body"
eta = "100 Pa s"
[[effect]]
kind = "edge_dampers"
region = "body"
damping = "0.02 N s/m"
"#;
    Beam { effects: effects.into(), ..beam(LENGTH, &stages) }.check(&by_nu("gent"));
}

/// A step costs one factorisation, a solve for each constant and one for each row; a tangent that does not change is
/// factorised once, and steps between the rows of a static stage cost nothing.
#[test]
fn what_the_derivatives_cost() {
    let keys: Vec<String> = ["C10", "C20", "C30", "nu"].map(String::from).to_vec();
    let (run, cost) = sensitivities(&beam(LENGTH, &[("\"bdf2\"", 6)]).build(&by_nu("yeoh")), &keys);
    assert_eq!((run.totals.steps, cost.factorisations, cost.solves), (6, 6, 6 * (4 + 1)));
    assert!(cost.solves * 2 <= 3 * keys.len() * run.totals.steps, "1.5 solves for each constant");

    let constant = LENGTH.replace("length", "tension").replace("3 mm", "0 N").replace("0 mm", "0 N");
    let linear = Beam { drive: constant.leak(), ..beam(LENGTH, &[(STATIC, 4)]) }.build(&example_table("linear"));
    let (_, cost) = sensitivities(&linear, &["E".into(), "nu".into()]);
    assert_eq!((cost.factorisations, cost.solves), (1, 4 * 2));
}

/// A run that is stopped, and one that cannot go on, have sensitivities for the rows there are.
#[test]
fn rows_so_far() {
    let constants: Vec<ParameterKey> = vec!["laws.rubber.mu".parse().expect("a name")];
    let mut law = by_nu("neo_hookean");
    law.remove("E");
    law.insert("mu".into(), "30 kPa".into());
    let scene = beam(LENGTH, &[("\"bdf2\"", 6)]).build(&law);
    let run_until = |scene: &Scene, end: f64| {
        let recorder = SensitivityRecorder::new(scene, &constants).unwrap_or_else(|e| panic!("{e}"));
        let mut on_progress = |p: Progress| p.t < end;
        let (on_progress, sensitivities) = (Some(&mut on_progress as _), Some(recorder));
        let mut run = scene.run_with(RunOptions { on_progress, sensitivities, ..RunOptions::default() });
        let sensitivities = run.sensitivities.take().expect("the options ask for them");
        (run, sensitivities)
    };
    let (run, cut) = run_until(&scene, 0.014);
    assert!(matches!(run.status, Status::Interrupted { .. }), "{}", run.status);
    assert_eq!((run.rows.len(), cut.rows.len(), &cut.stopped), (4, 4, &None));
    let (_, whole) = run_until(&scene, f64::INFINITY);
    assert_eq!(whole.rows[..4], cut.rows[..], "the same bits");

    const FAR: &str = r#"{ kind = "length", signal = { kind = "ramp", from = "0 mm", to = "33 mm", end = "20 ms" } }"#;
    let (run, cut) = run_until(&beam(FAR, &[(STATIC, 4)]).build(&law), f64::INFINITY);
    assert_ne!(run.status, Status::Converged);
    assert!(cut.rows.len() == run.rows.len() && cut.stopped.is_none(), "{} rows", cut.rows.len());
}
