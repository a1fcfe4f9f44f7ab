//! Data points and lines of the figure of softening. The stress on unloading is a function of the stretch and of the largest previous stretch, so
//! that there is one line for each largest stretch.

use super::path::CyclicPath;
use super::rows::{FirstLoading, Row};
use crate::calibrate::{CurveSet, Sample};
use crate::material::Softening;

/// Number of intervals of a line.
const INTERVALS: usize = 60;

/// The curves of unloading and reloading, with the stress `fitted` of each row, followed by the first loading.
pub fn sets(path: &CyclicPath, first: &FirstLoading, soft: &Softening, set: f64, fitted: &[f64]) -> Vec<CurveSet> {
    let one = |label: &str, samples: &[Sample], fitted: &[f64], lines: Vec<Vec<[f64; 2]>>| {
        let pairs = || samples.iter().zip(fitted);
        CurveSet {
            label: label.into(),
            measured: samples.iter().map(|s| [s.stretch, s.stress]).collect(),
            fitted: pairs().map(|(s, f)| [s.stretch, *f]).collect(),
            residuals: pairs().map(|(s, f)| [s.stretch, s.stress - f]).collect(),
            lines,
        }
    };
    let amount = |stretch: f64| stretch.ln().abs();
    let branches = path.softened.chunk_by(|a, b| (a.sample.mode, a.peak) == (b.sample.mode, b.peak));
    let down = branches.map(|rows| {
        let least = rows.iter().min_by(|a, b| amount(a.sample.stretch).total_cmp(&amount(b.sample.stretch)));
        let row = least.expect("a branch has rows");
        let at = |row: &Row| {
            let point = first.points(std::slice::from_ref(row), set).ok()?.pop()?;
            Some([row.sample.stretch, soft.at(point.energy, point.peak).eta * point.stress])
        };
        line(row.sample, row.peak).filter_map(|sample| at(&Row { sample, ..*row })).collect()
    });
    let softened: Vec<Sample> = path.softened.iter().map(|r| r.sample).collect();
    let virgin = &path.virgin;
    let modes = virgin.iter().enumerate().filter(|(k, s)| virgin[..*k].iter().all(|other| other.mode != s.mode));
    let up = modes.filter_map(|(_, s)| {
        let own = virgin.iter().filter(|other| other.mode == s.mode);
        let last = own.max_by(|a, b| amount(a.stretch).total_cmp(&amount(b.stretch)))?;
        let points = line(Sample { stretch: 1.0, ..*last }, last.stretch).map(|s| [s.stretch, first.stress(&s)]);
        Some(points.filter(|p| p[1].is_finite()).collect())
    });
    let law: Vec<f64> = virgin.iter().map(|s| first.stress(s)).collect();
    vec![
        one("unloading and reloading", &softened, fitted, down.collect()),
        one("first loading", virgin, &law, up.collect()),
    ]
}

/// Samples at even distances from the stretch of `from` to the stretch `to`.
fn line(from: Sample, to: f64) -> impl Iterator<Item = Sample> {
    (0..=INTERVALS).map(move |k| {
        let t = k as f64 / INTERVALS as f64;
        Sample { stretch: from.stretch + t * (to - from.stretch), ..from }
    })
}
