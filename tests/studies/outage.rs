//! A power cut or a stop at any call that writes, and a disk that is full at any byte, harm nothing: the next call gives what an undisturbed one
//! gives. So does a file system without hard links.
#![cfg(target_os = "linux")]

use crate::common::disk;
use crate::common::disk::{Disk, Fault};
use crate::common::program::{call, said, without_mesher};
use crate::common::stores::{assert_same, contents, write_rod, write_study};
use durometer::study::store::upkeep::verify;
use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Moments that a test in CI takes, of all there are.
const SOME: i64 = 12;
/// Calls before and after one that matters.
const ABOUT: i64 = 8;

/// A command whose results are in the folder `r`, and which parts of them are compared.
struct Job {
    arguments: &'static [&'static str],
    /// Makes what the command needs in an empty folder
    prepare: fn(&Path),
    /// Compares an undisturbed folder of results with another one
    compare: fn(&Path, &Path),
}

const STUDY: Job = Job {
    arguments: &["run", "study.toml", "--out", "r", "--jobs", "1"],
    prepare: |at| write_study(at, 3),
    compare: |whole, found| {
        assert_same(whole, found);
        assert!(found.join("index.html").is_file() && found.join("summary.json").is_file());
    },
};
const REDO: Job = Job {
    arguments: &["run", "study.toml", "--out", "r", "--jobs", "1", "--redo"],
    prepare: |at| {
        write_study(at, 2);
        call(at, STUDY.arguments, 0);
        let scene = std::fs::read_to_string(at.join("scene.toml")).expect("there");
        std::fs::write(at.join("scene.toml"), scene.replace("nu = 0.3", "nu = 0.4")).expect("room");
    },
    compare: assert_same,
};
const REPORT: Job = Job {
    arguments: &["report", "r"],
    prepare: |at| {
        write_study(at, 3);
        call(at, &["run", "study.toml", "--out", "r", "--jobs", "1"], 0);
        for entry in std::fs::read_dir(at.join("r")).expect("results").flatten() {
            match entry.file_name().to_str() {
                Some("figures" | "paper" | "tables") => std::fs::remove_dir_all(entry.path()).expect("own folder"),
                Some("index.html" | "summary.json") => std::fs::remove_file(entry.path()).expect("own file"),
                _ => {}
            }
        }
    },
    compare: |whole, found| assert_same_sizes(&["", "figures", "paper", "tables"], whole, found),
};
const FIT: Job = Job {
    arguments: &["fit", "t.csv", "--law", "neo_hookean", "--mode", "uniaxial", "--out", "r"],
    prepare: |at| {
        let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/treloar-1944/treloar-1944.csv");
        std::fs::copy(table, at.join("t.csv")).expect("room");
    },
    compare: |whole, found| assert_same_sizes(&["", "figures", "tables"], whole, found),
};
const SIMULATE: Job = Job {
    arguments: &["simulate", "scene.toml", "--out", "r"],
    prepare: |at| write_study(at, 1),
    compare: |whole, found| {
        let table = |dir: &Path| std::fs::read(dir.join("scene.csv")).expect("a table");
        assert_eq!(table(whole), table(found));
    },
};

const MESH: Job = Job {
    arguments: &["mesh", "rod.toml"],
    prepare: |at| write_rod(at, MESHER),
    compare: |whole, found| {
        let made = |dir: &Path| {
            let cache = std::fs::read_dir(dir.with_file_name("meshes").join("cache")).expect("meshes");
            let files = cache.flatten().filter(|e| !e.file_name().to_string_lossy().starts_with('.'));
            files.map(|e| (e.file_name(), std::fs::read(e.path()).expect("readable"))).collect::<BTreeMap<_, _>>()
        };
        assert_eq!(made(whole).len(), 2, "a mesh and its manifest");
        assert_eq!(made(whole), made(found));
    },
};
/// A mesher of one tetrahedron.
const MESHER: &str = r#"out=$(sed 's/.*"output":"\([^"]*\)".*/\1/')
printf '$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n' > "$out.text"
printf '$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n' >> "$out.text"
gzip -n < "$out.text" > "$out"
rm "$out.text"
cat <<'END'
{"request":{"body":"rod","output":"x"},"cells":1,"nodes":4,"facets":4,"order":1,"h_m":0.55,
"regions":{"body":{"dim":3,"count":1}},"quality":{"sicn_min":0.5},"volume_m3":0.1667,"volume_cad_m3":null,"volume_error":null,
"edge_error_m":0.0,"paths":{},"versions":{"gmsh":"4.15.2","cgal":null},"wall_s":0.1,"length_m":0.0039}
END"#;

/// Files by name and size. Numbers of fonts in a PDF, and times, change from call to call.
fn assert_same_sizes(folders: &[&str], whole: &Path, found: &Path) {
    let files = |dir: &Path| -> BTreeMap<String, u64> {
        let all = folders.iter().flat_map(|f| std::fs::read_dir(dir.join(f)).into_iter().flatten().flatten());
        let files = all.filter(|e| e.path().is_file() && !e.file_name().to_string_lossy().ends_with(".part"));
        files.map(|e| (e.path().strip_prefix(dir).expect("inside").display().to_string(), size(&e.path()))).collect()
    };
    assert_eq!(files(whole), files(found));
}

fn size(path: &Path) -> u64 {
    std::fs::metadata(path).expect("there").len()
}

impl Job {
    fn command(&self, at: &Path) -> Command {
        without_mesher(at, self.arguments)
    }

    /// A folder in which it can be called.
    fn prepared(&self) -> tempfile::TempDir {
        let keep = tempfile::tempdir().expect("a temporary folder");
        (self.prepare)(keep.path());
        keep
    }

    /// The results of an undisturbed call in a folder like this, and the calls and bytes it takes.
    fn whole(&self, prepared: &Path) -> (tempfile::TempDir, disk::Counts) {
        let keep = copy(prepared);
        let (output, counts) = Disk::new(keep.path()).call(self.command(keep.path()), Fault::None);
        said(&output, "undisturbed", 0);
        (keep, counts)
    }

    /// The power is cut at some of the calls, or at all.
    fn survives_power_cuts(&self, moments: i64) {
        let prepared = self.prepared();
        let (whole, counts) = self.whole(prepared.path());
        for k in moments_of(counts.calls, moments) {
            let keep = copy(prepared.path());
            let (at, disk) = (keep.path(), Disk::new(keep.path()));
            let (output, found) = disk.call(self.command(at), Fault::Cut(k));
            // The sign of life of a run may be a call more or less
            let is_cut = found.calls >= k;
            assert_eq!(output.status.code().is_none(), is_cut, "the power was cut at {k} of {}", counts.calls);
            disk.lose(k % 2 == 0);
            self.goes_on(&output, &whole.path().join("r"), at, &format!("after a cut at {k}"));
        }
    }

    /// There is room for a part of the bytes.
    fn survives_a_full_disk(&self, moments: i64) {
        let prepared = self.prepared();
        let (whole, counts) = self.whole(prepared.path());
        for bytes in moments_of(counts.bytes - 1, moments) {
            let keep = copy(prepared.path());
            let (at, disk) = (keep.path(), Disk::new(keep.path()));
            let (output, found) = disk.call(self.command(at), Fault::Space(bytes));
            let words = format!("{:?}, room for {bytes} of {} bytes", self.arguments, counts.bytes);
            // Times have more or fewer digits
            if found.bytes > bytes {
                refused(&output, &words);
            }
            self.goes_on(&output, &whole.path().join("r"), at, &words);
        }
    }

    /// The program is killed at some of the calls, and at each of those about the one from which on the last case has its new result, or finds no room: each
    /// case has its earlier result or its new one, whole.
    fn keeps_results(&self, moments: i64) {
        let prepared = self.prepared();
        let (whole, counts) = self.whole(prepared.path());
        let (earlier, new) = (contents(&prepared.path().join("r")), contents(&whole.path().join("r")));
        assert!(new.iter().all(|(name, bytes)| earlier[name] != *bytes), "the results differ");
        let is_all_new_after = |fault: Fault| {
            let keep = copy(prepared.path());
            Disk::new(keep.path()).call(self.command(keep.path()), fault);
            let found = verify(&keep.path().join("r")).unwrap_or_else(|e| panic!("{e}"));
            assert!(found.damaged.is_empty() && found.missing.is_empty(), "{fault:?}: {found:?}");
            let found = contents(&keep.path().join("r"));
            assert!(found.iter().all(|(name, bytes)| [&earlier[name], &new[name]].contains(&bytes)), "{fault:?}");
            found == new
        };
        let (mut low, mut high) = (1, counts.calls);
        while low < high {
            let middle = (low + high) / 2;
            if is_all_new_after(Fault::Cut(middle)) { high = middle } else { low = middle + 1 }
        }
        let cuts = moments_of(counts.calls, moments).into_iter().chain(low - ABOUT..=low + ABOUT).map(Fault::Cut);
        for fault in cuts.chain(moments_of(counts.bytes - 1, moments).into_iter().map(Fault::Space)) {
            is_all_new_after(fault);
        }
    }

    /// The user stops the program at some of the calls.
    fn survives_stops(&self, moments: i64) {
        let prepared = self.prepared();
        let (whole, counts) = self.whole(prepared.path());
        for k in moments_of(counts.calls, moments) {
            let keep = copy(prepared.path());
            let output = Disk::new(keep.path()).call(self.command(keep.path()), Fault::Stop(k)).0;
            let words = format!("{:?} was stopped at {k} of {}", self.arguments, counts.calls);
            match output.status.code() {
                // Ended by the signal
                None => assert_eq!(output.status.signal(), Some(2), "{words}"),
                Some(3) => {
                    let errors = String::from_utf8_lossy(&output.stderr);
                    assert!(errors.contains("stopped"), "{words}: {errors}");
                }
                // Too late: everything is there
                Some(0) => (self.compare)(&whole.path().join("r"), &keep.path().join("r")),
                code => panic!("{words}: {code:?}\n{}", String::from_utf8_lossy(&output.stderr)),
            }
            self.goes_on(&output, &whole.path().join("r"), keep.path(), &words);
        }
    }

    /// The next call keeps the cases that were finished, and gives the undisturbed results.
    fn goes_on(&self, disturbed: &Output, whole: &Path, at: &Path, when: &str) {
        let (_, again) = said(&self.command(at).output().expect("it starts"), when, 0);
        (self.compare)(whole, &at.join("r"));
        if at.join("r/study.json").is_file() {
            let first = String::from_utf8_lossy(&disturbed.stderr);
            let kept = cases(&again, "kept ");
            assert!(cases(&first, "done ").iter().all(|id| kept.contains(id)), "{when}: {first}\n{again}");
            call(at, &["store", "verify", "r"], 0);
        }
    }
}

/// The cases of lines with this head.
fn cases<'a>(said: &'a str, head: &str) -> Vec<&'a str> {
    said.lines().filter_map(|line| line.strip_prefix(head)?.split_whitespace().next()).collect()
}

/// A copy of a folder, with the times of its files.
fn copy(folder: &Path) -> tempfile::TempDir {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let copied = Command::new("cp").arg("-a").arg(folder.join(".")).arg(keep.path()).status();
    assert!(copied.expect("cp").success());
    keep
}

/// So many moments from 1 to the last, evenly distributed.
fn moments_of(last: i64, most: i64) -> Vec<i64> {
    let n = most.min(last);
    (0..n).map(|k| 1 + (last - 1) * k / (n - 1).max(1)).collect()
}

/// The program has named a file and why it cannot be written.
fn refused(output: &Output, words: &str) {
    let (_, errors) = said(output, words, 2);
    let names_it = ["No space left on device", "the disk is full"].iter().any(|fact| errors.contains(fact));
    assert!(names_it && !errors.contains("panicked"), "{words}: {errors}");
}

#[test]
fn a_power_cut_harms_no_study() {
    STUDY.survives_power_cuts(SOME);
}

#[test]
fn a_result_stays_until_the_next_one_is_there() {
    REDO.keeps_results(SOME / 2);
}

#[test]
fn a_power_cut_harms_no_report_fit_or_simulation() {
    [REPORT, FIT, SIMULATE, MESH].iter().for_each(|job| job.survives_power_cuts(SOME / 2));
}

#[test]
fn a_full_disk_harms_no_study() {
    STUDY.survives_a_full_disk(SOME);
}

#[test]
fn a_full_disk_harms_no_report_fit_or_simulation() {
    [REPORT, FIT, SIMULATE, MESH].iter().for_each(|job| job.survives_a_full_disk(SOME / 2));
}

#[test]
fn a_stop_harms_nothing() {
    STUDY.survives_stops(SOME);
    [REPORT, FIT, SIMULATE, MESH].iter().for_each(|job| job.survives_stops(SOME / 2));
}

/// Runs share a store on a file system without hard links: each case is computed once.
#[test]
fn runs_share_a_store_without_links() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(at, 20);
    call(at, &["run", "study.toml", "--out", "whole", "--jobs", "1"], 0);
    let run = || {
        let command = without_mesher(at, &["run", "study.toml", "--out", "r", "--jobs", "1"]);
        Disk::new(at).call(command, Fault::NoLinks).0
    };
    let outputs: Vec<Output> = std::thread::scope(|s| {
        let runs: Vec<_> = (0..3).map(|_| s.spawn(run)).collect();
        runs.into_iter().map(|r| r.join().expect("it does not panic")).collect()
    });
    let errors: Vec<String> = outputs.iter().map(|o| said(o, "without links", 0).1).collect();
    let mut done: Vec<&str> = errors.iter().flat_map(|e| cases(e, "done ")).collect();
    done.sort_unstable();
    assert_eq!(done.len(), 20, "{errors:?}");
    done.dedup();
    assert_eq!(done.len(), 20, "{errors:?}");
    assert_same(&at.join("whole"), &at.join("r"));
}

#[test]
#[ignore = "takes minutes"]
fn every_call_may_be_the_last() {
    REDO.keeps_results(500);
    for job in [STUDY, REPORT, FIT, SIMULATE, MESH] {
        job.survives_power_cuts(i64::MAX);
        job.survives_stops(i64::MAX);
    }
}

/// The layer does what it says: content that was not made safe is lost.
#[test]
fn the_layer_loses_what_is_not_safe() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let (at, disk) = (keep.path(), Disk::new(keep.path()));
    let paths: [PathBuf; 2] = ["a", "b"].map(|name| at.join(name));
    let shell = |line: &str| {
        let mut command = Command::new("sh");
        command.args(["-c", line]).current_dir(at);
        command
    };
    let (output, counts) =
        disk.call(shell("echo safe > a; sync a; echo lost > b; sync .; echo more >> a"), Fault::None);
    assert!(output.status.success() && counts.bytes == 15, "{output:?} {counts:?}");
    disk.lose(false);
    assert_eq!(paths.each_ref().map(|p| size(p)), [0, 0], "one of them was written to after it was safe");
    // Times of files are those of the last tick of the clock
    disk.call(shell("echo safe > a; sync a; sync .; sleep 0.1; echo lost > b"), Fault::None);
    disk.lose(true);
    assert_eq!(std::fs::read_to_string(&paths[0]).expect("there"), "safe\n");
    assert!(!paths[1].exists());
    let (output, _) = disk.call(shell("echo safe > a"), Fault::Space(4));
    assert!(!output.status.success());
    let (output, _) = disk.call(shell("echo safe > a; echo more > b"), Fault::Cut(2));
    assert_eq!(output.status.code(), None);
}
