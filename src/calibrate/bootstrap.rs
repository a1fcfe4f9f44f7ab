//! Intervals of a fit to tests by the bootstrap: the fit repeated on resampled data points.
//!
//! Rows of a testing machine are correlated, so they are drawn in blocks of neighbours in λ, per mode, closed to a circle (Politis &
//! Romano, in Exploring the Limits of Bootstrap, 1992). The block is twice the lag at which the correlation of the residuals
//! ρ_k = Σ rᵢrᵢ₊ₖ/Σ rᵢ² falls below 1.96/√n, at most n/4; 1 where neighbours are not correlated. Of three or more specimens whole
//! specimens are drawn. The interval is that of the percentiles 2.5 and 97.5 (Efron & Tibshirani, An Introduction to the
//! Bootstrap, 1993, ch. 13).
//!
//! Each sample has its own seed, so the answer does not depend on the thread count. Limits: too narrow for few data points or specimens
//! (by √((n − 1)/n) at least), and for correlation longer than n/8 data points; a misfit of the law is resampled like noise.

use super::solve::{LawFit, LawSetting, constants};
use super::{Mode, Sample};
use crate::math::random::SplitMix;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Intervals from the scatter of repeated fits.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Bootstrap {
    /// Fits that were made
    pub samples: usize,
    /// Samples without enough different data points, or without an answer: not counted
    pub failed: usize,
    pub drawn: Drawn,
    pub seed: u64,
    /// Standard deviation of each constant \[SI\]
    pub std_errors: Vec<f64>,
    /// Percentiles 2.5 and 97.5 of each constant \[SI\]
    pub intervals: Vec<[f64; 2]>,
}

/// Unit of resampling.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Drawn {
    /// Blocks of so many neighbours, of the mode with the longest ones
    Rows {
        block: usize,
    },
    Specimens {
        specimens: usize,
    },
}

impl fmt::Display for Drawn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Rows { block: 1 } => f.write_str("data points"),
            Self::Rows { block } => write!(f, "blocks of {block} data points"),
            Self::Specimens { specimens } => write!(f, "{specimens} specimens"),
        }
    }
}

/// Specimens from which on they are drawn as a whole
pub const SPECIMENS: usize = 3;
const SEED: u64 = 0x00d0_3e7e;
/// Samples that have to succeed for a percentile to mean something
const LEAST: usize = 40;

/// `groups`: the fitted data points, specimen by specimen. `None` where fewer than 40 samples could be fitted.
pub fn bootstrap(setting: &LawSetting, groups: &[Vec<Sample>], answer: &LawFit, samples: usize) -> Option<Bootstrap> {
    let (drawn, plan) = if groups.len() >= SPECIMENS {
        (Drawn::Specimens { specimens: groups.len() }, Plan::Specimens(groups))
    } else {
        let strips = strips(setting, &groups.concat(), answer);
        (Drawn::Rows { block: strips.iter().map(|s| s.block).max()? }, Plan::Rows(strips))
    };
    let p = answer.values.len();
    let one = |k: usize| {
        let rows = plan.draw(&mut SplitMix(SplitMix(SEED ^ k as u64).bits()));
        let mut different: Vec<_> = rows.iter().map(|s| (s.mode, s.stretch.to_bits(), s.second.to_bits())).collect();
        different.sort_unstable();
        different.dedup();
        (different.len() >= p).then(|| constants(setting, &rows, Some(answer)).ok()).flatten().map(|f| f.values)
    };
    let found: Vec<Vec<f64>> =
        (0..samples).into_par_iter().map(one).collect::<Vec<_>>().into_iter().flatten().collect();
    if found.len() < LEAST {
        return None;
    }
    let sorted = |k: usize| {
        let mut all: Vec<f64> = found.iter().map(|v| v[k]).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let columns: Vec<Vec<f64>> = (0..p).map(sorted).collect();
    Some(Bootstrap {
        samples,
        failed: samples - found.len(),
        drawn,
        seed: SEED,
        std_errors: columns.iter().map(|c| deviation(c)).collect(),
        intervals: columns.iter().map(|c| [percentile(c, 0.025), percentile(c, 0.975)]).collect(),
    })
}

/// Standard deviation with n − 1.
pub fn deviation(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
}

/// Of ascending values, between neighbours by a straight line.
fn percentile(sorted: &[f64], part: f64) -> f64 {
    let at = part * (sorted.len() - 1) as f64;
    let k = (at as usize).min(sorted.len() - 2);
    sorted[k] + (at - k as f64) * (sorted[k + 1] - sorted[k])
}

/// Rows of one mode in the order of λ.
struct Strip {
    rows: Vec<Sample>,
    block: usize,
}

enum Plan<'a> {
    Rows(Vec<Strip>),
    Specimens(&'a [Vec<Sample>]),
}

impl Plan<'_> {
    fn draw(&self, random: &mut SplitMix) -> Vec<Sample> {
        match self {
            Self::Specimens(groups) => groups.iter().flat_map(|_| groups[random.below(groups.len())].clone()).collect(),
            Self::Rows(strips) => strips.iter().flat_map(|s| s.draw(random)).collect(),
        }
    }
}

impl Strip {
    /// As many data points as there are.
    fn draw(&self, random: &mut SplitMix) -> Vec<Sample> {
        let n = self.rows.len();
        let starts: Vec<usize> = (0..n.div_ceil(self.block)).map(|_| random.below(n)).collect();
        let blocks = starts.into_iter().flat_map(|s| (s..s + self.block).map(|k| self.rows[k % n]));
        blocks.take(n).collect()
    }
}

fn strips(setting: &LawSetting, samples: &[Sample], answer: &LawFit) -> Vec<Strip> {
    let of = |mode: Mode| {
        let own = samples.iter().zip(&answer.weight).filter(|(s, _)| s.mode == mode);
        let residual = |s: &Sample, w: f64| w * (s.stress - setting.model.at(&answer.values, s));
        let mut rows: Vec<(Sample, f64)> = own.map(|(s, w)| (*s, residual(s, *w))).collect();
        rows.sort_by(|a, b| a.0.stretch.total_cmp(&b.0.stretch));
        let (rows, r): (Vec<Sample>, Vec<f64>) = rows.into_iter().unzip();
        (!rows.is_empty()).then(|| Strip { block: block(&r), rows })
    };
    Mode::ALL.into_iter().filter_map(of).collect()
}

/// Length of the blocks for these residuals in order.
pub(super) fn block(r: &[f64]) -> usize {
    let n = r.len();
    let most = (n / 4).max(1);
    let square: f64 = r.iter().map(|x| x * x).sum();
    let level = 1.96 / (n as f64).sqrt();
    let correlation = |k: usize| r.iter().zip(&r[k..]).map(|(a, b)| a * b).sum::<f64>() / square;
    let lag = (1..most).find(|k| square == 0.0 || correlation(*k) < level).unwrap_or(most);
    if lag == 1 { 1 } else { (2 * lag).min(most) }
}
