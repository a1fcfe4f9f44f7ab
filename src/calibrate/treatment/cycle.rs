//! Loading and unloading in a table, and which loading is fitted.
//!
//! With a = |ln λ| in the order of the rows, a branch ends at an extremum of a from which a returns by more than 2 % of its largest value. Rubbers
//! soften in the first loading (Mullins, Rubber Chem. Technol. 42 (1969) 339–362): one law describes one loading, not a mean over loading and
//! unloading. If a table has tension and compression, each of them has its own loadings.
//!
//! Scatter of the measured strain is not unloading. Loadings are separated by the median of each row and its neighbours, which ignores single wrong
//! rows, and a has to return by more than the range of n normal errors, 2√(2 ln n) σ (David & Nagaraja, *Order Statistics*, 2003, ch. 10), σ from the
//! median of
//! |aₖ − ½(aₖ₋₁ + aₖ₊₁)|/√1.5 (Gasser, Sroka & Jennen-Steinmetz, Biometrika 73, 1986).
//!
//! A hold of the stretch at the end of a loading is not part of it: [`super::hold`].
//!
//! Limits: rows out of order have no branches; a table has cycles only if branches of five or more rows hold four fifths of it; a loop of the size of
//! the scatter is not found.

use crate::calibrate::{FitError, Sample};
use crate::math::statistics::median;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// The part of a table with several branches that is fitted.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Cycle {
    FirstLoading,
    LastLoading,
    /// Counted from 1
    Loading(usize),
    /// Every row, including unloading
    All,
}

impl FromStr for Cycle {
    type Err = String;
    fn from_str(word: &str) -> Result<Self, String> {
        match word {
            "first-loading" => Ok(Self::FirstLoading),
            "last-loading" => Ok(Self::LastLoading),
            "all" => Ok(Self::All),
            _ => word.parse().ok().filter(|n| *n > 0).map(Self::Loading).ok_or_else(|| {
                format!("\"{word}\" is not a cycle; known: first-loading, last-loading, a number from 1 on, all")
            }),
        }
    }
}

impl TryFrom<String> for Cycle {
    type Error = String;
    fn try_from(word: String) -> Result<Self, String> {
        word.parse()
    }
}

impl From<Cycle> for String {
    fn from(cycle: Cycle) -> Self {
        cycle.to_string()
    }
}

impl fmt::Display for Cycle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FirstLoading => f.write_str("first-loading"),
            Self::LastLoading => f.write_str("last-loading"),
            Self::Loading(n) => write!(f, "{n}"),
            Self::All => f.write_str("all"),
        }
    }
}

/// Share of the largest |ln λ| by which rows have to return to end a branch \[–\]
const REVERSAL: f64 = 0.02;
/// Least number of rows of a branch that counts, and the share of all rows that such branches must hold
const LEAST: usize = 5;
const HELD: f64 = 0.8;

/// Rows from one extremum of a to the next.
#[derive(Clone, PartialEq, Debug)]
pub struct Branch {
    pub loading: bool,
    pub rows: Range<usize>,
}

/// Branches in the order of the rows, without smoothing.
pub fn branches(samples: &[&Sample]) -> Vec<Branch> {
    let a = path(samples);
    divided(&a, reversal(&a))
}

/// a = |ln λ| of every row.
pub fn path(samples: &[&Sample]) -> Vec<f64> {
    samples.iter().map(|s| s.stretch.ln().abs()).collect()
}

/// The smallest amount by which a has to return.
fn reversal(a: &[f64]) -> f64 {
    REVERSAL * a.iter().copied().fold(0.0, f64::max)
}

/// Range of the independent errors of a from row to row.
pub fn scatter(a: &[f64]) -> f64 {
    let bends: Vec<f64> = a.windows(3).map(|w| (w[1] - 0.5 * (w[0] + w[2])).abs()).collect();
    if bends.is_empty() {
        return 0.0;
    }
    let deviation = 1.4826 * median(&bends) / 1.5_f64.sqrt();
    2.0 * (2.0 * (a.len() as f64).ln()).sqrt() * deviation
}

/// Medians of each row and its neighbours.
pub fn medians(a: &[f64]) -> Vec<f64> {
    (0..a.len()).map(|k| if k == 0 || k + 1 == a.len() { a[k] } else { median(&a[k - 1..k + 2]) }).collect()
}

/// Branches that end where a returns by more than `reversal`.
fn divided(a: &[f64], reversal: f64) -> Vec<Branch> {
    let mut found = Vec::new();
    let (mut loading, mut start, mut extreme) = (true, 0, 0);
    for k in 1..a.len() {
        let ahead = if loading { a[k] - a[extreme] } else { a[extreme] - a[k] };
        if ahead >= 0.0 {
            extreme = k;
        } else if ahead < -reversal {
            found.push(Branch { loading, rows: start..extreme + 1 });
            (loading, start, extreme) = (!loading, extreme + 1, k);
        }
    }
    if start < a.len() {
        found.push(Branch { loading, rows: start..a.len() });
    }
    found
}

/// Branches of the medians, each extended to the extremum of the rows themselves.
fn quiet_branches(a: &[f64]) -> Vec<Branch> {
    let mut found = divided(&medians(a), reversal(a).max(scatter(a)));
    for k in 1..found.len() {
        let turn = found[k].rows.start - 1;
        let sign = if found[k - 1].loading { 1.0 } else { -1.0 };
        let near = turn.saturating_sub(1).max(found[k - 1].rows.start)..(turn + 2).min(found[k].rows.end);
        let extreme = near.max_by(|i, j| (sign * a[*i]).total_cmp(&(sign * a[*j]))).unwrap_or(turn);
        found[k - 1].rows.end = extreme + 1;
        found[k].rows.start = extreme + 1;
    }
    found
}

/// Lines in which the stretch jumps from its extremum back to the beginning within one row, which no machine does.
pub fn jumps(samples: &[Sample]) -> Vec<u64> {
    let a = |s: &Sample| s.stretch.ln().abs();
    let largest = samples.iter().map(a).fold(0.0, f64::max);
    samples.windows(2).filter(|w| a(&w[0]) - a(&w[1]) > 0.5 * largest).map(|w| w[1].line).collect()
}

/// Rows of each loading; `None` if the rows are a single loading or out of order.
pub fn loadings(samples: &[&Sample]) -> Option<Vec<Range<usize>>> {
    loadings_along(&path(samples))
}

/// Rows of each loading for rows with these values of a, which grow from rest; `None` if they are a single loading or out of order.
pub fn loadings_along(a: &[f64]) -> Option<Vec<Range<usize>>> {
    let all = quiet_branches(a);
    let long: Vec<Branch> = all.into_iter().filter(|b| b.rows.len() >= LEAST).collect();
    let held: usize = long.iter().map(|b| b.rows.len()).sum();
    let first = long.iter().position(|b| b.loading)?;
    if first + 1 == long.len() || (held as f64) < HELD * a.len() as f64 {
        return None;
    }
    Some(long.into_iter().filter(|b| b.loading).map(|b| b.rows).collect())
}

/// The rows of the chosen loading; refuses a loading that does not exist.
pub fn pick(file: &str, loadings: &[Range<usize>], rows: usize, cycle: Cycle) -> Result<Range<usize>, FitError> {
    let found = loadings.len();
    match cycle {
        Cycle::All => Ok(0..rows),
        Cycle::FirstLoading => Ok(loadings[0].clone()),
        Cycle::LastLoading => Ok(loadings[found - 1].clone()),
        Cycle::Loading(n) => {
            loadings.get(n - 1).cloned().ok_or_else(|| FitError::NoCycle { file: file.into(), asked: n, found })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Mode;

    fn path(stretches: &[f64]) -> Vec<Sample> {
        let sample =
            |s: &f64| Sample { mode: Mode::Uniaxial, stretch: *s, second: 1.0, stress: 1.0, line: 1, specimen: 0 };
        stretches.iter().map(sample).collect()
    }

    fn found(stretches: &[f64]) -> Option<Vec<Range<usize>>> {
        let samples = path(stretches);
        loadings(&samples.iter().collect::<Vec<_>>())
    }

    #[test]
    fn loadings_are_found_by_their_turning_points() {
        let up: Vec<f64> = (0..10).map(|k| 1.0 + 0.1 * f64::from(k)).collect();
        let down: Vec<f64> = up.iter().rev().skip(1).copied().collect();
        let twice = [&up[..], &down[..], &up[1..], &down[..]].concat();
        assert_eq!(found(&twice), Some(vec![0..10, 19..28]));
        assert_eq!(found(&up), None, "one loading");
        assert_eq!(found(&down), None, "listed from the end");
        // Two runs in succession: the jump back is not a branch of its own
        let runs = [&up[..], &up[..]].concat();
        assert_eq!(found(&runs).map(|l| l.len()), Some(2));
        // Noise of 1 % of the range does not create a branch
        let noisy: Vec<f64> = up.iter().enumerate().map(|(k, l)| l + 0.005 * f64::from(k as u32 % 2)).collect();
        assert_eq!(found(&noisy), None);
        // A wrong row is not unloading
        let mut wrong = [&up[..], &down[..], &up[1..], &down[..]].concat();
        (wrong[5], wrong[24]) = (1.1, 1.9);
        assert_eq!(found(&wrong), Some(vec![0..10, 19..28]));
        wrong.truncate(10);
        assert_eq!(found(&wrong), None);
        let shuffled: Vec<f64> = (0..40).map(|k| 1.0 + f64::from(k * 17 % 40) / 40.0).collect();
        assert_eq!(found(&shuffled), None, "rows out of order have no branches");
        // Small loops during the loading, and loops that do not return to rest
        let loops: Vec<f64> = (0..300).map(|k| 1.0 + 2e-3 * f64::from(k) + 0.05 * (f64::from(k) / 5.0).sin()).collect();
        assert_eq!(found(&loops).map(|l| l.len()), Some(10));
        // Compression is loading too
        let pressed: Vec<f64> = twice.iter().map(|l| 1.0 / l).collect();
        assert_eq!(found(&pressed), Some(vec![0..10, 19..28]));
    }
}
