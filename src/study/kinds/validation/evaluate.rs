//! The value of a quantity of a record, with its derivatives.

use crate::math::statistics::{larger, range};
use crate::motion::Curve;
use crate::motion::ring_down::{Creep, RingDown, ring_down};
use crate::study::kinds::validation::plan::QuantityPlan;
use crate::study::kinds::validation::spec::Evaluation;
use crate::study::store::record::Series;

/// Fraction of the range of a curve by which it is shifted along a derivative, for central differences of its ring-down: the error is of the order of
/// its square, the rounding error is 1e-12 divided by it.
const STEP: f64 = 1e-4;

/// Returns the value of a quantity and its derivatives by keys in SI, in its unit. `None` if the column or a derivative of it is missing, or if
/// nothing rings.
pub fn evaluate(
    q: &QuantityPlan,
    series: &Series,
    derivatives: Option<&Series>,
    keys: &[String],
) -> Option<(f64, Vec<f64>)> {
    let column = series.columns.get(&q.column)?;
    let along = |key: &String| derivatives?.columns.get(&format!("d {}/d {key}", q.column));
    let directions: Vec<&Vec<f64>> = keys.iter().map(along).collect::<Option<_>>()?;
    let linear = |f: fn(f64, f64) -> f64| {
        let of = |c: &Vec<f64>| Some(f(*c.first()?, *c.last()?));
        Some((of(column)?, directions.iter().map(|d| of(d)).collect::<Option<Vec<f64>>>()?))
    };
    let ringing = |of: fn(&RingDown) -> f64| {
        let at = |d: &[f64], step: f64| {
            let moved = column.iter().zip(d).map(|(y, d)| y + step * d).collect();
            let curve = Curve::new(&q.column, series.t_s.clone(), moved).ok()?;
            ring_down(&curve, q.window?, 0.0, Creep::default()).ok().map(|r| of(&r))
        };
        let extent = |c: &[f64]| c.iter().fold(0.0, |m: f64, v| m.max((v - c[0]).abs()));
        let derivative = |d: &&Vec<f64>| {
            let step = STEP * extent(column) / extent(d);
            if step.is_finite() { Some((at(d, step)? - at(d, -step)?) / (2.0 * step)) } else { Some(0.0) }
        };
        Some((at(column, 0.0)?, directions.iter().map(derivative).collect::<Option<Vec<f64>>>()?))
    };
    let (value, by) = match q.value {
        Evaluation::Final => linear(|_, last| last)?,
        Evaluation::Change => linear(|first, last| last - first)?,
        Evaluation::Frequency => ringing(|r| r.frequency_hz.value)?,
        Evaluation::Decay => ringing(|r| r.decay_per_s.value)?,
    };
    let all_finite = value.is_finite() && by.iter().all(|d| d.is_finite());
    all_finite.then(|| (q.factor * value, by.into_iter().map(|d| q.factor * d).collect()))
}

/// Returns how far the column of a quantity taken from its last row oscillates over the last third of the run, relative to its largest change; zero
/// for a ramp.
pub fn still_rings(q: &QuantityPlan, series: &Series) -> Option<f64> {
    if !matches!(q.value, Evaluation::Final | Evaluation::Change) {
        return None;
    }
    let column = series.columns.get(&q.column)?;
    let (first, end) = (*column.first()?, *series.t_s.last()?);
    let late: Vec<f64> = column
        .iter()
        .zip(&series.t_s)
        .filter(|(_, t)| **t >= end - (end - series.t_s[0]) / 3.0)
        .map(|(y, _)| *y)
        .collect();
    let net = (late.last()? - late.first()?).abs();
    let share =
        (range(late.iter().copied()) - net) / column.iter().fold(0.0, |most, y| larger(most, (y - first).abs()));
    share.is_finite().then_some(share)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(value: Evaluation) -> QuantityPlan {
        QuantityPlan {
            name: "tip".into(),
            label: "tip".into(),
            symbol: "u".into(),
            unit: "mm".into(),
            column: "tip_x_m".into(),
            value,
            factor: 1e3,
            window: None,
            records: [].into(),
            errors: vec![],
            by_record: [].into(),
        }
    }

    /// A release that is still ringing is reported; one that has come to rest and a ramp that continues are not, and a frequency is not taken from
    /// the last row.
    #[test]
    fn a_last_row_that_rings_is_told() {
        let t_s: Vec<f64> = (0..=200).map(|k| 0.01 * f64::from(k)).collect();
        let of = |value: Evaluation, y: &dyn Fn(f64) -> f64| {
            let columns = [("tip_x_m".to_string(), t_s.iter().map(|t| y(*t)).collect())].into();
            still_rings(&plan(value), &Series { t_s: t_s.clone(), columns })
        };
        let ring = |decay: f64| move |t: f64| 1.0 - (20.0 * t).cos() * (-decay * t).exp();
        assert!(of(Evaluation::Final, &ring(0.5)).is_some_and(|share| share > 0.2));
        assert!(of(Evaluation::Change, &ring(6.0)).is_some_and(|share| share < 1e-3));
        assert!(of(Evaluation::Final, &|t| 3.0 * t).is_some_and(|share| share < 1e-9));
        assert_eq!(of(Evaluation::Frequency, &ring(0.5)), None);
    }
}
