//! Vectors of polynomials of degree at most two in the coordinates of a model, and their identification from values.

use serde::{Deserialize, Serialize};

/// f(q) = c + L q + q·Q q; only the arrays of the degrees that f has are present.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quadratic {
    /// Number of coordinates q
    pub coordinates: usize,
    /// \[outputs\]
    pub constant: Vec<f64>,
    /// \[outputs × coordinates\], empty for degree 0
    pub linear: Vec<f64>,
    /// \[outputs × coordinates × coordinates\], symmetric in the last two indices, empty below degree 2
    pub quadratic: Vec<f64>,
}

impl Quadratic {
    /// Identifies the polynomials of this degree from the values of `f` at multiples of `steps`, one step for each coordinate.
    pub fn identify(degree: usize, steps: &[f64], mut f: impl FnMut(&[f64]) -> Vec<f64>) -> Self {
        let n = steps.len();
        let mut at = |places: &[(usize, f64)]| {
            let mut q = vec![0.0; n];
            places.iter().for_each(|&(i, times)| q[i] += times * steps[i]);
            f(&q)
        };
        let constant = at(&[]);
        let outputs = constant.len();
        let mut out = Self { coordinates: n, constant, linear: vec![], quadratic: vec![] };
        if degree == 0 {
            return out;
        }
        out.linear = vec![0.0; outputs * n];
        let ahead: Vec<Vec<f64>> = (0..n).map(|i| at(&[(i, 1.0)])).collect();
        if degree == 1 {
            for (a, i) in (0..outputs).flat_map(|a| (0..n).map(move |i| (a, i))) {
                out.linear[a * n + i] = (ahead[i][a] - out.constant[a]) / steps[i];
            }
            return out;
        }
        out.quadratic = vec![0.0; outputs * n * n];
        for i in 0..n {
            let behind = at(&[(i, -1.0)]);
            for a in 0..outputs {
                let (plus, minus, centre) = (ahead[i][a], behind[a], out.constant[a]);
                out.linear[a * n + i] = (plus - minus) / (2.0 * steps[i]);
                out.quadratic[(a * n + i) * n + i] = (plus + minus - 2.0 * centre) / (2.0 * steps[i] * steps[i]);
            }
            for j in 0..i {
                let both = at(&[(i, 1.0), (j, 1.0)]);
                for a in 0..outputs {
                    let mixed = (both[a] - ahead[i][a] - ahead[j][a] + out.constant[a]) / (2.0 * steps[i] * steps[j]);
                    out.quadratic[(a * n + i) * n + j] = mixed;
                    out.quadratic[(a * n + j) * n + i] = mixed;
                }
            }
        }
        out
    }

    pub fn outputs(&self) -> usize {
        self.constant.len()
    }

    /// Adds factor · f(q) to `out`.
    pub fn add(&self, q: &[f64], factor: f64, out: &mut [f64]) {
        let n = self.coordinates;
        for (a, out) in out.iter_mut().enumerate().take(self.outputs()) {
            let mut sum = self.constant[a];
            if !self.linear.is_empty() {
                sum += product(&self.linear[a * n..(a + 1) * n], q);
            }
            if !self.quadratic.is_empty() {
                let rows = self.quadratic[a * n * n..(a + 1) * n * n].chunks_exact(n);
                sum += rows.zip(q).map(|(row, q_i)| q_i * product(row, q)).sum::<f64>();
            }
            *out += factor * sum;
        }
    }

    /// Adds factor · ∂f_a/∂q_i to out\[a × stride + i\].
    pub fn add_derivative(&self, q: &[f64], factor: f64, stride: usize, out: &mut [f64]) {
        let n = self.coordinates;
        for a in 0..self.outputs() {
            for i in 0..n {
                let mut sum = if self.linear.is_empty() { 0.0 } else { self.linear[a * n + i] };
                if !self.quadratic.is_empty() {
                    sum += 2.0 * product(&self.quadratic[(a * n + i) * n..][..n], q);
                }
                out[a * stride + i] += factor * sum;
            }
        }
    }

    /// Returns q·c + ½ q·L q + ⅓ Σ q_a q·Q_a q, whose gradient is f if f is a gradient.
    pub fn potential(&self, q: &[f64]) -> f64 {
        let n = self.coordinates;
        let of = |a: usize| {
            let mut sum = self.constant[a];
            if !self.linear.is_empty() {
                sum += 0.5 * product(&self.linear[a * n..(a + 1) * n], q);
            }
            if !self.quadratic.is_empty() {
                let rows = self.quadratic[a * n * n..(a + 1) * n * n].chunks_exact(n);
                sum += rows.zip(q).map(|(row, q_i)| q_i * product(row, q)).sum::<f64>() / 3.0;
            }
            q[a] * sum
        };
        (0..self.outputs()).map(of).sum()
    }

    /// Whether the arrays have consistent sizes and finite values.
    pub fn is_sound(&self, coordinates: usize, outputs: usize) -> bool {
        let sizes = |v: &Vec<f64>, n: usize| v.is_empty() || v.len() == n;
        let arrays = [&self.constant, &self.linear, &self.quadratic];
        self.coordinates == coordinates
            && self.constant.len() == outputs
            && sizes(&self.linear, outputs * coordinates)
            && sizes(&self.quadratic, outputs * coordinates * coordinates)
            && arrays.iter().all(|v| v.iter().all(|x| x.is_finite()))
    }
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∂φ/∂q of φ = q₀²q₁ + 3q₀ + 2q₁: a polynomial of degree 2 is identified from its values, to rounding of a few dozen operations.
    #[test]
    fn a_gradient_of_degree_two_is_identified_with_its_derivative_and_potential() {
        let gradient = |q: &[f64]| vec![2.0 * q[0] * q[1] + 3.0, q[0] * q[0] + 2.0];
        let found = Quadratic::identify(2, &[0.3, 2.0], gradient);
        let q = [0.7, -1.3];
        let mut value = vec![0.0; 2];
        found.add(&q, 1.0, &mut value);
        assert!(value.iter().zip(gradient(&q)).all(|(a, b)| (a - b).abs() < 1e-13));
        let mut derivative = vec![0.0; 4];
        found.add_derivative(&q, 1.0, 2, &mut derivative);
        for (d, exact) in derivative.iter().zip([2.0 * q[1], 2.0 * q[0], 2.0 * q[0], 0.0]) {
            assert!((d - exact).abs() < 1e-13);
        }
        let exact = q[0] * q[0] * q[1] + 3.0 * q[0] + 2.0 * q[1];
        assert!((found.potential(&q) - exact).abs() < 1e-13);
    }
}
