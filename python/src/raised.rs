//! Exceptions of laws in Python, and the work that they end.

use crate::solve::Link;
use durometer::math::threads::locked;
use pyo3::prelude::*;
use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// The destination of the exceptions of the laws of one scene: the one run that is in progress with these laws.
#[derive(Default)]
pub struct Raised {
    link: Mutex<Option<Arc<Link>>>,
    /// Whether any law of the scene is in Python
    has_laws: AtomicBool,
    /// Whether the laws are no longer called once the work is stopped
    ends_laws: AtomicBool,
}

/// Work on a scene in progress: until this value is dropped, exceptions of the laws of the scene belong to this work.
pub struct Turn {
    pub raised: Arc<Raised>,
    before: Option<Arc<Raised>>,
}

impl Turn {
    /// Returns this work with the setting that laws are no longer called once it is stopped. This is for work that leaves no result when it is stopped,
    /// such as checks; a stopped run still evaluates the state that it has reached.
    #[must_use]
    pub fn with_ending_laws(self) -> Self {
        self.raised.ends_laws.store(true, Ordering::Relaxed);
        self
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        self.raised.ends_laws.store(false, Ordering::Relaxed);
        CURRENT.set(self.before.take());
        *locked(&self.raised.link) = None;
    }
}

thread_local! {
    static CURRENT: RefCell<Option<Arc<Raised>>> = const { RefCell::new(None) };
}

impl Raised {
    /// Begins work that makes its scenes itself, with this link.
    pub fn by(link: &Arc<Link>) -> Turn {
        let raised = Arc::new(Self::default());
        raised.begin(link).expect("no other work knows it")
    }

    /// Begins work on the scene: laws that this thread makes from now on belong to it. `None` if other work on the scene is in progress.
    pub fn begin(self: &Arc<Self>, link: &Arc<Link>) -> Option<Turn> {
        let mut held = locked(&self.link);
        if held.is_some() {
            return None;
        }
        *held = Some(link.clone());
        Some(Turn { raised: self.clone(), before: CURRENT.replace(Some(self.clone())) })
    }

    /// Assigns the current thread, which the library has started for some work and which ends with it, to this work: laws that it makes belong to the
    /// work.
    pub fn take_thread(self: &Arc<Self>) {
        CURRENT.set(Some(self.clone()));
    }

    /// Returns the exceptions of the scene for which this thread makes a law.
    pub fn of_a_law() -> Arc<Self> {
        let raised = CURRENT.with_borrow(Clone::clone).unwrap_or_default();
        raised.has_laws.store(true, Ordering::Relaxed);
        raised
    }

    /// Does work in this thread, and raises the first exception of its laws.
    pub fn raising<T>(self: &Arc<Self>, work: impl FnOnce() -> T) -> PyResult<T> {
        let link = Arc::default();
        let turn = self.begin(&link);
        let done = work();
        drop(turn);
        link.raised().map_or(Ok(done), Err)
    }

    /// Whether any law of the scene is of Python.
    pub fn has_laws(&self) -> bool {
        self.has_laws.load(Ordering::Relaxed)
    }

    /// Whether the laws are no longer called.
    pub fn has_ended_laws(&self) -> bool {
        let is_stopped = |link: &Arc<Link>| link.stop.load(Ordering::Relaxed);
        self.ends_laws.load(Ordering::Relaxed) && locked(&self.link).as_ref().is_some_and(is_stopped)
    }

    /// Ends the run with an exception.
    pub fn raise(&self, why: PyErr) {
        let link = locked(&self.link).clone();
        if let Some(link) = link {
            link.fail(why);
        }
    }
}
