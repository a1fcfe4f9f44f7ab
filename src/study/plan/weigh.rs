//! Settings with their expected errors and times, from the pilots alone: no mesh is made for a setting that a cheaper one surpasses.
//!
//! The counts of a mesh that has not been made are power laws of the number of cells through the pilots of its element: unknowns and h scale from the
//! largest pilot, entries and operations of the factor follow a fit.

use crate::report::numbers::percent;
use crate::study::curve::peak;
use crate::study::estimate::family::formal_order;
use crate::study::estimate::power_law::{PowerLaw, power_law};
use crate::study::plan::limit::{Limit, References};
use crate::study::plan::model::{Clock, Counted, LEAST_PILOTS, error_law};
use crate::study::plan::pilots::Pilots;
use crate::study::plan::settings::Setting;
use crate::study::plan::sizes::ElementMeshes;
use crate::study::plan::steps::Steps;
use crate::study::run::one_run::OneRunRecord;
use crate::study::store::record::{CaseRecord, StoredCase};
use crate::wording::joined;

/// End of the reason why an element is left out that more pilots would make usable.
pub const FEW: &str = "pilots that a law of its error takes";

/// Fits for one element that predict errors and times of its sizes.
pub struct Expectation {
    clock: Clock,
    laws: Vec<(String, PowerLaw)>,
    nnz: PowerLaw,
    flops: PowerLaw,
    largest: CaseRecord,
}

impl Expectation {
    /// Fits the pilots of one element. Returns the reason if they give no law of the time, or of the error of a quantity.
    pub fn new(own: &[StoredCase], references: &References) -> Result<Self, String> {
        let records: Vec<&CaseRecord> = own.iter().map(|c| &c.record).collect();
        if records.len() < LEAST_PILOTS {
            return Err(format!("it has {} of the {LEAST_PILOTS} {FEW}", records.len()));
        }
        let formal = formal_order(&own[0].record.formulation);
        let law = |(q, limit): (&String, &Limit)| {
            // The pilots have the steps of the scene, and so does the limit with which they are compared
            let error = |c: &StoredCase| Some((c.record.mesh.h_m, (peak(c, q)? / limit.at_steps - 1.0).abs()));
            let errors: Vec<(f64, f64)> = own.iter().filter_map(error).collect();
            let law = error_law(&errors, formal, limit.of_mesh);
            let from_to = || joined(&errors.iter().map(|e| percent(e.1)).collect::<Vec<_>>());
            let why = || format!("the errors of its pilots in {q} do not fall with the size of cells: {}", from_to());
            Ok((q.clone(), law.ok_or_else(why)?))
        };
        let laws = references.iter().map(law).collect::<Result<Vec<_>, String>>()?;
        let over_cells = |of: fn(&CaseRecord) -> f64| {
            power_law(&records.iter().map(|r| (r.mesh.cells as f64, of(r))).collect::<Vec<_>>())
        };
        let timed = || {
            let largest = (*records.iter().max_by_key(|r| r.mesh.cells)?).clone();
            let (nnz, flops) = (over_cells(|r| r.factor_nnz as f64)?, over_cells(|r| r.work.factor_flops)?);
            Some(Self { clock: Clock::new(&records)?, laws, nnz, flops, largest })
        };
        timed().ok_or_else(|| "its pilots give no law of its time".into())
    }

    /// Counts of a mesh with `cells` cells, for steps `factor` times those of the pilots.
    fn counted(&self, cells: u64, factor: f64) -> Counted {
        let (n, last) = (cells as f64, &self.largest);
        let ratio = n / last.mesh.cells as f64;
        Counted {
            cells: cells as usize,
            dofs: (last.dofs as f64 * ratio).round() as usize,
            h_m: last.mesh.h_m / ratio.cbrt(),
            steps: (last.steps as f64 / factor).ceil() as usize,
            factor_nnz: self.nnz.at(n) as usize,
            factor_flops: self.flops.at(n),
        }
    }

    /// Error, limiting column, and CPU time \[s\] of a run of this size.
    pub fn of(&self, counted: &Counted, steps: &Steps) -> (f64, String, f64) {
        let errors = self.laws.iter().map(|(q, law)| (q, law.at(counted.h_m) + steps.error(q)));
        let (limited_by, error) = errors.max_by(|a, b| a.1.total_cmp(&b.1)).expect("there is a law");
        (error, limited_by.clone(), steps.per_step * self.clock.predict(counted))
    }
}

/// Settings, cheapest first, and the elements without any setting: (name, reason).
pub type Weighed = (Vec<Setting>, Vec<(String, String)>);

/// Weighs error and time of every element and size that fits into `budget_s` of wall time.
pub fn settings(
    choices: &[ElementMeshes],
    pilots: &Pilots,
    references: &References,
    steps: &Steps,
    budget_s: f64,
) -> Weighed {
    let (mut out, mut lost) = (vec![], vec![]);
    for (k, (choice, own)) in choices.iter().zip(&pilots.of).enumerate() {
        let has_no_scene = own.is_empty() && pilots.refused.get(k).is_some_and(|reasons| !reasons.is_empty());
        let expectation = match Expectation::new(own, references) {
            Ok(expectation) => expectation,
            // The reason is reported with its pilots, and is not a lack of time
            Err(_) if has_no_scene => continue,
            Err(why) => {
                lost.push((choice.name.clone(), why));
                continue;
            }
        };
        for &cells in &choice.sizes {
            let counted = expectation.counted(cells, steps.factor);
            let (error, limited_by, cpu_s) = expectation.of(&counted, steps);
            let changes = [steps.changes.clone(), choice.changes(cells)].concat();
            out.push(Setting {
                formulation: choice.name.clone(),
                choice: k,
                cells,
                set: changes.iter().map(|(key, value)| format!("{key}={value}")).collect(),
                counted,
                on_its_mesh: false,
                error,
                uncertainty: references[&limited_by].uncertainty,
                limited_by,
                cpu_s,
                wall_s: cpu_s * pilots.slowness(),
            });
            // The next size of this element is even more expensive
            if cpu_s * pilots.slowness() > budget_s {
                break;
            }
        }
    }
    out.sort_by(|a, b| a.cpu_s.total_cmp(&b.cpu_s));
    (out, lost)
}

/// The settings on a given mesh, which are the pilots themselves, with the errors estimated from each run alone plus those of the step.
pub fn given(choices: &[ElementMeshes], pilots: &Pilots, references: &References, steps: &Steps) -> Weighed {
    let (mut out, mut lost) = (vec![], vec![]);
    for (k, (choice, own)) in choices.iter().zip(&pilots.of).enumerate() {
        let Some(case) = own.first() else { continue };
        let r = &case.record;
        let estimated = r.one_run.iter().flat_map(|found| &found.quantities);
        let whole = estimated.filter(|(q, e)| e.lacks.is_none() && references.contains_key(*q));
        let errors = whole.filter_map(|(q, e)| {
            let exact = peak(case, q)? + e.correction;
            (exact != 0.0).then(|| (q, e.bar / exact.abs() + steps.error(q)))
        });
        let Some((limited_by, error)) = errors.max_by(|a, b| a.1.total_cmp(&b.1)) else {
            let missing = r.one_run.as_ref().and_then(OneRunRecord::unusable);
            let why =
                missing.unwrap_or("the estimate of its error does not fit into the budget, or has no value".into());
            lost.push((choice.name.clone(), why));
            continue;
        };
        let changes = [steps.changes.clone(), choice.changes(0)].concat();
        let cpu_s = r.cpu_s * steps.per_step / steps.factor;
        out.push(Setting {
            formulation: choice.name.clone(),
            choice: k,
            cells: r.mesh.cells as u64,
            set: changes.iter().map(|(key, value)| format!("{key}={value}")).collect(),
            counted: Counted {
                cells: r.mesh.cells,
                dofs: r.dofs,
                h_m: r.mesh.h_m,
                steps: (r.steps as f64 / steps.factor).ceil() as usize,
                factor_nnz: r.factor_nnz,
                factor_flops: r.work.factor_flops,
            },
            on_its_mesh: true,
            error,
            limited_by: limited_by.clone(),
            uncertainty: references[limited_by].uncertainty,
            cpu_s,
            wall_s: cpu_s * pilots.slowness(),
        });
    }
    out.sort_by(|a, b| a.cpu_s.total_cmp(&b.cpu_s));
    (out, lost)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ElementSpec;
    use crate::study::store::record::Series;

    /// Returns a converged run on this many cells with these peaks.
    fn run(cells: usize, peaks: [f64; 2]) -> StoredCase {
        let n = cells as f64;
        let mut r = CaseRecord { formulation: "tet10".into(), status: "Converged".into(), ..CaseRecord::default() };
        (r.mesh.cells, r.mesh.h_m, r.dofs, r.steps, r.factor_nnz) =
            (cells, n.powf(-1.0 / 3.0), 3 * cells, 1, 100 * cells);
        (r.newton_iterations, r.work.factorisations, r.work.solves, r.work.factor_flops) = (4, 4, 4, 1e3 * n * n);
        (r.cpu_s, r.wall_s, r.phases.factorisation_s, r.phases.solve_s) = (1e-3 * n, 1e-3 * n, 5e-4 * n, 1e-4 * n);
        let columns = ["angle", "tension"].map(String::from).into_iter().zip(peaks.map(|f| vec![0.0, f])).collect();
        StoredCase::new(r, Series { t_s: vec![0.0, 1.0], columns })
    }

    /// An element that agrees with the limit in one quantity is weighed by the other; elements that cannot be weighed are listed with the reason.
    #[test]
    fn no_element_is_dropped_without_a_word() {
        let cells = [600, 1320, 2904];
        let choice = |name: &str| ElementMeshes {
            name: name.into(),
            sizes: vec![2904, 6389],
            element: ElementSpec::Tet10,
            ..ElementMeshes::default()
        };
        let choices = ["agrees", "departs", "short"].map(choice);
        let runs =
            |peaks: [[f64; 2]; 3]| cells.into_iter().zip(peaks).map(|(n, peaks)| run(n, peaks)).collect::<Vec<_>>();
        let agrees = runs([[1.002, 1.10], [0.999, 1.05], [1.0, 1.025]]);
        let departs = runs([[1.01, 1.10], [1.02, 1.05], [1.04, 1.025]]);
        let short = agrees[..2].to_vec();
        let pilots = Pilots { of: vec![agrees, departs, short], ..Pilots::default() };
        let limit =
            |of_mesh: f64| Limit { value: 1.0, uncertainty: of_mesh, at_steps: 1.0, of_mesh, of_steps: Some(0.0) };
        let references = References::from([("angle".into(), limit(0.005)), ("tension".into(), limit(0.02))]);
        let (weighed, lost) = settings(&choices, &pilots, &references, &Steps::of_scene(false, ""), f64::INFINITY);
        assert!(weighed.iter().all(|s| s.formulation == "agrees" && s.limited_by == "tension"), "{weighed:?}");
        assert!(weighed.len() == 2 && weighed[0].error < 0.03 && weighed[1].error < weighed[0].error, "{weighed:?}");
        let said: Vec<String> = lost.iter().map(|(what, why)| format!("{what}: {why}")).collect();
        let departs = "departs: the errors of its pilots in angle do not fall with the size of cells: 1 %, 2 %, 4 %";
        assert_eq!(said, [departs, "short: it has 2 of the 3 pilots that a law of its error takes"]);
    }
}
