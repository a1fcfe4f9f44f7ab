//! Identifiability: intervals from the Jacobian, and the names of the directions that the data do not determine.
//!
//! S = J diag(z)/‖wP‖ are sensitivities to relative changes of the constants, z = |value|. With S = UΣVᵀ, the residual r and s² = ‖r‖²/(n − p), the
//! change along the direction v_k has the standard deviation s/(‖wP‖σ_k), relative to the constants. A constant that takes part in a direction with
//! σ_k below 1e-10 of the largest has an infinite standard error; a pseudo-inverse would report no error along it. Source: Seber & Wild, *Nonlinear
//! Regression*, 1989, ch. 5; Belsley, *Conditioning Diagnostics*, 1991.
//!
//! Limits: the interval is that of the law linearised at the answer, and ignores active constraints.

use super::directions::BLIND;
use super::errors::Errors;
use super::estimate::{Direction, Estimate};
use crate::calibrate::fittable_law::unit;
use crate::calibrate::solve::rows::padded;
use crate::material::Parameter;
use crate::math::statistics;
use crate::math::svd::svd;
use crate::math::units::Dimension;
use nalgebra::{DMatrix, DVector};

/// Component of a direction below which it counts as zero \[–\]
const PART: f64 = 1e-6;
/// Half-width of the 95 % interval along a direction, relative to the constants, from which on the data do not determine it \[–\]
const LOOSE: f64 = 1.0;

/// Constants with their intervals, and the directions that are not determined.
#[derive(Clone, Debug, Default)]
pub struct Identified {
    pub estimates: Vec<Estimate>,
    pub directions: Vec<Direction>,
    /// Description of the direction that the data determine least
    pub least: String,
}

/// Computes intervals and open directions. `residual` and `jacobian` \[weighted Pa\], (n) and (n × p); `size` = ‖wP‖; a relative change of the
/// constants that changes the stresses by less than `rounding` counts as not determined. Changes are relative to `bases`, and to the size of the
/// curve where these are zero. `errors`: those of the data points, independent by default.
pub fn identify(
    parameters: &[Parameter],
    (values, bases): (&[f64], &[f64]),
    jacobian: &DMatrix<f64>,
    residual: &DVector<f64>,
    size: f64,
    rounding: f64,
    errors: Option<&Errors>,
) -> Identified {
    let (n, p) = (residual.len(), values.len());
    let scale: Vec<f64> = (0..p)
        .map(|k| {
            let length = jacobian.column(k).norm();
            if bases[k] != 0.0 {
                bases[k].abs()
            } else if length > 0.0 {
                size / length
            } else {
                1.0
            }
        })
        .collect();
    let s = DMatrix::from_fn(n, p, |i, k| jacobian[(i, k)] * scale[k] / size);
    let svd = svd(padded(&s, p), false, true);
    let (sigma, vt) = (svd.singular_values, svd.v_t.expect("asked for"));
    let blind = |k: usize| sigma[k] <= (BLIND * sigma.max()).max(rounding);
    let free = n.saturating_sub(p);
    let error = if free > 0 { residual.norm() / (free as f64).sqrt() / size } else { f64::INFINITY };
    let deviation = |k: usize| if blind(k) { f64::INFINITY } else { error / sigma[k] };
    let degrees = errors.map_or(free, |e| e.free);
    let quantile = if free > 0 { statistics::t_quantile(0.95, degrees) } else { f64::INFINITY };
    let estimate = |(i, q): (usize, &Parameter)| {
        // An infinite deviation along a direction makes the errors of all constants with a component in it infinite
        let parts = (0..p).map(|k| {
            let part = vt[(k, i)].abs();
            if deviation(k).is_infinite() && part <= PART { 0.0 } else { (part * deviation(k)).powi(2) }
        });
        let std_error = scale[i] * parts.sum::<f64>().sqrt();
        let std_error = errors.filter(|_| std_error.is_finite()).map_or(std_error, |e| e.deviations[i]);
        let half = if std_error == 0.0 { 0.0 } else { quantile * std_error };
        let interval = [values[i] - half, values[i] + half];
        Estimate { name: q.name, symbol: q.symbol, unit: unit(q), value: values[i], std_error, interval }
    };
    let estimates = parameters.iter().enumerate().map(|(i, q)| estimate((i, q))).collect();
    // Along such a direction the errors of the data points leave the constants open to their full size
    let wider = errors.map_or(1.0, |e| e.wider(error * size));
    let loose = |k: usize| blind(k) || (free > 0 && quantile * wider * deviation(k) > LOOSE);
    let told: Vec<usize> = (0..p).filter(|k| !loose(*k)).collect();
    let direction = |k: usize| {
        let v: Vec<f64> = vt.row(k).iter().copied().collect();
        let half_width = (!blind(k) && free > 0).then(|| quantile * wider * deviation(k));
        let names: Vec<&str> = parameters.iter().map(|q| q.symbol).collect();
        let alike = parameters.iter().all(|q| q.dimension == Dimension::PRESSURE);
        let known = (alike && told.len() == 1 && p == 2).then(|| {
            // The combination that the data determine is Σ (v/z) θ
            let seen: Vec<f64> = vt.row(told[0]).iter().zip(&scale).map(|(v, z)| v / z).collect();
            combination(&seen, &names)
        });
        Direction { changes: changes(&v, &names, bases), known, half_width }
    };
    let directions = (0..p).filter(|k| loose(*k)).map(direction).collect();
    let least = (0..p).min_by(|a, b| sigma[*a].total_cmp(&sigma[*b])).map(|k| direction(k).changes);
    Identified { estimates, directions, least: least.unwrap_or_default() }
}

/// A combination as text: `C10 + 0.98 C01`
fn combination(parts: &[f64], names: &[&str]) -> String {
    let first = parts[0];
    let mut text = names[0].to_string();
    for (part, name) in parts.iter().zip(names).skip(1) {
        let ratio = part / first;
        text += &format!(" {} {:.3} {name}", if ratio < 0.0 { "−" } else { "+" }, ratio.abs());
    }
    text
}

/// A change as text: `changing C10 by +1 %, C01 by −0.97 % together`, or the name of a single constant. Components below a hundredth of the largest
/// are omitted.
pub fn changes(v: &[f64], names: &[&str], values: &[f64]) -> String {
    let largest = v.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(1.0);
    // z = |value|: a relative change of a negative constant has the opposite sign
    let parts = v.iter().zip(names).zip(values).filter(|((v, _), _)| v.abs() >= 0.01 * largest.abs());
    let words: Vec<String> = parts
        .map(|((v, name), value)| {
            let percent = v / largest * if *value < 0.0 { -1.0 } else { 1.0 };
            if *value == 0.0 { (*name).to_string() } else { format!("{name} by {percent:+.2} %").replace('-', "−") }
        })
        .collect();
    match &words[..] {
        [one] => one.split(" by ").next().unwrap_or(one).to_string(),
        _ => format!("changing {} together", words.join(", ")),
    }
}

/// The part of a column outside the span of the sensitivities; directions below rounding do not count.
pub fn across(jacobian: &DMatrix<f64>, column: &DVector<f64>) -> DVector<f64> {
    let p = jacobian.ncols();
    let lengths: Vec<f64> = (0..p).map(|k| jacobian.column(k).norm()).map(|n| if n > 0.0 { n } else { 1.0 }).collect();
    let scaled = DMatrix::from_fn(jacobian.nrows(), p, |i, k| jacobian[(i, k)] / lengths[k]);
    let svd = svd(padded(&scaled, p), true, false);
    let (u, sigma) = (svd.u.expect("asked for"), svd.singular_values);
    let long = column.clone().resize_vertically(u.nrows(), 0.0);
    let mut rest = long.clone();
    for k in (0..p).filter(|k| sigma[*k] > BLIND * sigma.max()) {
        rest -= u.column(k) * u.column(k).dot(&long);
    }
    rest.resize_vertically(column.len(), 0.0)
}
