//! Discrepancy between the volumes given by the displacements and by the pressures: a sign that a formulation with pressures no longer controls the
//! volume.
//!
//! In these formulations G(J) = p/κ holds only in the mean over the pressure functions. Under large compression, points of a cell may collapse while
//! others expand, without a pressure that resists (Auricchio, Beirão da Veiga, Lovadina & Reali, *Comput. Methods Appl. Mech. Eng.* 194, 2005). Where
//! the mesh resolves the state, G − p/κ is a discretisation error.

use super::stress::Stressed;

/// Gap below which the pressures no longer control the volume of a point \[–\]; measured in `docs/explanation/elements.md`.
const LOST: f64 = -0.5;

/// A point of a cell that the displacements compress far more than its pressure implies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeGap {
    /// Cell of the mesh
    pub cell: u32,
    /// Volume ratio J given by the displacements \[–\]
    pub j: f64,
    /// G(J) − p/κ \[–\]
    pub gap: f64,
}

/// Returns the most compressed point of an elastic effect at displacements and pressures `x` \[unknowns\]; `None` if the effect has no pressures, or
/// if they control the volume everywhere.
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
