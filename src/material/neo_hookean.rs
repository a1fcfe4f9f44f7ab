//! Compressible neo-Hookean law with the logarithmic volumetric part.
//!
//! ψ = ½μ(I₁ − 3) − μ ln J + ½λ(ln J)², I₁ = F:F
//!
//! Source: Bonet & Wood, *Nonlinear Continuum Mechanics for Finite Element Analysis*, 2nd ed. 2008, eq. 6.27.
//!
//! Limits: J > 0 only. Not polyconvex: (ln J)² is concave in J beyond J = e, so strong dilatation softens.

use super::assemble::isotropic_into;
use super::entry::LawEntry;
use super::fit_form::{FitForm, FitTerms};
use super::kinematics::Invariants;
use super::law::{Law, LawInfo};
use super::moduli;
use super::moduli::Moduli;
use super::parameter::Parameter;
use super::principal::of_invariants;
use super::response::{LaneResponse, LawError, Response, Want};
use super::volumetric::{Volumetric, VolumetricKind};
use super::yeoh::Yeoh;
use crate::math::lanes::{Kernel, LANES, Lanes, Real, widest};
use crate::math::tensor::{Mat3, Row9, rows};
use crate::math::units::Dimension;

pub static INFO: LawInfo = LawInfo {
    name: "neo_hookean",
    title: "Neo-Hookean",
    formula: "ψ = ½μ(I₁ − 3) − μ ln J + ½λ(ln J)²",
    source: "Bonet & Wood 2008, eq. 6.27",
    limits: "J > 0; (ln J)² softens in strong dilatation, J > e",
    parameters: moduli::PAIR,
    optional: 0,
    choices: &[],
    survives_inversion: false,
    objective: true,
    isochoric: false,
};

/// The law in the registry.
pub const ENTRY: LawEntry =
    LawEntry::elastic(&INFO, |v, _| Ok(Box::new(NeoHookean(Moduli::from_map(v)?)))).with_fit(FIT);

/// The incompressible law in tests with homogeneous deformation.
const FIT: FitForm = FitForm {
    formula: "P = μ(λ − λ⁻²) uniaxial, μ(λ − λ⁻⁵) equibiaxial, μ(λ − λ⁻³) planar",
    source: "Treloar, The Physics of Rubber Elasticity, 3rd ed. (1975), chapter 4",
    parameters: &[Parameter {
        name: "mu",
        symbol: "μ",
        dimension: Dimension::PRESSURE,
        bounds: (0.0, f64::INFINITY),
        meaning: "shear modulus at small strain",
    }],
    term_counts: &[1],
    default_count: 1,
    compressible: false,
    // C10 = ½μ, the first term of Yeoh's law
    terms: FitTerms::Linear(|_, s| of_invariants(&Yeoh { c: [0.5, 0.0, 0.0], terms: 1 }, s)),
};

/// Neo-Hookean law in ln J.
#[derive(Clone, Copy, Debug)]
pub struct NeoHookean(pub Moduli);

impl Law for NeoHookean {
    fn info(&self) -> &'static LawInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.0.e, self.0.nu]
    }

    fn small_strain(&self) -> Moduli {
        self.0
    }

    /// ψ is linear in μ and λ.
    fn along(&self, rates: &[f64]) -> Box<dyn Law> {
        Box::new(Self(self.0.along(rates)))
    }

    /// The rest, ½μ(I₁ − 3) − μ ln J, is not isochoric.
    fn split(&self) -> Option<(Box<dyn Law>, Volumetric)> {
        let volumetric = Volumetric { kind: VolumetricKind::Logarithmic, kappa: self.0.lambda };
        Some((Box::new(Self(Moduli { lambda: 0.0, ..self.0 })), volumetric))
    }

    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let (psi, g, ln) = self.basis(f)?;
        let mut r = Response::energy(psi);
        if want >= Want::Residual {
            r.p = Mat3::from_row_slice(&self.stress(&rows(f), &g, ln));
            if want >= Want::Tangent {
                self.tangent(&g, ln, &mut r.a);
            }
        }
        Ok(r)
    }

    fn eval_lanes(&self, f: &[Lanes; 9], want: Want, out: &mut LaneResponse) -> Result<(), (usize, LawError)> {
        let (mut g, mut ln) = ([Lanes::ZERO; 9], Lanes::ZERO);
        for lane in 0..LANES {
            let f = Mat3::from_fn(|i, j| f[3 * i + j].0[lane]);
            let (psi, of_lane, ln_j) = self.basis(&f).map_err(|e| (lane, e))?;
            (out.psi.0[lane], ln.0[lane]) = (psi, ln_j);
            g.iter_mut().zip(of_lane).for_each(|(g, value)| g.0[lane] = value);
        }
        if want >= Want::Residual {
            widest(Tensors { law: self, f, g, ln, want, out });
        }
        Ok(())
    }
}

impl NeoHookean {
    /// ψ, G = F⁻ᵀ by rows, and ln J.
    #[inline(always)]
    fn basis(&self, f: &Mat3) -> Result<(f64, Row9, f64), LawError> {
        let Moduli { mu, lambda, .. } = self.0;
        let k = Invariants::of_positive(f)?;
        let ln = k.ln_j();
        Ok((0.5 * mu * k.i_2ln(ln) + 0.5 * lambda * ln * ln, rows(&(k.cof / k.j)), ln))
    }

    /// P = μ(F − G) + λ ln J G
    #[inline(always)]
    fn stress<S: Real>(&self, f: &[S; 9], g: &[S; 9], ln: S) -> [S; 9] {
        let (mu, pressure) = (S::of(self.0.mu), S::of(self.0.lambda) * ln);
        let mut p = *f;
        for (p, g) in p.iter_mut().zip(g) {
            *p = (*p - *g) * mu + *g * pressure;
        }
        p
    }

    /// A_iJkL = μ δ_ik δ_JL + λ G_iJ G_kL + (μ − λ ln J) G_iL G_kJ
    #[inline(always)]
    fn tangent<S: Real>(&self, g: &[S; 9], ln: S, a: &mut [[S; 9]; 9]) {
        let (mu, lambda) = (S::of(self.0.mu), S::of(self.0.lambda));
        isotropic_into(a, mu, mu - lambda * ln, g, [(&g.map(|g| lambda * g), g)]);
    }
}

/// P and A of all lanes.
struct Tensors<'a> {
    law: &'a NeoHookean,
    f: &'a [Lanes; 9],
    g: [Lanes; 9],
    ln: Lanes,
    want: Want,
    out: &'a mut LaneResponse,
}

impl Kernel for Tensors<'_> {
    #[inline(always)]
    fn run(self) {
        self.out.p = self.law.stress(self.f, &self.g, self.ln);
        if self.want >= Want::Tangent {
            self.law.tangent(&self.g, self.ln, &mut self.out.a);
        }
    }
}
