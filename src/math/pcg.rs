//! Conjugate gradients with a preconditioner P: x with ‖b − A x‖ ≤ bound from products A v and P⁻¹ r.
//!
//! Source: Hestenes & Stiefel, J. Res. NBS 49, 1952; for bordered matrices with a constraint preconditioner, Gould, Hribar & Nocedal, SIAM J. Sci.
//! Comput. 23, 2001: A need be positive definite only on the range of P⁻¹. Limits: it reports an indefinite A, and gives up if P is too far from A.

use super::vector::{dot, norm};

/// How a solve ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The residual is within the bound; the solution x
    Solved(Vec<f64>),
    /// A is not positive definite: v·A v ≤ 0 for some v
    Indefinite,
    /// The residual is still above the bound after the last iteration.
    Slow,
}

/// Solves A x = b from x = 0 with at most `most` products; also returns the number of products that it took.
pub fn pcg(
    mut multiply: impl FnMut(&[f64]) -> Vec<f64>,
    mut precondition: impl FnMut(&[f64]) -> Vec<f64>,
    b: &[f64],
    bound: f64,
    most: usize,
) -> (Outcome, usize) {
    let mut x = vec![0.0; b.len()];
    let mut r = b.to_vec();
    let (mut p, mut size) = (Vec::new(), 0.0);
    for k in 0..=most {
        if norm(&r) <= bound {
            return (Outcome::Solved(x), k);
        }
        if k == most {
            break;
        }
        let z = precondition(&r);
        let last = std::mem::replace(&mut size, dot(&r, &z));
        if k == 0 {
            p = z;
        } else {
            let beta = size / last;
            p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + beta * *p);
        }
        let q = multiply(&p);
        let curvature = dot(&p, &q);
        if size <= 0.0 || curvature <= 0.0 {
            return (Outcome::Indefinite, k);
        }
        let alpha = size / curvature;
        x.iter_mut().zip(&p).for_each(|(x, p)| *x += alpha * p);
        r.iter_mut().zip(&q).for_each(|(r, q)| *r -= alpha * q);
    }
    (Outcome::Slow, most)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P⁻¹A has three distinct eigenvalues, so that three iterations suffice in exact arithmetic (Hestenes & Stiefel 1952, theorem 5:1).
    #[test]
    fn as_many_iterations_as_eigenvalues() {
        let a = |v: &[f64]| v.iter().enumerate().map(|(i, v)| (1.0 + i as f64) * v).collect::<Vec<_>>();
        let p = |r: &[f64]| {
            r.iter().enumerate().map(|(i, r)| (1.0 + 0.5 * (i % 3) as f64) * r / (1.0 + i as f64)).collect::<Vec<_>>()
        };
        let b: Vec<f64> = (0..50).map(|i| (i as f64).cos()).collect();
        let (outcome, iterations) = pcg(a, p, &b, 1e-12 * norm(&b), 50);
        let Outcome::Solved(x) = outcome else { panic!("{outcome:?}") };
        assert_eq!(iterations, 3);
        // The bound on the residual, divided by the smallest eigenvalue, 1
        assert!(x.iter().zip(&b).enumerate().all(|(i, (x, b))| (x - b / (1.0 + i as f64)).abs() < 1e-11));
    }

    #[test]
    fn names_an_indefinite_matrix() {
        let a = |v: &[f64]| vec![v[0], -v[1]];
        assert_eq!(pcg(a, <[f64]>::to_vec, &[1.0, 2.0], 1e-9, 10).0, Outcome::Indefinite);
    }

    #[test]
    fn gives_up() {
        let a = |v: &[f64]| vec![v[0], 1e9 * v[1]];
        assert_eq!(pcg(a, <[f64]>::to_vec, &[1.0, 2.0], 1e-9, 1), (Outcome::Slow, 1));
    }
}
