//! Derivatives of functions of one variable by central differences of eighth order, with an estimate of their error.
//!
//! f′ ≈ Σ_k w_k (f(kh) − f(−kh))/h, k = 1 to 4, with a truncation of h⁸ f⁽⁹⁾/630 (Fornberg, *Math. Comp.* 51, 1988). From the same
//! values comes another derivative, of sixth order and one-sided: it has the eighth difference added, which is of order h⁷ for a smooth f and half
//! of the jump of f′ where f has a kink. The two differ by more than the truncation of the first and,
//! as a rule, by more than its rounding, which is about 2ε/h of the values.

/// w_k
pub const EIGHTH: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
/// The same of sixth order
const SIXTH: [f64; 4] = [3.0 / 4.0, -3.0 / 20.0, 1.0 / 60.0, 0.0];
/// Eighth difference of f(kh) + f(−kh) − 2f(0), divided by that of |k|: the share of a kink counts as it is
const ONE_SIDED: [f64; 4] = [56.0 / 40.0, -28.0 / 40.0, 8.0 / 40.0, -1.0 / 40.0];

/// Places of the values in units of h, in the order in which they are taken.
pub const PLACES: [i32; 9] = [0, 1, -1, 2, -2, 3, -3, 4, -4];

/// f′(0) and its one-sided companion of a function with several components; `f` gets the index of a place. What does not change is exactly zero.
pub fn derivatives<E>(h: f64, mut f: impl FnMut(usize) -> Result<Vec<f64>, E>) -> Result<[Vec<f64>; 2], E> {
    let middle = f(0)?;
    let (mut central, mut one_sided) = (vec![0.0; middle.len()], vec![0.0; middle.len()]);
    for k in 0..4 {
        let (plus, minus) = (f(2 * k + 1)?, f(2 * k + 2)?);
        for i in 0..middle.len() {
            let odd = plus[i] - minus[i];
            let even = (plus[i] - middle[i]) + (minus[i] - middle[i]);
            central[i] += EIGHTH[k] * odd / h;
            one_sided[i] += (SIXTH[k] * odd + ONE_SIDED[k] * even) / h;
        }
    }
    Ok([central, one_sided])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn both(h: f64, f: impl Fn(f64) -> f64) -> (f64, f64) {
        let at = |place: usize| Ok::<_, ()>(vec![f(f64::from(PLACES[place]) * h)]);
        let [central, one_sided] = derivatives(h, at).expect("no error");
        (central[0], one_sided[0])
    }

    /// Exact for x⁸, −h⁸/630 · 9! = −576 h⁸ for x⁹; rounding is ε/h times a few.
    #[test]
    fn the_order_is_eight() {
        let h = 0.01;
        for n in 0..=8 {
            let (found, _) = both(h, |x| (x + 1.0).powi(n));
            assert!((found - f64::from(n)).abs() < 1e-12, "x^{n}: {found}");
        }
        let (found, _) = both(0.1, |x| x.powi(9));
        assert!((found / (-576.0 * 1e-8) - 1.0).abs() < 1e-6, "{found:e}");
    }

    /// The companion sees truncation and kinks by more than the error; rounding of 1 + x leaves ε/h, twice of which is allowed.
    #[test]
    fn the_estimate_is_above_the_error() {
        for h in [1e-1, 1e-2, 1e-4, 1e-6] {
            let (found, other) = both(h, |x| (1.0 + x).ln() * (3.0 + x).exp());
            let exact = 3.0f64.exp();
            let rounding = 2.0 * f64::EPSILON * exact / h;
            assert!((found - exact).abs() <= (found - other).abs().max(rounding), "h = {h}: {found} {other}");
        }
        let (found, other) = both(1e-3, |x| 3.0 * x + 2.0 * x.abs());
        assert!((found - 3.0).abs() < 1e-12 && (other - 5.0).abs() < 1e-11, "{found} {other}");
        assert_eq!(both(1e-3, |_| 0.1), (0.0, 0.0));
    }
}
