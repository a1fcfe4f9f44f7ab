//! Error of extent: the change of the recorded quantities when regions of nodes whose border cuts through cells are widened by one layer of enriched cells.
//! The true border lies between the two.

use super::enrichment::EnrichedScene;
use super::kept_state::{Solved, Start};
use crate::scene::Scene;
use crate::scene::notes::cut_regions::CutRegions;

/// Bounds of the error of extent relative to that change: smallest, likely, largest.
pub(super) const EXTENT: [f64; 3] = [0.0, 0.5, 1.0];

/// The enriched space with wider regions.
pub(super) struct ExtentSpace {
    cut: CutRegions,
    wider: Option<Wider>,
    /// Regions whose border cuts through cells and for which the change is not known
    unknown: Vec<String>,
    pub factorisations: usize,
}

/// The enriched space with regions of nodes that are wider by one layer of cells.
struct Wider {
    enriched: EnrichedScene,
    /// Names of the widened regions
    names: Vec<String>,
    /// Changes of all columns at the start of the run
    start: Vec<f64>,
}

impl ExtentSpace {
    /// The extent in a run of `scene`. Without an enriched space and the start in it, for example if the whole protocol is run, no change is known.
    pub fn new(known: Option<(&EnrichedScene, &Start)>, scene: &Scene) -> Self {
        let cut = CutRegions::new(scene);
        let (of_nodes, mut unknown) = cut.of_nodes_and_others(&scene.regions);
        let mut wider = None;
        if !of_nodes.is_empty() {
            let found = known.and_then(|(enriched, first)| {
                let wider = enriched.with_wider_regions(scene, &of_nodes)?;
                let start = wider.row_at(&wider.taken(enriched, &first.state), first.memory);
                Some(Wider { start: difference(&first.row, &start), enriched: wider, names: of_nodes.clone() })
            });
            match found {
                Some(found) => wider = Some(found),
                None => unknown.extend(of_nodes),
            }
        }
        Self { cut, wider, unknown, factorisations: 0 }
    }

    /// The changes of all columns at the start of the run and at a solution in this enriched space; zeros without a wider region. If the space with wider
    /// regions has no equilibrium, the change is not known.
    pub fn changes(&mut self, enriched: &EnrichedScene, solved: &Solved) -> Vec<[f64; 2]> {
        if let Some(wider) = self.wider.take() {
            let from = wider.enriched.taken(enriched, &solved.end);
            if let Some(columns) = wider.enriched.columns_from(&from, &solved.memory, &mut self.factorisations) {
                let end = difference(&solved.values, &columns);
                let both = wider.start.iter().zip(end).map(|(start, end)| [*start, end]).collect();
                self.wider = Some(wider);
                return both;
            }
            self.unknown.extend(wider.names);
        }
        vec![[0.0; 2]; solved.values.len()]
    }

    /// The regions on which a column depends and for which the change is not known.
    pub fn unknown(&self, column: &str) -> Vec<String> {
        let mut own = self.cut.of(column);
        own.retain(|name| self.unknown.contains(name));
        own
    }
}

/// Changes of columns.
fn difference(from: &[f64], to: &[f64]) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| b - a).collect()
}
