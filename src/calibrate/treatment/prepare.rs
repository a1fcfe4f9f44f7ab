//! Treatment of the data points before a fit: order of time, choice of a loading, its end at a hold or at rupture, and on request zero of the stress and toe.
//!
//! *Zero*: the mean stress of the first N data points is subtracted from every stress. *Toe*: the slack of a test piece before it carries. The
//! straight line of least squares through the data points from the first of three in succession above the noise level p to the last one below 3p
//! reaches zero stress at the strain e₀, which is subtracted from every strain; data points before the line are left out. Source: ASTM D638-14, annex
//! A1, which takes the steepest part: rubbers are steepest at the start or at the end.
//!
//! Limits: a rubber that softens curves the line, which moves e₀ by −3(p/E)² (p/E the strain at the level, Neo-Hookean law).

use super::condense;
use super::cycle::{self, Cycle};
use super::hold;
use super::rupture::{self, Beginning};
use super::{Alternative, Preparation, Treatment};
use crate::calibrate::constant_format::stress_text;
use crate::calibrate::{AuditKind, Experiment, FitError, Mode, RawRow, Sample};
use crate::math::statistics::extent;
use crate::math::units::{self, Dimension};
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// Data points above the level that begin the line, and data points of a line
const BEGIN: usize = 3;
/// The line ends at this multiple of the level
const END: f64 = 3.0;

impl Experiment {
    /// The data points that are fitted, treated as requested; a card completes the request.
    pub fn prepare(mut self, asked: &Preparation) -> Result<Self, FitError> {
        let asked = self.card.as_ref().map_or_else(|| asked.clone(), |c| asked.or(&c.preparation));
        self.sort_by_time(asked.cycle.is_some())?;
        let chosen = asked.cycle.unwrap_or(Cycle::FirstLoading);
        let every = self.samples.clone();
        let loading = self.of_cycle(&every, chosen)?;
        let held = self.holds(&every, &loading, chosen, true);
        let whole = outside(&loading, &held);
        let picked = self.before_rupture(&whole, true);
        let taken = self.treat(&picked, asked.zero, asked.toe.as_deref(), true)?;
        let mut others = vec![];
        if loading.len() < every.len() {
            others.push((Treatment::EveryRow, asked.cycle.is_none(), every.clone(), asked.zero, asked.toe.as_deref()));
            let last = self.of_cycle(&every, Cycle::LastLoading)?;
            let held = self.holds(&every, &last, Cycle::LastLoading, false);
            let last = self.before_rupture(&outside(&last, &held), false);
            if last != picked {
                others.push((Treatment::LastLoading, asked.cycle.is_none(), last, asked.zero, asked.toe.as_deref()));
            }
            self.log_cycles(&every, &loading, &held, &asked);
        }
        if !held.is_empty() {
            let taken: HashSet<u64> = loading.iter().map(|s| s.line).chain(held.iter().copied()).collect();
            let with: Vec<Sample> = every.iter().filter(|s| taken.contains(&s.line)).copied().collect();
            others.push((Treatment::WithHold, false, with, asked.zero, asked.toe.as_deref()));
        }
        if picked.len() < whole.len() {
            others.push((Treatment::WithRupture, false, whole, asked.zero, asked.toe.as_deref()));
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
        if asked.zero.is_none() && asked.toe.is_none() {
            self.doubt_beginning(&taken);
        }
        let taken = self.by_stretch(taken);
        self.samples = self.condense(taken, true);
        for k in 0..self.alternatives.len() {
            let samples = std::mem::take(&mut self.alternatives[k].samples);
            self.alternatives[k].samples = self.condense(self.by_stretch(samples), false);
        }
        Ok(self)
    }

    /// Data points of one loading in the order of their stretches, where no time tells another order: their neighbours are then those in stretch, whatever
    /// the order of the file.
    fn by_stretch(&self, mut samples: Vec<Sample>) -> Vec<Sample> {
        let timed: HashSet<usize> = self.raw.iter().filter(|r| r.time.is_some()).map(|r| r.specimen).collect();
        for (specimen, mode) in self.groups() {
            let is_of = |s: &Sample| s.specimen == specimen && s.mode == mode;
            let places: Vec<usize> = (0..samples.len()).filter(|k| is_of(&samples[*k])).collect();
            let mut own: Vec<Sample> = places.iter().map(|k| samples[*k]).collect();
            let is_one_loading = || cycle::loadings(&own.iter().collect::<Vec<_>>()).is_none();
            // The directions of a biaxial test belong together
            if mode == Mode::Biaxial || timed.contains(&specimen) || !is_one_loading() {
                continue;
            }
            own.sort_by(|a, b| a.stretch.total_cmp(&b.stretch));
            places.into_iter().zip(own).for_each(|(place, sample)| samples[place] = sample);
        }
        samples
    }

    /// Means of neighbours where a group has very many data points.
    fn condense(&mut self, samples: Vec<Sample>, log: bool) -> Vec<Sample> {
        if samples.len() <= condense::MOST {
            return samples;
        }
        let mut found = vec![];
        for group in self.groups() {
            let own = of_group(&samples, group);
            // The directions of a biaxial test belong together
            match condense::condensed(&own).filter(|_| group.1 != Mode::Biaxial) {
                Some((means, size)) => {
                    if log {
                        let message = format!(
                            "{} {} data points became {} means of {size} neighbours in stretch each; the misfit is that of the means",
                            own.len(),
                            self.group_name(group),
                            means.len()
                        );
                        self.audit.add(AuditKind::Changed, message, vec![]);
                    }
                    found.extend(means);
                }
                None => found.extend(own),
            }
        }
        found
    }

    /// Specimens and modes that occur.
    fn groups(&self) -> Vec<(usize, Mode)> {
        let of = |specimen| Mode::ALL.into_iter().map(move |m| (specimen, m));
        let present: HashSet<(usize, Mode)> = self.samples.iter().map(|s| (s.specimen, s.mode)).collect();
        (0..self.specimens.len()).flat_map(of).filter(|g| present.contains(g)).collect()
    }

    /// Words on a group: the mode, and the specimen where there are several.
    fn group_name(&self, (specimen, mode): (usize, Mode)) -> String {
        if self.specimens.len() > 1 { format!("{mode} ({})", self.specimens[specimen]) } else { mode.to_string() }
    }

    /// Lines of the holds at the ends of the loadings, none where all data points were asked for.
    fn holds(&mut self, every: &[Sample], loading: &[Sample], cycle: Cycle, log: bool) -> HashSet<u64> {
        let mut gone = HashSet::new();
        // Directions of a biaxial test are held at different stretches
        let groups = self.groups().into_iter().filter(|g| cycle != Cycle::All && g.1 != Mode::Biaxial);
        for group in groups.collect::<Vec<_>>() {
            let (own, taken) = (of_group(every, group), of_group(loading, group));
            let start = taken.first().and_then(|first| own.iter().position(|s| s.line == first.line));
            let Some(hold) = start.and_then(|k| hold::at_the_end(&own, k..k + taken.len())) else { continue };
            let lines: Vec<u64> = own[hold.rows].iter().map(|s| s.line).collect();
            gone.extend(lines.iter().copied());
            if log {
                let message = format!(
                    "{} data points of a hold at the peak: the stress relaxes by {:.1} % at constant stretch, which is no loading (`durometer prony` fits \
                     relaxation; --cycle all takes them)",
                    self.group_name(group),
                    100.0 * hold.relaxed
                );
                self.audit.add(AuditKind::LeftOut, message, lines);
            }
        }
        gone
    }

    /// Leaves out the data points after the rupture of each piece.
    fn before_rupture(&mut self, rows: &[Sample], log: bool) -> Vec<Sample> {
        let mut kept = vec![];
        for group in self.groups() {
            let own = of_group(rows, group);
            let whole = if group.1 == Mode::Biaxial { own.len() } else { rupture::before(&own) };
            let gone: Vec<u64> = own[whole..].iter().map(|s| s.line).collect();
            if log && !gone.is_empty() {
                let message = format!(
                    "{} data points after rupture in {}: the stress falls below half of its largest level and does not return",
                    self.group_name(group),
                    self.file
                );
                self.audit.add(AuditKind::Ruptured, message, gone);
            }
            kept.extend_from_slice(&own[..whole]);
        }
        if kept.len() == rows.len() { rows.to_vec() } else { kept }
    }

    /// Doubts curves whose beginning does not go through zero.
    fn doubt_beginning(&mut self, rows: &[Sample]) {
        for group in self.groups() {
            let Some(found) = rupture::beginning(&of_group(rows, group), group.1) else { continue };
            let words = match found {
                Beginning::Offset { stress, part, to } => format!(
                    "up to a strain of {to:.3} the data extrapolate to {} at stretch 1, {:.1} % of the stress reached there: the force \
                     was not zeroed (--zero N where the first N data points are unloaded), or the piece was slack or pretensioned (--slack yes)",
                    stress_text(stress),
                    100.0 * part
                ),
                Beginning::Slack { strain, to } => format!(
                    "up to a strain of {strain:.4} the piece carries less than 2 % of the stress at {to:.3}: it was slack, and the constants of the \
                     fit depend on it (--slack yes)"
                ),
            };
            self.audit.add(AuditKind::Slack, format!("{}: {words}", self.group_name(group)), vec![]);
        }
    }

    /// Data points in the order of time, where that is the order of the test: fewer reversals of the stretch than in the order of the file.
    /// Refuses times that start again together with the stretch, unless a loading was asked for.
    fn sort_by_time(&mut self, cycle_asked: bool) -> Result<(), FitError> {
        let times: Option<Vec<f64>> = self.raw.iter().map(|r| r.time).collect();
        let back = |r: &[RawRow]| r[0].specimen == r[1].specimen && r[1].time < r[0].time;
        let lines: Vec<u64> = self.raw.windows(2).filter(|r| back(r)).map(|r| r[1].line).collect();
        let Some(times) = times.filter(|_| !lines.is_empty()) else { return Ok(()) };
        let time: HashMap<u64, f64> = self.raw.iter().map(|r| r.line).zip(times).collect();
        let groups = self.groups();
        let found: Vec<(u64, bool)> =
            groups.iter().flat_map(|g| restarts(&of_group(&self.samples, *g), &time)).collect();
        if !found.is_empty() {
            let (restarts, from_start): (Vec<u64>, Vec<bool>) = found.into_iter().unzip();
            if !cycle_asked && from_start.contains(&true) {
                return Err(FitError::Restarts { file: self.file.clone(), restarts });
            }
            self.audit.add(
                AuditKind::Kept,
                "time starts again in several parts of the table; the order was kept",
                restarts,
            );
            return Ok(());
        }
        let mut sorted = self.samples.clone();
        sorted.sort_by(|a, b| a.specimen.cmp(&b.specimen).then(time[&a.line].total_cmp(&time[&b.line])));
        let reversals = |samples: &[Sample]| {
            let of = |g: &(usize, Mode)| cycle::branches(&of_group(samples, *g).iter().collect::<Vec<_>>()).len();
            groups.iter().map(of).sum::<usize>()
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
        Ok(())
    }

    /// The data points of one loading of each specimen and mode that has several branches.
    fn of_cycle(&self, samples: &[Sample], cycle: Cycle) -> Result<Vec<Sample>, FitError> {
        let mut of: HashMap<(usize, Mode), Vec<usize>> = HashMap::new();
        for (k, s) in samples.iter().enumerate() {
            of.entry((s.specimen, s.mode)).or_default().push(k);
        }
        let mut found = vec![];
        for group in self.groups() {
            let Some(places) = of.get(&group) else { continue };
            let own: Vec<&Sample> = places.iter().map(|k| &samples[*k]).collect();
            // Directions of a biaxial test reverse at different times
            let loadings = (group.1 != Mode::Biaxial).then(|| cycle::loadings(&own)).flatten();
            // Without branches the table is one loading
            let loadings = loadings.unwrap_or_else(|| vec![Range { start: 0, end: own.len() }]);
            found.extend_from_slice(&places[cycle::pick(&self.file, &loadings, own.len(), cycle)?]);
        }
        found.sort_unstable();
        Ok(found.into_iter().map(|k| samples[k]).collect())
    }

    fn log_cycles(&mut self, every: &[Sample], picked: &[Sample], held: &HashSet<u64>, asked: &Preparation) {
        let mut counts = vec![];
        for group in self.groups() {
            let own = of_group(every, group);
            if let Some(loadings) = cycle::loadings(&own.iter().collect::<Vec<_>>()) {
                counts.push(format!("{} of {}", loadings.len(), self.group_name(group)));
            }
        }
        for group in self.groups() {
            let own = of_group(every, group);
            let jumps = cycle::jumps(&own);
            if !jumps.is_empty() {
                let message = format!(
                    "the stretch of the {} data points jumps back without unloading: if these are curves of several specimens, divide the file or \
                     add a column \"specimen\"",
                    self.group_name(group)
                );
                self.audit.add(AuditKind::Doubt, message, jumps);
            }
        }
        let taken: HashSet<u64> = picked.iter().map(|s| s.line).collect();
        let lines: Vec<u64> =
            every.iter().map(|s| s.line).filter(|l| !taken.contains(l) && !held.contains(l)).collect();
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
            for group in self.groups() {
                entries.push((AuditKind::Changed, self.zero(&mut samples, group, n)?));
            }
        }
        if let Some(text) = toe {
            let refuse = |reason: String| FitError::Toe { file: self.file.clone(), level: text.into(), reason };
            let level = units::parse(text, Dimension::PRESSURE).map_err(|e| refuse(e.to_string()))?;
            if !(level > 0.0 && level.is_finite()) {
                return Err(refuse("the noise level must be above zero".into()));
            }
            for group in self.groups() {
                let (message, gone) = shift(&mut samples, group, level).map_err(refuse)?;
                let name = self.group_name(group);
                entries.push((AuditKind::Changed, (format!("{name} {message}"), vec![])));
                entries.push((AuditKind::LeftOut, (format!("{name} data points of the toe, before the line"), gone)));
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
    fn zero(&self, samples: &mut [Sample], group: (usize, Mode), n: usize) -> Result<(String, Vec<u64>), FitError> {
        let mode = group.1;
        let own: Vec<usize> = (0..samples.len()).filter(|k| is_of(&samples[*k], group)).collect();
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
            "the mean stress of the first {n} data points, {}, was subtracted from every {} stress",
            offsets.join(" and "),
            self.group_name(group)
        );
        Ok((message, lines))
    }
}

/// Rows of a part of a table on average, and the part of a range that counts as an overlap, or as the start \[–\]
const RESTART: usize = 5;
const START: f64 = 0.1;

/// Lines in which the time goes back into a part of the test that is in the table already, and whether the stretch is back at the start, too. Rows
/// out of order are none: their parts are short, or do not overlap.
fn restarts(samples: &[Sample], time: &HashMap<u64, f64>) -> Vec<(u64, bool)> {
    let t = |s: &Sample| time[&s.line];
    let backs: Vec<usize> = (1..samples.len()).filter(|k| t(&samples[*k]) < t(&samples[*k - 1])).collect();
    let starts: Vec<usize> = [0].into_iter().chain(backs.iter().copied()).collect();
    let [low, high] = extent(samples.iter().map(|s| s.stretch));
    let ends = backs.iter().copied().chain([samples.len()]);
    let mut spans: Vec<[f64; 2]> =
        starts.iter().zip(ends).map(|(a, b)| [t(&samples[*a]), t(&samples[b - 1])]).collect();
    spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let overlap = |w: &[[f64; 2]]| w[0][1].min(w[1][1]) - w[1][0] > START * (w[0][1] - w[0][0]).min(w[1][1] - w[1][0]);
    if samples.len() < RESTART * starts.len() || !spans.windows(2).any(overlap) {
        return vec![];
    }
    let at_start = |s: &Sample| (s.stretch - samples[0].stretch).abs() <= START * (high - low);
    backs.iter().map(|k| (samples[*k].line, at_start(&samples[*k]))).collect()
}

/// The data points that are not on these lines.
fn outside(samples: &[Sample], lines: &HashSet<u64>) -> Vec<Sample> {
    samples.iter().filter(|s| !lines.contains(&s.line)).copied().collect()
}

fn is_of(s: &Sample, (specimen, mode): (usize, Mode)) -> bool {
    s.specimen == specimen && s.mode == mode
}

fn of_group(samples: &[Sample], group: (usize, Mode)) -> Vec<Sample> {
    samples.iter().filter(|s| is_of(s, group)).copied().collect()
}

/// Shifts the strain of a mode to where the line reaches zero stress, and drops the data points before the line. Returns the change and the lines.
fn shift(samples: &mut Vec<Sample>, group: (usize, Mode), level: f64) -> Result<(String, Vec<u64>), String> {
    let mode = group.1;
    if mode == Mode::Biaxial {
        return Err("a biaxial test has two strains, and no single toe".into());
    }
    let own = of_group(samples, group);
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
        seen += usize::from(is_of(s, group));
        !is_of(s, group) || seen > first
    });
    let moved = samples.iter_mut().filter(|s| is_of(s, group));
    moved.for_each(|s| s.stretch = mode.stretch(mode.strain(s.stretch) - origin));
    let message = format!(
        "strain was shifted by {:+.6}: the line through lines {from} to {to} ({} data points, slope {}) reaches zero stress at {origin:.6}",
        -origin,
        points.len(),
        stress_text(slope)
    );
    Ok((message, gone))
}
