//! Coulomb friction with a smooth start of sliding (Li et al., Incremental potential contact, 2020, eq. 13).
//!
//! |F_t| = F f(|u|/ε), F = μ N, f(y) = 2y − y² for y < 1, and 1 beyond. [`regularised`] gives f of a sliding u, and [`resistance`]
//! the force where the sliding depends on it.

/// f(|u|/ε)/|u| and ∂f/∂|u| at the sliding |u| = `size` \[1/m\].
pub fn regularised(size: f64, epsilon: f64) -> (f64, f64) {
    match size < epsilon {
        true => ((2.0 - size / epsilon) / epsilon, 2.0 * (1.0 - size / epsilon) / epsilon),
        false => (1.0 / size, 0.0),
    }
}

/// Resistance to sliding, as a share of the sliding `u` without it \[N/m\]: the force is F f(a/ε) where the sliding is a with it, and
/// a + w F f(a/ε) = u. F is the `limit`.
pub fn resistance(u: f64, w: f64, limit: f64, epsilon: f64) -> f64 {
    if u == 0.0 || limit == 0.0 {
        return 0.0;
    }
    if u >= epsilon + w * limit {
        return limit / u;
    }
    // (wF/ε²) a² − (1 + 2wF/ε) a + u = 0, the smaller root, without cancellation.
    let (square, linear) = (w * limit / (epsilon * epsilon), 1.0 + 2.0 * w * limit / epsilon);
    let y = 2.0 * u / (linear + (linear * linear - 4.0 * square * u).sqrt()) / epsilon;
    limit * (2.0 - y) * y / u
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sliding that is left and the force obey both laws; 1e-12 is 1e4 roundings.
    #[test]
    fn resistance_is_that_of_the_sliding_that_is_left() {
        let (w, limit, epsilon) = (2.0, 3.0, 0.5);
        for u in [1e-6, 0.3, 2.0, 6.4, 6.5, 6.6, 40.0] {
            let force = resistance(u, w, limit, epsilon) * u;
            let left = u - w * force;
            let law = limit * regularised(left, epsilon).0 * left;
            assert!(left > 0.0 && (force - law).abs() <= 1e-12 * limit, "u = {u}: {force} for {law}");
        }
    }
}
