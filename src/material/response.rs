//! Response of a law at one deformation gradient, or at several of them in vector lanes, and the errors of an evaluation.

use crate::math::lanes::{LANES, Lanes};
use crate::math::tensor::{Mat3, Mat9, ZERO9, rows};

/// The required parts of a response; each level includes the previous ones.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Want {
    Energy,
    Residual,
    Tangent,
}

/// Response of a law at one deformation gradient. Parts that were not requested are zero.
#[derive(Clone, Debug)]
pub struct Response {
    /// ψ \[J/m³\]
    pub psi: f64,
    /// P \[Pa\], P\[(i, J)\] = ∂ψ/∂F_iJ
    pub p: Mat3,
    /// A \[Pa\], A\[3i+J\]\[3k+L\] = ∂P_iJ/∂F_kL
    pub a: Mat9,
}

impl Response {
    /// A response with ψ \[J/m³\] alone; P and A are filled in if they are requested.
    pub fn energy(psi: f64) -> Self {
        Self { psi, p: Mat3::zeros(), a: ZERO9 }
    }
}

/// Responses at [`LANES`] deformation gradients. Parts that were not requested keep their values.
#[derive(Clone, Debug)]
pub struct LaneResponse {
    /// ψ \[J/m³\]
    pub psi: Lanes,
    /// P \[Pa\] by rows
    pub p: [Lanes; 9],
    /// A \[Pa\]
    pub a: [[Lanes; 9]; 9],
}

impl Default for LaneResponse {
    fn default() -> Self {
        Self { psi: Lanes::ZERO, p: [Lanes::ZERO; 9], a: [[Lanes::ZERO; 9]; 9] }
    }
}

impl LaneResponse {
    /// Evaluates the lanes one after the other, for laws without arithmetic on lanes; if one is refused, the error has its lane and the reason.
    pub(super) fn fill(
        &mut self,
        f: &[Lanes; 9],
        want: Want,
        eval: impl Fn(&Mat3) -> Result<Response, LawError>,
    ) -> Result<(), (usize, LawError)> {
        for lane in 0..LANES {
            let f = Mat3::from_fn(|i, j| f[3 * i + j].0[lane]);
            self.set(lane, &eval(&f).map_err(|e| (lane, e))?, want);
        }
        Ok(())
    }

    fn set(&mut self, lane: usize, one: &Response, want: Want) {
        self.psi.0[lane] = one.psi;
        if want >= Want::Residual {
            self.p.iter_mut().zip(rows(&one.p)).for_each(|(to, from)| to.0[lane] = from);
        }
        if want >= Want::Tangent {
            let entries = self.a.as_flattened_mut().iter_mut().zip(one.a.as_flattened());
            entries.for_each(|(to, from)| to.0[lane] = *from);
        }
    }
}

/// Errors of a law that is not defined at this deformation.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
pub enum LawError {
    /// det F ≤ 0 \[–\] in a law that requires J > 0
    #[error(
        "det F = {j:e} is not positive, where ln J and J^(-2/3) do not exist; take a smaller step or `stable_neo_hookean`"
    )]
    Inverted { j: f64 },
    /// Ī₁ − 3 \[–\] at or beyond the limit of the law
    #[error(
        "Ī₁ − 3 = {i:e} reaches {limit:e}, beyond which the law is not defined: its chains are fully stretched; take a smaller step or load"
    )]
    Locked { i: f64, limit: f64 },
    /// Outside the domain of a law that is defined elsewhere
    #[error("the law is not defined at this deformation; take a smaller step or load")]
    Undefined,
}
