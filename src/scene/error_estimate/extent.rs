//! Error of extent: the change of the recorded quantities where regions of nodes whose border runs through cells reach one layer of enriched cells
//! further. The border of the place is between the two.

use super::enrichment::EnrichedScene;
use super::kept_state::Solved;
use crate::scene::Scene;
use crate::scene::notes::cut_regions::CutRegions;

/// Bounds of the error of extent over that change: least, likely, most.
pub(super) const EXTENT: [f64; 3] = [0.0, 0.5, 1.0];

/// The enriched space with wider regions.
pub(super) struct Extent {
    cut: CutRegions,
    /// With the names of those regions
    wider: Option<(EnrichedScene, Vec<String>)>,
    /// Regions whose border runs through cells, and whose change is not known
    unknown: Vec<String>,
    pub factorisations: usize,
}

impl Extent {
    /// The extent in a run of `scene`. Without an enriched space, as where the run is followed whole, no change is known.
    pub fn new(enriched: Option<&EnrichedScene>, scene: &Scene) -> Self {
        let cut = CutRegions::new(scene);
        let (of_nodes, mut unknown) = cut.of_nodes_and_others(&scene.regions);
        let mut wider = None;
        if !of_nodes.is_empty() {
            match enriched.and_then(|enriched| enriched.with_wider_regions(scene, &of_nodes)) {
                Some(found) => wider = Some((found, of_nodes)),
                None => unknown.extend(of_nodes),
            }
        }
        Self { cut, wider, unknown, factorisations: 0 }
    }

    /// The changes of all columns at a solution in this enriched space; zeros without a wider region. Where the wider ones have no equilibrium, their change is
    /// not known.
    pub fn changes(&mut self, enriched: &EnrichedScene, solved: &Solved) -> Vec<f64> {
        if let Some((wider, names)) = self.wider.take() {
            let start = wider.taken(enriched, &solved.end);
            if let Some(columns) = wider.columns_from(&start, &solved.memory, &mut self.factorisations) {
                self.wider = Some((wider, names));
                return solved.values.iter().zip(&columns).map(|(a, b)| b - a).collect();
            }
            self.unknown.extend(names);
        }
        vec![0.0; solved.values.len()]
    }

    /// The regions on which a column depends, and whose change is not known.
    pub fn unknown(&self, column: &str) -> Vec<String> {
        let mut own = self.cut.of(column);
        own.retain(|name| self.unknown.contains(name));
        own
    }
}
