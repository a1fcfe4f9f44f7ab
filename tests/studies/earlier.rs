//! An earlier result of a case stays until there is a better one, and what was drawn of it does not stay longer.

use crate::common::program::call;
use crate::common::stores::{contents, write_study};
use durometer::study::expand::Study;
use durometer::study::report;
use durometer::study::run::growing::run_study;
use durometer::study::run::runner::{Options, RunError, Watch};
use durometer::study::store::record::CaseRecord;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

fn edit(path: &Path, old: &str, new: &str) {
    let text = std::fs::read_to_string(path).expect("a file");
    assert!(text.contains(old), "{text}");
    std::fs::write(path, text.replace(old, new)).expect("room");
}

/// A case without memory leaves its earlier result, of the same inputs or of others, and the run says that it is not complete.
#[test]
fn a_case_that_breaks_leaves_its_earlier_result() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(at, 2);
    call(at, &["run", "study.toml", "--out", "r"], 0);
    let before = contents(&at.join("r"));
    let broken = ["run", "study.toml", "--out", "r", "--memory", "1 MB"];
    let (said, errors) = call(at, &[&broken[..], &["--redo"]].concat(), 3);
    assert!(said.contains("report: "), "it is made of the earlier results: {said}");
    for k in 0..2 {
        let of_case =
            |line: &&str| line.starts_with(&format!("not complete: sweep-press-E{}kPa: OutOfMemory", 100 + k));
        let line = errors.lines().find(of_case).unwrap_or_else(|| panic!("{errors}"));
        assert!(line.contains("the earlier result of the case stays"), "{line}");
    }
    assert_eq!(contents(&at.join("r")), before);
    edit(&at.join("scene.toml"), "nu = 0.3", "nu = 0.31");
    let (_, errors) = call(at, &broken, 3);
    assert!(errors.contains("not complete: sweep-press-E100kPa: OutOfMemory"), "{errors}");
    assert_eq!(contents(&at.join("r")), before);
    edit(&at.join("scene.toml"), "nu = 0.31", "nu = 0.3");
    let (_, errors) = call(at, &["run", "study.toml", "--out", "r"], 0);
    assert_eq!(errors.lines().filter(|line| line.starts_with("kept ")).count(), 2, "{errors}");
}

/// Edits the table of the load when the first case is finished, and runs the study as it is then into the same folder.
struct Second<'a> {
    at: &'a Path,
    end: Mutex<Option<Result<Vec<CaseRecord>, RunError>>>,
}

impl Watch for Second<'_> {
    fn finished(&self, _: &CaseRecord, _: bool) {
        let mut end = self.end.lock().expect("no panic");
        if end.is_none() {
            std::fs::write(self.at.join("load.csv"), "t,w\n0,0\n1,-1.5\n").expect("room");
            *end = Some(into_r(self.at, &(), false));
        }
    }
}

fn into_r(at: &Path, watch: &dyn Watch, redo: bool) -> Result<Vec<CaseRecord>, RunError> {
    let study = Study::read(&at.join("study.toml"), &[]).unwrap_or_else(|e| panic!("{e}"));
    let stop = AtomicBool::new(false);
    run_study(&study, &at.join("r"), &Options { jobs: 1, redo, ..Options::new(&stop) }, watch)
}

/// A run of files that were edited since does not begin while another one goes on, which keeps the results of before for what it cannot compute any more.
#[test]
fn runs_before_and_after_an_edit_are_apart() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(at, 2);
    let ramp = "{ kind = \"ramp\", from = \"0 mm\", to = \"-1 mm\", start = \"0 s\", end = \"1 s\" }";
    edit(&at.join("scene.toml"), ramp, "{ kind = \"table\", file = \"load.csv\", unit = \"mm\" }");
    std::fs::write(at.join("load.csv"), "t,w\n0,0\n1,-1\n").expect("room");
    let whole = |end: Result<Vec<CaseRecord>, RunError>| end.unwrap_or_else(|e| panic!("{e}"));
    whole(into_r(at, &(), false));
    let before = contents(&at.join("r"));
    let watch = Second { at, end: Mutex::new(None) };
    let records = whole(into_r(at, &watch, true));
    let refused = watch.end.into_inner().expect("no panic").expect("a case was finished").expect_err("other files");
    assert!(refused.to_string().contains("with other changes or files"), "{refused}");
    assert!(records[0].converged() && records[1].status == "InputsChanged", "{records:?}");
    assert_eq!(contents(&at.join("r")), before);
    // The exit code follows what the report is made of
    std::fs::write(at.join("load.csv"), "t,w\n0,0\n1,-1\n").expect("room");
    let kept = whole(into_r(at, &(), false));
    let summary = |()| report::write_report(&at.join("r")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(summary(()).incomplete(&kept), [] as [String; 0]);
    assert_eq!(summary(()).failed(&records).len(), 1, "one broke");
    std::fs::write(at.join("load.csv"), "t,w\n0,0\n1,-1.5\n").expect("room");
    whole(into_r(at, &(), false));
    assert_eq!(summary(()).incomplete(&kept).len(), 2);
}

/// Fields for ParaView are those of the result next to them, or there are none.
#[test]
fn fields_belong_to_their_result() {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path();
    write_study(at, 2);
    let vtu = |out: &str, code: &str| {
        let (_, errors) = call(at, &["run", "study.toml", "--out", out, "--vtu"], 0);
        assert!(errors.lines().any(|line| line.starts_with(code)), "{code}: {errors}");
    };
    let fields = |out: &str| {
        let folder = at.join(out).join("cases/sweep-press-E100kPa");
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
        let files = files.filter(|path| path.extension().is_some_and(|end| end == "vtu" || end == "pvd"));
        files
            .map(|path| (path.file_name().map(ToOwned::to_owned), std::fs::read(&path).expect("readable")))
            .collect::<std::collections::BTreeMap<_, _>>()
    };
    vtu("r", "done ");
    vtu("r", "kept ");
    assert!(fields("r").len() > 3);
    std::fs::write(at.join("r/cases/sweep-press-E100kPa/notes.txt"), "mine").expect("room");
    edit(&at.join("scene.toml"), "nu = 0.3", "nu = 0.4");
    edit(&at.join("scene.toml"), "dt = \"0.5 s\"", "dt = \"1 s\"");
    call(at, &["run", "study.toml", "--out", "r"], 0);
    assert!(fields("r").is_empty(), "those of the earlier result");
    vtu("r", "done ");
    vtu("fresh", "done ");
    assert!(fields("r") == fields("fresh"));
    call(at, &["run", "study.toml", "--out", "r", "--redo"], 0);
    assert!(fields("r") == fields("fresh"), "they are still those of the result");
    assert!(at.join("r/cases/sweep-press-E100kPa/notes.txt").is_file());
}
