//! Rules for effects that act in addition to the elastic effect of a law: the same law in each cell, and only one such effect.

use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;

/// The cells of the region. Refuses a cell in which not exactly one elastic effect has this law: the history of an effect belongs to one solid.
///
/// # Errors
///
/// Where no elastic effect, or more than one, has this law in a cell of the region.
pub fn check_elastic_with(builder: &Builder, place: &str, region: &str, law: &str) -> Result<Vec<u32>, SceneError> {
    let mut elastic = vec![0; builder.body.mesh.cell_count()];
    for other in builder.gathered.laws.iter().filter(|other| other.name == law) {
        builder.cells(place, &other.region)?.iter().for_each(|&c| elastic[c as usize] += 1);
    }
    let cells = builder.cells(place, region)?.to_vec();
    let Some(&c) = cells.iter().find(|c| elastic[**c as usize] != 1) else { return Ok(cells) };
    let (fact, remedy) = if elastic[c as usize] == 0 {
        ("no elastic effect", "give `law` and `region` of an [[effect]] of kind \"elastic\"")
    } else {
        ("several elastic effects", "give the one that is added a law of another name with the same constants")
    };
    let fact = format!("cell {c} of region \"{region}\" has {fact} with the law \"{law}\"");
    Err(builder.content(place, fact, remedy))
}
