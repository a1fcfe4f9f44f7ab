//! The program away from its checkout: it brings its studies, bodies and meshes, unpacks them once, and takes nothing from the folder it runs in.

use crate::common::disk::{Disk, Fault};
use crate::common::program::{ROOT, said};
use crate::common::tools;
use durometer::catalogue::{Archive, Entry};
use durometer::math::threads::locked;
use serde_json::Value;
use std::collections::BTreeSet;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, Mutex, Weak};

const PROGRAM: &str = env!("CARGO_BIN_EXE_durometer");

/// A scene on a grid.
const GRID: &str = r#"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [4, 2, 2] }
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
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#;

/// A machine with the program and nothing else of the project.
struct Machine {
    keep: tempfile::TempDir,
    /// Where its cache is
    disk: Arc<tempfile::TempDir>,
}

impl Machine {
    /// One whose cache is that of the others that are there at the same time: to unpack the files takes seconds.
    fn new() -> Self {
        static SHARED: Mutex<Weak<tempfile::TempDir>> = Mutex::new(Weak::new());
        let mut shared = locked(&SHARED);
        let disk = shared.upgrade().unwrap_or_else(folder);
        *shared = Arc::downgrade(&disk);
        Self::with_cache_on(disk)
    }

    /// One with a cache of its own.
    fn with_empty_cache() -> Self {
        Self::with_cache_on(folder())
    }

    fn with_cache_on(disk: Arc<tempfile::TempDir>) -> Self {
        let machine = Self { keep: tempfile::tempdir().expect("a temporary folder"), disk };
        place(&machine.program());
        std::fs::create_dir(machine.work()).expect("writable");
        machine
    }

    fn program(&self) -> PathBuf {
        self.keep.path().join("durometer")
    }

    /// A path with a space.
    fn work(&self) -> PathBuf {
        self.keep.path().join("my work")
    }

    fn cache(&self) -> PathBuf {
        self.disk.path().join("My Cache (ä)")
    }

    /// The unpacked files.
    fn files(&self) -> PathBuf {
        self.cache().join(format!("files-{}", &durometer_files::DIGEST[..16]))
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(self.program());
        command.args(arguments).current_dir(self.work());
        for name in ["CARGO_MANIFEST_DIR", "DUROMETER_HOME"] {
            command.env_remove(name);
        }
        command.env("DUROMETER_CACHE", self.cache()).env("DUROMETER_PYTHON", "no-such-python");
        command
    }

    /// What a call prints that ends with this code.
    fn call(&self, arguments: &[&str], code: i32) -> (String, String) {
        self.call_in(&self.work(), arguments, code)
    }

    fn call_in(&self, folder: &Path, arguments: &[&str], code: i32) -> (String, String) {
        let output = self.command(arguments).current_dir(folder).output().expect("the program starts");
        said(&output, &format!("{arguments:?}"), code)
    }
}

fn folder() -> Arc<tempfile::TempDir> {
    Arc::new(tempfile::tempdir().expect("a temporary folder"))
}

/// The program under another path, without a copy where that is possible.
fn place(path: &Path) {
    std::fs::hard_link(PROGRAM, path)
        .or_else(|_| std::fs::copy(PROGRAM, path).map(|_| ()))
        .expect("room for the program");
}

/// The files that the program brings.
fn entries() -> impl Iterator<Item = Entry> {
    Archive { packed: durometer_files::PACKED, list: durometer_files::LIST, digest: durometer_files::DIGEST }.entries()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    names
}

#[test]
fn the_program_brings_every_committed_file_and_no_other() {
    let listed = Command::new("git").args(["ls-files", "data", "meshes", "studies"]).current_dir(ROOT).output();
    let listed = listed.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()).unwrap_or_default();
    if tools::is_missing(!listed.is_empty(), "the history of the project") {
        return;
    }
    let committed: BTreeSet<&str> = listed.lines().filter(|name| !name.starts_with("meshes/meshgen/tests/")).collect();
    let brought: BTreeSet<&str> = entries().map(|entry| entry.name).collect();
    let missing: Vec<_> = committed.difference(&brought).collect();
    assert!(missing.is_empty(), "not brought: {missing:?}");
    // A study or a mesh that is being written is not committed yet
    let fetched =
        |name: &&&str| name.starts_with("data/silicones/") && name.ends_with(".csv") || name.contains("__pycache__");
    assert!(!brought.iter().any(|name| fetched(&name)), "files that may not be passed on");
    assert!(committed.len() > 300, "{}", committed.len());
    for entry in entries() {
        let bytes = std::fs::read(Path::new(ROOT).join(entry.name)).expect("there");
        assert_eq!(durometer::storage::sha256(bytes), entry.sha256, "{}", entry.name);
    }
}

#[test]
fn every_study_is_there_with_its_meshes() {
    let machine = Machine::new();
    let (out, errors) = machine.call(&["studies", "--json"], 0);
    let studies: Vec<Value> = serde_json::from_str(&out).expect("a list");
    let without: Vec<&Value> = studies.iter().filter(|study| study["has_meshes"] != true).collect();
    assert!(without.is_empty(), "{without:#?}");
    let committed = names(&Path::new(ROOT).join("studies"));
    let mut known: Vec<&str> = studies.iter().filter_map(|study| study["name"].as_str()).collect();
    // Its data may not be passed on; data/README.md says where they are
    known.push("dumbbell-silicones");
    known.sort_unstable();
    assert_eq!(known, committed.iter().map(String::as_str).filter(|name| *name != "README.md").collect::<Vec<_>>());
    assert!(errors.starts_with("1 more cannot be run as they are: dumbbell-silicones;"), "{errors}");
    let (_, errors) = machine.call(&["check", "dumbbell-silicones"], 2);
    assert!(errors.contains("data/silicones"), "{errors}");
    let page = std::fs::read_to_string(machine.files().join("studies/dumbbell-silicones/README.md")).expect("a page");
    assert!(page.contains("10.1089/soro.2019.0115"), "where its data are: {page}");
    // A mesh from CAD and a converted one are really read
    for (name, cells) in [("trunk", "4012 cells"), ("tripod", "1919 cells")] {
        let (out, _) = machine.call(&["mesh", name], 0);
        assert!(out.contains(cells), "{out}");
    }
    let (_, errors) = machine.call(&["mesh", "trunk", "--keep"], 2);
    assert!(errors.contains("set DUROMETER_HOME to the folder of a project"), "{errors}");
}

/// The pages name files of the program by their paths in a project.
#[test]
fn files_of_the_program_are_found_by_their_paths_in_a_project() {
    let machine = Machine::new();
    for path in ["studies/finger-control/scene.toml", "studies/finger-control"] {
        let (out, _) = machine.call(&["check", path], 0);
        assert!(out.contains("The finger held at a bending angle"), "{out}");
    }
    let table = "data/treloar-1944/treloar-1944.csv";
    machine.call(&["fit", table, "--law", "neo_hookean", "--mode", "uniaxial", "--range", "1..1.6"], 0);
    assert!(machine.work().join("reports/fit-treloar-1944-neo_hookean/law.toml").is_file());
    let (out, _) = machine.call(&["laws", "list", "data"], 0);
    assert!(out.contains("ecoflex-00-30"), "{out}");
    // A mistake is answered with what is there
    for (arguments, near) in [
        (&["check", "studies/finger-contrl/scene.toml"][..], "studies/finger-control"),
        (&["check", "studies/finger-control/scen.toml"], "studies/finger-control/scene.toml"),
        (&["laws", "list", "data/silicone"], "data/silicones"),
    ] {
        let (_, errors) = machine.call(arguments, 2);
        assert!(errors.contains("among the files of the program"), "{errors}");
        assert!(errors.contains(&format!("did you mean `{near}`?")), "{errors}");
    }
    // What exists in the current folder is taken, and no path leads out of the catalogue
    let own = machine.work().join("studies/finger-control");
    std::fs::create_dir_all(&own).expect("room");
    std::fs::write(own.join("scene.toml"), GRID).expect("room");
    let (out, _) = machine.call(&["check", "studies/finger-control/scene.toml"], 0);
    assert!(out.contains("mesh         grid (96 cells"), "{out}");
    machine.call(&["check", "studies/../studies/finger-cube/scene.toml"], 2);
    assert_eq!(names(&machine.work()), ["reports", "studies"]);
}

/// Also in the command of a controller.
#[test]
fn a_controller_of_the_program_is_found() {
    let python = Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success());
    if tools::is_missing(python, "python3") {
        return;
    }
    let machine = Machine::new();
    let controller = "python3 studies/finger-control/pi.py 20";
    let short = ["--set", "stage.0.duration=\"0.1 s\"", "--no-view", "--controller", controller];
    machine.call(&[&["simulate", "studies/finger-control/scene.toml"], &short[..]].concat(), 0);
    assert!(machine.work().join("reports/simulate/scene.csv").is_file());
}

/// `run` starts the program again for every case.
#[test]
fn a_shipped_study_runs() {
    let machine = Machine::new();
    let only = ["run", "finger-convergence", "--only", "tet10_up-length-1100", "--set", "stage.0.duration=\"0.1 s\""];
    machine.call(&only, 0);
    let record =
        std::fs::read_to_string(machine.work().join("reports/finger-convergence/cases/tet10_up-length-1100.json"));
    let record: Value = serde_json::from_str(&record.expect("a result")).expect("JSON");
    assert_eq!(record["status"], "Converged");
    let whole = record.to_string();
    assert!(!whole.contains(ROOT), "a result names the folder of the build");
}

#[test]
fn a_starter_runs_as_it_is() {
    let machine = Machine::new();
    for (name, quantity) in
        [("finger", "bending_angle_deg"), ("pneunet", "cavity_pressure_Pa"), ("gripper", "ball_x_m")]
    {
        let (out, _) = machine.call(&["new", name], 0);
        assert!(out.contains(&format!("next, in {name}: durometer simulate scene.toml")), "{out}");
        let at = machine.work().join(name);
        assert_eq!(names(&at), ["README.md", "scene.schema.json", "scene.toml", "study.schema.json", "study.toml"]);
        for kind in ["scene", "study"] {
            let text = std::fs::read_to_string(at.join(format!("{kind}.toml"))).expect("a file of the project");
            assert!(text.starts_with(&format!("#:schema ./{kind}.schema.json\n")), "{text}");
            let (schema, _) = machine.call(&["schema", kind], 0);
            let stored = std::fs::read_to_string(at.join(format!("{kind}.schema.json"))).expect("a schema");
            assert_eq!(schema, stored);
        }
        let call = |arguments: &[&str]| machine.call_in(&at, arguments, 0);
        call(&["check", "study.toml"]);
        // The first steps only: the whole run of a gripper takes a minute
        let short = ["--set", "stage.0.duration=\"0.1 s\"", "--set", "stage.0.dt=\"0.05 s\"", "--no-view"];
        let (out, _) = call(&[&["simulate", "scene.toml"], &short[..]].concat());
        assert!(out.contains(quantity), "{out}");
        let page = std::fs::read_to_string(at.join("README.md")).expect("a page");
        for line in page.lines().filter(|line| line.starts_with("durometer ")) {
            let words: Vec<&str> = line.split(' ').skip(1).collect();
            assert!(["check", "simulate", "run"].contains(&words[0]) && at.join(words[1]).is_file(), "{line}");
        }
        assert!(page.contains(&format!("reports/{name}/index.html")), "{page}");
    }
    let (out, _) = machine.call(&["new"], 0);
    assert!(["finger", "pneunet", "gripper"].iter().all(|name| out.contains(name)), "{out}");
}

#[test]
fn the_study_of_a_starter_ends_with_a_report() {
    let machine = Machine::new();
    machine.call(&["new", "finger", "my finger"], 0);
    let at = machine.work().join("my finger");
    let (out, _) = machine.call_in(&at, &["run", "study.toml", "--set", "stage.0.duration=\"0.1 s\""], 0);
    assert!(out.contains("can be trusted within 5 %"), "{out}");
    let page = std::fs::read_to_string(at.join("README.md")).expect("a page");
    let report = "reports/my finger/index.html";
    assert!(page.contains(report) && at.join(report).is_file(), "{page}");
}

/// A mesh of the user needs no mesher; the bodies are those of the hard cases.
#[test]
fn a_project_is_made_around_a_mesh_file() {
    let machine = Machine::new();
    std::fs::copy(Path::new(ROOT).join("studies/hard-cases/scenes/tripod.vtk"), machine.work().join("robot.vtk"))
        .expect("room");
    machine.call(&["new", "robot.vtk", "--unit", "mm"], 0);
    let at = machine.work().join("robot");
    let schemas = ["scene.schema.json", "study.schema.json"];
    assert_eq!(names(&at), ["README.md", "robot.vtk", schemas[0], "scene.toml", schemas[1], "study.toml"]);
    std::fs::remove_file(machine.work().join("robot.vtk")).expect("own file");
    let call = |arguments: &[&str]| machine.call_in(&at, arguments, 0);
    call(&["simulate", "scene.toml"]);
    let (out, _) = call(&["run", "study.toml"]);
    assert!(out.contains("report: reports/robot/index.html"), "{out}");
}

#[test]
fn a_project_that_cannot_be_made_leaves_nothing() {
    let machine = Machine::new();
    std::fs::write(machine.work().join("broken.stl"), "no surface").expect("room");
    std::fs::create_dir(machine.work().join("full")).expect("room");
    std::fs::write(machine.work().join("full/mine.txt"), "").expect("room");
    let before = names(&machine.work());
    for (arguments, reason) in [
        (&["new", "fingr"][..], "fingr: there is no such starter and no such file; did you mean `finger`?"),
        (&["new", "finger", "full"], "full: there is something of this name already; name another folder"),
        (&["new", "finger", "broken.stl"], "broken.stl: there is something of this name already"),
        (&["new", "finger", "broken.stl/below"], "broken.stl/below: File exists"),
        (&["new", "finger", "/"], "/: a project needs a folder with a name; name one"),
        (&["new", "broken.stl"], "broken.stl"),
        (
            &["new", "finger", "mine", "--unit", "m"],
            "finger has a mesh of its own; leave the unit and the number of cells out",
        ),
        (
            &["new", "finger", "mine", "--cells", "900"],
            "finger has a mesh of its own; leave the unit and the number of cells out",
        ),
    ] {
        let (_, errors) = machine.call(arguments, 2);
        assert!(errors.contains(reason), "{arguments:?}: {errors}");
        assert_eq!(names(&machine.work()), before, "{arguments:?}");
    }
    // An empty folder is as good as none
    std::fs::create_dir(machine.work().join("empty")).expect("room");
    machine.call(&["new", "finger", "empty"], 0);
}

#[test]
fn many_processes_unpack_at_the_same_time() {
    let machine = Machine::with_empty_cache();
    let start = || machine.command(&["check", "finger-dynamics"]).stdout(std::process::Stdio::null()).spawn();
    let running: Vec<_> = (0..8).map(|_| start().expect("the program starts")).collect();
    for mut process in running {
        assert!(process.wait().expect("it ends").success());
    }
    assert_eq!(names(&machine.cache()), [machine.files().file_name().expect("a name").to_str().expect("digits")]);
    for entry in entries() {
        assert_eq!(std::fs::read(machine.files().join(entry.name)).expect("there").len() as u64, entry.bytes);
    }
}

/// Systems that tidy up delete single files; a killed process leaves a folder of another name; other versions have folders of their own.
#[test]
fn a_damaged_cache_is_repaired_and_other_versions_stay() {
    let machine = Machine::with_empty_cache();
    machine.call(&["check", "finger-dynamics"], 0);
    let (removed, cut) =
        (machine.files().join("meshes/finger/body.toml"), machine.files().join("studies/finger-dynamics/scene.toml"));
    let scene = std::fs::read(&cut).expect("there");
    std::fs::remove_file(&removed).expect("own file");
    std::fs::write(&cut, &scene[..scene.len() / 2]).expect("own file");
    let other = machine.cache().join("files-0123456789abcdef");
    std::fs::create_dir_all(other.join("studies/finger-dynamics")).expect("room");
    let (old, young) = (machine.cache().join(".files-old.part"), machine.cache().join(".files-young.part"));
    [&old, &young].iter().for_each(|folder| std::fs::create_dir(folder).expect("room"));
    let long_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(7200);
    std::fs::File::open(&old).and_then(|folder| folder.set_modified(long_ago)).expect("own folder");
    machine.call(&["check", "finger-dynamics"], 0);
    assert!(removed.is_file() && std::fs::read(&cut).expect("there") == scene);
    assert!(other.is_dir() && young.is_dir() && !old.exists());
    // A file of the same length is noticed by the doctor
    let mut bytes = scene.clone();
    bytes[0] ^= 1;
    std::fs::write(&cut, bytes).expect("own file");
    let (out, _) = machine.call(&["doctor"], 2);
    assert!(out.contains("altered: studies/finger-dynamics/scene.toml"), "{out}");
    assert!(out.contains("files-0123456789abcdef is of another version"), "{out}");
}

#[test]
fn a_cache_that_cannot_be_written_is_named() {
    let machine = Machine::with_empty_cache();
    std::fs::write(machine.cache(), "no folder").expect("room");
    let (_, errors) = machine.call(&["check", "finger-dynamics"], 2);
    let place = machine.cache().display().to_string();
    assert!(errors.contains(&place) && errors.contains("or set DUROMETER_CACHE to another folder"), "{errors}");
    // What needs no file of the program runs
    std::fs::write(machine.work().join("scene.toml"), GRID).expect("room");
    machine.call(&["check", "scene.toml"], 0);
}

#[test]
fn a_full_disk_leaves_nothing_half_unpacked() {
    let machine = Machine::with_empty_cache();
    std::fs::create_dir(machine.cache()).expect("room");
    let disk = Disk::new(&machine.cache());
    let check = || machine.command(&["check", "finger-dynamics"]);
    let (output, _) = disk.call(check(), Fault::Space(1_000_000));
    let (_, errors) = said(&output, "a call", 2);
    assert!(errors.contains("No space left") && errors.contains("MB free"), "{errors}");
    assert_eq!(names(&machine.cache()), Vec::<String>::new());
    said(&disk.call(check(), Fault::None).0, "check", 0);
}

/// The python of the system with the packages of the mesher in it: no environment is missing. Without one of them there is.
#[test]
fn a_python_with_the_packages_needs_no_environment() {
    let machine = Machine::new();
    let folder = machine.keep.path().join("bin");
    std::fs::create_dir(&folder).expect("room");
    let doctor = |packages: &str, code: i32| {
        let python = folder.join("python3");
        let answer = format!("case \"$*\" in *--doctor*) echo '{packages}';; *) echo 3.12.1;; esac");
        std::fs::write(&python, format!("#!/bin/sh\n{answer}\n")).expect("room");
        std::fs::set_permissions(&python, PermissionsExt::from_mode(0o755)).expect("own file");
        let mut command = machine.command(&["doctor"]);
        command.env_remove("DUROMETER_PYTHON").env("PATH", format!("{}:/usr/bin:/bin", folder.display()));
        said(&command.output().expect("the program starts"), "a call", code).0
    };
    let all = doctor(r#"{"versions": {"gmsh": "4.15.2", "meshio": "5.3.5"}}"#, 0);
    assert!(all.contains("ok      environment              not needed: ") && !all.contains("MISSING"), "{all}");
    let some =
        doctor(r#"{"versions": {"gmsh": "4.15.2", "meshio": null}, "errors": {"meshio": {"error": "absent"}}}"#, 2);
    assert!(some.contains("MISSING environment") && some.contains("MISSING meshio"), "{some}");
}

/// A checkout of somebody else in the current folder, and one around a folder for all users: no program in them is started.
#[test]
fn no_program_of_others_is_run() {
    let machine = Machine::new();
    let trap = |folder: &Path| {
        for sub in ["meshes/meshgen", ".venv/bin"] {
            std::fs::create_dir_all(folder.join(sub)).expect("room");
        }
        std::fs::write(folder.join("Cargo.toml"), "[package]\nname = \"durometer\"\n").expect("room");
        let (python, trace) = (folder.join(".venv/bin/python"), folder.join("started"));
        std::fs::write(&python, format!("#!/bin/sh\ntouch '{}'\n", trace.display())).expect("room");
        std::fs::set_permissions(&python, PermissionsExt::from_mode(0o755)).expect("own file");
        trace
    };
    let trace = trap(&machine.work());
    let (out, _) =
        said(&machine.command(&["doctor"]).env_remove("DUROMETER_PYTHON").output().expect("it starts"), "doctor", 2);
    assert!(!trace.exists() && out.contains("the files of the program, unpacked"), "{out}");
    // The program of one user in a folder of another one
    let shared = machine.keep.path().join("shared");
    let trace = trap(&shared);
    let own = shared.join("target/release/durometer");
    std::fs::create_dir_all(own.parent().expect("a folder")).expect("room");
    std::fs::copy(PROGRAM, &own).expect("room");
    let doctor = |machine: &Machine| {
        let mut command = machine.command(&["doctor"]);
        let mut of_shared = Command::new(&own);
        of_shared.args(command.get_args()).current_dir(machine.work()).env_remove("CARGO_MANIFEST_DIR");
        of_shared.env_remove("DUROMETER_HOME").env_remove("DUROMETER_PYTHON").env("DUROMETER_CACHE", machine.cache());
        command = of_shared;
        // A process that another test starts at this moment has the copy open for writing until it runs its own program
        let output = loop {
            match command.output() {
                Err(error) if error.kind() == std::io::ErrorKind::ExecutableFileBusy => std::thread::yield_now(),
                output => break output.expect("it starts"),
            }
        };
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    // Its own checkout it takes
    let out = doctor(&machine);
    assert!(trace.exists() && out.contains("the program was built in this folder"), "{out}");
    if shared.metadata().expect("there").uid() == 0 {
        std::fs::remove_file(&trace).expect("own file");
        std::os::unix::fs::chown(shared.join("meshes/meshgen"), Some(65534), None).expect("root may");
        let out = doctor(&machine);
        assert!(!trace.exists() && out.contains("the files of the program, unpacked"), "{out}");
    }
}

/// Without the lines for debuggers, which a released program does not have. Places in code that dependencies generate in `target` are left to the
/// flags of a release, which `.ci/package` sets.
#[test]
fn the_program_does_not_hold_the_folder_of_its_build() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let bare = keep.path().join("durometer");
    let stripped =
        Command::new("strip").arg("-o").arg(&bare).arg(PROGRAM).status().is_ok_and(|status| status.success());
    if tools::is_missing(stripped, "strip (binutils)") {
        return;
    }
    let bytes = std::fs::read(&bare).expect("written");
    let found = |text: &str| {
        let at = bytes.windows(text.len()).enumerate().filter(|(_, window)| *window == text.as_bytes());
        at.map(|(k, _)| String::from_utf8_lossy(&bytes[k..(k + text.len() + 80).min(bytes.len())]).into_owned())
            .collect::<Vec<_>>()
    };
    assert!(!found("DUROMETER_CACHE").is_empty(), "the search finds what is there");
    let generated = format!("{ROOT}/target/");
    let mut own = found(ROOT);
    own.retain(|place| !place.starts_with(&generated));
    assert!(own.is_empty(), "{own:?}");
}
