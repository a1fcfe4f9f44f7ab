//! Rule for effects of one kind that act on the same cells, where their values add up.

use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;

/// Refuses effect `number` if it acts on exactly the cells of an earlier effect of its kind, and adds a note if they share some of their cells. Only effects
/// with equal `which` are compared; it holds the other keys that must be equal for one effect to repeat another.
///
/// # Errors
///
/// Where an earlier effect acts on the same cells.
pub fn check_repeated(
    builder: &mut Builder,
    number: usize,
    kind: &'static str,
    which: String,
    region: &str,
) -> Result<(), SceneError> {
    let place = format!("effect {number} ({kind})");
    let cells = builder.cells(&place, region)?;
    let mut own = vec![false; builder.body.mesh.cell_count()];
    cells.iter().for_each(|&c| own[c as usize] = true);
    let mut notes = vec![];
    for (other, of_kind, of_which, their_region) in &builder.gathered.additive {
        if (*of_kind, of_which) != (kind, &which) {
            continue;
        }
        let theirs = builder.cells(&place, their_region)?;
        let shared = theirs.iter().filter(|&&c| own[c as usize]).count();
        if shared == cells.len() && shared == theirs.len() {
            let fact = format!("effect {other} is of the same kind on the same cells, and the two would add up");
            let remedy = "keep one of the two; if both are meant, with the sum of their values";
            return Err(builder.content(&place, fact, remedy));
        }
        if shared > 0 {
            notes.push(format!("{kind}: effects {other} and {number} add up in {shared} cells"));
        }
    }
    builder.notes.extend(notes);
    builder.gathered.additive.push((number, kind, which, region.into()));
    Ok(())
}
