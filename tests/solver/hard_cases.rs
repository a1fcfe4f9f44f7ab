//! The study of hard cases: its quick half is right, its switches are needed, and statics does not depend on what it must not.

use crate::common::renumbered::renumbered as renumbered_mesh;
use crate::common::studies::run_study;
use crate::common::threads;
use durometer::math::random::SplitMix;
use durometer::math::statistics::larger;
use durometer::math::units::{self, Dimension};
use durometer::scene::{Body, Run, Scene, SceneSpec, column};
use durometer::solve::Status;
use durometer::study::analysis::Analysis;
use durometer::study::case::Case;
use durometer::study::case_outcome::CaseOutcome;
use durometer::study::expand::Study;
use durometer::study::kind::StudyScope;
use durometer::study::kinds::robustness::analysis::{RobustnessFindings, analyse};
use durometer::study::kinds::robustness::record::RobustnessRecord;
use durometer::study::listing::{State, list};
use durometer::study::store::record::StudyRecord;
use durometer::study::store::results::{self, Results};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use toml::Value;

fn file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/hard-cases/study.toml")
}

fn quick(changes: &[(&str, Value)]) -> Study {
    let changes: Vec<_> = changes.iter().map(|(key, value)| (key.to_string(), value.clone())).collect();
    Study::read_scope(&file(), &changes, StudyScope::Quick).unwrap_or_else(|e| panic!("{e}"))
}

fn kept(study: &StudyRecord) -> RobustnessRecord {
    serde_json::from_value(study.details.clone()).expect("suites and maps")
}

fn judged(store: &Results) -> Analysis<RobustnessFindings> {
    analyse(&store.study, &kept(&store.study), &store.cases)
}

/// The quick half as it is, which is run once.
fn quick_half() -> &'static Results {
    static RESULTS: OnceLock<Results> = OnceLock::new();
    RESULTS.get_or_init(|| stored(&quick(&[]), None))
}

/// Runs the cases whose id contains `only`.
fn stored(study: &Study, only: Option<&str>) -> Results {
    let folder = tempfile::tempdir().expect("a temporary folder");
    run_study(study, folder.path(), only);
    results::read(folder.path()).unwrap_or_else(|e| panic!("{e}"))
}

/// Every case ends as it should and meets its references, of which most have one; none panics, hangs or leaves a number that is not finite.
#[test]
fn the_quick_half_is_right() {
    let a = judged(quick_half());
    println!("{}", a.verdict);
    let failed: Vec<String> = (a.cases.iter().filter(|c| c.outcome == CaseOutcome::Fail))
        .map(|c| format!("{}: {}", c.case, c.reason.as_deref().unwrap_or_default()))
        .collect();
    assert_eq!(failed, Vec::<String>::new());
    assert!(a.cases.len() >= 60 && a.incomplete.is_empty(), "{} cases", a.cases.len());
    // Every other case has nothing to be compared with, or stops where that is accepted
    assert_eq!([CaseOutcome::Pass, CaseOutcome::Demanded].map(|o| a.count(o)), [116, 11], "{}", a.verdict);
    let compared: usize = a.cases.iter().map(|c| c.findings.len()).sum();
    assert!(compared >= 160, "{compared} comparisons with a reference");
    // The column that is pressed straight beyond Euler's load says that it is unstable
    let column = a.cases.iter().filter(|c| c.suite == "column").flat_map(|c| &c.findings);
    let unstable: Vec<f64> = column.filter(|f| f.what == "unstable steps").map(|f| f.measured).collect();
    assert_eq!(unstable, [3.0, 1.0, 0.0]);
}

/// A factor that is kept, and one made afresh in every iteration: the same ends, and the same last rows.
/// Forces are solved to 1e-8 of the largest, which in slender bodies are 10³ times the load: 1e-5 of the largest value of the same unit. One case of every
/// suite in every variant.
#[test]
fn the_fast_path_gives_what_the_slow_one_does() {
    let some = |key: &str, value: Value| {
        let mut study = quick(&[(key, value)]);
        let mut seen = BTreeSet::new();
        study.cases.retain(|c| seen.insert((c.family.clone(), c.variant.clone())));
        stored(&study, None)
    };
    let fast = some("numerics.reuse_threshold", Value::Integer(0));
    let slow = some("numerics.reuse_factor", Value::Boolean(false));
    assert!(fast.cases.len() >= 50, "{} cases", fast.cases.len());
    let mut kept = 0;
    for a in fast.cases.iter().map(|c| &c.record) {
        let b = &slow.cases.iter().find(|c| c.record.id == a.id).expect("the same cases").record;
        assert_eq!(a.status, b.status, "{}", a.id);
        if !a.converged() {
            continue;
        }
        kept += usize::from(a.work.factorisations < b.work.factorisations);
        for (name, p) in a.probes.iter().filter(|(name, _)| *name != "newton_iterations") {
            let alike = b.probes.iter().filter(|(other, _)| column::comparable(other, name));
            let size = alike.map(|(_, other)| other.peak.abs()).fold(0.0, larger);
            let q = b.probes[name].last;
            assert!((p.last - q).abs() <= 1e-5 * size, "{}: {name} = {:e} and {q:e}", a.id, p.last);
        }
    }
    assert!(kept > 33, "{kept} cases saved factorisations");
}

/// A refused scene has a mesh all the same: its result is that of the study, and no later run computes it anew.
#[test]
fn the_result_of_a_refused_case_is_kept() {
    let study = Study::read(&file(), &[]).unwrap_or_else(|e| panic!("{e}"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    run_study(&study, folder.path(), Some("crumpled-refused"));
    let listed = list(&study, folder.path());
    let states = listed.iter().filter(|c| c.id.starts_with("crumpled-refused")).map(|c| c.state);
    assert_eq!(states.collect::<Vec<_>>(), [State::Stored; 2]);
}

/// A suite says which tables it has; one that is not understood is refused with its place.
#[test]
fn every_suite_has_a_setup_and_ends_that_exist() {
    let study = Study::read(&file(), &[]).unwrap_or_else(|e| panic!("{e}"));
    assert!(kept(&study.record).suites.iter().all(|s| s.setup.ends_with('.')), "a setup is a sentence");
    assert!(study.cases.len() >= 300, "{} cases", study.cases.len());
}

/// Static scenes of the quick half, with their bodies, but for arc length, friction, given starts, the law of St Venant and Kirchhoff, and columns.
fn static_scenes() -> Vec<(Case, Arc<Body>)> {
    let cases = quick(&[]).cases;
    let wanted = |c: &Case| {
        let text = &c.text;
        let path = ["arc_length", "friction", "[start", "st_venant", "column"].iter().any(|w| text.contains(w));
        text.matches("integrator = \"static\"").count() == c.spec.stages.len() && !path
    };
    let mut seen: Vec<String> = vec![];
    let loaded = cases.into_iter().filter(wanted).filter_map(|c| {
        // One member of every suite and variant is enough
        let kind = format!("{} {}", c.family, c.variant);
        if seen.contains(&kind) {
            return None;
        }
        let body = Body::load(&c.scene_file, &c.spec.mesh, &mut |_| {}).ok()?;
        seen.push(kind);
        Some((c, Arc::new(body)))
    });
    loaded.collect()
}

/// `None` if it is refused or has no answer, however long it takes.
fn ended(case: &Case, text: &str, body: Arc<Body>) -> Option<Run> {
    let mut spec = SceneSpec::from_text(&case.scene_file, text, "").unwrap_or_else(|e| panic!("{}: {e}", case.id));
    spec.numerics.time_budget = None;
    let scene = Scene::build(&case.scene_file, spec, text.into(), body).unwrap_or_else(|e| panic!("{}: {e}", case.id));
    let run = scene.run();
    (run.status == Status::Converged).then_some(run)
}

/// Largest difference of the last rows over the largest value that the column takes, iterations apart. Columns that are
/// nothing but rounding compared with their kind (reactions across the load, say) count by the largest of the same unit. Quantiles
/// of the stretch over cells jump from a cell to another where two weigh alike, and are left out.
fn difference(a: &Run, b: &Run, factor: impl Fn(&str) -> f64) -> f64 {
    let (x, y) = (a.rows.last().expect("rows"), b.rows.last().expect("rows"));
    (1..a.columns.len() - 1)
        .filter(|&k| !["stretch_median", "stretch_p95"].contains(&a.columns[k].as_str()))
        .map(|k| {
            let size = column::largest_of_unit(&a.columns, &a.rows, &a.columns[k]);
            let off = (x[k] - y[k] / factor(&a.columns[k])).abs();
            if off == 0.0 { 0.0 } else { off / size }
        })
        .fold(0.0, larger)
}

/// Two solutions to 1e-8 of the forces differ by that times the condition of the problem, the ratio of stiffnesses in length
/// and bending: 1e4 here and less.
const SAME: f64 = 1e-5;

/// Statics does not depend on the step, on the units, on the numbers of nodes and cells, or on the threads.
#[test]
fn statics_depends_on_nothing_else() {
    let scenes = static_scenes();
    assert!(scenes.len() >= 20, "{} scenes", scenes.len());
    let mut seed = SplitMix(7);
    let mut compared = 0;
    for (case, body) in &scenes {
        // Loads beyond a limit, and bodies that nothing holds
        let Some(run) = ended(case, &case.text, body.clone()) else { continue };
        compared += 1;
        let same = |what: &str, other: Option<Run>, factor: &dyn Fn(&str) -> f64, accept: f64| {
            let other = other.unwrap_or_else(|| panic!("{}: no answer with {what}", case.id));
            let off = difference(&run, &other, factor);
            assert!(off <= accept, "{}: {what} changes the answer by {off:.1e}", case.id);
        };
        let mut table: toml::Table = case.text.parse().expect("TOML");
        for stage in table["stage"].as_array_mut().into_iter().flatten() {
            let (dt, _) = units::quantity(stage["dt"].as_str().expect("text")).expect("a time");
            stage["dt"] = format!("{} s", dt / 2.0).into();
        }
        let halved = toml::to_string(&table).expect("TOML");
        same("half the step", ended(case, &halved, body.clone()), &|_| 1.0, SAME);
        let mixed = Arc::new(renumbered(body, &mut seed));
        same("other numbers", ended(case, &case.text, mixed), &|_| 1.0, SAME);
        // m, kPa, t and s → mm, MPa, … : lengths, masses and times of another size are the same problem
        let system = Similar { length: 1e3, mass: 1e-3, time: 0.1 };
        let text = toml::to_string(&system.table(&case.text)).expect("TOML");
        let scaled = Arc::new(system.body(body));
        same("other units", ended(case, &text, scaled), &|column| system.column(column), SAME);
        let [alone, shared] = [1, 3].map(|count| threads::on(count, || ended(case, &case.text, body.clone())));
        same("one thread", alone, &|_| 1.0, 0.0);
        same("three threads", shared, &|_| 1.0, 0.0);
    }
    println!("{compared} of {} scenes compared", scenes.len());
    assert!(compared >= 23, "{compared} of {} scenes have an answer", scenes.len());
}

/// Nodes and cells in another order.
fn renumbered(body: &Body, random: &mut SplitMix) -> Body {
    Body {
        mesh: renumbered_mesh(&body.mesh, &mut |n| random.below(n)),
        paths: body.paths.clone(),
        source: body.source.clone(),
        sha256: body.sha256.clone(),
        notes: body.notes.clone(),
        warnings: body.warnings.clone(),
        volumes: vec![],
        levels: None,
        undeformed: None,
        patches: durometer::scene::Patches::default(),
    }
}

/// Factors of length, mass and time.
struct Similar {
    length: f64,
    mass: f64,
    time: f64,
}

/// Exponents of length, mass and time of the quantities in the scenes.
const DIMENSIONS: [(Dimension, [i32; 3]); 13] = [
    (Dimension::NONE, [0, 0, 0]),
    (Dimension::LENGTH, [1, 0, 0]),
    (Dimension::CURVATURE, [-1, 0, 0]),
    (Dimension::AREA, [2, 0, 0]),
    (Dimension::VOLUME, [3, 0, 0]),
    (Dimension::TIME, [0, 0, 1]),
    (Dimension::ANGLE, [0, 0, 0]),
    (Dimension::FORCE, [1, 1, -2]),
    (Dimension::ENERGY, [2, 1, -2]),
    (Dimension::PRESSURE, [-1, 1, -2]),
    (Dimension::STIFFNESS, [0, 1, -2]),
    (Dimension::DENSITY, [-3, 1, 0]),
    (Dimension::ACCELERATION, [1, 0, -2]),
];

impl Similar {
    fn of(&self, dimension: Dimension) -> f64 {
        let known = DIMENSIONS.iter().find(|(d, _)| *d == dimension);
        let [m, kg, s] = known.unwrap_or_else(|| panic!("{dimension:?} is not in the list")).1;
        self.length.powi(m) * self.mass.powi(kg) * self.time.powi(s)
    }

    /// Every quantity of a scene with a unit, times its factor.
    fn table(&self, text: &str) -> toml::Table {
        fn scale(value: &mut Value, by: &Similar) {
            match value {
                Value::Table(table) => table.iter_mut().for_each(|(_, v)| scale(v, by)),
                Value::Array(list) => list.iter_mut().for_each(|v| scale(v, by)),
                Value::String(text) => {
                    if let Ok((si, dimension)) = units::quantity(text)
                        && dimension != Dimension::NONE
                    {
                        let unit = dimension.example();
                        let one = units::parse(&format!("1 {unit}"), dimension).expect("an example of a unit");
                        *text = format!("{} {unit}", si * by.of(dimension) / one);
                    }
                }
                _ => {}
            }
        }
        let mut table: toml::Table = text.parse().expect("TOML");
        table.iter_mut().for_each(|(_, v)| scale(v, self));
        table
    }

    fn body(&self, body: &Body) -> Body {
        let mut mesh = body.mesh.clone();
        mesh.points.iter_mut().for_each(|p| *p *= self.length);
        let mut paths = body.paths.clone();
        for path in paths.values_mut() {
            path.guides.iter_mut().chain([&mut path.pull_point]).flatten().for_each(|x| *x *= self.length);
            path.guide_radius *= self.length;
        }
        Body {
            mesh,
            paths,
            source: body.source.clone(),
            sha256: body.sha256.clone(),
            notes: body.notes.clone(),
            warnings: body.warnings.clone(),
            volumes: vec![],
            levels: None,
            undeformed: None,
            patches: durometer::scene::Patches::default(),
        }
    }

    /// Factor of a column, by the unit in its name.
    fn column(&self, name: &str) -> f64 {
        self.of(column::dimension(name).0)
    }
}

/// Each switch of the solver is there for a reason: without it a case of the suite that is right is not.
#[test]
fn the_suite_notices_what_is_switched_off() {
    for (key, value, only) in [
        ("numerics.line_search", Value::from(false), "snap-through-as-given-one-step"),
        ("numerics.cuts", Value::from(0), "balloon-tet10-mean-dilatation"),
        ("numerics.projection", Value::from(false), "projected-tet10-mean-dilatation-twice"),
    ] {
        let a = judged(&stored(&quick(&[(key, value)]), Some(only)));
        assert_eq!(a.count(CaseOutcome::Fail), 1, "{only} does not need {key}: {}", a.verdict);
    }
}

/// References of a map are compared in its quantity: they record it, whatever their variant judges.
#[test]
fn references_record_the_quantity_of_their_map() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/hard-cases/study.toml");
    let study = Study::read(&file, &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut references = study.cases.iter().filter(|c| c.family == "dt-nu-reference").peekable();
    assert!(references.peek().is_some(), "a map with references");
    references.for_each(|case| assert_eq!(study.columns_of(case), ["chord_angle_deg"], "{}", case.id));
}

/// Around a scene: its signals, steps, ν and mesh are varied where it has them, and dynamic scenes are compared with the linearised step.
#[test]
fn maps_are_drawn_around_a_scene() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/hard-cases/scenes");
    let around = |name: &str| Study::around(&folder.join(name), &[]).unwrap_or_else(|e| panic!("{e}"));
    let maps = |s: &Study| kept(&s.record).maps.iter().map(|m| m.family.clone()).collect::<Vec<_>>();
    let beam = around("beam.toml");
    assert_eq!(
        (maps(&beam), beam.record.variants.len()),
        (["dt-load", "dt-nu", "mesh-load"].map(String::from).into(), 1)
    );
    let case = |id: &str| beam.cases.iter().find(|c| c.id == id).unwrap_or_else(|| panic!("no case {id}"));
    let text = &case("dt-load-converged-dt0.5_load3").text;
    assert!(text.contains("dt = \"0.125 s\"") && text.contains("product"), "{text}");
    let crumpled = around("crumpled.toml");
    assert_eq!((maps(&crumpled), crumpled.record.variants.len()), (vec!["dt-nu".to_string()], 2));
}
