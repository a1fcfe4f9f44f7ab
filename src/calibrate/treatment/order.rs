//! Order of the data points: by time if that is the order of the test, and by stretch for a loading without times.

use super::cycle;
use super::group::Group;
use crate::calibrate::{AuditEntry, AuditKind, Experiment, FitError, Mode, RawRow, Sample};
use crate::math::statistics::extent;
use std::collections::{HashMap, HashSet};

/// Average number of rows of a part of a table, and the share of a range that counts as an overlap, or as the start \[–\]
const RESTART: usize = 5;
const START: f64 = 0.1;

/// Data points in the order of time, if that is the order of the test: it has fewer reversals of the stretch than the order of the file. Refuses
/// times that restart together with the stretch, unless a loading was requested.
pub fn by_time(
    table: &Experiment,
    groups: &[Group],
    cycle_asked: bool,
) -> Result<(Vec<Sample>, Vec<AuditEntry>), FitError> {
    let times: Option<Vec<f64>> = table.raw.iter().map(|r| r.time).collect();
    let back = |r: &[RawRow]| r[0].specimen == r[1].specimen && r[1].time < r[0].time;
    let lines: Vec<u64> = table.raw.windows(2).filter(|r| back(r)).map(|r| r[1].line).collect();
    let own = || table.samples.clone();
    let Some(times) = times.filter(|_| !lines.is_empty()) else { return Ok((own(), vec![])) };
    let time: HashMap<u64, f64> = table.raw.iter().map(|r| r.line).zip(times).collect();
    let found: Vec<(u64, bool)> = groups.iter().flat_map(|g| restarts(&g.of(&table.samples), &time)).collect();
    if !found.is_empty() {
        let (restarts, from_start): (Vec<u64>, Vec<bool>) = found.into_iter().unzip();
        if !cycle_asked && from_start.contains(&true) {
            return Err(FitError::Restarts { file: table.file.clone(), restarts });
        }
        let message = "time starts again in several parts of the table; the order was kept";
        return Ok((own(), vec![AuditEntry::new(AuditKind::Kept, message, restarts)]));
    }
    let mut sorted = own();
    sorted.sort_by(|a, b| a.specimen.cmp(&b.specimen).then(time[&a.line].total_cmp(&time[&b.line])));
    let reversals = |samples: &[Sample]| {
        let of = |g: &Group| cycle::branches(&g.of(samples).iter().collect::<Vec<_>>()).len();
        groups.iter().map(of).sum::<usize>()
    };
    Ok(if reversals(&sorted) < reversals(&table.samples) {
        let message = "data points were put into the order of the time column, which goes back";
        (sorted, vec![AuditEntry::new(AuditKind::Changed, message, lines)])
    } else {
        let message =
            "time goes back, but the stretch does not reverse more often in the order of the file: the order was kept";
        (own(), vec![AuditEntry::new(AuditKind::Kept, message, lines)])
    })
}

/// Lines in which the time returns to a part of the test that is already in the table, and whether the stretch is back at the start, too. Rows out of
/// order do not count: their parts are short, or do not overlap.
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

/// Data points of one loading in the order of their stretches, unless times give another order: their neighbours are then neighbours in stretch,
/// independently of the order of the file.
pub fn by_stretch(raw: &[RawRow], groups: &[Group], mut samples: Vec<Sample>) -> Vec<Sample> {
    let timed: HashSet<usize> = raw.iter().filter(|r| r.time.is_some()).map(|r| r.specimen).collect();
    for group in groups {
        let places = group.places(&samples);
        let mut own: Vec<Sample> = places.iter().map(|k| samples[*k]).collect();
        let is_loaded_once = |side: &Group| cycle::loadings(&side.of(&own).iter().collect::<Vec<_>>()).is_none();
        let is_one_loading = || group.by_side(&own).iter().all(is_loaded_once);
        // The directions of a biaxial test belong together
        if group.mode == Mode::Biaxial || timed.contains(&group.specimen) || !is_one_loading() {
            continue;
        }
        own.sort_by(|a, b| a.stretch.total_cmp(&b.stretch));
        places.into_iter().zip(own).for_each(|(place, sample)| samples[place] = sample);
    }
    samples
}
