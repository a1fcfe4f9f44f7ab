//! Scatter of a quantity between repeats, pooled over its records.
//!
//! ```text
//! s² = Σ νᵢ sᵢ²/Σ νᵢ,   νᵢ = nᵢ − 1                       of a single value, with Σ νᵢ degrees of freedom
//! u = (t₀.₉₇₅(Σ νᵢ)/1.96) s/√n                            of the mean of n values, as a normal distribution with the same 95 % interval
//! ```
//!
//! Assumption: all records of a quantity scatter equally. A record that scatters more than the others by more than chance (Cochran, *Ann. Eugen.* 11,
//! 1941, by draws) is treated separately. Two records with the same list of values are one measurement. Sources: JCGM 100:2008 (GUM), 4.2.4 (pooled
//! variance) and G.3 (Student's t). The sum of squares of such half-widths covers at least 95 % (Mickey & Brown, *Ann. Math. Stat.* 37, 1966).

use crate::math::random::SplitMix;
use crate::math::statistics::{t_quantile, variance};
use crate::study::kinds::validation::budget::COVERAGE;
use crate::study::kinds::validation::monte_carlo::{chi_square, quantiles};
use std::collections::BTreeMap;

/// Seed of the draws with equal scatter.
const SEED: u64 = 1941;
/// Probability that records with equal scatter are pooled. If one is separated by chance, the scatter of the others is too small.
const RARE: f64 = 0.99;

/// Scatter of single values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Variance s² \[unit²\]
    pub variance: f64,
    /// Its degrees of freedom
    pub freedom: usize,
}

impl Scatter {
    /// The scatter of some repeats; `None` for a single value.
    fn of(values: &[f64]) -> Option<Self> {
        (values.len() > 1).then(|| Self { variance: variance(values), freedom: values.len() - 1 })
    }

    fn pooled(all: &[Self]) -> Self {
        let freedom = all.iter().map(|s| s.freedom).sum();
        let squares: f64 = all.iter().map(|s| s.variance * s.freedom as f64).sum();
        Self { variance: squares / freedom as f64, freedom }
    }

    /// Returns the factor from s to the deviation of a normal distribution with the same 95 % interval.
    pub fn factor(&self) -> f64 {
        t_quantile(0.95, self.freedom) / COVERAGE
    }

    /// Returns the standard deviation of the mean of `values` values, including that factor.
    pub fn of_mean(&self, values: usize) -> f64 {
        self.factor() * (self.variance / values.max(1) as f64).sqrt()
    }
}

/// Repeats of one measurement.
#[derive(Clone, Debug)]
struct Repeated {
    /// Records with these values
    records: Vec<String>,
    scatter: Scatter,
}

/// Scatter of one quantity.
#[derive(Clone, Debug, Default)]
pub struct Repeats {
    /// Scatter of all records except those that are treated separately
    pub pooled: Option<Scatter>,
    alone: Vec<Repeated>,
}

impl Repeats {
    /// Computes the scatter from the measured values of all records.
    pub fn of(records: &BTreeMap<String, Vec<f64>>) -> Self {
        let mut lists: Vec<(&Vec<f64>, Repeated)> = vec![];
        for (name, values) in records {
            let Some(scatter) = Scatter::of(values) else { continue };
            match lists.iter_mut().find(|(known, _)| *known == values) {
                Some((_, same)) => same.records.push(name.clone()),
                None => lists.push((values, Repeated { records: vec![name.clone()], scatter })),
            }
        }
        let mut rest: Vec<Repeated> = lists.into_iter().map(|(_, r)| r).collect();
        rest.sort_by(|a, b| a.scatter.variance.total_cmp(&b.scatter.variance));
        let mut alone = vec![];
        while let Some(largest) = rest.pop() {
            let others: Vec<Scatter> = rest.iter().map(|r| r.scatter).collect();
            if !is_beyond_chance(largest.scatter, &others) {
                rest.push(largest);
                break;
            }
            alone.push(largest);
        }
        let rest: Vec<Scatter> = rest.iter().map(|r| r.scatter).collect();
        Self { pooled: (!rest.is_empty()).then(|| Scatter::pooled(&rest)), alone }
    }

    /// Returns the scatter of a record and its index among those of the quantity; `None` if all repeats are equal. A record without repeats of its
    /// own has the pooled scatter, as a single value.
    pub fn in_record(&self, name: &str) -> Option<(usize, Scatter)> {
        let own = self.alone.iter().position(|r| r.records.iter().any(|known| known == name));
        let found = match own {
            Some(k) => Some((k + 1, self.alone[k].scatter)),
            None => self.pooled.map(|s| (0, s)),
        };
        found.filter(|(_, s)| s.variance > 0.0)
    }

    /// Returns the records that are treated separately, with their scatter.
    pub fn alone(&self) -> impl Iterator<Item = (&str, Scatter)> {
        self.alone.iter().flat_map(|r| r.records.iter().map(|name| (name.as_str(), r.scatter)))
    }
}

/// Whether the largest scatter is above the 99 % quantile of the largest of as many equal ones. If all others have no scatter, with values equal to
/// the last digit, they are no measure of it.
fn is_beyond_chance(largest: Scatter, others: &[Scatter]) -> bool {
    let all = [others, &[largest]].concat();
    if others.iter().all(|s| s.variance == 0.0) {
        return false;
    }
    let ratio = |all: &[Scatter]| {
        let most = all.iter().map(|s| s.variance).fold(0.0, f64::max);
        most / Scatter::pooled(all).variance
    };
    let mut random = SplitMix(SEED);
    let drawn = |s: &Scatter, random: &mut SplitMix| Scatter {
        variance: chi_square(s.freedom, random) / s.freedom as f64,
        freedom: s.freedom,
    };
    let [limit] = quantiles([RARE], || ratio(&all.iter().map(|s| drawn(s, &mut random)).collect::<Vec<_>>()));
    ratio(&all) > limit
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repeats(records: &[(&str, &[f64])]) -> Repeats {
        Repeats::of(&records.iter().map(|(name, values)| ((*name).to_string(), values.to_vec())).collect())
    }

    /// Variances 2, 0 and 4 with 1, 1 and 2 degrees of freedom: (2 + 0 + 8)/4, and t for 4 degrees is 2.7764. Equal repeats and single values have it
    /// too.
    #[test]
    fn scatter_is_pooled() {
        let r = repeats(&[("a", &[1.0, 3.0]), ("b", &[5.0, 5.0]), ("c", &[6.0, 8.0, 10.0]), ("d", &[7.0])]);
        for name in ["a", "b", "c", "d"] {
            assert_eq!(r.in_record(name), Some((0, Scatter { variance: 2.5, freedom: 4 })));
        }
        let u = r.pooled.expect("repeats").of_mean(2);
        assert!((u - 2.776_445 / 1.959_964 * 1.25_f64.sqrt()).abs() < 1e-5, "{u}");
        assert!(repeats(&[("a", &[1.0]), ("b", &[])]).in_record("a").is_none());
    }

    /// The same list in two records is one measurement with one degree of freedom.
    #[test]
    fn a_measurement_counts_once() {
        let r = repeats(&[("gravity", &[5.0, 5.2]), ("gravity again", &[5.0, 5.2])]);
        assert_eq!(r.pooled.expect("repeats").freedom, 1);
    }

    /// Ten repeats that scatter 30 times as much as ten others are treated separately; two that do so, with two others, may do so by chance: F(1, 1)
    /// is above 900 or below 1/900 in 4.2 % of cases.
    #[test]
    fn scatter_beyond_chance_is_alone() {
        let of = |n: i32, size: f64| (0..n).map(|k| size * f64::from(k % 2)).collect::<Vec<f64>>();
        let r = repeats(&[("light", &of(10, 1.0)), ("heavy", &of(10, 30.0))]);
        let [light, heavy] = ["light", "heavy"].map(|name| r.in_record(name).expect("repeats"));
        assert!(light.0 != heavy.0 && (heavy.1.variance / light.1.variance - 900.0).abs() < 1e-9, "{r:?}");
        assert_eq!(r.alone().map(|(name, _)| name).collect::<Vec<_>>(), ["heavy"]);
        let few = repeats(&[("light", &of(2, 1.0)), ("heavy", &of(2, 30.0))]);
        assert_eq!(few.pooled.expect("repeats").freedom, 2);
        // Equal repeats do not make the scatter of the others exceed chance
        assert_eq!(repeats(&[("light", &[3.0; 9]), ("heavy", &of(9, 1.0))]).pooled.expect("repeats").freedom, 16);
    }
}
