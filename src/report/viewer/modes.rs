//! Principal modes of a history, by which a page stores it in a small fraction of the bytes.
//!
//! A history D \[values × states\] is written as D ≈ Σ_k φ_k a_kᵀ. The directions in time are the eigenvectors of DᵀD in descending order of their
//! eigenvalues, the method of snapshots (Sirovich, *Quart. Appl. Math.* 45 (1987) 561–571). Each mode φ_k is rounded to 16 bits, and its amplitudes
//! are a least-squares fit to the remainder of the previous modes. Further modes, in the directions of the remainder, absorb the rounding of earlier
//! ones. Modes are added until the largest difference at any point and state is within the tolerance. That difference is measured on the stored
//! numbers, not bounded by singular values.

use crate::math::svd::svd;
use nalgebra::DMatrix;

/// The values of successive states \[states × points × components\].
pub struct History {
    pub components: usize,
    /// Values \[states\]\[points × components\]; values that are not finite mark a state without any, or a point that lacks one in some other state
    pub states: Vec<Vec<f32>>,
}

/// A history in the form of modes.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Modes {
    pub components: usize,
    /// Integers from −32767 to 32767 \[modes\]\[points × components\]; [`Modes::NONE`] in the first mode where there is no value
    pub shapes: Vec<Vec<i16>>,
    /// Factors of the integers \[modes\]\[states\]; NaN for a state without values
    pub amplitudes: Vec<Vec<f32>>,
    /// Largest distance from the history at any point and state, Euclidean over the components
    pub error: f64,
}

/// Largest number of modes of a history.
const MOST: usize = 64;
/// Number of rows that are multiplied at a time, which avoids a second copy of a history in double precision.
const ROWS: usize = 8192;
const FULL: f64 = 32767.0;
/// Relative size below which eigenvalues are rounding of the largest one.
const ROUNDING: f64 = 1e-13;

impl Modes {
    /// Mark of a point without a value.
    pub const NONE: i16 = i16::MIN;

    /// Computes the modes of a history within a tolerance in its unit. The result does not depend on the number of threads.
    pub fn of(mut history: History, tolerance: f64) -> Self {
        let (gaps, missing) = take_out(&mut history.states);
        let count = history.states.first().map_or(0, Vec::len);
        let mut out = Self { components: history.components, shapes: vec![], amplitudes: vec![], error: 0.0 };
        let most = MOST.min(2 * history.states.len());
        let mut left = vec![].into_iter().peekable();
        loop {
            out.error = largest(&history);
            if out.error <= tolerance || out.shapes.len() == most {
                break;
            }
            // If the directions hold less than the tolerance, the remainder is the rounding of earlier modes, in their directions
            if left.peek().is_none_or(|(size, _)| *size <= tolerance) {
                left = directions(&history.states).into_iter().peekable();
            }
            let Some((_, direction)) = left.next() else { break };
            let (shape, amplitudes) = mode(&history.states, &direction);
            subtract(&mut history.states, &shape, &amplitudes);
            out.shapes.push(shape);
            out.amplitudes.push(amplitudes);
        }
        if out.shapes.is_empty() && count > 0 {
            // A page needs the number of points, and which points have no value
            out.shapes.push(vec![0; count]);
            out.amplitudes.push(vec![0.0; history.states.len()]);
        }
        missing.into_iter().for_each(|p| out.shapes[0][p] = Self::NONE);
        out.amplitudes.iter_mut().for_each(|a| gaps.iter().for_each(|&k| a[k] = f32::NAN));
        out
    }

    /// Returns the modes at some of the points; the error is then only a bound.
    pub fn of_points(&self, points: &[u32]) -> Self {
        let own = |s: &Vec<i16>| {
            let all = |p: u32| (0..self.components).map(move |i| p as usize * self.components + i);
            points.iter().flat_map(|&p| all(p)).map(|k| s[k]).collect()
        };
        Self { shapes: self.shapes.iter().map(own).collect(), ..self.clone() }
    }

    /// Returns the history in a state as computed by the page; NaN where there is no value.
    pub fn at(&self, state: usize) -> Vec<f64> {
        let mut out = vec![0.0; self.shapes.first().map_or(0, Vec::len)];
        for (shape, amplitudes) in self.shapes.iter().zip(&self.amplitudes) {
            let a = f64::from(amplitudes[state]);
            out.iter_mut().zip(shape).for_each(|(v, q)| *v += a * f64::from(*q));
        }
        let none = self.shapes.first().into_iter().flatten().enumerate().filter(|(_, q)| **q == Self::NONE);
        none.for_each(|(p, _)| out[p] = f64::NAN);
        out
    }
}

/// Sets states without a value to zero, and values that are not finite in some other state to zero in all states; returns the indices of these states
/// and values.
fn take_out(states: &mut [Vec<f32>]) -> (Vec<usize>, Vec<usize>) {
    let (gaps, missing) = without_values(states);
    gaps.iter().for_each(|&k| states[k].fill(0.0));
    for state in states {
        missing.iter().for_each(|&p| state[p] = 0.0);
    }
    (gaps, missing)
}

/// Returns the states that have no value while others have some, and the indices of values missing in some other state.
pub fn without_values(states: &[Vec<f32>]) -> (Vec<usize>, Vec<usize>) {
    let is_gap = |s: &Vec<f32>| s.iter().all(|v| !v.is_finite());
    let (gaps, known): (Vec<usize>, Vec<usize>) = (0..states.len()).partition(|&k| is_gap(&states[k]));
    let (gaps, known) = if known.is_empty() { (known, gaps) } else { (gaps, known) };
    let count = states.first().map_or(0, Vec::len);
    let missing = (0..count).filter(|&p| known.iter().any(|&k| !states[k][p].is_finite())).collect();
    (gaps, missing)
}

/// Eigenvectors of DᵀD in descending order of the eigenvalues, with the norm of the part of D along each.
fn directions(states: &[Vec<f32>]) -> Vec<(f64, Vec<f64>)> {
    let (count, frames) = (states.first().map_or(0, Vec::len), states.len());
    let mut gram = DMatrix::<f64>::zeros(frames, frames);
    for first in (0..count).step_by(ROWS) {
        let rows = ROWS.min(count - first);
        let block = DMatrix::from_fn(rows, frames, |i, j| f64::from(states[j][first + i]));
        gram.gemm_tr(1.0, &block, &block, 1.0);
    }
    let found = svd(gram, true, false);
    let Some(u) = found.u else { return vec![] };
    let least = ROUNDING * found.singular_values.max();
    let mut order: Vec<usize> = (0..frames).filter(|&k| found.singular_values[k] > least).collect();
    order.sort_by(|&a, &b| found.singular_values[b].total_cmp(&found.singular_values[a]));
    order.into_iter().map(|k| (found.singular_values[k].sqrt(), u.column(k).iter().copied().collect())).collect()
}

/// The rounded mode of a direction in time, with its least-squares amplitudes.
fn mode(states: &[Vec<f32>], direction: &[f64]) -> (Vec<i16>, Vec<f32>) {
    let mut shape = vec![0.0f64; states[0].len()];
    for (state, &d) in states.iter().zip(direction) {
        shape.iter_mut().zip(state).for_each(|(s, v)| *s += d * f64::from(*v));
    }
    let size = shape.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let scale = if size > 0.0 { FULL / size } else { 0.0 };
    let shape: Vec<i16> = shape.into_iter().map(|v| (v * scale).round() as i16).collect();
    let norm: f64 = shape.iter().map(|&q| f64::from(q).powi(2)).sum();
    let dot = |state: &Vec<f32>| shape.iter().zip(state).map(|(&q, &v)| f64::from(q) * f64::from(v)).sum::<f64>();
    let amplitudes = states.iter().map(|state| if norm > 0.0 { (dot(state) / norm) as f32 } else { 0.0 }).collect();
    (shape, amplitudes)
}

fn subtract(states: &mut [Vec<f32>], shape: &[i16], amplitudes: &[f32]) {
    for (state, &a) in states.iter_mut().zip(amplitudes) {
        state.iter_mut().zip(shape).for_each(|(v, &q)| *v = (f64::from(*v) - f64::from(a) * f64::from(q)) as f32);
    }
}

/// The largest Euclidean norm of the components of a point in any state.
fn largest(history: &History) -> f64 {
    let norm = |v: &[f32]| v.iter().map(|c| f64::from(*c).powi(2)).sum::<f64>();
    let all = history.states.iter().flat_map(|s| s.chunks_exact(history.components.max(1)).map(norm));
    all.fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;
    use crate::math::statistics::larger;

    /// A bar that bends up to a quarter circle: few modes reach the tolerance, and the stated error is that of the decoded numbers.
    #[test]
    fn a_bending_bar_needs_few_modes_and_its_error_is_the_stated_one() {
        let state = |t: usize| {
            let curvature = 1.57 * t as f64 / 40.0 + 1e-9;
            let point = |k: usize| {
                let (s, z) = ((k / 5) as f64 / 400.0, (k % 5) as f64 / 100.0);
                let (x, y) = ((curvature * s).sin() / curvature, (1.0 - (curvature * s).cos()) / curvature);
                [x - z * (curvature * s).sin() - s, y + z * ((curvature * s).cos() - 1.0), 0.0].map(|v| v as f32)
            };
            (0..2000).flat_map(point).collect::<Vec<f32>>()
        };
        let states: Vec<Vec<f32>> = (0..41).map(state).collect();
        for tolerance in [1e-2, 1e-3, 1e-4] {
            let modes = Modes::of(History { components: 3, states: states.clone() }, tolerance);
            assert!(modes.error <= tolerance && modes.shapes.len() <= 12, "{} modes", modes.shapes.len());
            let distance = |(t, state): (usize, &Vec<f32>)| {
                let decoded = modes.at(t);
                let of =
                    |(a, b): (&[f64], &[f32])| (0..3).map(|i| (a[i] - f64::from(b[i])).powi(2)).sum::<f64>().sqrt();
                decoded.chunks(3).zip(state.chunks(3)).map(of).fold(0.0, larger)
            };
            let found = states.iter().enumerate().map(distance).fold(0.0, larger);
            // The residual is kept in single precision: one rounding of numbers up to 1 per mode
            let rounding = 6e-8 * modes.shapes.len() as f64;
            assert!((found - modes.error).abs() <= rounding, "{found} is stated as {}", modes.error);
        }
    }

    /// Noise has no dominant modes: all of them are used, and the remaining error is stated.
    #[test]
    fn noise_is_stored_by_all_of_its_modes() {
        let mut random = SplitMix(7);
        let states: Vec<Vec<f32>> = (0..12).map(|_| (0..300).map(|_| random.unit() as f32).collect()).collect();
        let modes = Modes::of(History { components: 1, states }, 1e-3);
        assert_eq!(modes.shapes.len(), 12);
        assert!(modes.error < 1e-3, "{}", modes.error);
    }

    /// The rounding of a mode to 16 bits does not bound the error: a further mode absorbs it, even for a single state.
    #[test]
    fn further_modes_take_up_the_rounding_of_the_first() {
        let mut random = SplitMix(5);
        let state: Vec<f32> = (0..300).map(|_| random.unit() as f32).collect();
        for count in [1u8, 6] {
            let states = (1..=count).map(|k| state.iter().map(|v| f32::from(k) * v).collect()).collect();
            let tolerance = 1e-5 * f64::from(count);
            let modes = Modes::of(History { components: 1, states }, tolerance);
            let found = (modes.shapes.len(), modes.error);
            assert!(found.0 == 2 && found.1 <= tolerance, "{found:?}");
        }
    }

    /// A state without any values does not affect the others.
    #[test]
    fn a_state_without_values_has_none_and_the_others_keep_theirs() {
        let states = vec![vec![1.0, 2.0], vec![f32::NAN; 2], vec![3.0, 5.0]];
        let modes = Modes::of(History { components: 1, states }, 1e-4);
        assert!(modes.at(1).iter().all(|v| v.is_nan()), "{:?}", modes.at(1));
        for (state, expected) in [(0, [1.0, 2.0]), (2, [3.0, 5.0])] {
            let off = modes.at(state).iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
            // The residual is kept in single precision
            assert!(off <= modes.error + 5.0 * 6e-8 && modes.error <= 1e-4, "{off}, stated {}", modes.error);
        }
    }

    #[test]
    fn points_without_a_value_and_histories_of_zeros_are_kept() {
        let states = vec![vec![1.0, f32::NAN, 2.0], vec![1.0, 5.0, 3.0]];
        let modes = Modes::of(History { components: 1, states }, 1e-4);
        let decoded = modes.at(1);
        assert!(decoded[1].is_nan() && (decoded[2] - 3.0).abs() < 1e-3, "{decoded:?}");
        let zeros = Modes::of(History { components: 1, states: vec![vec![0.0; 4]; 3] }, 0.0);
        assert_eq!((zeros.shapes, zeros.error), (vec![vec![0; 4]], 0.0));
        assert!(Modes::of(History { components: 3, states: vec![] }, 1.0).shapes.is_empty());
    }
}
