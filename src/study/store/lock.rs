//! Coordinates several runs into one store: which run computes which case.
//!
//! Every run has a file `runs/<name>.json` with its host, process and study, which it rewrites every ten seconds. A case that is being computed has a
//! file `locks/<id>.json` with the run that computes it.
//!
//! The scheme relies on three properties, which network file systems must have too: of several processes only one succeeds in creating a hard link (or,
//! where there are no links, a file that must be new); a rename replaces a file as a whole; and modification times come from one clock, that of the
//! file system. It does not rely on advisory locks or on synchronised clocks.
//!
//! A run on this machine is alive if its process is; a run on another machine is alive as long as its file is no older than [`SILENT`] compared with
//! the own one. If a sign of life is ahead by more than that, because the clock of the file system was set back, whoever sees it resets its time: a
//! live run soon gives the next sign, and a dead one is silent from then on. The lock of a dead run is taken over by the run that first obtains the
//! lock `<id>.json.after-<name>`, so that two runs do not take it over from each other. A run on another machine that was suspended for longer loses
//! its cases; they are then computed twice, with equal results.

use crate::storage::{self, TEXT_LIMIT, sha256, unix_time};
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime};

/// Interval between two signs of life of a run.
const BEAT: Duration = Duration::from_secs(10);
/// Age of the last sign of life at which a run on another machine counts as dead; networks may report modification times with a delay of a minute.
pub const SILENT: Duration = Duration::from_secs(120);
/// Largest number of attempts to be the only run, if runs of different studies start at the same moment.
const TRIES: u32 = 5;

/// A run as seen by others.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq, Default)]
pub struct Owner {
    /// Name that no other run has
    pub name: String,
    pub host: String,
    /// Boot id of the system and process name space; empty if the system does not report them
    pub machine: String,
    pub pid: u32,
    /// Start of the process in ticks of its system; it distinguishes processes that have the same number one after the other
    pub pid_started: u64,
    pub started_unix_s: u64,
    /// Digest of the study with all its changes and the contents of its files
    pub study_sha256: String,
}

/// Why a run cannot work on a store.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    #[error("{}: cannot be written: {reason}; choose another folder with --out, or make room", path.display())]
    Io { path: PathBuf, reason: String },
    #[error(
        "{}: process {} on {} computes another study into it, or the same with other changes or files; wait for its end, or choose \
         another folder with --out", dir.display(), owner.pid, owner.host
    )]
    OtherStudy { dir: PathBuf, owner: Box<Owner> },
}

/// The registration of this run in a store, which ends for other runs when it is dropped.
pub struct Locks {
    dir: PathBuf,
    own: Owner,
    heart: Option<(Sender<()>, JoinHandle<()>)>,
}

/// The exclusive right to compute a case, until it is dropped.
pub struct Claim<'a> {
    locks: &'a Locks,
    path: PathBuf,
}

impl Locks {
    /// Joins the runs of a store. All live runs must belong to the same study.
    pub fn join(dir: &Path, study_sha256: &str) -> Result<Self, LockError> {
        for folder in ["runs", "locks"].map(|name| dir.join(name)) {
            std::fs::create_dir_all(&folder).map_err(|e| io(&folder, &e))?;
        }
        let mut locks = Self { dir: dir.into(), own: Owner::this(study_sha256), heart: None };
        for attempt in 1.. {
            beat(dir, &locks.own)?;
            let other = locks.others().into_iter().find(|run| run.study_sha256 != study_sha256 && locks.alive(run));
            let Some(other) = other else { break };
            std::fs::remove_file(run_file(dir, &locks.own.name)).ok();
            if attempt == TRIES {
                return Err(LockError::OtherStudy { dir: dir.into(), owner: Box::new(other) });
            }
            // Two runs that started together wait for different times
            let digits = u64::from_str_radix(&locks.own.name[..4], 16).unwrap_or(1);
            std::thread::sleep(Duration::from_millis(20 + digits % 180));
        }
        let (stop, stopped) = channel::<()>();
        let (folder, own) = (locks.dir.clone(), locks.own.clone());
        let heart = std::thread::spawn(move || {
            // On a full disk a sign of life is lost; the next one may succeed
            while stopped.recv_timeout(BEAT) == Err(RecvTimeoutError::Timeout) {
                beat(&folder, &own).ok();
            }
        });
        locks.heart = Some((stop, heart));
        Ok(locks)
    }

    /// Whether no other run works on this store.
    pub fn alone(&self) -> bool {
        !self.others().iter().any(|run| self.alive(run))
    }

    /// Claims the right to compute a case; returns the run that has it if it is taken.
    pub fn claim(&self, id: &str) -> Result<Result<Claim<'_>, Owner>, LockError> {
        self.claim_file(self.dir.join("locks").join(format!("{id}.json")))
    }

    fn claim_file(&self, path: PathBuf) -> Result<Result<Claim<'_>, Owner>, LockError> {
        loop {
            if create(&path, &json(&self.own)).map_err(|e| io(&path, &e))? {
                return Ok(Ok(Claim { locks: self, path }));
            }
            let Some(owner) = self.owner(&path)? else { continue };
            if self.alive(&owner) {
                return Ok(Err(owner));
            }
            // Only one of the runs that see it dead takes it over, and only if the owner is still the same
            let mut guard = path.clone().into_os_string();
            guard.push(format!(".after-{}", owner.name));
            let _guard = match self.claim_file(guard.into())? {
                Ok(guard) => guard,
                Err(other) => return Ok(Err(other)),
            };
            if self.owner(&path)?.as_ref() == Some(&owner) {
                storage::write(&path, json(&self.own).as_bytes()).map_err(|e| io(&path, &e))?;
                return Ok(Ok(Claim { locks: self, path }));
            }
        }
    }

    /// The run that holds a lock; `None` if the lock is gone. A lock that cannot be read belongs to a nameless run, which counts as alive as long as
    /// the file is recent.
    fn owner(&self, path: &Path) -> Result<Option<Owner>, LockError> {
        match storage::read(path, TEXT_LIMIT) {
            Ok(bytes) => Ok(Some(serde_json::from_slice(&bytes).unwrap_or_else(|_| {
                let young = self.age(path).is_some_and(|age| age < SILENT);
                let name = if young { self.own.name.clone() } else { sha256(&bytes)[..16].to_string() };
                Owner { name, host: "an unknown host".into(), ..Owner::default() }
            }))),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
            Err(e) => Err(io(path, &e)),
        }
    }

    /// The other runs that have not reported their end.
    fn others(&self) -> Vec<Owner> {
        let files = std::fs::read_dir(self.dir.join("runs")).into_iter().flatten().flatten();
        let runs = files.filter_map(|file| storage::read(&file.path(), TEXT_LIMIT).ok());
        let runs = runs.filter_map(|bytes| serde_json::from_slice::<Owner>(&bytes).ok());
        runs.filter(|run| run.name != self.own.name).collect()
    }

    fn alive(&self, run: &Owner) -> bool {
        let file = run_file(&self.dir, &run.name);
        if run.machine.is_empty() || run.machine != self.own.machine {
            return self.age(&file).is_some_and(|age| age < SILENT);
        }
        file.is_file() && started(run.pid) == Some(run.pid_started)
    }

    /// Age of a file relative to the own sign of life, by the clock of the file system. A file that is far ahead is reset to the present time, and
    /// counts as silent if its time cannot be set.
    fn age(&self, file: &Path) -> Option<Duration> {
        let changed = |path: &Path| std::fs::metadata(path).and_then(|m| m.modified()).ok();
        let now = changed(&run_file(&self.dir, &self.own.name)).unwrap_or_else(SystemTime::now);
        let age = match now.duration_since(changed(file)?) {
            Ok(age) => age,
            Err(ahead) if ahead.duration() <= SILENT => Duration::ZERO,
            Err(_) => {
                let dated = std::fs::File::options().append(true).open(file).and_then(|file| file.set_modified(now));
                dated.map_or(SILENT, |()| Duration::ZERO)
            }
        };
        Some(age)
    }
}

impl Drop for Locks {
    fn drop(&mut self) {
        if let Some((stop, heart)) = self.heart.take() {
            drop(stop);
            heart.join().ok();
        }
        std::fs::remove_file(run_file(&self.dir, &self.own.name)).ok();
    }
}

impl Drop for Claim<'_> {
    fn drop(&mut self) {
        // Another run may have taken it over in the meantime
        if matches!(self.locks.owner(&self.path), Ok(Some(owner)) if owner == self.locks.own) {
            std::fs::remove_file(&self.path).ok();
        }
    }
}

impl Owner {
    /// Describes this process, under a unique name.
    fn this(study_sha256: &str) -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let now = unix_time();
        let read = |path: &str| std::fs::read_to_string(path).map(|text| text.trim().to_string()).ok();
        let host = read("/proc/sys/kernel/hostname").or_else(|| std::env::var("HOSTNAME").ok()).unwrap_or_default();
        let space = std::fs::read_link("/proc/self/ns/pid").map(|link| link.display().to_string()).ok();
        let machine = read("/proc/sys/kernel/random/boot_id").zip(space).map(|(boot, space)| format!("{boot} {space}"));
        let pid = std::process::id();
        let (machine, pid_started) = match started(pid) {
            Some(ticks) => (machine.unwrap_or_default(), ticks),
            None => (String::new(), 0),
        };
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = sha256(format!("{host} {machine} {pid} {pid_started} {now:?} {count}"))[..16].to_string();
        let (started_unix_s, study_sha256) = (now.as_secs(), study_sha256.into());
        Self { name, host, machine, pid, pid_started, started_unix_s, study_sha256 }
    }
}

/// Start of a process on this machine in ticks; `None` if it has ended or the system does not report it.
fn started(pid: u32) -> Option<u64> {
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // The name of the program, in brackets, may contain any character
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace();
    let ended = matches!(fields.next()?, "Z" | "X");
    fields.nth(18)?.parse().ok().filter(|_| !ended)
}

fn run_file(dir: &Path, name: &str) -> PathBuf {
    dir.join("runs").join(format!("{name}.json"))
}

fn beat(dir: &Path, own: &Owner) -> Result<(), LockError> {
    let path = run_file(dir, &own.name);
    storage::write(&path, json(own).as_bytes()).map_err(|e| io(&path, &e))
}

/// Creates a file with this content; returns false if it already exists.
fn create(path: &Path, text: &str) -> std::io::Result<bool> {
    use std::io::Write;
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut whole = tempfile::Builder::new().prefix(".").suffix(".part").tempfile_in(folder)?;
    whole.write_all(text.as_bytes())?;
    match std::fs::hard_link(whole.path(), path) {
        Ok(()) => return Ok(true),
        Err(e) if e.kind() == ErrorKind::AlreadyExists => return Ok(false),
        Err(_) => {}
    }
    // A file system without hard links
    match std::fs::File::create_new(path) {
        Ok(mut file) => file.write_all(text.as_bytes()).map(|()| true),
        Err(e) if e.kind() == ErrorKind::AlreadyExists => Ok(false),
        Err(e) => Err(e),
    }
}

fn json(owner: &Owner) -> String {
    serde_json::to_string_pretty(owner).expect("numbers and strings only") + "\n"
}

fn io(path: &Path, e: &std::io::Error) -> LockError {
    LockError::Io { path: path.into(), reason: e.to_string() }
}
