//! Checks of the balls through which cables and forces act on a body.

use crate::math::units::Decimals;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;

/// Refuses a radius \[m\] that is not positive or larger than the body; `key`: how it is called in the file.
pub(super) fn check_radius(builder: &Builder, place: &str, key: &str, radius: f64) -> Result<(), SceneError> {
    let fact = format!("{key} is {} mm", radius * 1e3);
    if radius <= 0.0 {
        return Err(builder.content(place, fact, "give a positive length, at least the size of a cell"));
    }
    let diagonal = builder.body.mesh.diagonal();
    if radius > diagonal {
        let fact = format!("{fact}, and the body is {:.4} mm from corner to corner", Decimals(diagonal * 1e3));
        return Err(builder.content(place, fact, "it would be the mean of the whole body; check the unit"));
    }
    Ok(())
}

/// Notes a radius \[m\] below the size of the cells, and one above half of the middle extent of the body; `what`: `the guide radius`.
pub(super) fn note_radius(builder: &mut Builder, name: &str, what: &str, radius: f64) {
    let (radius, h) = (radius * 1e3, builder.body.mesh.h() * 1e3);
    let (low, high) = builder.body.mesh.bounding_box();
    let mut sizes: [f64; 3] = (1e3 * (high - low)).into();
    sizes.sort_by(f64::total_cmp);
    let half = 0.5 * sizes[1];
    if radius < h {
        builder.notes.push(format!("{name}: {what} {radius:.3} mm is below h = {h:.3} mm"));
    } else if radius > half {
        builder.notes.push(format!(
            "{name}: {what} {radius:.3} mm is above half of the width of the body, {half:.3} mm: it acts on whole sections, and less sharply than a place on the surface"
        ));
    }
}
