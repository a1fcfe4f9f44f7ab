//! A study that Slurm or HyperQueue runs is the study that one process runs, whatever is killed meanwhile. The engines are the real ones, on this
//! machine; where one is not installed, its tests are skipped with a message.

mod slurm;

use crate::common::program::{call, said, without_mesher};
use crate::common::stores::{assert_same, write_slow_study, write_study};
use slurm::{Cluster, wait_for};
use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

fn folder() -> (tempfile::TempDir, PathBuf) {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path().to_path_buf();
    (keep, at)
}

/// Records of a folder of results, with their bytes.
fn records(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(dir.join("cases")).into_iter().flatten().flatten();
    let named = entries.map(|e| (e.file_name().to_string_lossy().into_owned(), e.path()));
    let records = named.filter(|(name, _)| name.ends_with(".json") && !name.starts_with('.'));
    records.filter_map(|(name, path)| Some((name, std::fs::read(path).ok()?))).collect()
}

/// How often each case was computed, by the logs of the tasks.
fn computed(dir: &Path) -> BTreeMap<String, usize> {
    let mut times = BTreeMap::new();
    for log in std::fs::read_dir(dir.join("engine/logs")).expect("logs").flatten() {
        let text = std::fs::read_to_string(log.path()).unwrap_or_default();
        for case in text.lines().filter_map(|l| l.strip_prefix("done ")?.split_whitespace().next().map(String::from)) {
            *times.entry(case).or_default() += 1;
        }
    }
    times
}

fn submit(at: &Path, cluster: &Cluster, options: &[&str]) -> String {
    let fixed = [
        "run",
        "study.toml",
        "--out",
        "r",
        "--engine",
        "slurm",
        "--task-time",
        "60 s",
        "--case-time",
        "20 s",
        "--case-memory",
        "0.3",
    ];
    let mut command = without_mesher(at, &[&fixed, options].concat());
    let output = command.env("SLURM_CONF", cluster.configuration()).output().expect("it starts");
    said(&output, "submission", 0).0
}

#[test]
fn slurm_runs_a_study_as_one_process_does() {
    let (_keep, at) = folder();
    let Some(cluster) = Cluster::start(&at.join("slurm")) else { return };
    write_study(&at, 12);
    call(&at, &["run", "study.toml", "--out", "whole"], 0);
    let said = submit(&at, &cluster, &["--tasks", "4"]);
    assert!(said.contains("submitted: 12 of 12 cases in 4 tasks"), "{said}");
    cluster.wait();
    assert_same(&at.join("whole"), &at.join("r"));
    assert!(at.join("r/index.html").is_file(), "the report follows the cases");
    assert!(computed(&at.join("r")).values().all(|n| *n == 1));
    let again = submit(&at, &cluster, &[]);
    assert!(again.contains("all 12 cases are stored"), "{again}");
}

/// One task is told that its time is over, one is cancelled before it begins, and the node dies; then the study is submitted again.
#[test]
fn slurm_loses_nothing_when_tasks_and_nodes_die() {
    let (_keep, at) = folder();
    let Some(mut cluster) = Cluster::start(&at.join("slurm")) else { return };
    write_slow_study(&at, 12);
    call(&at, &["run", "study.toml", "--out", "whole"], 0);
    let dir = at.join("r");
    let said = submit(&at, &cluster, &["--tasks", "3"]);
    let job = said.split("jobs ").nth(1).and_then(|rest| rest.split(',').next()).expect("an id").to_string();
    let some = |n: usize| wait_for("results", || (records(&dir).len() >= n).then(|| records(&dir)));
    some(1);
    cluster.said("scancel", &["--batch", "--signal=USR1", &format!("{job}_0")]);
    cluster.said("scancel", &[&format!("{job}_2")]);
    let before = some(3);
    cluster.kill_node();
    cluster.wait();
    let said = submit(&at, &cluster, &["--tasks", "3"]);
    assert!(
        said.contains("submitted: ") && !said.contains("submitted: 12 of 12"),
        "the cancelled task is left: {said}"
    );
    cluster.wait();
    assert_same(&at.join("whole"), &dir);
    let after = records(&dir);
    assert!(before.iter().all(|(name, bytes)| after[name] == *bytes), "a result that is there is not computed again");
    let twice: Vec<_> = computed(&dir).into_iter().filter(|(_, n)| *n > 1).collect();
    assert!(twice.is_empty(), "{twice:?}");
}

/// The Python that has HyperQueue: that of DUROMETER_PYTHON, of the project, or of the system.
fn python_with_hyperqueue() -> Option<PathBuf> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join(".venv/bin/python");
    let given = std::env::var_os("DUROMETER_PYTHON").map(PathBuf::from);
    let has = |python: &PathBuf| {
        let call = Command::new(python).args(["-c", "import hyperqueue"]).output();
        call.is_ok_and(|output| output.status.success())
    };
    let found = given.into_iter().chain([own, "python3".into()]).find(has);
    if found.is_none() {
        println!("skipped: HyperQueue is missing; .venv/bin/pip install hyperqueue");
    }
    found
}

/// A server with one worker of two cores, in one process.
fn start_hyperqueue(python: &Path, dir: &Path) -> (Child, String) {
    let script = "import sys, time\nfrom hyperqueue.cluster import LocalCluster, WorkerConfig\n\
        cluster = LocalCluster(sys.argv[1], WorkerConfig(cores=2))\nprint('server', cluster.cluster.server_dir, flush=True)\nsys.stdin.read()\n";
    std::fs::create_dir_all(dir).expect("room");
    let mut command = Command::new(python);
    command.args(["-c", script]).arg(dir).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut server = command.spawn().expect("Python starts");
    let lines = std::io::BufReader::new(server.stdout.take().expect("piped")).lines().map_while(Result::ok);
    let address = lines.filter_map(|l| l.strip_prefix("server ").map(String::from)).next();
    (server, address.expect("it says where it is"))
}

fn submit_to_hyperqueue(at: &Path, python: &Path, server: &str) -> String {
    let server = format!("--engine-option=--server-dir={server}");
    let options = ["--case-time", "60 min", "--memory-factor", "0", "--tasks", "4", "--task-time", "180 min", &server];
    let mut command =
        without_mesher(at, &[&["run", "study.toml", "--out", "r", "--engine", "hyperqueue"], &options[..]].concat());
    said(&command.env("DUROMETER_PYTHON", python).output().expect("it starts"), "submission", 0).0
}

#[test]
fn hyperqueue_runs_a_study_as_one_process_does_and_loses_nothing_when_it_is_killed() {
    let Some(python) = python_with_hyperqueue() else { return };
    let (_keep, at) = folder();
    write_slow_study(&at, 12);
    call(&at, &["run", "study.toml", "--out", "whole"], 0);
    let dir = at.join("r");
    let (mut server, address) = start_hyperqueue(&python, &at.join("hq-1"));
    let said = submit_to_hyperqueue(&at, &python, &address);
    assert!(said.contains("submitted: 12 of 12 cases in 4 tasks"), "{said}");
    wait_for("results", || (records(&dir).len() >= 2).then_some(()));
    server.kill().expect("it runs");
    server.wait().expect("it ends");
    wait_for("the end of its tasks", || tasks_of(&at).is_empty().then_some(()));
    let before = records(&dir);
    assert!(before.len() < 12, "it was killed in the middle");
    let (mut server, address) = start_hyperqueue(&python, &at.join("hq-2"));
    submit_to_hyperqueue(&at, &python, &address);
    wait_for("the report", || dir.join("index.html").is_file().then_some(()));
    server.kill().expect("it runs");
    server.wait().expect("it ends");
    assert_same(&at.join("whole"), &dir);
    let after = records(&dir);
    assert!(before.iter().all(|(name, bytes)| after[name] == *bytes), "a result that is there is not computed again");
}

/// Processes of the tasks of a folder.
fn tasks_of(at: &Path) -> Vec<String> {
    let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let commands = processes.filter_map(|p| std::fs::read(p.path().join("cmdline")).ok());
    let commands = commands.map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    commands.filter(|c| c.contains("/engine/batches-") && c.contains(&*at.to_string_lossy())).collect()
}

/// An engine that is not there is named, with what to install.
#[test]
fn a_missing_engine_says_what_to_install() {
    let (_keep, at) = folder();
    write_study(&at, 2);
    for (engine, words) in [("slurm", "apt install slurm-client"), ("hyperqueue", "pip install hyperqueue")] {
        let arguments = ["run", "study.toml", "--out", "r", "--engine", engine];
        let output = without_mesher(&at, &arguments).env("PATH", "/nonexistent").output().expect("it starts");
        let (_, errors) = said(&output, engine, 2);
        assert!(errors.contains(words) && errors.contains("is not found"), "{errors}");
    }
    let (files, _) = call(&at, &["run", "study.toml", "--out", "none", "--engine", "slurm", "--dry-run"], 0);
    assert!(files.contains("==> cases-1.sbatch <==") && files.contains("#SBATCH --array=0-0"), "{files}");
    assert!(!at.join("none").exists(), "nothing is written");
    for (options, words) in [
        (["--task-time", "0 s"], "--task-time: it is 0 s"),
        (["--time-factor", "0.5"], "--time-factor: it is 0.5"),
        (["--case-memory", "-1"], "--case-memory: it is -1"),
    ] {
        let fixed = ["run", "study.toml", "--out", "none", "--engine", "slurm", "--dry-run"];
        let [name, value] = options;
        let (_, errors) = call(&at, &[&fixed[..], &[&format!("{name}={value}")]].concat(), 2);
        assert!(errors.contains(words), "{errors}");
    }
    // Where the cases run here, options of a scheduler mean nothing
    for (options, words) in [
        (&["--dry-run"][..], "--engine"),
        (&["--task-time", "5 min"], "--engine"),
        (&["--task-time", "5 min", "--jobs", "2"], "cannot be used with"),
        (&["--engine", "local", "--dry-run"], "--dry-run prints the files of a scheduler"),
        (&["--engine", "local", "--task-time", "nonsense"], "--task-time"),
    ] {
        let (_, errors) = call(&at, &[&["run", "study.toml", "--out", "none"][..], options].concat(), 2);
        assert!(errors.contains(words) && !at.join("none").exists(), "{errors}");
    }
    for (batch, words) in [("none.txt:1", "none.txt: it cannot be read"), ("1", "names no batch")] {
        let (_, errors) = call(&at, &["run", "study.toml", "--out", "none", "--batch", batch], 2);
        assert!(errors.contains(words), "{errors}");
    }
}
