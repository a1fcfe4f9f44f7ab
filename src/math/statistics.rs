//! Student's t distribution and the runs test, exact for any number of data points; mean, scatter and median of values.

/// Returns P(|T| ≤ t) for Student's t with ν degrees of freedom \[–\].
///
/// Finite trigonometric series in θ = atan(t/√ν): Abramowitz & Stegun, Handbook of Mathematical Functions (1964),
/// 26.7.3 (ν odd) and 26.7.4 (ν even).
pub fn t_probability(t: f64, nu: usize) -> f64 {
    assert!(nu >= 1, "Student's t needs a degree of freedom");
    let theta = (t.abs() / (nu as f64).sqrt()).atan();
    let (sin, cos) = theta.sin_cos();
    let odd = nu % 2 == 1;
    // Terms cos^k for k = 1, 3, … or 0, 2, … up to ν − 2, with the ratio k/(k+1) between neighbours
    let (mut term, mut k) = if odd { (cos, 1) } else { (1.0, 0) };
    let mut sum = 0.0;
    while k + 2 <= nu {
        sum += term;
        term *= cos * cos * (k + 1) as f64 / (k + 2) as f64;
        k += 2;
    }
    if odd { std::f64::consts::FRAC_2_PI * (theta + sin * sum) } else { sin * sum }
}

/// Returns t with P(|T| ≤ t) = `confidence` \[–\], by bisection to the last digit.
pub fn t_quantile(confidence: f64, nu: usize) -> f64 {
    let mut high = 1.0;
    while t_probability(high, nu) < confidence {
        high *= 2.0;
    }
    let mut low = 0.0;
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return high;
        }
        if t_probability(middle, nu) < confidence { low = middle } else { high = middle }
    }
}

/// Quantile of Student's t for real ν ≥ 1: ln t is interpolated linearly in 1/ν between the neighbouring integers. It is up to 3 % too large (at ν =
/// 1.5), and exact for integer ν.
pub fn real_quantile(confidence: f64, nu: f64) -> f64 {
    let low = nu.floor().max(1.0);
    let [a, b] = [low, low + 1.0].map(|n| t_quantile(confidence, n as usize).ln());
    let part = (1.0 / low - 1.0 / nu) / (1.0 / low - 1.0 / (low + 1.0));
    (a + part * (b - a)).exp()
}

/// The number of runs of these signs, and the probability that the same signs in random order have at most this number of runs (Wald & Wolfowitz,
/// Ann. Math. Statist. 11 (1940) 147–162). `None` if all signs are equal, because then there is nothing to order.
pub fn few_runs(positive: &[bool]) -> Option<(usize, f64)> {
    let n = positive.len();
    let a = positive.iter().filter(|s| **s).count();
    let b = n - a;
    if a == 0 || b == 0 {
        return None;
    }
    let runs = 1 + positive.windows(2).filter(|w| w[0] != w[1]).count();
    let log_factorial: Vec<f64> = std::iter::once(0.0)
        .chain((1..=n).scan(0.0, |sum, k| {
            *sum += (k as f64).ln();
            Some(*sum)
        }))
        .collect();
    let log_choose = |n: usize, k: usize| {
        if k > n { f64::NEG_INFINITY } else { log_factorial[n] - log_factorial[k] - log_factorial[n - k] }
    };
    let arrangements = |r: usize| {
        let k = r / 2;
        if r.is_multiple_of(2) {
            2.0 * (log_choose(a - 1, k - 1) + log_choose(b - 1, k - 1) - log_choose(n, a)).exp()
        } else {
            (log_choose(a - 1, k) + log_choose(b - 1, k - 1) - log_choose(n, a)).exp()
                + (log_choose(a - 1, k - 1) + log_choose(b - 1, k) - log_choose(n, a)).exp()
        }
    };
    Some((runs, (2..=runs).map(arrangements).sum::<f64>().min(1.0)))
}

/// Arithmetic mean; NaN without values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Sample variance, with n − 1 in the denominator.
pub fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() as f64 - 1.0)
}

/// Sample standard deviation, with n − 1 in the denominator.
pub fn deviation(values: &[f64]) -> f64 {
    variance(values).sqrt()
}

/// Half-width of the 95 % interval of a single value about the population mean, from the scatter of n ≥ 2 values: t_{n − 1} s.
pub fn half_width_of_one(values: &[f64]) -> f64 {
    t_quantile(0.95, values.len() - 1) * deviation(values)
}

/// Smallest and largest value; `[∞, −∞]` without values, NaN if any value is NaN.
pub fn extent(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| [smaller(a, s), larger(b, s)])
}

/// Difference of the largest and the smallest value; 0 without values, NaN if any value is NaN.
pub fn range(values: impl Iterator<Item = f64>) -> f64 {
    let [low, high] = extent(values);
    larger(high - low, 0.0)
}

/// The square root of a variance or another sum of squares that rounding may have made negative; NaN for NaN.
pub fn root(square: f64) -> f64 {
    larger(square, 0.0).sqrt()
}

/// The larger of two values; NaN if either is NaN, which `f64::max` ignores. `values.fold(0.0, larger)` is therefore below a bound only if every
/// value is; without values it is 0.
pub fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }
}

/// The smaller of two values; NaN if either is NaN, which `f64::min` ignores.
pub fn smaller(a: f64, b: f64) -> f64 {
    if a.is_nan() || b.is_nan() { f64::NAN } else { a.min(b) }
}

/// The median: the middle of the sorted values, or the mean of the two middle ones; NaN without values.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn middle_and_scatter() {
        assert_eq!(median(&[3.0, 1.0, 2.0, 10.0]), 2.5);
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert!(median(&[]).is_nan());
        assert_eq!((mean(&[1.0, 2.0, 6.0]), variance(&[1.0, 2.0, 6.0])), (3.0, 7.0));
        assert_eq!(half_width_of_one(&[1.0, 2.0, 6.0]), t_quantile(0.95, 2) * 7.0_f64.sqrt());
    }

    /// NaN is found wherever it is among the values, also in first position.
    #[test]
    fn what_is_not_a_number_is_not_left_out() {
        for place in 0..3 {
            let mut values = [1.0, 3.0, 2.0];
            let ends = |values: [f64; 3]| [values.into_iter().fold(0.0, larger), values.into_iter().fold(9.0, smaller)];
            assert_eq!(ends(values), [3.0, 1.0]);
            values[place] = f64::NAN;
            assert!(ends(values).iter().all(|end| end.is_nan()), "{values:?}");
        }
        assert_eq!([larger(f64::INFINITY, 1.0), smaller(1.0, f64::NEG_INFINITY)], [f64::INFINITY, f64::NEG_INFINITY]);
    }

    /// Two-sided 95 % points of Student's t. ν = 1 and 2 have closed forms: tan(0.475π) and √(2·0.95²/(1 − 0.95²)); the others are from printed
    /// tables, to their three decimals.
    #[test]
    fn quantiles_of_t() {
        let exact = [(1, (0.475 * std::f64::consts::PI).tan()), (2, (2.0_f64 * 0.9025 / 0.0975).sqrt())];
        for (nu, t) in exact {
            assert!((t_quantile(0.95, nu) / t - 1.0).abs() < 1e-12, "ν = {nu}: {}", t_quantile(0.95, nu));
        }
        for (nu, t) in [(3, 3.182), (4, 2.776), (5, 2.571), (10, 2.228), (30, 2.042), (120, 1.980)] {
            assert!((t_quantile(0.95, nu) - t).abs() < 5e-4, "ν = {nu}: {}", t_quantile(0.95, nu));
        }
    }

    /// For non-integer ν, within 3 % of the integral of the density (scipy 1.14), and not below it.
    #[test]
    fn real_quantiles_of_t() {
        for (nu, t) in
            [(1.0, 12.706205), (1.25, 8.027951), (1.5, 6.016663), (2.5, 3.574655), (5.5, 2.501859), (40.0, 2.021075)]
        {
            let ratio = real_quantile(0.95, nu) / t;
            assert!((1.0 - 1e-6..1.03).contains(&ratio), "ν = {nu}: {ratio}");
        }
    }

    /// NaN is not ignored as by `f64::max`.
    #[test]
    fn what_is_no_number_stays_so() {
        assert_eq!((range([2.0, -1.0, 0.5].into_iter()), range(std::iter::empty())), (3.0, 0.0));
        assert_eq!((root(4.0), root(-1e-20)), (2.0, 0.0));
        assert!(root(f64::NAN).is_nan());
        for values in [[f64::NAN, 1.0], [1.0, f64::NAN]] {
            assert!(range(values.into_iter()).is_nan() && extent(values.into_iter())[0].is_nan());
        }
    }

    /// By counting: 2 of the 6 orders of ++−− have 2 runs; the counts for 3 and 3 signs cover all orders.
    #[test]
    fn runs_are_counted_right() {
        assert_eq!(few_runs(&[true, true]), None);
        let (runs, p) = few_runs(&[true, true, false, false]).expect("both signs");
        assert_eq!(runs, 2);
        assert!((p - 2.0 / 6.0).abs() < 1e-14);
        let every = (0..64_u32).map(|bits| (0..6).map(|i| bits >> i & 1 == 1).collect::<Vec<_>>());
        let orders: Vec<_> = every.filter(|s| s.iter().filter(|x| **x).count() == 3).collect();
        for signs in &orders {
            let (runs, p) = few_runs(signs).expect("both signs");
            let counted = orders.iter().filter(|o| few_runs(o).expect("both signs").0 <= runs).count();
            assert!((p - counted as f64 / orders.len() as f64).abs() < 1e-13, "{signs:?}");
        }
    }
}
