//! Error of extent: the change of the recorded quantities where regions of nodes whose border runs through cells reach one layer of enriched cells
//! further. The border of the place is between the two.

use super::enrichment::EnrichedScene;
use super::kept_state::Solved;
use crate::mesh::Region;
use crate::scene::Scene;
use crate::scene::cut_regions;

/// Bounds of the error of extent over that change: least, likely, most.
pub(super) const EXTENT: [f64; 3] = [0.0, 0.5, 1.0];

/// The enriched space with wider regions.
#[derive(Default)]
pub(super) struct Extent {
    /// With the names of those regions
    wider: Option<(EnrichedScene, Vec<String>)>,
    /// Regions whose border runs through cells, and whose change is not known
    pub unknown: Vec<String>,
    pub factorisations: usize,
}

impl Extent {
    /// The extent in a run that is followed whole, whose changes are not known.
    pub fn unknown(scene: &Scene) -> Self {
        Self { unknown: cut_regions(scene), ..Self::default() }
    }

    /// The enriched space with wider regions, if a region of the scene has a border through cells.
    pub fn new(enriched: &EnrichedScene, scene: &Scene) -> Self {
        let is_of_nodes = |region: &Region| region.facets.is_empty() && region.cells.is_empty();
        let (of_nodes, mut unknown): (Vec<String>, Vec<String>) =
            cut_regions(scene).into_iter().partition(|name| is_of_nodes(&scene.regions[name]));
        if of_nodes.is_empty() {
            return Self { unknown, ..Self::default() };
        }
        let wider = match enriched.with_wider_regions(scene, &of_nodes) {
            Some(wider) => Some((wider, of_nodes)),
            None => {
                unknown.extend(of_nodes);
                None
            }
        };
        Self { wider, unknown, factorisations: 0 }
    }

    /// The changes of all columns at a solution in the enriched space; zeros without a wider region. Where the wider ones have no equilibrium, their change is
    /// not known.
    pub fn changes(&mut self, solved: &Solved) -> Vec<f64> {
        if let Some((wider, names)) = self.wider.take() {
            if let Some(columns) = wider.columns_from(&solved.end, &solved.memory, &mut self.factorisations) {
                self.wider = Some((wider, names));
                return solved.values.iter().zip(&columns).map(|(a, b)| b - a).collect();
            }
            self.unknown.extend(names);
        }
        vec![0.0; solved.values.len()]
    }
}
