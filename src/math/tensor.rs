//! 3×3 tensors and their 9×9 derivatives.
//!
//! Index convention: F\[(i, J)\] = ∂x_i/∂X_J; a fourth-order tensor A_iJkL = ∂P_iJ/∂F_kL is a [`Mat9`] with row 3i + J and
//! column 3k + L.

/// A vector in space, with 3 components \[SI\].
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3×3 tensor.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// A second-order tensor stored by rows, m\[3i+J\], in the order of the rows and columns of [`Mat9`].
pub type Row9 = [f64; 9];

/// A fourth-order tensor as a 9×9 array, `a[3 * i + J][3 * k + L]`.
pub type Mat9 = [[f64; 9]; 9];

/// The zero fourth-order tensor.
pub const ZERO9: Mat9 = [[0.0; 9]; 9];

/// The entries of a tensor by rows.
pub fn rows(m: &Mat3) -> Row9 {
    [m[(0, 0)], m[(0, 1)], m[(0, 2)], m[(1, 0)], m[(1, 1)], m[(1, 2)], m[(2, 0)], m[(2, 1)], m[(2, 2)]]
}

/// The cofactor cof F = J F⁻ᵀ, which is also defined for singular F.
pub fn cofactor(f: &Mat3) -> Mat3 {
    let c = |i: usize, j: usize| {
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        f[(i1, j1)] * f[(i2, j2)] - f[(i1, j2)] * f[(i2, j1)]
    };
    Mat3::from_fn(c)
}

/// J − 1 for F = I + H, computed without cancellation: tr H + ½(tr²H − tr H²) + det H.
pub fn det_minus_one(h: &Mat3) -> f64 {
    let second = h[(0, 0)] * h[(1, 1)] - h[(0, 1)] * h[(1, 0)] + h[(1, 1)] * h[(2, 2)] - h[(1, 2)] * h[(2, 1)]
        + h[(0, 0)] * h[(2, 2)]
        - h[(0, 2)] * h[(2, 0)];
    h.trace() + second + h.determinant()
}

/// A unit vector perpendicular to a unit vector.
pub fn perpendicular(u: &Vec3) -> Vec3 {
    let axis = Vec3::ith(u.iamin(), 1.0);
    u.cross(&axis).normalize()
}
