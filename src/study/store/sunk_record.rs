//! Facets of a case that lie inside an obstacle between their contact points, as stored in its record and as described to the reader.

use crate::scene::SunkenFacet;
use crate::wording::few;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The remedy for facets in an obstacle.
const REMEDY: &str = "contact is felt at points of the mesh alone; refine the mesh there, or take tet10";

/// The deepest point of the facets of a contact inside its obstacle.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct SunkenRecord {
    /// Name of the contact
    pub contact: String,
    /// Time of the state: the last one, or that of the largest displacement \[s\]
    pub t_s: f64,
    /// Depth \[m\]
    pub depth_m: f64,
    /// Position in space \[m\]
    pub place_m: [f64; 3],
}

impl From<&SunkenFacet> for SunkenRecord {
    fn from(found: &SunkenFacet) -> Self {
        let SunkenFacet { contact, t, depth, at } = found;
        Self { contact: contact.clone(), t_s: *t, depth_m: *depth, place_m: *at }
    }
}

impl SunkenRecord {
    /// The warning for a single run.
    pub fn warning(&self) -> String {
        let Self { contact, t_s, depth_m, place_m: [x, y, z] } = self;
        format!(
            "facet in an obstacle: at t = {t_s:.6} s a facet of the contact {contact} lies {:.4} mm inside of the obstacle at ({:.4}, {:.4}, {:.4}) mm, between its \
             contact points, and is not pushed out: the force is too small; {REMEDY}",
            depth_m * 1e3,
            x * 1e3,
            y * 1e3,
            z * 1e3
        )
    }
}

/// A warning if facets lie in obstacles in some of the cases, which are given with their names.
pub fn warning<'a>(cases: impl Iterator<Item = (&'a str, &'a [SunkenRecord])>) -> Option<String> {
    let deepest = |all: &[SunkenRecord]| all.iter().map(|found| found.depth_m).reduce(f64::max);
    let (names, depths): (Vec<&str>, Vec<f64>) = cases.filter_map(|(name, all)| Some((name, deepest(all)?))).unzip();
    let deepest = depths.into_iter().reduce(f64::max)?;
    Some(format!(
        "Facets lie inside of an obstacle between their contact points, by up to {:.4} mm, in {}: {REMEDY}.",
        deepest * 1e3,
        few(&names)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_names_the_cases_and_the_greatest_depth() {
        let of = |depth_m| [SunkenRecord { contact: "ball".into(), t_s: 0.5, depth_m, place_m: [0.028, 0.001, 0.0] }];
        let (less, more) = (of(0.002), of(0.006));
        assert_eq!(warning([("sound", &[][..])].into_iter()), None);
        let told = warning([("fine", &less[..]), ("sound", &[]), ("coarse", &more)].into_iter()).expect("two cases");
        assert!(told.contains("by up to 6.0000 mm") && told.contains("fine and coarse"), "{told}");
        let one = more[0].warning();
        assert!(
            one.contains("contact ball lies 6.0000 mm inside of the obstacle at (28.0000, 1.0000, 0.0000) mm"),
            "{one}"
        );
    }
}
