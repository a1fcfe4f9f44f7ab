//! The samples on which two curves are compared.

use crate::study::curve::Curve;

/// Difference of two times, relative to the duration of the run, below which they count as one.
const ROUNDING: f64 = 1e-9;

/// Times of the first and the last sample of a curve \[s\].
pub fn span(curve: &Curve) -> [f64; 2] {
    [curve.t[0], curve.t[curve.t.len() - 1]]
}

/// The times of the samples of both curves \[s\], with the time of `f` where two coincide; `None` if the curves do not cover the same time.
pub fn of_both(f: &Curve, g: &Curve) -> Option<Vec<f64>> {
    let ([a, b], [c, d]) = (span(f), span(g));
    let slack = ROUNDING * (b - a).max(d - c);
    if (a - c).abs() > slack || (b - d).abs() > slack {
        return None;
    }
    let is_new = |t: &f64| {
        let k = f.t.partition_point(|own| own < t);
        f.t[k.saturating_sub(1)..].iter().take(2).all(|own| (own - t).abs() > slack)
    };
    let mut all: Vec<f64> = f.t.iter().copied().chain(g.t.iter().copied().filter(is_new)).collect();
    all.sort_by(f64::total_cmp);
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_samples_of_both_are_merged_where_the_time_is_the_same() {
        let curve = |t: &[f64]| Curve { t: t.to_vec(), f: vec![0.0; t.len()] };
        let fine = curve(&[0.0, 0.25, 0.5, 1.0]);
        assert_eq!(of_both(&curve(&[0.0, 0.4, 1.0 + 1e-13]), &fine), Some(vec![0.0, 0.25, 0.4, 0.5, 1.0 + 1e-13]));
        assert_eq!(of_both(&fine, &fine), Some(fine.t.clone()));
        assert_eq!(of_both(&curve(&[0.0, 0.5]), &fine), None);
        assert_eq!(of_both(&curve(&[0.1, 1.0]), &fine), None);
    }
}
