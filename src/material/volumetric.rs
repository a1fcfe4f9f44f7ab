//! Volumetric parts U(J) = ½κ G(J)², where G measures the change of volume: the pressure is p = κ G and U' = p G'.

use super::LawError;

/// Which measure of volume change.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum VolumetricKind {
    /// G = J − 1
    Quadratic,
    /// G = ln J
    Logarithmic,
}

/// A volumetric part with its modulus κ [Pa].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Volumetric {
    pub kind: VolumetricKind,
    pub kappa: f64,
}

impl Volumetric {
    /// G, dG/dJ, d²G/dJ² at x = J − 1 [–].
    pub fn gap(&self, x: f64) -> Result<(f64, f64, f64), LawError> {
        let j = 1.0 + x;
        match self.kind {
            VolumetricKind::Quadratic => Ok((x, 1.0, 0.0)),
            VolumetricKind::Logarithmic if j > 0.0 => Ok((x.ln_1p(), 1.0 / j, -1.0 / (j * j))),
            VolumetricKind::Logarithmic => Err(LawError::Inverted { j }),
        }
    }
}
