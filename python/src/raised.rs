//! Exceptions of laws in Python, and the work that they end.

use crate::solve::Link;
use durometer::math::threads::locked;
use pyo3::prelude::*;
use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// Where the exceptions of the laws of one scene go: to the one run that is under way with these laws.
#[derive(Default)]
pub struct Raised {
    link: Mutex<Option<Arc<Link>>>,
    /// Whether any law of the scene is of Python
    has_laws: AtomicBool,
    /// Whether the laws are asked no more once the work is stopped
    ends_laws: AtomicBool,
}

/// Some work on a scene, from now on until it is dropped: exceptions of the laws of the scene are those of this work.
pub struct Turn {
    pub raised: Arc<Raised>,
    before: Option<Arc<Raised>>,
}

impl Turn {
    /// The same, whose laws are asked no more once it is stopped: for work of which nothing is left then, such as checks. A run still evaluates what it
    /// has reached.
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
    /// Those of work on scenes that it makes itself, with this link.
    pub fn by(link: &Arc<Link>) -> Turn {
        let raised = Arc::new(Self::default());
        raised.begin(link).expect("no other work knows it")
    }

    /// Work on the scene begins: laws that this thread makes from now on belong to it. None where other work on the scene is under way.
    pub fn begin(self: &Arc<Self>, link: &Arc<Link>) -> Option<Turn> {
        let mut held = locked(&self.link);
        if held.is_some() {
            return None;
        }
        *held = Some(link.clone());
        Some(Turn { raised: self.clone(), before: CURRENT.replace(Some(self.clone())) })
    }

    /// Takes in a thread that the library has started for some work, and that ends with it: laws that it makes belong to this work.
    pub fn take_thread(self: &Arc<Self>) {
        CURRENT.set(Some(self.clone()));
    }

    /// Those of the scene for which this thread makes a law.
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

    /// Whether the laws are asked no more.
    pub fn has_ended_laws(&self) -> bool {
        let is_stopped = |link: &Arc<Link>| link.stop.load(Ordering::Relaxed);
        self.ends_laws.load(Ordering::Relaxed) && locked(&self.link).as_ref().is_some_and(is_stopped)
    }

    /// Ends the run by an exception.
    pub fn raise(&self, why: PyErr) {
        let link = locked(&self.link).clone();
        if let Some(link) = link {
            link.fail(why);
        }
    }
}
