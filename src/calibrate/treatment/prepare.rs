//! Treatment of the data points before a fit: order in time, choice of a loading, its end at a hold or at rupture, and on request the zero of the
//! stress and the toe.

use super::condense;
use super::corrections::{Corrected, Corrections};
use super::cycle::{self, Cycle};
use super::group::Group;
use super::hold;
use super::order;
use super::rupture::{self, Beginning};
use super::{Alternative, Preparation, Treatment};
use crate::calibrate::constant_format::stress_text;
use crate::calibrate::solve::offset::no_single_offset;
use crate::calibrate::{AuditEntry, AuditKind, Experiment, FitError, Mode, Sample};
use std::collections::HashSet;
use std::ops::Range;

impl Experiment {
    /// The data points that are fitted, treated as requested; a card completes the request.
    pub fn prepare(mut self, asked: &Preparation) -> Result<Self, FitError> {
        let asked = self.card.as_ref().map_or_else(|| asked.clone(), |c| asked.or(&c.preparation));
        let groups = Group::all(&self);
        let (every, mut log) = order::by_time(&self, &groups, asked.cycle.is_some())?;
        let table = Table::new(&self, groups, every);
        let corrections = Corrections { zero: asked.zero, toe: asked.toe.as_deref() };
        let mut loading = table.loading(asked.cycle.unwrap_or(Cycle::FirstLoading))?;
        log.append(&mut loading.log);
        let taken = table.corrected(&loading.picked, corrections)?;
        log.extend(taken.log);
        let variants = table.variants(&loading, asked.cycle, corrections)?;
        if table.is_divided_by(&loading) {
            log.extend(table.other_branches(&loading, asked.cycle));
        }
        if asked.zero.is_none() && asked.toe.is_none() {
            log.extend(table.doubtful_beginnings(&taken.samples));
        }
        let single = taken.samples.clone();
        let (samples, condensed) = table.condensed(taken.samples);
        log.extend(condensed);
        let alternative = |Variant { treatment, unasked, rows, corrections }: Variant| {
            // A treatment that fails is not an alternative
            let Corrected { samples, .. } = table.corrected(&rows, corrections).ok()?;
            Some(Alternative { treatment, unasked, samples: table.condensed(samples).0 })
        };
        let alternatives: Vec<Alternative> = variants.into_iter().filter_map(alternative).collect();
        self.samples = samples;
        self.single = single;
        taken.errors.into_iter().for_each(|(specimen, error)| self.pieces[specimen].corrections.push(error));
        self.alternatives.extend(alternatives);
        self.audit.0.extend(log);
        Ok(self)
    }
}

impl Experiment {
    /// All data points of a cyclic test in the order of time, except holds at the ends of its loadings and data points after a rupture.
    pub fn prepare_cycles(mut self) -> Result<Self, FitError> {
        let groups = Group::all(&self);
        let (every, mut log) = order::by_time(&self, &groups, true)?;
        let table = Table::new(&self, groups, every);
        let (held, holds) = table.holds_of_cycles();
        let whole: Vec<Sample> = table.every.iter().filter(|s| !held.contains(&s.line)).copied().collect();
        let (samples, ruptured) = table.before_rupture(&whole);
        log.extend(holds.into_iter().chain(ruptured));
        self.samples = samples;
        self.audit.0.extend(log);
        Ok(self)
    }
}

/// Data points, before their corrections, under a treatment that differs from the chosen one.
struct Variant<'a> {
    treatment: Treatment,
    unasked: bool,
    rows: Vec<Sample>,
    corrections: Corrections<'a>,
}

/// One loading of each group.
struct Loading {
    /// With its hold and the data points after a rupture
    all: Vec<Sample>,
    /// Lines of the hold at its end
    held: HashSet<u64>,
    /// Without the hold
    whole: Vec<Sample>,
    /// Without the hold and the data points after a rupture
    picked: Vec<Sample>,
    /// Log entries on the data points that it leaves out
    log: Vec<AuditEntry>,
}

/// A table in the order of its test.
struct Table<'a> {
    of: &'a Experiment,
    groups: Vec<Group>,
    /// The groups, divided into the sides of rest
    sides: Vec<Group>,
    every: Vec<Sample>,
}

impl<'t> Table<'t> {
    fn new(of: &'t Experiment, groups: Vec<Group>, every: Vec<Sample>) -> Self {
        let sides = groups.iter().flat_map(|group| group.by_side(&every)).collect();
        Self { of, groups, sides, every }
    }

    fn loading(&self, cycle: Cycle) -> Result<Loading, FitError> {
        let all = self.of_cycle(cycle)?;
        let (held, mut log) = self.holds(&all, cycle);
        let whole: Vec<Sample> = all.iter().filter(|s| !held.contains(&s.line)).copied().collect();
        let (picked, ruptured) = self.before_rupture(&whole);
        log.extend(ruptured);
        Ok(Loading { all, held, whole, picked, log })
    }

    /// Whether the table has data points outside this loading.
    fn is_divided_by(&self, loading: &Loading) -> bool {
        loading.all.len() < self.every.len()
    }

    /// The treatments that were not chosen.
    fn variants<'a>(
        &self,
        taken: &Loading,
        asked: Option<Cycle>,
        corrections: Corrections<'a>,
    ) -> Result<Vec<Variant<'a>>, FitError> {
        let mut found = vec![];
        let mut add = |treatment, unasked, rows: &[Sample], corrections| {
            found.push(Variant { treatment, unasked, rows: rows.to_vec(), corrections });
        };
        if self.is_divided_by(taken) {
            add(Treatment::EveryRow, asked.is_none(), &self.every, corrections);
            let last = self.loading(Cycle::LastLoading)?.picked;
            if last != taken.picked {
                add(Treatment::LastLoading, asked.is_none(), &last, corrections);
            }
        }
        if !taken.held.is_empty() {
            let lines: HashSet<u64> = taken.all.iter().map(|s| s.line).chain(taken.held.iter().copied()).collect();
            let with: Vec<Sample> = self.every.iter().filter(|s| lines.contains(&s.line)).copied().collect();
            add(Treatment::WithHold, false, &with, corrections);
        }
        if taken.picked.len() < taken.whole.len() {
            add(Treatment::WithRupture, false, &taken.whole, corrections);
        }
        if corrections.zero.is_some() {
            add(Treatment::WithoutZero, false, &taken.picked, Corrections { zero: None, ..corrections });
        }
        if corrections.toe.is_some() {
            add(Treatment::WithoutToe, false, &taken.picked, Corrections { toe: None, ..corrections });
        }
        Ok(found)
    }

    fn corrected(&self, rows: &[Sample], corrections: Corrections) -> Result<Corrected, FitError> {
        let mut found = corrections.applied(rows, (&self.groups, &self.sides), &self.of.file)?;
        found.log.extend(self.waiting(&mut found.samples));
        Ok(found)
    }

    /// Leaves out the data points while the machine waits at zero strain, except the last one before it continues: otherwise any number of them would
    /// count as data of the law.
    fn waiting(&self, samples: &mut Vec<Sample>) -> Option<AuditEntry> {
        let mut gone: HashSet<(usize, u64)> = HashSet::new();
        for group in &self.groups {
            let own = group.of(samples);
            let waits = own.windows(2).filter(|w| w[0].line != w[1].line && w.iter().all(Sample::is_at_rest));
            gone.extend(waits.map(|w| (w[0].specimen, w[0].line)));
        }
        samples.retain(|s| !gone.contains(&(s.specimen, s.line)));
        let mut gone: Vec<u64> = gone.into_iter().map(|(_, line)| line).collect();
        gone.sort_unstable();
        let message = format!(
            "{} data points of {} without strain, next to another one, were left out: a machine that waits says nothing about a law",
            gone.len(),
            self.of.file
        );
        (!gone.is_empty()).then(|| AuditEntry::new(AuditKind::LeftOut, message, gone))
    }

    /// The data points in order, replaced by means of neighbours if a group has very many.
    fn condensed(&self, samples: Vec<Sample>) -> (Vec<Sample>, Vec<AuditEntry>) {
        let samples = order::by_stretch(&self.of.raw, &self.groups, samples);
        let (mut found, mut log) = (vec![], vec![]);
        if samples.len() <= condense::MOST {
            return (samples, log);
        }
        for group in &self.groups {
            let own = group.of(&samples);
            // The directions of a biaxial test belong together
            match condense::condensed(&own).filter(|_| group.mode != Mode::Biaxial) {
                Some((means, size)) => {
                    let message = format!(
                        "{} {} data points became {} means of {size} neighbours in stretch each; the misfit is that of the means",
                        own.len(),
                        group.name,
                        means.len()
                    );
                    log.push(AuditEntry::new(AuditKind::Changed, message, vec![]));
                    found.extend(means);
                }
                None => found.extend(own),
            }
        }
        (found, log)
    }

    /// Lines of the holds at the ends of the loadings; empty if all data points were requested.
    fn holds(&self, loading: &[Sample], cycle: Cycle) -> (HashSet<u64>, Vec<AuditEntry>) {
        let (mut gone, mut log) = (HashSet::new(), vec![]);
        // Directions of a biaxial test are held at different stretches
        for group in self.sides.iter().filter(|g| cycle != Cycle::All && g.mode != Mode::Biaxial) {
            let (own, taken) = (group.of(&self.every), group.of(loading));
            let start = taken.first().and_then(|first| own.iter().position(|s| s.line == first.line));
            let Some(hold) = start.and_then(|k| hold::at_the_end(&own, k..k + taken.len())) else { continue };
            log.push(hold_entry(group, &own, &[hold], "; --cycle all takes them"));
        }
        gone.extend(log.iter().flat_map(|entry| entry.lines.iter().copied()));
        (gone, log)
    }

    /// Lines of the holds at the ends of all loadings of a cyclic test.
    fn holds_of_cycles(&self) -> (HashSet<u64>, Vec<AuditEntry>) {
        let of = |group: &Group| {
            let own = group.of(&self.every);
            let loadings = cycle::loadings(&own.iter().collect::<Vec<_>>());
            let loadings = loadings.unwrap_or_else(|| vec![Range { start: 0, end: own.len() }]);
            let holds: Vec<hold::Hold> = loadings.into_iter().filter_map(|l| hold::at_the_end(&own, l)).collect();
            (!holds.is_empty()).then(|| hold_entry(group, &own, &holds, ""))
        };
        let log: Vec<AuditEntry> = self.sides.iter().filter(|g| g.mode != Mode::Biaxial).filter_map(of).collect();
        (log.iter().flat_map(|entry| entry.lines.iter().copied()).collect(), log)
    }

    /// The data points before the rupture of each test piece.
    fn before_rupture(&self, rows: &[Sample]) -> (Vec<Sample>, Vec<AuditEntry>) {
        let (mut kept, mut log) = (vec![], vec![]);
        for group in &self.sides {
            let own = group.of(rows);
            let whole = if group.mode == Mode::Biaxial { own.len() } else { rupture::before(&own) };
            let gone: Vec<u64> = own[whole..].iter().map(|s| s.line).collect();
            if !gone.is_empty() {
                let message = format!(
                    "{} data points after rupture in {}: the stress falls below half of its largest level and does not return",
                    group.name, self.of.file
                );
                log.push(AuditEntry::new(AuditKind::Ruptured, message, gone));
            }
            kept.extend_from_slice(&own[..whole]);
        }
        (if kept.len() == rows.len() { rows.to_vec() } else { kept }, log)
    }

    /// Doubts about curves whose beginning does not go through zero.
    fn doubtful_beginnings(&self, rows: &[Sample]) -> Vec<AuditEntry> {
        let doubt = |group: &Group| {
            let curve = rows.iter().filter(|s| s.specimen == group.specimen && s.mode == group.mode);
            let slack = match no_single_offset(group.mode, curve) {
                None => "--slack yes",
                Some(_) => "--slack yes of each side alone, with --range",
            };
            let words = match rupture::beginning(&group.of(rows), group.mode)? {
                Beginning::Offset { stress, part, to } => format!(
                    "up to a strain of {to:.3} the data extrapolate to {} at stretch 1, {:.1} % of the stress reached there: the force \
                     was not zeroed (--zero N where the first N data points are unloaded), or the piece was slack or pretensioned ({slack})",
                    stress_text(stress),
                    100.0 * part
                ),
                Beginning::Slack { strain, to } => format!(
                    "up to a strain of {strain:.4} the piece carries less than 2 % of the stress at {to:.3}: it was slack, and the constants of the \
                     fit depend on it ({slack})"
                ),
            };
            Some(AuditEntry::new(AuditKind::Slack, format!("{}: {words}", group.name), vec![]))
        };
        self.sides.iter().filter_map(doubt).collect()
    }

    /// The data points of one loading of each group that has several branches.
    fn of_cycle(&self, cycle: Cycle) -> Result<Vec<Sample>, FitError> {
        let mut found = vec![];
        for group in &self.sides {
            let places = group.places(&self.every);
            let own: Vec<&Sample> = places.iter().map(|k| &self.every[*k]).collect();
            // Directions of a biaxial test reverse at different times
            let loadings = (group.mode != Mode::Biaxial).then(|| cycle::loadings(&own)).flatten();
            // Without branches the table is a single loading
            let loadings = loadings.unwrap_or_else(|| vec![Range { start: 0, end: own.len() }]);
            found.extend_from_slice(&places[cycle::pick(&self.of.file, &loadings, own.len(), cycle)?]);
        }
        found.sort_unstable();
        Ok(found.into_iter().map(|k| self.every[k]).collect())
    }

    /// Log entries on stretches that jump back, and on the data points of branches other than the chosen loading.
    fn other_branches(&self, taken: &Loading, asked: Option<Cycle>) -> Vec<AuditEntry> {
        let (mut counts, mut log) = (vec![], vec![]);
        for group in &self.sides {
            let own = group.of(&self.every);
            if let Some(loadings) = cycle::loadings(&own.iter().collect::<Vec<_>>()) {
                counts.push(format!("{} of {}", loadings.len(), group.name));
            }
            let jumps = cycle::jumps(&own);
            if !jumps.is_empty() {
                let message = format!(
                    "the stretch of the {} data points jumps back without unloading: if these are curves of several specimens, divide the file or \
                     add a column \"specimen\"",
                    group.name
                );
                log.push(AuditEntry::new(AuditKind::Doubt, message, jumps));
            }
        }
        let lines: HashSet<u64> = taken.all.iter().map(|s| s.line).chain(taken.held.iter().copied()).collect();
        let others = self.every.iter().map(|s| s.line).filter(|l| !lines.contains(l)).collect();
        let what = match asked {
            Some(cycle) => format!("as asked, --cycle {cycle}"),
            None => "the first loading is fitted".into(),
        };
        let message = format!("data points of other branches ({what}; the table has {} loadings)", counts.join(", "));
        log.push(AuditEntry::new(AuditKind::LeftOut, message, others));
        log
    }
}

/// Log entry on the data points of holds.
fn hold_entry(group: &Group, own: &[Sample], holds: &[hold::Hold], remedy: &str) -> AuditEntry {
    let lines = holds.iter().flat_map(|hold| own[hold.rows.clone()].iter().map(|s| s.line)).collect();
    let relaxed = holds.iter().map(|hold| hold.relaxed).fold(0.0, f64::max);
    let message = format!(
        "{} data points of a hold at the peak: the stress relaxes by {:.1} % at constant stretch, which is no loading (`durometer prony` fits relaxation{remedy})",
        group.name,
        100.0 * relaxed
    );
    AuditEntry::new(AuditKind::LeftOut, message, lines)
}
