//! The error of the time steps of a prediction, where a stage before the movement has a step of its own.

use crate::beam::{LOADS, by_formula, drop, found};
use durometer::math::statistics::larger;
use durometer::study::kinds::validation::plan::FamilyPlan;
use durometer::study::store::record::{CaseRecord, FamilyRecord, Role, Series, StoredCase};

const STEPS: [f64; 3] = [0.05, 0.025, 0.0125];

/// Predictions from values with an error of 1 % at 50 ms, in proportion to Δt², where these are the steps of the stages.
fn predicted(stages: impl Fn(f64) -> Vec<f64>) -> String {
    let (mut plan, mut results) = by_formula();
    let mut ids = vec![];
    for (name, load) in LOADS {
        let value = drop(load, (300.0, [0.0; 3]), name == "heavy");
        if name != "heavy" {
            plan.quantities[0].records.insert(name.into(), vec![value]);
        }
        for dt in STEPS {
            let stage_dt_s = stages(dt);
            let dt_s = stage_dt_s.iter().copied().fold(0.0, larger);
            let (id, variant) = (format!("steps-{name}-{dt}"), name.to_string());
            ids.push(id.clone());
            let status = "Converged".into();
            let record = CaseRecord { id, variant, status, dt_s, stage_dt_s, ..CaseRecord::default() };
            let end = 0.01 - 1e-3 * value * (1.0 + 0.01 * (dt / STEPS[0]).powi(2));
            let columns = [("xmax_z_m".to_string(), vec![0.01, end])].into();
            results.cases.push(StoredCase::new(record, Series { t_s: vec![0.0, 1.0], columns }));
        }
    }
    let (name, records) = ("steps".to_string(), LOADS.map(|(name, _)| name.to_string()).to_vec());
    plan.families.push(FamilyPlan { name: name.clone(), members: STEPS.len(), records });
    let (role, formulation, members) = (Role::TimeStep, "tet4".into(), vec![]);
    results.study.families.push(FamilyRecord { name, role, formulation, cases: ids, members });
    let found = found(&results, &plan);
    let of_steps = found.predictions[0].budget.iter().find(|c| c.group == "time step");
    assert!(of_steps.is_some_and(|c| c.deviation > 0.0), "{:?}", found.predictions[0].budget);
    assert!(!format!("{found:?}").contains("role \"time_step\""), "{:?}", found.predictions);
    format!("{:?}", found.predictions)
}

#[test]
fn a_hold_before_the_movement_changes_no_prediction() {
    let expected = predicted(|dt| vec![dt]);
    for hold in [1.0, 0.01] {
        assert_eq!(predicted(|dt| vec![hold, dt]), expected, "a hold with steps of {hold} s");
    }
}
