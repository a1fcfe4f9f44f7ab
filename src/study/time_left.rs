//! Time that the cases of a run still need, from their expected costs and from the actual costs of those that have finished.

use crate::study::case::Case;
use crate::study::expand::Study;
use crate::study::forecast::{Forecast, Size};
use crate::study::listing::{Listed, list};
use crate::study::store::record::CaseRecord;
use std::collections::BTreeMap;
use std::path::Path;

/// The cases that have not finished.
pub struct TimeLeft {
    cases: BTreeMap<String, Open>,
    finished: Forecast,
    jobs: usize,
}

struct Open {
    size: Size,
    /// Expected from earlier results \[s\]
    expected: Option<f64>,
    /// Completed part \[–\]
    done: f64,
}

impl TimeLeft {
    /// Collects the wanted cases of a study with results in `dir`, of which `jobs` run side by side. Meshes that already exist are taken into account.
    pub fn of(study: &Study, dir: &Path, wants: &dyn Fn(&str) -> bool, jobs: usize) -> Self {
        let listed = list(study, dir).into_iter().zip(&study.cases).filter(|(listed, _)| wants(&listed.id));
        let open = |(listed, case): (Listed, &Case)| {
            let (size, expected) = (Size::of(&case.spec, listed.nodes), listed.expected.cost_s);
            (listed.id, Open { size, expected, done: 0.0 })
        };
        Self { cases: listed.map(open).collect(), finished: Forecast::default(), jobs: jobs.max(1) }
    }

    /// Records that a part of a case is done.
    pub fn progress(&mut self, case: &str, part: f64) {
        if let Some(open) = self.cases.get_mut(case) {
            open.done = part.clamp(0.0, 1.0);
        }
    }

    /// Records that a case has ended. A result that was `kept` says nothing about this machine.
    pub fn finish(&mut self, record: &CaseRecord, kept: bool) {
        if let Some(open) = self.cases.remove(&record.id).filter(|_| !kept) {
            self.finished.learn(record, &open.size);
        }
    }

    /// Seconds, at least those of the longest case; `None` while the cost of some case is unknown.
    pub fn seconds(&self) -> Option<f64> {
        let fitted = self.finished.fitted();
        let cost = |(id, open): (&String, &Open)| {
            let by_others = || fitted.of(id, &open.size).cost_s;
            Some(open.expected.or_else(by_others)? * (1.0 - open.done))
        };
        let (sum, longest) =
            self.cases.iter().map(cost).try_fold((0.0, 0.0f64), |(sum, most), s| s.map(|s| (sum + s, most.max(s))))?;
        Some(longest.max(sum / self.jobs.min(self.cases.len()).max(1) as f64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn open(nodes: usize, expected: Option<f64>) -> Open {
        let size = Size { formulation: "tet10".into(), nodes: Some(nodes), stages: vec![] };
        Open { size, expected, done: 0.0 }
    }

    #[test]
    fn what_is_left_follows_expected_costs_and_those_of_finished_cases() {
        let cases =
            [("a", open(1000, None)), ("b", open(2000, None)), ("c", open(4000, None)), ("d", open(900, Some(3.0)))];
        let cases = cases.into_iter().map(|(id, open)| (id.to_string(), open)).collect();
        let mut left = TimeLeft { cases, finished: Forecast::default(), jobs: 2 };
        assert_eq!(left.seconds(), None, "nothing is known of three of them");
        for (id, nodes, cpu_s) in [("a", 1000, 1.0), ("b", 2000, 4.0)] {
            let mut record = CaseRecord { id: id.into(), formulation: "tet10".into(), cpu_s, ..CaseRecord::default() };
            (record.status, record.mesh.nodes) = ("Converged".into(), nodes);
            left.finish(&record, false);
        }
        // 16 s from the square of the number of nodes, and 3 s side by side; rounding of a few logarithms
        assert!((left.seconds().expect("known") / 16.0 - 1.0).abs() < 1e-9, "{:?}", left.seconds());
        left.progress("c", 0.875);
        assert!((left.seconds().expect("known") / 3.0 - 1.0).abs() < 1e-9, "{:?}", left.seconds());
        left.finish(&CaseRecord { id: "d".into(), ..CaseRecord::default() }, true);
        left.finish(&CaseRecord { id: "c".into(), ..CaseRecord::default() }, true);
        assert_eq!(left.seconds(), Some(0.0));
    }
}
