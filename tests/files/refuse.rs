//! Every refusal has a small bad file in `tests/bad/scenes/` and next to it the message it must give, compared exactly.
//! `DUROMETER_BLESS=1 cargo test --release --test files refuse::` writes the messages anew: read them before you commit them.
#![cfg(unix)]

use crate::common::program::{Ended, ROOT, ended, program};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

const SCENES: &str = "tests/bad/scenes";
const REMEDY: &str = "`DUROMETER_BLESS=1 cargo test --release --test files refuse::` writes messages that were changed on purpose, such as a list \
    with a new kind: read them before you commit them";

const BODY: &str = r#"
version = 1
summary = "a rod"
[parameters]
length = { default = "100 mm", meaning = "root to tip" }
[regions]
body = { dim = 3, meaning = "all" }
"#;

/// A project with one body, `rod`, whose mesher is a shell script.
fn project(script: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for sub in ["meshes/meshgen", "meshes/rod", "studies/finger-convergence"] {
        std::fs::create_dir_all(folder.path().join(sub)).expect("writable");
    }
    std::fs::write(folder.path().join("meshes/rod/body.toml"), BODY).expect("writable");
    std::fs::write(folder.path().join("studies/finger-convergence/study.toml"), "").expect("writable");
    // Written under another name first: a file that is open for writing cannot be run.
    let draft = folder.path().join("draft");
    std::fs::write(&draft, format!("#!/bin/sh\n{script}\n")).expect("writable");
    std::fs::set_permissions(&draft, PermissionsExt::from_mode(0o755)).expect("ours");
    std::fs::rename(&draft, folder.path().join("python")).expect("writable");
    folder
}

/// What the mesher does in the file of this name.
fn script(name: &str) -> &'static str {
    match name {
        "mesher-absent" => "echo 'No module named gmsh' >&2; exit 1",
        "mesher-dies" => "echo 'meshing 3D' >&2; kill -SEGV $$",
        "mesher-fails" => {
            r#"echo 'meshing 3D' >&2; echo '{"error": "gmsh: invalid boundary mesh", "hint": "take a smaller size"}'; exit 3"#
        }
        _ => "exit 9",
    }
}

/// A call with the bodies and the mesher of this folder.
fn at_home(home: &Path, arguments: &[&str]) -> Ended {
    ended(program(ROOT, arguments).env("DUROMETER_HOME", home).env("DUROMETER_PYTHON", home.join("python")))
}

/// What the user sees: messages, then the exit code.
fn said(Ended { code, err, .. }: &Ended) -> String {
    let code = code.map_or("none".into(), |c| c.to_string());
    format!("{err}exit code {code}\n")
}

/// Compares with the message in `<name>.txt`, or writes it.
fn compare(name: &str, said: &str, wrong: &mut Vec<String>) {
    let path = Path::new(ROOT).join(SCENES).join(format!("{name}.txt"));
    if std::env::var_os("DUROMETER_BLESS").is_some() {
        std::fs::write(&path, said).expect("writable");
        return;
    }
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    if known != said {
        wrong.push(format!("{name}\n--- expected\n{known}--- said\n{said}"));
    }
}

fn bad_files() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(Path::new(ROOT).join(SCENES)).expect("the folder").flatten();
    let mut files: Vec<PathBuf> =
        entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|x| x == "toml")).collect();
    files.sort();
    files
}

#[test]
fn every_bad_file_is_refused_with_its_message() {
    let mut wrong = Vec::new();
    for file in bad_files() {
        let name = file.file_stem().expect("a name").to_string_lossy().into_owned();
        let home = project(script(&name));
        let output = at_home(home.path(), &["check", &format!("{SCENES}/{name}.toml")]);
        if name == "scene" {
            assert!(output.is_success(), "the scene the bad ones are made from: {}", said(&output));
            continue;
        }
        let said = said(&output);
        if !said.ends_with("exit code 2\n") || output.out.contains("effect ") {
            wrong.push(format!("{name} is not refused:\n{said}"));
        }
        assert!(!said.contains(ROOT), "{name}: a message must not depend on the machine: {said}");
        compare(&name, &said, &mut wrong);
    }
    assert!(wrong.is_empty(), "{REMEDY}\n{}", wrong.join("\n"));
}

/// Every message file belongs to a bad file or to a command below.
#[test]
fn no_message_is_left_over() {
    let folder = Path::new(ROOT).join(SCENES);
    for entry in std::fs::read_dir(&folder).expect("the folder").flatten() {
        let path = entry.path();
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        if path.extension().is_some_and(|x| x == "txt") {
            let known = path.with_extension("toml").is_file() || COMMANDS.iter().any(|c| c.0 == name);
            assert!(known, "{} has no bad file", path.display());
        }
    }
}

/// (name of the message file, arguments)
const COMMANDS: &[(&str, &[&str])] = &[
    ("command-no-such-study", &["run", "finger-convergance"]),
    ("command-no-such-scene", &["simulate", "no/such/scene.toml"]),
    ("command-no-such-file", &["check", "no-such-file.toml"]),
    ("command-run-scene", &["run", "tests/bad/scenes/scene.toml"]),
    ("command-simulate-study", &["simulate", "tests/cli/study.toml"]),
    ("command-only-nothing", &["run", "tests/cli/study.toml", "--only", "tet99", "--out", "target/none"]),
    ("command-robustness-study", &["robustness", "tests/cli/study.toml"]),
    ("command-view-study", &["view", "studies/gripper/study.toml"]),
    ("command-set-form", &["check", "tests/bad/scenes/scene.toml", "--set", "mesh.unit"]),
    ("command-set-unknown", &["check", "tests/bad/scenes/scene.toml", "--set", "mesh.unitt=mm"]),
    ("command-set-no-entry", &["check", "tests/bad/scenes/scene.toml", "--set", "constraint.tendon.guide_radius=1 mm"]),
    ("command-set-no-law", &["check", "tests/bad/scenes/scene.toml", "--set", "laws.ruber.nu=0.3"]),
    ("command-set-study", &["check", "tests/cli/study.toml", "--set", "mesh.cell=10"]),
    ("command-report-nothing", &["report", "tests/bad"]),
    ("command-jobs", &["run", "finger-convergence", "--jobs", "0"]),
    ("command-plan-tolerance", &["plan", "finger-convergence", "--tolerance", "5 mm", "--budget", "1 min"]),
    ("command-plan-tolerance-range", &["plan", "finger-convergence", "--tolerance", "500 %", "--budget", "1 min"]),
    ("command-plan-budget", &["plan", "finger-convergence", "--tolerance", "5 %", "--budget", "0 s"]),
    (
        "command-plan-quantity",
        &[
            "plan",
            "tests/bad/scenes/scene.toml",
            "--tolerance",
            "5 %",
            "--budget",
            "1 min",
            "--quantity",
            "cable_tensoin_N",
        ],
    ),
    ("command-fit-absent", &["fit", "no-such.csv", "--law", "neo_hookean"]),
    ("command-fit-law", &["fit", "no-such.csv", "--law", "neo_hokean"]),
    ("command-fit-terms", &["fit", "data/treloar-1944/treloar-1944.csv", "--law", "mooney_rivlin", "--terms", "4"]),
];

#[test]
fn every_bad_command_is_refused_with_its_message() {
    let (mut wrong, home) = (Vec::new(), project("exit 9"));
    for (name, arguments) in COMMANDS {
        let output = at_home(home.path(), arguments);
        let said = said(&output);
        if output.code != Some(2) {
            wrong.push(format!("{name} is not refused: {said}"));
        }
        compare(name, &said, &mut wrong);
    }
    assert!(wrong.is_empty(), "{REMEDY}\n{}", wrong.join("\n"));
    assert!(!Path::new(ROOT).join("target/none").exists(), "a refused command leaves nothing behind");
}

/// A file where a folder is needed, and a disk without room.
#[test]
fn an_unwritable_output_is_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("file");
    std::fs::write(&file, "").expect("writable");
    let out = file.join("out");
    let out = out.to_str().expect("ASCII");
    for arguments in [
        &["run", "tests/cli/study.toml", "--out", out][..],
        &["simulate", "tests/bad/scenes/scene.toml", "--out", out],
        &["fit", "data/treloar-1944/treloar-1944.csv", "--law", "neo_hookean", "--mode", "uniaxial", "--out", out],
    ] {
        let output = at_home(Path::new(ROOT), arguments);
        let said = said(&output);
        assert_eq!(output.code, Some(2), "{arguments:?}: {said}");
        assert!(said.contains(out) && said.contains("--out"), "{arguments:?}: {said}");
    }
    // As on a full disk, no file takes a byte: the shell limits their size, and the signal that would end the program is ignored.
    let full = folder.path().join("full");
    let limited = "trap '' XFSZ; ulimit -f 0; exec \"$@\"";
    let mut shell = Command::new("sh");
    shell.args([
        "-c",
        limited,
        "sh",
        env!("CARGO_BIN_EXE_durometer"),
        "simulate",
        "tests/bad/scenes/scene.toml",
        "--out",
    ]);
    let said = said(&ended(shell.arg(&full).current_dir(ROOT)));
    assert!(said.contains("File too large") && said.contains("make room") && said.ends_with("exit code 2\n"), "{said}");
    assert!(!full.join("scene.json").exists(), "no record without its results");
}
