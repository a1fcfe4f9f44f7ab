//! Facts about a run that limit how its numbers may be used, in words: commands print them, and the Python package issues them as warnings.

use super::locking::{self, REMEDY};
use super::store::record::CaseRecord;
use crate::report::numbers::percent;
use crate::wording::few;

/// Kind of a fact without a more specific kind.
pub const WARNING: &str = "warning";

/// The limits of a run in words, each with its kind: `warning` or `locking alarm`.
pub fn limits_of_run(record: &CaseRecord) -> Vec<(&'static str, String)> {
    let solver = &record.solver;
    let energy = solver.energy_from_nothing.iter().map(|found| (WARNING, found.warning()));
    let cavities = solver.collapsed_cavities.iter().map(|found| (WARNING, found.warning()));
    let locked = locking::alarm(record).map(|scatter| {
        ("locking alarm", format!("the pressures scatter by {scatter:.2} of the deviatoric stress; {REMEDY}"))
    });
    let steps = unresolved(record).map(|fact| (WARNING, fact));
    let sunken = solver.sunken_facets.iter().map(|found| (WARNING, found.warning()));
    energy.chain(cavities).chain(sunken).chain(locked).chain(steps).collect()
}

/// The columns whose motion the time steps do not resolve; `None` if they resolve all.
fn unresolved(record: &CaseRecord) -> Option<String> {
    let of = |probe: &String| Some(format!("{probe} ({})", percent(record.unresolved(probe, 0.0)?)));
    let unresolved: Vec<String> = record.probes.keys().filter_map(of).collect();
    (!unresolved.is_empty()).then(|| {
        format!(
            "the time steps do not resolve the motion: one of them covers a large part of the range of {}; shorten them",
            few(&unresolved)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ExtremeKind;
    use crate::study::store::record::{LockingRecord, MotionRecord, ProbeRecord};

    #[test]
    fn a_run_that_locks_and_jumps_is_told_with_remedies() {
        let probe = |largest_step| ProbeRecord {
            peak: 1.0,
            peak_is: ExtremeKind::Constant,
            peak_t_s: 0.0,
            last: 1.0,
            opposite: None,
            motion: Some(MotionRecord { largest_step, range: 1.0 }),
        };
        let record = CaseRecord {
            locking: Some(LockingRecord { pressure_scatter: 1.234, volumetric_share: 0.5, alarm: true }),
            probes: [("fine_z_m", 0.01), ("tip_z_m", 0.9)].map(|(name, step)| (name.into(), probe(step))).into(),
            ..CaseRecord::default()
        };
        let [(first, locked), (second, steps)] = &limits_of_run(&record)[..] else { panic!("two facts") };
        assert_eq!((*first, *second), ("locking alarm", WARNING));
        assert!(locked.starts_with("the pressures scatter by 1.23 of the deviatoric stress; take "), "{locked}");
        assert!(steps.ends_with("a large part of the range of tip_z_m (90 %); shorten them"), "{steps}");
        assert!(limits_of_run(&CaseRecord::default()).is_empty());
    }
}
