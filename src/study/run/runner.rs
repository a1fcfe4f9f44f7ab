//! Runs the cases of a study side by side, skips those with a valid result, and keeps what is finished.

use crate::catalogue::Launch;
use crate::live::Access;
use crate::math::threads::{self, locked};
use crate::mesh::generate::MesherOwner;
use crate::scene::{ParameterKey, Progress, SceneError};
use crate::storage::sha256;
use crate::study::case::{Bodies, Case};
use crate::study::expand::Study;
use crate::study::run::compute::{CaseError, Follow, compute};
use crate::study::run::cores::{Cores, Share};
use crate::study::run::memory::{self, Admission, Allowance, SHARE};
use crate::study::run::mistakes::{self, SmallestMeshes};
use crate::study::run::only::Only;
use crate::study::run::task::Task;
use crate::study::run::waiting;
use crate::study::run::worker::{End, Order, Said, Wants, compute_apart};
use crate::study::store::finished_run::refused;
use crate::study::store::folder::{Store, StoreError, Stored};
use crate::study::store::identity::Identity;
use crate::study::store::lock::{LockError, Locks};
use crate::study::store::origin;
use crate::study::store::record::{CRASHED, CaseRecord, INPUTS_CHANGED, OUT_OF_MEMORY, OUT_OF_TIME, StudyRecord};
use crate::study::store::superseded;
use crate::wording::first;
use std::collections::{BTreeMap, HashMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

/// Interval between checks of cases that other runs compute.
const LOOK: Duration = Duration::from_millis(200);

/// Observer of the run of a study. Methods that are not implemented ignore their event.
pub trait Watch: Sync {
    /// Receives a line of the mesher about the mesh of a case.
    fn meshing(&self, _case: &str, _line: &str) {}
    /// Called before a case is computed, in the thread that computes it; the thread ends with the run.
    fn started(&self, _case: &str) {}
    fn progress(&self, _case: &str, _progress: Progress) {}
    /// Receives the reason why a case waits or is run again.
    fn note(&self, _case: &str, _text: &str) {}
    fn finished(&self, _record: &CaseRecord, _skipped: bool) {}
    /// Access to the live view of the cases, if there is one, for cases in processes of their own.
    fn live(&self) -> Option<Access> {
        None
    }
    /// Reports the port at which the process of a case serves its live view; `None` when it no longer does.
    fn serves(&self, _case: &str, _port: Option<u16>) {}
}

/// Ignores all events.
impl Watch for () {}

/// Reason why a study stopped; results finished before are kept.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    #[error(transparent)]
    Case(#[from] CaseError),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Lock(#[from] LockError),
    /// A reason reported by the process of a case
    #[error("{why}")]
    Apart { why: String },
    #[error("{}: the process of a case cannot be started: {reason}; close other programs, or run fewer cases with --jobs", program.display())]
    Start { program: PathBuf, reason: String },
    #[error("{}: none of the cases was run, because some are refused:\n  {}", file.display(), refused.join("\n  "))]
    Refused { file: PathBuf, refused: Vec<String> },
    #[error("no case is called like \"{only}\"; the cases are: {known}")]
    NoSuchCase { only: String, known: String },
}

impl From<SceneError> for RunError {
    fn from(why: SceneError) -> Self {
        Self::Case(why.into())
    }
}

/// Where cases are computed. The results do not depend on it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Isolation {
    /// Cases are computed in threads of this process. A panic is the status of its case; an abort ends all of them.
    Threads,
    /// Each case is computed in a separate process of this program, started as `program worker` ([`crate::study::run::worker`]): whatever ends it is
    /// the status of its case.
    Processes(Launch),
}

/// Options of a run; [`Options::new`] has the usual choices.
pub struct Options<'a> {
    /// Number of cases that run at the same time; cases in processes share as many threads
    pub jobs: usize,
    /// Also rerun cases that have a result
    pub redo: bool,
    /// Also rerun cases that use a law registered in this process, because its name may have referred to another law before
    pub redo_registered: bool,
    /// Keep results that another build of this program computed from the same inputs
    pub accept_build: bool,
    /// Only these cases
    pub only: Option<Only>,
    /// Write the fields of every case into `cases/<id>/`; a finished case without them is rerun
    pub vtu: bool,
    /// Where cases are computed
    pub isolation: Isolation,
    /// Memory that cases in processes may take together \[bytes\]; by default [`SHARE`] of the memory available when the run begins
    pub memory: Option<u64>,
    /// Flag that stops the run when set: running cases are dropped, finished ones kept
    pub stop: &'a AtomicBool,
}

impl<'a> Options<'a> {
    /// Options that run every case without a result, in threads of this process, as many at a time as there are processors.
    pub fn new(stop: &'a AtomicBool) -> Self {
        Self {
            jobs: threads::available(),
            redo: false,
            redo_registered: true,
            accept_build: false,
            only: None,
            vtu: false,
            isolation: Isolation::Threads,
            memory: None,
            stop,
        }
    }

    /// Whether this case is to be run or its result kept.
    pub fn wants(&self, id: &str) -> bool {
        self.only.as_ref().is_none_or(|only| only.takes(id))
    }

    /// Whether a case is rerun although it has a result.
    fn redoes(&self, case: &Case) -> bool {
        self.redo || (self.redo_registered && case.has_registered_law())
    }
}

/// Runs the cases of a study into `dir`, except those that follow from their results. Returns the records of all wanted cases that have one; an
/// interrupted case has none.
///
/// # Errors
///
/// No case is wanted, a scene is refused, another run writes to the folder, or a result cannot be written.
pub(in crate::study) fn run_cases(
    study: &Study,
    dir: &Path,
    options: &Options,
    watch: &dyn Watch,
) -> Result<Vec<CaseRecord>, RunError> {
    let cases: Vec<&Case> = study.cases.iter().filter(|c| options.wants(&c.id)).collect();
    if let (true, Some(Only::Containing(only))) = (cases.is_empty(), &options.only) {
        let known = first(&study.cases.iter().map(|c| c.id.as_str()).collect::<Vec<_>>());
        return Err(RunError::NoSuchCase { only: only.clone(), known });
    }
    all_sound(study, mistakes::before_meshing(study, &cases))?;
    let is_part = options.only.as_ref().is_some_and(Only::is_part);
    let store = Store::open(dir)?;
    let inputs = Inputs::of(study);
    let locks = Locks::join(dir, &inputs.digest(study))?;
    store.describe(&inputs.described(study))?;
    origin::note(dir, &study.file)?;
    if locks.alone() {
        store.sweep();
    }
    compare_others(study, &store, options, watch)?;
    let (now, later): (Vec<&Case>, Vec<&Case>) = cases.into_iter().partition(|c| c.after.is_none());
    let with_constants = |c: &Case| (c.clone(), Task::of(study, c, false).constants);
    let usual = || memory::available().map_or(u64::MAX, |bytes| (SHARE * bytes as f64) as u64);
    let memory = Allowance::new(options.memory.unwrap_or_else(usual));
    let (cases, cores) = (AtomicUsize::new(0), Cores::new(options.jobs));
    let run = Running { store: &store, locks: &locks, options, watch, inputs, cases, memory, cores };
    let mut records = run.side_by_side(study, now.into_iter().map(with_constants).collect())?;
    if !later.is_empty() && !options.stop.load(Ordering::Relaxed) {
        // Other runs produce the results of the other cases: a case that waits for them reads them from the store once all are there
        let sources = |c: &Case| match is_part {
            true => waiting::sources(study, c, (&store, options.accept_build), &mut |c| {
                c.bodies(&mut |_| {}).ok().map(|bodies| bodies.sha256())
            }),
            false => Some(records.clone()),
        };
        let ready = |c| waiting::ready(study, c, &sources(c)?, &store);
        let ready = later.into_iter().filter_map(ready).collect();
        records.extend(run.side_by_side(study, ready)?);
    }
    let places: HashMap<&str, usize> = study.cases.iter().enumerate().map(|(k, c)| (c.id.as_str(), k)).collect();
    records.sort_by_key(|r: &CaseRecord| places.get(r.id.as_str()).copied());
    Ok(records)
}

/// Refuses a study if some of its cases have mistakes.
fn all_sound(study: &Study, refused: Vec<String>) -> Result<(), RunError> {
    if refused.is_empty() { Ok(()) } else { Err(RunError::Refused { file: study.file.clone(), refused }) }
}

/// Reports which stored results among the cases that are not run have other inputs. Cases that wait for others are included, because they may never
/// run; the remaining cases are checked when their turn comes. A partial run makes no meshes for other parts and compares only on the meshes of their
/// results.
fn compare_others(study: &Study, store: &Store, options: &Options, watch: &dyn Watch) -> Result<(), RunError> {
    let is_part = options.only.as_ref().is_some_and(Only::is_part);
    let is_other = |c: &&Case| (c.after.is_some() || !options.wants(&c.id)) && store.has(&c.id);
    for case in study.cases.iter().filter(is_other) {
        let mut meshes = |c: &Case| {
            if is_part {
                return store.record(&c.id).map(|record| record.provenance.identity.meshes());
            }
            let bodies = c.bodies(&mut |line| watch.meshing(&c.id, line));
            // The result of a refused case has no mesh
            Some(bodies.map_or_else(|_| vec![], |bodies| bodies.sha256()))
        };
        let now = waiting::identity(study, case, store, &mut meshes);
        // A mesher that was stopped says nothing about the inputs
        if options.stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        store.compare_inputs(&case.id, now.as_ref().map(|identity| identity.sha256.as_str()))?;
    }
    Ok(())
}

/// A case that is ready to run.
struct Ready {
    task: Task,
    /// Identity of the result; `None` if the case has no body
    identity: Option<Identity>,
    /// Number of nodes of its mesh
    size: usize,
    /// Digest of the record that existed before, independently of the clock; `None` if there was no record
    before: Option<String>,
}

/// A case waiting for its turn.
struct Turn {
    ready: Ready,
    /// Whether another run was computing it at the last check
    waits: bool,
}

/// Outcome of the turn of a case.
enum Turned {
    /// Another run computes the case
    Busy,
    /// The case was stopped, and has no record
    Stopped,
    /// The record was kept or computed
    Done(Box<CaseRecord>),
}

/// Prepares the cases with their bodies and identities, in the order in which they run; empty if the run was stopped.
fn prepare(
    study: &Study,
    cases: Vec<(Case, Vec<ParameterKey>)>,
    (store, options, inputs): (&Store, &Options, &Inputs),
    watch: &dyn Watch,
) -> Result<VecDeque<Turn>, RunError> {
    // Meshes come first, one after the other: the mesher takes its own time, and two cases may need the same mesh
    let mut all: Vec<Ready> = vec![];
    let mut smallest = SmallestMeshes::default();
    for (case, constants) in cases {
        if options.stop.load(Ordering::Relaxed) {
            return Ok(VecDeque::new());
        }
        let bodies = match case.bodies(&mut |line| watch.meshing(&case.id, line)) {
            // Ctrl-C also reaches the mesher, which is not a fault of the study
            Err(_) if options.stop.load(Ordering::Relaxed) => return Ok(VecDeque::new()),
            Err(_) if study.rules.keep_refusals => None,
            bodies => Some(bodies?),
        };
        // From here on results of other inputs do not count, even if the run is stopped before there are new ones
        let meshes = bodies.as_ref().map(Bodies::sha256);
        store.compare_inputs(&case.id, Some(&case.identity(meshes.as_deref().unwrap_or_default()).sha256))?;
        let identity = meshes.map(|meshes| case.identity(&meshes));
        let size = bodies.as_ref().map_or(0, |bodies| bodies.own.mesh.points.len());
        let files = inputs.files.get(&case.id).cloned().unwrap_or_default();
        let task = Task { files, ..Task::new(study, case, constants, options.vtu) };
        let stored = store.record(&task.case.id);
        let counts = |record: &CaseRecord| {
            identity.as_ref().is_some_and(|identity| record.provenance.counts_for(identity, options.accept_build))
        };
        if let Some(bodies) = bodies.filter(|_| options.redoes(&task.case) || !stored.as_ref().is_some_and(counts)) {
            smallest.add(all.len(), &task, &bodies.own);
        }
        let before = stored.map(|record| record.provenance.record_sha256);
        all.push(Ready { task, identity, size, before });
    }
    all_sound(study, smallest.mistakes(|k| &all[k].task))?;
    // The largest case runs first, so that the last ones to end are short. If memory is measured, the smallest runs first: memory that the allocator
    // keeps after a large case must not be attributed to a small one.
    all.sort_by_key(|ready| std::cmp::Reverse(ready.size));
    if study.rules.smallest_first {
        all.reverse();
    }
    Ok(all.into_iter().map(|ready| Turn { ready, waits: false }).collect())
}

/// The inputs of a study when its run starts.
struct Inputs {
    /// Case → digest of its inputs; cases that wait for constants have none
    sha256: BTreeMap<String, String>,
    /// Case → path of each of its files → SHA-256
    files: HashMap<String, BTreeMap<PathBuf, String>>,
}

impl Inputs {
    fn of(study: &Study) -> Self {
        let known = study.cases.iter().filter(|c| c.after.is_none());
        Self {
            sha256: known.map(|c| (c.id.clone(), c.identity(&[]).inputs_sha256)).collect(),
            files: study.cases.iter().map(|c| (c.id.clone(), c.files())).collect(),
        }
    }

    /// The record of the study with these inputs.
    fn described(&self, study: &Study) -> StudyRecord {
        StudyRecord { inputs_sha256: self.sha256.clone(), ..study.record.clone() }
    }

    /// Digest of the study with these inputs, by which runs into one folder recognise each other. The location of its files does not count.
    fn digest(&self, study: &Study) -> String {
        let mut files: Vec<&String> = self.files.values().flat_map(BTreeMap::values).collect();
        files.sort_unstable();
        files.dedup();
        sha256(format!("{} {:?} {files:?}", study.sha256(), self.sha256))
    }
}

/// The shared state of cases that run side by side.
struct Running<'a> {
    store: &'a Store,
    locks: &'a Locks,
    options: &'a Options<'a>,
    watch: &'a dyn Watch,
    inputs: Inputs,
    /// Number of cases that are being computed
    cases: AtomicUsize,
    memory: Allowance,
    cores: Cores,
}

impl Running<'_> {
    /// Runs cases, each with its derivatives with respect to the constants. Before that, a report of other inputs is marked as superseded.
    fn side_by_side(&self, study: &Study, cases: Vec<(Case, Vec<ParameterKey>)>) -> Result<Vec<CaseRecord>, RunError> {
        let queue = Mutex::new(prepare(study, cases, (self.store, self.options, &self.inputs), self.watch)?);
        superseded::mark(&self.store.dir, &self.inputs.described(study))?;
        let (records, failure) = (Mutex::new(Vec::new()), Mutex::new(None));
        let owner = MesherOwner::current();
        std::thread::scope(|scope| {
            for _ in 0..self.options.jobs.max(1) {
                scope.spawn(|| {
                    let _turn = owner.begin();
                    // Number of consecutive checks that found a case of another run
                    let mut busy = 0;
                    while !self.options.stop.load(Ordering::Relaxed) && locked(&failure).is_none() {
                        let Some(mut turn) = locked(&queue).pop_front() else { break };
                        match self.case(&turn) {
                            Ok(Turned::Done(record)) => {
                                busy = 0;
                                locked(&records).push(*record);
                            }
                            Ok(Turned::Stopped) => busy = 0,
                            Ok(Turned::Busy) => {
                                busy += 1;
                                turn.waits = true;
                                let left = {
                                    let mut queue = locked(&queue);
                                    queue.push_back(turn);
                                    queue.len()
                                };
                                if busy >= left {
                                    busy = 0;
                                    std::thread::sleep(LOOK);
                                }
                            }
                            Err(error) => {
                                locked(&failure).get_or_insert(error);
                            }
                        }
                    }
                });
            }
        });
        if let Some(error) = locked(&failure).take() {
            return Err(error);
        }
        Ok(std::mem::take(&mut *locked(&records)))
    }

    /// Returns the stored result of a case, or computes it.
    fn case(&self, turn: &Turn) -> Result<Turned, RunError> {
        let (ready, id) = (&turn.ready, &turn.ready.task.case.id);
        if let Some(record) = self.kept(turn)? {
            return Ok(Turned::Done(record.into()));
        }
        let _claim = match self.locks.claim(id)? {
            Ok(claim) => claim,
            Err(owner) => {
                if !turn.waits {
                    self.watch.note(id, &format!("process {} on {} computes it", owner.pid, owner.host));
                }
                return Ok(Turned::Busy);
            }
        };
        // It may have been finished since the check
        if let Some(record) = self.kept(turn)? {
            return Ok(Turned::Done(record.into()));
        }
        if let Stored::Damaged(why) = self.store.look(id)? {
            let aside = self.store.set_aside(id)?;
            self.watch.note(
                id,
                &format!("its stored result cannot be used ({why}): it is set aside as {aside} and computed again"),
            );
        }
        if ready.before.is_some() && !self.options.redo && self.options.redoes(&ready.task.case) {
            self.watch
                .note(id, "it is computed again: its law is one of this process, which may have changed since then");
        }
        self.watch.started(id);
        self.cases.fetch_add(1, Ordering::SeqCst);
        let record = match &self.options.isolation {
            Isolation::Threads => self.in_this_thread(&ready.task),
            Isolation::Processes(program) => self.in_a_process(program, &ready.task, ready.size),
        };
        self.cases.fetch_sub(1, Ordering::SeqCst);
        let Some(record) = record? else { return Ok(Turned::Stopped) };
        self.watch.finished(&record, false);
        Ok(Turned::Done(record.into()))
    }

    /// The stored result of a case, if it equals the one that would be computed; an error if it lacks a judged column.
    fn kept(&self, turn: &Turn) -> Result<Option<CaseRecord>, RunError> {
        let task = &turn.ready.task;
        let Some(record) = self.store.record(&task.case.id).filter(|record| self.usable(turn, record)) else {
            return Ok(None);
        };
        task.check_record(&record).map_err(CaseError::from)?;
        self.watch.finished(&record, true);
        Ok(Some(record))
    }

    /// Whether a stored record is the result that would be computed.
    fn usable(&self, turn: &Turn, record: &CaseRecord) -> bool {
        let (task, identity) = (&turn.ready.task, &turn.ready.identity);
        // Another run has just computed it, with this outcome
        let now = turn.ready.before.as_ref() != Some(&record.provenance.record_sha256);
        if turn.waits && now && record.broke() && record.status != INPUTS_CHANGED {
            return true;
        }
        let drawn = !task.vtu || self.store.has_fields(record);
        let counts = |identity| record.provenance.counts_for(identity, self.options.accept_build);
        let same = identity.as_ref().is_some_and(counts);
        // A search that ran out of time continues
        let goes_on = record.status == OUT_OF_TIME && !now;
        drawn && (now || !self.options.redoes(&task.case)) && same && record.has(&task.asked()) && !goes_on
    }

    fn shared(&self) -> bool {
        self.cases.load(Ordering::Relaxed) > 1
    }

    fn in_this_thread(&self, task: &Task) -> Result<Option<CaseRecord>, RunError> {
        let id = &task.case.id;
        let mut follow = Follow {
            meshing: &mut |line| self.watch.meshing(id, line),
            progress: &mut |progress| {
                self.watch.progress(id, progress);
                !self.options.stop.load(Ordering::Relaxed)
            },
            shared: &|| self.shared(),
            admit: &mut |_| true,
            live: None,
            own_process: false,
        };
        Ok(compute(task, self.store, &mut follow)?)
    }

    fn in_a_process(&self, program: &Launch, task: &Task, size: usize) -> Result<Option<CaseRecord>, RunError> {
        let id = &task.case.id;
        let order = Order { dir: self.store.dir.clone(), task: task.clone(), live: self.watch.live() };
        let mut following = Following { run: self, id, size, promised: 0, share: None };
        let end = compute_apart(program, &order, &mut following)
            .map_err(|e| RunError::Start { program: program.file.clone(), reason: e.to_string() })?;
        let broken = |status: &str, why: String| {
            let mut record = refused(&task.case, status, why);
            self.store.save_refused(&mut record).map(|()| Some(record))
        };
        match end {
            End::Stopped => Ok(None),
            End::Failed(why) => Err(RunError::Apart { why: format!("case {id}: {why}") }),
            // Its process has stored everything that can be stored
            End::Broke(status, why) => Ok(Some(refused(&task.case, &status, why))),
            End::TooLarge(bytes) => {
                let [needed, allowed] = [bytes, self.memory.limit].map(|bytes| bytes as f64 / 1e9);
                let why = format!(
                    "it is going to take {needed:.2} GB, and all cases together may take {allowed:.2} GB; allow more with --memory, take the iterative \
                     method by numerics.factor_memory, or a coarser mesh"
                );
                Ok(broken(OUT_OF_MEMORY, why)?)
            }
            End::Died(how) => Ok(broken(CRASHED, how)?),
            End::Stored => match self.store.record(id) {
                Some(record) => Ok(Some(record)),
                None => {
                    let why = "its stored result cannot be read back; look at the disk, and run it again";
                    Ok(broken(CRASHED, why.into())?)
                }
            },
        }
    }
}

/// Follows the process of a case on behalf of its run.
struct Following<'a> {
    run: &'a Running<'a>,
    id: &'a str,
    /// Number of nodes
    size: usize,
    /// Promised memory \[bytes\]
    promised: u64,
    /// Share of the cores, from the moment it computes
    share: Option<Share<'a>>,
}

impl Wants for Following<'_> {
    fn said(&mut self, said: Option<&Said>) -> bool {
        match said {
            Some(&Said::Serves(port)) => self.run.watch.serves(self.id, Some(port)),
            Some(Said::Meshing(line)) => self.run.watch.meshing(self.id, line),
            Some(&Said::Progress { t, end }) => self.run.watch.progress(self.id, Progress { t, end }),
            _ => {}
        }
        !self.run.options.stop.load(Ordering::Relaxed)
    }

    fn shared(&self) -> bool {
        self.run.shared()
    }

    fn threads(&self) -> usize {
        self.share.as_ref().map_or(1, Share::threads)
    }

    fn admit(&mut self, bytes: u64) -> Admission {
        let admission = self.run.memory.admit(bytes);
        if admission == Admission::Now {
            self.promised += bytes;
            self.share.get_or_insert_with(|| self.run.cores.join(self.size));
        }
        admission
    }
}

impl Drop for Following<'_> {
    fn drop(&mut self) {
        self.run.memory.release(self.promised);
        self.run.watch.serves(self.id, None);
    }
}
