//! The solver where it is hard: bodies that nothing holds, limit points, unstable equilibria, crumpled starts, and every
//! end a run can have.

use crate::common;
use crate::common::{DeadLoad, elastic, hold, law, newton, nodes, ramp, scene};
use durometer::effect::EdgeSprings;
use durometer::math::signal::Signal;
use durometer::math::statistics::larger;
use durometer::math::stopwatch::Spent;
use durometer::math::tensor::Vec3;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::solve::{
    AcceptedStep, Driver, Failure, Integrator, NewtonSettings, NonlinearSolver, Status, Step, StepSettings, TimeSpan,
    free_motions,
};
use durometer::system::{Effect, Prescribed, System};
use std::collections::BTreeMap;

/// What nothing holds of a block, in the words of the status.
fn free(mesh: &TetMesh, held: Vec<Prescribed>) -> String {
    let effects = vec![elastic(mesh, law("neo_hookean", 1e5, 0.45))];
    let system = System::new(mesh.points.len(), effects, vec![], held).expect("a system");
    let rest = system.rest();
    let step = Step { system: &system, integrator: Integrator::Static, past: &rest, dt: 1.0 };
    let motions = free_motions(&mut newton(&system, 1e-8, mesh.diagonal()), &step, &rest, &mesh.points);
    if motions.is_empty() { String::new() } else { Status::Singular { t: 0.0, motions }.fact() }
}

/// Every direction that a fixture leaves free, by hand.
#[test]
fn rigid_motions_are_named() {
    for order in common::ORDERS {
        // Twice as long as wide, so that an edge, a diagonal and a face differ.
        let mesh = block(2, 2, 1, 0.02, 0.02, 0.01, order);
        let at = |wanted: [f64; 3]| {
            let near = |p: &Vec3| (p - Vec3::from(wanted)).norm() < 1e-9;
            mesh.points.iter().position(near).expect("a node there") as u32
        };
        let (origin, sideways, across) = (at([0.0; 3]), at([0.0, 0.02, 0.0]), at([0.02, 0.02, 0.0]));
        let face = |name: &str, components: &[u32]| hold(&nodes(&mesh, name), components);
        let all = [0, 1, 2];
        for (held, words) in [
            (vec![], "it can translate in x, y and z and rotate about x, y and z"),
            (face("xmin", &[0]), "it can translate in y and z and rotate about x"),
            // u = e_y × (x − o) has no y, and no z on the face, if the axis lies in it
            (face("xmin", &[1, 2]), "it can translate in x and rotate about y and z"),
            ([face("xmin", &[0]), face("ymin", &[1])].concat(), "it can translate in z"),
            (hold(&[origin], &all), "it can rotate about x, y and z"),
            (hold(&[origin, sideways], &all), "it can rotate about y"),
            (hold(&[origin, across], &all), "it can rotate about (0.71, 0.71, 0.00)"),
            // A hinge that slides: held across its axis only
            (hold(&[origin, sideways], &[0, 2]), "it can translate in y and rotate about y"),
        ] {
            assert_eq!(free(&mesh, held), format!("nothing holds the body: {words}"), "{order:?}");
        }
        assert_eq!(free(&mesh, face("xmin", &all)), "", "{order:?}: a clamped body is held");
        assert_eq!(free(&mesh, hold(&[origin, sideways, across], &all)), "", "{order:?}: three points hold a body");
    }
}

/// Two blocks, one of them clamped: the other is named by one of its nodes.
#[test]
fn a_loose_part_is_named() {
    let one = block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear);
    let n = one.points.len() as u32;
    let mut two = one.clone();
    two.points.extend(one.points.iter().map(|p| p + Vec3::new(0.05, 0.0, 0.0)));
    two.cells.extend(one.cells.iter().map(|k| k + n));
    two.regions.get_mut("body").expect("all cells").cells = (0..two.cell_count() as u32).collect();
    let held = hold(&nodes(&one, "xmin"), &[0, 1, 2]);
    let words = free(&two, held);
    assert_eq!(words, "nothing holds the part at node 8: it can translate in x, y and z and rotate about x, y and z");
}

/// Two bars in a line: the node between them has no stiffness across. No rigid motion, but a mechanism.
#[test]
fn a_mechanism_is_named_by_its_node() {
    let points: Vec<Vec3> = [0.0, 0.1, 0.2].map(|x| Vec3::new(x, 0.0, 0.0)).into();
    let springs: Box<dyn Effect> = Box::new(EdgeSprings::between(&points, &[[0, 1], [1, 2]], 50.0));
    let mut held = hold(&[0, 2], &[0, 1, 2]);
    held.extend(hold(&[1], &[2]));
    let system = System::new(3, vec![springs], vec![], held).expect("a system");
    let rest = system.rest();
    let step = Step { system: &system, integrator: Integrator::Static, past: &rest, dt: 1.0 };
    let motions = free_motions(&mut newton(&system, 1e-8, 0.2), &step, &rest, &points);
    let fact = Status::Singular { t: 0.0, motions }.fact();
    assert_eq!(fact, "node 1 can move along y without resistance: the parts around it form a mechanism");
}

/// Half-span, height and stiffness of each of the two bars of a truss.
const TRUSS: (f64, f64, f64) = (0.1, 0.015, 2e3);

fn truss() -> TetMesh {
    let (a, h, _) = TRUSS;
    let points = vec![Vec3::new(-a, 0.0, 0.0), Vec3::new(a, 0.0, 0.0), Vec3::new(0.0, 0.0, h)];
    TetMesh { order: Order::Linear, points, cells: vec![], facets: vec![], regions: BTreeMap::new() }
}

/// P(w) = 2EA(h − w)(1/l − 1/l₀), EA = k l₀.
fn by_hand(w: f64) -> f64 {
    let (a, h, k) = TRUSS;
    let rest = a.hypot(h);
    2.0 * k * rest * (h - w) * (1.0 / a.hypot(h - w) - 1.0 / rest)
}

/// Its maximum: dP/dw = 0 where l³ = a² l₀.
fn largest_load() -> f64 {
    let (a, h, _) = TRUSS;
    let l = (a * a * a.hypot(h)).cbrt();
    by_hand(h - (l * l - a * a).sqrt())
}

/// The truss under a force at its apex that grows to `load` by t = 1, and below 0 before t = 0.
fn loaded_truss(load: f64) -> System {
    let (_, _, k) = TRUSS;
    let mesh = truss();
    let springs: Box<dyn Effect> = Box::new(EdgeSprings::between(&mesh.points, &[[0, 2], [1, 2]], k));
    let signal = Signal::Continued { signal: Box::new(ramp(load)), from: 0.0, to: 1.0, before: load, after: load };
    let force = DeadLoad::new(&[Vec3::zeros(), Vec3::zeros(), Vec3::new(0.0, 0.0, -1.0)], signal);
    let mut held = hold(&[0, 1], &[0, 1, 2]);
    held.extend(hold(&[2], &[1]));
    System::new(3, vec![springs, Box::new(force)], vec![], held).expect("a system")
}

/// Loads that grow until t = 1 and then stay: the path ends there, and the reason is theirs, not that of the bars.
#[test]
fn arc_length_says_where_the_loads_no_longer_change() {
    let mut system = loaded_truss(0.0);
    let force = Vec3::new(0.0, 0.0, -0.5 * largest_load());
    system.effects[1] = Box::new(DeadLoad::new(&[Vec3::zeros(), Vec3::zeros(), force], ramp(1.0)));
    let mut driver = Driver::new(&system, newton(&system, 1e-10, truss().diagonal()), StepSettings::default());
    let mut state = system.rest();
    let span = TimeSpan { integrator: Integrator::ArcLength { max_steps: 200 }, start: 0.0, end: 2.0, dt: 0.05 };
    let status = driver.run(span, &mut state, &mut ());
    let Status::StepTooSmall { t, why: Failure::Unloaded, .. } = &status else { panic!("{status:?}") };
    // By less than a step the last one may go beyond.
    assert!((t - 1.0).abs() <= span.dt, "{status}");
    assert!(status.to_string().contains("the loads do not change there"), "{status}");
}

/// Arc length: up to the limit point, down through zero to the other one, and up to the whole load, all on
/// P(w) to the tolerance of the solve (1e-10 of the forces in the bars, which are ten times P).
#[test]
fn arc_length_follows_the_truss_through_its_snap() {
    let top = largest_load();
    let load = 1.5 * top;
    let (mesh, system) = (truss(), loaded_truss(load));
    let mut driver = Driver::new(&system, newton(&system, 1e-10, mesh.diagonal()), StepSettings::default());
    let (mut state, mut curve) = (system.rest(), vec![]);
    let span = TimeSpan { integrator: Integrator::ArcLength { max_steps: 200 }, start: 0.0, end: 1.0, dt: 0.05 };
    let status = driver.run(span, &mut state, &mut |step: &AcceptedStep| {
        let AcceptedStep { now, .. } = *step;
        curve.push((-now.x[8], load * now.t));
        true
    });
    assert_eq!(status, Status::Converged);
    let off = curve.iter().map(|(w, p)| (p - by_hand(*w)).abs() / top).fold(0.0, larger);
    let turns = &driver.findings.turning_points;
    let found: Vec<f64> = turns.iter().map(|p| load * p.t / top).collect();
    println!("truss: {} points, off by {off:.1e}, limit loads over the exact ones {found:?}", curve.len());
    assert!(off < 1e-8, "{off:e}");
    assert_eq!(turns.iter().map(|p| (p.highest, p.node)).collect::<Vec<_>>(), [(true, 2), (false, 2)]);
    // The parabola is off by the third power of the step, the load at its top by the square of that.
    assert!((found[0] - 1.0).abs() < 1e-3 && (found[1] + 1.0).abs() < 1e-3, "{found:?}");
    assert_eq!(curve.last().map(|c| c.1), Some(load), "the whole load is on");
    assert!(curve.last().is_some_and(|c| c.0 > 2.0 * TRUSS.1), "on the other side");
    assert!(curve.iter().any(|(_, p)| *p < -0.9 * top));
    // Between the limit points the equilibrium is unstable, outside it is not.
    assert_eq!(driver.findings.unstable.iter().map(|u| u.1).collect::<Vec<_>>(), [1, 0]);
}

/// Too few steps: the limit point is stated.
#[test]
fn a_path_that_does_not_arrive_states_its_limit_point() {
    let (top, mesh) = (largest_load(), truss());
    let system = loaded_truss(1.5 * top);
    let mut driver = Driver::new(&system, newton(&system, 1e-10, mesh.diagonal()), StepSettings::default());
    let mut state = system.rest();
    let span = TimeSpan { integrator: Integrator::ArcLength { max_steps: 12 }, start: 0.0, end: 1.0, dt: 0.05 };
    let status = driver.run(span, &mut state, &mut ());
    let Status::LimitPoint { limit, .. } = status else { panic!("{status}") };
    assert!((1.5 * limit - 1.0).abs() < 1e-3, "{limit}");
}

/// Under the force alone a step beyond the limit point would snap to the other side, where there is an equilibrium too: that is
/// no equilibrium of this path. The largest load is stated, and the last good state lies before it. With small steps, and with
/// one that is as large as the load.
#[test]
fn a_limit_point_under_force_is_stated() {
    let (top, mesh) = (largest_load(), truss());
    for (dt, projection) in [(0.1, false), (1.0, false), (0.1, true)] {
        let system = loaded_truss(1.5 * top);
        let settings = NewtonSettings { tolerance: 1e-10, projection, ..NewtonSettings::default() };
        let newton = NonlinearSolver::new(&system, settings, mesh.diagonal());
        let mut driver = Driver::new(&system, newton, StepSettings::default());
        let mut state = system.rest();
        let span = TimeSpan { integrator: Integrator::Static, start: 0.0, end: 1.0, dt };
        let status = driver.run(span, &mut state, &mut ());
        println!("truss under force, dt = {dt}: {status}; {:?}", driver.totals);
        let Status::NoEquilibrium { t, limit, node: 2, in_contact: false, by_force: true } = status else {
            panic!("{status}")
        };
        // As by arc length
        assert!(
            (1.5 * limit - 1.0).abs() < 1e-3 && t <= limit && limit - t < dt && -state.x[8] < TRUSS.1,
            "{t} {limit}"
        );
    }
}

/// Two springs k in a line, held across by two soft ones c: K_yy = 2N/l + …, so the line would buckle at N = −c l, long before
/// the end, but is in equilibrium where it is. Noted by the step after at the latest: the tangent of a step is one of its start.
#[test]
fn an_unstable_equilibrium_is_noted() {
    let places = [[0.0, 0.0], [0.1, 0.0], [0.2, 0.0], [0.1, 0.1], [0.1, -0.1]];
    let points: Vec<Vec3> = places.map(|[x, y]| Vec3::new(x, y, 0.0)).into();
    let effects: Vec<Box<dyn Effect>> = vec![
        Box::new(EdgeSprings::between(&points, &[[0, 1], [1, 2]], 50.0)),
        Box::new(EdgeSprings::between(&points, &[[1, 3], [1, 4]], 1.0)),
    ];
    let mut held = hold(&[0, 3, 4], &[0, 1, 2]);
    held.extend(hold(&[2], &[1, 2]));
    held.extend(hold(&[1], &[2]));
    held.push(Prescribed { dof: 6, signal: ramp(-0.02) });
    let system = System::new(5, effects, vec![], held).expect("a system");
    let mut driver = Driver::new(&system, newton(&system, 1e-10, 0.2), StepSettings::default());
    let mut state = system.rest();
    let span = TimeSpan { integrator: Integrator::Static, start: 0.0, end: 1.0, dt: 0.25 };
    assert_eq!(driver.run(span, &mut state, &mut ()), Status::Converged);
    assert_eq!(state.x[4], 0.0, "it stays straight");
    let [(t, 1)] = driver.findings.unstable[..] else { panic!("{:?}", driver.findings) };
    assert!(t <= 0.5 && driver.totals.unstable >= 3, "{t} {:?}", driver.totals);
}

/// A cube of 2³ boxes, clamped at one face, thrown into disorder and let go.
fn crumpled(start: &str, numerics: &str) -> String {
    format!(
        r#"
[mesh]
body = "cube"
[laws.rubber]
law = "stable_neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "inertia"
region = "body"
density = "1000 kg/m^3"
mass = "lumped"
[[effect]]
kind = "mass_damping"
region = "body"
density = "1000 kg/m^3"
mass = "lumped"
alpha = "10 1/s"
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "implicit_euler"
duration = "6 s"
dt = "0.2 s"
{start}
{numerics}
"#
    )
}

/// Largest distance from rest at the end, over the side of the cube; NaN counts as far away.
fn left_over(start: &str, numerics: &str) -> f64 {
    let scene = scene(block(2, 2, 2, 1.0, 1.0, 1.0, Order::Linear), &crumpled(start, numerics));
    let run = common::run(&scene);
    if run.status != Status::Converged {
        return f64::INFINITY;
    }
    let most = common::largest(&run.last.x);
    if most.is_nan() { f64::INFINITY } else { most }
}

/// Every free node anywhere in a cube of twice the side.
fn random_start(seed: u64) -> String {
    format!("[start]\nkind = \"random\"\nsize = \"1 m\"\nseed = {seed}")
}

/// 100 seeds with every free node anywhere in a cube of twice the side; 99 at least are at rest to 1e-6 L. At
/// ν = 0.45 half of them end in equilibria of this mesh that are stable though cells are inverted: no solver leaves those.
#[test]
fn a_body_comes_back_from_a_random_start() {
    let left: Vec<f64> = (0..100).map(|seed| left_over(&random_start(seed), "")).collect();
    let back = left.iter().filter(|l| **l <= 1e-6).count();
    println!("random start: {back} of 100 seeds at rest");
    assert!(back >= 99, "{back} of 100: {left:?}");
}

/// Collapsed to a point, a line, a plane (off by 1 % of the side, since the collapsed state itself is a saddle), and twisted by
/// two turns and a half.
#[test]
fn a_body_comes_back_from_collapse_and_twist() {
    for keep in ["", "x", "xy"] {
        let left = left_over(
            &format!("[start]\nkind = \"collapsed\"\nkeep = \"{keep}\"\nperturbation = \"10 mm\"\nseed = 3"),
            "",
        );
        assert!(left <= 1e-6, "keep = \"{keep}\": {left:e}");
    }
    let left = left_over("[start]\nkind = \"twisted\"\naxis = [1, 0, 0]\nangle = \"900 deg\"", "");
    assert!(left <= 1e-6, "twisted: {left:e}");
}

/// A law that ends at J = 0 refuses such a start where the scene is read.
#[test]
fn a_start_that_the_law_does_not_survive_is_refused() {
    let text = crumpled("[start]\nkind = \"random\"\nsize = \"1 m\"", "").replace("stable_neo_hookean", "neo_hookean");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, &text).expect("a temporary file");
    let (spec, text) = durometer::scene::read_scene(&file, &[]).expect("the file itself is fine");
    let mesh = block(1, 1, 1, 1.0, 1.0, 1.0, Order::Linear);
    let (source, sha256, notes) = ("block".into(), String::new(), Vec::new());
    let body = durometer::scene::Body { source, sha256, notes, ..durometer::scene::Body::of_mesh(mesh) };
    let refusal = durometer::scene::Scene::build(&file, spec, text, body.into()).err().expect("refused").to_string();
    assert!(
        refusal.ends_with(
            "start: the start inverts cells, where the law neo_hookean is not defined; take stable_neo_hookean"
        ),
        "{refusal}"
    );
}

/// The budget stops a run, keeps what is there, and changes nothing of what was accepted.
#[test]
fn a_time_budget_stops_the_run_and_changes_no_number() {
    let start = "[start]\nkind = \"random\"\nsize = \"0.6 m\"\nseed = 5";
    let run = |numerics: &str| {
        let scene = scene(block(2, 2, 2, 1.0, 1.0, 1.0, Order::Linear), &crumpled(start, numerics));
        let run = common::run(&scene);
        let record = durometer::study::store::finished_run::record(&scene, &run, Spent::default());
        (run, record)
    };
    let (without, _) = run("");
    let (with, _) = run("[numerics]\ntime_budget = \"60 min\"");
    assert_eq!((with.status, with.rows.len()), (Status::Converged, without.rows.len()));
    assert!(with.last.x.iter().zip(&without.last.x).all(|(a, b)| a.to_bits() == b.to_bits()));
    let (stopped, record) = run("[numerics]\ntime_budget = \"0.001 ms\"");
    assert!(matches!(stopped.status, Status::TimeBudget { t: 0.0 }), "{}", stopped.status);
    assert_eq!((stopped.rows.len(), stopped.rows[0].len()), (1, without.rows[0].len()));
    let stop = record.solver.stop.expect("it stopped");
    assert!(stop.remedy.contains("time_budget") && record.status == "TimeBudget", "{stop:?}");
}

/// Without cuts one of the first 30 starts is lost that is back with them.
#[test]
fn without_cuts_starts_are_lost() {
    let is_lost = |seed: u64, numerics: &str| left_over(&random_start(seed), numerics) > 1e-6;
    let first = (0..30).find(|seed| is_lost(*seed, "[numerics]\ncuts = 0")).expect("some are lost");
    println!("without cuts the random start {first} is lost");
    assert!(!is_lost(first, ""), "seed {first}");
}

/// Nodes anywhere in a cube of six times the side, and one static step without a load: Newton's method finds the way back with
/// projected tangents, and says so. Without them rounding decides whether a far start is back by chance: at most two of eight.
#[test]
fn without_projection_far_starts_are_lost() {
    let statics = |text: String| {
        let (head, rest) = text.split_once("[[effect]]\nkind = \"inertia\"").expect("inertia");
        let tail = rest.split_once("[[constraint]]").expect("a constraint").1;
        format!("{head}[[constraint]]{tail}").replace("\"implicit_euler\"", "\"static\"").replace("0.2 s", "6 s")
    };
    let back = |seed: u64, projection: bool| {
        let start = format!("[start]\nkind = \"random\"\nsize = \"3 m\"\nseed = {seed}");
        let text = statics(crumpled(&start, &format!("[numerics]\ncuts = 0\nprojection = {projection}")));
        let run = common::run(&scene(block(2, 2, 2, 1.0, 1.0, 1.0, Order::Linear), &text));
        (run.status == Status::Converged && common::largest(&run.last.x) <= 1e-6, run.totals.projected)
    };
    let mut by_chance = 0;
    for seed in 0..8 {
        let ((without, never), (with, projected)) = (back(seed, false), back(seed, true));
        assert!(with && never == 0, "seed {seed}");
        assert!(projected == usize::from(!without), "seed {seed}: {projected} projected, back without: {without}");
        by_chance += usize::from(without);
    }
    println!("of 8 far starts all are back with projection, {by_chance} without");
    assert!(by_chance <= 2);
}

/// A beam under far more than its weight, in one step without cuts: full Newton steps get lost.
#[test]
fn without_line_search_a_large_step_is_lost() {
    let run = |line_search: bool| {
        let mesh = block(8, 1, 1, 0.2, 0.025, 0.025, Order::Linear);
        let numerics = format!("[numerics]\ncuts = 0\nline_search = {line_search}");
        common::run(&scene(mesh, &beam("100 m/s^2", "1 s", &numerics))).status
    };
    assert_eq!(run(true), Status::Converged);
    let status = run(false);
    assert!(matches!(status, Status::StepTooSmall { .. }), "{status}");
}

/// A beam that hangs from one end under a growing weight.
fn beam(acceleration: &str, dt: &str, more: &str) -> String {
    format!(
        r#"
[mesh]
body = "beam"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
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
acceleration = {{ kind = "ramp", from = "0 m/s^2", to = "{acceleration}", end = "1 s" }}
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "{dt}"
{more}
"#
    )
}

/// A stage by arc length reaches the same end as one under the loads, and says what it is. To the tolerance of both solves,
/// 1e-8 of the forces in a bent beam.
#[test]
fn a_stage_by_arc_length_ends_where_the_loads_do() {
    let run = |continuation: &str| {
        let scene = scene(block(6, 1, 1, 0.06, 0.01, 0.01, Order::Linear), &beam("9.81 m/s^2", "0.2 s", continuation));
        let run = common::run(&scene);
        assert_eq!(run.status, Status::Converged, "{continuation}");
        assert_eq!(scene.check_time().is_err(), !continuation.is_empty(), "a study refuses time that may run back");
        (run.last.x, run.rows.len(), scene.spans[0].integrator.name())
    };
    let (plain, steps, _) = run("");
    let (traced, arcs, name) = run("continuation = \"arc_length\"");
    assert!(steps == 6 && arcs > 2 && name == "arc_length", "{steps} {arcs} {name}");
    let off = plain.iter().zip(&traced).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
    assert!(off < 1e-6 * common::largest(&plain), "{off:e} of {}", common::largest(&plain));
}

/// Loads that act in full from the start are in balance where the path begins: its end is that of steps under the same loads, to the tolerance of both solves.
#[test]
fn a_path_begins_in_balance_with_the_loads_of_its_start() {
    let growing = "[[effect]]\nkind = \"traction\"\nregion = \"xmax\"\ndirection = [0, 0, -1]\n\
                   traction = { kind = \"ramp\", from = \"0 Pa\", to = \"100 Pa\", end = \"1 s\" }\n";
    let run = |continuation: &str| {
        let in_full = beam("9.81 m/s^2", "0.2 s", continuation).replace("from = \"0 m/s^2\"", "from = \"9.81 m/s^2\"");
        let text = in_full + growing;
        let run = common::run(&scene(block(6, 1, 1, 0.06, 0.01, 0.01, Order::Linear), &text));
        assert_eq!(run.status, Status::Converged, "{continuation}");
        run.last.x
    };
    let (plain, traced) = (run(""), run("continuation = \"arc_length\""));
    let off = plain.iter().zip(&traced).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
    assert!(off < 1e-6 * common::largest(&plain), "{off:e} of {}", common::largest(&plain));
}
