//! Rules of effects that act in addition to the elastic effect of a law: the same law in each cell, and one such effect only.

use crate::scene::builder::Builder;
use crate::scene::error::SceneError;

/// Refuses a cell of the region that is not elastic with this law.
pub fn check_elastic_with(builder: &Builder, place: &str, region: &str, law: &str) -> Result<Vec<u32>, SceneError> {
    let mut elastic = vec![false; builder.body.mesh.cell_count()];
    for other in builder.gathered.laws.iter().filter(|other| other.name == law) {
        builder.cells(place, &other.region)?.iter().for_each(|&c| elastic[c as usize] = true);
    }
    let cells = builder.cells(place, region)?.to_vec();
    match cells.iter().find(|c| !elastic[**c as usize]) {
        None => Ok(cells),
        Some(c) => {
            let fact = format!("cell {c} of region \"{region}\" has no elastic effect with the law \"{law}\"");
            let remedy = "give `law` and `region` of an [[effect]] of kind \"elastic\"";
            Err(builder.content(place, fact, remedy))
        }
    }
}
