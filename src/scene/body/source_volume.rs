//! Volumes of a surface or CAD file and of the mesh that was made of it.

use crate::math::units::Decimals;
use crate::mesh::generate::Manifest;
use std::fmt;

/// Difference of the volumes, as a share, above which it is a warning.
const LARGE: f64 = 0.02;

/// The volume that a surface or CAD encloses, without its cavities, and that of its mesh \[m³\].
#[derive(Clone, Debug, PartialEq)]
pub struct SourceVolume {
    pub enclosed: f64,
    pub mesh: f64,
}

impl SourceVolume {
    /// From the manifest of a mesh; none where the mesher does not know the volume that is enclosed.
    pub(in crate::scene) fn of(manifest: &Manifest) -> Option<Self> {
        let enclosed = manifest.volume_cad_m3.filter(|volume| *volume > 0.0)?;
        Some(Self { enclosed, mesh: manifest.volume_m3 })
    }

    /// The volume of the mesh over the enclosed one, less one.
    pub fn difference(&self) -> f64 {
        self.mesh / self.enclosed - 1.0
    }

    /// The warning of a mesh whose volume is far from the enclosed one.
    pub(in crate::scene) fn warning(&self) -> Option<String> {
        (self.difference().abs() > LARGE).then(|| {
            let limit = 100.0 * LARGE;
            format!("the volume of the mesh is far from that of its surface or CAD ({self}; limit {limit} %): use more cells, or a smaller size")
        })
    }
}

impl fmt::Display for SourceVolume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm3 = |volume: f64| format!("{:.4} mm^3", Decimals(1e9 * volume));
        let (enclosed, mesh, difference) = (mm3(self.enclosed), mm3(self.mesh), 100.0 * self.difference());
        // Rounding has no sign
        let difference = if difference.abs() < 5e-4 { 0.0 } else { difference };
        write!(f, "{enclosed} enclosed, {mesh} in the mesh, difference {difference:.3} %")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_difference_of_volumes_is_a_warning() {
        let of = |mesh: f64| SourceVolume { enclosed: 2e-6, mesh };
        assert_eq!(of(1.99e-6).to_string(), "2000.0000 mm^3 enclosed, 1990.0000 mm^3 in the mesh, difference -0.500 %");
        assert_eq!(
            of(2e-6 * (1.0 - 1e-9)).to_string(),
            "2000.0000 mm^3 enclosed, 2000.0000 mm^3 in the mesh, difference 0.000 %"
        );
        assert_eq!(of(1.97e-6).warning(), None);
        assert!(of(1.95e-6).warning().is_some_and(|text| text.contains("difference -2.500 %; limit 2 %")));
        assert!(of(2.05e-6).warning().is_some());
    }
}
