//! The law of points next to a pressure field.

use crate::material::{Law, Volumetric};

/// The law that acts at the points, and its volumetric part where a pressure field takes that over.
pub(in crate::reduction) fn parted(whole: Box<dyn Law>, has_pressure: bool) -> (Box<dyn Law>, Option<Volumetric>) {
    let split = has_pressure.then(|| whole.split()).flatten();
    split.map_or((whole, None), |(rest, volumetric)| (rest, Some(volumetric)))
}
