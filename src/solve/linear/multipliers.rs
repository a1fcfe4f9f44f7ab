//! The few dense constraints in addition to K: the change of the multipliers from the Schur complement, under the laws of the constraints.

use super::tangent;
use crate::math::linear::{Factor, LinearError};
use crate::math::statistics::{larger, smaller};
use crate::math::vector::dot;
use crate::system::{Assembled, ConstraintKind, ConstraintValues, LawPiece, LinearFunction, System, constraint_law};

/// Share of the largest diagonal entry of S of linked constraints that is added to the diagonal of each: if two of them fix the same length, one
/// tension is undetermined and keeps its value. The term acts on the step and vanishes with it.
const PROXIMAL: f64 = 1e-9;
/// Rounding error of a constraint relative to its scale.
const ROUNDING: f64 = 1e-14;
/// Largest number of pivots; m constraints need a few times m.
const PIVOTS: usize = 10_000;

/// Z = K⁻¹ Hᵀ and S = H Z + compliance for the current factorisation.
#[derive(Default)]
pub(in crate::solve) struct Schur {
    /// \[constraints × equations\]; zero for a monitored constraint
    pub z: Vec<f64>,
    /// \[constraints × constraints\]
    pub s: Vec<f64>,
    /// Number of negative eigenvalues of S on the constraints that act on the body
    pub negative: usize,
}

impl Schur {
    /// Computes Z and S of these constraints of the system, each with its gradient; `factor` holds the K of `sums`.
    pub fn new(
        factor: &mut Factor,
        sums: &Assembled,
        system: &System,
        rows: &[usize],
        gradient: &[Vec<f64>],
    ) -> Result<Self, LinearError> {
        let m = rows.len();
        if m == 0 {
            return Ok(Self::default());
        }
        let acting: Vec<usize> =
            (0..m).filter(|&i| system.constraints[rows[i]].kind() != ConstraintKind::Monitored).collect();
        let mut solved: Vec<f64> = acting.iter().flat_map(|&i| gradient[i].iter().copied()).collect();
        tangent::solve(factor, sums, &mut solved)?;
        let n = gradient[0].len();
        let mut z = vec![0.0; m * n];
        for (&i, column) in acting.iter().zip(solved.chunks_exact(n)) {
            z[i * n..(i + 1) * n].copy_from_slice(column);
        }
        Ok(Self::of(z, system, rows, gradient))
    }

    /// Completes Z of these rows \[constraints × equations\] with the resulting S.
    pub fn of(z: Vec<f64>, system: &System, rows: &[usize], gradient: &[Vec<f64>]) -> Self {
        let m = rows.len();
        if m == 0 {
            return Self::default();
        }
        let n = gradient[0].len();
        let kinds: Vec<ConstraintKind> = rows.iter().map(|&c| system.constraints[c].kind()).collect();
        let acting: Vec<usize> = (0..m).filter(|&i| kinds[i] != ConstraintKind::Monitored).collect();
        let mut s: Vec<f64> = (0..m * m).map(|ij| dot(&gradient[ij / m], &z[(ij % m) * n..(ij % m + 1) * n])).collect();
        (0..m).for_each(|i| s[i * m + i] += system.constraints[rows[i]].compliance());
        let symmetric = nalgebra::DMatrix::from_fn(acting.len(), acting.len(), |a, b| {
            0.5 * (s[acting[a] * m + acting[b]] + s[acting[b] * m + acting[a]])
        });
        let negative = symmetric.symmetric_eigenvalues().iter().filter(|&&e| e < 0.0).count();
        let most = softest_link(&s, &kinds);
        (0..m).filter(|&i| kinds[i] == ConstraintKind::Linked).for_each(|i| s[i * m + i] += PROXIMAL * most);
        Self { z, s, negative }
    }

    /// Returns the multipliers after the step, with g' = g + `shift` + S (λ' − λ), under the laws of all constraints of the system, and for each
    /// constraint whether the active piece of its law depends on g.
    pub fn multipliers(
        &self,
        system: &System,
        rows: &ConstraintValues,
        shift: &[f64],
    ) -> Option<(Vec<f64>, Vec<bool>)> {
        let laws: Vec<Vec<LawPiece>> =
            system.constraints.iter().enumerate().map(|(c, row)| constraint_law(row.as_ref(), c, rows)).collect();
        let (change, chosen) = change(&self.s, shift, &laws)?;
        let kinds: Vec<ConstraintKind> = system.constraints.iter().map(|row| row.kind()).collect();
        let softest = softest_link(&self.s, &kinds);
        let settle = |c: usize| {
            let row = &system.constraints[c];
            let lambda = row.kind().admit(rows.lambda[c] + change[c]);
            // A linked multiplier that moves the body only by rounding counts as zero
            let noise = if row.kind() == ConstraintKind::Linked { ROUNDING * row.scale() / softest } else { 0.0 };
            if lambda.abs() <= noise { 0.0 } else { lambda }
        };
        let holds = laws.iter().zip(chosen).map(|(law, piece)| !law[piece].equation.g.is_empty()).collect();
        Some(((0..laws.len()).map(settle).collect(), holds))
    }
}

/// The largest diagonal entry of S of linked constraints, all of which fix lengths; the entries of others have other units.
fn softest_link(s: &[f64], kinds: &[ConstraintKind]) -> f64 {
    let m = kinds.len();
    (0..m).filter(|&i| kinds[i] == ConstraintKind::Linked).map(|i| s[i * m + i]).fold(0.0, f64::max)
}

/// Largest deviation of the constraints from their laws, relative to the scales.
pub(in crate::solve) fn error(system: &System, rows: &ConstraintValues) -> f64 {
    let of_row = |c: usize| {
        constraint_law(system.constraints[c].as_ref(), c, rows).iter().map(LawPiece::error).fold(f64::INFINITY, smaller)
    };
    let finite = |c: usize| rows.g[c].is_finite() && rows.lambda[c].is_finite();
    let error = |c: usize| if finite(c) { of_row(c) } else { f64::NAN };
    (0..system.constraints.len()).map(error).fold(0.0, larger)
}

/// A linear function of the values after the step, Σ a_j Δλ_j + b.
struct Linear {
    a: Vec<f64>,
    b: f64,
}

impl Linear {
    fn new(function: &LinearFunction, s: &[f64], shift: &[f64]) -> Self {
        let m = shift.len();
        let (mut a, mut b) = (vec![0.0; m], function.value);
        for &(i, d) in &function.g {
            a.iter_mut().zip(&s[i * m..(i + 1) * m]).for_each(|(a, s)| *a += d * s);
            b += d * shift[i];
        }
        function.lambda.iter().for_each(|&(j, d)| a[j] += d);
        Self { a, b }
    }

    /// Whether the function is negative beyond the rounding of its terms.
    fn violated(&self, change: &[f64], scale: f64) -> bool {
        let size = self.a.iter().zip(change).map(|(a, x)| (a * x).abs()).sum::<f64>() + self.b.abs() + scale;
        dot(&self.a, change) + self.b < -ROUNDING * size
    }
}

/// Computes Δλ under the laws, and the active piece of each row, by principal pivoting with the least index (Murty 1974, who proves that it
/// terminates for laws 0 ≤ g ⟂ λ ≥ 0 and an S with positive principal minors): all constraints start with their first piece, and the first violated
/// inequality determines the next piece of its row.
fn change(s: &[f64], shift: &[f64], laws: &[Vec<LawPiece>]) -> Option<(Vec<f64>, Vec<usize>)> {
    let m = laws.len();
    let mut chosen = vec![0; m];
    for _ in 0..PIVOTS {
        let equations: Vec<Linear> =
            laws.iter().zip(&chosen).map(|(law, &p)| Linear::new(&law[p].equation, s, shift)).collect();
        let matrix = nalgebra::DMatrix::from_fn(m, m, |i, j| equations[i].a[j]);
        let rhs = nalgebra::DVector::from_fn(m, |i, _| -equations[i].b);
        // Constraints are in metres or in newtons: each row is divided by its largest entry for the pivoting
        let size: Vec<f64> = matrix.row_iter().map(|row| row.amax()).collect();
        let matrix = nalgebra::DMatrix::from_fn(m, m, |i, j| matrix[(i, j)] / size[i]);
        let rhs = nalgebra::DVector::from_fn(m, |i, _| rhs[i] / size[i]);
        let mut change: Vec<f64> = matrix.lu().solve(&rhs)?.iter().copied().collect();
        // A multiplier that its piece fixes has no rounding error
        for (i, equation) in equations.iter().enumerate() {
            if laws[i][chosen[i]].equation.g.is_empty() && laws[i][chosen[i]].equation.lambda.len() == 1 {
                let j = laws[i][chosen[i]].equation.lambda[0].0;
                change[j] = -equation.b / equation.a[j];
            }
        }
        if change.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let wrong = (0..m).find_map(|i| {
            let inequalities = &laws[i][chosen[i]].inequalities;
            let broken = inequalities.iter().find(|(f, _)| Linear::new(f, s, shift).violated(&change, f.scale));
            broken.map(|(_, next)| (i, *next))
        });
        match wrong {
            None => return Some((change, chosen)),
            Some((i, next)) => chosen[i] = next,
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::bounded_multiplier;

    /// Two constraints with 0 ≤ λ ≤ most, from λ = 0: g' = q + S λ'.
    fn solve(s: &[f64; 4], q: &[f64; 2], most: f64) -> Vec<f64> {
        let rows = ConstraintValues { now: 0.0.into(), g: q, lambda: &[0.0; 2], old: &[0.0; 2], force: 0.0 };
        let laws: Vec<_> =
            (0..2).map(|c| bounded_multiplier(&rows, c, LinearFunction::gap(&rows, c..c + 1, 1.0), most)).collect();
        change(s, &[0.0; 2], &laws).expect("S is positive definite").0
    }

    #[test]
    fn holds_complementarity() {
        let s = [2.0, 0.5, 0.5, 1.0];
        for q in [[-1.0, 1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, -1.0], [-1.0, 0.0]] {
            let lambda = solve(&s, &q, f64::INFINITY);
            for i in 0..2 {
                let w = q[i] + dot(&s[2 * i..2 * i + 2], &lambda);
                assert!(lambda[i] >= 0.0 && w > -1e-15 && (w * lambda[i]).abs() < 1e-15, "q = {q:?}, row {i}");
            }
            // The same rows, with an upper bound of 0.3
            let capped = solve(&s, &q, 0.3);
            for i in 0..2 {
                let w = q[i] + dot(&s[2 * i..2 * i + 2], &capped);
                let right = match capped[i] {
                    0.0 => w > -1e-15,
                    0.3 => w < 1e-15,
                    lambda => (0.0..0.3).contains(&lambda) && w.abs() < 1e-15,
                };
                assert!(right, "q = {q:?}, row {i}: λ = {}, g = {w}", capped[i]);
            }
        }
    }
}
