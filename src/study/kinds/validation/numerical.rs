//! Errors of constants and predictions due to mesh, time steps, response surface and the tolerance of Newton's method.
//!
//! The calibration is repeated with the surfaces of all records of a family shifted to another mesh, and the prediction is made there, so that an
//! effect of the mesh that is common to all of them cancels. The outcomes over the meshes have the error bars of a convergence study
//! ([`estimate`](mod@crate::study::estimate)).
//!
//! ```text
//! z + Σ (z_F − z),  u² = Σ u_F²                  over the families F of the records that z rests on; z_F is its limit with the records of F moved
//! ```
//!
//! A record counts in one family. The error that remains after the correction to its limit has no known sign, so that different families count as
//! independent (JCGM 100:2008, 5.1.2; ASME V&V 20-2009, u_num).
//!
//! ```text
//! u² = Σ mean over runs k of (Σ ∂z/∂dᵢ eᵢₖ)²   over records and their data i; eₖ is the distance of the surface from run k, ∂z/∂d = 1 of the predicted value
//! ```
//!
//! is the variance due to the response surfaces, to first order.

use crate::math::statistics::smaller;
use crate::study::estimate::family::{Estimate, Level, estimate, estimate_of_order, order_objection};
use crate::study::estimate::step_size::step_sizes;
use crate::study::kinds::validation::budget::COVERAGE;
use crate::study::kinds::validation::design::{ALGEBRAIC, TIGHTER};
use crate::study::kinds::validation::evaluate::evaluate;
use crate::study::kinds::validation::plan::{FamilyPlan, QuantityPlan, RecordPlan, ValidationPlan};
use crate::study::kinds::validation::responses::{Shift, Target};
use crate::study::store::record::{FamilyRecord, Role, StoredCase};
use crate::study::store::results::Results;
use crate::wording::few;
use std::collections::BTreeMap;

/// Roles of the families of meshes.
const MESHES: [Role; 3] = [Role::Sizes, Role::Nested, Role::Remeshed];
/// Derivative by a datum, relative to the largest, below which an outcome does not depend on the datum.
const NEGLIGIBLE: f64 = 1e-6;

/// Numerical part of the error of a constant or a prediction.
#[derive(Clone, Debug, Default)]
pub struct Numerical {
    /// Change from the meshes and steps of the design to their limits
    pub correction: f64,
    pub mesh: f64,
    /// Whether the runs do not show the mesh error of every record that it depends on
    pub lacks_mesh: bool,
    pub steps: f64,
    pub surface: f64,
    /// Error because Newton's method stops short of the solution
    pub algebraic: f64,
    pub doubts: Vec<String>,
}

impl Numerical {
    /// Returns the groups of the budget with their standard deviations.
    pub fn deviations(&self) -> [(&'static str, f64); 4] {
        [
            ("mesh", self.mesh),
            ("time step", self.steps),
            ("response surface", self.surface),
            ("algebraic", self.algebraic),
        ]
    }

    /// Returns the total variance.
    pub fn variance(&self) -> f64 {
        self.deviations().iter().map(|(_, d)| d * d).sum()
    }
}

/// Recomputes an outcome with surfaces shifted record by record; `Ok(None)` if one record has no run.
///
/// # Errors
///
/// The reason, in words, why the calibration gives no constants with the shifted surfaces.
type Again<'f> = dyn Fn(&Shift) -> Result<Option<f64>, String> + 'f;

/// A constant or a prediction, with what it depends on.
pub struct Outcome<'a> {
    pub value: f64,
    /// Record and quantity of a prediction; `None` for a constant
    pub own: Option<&'a Target<'a>>,
    /// Its derivative by each datum of the calibration
    pub by_data: Vec<f64>,
    pub again: &'a Again<'a>,
}

/// The runs of a validation that show numerical errors.
pub struct Meshes<'a> {
    results: &'a Results,
    plan: &'a ValidationPlan,
    /// Data of the calibration
    data: &'a [&'a Target<'a>],
    /// Errors of their surfaces, by datum
    errors: Vec<Errors<'a>>,
}

/// Distances of a surface from runs, by case: from the checks, and from the runs that it was fitted to.
type Errors<'a> = [BTreeMap<&'a str, f64>; 2];

/// Records that one family shifts together, or that no family runs.
struct Group<'a> {
    family: Option<(&'a FamilyRecord, &'a FamilyPlan)>,
    records: Vec<&'a RecordPlan>,
}

/// Error of an outcome from the families of some roles.
#[derive(Default)]
struct Discretisation {
    correction: f64,
    variance: f64,
    is_incomplete: bool,
}

impl<'a> Meshes<'a> {
    pub fn new(results: &'a Results, plan: &'a ValidationPlan, data: &'a [&'a Target<'a>]) -> Self {
        let mut own = Self { results, plan, data, errors: vec![] };
        own.errors = data.iter().map(|t| own.errors(t)).collect();
        own
    }

    /// Returns the numerical errors of an outcome.
    pub fn of(&self, outcome: &Outcome) -> Numerical {
        let mut doubts = vec![];
        let mesh = self.discretisation(outcome, &MESHES, &mut doubts);
        let steps = self.discretisation(outcome, &[Role::TimeStep], &mut doubts);
        let algebraic = self.algebraic(outcome).unwrap_or_else(|why| {
            doubts.push(format!("with tighter tolerances {why}"));
            Some(0.0)
        });
        if algebraic.is_none() {
            let lacks = "so that the algebraic error is not in the interval";
            doubts.push(format!("no converged run with tighter tolerances, {lacks}"));
        }
        Numerical {
            correction: mesh.correction + steps.correction,
            mesh: mesh.variance.sqrt(),
            lacks_mesh: mesh.is_incomplete,
            steps: steps.variance.sqrt(),
            surface: self.surface(outcome),
            algebraic: algebraic.unwrap_or(0.0),
            doubts,
        }
    }

    /// The error from the families of these roles; adds a doubt for each group of records whose error they do not show.
    fn discretisation(&self, outcome: &Outcome, roles: &[Role], doubts: &mut Vec<String>) -> Discretisation {
        let of_steps = roles.contains(&Role::TimeStep);
        let mut out = Discretisation::default();
        for Group { family, records } in self.groups(outcome, roles) {
            let mut own = vec![];
            if let Some(e) = family.and_then(|f| self.estimate(f, &records, outcome, &mut own)) {
                doubts.append(&mut own);
                let (correction, deviation) = of_limit(&e, outcome.value, doubts);
                out.correction += correction;
                out.variance += deviation * deviation;
                continue;
            }
            let counting = records.iter().filter(|r| !of_steps || self.is_dynamic(r));
            let labels: Vec<&str> = counting.map(|r| r.label.as_str()).collect();
            if labels.is_empty() {
                continue;
            }
            out.is_incomplete = true;
            let fact = match (of_steps, family) {
                (false, _) => format!("no family of meshes has two converged members of {}", few(&labels)),
                (true, None) => format!("no family of role \"time_step\" runs {}", few(&labels)),
                (true, Some((f, _))) => {
                    format!("family {} has no two converged members of {} with different steps", f.name, few(&labels))
                }
            };
            let why = own.into_iter().reduce(|a, b| format!("{a}; {b}")).unwrap_or(fact);
            doubts.push(match (of_steps, outcome.own) {
                (true, _) => format!("{why}: the interval lacks the error of the time steps"),
                (false, None) => format!("{why}: the interval lacks the error of the mesh"),
                (false, Some(_)) => {
                    format!("{why}: the interval lacks the error of the mesh, and is not judged by the measured value")
                }
            });
        }
        out
    }

    /// The records that an outcome depends on, grouped by the families of these roles that run them; the record of the outcome itself comes first.
    fn groups<'o>(&self, outcome: &Outcome<'o>, roles: &[Role]) -> Vec<Group<'o>>
    where
        'a: 'o,
    {
        let parts = self.data.iter().zip(&outcome.by_data).map(|(t, by)| (by * t.response.sigma()).abs());
        let parts: Vec<f64> = parts.collect();
        let least = NEGLIGIBLE * parts.iter().fold(0.0_f64, |most, part| most.max(*part));
        let data = self.data.iter().zip(&parts).filter(|(_, part)| **part > least).map(|(t, _)| t.record);
        let mut all: Vec<Group> = vec![];
        for record in outcome.own.map(|t| t.record).into_iter().chain(data) {
            if all.iter().any(|g| g.records.iter().any(|r| r.name == record.name)) {
                continue;
            }
            let known = all.iter().position(|g| g.family.is_some_and(|(_, plan)| plan.records.contains(&record.name)));
            let family = if known.is_none() { self.family(record, roles) } else { None };
            let alike = || all.iter().position(|g| g.family.is_none() && family.is_none());
            match known.or_else(alike) {
                Some(k) => all[k].records.push(record),
                None => all.push(Group { family, records: vec![record] }),
            }
        }
        all
    }

    /// Whether the results of a record depend on the time steps.
    fn is_dynamic(&self, record: &RecordPlan) -> bool {
        let mut own = self.results.cases.iter().filter(|c| c.is_of(&record.name) && c.record.converged());
        own.any(|c| c.record.depends_on_steps())
    }

    /// Standard deviation from the runs with 100 times tighter tolerances. The error of the design is the difference from them divided by 1 − 1/100,
    /// because the error of those runs is proportional to their tolerance.
    fn algebraic(&self, outcome: &Outcome) -> Result<Option<f64>, String> {
        // A check may be the same run, which then belongs to both families
        let tighter = |r: &RecordPlan| self.run(|c| c.is_in(ALGEBRAIC, &r.name));
        let on = |r: &RecordPlan, q: &QuantityPlan| self.moved(r, q, tighter(r));
        Ok((outcome.again)(&on)?.map(|then| (then - outcome.value).abs() / (1.0 - 1.0 / TIGHTER) / COVERAGE))
    }

    /// The change of a quantity of a record in a run, relative to the centre of its design.
    fn moved(&self, record: &RecordPlan, quantity: &QuantityPlan, run: Option<&StoredCase>) -> Option<f64> {
        let mut centres = self.plan.points.iter().filter(|(_, xi)| xi.iter().all(|x| *x == 0.0));
        let centre = centres.find_map(|(id, _)| self.run(|c| c.record.id == *id && c.is_of(&record.name)));
        let [there, here] = [run?, centre?].map(|c| evaluate(quantity, &c.series, None, &[]).map(|(value, _)| value));
        Some(there? - here?)
    }

    /// The first converged case that meets a condition.
    fn run(&self, is: impl Fn(&StoredCase) -> bool) -> Option<&'a StoredCase> {
        self.results.cases.iter().find(|c| is(c) && c.record.converged())
    }

    /// The family of one of these roles that runs the record.
    fn family(&self, record: &RecordPlan, roles: &[Role]) -> Option<(&'a FamilyRecord, &'a FamilyPlan)> {
        let plan = |f: &'a FamilyRecord| self.plan.families.iter().find(|p| p.name == f.name);
        let all = self.results.study.families.iter().filter(|f| roles.contains(&f.role));
        all.filter_map(|f| Some((f, plan(f)?))).find(|(_, plan)| plan.records.contains(&record.name))
    }

    /// The case of a record in a member of a family, which lists the members of one record after those of another.
    fn member(
        &self,
        (family, plan): (&FamilyRecord, &FamilyPlan),
        member: usize,
        r: &RecordPlan,
    ) -> Option<&'a StoredCase> {
        let place = plan.records.iter().position(|name| *name == r.name)?;
        let id = family.cases.get(place * plan.members + member)?;
        self.run(|c| c.record.id == *id)
    }

    /// The limit of an outcome over the members of a family, with these records shifted; sizes are taken from the first record.
    fn estimate(
        &self,
        (family, plan): (&FamilyRecord, &FamilyPlan),
        records: &[&RecordPlan],
        outcome: &Outcome,
        doubts: &mut Vec<String>,
    ) -> Option<Estimate> {
        let tolerance = self.results.study.tolerance;
        let first = records.first()?;
        let member = |k: usize| Some((k, self.member((family, plan), k, first)?));
        let members: BTreeMap<usize, &StoredCase> = (0..plan.members).filter_map(member).collect();
        let runs: Vec<&StoredCase> = members.values().copied().collect();
        let of = (family.name.as_str(), family.role, family.formulation_of(&runs));
        if family.role != Role::TimeStep {
            let own = outcome.own.filter(|t| records.iter().any(|r| r.name == t.record.name));
            let column = own.map_or("", |t| t.quantity.column.as_str());
            let level = |_: usize, c: &StoredCase, z: f64| Level::of(&c.record, column, z);
            let levels = self.levels((family, plan), records, outcome, doubts, level);
            return estimate(of, levels, None, tolerance);
        }
        let sizes = step_sizes(&runs.iter().map(|c| &c.record).collect::<Vec<_>>());
        let sizes: BTreeMap<usize, f64> = members.into_keys().zip(sizes).collect();
        let level = |member: usize, c: &StoredCase, z| Level::of_steps(&c.record, z, sizes[&member]);
        let levels = self.levels((family, plan), records, outcome, doubts, level);
        let order = runs.iter().map(|c| c.record.order_in_time()).fold(f64::INFINITY, smaller);
        estimate_of_order(of, order, levels, None, tolerance)
    }

    /// The outcome on every member of a family; adds a doubt for each member whose calibration gives no constants.
    fn levels(
        &self,
        family: (&FamilyRecord, &FamilyPlan),
        records: &[&RecordPlan],
        outcome: &Outcome,
        doubts: &mut Vec<String>,
        level: impl Fn(usize, &StoredCase, f64) -> Level,
    ) -> Vec<Level> {
        let on = |member: usize, r: &RecordPlan, q: &QuantityPlan| match records.iter().any(|own| own.name == r.name) {
            true => self.moved(r, q, self.member(family, member, r)),
            false => Some(0.0),
        };
        let one = |member: usize| {
            let own = self.member(family, member, records.first()?)?;
            match (outcome.again)(&|r, q| on(member, r, q)) {
                Ok(value) => Some(level(member, own, value?)),
                Err(why) => {
                    doubts.push(format!("calibrated with case {}, {why}", own.record.id));
                    None
                }
            }
        };
        (0..family.1.members).filter_map(one).collect()
    }

    /// Standard deviation due to the surfaces of all records that an outcome depends on; different records count as independent.
    fn surface(&self, outcome: &Outcome) -> f64 {
        let own = outcome.own.map(|t| (t.record.name.as_str(), self.errors(t)));
        let mut records: BTreeMap<&str, Vec<(&Errors, f64)>> = BTreeMap::new();
        for ((t, errors), by) in self.data.iter().zip(&self.errors).zip(&outcome.by_data) {
            records.entry(&t.record.name).or_default().push((errors, *by));
        }
        if let Some((record, errors)) = &own {
            records.entry(record).or_default().push((errors, 1.0));
        }
        records.values().map(|parts| by_surfaces(parts)).sum::<f64>().sqrt()
    }

    /// Distances of the surface of a target from the checks, and from the runs that it was fitted to.
    fn errors(&self, target: &Target) -> Errors<'a> {
        let error = |id: &'a String, xi: &[f64], s: &[f64]| {
            let case = self.run(|c| c.record.id == *id && c.is_of(&target.record.name))?;
            let (value, _) = evaluate(target.quantity, &case.series, None, &[])?;
            Some((id.as_str(), target.response.surface.at(xi, s).0 - value))
        };
        let checks = self.plan.checks.iter().filter_map(|(id, (xi, s))| error(id, xi, s));
        [checks.collect(), self.plan.points.iter().filter_map(|(id, xi)| error(id, xi, &[])).collect()]
    }
}

/// Variance due to the surfaces of one record, each with the derivative of an outcome by its value. Their errors are correlated: mean square of the
/// sum over the checks, and at least that over the runs that they were fitted to.
fn by_surfaces(parts: &[(&Errors, f64)]) -> f64 {
    let mean_square = |k: usize| {
        let runs = parts.first().into_iter().flat_map(|(errors, _)| errors[k].keys());
        let sum = |run: &&str| parts.iter().map(|(errors, by)| Some(by * errors[k].get(run)?)).sum::<Option<f64>>();
        let squares: Vec<f64> = runs.filter_map(sum).map(|e| e * e).collect();
        squares.iter().sum::<f64>() / squares.len().max(1) as f64
    };
    mean_square(0).max(mean_square(1))
}

/// Correction to the limit of an estimate, which is zero if it is refused, and its standard deviation; adds a doubt if there are only two members.
fn of_limit(e: &Estimate, value: f64, doubts: &mut Vec<String>) -> (f64, f64) {
    if e.refused {
        doubts.extend(e.reasons.iter().cloned());
        return (0.0, e.uncertainty_finest.max((e.values[0] - value).abs()) / COVERAGE);
    }
    doubts.extend(order_objection(e).map(|why| format!("family {}: {why}", e.family)));
    (e.extrapolated - value, e.uncertainty / COVERAGE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Errors of two data of one record cancel or add run by run; the runs of the fit count if they are farther off than the checks.
    #[test]
    fn surfaces_of_a_record_are_wrong_together() {
        let errors = |checks: [f64; 2], fit: f64| -> Errors {
            [["a", "b"].into_iter().zip(checks).collect(), [("c", fit)].into()]
        };
        let (x, y) = (errors([3.0, -1.0], 0.5), errors([-3.0, 1.0], 0.5));
        assert_eq!(by_surfaces(&[(&x, 1.0), (&y, -1.0)]), 20.0);
        assert_eq!(by_surfaces(&[(&x, 1.0), (&y, 1.0)]), 1.0);
        assert_eq!(by_surfaces(&[]), 0.0);
    }
}
