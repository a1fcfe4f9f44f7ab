//! The parts of a paper that follow from a result: `paper/` with the methods, the references, and a document of the generated parts.

pub mod law;
mod paragraph;
mod references;
mod sample;

use crate::report::{ReportError, files};
pub use paragraph::Paragraph;
use references::Reference;
pub use sample::Parts;
use std::collections::BTreeSet;
use std::path::Path;

/// Content of the folder `paper`.
pub struct Paper<'a> {
    pub paragraphs: Vec<Paragraph>,
    /// Versions of the program that computed the results
    pub versions: BTreeSet<&'a str>,
    /// Time of the last of these runs \[s since 1970\], if known
    pub last_run_s: Option<u64>,
    pub parts: Parts<'a>,
}

impl Paper<'_> {
    /// Writes `methods.tex`, `methods.md`, `references.bib` and `paper.tex` into `dir`.
    ///
    /// # Errors
    /// Returns an error if a folder or file cannot be written.
    pub fn write(&self, dir: &Path) -> Result<(), ReportError> {
        files::folder(dir)?;
        let latex: String = self.paragraphs.iter().map(Paragraph::latex).collect();
        files::write(&dir.join("methods.tex"), latex.as_bytes())?;
        let markdown: Vec<String> = self.paragraphs.iter().map(Paragraph::markdown).collect();
        files::write(&dir.join("methods.md"), markdown.join("\n").as_bytes())?;
        files::write(&dir.join("references.bib"), self.bibliography().as_bytes())?;
        files::write(&dir.join("paper.tex"), sample::document(&self.parts).as_bytes())
    }

    /// Every cited reference once, sorted by key, and the program.
    fn bibliography(&self) -> String {
        let cited: BTreeSet<&str> = self.paragraphs.iter().flat_map(Paragraph::references).map(|r| r.key).collect();
        let entries = cited.iter().filter_map(|key| Reference::of_key(key)).map(|r| r.entry.as_str());
        let entries: Vec<&str> = entries.collect();
        format!("{}\n{}", self.program(), entries.join("\n"))
    }

    /// The entry of the program, with the version that computed the results and the year of the last run.
    fn program(&self) -> String {
        let versions: Vec<&str> = self.versions.iter().copied().filter(|v| !v.is_empty()).collect();
        let version = if versions.is_empty() { "unknown".into() } else { versions.join(", ") };
        // Mean year of the Gregorian calendar; the first hours of a year may count as the previous one
        let year = |seconds: u64| 1970 + (seconds as f64 / (365.2425 * 86_400.0)) as u64;
        let year = self.last_run_s.map_or(String::new(), |s| format!("  year = {{{}}},\n", year(s)));
        format!(
            "@misc{{durometer,\n  title = {{Durometer: mesh-convergence studies, hyperelastic calibration and paper figures for soft-robot simulation}},\n{year}  note = {{Version {version}}},\n}}\n"
        )
    }
}

/// Returns the paragraph that names the program and what is known of its builds.
pub fn software(builds: &[String]) -> Paragraph {
    Paragraph::new("Software").text("Durometer").cite_program().text(format!(" {}.", builds.join("; ")))
}
