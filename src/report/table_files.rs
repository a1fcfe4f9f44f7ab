//! Files of a table: CSV and LaTeX.

use crate::report::error::ReportError;
use crate::report::files::write;
use crate::report::latex;
use crate::report::table::Table;
use std::path::Path;

impl Table {
    /// Writes `<name>.csv` and `<name>.tex` into `dir`.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn save(&self, dir: &Path) -> Result<(), ReportError> {
        write(&dir.join(format!("{}.csv", self.name)), self.csv().as_bytes())?;
        write(&dir.join(format!("{}.tex", self.name)), latex::table(self).as_bytes())
    }
}
