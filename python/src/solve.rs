//! Long-running work of the library in a thread of its own: without the interpreter lock, with progress, and ended by Ctrl-C.

use crate::threads;
use durometer::math::threads::{alone, is_alone, locked};
use durometer::mesh::generate::MesherOwner;
use durometer::scene::Progress;
use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Interval at which Python is checked for an interrupt, and progress is reported.
const LOOK: Duration = Duration::from_millis(50);
/// Stack size of the working thread \[bytes\], that of a typical main thread.
const STACK: usize = 8 << 20;

/// Connects work with the Python code that waits for it.
#[derive(Default)]
pub struct Link {
    /// Set to end the work
    pub stop: Arc<AtomicBool>,
    now: Mutex<Option<Progress>>,
    failure: Mutex<Option<PyErr>>,
    /// Owner of the meshers that the work starts
    meshers: MesherOwner,
}

impl Link {
    /// Creates a link whose stop flag is the given one, which the work already checks; the flag is cleared.
    pub fn by(stop: Arc<AtomicBool>) -> Self {
        stop.store(false, Ordering::Relaxed);
        Self { stop, ..Self::default() }
    }

    /// Records the progress of the work; returns false if the work is to end.
    pub fn progress(&self, now: Progress) -> bool {
        *locked(&self.now) = Some(now);
        !self.stop.load(Ordering::Relaxed)
    }

    /// Ends the work with an exception; the first exception is the one that is raised.
    pub fn fail(&self, why: PyErr) {
        let mut first = locked(&self.failure);
        let later = if first.is_some() { Some(why) } else { first.replace(why) };
        // Dropping an exception may run Python code, which may wait for a thread that waits for the lock
        drop(first);
        drop(later);
        self.stop.store(true, Ordering::Relaxed);
        self.meshers.end_meshers();
    }

    /// Takes the exception that has ended the work.
    pub fn raised(&self) -> Option<PyErr> {
        locked(&self.failure).take()
    }

    /// Ends the line of a progress bar that follows the work.
    fn close(&self, follower: Option<&Bound<'_, PyAny>>) {
        let closed = |follower: &Bound<'_, PyAny>| {
            follower.py().import("durometer._progress")?.call_method1("close", (follower,)).map(|_| ())
        };
        follower.map_or(Ok(()), closed).unwrap_or_else(|why| self.fail(why));
    }

    /// Calls the user's function that follows the work.
    fn tell(&self, follower: Option<&Bound<'_, PyAny>>) {
        let now = locked(&self.now).take();
        if let (Some(Progress { t, end }), Some(follower)) = (now, follower)
            && let Err(why) = follower.call1((t, end))
        {
            self.fail(why);
        }
    }
}

/// Does work in a thread of its own, while this thread regularly checks Python for interrupts. `follower` is called with the work done and the total
/// work.
pub fn apart<T: Send>(
    py: Python<'_>,
    follower: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Arc<Link>) -> T + Send,
) -> PyResult<T> {
    followed(py, Link::default(), follower, work)
}

/// Does work in a thread of its own as [`apart`] does, with the given link.
pub fn followed<T: Send>(
    py: Python<'_>,
    link: Link,
    follower: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Arc<Link>) -> T + Send,
) -> PyResult<T> {
    let (done, raised) = ended(py, link, follower, work)?;
    raised.map_or(Ok(done), Err)
}

/// Does work in a thread of its own that returns a partial result when an exception ends it. Returns the result of the work, and the exception.
pub fn ended<T: Send>(
    py: Python<'_>,
    link: Link,
    follower: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Arc<Link>) -> T + Send,
) -> PyResult<(T, Option<PyErr>)> {
    threads::check_fork()?;
    let (link, is_alone) = (Arc::new(link), is_alone());
    let done = std::thread::scope(|scope| {
        let (sender, ended) = channel::<()>();
        let worker = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, {
            let link = &link;
            move || {
                // Dropped at the end, also if the work panics
                let _sender = sender;
                let _turn = link.meshers.begin();
                if is_alone { alone(|| work(link)) } else { work(link) }
            }
        })?;
        let mut ended = Some(ended);
        while let Some(receiver) = ended.take() {
            let (waited, receiver) = py.detach(move || (receiver.recv_timeout(LOOK), receiver));
            link.tell(follower);
            py.check_signals().unwrap_or_else(|why| link.fail(why));
            ended = (waited == Err(RecvTimeoutError::Timeout)).then_some(receiver);
        }
        Ok::<_, PyErr>(py.detach(|| worker.join()))
    })?;
    link.close(follower);
    match (done, link.raised()) {
        (Ok(done), raised) => Ok((done, raised)),
        (Err(_), Some(why)) => Err(why),
        (Err(panic), None) => resume_unwind(panic),
    }
}
