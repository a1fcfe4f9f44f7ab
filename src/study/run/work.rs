//! The amount of work of a case, independent of the machine, and the scatter of its cost between runs.

use crate::live::{Board, iterations};
use crate::math::stopwatch::{Spent, Stopwatch};
use crate::scene::{OnProgress, Run, RunOptions, Scene, Sensitivities, SensitivityRecorder};
use crate::solve::Status;
use crate::system::State;
use serde::{Deserialize, Serialize};
use std::cell::Cell;
use std::sync::Arc;

/// Work of a case, counted instead of timed.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct WorkRecord {
    /// Number of numeric factorisations, including those of shifted matrices
    pub factorisations: usize,
    /// Number of right-hand sides solved for
    pub solves: usize,
    /// Additions and multiplications of one factorisation: the sum over the columns of L of their squared length
    pub factor_flops: f64,
    /// Stored entries in one triangle of the tangent
    pub matrix_nnz: usize,
    /// Largest resident set of the process while the case ran \[bytes\]; `None` if it ran alongside another, or if the system does not report it
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub memory_bytes: Option<u64>,
    /// Memory expected before the first factorisation, if the case ran in a process of its own \[bytes\]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_bytes: Option<u64>,
}

/// One run of a case that was run several times.
#[derive(Serialize, Deserialize, Clone, Copy, Debug, PartialEq)]
pub struct RepeatRecord {
    pub wall_s: f64,
    pub cpu_s: f64,
}

/// A run with its time, without that of activities that only follow the run.
pub(super) struct Timed {
    pub run: Run,
    pub spent: Spent,
}

/// Callbacks of a timed run.
pub(super) struct RunFollow<'a, 'b> {
    /// Returns false to stop the run
    pub go_on: &'a mut OnProgress<'b>,
    /// Receives the states; its time does not count
    pub states: &'a mut dyn FnMut(&State),
    /// Shows the rows and iterations in a live view
    pub board: Option<&'a Arc<Board>>,
    /// Receives the memory that the factorisation needs \[bytes\], before the first one, and returns false to stop; its time does not count
    pub sized: &'a mut dyn FnMut(u64) -> bool,
}

/// Time spent on other things during a run.
#[derive(Default)]
struct Aside(Cell<Spent>);

impl Aside {
    /// Calls `act` and adds the time spent in it.
    fn count<T>(&self, act: impl FnOnce() -> T) -> T {
        let stopwatch = Stopwatch::start();
        let result = act();
        self.0.set(self.0.get() + stopwatch.spent());
        result
    }
}

/// Runs the scene once, with derivatives if there is a recorder; the time for these does not count.
fn timed(scene: &Scene, sensitivities: Option<SensitivityRecorder>, follow: &mut RunFollow) -> Timed {
    let RunFollow { go_on, states, board, sized } = follow;
    let (stopwatch, aside) = (Stopwatch::start(), Aside::default());
    let mut on_sized = |bytes| aside.count(|| sized(bytes));
    let mut on_state = |state: &State| aside.count(|| states(state));
    let mut on_row = |row: &[f64]| {
        board.iter().for_each(|board| board.row(row));
        true
    };
    let run = scene.run_with(RunOptions {
        on_progress: Some(&mut **go_on),
        on_state: Some(&mut on_state),
        on_row: Some(&mut on_row),
        on_iteration: board.cloned().map(iterations),
        on_sized: Some(&mut on_sized),
        sensitivities,
        ..RunOptions::default()
    });
    let spent = run.own_time(stopwatch.spent(), aside.0.get());
    Timed { run, spent }
}

/// Runs the scene `repeats` times. Returns the run with the median CPU time, and the times of all. All runs give identical results; the states are
/// those of the first. A run that does not converge is not repeated.
pub(super) fn measure(scene: &Scene, repeats: usize, mut follow: RunFollow) -> (Timed, Vec<RepeatRecord>) {
    let is_complete = |timed: &Timed| timed.run.status == Status::Converged;
    let mut runs = vec![timed(scene, None, &mut follow)];
    let RunFollow { go_on, sized, .. } = follow;
    let mut unseen = RunFollow { go_on, states: &mut |_: &State| (), board: None, sized };
    while is_complete(&runs[0]) && runs.len() < repeats {
        let again = timed(scene, None, &mut unseen);
        if !is_complete(&again) {
            break;
        }
        runs.push(again);
    }
    let all = runs.iter().map(|r| RepeatRecord { wall_s: r.spent.wall_s, cpu_s: r.spent.cpu_s }).collect();
    runs.sort_by(|a, b| a.spent.cpu_s.total_cmp(&b.spent.cpu_s));
    (runs.swap_remove((runs.len() - 1) / 2), all)
}

/// Runs the scene once with derivatives; the time for these does not count.
pub(super) fn measure_with(
    scene: &Scene,
    recorder: SensitivityRecorder,
    mut follow: RunFollow,
) -> (Timed, Sensitivities) {
    let mut timed = timed(scene, Some(recorder), &mut follow);
    let sensitivities = timed.run.sensitivities.take().expect("the options ask for them");
    (timed, sensitivities)
}

/// Resets the peak of the resident set of the process. Only Linux counts it; `None` elsewhere.
pub(super) fn watch_memory() -> Option<()> {
    std::fs::write("/proc/self/clear_refs", "5").ok()
}

/// The largest resident set since [`watch_memory`] \[bytes\].
pub(super) fn largest_memory() -> Option<u64> {
    of_this_process("VmHWM:")
}

/// The present resident set \[bytes\].
pub(super) fn present_memory() -> Option<u64> {
    of_this_process("VmRSS:")
}

fn of_this_process(key: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix(key))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kilobytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parse_scene;
    use std::time::Duration;

    const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["10 mm", "10 mm", "10 mm"], divisions = [1, 1, 1] }
[laws.rubber]
law = "neo_hookean"
E = "1 MPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
[[probe]]
kind = "position"
region = "xmax"
"#;

    /// Only the first of several runs waits for memory, whichever of them is kept.
    #[test]
    fn waiting_for_memory_is_no_time_of_any_run() {
        let scene = parse_scene(SCENE).unwrap_or_else(|e| panic!("{e}"));
        let mut waits = vec![Duration::from_secs(2)];
        let mut sized = |_| {
            waits.pop().into_iter().for_each(std::thread::sleep);
            true
        };
        let (go_on, states): (&mut OnProgress, _) = (&mut |_| true, &mut |_: &State| ());
        let (kept, all) = measure(&scene, 3, RunFollow { go_on, states, board: None, sized: &mut sized });
        let walls: Vec<f64> = all.iter().map(|r| r.wall_s).chain([kept.spent.wall_s]).collect();
        assert!(all.len() == 3 && walls.iter().all(|s| *s > 0.0 && *s < 2.0), "{walls:?}");
    }
}
