//! Rigid registration of one set of points onto another, with its uncertainty.
//!
//! Source: Umeyama, IEEE Trans. Pattern Anal. Mach. Intell. 13 (1991) 376–380, eqs. 40–43 without scale; Kabsch, Acta Cryst. A 32 (1976) 922. The
//! rotation is R = U diag(1, 1, det U det V) Vᵀ of the singular value decomposition of Σ wᵢ bᵢ aᵢᵀ about the centroids.
//!
//! Uncertainty: y = R x + t + e with independent errors e of the same variance in all directions, σ²/w. With the small rotation ω about the
//! centroid of the image, δy = ω × (y − ȳ) + τ, so that cov τ = σ²/Σw I and cov ω = σ² (Σ w (|r|² I − r rᵀ))⁻¹, without covariance between the two; σ²
//! = Σ w|e|²/(3n − 6). Limits: linear in ω; the errors of both sets are combined.

use super::error::MotionError;
use crate::math::statistics::{larger, root, t_quantile};
use crate::math::svd::svd;
use crate::math::tensor::{Mat3, Vec3};
use nalgebra::{DMatrix, SMatrix};

/// Covariance of (ω, τ), 6 × 6
pub type Covariance = SMatrix<f64, 6, 6>;

/// Extent of the points across a line relative to that along it, from which on the rotation counts as determined \[–\]
const ACROSS: f64 = 1e-3;
/// Size ratios caused by wrong units, and the tolerance within which they are recognised \[–\]
const UNITS: [(f64, &str); 4] = [
    (10.0, "centimetres and millimetres were confused"),
    (25.4, "inches and millimetres were confused"),
    (100.0, "metres and centimetres were confused"),
    (1000.0, "metres and millimetres were confused"),
];
const ALIKE: f64 = 0.1;
/// Largest ratio of the rms with a reflection to that without, for points that are mirrored \[–\]
const MIRRORED: f64 = 0.1;
/// Rms relative to the size of the points below which it is rounding \[–\]
const ROUNDING: f64 = 1e-12;

/// A rigid motion y = R x + t estimated from points.
#[derive(Clone, Debug)]
pub struct Registration {
    pub rotation: Mat3,
    /// \[m\]
    pub translation: Vec3,
    /// Rms distance of the points after the motion, √(Σ w|e|²/Σ w) \[m\]
    pub rms: f64,
    /// Rms with a reflection \[m\], if it is below a tenth of that without: one set of points is in a left-handed frame, or names are exchanged
    pub mirrored_rms: Option<f64>,
    /// Residual of each point, y − R x − t \[m\]
    pub residuals: Vec<Vec3>,
    /// Distance of each point from its prediction by the others \[m\]; `None` if these do not determine a motion (always for three points)
    pub leave_one_out: Vec<Option<f64>>,
    /// Standard deviation of the error in one direction at unit weight \[m\]
    pub sigma: f64,
    /// Covariance of (ω, τ): the small rotation about `centre` \[rad\] and the shift of `centre` \[m\]
    pub covariance: Covariance,
    /// Centroid of the target points \[m\]
    pub centre: Vec3,
    /// Degrees of freedom of the errors, 3n − 6
    pub free: usize,
    /// Extent of the target points relative to that of the source points \[–\]
    pub size_ratio: f64,
}

impl Registration {
    /// Returns the image of a point \[m\].
    pub fn apply(&self, point: Vec3) -> Vec3 {
        self.rotation * point + self.translation
    }

    /// Returns the covariance of the image of a point \[m²\].
    pub fn covariance_at(&self, point: Vec3) -> Mat3 {
        let by_rotation = -(self.apply(point) - self.centre).cross_matrix();
        let [rotation, shift] = [0, 3].map(|k| self.covariance.fixed_view::<3, 3>(k, k).into_owned());
        by_rotation * rotation * by_rotation.transpose() + shift
    }

    /// Returns the half-widths of the 95 % intervals of the image of a point by Student's t \[m\]; infinite without degrees of freedom.
    pub fn half_widths_at(&self, point: Vec3) -> Vec3 {
        let t = self.quantile();
        self.covariance_at(point).diagonal().map(|v| t * root(v))
    }

    /// Returns the half-widths of the 95 % intervals of the rotation about the three axes \[rad\].
    pub fn rotation_half_widths(&self) -> Vec3 {
        let t = self.quantile();
        Vec3::from_fn(|k, _| t * root(self.covariance[(k, k)]))
    }

    /// Returns the two-sided 95 % quantile of Student's t; infinite without degrees of freedom.
    pub fn quantile(&self) -> f64 {
        if self.free == 0 { f64::INFINITY } else { t_quantile(0.95, self.free) }
    }

    /// Returns the largest and the rms distance of a point from its prediction by the others \[m\].
    pub fn worst_and_rms_left_out(&self) -> Option<[f64; 2]> {
        let all: Vec<f64> = self.leave_one_out.iter().copied().flatten().collect();
        let rms = (all.iter().map(|d| d * d).sum::<f64>() / all.len() as f64).sqrt();
        (!all.is_empty()).then(|| [all.iter().copied().fold(0.0, larger), rms])
    }
}

/// Returns the rigid motion that maps the points `from` onto `to` with the smallest Σ w|e|²; reflections are excluded. Without `weights` all weights
/// are one.
///
/// # Errors
/// Fewer than three points, points on a line, values that are not finite, weights that are not positive, and sizes that differ by the ratio of two
/// units.
pub fn rigid(from: &[Vec3], to: &[Vec3], weights: Option<&[f64]>) -> Result<Registration, MotionError> {
    let ones = vec![1.0; from.len()];
    let weights = weights.unwrap_or(&ones);
    check(from, to, weights)?;
    let size = |points: &[Vec3]| {
        let c = centroid(points, weights);
        points.iter().zip(weights).map(|(p, w)| w * (p - c).norm_squared()).sum::<f64>().sqrt()
    };
    let size_ratio = size(to) / size(from);
    check_size(size_ratio)?;
    not_on_a_line(from)?;
    not_on_a_line(to)?;
    let (rotation, translation) = best(from, to, weights, 1.0);
    let left = |(rotation, translation): (Mat3, Vec3)| -> Vec<Vec3> {
        from.iter().zip(to).map(|(x, y)| y - rotation * x - translation).collect()
    };
    let squares = |e: &[Vec3]| e.iter().zip(weights).map(|(e, w)| w * e.norm_squared()).sum::<f64>();
    let residuals = left((rotation, translation));
    let mirrored = squares(&left(best(from, to, weights, -1.0)));
    let squares = squares(&residuals);
    let total: f64 = weights.iter().sum();
    let free = 3 * from.len() - 6;
    let sigma = (squares / free as f64).sqrt();
    let centre = centroid(to, weights);
    let mut inertia = Mat3::zeros();
    for (x, w) in from.iter().zip(weights) {
        let r = rotation * x + translation - centre;
        inertia += *w * (r.norm_squared() * Mat3::identity() - r * r.transpose());
    }
    let mut covariance = Covariance::zeros();
    // Points that do not lie on a line have a positive inertia about every axis
    let inverse = inertia.try_inverse().unwrap_or_else(|| Mat3::from_element(f64::INFINITY));
    covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&(inverse * sigma.powi(2)));
    covariance.fixed_view_mut::<3, 3>(3, 3).copy_from(&(Mat3::identity() * (sigma.powi(2) / total)));
    let leave_one_out = (0..from.len()).map(|k| left_out(from, to, weights, k)).collect();
    let [rms, mirrored] = [squares, mirrored].map(|s| (s / total).sqrt());
    let is_seen = rms > ROUNDING * size(to) / total.sqrt() && mirrored < MIRRORED * rms;
    Ok(Registration {
        rotation,
        translation,
        rms,
        mirrored_rms: is_seen.then_some(mirrored),
        residuals,
        leave_one_out,
        sigma,
        covariance,
        centre,
        free,
        size_ratio,
    })
}

/// Returns the least-squares rotation, or rotation with reflection, and translation: the matrix has the determinant `hand`, 1 or −1.
fn best(from: &[Vec3], to: &[Vec3], weights: &[f64], hand: f64) -> (Mat3, Vec3) {
    let (a, b) = (centroid(from, weights), centroid(to, weights));
    let mut products = Mat3::zeros();
    for ((x, y), w) in from.iter().zip(to).zip(weights) {
        products += *w * (y - b) * (x - a).transpose();
    }
    let found = svd(DMatrix::from_fn(3, 3, |i, j| products[(i, j)]), true, true);
    let three = |m: Option<DMatrix<f64>>| m.map_or_else(Mat3::identity, |m| Mat3::from_fn(|i, j| m[(i, j)]));
    let (u, vt) = (three(found.u), three(found.v_t));
    let sign = hand * (u.determinant() * vt.determinant()).signum();
    let rotation = u * Mat3::from_diagonal(&Vec3::new(1.0, 1.0, sign)) * vt;
    (rotation, b - rotation * a)
}

/// Returns the distance of point k from its prediction by the other points.
fn left_out(from: &[Vec3], to: &[Vec3], weights: &[f64], k: usize) -> Option<f64> {
    let others = |all: &[Vec3]| all.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, p)| *p).collect::<Vec<_>>();
    let (x, y) = (others(from), others(to));
    let w: Vec<f64> = weights.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, w)| *w).collect();
    if x.len() < 3 || not_on_a_line(&x).is_err() || not_on_a_line(&y).is_err() {
        return None;
    }
    let (rotation, translation) = best(&x, &y, &w, 1.0);
    Some((to[k] - rotation * from[k] - translation).norm())
}

fn centroid(points: &[Vec3], weights: &[f64]) -> Vec3 {
    let total: f64 = weights.iter().sum();
    points.iter().zip(weights).map(|(p, w)| *w * p).sum::<Vec3>() / total
}

fn check(from: &[Vec3], to: &[Vec3], weights: &[f64]) -> Result<(), MotionError> {
    if from.len() != to.len() || from.len() != weights.len() {
        let lengths = vec![from.len(), to.len(), weights.len()];
        return Err(MotionError::Lengths { what: "points and weights to register", lengths });
    }
    if from.len() < 3 {
        return Err(MotionError::TooFew { found: from.len(), names: vec!["points to register".into()] });
    }
    let infinite = from.iter().chain(to).position(|p| !p.iter().all(|x| x.is_finite()));
    if let Some(k) = infinite {
        return Err(MotionError::NotFinite { what: format!("point {} to register", k % from.len() + 1) });
    }
    match weights.iter().position(|w| !(*w > 0.0 && w.is_finite())) {
        Some(k) => Err(MotionError::NotFinite { what: format!("weight {} (or it is not positive)", k + 1) }),
        None => Ok(()),
    }
}

/// Refuses a size ratio that is caused by a wrong unit.
fn check_size(ratio: f64) -> Result<(), MotionError> {
    let near = |of: f64, value: f64| (value / of - 1.0).abs() < ALIKE;
    match UNITS.iter().find(|(of, _)| near(*of, ratio) || near(*of, 1.0 / ratio)) {
        Some((_, meaning)) => Err(MotionError::Size { ratio, meaning: meaning.to_string() }),
        None => Ok(()),
    }
}

/// Refuses points that lie on a line: their extent along the second principal axis is negligible.
pub(super) fn not_on_a_line(points: &[Vec3]) -> Result<(), MotionError> {
    let c = centroid(points, &vec![1.0; points.len()]);
    let found = svd(DMatrix::from_fn(points.len(), 3, |i, j| points[i][j] - c[j]), false, false);
    let root = (points.len() as f64).sqrt();
    let extent = |k: usize| found.singular_values.get(k).copied().unwrap_or(0.0) / root;
    let (along_m, across_m) = (extent(0), extent(1));
    if across_m > ACROSS * along_m { Ok(()) } else { Err(MotionError::Collinear { along_m, across_m }) }
}
