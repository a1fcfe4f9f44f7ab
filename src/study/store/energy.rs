//! Energy from nothing in the dynamic stages of a case, for the record and for the reader.

use crate::scene::EnergyFromNothing;
use crate::wording::few;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The remedy for energy from nothing.
const REMEDY: &str = "shorten dt, or take \"bdf2\" or \"implicit_euler\"; where deformable bodies hit each other or an obstacle, \"implicit_euler\"";

/// Energy of a dynamic stage that nothing has put in
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct EnergyRecord {
    /// End of the last of three steps that have as much \[s\]
    pub t_s: f64,
    /// Elastic and kinetic energy beyond those of the start of the stage, the work, and what relaxing parts gave back \[J\]
    pub excess_j: f64,
    /// The same as a share of the largest energy of the stage
    pub share: f64,
}

impl EnergyRecord {
    /// The record of what a run has found.
    pub fn new(found: EnergyFromNothing) -> Self {
        Self { t_s: found.t, excess_j: found.excess, share: found.share() }
    }

    /// A warning for the reader of one run.
    pub fn warning(&self) -> String {
        let Self { t_s, excess_j, share } = self;
        format!(
            "energy from nothing: at t = {t_s:.6} s the body has {excess_j:.2e} J that nothing has put in, {:.0} % of the largest energy of \
             the stage; {REMEDY}",
            100.0 * share
        )
    }
}

/// A warning where cases have energy from nothing, each given by its name.
pub fn warning<'a>(cases: impl Iterator<Item = (&'a str, &'a EnergyRecord)>) -> Option<String> {
    let (names, shares): (Vec<&str>, Vec<f64>) = cases.map(|(name, found)| (name, found.share)).unzip();
    let largest = 100.0 * shares.into_iter().reduce(f64::max)?;
    let names = few(&names);
    Some(format!("Energy from nothing, up to {largest:.0} % of the largest energy of a stage, in {names}: {REMEDY}."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_names_the_cases_and_the_worst_share() {
        let of = |share: f64| EnergyRecord { t_s: 1.5, excess_j: 2e-3, share };
        assert_eq!(warning(std::iter::empty()), None);
        let (a, b) = (of(0.34), of(0.998));
        let told = warning([("fine", &a), ("coarse", &b)].into_iter()).expect("two cases");
        assert!(told.contains("up to 100 %") && told.contains("fine and coarse"), "{told}");
        assert!(a.warning().contains("at t = 1.500000 s the body has 2.00e-3 J") && a.warning().contains("34 %"));
    }
}
