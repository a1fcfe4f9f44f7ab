//! Which cells of the body resist a deformation.

use super::builder::Builder;
use super::error::SceneError;
use crate::mesh::error::point;

/// Every cell belongs to an effect that stores energy; two at the same place add up, which is said.
pub(super) fn check_cover(builder: &mut Builder) -> Result<(), SceneError> {
    let body = builder.body.clone();
    let mut count = vec![0u32; body.mesh.cell_count()];
    builder.gathered.points.iter().flat_map(|points| &points.cells).for_each(|&c| count[c as usize] += 1);
    builder.rigid_cells.iter().for_each(|&c| count[c as usize] = count[c as usize].max(1));
    let (bare, twice) = (count.iter().filter(|n| **n == 0).count(), count.iter().filter(|n| **n > 1).count());
    if let Some(c) = count.iter().position(|n| *n == 0) {
        let at = point(&body.mesh.position(c, [0.25; 3]));
        let fact = format!("{bare} of {} cells have no elastic effect, one of them at {at}", count.len());
        let remedy = "give every cell a law: regions cover the body together (a cell that a box cuts belongs to none)";
        return Err(builder.content("effect", fact, remedy));
    }
    if twice > 0 {
        builder.notes.push(format!("{twice} cells have more than one elastic effect: their stiffnesses add up"));
    }
    Ok(())
}
