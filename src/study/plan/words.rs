//! A plan in words.

use crate::report::numbers::{capital, percent, seconds};
use crate::study::plan::limit::Limit;
use crate::study::plan::mesh_limits::Contradiction;
use crate::study::plan::pilots::Pilots;
use crate::study::plan::settings::{Outcome, Plan, Setting};
use crate::study::plan::sizes::Meshes;
use crate::study::plan::weigh::FEW;

/// The limitations of a plan: what it cannot promise.
pub(super) fn promises(plan: &Plan, pilots: &Pilots) -> Vec<String> {
    let mut out = vec![];
    for q in &plan.quantities {
        match plan.references.get(q) {
            None if plan.meshes == Meshes::Given => {
                let why = pilots.of.iter().flatten().find_map(|c| c.record.one_run.as_ref()?.unusable());
                let why = why
                    .unwrap_or("an estimate from the run alone does not fit into the budget, or has no value".into());
                out.push(format!("{q} is not judged: {why}."));
            }
            None => out.push(format!(
                "{q} is not judged: its pilots have no limit other than zero, or none on any mesh (a largest value within the body, a force at a point, a \
                 region whose border runs through cells), or no element has three of them."
            )),
            Some(limit) => out.push(knowledge(q, limit, plan.tolerance)),
        }
    }
    out.push("Errors are those of peaks, not of whole curves, of fields or of contact.".into());
    out.push("Times are those of this machine, as busy as it was during the pilots; iterations a step are taken from the largest pilot, and harder steps on a finer mesh are not foreseen.".into());
    if plan.meshes == Meshes::Given {
        out.push(
            "The mesh is given: its size is no choice, and errors are those estimated from each run alone, without that of the geometry. For other \
             sizes give a `body`, CAD or a surface file with `cells`, or a grid whose divisions have a common factor, by which it can be coarser."
                .into(),
        );
    }
    if plan.meshes == Meshes::Scaled {
        out.push("Grids with the proportions of that of the scene were weighed: a curved surface is the closer to its shape the finer they are.".into());
    }
    if plan.meshes == Meshes::Stored {
        out.push(
            "Only the stored sizes of this body were weighed; with the mesher (durometer doctor --setup) others are."
                .into(),
        );
    }
    if let Some(s) = plan.chosen.as_ref().filter(|_| !plan.meets) {
        let why = match plan.weighed.iter().find(|w| w.error <= plan.tolerance) {
            Some(w) => {
                format!("the cheapest that would is {}, {} cells, for {}", w.formulation, w.cells, seconds(w.cpu_s))
            }
            None => "no mesh that was weighed would".into(),
        };
        let tolerance = percent(plan.tolerance);
        let best = format!("the best that fits is expected to be {} off; {why}.", percent(s.error));
        out.push(match &plan.without_pilots()[..] {
            [] => format!("{tolerance} is not met within the budget: {best}"),
            left => format!(
                "No element that could be judged meets {tolerance} within the budget: {best} Left out for lack of pilots, which a larger --budget may \
                 allow: {}.",
                left.join(", ")
            ),
        });
    }
    out
}

/// How well the limit of a quantity is known, with respect to the mesh and to the step.
fn knowledge(quantity: &str, limit: &Limit, tolerance: f64) -> String {
    let known = percent(limit.uncertainty);
    let parts = match limit.of_steps {
        Some(steps) if steps > 0.0 => {
            format!(" ({} by the mesh, {} by the time step)", percent(limit.of_mesh), percent(steps))
        }
        Some(_) => String::new(),
        None => " for the steps of the scene".into(),
    };
    let mut out = if limit.uncertainty > tolerance {
        format!(
            "The pilots know the limit of {quantity} to {known} only{parts}, which is more than the tolerance: the expected error is an estimate, not \
             a bound."
        )
    } else {
        format!("The pilots know the limit of {quantity} to {known}{parts}; an error bar adds that.")
    };
    if limit.of_steps.is_none() {
        out += " The error of these steps is not known.";
    }
    out
}

impl Setting {
    /// The setting in words: `tet10_up with 4500 cells`.
    pub fn words(&self) -> String {
        format!("{} with {} cells", self.formulation, self.cells)
    }
}

impl Contradiction {
    fn words(&self) -> String {
        format!(
            "No setting is advised: two pilots of {} agree to {} in {}, and the limit that other elements give lies {} from them. Raise --budget, so that \
             it has a third one.",
            self.formulation,
            percent(self.change),
            self.quantity,
            percent(self.distance)
        )
    }
}

impl Plan {
    /// The elements that more pilots would make usable.
    fn without_pilots(&self) -> Vec<&str> {
        self.lost.iter().filter(|(_, why)| why.ends_with(FEW)).map(|(what, _)| what.as_str()).collect()
    }

    /// The answer and its limitations, line by line.
    pub fn lines(&self) -> Vec<String> {
        let mut out = vec![];
        match &self.chosen {
            None if self.weighed.is_empty() => out.push("The error of no setting is known.".into()),
            None => out.push(self.contradicted.as_ref().map_or_else(
                || format!("No setting fits into {}.", seconds((self.budget_s - self.planning_s).max(0.0))),
                Contradiction::words,
            )),
            Some(s) => {
                let verdict = match self.meets {
                    true => "is the cheapest setting expected within",
                    false if self.without_pilots().is_empty() => "comes closest to",
                    false => "comes closest, of the elements that could be judged, to",
                };
                out.push(format!(
                    "{} {verdict} {}: expected error {} (peak of {}), {} CPU time ({} by the clock), {} unknowns, {} steps. Planning took {} by the clock.",
                    capital(&s.words()),
                    percent(self.tolerance),
                    percent(s.error),
                    s.limited_by,
                    seconds(s.cpu_s),
                    seconds(s.wall_s),
                    s.counted.dofs,
                    s.counted.steps,
                    seconds(self.planning_s)
                ));
                if self
                    .pilots
                    .iter()
                    .any(|p| p.cells == s.counted.cells && p.name.starts_with(&format!("{}, ", s.formulation)))
                    && self.steps.factor == 1.0
                {
                    out.push("It was one of the pilots: a run would tell nothing new.".into());
                }
                let set: Vec<String> = s.set.iter().map(|c| format!("--set '{c}'")).collect();
                out.push(format!("Changes: {}", set.join(" ")));
            }
        }
        out.push(format!("Time step: {}.", self.steps.words));
        out.extend(self.promises.iter().cloned());
        out.extend(self.lost.iter().map(|(what, why)| format!("Left out: {what}: {why}.")));
        out.extend(self.outcome.iter().map(Outcome::words));
        if self.stopped {
            out.push("Stopped: this is what was known by then.".into());
        }
        out
    }
}

impl Outcome {
    fn words(&self) -> String {
        if !self.error.is_finite() {
            return format!(
                "The run ended with {} after {}; its error cannot be told.",
                self.status,
                seconds(self.cpu_s)
            );
        }
        format!(
            "The run took {} CPU time ({} by the clock): expected was {:.2} times that. {} its error is {} (the limit being known to {}): \
             expected was {:.2} times that.{}",
            seconds(self.cpu_s),
            seconds(self.wall_s),
            self.time_ratio,
            if self.further_mesh { "With it as a further mesh" } else { "Against the limit from the pilots" },
            percent(self.error),
            percent(self.uncertainty),
            self.error_ratio,
            if self.with_steps { "" } else { " The error of its steps is in neither." }
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::plan::limit::References;
    use crate::study::plan::model::Counted;
    use crate::study::plan::steps::Steps;

    /// Returns a plan whose only setting is 13 % off, with these elements left out.
    fn plan(lost: &[(&str, &str)], contradicted: Option<Contradiction>) -> Plan {
        let counted = Counted { cells: 54_432, dofs: 3, h_m: 1e-3, steps: 1, factor_nnz: 1, factor_flops: 1.0 };
        let setting = Setting {
            formulation: "tet4_up".into(),
            choice: 0,
            cells: 54_432,
            set: vec![],
            counted,
            on_its_mesh: true,
            error: 0.13,
            limited_by: "angle".into(),
            uncertainty: 0.22,
            cpu_s: 1.8,
            wall_s: 8.7,
        };
        Plan {
            tolerance: 0.01,
            budget_s: 30.0,
            meshes: Meshes::Scaled,
            quantities: vec![],
            references: References::new(),
            pilots: vec![],
            pilots_cpu_s: 1.0,
            planning_s: 6.6,
            steps: Steps::of_scene(false, ""),
            weighed: vec![setting.clone()],
            chosen: Some(setting).filter(|_| contradicted.is_none()),
            meets: false,
            contradicted,
            lost: lost.iter().map(|(what, why)| ((*what).into(), (*why).into())).collect(),
            promises: vec![],
            stopped: false,
            outcome: None,
        }
    }

    fn said(plan: &Plan) -> String {
        [promises(plan, &Pilots::default()), plan.lines()].concat().join("\n")
    }

    #[test]
    fn nothing_is_said_of_elements_that_were_not_judged() {
        let judged = said(&plan(&[("tet4", "the errors of its pilots in angle do not fall")], None));
        assert!(
            judged.contains("1 % is not met within the budget") && judged.contains("comes closest to 1 %"),
            "{judged}"
        );
        let why = format!("it has 2 of the 3 {FEW}");
        let few = said(&plan(&[("tet10_up", &why), ("tet10", &why)], None));
        assert!(!few.contains("is not met"), "{few}");
        assert!(few.contains("No element that could be judged meets 1 % within the budget"), "{few}");
        assert!(few.contains("which a larger --budget may allow: tet10_up, tet10."), "{few}");
        assert!(few.contains("comes closest, of the elements that could be judged, to 1 %"), "{few}");
        let (formulation, quantity) = ("tet10_up".into(), "angle".into());
        let against = Contradiction { formulation, quantity, change: 0.017, distance: 0.096 };
        let none = said(&plan(&[("tet10_up", &why)], Some(against)));
        assert!(none.contains("No setting is advised: two pilots of tet10_up agree to 1.70 % in angle"), "{none}");
        assert!(!none.contains("comes closest") && !none.contains("is not met"), "{none}");
    }
}
