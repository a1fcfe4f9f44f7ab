//! Whether the data scatter as their errors predict, and otherwise by how much more.
//!
//! χ² of the calibration is compared with its 95 % and its 1 % quantile. If all errors are known, these are quantiles of the χ² distribution. The
//! scatter of a few repeats is itself known only with few degrees of freedom ν, and χ² is then distributed as F: its quantiles come from draws in
//! which σ² = s² ν/χ²(ν), with one χ²(ν) for all data with that scatter (JCGM 101:2008, 6.4.9) and a response that is linear in constants and
//! sources.

use crate::math::random::SplitMix;
use crate::study::kinds::validation::joint::{FARTHEST, Problem, Response, Solution};
use crate::study::kinds::validation::monte_carlo::{chi_square, quantiles};
use std::collections::BTreeMap;

/// Seed of the draws of χ².
const SEED: u64 = 1932;
/// Upper bound of χ² for an exact fit, in which the search leaves residuals of at most 0.03 standard deviations.
const EXACT: f64 = 1e-3;
/// Probabilities of the limits of χ².
const LIMITS: [f64; 2] = [0.01, 0.95];
/// Quantiles of the normal distribution at these probabilities.
const NORMAL: [f64; 2] = [-2.326_347_874, 1.644_853_627];

/// χ² of a calibration and its admissible range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Consistency {
    pub chi2: f64,
    /// Number of data minus number of constants
    pub freedom: usize,
    /// 1 % and 95 % quantiles of χ² predicted by the errors of the data
    limits: [f64; 2],
}

impl Consistency {
    pub fn of(problem: &Problem, solution: &Solution) -> Self {
        let is_known = problem.data.iter().all(|r| r.scatter.is_none());
        let known = || NORMAL.map(|z| quantile(solution.freedom, z));
        let limits = if is_known { known() } else { drawn(problem, solution) };
        Self { chi2: solution.chi2, freedom: solution.freedom, limits }
    }

    /// Whether χ² is below its 95 % quantile. As many constants as data fit them exactly, unless the search ends where no constant brings them
    /// closer.
    pub fn holds(&self) -> bool {
        self.chi2 <= if self.freedom == 0 { EXACT } else { self.limits[1] }
    }

    /// Whether χ² is below its 1 % quantile, as it is if errors are overstated, or if errors shared by many data are treated as independent.
    pub fn agrees_too_well(&self) -> bool {
        self.freedom > 0 && self.chi2 < self.limits[0]
    }

    /// Returns a constant that the scatter of the data leaves undetermined over the whole range of the search, if that scatter is beyond chance: the
    /// search has then ended at a point where the data do not depend on the constant, and their misfit is no measure of it.
    pub fn open(&self, solution: &Solution) -> Option<usize> {
        let deviation = |k: &usize| self.birge() * solution.covariance[(*k, *k)].sqrt();
        (0..solution.xi.len()).find(|k| !self.holds() && deviation(k) > FARTHEST)
    }

    /// Returns the factor √(χ²/ν) by which the data scatter more than their errors predict, if that is beyond chance; otherwise 1.
    /// Source: Birge, *Phys. Rev.* 40, 1932.
    pub fn birge(&self) -> f64 {
        if self.holds() { 1.0 } else { (self.chi2 / self.freedom as f64).sqrt().max(1.0) }
    }
}

/// Quantile of χ² from that of the normal distribution (Wilson & Hilferty, *PNAS* 17, 1931).
fn quantile(freedom: usize, normal: f64) -> f64 {
    let nu = freedom as f64;
    let a = 2.0 / (9.0 * nu);
    nu * (1.0 - a + normal * a.sqrt()).powi(3)
}

/// Both limits if the scatter of repeats is estimated.
fn drawn(problem: &Problem, solution: &Solution) -> [f64; 2] {
    let mut random = SplitMix(SEED);
    let parts: Vec<[f64; 2]> = problem.data.iter().map(|r| parts(r)).collect();
    quantiles(LIMITS, || {
        let mut scale: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        let error = |(r, [known, scatter]): (&&Response, &[f64; 2])| {
            let by_scatter = r.scatter.map_or(0.0, |s| {
                let nu = s.freedom as f64;
                scatter * scale.entry(s.pool).or_insert_with(|| nu / chi_square(s.freedom, &mut random)).to_owned()
            });
            (known + by_scatter).sqrt() * random.normal()
        };
        let errors: Vec<f64> = problem.data.iter().zip(&parts).map(error).collect();
        let sources: Vec<f64> = (0..problem.sources).map(|_| random.normal()).collect();
        solution.misfit(problem, &errors, &sources)
    })
}

/// Variances of a datum due to known errors and due to the scatter s²/n without its widening, relative to the variance in its weight.
fn parts(r: &Response) -> [f64; 2] {
    let total = r.sigma().powi(2);
    let wide = r.scatter.and(r.noise.last()).map_or(0.0, |s| s * s);
    let scatter = r.scatter.map_or(0.0, |s| wide / s.factor.powi(2));
    [(total - wide) / total, scatter / total]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::kinds::validation::surface::{Sample, Surface};

    /// Data drawn from the true model are called inconsistent in 5 % of cases: the 95 % quantiles for ν = 2 and 10 from tables (5.991, 18.307), which
    /// Wilson & Hilferty approximate within 1 %.
    #[test]
    fn the_quantile_of_chi_square_is_that_of_the_tables() {
        for (nu, expected) in [(2, 5.991), (10, 18.307)] {
            let with = |chi2| Consistency { chi2, freedom: nu, limits: NORMAL.map(|z| quantile(nu, z)) };
            assert!(with(0.99 * expected).holds() && !with(1.01 * expected).holds());
        }
        let with = |chi2, freedom| Consistency { chi2, freedom, limits: NORMAL.map(|z| quantile(freedom, z)) };
        assert_eq!(with(40.0, 10).birge(), 2.0);
        // The 1 % quantile for ν = 10 (2.558) is met within 2 %; with one or zero degrees of freedom data never agree too well
        assert!(with(0.97 * 2.558, 10).agrees_too_well() && !with(2.558, 10).agrees_too_well());
        assert!(!with(1e-9, 1).agrees_too_well() && !with(0.0, 0).agrees_too_well());
    }

    /// A parabola never falls below its vertex: a datum there leaves the constant undetermined, even if there are two equal data; one above it does
    /// not.
    #[test]
    fn a_datum_out_of_reach_leaves_its_constant_open() {
        let at = |x: f64| Sample {
            at: vec![x],
            value: (x - 1.5).powi(2),
            by_constants: vec![2.0 * (x - 1.5)],
            by_inputs: vec![],
        };
        let surface = Surface::fit(1, &[at(-1.0), at(0.0), at(1.0)]).expect("three runs");
        let noise = vec![0.1];
        let one = Response { surface, constants: vec![0], inputs: vec![], noise, scatter: None, shared: vec![] };
        for (values, open) in
            [(vec![-10.0], true), (vec![-10.0, -10.0], true), (vec![1.0], false), (vec![1.0, 1.1], false)]
        {
            let problem = Problem { constants: 1, sources: 0, data: vec![&one; values.len()] };
            let found = problem.solve(&values).map(|s| Consistency::of(&problem, &s).open(&s));
            let is_refused = found.as_ref().map_or(true, Option::is_some);
            assert_eq!(is_refused, open, "{values:?}: {found:?}");
        }
    }
}
