//! Volumes of a surface or CAD file, or of the round body of a grid, and of the mesh that was made of it.

use crate::math::units::Decimals;
use crate::mesh::TetMesh;
use crate::mesh::generate::Manifest;
use std::fmt;

/// Relative difference of the volumes above which there is a warning.
const LARGE: f64 = 0.02;
/// Relative difference of the volumes that is allowed for curved cells some of whose edges left the CAD; on the CAD it is within 1e-4 with a few cells around
/// a circle.
const LARGE_OF_STRAIGHTENED: f64 = 0.002;
/// Relative error that the change to a smooth surface may have, as in the bounds of the geometry error.
const OF_SMOOTH: f64 = 0.5;

/// The volume enclosed by a surface or CAD body, one of its solids, or a round grid, without its cavities, and the volume of its mesh \[m³\].
#[derive(Clone, Debug, PartialEq)]
pub struct SourceVolume {
    /// Name of the solid or of the cavity; `None` for the whole
    pub region: Option<String>,
    pub enclosed: f64,
    pub mesh: f64,
    /// Whether edges of curved cells left the CAD
    pub straightened: bool,
}

impl SourceVolume {
    /// The volumes in the manifest of a mesh: the whole first, then the solids, which can differ although the whole agrees where the surface between two of
    /// them is displaced, or the cavities of a surface. Empty if the mesher does not know the enclosed volume.
    pub(in crate::scene) fn all(manifest: &Manifest, mesh: &TetMesh) -> Vec<Self> {
        let straightened = manifest.straightened_edges.is_some_and(|edges| edges > 0);
        let of = |region, enclosed, mesh| Self { region, enclosed, mesh, straightened };
        let whole = manifest.volume_cad_m3.map(|enclosed| of(None, enclosed, manifest.volume_m3));
        let solids = manifest
            .volumes_cad_m3
            .iter()
            .map(|(name, enclosed)| of(Some(name.clone()), *enclosed, mesh.volume_of(&mesh.regions[name])));
        whole.into_iter().chain(solids).filter(|volume| volume.enclosed > 0.0).collect()
    }

    /// The volume of a grid that fills a round body of volume `round`; empty for other grids.
    pub(in crate::scene) fn of_grid(round: Option<f64>, mesh: &TetMesh) -> Vec<Self> {
        let of = |enclosed| Self { region: None, enclosed, mesh: mesh.volume(), straightened: false };
        round.map(of).into_iter().collect()
    }

    /// The same volume with the name of the part of the scene to which its body belongs.
    pub(in crate::scene) fn of_part(&self, part: &str) -> Self {
        let region = format!("{part}.{}", self.region.as_deref().unwrap_or("body"));
        Self { region: Some(region), ..self.clone() }
    }

    /// Relative difference of the volume of the mesh from the enclosed one.
    pub fn difference(&self) -> f64 {
        self.mesh / self.enclosed - 1.0
    }

    /// Whether a smooth surface through the nodes, which changes the volume by the share `gain`, differs from the surface of the CAD by more than is allowed.
    pub(in crate::scene) fn is_missed(&self, gain: f64) -> bool {
        let limit = if self.straightened { LARGE_OF_STRAIGHTENED } else { LARGE };
        let left = (1.0 + self.difference()) * (1.0 + gain) - 1.0;
        left.abs() > OF_SMOOTH * gain.abs() + limit
    }

    /// The warning about a mesh whose volume is far from the enclosed one.
    pub(in crate::scene) fn warning(&self) -> Option<String> {
        (self.difference().abs() > LARGE).then(|| {
            let limit = 100.0 * LARGE;
            let cause = match self.region {
                None => "",
                Some(_) => ", also where the whole agrees, since the cells cut its own surface",
            };
            format!("the volume of the mesh is far from that of its surface or CAD ({self}; limit {limit} %){cause}: use more cells, or a smaller size")
        })
    }
}

impl fmt::Display for SourceVolume {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm3 = |volume: f64| format!("{:.4} mm^3", Decimals(1e9 * volume));
        let (enclosed, mesh, difference) = (mm3(self.enclosed), mm3(self.mesh), 100.0 * self.difference());
        // A difference that rounds to zero is shown without a sign
        let difference = if difference.abs() < 5e-4 { 0.0 } else { difference };
        let of = self.region.as_ref().map_or_else(String::new, |name| format!("{name}: "));
        write!(f, "{of}{enclosed} enclosed, {mesh} in the mesh, difference {difference:.3} %")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::structured::block;
    use crate::mesh::{Order, Region};

    #[test]
    fn a_large_difference_of_volumes_is_a_warning() {
        let of = |mesh: f64| SourceVolume { region: None, enclosed: 2e-6, mesh, straightened: false };
        assert_eq!(of(1.99e-6).to_string(), "2000.0000 mm^3 enclosed, 1990.0000 mm^3 in the mesh, difference -0.500 %");
        assert_eq!(
            of(2e-6 * (1.0 - 1e-9)).to_string(),
            "2000.0000 mm^3 enclosed, 2000.0000 mm^3 in the mesh, difference 0.000 %"
        );
        assert_eq!(of(1.97e-6).warning(), None);
        assert!(of(1.95e-6).warning().is_some_and(|text| text.contains("difference -2.500 %; limit 2 %")));
        assert!(of(2.05e-6).warning().is_some());
        // For curved cells whose edges left the CAD a smaller difference is already too large
        let curved = |mesh: f64| SourceVolume { straightened: true, ..of(mesh) };
        let meshes = [1.997e-6, 1.99e-6, 1.95e-6];
        assert_eq!(meshes.map(|mesh| of(mesh).is_missed(0.0)), [false, false, true]);
        assert_eq!(meshes.map(|mesh| curved(mesh).is_missed(0.0)), [false, true, true]);
        // A smooth surface that fills all or most of what the facets cut off is that of the CAD; one that removes more is not
        assert_eq!([0.1, 0.08, 0.04, -0.1].map(|gain| of(1.8e-6).is_missed(gain)), [false, false, true, true]);
    }

    /// In a scene of two bodies, the volume of each is compared with that of its own cells.
    #[test]
    fn the_volume_of_a_part_is_that_of_its_region() {
        let whole = SourceVolume { region: None, enclosed: 2e-6, mesh: 1.9e-6, straightened: false };
        let solid = SourceVolume { region: Some("core".into()), ..whole.clone() };
        let of_left = |volume: &SourceVolume| volume.of_part("left").region;
        assert_eq!([of_left(&whole), of_left(&solid)], ["left.body", "left.core"].map(|name| Some(name.into())));
        assert_eq!(SourceVolume { region: None, ..whole.of_part("left") }, whole);
    }

    /// Two halves of a block of 2 mm^3 whose interface is shifted by a quarter of the block: the whole agrees, and the solids do not.
    #[test]
    fn solids_are_compared_one_by_one() {
        let mut mesh = block(4, 1, 1, 2e-3, 1e-3, 1e-3, Order::Linear);
        let is_left = |c: &u32| mesh.cell(*c as usize).iter().all(|node| mesh.points[*node as usize].x < 1.6e-3);
        let (left, right): (Vec<u32>, Vec<u32>) = (0..mesh.cell_count() as u32).partition(is_left);
        for (name, cells) in [("volume_1", left), ("volume_2", right)] {
            mesh.regions.insert(name.into(), Region { cells, ..Region::default() });
        }
        let text = r#"{"request":{},"cells":24,"nodes":20,"facets":36,"order":1,"h_m":0.0004,"regions":{},"volume_m3":2e-9,"volume_cad_m3":2e-9,
            "volume_error":0.0,"volumes_cad_m3":{"volume_1":1e-9,"volume_2":1e-9}}"#;
        let manifest: Manifest = serde_json::from_str(text).expect("a manifest");
        let told: Vec<String> = SourceVolume::all(&manifest, &mesh).iter().map(ToString::to_string).collect();
        assert_eq!(
            told,
            [
                "2.0000 mm^3 enclosed, 2.0000 mm^3 in the mesh, difference 0.000 %",
                "volume_1: 1.0000 mm^3 enclosed, 1.5000 mm^3 in the mesh, difference 50.000 %",
                "volume_2: 1.0000 mm^3 enclosed, 0.5000 mm^3 in the mesh, difference -50.000 %",
            ]
        );
        let warned: Vec<bool> =
            SourceVolume::all(&manifest, &mesh).iter().map(|volume| volume.warning().is_some()).collect();
        assert_eq!(warned, [false, true, true]);
    }

    /// The volume of a cavity is that which its facets enclose, wherever the mesh lies: here those around a block of 2 mm^3, with curved cells of straight edges too.
    #[test]
    fn the_volume_of_a_cavity_is_that_within_its_facets() {
        for order in [Order::Linear, Order::Quadratic] {
            let mut mesh = block(4, 1, 1, 2e-3, 1e-3, 1e-3, order);
            mesh.points.iter_mut().for_each(|p| p.x += 0.5);
            let facets = (0..mesh.facet_count() as u32).collect();
            mesh.regions.insert("cavity".into(), Region { facets, ..Region::default() });
            let text = r#"{"request":{},"cells":24,"nodes":20,"facets":36,"order":1,"h_m":0.0004,"regions":{},"volume_m3":2e-9,"volume_cad_m3":2e-9,
                "volume_error":0.0,"volumes_cad_m3":{"cavity":2.5e-9}}"#;
            let manifest: Manifest = serde_json::from_str(text).expect("a manifest");
            let [_, cavity] = &SourceVolume::all(&manifest, &mesh)[..] else { panic!("two volumes") };
            assert!((cavity.difference() + 0.2).abs() < 1e-9, "{cavity}");
            assert!(cavity.warning().is_some_and(|told| told.contains("cavity: 2.5000 mm^3 enclosed")));
        }
    }
}
