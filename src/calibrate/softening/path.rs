//! The path of loading in a cyclic table: rows of the first loading, and the largest stretch before each other row.

use super::error::SofteningFitError;
use super::rows::Row;
use crate::calibrate::{Experiment, Mode, Sample};

/// A row is on the first loading as long as |ln λ| is not below its largest value before by more than this part of the largest of all \[–\]:
/// noise of the strain is no unloading
const SAME: f64 = 0.005;

/// Rows of a cyclic test of one mode.
pub struct CyclicPath {
    /// On the first loading, of every specimen
    pub virgin: Vec<Sample>,
    /// Below the largest stretch before them, with that stretch
    pub softened: Vec<Row>,
}

/// Divides the rows of a table, in their order.
pub fn divide(experiment: &Experiment) -> Result<CyclicPath, SofteningFitError> {
    let file = || experiment.file.clone();
    if experiment.modes().contains(&Mode::Biaxial) {
        return Err(SofteningFitError::Biaxial { file: file() });
    }
    let amount = |s: &Sample| s.stretch.ln();
    let largest = experiment.samples.iter().map(|s| amount(s).abs()).fold(0.0, f64::max);
    for mode in experiment.modes() {
        let own = || experiment.samples.iter().filter(|s| s.mode == mode).map(amount);
        let both = own().any(|a| a > 0.1 * largest) && own().any(|a| a < -0.1 * largest);
        if both {
            return Err(SofteningFitError::BothSides { file: file(), mode });
        }
    }
    let mut path = CyclicPath { virgin: vec![], softened: vec![] };
    // Largest stretch so far, of each specimen and mode
    let mut peaks: Vec<(usize, Mode, f64)> = vec![];
    for s in &experiment.samples {
        let k = peaks.iter().position(|p| (p.0, p.1) == (s.specimen, s.mode));
        let k = k.unwrap_or_else(|| {
            peaks.push((s.specimen, s.mode, 1.0));
            peaks.len() - 1
        });
        let peak = &mut peaks[k].2;
        if amount(s).abs() >= peak.ln().abs() - SAME * largest {
            path.virgin.push(*s);
        } else if s.is_informative() {
            path.softened.push(Row { sample: *s, peak: *peak });
        }
        if amount(s).abs() > peak.ln().abs() {
            *peak = s.stretch;
        }
    }
    Ok(path)
}
