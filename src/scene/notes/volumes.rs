//! Elastic effects whose pressures no longer control the volume at a state.

use crate::effect::Stressed;
use crate::effect::volume_gap::{VolumeGap, lost_volume};
use crate::scene::build::Scene;
use std::fmt::{self, Display, Formatter};

/// An elastic effect with points that are compressed without a resisting pressure.
pub struct LostVolume {
    effect: String,
    worst: VolumeGap,
}

impl LostVolume {
    /// The fact, its consequence and the remedies, as a note.
    pub fn note(&self) -> String {
        format!(
            "{self}; the state may be one that no finer mesh has, and the bending at such places is too soft: run it with formulation = \"displacement\", which \
             resists in every point, on a mesh that is finer there"
        )
    }
}

impl Display for LostVolume {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let VolumeGap { cell, j, gap } = self.worst;
        let (effect, gap) = (&self.effect, -gap);
        write!(
            f,
            "{effect}: the pressures have lost their hold on the volume: a point of cell {cell} is squeezed to {j:.2} of its volume, {gap:.2} below the volume of \
             its pressure"
        )
    }
}

/// Each elastic effect of a scene whose pressures no longer control the volume at displacements and pressures `x` \[unknowns\].
pub fn lost_volumes<'a>(scene: &'a Scene, x: &'a [f64]) -> impl Iterator<Item = LostVolume> + 'a {
    let lost =
        |effect: &dyn Stressed| Some(LostVolume { effect: effect.name().into(), worst: lost_volume(effect, x)? });
    scene.stressed.iter().filter_map(move |effect| lost(&**effect))
}
