//! Fits over ranges that end earlier or later, measured by |ln λ| in both tension and compression, and whether the constants of a shorter range
//! differ by more than the errors of both fits explain.
//!
//! If the law describes the data, the constants θₖ of a part of the data points are less precise than θ of all of them, and their difference has the
//! covariance Var θₖ − Var θ (Hausman, Econometrica 46, 1978, 1251–1271), which is σ²\[(JₖᵀJₖ)⁻¹ − (JᵀJ)⁻¹\] for equal errors. There are two
//! estimates of σ without the misfit of the law over the whole range: from the errors of θₖ in its own data points, and from the residual of all data
//! points beyond the departure β P(λ)/λ (`solve::Pattern`), which is the better one for a range with few data points. The t-tests with both
//! estimates, over all constants and ranges, share the level of 5 % (Bonferroni), so that a law that describes its data is reported to depend on the
//! range in at most one fit of twenty, although the shortest ranges have constants that are far off.
//!
//! A short range does not reveal that neighbours are correlated, and its own errors are then too small: with ρ = 0.9 that test alone found a
//! difference in 15 % of the fits. If the whole range shows correlation, the own errors of a range are used only if a pattern beyond the correlation
//! says that the law does not describe the data.
//!
//! Limits: linearised at the answer; the own errors of a range are those that its data points show.

use crate::calibrate::judgement::errors::directions;
use crate::calibrate::judgement::misfit::residuals;
use crate::calibrate::solve::{LawFit, LawSetting, ROUNDING, jacobian, solve_untested};
use crate::calibrate::{ErrorModel, Estimate, Experiment, Misfit, Mode, RangeRow, Sample, StretchRange};
use crate::math::statistics::{extent, t_probability};
use nalgebra::DMatrix;

/// Probability, over all constants and ranges, that random errors are reported as a difference \[–\]
const LEVEL: f64 = 0.05;
/// Number of tests of a constant in a range
const TESTS: usize = 2;

/// Amount of deformation, |ln λ|.
fn amount(stretch: f64) -> f64 {
    stretch.ln().abs()
}

/// The fits to other ranges.
pub struct ByRange {
    pub rows: Vec<RangeRow>,
    /// Smallest and largest value of each constant over the fitted range and those shorter ranges whose difference from it the errors do not explain
    pub spread: Vec<[f64; 2]>,
}

/// The fit to all data points of the fitted range.
pub struct Whole<'a> {
    setting: &'a LawSetting,
    fitted: &'a [Sample],
    answer: &'a LawFit,
}

impl<'a> Whole<'a> {
    pub fn of(setting: &'a LawSetting, fitted: &'a [Sample], answer: &'a LawFit) -> Self {
        Self { setting, fitted, answer }
    }

    /// The fits over about `count` other ranges.
    pub fn ranges(&self, experiment: &Experiment, modes: &[Mode], (range, count): (StretchRange, usize)) -> ByRange {
        let rows = self.repeated(experiment, modes, (range, count));
        ByRange { spread: self.spread(&rows), rows }
    }

    /// Repeats the fit with every end of the range that the data offer on its longer side, with about `count` of them if there are more.
    fn repeated(
        &self,
        experiment: &Experiment,
        modes: &[Mode],
        (range, ranges): (StretchRange, usize),
    ) -> Vec<RangeRow> {
        if ranges == 0 {
            return vec![];
        }
        let [low, high] = extent(self.fitted.iter().map(Sample::reach));
        let has_other_end =
            |s: &Sample| if amount(low) > amount(high) { s.reach() <= range.to } else { s.reach() >= range.from };
        let own = |s: &&Sample| modes.contains(&s.mode) && has_other_end(s) && s.is_informative();
        let mut samples: Vec<Sample> = experiment.samples.iter().filter(own).copied().collect();
        samples.sort_by(|a, b| amount(a.reach()).total_cmp(&amount(b.reach())));
        let needed = self.setting.model.parameters().len() + 1;
        let last_of_stretch =
            |&n: &usize| n == samples.len() || amount(samples[n].reach()) > amount(samples[n - 1].reach());
        let ends: Vec<usize> = (needed..=samples.len()).filter(last_of_stretch).collect();
        let step = ends.len().div_ceil(ranges).max(1);
        let chosen = ends.iter().rev().step_by(step).rev();
        let found: Vec<(RangeRow, LawFit)> = chosen.filter_map(|&n| self.part(&samples[..n])).collect();
        let tests = TESTS * needed.saturating_sub(1) * found.iter().filter(|(row, _)| self.is_longer(row)).count();
        let comparison = Comparison::new(self, tests);
        let compared = |(row, found): (RangeRow, LawFit)| match self.is_longer(&row) {
            true => RangeRow { departs: comparison.departs(row.to, &found), ..row },
            false => row,
        };
        found.into_iter().map(compared).collect()
    }

    /// The fit to some of the data points.
    fn part(&self, part: &[Sample]) -> Option<(RangeRow, LawFit)> {
        let found = solve_untested(&self.setting.of(part), part, self.answer).ok()?;
        let misfit = Misfit::of(&residuals(part, |s| self.setting.model.at(&found.values, s)))?;
        let row = RangeRow {
            to: part.last()?.reach(),
            rows: part.len(),
            parameters: found.identified.estimates.clone(),
            departs: vec![false; found.values.len()],
            rms_pa: misfit.rms_pa,
            rms_relative: misfit.rms_relative,
        };
        // A law that is infinite at its own data points is not a fit
        misfit.rms_pa.is_finite().then_some((row, found))
    }

    /// Whether the fitted range contains all data points of another range, and more.
    fn is_longer(&self, row: &RangeRow) -> bool {
        let [_, last] = extent(self.fitted.iter().map(|s| amount(s.reach())));
        amount(row.to) <= last && row.rows < self.fitted.len()
    }

    /// The spread of each constant.
    fn spread(&self, rows: &[RangeRow]) -> Vec<[f64; 2]> {
        let spread = |(k, own): (usize, f64)| {
            let departing = rows.iter().filter(|row| row.departs[k]).map(|row| row.parameters[k].value);
            extent(departing.chain([own]))
        };
        self.answer.identified.estimates.iter().map(|e| e.value).enumerate().map(spread).collect()
    }
}

/// The whole range, with which shorter ranges are compared.
struct Comparison<'a> {
    whole: &'a Whole<'a>,
    jacobian: DMatrix<f64>,
    /// √((JᵀJ)⁻¹ⱼⱼ)
    plain: Vec<f64>,
    /// Whether the errors that a range shows by itself are used
    own: bool,
    /// Standard deviation of an independent data point beyond the departure of the law, with its degrees of freedom
    beyond: Option<(f64, usize)>,
    /// P(|T| ≤ t) above which a difference is not explained by the errors; above 1 if the whole fit leaves only rounding
    limit: f64,
}

impl<'a> Comparison<'a> {
    fn new(whole: &'a Whole<'a>, tests: usize) -> Self {
        let Whole { setting, fitted, answer } = whole;
        let jacobian = jacobian(setting, fitted, answer);
        let plain = directions(&jacobian).plain();
        let misfit = Misfit::of(&residuals(fitted, |s| setting.model.at(&answer.values, s)));
        let is_rounding = misfit.is_none_or(|m| m.rms_relative <= ROUNDING);
        let limit = if is_rounding { f64::INFINITY } else { 1.0 - LEVEL / tests.max(1) as f64 };
        // Rows divided by the sizes of their errors have a different deviation
        let beyond = answer.pattern.beyond.filter(|_| answer.errors.sizes.is_none());
        let own = !matches!(answer.errors.model, ErrorModel::Correlated { .. }) || answer.pattern.is_found(1);
        Self { whole, jacobian, plain, own, beyond, limit }
    }

    /// Whether each constant of the range up to `to` differs by more than the errors explain.
    fn departs(&self, to: f64, found: &LawFit) -> Vec<bool> {
        let Whole { fitted, answer, .. } = self.whole;
        let rows: Vec<usize> = (0..fitted.len()).filter(|i| amount(fitted[*i].reach()) <= amount(to)).collect();
        let plain = directions(&self.jacobian.select_rows(&rows)).plain();
        let pairs = found.identified.estimates.iter().zip(&answer.identified.estimates);
        let one = |(j, (part, all)): (usize, (&Estimate, &Estimate))| {
            let difference = (part.value - all.value).abs();
            // √((JₖᵀJₖ)⁻¹ − (JᵀJ)⁻¹)ⱼⱼ
            let rest = (plain[j].powi(2) - self.plain[j].powi(2)).max(0.0).sqrt();
            let own = self.own.then_some((part.std_error / plain[j], found.errors.free));
            let is_beyond = |(size, free): (f64, usize)| {
                let deviation = size * rest;
                deviation > 0.0 && free > 0 && t_probability(difference / deviation, free) > self.limit
            };
            part.std_error.is_finite() && [own, self.beyond].into_iter().flatten().any(is_beyond)
        };
        pairs.enumerate().map(one).collect()
    }
}
