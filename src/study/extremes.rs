//! Chooses which extreme of a quantity is its peak, so that compared cases use the extreme on the same side of the first value.
//!
//! The extreme of a run is the value farthest from the first one. In a cycle with motion to both sides, the values on both sides are about equally far,
//! and the last digits decide which is farther. If the extremes of a quantity in the cases of a variant lie on both sides, one side is chosen for all
//! of them: a case whose farthest value on that side is at least half as far as its extreme takes that value as its peak. A case that is far from the
//! start on one side only keeps its extreme.
//!
//! ```text
//! side = argmax Σ s over the cases      s = |farthest value on the side − first|/|extreme − first|, 0 where it is below ½
//! ```

use crate::scene::{ExtremeKind, extreme_on};
use crate::study::curve::Curve;
use crate::study::store::record::{OppositeRecord, StoredCase, StudyRecord};
use std::collections::BTreeSet;

/// Smallest distance of the opposite extreme from the start, relative to that of the extreme, at which the two are comparable \[–\]
const AS_FAR: f64 = 0.5;

/// Chooses one side for every quantity in the cases of a variant, and of variants that share cases.
pub fn align(study: &StudyRecord, cases: &mut [StoredCase]) {
    let columns: BTreeSet<&str> = study.quantities.values().flatten().map(|q| q.name.as_str()).collect();
    for column in columns {
        for group in compared(study, cases, column) {
            align_column(column, &group, cases);
        }
    }
}

/// The converged cases that are compared in a column, by index: those of each variant that judges it, merged if variants share cases.
fn compared(study: &StudyRecord, cases: &[StoredCase], column: &str) -> Vec<BTreeSet<usize>> {
    let judges =
        |variant: &&String| study.quantities.get(*variant).is_some_and(|all| all.iter().any(|q| q.name == column));
    let mut groups: Vec<BTreeSet<usize>> = vec![];
    for variant in study.variants.iter().filter(judges) {
        let is_own = |k: &usize| cases[*k].is_of(variant) && cases[*k].record.converged();
        let own: BTreeSet<usize> = (0..cases.len()).filter(is_own).collect();
        let (linked, mut others): (Vec<_>, Vec<_>) = groups.into_iter().partition(|group| !group.is_disjoint(&own));
        others.push(linked.into_iter().flatten().chain(own).collect());
        groups = others;
    }
    groups
}

fn align_column(column: &str, group: &BTreeSet<usize>, cases: &mut [StoredCase]) {
    let lies = |side: ExtremeKind| group.iter().any(|k| extreme_is(&cases[*k], column, side));
    if !(lies(ExtremeKind::Minimum) && lies(ExtremeKind::Maximum)) {
        return;
    }
    let weight = |side: ExtremeKind| -> f64 { group.iter().map(|k| share(&cases[*k], column, side)).sum() };
    let is_above = weight(ExtremeKind::Maximum) >= weight(ExtremeKind::Minimum);
    let side = if is_above { ExtremeKind::Maximum } else { ExtremeKind::Minimum };
    for k in group {
        if !extreme_is(&cases[*k], column, side) {
            turn(&mut cases[*k], column);
        }
    }
}

fn extreme_is(case: &StoredCase, column: &str, side: ExtremeKind) -> bool {
    case.record.probes.get(column).is_some_and(|probe| probe.peak_is == side)
}

/// Largest distance of a column from the start on a side, relative to its extreme; 0 if it is not comparable.
fn share(case: &StoredCase, column: &str, side: ExtremeKind) -> f64 {
    match extreme_is(case, column, side) {
        true => 1.0,
        false => opposite(case, column).map_or(0.0, |(_, share)| share),
    }
}

/// The farthest value on the other side and its relative distance, if that is comparable with the extreme. For records of earlier versions it is taken
/// from the written rows.
fn opposite(case: &StoredCase, column: &str) -> Option<(OppositeRecord, f64)> {
    let probe = case.record.probes.get(column)?;
    let curve = Curve::of(&case.series, column)?;
    let of_rows = || {
        let found = extreme_on(probe.peak_is.opposite(), curve.f.iter().copied())?;
        Some(OppositeRecord { value: found.value, t_s: curve.t[found.at] })
    };
    let other = probe.opposite.or_else(of_rows)?;
    let share = ((other.value - curve.f[0]) / (probe.peak - curve.f[0])).abs();
    (share >= AS_FAR).then_some((other, share))
}

/// Makes the farthest value on the other side the peak, if it is comparable. Results at the former extreme, namely its error from one run and its
/// derivatives, do not apply to that value and are removed.
fn turn(case: &mut StoredCase, column: &str) {
    let Some((other, _)) = opposite(case, column) else { return };
    let record = &mut case.record;
    let Some(probe) = record.probes.get_mut(column) else { return };
    probe.opposite = Some(OppositeRecord { value: probe.peak, t_s: probe.peak_t_s });
    (probe.peak, probe.peak_t_s, probe.peak_is) = (other.value, other.t_s, probe.peak_is.opposite());
    if let Some(run) = &mut record.one_run {
        run.quantities.remove(column);
    }
    for input in &mut record.inputs {
        input.derivatives.remove(column);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::extreme;
    use crate::study::curve::{peak, peak_words};
    use crate::study::run::one_run::{OneRunError, OneRunRecord};
    use crate::study::store::record::{CaseRecord, ProbeRecord, Series, StudyQuantity};

    fn case(id: &str, variant: &str, rows: &[f64]) -> StoredCase {
        let found = extreme(rows.iter().copied()).expect("rows");
        let probe = ProbeRecord {
            peak: found.value,
            peak_is: found.kind,
            peak_t_s: found.at as f64,
            last: rows[rows.len() - 1],
            opposite: None,
            motion: None,
        };
        let record = CaseRecord {
            id: id.into(),
            variant: variant.into(),
            status: "Converged".into(),
            probes: [("f_N".to_string(), probe)].into(),
            ..CaseRecord::default()
        };
        let t_s = (0..rows.len()).map(|k| k as f64).collect();
        StoredCase::new(record, Series { t_s, columns: [("f_N".to_string(), rows.to_vec())].into() })
    }

    fn study(variants: &[&str]) -> StudyRecord {
        let quantity = StudyQuantity { name: "f_N".into(), ..StudyQuantity::default() };
        StudyRecord {
            variants: variants.iter().map(ToString::to_string).collect(),
            quantities: variants.iter().map(|v| (v.to_string(), vec![quantity.clone()])).collect(),
            ..serde_json::from_value(serde_json::json!({
                "study": "", "kind": "", "question": "", "expectation": "", "tolerance": 0.01, "quantities": {},
                "variants": [], "families": [], "version": ""
            }))
            .expect("a study")
        }
    }

    fn peaks(cases: &[StoredCase]) -> Vec<f64> {
        cases.iter().filter_map(|c| peak(c, "f_N")).collect()
    }

    /// Forces of a bar that is moved back and forth, on four meshes; the last digits would have given −0.2303 and +0.2216 in a converging sequence.
    #[test]
    fn a_cycle_to_and_fro_has_one_peak_on_all_meshes() {
        let rows = [[0.23, -0.2303], [0.22351, -0.2235], [0.221931, -0.22193], [0.2216, -0.22152]];
        let mut cases: Vec<StoredCase> = rows.iter().map(|[a, b]| case("c", "v", &[0.0, *a, *b, 0.0])).collect();
        assert_eq!(peaks(&cases), [-0.2303, 0.22351, 0.221931, 0.2216]);
        let error = OneRunError { correction: 0.1, uncertainty: 0.1, bar: 0.2, ..OneRunError::default() };
        let estimate = OneRunRecord { quantities: [("f_N".to_string(), error)].into(), ..OneRunRecord::default() };
        cases.iter_mut().for_each(|c| c.record.one_run = Some(estimate.clone()));
        align(&study(&["v"]), &mut cases);
        assert_eq!(peaks(&cases), [-0.2303, -0.2235, -0.22193, -0.22152]);
        assert_eq!(peak_words(&cases, "f_N"), "minimum");
        assert_eq!(cases[1].record.probes["f_N"].peak_t_s, 2.0);
        let estimates = cases.iter().map(|c| c.record.one_run.as_ref().map_or(0, |run| run.quantities.len()));
        assert_eq!(estimates.collect::<Vec<_>>(), [1, 0, 0, 0], "an estimate is of the extreme of the run");
        let turned = cases.clone();
        align(&study(&["v"]), &mut cases);
        assert_eq!(cases, turned, "what is on one side stays");
    }

    /// All rows of the run count, even if only a few of them were written.
    #[test]
    fn the_other_extreme_is_that_of_the_record() {
        let mut cases =
            [case("a", "v", &[0.0, 0.2, -1.0]), case("b", "v", &[0.0, 1.0, -0.9]), case("c", "v", &[0.0, 1.0])];
        cases[0].record.probes.get_mut("f_N").expect("a probe").opposite =
            Some(OppositeRecord { value: 0.99, t_s: 0.5 });
        align(&study(&["v"]), &mut cases);
        assert_eq!(peaks(&cases), [0.99, 1.0, 1.0]);
    }

    /// A bar that is pulled and one that is pushed keep their own extremes, and so do variants that share no case.
    #[test]
    fn a_case_on_one_side_alone_keeps_its_extreme() {
        let mut cases = [
            case("pulled", "v", &[0.0, 1.0, -0.4]),
            case("pushed", "v", &[0.0, -1.0, 0.4]),
            case("to", "w", &[0.0, 1.0, -0.9]),
            case("fro", "w", &[0.0, 0.9, -1.0]),
            case("other", "x", &[0.0, 0.9, -1.0]),
        ];
        align(&study(&["v", "w", "x"]), &mut cases);
        assert_eq!(peaks(&cases), [1.0, -1.0, 1.0, 0.9, -1.0]);
    }
}
