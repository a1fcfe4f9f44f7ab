//! Upkeep of a folder of results: damage is named, what nothing uses is removed, and results move between machines unchanged.

use crate::common::program::{call, said, without_mesher};
use crate::common::stores;
use crate::common::stores::{assert_same, write_study};
use flate2::{Compression, write::GzEncoder};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use tar::{Builder, EntryType, Header};

/// A study of four cases with its results in `r`.
fn results() -> (tempfile::TempDir, PathBuf) {
    let keep = tempfile::tempdir().expect("a temporary folder");
    let at = keep.path().to_path_buf();
    write_study(&at, 4);
    call(&at, &["run", "study.toml", "--out", "r"], 0);
    (keep, at)
}

fn case(k: usize, end: &str) -> String {
    format!("sweep-press-E{}kPa.{end}", 100 + k)
}

fn write(path: impl AsRef<Path>, bytes: impl AsRef<[u8]>) {
    std::fs::write(path, bytes).expect("room");
}

#[test]
fn damage_is_named() {
    let (_keep, at) = results();
    let (sound, _) = call(&at, &["store", "verify", "r"], 0);
    assert!(sound.contains("4 cases are sound, 0 have no result"), "{sound}");
    let cases = at.join("r/cases");
    let csv = std::fs::read(cases.join(case(0, "csv"))).expect("stored");
    let mut flipped = csv.clone();
    *flipped.last_mut().expect("not empty") ^= 1;
    write(cases.join(case(0, "csv")), flipped);
    write(cases.join(case(1, "json")), "{");
    std::fs::remove_file(cases.join(case(2, "skin.json.gz"))).expect("stored");
    let (found, errors) = call(&at, &["store", "verify", "r", "--json"], 3);
    let found: Value = serde_json::from_str(&found).expect("JSON");
    let files: Vec<&str> =
        found["damaged"].as_array().expect("a list").iter().filter_map(|d| d["file"].as_str()).collect();
    let named = [case(0, "csv"), case(1, "json"), case(2, "skin.json.gz")].map(|name| format!("cases/{name}"));
    assert_eq!(files, named);
    assert!(named.iter().all(|name| errors.contains(name)), "{errors}");
    assert_eq!(found["sound"], 1);
    call(&at, &["run", "study.toml", "--out", "r"], 0);
    call(&at, &["store", "verify", "r"], 0);
    for (folder, words) in [(".", "there is no such file"), ("none", "there is no such file")] {
        let (_, errors) = call(&at, &["store", "verify", folder], 2);
        assert!(errors.contains(words), "{errors}");
    }
}

/// A quantity that no stored result has is refused as one that no scene records, and the results stay.
#[test]
fn a_misspelt_quantity_is_refused_with_kept_results() {
    let (_keep, at) = results();
    let study = std::fs::read_to_string(at.join("study.toml")).expect("the study");
    write(at.join("study.toml"), study.replace("zmax_reaction_z_N", "zmax_reaction_N"));
    let (_, errors) = call(&at, &["run", "study.toml", "--out", "r"], 2);
    assert!(errors.contains("no \"zmax_reaction_N\"; did you mean `zmax_reaction_"), "{errors}");
    call(&at, &["store", "verify", "r"], 0);
}

/// A report names damage on its standard error, and a case whose numbers are not those that were stored does not count.
#[test]
fn a_report_counts_no_damaged_result() {
    let (_keep, at) = results();
    let cases = at.join("r/cases");
    std::fs::remove_file(cases.join(case(0, "skin.json.gz"))).expect("stored");
    let (_, errors) = call(&at, &["report", "r"], 0);
    assert!(!errors.contains("damaged"), "a surface is only drawn: {errors}");
    let change = |k: usize| {
        let path = cases.join(case(k, "csv"));
        let mut bytes = std::fs::read(&path).expect("stored");
        let digit = bytes.iter().rposition(u8::is_ascii_digit).expect("a number");
        bytes[digit] = if bytes[digit] == b'1' { b'2' } else { b'1' };
        write(path, bytes);
    };
    change(1);
    let (said, errors) = call(&at, &["report", "r", "--json"], 3);
    assert!(errors.contains(&format!("damaged: cases/{}: its contents are not", case(1, "csv"))), "{errors}");
    let summary: Value = serde_json::from_str(&said).expect("JSON");
    let ids: Vec<&str> = summary["cases"].as_array().expect("cases").iter().filter_map(|c| c["id"].as_str()).collect();
    assert_eq!(ids, [0, 2, 3].map(|k| format!("sweep-press-E{}kPa", 100 + k)));
    assert!(summary["warnings"].to_string().contains("The case does not count"), "{summary}");
    // So does a run of other cases; one of this case mends it
    let (_, errors) = call(&at, &["run", "study.toml", "--out", "r", "--only", "E102kPa"], 3);
    assert!(errors.contains("damaged: "), "{errors}");
    let warned = |line: &str| line.starts_with("warning: ") && line.contains("The case does not count");
    assert!(errors.lines().any(warned), "{errors}");
    call(&at, &["run", "study.toml", "--out", "r", "--only", "E101kPa"], 0);
    call(&at, &["report", "r"], 0);
    // Without its series a case has no first value, from which its peaks count
    std::fs::remove_file(cases.join(case(2, "csv"))).expect("stored");
    let (said, errors) = call(&at, &["report", "r", "--json"], 3);
    let named = |line: &str| line.contains(&case(2, "csv")) && line.contains("The case does not count");
    assert!(errors.lines().any(named), "{errors}");
    let summary: Value = serde_json::from_str(&said).expect("JSON");
    let ids: Vec<&str> = summary["cases"].as_array().expect("cases").iter().filter_map(|c| c["id"].as_str()).collect();
    assert_eq!(ids, [0, 1, 3].map(|k| format!("sweep-press-E{}kPa", 100 + k)));
    call(&at, &["run", "study.toml", "--out", "r", "--only", "E102kPa"], 0);
    (0..4).for_each(change);
    let (_, errors) = call(&at, &["report", "r"], 2);
    assert!(errors.contains("no case has a sound result"), "{errors}");
}

/// Results of other inputs than the study has now are in no archive.
#[test]
fn outdated_results_are_not_exported() {
    let (_keep, at) = results();
    let scene = std::fs::read_to_string(at.join("scene.toml")).expect("the scene");
    write(at.join("scene.toml"), scene.replace("nu = 0.3", "nu = 0.31"));
    let (_, errors) = call(&at, &["run", "study.toml", "--out", "r", "--only", "E100kPa"], 0);
    assert!(errors.contains("note: 3 stored results are of other inputs"), "{errors}");
    let (said, errors) = call(&at, &["store", "export", "r", "r.tar.gz"], 0);
    assert!(said.contains("1 cases") && errors.contains("left out: "), "{said} {errors}");
    let (listed, _) = call(&at, &["cases", "study.toml", "--out", "r"], 0);
    assert_eq!(listed.matches(" outdated ").count(), 3, "{listed}");
    write(at.join("r/outdated/no-such-case"), "0");
    let (said, _) = call(&at, &["store", "gc", "r"], 0);
    assert!(said.contains("outdated/no-such-case") && !at.join("r/outdated/no-such-case").exists(), "{said}");
    assert!(at.join("r/outdated").join("sweep-press-E101kPa").is_file());
}

#[test]
fn what_nothing_uses_is_removed_and_the_rest_stays() {
    let (_keep, at) = results();
    let cases = at.join("r/cases");
    call(&at, &["run", "study.toml", "--out", "s"], 0);
    // A result of a case that the study had before, with fields
    let study = std::fs::read_to_string(at.join("study.toml")).expect("the study");
    write(at.join("study.toml"), study.replace("\"100 kPa\"", "\"90 kPa\""));
    call(&at, &["run", "study.toml", "--out", "old", "--only", "E90kPa", "--vtu"], 0);
    write(at.join("study.toml"), study);
    let old = "sweep-press-E90kPa";
    for end in ["json", "csv", "skin.json.gz"] {
        let name = format!("{old}.{end}");
        std::fs::copy(at.join("old/cases").join(&name), cases.join(name)).expect("room");
    }
    // Files of the user: with names like those of cases, and in the folder of a case
    let mine = ["measured-2024.csv", "analysis.json", "notes.txt"];
    for name in mine {
        write(cases.join(name), "{}");
    }
    write(cases.join(".x.part"), "half");
    std::fs::create_dir_all(cases.join("mine")).expect("room");
    write(cases.join("mine/mine.pvd"), "<VTKFile/>");
    std::fs::create_dir_all(at.join("r/next").join(old)).expect("room");
    write(at.join("r/.y.part"), "half");
    let hour = std::time::SystemTime::now() - std::time::Duration::from_secs(3600);
    for name in ["runs/dead.json", "runs/alive.json", "locks/a.json", "locks/b.json", "locks/c.json"] {
        let owner = if name.contains('b') { "alive" } else { "dead" };
        write(
            at.join("r").join(name),
            json!({ "name": owner, "host": "h", "machine": "", "pid": 1, "pid_started": 0,
            "started_unix_s": 0, "study_sha256": "" })
            .to_string(),
        );
        let file = std::fs::File::options().write(true).open(at.join("r").join(name)).expect("there");
        file.set_modified(if name.contains("alive") { std::time::SystemTime::now() } else { hour }).expect("own file");
    }
    std::fs::rename(at.join("old/cases").join(old), cases.join(old)).expect("own folder");
    let left = || std::fs::read_dir(&cases).expect("there").count();
    let all = left();
    let (young, _) = call(&at, &["store", "gc", "r", "--dry-run"], 0);
    assert!(young.contains("E90kPa.json") && !young.contains(".part"), "a file of a run that goes on stays: {young}");
    assert_eq!(left(), all, "a dry run removes nothing");
    let (done, _) = call(&at, &["store", "gc", "r", "--older-than", "0 s"], 0);
    let gone = [
        "E90kPa.json",
        "E90kPa.csv",
        "E90kPa.skin.json.gz",
        "cases/sweep-press-E90kPa ",
        "next/sweep-press-E90kPa",
        "cases/.x.part",
        ".y.part",
        "runs/dead",
        "locks/a",
        "locks/c",
    ];
    for name in gone {
        assert!(done.contains(name), "{name}: {done}");
    }
    assert!(
        at.join("r/locks/b.json").is_file() && at.join("r/runs/alive.json").is_file(),
        "a run that lives keeps its lock"
    );
    for name in mine {
        assert!(done.contains(&format!("unknown, stays: cases/{name}")), "{done}");
        std::fs::remove_file(cases.join(name)).expect("it stayed");
    }
    assert!(done.contains("unknown, stays: cases/mine") && cases.join("mine/mine.pvd").is_file(), "{done}");
    assert_same(&at.join("s"), &at.join("r"));
    assert!(!at.join("r/.y.part").exists() && !cases.join(old).exists());
    let (_, errors) = call(&at, &["store", "gc", "r", "--older-than=-1 s"], 2);
    assert!(errors.contains("--older-than"), "{errors}");
}

/// Two machines with one half each: archives that are the same bytes each time, and a merged folder that is the whole study.
#[test]
fn halves_of_two_machines_are_merged() {
    let (_keep, at) = results();
    for k in ["1", "2"] {
        call(&at, &["run", "study.toml", "--out", k, "--partition", &format!("{k}/2")], 0);
        call(&at, &["store", "export", k, &format!("{k}.tar.gz")], 0);
        call(&at, &["store", "export", k, &format!("{k}-again.tar.gz")], 0);
        let bytes = |name: String| std::fs::read(at.join(name)).expect("written");
        assert!(bytes(format!("{k}.tar.gz")) == bytes(format!("{k}-again.tar.gz")));
        call(&at, &["store", "import", &format!("{k}.tar.gz"), "merged"], 0);
    }
    assert_same(&at.join("r"), &at.join("merged"));
    let (again, _) = call(&at, &["store", "import", "1.tar.gz", "merged", "--json"], 0);
    let again: Value = serde_json::from_str(&again).expect("JSON");
    assert!(
        again["added"] == json!([]) && again["conflicts"] == json!([]) && again["kept"].as_u64() > Some(0),
        "{again}"
    );
    call(&at, &["report", "merged"], 0);
    let kept = call(&at, &["run", "study.toml", "--out", "merged"], 0).1;
    assert_eq!(kept.lines().filter(|l| l.starts_with("kept")).count(), 4, "{kept}");
}

/// The members that were added to a study go with its results: a run into the other folder keeps all of them.
#[test]
fn added_members_go_with_their_results() {
    let (_keep, at) = results();
    let added = "[family.sweep]\nE110kPa = { \"laws.rubber.E\" = \"110 kPa\" }\n";
    std::fs::create_dir(at.join("more")).expect("room");
    write(at.join("more/extension.toml"), added);
    let run = |out: &str| call(&at, &["run", "study.toml", "--out", out, "--partition", "1/1"], 0).1;
    run("more");
    call(&at, &["store", "export", "more", "more.tar.gz"], 0);
    let import =
        |more: &[&str], code| call(&at, &[&["store", "import", "more.tar.gz", "moved"], more].concat(), code).1;
    let moved = || std::fs::read_to_string(at.join("moved/extension.toml")).expect("it was moved");
    import(&[], 0);
    assert_eq!(moved(), added);
    // Other additions are a conflict, and give way where that is asked for
    import(&[], 0);
    write(at.join("moved/extension.toml"), "# none\n");
    let errors = import(&[], 3);
    assert!(errors.contains("conflict: extension.toml: the archive has other cases"), "{errors}");
    assert_eq!(moved(), "# none\n");
    import(&["--replace"], 0);
    assert_eq!(moved(), added);
    let kept = run("moved");
    assert_eq!(kept.lines().filter(|l| l.starts_with("kept")).count(), 5, "{kept}");
    assert_same(&at.join("more"), &at.join("moved"));
    // One that cannot be read is no file to be replaced
    let own = at.join("moved/extension.toml");
    std::fs::remove_file(&own).expect("it was moved");
    std::fs::create_dir(&own).expect("room");
    let errors = import(&[], 2);
    assert!(errors.contains("extension.toml: it cannot be read"), "{errors}");
    std::fs::remove_dir(&own).expect("it is empty");
    // The study of an archive without additions has none in the folder either
    write(&own, added);
    call(&at, &["store", "export", "r", "r.tar.gz"], 0);
    let (said, errors) = call(&at, &["store", "import", "r.tar.gz", "moved", "--replace", "--json"], 0);
    assert!(errors.contains("removed: extension.toml") && !own.exists(), "{errors}");
    let said: Value = serde_json::from_str(&said).expect("JSON");
    assert_eq!((&said["kept"], &said["removed"]), (&json!(4), &json!(["extension.toml"])), "{said}");
    let kept = run("moved");
    assert_eq!(kept.lines().filter(|l| l.starts_with("kept")).count(), 4, "{kept}");
    assert!(!kept.contains("E110kPa"), "{kept}");
}

#[test]
fn results_that_differ_are_conflicts() {
    let (_keep, at) = results();
    let set = ["--set", "laws.rubber.nu=0.31"];
    call(&at, &[&["run", "study.toml", "--out", "other"], &set[..]].concat(), 0);
    call(&at, &["store", "export", "other", "other.tar.gz"], 0);
    let before = stores::contents(&at.join("r"));
    let (_, errors) = call(&at, &["store", "import", "other.tar.gz", "r"], 3);
    for k in 0..4 {
        let id = case(k, "").trim_end_matches('.').to_string();
        assert!(errors.contains(&format!("conflict: {id}: the archive has a result of other inputs")), "{errors}");
    }
    assert_eq!(before, stores::contents(&at.join("r")), "nothing was changed");
    // A damaged result is no result: that of the archive takes its place
    call(&at, &["store", "export", "r", "r.tar.gz"], 0);
    write(at.join("r/cases").join(case(1, "csv")), "t_s\n");
    let (said, errors) = call(&at, &["store", "export", "r", "part.tar.gz"], 3);
    assert!(said.contains("3 cases") && errors.contains(&case(1, "csv")), "{said}{errors}");
    let (said, _) = call(&at, &["store", "import", "r.tar.gz", "r"], 0);
    assert!(said.contains("1 cases added, 3 kept"), "{said}");
    assert_eq!(before, stores::contents(&at.join("r")));
    call(&at, &["store", "import", "other.tar.gz", "r", "--replace"], 0);
    assert_same(&at.join("other"), &at.join("r"));
    std::fs::create_dir(at.join("b")).expect("room");
    write_study(&at.join("b"), 4);
    call(&at, &["run", "b/study.toml", "--out", "b/r"], 0);
    let (_, errors) = call(&at, &["store", "import", "r.tar.gz", "b/r"], 2);
    assert!(errors.contains("it holds results of the study"), "{errors}");
}

/// Results that an archive brings back with their study count again.
#[test]
fn restored_results_count() {
    let (_keep, at) = results();
    call(&at, &["store", "export", "r", "r.tar.gz"], 0);
    let before = stores::contents(&at.join("r"));
    let scene = std::fs::read_to_string(at.join("scene.toml")).expect("the scene");
    write(at.join("scene.toml"), scene.replace("nu = 0.3", "nu = 0.31"));
    // One case is computed anew, and the others are noted as those of other inputs
    for only in ["E100kPa", ""] {
        call(&at, &["run", "study.toml", "--out", "r", "--only", only], 0);
        call(&at, &["store", "import", "r.tar.gz", "r", "--replace"], 0);
        assert_eq!(stores::contents(&at.join("r")), before);
        let (said, _) = call(&at, &["report", "r", "--json"], 0);
        let summary: Value = serde_json::from_str(&said).expect("JSON");
        assert_eq!(summary["cases"].as_array().map(Vec::len), Some(4), "{summary}");
        let (said, _) = call(&at, &["store", "export", "r", "again.tar.gz"], 0);
        assert!(said.contains("4 cases"), "{said}");
    }
}

/// Halves of other inputs are not merged, whichever comes first; those of the archive take the place of the others where that is asked for.
#[test]
fn halves_of_other_inputs_are_not_merged() {
    let (_keep, at) = results();
    for (k, set) in [("1", "laws.rubber.nu=0.3"), ("2", "laws.rubber.nu=0.31")] {
        let part = format!("{k}/2");
        call(&at, &["run", "study.toml", "--out", k, "--set", set, "--partition", &part], 0);
        let (_, errors) = call(&at, &["store", "export", k, &format!("{k}.tar.gz")], 0);
        assert!(errors.contains("cases of the study have no result"), "{errors}");
    }
    let counted = || {
        let (said, _) = call(&at, &["report", "merged", "--json"], 0);
        let summary: Value = serde_json::from_str(&said).expect("JSON");
        ["cases", "outdated"].map(|key| summary[key].as_array().map_or(0, Vec::len))
    };
    call(&at, &["store", "import", "1.tar.gz", "merged"], 0);
    let before = counted();
    let (said, errors) = call(&at, &["store", "import", "2.tar.gz", "merged"], 3);
    assert!(said.contains("0 cases added") && errors.contains("the archive has a result of other inputs"), "{errors}");
    assert_eq!(counted(), before);
    call(&at, &["store", "import", "2.tar.gz", "merged", "--replace"], 0);
    assert_eq!(counted(), [4 - before[0], before[0]]);
}

/// A comparison and a bundle take no report that is older than the results.
#[test]
fn a_report_of_other_results_is_not_compared() {
    let (_keep, at) = results();
    call(&at, &["run", "study.toml", "--out", "s"], 0);
    call(&at, &["compare", "r", "s"], 0);
    let scene = std::fs::read_to_string(at.join("scene.toml")).expect("the scene");
    write(at.join("scene.toml"), scene.replace("nu = 0.3", "nu = 0.4"));
    call(&at, &["run", "study.toml", "--out", "s", "--partition", "1/1"], 0);
    for arguments in
        [&["compare", "r", "s"][..], &["bundle", "write", "study.toml", "b", "--results", "s", "--license", "CC0-1.0"]]
    {
        let (_, errors) = call(&at, arguments, 2);
        assert!(errors.contains("durometer report s"), "{errors}");
    }
    call(&at, &["report", "s"], 0);
    call(&at, &["compare", "r", "s"], 3);
}

/// Whatever is in the place of a record or a surface, the report is made of the other cases.
#[test]
fn a_report_is_made_without_an_unreadable_record() {
    let (_keep, at) = results();
    let record = at.join("r/cases").join(case(1, "json"));
    let sound = std::fs::read(&record).expect("stored");
    for bytes in [&sound[..sound.len() / 2], b"", b"{}", b"\xff\x00"] {
        write(&record, bytes);
        let (said, errors) = call(&at, &["report", "r", "--json"], 3);
        let summary: Value = serde_json::from_str(&said).expect("JSON");
        assert_eq!(summary["cases"].as_array().map(Vec::len), Some(3));
        assert!(errors.contains(&case(1, "json")) && errors.contains("The case does not count"), "{errors}");
    }
    std::fs::remove_file(&record).expect("there");
    std::fs::create_dir(&record).expect("room");
    call(&at, &["report", "r"], 3);
    std::fs::remove_dir(&record).expect("there");
    write(&record, sound);
    let skin = at.join("r/cases").join(case(2, "skin.json.gz"));
    std::fs::remove_file(&skin).expect("stored");
    std::fs::create_dir(&skin).expect("room");
    let (said, errors) = call(&at, &["report", "r", "--json"], 3);
    let summary: Value = serde_json::from_str(&said).expect("JSON");
    assert!(summary["cases"].as_array().map(Vec::len) == Some(4) && errors.contains("surface"), "{errors}");
}

/// Results that are links to files elsewhere are results.
#[cfg(unix)]
#[test]
fn links_to_results_are_results() {
    let (_keep, at) = results();
    std::fs::create_dir_all(at.join("l/cases")).expect("room");
    write(at.join("l/study.json"), std::fs::read(at.join("r/study.json")).expect("stored"));
    let (said, errors) = call(&at, &["store", "export", "l", "none.tar.gz"], 3);
    assert!(said.contains("0 cases") && errors.contains("4 cases of the study have no result"), "{said}{errors}");
    for entry in std::fs::read_dir(at.join("r/cases")).expect("there").flatten() {
        std::os::unix::fs::symlink(entry.path(), at.join("l/cases").join(entry.file_name())).expect("a link");
    }
    let (said, _) = call(&at, &["store", "verify", "l"], 0);
    assert!(said.contains("4 cases are sound"), "{said}");
    call(&at, &["store", "export", "l", "l.tar.gz"], 0);
    call(&at, &["store", "export", "r", "r.tar.gz"], 0);
    assert!(std::fs::read(at.join("l.tar.gz")).ok() == std::fs::read(at.join("r.tar.gz")).ok());
}

/// An entry of a made archive: name, type, contents.
type Made<'a> = (&'a str, EntryType, &'a [u8]);

fn archive(path: &Path, entries: &[Made]) {
    let mut archive = Builder::new(GzEncoder::new(Vec::new(), Compression::fast()));
    for (name, kind, bytes) in entries {
        let mut header = Header::new_gnu();
        // The checks of the writer are those of an honest one
        header.as_old_mut().name[..name.len()].copy_from_slice(name.as_bytes());
        header.set_entry_type(*kind);
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        if *kind == EntryType::Symlink {
            header.set_link_name("/etc/passwd").expect("short");
        }
        header.set_cksum();
        archive.append(&header, *bytes).expect("memory");
    }
    write(path, archive.into_inner().expect("memory").finish().expect("memory"));
}

fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// The list of an archive.
fn c(bytes: &[u8]) -> Made<'_> {
    ("contents.json", EntryType::Regular, bytes)
}

/// Archives that were made to do harm: nothing is written, inside or outside of the folder, and each is refused with its reason.
#[test]
fn a_hostile_archive_is_refused() {
    let (_keep, at) = results();
    let study = std::fs::read(at.join("r/study.json")).expect("stored");
    let (own, x) = (digest(&study), digest(b"x"));
    let first = json!({ "case": null, "bytes": study.len(), "sha256": own });
    let list = |files: &[Value]| {
        let files: Vec<&Value> = std::iter::once(&first).chain(files).collect();
        json!({ "format": 1, "study": "s", "files": files }).to_string().into_bytes()
    };
    let file = |id: &str, end: &str| json!({ "case": [id, end], "bytes": 1, "sha256": x });
    let regular = EntryType::Regular;
    let s: Made = ("study.json", regular, &study);
    let traversal = list(&[file("../../evil", "csv")]);
    let absolute = list(&[file("/tmp/evil", "csv")]);
    let strange = list(&[file("a", "sh")]);
    let twice = list(&[file("a", "csv"), file("a", "csv")]);
    let torn = list(&[file("a", "csv"), file("b", "csv"), file("a", "json")]);
    let one = list(&[file("a", "csv")]);
    let added = |name: &str| json!({ "case": null, "added": name, "bytes": 1, "sha256": x });
    let outside = list(&[added("../../evil.csv")]);
    let repeated = list(&[added("extension.toml"), added("extension.toml")]);
    let none = list(&[]);
    let large = json!({ "format": 1, "study": "s", "files": [{ "case": null, "bytes": 1u64 << 50, "sha256": "" }] });
    let (large, newer) =
        (large.to_string().into_bytes(), json!({ "format": 2, "study": "s", "files": [] }).to_string());
    let cases: [(&str, Vec<Made>); 16] = [
        ("is no file of a case", vec![c(&traversal), s, ("cases/../../evil.csv", regular, b"x")]),
        ("is no file of a case", vec![c(&absolute), s, ("/tmp/evil.csv", regular, b"x")]),
        ("is no file of a case", vec![c(&strange), s]),
        ("is no file of a case", vec![c(&outside), s, ("../../evil.csv", regular, b"x")]),
        ("is no file of a case", vec![c(&repeated), s]),
        ("is listed twice", vec![c(&twice), s]),
        ("are not together", vec![c(&torn), s]),
        ("is not a regular file", vec![c(&one), s, ("cases/a.csv", EntryType::Symlink, b"")]),
        ("is not a regular file", vec![c(&one), s, ("cases/a.csv", EntryType::Link, b"")]),
        ("are not those of the list", vec![c(&one), s, ("../evil", regular, b"x")]),
        ("are not those of the list", vec![c(&one), s, ("cases/a.csv", regular, b"y")]),
        ("has more than", vec![c(&one), s, ("cases/a.csv", regular, b"xxxxxxx")]),
        ("it ends before its list does", vec![c(&one), s]),
        ("entries that are not in its list", vec![c(&none), s, ("cases/a.csv", regular, b"x")]),
        ("more than 65536 MiB", vec![c(&large)]),
        ("it has form 2", vec![c(newer.as_bytes())]),
    ];
    for (words, entries) in cases {
        archive(&at.join("bad.tar.gz"), &entries);
        let (_, errors) = call(&at, &["store", "import", "bad.tar.gz", "new/results"], 2);
        assert!(errors.contains(words), "{words}: {errors}");
        assert!(!at.join("new").exists() && !Path::new("/tmp/evil.csv").exists() && !at.join("evil.csv").exists());
    }
    call(&at, &["store", "export", "r", "r.tar.gz"], 0);
    let sound = std::fs::read(at.join("r.tar.gz")).expect("written");
    // Every 97th byte, of 20 to 40 kB, and every cut at one of them
    for k in (0..sound.len()).step_by(sound.len() / 97) {
        let mut flipped = sound.clone();
        flipped[k] ^= 0x10;
        for bytes in [&flipped[..], &sound[..k]] {
            write(at.join("bad.tar.gz"), bytes);
            let output = without_mesher(&at, &["store", "import", "bad.tar.gz", "new"]).output().expect("it starts");
            if output.status.code() == Some(0) {
                // A byte of the head of the stream that nothing reads
                assert_same(&at.join("r"), &at.join("new"));
                std::fs::remove_dir_all(at.join("new")).expect("made");
                continue;
            }
            said(&output, "a damaged archive", 2);
            assert!(!at.join("new").exists(), "byte {k}");
        }
    }
}
