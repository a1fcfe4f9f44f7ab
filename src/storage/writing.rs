//! The files that a thread has written, so that files that are no longer written can be removed later.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

thread_local! {
    static WRITTEN: RefCell<Option<BTreeSet<PathBuf>>> = const { RefCell::new(None) };
}

/// Records which files this thread writes, until it is dropped.
pub struct Writing {
    /// The enclosing record, which continues when this one is dropped
    outer: Option<BTreeSet<PathBuf>>,
}

impl Writing {
    pub fn begin() -> Self {
        Self { outer: WRITTEN.with(|written| written.borrow_mut().replace(BTreeSet::new())) }
    }

    /// The files written since recording began, by the paths used to write them.
    pub fn files(&self) -> BTreeSet<PathBuf> {
        WRITTEN.with(|written| written.borrow().clone().unwrap_or_default())
    }
}

impl Drop for Writing {
    fn drop(&mut self) {
        WRITTEN.with(|written| *written.borrow_mut() = self.outer.take());
    }
}

/// Records, if writes are recorded, that this thread has written a file, or has found it with the content that it would have written.
pub fn note(path: &Path) {
    WRITTEN.with(|written| {
        if let Some(written) = &mut *written.borrow_mut() {
            written.insert(path.into());
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::write;

    #[test]
    fn files_are_counted_while_account_is_kept() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [a, b, c] = ["a", "b", "c"].map(|name| folder.path().join(name));
        write(&a, b"before").expect("room");
        let writing = Writing::begin();
        write(&b, b"first").expect("room");
        {
            let inner = Writing::begin();
            write(&c, b"inside").expect("room");
            assert_eq!(inner.files(), BTreeSet::from([c]));
        }
        assert!(write(&folder.path().join("none/d"), b"x").is_err());
        assert_eq!(writing.files(), BTreeSet::from([b]));
    }
}
