//! Spurious energy in the dynamic stages of a case ("energy from nothing"), as stored in its record and as described to the reader.

use crate::scene::EnergyFromNothing;
use crate::solve::{Integrator, TimeSpan};
use crate::wording::few;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Energy of a dynamic stage that no work explains.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct EnergyRecord {
    /// End of the last of three steps with at least this energy \[s\]
    pub t_s: f64,
    /// Elastic and kinetic energy in excess of that at the start of the stage, the work, and the energy returned by relaxing parts \[J\]
    pub excess_j: f64,
    /// The excess relative to the largest energy of the stage
    pub share: f64,
    /// Integration rule of the stage; `None` in records of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub integrator: Option<String>,
}

impl EnergyRecord {
    /// Builds the record from the finding in a run of these stages.
    pub fn new(found: EnergyFromNothing, spans: &[TimeSpan]) -> Self {
        let stage = spans.iter().find(|span| found.t <= span.end);
        let integrator = stage.map(|span| span.integrator.name().into());
        Self { t_s: found.t, excess_j: found.excess, share: found.share(), integrator }
    }

    /// The warning for a single run.
    pub fn warning(&self) -> String {
        let Self { t_s, excess_j, share, .. } = self;
        format!(
            "energy from nothing: at t = {t_s:.6} s the body has {excess_j:.2e} J that nothing has put in, {:.0} % of the largest energy of \
             the stage; {}",
            100.0 * share,
            remedy(&[self])
        )
    }
}

/// The remedy, which names rules that damp more than those of all these stages.
fn remedy(found: &[&EnergyRecord]) -> &'static str {
    let has = |rule: Integrator| found.iter().any(|record| record.integrator.as_deref() == Some(rule.name()));
    if has(Integrator::ImplicitEuler { linearised: false }) {
        "shorten dt"
    } else if has(Integrator::Bdf2) {
        "shorten dt, or take \"implicit_euler\""
    } else {
        "shorten dt, or take \"bdf2\" or \"implicit_euler\"; where deformable bodies hit each other or an obstacle, \"implicit_euler\""
    }
}

/// A warning if some of the cases, which are given with their names, have energy from nothing.
pub fn warning<'a>(cases: impl Iterator<Item = (&'a str, &'a EnergyRecord)>) -> Option<String> {
    let (names, found): (Vec<&str>, Vec<&EnergyRecord>) = cases.unzip();
    let largest = 100.0 * found.iter().map(|record| record.share).reduce(f64::max)?;
    let (names, remedy) = (few(&names), remedy(&found));
    Some(format!("Energy from nothing, up to {largest:.0} % of the largest energy of a stage, in {names}: {remedy}."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_names_the_cases_and_the_worst_share() {
        let of = |share: f64| EnergyRecord { t_s: 1.5, excess_j: 2e-3, share, integrator: None };
        assert_eq!(warning(std::iter::empty()), None);
        let (a, b) = (of(0.34), of(0.998));
        let told = warning([("fine", &a), ("coarse", &b)].into_iter()).expect("two cases");
        assert!(told.contains("up to 100 %") && told.contains("fine and coarse"), "{told}");
        assert!(a.warning().contains("at t = 1.500000 s the body has 2.00e-3 J") && a.warning().contains("34 %"));
    }
    /// The remedy is not the rule that produced the energy, nor one that damps less.
    #[test]
    fn the_remedy_names_rules_that_are_not_those_of_the_stages() {
        let ends = [(Integrator::GeneralisedAlpha { rho: 0.9 }, 1.0), (Integrator::Bdf2, 2.0)];
        let euler = (Integrator::ImplicitEuler { linearised: false }, 3.0);
        let spans = ends.into_iter().chain([euler]).map(|(integrator, end)| {
            let start = end - 1.0;
            TimeSpan { integrator, start, end, dt: 0.1 }
        });
        let spans: Vec<TimeSpan> = spans.collect();
        let at = |t: f64| EnergyRecord::new(EnergyFromNothing { t, excess: 2.0, largest: 4.0 }, &spans);
        let [alpha, bdf2, euler] = [1.0, 1.1, 3.0].map(at);
        assert!(alpha.warning().contains("or take \"bdf2\" or \"implicit_euler\""), "{}", alpha.warning());
        assert!(bdf2.warning().ends_with("the stage; shorten dt, or take \"implicit_euler\""), "{}", bdf2.warning());
        assert!(euler.warning().ends_with("the stage; shorten dt"), "{}", euler.warning());
        let told = warning([("a", &alpha), ("b", &bdf2)].into_iter()).expect("two cases");
        assert!(told.ends_with("in a and b: shorten dt, or take \"implicit_euler\"."), "{told}");
    }
}
