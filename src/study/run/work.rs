//! How much work a case was, whatever the machine; and how its cost scatters when it is run again.

use crate::math::threads::CpuClock;
use crate::scene::{Progress, Run, RunOptions, Scene};
use crate::solve::Status;
use crate::system::State;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Counted, not timed.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct WorkRecord {
    /// Numeric factorisations, the shifted ones included
    pub factorisations: usize,
    /// Right sides solved for
    pub solves: usize,
    /// Additions and multiplications of one factorisation: Σ over the columns of L of the square of their length
    pub factor_flops: f64,
    /// Stored entries of the tangent, one triangle
    pub matrix_nnz: usize,
    /// Largest resident set of the process while the case ran \[bytes\]; none where it ran alongside another, or where the system
    /// does not tell
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory_bytes: Option<u64>,
    /// The same as it was expected before the first factorisation, where the case ran in a process of its own \[bytes\]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_bytes: Option<u64>,
}

/// One run of a case that was run several times.
#[derive(Serialize, Deserialize, Clone, Copy, Debug, PartialEq)]
pub struct RepeatRecord {
    pub wall_s: f64,
    pub cpu_s: f64,
}

/// Wall and CPU seconds that something else has taken during a run.
#[derive(Default)]
pub(super) struct Aside {
    wall: f64,
    cpu: f64,
}

impl Aside {
    /// Does it, and counts what it takes.
    pub fn count(&mut self, act: impl FnOnce()) {
        let (wall, cpu) = (Instant::now(), CpuClock::start());
        act();
        self.wall += wall.elapsed().as_secs_f64();
        self.cpu += cpu.elapsed().as_secs_f64();
    }

    /// The seconds of a run without it.
    pub fn subtracted(&self, (wall, cpu): (f64, f64)) -> (f64, f64) {
        (wall - self.wall, cpu - self.cpu)
    }
}

/// Runs the scene `repeats` times. Returns the run of median CPU time, its wall and CPU seconds, and those of all. All runs give the
/// same bits; `states` gets those of the first, in time that does not count. A run that does not converge is not repeated.
pub(super) fn measure(
    scene: &Scene,
    repeats: usize,
    go_on: &mut dyn FnMut(Progress) -> bool,
    states: &mut dyn FnMut(&State),
    sized: &mut dyn FnMut(u64) -> bool,
) -> (Run, (f64, f64), Vec<RepeatRecord>) {
    let mut runs: Vec<(RepeatRecord, Run)> = Vec::new();
    loop {
        let (wall, cpu) = (Instant::now(), CpuClock::start());
        let first = runs.is_empty();
        let mut aside = Aside::default();
        let mut on_state = |state: &State| {
            if first {
                aside.count(|| states(state));
            }
        };
        let run = scene.run_with(RunOptions {
            on_progress: Some(go_on),
            on_state: Some(&mut on_state),
            on_sized: Some(sized),
            ..RunOptions::default()
        });
        let (wall_s, cpu_s) = aside.subtracted((wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64()));
        let times = RepeatRecord { wall_s, cpu_s };
        let done = run.status == Status::Converged;
        if done || first {
            runs.push((times, run));
        }
        if !done || runs.len() >= repeats {
            break;
        }
    }
    let all: Vec<RepeatRecord> = runs.iter().map(|r| r.0).collect();
    runs.sort_by(|a, b| a.0.cpu_s.total_cmp(&b.0.cpu_s));
    let (times, run) = runs.swap_remove((runs.len() - 1) / 2);
    (run, (times.wall_s, times.cpu_s), all)
}

/// The largest resident set of the process from here on. Linux counts it; `None` elsewhere.
pub(super) fn watch_memory() -> Option<()> {
    std::fs::write("/proc/self/clear_refs", "5").ok()
}

/// The largest resident set since [`watch_memory`] \[bytes\].
pub(super) fn largest_memory() -> Option<u64> {
    of_this_process("VmHWM:")
}

/// The resident set \[bytes\].
pub(super) fn present_memory() -> Option<u64> {
    of_this_process("VmRSS:")
}

fn of_this_process(key: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix(key))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kilobytes)
}
