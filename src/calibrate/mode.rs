//! Homogeneous modes of deformation of an incompressible test piece.

use super::FitError;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// How the test piece is stretched; λ is the stretch in the loaded direction, J = 1.
///
/// | mode | F | loaded directions |
/// |---|---|---|
/// | uniaxial | diag(λ, λ^-½, λ^-½) | 1 |
/// | equibiaxial | diag(λ, λ, λ⁻²) | 1 and 2, the same nominal stress in both |
/// | planar (pure shear) | diag(λ, 1, λ⁻¹) | 1; the stress that holds direction 2 is not recorded |
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    Uniaxial,
    Equibiaxial,
    Planar,
}

impl Mode {
    pub const ALL: [Self; 3] = [Self::Uniaxial, Self::Equibiaxial, Self::Planar];

    /// Name in files and messages
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniaxial => "uniaxial",
            Self::Equibiaxial => "equibiaxial",
            Self::Planar => "planar",
        }
    }

    /// The mode that a word in a file means: `uniaxial`, `equibiaxial`, `planar`, and what tables call them.
    pub fn from_word(word: &str) -> Option<Self> {
        let word: String = word.to_lowercase().chars().filter(char::is_ascii_alphanumeric).collect();
        match word.as_str() {
            "uniaxial" | "ut" | "tension" | "simpletension" | "uniaxialtension" | "uniaxialcompression" => {
                Some(Self::Uniaxial)
            }
            "equibiaxial" | "equibiaxialtension" | "eb" | "et" => Some(Self::Equibiaxial),
            "planar" | "pureshear" | "planartension" | "ps" | "pt" => Some(Self::Planar),
            _ => None,
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Mode {
    type Err = FitError;
    fn from_str(word: &str) -> Result<Self, FitError> {
        Self::from_word(word).ok_or_else(|| FitError::ModeWord { line: None, word: word.into() })
    }
}
