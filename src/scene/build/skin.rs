//! Surfaces that follow the body and are written with its fields. They have no stiffness and no mass.

use crate::mesh::surface_file::Surface;
use std::collections::BTreeMap;

/// A surface with the nodes that move its vertices.
pub struct NamedSkin {
    pub name: String,
    pub surface: Surface,
    /// \[vertices\] (node, weight), Σ w = 1
    pub weights: Vec<Vec<(u32, f64)>>,
    /// Distance from the body that its vertices may have \[m\]
    pub reach: f64,
    /// The largest one that a vertex has \[m\]
    pub outside: f64,
}

impl NamedSkin {
    /// \[3 × vertices\] displacement \[m\] with that of the nodes x.
    pub fn displacement(&self, x: &[f64]) -> Vec<f64> {
        let component =
            |weights: &Vec<(u32, f64)>, i: usize| weights.iter().map(|&(k, w)| w * x[3 * k as usize + i]).sum::<f64>();
        self.weights.iter().flat_map(|w| [0, 1, 2].map(|i| component(w, i))).collect()
    }

    /// (node, area \[m²\]): the areas of the vertices, taken to the nodes by the transpose.
    pub(in crate::scene) fn nodal_areas(&self) -> Vec<(u32, f64)> {
        let mut nodal = BTreeMap::new();
        for (weights, area) in self.weights.iter().zip(self.surface.areas()) {
            weights.iter().for_each(|&(k, w)| *nodal.entry(k).or_insert(0.0) += w * area);
        }
        nodal.into_iter().filter(|(_, area)| *area != 0.0).collect()
    }
}
