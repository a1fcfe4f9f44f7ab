//! Cases in processes of their own: the results are those of threads, and whatever ends a process is the status of one case.
#![cfg(target_os = "linux")]

use crate::common::program::without_mesher;
use crate::common::stores::{contents, write_rod};
use durometer::scene::Progress;
use durometer::study::expand::Study;
use durometer::study::run::growing::run_study;
use durometer::study::run::runner::{Isolation, Options, Watch};
use durometer::study::store::record::CaseRecord;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

const PROGRAM: &str = env!("CARGO_BIN_EXE_durometer");
const SCENE: &str = r#"
title = "A block that is pressed"
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
region = "zmin"
components = "xyz"
[[constraint]]
kind = "prescribed"
region = "zmax"
components = "z"
displacement = { kind = "ramp", from = "0 mm", to = "-2 mm", start = "0 s", end = "1 s" }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.05 s"
[[probe]]
kind = "reaction"
region = "zmax"
"#;
const STUDY: &str = r#"
kind = "comparison"
reference = "c0"
question = "Does a killed process harm the others?"
expectation = "No."
scene = "scene.toml"
tolerance = "5 %"
[[variant]]
name = "press"
quantity = [{ name = "zmax_reaction_z_N", label = "force", symbol = "F", unit = "N" }]
[[family]]
name = "steps"
role = "members"
[family.members]
"#;

/// A folder with a study of one case per mesh: cells along the three axes.
fn study(meshes: &[[usize; 3]]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let members = meshes.iter().enumerate();
    // Each its own modulus, so that no two cases are the same scene
    let member =
        |(k, d)| format!("c{k} = {{ \"mesh.grid.divisions\" = {d:?}, \"laws.rubber.E\" = \"{} kPa\" }}\n", 100 + k);
    let text = STUDY.to_string() + &members.map(member).collect::<String>();
    std::fs::write(folder.path().join("study.toml"), text).expect("writable");
    std::fs::write(folder.path().join("scene.toml"), SCENE).expect("writable");
    folder
}

/// Panics in the second step of one case.
struct Bug;
impl Watch for Bug {
    fn progress(&self, case: &str, _: Progress) {
        assert!(!case.ends_with("c1"), "a bug in the middle of c1");
    }
}

fn in_library(folder: &Path, out: &str, isolation: Isolation, watch: &dyn Watch) -> Vec<CaseRecord> {
    let study = Study::read(&folder.join("study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let stop = AtomicBool::new(false);
    let options = Options { jobs: 2, isolation, ..Options::new(&stop) };
    run_study(&study, &folder.join(out), &options, watch).unwrap_or_else(|e| panic!("{e}"))
}

fn command(folder: &Path, out: &str, more: &[&str]) -> Command {
    let mut command = Command::new(PROGRAM);
    command.args(["run", "study.toml", "--out", out]).args(more).current_dir(folder);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

/// Exit code and standard error of a run that is not disturbed.
fn finish(child: Child) -> (Option<i32>, String) {
    let output = child.wait_with_output().expect("it ends");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn statuses(results: &Path) -> BTreeMap<String, String> {
    let cases = std::fs::read_dir(results.join("cases")).expect("results").map(|e| e.expect("readable").path());
    let records = cases.filter(|path| path.extension().is_some_and(|e| e == "json"));
    let status = |path: PathBuf| {
        let record: Value = serde_json::from_slice(&std::fs::read(&path).expect("readable")).expect("JSON");
        let text = |key: &str| record[key].as_str().unwrap_or_default().to_string();
        (text("member"), format!("{}: {}", text("status"), text("status_detail")))
    };
    records.map(status).collect()
}

/// Processes whose parent this is.
fn children(of: u32) -> Vec<i32> {
    let all = std::fs::read_dir("/proc").expect("Linux").flatten();
    let pids = all.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
    let parent = |pid: &i32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        let (_, rest) = stat.rsplit_once(')')?;
        let mut fields = rest.split_whitespace();
        (fields.next()? != "Z").then(|| fields.next()?.parse::<u32>().ok()).flatten()
    };
    pids.filter(|pid| parent(pid) == Some(of)).collect()
}

/// Waits until something is there, for at most ten seconds.
fn wait_for<T>(mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < Duration::from_secs(10), "it does not come");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn processes_give_the_results_of_threads() {
    let folder = study(&[[4, 2, 2], [6, 3, 3], [5, 2, 2]]);
    let at = folder.path();
    let threads = in_library(at, "threads", Isolation::Threads, &());
    let apart = in_library(at, "apart", Isolation::Processes(PROGRAM.into()), &());
    assert!(threads.iter().all(CaseRecord::converged) && apart.len() == 3);
    assert_eq!(contents(&at.join("threads")), contents(&at.join("apart")));
    // In one process the memory of a case that ran next to others is not known
    assert!(apart.iter().all(|record| record.work.memory_bytes.is_some_and(|bytes| bytes > 1 << 20)), "{apart:?}");
}

/// Mistakes that end a case are found in all cases before the first one runs: those that need no mesh before there is one, the others on the meshes.
#[test]
fn all_cases_with_mistakes_are_named_before_one_runs() {
    let folder = study(&[[4, 2, 2], [5, 2, 2]]);
    let at = folder.path();
    let text = std::fs::read_to_string(at.join("study.toml")).expect("the study");
    let refuses = |members: &str, named: &[&str], unnamed: &str| {
        std::fs::write(at.join("study.toml"), format!("{text}{members}")).expect("writable");
        let (code, said) = finish(command(at, "results", &[]).spawn().expect("it starts"));
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains("none of the cases was run, because some are refused"), "{said}");
        assert!(named.iter().all(|name| said.contains(name)) && !said.contains(unnamed), "{said}");
        let records = std::fs::read_dir(at.join("results/cases")).into_iter().flatten().count();
        assert_eq!(records, 0, "{said}");
    };
    let sound = "case steps-press-c0";
    refuses(
        "x0 = { \"numerics.cuts\" = 1000 }\nx1 = { \"stage.0.dt\" = \"-1 s\" }\nx2 = { \"laws.rubber.nu\" = 0.6 }\n",
        &[
            "case steps-press-x0",
            "numerics: cuts",
            "case steps-press-x1",
            "stage 1: dt",
            "case steps-press-x2",
            "laws.rubber",
        ],
        sound,
    );
    refuses(
        "x0 = { \"constraint.fixed.region\" = \"zmni\" }\nx1 = { \"constraint.prescribed.components\" = \"w\" }\n\
         x2 = { \"mesh.regions\" = { far = { kind = \"box\", min = [\"1 m\", \"1 m\", \"1 m\"], max = [\"2 m\", \"2 m\", \"2 m\"] } } }\n",
        &["case steps-press-x0", "did you mean `zmin`", "case steps-press-x1", "case steps-press-x2", "far"],
        sound,
    );
    // Without mistakes everything runs
    std::fs::write(at.join("study.toml"), text).expect("writable");
    assert_eq!(finish(command(at, "results", &[]).spawn().expect("it starts")).0, Some(0));
}

/// A panic is the status of its case; the next run computes it again.
#[test]
fn a_panic_ends_its_case_only() {
    let folder = study(&[[4, 2, 2], [6, 3, 3], [5, 2, 2]]);
    let at = folder.path();
    in_library(at, "whole", Isolation::Threads, &());
    let records = in_library(at, "results", Isolation::Threads, &Bug);
    let status: Vec<&str> = records.iter().map(|r| r.status.as_str()).collect();
    assert_eq!(status, ["Converged", "Panicked", "Converged"]);
    assert!(records[1].status_detail.as_ref().is_some_and(|d| d.contains("a bug in the middle of c1")), "{records:?}");
    in_library(at, "results", Isolation::Threads, &());
    assert_eq!(contents(&at.join("whole")), contents(&at.join("results")));
}

/// A process that is killed is the status of its case; the next run computes it again.
#[test]
fn a_killed_process_ends_its_case_only() {
    let folder = study(&[[12, 6, 6], [4, 2, 2], [5, 2, 2]]);
    let at = folder.path();
    assert_eq!(finish(command(at, "whole", &[]).spawn().expect("it starts")).0, Some(0));
    let run = command(at, "results", &["--jobs", "1"]).spawn().expect("it starts");
    let worker = wait_for(|| children(run.id()).pop());
    kill(Pid::from_raw(worker), Signal::SIGKILL).expect("it runs");
    let (code, said) = finish(run);
    assert_eq!(code, Some(3), "{said}");
    let status = statuses(&at.join("results"));
    assert!(status["c0"].starts_with("Crashed: the process of the case ended with signal: 9"), "{status:?}");
    assert!(status["c0"].contains("--jobs") && said.contains("not complete: steps-press-c0: Crashed"), "{said}");
    assert!(status["c1"].starts_with("Converged") && status["c2"].starts_with("Converged"), "{status:?}");
    assert_eq!(finish(command(at, "results", &[]).spawn().expect("it starts")).0, Some(0));
    assert_eq!(contents(&at.join("whole")), contents(&at.join("results")));
}

/// A run that waits for a case whose earlier result broke takes the result of the run that computes it, and not the earlier one.
#[test]
fn a_broken_result_is_not_the_answer_while_another_run_computes() {
    let folder = study(&[[12, 6, 6], [4, 2, 2]]);
    let at = folder.path();
    let killed = command(at, "results", &["--jobs", "1"]).spawn().expect("it starts");
    let worker = wait_for(|| children(killed.id()).pop());
    kill(Pid::from_raw(worker), Signal::SIGKILL).expect("it runs");
    assert_eq!(finish(killed).0, Some(3));
    assert!(statuses(&at.join("results"))["c0"].starts_with("Crashed"));
    let first = command(at, "results", &["--jobs", "1"]).spawn().expect("it starts");
    let worker = Pid::from_raw(wait_for(|| children(first.id()).pop()));
    kill(worker, Signal::SIGSTOP).expect("it runs");
    let second = command(at, "results", &["--jobs", "1"]).spawn().expect("it starts");
    // Time in which the second run looks at the case more than once
    std::thread::sleep(Duration::from_secs(3));
    kill(worker, Signal::SIGCONT).expect("it waits");
    for run in [first, second] {
        let (code, said) = finish(run);
        assert!(code == Some(0) && !said.contains("Crashed"), "{said}");
    }
    assert!(statuses(&at.join("results"))["c0"].starts_with("Converged"));
}

/// Where memory is limited below the need of one case, this case has a status and the others finish.
#[test]
fn a_case_without_memory_ends_alone() {
    let folder = study(&[[36, 18, 18], [4, 2, 2], [5, 2, 2]]);
    let limit = |command: Command| {
        let mut limited = Command::new("sh");
        // Kilobytes of address space: the small cases need less, the factor of the large one is larger alone
        limited.env("MALLOC_ARENA_MAX", "2");
        limited.args(["-c", "ulimit -v 250000; exec \"$@\"", "sh"]).arg(command.get_program()).args(command.get_args());
        limited.current_dir(command.get_current_dir().expect("given")).stdout(Stdio::null()).stderr(Stdio::piped());
        limited
    };
    let at = folder.path();
    // The limit is seen before the factorisation; where more is allowed than there is, the process of the case dies of it
    for (out, memory, end) in [("seen", &[][..], "OutOfMemory: "), ("met", &["--memory", "100 GB"][..], "Crashed: ")] {
        let run = limit(command(at, out, &[&["--jobs", "1"], memory].concat())).spawn().expect("it starts");
        let (code, said) = finish(run);
        assert_eq!(code, Some(3), "{said}");
        let status = statuses(&at.join(out));
        assert!(status["c0"].starts_with(end) && status["c0"].contains("memory"), "{status:?}");
        assert!(status["c1"].starts_with("Converged") && status["c2"].starts_with("Converged"), "{status:?}");
    }
}

/// When a run is killed, the processes of its cases end too, and the next run makes the rest.
#[test]
fn nothing_survives_a_killed_run() {
    let folder = study(&[[12, 6, 6], [11, 6, 6], [5, 2, 2]]);
    let at = folder.path();
    assert_eq!(finish(command(at, "whole", &[]).spawn().expect("it starts")).0, Some(0));
    let mut run = command(at, "results", &["--jobs", "2"]).spawn().expect("it starts");
    let workers = wait_for(|| Some(children(run.id())).filter(|all| all.len() == 2));
    run.kill().expect("it runs");
    run.wait().expect("it ends");
    let gone =
        |pid: &i32| std::fs::read_to_string(format!("/proc/{pid}/stat")).map_or(true, |stat| stat.contains(") Z"));
    wait_for(|| workers.iter().all(gone).then_some(()));
    assert_eq!(finish(command(at, "results", &[]).spawn().expect("it starts")).0, Some(0));
    assert_eq!(contents(&at.join("whole")), contents(&at.join("results")));
}

/// Twenty small cases.
fn twenty() -> tempfile::TempDir {
    study(&std::array::from_fn::<_, 20, _>(|k| [4 + k % 5, 2 + k % 3, 3]))
}

/// Numbers of cases that a run has computed and kept, from what it says.
fn counts(said: &str) -> (usize, usize) {
    let lines = |head: &str| said.lines().filter(|line| line.starts_with(head)).count();
    (lines("done "), lines("kept "))
}

/// Several runs share the cases of a store: each is computed once, and every run ends with all of them.
fn together(runs: usize) {
    let folder = twenty();
    let at = folder.path();
    assert_eq!(finish(command(at, "whole", &[]).spawn().expect("it starts")).0, Some(0));
    let start = |_| command(at, "results", &["--jobs", "2"]).spawn().expect("it starts");
    let all: Vec<Child> = (0..runs).map(start).collect();
    let ended: Vec<_> = all.into_iter().map(finish).collect();
    assert!(ended.iter().all(|(code, _)| *code == Some(0)), "{ended:?}");
    let counts: Vec<(usize, usize)> = ended.iter().map(|(_, said)| counts(said)).collect();
    assert!(counts.iter().all(|(done, kept)| done + kept == 20), "{counts:?}");
    assert_eq!(counts.iter().map(|(done, _)| done).sum::<usize>(), 20, "{counts:?}");
    assert_eq!(contents(&at.join("whole")), contents(&at.join("results")));
    assert!(std::fs::read_dir(at.join("results/locks")).expect("there").next().is_none());
}

#[test]
fn two_runs_share_a_store() {
    together(2);
}

#[test]
fn eight_runs_share_a_store() {
    together(8);
}

/// A run with other changes into the same folder is refused while the first one lives; scenes do not mix.
#[test]
fn a_living_run_of_another_study_is_not_disturbed() {
    let folder = study(&[[12, 6, 6], [11, 6, 6], [5, 2, 2]]);
    let at = folder.path();
    assert_eq!(finish(command(at, "whole", &[]).spawn().expect("it starts")).0, Some(0));
    let first = command(at, "results", &["--jobs", "1"]).spawn().expect("it starts");
    wait_for(|| children(first.id()).pop());
    // It lives, and does not end before the other has looked
    let process = Pid::from_raw(first.id() as i32);
    kill(process, Signal::SIGSTOP).expect("it runs");
    let (code, said) = finish(command(at, "results", &["--set", "laws.rubber.nu=0.4"]).spawn().expect("it starts"));
    kill(process, Signal::SIGCONT).expect("it runs");
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("computes another study into it") && said.contains("--out"), "{said}");
    assert_eq!(finish(first).0, Some(0));
    assert_eq!(contents(&at.join("whole")), contents(&at.join("results")));
}

/// A damaged result is named, set aside and computed again; one of a newer version is refused.
#[test]
fn damaged_and_newer_results_are_named() {
    let folder = study(&[[4, 2, 2], [5, 2, 2]]);
    let at = folder.path();
    let run = || finish(command(at, "results", &[]).spawn().expect("it starts"));
    assert_eq!(run().0, Some(0));
    let whole = contents(&at.join("results"));
    let (record, csv) = (at.join("results/cases/steps-press-c0.json"), at.join("results/cases/steps-press-c1.csv"));
    let sound = std::fs::read_to_string(&record).expect("stored");
    std::fs::write(&record, &sound[..sound.len() / 2]).expect("writable");
    std::fs::write(&csv, "t_s\n0\n").expect("writable");
    let (code, said) = run();
    assert_eq!((code, counts(&said)), (Some(0), (2, 0)), "{said}");
    for aside in ["cases/steps-press-c0.damaged-1.json", "cases/steps-press-c1.damaged-1.json"] {
        assert!(said.contains(&format!("set aside as {aside}")) && at.join("results").join(aside).is_file(), "{said}");
    }
    let again = contents(&at.join("results"));
    assert!(whole.iter().all(|(name, bytes)| again[name] == *bytes));
    let study = at.join("results/study.json");
    for path in [record, study] {
        let text = std::fs::read_to_string(&path).expect("stored");
        std::fs::write(&path, text.replace("\"schema\": 1", "\"schema\": 2")).expect("writable");
        let (code, said) = run();
        assert_eq!(code, Some(2), "{said}");
        assert!(said.contains("newer version") && said.contains("schema 2"), "{said}");
        std::fs::write(&path, text).expect("writable");
    }
    assert_eq!(run().0, Some(0));
}

/// SIGTERM is like Ctrl-C: finished cases are kept, the exit code is 3, and the next run makes the rest.
#[test]
fn a_termination_keeps_what_is_finished() {
    let folder = study(&[[12, 6, 6], [11, 6, 6], [5, 2, 2]]);
    let at = folder.path();
    assert_eq!(finish(command(at, "whole", &[]).spawn().expect("it starts")).0, Some(0));
    let run = command(at, "results", &["--jobs", "1"]).spawn().expect("it starts");
    let worker = wait_for(|| children(run.id()).pop());
    kill(Pid::from_raw(run.id() as i32), Signal::SIGTERM).expect("it runs");
    let start = Instant::now();
    let (code, said) = finish(run);
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("stopped: ") && start.elapsed() < Duration::from_secs(2), "{said}");
    assert!(!Path::new(&format!("/proc/{worker}")).exists());
    assert_eq!(finish(command(at, "results", &[]).spawn().expect("it starts")).0, Some(0));
    assert_eq!(contents(&at.join("whole")), contents(&at.join("results")));
}

/// All earlier results are still there when a run that computes them again is stopped, and its last words say so.
#[test]
fn a_termination_of_a_redo_counts_what_is_there() {
    let folder = study(&[[12, 6, 6], [11, 6, 6], [5, 2, 2]]);
    let at = folder.path();
    assert_eq!(finish(command(at, "results", &[]).spawn().expect("it starts")).0, Some(0));
    let whole = contents(&at.join("results"));
    let run = command(at, "results", &["--redo", "--jobs", "1"]).spawn().expect("it starts");
    wait_for(|| children(run.id()).pop());
    kill(Pid::from_raw(run.id() as i32), Signal::SIGTERM).expect("it runs");
    let (code, said) = finish(run);
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("of 3 cases were run again; 3 have a result in results"), "{said}");
    assert_eq!(contents(&at.join("results")), whole);
    let (code, said) = finish(command(at, "results", &[]).spawn().expect("it starts"));
    assert_eq!((code, counts(&said)), (Some(0), (0, 3)), "{said}");
}

/// Kills runs and the processes of their cases at moments that a generator of random numbers draws, until a run ends by itself; then
/// everything is as without.
fn killed_at_random(kills: usize, seed: u64) {
    let folder = twenty();
    let at = folder.path();
    let start = Instant::now();
    assert_eq!(finish(command(at, "whole", &["--jobs", "2"]).spawn().expect("it starts")).0, Some(0));
    let whole = start.elapsed();
    let mut state = seed;
    let mut draw = |below: u128| {
        // Knuth's generator modulo 2^64; the upper bits are the random ones
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (u128::from(state >> 33) * below) >> 31
    };
    for _ in 0..kills {
        // What is done is computed again in every third round, so that there is always something to disturb
        let more = if draw(3) == 0 { &["--jobs", "2", "--redo"][..] } else { &["--jobs", "2"][..] };
        let mut run = command(at, "results", more).stderr(Stdio::null()).spawn().expect("it starts");
        std::thread::sleep(Duration::from_micros(draw(whole.as_micros()) as u64));
        match children(run.id()).first().filter(|_| draw(2) == 0) {
            Some(worker) => {
                kill(Pid::from_raw(*worker), Signal::SIGKILL).ok();
                std::thread::sleep(Duration::from_micros(draw(20_000) as u64));
                run.kill().expect("it is a child");
            }
            None => run.kill().expect("it is a child"),
        }
        run.wait().expect("it ends");
    }
    let (code, said) = finish(command(at, "results", &[]).spawn().expect("it starts"));
    assert_eq!(code, Some(0), "{said}");
    let (whole, found) = (contents(&at.join("whole")), contents(&at.join("results")));
    assert_eq!(whole, found, "a kill harms nothing");
}

#[test]
fn kills_at_random_moments_harm_nothing() {
    killed_at_random(8, 1);
}

#[test]
#[ignore = "takes minutes"]
fn two_hundred_kills_harm_nothing() {
    killed_at_random(200, 2);
}

/// The time budget ends a run within its only step.
#[test]
fn a_time_budget_ends_a_step() {
    let folder = study(&[[24, 12, 12]]);
    let at = folder.path();
    let scene = SCENE.replace("dt = \"0.05 s\"", "dt = \"1 s\"") + "[numerics]\ntime_budget = \"50 ms\"\n";
    std::fs::write(at.join("scene.toml"), scene).expect("writable");
    let records = in_library(at, "results", Isolation::Threads, &());
    assert_eq!((records[0].status.as_str(), records[0].steps), ("TimeBudget", 0), "{:?}", records[0].status_detail);
}

/// What a case is going to take is known before; where it is more than allowed, the case has a status, and what is allowed is not
/// exceeded by several cases together.
#[test]
fn cases_take_the_memory_that_is_allowed() {
    let folder = study(&[[24, 12, 12], [4, 2, 2], [24, 12, 11], [24, 11, 12]]);
    let at = folder.path();
    let (code, said) = finish(command(at, "free", &["--jobs", "4"]).spawn().expect("it starts"));
    assert_eq!(code, Some(0), "{said}");
    let record = |out: &str, member: &str| -> Value {
        let path = at.join(format!("{out}/cases/steps-press-{member}.json"));
        serde_json::from_slice(&std::fs::read(path).expect("stored")).expect("JSON")
    };
    for member in ["c0", "c2", "c3"] {
        let work = &record("free", member)["work"];
        let ratio = work["expected_bytes"].as_f64().expect("known") / work["memory_bytes"].as_f64().expect("measured");
        // The copy in single precision need not be made, and not everything that is counted is held at the same time
        assert!((1.0..1.5).contains(&ratio), "{member}: {ratio}");
    }
    let expected = record("free", "c0")["work"]["expected_bytes"].as_u64().expect("known");
    // Two of them do not fit, and one does: they wait for each other
    let allowed = format!("{} MB", (1.5 * expected as f64 / 1e6) as u64);
    let (code, said) = finish(command(at, "tight", &["--jobs", "4", "--memory", &allowed]).spawn().expect("it starts"));
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(contents(&at.join("free")), contents(&at.join("tight")));
    let allowed = format!("{} MB", expected * 3 / 4 / 1_000_000);
    let (code, said) = finish(command(at, "short", &["--jobs", "4", "--memory", &allowed]).spawn().expect("it starts"));
    assert_eq!(code, Some(3), "{said}");
    let status = statuses(&at.join("short"));
    assert!(status["c0"].starts_with("OutOfMemory: ") && status["c0"].contains("--memory"), "{status:?}");
    assert!(status["c1"].starts_with("Converged"), "{status:?}");
}

/// A command that is stopped while the mesher works has not been given bad input: its exit code is that of a stop.
#[test]
fn a_simulation_that_is_stopped_while_meshing_says_so() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    write_rod(at, "echo meshing >&2\nexec sleep 60");
    let mut run =
        without_mesher(at, &["simulate", "rod.toml", "--out", "r"]).stderr(Stdio::piped()).spawn().expect("it starts");
    let mut said = BufReader::new(run.stderr.take().expect("piped")).lines().map_while(Result::ok);
    assert!(said.by_ref().any(|line| line.contains("meshing")));
    let mesher = wait_for(|| children(run.id()).pop());
    kill(Pid::from_raw(run.id() as i32), Signal::SIGTERM).expect("it runs");
    let rest: Vec<String> = said.collect();
    assert_eq!(run.wait().expect("it ends").code(), Some(3), "{rest:?}");
    assert!(rest.iter().any(|line| line.starts_with("stopped: ")), "{rest:?}");
    assert!(!Path::new(&format!("/proc/{mesher}")).exists());
}
