//! Treatment of the data points before a fit, on request only: order of time, choice of a loading, zero of the stress, toe.
//!
//! *Zero*: the mean stress of the first N data points is subtracted from every stress. *Toe*: the slack of a test piece before it carries. The
//! straight line of least squares through the data points from the first of three in succession above the noise level p to the last one below 3p
//! reaches zero stress at the strain e₀, which is subtracted from every strain; data points before the line are left out. Source: ASTM D638-14, annex
//! A1, which takes the steepest part: rubbers are steepest at the start or at the end.
//!
//! Limits: a rubber that softens curves the line, which moves e₀ by −3(p/E)² (p/E the strain at the level, Neo-Hookean law).

use super::cycle::{self, Cycle};
use super::{Alternative, AuditKind, Experiment, FitError, Mode, Preparation, RawRow, Sample, Treatment};
use crate::math::units::{self, Dimension};
use std::ops::Range;

/// Data points above the level that begin the line, and data points of a line
const BEGIN: usize = 3;
/// The line ends at this multiple of the level
const END: f64 = 3.0;

impl Experiment {
    /// The data points that are fitted, treated as requested; a card completes the request.
    pub fn prepare(mut self, asked: &Preparation) -> Result<Self, FitError> {
        let asked = self.card.as_ref().map_or_else(|| asked.clone(), |c| asked.or(&c.preparation));
        self.sort_by_time();
        let chosen = asked.cycle.unwrap_or(Cycle::FirstLoading);
        let every = self.samples.clone();
        let picked = self.of_cycle(&every, chosen)?;
        let taken = self.treat(&picked, asked.zero, asked.toe.as_deref(), true)?;
        let mut others = vec![];
        if picked.len() < every.len() {
            others.push((Treatment::EveryRow, asked.cycle.is_none(), every.clone(), asked.zero, asked.toe.as_deref()));
            let last = self.of_cycle(&every, Cycle::LastLoading)?;
            if last != picked {
                others.push((Treatment::LastLoading, asked.cycle.is_none(), last, asked.zero, asked.toe.as_deref()));
            }
            self.log_cycles(&every, &picked, &asked);
        }
        if asked.zero.is_some() {
            others.push((Treatment::WithoutZero, false, picked.clone(), None, asked.toe.as_deref()));
        }
        if asked.toe.is_some() {
            others.push((Treatment::WithoutToe, false, picked.clone(), asked.zero, None));
        }
        for (treatment, unasked, rows, zero, toe) in others {
            // A treatment that cannot be had is no alternative
            if let Ok(samples) = self.treat(&rows, zero, toe, false) {
                self.alternatives.push(Alternative { treatment, unasked, samples });
            }
        }
        self.samples = taken;
        Ok(self)
    }

    /// Data points in the order of time, where that is the order of the test: fewer reversals of the stretch than in the order of the file.
    fn sort_by_time(&mut self) {
        let time = |raw: &[RawRow], s: &Sample| raw.iter().find(|r| r.line == s.line).and_then(|r| r.time);
        let times: Option<Vec<f64>> = self.raw.iter().map(|r| r.time).collect();
        let Some(times) = times.filter(|t| t.windows(2).any(|w| w[1] < w[0])) else { return };
        let lines: Vec<u64> =
            (self.raw.windows(2).zip(times.windows(2))).filter(|(_, t)| t[1] < t[0]).map(|(r, _)| r[1].line).collect();
        let mut sorted = self.samples.clone();
        sorted.sort_by(|a, b| {
            let [a, b] = [a, b].map(|s| time(&self.raw, s).expect("every data point has a time"));
            a.total_cmp(&b)
        });
        let reversals = |samples: &[Sample]| {
            let of = |m: Mode| {
                let own: Vec<&Sample> = samples.iter().filter(|s| s.mode == m).collect();
                cycle::branches(&own).len()
            };
            Mode::ALL.map(of).iter().sum::<usize>()
        };
        if reversals(&sorted) < reversals(&self.samples) {
            self.samples = sorted;
            self.audit.add(
                AuditKind::Changed,
                "data points were put into the order of the time column, which goes back",
                lines,
            );
        } else {
            let message = "time goes back, but the stretch does not reverse more often in the order of the file: the order was kept";
            self.audit.add(AuditKind::Kept, message, lines);
        }
    }

    /// The data points of one loading of each mode that has several branches.
    fn of_cycle(&self, samples: &[Sample], cycle: Cycle) -> Result<Vec<Sample>, FitError> {
        let mut found = vec![];
        for mode in self.modes() {
            let own: Vec<&Sample> = samples.iter().filter(|s| s.mode == mode).collect();
            // Directions of a biaxial test reverse at different times
            let loadings = (mode != Mode::Biaxial).then(|| cycle::loadings(&own)).flatten();
            // Without branches the table is one loading
            let loadings = loadings.unwrap_or_else(|| vec![Range { start: 0, end: own.len() }]);
            let range = cycle::pick(&self.file, &loadings, own.len(), cycle)?;
            found.extend(own[range].iter().map(|s| **s));
        }
        let place = |s: &Sample| samples.iter().position(|o| o == s).expect("a data point of the table");
        if self.modes().len() > 1 {
            found.sort_by_key(place);
        }
        Ok(found)
    }

    fn log_cycles(&mut self, every: &[Sample], picked: &[Sample], asked: &Preparation) {
        let mut counts = vec![];
        for mode in self.modes() {
            let own: Vec<&Sample> = every.iter().filter(|s| s.mode == mode).collect();
            if let Some(loadings) = cycle::loadings(&own) {
                counts.push(format!("{} of {mode}", loadings.len()));
            }
        }
        let lines: Vec<u64> =
            every.iter().filter(|s| !picked.iter().any(|p| p.line == s.line)).map(|s| s.line).collect();
        let what = match asked.cycle {
            Some(cycle) => format!("as asked, --cycle {cycle}"),
            None => "the first loading is fitted".into(),
        };
        let message = format!("data points of other branches ({what}; the table has {} loadings)", counts.join(", "));
        self.audit.add(AuditKind::LeftOut, message, lines);
    }

    /// Zero and toe of each mode; `log`: with entries for the audit.
    fn treat(
        &mut self,
        rows: &[Sample],
        zero: Option<usize>,
        toe: Option<&str>,
        log: bool,
    ) -> Result<Vec<Sample>, FitError> {
        let mut samples = rows.to_vec();
        let mut entries = vec![];
        if let Some(n) = zero {
            for mode in self.modes() {
                entries.push((AuditKind::Changed, self.zero(&mut samples, mode, n)?));
            }
        }
        if let Some(text) = toe {
            let refuse = |reason: String| FitError::Toe { file: self.file.clone(), level: text.into(), reason };
            let level = units::parse(text, Dimension::PRESSURE).map_err(|e| refuse(e.to_string()))?;
            if !(level > 0.0 && level.is_finite()) {
                return Err(refuse("the noise level must be above zero".into()));
            }
            for mode in self.modes() {
                let (message, gone) = shift(&mut samples, mode, level).map_err(refuse)?;
                entries.push((AuditKind::Changed, (message, vec![])));
                entries.push((AuditKind::LeftOut, (format!("{mode} data points of the toe, before the line"), gone)));
            }
        }
        for (kind, (message, lines)) in
            entries.into_iter().filter(|(k, (_, lines))| log && (*k == AuditKind::Changed || !lines.is_empty()))
        {
            self.audit.add(kind, message, lines);
        }
        Ok(samples)
    }

    /// Subtracts the mean stress of the first data points; in a biaxial test of each direction alone.
    fn zero(&self, samples: &mut [Sample], mode: Mode, n: usize) -> Result<(String, Vec<u64>), FitError> {
        let own: Vec<usize> = (0..samples.len()).filter(|k| samples[*k].mode == mode).collect();
        let directions = if mode == Mode::Biaxial { 2 } else { 1 };
        if n == 0 || 2 * n * directions > own.len() {
            return Err(FitError::Zero { file: self.file.clone(), mode, asked: n, rows: own.len() / directions });
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
            "the mean stress of the first {n} data points, {}, was subtracted from every {mode} stress",
            offsets.join(" and ")
        );
        Ok((message, lines))
    }
}

/// Shifts the strain of a mode to where the line reaches zero stress, and drops the data points before the line. Returns the change and the lines.
fn shift(samples: &mut Vec<Sample>, mode: Mode, level: f64) -> Result<(String, Vec<u64>), String> {
    if mode == Mode::Biaxial {
        return Err("a biaxial test has two strains, and no single toe".into());
    }
    let own: Vec<Sample> = samples.iter().filter(|s| s.mode == mode).copied().collect();
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
        seen += usize::from(s.mode == mode);
        s.mode != mode || seen > first
    });
    let moved = samples.iter_mut().filter(|s| s.mode == mode);
    moved.for_each(|s| s.stretch = mode.stretch(mode.strain(s.stretch) - origin));
    let message = format!(
        "{mode} strain was shifted by {:+.6}: the line through lines {from} to {to} ({} data points, slope {slope:.4e} Pa) reaches zero stress at \
         {origin:.6}",
        -origin,
        points.len()
    );
    Ok((message, gone))
}
