//! The extent of a surface from a file compared with that of the body, which reveals a wrong unit.

use super::mesh_file::usual_units;
use crate::mesh::TetMesh;
use crate::mesh::error::point;
use crate::mesh::surface_file::Surface;

/// Ratio up to which two sizes count as similar.
const ALIKE: f64 = 3.0;
/// Ratio of sizes beyond which a surface is neither a part of the body nor its surroundings.
const FAR_OFF: f64 = 100.0;

/// A surface, the length of the unit of its file \[m\], and the body that it belongs to.
#[derive(Clone, Copy)]
pub(in crate::scene) struct Sizes<'a> {
    pub surface: &'a Surface,
    pub unit_m: f64,
    pub mesh: &'a TetMesh,
}

impl Sizes<'_> {
    /// Both extents, and the unit that would make them similar.
    pub fn words(&self) -> String {
        let ((a, b), (low, high)) = (self.surface.bounds(), self.mesh.bounding_box());
        let (a, b, low, high) = (point(&a), point(&b), point(&low), point(&high));
        let unit = self.other_unit().map_or(String::new(), |unit| format!("; unit = \"{unit}\" would make them alike"));
        format!("the surface fills {a} to {b}, the mesh fills {low} to {high}{unit}")
    }

    /// The first of the usual units that makes the surface and the body similar in size; `None` if the given unit already does.
    pub fn other_unit(&self) -> Option<&'static str> {
        let is_alike = |metre: f64| (self.ratio() * metre / self.unit_m).ln().abs() < ALIKE.ln();
        let fits = usual_units().find(|(_, metre)| is_alike(*metre)).map(|(unit, _)| unit);
        fits.filter(|_| !is_alike(self.unit_m))
    }

    /// Both extents and the likely unit, if the sizes are so different that the unit must be wrong.
    pub fn doubt(&self) -> Option<String> {
        (self.ratio().ln().abs() > FAR_OFF.ln() && self.other_unit().is_some()).then(|| self.words())
    }

    fn ratio(&self) -> f64 {
        let (low, high) = self.surface.bounds();
        (high - low).norm() / self.mesh.diagonal()
    }
}
