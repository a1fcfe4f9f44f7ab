//! Runs of `simulate` that are cut off: killed, or on a disk that is full. Everything that was computed is there, and a restart goes on from it.
#![cfg(unix)]

use crate::common::tools;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A block that is pulled in so many steps.
fn scene(steps: usize) -> String {
    format!(
        r#"
[mesh]
grid = {{ kind = "box", size = ["40 mm", "10 mm", "10 mm"], divisions = [4, 1, 1] }}
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
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = {{ kind = "ramp", from = "0 mm", to = "4 mm", end = "1 s" }}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "{} s"
[[probe]]
kind = "reaction"
region = "xmax"
[[probe]]
kind = "energy"
"#,
        1.0 / steps as f64
    )
}

fn simulate(folder: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_durometer"));
    command.current_dir(folder).args(["simulate", "scene.toml"]).args(more);
    command
}

fn output(mut command: Command) -> (Option<i32>, String) {
    answer(command.output().expect("the program runs"))
}

/// The exit code and the messages.
fn answer(Output { status, stderr, .. }: Output) -> (Option<i32>, String) {
    (status.code(), String::from_utf8_lossy(&stderr).into_owned())
}

fn lines(file: &Path) -> Vec<String> {
    std::fs::read_to_string(file).unwrap_or_default().lines().map(String::from).collect()
}

/// A run is killed while it goes on. Its rows are those of the undisturbed run, and a restart from its checkpoint ends as that.
#[test]
fn a_killed_run_leaves_its_rows_and_a_state() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    std::fs::write(at.join("scene.toml"), scene(3000)).expect("writable");
    let (code, error) = output(simulate(at, &["--out", "whole"]));
    assert_eq!(code, Some(0), "{error}");
    let whole = lines(&at.join("whole/scene.csv"));
    assert!(!at.join("whole/scene.partial.csv").exists() && !at.join("whole/scene-partial.state").exists());
    let mut run = simulate(at, &["--out", "cut", "--checkpoint", "1 ms"]);
    let mut child = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program runs");
    let (rows, state) = (at.join("cut/scene.partial.csv"), at.join("cut/scene-partial.state"));
    let start = Instant::now();
    while (lines(&rows).len() < 100 || !state.exists()) && start.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().expect("it runs");
    child.wait().expect("it was killed");
    let left = lines(&rows);
    assert!(left.len() >= 100 && left.len() < whole.len(), "{} of {} rows", left.len(), whole.len());
    assert_eq!(left[..], whole[..left.len()]);
    assert!(!at.join("cut/scene.csv").exists());
    let restart = ["--out", "cut", "--restart", "cut/scene-partial.state"];
    let (code, error) = output(simulate(at, &restart));
    assert_eq!(code, Some(0), "{error}");
    assert_eq!(lines(&at.join("cut/scene.csv")), whole);
    assert!(!rows.exists() && !state.exists());
}

/// The exit code and the messages of a run that is stopped by Ctrl-C after some rows.
fn interrupted(folder: &Path, out: &str, more: &[&str]) -> (Option<i32>, String) {
    let mut run = simulate(folder, &[&["--out", out], more].concat());
    let mut child = run.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program runs");
    let (rows, start) = (folder.join(out).join("scene.partial.csv"), Instant::now());
    while lines(&rows).len() < 20 && start.elapsed() < Duration::from_secs(120) {
        assert!(child.try_wait().expect("ours").is_none(), "it goes on");
        std::thread::sleep(Duration::from_millis(2));
    }
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    answer(child.wait_with_output().expect("it ends"))
}

/// A run that is stopped by Ctrl-C says how it could have kept a state, unless it has kept one.
#[test]
fn an_interrupted_run_names_the_flag_by_which_it_could_go_on() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    std::fs::write(at.join("scene.toml"), scene(100_000)).expect("writable");
    let flag = "pass --save-state end to be able to go on with --restart";
    let (code, said) = interrupted(at, "lost", &[]);
    assert!(code == Some(3) && said.contains(flag), "{said}");
    let (code, said) = interrupted(at, "kept", &["--save-state", "end"]);
    assert!(code == Some(3) && !said.contains(flag) && at.join("kept/scene-end.state").exists(), "{said}");
}

/// While a run estimates its errors, another one does not take its name: record and errors would be those of two runs.
#[test]
fn a_name_is_taken_until_all_is_written() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    std::fs::write(at.join("scene.toml"), scene(2)).expect("writable");
    let finer = ["--set", "mesh.grid.divisions=[16,5,5]", "--set", "mesh.element='tet10'"];
    let mut run = simulate(at, &[&["--out", "r", "--error", "all"], &finer[..]].concat());
    let mut child = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program runs");
    let (record, start) = (at.join("r/scene.json"), Instant::now());
    while !record.exists() && start.elapsed() < Duration::from_secs(120) {
        std::thread::sleep(Duration::from_millis(1));
    }
    // It takes no more time, so that it still estimates when the other one comes
    Command::new("kill").args(["-STOP", &child.id().to_string()]).status().expect("kill");
    let other = simulate(at, &["--out", "r"]).output();
    let estimated = at.join("r/scene.errors.csv").exists();
    // Before anything can fail, so that no stopped process is left
    child.kill().expect("it is there");
    child.wait().expect("it was killed");
    assert!(!estimated, "it was stopped while it estimated");
    let (code, error) = answer(other.expect("the program runs"));
    assert!(code == Some(2) && error.contains("another process runs a scene of this name"), "{error}");
    let (code, error) = output(simulate(at, &["--out", "r"]));
    assert_eq!(code, Some(0), "{error}");
}

/// The names of the files in a folder that end like this, in order.
fn names(folder: &Path, end: &str) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    let mut all: Vec<String> = entries.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    all.retain(|name| name.ends_with(end));
    all.sort();
    all
}

/// A run that goes on next to the fields of its part before keeps them, and its collections name all of them; a part of another run it replaces, its skins too.
#[test]
fn fields_of_a_restart_follow_those_before() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    let facet = "facet normal 0 0 1\nouter loop\nvertex 10 2 10\nvertex 20 2 10\nvertex 20 8 10\nendloop\nendfacet\n";
    std::fs::write(at.join("glove.stl"), format!("solid a\n{facet}endsolid a\n")).expect("writable");
    let skin = "[[skin]]\nname = 'glove'\nfile = 'glove.stl'\nunit = 'mm'\nreach = '1 mm'\n";
    std::fs::write(at.join("scene.toml"), scene(4) + skin).expect("writable");
    let run = |more: &[&str]| {
        let (code, error) = output(simulate(at, more));
        assert_eq!(code, Some(0), "{error}");
    };
    run(&["--out", "r", "--vtu", "--save-state", "0.5 s"]);
    let read = |file: &str| std::fs::read_to_string(at.join("r").join(file)).expect("a collection");
    let collections = || ["scene.pvd", "scene-glove.pvd"].map(read);
    let (files, whole) = (names(&at.join("r"), ".vtu"), collections());
    assert_eq!(files.len(), 11, "five states of the body and of the skin, and the regions");
    run(&["--out", "r", "--vtu", "--restart", "r/scene-0.5s.state"]);
    assert_eq!((names(&at.join("r"), ".vtu"), collections()), (files, whole));
    // Rows of another run: its fields are none of this one
    run(&["--out", "r", "--vtu", "--set", "laws.rubber.E='90 kPa'"]);
    run(&["--out", "r", "--vtu", "--restart", "r/scene-0.5s.state"]);
    assert_eq!(collections().map(|text| text.matches("DataSet").count()), [2, 2]);
    assert_eq!(names(&at.join("r"), ".vtu").len(), 5);
    // Without fields none of them are left
    run(&["--out", "r"]);
    assert_eq!([".vtu", ".pvd"].map(|end| names(&at.join("r"), end).len()), [0, 0]);
}

/// Where only the rows at rest are recorded up to a checkpoint, which are those of any such scene, the scene tells whose fields are there.
#[test]
fn fields_of_another_scene_are_none_of_a_restart() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    std::fs::write(at.join("scene.toml"), scene(4) + "[output.series]\nevery = '1 s'\n").expect("writable");
    let states = |more: &[&str]| {
        let (code, error) = output(simulate(at, &[&["--out", "r", "--vtu"], more].concat()));
        assert_eq!(code, Some(0), "{error}");
        let collection = std::fs::read_to_string(at.join("r/scene.pvd")).expect("a collection");
        collection.matches("DataSet").count()
    };
    let restart = ["--restart", "r/scene-0.5s.state"];
    assert_eq!(states(&["--save-state", "0.5 s"]), 5);
    assert_eq!(states(&[&restart[..], &["--set", "title='Continued'"]].concat()), 5);
    let rest = || lines(&at.join("r/scene.csv"))[1].clone();
    let own = rest();
    assert_eq!((states(&["--set", "laws.rubber.E='90 kPa'"]), rest()), (5, own));
    assert_eq!(states(&restart), 2);
}

/// A folder that cannot be made or written is refused before the run.
#[test]
fn an_unwritable_folder_is_refused_first() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(keep.path().join("scene.toml"), scene(1_000_000)).expect("writable");
    std::fs::write(keep.path().join("file"), "").expect("writable");
    for out in ["file", "file/below", "/proc/here"] {
        let start = Instant::now();
        let (code, error) = output(simulate(keep.path(), &["--out", out]));
        assert_eq!(code, Some(2), "{error}");
        assert!(error.contains("cannot be written") && error.contains("--out"), "{error}");
        assert!(start.elapsed() < Duration::from_secs(30));
    }
}

/// The program in a file system of this size for its results, with the rows and files that are there after it. None where none can be mounted.
fn on_a_small_disk(steps: usize, size: &str, more: &str) -> Option<(Option<i32>, String, Vec<String>)> {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    std::fs::write(at.join("scene.toml"), scene(steps)).expect("writable");
    std::fs::create_dir(at.join("out")).expect("writable");
    let program = env!("CARGO_BIN_EXE_durometer");
    let script = format!(
        "mount -t tmpfs -o size={size} none out || exit 77\n\
         {program} simulate scene.toml --out out {more}\ncode=$?\ncp out/*.csv .\nexit $code"
    );
    let mut command = Command::new("unshare");
    command.args(["-m", "--propagation", "private", "sh", "-c", &script]).current_dir(at);
    let output = command.output();
    let is_refused = |o: &Output| {
        o.status.code() == Some(77) || String::from_utf8_lossy(&o.stderr).contains("Operation not permitted")
    };
    let is_mounted = output.as_ref().is_ok_and(|o| !is_refused(o));
    if tools::is_missing(is_mounted, "the right to mount a file system (unshare, root)") {
        return None;
    }
    let Output { status, stderr, .. } = output.expect("it was mounted");
    let error = String::from_utf8_lossy(&stderr).into_owned();
    let partial = at.join("scene.partial.csv");
    let rows = lines(&if partial.exists() { partial } else { at.join("scene.csv") });
    Some((status.code(), error, rows))
}

/// The rows up to the full disk are kept, and the run ends there with the fact.
#[test]
fn a_full_disk_keeps_the_rows() {
    let Some((code, error, rows)) = on_a_small_disk(3000, "64k", "--checkpoint '1000 s'") else { return };
    assert_eq!(code, Some(2), "{error}");
    assert!(error.contains("No space left on device"), "{error}");
    // Of 64 kB, at 60 to 200 bytes a row
    assert!((200..1100).contains(&rows.len()), "{}", rows.len());
    let keep = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(keep.path().join("scene.toml"), scene(3000)).expect("writable");
    assert_eq!(output(simulate(keep.path(), &["--out", "whole"])).0, Some(0));
    let whole = lines(&keep.path().join("whole/scene.csv"));
    // The last line may have been cut
    let complete = rows.len() - 1;
    assert_eq!(rows[..complete], whole[..complete]);
}

/// Fields that find no room do not cost the rows that were computed.
#[test]
fn fields_on_a_full_disk_do_not_cost_the_rows() {
    let Some((code, error, rows)) = on_a_small_disk(200, "400k", "--vtu") else { return };
    assert_eq!(code, Some(2), "{error}");
    assert!(error.contains("No space left on device"), "{error}");
    let times: Vec<f64> =
        rows[1..rows.len() - 1].iter().filter_map(|row| row.split(',').next()?.parse().ok()).collect();
    assert!(times.len() > 20 && times.windows(2).all(|w| w[0] < w[1]), "{times:?}");
}
