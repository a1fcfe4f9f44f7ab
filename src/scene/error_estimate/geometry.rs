//! Geometry error: the change of the recorded quantities when the new boundary nodes of the enriched mesh lie on a smooth surface.

use super::enrichment::{EnrichedScene, SmoothSurface};
use super::kept_state::{Solved, Start};
use crate::scene::Scene;
use crate::scene::body::source_volume::SourceVolume;

/// Change of a quantity when the boundary nodes of the enriched space lie on a smooth surface \[unit of J\].
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct GeometryError {
    pub change: f64,
    /// Change of the value at the start of the run, such as the volume of a cavity at rest
    pub start: f64,
}

/// Bounds of the geometry error relative to the change by the smooth surface: smallest, likely, largest. On spheres, cylinders and fillets the surface is
/// within a tenth of the true one, on a torus within a third (`mesh::smooth_surface`).
pub(super) const GEOMETRY: [f64; 3] = [0.5, 1.0, 1.5];

/// The enriched space on the smooth surface.
pub(super) struct Geometry {
    is_flat: bool,
    missed: Vec<SourceVolume>,
    curved: Option<Curved>,
    pub factorisations: usize,
}

/// The enriched space on a curved smooth surface, for which a change is known.
struct Curved {
    moved: EnrichedScene,
    /// Share of the distance to the surface by which its nodes were moved
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

    /// The geometry for a protocol that is run whole: the change is known only for a flat boundary, where it is zero.
    pub fn of_whole_run(enriched: &EnrichedScene, scene: &Scene) -> Self {
        Self::of(&enriched.smooth_surface(scene))
    }

    fn of(surface: &SmoothSurface) -> Self {
        let missed = if let SmoothSurface::Missed(volumes) = surface { volumes.clone() } else { vec![] };
        Self { is_flat: matches!(surface, SmoothSurface::Flat), missed, curved: None, factorisations: 0 }
    }

    /// The error of every column on a flat boundary, which is zero; `None` on a curved one.
    pub fn of_flat(&self) -> Option<GeometryError> {
        self.is_flat.then(GeometryError::default)
    }

    /// Volumes of the CAD that the mesh misses on the smooth surface as well, which is then not a valid measure.
    pub fn missed_volumes(&self) -> Vec<SourceVolume> {
        self.missed.clone()
    }

    /// The errors of all columns at a solution in the enriched space; `None` if the smooth surface is not a valid measure, folds cells or has no equilibrium.
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

/// Changes of columns extrapolated to the whole distance to the smooth surface, of which the nodes were moved by the share `part`.
fn difference(from: &[f64], to: &[f64], part: f64) -> Vec<f64> {
    from.iter().zip(to).map(|(a, b)| (b - a) / part).collect()
}
