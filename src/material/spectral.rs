//! Energies in principal stretches, of the Valanis–Landel form W = Σᵢ w(ēᵢ), ēᵢ = ln λᵢ − ⅓ ln J, or W = Σᵢ w(eᵢ), eᵢ = ln λᵢ.
//!
//! With λᵢ the principal stretches, F = U diag(λ) Vᵀ, τᵢ = w′(ēᵢ) − ⅓Σⱼ w′(ēⱼ), or w′(eᵢ), and pᵢ = τᵢ/λᵢ:
//!
//! P = U diag(p) Vᵀ
//!
//! A = Σᵢⱼ (∂pᵢ/∂λⱼ) Nᵢ⊗Nⱼ + Σ_{i<j} ½ (pᵢ − pⱼ)/(λᵢ − λⱼ) M⁺ᵢⱼ⊗M⁺ᵢⱼ + ½ (pᵢ + pⱼ)/(λᵢ + λⱼ) M⁻ᵢⱼ⊗M⁻ᵢⱼ,
//! Nᵢ = uᵢvᵢᵀ, M^±ᵢⱼ = uᵢvⱼᵀ ± uⱼvᵢᵀ
//!
//! Repeated stretches: with d = ln λᵢ − ln λⱼ the quotient is (pᵢ − pⱼ)/(λᵢ − λⱼ) = \[w′(ēᵢ) − w′(ēⱼ)\]/\[λᵢλⱼ(eᵈ − 1)\] − τⱼ/(λᵢλⱼ), and for w′ =
//! μ(e^{αē} − 1) the bracket is μ e^{αēⱼ}(e^{αd} − 1)/(eᵈ − 1). Both differences are `exp_m1` of a given number, accurate to the last digits however
//! small it is; at d = 0 the ratio is α. This needs no series and no threshold that affects the result.
//!
//! Near F = I the stretches come from the eigenvalues of FᵀF − I, formed without cancellation; elsewhere from the SVD of F, which keeps the digits of
//! the small ones. Sources: Valanis & Landel 1967; Ogden, *Non-linear Elastic Deformations*, 1984, ch. 6; the modes: Smith, de Goes & Kim, ACM TOG
//! 38(1), 2019.

use super::assemble::{add_dyad, isotropic};
use super::kinematics::Invariants;
use super::polar::SignedSvd;
use super::response::{LawError, Response, Want};
use super::volumetric::Volumetric;
use crate::math::tensor::{Mat3, Row9, Vec3, rows};

/// Values at the three ēᵢ: W = Σw \[J/m³\], w′ and w″ \[Pa\].
#[derive(Clone, Copy, Debug)]
pub struct Sums {
    pub w: f64,
    pub dw: [f64; 3],
    pub d2w: [f64; 3],
}

/// An energy given by w(ē).
pub trait ValanisLandel {
    /// W, w′ and w″ at ē or e \[–\], with W = 0 and w′ = 0 at rest
    fn sums(&self, e: &[f64; 3]) -> Sums;
    /// \[w′(a) − w′(b)\]/(e^{a−b} − 1) \[Pa\] for a ≥ b, including a = b
    fn quotient(&self, a: f64, b: f64) -> f64;
}

/// (e^{αd} − 1)/(eᵈ − 1) \[–\] for d ≥ 0, to the last digits.
#[inline]
pub fn power_quotient(alpha: f64, d: f64) -> f64 {
    // Below 1e-150 the floating-point range is exhausted before the accuracy; the next term is ½α(α − 1)d.
    if d < 1e-150 { alpha } else { (alpha * d).exp_m1() / d.exp_m1() }
}

/// F = U diag(s) Vᵀ with e = ln s.
struct Principal {
    u: Mat3,
    v: Mat3,
    s: [f64; 3],
    e: [f64; 3],
}

impl Principal {
    /// The decomposition of an F with J > 0.
    fn of(f: &Mat3) -> Self {
        let h = f - Mat3::identity();
        if h.norm_squared() < 0.1 {
            let (x, v) = eigen(h + h.transpose() + h.transpose() * h);
            let s = x.map(|x| (1.0 + x).sqrt());
            let u = f * v * Mat3::from_diagonal(&Vec3::from(s.map(f64::recip)));
            Self { u, v, s, e: x.map(|x| 0.5 * x.ln_1p()) }
        } else {
            let SignedSvd { u, s, v } = SignedSvd::of(f);
            Self { u, v, s, e: s.map(f64::ln) }
        }
    }

    /// c uᵢvⱼᵀ + uⱼvᵢᵀ by rows.
    #[inline(always)]
    fn mode(&self, i: usize, j: usize, c: f64) -> Row9 {
        let mut m = [0.0; 9];
        for a in 0..3 {
            for b in 0..3 {
                m[3 * a + b] = c * self.u[(a, i)] * self.v[(b, j)] + self.u[(a, j)] * self.v[(b, i)];
            }
        }
        m
    }
}

/// Eigenvalues and eigenvectors of a symmetric matrix by Jacobi rotations, each to ε‖A‖, in descending order.
fn eigen(mut a: Mat3) -> ([f64; 3], Mat3) {
    let mut v = Mat3::identity();
    let tolerance = 0.25 * f64::EPSILON * a.norm();
    for _ in 0..20 {
        let mut rotated = false;
        for (p, q) in [(0, 1), (1, 2), (0, 2)] {
            let c = a[(p, q)];
            if c.abs() <= tolerance {
                continue;
            }
            rotated = true;
            let zeta = (a[(q, q)] - a[(p, p)]) / (2.0 * c);
            let t = 1.0_f64.copysign(zeta) / (zeta.abs() + (1.0 + zeta * zeta).sqrt());
            let cos = 1.0 / (1.0 + t * t).sqrt();
            let sin = cos * t;
            let r = 3 - p - q;
            (a[(p, p)], a[(q, q)]) = (a[(p, p)] - t * c, a[(q, q)] + t * c);
            (a[(p, r)], a[(q, r)]) = (cos * a[(p, r)] - sin * a[(q, r)], sin * a[(p, r)] + cos * a[(q, r)]);
            (a[(r, p)], a[(r, q)]) = (a[(p, r)], a[(q, r)]);
            (a[(p, q)], a[(q, p)]) = (0.0, 0.0);
            for n in 0..3 {
                (v[(n, p)], v[(n, q)]) = (cos * v[(n, p)] - sin * v[(n, q)], sin * v[(n, p)] + cos * v[(n, q)]);
            }
        }
        if !rotated {
            break;
        }
    }
    let mut x = [a[(0, 0)], a[(1, 1)], a[(2, 2)]];
    for (p, q) in [(0, 1), (1, 2), (0, 1)] {
        if x[p] < x[q] {
            x.swap(p, q);
            v.swap_columns(p, q);
        }
    }
    (x, v)
}

/// ψ = Σ w(ēᵢ) + U(J), P and A at F.
#[inline(always)]
pub fn response<W: ValanisLandel>(part: &W, vol: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
    let k = Invariants::of_positive(f)?;
    let (energy, du, d2u) = vol.at(k.x);
    Ok(sum::<W, true>(part, &k, [energy, du * k.j, (d2u * k.j + du) * k.j], f, want))
}

/// ψ = Σ w(eᵢ) + g(ln J), P and A at F, with g, g′ and g″ at ln J.
pub fn coupled<W: ValanisLandel>(
    part: &W,
    g: impl Fn(f64) -> [f64; 3],
    f: &Mat3,
    want: Want,
) -> Result<Response, LawError> {
    let k = Invariants::of_positive(f)?;
    Ok(sum::<W, false>(part, &k, g(k.ln_j()), f, want))
}

/// The sum of w over ēᵢ if `ISOCHORIC`, otherwise over eᵢ, plus a function of ln J with its derivatives.
#[inline(always)]
fn sum<W: ValanisLandel, const ISOCHORIC: bool>(
    part: &W,
    k: &Invariants,
    [energy, pressure, stiffness]: [f64; 3],
    f: &Mat3,
    want: Want,
) -> Response {
    let d = Principal::of(f);
    let third = |x: [f64; 3], n: f64| if ISOCHORIC { (x[0] + x[1] + x[2]) / n } else { 0.0 };
    let mean = third(d.e, 3.0);
    let e = d.e.map(|e| e - mean);
    let Sums { w, dw, d2w } = part.sums(&e);
    let mut r = Response::energy(w + energy);
    if want < Want::Residual {
        return r;
    }
    let g = k.cof / k.j;
    let middle = third(dw, 3.0);
    let tau = dw.map(|x| x - middle);
    let s = d.s;
    let p = [tau[0] / s[0], tau[1] / s[1], tau[2] / s[2]];
    r.p = d.u * Mat3::from_diagonal(&Vec3::from(p)) * d.v.transpose() + g * pressure;
    if want < Want::Tangent {
        return r;
    }
    r.a = isotropic(0.0, stiffness, -pressure, &rows(&g));
    let n = [0, 1, 2].map(|i| d.mode(i, i, 0.0));
    let all = third(d2w, 9.0);
    for i in 0..3 {
        // ∂τᵢ/∂eⱼ = w″ᵢδᵢⱼ − ⅓(w″ᵢ + w″ⱼ) + (1/9)Σw″, or w″ᵢδᵢⱼ, and ∂pᵢ/∂λⱼ = (∂τᵢ/∂eⱼ − τᵢδᵢⱼ)/(λᵢλⱼ)
        let mut row = [0.0; 9];
        for j in 0..3 {
            let own = if i == j { d2w[i] - tau[i] } else { 0.0 };
            let mixed = if ISOCHORIC { (d2w[i] + d2w[j]) / 3.0 } else { 0.0 };
            let x = (own - mixed + all) / (s[i] * s[j]);
            for (row, n) in row.iter_mut().zip(&n[j]) {
                *row += x * n;
            }
        }
        add_dyad(&mut r.a, 1.0, &n[i], &row);
    }
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let flip = (part.quotient(e[i], e[j]) - tau[j]) / (s[i] * s[j]);
        let twist = (p[i] + p[j]) / (s[i] + s[j]);
        let (plus, minus) = (d.mode(i, j, 1.0), d.mode(i, j, -1.0));
        add_dyad(&mut r.a, 0.5 * flip, &plus, &plus);
        add_dyad(&mut r.a, 0.5 * twist, &minus, &minus);
    }
    r
}
