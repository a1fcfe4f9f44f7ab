//! Closed forms of fourth-order tensors, A\[3i+J\]\[3k+L\].

use crate::math::lanes::Real;

/// c δ_ik δ_JL + w G_iJ G_kL + x G_iL G_kJ, the form of all laws in F and G = F⁻ᵀ.
#[inline(always)]
pub(crate) fn isotropic<S: Real>(c: S, w: S, x: S, g: &[S; 9]) -> [[S; 9]; 9] {
    let mut a = [[S::of(0.0); 9]; 9];
    isotropic_into(&mut a, c, x, g, [(&g.map(|g| w * g), g)]);
    a
}

/// a = c δ_ik δ_JL + x G_iL G_kJ + Σ u ⊗ v over some dyads (u, v).
#[inline(always)]
pub(crate) fn isotropic_into<S: Real, const N: usize>(
    a: &mut [[S; 9]; 9],
    c: S,
    x: S,
    g: &[S; 9],
    dyads: [(&[S; 9], &[S; 9]); N],
) {
    for i in 0..3 {
        for j in 0..3 {
            let row = &mut a[3 * i + j];
            for k in 0..3 {
                let xg = x * g[3 * k + j];
                for l in 0..3 {
                    let mut sum = xg * g[3 * i + l];
                    for (u, v) in dyads {
                        sum += u[3 * i + j] * v[3 * k + l];
                    }
                    row[3 * k + l] = sum;
                }
            }
            row[3 * i + j] += c;
        }
    }
}

/// a += w u ⊗ v.
#[inline(always)]
pub(crate) fn add_dyad<S: Real>(a: &mut [[S; 9]; 9], w: S, u: &[S; 9], v: &[S; 9]) {
    for (row, ui) in a.iter_mut().zip(u) {
        let wu = w * *ui;
        for (x, vk) in row.iter_mut().zip(v) {
            *x += wu * *vk;
        }
    }
}
