//! The law at points with a pressure field.

use crate::material::{Law, Volumetric};

/// Splits a law into the law that acts at the points and the volumetric part, if a pressure field replaces the latter.
pub(in crate::reduction) fn parted(whole: Box<dyn Law>, has_pressure: bool) -> (Box<dyn Law>, Option<Volumetric>) {
    let split = has_pressure.then(|| whole.split()).flatten();
    split.map_or((whole, None), |(rest, volumetric)| (rest, Some(volumetric)))
}
