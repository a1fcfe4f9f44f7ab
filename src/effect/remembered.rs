//! ½ H:C̄ with a fixed H, C̄ = J^{−2/3} FᵀF: the remembered part of a relaxing stress, and its derivatives with respect to F.

use crate::math::tensor::{Mat3, Mat9, ZERO9, cofactor, rows};

/// ½ H:C̄ and its derivatives with respect to F.
pub(super) struct Remembered {
    h: Mat3,
    /// F H
    fh: Mat3,
    /// F⁻ᵀ
    g: Mat3,
    /// J^{−2/3}
    m: f64,
    /// H:C
    q: f64,
}

impl Remembered {
    /// Computes the terms at an F with J > 0.
    pub(super) fn new(f: &Mat3, h: &Mat3) -> Self {
        let (j, fh) = (f.determinant(), f * h);
        Self { h: *h, fh, g: cofactor(f) / j, m: j.powf(-2.0 / 3.0), q: f.dot(&fh) }
    }

    pub(super) fn p(&self) -> Mat3 {
        self.m * (self.fh - self.q / 3.0 * self.g)
    }

    pub(super) fn a(&self) -> Mat9 {
        let Self { h, fh, g, m, q } = *self;
        let (gr, fhr) = (rows(&g), rows(&fh));
        // The dyads as G ⊗ u + FH ⊗ v.
        let u = rows(&(m * (2.0 / 9.0 * q * g - 2.0 / 3.0 * fh)));
        let v = rows(&(-2.0 / 3.0 * m * g));
        let third = m * q / 3.0;
        let mut out = ZERO9;
        for (row, out) in out.iter_mut().enumerate() {
            for (out, (u, v)) in out.iter_mut().zip(u.iter().zip(&v)) {
                *out = gr[row] * u + fhr[row] * v;
            }
            let (i, j) = (row / 3, row % 3);
            for k in 0..3 {
                for l in 0..3 {
                    out[3 * k + l] += third * gr[3 * i + l] * gr[3 * k + j];
                }
                out[3 * i + k] += m * h[(k, j)];
            }
        }
        out
    }
}
