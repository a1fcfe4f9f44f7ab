//! Expected time and memory of a case before it runs, by the results that are stored.
//!
//! A case costs what its own last result has cost, whichever inputs and build that had. One without a result costs what the law of growth
//! over the nodes says ([`growth`]) that is fitted to the results of its formulation, or, where those are all of one size, the largest of them.

use crate::study::estimate::growth::growth;
use crate::study::store::record::CaseRecord;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};

/// Sizes closer than this are one size \[–\].
const ONE_SIZE: f64 = 0.01;

/// Costs of the stored results of a study.
#[derive(Default)]
pub struct Forecast {
    /// Case id → its own cost
    own: HashMap<String, Expected>,
    /// Formulation → the costs over the size
    by_size: BTreeMap<String, Points>,
}

#[derive(Default)]
struct Points {
    /// Nodes, and seconds
    cost: Vec<(f64, f64)>,
    /// Nodes, and bytes
    memory: Vec<(f64, f64)>,
}

/// Time and memory of a case, as far as something is known.
#[derive(Serialize, Clone, Copy, Debug, PartialEq, Default)]
pub struct Expected {
    /// Time on one core \[s\]
    pub cost_s: Option<f64>,
    pub memory_bytes: Option<u64>,
}

impl Forecast {
    /// Takes a stored result into account.
    pub fn learn(&mut self, record: &CaseRecord) {
        let cost = record.cpu_s * record.repeats.len().max(1) as f64 + record.phases.build_s;
        let (cost_s, memory_bytes) = (Some(cost).filter(|s| *s > 0.0), record.work.memory_bytes);
        self.own.insert(record.id.clone(), Expected { cost_s, memory_bytes });
        if !record.converged() {
            return;
        }
        let (nodes, points) = (record.mesh.nodes as f64, self.by_size.entry(record.formulation.clone()).or_default());
        points.cost.extend(cost_s.map(|s| (nodes, s)));
        points.memory.extend(memory_bytes.map(|b| (nodes, b as f64)));
    }

    /// The laws of growth over what was learnt.
    pub fn fitted(&self) -> Fitted<'_> {
        let laws =
            self.by_size.iter().map(|(name, points)| (name.as_str(), [&points.cost[..], &points.memory].map(law)));
        Fitted { own: &self.own, laws: laws.collect() }
    }
}

type Law = Box<dyn Fn(f64) -> Option<f64>>;

/// Costs by their laws of growth.
pub struct Fitted<'a> {
    own: &'a HashMap<String, Expected>,
    /// Formulation → seconds and bytes over nodes
    laws: BTreeMap<&'a str, [Law; 2]>,
}

impl Fitted<'_> {
    /// Expected cost of a case of this formulation and number of nodes, where the mesh exists.
    pub fn of(&self, id: &str, formulation: &str, nodes: Option<usize>) -> Expected {
        let own = self.own.get(id).copied().unwrap_or_default();
        let by_size = |k: usize| self.laws.get(formulation).and_then(|laws| laws[k](nodes? as f64));
        let memory_bytes = own.memory_bytes.or_else(|| by_size(1).map(|b| b as u64));
        Expected { cost_s: own.cost_s.or_else(|| by_size(0)), memory_bytes }
    }
}

fn law(points: &[(f64, f64)]) -> Law {
    let (low, high) = points.iter().fold((f64::INFINITY, 0.0f64), |(l, h), p| (l.min(p.0), h.max(p.0)));
    let largest = points.iter().map(|p| p.1).fold(0.0, f64::max);
    match growth(points) {
        Some(growth) if high > low * (1.0 + ONE_SIZE) => Box::new(move |nodes| Some(growth.at(nodes))),
        _ => Box::new(move |nodes| (largest > 0.0 && (nodes / high - 1.0).abs() < ONE_SIZE).then_some(largest)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(id: &str, nodes: usize, cpu_s: f64) -> CaseRecord {
        let mut record = CaseRecord { id: id.into(), formulation: "tet10".into(), cpu_s, ..CaseRecord::default() };
        record.status = "Converged".into();
        (record.mesh.nodes, record.work.memory_bytes) = (nodes, Some(1000 * nodes as u64));
        record
    }

    #[test]
    fn a_case_costs_as_its_last_result_or_by_the_growth_of_the_others() {
        let mut forecast = Forecast::default();
        for (id, nodes) in [("a", 1000), ("b", 2000), ("c", 4000)] {
            forecast.learn(&record(id, nodes, 1e-6 * (nodes as f64).powi(2)));
        }
        let fitted = forecast.fitted();
        assert_eq!(fitted.of("b", "tet10", None), Expected { cost_s: Some(4.0), memory_bytes: Some(2_000_000) });
        let new = fitted.of("d", "tet10", Some(8000));
        // Rounding of a few logarithms
        assert!((new.cost_s.expect("a law") / 64.0 - 1.0).abs() < 1e-10, "{new:?}");
        assert!((new.memory_bytes.expect("a law") as f64 / 8e6 - 1.0).abs() < 1e-6, "{new:?}");
        assert_eq!(fitted.of("d", "tet4", Some(8000)), Expected::default());
        assert_eq!(fitted.of("d", "tet10", None), Expected::default());
    }

    #[test]
    fn one_size_says_nothing_of_another() {
        let mut forecast = Forecast::default();
        [("a", 2.0), ("b", 3.0)].iter().for_each(|(id, s)| forecast.learn(&record(id, 1000, *s)));
        let fitted = forecast.fitted();
        assert_eq!(fitted.of("d", "tet10", Some(1001)).cost_s, Some(3.0));
        assert_eq!(fitted.of("d", "tet10", Some(2000)).cost_s, None);
    }
}
