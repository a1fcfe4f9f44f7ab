//! Surfaces that follow the body and are written with its fields. They have neither stiffness nor mass.

use crate::mesh::TetMesh;
use crate::mesh::attach::{TooFar, attach};
use crate::mesh::divided::FacetSizes;
use crate::mesh::surface_file::Surface;
use std::collections::BTreeMap;

/// A surface with the nodes that move its vertices.
pub struct NamedSkin {
    pub name: String,
    pub surface: Surface,
    /// \[vertices\] (node, weight), Σ w = 1
    pub weights: Vec<Vec<(u32, f64)>>,
    /// Largest distance from the body that its vertices may have \[m\]
    pub reach: f64,
    /// Largest distance from the body that a vertex has \[m\]
    pub outside: f64,
}

impl NamedSkin {
    /// Displacements \[3 × vertices\] \[m\] for the nodal displacements x.
    pub fn displacement(&self, x: &[f64]) -> Vec<f64> {
        let component =
            |weights: &Vec<(u32, f64)>, i: usize| weights.iter().map(|&(k, w)| w * x[3 * k as usize + i]).sum::<f64>();
        self.weights.iter().flat_map(|w| [0, 1, 2].map(|i| component(w, i))).collect()
    }

    /// The skin with these triangles between its vertices, subdivided for loads so that no triangle is larger than the facets next to it. New vertices that
    /// are further from the body than `reach` \[m\] are refused.
    pub(in crate::scene) fn divided(
        &self,
        mesh: &TetMesh,
        sizes: &FacetSizes,
        triangles: Vec<[u32; 3]>,
        reach: f64,
    ) -> Result<Self, TooFar> {
        let surface = sizes.divided(Surface { points: self.surface.points.clone(), triangles });
        let (mut weights, mut outside) = (self.weights.clone(), self.outside);
        for attached in attach(mesh, &surface.points[weights.len()..], reach)? {
            outside = outside.max(attached.outside);
            weights.push(attached.weights);
        }
        Ok(Self { name: self.name.clone(), surface, weights, reach: self.reach, outside })
    }

    /// The reason why loads on the skin have no limit as h → 0: between its vertices it is further from the body than the vertices may be.
    fn no_limit(&self) -> Option<String> {
        let apart = self.outside * 1e3;
        let why = || {
            format!(
                "the skin {} leaves the body by up to {apart:.4} mm between its vertices, which finer cells do not follow: give one of smaller triangles, \
                 or a region of facets",
                self.name
            )
        };
        (self.outside > self.reach).then(why)
    }

    /// Nodal areas (node, area \[m²\]) and the reason, if there is one, why the load has no limit. The areas are those of the facets on which the skin lies;
    /// otherwise those of its vertices, subdivided for loads and distributed by the transpose of their map.
    pub(in crate::scene) fn nodal_areas(&self, mesh: &TetMesh) -> (Vec<(u32, f64)>, Option<String>) {
        let sizes = FacetSizes::new(mesh);
        match sizes.facets_under(mesh, &self.surface, self.reach) {
            Ok(facets) => (mesh.nodal_areas(&facets), None),
            Err(_) => {
                let divided = self.divided(mesh, &sizes, self.surface.triangles.clone(), f64::INFINITY);
                let divided = divided.expect("everything is within an infinite reach");
                (divided.areas_of_vertices(), divided.no_limit())
            }
        }
    }

    fn areas_of_vertices(&self) -> Vec<(u32, f64)> {
        let mut nodal = BTreeMap::new();
        for (weights, area) in self.weights.iter().zip(self.surface.areas()) {
            weights.iter().for_each(|&(k, w)| *nodal.entry(k).or_insert(0.0) += w * area);
        }
        nodal.into_iter().filter(|(_, area)| *area != 0.0).collect()
    }
}
