//! The contents of the files that a thread has read, by their digests. A file that is edited meanwhile is read with different contents the next time.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Path → SHA-256 of every content with which it was read.
type Contents = BTreeMap<PathBuf, BTreeSet<String>>;

thread_local! {
    static READ: RefCell<Option<Contents>> = const { RefCell::new(None) };
}

/// Records which files this thread reads, until it is dropped.
pub struct Reading {
    /// The enclosing record, which continues when this one is dropped
    outer: Option<Contents>,
}

impl Reading {
    pub fn begin() -> Self {
        Self { outer: READ.with(|read| read.borrow_mut().replace(Contents::new())) }
    }

    /// The files that were read with contents different from `expected` (path → SHA-256) at any time since recording began.
    pub fn changed(&self, expected: &BTreeMap<PathBuf, String>) -> Vec<PathBuf> {
        READ.with(|read| {
            let read = read.borrow();
            let found = |path: &PathBuf| read.as_ref().and_then(|read| read.get(path));
            let differs =
                |(path, digest): &(&PathBuf, &String)| found(path).is_some_and(|all| all.iter().any(|d| d != *digest));
            expected.iter().filter(differs).map(|(path, _)| path.clone()).collect()
        })
    }
}

impl Drop for Reading {
    fn drop(&mut self) {
        READ.with(|read| *read.borrow_mut() = self.outer.take());
    }
}

/// Records that this thread has read a file with contents of this digest, which is computed only while reads are recorded.
pub(super) fn note(path: &Path, sha256: impl FnOnce() -> String) {
    READ.with(|read| {
        if let Some(read) = &mut *read.borrow_mut() {
            read.entry(path.into()).or_default().insert(sha256());
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::storage::{read, sha256};

    #[test]
    fn an_edit_that_is_taken_back_is_seen() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.csv");
        let write = |text: &str| std::fs::write(&path, text).expect("room");
        let expected = BTreeMap::from([(path.clone(), sha256("first")), (folder.path().join("b"), String::new())]);
        let look = || read(&path, 100).expect("there");
        write("other");
        look();
        let reading = Reading::begin();
        write("first");
        look();
        assert_eq!(reading.changed(&expected), [] as [PathBuf; 0]);
        {
            let inner = Reading::begin();
            write("second");
            look();
            assert_eq!(inner.changed(&expected), [path.as_path()]);
        }
        assert_eq!(reading.changed(&expected), [] as [PathBuf; 0]);
        look();
        write("first");
        look();
        assert_eq!(reading.changed(&expected), [path]);
    }
}
