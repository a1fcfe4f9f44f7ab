//! The command line as a user meets it: what it says, what it leaves on disk, its exit codes.

use crate::common::program::{self, ROOT, ended, without_mesher};
use crate::common::stores::{assert_same, contents};
use crate::common::tools;
use durometer::math::statistics::smaller;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

const SCENE: &str = "tests/cli/scene.toml";
const STUDY: &str = "tests/cli/study.toml";
/// Shortens the cable beyond its length in one case: that one cannot complete.
const OVERPULL: &str = "tests/cli/overpull/study.toml";

/// Standard output of a call that must end with `code`.
fn call(arguments: &[&str], code: i32) -> String {
    program::call(ROOT, arguments, code).0
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A temporary folder and its path as text.
fn folder() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().to_str().expect("UTF-8").to_string();
    (folder, path)
}

/// Columns of a CSV by name.
fn table(path: &Path) -> BTreeMap<String, Vec<f64>> {
    let text = read(path);
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let mut columns: BTreeMap<String, Vec<f64>> = names.iter().map(|n| (n.to_string(), Vec::new())).collect();
    for line in lines {
        let values: Vec<f64> = line.split(',').map(|x| x.parse().expect("a number")).collect();
        assert_eq!(values.len(), names.len(), "{line}");
        names.iter().zip(values).for_each(|(n, v)| columns.get_mut(*n).expect("named").push(v));
    }
    columns
}

/// Two scenes of one study, each with the file `m.msh` of its own folder; the second one holds quadratic cells.
#[test]
fn check_reads_the_mesh_of_each_scene() {
    let (keep, _) = folder();
    let suite = |name: &str| {
        format!(
            r#"
[[suite]]
name = "{name}"
setup = "A cable is shortened."
scene = "{name}/scene.toml"
variants = ["plain"]
[suite.members]
pull = {{}}
[[suite.check]]
what = "tension"
measured = "cable_tension_N"
reference = "cable_tension_N"
accept = "1e-8"
source = "itself"
"#
        )
    };
    let scene = read(&Path::new(ROOT).join(SCENE)).replace("../bad/good/boxes.msh", "m.msh");
    for (name, mesh) in [("linear", "boxes.msh"), ("quadratic", "boxes-order2-binary.msh")] {
        let at = keep.path().join(name);
        std::fs::create_dir(&at).expect("room");
        std::fs::write(at.join("scene.toml"), &scene).expect("room");
        std::fs::copy(Path::new(ROOT).join("tests/bad/good").join(mesh), at.join("m.msh")).expect("room");
    }
    let head = "kind = \"robustness\"\nquestion = \"Is each mesh read?\"\nexpectation = \"Yes.\"\nscene = \"linear/scene.toml\"\n\
                tolerance = \"5 %\"\n[[variant]]\nname = \"plain\"\nlabel = \"plain\"\nset = {}\n";
    let file = keep.path().join("study.toml");
    std::fs::write(&file, head.to_string() + &suite("linear") + &suite("quadratic")).expect("room");
    let output = ended(without_mesher(ROOT, &["check", file.to_str().expect("UTF-8")]));
    let errors = output.err;
    assert_eq!(output.code, Some(2), "{errors}");
    assert!(errors.contains("the file holds tet10 cells"), "{errors}");
}

/// Where DUROMETER_PYTHON names the Python of the mesher, no environment of the program helps it.
#[cfg(unix)]
#[test]
fn the_doctor_helps_the_python_that_is_named() {
    let (keep, _) = folder();
    std::fs::create_dir_all(keep.path().join("meshes/meshgen")).expect("room");
    let answer =
        r#"{"ok":false,"versions":{"meshio":null},"errors":{"meshio":{"error":"No module named meshio"}},"fix":[]}"#;
    let mesher = keep.path().join("mesher");
    let doctor = || ended(without_mesher(keep.path(), &["doctor"]));
    for (version, remedy) in [
        (
            "3.12.1",
            format!(
                "run: {0} -m pip install -r {1}/meshes/meshgen/requirements.txt",
                mesher.display(),
                keep.path().display()
            ),
        ),
        ("3.10.1", "run: unset DUROMETER_PYTHON, or let it name a Python 3.11 or newer".into()),
    ] {
        let script = format!("#!/bin/sh\ncase \"$*\" in *--doctor) echo '{answer}' ;; -c*) echo {version} ;; esac\n");
        // Written under another name first: a file that is open for writing cannot be run
        let part = keep.path().join("part");
        std::fs::write(&part, script).expect("room");
        std::fs::set_permissions(&part, std::os::unix::fs::PermissionsExt::from_mode(0o755)).expect("own file");
        std::fs::rename(&part, &mesher).expect("room");
        let said = doctor();
        assert!(said.code == Some(2) && said.out.contains(&remedy) && !said.out.contains("--setup"), "{}", said.said());
    }
}

/// The volume of a grid is that of its round body, which has not the shape that formulas give.
#[test]
fn the_volume_before_formulas_is_told_as_such() {
    let (keep, _) = folder();
    let rest = "[laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
                [[constraint]]\nkind = \"fixed\"\nregion = \"zmin\"\n[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n";
    let bar = "[mesh]\ngrid = { kind = \"cylinder\", radius = \"5 mm\", length = \"60 mm\", divisions = [2, 12] }\n";
    let (plain, deformed) = (format!("{bar}{rest}"), format!("{bar}[mesh.deform]\nx = \"2 * X\"\n{rest}"));
    for (name, mesh, is_before) in [("plain", plain, false), ("deformed", deformed, true)] {
        let file = keep.path().join(format!("{name}.toml"));
        std::fs::write(&file, mesh).expect("room");
        let said = ended(without_mesher(ROOT, &["mesh", file.to_str().expect("UTF-8")]));
        let line =
            said.out.lines().find(|line| line.starts_with("volume ")).unwrap_or_else(|| panic!("{}", said.said()));
        assert_eq!(line.ends_with(" %, before [mesh.deform]"), is_before, "{line}");
    }
}

/// Of cases that cannot be run `check` says each fact, and the others are listed.
#[test]
fn check_names_every_refused_case() {
    let (keep, _) = folder();
    let scene = Path::new(ROOT).join(SCENE);
    let study = read(&Path::new(ROOT).join(STUDY)).replace("scene.toml", scene.to_str().expect("UTF-8"));
    let members = r#"
far = { "constraint.1.drive.signal.amplitude" = "200 mm" }
far_in_fine_steps = { "constraint.1.drive.signal.amplitude" = "200 mm", "stage.0.dt" = "0.125 s" }
nowhere = { "probe.0.tip" = "nowhere" }
"#;
    let file = keep.path().join("study.toml");
    std::fs::write(&file, study.trim_end().to_string() + members).expect("room");
    let output = ended(without_mesher(ROOT, &["check", file.to_str().expect("UTF-8")]));
    let (out, errors) = (output.out, output.err);
    assert_eq!(output.code, Some(2), "{out}\n{errors}");
    let said: Vec<&str> = errors.lines().collect();
    assert_eq!(said[0], "error: 3 cases cannot be run:");
    assert!(said[1].starts_with("  dt-length-far and 1 more: ") && said[1].contains("only 27.0000 mm"), "{errors}");
    assert!(said[2].starts_with("  dt-length-nowhere: ") && said[2].contains("no region \"nowhere\""), "{errors}");
    assert!(out.contains("dt-length-fine"), "{out}");
}

/// A beam above a table, with a region that nothing uses and one that another region is made of.
const TABLE: &str = r#"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [4, 2, 2] }
[mesh.regions]
end = { kind = "box", min = ["19 mm", "-1 mm", "-1 mm"], max = ["21 mm", "11 mm", "11 mm"] }
most = { kind = "complement", of = ["end"] }
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[contact]]
name = "table"
region = "zmin"
obstacle = { kind = "floor", point = ["0 mm", "0 mm", "-5 mm"], normal = [0, 0, 1] }
response = "penalty"
friction = 0.5
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#;

/// Contacts are listed as such, with their friction; what the scene does not have is named, and so are regions that nothing uses.
#[test]
fn check_lists_contacts_and_unused_regions() {
    let (keep, _) = folder();
    let file = keep.path().join("scene.toml");
    std::fs::write(&file, TABLE).expect("room");
    let check = || call(&["check", file.to_str().expect("UTF-8")], 0);
    let said = check();
    let contacts: Vec<&str> = said.lines().filter(|line| line.starts_with("contact ")).collect();
    assert_eq!(contacts.len(), 2, "{said}");
    assert!(contacts.iter().all(|line| line.contains(": floor, region zmin, penalty, friction 0.5")), "{said}");
    assert!(contacts[0].contains(", distance ") && contacts[0].contains(" mm, modulus 100000 Pa, "), "{said}");
    assert!(!said.contains("load of a constraint"), "{said}");
    let absent = said.split("not there").nth(1).expect("a list");
    assert!(absent.contains("\n             rigid bodies\n") && !absent.contains("\n             contact\n"), "{said}");
    assert!(said.contains("nothing uses the region most\n") && !said.contains("the region end\n"), "{said}");
    let probe = TABLE.to_string() + "[[probe]]\nkind = \"position\"\nregion = \"most\"\n";
    std::fs::write(&file, probe).expect("room");
    assert!(!check().contains("nothing uses"), "{}", check());
}

/// A case whose right end is a stated reason is done, not incomplete; a map counts an inaccurate answer as what it looks for.
#[test]
fn an_expected_end_is_complete() {
    let (_keep, out) = folder();
    let said = call(&["robustness", "--quick", "--only", "crumpled-refused", "--out", &out], 0);
    assert!(said.contains("Of 2 cases, 2 stop as demanded, and none fails."), "{said}");
}

#[test]
fn help_names_every_command_and_each_has_an_example() {
    let help = call(&["--help"], 0);
    for name in ["run", "cases", "simulate", "mesh", "fit", "check", "report", "store", "doctor"] {
        assert!(help.lines().any(|l| l.trim_start().starts_with(&format!("{name} "))), "{name} in {help}");
        let own = call(&[name, "--help"], 0);
        assert!(own.contains("Example") && own.contains(&format!("durometer {name}")), "{own}");
        let options = own.split("Options:").nth(1).expect("options").split("Example").next().expect("a part");
        let (mut lines, mut bare) = (options.lines().peekable(), Vec::new());
        while let Some(line) = lines.next().map(str::trim) {
            // The words are next to the option or below it.
            let words =
                line.split("  ").nth(1).is_some() || lines.peek().is_some_and(|next| next.starts_with("      "));
            if line.starts_with("--") && !words {
                bare.push(line.to_string());
            }
        }
        assert!(bare.is_empty(), "{name}: options without a word of help: {bare:?}");
    }
    assert!(help.contains("Exit codes"));
}

/// A file of Linux that is a disk without room.
#[cfg(target_os = "linux")]
#[test]
fn an_output_without_room_is_an_error_and_results_are_written() {
    let (_keep, out) = folder();
    let full = || std::fs::File::options().write(true).open("/dev/full").expect("a device of Linux");
    for arguments in [
        &["check", SCENE][..],
        &["cases", STUDY, "--out", &out],
        &["schema", "scene"],
        &["studies"],
        &["fit", "--help"],
        &["run", STUDY, "--partition", "1/100000", "--out", &out, "--json"],
        &["simulate", SCENE, "--out", &out, "--json"],
    ] {
        let output = ended(without_mesher(ROOT, arguments).stdout(full()));
        let said = output.err;
        assert_eq!(output.code, Some(2), "{arguments:?}: {said}");
        let expected = "the standard output cannot be written: No space left on device";
        assert!(said.contains(expected) && !said.contains("panicked"), "{arguments:?}: {said}");
    }
    assert_eq!(json(&read(&Path::new(&out).join("scene.json")))["status"], "Converged");
}

/// A beam of split quadratic cells that lock too has a bar with a warning, and the mixed formulation one without. Its weight in full from the start, under which
/// it bends far, is answered with the remedy.
#[test]
fn bars_of_cells_that_lock_are_warned_of() {
    let (keep, out) = folder();
    let scene = keep.path().join("beam.toml");
    let said = |formulation: &str, acceleration: &str| {
        let text = format!(
            r#"title = "A beam under its weight"
[mesh]
grid = {{ kind = "box", size = ["80 mm", "10 mm", "10 mm"], divisions = [4, 1, 1] }}
element = "tet10"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.499
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "{formulation}"
[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = {acceleration}
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.2 s"
[[probe]]
kind = "position"
region = "xmax"
"#
        );
        std::fs::write(&scene, text).expect("room");
        let path = scene.to_str().expect("UTF-8");
        let output =
            ended(without_mesher(ROOT, &["simulate", path, "--error", "xmax_z_m", "--out", &out, "--no-view"]));
        (output.code, output.err)
    };
    let growing = r#"{ kind = "ramp", from = "0 m/s^2", to = "1 m/s^2", end = "1 s" }"#;
    for (formulation, locks) in [("displacement", true), ("mixed", false)] {
        let (code, errors) = said(formulation, growing);
        assert_eq!((code, errors.contains("are estimated lock too")), (Some(0), locks), "{formulation}: {errors}");
    }
    let (code, errors) = said("displacement", "\"9.81 m/s^2\"");
    assert!(code == Some(3) && errors.contains("let them grow"), "{code:?}: {errors}");
}

/// What cannot be said is lost, not the command.
#[cfg(target_os = "linux")]
#[test]
fn messages_without_room_end_no_command() {
    let (_keep, out) = folder();
    for (arguments, code) in
        [(&["simulate", SCENE, "--out", &out][..], 0), (&["check", "no-such.toml"], 2), (&["no-such"], 2)]
    {
        let full = std::fs::File::options().write(true).open("/dev/full").expect("a device of Linux");
        let output = ended(without_mesher(ROOT, arguments).stderr(full));
        assert_eq!(output.code, Some(code), "{arguments:?}");
    }
}

#[test]
fn more_threads_than_a_machine_can_use_are_refused() {
    let fit = ["fit", "data/treloar-1944/treloar-1944.csv", "--law", "yeoh", "--threads", "5000"];
    for arguments in [&["run", STUDY, "--jobs", "5000"][..], &["simulate", SCENE, "--threads", "5000"], &fit] {
        let output = ended(without_mesher(ROOT, arguments));
        let said = output.err;
        assert!(output.code == Some(2) && said.contains("only wait for each other"), "{arguments:?}: {said}");
    }
}

/// A fit starts and profiles its constants on the threads that it is given.
#[test]
fn a_fit_has_the_same_law_on_any_number_of_threads() {
    let (_keep, out) = folder();
    let [one, three] = ["1", "3"].map(|threads| {
        let (dir, table) = (format!("{out}/{threads}"), "data/treloar-1944/treloar-1944.csv");
        call(&["fit", table, "--law", "yeoh", "--mode", "uniaxial", "--threads", threads, "--out", &dir], 3);
        read(&Path::new(&dir).join("law.toml"))
    });
    assert_eq!(one, three);
}

#[test]
fn check_says_what_is_assembled_and_nothing_more() {
    let said = call(&["check", SCENE], 0);
    let line = |word: &str| said.lines().find(|l| l.starts_with(word)).unwrap_or_else(|| panic!("{word}: {said}"));
    assert_eq!(said.lines().filter(|l| l.starts_with("effect ")).count(), 1, "{said}");
    assert!(line("effect ").contains("elastic (48 blocks)"));
    assert!(line("constraint ").contains("cable"));
    assert!(line("stage ").ends_with("4 steps of 0.25 s"), "{}", line("stage "));
    assert!(
        line("unknowns ").split_whitespace().nth(1).is_some_and(|n| n.trim_end_matches(',').parse::<usize>().is_ok())
    );
    assert!(line("signal ").contains("cable_shortening_m between 0 and 0.002"), "{}", line("signal "));
    assert!(said.contains("nothing else is assembled"));
    // What check announces is what simulate records.
    let (_keep, out) = folder();
    call(&["simulate", SCENE, "--out", &out], 0);
    let header = read(&Path::new(&out).join("scene.csv"));
    for column in header.lines().next().expect("a header").split(',') {
        assert!(said.contains(column), "{column} is recorded, but not announced");
    }
    let study = call(&["check", STUDY], 0);
    for case in ["sizes-length-nominal", "dt-length-coarse", "dt-length-fine"] {
        assert!(study.lines().any(|l| l.trim_start().starts_with(case)), "{study}");
    }
    assert!(!study.contains("dt-length-nominal"), "the same scene is one case");
}

#[test]
fn simulate_writes_series_signals_record_and_fields() {
    let (_keep, out) = folder();
    let said = call(&["simulate", SCENE, "--out", &out, "--vtu", "--json"], 0);
    let record = json(&said);
    assert_eq!(record["status"], "Converged");
    assert_eq!(record["steps"], 4);
    let out = PathBuf::from(out);
    assert_eq!(json(&read(&out.join("scene.json"))), record);
    let series = table(&out.join("scene.csv"));
    assert_eq!(series["t_s"], [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert!(series["bending_angle_deg"][2] > 5.0 && series["cable_tension_N"][2] > 0.0);
    assert!(series["cable_tension_N"].iter().all(|t| *t >= 0.0), "a cable cannot push");
    for (name, probe) in record["probes"].as_object().expect("probes") {
        // The peak is the sample farthest from the start.
        let (first, peak) = (series[name][0], probe["peak"].as_f64().expect("a number"));
        assert!(series[name].contains(&peak), "{name}");
        assert!(series[name].iter().all(|v| (v - first).abs() <= (peak - first).abs()), "{name}");
    }
    // The signal is ½A(1 − cos 2πft), and the length follows it while the cable is taut.
    let signals = table(&out.join("scene.signals.csv"));
    for (k, d) in signals["cable_shortening_m"].iter().enumerate() {
        let exact = 1e-3 * (1.0 - (std::f64::consts::TAU * signals["t_s"][k]).cos());
        assert!((d - exact).abs() < 1e-15);
        let length = series["cable_length_m"][k];
        let taut = series["cable_tension_N"][k] > 0.0;
        assert!(!taut || (series["cable_length_m"][0] - d - length).abs() < 1e-8 * length);
    }
    let pvd = read(&out.join("scene.pvd"));
    for k in 0..5 {
        let frame = format!("scene-{k:04}.vtu");
        assert!(pvd.contains(&frame) && out.join(&frame).is_file(), "{frame}");
    }
}

/// A later run leaves nothing of an earlier one next to its own files, but for saved states and files of others.
#[test]
fn a_later_run_removes_what_it_has_not_written() {
    let (keep, out) = folder();
    call(&["simulate", SCENE, "--out", &out, "--vtu", "--save-state", "end"], 0);
    std::fs::write(keep.path().join("scene.notes.txt"), "mine").expect("writable");
    let names = || -> BTreeSet<String> {
        let entries = std::fs::read_dir(keep.path()).expect("a folder").flatten();
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
    };
    assert!(["scene.html", "scene.pvd", "scene-0000.vtu"].iter().all(|file| names().contains(*file)));
    call(&["simulate", SCENE, "--out", &out, "--no-view"], 0);
    let left = [".scene.lock", "scene-end.state", "scene.csv", "scene.json", "scene.notes.txt", "scene.signals.csv"];
    assert_eq!(names(), left.map(String::from).into());
}

/// Folders of the user in the folder of the results stay, whatever their names and ages.
#[test]
#[cfg(unix)]
fn folders_of_the_user_stay() {
    let (keep, out) = folder();
    let mine = keep.path().join("next/thesis");
    std::fs::create_dir_all(&mine).expect("writable");
    std::fs::write(mine.join("data.csv"), "mine").expect("writable");
    let hour = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
    std::fs::File::open(&mine).and_then(|folder| folder.set_modified(hour)).expect("an own folder");
    call(&["simulate", SCENE, "--out", &out, "--no-view"], 0);
    assert!(mine.join("data.csv").is_file());
}

/// A run that cannot replace all files leaves no record next to a series of another run, and `report` tells one that comes there in another way.
#[test]
fn a_record_is_that_of_the_series_next_to_it() {
    let (keep, out) = folder();
    let [series, signals, record] = ["scene.csv", "scene.signals.csv", "scene.json"].map(|name| keep.path().join(name));
    call(&["simulate", SCENE, "--out", &out, "--no-view"], 0);
    let before = std::fs::read(&series).expect("written");
    call(&["report", record.to_str().expect("UTF-8")], 0);
    std::fs::remove_file(&signals).expect("written");
    std::fs::create_dir(&signals).expect("writable");
    let softer = ["simulate", SCENE, "--out", &out, "--no-view", "--set", "laws.rubber.nu=0.4"];
    call(&softer, 2);
    assert!(std::fs::read(&series).expect("written") != before && !record.exists());
    std::fs::remove_dir(&signals).expect("empty");
    call(&softer, 0);
    std::fs::write(&series, before).expect("writable");
    let (_, error) = program::call(ROOT, &["report", record.to_str().expect("UTF-8")], 2);
    assert!(error.contains("scene.csv: its contents are not those that were stored with"), "{error}");
    let copy = keep.path().join("kept.json");
    std::fs::copy(&record, &copy).expect("writable");
    call(&["report", copy.to_str().expect("UTF-8")], 0);
}

/// Where another process has the right to the name, nothing is run.
#[test]
fn a_second_run_of_a_name_is_refused() {
    let (keep, out) = folder();
    let rows = std::fs::File::create(keep.path().join(".scene.lock")).expect("writable");
    rows.try_lock().expect("nobody else");
    let output = ended(without_mesher(ROOT, &["simulate", SCENE, "--out", &out]));
    let said = output.err;
    assert!(output.code == Some(2) && said.contains("another process runs a scene of this name"), "{said}");
    drop(rows);
    call(&["simulate", SCENE, "--out", &out], 0);
}

/// A limit on the size of files, as batch systems set one, is an error of writing, and the rows of the run are kept.
#[test]
#[cfg(unix)]
fn a_limit_on_the_size_of_files_is_told() {
    let (keep, out) = folder();
    let program = env!("CARGO_BIN_EXE_durometer");
    let line = format!("ulimit -f 4; exec '{program}' simulate {SCENE} --out '{out}'");
    let output = ended(Command::new("sh").args(["-c", &line]).current_dir(ROOT));
    let said = output.err;
    assert!(output.code == Some(2) && said.contains("cannot be written: File too large"), "{said}");
    assert!(keep.path().join("scene.partial.csv").is_file(), "{said}");
}

#[test]
fn a_change_on_the_command_line_changes_the_result() {
    let tension = |set: &[&str]| {
        let (_keep, out) = folder();
        let mut arguments = vec!["simulate", SCENE, "--out", &out, "--json"];
        set.iter().for_each(|s| arguments.extend(["--set", s]));
        json(&call(&arguments, 0))["probes"]["cable_tension_N"]["peak"].as_f64().expect("a number")
    };
    // Statics under an imposed length: the tension is proportional to the stiffness.
    let (soft, stiff) = (tension(&[]), tension(&["laws.rubber.E=200 kPa"]));
    assert!((stiff / soft - 2.0).abs() < 1e-6, "{soft} {stiff}");
    let imposed =
        tension(&[r#"constraint.cable.drive={ kind = "tension", signal = "0.05 N" }"#, "numerics.tolerance=1e-9"]);
    assert_eq!(imposed, 0.05);
}

/// C10 + C01λ² falls below zero at λ = 1.58, and in equibiaxial tension stability ends before, within the stretches that are looked at.
#[test]
fn a_law_that_loses_stability_is_noted() {
    let law =
        r#"laws.rubber={ law = "mooney_rivlin", C10 = "20 kPa", C01 = "-8 kPa", nu = 0.49, volumetric = "quadratic" }"#;
    let said = call(&["check", SCENE, "--set", law], 0);
    assert!(said.contains("note         laws.rubber (mooney_rivlin) is not stable"), "{said}");
    assert!(said.contains("equibiaxial at 1.2") || said.contains("equibiaxial at 1.3"), "{said}");
    assert!(!call(&["check", SCENE], 0).contains("is not stable"));
}

/// A material of Abaqus that relaxes becomes a law of the long term and a series; without a file for the series nothing is written.
#[test]
fn an_imported_law_keeps_its_relaxation() {
    let (_folder, out) = folder();
    let file = |name: &str| format!("{out}/{name}");
    let input = "*MATERIAL, NAME=R\n*HYPERELASTIC, NEO HOOKE, MODULI=INSTANTANEOUS\n50, 1e-3\n*VISCOELASTIC, TIME=PRONY\n0.25, 0, 2\n";
    std::fs::create_dir_all(&out).expect("writable");
    std::fs::write(file("r.inp"), input).expect("writable");
    let (data, law, series) = (file("r.inp"), file("law.toml"), file("prony.toml"));
    let import = ["laws", "import", &data, "--from", "abaqus", "--unit", "kPa", "--out", &law];
    let refused = ended(without_mesher(ROOT, &import));
    let message = refused.err;
    assert!(refused.code == Some(2) && message.contains("pass --prony prony.toml"), "{message}");
    assert!(!Path::new(&law).exists());
    call(&[&import[..], &["--prony", &series]].concat(), 0);
    let (law, series): (toml::Table, toml::Table) =
        (read(Path::new(&law)).parse().expect("TOML"), read(Path::new(&series)).parse().expect("TOML"));
    assert_eq!(law["mu"].as_str(), Some("75000 Pa"));
    assert!(law["source"].as_str().is_some_and(|s| s.ends_with("constants of the long term")), "{law}");
    assert_eq!(series["prony"].to_string(), "[{ g = 0.25, tau = \"2 s\" }]");
    std::fs::write(&data, "*HYPERELASTIC, NEO HOOKE\n50, 1e-3\n").expect("writable");
    let message = ended(without_mesher(ROOT, &[&import[..], &["--prony", "p.toml"]].concat())).err;
    assert!(message.contains("does not relax; leave out --prony"), "{message}");
}

#[test]
fn an_export_names_the_flags_of_what_the_law_file_lacks() {
    let (_folder, out) = folder();
    std::fs::create_dir_all(&out).expect("writable");
    let law = format!("{out}/law.toml");
    std::fs::write(&law, "law = \"mooney_rivlin\"\nC10 = \"75 kPa\"\nC01 = \"5 kPa\"\n").expect("writable");
    let export = ["laws", "export", &law, "--to", "calculix", "--unit", "MPa"];
    let refused = ended(without_mesher(ROOT, &export));
    let message = refused.err;
    assert!(refused.code == Some(2) && message.contains("--volumetric quadratic --nu 0.49"), "{message}");
    call(&[&export[..], &["--volumetric", "quadratic", "--nu", "0.49"]].concat(), 0);
    std::fs::write(&law, "law = \"neo_hookean\"\nmu = \"75 kPa\"\n").expect("writable");
    let refused = ended(without_mesher(ROOT, &export));
    assert!(refused.code == Some(2) && refused.err.contains("pass for example --nu 0.49"), "{}", refused.err);
    call(&[&export[..], &["--nu", "0.49"]].concat(), 0);
    // What the file has already is not replaced
    std::fs::write(&law, "law = \"yeoh\"\nC10 = \"50 kPa\"\nnu = 0.45\nvolumetric = \"logarithmic\"\n")
        .expect("writable");
    call(&export, 0);
    for (flag, value, own) in
        [("--nu", "0.49", "nu = 0.45"), ("--volumetric", "quadratic", "volumetric = \"logarithmic\"")]
    {
        let (_, said) = program::call(ROOT, &[&export[..], &[flag, value]].concat(), 2);
        assert!(said.contains(&format!("the law has {own} already; leave out {flag}")), "{said}");
    }
}

/// Two rows and six constants: a law is written, with the warning, and the exit code says that it is not determined.
#[test]
fn an_undetermined_fit_ends_with_code_3() {
    let (_keep, out) = folder();
    let csv = PathBuf::from(&out).join("two.csv");
    std::fs::create_dir_all(&out).expect("a folder");
    std::fs::write(&csv, "stretch,nominal stress (MPa)\n1.2,0.1\n1.5,0.2\n").expect("writable");
    let csv = csv.display().to_string();
    let said = call(&["fit", &csv, "--law", "ogden", "--terms", "3", "--mode", "uniaxial", "--out", &out], 3);
    assert!(said.contains("not determined by the data") && said.contains("unidentifiable"), "{said}");
    let page = read(&PathBuf::from(&out).join("index.html"));
    assert!(page.contains("not determined"));
    let other = ["fit", &csv, "--law", "neo_hookean", "--mode", "uniaxial", "--out", &out];
    call(&other, 2);
    call(&[&other[..], &["--replace"]].concat(), 0);
    let twice = ["--accuracy", "stress_scale=2%", "--accuracy", "stress_scale=5%"];
    let (_, said) = program::call(ROOT, &[&other[..], &twice].concat(), 2);
    assert!(said.contains("the scale of the stress is given twice"), "{said}");
    let all = ["fit", "data/treloar-1944/treloar-1944.csv", "--law", "all", "--mode", "planar", "--out", &out];
    call(&all, 2);
    for flag in [["--nu", "0.7"], ["--volumetric", "bogus"], ["--terms", "2"], ["--kappa", "2 GPa"]] {
        let refused = program::call(ROOT, &[&all[..], &["--replace"], &flag].concat(), 2).1;
        assert!(refused.contains(&format!("{} does not go with --law all", flag[0])), "{refused}");
    }
    let all = call(&[&all[..], &["--replace"]].concat(), 0);
    assert!(all.contains("cross-mode") && PathBuf::from(&out).join("compare.json").is_file(), "{all}");
    assert!(!PathBuf::from(&out).join("law.toml").exists(), "of the fit before");
}

/// Every command with a folder of its own: the same again is written anew, another command or another table is refused and changes nothing.
#[test]
fn results_of_others_are_replaced_only_when_asked() {
    let (keep, out) = folder();
    let file = |name: &str, text: &str| {
        let path = keep.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(&path, text).expect("writable");
        path.to_str().expect("UTF-8").to_string()
    };
    let lateral = |nu: f64| {
        let row = |k: i32| format!("{},{}\n", 0.02 * f64::from(k), -nu * 0.02 * f64::from(k) + 1e-4 * f64::from(k % 3));
        format!("strain [1],lateral strain [1]\n{}", (0..12).map(row).collect::<String>())
    };
    let decay = |tau: f64| {
        let row = |k: i32| 0.05 * 1.5_f64.powi(k);
        let row = |k| format!("{},{}\n", row(k), 50.0 + 40.0 * (-row(k) / tau).exp() + 0.1 * f64::from(k % 3));
        format!("time [s],stress [kPa]\n{}", (0..20).map(row).collect::<String>())
    };
    let motion = |name: &str| format!("{ROOT}/tests/motion/{name}.csv");
    let [volume, prony, track] = ["volume", "prony", "motion"].map(|name| format!("{out}/{name}"));
    let commands = [
        (
            vec!["volume", "--experiment", "lateral", "--out", &volume],
            file("a/t.csv", &lateral(0.4)),
            file("b/t.csv", &lateral(0.3)),
        ),
        (
            vec!["prony", "--experiment", "relaxation", "--ramp", "0 s", "--terms", "1", "--out", &prony],
            file("a/r.csv", &decay(1.0)),
            file("b/r.csv", &decay(2.0)),
        ),
        (vec!["motion", "--body", "tip1,tip2,tip3", "--out", &track], motion("gravity_a"), motion("gravity_b")),
    ];
    let code = |arguments: &[&str]| {
        let output = ended(without_mesher(ROOT, arguments));
        (output.code.expect("no signal"), output.err)
    };
    for (words, table, other) in &commands {
        let (dir, of) = (words[words.len() - 1], |table| [&words[..1], &[table], &words[1..]].concat());
        for _ in 0..2 {
            let (done, said) = code(&of(table.as_str()));
            assert!(done != 2, "{words:?}: {said}");
        }
        let list = || read(&Path::new(dir).join("results.json"));
        let before = list();
        let fit =
            vec!["fit", "data/treloar-1944/treloar-1944.csv", "--law", "yeoh", "--mode", "uniaxial", "--out", dir];
        let plan = vec!["plan", SCENE, "--tolerance", "5 %", "--budget", "5 s", "--out", dir];
        for another in [of(other.as_str()), fit, plan, vec!["run", STUDY, "--out", dir]] {
            let (refused, said) = code(&another);
            let remedy =
                if another[0] == "run" { "--out" } else { "name another folder with --out, or pass --replace" };
            assert!(refused == 2 && said.contains(&format!("holds results of {}", words[0])), "{another:?}: {said}");
            assert!(said.contains(remedy), "{another:?}: {said}");
        }
        assert_eq!(list(), before, "{words:?}");
        assert!(code(&[&of(other.as_str())[..], &["--replace"]].concat()).0 != 2, "{words:?}");
        assert!(list() != before, "{words:?}");
    }
}

/// The files of a fit of several specimens go with it; a page that cannot be written leaves no law.
#[test]
fn a_folder_of_results_has_the_files_of_the_last_run() {
    let (keep, out) = folder();
    let tables = [1.0, 1.1, 0.95].map(|size| {
        let path = keep.path().join(format!("pull-{size}.csv"));
        let row = |k: i32| 1.0 + 0.05 * f64::from(k);
        let row = |k| format!("{},{}\n", row(k), size * 100.0 * (row(k) - row(k).powi(-2)) + 0.1 * f64::from(k % 3));
        let text = format!("stretch,stress (kPa)\n{}", (0..12).map(row).collect::<String>());
        std::fs::write(&path, text).expect("writable");
        path.to_str().expect("UTF-8").to_string()
    });
    let fit = |tables: &[String], out: &str, code: i32| {
        let files: Vec<&str> = tables.iter().map(String::as_str).collect();
        let options = ["--law", "neo_hookean", "--mode", "uniaxial", "--out", out, "--replace"];
        call(&[&["fit"], &files[..], &options].concat(), code)
    };
    let dir = PathBuf::from(&out).join("r");
    let at = dir.to_str().expect("UTF-8");
    fit(&tables, at, 0);
    std::fs::write(dir.join("tables/mine.csv"), "mine").expect("writable");
    let specimens = ["specimens.csv", "next-specimen.csv"].map(|name| dir.join("tables").join(name));
    assert!(specimens.iter().all(|file| file.is_file()));
    fit(&tables[..1], at, 0);
    assert!(!specimens.iter().any(|file| file.exists()), "of the fit before");
    assert!(dir.join("tables/mine.csv").is_file(), "of the user");
    let other = PathBuf::from(&out).join("other");
    std::fs::create_dir_all(other.join("index.html")).expect("a folder in the place of the page");
    fit(&tables, other.to_str().expect("UTF-8"), 2);
    assert!(!other.join("law.toml").exists() && !other.join("fit.json").exists());
}

/// The commands that read results name the folder that is meant, and none advises to delete a file of the user.
#[test]
fn a_study_file_is_no_result() {
    for command in [&["report", STUDY][..], &["compare", STUDY, STUDY], &["store", "verify", STUDY]] {
        let output = ended(without_mesher(ROOT, command));
        let said = output.err;
        assert_eq!(output.code, Some(2), "{command:?}: {said}");
        assert!(said.contains("that `durometer run STUDY`") && said.contains("give "), "{command:?}: {said}");
        assert!(!said.contains("delete"), "{command:?}: {said}");
    }
}

#[test]
fn finished_cases_are_kept_and_done_again_only_when_asked() {
    let (_keep, out) = folder();
    let dir = PathBuf::from(&out);
    let run = |more: &[&str]| json(&call(&[&["run", STUDY, "--out", &out, "--json"], more].concat(), 0));
    let files = || {
        let cases = std::fs::read_dir(dir.join("cases")).expect("cases").flatten();
        let stamp = |e: std::fs::DirEntry| (e.file_name(), e.metadata().and_then(|m| m.modified()).expect("a time"));
        cases.map(stamp).collect::<BTreeMap<_, _>>()
    };
    // One case first: the report shows what exists.
    let some = run(&["--only", "coarse"]);
    assert_eq!(some["cases"].as_array().map(Vec::len), Some(1));
    let summary = run(&[]);
    assert_eq!(summary["cases"].as_array().map(Vec::len), Some(3));
    for name in ["index.html", "summary.json", "study.json"] {
        assert!(dir.join(name).is_file(), "{name}");
    }
    let before = files();
    assert_eq!(before.len(), 9, "series, surface and record of three cases: {before:?}");
    let again = call(&["run", STUDY, "--out", &out], 0);
    assert!(again.contains("report:"));
    assert_eq!(files(), before, "nothing is done again");
    run(&["--redo", "--only", "fine"]);
    let after = files();
    for (name, time) in &after {
        let redone = name.to_string_lossy().starts_with("dt-length-fine");
        assert_eq!(before[name] != *time, redone, "{name:?}");
    }
    // Another scene: its cases are run, and results of the old one are not mixed with them.
    let changed = run(&["--set", "laws.rubber.nu=0.2", "--only", "coarse"]);
    assert_eq!(changed["cases"].as_array().map(Vec::len), Some(1), "{changed}");
    // The report can be drawn again from what is stored, without a mesher or a solver.
    std::fs::remove_file(dir.join("index.html")).expect("there");
    call(&["report", &out], 0);
    assert!(dir.join("index.html").is_file());
    let drawn = json(&call(&["report", &out, "--json"], 0));
    assert_eq!(drawn, json(&read(&dir.join("summary.json"))));
}

#[test]
fn the_number_of_jobs_does_not_change_a_bit() {
    let (_one, first) = folder();
    let (_two, second) = folder();
    call(&["run", STUDY, "--jobs", "1", "--out", &first], 0);
    call(&["run", STUDY, "--jobs", "2", "--out", &second], 0);
    assert_eq!(contents(Path::new(&first)).len(), 9);
    assert_same(Path::new(&first), Path::new(&second));
}

#[test]
fn a_case_that_cannot_be_solved_stops_no_other() {
    let (_keep, out) = folder();
    let dir = PathBuf::from(&out);
    let output = ended(without_mesher(ROOT, &["run", OVERPULL, "--out", &out]));
    let errors = output.err;
    assert_eq!(output.code, Some(3), "{errors}");
    assert!(errors.contains("not complete: dt-length-overpull"), "{errors}");
    let record = |case: &str| json(&read(&dir.join(format!("cases/{case}.json"))));
    for case in ["dt-length-coarse", "dt-length-nominal"] {
        assert_eq!(record(case)["status"], "Converged");
    }
    let failed = record("dt-length-overpull");
    assert_ne!(failed["status"], "Converged");
    assert!(failed["status_detail"].as_str().is_some_and(|d| d.contains("t = ")), "{failed}");
    let stop = &failed["solver"]["stop"];
    assert!(stop["t_s"].as_f64().is_some_and(|t| t > 0.0 && t < 1.0), "{stop}");
    assert!(["fact", "remedy"].iter().all(|key| stop[key].as_str().is_some_and(|text| text.len() > 10)), "{stop}");
    // What was reached before is there, and finite.
    let series = table(&dir.join("cases/dt-length-overpull.csv"));
    let reached = series["t_s"].last().copied().expect("a row");
    assert!(reached > 0.0 && reached < 1.0 && series.values().flatten().all(|v| v.is_finite()), "{series:?}");
    assert!(dir.join("index.html").is_file(), "the report is written");
    let summary = json(&read(&dir.join("summary.json")));
    assert_eq!(summary["cases"].as_array().map(Vec::len), Some(3));
    let told = summary["cases"].as_array().into_iter().flatten().find(|c| c["id"] == "dt-length-overpull");
    assert_eq!(told.map(|c| &c["solver"]["stop"]), Some(stop));
    // The incomplete case is not tried again for nothing, and still counts.
    let again = ended(without_mesher(ROOT, &["run", OVERPULL, "--out", &out]));
    assert_eq!(again.code, Some(3));
    let alone = ended(without_mesher(ROOT, &["simulate", "tests/cli/overpull/scene.toml", "--out", &out]));
    assert_eq!(alone.code, Some(3));
    assert!(table(&dir.join("scene.csv"))["t_s"].len() > 1);
}

/// Ctrl-C: what runs is dropped, what is finished is kept, the next run goes on.
#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on_where_it_stopped() {
    let (_keep, out) = folder();
    let cases = Path::new(&out).join("cases");
    let done = || {
        let names = std::fs::read_dir(&cases).into_iter().flatten().flatten().map(|e| e.file_name());
        let records = names.filter_map(|n| n.into_string().ok());
        records.filter(|n| n.ends_with(".json") && !n.ends_with(".skin.json")).count()
    };
    // Steps enough that the last case is still running when the first is done.
    let long = ["run", STUDY, "--jobs", "1", "--out", &out, "--set", "stage.0.duration=4000 s"];
    let mut child =
        without_mesher(ROOT, &long).stderr(std::process::Stdio::null()).spawn().expect("the program starts");
    let start = std::time::Instant::now();
    while done() == 0 {
        assert!(start.elapsed().as_secs() < 60 && child.try_wait().expect("ours").is_none(), "no case is finished");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    let status = child.wait().expect("it ends");
    let kept = done();
    assert_eq!(status.code(), Some(3));
    assert!((1..3).contains(&kept), "{kept} of 3 cases are finished");
    assert!(!Path::new(&out).join("index.html").exists());
    let parts = std::fs::read_dir(&cases)
        .expect("there")
        .flatten()
        .filter(|e| e.path().extension().is_some_and(|x| x == "part"));
    assert_eq!(parts.count(), 0, "no half-written file is left");
}

/// The finger of the SoftRobots plugin: with guide patches and with points.
#[test]
#[ignore = "reads public data outside of the project, from the folder that DUROMETER_SHARED names"]
fn the_plugins_finger_runs_with_its_cable_and_root_box() {
    let mesh = tools::shared("data/finger/finger.vtk");
    let mesh = format!("mesh.file={}", std::path::absolute(mesh).expect("a path").display());
    let (_keep, out) = folder();
    let peak = |radius: &str, probe: &str| {
        let radius = format!("constraint.cable.guide_radius={radius}");
        let scene = "tests/scenes/sofa-finger.toml";
        let record = json(&call(&["simulate", scene, "--set", &mesh, "--set", &radius, "--out", &out, "--json"], 0));
        assert_eq!(record["mesh"]["nodes"], 158);
        record["probes"][probe]["peak"].as_f64().expect("a number")
    };
    // It bends towards the cable, which lies above the middle of the section (y = 7.5 mm), and works against the rubber.
    assert!(peak("4 mm", "chord_angle_deg") > 5.0 && peak("4 mm", "tip_y_m") > 0.015);
    let (ball, point) = (peak("4 mm", "cable_tension_N"), peak("point", "cable_tension_N"));
    // The cells are larger than the ball, so the two see nearly the same field; equal they are not.
    assert!(ball > 0.0 && ball != point && (ball / point - 1.0).abs() < 0.05, "{ball} {point}");
    let length = table(&Path::new(&out).join("sofa-finger.csv"))["cable_length_m"].clone();
    let shortest = length.iter().fold(f64::INFINITY, |m, l| smaller(m, *l));
    assert!((length[0] - shortest - 0.015).abs() < 1e-9, "the cable is shortened by its amplitude");
}

/// An eighth of a balloon, whose inner pressure is this signal.
fn balloon(signal: &str) -> String {
    let scene = r#"
        [mesh]
        grid = { kind = "octant", inner = "10 mm", outer = "11 mm", divisions = [2, 1] }
        element = "tet10"

        [laws.rubber]
        law = "neo_hookean"
        E = "100 kPa"
        nu = 0.49

        [[effect]]
        kind = "elastic"
        region = "body"
        law = "rubber"
        formulation = "mixed"

        HELD

        [[constraint]]
        kind = "cavity"
        name = "gas"
        region = "inner"
        drive = { kind = "pressure", signal = SIGNAL }

        [[stage]]
        integrator = "static"
        duration = "1 s"
        dt = "0.1 s"
    "#;
    let held = ["x", "y", "z"]
        .map(|axis| format!("[[constraint]]\nkind = \"fixed\"\nregion = \"{axis}min\"\ncomponents = \"{axis}\"\n"));
    scene.replace("HELD", &held.concat()).replace("SIGNAL", signal)
}

/// A balloon under more pressure than it carries: the largest load is a number of its signal, whether that is a function of time, is computed from a column of
/// the run, or was switched by an event.
#[test]
fn the_largest_load_is_stated_whatever_sets_it() {
    let ramp = "{ kind = \"ramp\", from = \"0 Pa\", to = \"10 kPa\", end = \"1 s\" }";
    let formula = "{ kind = \"expression\", formula = \"10000 * t + 0 * gas_volume_m3\", unit = \"Pa\" }";
    let event = format!(
        "[[event]]\nname = \"go\"\nwhen = {{ kind = \"at\", t = \"0.2 s\" }}\n\
         then = [{{ kind = \"switch\", signal = \"gas_imposed_pressure_Pa\", to = {ramp} }}]\n"
    );
    let slow = ramp.replace("10 kPa", "1 kPa");
    let (_keep, out) = folder();
    let largest = |signal: &str, more: &str| {
        let file = Path::new(&out).join("balloon.toml");
        std::fs::write(&file, balloon(signal) + more).expect("a file");
        let record = json(&call(&["simulate", &file.display().to_string(), "--out", &out, "--json"], 3));
        assert_eq!(record["status"], "NoEquilibrium");
        record["solver"]["stop"]["limit"]["gas_imposed_pressure_Pa"].as_f64().expect("a number")
    };
    let by_time = largest(ramp, "");
    // Closed form of an incompressible one (Green & Zerna, Theoretical Elasticity, 1968): 0.11801 μ = 3960 Pa, μ = E/2(1 + ν)
    assert!((by_time / 3960.0 - 1.0).abs() < 0.01, "{by_time}");
    for (signal, more) in [(formula, ""), (&slow, &event)] {
        let other = largest(signal, more);
        assert!((other / by_time - 1.0).abs() < 1e-3, "{signal}: {other} {by_time}");
    }
}

/// Air in a balloon by its law, a formula of the volume: where the balloon is soft against it, the loop of one step diverges, and the run says so. Against thin air
/// it converges, and a run that stops at a limit point has no such note.
#[test]
fn a_loop_that_grows_by_itself_is_named() {
    let (_keep, out) = folder();
    let notes = |signal: &str, code: i32| {
        let file = Path::new(&out).join("balloon.toml");
        std::fs::write(&file, balloon(signal)).expect("a file");
        let record = json(&call(&["simulate", &file.display().to_string(), "--out", &out, "--json"], code));
        record["notes"].to_string()
    };
    let air = |pressure: &str| {
        let formula = format!("{pressure} * ((1 + 0.1 * t) * 5.16632e-7 / gas_volume_m3 - 1)");
        format!("{{ kind = \"expression\", formula = \"{formula}\", unit = \"Pa\" }}")
    };
    let grows = "gas_imposed_pressure_Pa alternates by more from row to row";
    let diverging = notes(&air("20000"), 3);
    assert!(diverging.contains(grows), "{diverging}");
    assert!(!notes(&air("200"), 0).contains(grows));
    assert!(
        !notes("{ kind = \"expression\", formula = \"10000 * t + 0 * gas_volume_m3\", unit = \"Pa\" }", 3)
            .contains(grows)
    );
}
