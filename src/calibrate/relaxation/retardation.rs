//! From the compliances of a creep test to the moduli of a Prony series, exactly.
//!
//! J(t) = J₀ + Σ Jⱼ(1 − e^{−t/λⱼ}) has the Carson transform Ĵ(s) = J₀ + Σ Jⱼ/(1 + λⱼs), and the moduli have the transform 1/Ĵ (Gross, *Mathematical
//! Structure of the Theories of Viscoelasticity*, 1953). Between two neighbouring poles −1/λⱼ, and beyond the last one, Ĵ decreases through one zero
//! s = −1/τᵢ, which gives
//!
//! E₀ = 1/J₀, E∞ = 1/(J₀ + Σ Jⱼ), Eᵢ = 1/(sᵢ Ĵ′(sᵢ)), τᵢ > λᵢ₋₁ and τᵢ < λᵢ

/// E∞ and (Eᵢ, τᵢ) ascending in τ, from J₀ > 0 and (Jⱼ > 0, λⱼ > 0) ascending in λ.
pub fn moduli(instant: f64, terms: &[(f64, f64)]) -> (f64, Vec<(f64, f64)>) {
    let sum: f64 = terms.iter().map(|t| t.0).sum();
    // x = −s: Ĵ = J₀ + Σ Jⱼ/(1 − λⱼx)
    let transform = |x: f64| instant + terms.iter().map(|(j, l)| j / (1.0 - l * x)).sum::<f64>();
    let slope = |x: f64| -terms.iter().map(|(j, l)| j * l / (1.0 - l * x).powi(2)).sum::<f64>();
    let rates: Vec<f64> = terms.iter().map(|(_, l)| 1.0 / l).collect();
    let zero = |k: usize| {
        // In x, Ĵ rises from −∞ to the right of the pole 1/λ_k towards the next pole, or towards J₀ at infinity
        let mut low = rates[k];
        let mut high = if k == 0 { low * (2.0 + 2.0 * sum / instant) } else { rates[k - 1] };
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if transform(middle) < 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    let one = |k: usize| {
        let x = zero(k);
        (1.0 / (-x * slope(x)), 1.0 / x)
    };
    (1.0 / (instant + sum), (0..terms.len()).map(one).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The standard linear solid E∞ + E e^{−t/τ}: J₀ = 1/(E∞ + E), J∞ = 1/E∞, λ = τ(E∞ + E)/E∞.
    #[test]
    fn a_standard_linear_solid_comes_back() {
        let (long, e, tau) = (2.0, 3.0, 0.7);
        let (instant, lambda) = (1.0 / (long + e), tau * (long + e) / long);
        let (found, terms) = moduli(instant, &[(1.0 / long - instant, lambda)]);
        assert!((found / long - 1.0).abs() < 1e-14, "{found}");
        assert!((terms[0].0 / e - 1.0).abs() < 1e-13 && (terms[0].1 / tau - 1.0).abs() < 1e-13, "{terms:?}");
    }

    /// Ĵ(s) Ê(s) = 1 at any s, with four terms over five decades.
    #[test]
    fn the_transforms_are_reciprocal() {
        let terms = [(0.3, 0.01), (0.1, 0.3), (0.05, 2.0), (0.4, 700.0)];
        let (long, moduli) = moduli(1.5, &terms);
        assert!(moduli.iter().all(|(e, tau)| *e > 0.0 && *tau > 0.0));
        for s in [0.0, 1e-4, 0.1, 1.0, 50.0, 1e4] {
            let j = 1.5 + terms.iter().map(|(j, l)| j / (1.0 + l * s)).sum::<f64>();
            let e = long + moduli.iter().map(|(e, tau)| e * tau * s / (1.0 + tau * s)).sum::<f64>();
            assert!((j * e - 1.0).abs() < 1e-12, "s = {s}: {}", j * e);
        }
        let sum: f64 = moduli.iter().map(|m| m.0).sum();
        assert!(((long + sum) * 1.5 - 1.0).abs() < 1e-12);
    }
}
