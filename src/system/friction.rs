//! Coulomb friction with a smooth transition to sliding (Li et al., Incremental potential contact, 2020, eq. 13).
//!
//! F_t| = F f(|u|/ε), F = μ N, f(y) = 2y − y² for y < 1, and 1 beyond. [`regularised`] gives f for a sliding u, and [`resistance`] the force if the
//! sliding depends on it.
//! the force where the sliding depends on it.

/// Number of history variables of friction at a point: its elastic slip divided by ε, the part of the sliding that has not become permanent; a vector
/// of length at most 1.
pub const HISTORY: usize = 3;

/// Returns f(|u|/ε)/|u| and ∂f/∂|u| at the sliding |u| = `size` \[1/m\].
pub fn regularised(size: f64, epsilon: f64) -> (f64, f64) {
    match size < epsilon {
        true => ((2.0 - size / epsilon) / epsilon, 2.0 * (1.0 - size / epsilon) / epsilon),
        false => (1.0 / size, 0.0),
    }
}

/// The friction force against a sliding u that depends on the force itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resistance {
    /// Magnitude of the force \[N\]
    pub force: f64,
    /// Derivative with respect to u, the sliding without friction \[N/m\]
    pub by_sliding: f64,
    /// Derivative with respect to the limit F \[–\]
    pub by_limit: f64,
}

/// Returns the resistance to a sliding that would be `u` without friction \[m\]: the force is F f(a/ε), where the sliding a with friction solves a +
/// w F f(a/ε) = u, and F is the `limit`.
pub fn resistance(u: f64, w: f64, limit: f64, epsilon: f64) -> Resistance {
    if u >= epsilon + w * limit {
        return Resistance { force: limit, by_sliding: 0.0, by_limit: 1.0 };
    }
    // (wF/ε²) a² − (1 + 2wF/ε) a + u = 0; the smaller root, without cancellation
    let (square, linear) = (w * limit / (epsilon * epsilon), 1.0 + 2.0 * w * limit / epsilon);
    let y = 2.0 * u / (linear + (linear * linear - 4.0 * square * u).sqrt()) / epsilon;
    let (f, slope) = ((2.0 - y) * y, 2.0 * (1.0 - y) / epsilon);
    let give = 1.0 + w * limit * slope;
    Resistance { force: limit * f, by_sliding: limit * slope / give, by_limit: f / give }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The remaining sliding and the force obey both laws; 1e-12 is 1e4 times the rounding.
    #[test]
    fn resistance_is_that_of_the_sliding_that_is_left() {
        let (w, limit, epsilon) = (2.0, 3.0, 0.5);
        for u in [1e-6, 0.3, 2.0, 6.4, 6.5, 6.6, 40.0] {
            let Resistance { force, by_sliding, by_limit } = resistance(u, w, limit, epsilon);
            let left = u - w * force;
            let law = limit * regularised(left, epsilon).0 * left;
            assert!(left > 0.0 && (force - law).abs() <= 1e-12 * limit, "u = {u}: {force} for {law}");
            // The force has a kink where sliding begins. Elsewhere central differences have errors of h² and of rounding over h
            if u == epsilon + w * limit {
                continue;
            }
            let h = 1e-6 * u;
            let difference = |change: &dyn Fn(f64) -> f64| (change(h) - change(-h)) / (2.0 * h);
            let by_u = difference(&|h| resistance(u + h, w, limit, epsilon).force);
            let by_f = difference(&|h| resistance(u, w, limit + h, epsilon).force);
            assert!((by_u - by_sliding).abs() < 1e-6 * limit / epsilon, "u = {u}: {by_sliding} for {by_u}");
            assert!((by_f - by_limit).abs() < 1e-6, "u = {u}: {by_limit} for {by_f}");
        }
    }
}
