//! The program on a machine with nothing else: a root folder with the program, the libraries that it is linked with and a user whose home cannot be
//! written, apart from the cache. There is no shell, no Python, no compiler, no `/proc` and no `/tmp`.

use crate::common::program;
use crate::common::tools;
use std::os::unix::fs::{PermissionsExt, chown};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const PROGRAM: &str = env!("CARGO_BIN_EXE_durometer");
/// Nobody
const USER: u32 = 65534;

struct Machine {
    root: tempfile::TempDir,
}

impl Machine {
    /// None where this user may not change the root folder.
    fn new() -> Option<Self> {
        let machine = Self { root: tempfile::tempdir().expect("a temporary folder") };
        // Libraries where the program looks for them, as `ldd` lists them: `name => path (address)` or `path (address)`
        let listed = Command::new("ldd").arg(PROGRAM).output().ok()?;
        let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
        let libraries = listed.lines().filter_map(|line| line.split_whitespace().find(|word| word.starts_with('/')));
        for library in libraries {
            let place = machine.at(library);
            std::fs::create_dir_all(place.parent().expect("a folder")).expect("room");
            std::fs::copy(library, place).expect("room");
        }
        std::fs::create_dir(machine.at("/bin")).expect("room");
        std::fs::copy(PROGRAM, machine.at("/bin/durometer")).expect("room");
        for folder in ["/home/user/.cache", "/home/user/my robots"] {
            std::fs::create_dir_all(machine.at(folder)).expect("room");
            chown(machine.at(folder), Some(USER), Some(USER)).ok()?;
        }
        let read_only = PermissionsExt::from_mode(0o555);
        std::fs::set_permissions(machine.at("/home/user"), read_only).expect("own folder");
        std::fs::set_permissions(machine.root.path(), PermissionsExt::from_mode(0o755)).expect("own folder");
        machine.call("/home/user", &["--version"]).status.success().then_some(machine)
    }

    fn at(&self, path: &str) -> PathBuf {
        self.root.path().join(path.trim_start_matches('/'))
    }

    /// Calls the program as the user, in a folder of the machine. Of the environment only the home is set.
    fn call(&self, folder: &str, arguments: &[&str]) -> Output {
        let mut command = Command::new("unshare");
        command.arg("--root").arg(self.root.path()).args(["--wd", folder]);
        command.args([format!("--setuid={USER}"), format!("--setgid={USER}")]).arg("/bin/durometer").args(arguments);
        command.env_clear().env("HOME", "/home/user");
        command.output().expect("unshare is part of every Linux")
    }

    /// What a call prints that ends with this code.
    fn said(&self, folder: &str, arguments: &[&str], code: i32) -> (String, String) {
        program::said(&self.call(folder, arguments), &format!("{arguments:?}"), code)
    }

    fn is_file(&self, path: &str) -> bool {
        self.at(path).is_file()
    }
}

/// The folder that the user works in.
const WORK: &str = "/home/user/my robots";

#[test]
fn a_new_user_runs_a_study_and_makes_a_project() {
    let machine = Machine::new();
    if tools::is_missing(machine.is_some(), "the right to change the root folder") {
        return;
    }
    let machine = machine.expect("asked above");
    // Each case is a process of its own
    let only = ["run", "finger-convergence", "--only", "tet10_up-length-1100", "--set", "stage.0.duration=\"0.1 s\""];
    machine.said(WORK, &only, 0);
    assert!(machine.is_file(&format!("{WORK}/reports/finger-convergence/cases/tet10_up-length-1100.json")));
    assert!(machine.at("/home/user/.cache/durometer").is_dir());
    for starter in ["finger", "pneunet", "gripper"] {
        machine.said(WORK, &["new", starter], 0);
        machine.said(&format!("{WORK}/{starter}"), &["check", "study.toml"], 0);
    }
    let short = ["simulate", "scene.toml", "--set", "stage.0.duration=\"0.1 s\"", "--set", "stage.0.dt=\"0.05 s\""];
    let at = format!("{WORK}/finger");
    machine.said(&at, &short, 0);
    assert!(machine.is_file(&format!("{at}/reports/simulate/scene.html")));
    // A shape needs the mesher, whose Python is not there
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("studies/trunk/trunk.step"), machine.at("/trunk.step"))
        .expect("room");
    let (_, errors) = machine.said(WORK, &["new", "/trunk.step"], 2);
    assert!(errors.contains("durometer doctor"), "{errors}");
    let (out, _) = machine.said(WORK, &["doctor"], 2);
    assert!(out.contains("MISSING python") && out.contains("run: "), "{out}");
    // Nothing was written anywhere else
    assert_eq!(names(&machine.at("/home/user")), [".cache", "my robots"]);
    assert_eq!(names(&machine.at("/home/user/.cache")), ["durometer"]);
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    names
}

/// Every shipped study is planned from the program alone, which reads its scenes, laws and meshes.
#[test]
fn every_shipped_study_can_be_planned() {
    let machine = Machine::new();
    if tools::is_missing(machine.is_some(), "the right to change the root folder") {
        return;
    }
    let machine = machine.expect("asked above");
    let (out, _) = machine.said(WORK, &["studies", "--json"], 0);
    let studies: Vec<serde_json::Value> = serde_json::from_str(&out).expect("a list");
    assert!(studies.len() > 25, "{}", studies.len());
    for study in studies.iter().filter(|study| study["kind"] != "scene") {
        let name = study["name"].as_str().expect("a name");
        let (command, code, reason) = match name {
            // One start inverts cells on purpose, which is bad input
            "hard-cases" => ("check", 2, "start: the start inverts cells"),
            // To build 2 808 scenes on grids takes half a minute: they are read
            "coverage" => ("cases", 0, ""),
            _ => ("check", 0, ""),
        };
        let (_, errors) = machine.said(WORK, &[command, name], code);
        assert!(errors.contains(reason), "{errors}");
    }
}

#[test]
fn a_home_without_a_cache_is_answered_with_a_remedy() {
    let machine = Machine::new();
    if tools::is_missing(machine.is_some(), "the right to change the root folder") {
        return;
    }
    let machine = machine.expect("asked above");
    std::fs::set_permissions(machine.at("/home/user/.cache"), PermissionsExt::from_mode(0o555)).expect("own folder");
    let (_, errors) = machine.said(WORK, &["studies"], 2);
    assert!(errors.contains("/home/user/.cache/durometer") && errors.contains("set DUROMETER_CACHE"), "{errors}");
}
