//! Input that is made to break the program, and results that a crash has damaged: each ends in a typed error, a status or a sound report.
#![cfg(unix)]

use crate::common::program::durometer;
use crate::common::scene;
use crate::common::studies::run_folder;
use durometer::math::stopwatch::Spent;
use durometer::mesh::ball::ball_weights;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, read};
use durometer::report::canvas::{At, INK, LABEL, figure, italic, text};
use durometer::report::export::{Pictures, png};
use durometer::scene::control::process::Process;
use durometer::scene::{Checkpoint, CheckpointError, RunOptions, Scene};
use durometer::solve::Status;
use durometer::study::report;
use durometer::study::store::folder;
use durometer::study::store::record::CaseRecord;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

const SCENE: &str = r#"
title = "A block that is pulled"
[mesh]
grid = { kind = "box", size = ["100 mm", "20 mm", "20 mm"], divisions = [4, 1, 1] }
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = { kind = "ramp", from = "0 mm", to = "20 mm", end = "1 s" }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.2 s"
[[probe]]
kind = "reaction"
region = "xmax"
[[probe]]
kind = "energy"
"#;
const STUDY: &str = r#"
kind = "convergence"
question = "Does it hold?"
expectation = "Yes."
scene = "scene.toml"
tolerance = "2 %"
[[variant]]
name = "pull"
quantity = [{ name = "xmax_reaction_x_N", label = "force", symbol = "F", unit = "N" }]
[[family]]
name = "sizes"
role = "sizes"
[family.members]
a = { "mesh.grid.divisions" = [4, 1, 1] }
b = { "mesh.grid.divisions" = [8, 2, 2] }
"#;

/// A folder with a scene and a study of it.
fn folder(scene: &str, study: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("scene.toml"), scene).expect("writable");
    std::fs::write(folder.path().join("study.toml"), study).expect("writable");
    folder
}

/// A patch of 2 mm in cells of 750 mm × 10 mm × 10 mm: its weights follow affine motions, soon.
#[test]
fn a_patch_in_a_slender_cell_is_integrated() {
    for order in [Order::Linear, Order::Quadratic] {
        let mesh = block(4, 2, 2, 3.0, 0.02, 0.02, order);
        let at = durometer::math::tensor::Vec3::new(0.04, 0.01, 0.01);
        let start = Instant::now();
        let weights = ball_weights(&mesh, at, 0.002).unwrap_or_else(|e| panic!("{e}"));
        assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
        let mean = |f: &dyn Fn(usize) -> f64| weights.iter().map(|&(i, w)| w * f(i as usize)).sum::<f64>();
        assert!((mean(&|_| 1.0) - 1.0).abs() < 1e-9);
        for d in 0..3 {
            assert!((mean(&|i| mesh.points[i][d]) - at[d]).abs() < 1e-9, "{order:?} {d}");
        }
        let small = ball_weights(&mesh, at, 1e-103).expect_err("too small").to_string();
        assert!(small.contains("less than a millionth of the body"), "{small}");
    }
}

/// A surface in thousands of physical groups: each facet would be listed in all of them.
#[test]
fn groups_times_elements_stay_small() {
    let (groups, facets) = (20_000, 20_000);
    let mut msh = String::from("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 0\n1 0 0 0 1 1 1 ");
    write!(msh, "{groups}").expect("a string");
    (1..=groups).for_each(|tag| write!(msh, " {tag}").expect("a string"));
    msh += " 0\n$EndEntities\n$Nodes\n1 3 1 3\n2 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n0 1 0\n$EndNodes\n$Elements\n";
    writeln!(msh, "1 {facets} 1 {facets}\n2 1 2 {facets}").expect("a string");
    (1..=facets).for_each(|tag| writeln!(msh, "{tag} 1 2 3").expect("a string"));
    msh += "$EndElements\n";
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("groups.msh");
    std::fs::write(&file, msh).expect("writable");
    let error = read(&file, 1.0).expect_err("too many").to_string();
    assert!(error.contains("entity 1 belongs to 20000 physical groups"), "{error}");
}

/// A pipe, a device, a gzipped file of zeros: refused at once with the fact.
#[test]
fn files_without_an_end_are_refused() {
    let keep = folder(SCENE, STUDY);
    let at = keep.path();
    let pipe = Command::new("mkfifo").arg(at.join("pipe")).status().expect("mkfifo runs");
    assert!(pipe.success());
    for (name, change) in [
        ("pipe", "laws.rubber.include=\"pipe\""),
        ("/dev/zero", "laws.rubber.include=\"/dev/zero\""),
        ("pipe", "constraint.1.displacement={ kind = \"table\", file = \"pipe\", unit = \"mm\" }"),
        ("/dev/zero", "constraint.1.displacement={ kind = \"table\", file = \"/dev/zero\", unit = \"mm\" }"),
    ] {
        let said = durometer(at, &["check", "scene.toml", "--set", change]);
        let error = said.err;
        assert_eq!(said.code, Some(2), "{name}: {error}");
        assert!(error.contains("not a regular file"), "{name}: {error}");
    }
    let said = durometer(at, &["check", "pipe"]);
    assert_eq!(said.code, Some(2), "{}", said.err);
}

/// Numbers beyond all measurement are left out of a fit, with the reason; the others are fitted.
#[test]
fn a_fit_leaves_out_numbers_that_are_no_measurement() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    for wild in ["-1e308", "1e160", "3e200"] {
        let table = format!("stretch,stress [MPa]\n1,0\n1.1,0.05\n1.2,0.09\n1.3,{wild}\n1.4,0.16\n1.5,0.18\n1.6,0.2\n");
        std::fs::write(keep.path().join("data.csv"), table).expect("writable");
        for law in ["yeoh", "mooney_rivlin"] {
            let fit = ["fit", "data.csv", "--law", law, "--mode", "uniaxial", "--out", "out", "--replace"];
            let said = durometer(keep.path(), &fit);
            let error = said.err;
            // Five data points need not determine every constant
            assert!(matches!(said.code, Some(0 | 3)), "{law} {wild}: {error}");
            let stored = std::fs::read_to_string(keep.path().join("out/fit.json")).expect("written");
            assert!(stored.contains("is beyond 1e30 Pa"), "{law} {wild}: {stored}");
        }
    }
}

fn state_of(scene: &Scene, file: &Path, at: f64) {
    let mut save = |checkpoint: &Checkpoint, _: &str| checkpoint.write(file).unwrap_or_else(|e| panic!("{e}"));
    let options = RunOptions { save_at: vec![at], on_save: Some(&mut save), ..RunOptions::default() };
    let run = scene.run_with(options);
    assert_eq!(run.status, Status::Converged);
}

/// Whichever byte of a saved state changes, it is refused.
#[test]
fn a_changed_state_is_refused() {
    let scene = scene(block(4, 1, 1, 0.1, 0.02, 0.02, Order::Linear), SCENE);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("a.state");
    state_of(&scene, &file, 0.4);
    let sound = std::fs::read(&file).expect("saved");
    Checkpoint::read(&file, &scene).unwrap_or_else(|e| panic!("{e}"));
    for k in (0..sound.len()).step_by(1 + sound.len() / 400) {
        let mut changed = sound.clone();
        changed[k] ^= 1;
        std::fs::write(&file, &changed).expect("writable");
        let error = Checkpoint::read(&file, &scene).expect_err("changed");
        let expected = matches!(error, CheckpointError::Damaged { .. } | CheckpointError::NotAState { .. });
        assert!(expected, "byte {k}: {error}");
    }
    std::fs::write(&file, &sound[..sound.len() - 8]).expect("writable");
    assert!(matches!(Checkpoint::read(&file, &scene), Err(CheckpointError::Damaged { .. })));
    // A sum that was made anew does not help a header that fits no run
    let rest = sound.iter().position(|b| *b == b'\n').expect("a line") + 1;
    let text = String::from_utf8_lossy(&sound[rest..rest + 2000]).to_string();
    let unfit = "do not fit the scene";
    let forged = [
        ("\"degree\":", "9223372036854775807", unfit),
        ("\"degree\":", "9", unfit),
        ("\"degree\":", "0", unfit),
        ("\"span\":", "7", unfit),
        ("\"step\":", "600", unfit),
        ("\"build\":", "\"4f2a00112233445566\"", "saved from another build of this program"),
    ];
    for (key, value, says) in forged {
        let from = rest + text.find(key).expect("a key of the header") + key.len();
        let to = from + sound[from..].iter().position(|b| *b == b',').expect("another key");
        let body = [&sound[rest..from], value.as_bytes(), &sound[to..]].concat();
        let sum = durometer::storage::sha256(&body);
        let first = String::from_utf8_lossy(&sound[..rest - 65]).to_string();
        std::fs::write(&file, [format!("{first}{sum}\n").as_bytes(), &body].concat()).expect("writable");
        let error = Checkpoint::read(&file, &scene).expect_err(key).to_string();
        assert!(error.contains(says), "{key} {error}");
    }
}

/// A run that an event has ended is not continued from the state that was saved there.
#[test]
fn a_restart_keeps_the_stop_that_ended_the_run() {
    let event = "[[event]]\nwhen = { kind = \"above\", column = \"elastic_J\", value = \"1e-6 N m\" }\nthen = [{ kind = \"stop\" }]\n";
    let scene = scene(block(4, 1, 1, 0.1, 0.02, 0.02, Order::Linear), &format!("{SCENE}{event}"));
    let whole = scene.run();
    let end = whole.rows.last().expect("a row")[0];
    assert!(end < 0.9, "{end}");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("a.state");
    state_of(&scene, &file, end);
    let restart = Checkpoint::read(&file, &scene).unwrap_or_else(|e| panic!("{e}"));
    let again = scene.run_with(RunOptions { restart: Some(restart), ..RunOptions::default() });
    assert_eq!((&again.status, &again.rows), (&Status::Converged, &whole.rows));
}

/// A column that is not a finite number ends the run with a status; no file holds it, and the study has its report.
#[test]
fn no_number_that_is_not_finite_is_stored() {
    let cable = "[[constraint]]\nkind = \"cable\"\npull_point = [\"1e200 mm\", \"10 mm\", \"10 mm\"]\n\
                 guides = [[\"50 mm\", \"10 mm\", \"10 mm\"]]\nguide_radius = \"4 mm\"\ndrive = { kind = \"tension\", signal = \"1 N\" }\n";
    let keep = folder(&format!("{SCENE}{cable}"), STUDY);
    let records = run_folder(keep.path());
    assert!(!records.is_empty());
    for record in &records {
        assert_eq!(record.status, "NotFinite", "{:?}", record.status_detail);
        let csv = keep.path().join(format!("results/cases/{}.csv", record.id));
        let csv = std::fs::read_to_string(csv).expect("stored");
        assert!(!csv.contains("inf") && !csv.contains("NaN"), "{csv}");
    }
    report::write_report(&keep.path().join("results")).unwrap_or_else(|e| panic!("{e}"));
    let said = durometer(keep.path(), &["simulate", "scene.toml", "--out", "one"]);
    let error = said.err;
    assert_eq!(said.code, Some(3), "{error}");
    assert!(error.contains("is not a finite number"), "{error}");
    let scene = scene(block(4, 1, 1, 0.1, 0.02, 0.02, Order::Linear), SCENE);
    let mut record =
        durometer::study::store::finished_run::record(&scene, &scene.run(), Spent { wall_s: 1.0, cpu_s: 1.0 });
    assert!(folder::json(&record).is_ok());
    record.wall_s = f64::NAN;
    assert!(folder::json(&record).expect_err("no reader takes it").contains("no reader takes"));
}

/// Names of regions, labels and units are text, whatever they hold.
#[test]
fn names_are_text() {
    let regions = "[mesh.regions]\n'left, \"part\" <b>' = { kind = \"plane\", point = [\"0 mm\", \"0 mm\", \"0 mm\"], normal = [1, 0, 0], \
                   tolerance = \"1 mm\" }\n[laws.rubber]";
    let probe = "[[probe]]\nkind = \"position\"\nregion = 'left, \"part\" <b>'\n";
    let scene = format!("{}{probe}", SCENE.replace("[laws.rubber]", regions));
    let labels = [r#"left, \"part\" <b>"#, r"\u001b[31m red", r"\ue000 open", r"o\u0301\u0302 \u20d7", r"\u202e back"];
    for label in labels {
        let study = STUDY.replace("label = \"force\"", &format!("label = \"{label}\""));
        let keep = folder(&scene, &study.replace("\"F\"", &format!("\"{label}\"")));
        assert!(run_folder(keep.path()).iter().all(CaseRecord::converged));
        let said = report::write_report(&keep.path().join("results")).unwrap_or_else(|e| panic!("{label}: {e}"));
        assert!(!said.warnings.join("\n").contains("without a figure"), "{label}: {:?}", said.warnings);
        let page = std::fs::read_to_string(keep.path().join("results/index.html")).expect("written");
        assert!(!page.contains("<b>'") && !page.contains("\" <b>"), "{label}");
    }
}

/// A rod that is 1700 times as long as wide, and upright: its figures fit on a page.
#[test]
fn figures_of_slender_bodies_fit_on_a_page() {
    let rod = SCENE.replace("\"100 mm\", \"20 mm\", \"20 mm\"", "\"0.3 mm\", \"0.3 mm\", \"500 mm\"");
    let rod = rod.replace("xmin", "zmin").replace("xmax", "zmax").replace("components = \"x\"", "components = \"z\"");
    let study = STUDY.replace("xmax_reaction_x_N", "zmax_reaction_z_N");
    let keep = folder(&rod, &study.replace("[4, 1, 1]", "[1, 1, 8]").replace("[8, 2, 2]", "[1, 1, 16]"));
    assert!(run_folder(keep.path()).iter().all(CaseRecord::converged));
    let results = keep.path().join("results");
    let said = report::write_report(&results).unwrap_or_else(|e| panic!("{e}"));
    assert!(!said.warnings.join("\n").contains("without a figure"), "{:?}", said.warnings);
    for name in ["meshes", "bent"] {
        let bytes = std::fs::read(results.join(format!("figures/{name}.png"))).expect("drawn");
        let [wide, tall] = [16, 20].map(|k| u32::from_be_bytes(bytes[k..k + 4].try_into().expect("four bytes")));
        assert!(wide < 4000 && tall < 4000, "{name}: {wide} x {tall}");
    }
    let tall = figure(100.0, 1e6, "", |_| {});
    assert!(png("tall", &tall).expect_err("too large").to_string().contains("too large to rasterise"));
}

/// Stored files that a crash or a hand has damaged: the report goes on, and the next run computes the case again.
#[test]
fn damaged_results_do_not_block_a_study() {
    let keep = folder(SCENE, STUDY);
    run_folder(keep.path());
    let results = keep.path().join("results");
    let cases = results.join("cases");
    let surface = |points: &str| {
        format!(
            "{{\"points\":{points},\"triangles\":[[0,1,2]],\"t_s\":1.0,\"displacement\":[[0,0,0],[0,0,0],[0,0,0]],\"stretch\":[1,1,1],\"cables\":[]}}"
        )
    };
    let skin = cases.join("sizes-pull-b.skin.json.gz");
    for content in
        ["", "{", "\u{1f}\u{8b}", &surface("[[0,0,0],[1,0,0],[0,0,1e9]]"), &surface("[[0,0,0],[1,0,0],[0,0,1e300]]")]
    {
        std::fs::write(&skin, content).expect("writable");
        report::write_report(&results).unwrap_or_else(|e| panic!("{content}: {e}"));
    }
    let path = cases.join("sizes-pull-a.json");
    let text = std::fs::read_to_string(&path).expect("stored");
    let stored: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    for cpu in [5e-324, 1e308, 0.0] {
        let mut changed = stored.clone();
        changed["cpu_s"] = cpu.into();
        changed["wall_s"] = cpu.into();
        std::fs::write(&path, changed.to_string()).expect("writable");
        report::write_report(&results).unwrap_or_else(|e| panic!("{cpu}: {e}"));
    }
    for name in ["sizes-pull-a.csv", "sizes-pull-b.skin.json.gz", "sizes-pull-a.json"] {
        std::fs::write(cases.join(name), "").expect("writable");
    }
    assert!(run_folder(keep.path()).iter().all(CaseRecord::converged));
    let said = report::write_report(&results).unwrap_or_else(|e| panic!("{e}"));
    assert!(!said.warnings.join("\n").contains("damaged"), "{:?}", said.warnings);
}

/// A controller whose line does not end is refused, and does not fill the memory.
#[test]
fn an_endless_line_of_a_controller_is_refused() {
    let drive = "{ kind = \"ramp\", from = \"0 mm\", to = \"20 mm\", end = \"1 s\" }";
    let scene = scene(
        block(4, 1, 1, 0.1, 0.02, 0.02, Order::Linear),
        &SCENE.replace(drive, "{ kind = \"controlled\", initial = \"0 mm\" }"),
    );
    let mut endless =
        Process::start("sh -c 'tr \"\\000\" x < /dev/zero'", Duration::from_secs(30), None).expect("it starts");
    let run = scene.run_with(RunOptions { controller: Some(&mut endless), ..RunOptions::default() });
    let why = run.failure.expect("refused").to_string();
    assert!(why.contains("this line has more than 16 MiB"), "{why}");
}

/// Text of any characters is drawn, or its figure is refused; nothing panics.
#[test]
fn any_text_is_drawn_or_refused() {
    let mut random = durometer::math::random::SplitMix(7);
    let odd = [
        '\u{301}',
        '\u{e01}',
        '\u{e33}',
        '\u{64b}',
        '\u{20d7}',
        '\u{200d}',
        '\u{202e}',
        '\u{e000}',
        '\u{e001}',
        '\u{0}',
        '\u{fffe}',
        '\u{1f600}',
        'a',
        ' ',
        '<',
        '&',
        '\u{ad}',
        '\u{115f}',
        '\u{fe0f}',
    ];
    let mut draw = || -> String {
        let length = (random.unit() * 6.0) as usize;
        (0..length).map(|_| odd[(random.unit() * odd.len() as f64) as usize % odd.len()]).collect()
    };
    for _ in 0..400 {
        let (words, symbol) = (draw(), draw());
        let svg = figure(60.0, 30.0, "", |area| {
            text(area, &format!("{words} {}{words}", italic(&symbol)), (200, 200), At::Left, LABEL, INK);
            text(area, &words, (300, 400), At::Turned, LABEL, INK);
        });
        assert!(Pictures::of("any", &svg).is_ok(), "{words:?} {symbol:?}");
    }
}

/// A folder of somebody else with a mesher and a Python in it: neither is started by a program that happens to run there.
#[test]
fn the_mesher_of_a_foreign_folder_is_not_run() {
    use std::os::unix::fs::PermissionsExt;
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    for folder in ["meshes/meshgen", ".venv/bin"] {
        std::fs::create_dir_all(at.join(folder)).expect("writable");
    }
    let (python, trace) = (at.join(".venv/bin/python"), at.join("started"));
    std::fs::write(&python, format!("#!/bin/sh\ntouch '{}'\n", trace.display())).expect("writable");
    std::fs::set_permissions(&python, PermissionsExt::from_mode(0o755)).expect("ours");
    for arguments in [&["doctor"][..], &["check", "scene.toml"]] {
        std::fs::write(at.join("scene.toml"), SCENE).expect("writable");
        let mut command = Command::new(env!("CARGO_BIN_EXE_durometer"));
        command.args(arguments).current_dir(at).env_remove("DUROMETER_HOME").env_remove("DUROMETER_PYTHON");
        command.output().expect("the program runs");
        assert!(!trace.exists(), "{arguments:?}");
    }
}
