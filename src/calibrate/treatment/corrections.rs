//! Corrections of the data points on request: zero of the stress and toe.
//!
//! *Zero*: the mean stress of the first N data points is subtracted from every stress. *Toe*: the slack of a test piece before it carries load. The
//! least-squares line through the data points from the first of three in succession above the noise level p to the last one below 3p reaches zero
//! stress at the strain e₀, which is subtracted from every strain; data points before the line are left out. Source: ASTM D638-14, annex A1, which
//! takes the steepest part: for rubbers that is the start or the end.
//!
//! Limits: the curve of a softening rubber is not straight, which shifts e₀ by −3(p/E)² (with the strain p/E at the level, for a neo-Hookean law).
//!
//! All data points of a curve share the errors of its zero and its toe. The mean of N data points has the half-width t s/√N with their standard
//! deviation s and N − 1 degrees of freedom. For a single data point the noise of the whole curve is used, limited by the scatter about the fitted
//! law, because the noise estimate of a sparse curve contains its curvature. An error of the zero shifts the line of the toe together with the data.

use super::condense;
use super::group::Group;
use super::toe_line::ToeLine;
use crate::calibrate::constant_format::stress_text;
use crate::calibrate::intake::piece::CorrectionError;
use crate::calibrate::sample::sides;
use crate::calibrate::solve::noise;
use crate::calibrate::{AuditEntry, AuditKind, FitError, Mode, Sample, SharedError};
use crate::math::statistics::{deviation, t_quantile};
use crate::math::units::{self, Dimension};
use std::collections::HashSet;

/// Number of successive data points above the level that begin the line, and least number of data points of a line
const BEGIN: usize = 3;
/// Multiple of the level at which the line ends
const END: f64 = 3.0;
/// Ratio of a 95 % half-width of a normal error to its standard deviation
const NORMAL: f64 = 1.96;

/// The requested corrections.
#[derive(Clone, Copy, Debug)]
pub struct Corrections<'a> {
    /// Number of first data points whose mean stress becomes zero
    pub zero: Option<usize>,
    /// Noise level, such as `2 kPa`
    pub toe: Option<&'a str>,
}

/// Data points after their corrections.
#[derive(Clone, Debug, Default)]
pub struct Corrected {
    pub samples: Vec<Sample>,
    pub log: Vec<AuditEntry>,
    /// Specimen and error of each correction
    pub errors: Vec<(usize, CorrectionError)>,
}

impl Corrections<'_> {
    /// Applies the zero of each group and the toe of each side of rest to the data points of a table.
    pub fn applied(
        self,
        rows: &[Sample],
        (groups, sides): (&[Group], &[Group]),
        file: &str,
    ) -> Result<Corrected, FitError> {
        let mut all = Corrected { samples: rows.to_vec(), ..Corrected::default() };
        if let Some(n) = self.zero {
            for group in groups {
                zero(&mut all, group, n, file)?;
            }
        }
        if let Some(text) = self.toe {
            let refuse = |reason: String| FitError::Toe { file: file.into(), level: text.into(), reason };
            let level = units::parse(text, Dimension::PRESSURE).map_err(|e| refuse(e.to_string()))?;
            if !(level > 0.0 && level.is_finite()) {
                return Err(refuse("the noise level must be above zero".into()));
            }
            // A shift may move data points near rest to the other side
            let lines = |group: &Group| group.of(&all.samples).iter().map(|s| s.line).collect::<HashSet<u64>>();
            let lines: Vec<HashSet<u64>> = sides.iter().map(lines).collect();
            for (group, lines) in sides.iter().zip(&lines) {
                shift(&mut all, group, lines, level).map_err(refuse)?;
            }
        }
        Ok(all)
    }
}

/// Subtracts the mean stress of the first data points; in a biaxial test for each direction separately.
fn zero(all: &mut Corrected, group: &Group, n: usize, file: &str) -> Result<(), FitError> {
    let samples = &mut all.samples;
    let own = group.places(samples);
    let directions = if group.mode == Mode::Biaxial { 2 } else { 1 };
    if n == 0 || 2 * n * directions > own.len() {
        return Err(FitError::Zero { file: file.into(), mode: group.mode, asked: n, rows: own.len() / directions });
    }
    let (mut offsets, mut lines, mut half_width) = (vec![], vec![], 0.0_f64);
    for direction in 0..directions {
        let part: Vec<usize> = own.iter().skip(direction).step_by(directions).copied().collect();
        let rows: Vec<Sample> = part.iter().map(|k| samples[*k]).collect();
        let offset = rows[..n].iter().map(|s| s.stress).sum::<f64>() / n as f64;
        // Later steps cannot tell the directions of data points apart
        half_width = half_width.max(error_of_zero(&rows, n));
        lines = part[..n].iter().map(|k| samples[*k].line).collect();
        part.iter().for_each(|k| samples[*k].stress -= offset);
        offsets.push(format!("{offset:.1} Pa"));
    }
    let message = format!(
        "the mean stress of the first {n} data points, {}, was subtracted from every {} stress",
        offsets.join(" and "),
        group.name
    );
    all.log.push(AuditEntry::new(AuditKind::Changed, message, lines));
    // Means of neighbours scatter less than the data point whose stress was subtracted
    let bounded = n == 1 && (half_width.is_infinite() || own.len() <= condense::MOST);
    all.add(group, CorrectionError { bounded, ..CorrectionError::of(SharedError::Zeroing, group.mode, half_width) });
    Ok(())
}

/// Half-width of the 95 % interval of the mean stress of the first n data points \[Pa\]; infinite for a single data point of a curve that shows no
/// noise.
fn error_of_zero(rows: &[Sample], n: usize) -> f64 {
    let (strains, stresses): (Vec<f64>, Vec<f64>) = rows.iter().map(|s| (s.stretch, s.stress)).unzip();
    match n.checked_sub(1).filter(|free| *free > 0) {
        Some(free) => t_quantile(0.95, free) * deviation(&stresses[..n]) / (n as f64).sqrt(),
        None => NORMAL * noise::of_curve(&strains, &stresses).unwrap_or(f64::INFINITY),
    }
}

impl Corrected {
    /// Adds the error of a correction of a group.
    fn add(&mut self, group: &Group, error: CorrectionError) {
        self.errors.push((group.specimen, error));
    }
}

/// Shifts the strain of a group by the strain at which the line reaches zero stress, and drops the data points before the line.
fn shift(all: &mut Corrected, group: &Group, lines: &HashSet<u64>, level: f64) -> Result<(), String> {
    let (mode, samples) = (group.mode, &mut all.samples);
    if mode == Mode::Biaxial {
        return Err("a biaxial test has two strains, and no single toe".into());
    }
    let has = |s: &Sample| s.specimen == group.specimen && s.mode == mode && lines.contains(&s.line);
    let mut own: Vec<Sample> = samples.iter().filter(|s| has(s)).copied().collect();
    if sides(&own) == [true, true] {
        return Err(format!("the {mode} test goes to both sides of rest, and has no single toe; leave it out"));
    }
    let amount = |s: &Sample| mode.strain(s.stretch).abs();
    // A table may list its data points towards rest
    let most = own.iter().map(amount).fold(0.0, f64::max);
    if own.first().is_some_and(|s| amount(s) > 0.5 * most) && own.last().is_some_and(|s| amount(s) < 0.5 * most) {
        own.reverse();
    }
    // Compression has the opposite sign
    let side = own.iter().map(|s| mode.strain(s.stretch)).sum::<f64>().signum();
    let above = |s: &Sample| side * s.stress >= level;
    let Some(first) = own.windows(BEGIN).position(|w| w.iter().all(above)) else {
        return Err(format!("no {BEGIN} successive {} data points lie above it; give a lower level", group.name));
    };
    let line = own[first..].iter().take_while(|s| side * s.stress < END * level).count().max(BEGIN);
    let points: Vec<(f64, f64)> = own[first..first + line].iter().map(|s| (mode.strain(s.stretch), s.stress)).collect();
    let Some(found) = ToeLine::through(&points) else {
        return Err(format!(
            "the stress does not rise with the strain in the {} {} data points after it is reached",
            points.len(),
            group.name
        ));
    };
    let ToeLine { origin, slope, half_width } = found;
    let (from, to) = (own[first].line, own[first + line - 1].line);
    let gone: Vec<u64> = own[..first].iter().map(|s| s.line).collect();
    let moved = samples.iter_mut().filter(|s| has(s));
    moved.for_each(|s| s.stretch = mode.stretch(mode.strain(s.stretch) - origin));
    samples.retain(|s| !has(s) || !gone.contains(&s.line));
    let message = format!(
        "{} strain was shifted by {:+.6}: the line through lines {from} to {to} ({} data points, slope {}) reaches zero stress at {origin:.6}",
        group.name,
        -origin,
        points.len(),
        stress_text(slope)
    );
    all.log.push(AuditEntry::new(AuditKind::Changed, message, vec![]));
    if !gone.is_empty() {
        let message = format!("{} data points of the toe, before the line", group.name);
        all.log.push(AuditEntry::new(AuditKind::LeftOut, message, gone));
    }
    let line = points.iter().map(|(strain, _)| strain - origin).collect();
    let of_curve = CorrectionError::of(SharedError::Toe, mode, half_width);
    all.add(group, CorrectionError { tension: group.tension(), strain_per_stress: slope.recip(), line, ..of_curve });
    Ok(())
}
