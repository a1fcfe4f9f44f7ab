//! The path of loading in a cyclic table: rows of the first loading, and the largest stretch before each other row.

use super::error::SofteningFitError;
use super::rows::Row;
use crate::calibrate::sample::sides;
use crate::calibrate::{Experiment, Mode, Sample, StretchRange};

/// A row is on the first loading as long as |ln λ| is below its largest previous value by no more than this share of the overall largest value \[–\]:
/// noise of the strain is not unloading
const SAME: f64 = 0.005;

/// Rows of a cyclic test.
pub struct CyclicPath {
    /// Rows on the first loading, of every specimen
    pub virgin: Vec<Sample>,
    /// Rows below the largest previous stretch, with that stretch
    pub softened: Vec<Row>,
    /// Rows on the first loading of other modes or outside the range, which the law predicts
    pub other: Vec<Sample>,
}

/// Divides the rows of a table, in their order. Only rows of the fitted modes and within the range count; for softened rows the largest previous
/// stretch must be in the range too.
pub fn divide(experiment: &Experiment, modes: &[Mode], range: StretchRange) -> Result<CyclicPath, SofteningFitError> {
    let file = || experiment.file.clone();
    if modes.contains(&Mode::Biaxial) {
        return Err(SofteningFitError::Biaxial { file: file() });
    }
    let is_fitted = |s: &&Sample| modes.contains(&s.mode) && range.contains(s.stretch);
    let fitted = || experiment.samples.iter().filter(is_fitted);
    for mode in modes {
        if sides(fitted().filter(|s| s.mode == *mode)) == [true, true] {
            return Err(SofteningFitError::BothSides { file: file(), mode: *mode });
        }
    }
    let amount = |stretch: f64| stretch.ln().abs();
    let largest = fitted().map(|s| amount(s.stretch)).fold(0.0, f64::max);
    let mut path = CyclicPath { virgin: vec![], softened: vec![], other: vec![] };
    // Largest stretch so far, for each specimen and mode
    let mut peaks: Vec<(usize, Mode, f64)> = vec![];
    for s in &experiment.samples {
        let k = peaks.iter().position(|p| (p.0, p.1) == (s.specimen, s.mode));
        let k = k.unwrap_or_else(|| {
            peaks.push((s.specimen, s.mode, 1.0));
            peaks.len() - 1
        });
        let peak = &mut peaks[k].2;
        if amount(s.stretch) >= amount(*peak) - SAME * largest {
            let to = if is_fitted(&s) { &mut path.virgin } else { &mut path.other };
            to.push(*s);
        } else if s.is_informative() && is_fitted(&s) && range.contains(*peak) {
            path.softened.push(Row { sample: *s, peak: *peak });
        }
        if amount(s.stretch) > amount(*peak) {
            *peak = s.stretch;
        }
    }
    Ok(path)
}
