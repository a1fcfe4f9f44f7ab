//! Error of geometry: the change of the recorded quantities where the new boundary nodes of the enriched mesh lie on a smooth surface.

use super::enrichment::{EnrichedScene, SmoothSurface};
use super::kept_state::{Solved, Start};
use crate::scene::Scene;
use crate::scene::body::source_volume::SourceVolume;

/// Change of a quantity where the boundary nodes of the enriched space lie on a smooth surface \[unit of J\].
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct GeometryError {
    pub change: f64,
    /// The same of the value at the start of the run: of the volume of a cavity at rest
    pub start: f64,
}

/// Bounds of the error of geometry over the change by the smooth surface: least, likely, most. On spheres, cylinders and fillets that surface is
/// within a tenth of the true one, on a torus within a third (`mesh::smooth_surface`).
pub(super) const GEOMETRY: [f64; 3] = [0.5, 1.0, 1.5];

/// The enriched space on the smooth surface.
pub(super) struct Geometry {
    is_flat: bool,
    missed: Vec<SourceVolume>,
    curved: Option<Curved>,
    pub factorisations: usize,
}

/// The same on a curved surface, where a change is known.
struct Curved {
    moved: EnrichedScene,
    /// Part of the way to the surface that its nodes have gone
    part: f64,
    /// Changes of all columns at the start of the run
    start: Vec<f64>,
}

impl Geometry {
    /// The enriched space on the smooth surface, for a run of `scene` from this start.
    pub fn new(enriched: &EnrichedScene, scene: &Scene, first: &Start) -> Self {
        let surface = enriched.smooth_surface(scene);
        let mut geometry = Self::of(&surface);
        if let SmoothSurface::Curved(map, part) = surface {
            geometry.curved = enriched.with_map(scene, *map).map(|moved| {
                let start = difference(&first.row, &moved.row_at(&first.state, first.memory), part);
                Curved { moved, part, start }
            });
        }
        geometry
    }

    /// The same of a protocol that is run whole: no change is known but that of a flat boundary, which is none.
    pub fn of_whole_run(enriched: &EnrichedScene, scene: &Scene) -> Self {
        Self::of(&enriched.smooth_surface(scene))
    }

    fn of(surface: &SmoothSurface) -> Self {
        let missed = if let SmoothSurface::Missed(volumes) = surface { volumes.clone() } else { vec![] };
        Self { is_flat: matches!(surface, SmoothSurface::Flat), missed, curved: None, factorisations: 0 }
    }

    /// The error of every column on a flat boundary.
    pub fn of_flat(&self) -> Option<GeometryError> {
        self.is_flat.then(GeometryError::default)
    }

    /// Volumes of the CAD that the mesh misses, also on the smooth surface, which is no measure then.
    pub fn missed_volumes(&self) -> Vec<SourceVolume> {
        self.missed.clone()
    }

    /// The errors of all columns at a solution in the enriched space; none where the smooth surface is no measure, folds cells or has no equilibrium.
    pub fn errors(&mut self, solved: &Solved) -> Option<Vec<GeometryError>> {
        if let Some(flat) = self.of_flat() {
            return Some(vec![flat; solved.values.len()]);
        }
        let Curved { moved, part, start } = self.curved.as_ref()?;
        let end = moved.columns_from(&solved.end, &solved.memory, &mut self.factorisations)?;
        let both = difference(&solved.values, &end, *part).into_iter().zip(start);
        Some(both.map(|(change, start)| GeometryError { change, start: *start }).collect())
    }
}

/// Changes of columns over the whole way to the smooth surface, of which this part was gone.
fn difference(from: &[f64], to: &[f64], part: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| (b - a) / part).collect()
}
