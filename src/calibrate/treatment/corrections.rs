//! Corrections of the data points on request: zero of the stress and toe.
//!
//! *Zero*: the mean stress of the first N data points is subtracted from every stress. *Toe*: the slack of a test piece before it carries. The
//! straight line of least squares through the data points from the first of three in succession above the noise level p to the last one below 3p
//! reaches zero stress at the strain e₀, which is subtracted from every strain; data points before the line are left out. Source: ASTM D638-14, annex
//! A1, which takes the steepest part: rubbers are steepest at the start or at the end.
//!
//! Limits: a rubber that softens curves the line, which moves e₀ by −3(p/E)² (p/E the strain at the level, Neo-Hookean law).

use super::group::Group;
use crate::calibrate::constant_format::stress_text;
use crate::calibrate::{AuditEntry, AuditKind, FitError, Mode, Sample};
use crate::math::units::{self, Dimension};

/// Data points above the level that begin the line, and data points of a line
const BEGIN: usize = 3;
/// The line ends at this multiple of the level
const END: f64 = 3.0;

/// The corrections that are made.
#[derive(Clone, Copy, Debug)]
pub struct Corrections<'a> {
    /// Number of first data points whose mean stress becomes zero
    pub zero: Option<usize>,
    /// Noise level, such as `2 kPa`
    pub toe: Option<&'a str>,
}

impl Corrections<'_> {
    /// The data points of a table with the zero and the toe of each group.
    pub fn applied(
        self,
        rows: &[Sample],
        groups: &[Group],
        file: &str,
    ) -> Result<(Vec<Sample>, Vec<AuditEntry>), FitError> {
        let mut samples = rows.to_vec();
        let mut log = vec![];
        if let Some(n) = self.zero {
            for group in groups {
                log.push(zero(&mut samples, group, n, file)?);
            }
        }
        if let Some(text) = self.toe {
            let refuse = |reason: String| FitError::Toe { file: file.into(), level: text.into(), reason };
            let level = units::parse(text, Dimension::PRESSURE).map_err(|e| refuse(e.to_string()))?;
            if !(level > 0.0 && level.is_finite()) {
                return Err(refuse("the noise level must be above zero".into()));
            }
            for group in groups {
                log.extend(shift(&mut samples, group, level).map_err(refuse)?);
            }
        }
        Ok((samples, log))
    }
}

/// Subtracts the mean stress of the first data points; in a biaxial test of each direction alone.
fn zero(samples: &mut [Sample], group: &Group, n: usize, file: &str) -> Result<AuditEntry, FitError> {
    let own = group.places(samples);
    let directions = if group.mode == Mode::Biaxial { 2 } else { 1 };
    if n == 0 || 2 * n * directions > own.len() {
        return Err(FitError::Zero { file: file.into(), mode: group.mode, asked: n, rows: own.len() / directions });
    }
    let (mut offsets, mut lines) = (vec![], vec![]);
    for direction in 0..directions {
        let part: Vec<usize> = own.iter().skip(direction).step_by(directions).copied().collect();
        let offset = part[..n].iter().map(|k| samples[*k].stress).sum::<f64>() / n as f64;
        lines = part[..n].iter().map(|k| samples[*k].line).collect();
        part.iter().for_each(|k| samples[*k].stress -= offset);
        offsets.push(format!("{offset:.1} Pa"));
    }
    let message = format!(
        "the mean stress of the first {n} data points, {}, was subtracted from every {} stress",
        offsets.join(" and "),
        group.name
    );
    Ok(AuditEntry::new(AuditKind::Changed, message, lines))
}

/// Shifts the strain of a group to where the line reaches zero stress, and drops the data points before the line.
fn shift(samples: &mut Vec<Sample>, group: &Group, level: f64) -> Result<Vec<AuditEntry>, String> {
    let mode = group.mode;
    if mode == Mode::Biaxial {
        return Err("a biaxial test has two strains, and no single toe".into());
    }
    let own = group.of(samples);
    // Compression has the opposite sign
    let side = own.iter().map(|s| mode.strain(s.stretch)).sum::<f64>().signum();
    let above = |s: &Sample| side * s.stress >= level;
    let Some(first) = own.windows(BEGIN).position(|w| w.iter().all(above)) else {
        return Err(format!("no {BEGIN} successive {mode} data points lie above it; give a lower level"));
    };
    let line = own[first..].iter().take_while(|s| side * s.stress < END * level).count().max(BEGIN);
    let points: Vec<(f64, f64)> = own[first..first + line].iter().map(|s| (mode.strain(s.stretch), s.stress)).collect();
    let n = points.len() as f64;
    let (e, p) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let slope = points.iter().map(|(x, y)| (x - e) * (y - p)).sum::<f64>()
        / points.iter().map(|(x, _)| (x - e).powi(2)).sum::<f64>();
    if !(slope > 0.0 && slope.is_finite()) {
        return Err(format!(
            "the stress does not rise with the strain in the {} {mode} data points after it is reached",
            points.len()
        ));
    }
    let origin = e - p / slope;
    let (from, to) = (own[first].line, own[first + line - 1].line);
    let gone: Vec<u64> = own[..first].iter().map(|s| s.line).collect();
    let mut seen = 0;
    samples.retain(|s| {
        seen += usize::from(group.has(s));
        !group.has(s) || seen > first
    });
    let moved = samples.iter_mut().filter(|s| group.has(s));
    moved.for_each(|s| s.stretch = mode.stretch(mode.strain(s.stretch) - origin));
    let message = format!(
        "{} strain was shifted by {:+.6}: the line through lines {from} to {to} ({} data points, slope {}) reaches zero stress at {origin:.6}",
        group.name,
        -origin,
        points.len(),
        stress_text(slope)
    );
    let mut log = vec![AuditEntry::new(AuditKind::Changed, message, vec![])];
    if !gone.is_empty() {
        let message = format!("{} data points of the toe, before the line", group.name);
        log.push(AuditEntry::new(AuditKind::LeftOut, message, gone));
    }
    Ok(log)
}
