//! A scene pays only for what it declares: what is not declared is not executed, has no column and no cost, and a load of no
//! intensity changes no bit of the rest.

use crate::common::{changed_scene, tools};
use durometer::material::LAWS;
use durometer::math::statistics::larger;
use durometer::scene::spec::{ConstraintSpec, EffectSpec};
use durometer::scene::{Run, Scene};
use durometer::solve::Status;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

const GRAVITY: &str = "effect.+={ kind = \"gravity\", region = \"body\", density = \"1 g/cm^3\", direction = [0, 0, -1], acceleration = \"9.81 m/s^2\" }";
const FLOOR: &str = "contact.+={ name = \"floor\", region = \"tip\", obstacle = { kind = \"floor\", point = [\"0 mm\", \"0 mm\", \"-50 mm\"], normal = [0, 0, 1] }, response = \"barrier\", friction = 0 }";
/// Of the scene: one pass over its blocks costs at least an instruction for each.
const CELLS: u64 = 48;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn scene(changes: &[&str]) -> Scene {
    changed_scene("tests/cli/scene.toml", changes)
}

fn run(changes: &[&str]) -> Run {
    let run = scene(changes).run();
    assert_eq!(run.status, Status::Converged, "{changes:?}");
    run
}

/// Source file → instructions executed in it, inlined code counted where it was written. `None` where valgrind is absent.
fn instructions(changes: &[&str]) -> Option<BTreeMap<String, u64>> {
    if tools::is_missing(Command::new("valgrind").arg("--version").output().is_ok(), "valgrind (Debian: valgrind)") {
        return None;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("callgrind");
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", &format!("--callgrind-out-file={}", out.display())]);
    command.args([env!("CARGO_BIN_EXE_durometer"), "simulate", "tests/cli/scene.toml", "--out"]).arg(folder.path());
    command.args(changes.iter().flat_map(|c| ["--set", c]));
    let output = command.current_dir(root()).output().expect("valgrind starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(by_file(&std::fs::read_to_string(out).expect("valgrind has written its counts")))
}

/// Those of the scene as it is, which are counted once.
fn of_scene() -> Option<&'static BTreeMap<String, u64>> {
    static COUNTS: OnceLock<Option<BTreeMap<String, u64>>> = OnceLock::new();
    COUNTS.get_or_init(|| instructions(&[])).as_ref()
}

/// The format of callgrind: `fl=(3) path` names a file once and is the current one from then on, as are `fi` and `fe` of
/// inlined code; a line after `calls=` counts a call as a whole and is none of the file's own.
fn by_file(text: &str) -> BTreeMap<String, u64> {
    let (mut names, mut counts) = (BTreeMap::new(), BTreeMap::new());
    let (mut current, mut called) = (String::new(), false);
    for line in text.lines() {
        let file = ["fl=", "fi=", "fe=", "cfi=", "cfl="].iter().find_map(|key| Some((*key, line.strip_prefix(key)?)));
        if let Some((key, rest)) = file {
            let (id, name) = rest.split_once(' ').unwrap_or((rest, ""));
            if !name.is_empty() {
                names.insert(id.to_string(), name.to_string());
            }
            if !key.starts_with('c') {
                current = names.get(id).cloned().unwrap_or_default();
            }
        } else if line.starts_with("calls=") {
            called = true;
        } else if line.starts_with(|c: char| c.is_ascii_digit() || "+-*".contains(c)) && !std::mem::take(&mut called) {
            let count = line.split(' ').nth(1).and_then(|n| n.parse::<u64>().ok());
            *counts.entry(current.clone()).or_insert(0) += count.unwrap_or(0);
        }
    }
    counts
}

/// Instructions in the file of this path below `src`.
fn of(counts: &BTreeMap<String, u64>, path: &str) -> u64 {
    let own = counts.iter().filter(|(name, _)| name.ends_with(&format!("src/{path}")));
    own.map(|(_, n)| n).sum()
}

/// Files and folders of `src/effect`, so that a new effect is watched without being named here.
fn effects() -> Vec<String> {
    let entries = std::fs::read_dir(root().join("src/effect")).expect("a folder").flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Instructions in a file of `src/effect`, or in all files below a folder of it.
fn of_effect(counts: &BTreeMap<String, u64>, name: &str) -> u64 {
    match name.ends_with(".rs") {
        true => of(counts, &format!("effect/{name}")),
        false => counts.iter().filter(|(file, _)| file.contains(&format!("src/effect/{name}/"))).map(|(_, n)| n).sum(),
    }
}

/// The scene has `elastic` (with its cells and the scatter of its pressures), a cable, and a Neo-Hookean law. The compiler folds
/// functions of the same code into one, whose lines are those of either, so a few instructions of a getter may be counted in
/// a file that was not meant: fewer than cells are allowed, and one pass over a body takes at least one for each.
#[test]
fn what_is_not_declared_is_not_executed() {
    let Some(counts) = of_scene() else { return };
    let declared = ["cable.rs", "cell.rs", "elastic.rs", "pressure_scatter.rs"];
    for name in effects() {
        let n = of_effect(counts, &name);
        match declared.contains(&name.as_str()) {
            true => assert!(n > CELLS, "{name} is declared, and was seen for {n} instructions"),
            false => assert!(n < CELLS, "{name} is not declared, and {n} instructions of it were executed"),
        }
    }
    for law in LAWS.iter().map(|l| l.info.name) {
        let n = of(counts, &format!("material/{law}.rs"));
        assert_eq!(n >= CELLS, law == "neo_hookean", "law {law}: {n} instructions");
    }
    // It can fail: declared, the same files are seen.
    let with = instructions(&[GRAVITY, FLOOR]).expect("valgrind was there");
    for name in ["gravity.rs", "contact"] {
        let n = of_effect(&with, name);
        assert!(n > CELLS, "{name} is declared, and was seen for {n} instructions");
    }
    println!("{} instructions, with gravity and a floor {}", counts.values().sum::<u64>(), with.values().sum::<u64>());
}

/// Twice the steps do not execute one instruction more in what knows the kinds of effects: the registries are left behind
/// when the system is built, so a kind more in them cannot make a step more expensive. 0.1 % leaves room for hashes that differ.
#[test]
fn a_step_does_not_see_the_registry() {
    let (Some(short), Some(long)) = (of_scene(), instructions(&["stage.0.duration=\"2 s\""])) else { return };
    for file in [
        "scene/parts/effects/mod.rs",
        "scene/build/mod.rs",
        "scene/build/builder.rs",
        "scene/stages.rs",
        "material/registry.rs",
    ] {
        let (a, b) = (of(short, file), of(&long, file));
        assert!(a > 0, "{file} was not seen at all");
        assert!(a.abs_diff(b) as f64 <= 1e-3 * a as f64, "{file}: {a} instructions for 4 steps, {b} for 8");
    }
    let [a, b] = [short, &long].map(|counts| of(counts, "system/assembly.rs") as f64);
    assert!(b > 1.3 * a, "twice the steps must be assembled more often: {a}, {b}");
}

fn same_bits(label: &str, a: &Run, b: &Run) {
    for (k, name) in a.columns.iter().enumerate() {
        let other = b.columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("{label}: no {name}"));
        for (x, y) in a.rows.iter().zip(&b.rows) {
            assert_eq!(x[k].to_bits(), y[other].to_bits(), "{label}: {name} at {} s: {} and {}", x[0], x[k], y[other]);
        }
    }
    assert_eq!(a.rows.len(), b.rows.len(), "{label}");
}

/// What acts on nodes and cells that share an entry of the tangent already adds zeros to sums: not one bit changes.
#[test]
fn a_load_or_damping_of_no_intensity_changes_no_bit() {
    let idle = [
        "effect.+={ kind = \"gravity\", region = \"body\", density = \"1 g/cm^3\", direction = [0, 0, -1], acceleration = \"0 m/s^2\" }",
        "effect.+={ kind = \"point_force\", point = [\"1.5 cm\", \"0.5 cm\", \"0.5 cm\"], radius = \"3 mm\", direction = [0, 0, -1], force = \"0 N\" }",
        "effect.+={ kind = \"traction\", region = \"tip\", direction = [0, 0, -1], traction = \"0 Pa\" }",
    ];
    let base = run(&[]);
    idle.iter().for_each(|effect| same_bits(effect, &base, &run(&[effect])));
    let inertia = "effect.+={ kind = \"inertia\", region = \"body\", density = \"1 g/cm^3\", mass = \"consistent\" }";
    let dynamic = [inertia, "stage.0.integrator=\"implicit_euler\"", "stage.0.dt=\"0.1 s\""];
    let base = run(&dynamic);
    for effect in [
        "effect.+={ kind = \"mass_damping\", region = \"body\", density = \"1 g/cm^3\", mass = \"lumped\", alpha = \"0 1/s\" }",
        "effect.+={ kind = \"viscous_damping\", region = \"body\", eta = \"0 Pa s\" }",
    ] {
        same_bits(effect, &base, &run(&[&dynamic[..], &[effect]].concat()));
    }
}

/// A cable of no tension is part of the factorisation by its guides: the order is another one, and its rounding differs. Newton stops at 1e-8 of the forces, which leaves less than 1e-6 in the columns.
#[test]
fn a_cable_of_no_tension_changes_rounding_only() {
    let cable = "constraint.+={ kind = \"cable\", name = \"idle\", guides = [[\"0.6 cm\", \"0.5 cm\", \"0.8 cm\"], [\"1.7 cm\", \"0.5 cm\", \"0.8 cm\"]], pull_point = [\"-1 cm\", \"0.5 cm\", \"0.8 cm\"], guide_radius = \"2 mm\", drive = { kind = \"tension\", signal = \"0 N\" } }";
    let (base, with) = (run(&[]), run(&[cable]));
    assert!(with.factor_nnz > base.factor_nnz, "the guides of the cable are part of the factorisation");
    for name in ["bending_angle_deg", "cable_tension_N", "elastic_J"] {
        let column = |run: &Run| {
            let k = run.columns.iter().position(|c| c == name).expect("recorded");
            run.rows.iter().map(|row| row[k]).collect::<Vec<_>>()
        };
        let (a, b) = (column(&base), column(&with));
        let largest = a.iter().fold(0.0, |m, v| larger(m, v.abs()));
        let off = a.iter().zip(&b).fold(0.0, |m, (a, b)| larger(m, (a - b).abs()));
        assert!(off <= 1e-6 * largest, "{name}: off by {off:e} of {largest:e}");
    }
}

#[test]
fn columns_signals_and_costs_are_those_of_what_is_declared() {
    let bare = scene(&["constraint=[{ kind = \"fixed\", region = \"root\" }]", GRAVITY]);
    assert!(!bare.columns().iter().any(|c| c.contains("cable") || c.contains("cavity")), "{:?}", bare.columns());
    let signals: Vec<&str> = bare.signals.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(signals, ["body_acceleration_m_s2"]);
    let costs = |changes: &[&str]| run(changes).costs.into_iter().map(|c| c.name).collect::<Vec<_>>();
    assert_eq!(costs(&[]), ["elastic", "cable"]);
    assert_eq!(costs(&[GRAVITY]), ["elastic", "gravity", "cable"]);
}

/// Two components of the weight, each with a name that an event, a controller or a reduced model sets it by.
#[test]
fn weights_of_one_region_have_signals_of_their_own() {
    let weight = |name: &str, direction: &str| {
        format!(
            "effect.+={{ kind = \"gravity\", name = \"{name}\", region = \"body\", density = \"1 g/cm^3\", \
             direction = {direction}, acceleration = {{ kind = \"controlled\", initial = \"0 m/s^2\" }} }}"
        )
    };
    let [down, aside] = [weight("down", "[0, 0, -1]"), weight("aside", "[0, -1, 0]")];
    let names = ["down_acceleration_m_s2", "aside_acceleration_m_s2"];
    let scene = scene(&["constraint=[{ kind = \"fixed\", region = \"root\" }]", &down, &aside]);
    assert_eq!(scene.controls.controlled(), names);
    assert_eq!(scene.signals.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), names);
}

/// `check` names every kind: what is there and what is not, together, is the registry.
#[test]
fn check_names_what_is_not_there() {
    let output = Command::new(env!("CARGO_BIN_EXE_durometer"))
        .args(["check", "tests/cli/scene.toml", "--set", GRAVITY])
        .current_dir(root())
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let after = |start: &str| -> Vec<String> {
        let line = said.lines().find_map(|l| l.strip_prefix(start)).unwrap_or_else(|| panic!("{start}: {said}"));
        line.split(", ").map(String::from).collect()
    };
    let absent = after("not there    effects: ");
    assert_eq!(absent.len() + 2, EffectSpec::KINDS.len(), "{absent:?}");
    assert!(!absent.contains(&"gravity".to_string()) && absent.contains(&"viscoelastic".to_string()), "{absent:?}");
    let absent = after("             constraints: ");
    assert_eq!(absent, ["prescribed", "cavity", "rigid"]);
    assert_eq!(absent.len() + 2, ConstraintSpec::KINDS.len());
    assert!(said.contains("elastic (48 blocks): region body, law rubber, formulation displacement"), "{said}");
    assert!(said.contains("gravity (") && said.contains("towards [0.0, 0.0, -1.0]"), "{said}");
}
