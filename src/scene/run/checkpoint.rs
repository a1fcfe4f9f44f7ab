//! A checkpoint, the file from which a run restarts: everything that it needs to continue bit for bit from a point of the time grid.
//!
//! A saved state is a line with the format and the SHA-256 of everything that follows, one line of JSON that states its origin, and then the numbers as 64-bit
//! floats, least significant byte first. It contains the rows recorded so far, so that a run that continues from it writes the same files as an uninterrupted
//! one.

use super::energy_balance::EnergyBalance;
use super::energy_growth::EnergyGrowth;
use super::identity::mesh_sha256;
use crate::math::signal::{Known, Ramp};
use crate::scene::build::Scene;
use crate::scene::control::{ControlError, ControlMemory, Controller, SignalSetting};
use crate::scene::parts::constraints::CableLog;
use crate::scene::record::recorder::Energies;
use crate::scene::signal::instant::rounding;
use crate::solve::{DriverMemory, GridPosition, LaggedFactorRecord, MOST_CUTS, PastPoint, Prediction, Totals};
use crate::storage::{self, DATA_LIMIT, sha256};
use crate::system::{Rates, State};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A state to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    pub t: f64,
    pub x: Vec<f64>,
}

/// Digests that identify the scene of a checkpoint, and its mesh with the cable paths.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::scene) struct Origin {
    scene_sha256: String,
    mesh_sha256: String,
}

impl Origin {
    /// The origin of the states of a scene: the scene with its signals and their tables, and its mesh.
    fn of(scene: &Scene) -> Self {
        let all = format!("{}\n{:?}\n{:?}", scene.simulated, scene.signals, scene.controls);
        Self { scene_sha256: sha256(all), mesh_sha256: mesh_sha256(&scene.body) }
    }

    /// Refuses the states of a different scene or mesh: the error is the word for it, and a hint.
    fn check(&self, scene: &Scene) -> Result<(), (&'static str, &'static str)> {
        let own = Self::of(scene);
        if self.mesh_sha256 != own.mesh_sha256 {
            return Err(("mesh", ""));
        }
        if self.scene_sha256 != own.scene_sha256 {
            return Err((
                "scene",
                " (only title, numerics, output and compare may differ, and no file that the other keys name)",
            ));
        }
        Ok(())
    }
}

/// A run at a point of the time grid, in memory; [`Checkpoint::write`] and [`Checkpoint::read`] store it in a file. It belongs to the scene and mesh of the
/// run, and [`RunOptions::restart`](crate::scene::RunOptions::restart) continues from it only with these.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    pub state: State,
    /// Scene and mesh to which it belongs
    pub(in crate::scene) origin: Origin,
    /// Index of the stage, and of the step in it. Events and the controller have been processed at this point
    pub(in crate::scene) position: GridPosition,
    pub(in crate::scene) memory: DriverMemory,
    pub(in crate::scene) control: ControlMemory,
    pub(in crate::scene) balance: EnergyBalance,
    pub(in crate::scene) cables: CableLog,
    /// Recorded rows \[points\]
    pub(in crate::scene) rows: Vec<Vec<f64>>,
    pub(in crate::scene) signals: Vec<Vec<f64>>,
    /// Memories of the recorders \[points\]
    pub(in crate::scene) memories: Vec<Vec<f64>>,
    pub(in crate::scene) peak: Snapshot,
}

/// Reason why a saved state cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    #[error("{}: cannot be read: {reason}; check the path", file.display())]
    Unreadable { file: PathBuf, reason: String },
    #[error("{}: cannot be written: {reason}; choose another folder with --out, or make room", file.display())]
    Unwritable { file: PathBuf, reason: String },
    #[error("{}: this is no saved state: {fact}; take a file that --save-state has written", file.display())]
    NotAState { file: PathBuf, fact: String },
    #[error("{}: it was saved from another {what}; restart it with the one it belongs to{hint}", file.display())]
    Elsewhere { file: PathBuf, what: &'static str, hint: &'static str },
    #[error("{}: the file is damaged: {fact}; save the state again", file.display())]
    Damaged { file: PathBuf, fact: String },
}

const FORMAT: &str = "durometer state 10";
/// SHA-256 of the sources of the library, with the versions of all dependencies: another build may compute different bits.
const BUILD: &str = env!("DUROMETER_SOURCE_SHA256");
/// Number of values that are written at a time.
const PIECE: usize = 8192;

#[derive(Serialize, Deserialize)]
struct Head {
    build: String,
    t_s: f64,
    scene_sha256: String,
    mesh_sha256: String,
    span: usize,
    step: usize,
    degree: usize,
    level: u32,
    totals: Totals,
    control: ControlMemory,
    cables: CableLog,
    /// Length of each array of the payload
    lengths: Vec<usize>,
}

impl Head {
    /// Whether the position, the counts and the memory of the controls can belong to a run of this scene.
    fn fits(&self, scene: &Scene) -> bool {
        let memory = scene.controls.memory();
        let [own, expected] = [&self.control, &memory].map(|m| (m.programs.len(), m.outside.len(), m.events.len()));
        // The end of the protocol is the start of a span beyond the last
        let in_spans = match scene.spans.get(self.span) {
            Some(span) => self.step <= span.steps(),
            None => self.span == scene.spans.len() && self.step == 0,
        };
        in_spans && own == expected && self.level <= MOST_CUTS
    }
}

/// An input as numbers: a ramp, or, after NaN, the number of the signal that it follows and the time from which that signal counts.
fn numbers(known: &Known) -> [f64; 4] {
    match *known {
        Known::Ramp(Ramp { start, from, end, to }) => [start, from, end, to],
        Known::Follows { signal, since } => [f64::NAN, signal as f64, since, 0.0],
    }
}

/// The input that these numbers represent.
fn of_numbers(four: &[f64]) -> Known {
    match four[0].is_nan() {
        true => Known::Follows { signal: four[1] as usize, since: four[2] },
        false => Known::Ramp(Ramp { start: four[0], from: four[1], end: four[2], to: four[3] }),
    }
}

/// The bytes before and after the first line break.
fn split_line(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|b| *b == b'\n')?;
    Some((&bytes[..end], &bytes[end + 1..]))
}

impl Checkpoint {
    /// Values of the signals that are set from outside, in the order of [`Controls::controlled`](crate::scene::control::Controls::controlled).
    pub fn controlled(&self, scene: &Scene) -> Vec<f64> {
        scene.controls.values_from_outside(&self.control)
    }

    /// The checkpoint at rest, before the first step; an error if an input has no value there.
    pub(in crate::scene) fn new(scene: &Scene) -> (Self, Result<(), ControlError>) {
        let (mut state, mut control) = (scene.start(), scene.controls.memory());
        let observed = |state: &State| {
            let balance = EnergyBalance::new(&scene.system, state);
            let mut memory = scene.memory();
            scene.remember(state, &mut memory);
            let row = scene.record(state, None, &balance.residual, balance.energies, 0, &memory);
            (balance, memory, row)
        };
        let record = |state: &State| observed(&scene.in_place(state.clone())).2;
        let outcome = scene.controls.start(&mut control, &mut state, record);
        let state = scene.in_place(state);
        let (balance, memory, row) = observed(&state);
        let (rows, signals) = (vec![row], vec![scene.signal_values(&state)]);
        let memories = vec![memory];
        let peak = Snapshot { t: 0.0, x: state.x.clone() };
        let (position, memory, cables) = (GridPosition::default(), DriverMemory::default(), CableLog::default());
        let origin = Origin::of(scene);
        (Self { state, origin, position, memory, control, balance, cables, rows, signals, memories, peak }, outcome)
    }

    /// The rows recorded so far.
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// Number of rows recorded so far.
    pub fn recorded(&self) -> usize {
        self.rows.len()
    }

    /// Refuses to continue with a scene or mesh different from that of its run.
    pub(in crate::scene) fn check(&self, scene: &Scene) -> Result<(), ControlError> {
        self.origin.check(scene).map_err(|(what, hint)| ControlError::Elsewhere { what, hint })
    }

    /// Refuses to continue with a controller different from the one that has set the signals so far, by its identity or by the values that it would have set.
    ///
    /// # Errors
    ///
    /// [`ControlError::OtherController`]
    pub fn check_controller(&self, scene: &Scene, controller: &dyn Controller) -> Result<(), ControlError> {
        let before = self.control.controllers.last().map(|c| c.identity.as_str());
        let now = controller.identity();
        if now.is_some() && before == now.as_deref() {
            return Ok(());
        }
        let set = &self.control.set;
        let setting = |w: &[f64]| {
            let [t, next] = [w[0], w[1]];
            let slack = rounding(t, next - t);
            let (_, values) = set.get(set.partition_point(|(since, _)| *since <= t + slack).checked_sub(1)?)?;
            (t < next && t <= self.state.t + slack).then_some(SignalSetting { t, next, values })
        };
        let grid: Vec<f64> = scene.spans.iter().flat_map(|span| (0..=span.steps()).map(|k| span.point(k))).collect();
        let initial = scene.controls.values_from_outside(&scene.controls.memory());
        let would_set = controller.would_set(&initial, &grid.windows(2).filter_map(setting).collect::<Vec<_>>());
        if would_set.unwrap_or(before.is_none() || now.is_none()) {
            return Ok(());
        }
        Err(ControlError::OtherController { t: self.state.t })
    }

    /// Writes the state to a file, whole or not at all.
    ///
    /// # Errors
    ///
    /// [`CheckpointError::Unwritable`] where the file cannot be written.
    pub fn write(&self, file: &Path) -> Result<(), CheckpointError> {
        let arrays = self.arrays();
        let head = Head {
            build: BUILD.into(),
            t_s: self.state.t,
            scene_sha256: self.origin.scene_sha256.clone(),
            mesh_sha256: self.origin.mesh_sha256.clone(),
            span: self.position.span,
            step: self.position.step,
            degree: self.memory.prediction.degree,
            level: self.memory.cuts,
            totals: self.memory.totals,
            control: self.control.clone(),
            cables: self.cables.clone(),
            lengths: arrays.iter().map(|array| array.len()).collect(),
        };
        let head = serde_json::to_string(&head).expect("numbers, strings and string keys only");
        // Called twice, since the digest comes first. The numbers include the factorised tangent, and are not copied
        let fill = |to: &mut dyn Write| {
            writeln!(to, "{head}")?;
            let mut bytes = Vec::with_capacity(8 * PIECE);
            for piece in arrays.iter().flat_map(|array| array.chunks(PIECE)) {
                bytes.clear();
                bytes.extend(piece.iter().flat_map(|v| v.to_le_bytes()));
                to.write_all(&bytes)?;
            }
            Ok(())
        };
        let written = storage::sha256_of(fill).and_then(|sum| {
            storage::write_with(file, |to| {
                writeln!(to, "{FORMAT} {sum}")?;
                fill(to)
            })
        });
        written.map_err(|e| CheckpointError::Unwritable { file: file.into(), reason: e.to_string() })
    }

    /// Reads a state that [`Checkpoint::write`] wrote for the same scene.
    ///
    /// # Errors
    ///
    /// Where the file cannot be read, is not a saved state, is damaged, or belongs to a different scene, mesh or build of the program.
    pub fn read(file: &Path, scene: &Scene) -> Result<Self, CheckpointError> {
        let unreadable = |e: std::io::Error| CheckpointError::Unreadable { file: file.into(), reason: e.to_string() };
        let bytes = storage::read(file, DATA_LIMIT).map_err(unreadable)?;
        let stranger = |fact: &str| CheckpointError::NotAState { file: file.into(), fact: fact.into() };
        let damaged = |fact: &str| CheckpointError::Damaged { file: file.into(), fact: fact.into() };
        let (first, rest) = split_line(&bytes).ok_or_else(|| stranger("it has no first line"))?;
        let sum = std::str::from_utf8(first).ok().and_then(|line| line.strip_prefix(FORMAT));
        let sum = sum.ok_or_else(|| stranger(&format!("its first line does not begin with \"{FORMAT}\"")))?;
        if sum.trim() != sha256(rest) {
            return Err(damaged("its content is not that which was written"));
        }
        let (head, payload) = split_line(rest).ok_or_else(|| damaged("it has no second line"))?;
        let head: Head = serde_json::from_slice(head).map_err(|_| damaged("its second line is not that of a state"))?;
        let elsewhere = |what, hint| CheckpointError::Elsewhere { file: file.into(), what, hint };
        if head.build != BUILD {
            return Err(elsewhere("build of this program", ""));
        }
        let origin = Origin { scene_sha256: head.scene_sha256.clone(), mesh_sha256: head.mesh_sha256.clone() };
        origin.check(scene).map_err(|(what, hint)| elsewhere(what, hint))?;
        let length = head.lengths.iter().try_fold(0usize, |sum, n| sum.checked_add(*n));
        if length.and_then(|n| n.checked_mul(8)) != Some(payload.len()) || !head.fits(scene) {
            return Err(damaged("its numbers do not fit the scene"));
        }
        let mut numbers = payload.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes")));
        let arrays = head.lengths.iter().map(|n| numbers.by_ref().take(*n).collect()).collect();
        Self::from_arrays(head, arrays, scene).ok_or_else(|| damaged("its arrays do not fit the scene"))
    }

    /// All numbers outside of the head, in the order of [`Checkpoint::from_arrays`].
    fn arrays(&self) -> Vec<Cow<'_, [f64]>> {
        let State { t, x, v, a, lambda, memory, dt, history, inputs } = &self.state;
        let Energies { elastic, kinetic, dissipated, work } = self.balance.energies;
        let scalars = vec![*t, *dt, self.memory.stiffness, elastic, kinetic, dissipated, work, self.peak.t];
        let known: Vec<f64> = inputs.iter().flat_map(numbers).collect();
        let state = [x, v, a, lambda, memory, history].map(Cow::from);
        let state = std::iter::once(Cow::from(scalars)).chain(state).chain([Cow::from(known)]);
        let flat = |rows: &[Vec<f64>]| Cow::from(rows.concat());
        let LaggedFactorRecord { k, x: placed, solves, steps, rates, renew } = &self.memory.lagged_factor;
        let counts = [solves[0], solves[1], *steps, usize::from(*renew)].map(|n| n as f64);
        let counts = vec![counts[0], counts[1], counts[2], counts[3], rates.cv, rates.ca];
        let lagged_factor = [Cow::from(k.as_slice()), Cow::from(placed.as_slice()), Cow::from(counts)];
        let balance = [&self.balance.effect, &self.balance.g, &self.balance.residual].map(Cow::from);
        let growth = [Cow::from(self.balance.growth.numbers().to_vec())];
        let kept = [flat(&self.rows), flat(&self.signals), flat(&self.memories), Cow::from(&self.peak.x)];
        let recent = self.memory.prediction.recent.iter();
        let recent = recent.flat_map(|p| [Cow::from(vec![p.t]), Cow::from(&p.x), Cow::from(&p.lambda)]);
        state.chain(balance).chain(growth).chain(kept).chain(lagged_factor).chain(recent).collect()
    }

    fn from_arrays(head: Head, arrays: Vec<Vec<f64>>, scene: &Scene) -> Option<Self> {
        let (system, rest) = (&scene.system, scene.system.rest());
        let mut arrays = arrays.into_iter();
        let [t, dt, stiffness, elastic, kinetic, dissipated, work, peak] = arrays.next()?[..] else { return None };
        let mut of_size = |n: usize| arrays.next().filter(|a| a.len() == n);
        let n = rest.x.len();
        let (x, v, a) = (of_size(n)?, of_size(rest.v.len())?, of_size(rest.a.len())?);
        let lambda = of_size(rest.lambda.len())?;
        let memory = arrays.next()?;
        let history = arrays.next().filter(|h| h.len() == rest.history.len())?;
        let inputs: Vec<Known> = arrays.next()?.chunks_exact(4).map(of_numbers).collect();
        if !scene.controls.admit(&inputs) {
            return None;
        }
        let mut of_size = |n: usize| arrays.next().filter(|a| a.len() == n);
        let (effect, g, residual) = (of_size(system.effects.len())?, of_size(system.constraints.len())?, of_size(n)?);
        let growth = EnergyGrowth::of_numbers(arrays.next()?.try_into().ok()?);
        let rows = rows(arrays.next()?, scene.columns().len());
        let signals = rows_of(arrays.next()?, scene.signals.len(), rows.len());
        let memories = rows_of(arrays.next()?, scene.memory().len(), rows.len());
        let peak = Snapshot { t: peak, x: arrays.next().filter(|x| x.len() == n)? };
        let k = arrays.next().filter(|k| k.is_empty() || k.len() == system.pattern.nnz())?;
        let placed = arrays.next().filter(|x| x.len() == n || k.is_empty())?;
        let [all, here, steps, renew, cv, ca] = arrays.next()?[..] else { return None };
        let solves = [all as usize, here as usize];
        let lagged_factor = LaggedFactorRecord {
            k: k.into(),
            x: placed.into(),
            solves,
            steps: steps as usize,
            rates: Rates { cv, ca },
            renew: renew == 1.0,
        };
        let mut recent = Vec::new();
        while let Some(t) = arrays.next() {
            let (x, lambda) = (arrays.next().filter(|x| x.len() == n)?, arrays.next()?);
            recent.push(PastPoint { t: *t.first()?, x, lambda });
        }
        // A polynomial through the available states
        let degree = Some(head.degree).filter(|d| *d >= 1 && (recent.len() < 2 || *d < recent.len()))?;
        let energies = Energies { elastic, kinetic, dissipated, work };
        Some(Self {
            state: State { t, x, v, a, lambda, memory, dt, history, inputs },
            origin: Origin { scene_sha256: head.scene_sha256, mesh_sha256: head.mesh_sha256 },
            position: GridPosition { span: head.span, step: head.step },
            memory: DriverMemory {
                prediction: Prediction { recent, degree },
                cuts: head.level,
                stiffness,
                lagged_factor,
                totals: head.totals,
            },
            control: head.control,
            balance: EnergyBalance { energies, effect, g, residual, growth },
            cables: head.cables,
            rows,
            signals,
            memories,
            peak,
        })
    }
}

fn rows(flat: Vec<f64>, columns: usize) -> Vec<Vec<f64>> {
    flat.chunks_exact(columns).map(<[f64]>::to_vec).collect()
}

/// The numbers as `count` rows, even if there are no columns.
fn rows_of(flat: Vec<f64>, columns: usize, count: usize) -> Vec<Vec<f64>> {
    if columns == 0 { vec![Vec::new(); count] } else { rows(flat, columns) }
}
