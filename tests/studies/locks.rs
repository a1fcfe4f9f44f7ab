//! Several runs into one store: a case has one owner, a dead one loses it to one of many, and memory is promised once.

use durometer::study::run::memory::{Admission, Allowance, available};
use durometer::study::store::lock::{Claim, LockError, Locks, Owner, SILENT};
use std::path::{Path, PathBuf};
use std::sync::Barrier;
use std::time::Duration;

fn is_held(claim: Result<Result<Claim<'_>, Owner>, LockError>) -> bool {
    claim.expect("writable").is_ok()
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

fn join(folder: &Path, study: &str) -> Locks {
    Locks::join(folder, study).unwrap_or_else(|e| panic!("{e}"))
}

/// The file of a run, and what it says.
fn a_run(folder: &Path) -> (PathBuf, Owner) {
    let path = std::fs::read_dir(folder.join("runs")).expect("there").flatten().next().expect("a run").path();
    let owner = serde_json::from_slice(&std::fs::read(&path).expect("there")).expect("an owner");
    (path, owner)
}

#[test]
fn a_case_has_one_owner() {
    let keep = folder();
    let at = keep.path();
    let a = join(at, "x");
    let (_, owner) = a_run(at);
    let b = join(at, "x");
    let first = a.claim("case").expect("writable").expect("free");
    assert_eq!(b.claim("case").expect("writable").err(), Some(owner));
    assert!(!is_held(a.claim("case")) && is_held(b.claim("other")));
    drop(first);
    assert!(is_held(b.claim("case")) && !a.alone());
    drop(b);
    assert!(a.alone());
    assert_eq!(std::fs::read_dir(at.join("locks")).expect("there").count(), 0);
    drop(a);
    assert_eq!(std::fs::read_dir(at.join("runs")).expect("there").count(), 0);
}

#[test]
fn a_living_run_of_another_study_refuses() {
    let keep = folder();
    let first = join(keep.path(), "x");
    let refused = Locks::join(keep.path(), "y").err().expect("the first one lives").to_string();
    assert!(refused.contains("another study") && refused.contains("--out"), "{refused}");
    drop(first);
    join(keep.path(), "y");
}

/// Leaves the lock of a run like this one, whose sign of life is so old.
fn leave(folder: &Path, like: &Owner, machine: &str, age: Duration) -> Owner {
    let name = format!("{:016x}", age.as_millis());
    let dead = Owner { name, machine: machine.into(), pid: u32::MAX, ..like.clone() };
    let text = serde_json::to_string(&dead).expect("an owner");
    let [own, path] = [&like.name, &dead.name].map(|name| folder.join(format!("runs/{name}.json")));
    std::fs::write(&path, &text).expect("writable");
    let now = std::fs::metadata(own).and_then(|m| m.modified()).expect("there");
    let file = std::fs::File::options().append(true).open(path).expect("there");
    file.set_modified(now - age).expect("the own file");
    std::fs::write(folder.join("locks/case.json"), text).expect("writable");
    dead
}

#[test]
fn the_lock_of_a_dead_run_is_taken_over() {
    let keep = folder();
    let at = keep.path();
    let locks = join(at, "x");
    let (_, own) = a_run(at);
    // On this machine its process is looked for
    leave(at, &own, &own.machine, Duration::ZERO);
    assert_eq!(is_held(locks.claim("case")), !own.machine.is_empty());
    // On another one its sign of life counts
    leave(at, &own, "elsewhere", SILENT / 2);
    assert!(!is_held(locks.claim("case")));
    let dead = leave(at, &own, "elsewhere", SILENT);
    // The run that began to take it over has died too
    let second = Owner { name: "second".into(), ..dead.clone() };
    let guard = at.join(format!("locks/case.json.after-{}", dead.name));
    std::fs::write(&guard, serde_json::to_string(&second).expect("an owner")).expect("writable");
    assert!(is_held(locks.claim("case")));
    assert_eq!(std::fs::read_dir(at.join("locks")).expect("there").count(), 0);
    // A lock that cannot be read is one as long as it is young
    std::fs::write(at.join("locks/case.json"), "").expect("writable");
    assert!(!is_held(locks.claim("case")));
}

/// The clock went back by a day: a sign of life from then begins to age when it is seen, and one of a run that lives is renewed anyway.
#[test]
fn a_sign_of_life_from_the_future_does_not_last() {
    let keep = folder();
    let at = keep.path();
    let locks = join(at, "x");
    let (own_file, own) = a_run(at);
    let dead = leave(at, &own, "elsewhere", SILENT);
    let file = at.join(format!("runs/{}.json", dead.name));
    let changed = |path: &Path| std::fs::metadata(path).and_then(|m| m.modified()).expect("there");
    let date = |time| {
        let file = std::fs::File::options().append(true).open(&file).expect("there");
        file.set_modified(time).expect("the own file");
    };
    date(changed(&own_file) + Duration::from_secs(86_400));
    assert!(!is_held(locks.claim("case")), "it may live");
    assert!(changed(&file) <= changed(&own_file), "it ages from now on");
    date(changed(&file) - SILENT);
    assert!(is_held(locks.claim("case")));
}

/// Of many that see a dead owner at the same time one gets the case.
#[test]
fn one_of_many_takes_over() {
    let keep = folder();
    let at = keep.path();
    let first = join(at, "x");
    let (_, own) = a_run(at);
    let all: Vec<Locks> = std::iter::once(first).chain((0..7).map(|_| join(at, "x"))).collect();
    for round in 0..50 {
        leave(at, &own, "elsewhere", SILENT + Duration::from_secs(round));
        let barrier = Barrier::new(all.len());
        let attempt = |locks: &Locks| {
            barrier.wait();
            let claim = locks.claim("case").expect("writable").ok();
            // Held until all have tried
            barrier.wait();
            usize::from(claim.is_some())
        };
        let attempt = &attempt;
        let owners: usize = std::thread::scope(|scope| {
            let threads: Vec<_> = all.iter().map(|locks| scope.spawn(move || attempt(locks))).collect();
            threads.into_iter().map(|thread| thread.join().expect("no panic")).sum()
        });
        assert_eq!(owners, 1, "round {round}");
    }
}

#[test]
fn memory_is_promised_once() {
    let allowance = Allowance::new(10);
    assert_eq!(allowance.admit(11), Admission::Never);
    assert_eq!(allowance.admit(6), Admission::Now);
    assert_eq!(allowance.admit(6), Admission::Later);
    assert_eq!(allowance.admit(4), Admission::Now);
    allowance.release(6);
    assert_eq!(allowance.admit(6), Admission::Now);
}

#[cfg(target_os = "linux")]
#[test]
fn the_system_tells_what_is_available() {
    assert!(available().is_some_and(|bytes| bytes > 1 << 24));
}
