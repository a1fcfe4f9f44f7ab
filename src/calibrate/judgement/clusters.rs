//! Covariance of the constants from the scatter between specimens, whose data points may lie at different stretches or in different modes.
//!
//! With the rows Uⱼ of specimen j, Gⱼ = UⱼᵀUⱼ and its residual rⱼ, the covariance of the directions is Σⱼ HⱼUⱼᵀrⱼrⱼᵀUⱼHⱼ with Hⱼ = (I − Gⱼ)^(−½),
//! which corrects for the small residual of a specimen that dominates a direction, because the law follows it (CR2: Bell & McCaffrey, Survey
//! Methodology 28, 2002, 169–181; generalised inverse: Pustejovsky & Tipton, J. Bus. Econ. Stat. 36, 2018, 672–683). Student's t has Satterthwaite's
//! degrees of freedom ν = (tr Γ)²/tr Γ² for each constant, with Γ the covariance of the HⱼUⱼᵀrⱼ along it, and the covariance is scaled to be
//! unbiased; both assume errors τ²P̂P̂ᵀ + σ²I: a level of each specimen with the variance τ² on the stresses P̂ of the law, and noise (Imbens &
//! Kolesár, Rev. Econ. Stat. 98, 2016, 701–712). Without P̂ only the noise remains.
//!
//! For k specimens with the same stretches the covariance is k/(k − 1) Σⱼ(Uⱼᵀrⱼ)(Uⱼᵀrⱼ)ᵀ with k − 1 degrees of freedom (Liang & Zeger, Biometrika 73,
//! 1986, 13–22), the covariance s²/k of the mean. Standard errors are stated for k − 1 degrees: they are enlarged by t(ν)/t(k − 1).

use super::directions::Directions;
use crate::math::statistics::real_quantile;
use nalgebra::{DMatrix, DVector};

/// 1 − g below which a direction is determined by one specimen alone, so that nothing is known about its scatter \[–\]
const ALONE: f64 = 1e-9;

/// Sums of one specimen along the directions.
struct Cluster {
    /// UⱼᵀUⱼ
    gram: DMatrix<f64>,
    /// (I − Gⱼ)^(−½)
    root: DMatrix<f64>,
    /// Uⱼᵀrⱼ
    pull: DVector<f64>,
    /// UⱼᵀP̂ⱼ
    level: DVector<f64>,
}

/// Variance of the level of specimens and of the noise of data points.
#[derive(Clone, Copy)]
struct Sizes {
    tau2: f64,
    s2: f64,
}

/// Covariance of the directions from the scatter between the specimens, which are given by their rows, and a factor for each standard error;
/// `fitted`: the stresses of the law.
pub fn scatter(
    directions: &Directions,
    residual: &DVector<f64>,
    fitted: Option<&DVector<f64>>,
    specimens: &[Vec<usize>],
) -> (DMatrix<f64>, Vec<f64>) {
    let u = &directions.u;
    let of = |rows: &Vec<usize>| {
        let own = u.select_rows(rows);
        let gram = own.transpose() * &own;
        let pull = own.transpose() * residual.select_rows(rows);
        let level = fitted.map_or(DVector::zeros(u.ncols()), |f| own.transpose() * f.select_rows(rows));
        Cluster { root: inverse_root(&gram), gram, pull, level }
    };
    let all: Vec<Cluster> = specimens.iter().map(of).collect();
    let sizes = fitted.map_or(Sizes { tau2: 0.0, s2: 1.0 }, |f| sizes(residual, f, specimens, u.ncols()));
    let corrected = |c: &Cluster| &c.root * &c.pull;
    let zero = DMatrix::zeros(u.ncols(), u.ncols());
    let covariance = all.iter().map(corrected).fold(zero, |sum, q| sum + &q * q.transpose());
    let factors = directions.by.row_iter().map(|row| factor(&all, &row.transpose(), sizes)).collect();
    (covariance, factors)
}

/// (I − G)^(−½), with zero along directions that one specimen alone determines.
fn inverse_root(gram: &DMatrix<f64>) -> DMatrix<f64> {
    // The data determine no direction
    if gram.is_empty() {
        return gram.clone();
    }
    let eigen = (DMatrix::identity(gram.nrows(), gram.nrows()) - gram).symmetric_eigen();
    let inverse = eigen.eigenvalues.map(|e| if e > ALONE { e.sqrt().recip() } else { 0.0 });
    &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose()
}

/// Level of each curve, given by its rows: r·P̂/P̂².
pub fn levels(residual: &DVector<f64>, fitted: &DVector<f64>, curves: &[Vec<usize>]) -> Vec<f64> {
    let one = |rows: &Vec<usize>| {
        let (r, f) = (residual.select_rows(rows), fitted.select_rows(rows));
        r.dot(&f) / f.norm_squared().max(f64::MIN_POSITIVE)
    };
    curves.iter().map(one).collect()
}

/// τ² between the specimens, and σ² of the residual without their levels.
fn sizes(residual: &DVector<f64>, fitted: &DVector<f64>, specimens: &[Vec<usize>], p: usize) -> Sizes {
    let k = specimens.len();
    let level = levels(residual, fitted, specimens);
    let mean = level.iter().sum::<f64>() / k as f64;
    let tau2 = level.iter().map(|l| (l - mean).powi(2)).sum::<f64>() / (k - 1) as f64;
    let rest =
        |(rows, l): (&Vec<usize>, &f64)| rows.iter().map(|i| (residual[*i] - l * fitted[*i]).powi(2)).sum::<f64>();
    let square: f64 = specimens.iter().zip(&level).map(rest).sum();
    Sizes { tau2, s2: square / residual.len().saturating_sub(p + k).max(1) as f64 }
}

/// √(variance/expectation of its estimate) · t(ν)/t(k − 1) of the constant along `c`.
fn factor(all: &[Cluster], c: &DVector<f64>, Sizes { tau2, s2 }: Sizes) -> f64 {
    let k = all.len();
    let roots: Vec<DVector<f64>> = all.iter().map(|one| &one.root * c).collect();
    let moved: Vec<DVector<f64>> = all.iter().zip(&roots).map(|(one, b)| &one.gram * b).collect();
    // Along cluster l the estimate of cluster i is Uₗ(δᵢₗbᵢ − Gᵢbᵢ)
    let along = |i: usize, l: usize| if i == l { &roots[i] - &moved[i] } else { -&moved[i] };
    let mut gamma = DMatrix::<f64>::zeros(k, k);
    for (l, one) in all.iter().enumerate() {
        let h: Vec<DVector<f64>> = (0..k).map(|i| along(i, l)).collect();
        let g: Vec<DVector<f64>> = h.iter().map(|h| &one.gram * h).collect();
        let v: Vec<f64> = h.iter().map(|h| one.level.dot(h)).collect();
        for i in 0..k {
            for j in 0..k {
                gamma[(i, j)] += tau2 * v[i] * v[j] + s2 * h[i].dot(&g[j]);
            }
        }
    }
    let trace = gamma.trace();
    let variance = s2 * c.norm_squared() + tau2 * all.iter().map(|one| one.level.dot(c).powi(2)).sum::<f64>();
    let most = (k - 1) as f64;
    if trace.is_nan() || trace <= ALONE * variance {
        return 1.0;
    }
    let free = (trace * trace / gamma.norm_squared()).clamp(1.0, most);
    (variance / trace).sqrt() * real_quantile(0.95, free) / real_quantile(0.95, most)
}
