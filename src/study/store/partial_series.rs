//! The time series of a run in progress.

use crate::scene::Scene;
use crate::scene::output::ScheduleSpec;
use crate::storage;
use crate::study::store::csv_text::{header, line};
use crate::study::store::folder::{StoreError, unwritable};
use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The exclusive right to write the files of a name in a folder, as long as this value lives: the lock on a file that remains there and is never
/// replaced.
pub struct NameLock(#[expect(dead_code, reason = "it is open as long as this value lives")] File);

impl NameLock {
    /// Acquires the right; an error if another process has it.
    pub fn take(dir: &Path, name: &str) -> Result<Self, StoreError> {
        let path = dir.join(format!(".{name}.lock"));
        // Windows cannot lock a file that is opened only for appending
        let file = File::options().create(true).read(true).append(true).open(&path);
        let file = file.map_err(|e| unwritable(&path, &e))?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                let reason = "another process runs a scene of this name there".into();
                Err(StoreError::Unwritable { path: file_of(dir, name), reason })
            }
            // A file system without locks cannot tell
            _ => Ok(Self(file)),
        }
    }
}

/// The rows of a run in progress: `<name>.partial.csv`. A killed run leaves it behind; a run that has written its files removes it.
pub struct PartialSeries {
    path: PathBuf,
    file: File,
    schedule: ScheduleSpec,
    /// Time of the last row \[s\]
    past: Option<f64>,
    failure: Option<StoreError>,
}

impl PartialSeries {
    /// Creates the file with the names of the columns in its first line.
    pub fn create(dir: &Path, name: &str, scene: &Scene) -> Result<Self, StoreError> {
        let path = file_of(dir, name);
        let schedule = scene.spec.output.series.clone().unwrap_or_default();
        // A symbolic link of this name is replaced, not followed
        storage::write(&path, header(scene.columns().into_iter()).as_bytes())
            .and_then(|()| File::options().append(true).open(&path))
            .map(|file| Self { path: path.clone(), file, schedule, past: None, failure: None })
            .map_err(|e| unwritable(&path, &e))
    }

    /// Appends a row if it is due. Returns false once a row could not be written: later rows could not be written either.
    pub fn add(&mut self, row: &[f64]) -> bool {
        let due = self.schedule.due(self.past, row[0]);
        self.past = Some(row[0]);
        if due && self.failure.is_none() {
            let written = self.file.write_all(line(row).as_bytes());
            self.failure = written.err().map(|e| unwritable(&self.path, &e));
        }
        self.failure.is_none()
    }

    /// Path of the file of the rows.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The failure that ended the rows, if one did.
    pub fn failure(&mut self) -> Option<StoreError> {
        self.failure.take()
    }

    /// Removes the file, once everything that the run writes under this name has been written.
    pub fn remove(self) {
        std::fs::remove_file(&self.path).ok();
    }
}

fn file_of(dir: &Path, name: &str) -> PathBuf {
    dir.join(format!("{name}.partial.csv"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_has_one_writer_at_a_time() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let take = |name: &str| NameLock::take(folder.path(), name);
        let first = take("scene").expect("nobody else");
        let refused = take("scene").err().expect("it is taken").to_string();
        assert!(refused.contains("another process runs a scene of this name"), "{refused}");
        take("other").expect("nobody else");
        drop(first);
        take("scene").expect("it is free again");
    }
}
