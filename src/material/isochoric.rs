//! Isochoric parts W(Ī₁, Ī₂) of the modified invariants Ī₁ = J^{−2/3} I₁, Ī₂ = J^{−4/3} I₂, I₂ = ½(I₁² − C:C) = cof F:cof F.
//!
//! With G = F⁻ᵀ, N = ½ ∂I₂/∂F = I₁F − FFᵀF, D₁ = J^{−2/3}(F − ⅓I₁G) = ½ ∂Ī₁/∂F and D₂ = J^{−4/3}(N − ⅔I₂G) = ½ ∂Ī₂/∂F:
//!
//! P = 2W₁D₁ + 2W₂D₂ + U′J G
//!
//! A = 4W₁₁ D₁⊗D₁ + 4W₁₂(D₁⊗D₂ + D₂⊗D₁) + 4W₂₂ D₂⊗D₂ + 2W₁ ∂D₁ + 2W₂ ∂D₂ + (U″J² + U′J) G⊗G − U′J G_iL G_kJ
//!
//! ∂D₁ = J^{−2/3}\[𝕀 − (2/9)I₁ G⊗G + ⅓I₁ G_iL G_kJ\] − ⅔(D₁⊗G + G⊗D₁)
//!
//! ∂D₂ = J^{−4/3}\[2F⊗F + I₁𝕀 − δ_ik (FᵀF)_JL − F_iL F_kJ − (FFᵀ)_ik δ_JL − (8/9)I₂ G⊗G + ⅔I₂ G_iL G_kJ\] − (4/3)(D₂⊗G + G⊗D₂)
//!
//! Source: Holzapfel, *Nonlinear Solid Mechanics*, 2000, ch. 6, written in F.

use super::assemble::isotropic_into;
use super::kinematics::Invariants;
use super::response::{LaneResponse, LawError, Response, Want};
use super::volumetric::Volumetric;
use crate::math::lanes::{Kernel, LANES, Lanes, Real, widest};
use crate::math::tensor::{Mat3, Row9, rows};
use std::marker::PhantomData;

/// W \[J/m³\] and its derivatives \[Pa\] with respect to Ī₁ and Ī₂.
#[derive(Clone, Copy, Default, Debug)]
pub struct Partials {
    pub w: f64,
    pub w1: f64,
    pub w2: f64,
    pub w11: f64,
    pub w12: f64,
    pub w22: f64,
}

/// An isochoric part W(Ī₁, Ī₂), given by its derivatives.
pub trait InvariantEnergy {
    /// Whether it depends on Ī₂; otherwise the second invariant is not computed
    const SECOND: bool;
    /// W and its derivatives at i = Ī₁ − 3 ≥ 0 and k = Ī₂ − 3 ≥ 0 \[–\] (k = 0 if it does not depend on Ī₂)
    fn partials(&self, i: f64, k: f64) -> Result<Partials, LawError>;
}

/// An isochoric part whose constants are parameters.
pub trait Parametric: InvariantEnergy {
    /// ∂/∂θ of [`InvariantEnergy::partials`], where the values of the part change by `rates` per unit of θ
    fn partials_along(&self, rates: &[f64], i: f64, k: f64) -> Result<Partials, LawError>;
}

/// ∂W/∂θ of a part, itself an energy of the same form: its derivatives are ∂/∂θ of the derivatives of W.
pub struct Along<'a, W> {
    pub part: &'a W,
    /// ∂/∂θ of its values
    pub rates: &'a [f64],
}

impl<W: Parametric> InvariantEnergy for Along<'_, W> {
    const SECOND: bool = W::SECOND;

    fn partials(&self, i: f64, k: f64) -> Result<Partials, LawError> {
        self.part.partials_along(self.rates, i, k)
    }
}

/// ψ = W + U, P and A at F.
#[inline(always)]
pub fn response<W: InvariantEnergy>(part: &W, u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
    let (psi, g, factors) = scalars(part, u, f)?;
    let mut r = Response::energy(psi);
    if want >= Want::Residual {
        let f = rows(f);
        let d = Directions::new::<W>(&f, &g, &factors);
        r.p = Mat3::from_row_slice(&d.stress::<W>(&g, &factors));
        if want >= Want::Tangent {
            d.tangent::<W>(&f, &g, &factors, &mut r.a);
        }
    }
    Ok(r)
}

/// ψ = W + U, P and A at [`LANES`] deformation gradients, given by rows; if one is refused, the error has its lane and the reason.
#[inline(always)]
pub fn lanes<W: InvariantEnergy>(
    part: &W,
    u: &Volumetric,
    f: &[Lanes; 9],
    want: Want,
    out: &mut LaneResponse,
) -> Result<(), (usize, LawError)> {
    let (mut g, mut factors) = ([Lanes::ZERO; 9], [Lanes::ZERO; 10]);
    for lane in 0..LANES {
        let f = Mat3::from_fn(|i, j| f[3 * i + j].0[lane]);
        let (psi, of_g, of_factors) = scalars(part, u, &f).map_err(|e| (lane, e))?;
        out.psi.0[lane] = psi;
        g.iter_mut().zip(of_g).for_each(|(to, value)| to.0[lane] = value);
        factors.iter_mut().zip(of_factors).for_each(|(to, value)| to.0[lane] = value);
    }
    if want >= Want::Residual {
        widest(AllLanes::<W> { f, g, factors, want, out, part: PhantomData });
    }
    Ok(())
}

/// ⅓I₁, I₂, U′J, c₁ = 2W₁J^{−2/3}, c₂ = 2W₂J^{−4/3}, the factors of G_iJ G_kL and G_iL G_kJ, and those of d₁⊗d₁, d₁⊗d₂ and d₂⊗d₂ with d₁ = J^{2/3}D₁
/// and d₂ = J^{4/3}D₂. I₂ and the factors that depend on it are 0 for a part without Ī₂.
type Factors<S> = [S; 10];

/// ψ, G by rows, and the factors of the tensors in P and A.
#[inline(always)]
fn scalars<W: InvariantEnergy>(part: &W, u: &Volumetric, f: &Mat3) -> Result<(f64, Row9, Factors<f64>), LawError> {
    let k = Invariants::of_positive(f)?;
    // With c = J^{1/3}, d = c − 1 and x = J − 1 = d³ + 3d² + 3d: J^{−2/3} I₁ − 3 = c⁻²{[I₁ − 3 − 2x] + d²(3 + 2d)}; Ī₂(F) = Ī₁(cof F), where c² and
    // d(2 + d) replace c and d
    let c = k.j.cbrt();
    let d = k.x / (1.0 + c + c * c);
    let m = 1.0 / (c * c);
    let first = m * (k.i_2x + d * d * (3.0 + 2.0 * d));
    let second = if W::SECOND {
        let d = d * (2.0 + d);
        m * m * (k.second_2x(f) + d * d * (3.0 + 2.0 * d))
    } else {
        0.0
    };
    let d = part.partials(first, second)?;
    let (energy, du, d2u) = u.at(k.x);
    let (j, third) = (k.j, (k.i + 3.0) / 3.0);
    let i2 = if W::SECOND { k.cof.norm_squared() } else { 0.0 };
    let (c1, c2, pressure) = (2.0 * m * d.w1, 2.0 * m * m * d.w2, du * j);
    let ww = (d2u * j + du) * j - 2.0 / 3.0 * c1 * third - 8.0 / 9.0 * c2 * i2;
    let xx = c1 * third + 2.0 / 3.0 * c2 * i2 - pressure;
    let (m2, m3, m4) = (m * m, m * m * m, m * m * m * m);
    let dyads = [4.0 * m2 * d.w11, 4.0 * m3 * d.w12, 4.0 * m4 * d.w22];
    let factors = [third, i2, pressure, c1, c2, ww, xx, dyads[0], dyads[1], dyads[2]];
    Ok((d.w + energy, rows(&(k.cof / j)), factors))
}

/// d₁ = F − ⅓I₁G and d₂ = N − ⅔I₂G by rows.
struct Directions<S> {
    d1: [S; 9],
    d2: [S; 9],
}

impl<S: Real> Directions<S> {
    #[inline(always)]
    fn new<W: InvariantEnergy>(f: &[S; 9], g: &[S; 9], [third, i2, ..]: &Factors<S>) -> Self {
        let mut d1 = *f;
        (0..9).for_each(|n| d1[n] = f[n] - g[n] * *third);
        let mut d2 = [S::of(0.0); 9];
        if W::SECOND {
            let (right, i1) = (right(f), S::of(3.0) * *third);
            for n in 0..9 {
                let (i, j) = (n / 3, n % 3);
                let product = f[3 * i] * right[j] + f[3 * i + 1] * right[3 + j] + f[3 * i + 2] * right[6 + j];
                d2[n] = f[n] * i1 - product - g[n] * (S::of(2.0 / 3.0) * *i2);
            }
        }
        Self { d1, d2 }
    }

    /// P = c₁d₁ + c₂d₂ + U′J G
    #[inline(always)]
    fn stress<W: InvariantEnergy>(&self, g: &[S; 9], [_, _, pressure, c1, c2, ..]: &Factors<S>) -> [S; 9] {
        let mut p = self.d1;
        for n in 0..9 {
            p[n] = self.d1[n] * *c1 + g[n] * *pressure;
            if W::SECOND {
                p[n] += self.d2[n] * *c2;
            }
        }
        p
    }

    /// Adds the dyads with G, d₁ or d₂ on the right.
    #[inline(always)]
    fn tangent<W: InvariantEnergy>(&self, f: &[S; 9], g: &[S; 9], factors: &Factors<S>, a: &mut [[S; 9]; 9]) {
        let [third, _, _, c1, c2, ww, xx, k11, k12, k22] = *factors;
        let Self { d1, d2 } = self;
        let (g1, g2) = (S::of(-2.0 / 3.0) * c1, S::of(-4.0 / 3.0) * c2);
        if W::SECOND {
            let of_g = sum([(ww, g), (g1, d1), (g2, d2)]);
            let of_d1 = sum([(g1, g), (k11, d1), (k12, d2)]);
            let of_d2 = sum([(g2, g), (k12, d1), (k22, d2)]);
            isotropic_into(a, c1 + S::of(3.0) * third * c2, xx, g, [(&of_g, g), (&of_d1, d1), (&of_d2, d2)]);
            add_second(a, c2, f);
        } else {
            let (of_g, of_d1) = (sum([(ww, g), (g1, d1)]), sum([(g1, g), (k11, d1)]));
            isotropic_into(a, c1, xx, g, [(&of_g, g), (&of_d1, d1)]);
        }
    }
}

/// P and A of all lanes.
struct AllLanes<'a, W> {
    f: &'a [Lanes; 9],
    g: [Lanes; 9],
    factors: Factors<Lanes>,
    want: Want,
    out: &'a mut LaneResponse,
    part: PhantomData<W>,
}

impl<W: InvariantEnergy> Kernel for AllLanes<'_, W> {
    #[inline(always)]
    fn run(self) {
        let d = Directions::new::<W>(self.f, &self.g, &self.factors);
        self.out.p = d.stress::<W>(&self.g, &self.factors);
        if self.want >= Want::Tangent {
            d.tangent::<W>(self.f, &self.g, &self.factors, &mut self.out.a);
        }
    }
}

/// Σ of factors times tensors.
#[inline(always)]
fn sum<S: Real, const N: usize>(terms: [(S, &[S; 9]); N]) -> [S; 9] {
    let mut out = [S::of(0.0); 9];
    for (factor, tensor) in terms {
        out.iter_mut().zip(tensor).for_each(|(out, x)| *out += factor * *x);
    }
    out
}

/// FᵀF by rows.
#[inline(always)]
fn right<S: Real>(f: &[S; 9]) -> [S; 9] {
    let mut out = *f;
    (0..9).for_each(|n| out[n] = f[n / 3] * f[n % 3] + f[3 + n / 3] * f[3 + n % 3] + f[6 + n / 3] * f[6 + n % 3]);
    out
}

/// FFᵀ by rows.
#[inline(always)]
fn left<S: Real>(f: &[S; 9]) -> [S; 9] {
    let mut out = *f;
    for (n, out) in out.iter_mut().enumerate() {
        let (i, k) = (3 * (n / 3), 3 * (n % 3));
        *out = f[i] * f[k] + f[i + 1] * f[k + 1] + f[i + 2] * f[k + 2];
    }
    out
}

/// a += c\[2F⊗F − δ_ik (FᵀF)_JL − F_iL F_kJ − (FFᵀ)_ik δ_JL\].
#[inline(always)]
fn add_second<S: Real>(a: &mut [[S; 9]; 9], c: S, f: &[S; 9]) {
    let (right, left, two) = (right(f), left(f), S::of(2.0));
    let minus = S::of(-1.0) * c;
    for i in 0..3 {
        for j in 0..3 {
            let row = &mut a[3 * i + j];
            for k in 0..3 {
                for l in 0..3 {
                    row[3 * k + l] += c * (two * f[3 * i + j] * f[3 * k + l] - f[3 * i + l] * f[3 * k + j]);
                }
                row[3 * i + k] += minus * right[3 * j + k];
                row[3 * k + j] += minus * left[3 * i + k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::volumetric::VolumetricKind;

    /// The energy Ī₁ − 3 or Ī₂ − 3 itself.
    struct Invariant {
        second: bool,
    }

    impl InvariantEnergy for Invariant {
        const SECOND: bool = true;

        fn partials(&self, i: f64, k: f64) -> Result<Partials, LawError> {
            Ok(Partials { w: if self.second { k } else { i }, ..Partials::default() })
        }
    }

    /// Compares Ī₁ − 3 and Ī₂ − 3 of F = I + H with 60-digit values for the same F in double precision (the Python module decimal), on both sides of
    /// the switch in [`Invariants`]. The brackets lose at most a digit, so that 1e-14 leaves a margin of one.
    #[test]
    fn invariants_keep_their_digits() {
        let h = Mat3::new(0.3, -0.5, 0.7, 0.2, 0.4, -0.6, -0.1, 0.8, 0.5);
        let u = Volumetric { kind: VolumetricKind::Quadratic, kappa: 0.0 };
        for (size, first, second) in [
            (1e-9, 5.300_000_061_072_299e-19, 5.300_000_061_892_299e-19),
            (1e-6, 5.299_994_880_469_797e-13, 5.299_995_700_470_022e-13),
            (1e-3, 5.294_882_703_638_906e-7, 5.295_702_926_118_829e-7),
            (2e-2, 2.079_471_440_534_058_6e-4, 2.086_060_561_502_623_2e-4),
            (1e-1, 4.814_611_618_196_893e-3, 4.896_939_599_804_436e-3),
            (0.5, 8.354_474_700_712_52e-2, 9.165_917_189_911_232e-2),
            (1.0, 2.238_878_495_583_023_8e-1, 2.647_858_373_832_832e-1),
        ] {
            for (is_second, exact) in [(false, first), (true, second)] {
                let part = Invariant { second: is_second };
                let found = scalars(&part, &u, &(Mat3::identity() + h * size)).expect("J > 0").0;
                assert!((found / exact - 1.0).abs() < 1e-14, "{size}, second {is_second}: {found:e}, not {exact:e}");
            }
        }
    }
}
