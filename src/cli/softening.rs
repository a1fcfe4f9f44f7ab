//! Results of `durometer fit --softening`, next to those of the law.

use super::files;
use durometer::calibrate::softening::SofteningFit;
use durometer::report::ReportError;
use std::error::Error;
use std::path::Path;

/// Writes `mullins.toml`, `mullins.json` and a page into a folder of their own; returns the error of a figure that could not be written.
pub fn write(dir: &Path, fit: &SofteningFit) -> Result<Option<ReportError>, Box<dyn Error>> {
    files::make_folder(dir)?;
    fit.write_softening(&dir.join("mullins.toml"))?;
    fit.write_json(&dir.join("mullins.json"))?;
    Ok(ReportError::of_figure(durometer::report::service_fit::write(dir))?)
}
