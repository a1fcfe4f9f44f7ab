//! Homogeneous modes of deformation of a test piece.

use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Mode of deformation of the test piece; λ is the stretch in the loaded direction, J = 1.
///
/// | mode | F | loaded directions |
/// |---|---|---|
/// | uniaxial | diag(λ, λ^-½, λ^-½) | 1; compression has λ < 1 |
/// | equibiaxial | diag(λ, λ, λ⁻²) | 1 and 2, the same nominal stress in both |
/// | planar (pure shear) | diag(λ, 1, λ⁻¹) | 1; the stress that holds direction 2 is not recorded |
/// | simple_shear | I + γ e₁⊗e₂ | the shear stress P₁₂; λ is the principal stretch, γ = λ − λ⁻¹ |
/// | biaxial | diag(λ, λ₂, 1/(λλ₂)) | 1 and 2, one sample each; `second` is the stretch of the other direction |
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    Uniaxial,
    Equibiaxial,
    Planar,
    SimpleShear,
    Biaxial,
}

impl Mode {
    pub const ALL: [Self; 5] = [Self::Uniaxial, Self::Equibiaxial, Self::Planar, Self::SimpleShear, Self::Biaxial];
    /// Modes with one measured stretch, which is λ
    pub const PULLED: [Self; 3] = [Self::Uniaxial, Self::Equibiaxial, Self::Planar];

    /// Name in files and messages
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniaxial => "uniaxial",
            Self::Equibiaxial => "equibiaxial",
            Self::Planar => "planar",
            Self::SimpleShear => "simple_shear",
            Self::Biaxial => "biaxial",
        }
    }

    /// Name in sentences
    pub fn words(self) -> String {
        self.name().replace('_', " ")
    }

    /// The mode that a word in a file denotes: its name, or a usual name in tables.
    pub fn from_word(word: &str) -> Option<Self> {
        let word: String = word.to_lowercase().chars().filter(char::is_ascii_alphanumeric).collect();
        match word.as_str() {
            "uniaxial"
            | "ut"
            | "tension"
            | "simpletension"
            | "uniaxialtension"
            | "uniaxialcompression"
            | "compression" => Some(Self::Uniaxial),
            "equibiaxial" | "equibiaxialtension" | "eb" | "et" => Some(Self::Equibiaxial),
            "planar" | "pureshear" | "planartension" | "ps" | "pt" => Some(Self::Planar),
            "simpleshear" | "ss" => Some(Self::SimpleShear),
            "biaxial" | "biaxialtension" => Some(Self::Biaxial),
            _ => None,
        }
    }

    /// Principal stretches \[–\] at λ: loaded, second, free. `second`: λ₂ of a biaxial test.
    pub fn stretches(self, l: f64, second: f64) -> [f64; 3] {
        match self {
            Self::Uniaxial => [l, 1.0 / l.sqrt(), 1.0 / l.sqrt()],
            Self::Equibiaxial => [l, l, 1.0 / (l * l)],
            Self::Planar | Self::SimpleShear => [l, 1.0, 1.0 / l],
            Self::Biaxial => [l, second, 1.0 / (l * second)],
        }
    }

    /// Principal stretches \[–\] at λ for a material whose stress-free directions follow a constant logarithmic Poisson's ratio ν: e₃ = −ν e₁ if
    /// directions 2 and 3 are free, otherwise −ν(e₁ + e₂)/(1 − ν), with e = ln λ. ν = ½ keeps the volume.
    pub fn stretches_with(self, nu: f64, l: f64, second: f64) -> [f64; 3] {
        let plane = -nu / (1.0 - nu);
        match self {
            _ if nu == 0.5 => self.stretches(l, second),
            Self::Uniaxial => [l, l.powf(-nu), l.powf(-nu)],
            Self::Equibiaxial => [l, l, l.powf(2.0 * plane)],
            Self::Planar => [l, 1.0, l.powf(plane)],
            // Simple shear keeps the volume for every material
            Self::SimpleShear => self.stretches(l, second),
            Self::Biaxial => [l, second, (l * second).powf(plane)],
        }
    }

    /// Nominal stress P \[Pa\] of a law with the principal Kirchhoff stresses τ \[Pa\]: (τ₁ − τ₃)/λ, because the pressure makes direction 3
    /// stress-free; in simple shear P₁₂ = dψ/dγ = (τ₁ − τ₃)/(λ + λ⁻¹), because γ = 2 sinh ln λ.
    pub fn nominal(self, tau: [f64; 3], l: f64) -> f64 {
        (tau[0] - tau[2]) / if self == Self::SimpleShear { l + 1.0 / l } else { l }
    }

    /// λ \[–\] at a measured strain \[–\]: 1 + e, in simple shear ½γ + √(1 + ¼γ²).
    pub fn stretch(self, e: f64) -> f64 {
        if self == Self::SimpleShear { 0.5 * e + (0.5 * e).hypot(1.0) } else { 1.0 + e }
    }

    /// The strain \[–\] that is measured at λ: the inverse of [`Mode::stretch`].
    pub fn strain(self, l: f64) -> f64 {
        if self == Self::SimpleShear { l - 1.0 / l } else { l - 1.0 }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A word that does not name a mode of deformation, with its line in a table.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error(
    "{}\"{word}\" is not a mode of deformation; known: uniaxial, equibiaxial, planar (pure_shear), simple_shear, biaxial",
    at_line(line)
)]
pub struct UnknownMode {
    pub line: Option<u64>,
    pub word: String,
}

fn at_line(line: &Option<u64>) -> String {
    line.map(|l| format!("line {l}: ")).unwrap_or_default()
}

impl FromStr for Mode {
    type Err = UnknownMode;
    fn from_str(word: &str) -> Result<Self, UnknownMode> {
        Self::from_word(word).ok_or_else(|| UnknownMode { line: None, word: word.into() })
    }
}
