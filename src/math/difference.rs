//! Derivatives of functions of one variable by central differences of eighth order, with an estimate of their error.
//!
//! f′ ≈ Σ_k w_k (f(kh) − f(−kh))/h, k = 1 to 4, with a truncation of h⁸ f⁽⁹⁾/630 (Fornberg, *Math. Comp.* 51, 1988). The same values give another
//! estimate of f′, one-sided and of sixth order: it adds the eighth difference, which is of order h⁷ for a smooth f and half the jump of f′ where f
//! has a kink. The two differ by more than the truncation error of the first and, as a rule, by more than its rounding error, which is about 2ε/h of
//! the values.
//!
//! No step is right for every function: where f changes over a thousandth of its variable, like a contact over its penetration depth, only a small
//! step resolves it; elsewhere a small step only adds rounding errors. Several steps are therefore tried, from the largest on, until the two
//! derivatives agree ([`by_best_step`]).

/// Weights w_k of the central difference of eighth order.
pub const EIGHTH: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
/// Weights w_k of sixth order
const SIXTH: [f64; 4] = [3.0 / 4.0, -3.0 / 20.0, 1.0 / 60.0, 0.0];
/// Eighth difference of f(kh) + f(−kh) − 2f(0), divided by the eighth difference of |k|, so that a kink contributes exactly half of its jump
const ONE_SIDED: [f64; 4] = [56.0 / 40.0, -28.0 / 40.0, 8.0 / 40.0, -1.0 / 40.0];

/// Points of the function values in units of h, in the order of their evaluation.
pub const PLACES: [i32; 9] = [0, 1, -1, 2, -2, 3, -3, 4, -4];

/// Steps that are tried, as exponents of two relative to the size of the variable: 1e-3, 3e-5, 1e-6, 3e-8, 1e-9. The rounding error is about 2ε/h of
/// the values: 5e-13, 1.5e-11, 5e-10, 1.5e-8, 5e-7.
pub const STEPS: [i32; 5] = [-10, -15, -20, -25, -30];
/// Relative error of a derivative that is small enough.
pub const ENOUGH: f64 = 1e-9;
/// Relative error below which rounding may dominate: a smaller step that does not reduce the error is then the last one.
const ROUNDED: f64 = 1e-7;
/// Factor by which a smaller step must reduce the disagreement of the two derivatives to be preferred: rounding can make them agree by chance.
const NEARER: f64 = 100.0;

/// Returns f′(0) and its companion. The [`STEPS`] are tried from the largest on until the error is at most [`ENOUGH`], or at the rounding level; a
/// smaller step replaces a component only if the two derivatives of the component agree decidedly better there.
///
/// `derive` computes both for the step of an index; it returns `None` if f is not defined that far from 0. `error` returns their relative
/// disagreement. An error is returned if every step yields one, `None` if no step can be taken.
pub fn by_best_step<E>(
    mut derive: impl FnMut(usize) -> Option<Result<[Vec<f64>; 2], E>>,
    error: impl Fn(&[Vec<f64>; 2]) -> f64,
) -> Option<Result<[Vec<f64>; 2], E>> {
    let mut best: Option<[Vec<f64>; 2]> = None;
    let (mut refused, mut last) = (None, f64::INFINITY);
    for step in 0..STEPS.len() {
        let found = match derive(step) {
            None => continue,
            Some(Err(why)) => {
                refused.get_or_insert(why);
                continue;
            }
            Some(Ok(found)) => found,
        };
        let own = error(&found);
        let kept = match best.as_mut() {
            None => best.insert(found),
            Some(kept) => {
                take_nearer(kept, &found);
                kept
            }
        };
        let least = error(kept);
        if least <= ENOUGH || least <= ROUNDED && own >= last {
            break;
        }
        last = own;
    }
    best.map(Ok).or(refused.map(Err))
}

/// Takes the components of `found` whose two derivatives agree decidedly better.
fn take_nearer([central, one_sided]: &mut [Vec<f64>; 2], found: &[Vec<f64>; 2]) {
    for i in 0..central.len() {
        let other = [found[0][i], found[1][i]];
        let (kept, new) = ((central[i] - one_sided[i]).abs(), (other[0] - other[1]).abs());
        if NEARER * new < kept || kept.is_nan() {
            [central[i], one_sided[i]] = other;
        }
    }
}

/// Largest difference of two derivatives, relative to the largest of their components; 0 if both are zero, infinite if any component is NaN.
pub fn disagreement(a: &[f64], b: &[f64]) -> f64 {
    if a.iter().chain(b).any(|v| v.is_nan()) {
        return f64::INFINITY;
    }
    let size = a.iter().chain(b).fold(0.0_f64, |m, v| m.max(v.abs()));
    let error = a.iter().zip(b).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    if size > 0.0 { error / size } else { 0.0 }
}

/// Returns f′(0) and its one-sided companion for a function with several components. `f` takes an index into [`PLACES`]. Components that do not
/// change have a derivative of exactly zero.
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

    /// The companion reveals truncation and kinks by more than the error; rounding of 1 + x leaves ε/h, and twice this is allowed.
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

    /// Derivatives of a smooth component, of one that begins 3e-7 away and of one that is defined only below 1e-4: each is accurate to the rounding
    /// of the step that it needs.
    #[test]
    fn the_step_is_small_where_the_function_needs_it() {
        let f = |x: f64| vec![(1.0 + x).exp(), (x + 3e-7).max(0.0), (x + 2e-4).max(0.0).powi(2)];
        let mut tried = Vec::new();
        let derive = |step: usize| {
            let h = 2f64.powi(STEPS[step]);
            tried.push(step);
            (h < 1e-4).then(|| derivatives(h, |place| Ok::<_, ()>(f(f64::from(PLACES[place]) * h))))
        };
        let error = |[a, b]: &[Vec<f64>; 2]| disagreement(a, b);
        let found = by_best_step(derive, error).expect("steps that can be taken").expect("no error");
        for (found, exact) in found[0].iter().zip([1f64.exp(), 1.0, 4e-4]) {
            assert!((found - exact).abs() < 1e-9, "{found} and {exact}");
        }
        assert_eq!(tried, [0, 1, 2, 3]);
        let refused = by_best_step(|_| Some(Err("refused")), error);
        assert_eq!(refused, Some(Err("refused")));
        assert_eq!(by_best_step(|_| None::<Result<_, ()>>, error), None);
    }
}
