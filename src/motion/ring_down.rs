//! Frequency and decay of a free vibration.
//!
//! y(t) = A e^{−δs} cos(2πfs + φ) + c₀ + c₁ g(s) with s = t − t₀ from the release, fitted by least squares. The coefficients A cos φ, A sin φ, c₀ and
//! c₁ are linear and eliminated (variable projection: Golub & Pereyra, SIAM J. Numer. Anal. 10, 1973); Gauss–Newton steps with step halving find f
//! and δ, starting from the best point of a grid. Creep is g = ln(s/1 s), which is usual for polymers over a few decades, g = s, or absent.
//!
//! Intervals are those of least squares linearised at the solution, with errors that may be correlated from one row to the next (restricted
//! likelihood of ρ, see `calibrate::judgement::errors`), and Student's t for the independent rows. The function uses only a curve, so that simulated
//! and measured curves are evaluated in the same way.

use super::curve::Curve;
use super::error::MotionError;
use super::ring_down_start as start;
pub use super::vibration::{Creep, RingDown};
use crate::calibrate::Bounded;
use crate::calibrate::judgement::errors;
use crate::math::statistics::{root, t_quantile};
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Smallest number of rows in the window
const LEAST: usize = 12;
/// Largest number of Gauss–Newton steps, and of halvings of one step
const STEPS: usize = 60;
const HALVINGS: i32 = 30;
/// Relative decrease of the misfit below which the search ends \[–\]
const FLAT: f64 = 1e-13;
/// Residual relative to the values below which it is rounding \[–\]
const ROUNDING: f64 = 1e-11;
/// Number of standard errors that an amplitude must exceed
const SEEN: f64 = 4.0;

/// Fits a damped vibration to the rows of `curve` in `window_s`; `origin_s` is the time of the release.
///
/// # Errors
/// A window that has too few rows or begins before the release, or a curve without a vibration of at least one period and above the noise.
pub fn ring_down(curve: &Curve, window_s: [f64; 2], origin_s: f64, kind: Creep) -> Result<RingDown, MotionError> {
    let cut = curve.window(window_s);
    if cut.value.len() < LEAST {
        let ([from_s, to_s], found) = (window_s, cut.value.len());
        return Err(MotionError::TooShort { found, needed: LEAST, from_s, to_s, step_s: curve.time_step() });
    }
    let problem = Problem::new(&cut, window_s, origin_s, kind)?;
    let refuse =
        |fact: String, remedy| MotionError::NoRingDown { from_s: window_s[0], to_s: window_s[1], fact, remedy };
    let started = start::best(&problem.s, problem.frequencies(&cut), |x| problem.misfit(x));
    let x = problem.search(started.ok_or_else(|| refuse("its values are constant".into(), "take another window"))?);
    let fit = problem.solve(x);
    let [frequency, _] = x;
    let span = problem.s[problem.s.len() - 1] - problem.s[0];
    if frequency * span < 1.0 {
        let fact = format!("the best frequency, {frequency:.4} Hz, has less than one period");
        return Err(refuse(fact, "take a longer window"));
    }
    let answer = problem.answer(&cut, x, &fit, (origin_s, kind));
    let half = answer.amplitude.half_width() / t_quantile(0.95, answer.free);
    if answer.amplitude.value <= SEEN * half {
        let fact = format!("the amplitude {:.3e} is not above its standard error {half:.3e}", answer.amplitude.value);
        return Err(refuse(fact, "take an earlier window"));
    }
    Ok(answer)
}

/// Rows of the window, weighted by the root of their samples.
struct Problem {
    s: Vec<f64>,
    root: Vec<f64>,
    target: DVector<f64>,
    /// Values of the creep function; `None` without creep
    creep: Option<Vec<f64>>,
    /// Magnitude of the values, to judge rounding
    size: f64,
}

/// Linear coefficients (A cos φ, −A sin φ, c₀, c₁) with their columns and the residual.
struct Solved {
    factors: DVector<f64>,
    columns: DMatrix<f64>,
    residual: DVector<f64>,
}

impl Problem {
    fn new(cut: &Curve, window: [f64; 2], origin_s: f64, kind: Creep) -> Result<Self, MotionError> {
        let [from_s, to_s] = window;
        let n = cut.value.len();
        let s: Vec<f64> = cut.time_s.iter().map(|t| t - origin_s).collect();
        if kind == Creep::Logarithmic && s[0] <= 0.0 {
            let fact = "begins at the release or before it";
            return Err(MotionError::Window {
                from_s,
                to_s,
                fact,
                remedy: "begin it after the release, or fit without logarithmic creep",
            });
        }
        let creep = s.iter().map(|s| kind.at(*s)).collect();
        let root: Vec<f64> = cut.samples.iter().map(|w| w.sqrt()).collect();
        let target = DVector::from_fn(n, |i, _| root[i] * cut.value[i]);
        let size = target.norm();
        Ok(Self { s, root, target, creep, size })
    }

    /// Returns the columns of the linear coefficients.
    fn columns(&self, [f, d]: [f64; 2]) -> DMatrix<f64> {
        let n = self.s.len();
        let width = if self.creep.is_some() { 4 } else { 3 };
        DMatrix::from_fn(n, width, |i, k| {
            let s = self.s[i];
            let value = match (k, &self.creep) {
                (0, _) => (-d * s).exp() * (TAU * f * s).cos(),
                (1, _) => (-d * s).exp() * (TAU * f * s).sin(),
                (3, Some(creep)) => creep[i],
                _ => 1.0,
            };
            self.root[i] * value
        })
    }

    fn solve(&self, x: [f64; 2]) -> Solved {
        let columns = self.columns(x);
        let factors = svd(columns.clone(), true, true)
            .solve(&self.target, 1e-13 * columns.norm())
            .unwrap_or_else(|_| DVector::zeros(columns.ncols()));
        let residual = &self.target - &columns * &factors;
        Solved { factors, columns, residual }
    }

    /// Returns ‖r‖ with the best linear coefficients; infinite if it is not finite.
    fn misfit(&self, x: [f64; 2]) -> f64 {
        let norm = self.solve(x).residual.norm();
        if norm.is_finite() { norm } else { f64::INFINITY }
    }

    /// Returns the Jacobian of the model with respect to (f, δ) and the linear coefficients.
    fn jacobian(&self, [f, d]: [f64; 2], solved: &Solved) -> DMatrix<f64> {
        let (a, b) = (solved.factors[0], solved.factors[1]);
        DMatrix::from_fn(self.s.len(), 2 + solved.columns.ncols(), |i, k| {
            let s = self.s[i];
            let (sin, cos) = (TAU * f * s).sin_cos();
            let envelope = self.root[i] * (-d * s).exp();
            match k {
                0 => envelope * TAU * s * (b * cos - a * sin),
                1 => -s * envelope * (a * cos + b * sin),
                k => solved.columns[(i, k - 2)],
            }
        })
    }

    /// Returns the range of frequencies to try, around the one at which the curve crosses its creep, or its line if it has none.
    fn frequencies(&self, cut: &Curve) -> [f64; 2] {
        let creep = self.creep.as_ref().unwrap_or(&self.s);
        let trend = svd(DMatrix::from_fn(self.s.len(), 2, |i, k| if k == 0 { 1.0 } else { creep[i] }), true, true);
        let line = trend.solve(&DVector::from_column_slice(&cut.value), 1e-13).unwrap_or_else(|_| DVector::zeros(2));
        let left: Vec<f64> = creep.iter().zip(&cut.value).map(|(g, v)| v - line[0] - line[1] * g).collect();
        start::frequencies(&self.s, &left)
    }

    /// Gauss–Newton search in all parameters; each step is halved until the misfit decreases.
    fn search(&self, mut x: [f64; 2]) -> [f64; 2] {
        for _ in 0..STEPS {
            let solved = self.solve(x);
            let before = solved.residual.norm();
            let jacobian = self.jacobian(x, &solved);
            let scale: Vec<f64> = jacobian.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
            let scaled = DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |i, k| jacobian[(i, k)] / scale[k]);
            let Ok(step) = svd(scaled, true, true).solve(&solved.residual, 1e-12) else { break };
            let moved = |n: i32| [0, 1].map(|k| x[k] + 0.5_f64.powi(n) * step[k] / scale[k]);
            let Some(next) = (0..HALVINGS).map(moved).find(|x| x[0] > 0.0 && self.misfit(*x) < before) else { break };
            let after = self.misfit(next);
            x = next;
            if after > before * (1.0 - FLAT) || after <= ROUNDING * self.size {
                break;
            }
        }
        x
    }

    fn answer(&self, cut: &Curve, x: [f64; 2], fit: &Solved, (origin_s, kind): (f64, Creep)) -> RingDown {
        let n = self.s.len();
        let jacobian = self.jacobian(x, fit);
        let rounding = fit.residual.norm() <= ROUNDING * self.size;
        let found = errors::of_curves(&jacobian, &fit.residual, &[(0..n).collect()], rounding);
        let free = found.free.max(1);
        let t = if rounding { 0.0 } else { t_quantile(0.95, free) };
        let bounded = |value: f64, deviation: f64| {
            let half = if rounding { 0.0 } else { t * deviation };
            Bounded { value, interval: [value - half, value + half] }
        };
        let (a, b) = (fit.factors[0], fit.factors[1]);
        let size = a.hypot(b);
        // A = √(a² + b²) and φ = atan2(−b, a) to first order
        let by_factors = |da: f64, db: f64| {
            let c = &found.covariance;
            root(da * da * c[(2, 2)] + 2.0 * da * db * c[(2, 3)] + db * db * c[(3, 3)])
        };
        let creep =
            fit.factors.get(3).map_or(Bounded { value: 0.0, interval: [0.0; 2] }, |c| bounded(*c, found.deviations[5]));
        let squares: f64 = fit.residual.iter().map(|r| r * r).sum();
        RingDown {
            window_s: [cut.time_s[0], cut.time_s[n - 1]],
            origin_s,
            rows: n,
            frequency_hz: bounded(x[0], found.deviations[0]),
            decay_per_s: bounded(x[1], found.deviations[1]),
            amplitude: bounded(size, by_factors(a / size, b / size)),
            phase: bounded((-b).atan2(a), by_factors(b / size.powi(2), -a / size.powi(2))),
            offset: bounded(fit.factors[2], found.deviations[4]),
            creep,
            kind,
            rms: (squares / self.root.iter().map(|r| r * r).sum::<f64>()).sqrt(),
            correlation: found.correlation.of_neighbours(),
            free,
        }
    }
}
