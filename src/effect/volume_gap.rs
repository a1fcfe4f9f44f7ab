//! Volumes by the displacements that differ from those by the pressures: a sign that a formulation with pressures has lost its hold on the volume.
//!
//! In these formulations G(J) = p/κ holds in the mean over the functions of the pressures only. Under large compression points of a cell may collapse
//! while others expand, with no pressure that resists (Auricchio, Beirão da Veiga, Lovadina & Reali, *Comput. Methods Appl. Mech. Eng.* 194,
//! 2005). Where the mesh resolves the state, G − p/κ is an error of discretisation.

use super::stress::Stressed;

/// Gap below which the pressures have lost their hold on the volume of a point \[–\]; measured in `docs/explanation/elements.md`.
const LOST: f64 = -0.5;

/// A point of a cell whose volume the displacements squeeze far below that of its pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeGap {
    /// Cell of the mesh
    pub cell: u32,
    /// Ratio of the volumes by the displacements \[–\]
    pub j: f64,
    /// G(J) − p/κ \[–\]
    pub gap: f64,
}

/// The most squeezed point of an elastic effect at displacements and pressures `x` \[unknowns\]; none without pressures of its own, or where they hold the
/// volume.
pub fn lost_volume(effect: &dyn Stressed, x: &[f64]) -> Option<VolumeGap> {
    if effect.displacement_only() {
        return None;
    }
    let cells = &effect.points().cells;
    let gaps = |(b, &cell): (usize, &u32)| {
        let of_block = effect.volume_gaps(x, b).unwrap_or_default();
        of_block.into_iter().map(move |(j, gap)| VolumeGap { cell, j, gap })
    };
    let least = cells.iter().enumerate().flat_map(gaps).min_by(|a, b| a.gap.total_cmp(&b.gap));
    least.filter(|found| found.gap < LOST)
}
