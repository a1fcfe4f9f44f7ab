//! The time series of a run that goes on.

use crate::scene::Scene;
use crate::scene::output::ScheduleSpec;
use crate::storage;
use crate::study::store::csv_text::{header, line};
use crate::study::store::folder::{StoreError, unwritable};
use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The rows of a run while it goes on: `<name>.partial.csv`, which is locked as long as this value lives. A run that is killed leaves it; one that has written its files removes it.
pub struct PartialSeries {
    path: PathBuf,
    file: File,
    schedule: ScheduleSpec,
    /// Time of the last row \[s\]
    past: Option<f64>,
    failure: Option<StoreError>,
}

impl PartialSeries {
    /// Refuses a name under which another process runs.
    pub fn check_free(dir: &Path, name: &str) -> Result<(), StoreError> {
        let path = file_of(dir, name);
        match storage::open(&path).map(|file| file.try_lock()) {
            Ok(Err(TryLockError::WouldBlock)) => {
                let reason = "another process runs a scene of this name there".into();
                Err(StoreError::Unwritable { path, reason })
            }
            // A file system without locks tells nothing
            _ => Ok(()),
        }
    }

    /// Creates the file with the names of the columns.
    pub fn create(dir: &Path, name: &str, scene: &Scene) -> Result<Self, StoreError> {
        Self::check_free(dir, name)?;
        let path = file_of(dir, name);
        let schedule = scene.spec.output.series.clone().unwrap_or_default();
        // A link of this name is replaced, not followed
        storage::write(&path, header(scene.columns().into_iter()).as_bytes())
            .and_then(|()| File::options().append(true).open(&path))
            // In Windows a lock would keep readers off
            .inspect(|file| drop(cfg!(unix).then(|| file.try_lock())))
            .map(|file| Self { path: path.clone(), file, schedule, past: None, failure: None })
            .map_err(|e| unwritable(&path, &e))
    }

    /// Appends a row, if it is due. False where it cannot be written: what follows could not be either.
    pub fn add(&mut self, row: &[f64]) -> bool {
        let due = self.schedule.due(self.past, row[0]);
        self.past = Some(row[0]);
        if due && self.failure.is_none() {
            let written = self.file.write_all(line(row).as_bytes());
            self.failure = written.err().map(|e| unwritable(&self.path, &e));
        }
        self.failure.is_none()
    }

    /// The file of the rows.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The failure that ended the rows, if one did.
    pub fn failure(&mut self) -> Option<StoreError> {
        self.failure.take()
    }

    /// Removes the file, when all that the run writes under this name is written: until then no other process takes the name.
    pub fn remove(self) {
        std::fs::remove_file(&self.path).ok();
    }
}

fn file_of(dir: &Path, name: &str) -> PathBuf {
    dir.join(format!("{name}.partial.csv"))
}
