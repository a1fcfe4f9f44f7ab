//! Running mesher processes and the work for which they run: they can be ended all together, or for one piece of work.

use crate::math::threads::locked;
use crate::subprocess::kill;
use std::cell::Cell;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Running mesher processes and their owners.
static RUNNING: Mutex<Vec<(u32, MesherOwner)>> = Mutex::new(vec![]);

thread_local! {
    static CURRENT: Cell<MesherOwner> = const { Cell::new(MesherOwner(0)) };
}

/// A piece of work that may start mesher processes, which can be ended independently of those of other work.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct MesherOwner(usize);

impl Default for MesherOwner {
    /// Creates an owner different from all others.
    fn default() -> Self {
        static MADE: AtomicUsize = AtomicUsize::new(0);
        Self(MADE.fetch_add(1, Ordering::Relaxed) + 1)
    }
}

impl MesherOwner {
    /// Returns the owner of the work that this thread does, to be passed to the threads that it starts.
    pub fn current() -> Self {
        CURRENT.get()
    }

    /// Marks this thread as doing a part of the work, until the returned value is dropped.
    pub fn begin(self) -> MesherTurn {
        MesherTurn { before: CURRENT.replace(self) }
    }

    /// Ends the processes of this work. Their meshes fail.
    pub fn end_meshers(self) {
        end(|owner| owner == self);
    }
}

/// A period in which a thread does a part of some work.
pub struct MesherTurn {
    before: MesherOwner,
}

impl Drop for MesherTurn {
    fn drop(&mut self) {
        CURRENT.set(self.before);
    }
}

/// A process that [`end_meshers`] can end.
pub(super) struct Running(u32);

impl Running {
    pub(super) fn new(pid: u32) -> Self {
        locked(&RUNNING).push((pid, MesherOwner::current()));
        Self(pid)
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        locked(&RUNNING).retain(|(pid, _)| *pid != self.0);
    }
}

/// Ends all mesher processes started by this process: for a program that is told to stop. Their meshes fail.
pub fn end_meshers() {
    end(|_| true);
}

fn end(is_meant: impl Fn(MesherOwner) -> bool) {
    // Processes are waited for only after they have left the list, so that their ids belong to no other process
    locked(&RUNNING).iter().filter(|(_, owner)| is_meant(*owner)).for_each(|(pid, _)| kill(*pid));
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::process::{Child, Command};

    /// Starts a process that would keep running, for some work.
    fn started(owner: MesherOwner) -> (Child, Running) {
        let child = Command::new("sleep").arg("60").spawn().expect("every system can sleep");
        let _turn = owner.begin();
        let running = Running::new(child.id());
        (child, running)
    }

    #[test]
    fn work_that_ends_leaves_the_meshers_of_others() {
        let [one, other] = [(); 2].map(|()| MesherOwner::default());
        let (mut ended, of_one) = started(one);
        let (mut left, of_other) = started(other);
        one.end_meshers();
        drop(of_one);
        assert!(!ended.wait().expect("it was started").success());
        assert!(left.try_wait().expect("it was started").is_none(), "it still runs");
        other.end_meshers();
        drop(of_other);
        assert!(!left.wait().expect("it was started").success());
        assert_eq!(MesherOwner::current(), MesherOwner(0));
    }
}
