//! Settings with what is expected of them, from the pilots alone: no mesh is made for a setting that a cheaper one surpasses.
//!
//! Counts of a mesh that has not been made are power laws of the number of cells through the pilots of its element: unknowns and h as in
//! the largest pilot, entries and operations of the factor by a fit.

use crate::study::curve::peak;
use crate::study::estimate::family::formal_order;
use crate::study::estimate::growth::{Growth, growth};
use crate::study::plan::limit::{Limit, References};
use crate::study::plan::model::{Clock, Counted, error_law};
use crate::study::plan::pilots::Pilots;
use crate::study::plan::settings::Setting;
use crate::study::plan::sizes::Choice;
use crate::study::plan::steps::Steps;
use crate::study::store::record::{CaseRecord, StoredCase};

/// Knowledge of one element, to expect errors and times of its sizes.
pub struct Expectation {
    clock: Clock,
    laws: Vec<(String, Growth)>,
    nnz: Growth,
    flops: Growth,
    largest: CaseRecord,
}

impl Expectation {
    /// From the pilots of one element; none without two of them and a law of the error in every quantity.
    pub fn new(own: &[StoredCase], references: &References) -> Option<Self> {
        let records: Vec<&CaseRecord> = own.iter().map(|c| &c.record).collect();
        let formal = own.first().map_or(2.0, |c| formal_order(&c.record.formulation));
        // The pilots have the steps of the scene, and so has the limit that they are compared with
        let law = |(q, limit): (&String, &Limit)| {
            let error = |c: &StoredCase| Some((c.record.mesh.h_m, (peak(c, q)? / limit.at_steps - 1.0).abs()));
            error_law(&own.iter().filter_map(error).collect::<Vec<_>>(), formal).map(|law| (q.clone(), law))
        };
        let laws: Option<Vec<_>> = references.iter().map(law).collect();
        let over_cells = |of: fn(&CaseRecord) -> f64| {
            growth(&records.iter().map(|r| (r.mesh.cells as f64, of(r))).collect::<Vec<_>>())
        };
        Some(Self {
            clock: Clock::new(&records)?,
            laws: laws.filter(|l| !l.is_empty())?,
            nnz: over_cells(|r| r.factor_nnz as f64)?,
            flops: over_cells(|r| r.work.factor_flops)?,
            largest: (*records.iter().max_by_key(|r| r.mesh.cells)?).clone(),
        })
    }

    /// Counts of a mesh with so many cells, with steps of the pilots times `factor`.
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

    /// Error, the column that limits it, and CPU time \[s\] of a run of this size.
    pub fn of(&self, counted: &Counted, steps: &Steps) -> (f64, String, f64) {
        let errors = self.laws.iter().map(|(q, law)| (q, law.at(counted.h_m) + steps.error(q)));
        let (limited_by, error) = errors.max_by(|a, b| a.1.total_cmp(&b.1)).expect("there is a law");
        (error, limited_by.clone(), steps.per_step * self.clock.predict(counted))
    }
}

/// Error and time of every element and size that fit into `budget_s` by the clock, cheapest first.
pub fn settings(
    choices: &[Choice],
    pilots: &Pilots,
    references: &References,
    steps: &Steps,
    budget_s: f64,
) -> Vec<Setting> {
    let mut out = vec![];
    for (k, (choice, own)) in choices.iter().zip(&pilots.of).enumerate() {
        let Some(expectation) = Expectation::new(own, references) else { continue };
        for &cells in &choice.sizes {
            let counted = expectation.counted(cells, steps.factor);
            let (error, limited_by, cpu_s) = expectation.of(&counted, steps);
            let changes = [steps.changes.clone(), choice.changes(cells)].concat();
            out.push(Setting {
                element: choice.name.clone(),
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
            // The next size of this element is more expensive still
            if cpu_s * pilots.slowness() > budget_s {
                break;
            }
        }
    }
    out.sort_by(|a, b| a.cpu_s.total_cmp(&b.cpu_s));
    out
}

/// Settings on a given mesh, which are the pilots themselves, by the errors estimated from each run alone, and those of the step.
pub fn given(choices: &[Choice], pilots: &Pilots, references: &References, steps: &Steps) -> Vec<Setting> {
    let mut out = vec![];
    for (k, (choice, own)) in choices.iter().zip(&pilots.of).enumerate() {
        let Some(case) = own.first() else { continue };
        let r = &case.record;
        let estimated = r.one_run.iter().flat_map(|found| &found.quantities);
        let errors = estimated.filter(|(q, _)| references.contains_key(*q)).filter_map(|(q, e)| {
            let exact = peak(case, q)? + e.correction;
            (exact != 0.0).then(|| (q, e.bar / exact.abs() + steps.error(q)))
        });
        let Some((limited_by, error)) = errors.max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let changes = [steps.changes.clone(), choice.changes(0)].concat();
        let cpu_s = r.cpu_s * steps.per_step / steps.factor;
        out.push(Setting {
            element: choice.name.clone(),
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
    out
}
