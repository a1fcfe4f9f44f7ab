//! Cavities whose walls have passed through each other in a case, as stored in its record and as described to the reader.

use crate::scene::CollapsedCavity;
use crate::wording::few;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The remedy for walls that pass through each other.
const REMEDY: &str = "keep the walls apart by a [[contact]] between deformable surfaces, or take out less";

/// A cavity whose volume is no longer positive.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct CollapseRecord {
    /// Name of the cavity
    pub cavity: String,
    /// First recorded time with such a volume \[s\]
    pub t_s: f64,
    /// Its volume at that time \[m³\]
    pub volume_m3: f64,
}

impl From<&CollapsedCavity> for CollapseRecord {
    fn from(found: &CollapsedCavity) -> Self {
        Self { cavity: found.name.clone(), t_s: found.t, volume_m3: found.volume }
    }
}

impl CollapseRecord {
    /// The warning for a single run.
    pub fn warning(&self) -> String {
        let Self { cavity, t_s, volume_m3 } = self;
        format!(
            "collapsed cavity: from t = {t_s:.6} s on the volume of {cavity} is not positive ({:.4} ml): its walls have passed through each other, and what follows is no \
             result; {REMEDY}",
            volume_m3 * 1e6
        )
    }
}

/// A warning if cavities collapse in some of the cases, which are given with their names.
pub fn warning<'a>(cases: impl Iterator<Item = (&'a str, &'a [CollapseRecord])>) -> Option<String> {
    let found: Vec<(&str, &CollapseRecord)> = cases.filter_map(|(name, all)| Some((name, all.first()?))).collect();
    let earliest = found.iter().map(|(_, first)| first.t_s).reduce(f64::min)?;
    let names: Vec<&str> = found.iter().map(|(name, _)| *name).collect();
    Some(format!(
        "Walls of a cavity pass through each other, from t = {earliest:.6} s on at the earliest, in {}: {REMEDY}.",
        few(&names)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_names_the_cases_and_the_first_time() {
        let of = |t_s: f64| [CollapseRecord { cavity: "air".into(), t_s, volume_m3: -2e-7 }];
        let (late, early) = (of(1.5), of(0.25));
        assert_eq!(warning([("sound", &[][..])].into_iter()), None);
        let told = warning([("fine", &late[..]), ("sound", &[]), ("coarse", &early)].into_iter()).expect("two cases");
        assert!(told.contains("from t = 0.250000 s") && told.contains("fine and coarse"), "{told}");
        assert!(late[0].warning().contains("from t = 1.500000 s on the volume of air is not positive (-0.2000 ml)"));
    }
}
