//! Errors of a prediction by mesh, time steps, response surface and the tolerance of Newton's method.
//!
//! The calibration is repeated with every surface moved to another mesh, and the prediction made there: what mesh does to both alike cancels. The
//! predictions over the meshes have the error bars of a convergence study ([`estimate`](mod@crate::study::estimate)).

use crate::study::estimate::family::{Estimate, Level, estimate, estimate_of_order};
use crate::study::estimate::step_size::step_sizes;
use crate::study::kinds::validation::budget::COVERAGE;
use crate::study::kinds::validation::design::{TIGHTER, tighter_case};
use crate::study::kinds::validation::evaluate::evaluate;
use crate::study::kinds::validation::plan::{FamilyPlan, QuantityPlan, RecordPlan, ValidationPlan};
use crate::study::kinds::validation::surface::Surface;
use crate::study::store::record::{CaseRecord, FamilyRecord, Role, StoredCase};
use crate::study::store::results::Results;
use std::collections::BTreeMap;

/// Formal order of the time integration of the families of time steps.
const ORDER_IN_TIME: f64 = 2.0;

/// Numerical part of the error of a prediction.
#[derive(Clone, Debug, Default)]
pub struct Numerical {
    /// From the mesh and the steps of the design to their limits
    pub correction: f64,
    /// `None` where the runs do not tell it
    pub mesh: Option<f64>,
    pub steps: f64,
    pub surface: f64,
    /// By Newton's method, which stops short of the solution
    pub algebraic: f64,
    pub doubts: Vec<String>,
}

impl Numerical {
    /// Groups of the budget with standard deviations.
    pub fn deviations(&self) -> [(&'static str, f64); 4] {
        [
            ("mesh", self.mesh.unwrap_or(0.0)),
            ("time step", self.steps),
            ("response surface", self.surface),
            ("algebraic", self.algebraic),
        ]
    }
}

/// The runs of a validation that tell numerical errors.
pub struct Meshes<'a> {
    results: &'a Results,
    plan: &'a ValidationPlan,
}

/// A prediction with surfaces moved record by record; `Ok(None)` where one has no run.
///
/// # Errors
///
/// In words, why the calibration gives no constants with the moved surfaces.
type Again<'f> = dyn Fn(&dyn Fn(&RecordPlan, &QuantityPlan) -> Option<f64>) -> Result<Option<f64>, String> + 'f;

impl<'a> Meshes<'a> {
    pub fn new(results: &'a Results, plan: &'a ValidationPlan) -> Self {
        Self { results, plan }
    }

    /// Errors of the prediction `value` of a quantity with this surface.
    pub fn of(
        &self,
        (record, quantity): (&RecordPlan, &QuantityPlan),
        surface: &Surface,
        value: f64,
        again: &Again,
    ) -> Numerical {
        let mut out = Numerical { surface: self.surface(record, quantity, surface), ..Numerical::default() };
        let tolerance = self.results.study.tolerance;
        let meshes = self.family(record, &[Role::Sizes, Role::Nested, Role::Remeshed]).and_then(|(f, plan)| {
            let levels = self.levels((f, plan), record, again, &mut out.doubts, |_, c, p| Level::of(&c.record, p));
            estimate((&f.name, f.role, &f.formulation), levels, None, tolerance)
        });
        match meshes {
            Some(e) => out.mesh = Some(take(&e, value, &mut out)),
            None => {
                let none = || "no family of meshes has two converged members".to_string();
                let why = std::mem::take(&mut out.doubts).into_iter().reduce(|a, b| format!("{a}; {b}"));
                let lacks = "the interval lacks the error of the mesh, and is not judged by the measured value";
                out.doubts.push(format!("{}: {lacks}", why.unwrap_or_else(none)));
            }
        }
        let of_steps = self.family(record, &[Role::TimeStep]);
        let steps = of_steps.and_then(|(f, plan)| {
            let members = (0..plan.members).map(|k| Some(&self.member((f, plan), k, record)?.record));
            let places: Vec<(usize, &CaseRecord)> = members.enumerate().filter_map(|(k, r)| Some((k, r?))).collect();
            let sizes = step_sizes(&places.iter().map(|(_, r)| *r).collect::<Vec<_>>());
            let sizes: BTreeMap<usize, f64> = places.iter().map(|(k, _)| *k).zip(sizes).collect();
            let level = |member: usize, c: &StoredCase, p| Level::of_steps(&c.record, p, sizes[&member]);
            let levels = self.levels((f, plan), record, again, &mut out.doubts, level);
            estimate_of_order((&f.name, f.role, &f.formulation), ORDER_IN_TIME, levels, None, tolerance)
        });
        let is_dynamic = || {
            let mut own = self.results.cases.iter().filter(|c| c.is_of(&record.name) && c.record.converged());
            own.any(|c| c.record.depends_on_steps())
        };
        let no_steps = || match of_steps {
            Some((f, _)) => format!("family {} has no two converged members with different time steps", f.name),
            None => "no family of role \"time_step\"".into(),
        };
        match steps {
            Some(e) => out.steps = take(&e, value, &mut out),
            None if is_dynamic() => {
                let lacks = "so that the error of the time steps is not in the interval";
                out.doubts.push(format!("{}, {lacks}", no_steps()));
            }
            None => {}
        }
        match self.algebraic(value, again) {
            Ok(Some(deviation)) => out.algebraic = deviation,
            Err(why) => out.doubts.push(format!("with tighter tolerances {why}")),
            Ok(None) => out.doubts.push(
                "no converged run with tighter tolerances, so that the algebraic error is not in the interval".into(),
            ),
        }
        out
    }

    /// Standard deviation by the runs whose tolerances are 100 times tighter. The error of the design is the difference to them over 1 − 1/100, since
    /// theirs is in proportion to the tolerance.
    fn algebraic(&self, value: f64, again: &Again) -> Result<Option<f64>, String> {
        let of = |id: String, q: &QuantityPlan| Some(evaluate(q, &self.case(&id)?.series, None, &[])?.0);
        let on = |r: &RecordPlan, q: &QuantityPlan| {
            Some(of(tighter_case(&r.name), q)? - of(format!("design-{}-centre", r.name), q)?)
        };
        Ok(again(&on)?.map(|then| (then - value).abs() / (1.0 - 1.0 / TIGHTER) / COVERAGE))
    }

    fn case(&self, id: &str) -> Option<&'a StoredCase> {
        self.results.cases.iter().find(|c| c.record.id == *id && c.record.converged())
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
        self.case(family.cases.get(place * plan.members + member)?)
    }

    /// The prediction on every member of a family; a doubt for each whose calibration gives no constants.
    fn levels(
        &self,
        family: (&FamilyRecord, &FamilyPlan),
        record: &RecordPlan,
        again: &Again,
        doubts: &mut Vec<String>,
        level: impl Fn(usize, &StoredCase, f64) -> Level,
    ) -> Vec<Level> {
        let value = |c: &StoredCase, q: &QuantityPlan| evaluate(q, &c.series, None, &[]).map(|(v, _)| v);
        let on = |member: usize, r: &RecordPlan, q: &QuantityPlan| {
            if !family.1.records.contains(&r.name) {
                return Some(0.0);
            }
            let centre = self.case(&format!("design-{}-centre", r.name))?;
            Some(value(self.member(family, member, r)?, q)? - value(centre, q)?)
        };
        let one = |member: usize| {
            let own = self.member(family, member, record)?;
            match again(&|r, q| on(member, r, q)) {
                Ok(value) => Some(level(member, own, value?)),
                Err(why) => {
                    doubts.push(format!("calibrated with case {}, {why}", own.record.id));
                    None
                }
            }
        };
        (0..family.1.members).filter_map(one).collect()
    }

    /// Root mean square distance of the checks from the surface, and at least that of the runs it was fitted to.
    fn surface(&self, record: &RecordPlan, quantity: &QuantityPlan, surface: &Surface) -> f64 {
        let error = |(id, (xi, s)): (&String, &(Vec<f64>, Vec<f64>))| {
            let case = self.case(id).filter(|c| c.is_of(&record.name))?;
            let (value, _) = evaluate(quantity, &case.series, None, &[])?;
            Some((surface.at(xi, s).0 - value).powi(2))
        };
        let errors: Vec<f64> = self.plan.checks.iter().filter_map(error).collect();
        let rms = (errors.iter().sum::<f64>() / errors.len().max(1) as f64).sqrt();
        rms.max(surface.misfit)
    }
}

/// Standard deviation by an estimate; its correction to the limit is taken unless the limit is refused.
fn take(e: &Estimate, value: f64, out: &mut Numerical) -> f64 {
    if e.refused {
        out.doubts.extend(e.reasons.iter().cloned());
        return e.uncertainty_finest.max((e.values[0] - value).abs()) / COVERAGE;
    }
    out.correction += e.extrapolated - value;
    e.uncertainty / COVERAGE
}
