//! Expected time and memory of a case before it runs, from the stored results.
//!
//! ```text
//! cost = setup + steps × cost of a step,   steps = Σ over the stages of duration/dt, known before the run
//! ```
//!
//! The costs of setup and step of a case are those of its own last result, with any inputs and build, on a mesh with the same number of nodes. Without
//! such a result they follow from the power law of cost versus nodes ([`power_law`]) fitted to the results of its formulation or, if these all have one
//! size, from the largest of them. Cases that did not converge do not count: they ended early, or late. It is neglected that longer steps take more
//! iterations.
//!
//! ```text
//! step ∝ Nᑫ, 1 ≤ q ≤ 2;   setup ∝ Nᑫ, 0 ≤ q ≤ 2
//! memory = the larger of   c Nᑫ, 0 ≤ q ≤ 4/3, through all results   and   a + b N^4/3  through the smallest and the largest of them
//! ```
//!
//! The cost of a step grows at least like assembly, N, and at most like factorisation by nested dissection for a body in three dimensions, N², whose
//! factor has O(N^4/3) entries (Lipton, Rose & Tarjan, *SIAM J. Numer. Anal.* 16, 1979); flat bodies and the iterative method take less. The constant a
//! is the process itself, about 20 MB, which hides the growth for small cases. Sizes within a factor of two do not determine an exponent: a scatter of
//! a few per cent could give any value. Through their mean, the cost of a step is then assumed to grow with N^4/3, about what is measured for the
//! finger ([performance](../docs/performance.md)), setup with N, and memory from that of the process.

use crate::math::statistics::extent;
use crate::scene::SceneSpec;
use crate::study::estimate::power_law::power_law;
use crate::study::store::record::CaseRecord;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};

/// Relative difference below which two sizes are equal \[–\].
const ONE_SIZE: f64 = 0.01;

/// Exponent of the number of nodes with which the factor L of a body in three dimensions grows \[–\].
const OF_FACTOR: f64 = 4.0 / 3.0;

/// Smallest ratio of the largest to the smallest size that determines an exponent \[–\].
const TELLING: f64 = 2.0;

/// Memory of the process without a case \[B\].
const PROCESS: f64 = 2e7;

/// Possible range of the exponent of the number of nodes in a cost, and the exponent assumed if the sizes are too close to determine it.
struct Powers {
    possible: [f64; 2],
    assumed: f64,
}

const OF_SETUP: Powers = Powers { possible: [0.0, 2.0], assumed: 1.0 };
const OF_STEP: Powers = Powers { possible: [1.0, 2.0], assumed: 4.0 / 3.0 };
const OF_MEMORY: Powers = Powers { possible: [0.0, OF_FACTOR], assumed: 0.0 };

/// Costs of the stored results of a study.
#[derive(Default)]
pub struct Forecast {
    own: HashMap<String, Own>,
    /// Formulation → costs versus size
    by_size: BTreeMap<String, Points>,
}

/// Costs of a case: setup \[s\], one step \[s\], and memory \[bytes\].
type Known = [Option<f64>; 3];

/// Costs of the last result of a case.
struct Own {
    formulation: String,
    /// `None` for a mesh that was adapted in the run: its initial number of nodes is unknown
    nodes: Option<usize>,
    known: Known,
}

impl Own {
    /// Whether a case of this size matches the size of the result, as far as both are known.
    fn is_of(&self, size: &Size) -> bool {
        self.formulation == size.formulation && self.nodes.zip(size.nodes).is_none_or(|(own, now)| own == now)
    }
}

/// The three costs of several cases, each with the number of nodes.
type Points = [Vec<(f64, f64)>; 3];

/// Expected time and memory of a case, as far as they are known.
#[derive(Serialize, Clone, Copy, Debug, PartialEq, Default)]
pub struct Expected {
    /// Time on one core \[s\]
    pub cost_s: Option<f64>,
    pub memory_bytes: Option<u64>,
}

/// Size of a case as known before the run.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Size {
    pub formulation: String,
    /// Nodes of the mesh; `None` before it exists
    pub nodes: Option<usize>,
    /// Duration and time step of every stage \[s\]
    pub stages: Vec<[f64; 2]>,
}

impl Size {
    pub fn of(scene: &SceneSpec, nodes: Option<usize>) -> Self {
        let stages = scene.stages.iter().map(|stage| [stage.duration.0, stage.dt.0]).collect();
        Self { formulation: scene.formulation(), nodes, stages }
    }

    /// Number of time steps of the run if none is cut.
    fn steps(&self) -> f64 {
        steps(self.stages.iter().copied())
    }

    /// Number of time steps with the step sizes of a result, if it has the same number of stages.
    fn steps_of(&self, record: &CaseRecord) -> f64 {
        match record.stage_dt_s.len() == self.stages.len() {
            true => steps(self.stages.iter().zip(&record.stage_dt_s).map(|([duration, _], dt)| [*duration, *dt])),
            false => self.steps(),
        }
    }
}

fn steps(stages: impl Iterator<Item = [f64; 2]>) -> f64 {
    stages.map(|[duration, dt]| (duration / dt).max(1.0)).sum::<f64>().max(1.0)
}

impl Forecast {
    /// Includes a stored result of a case of this size.
    pub fn learn(&mut self, record: &CaseRecord, size: &Size) {
        if !record.converged() {
            return;
        }
        let step_s = record.cpu_s * record.repeats.len().max(1) as f64 / size.steps_of(record);
        let costs = [Some(record.phases.build_s), Some(step_s), record.work.memory_bytes.map(|bytes| bytes as f64)];
        let known = costs.map(|cost| cost.filter(|c| *c > 0.0));
        let nodes = record.refinement.is_empty().then_some(record.mesh.nodes);
        self.own.insert(record.id.clone(), Own { formulation: record.formulation.clone(), nodes, known });
        let (nodes, points) = (record.mesh.nodes as f64, self.by_size.entry(record.formulation.clone()).or_default());
        points.iter_mut().zip(known).for_each(|(points, cost)| points.extend(cost.map(|cost| (nodes, cost))));
    }

    /// Fits the power laws to the results learnt.
    pub fn fitted(&self) -> Fitted<'_> {
        let laws = |[setup, step, bytes]: &Points| [law(setup, &OF_SETUP), law(step, &OF_STEP), memory_law(bytes)];
        let laws = self.by_size.iter().map(|(name, points)| (name.as_str(), laws(points)));
        Fitted { own: &self.own, laws: laws.collect() }
    }
}

type Law = Box<dyn Fn(f64) -> Option<f64>>;

/// Costs of cases from their last results and the power laws.
pub struct Fitted<'a> {
    own: &'a HashMap<String, Own>,
    /// Formulation → costs versus nodes
    laws: BTreeMap<&'a str, [Law; 3]>,
}

impl Fitted<'_> {
    /// Returns the expected cost of a case.
    pub fn of(&self, id: &str, size: &Size) -> Expected {
        let own = self.own.get(id).filter(|own| own.is_of(size)).map_or_else(Known::default, |own| own.known);
        let by_size = |k: usize| self.laws.get(size.formulation.as_str()).and_then(|laws| laws[k](size.nodes? as f64));
        let [setup, step, bytes] = [0, 1, 2].map(|k| own[k].or_else(|| by_size(k)));
        // Records of earlier versions have no setup time
        let cost_s = step.map(|step| setup.unwrap_or(0.0) + step * size.steps());
        Expected { cost_s, memory_bytes: bytes.map(|b| b as u64) }
    }
}

fn law(points: &[(f64, f64)], powers: &Powers) -> Law {
    let [low, high] = extent(points.iter().map(|p| p.0));
    let largest = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let bounds = if high < TELLING * low { [powers.assumed; 2] } else { powers.possible };
    match power_law(points).map(|law| law.bounded(bounds)) {
        Some(law) if high > low * (1.0 + ONE_SIZE) => Box::new(move |nodes| Some(law.at(nodes))),
        _ => Box::new(move |nodes| (largest > 0.0 && (nodes / high - 1.0).abs() < ONE_SIZE).then_some(largest)),
    }
}

/// The power law, but at least the memory of the process plus a factor that grows from the smallest to the largest size, at which the largest observed
/// memory counts.
fn memory_law(points: &[(f64, f64)]) -> Law {
    let by_growth = law(points, &OF_MEMORY);
    let by_size = |a: &&(f64, f64), b: &&(f64, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
    let ends = points.iter().min_by(by_size).zip(points.iter().max_by(by_size));
    let Some((small, large)) = ends.filter(|(small, large)| large.0 > small.0 * (1.0 + ONE_SIZE)) else {
        return by_growth;
    };
    let most = points.iter().map(|p| p.1).fold(0.0, f64::max);
    let (start, least) = if large.0 < TELLING * small.0 { (0.0, most.min(PROCESS)) } else { *small };
    let [low, high] = [start, large.0].map(|n| n.powf(OF_FACTOR));
    let growth = (most - least).max(0.0) / (high - low);
    let with_process = move |nodes: f64| most + growth * (nodes.powf(OF_FACTOR) - high);
    Box::new(move |nodes| by_growth(nodes).map(|bytes| bytes.max(with_process(nodes))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Memory of a process of 20 MB with a factor of 2 MB at 1000 nodes.
    fn memory(nodes: usize) -> f64 {
        2e7 + 2e6 * (nodes as f64 / 1000.0).powf(4.0 / 3.0)
    }

    fn record(id: &str, nodes: usize, cpu_s: f64) -> CaseRecord {
        let mut record = CaseRecord { id: id.into(), formulation: "tet10".into(), cpu_s, ..CaseRecord::default() };
        record.status = "Converged".into();
        (record.mesh.nodes, record.work.memory_bytes) = (nodes, Some(memory(nodes) as u64));
        record
    }

    /// A case of one step.
    fn size(formulation: &str, nodes: Option<usize>) -> Size {
        Size { formulation: formulation.into(), nodes, stages: vec![[1.0, 1.0]] }
    }

    #[test]
    fn a_case_costs_as_its_last_result_or_by_the_growth_of_the_others() {
        let mut forecast = Forecast::default();
        for (id, nodes) in [("a", 1000), ("b", 2000), ("c", 4000)] {
            forecast.learn(&record(id, nodes, 1e-6 * (nodes as f64).powi(2)), &size("tet10", None));
        }
        let fitted = forecast.fitted();
        let own = Expected { cost_s: Some(4.0), memory_bytes: Some(memory(2000) as u64) };
        assert_eq!(fitted.of("b", &size("tet10", None)), own);
        let new = fitted.of("d", &size("tet10", Some(8000)));
        // Rounding of a few logarithms
        assert!((new.cost_s.expect("a law") / 64.0 - 1.0).abs() < 1e-10, "{new:?}");
        assert!((new.memory_bytes.expect("a law") as f64 / memory(8000) - 1.0).abs() < 1e-6, "{new:?}");
        assert_eq!(fitted.of("d", &size("tet4", Some(8000))), Expected::default());
        assert_eq!(fitted.of("d", &size("tet10", None)), Expected::default());
    }

    /// The mesh of `a` has become four times finer: its expected cost is that of another case of its new size.
    #[test]
    fn a_result_on_another_mesh_is_not_what_a_case_costs_now() {
        let mut forecast = Forecast::default();
        for (id, nodes) in [("a", 1000), ("b", 2000)] {
            forecast.learn(&record(id, nodes, 1e-3 * nodes as f64), &size("tet10", Some(nodes)));
        }
        let fitted = forecast.fitted();
        let [own, finer, other] =
            [("a", 1000), ("a", 4000), ("d", 4000)].map(|(id, n)| fitted.of(id, &size("tet10", Some(n))));
        assert_eq!(own, Expected { cost_s: Some(1.0), memory_bytes: Some(memory(1000) as u64) });
        assert!((finer.cost_s.expect("a law") / 4.0 - 1.0).abs() < 1e-10, "{finer:?}");
        assert_eq!(finer, other);
        assert_eq!(fitted.of("a", &size("tet4", Some(1000))), Expected::default());
    }

    /// A bar of tet10, as measured with the program in MiB: most of the memory of its three coarsest meshes is the process.
    #[test]
    fn no_less_memory_is_expected_than_large_cases_take() {
        let mut forecast = Forecast::default();
        let mut small = |id: &str, nodes: usize, mib: f64| {
            let mut record = record(id, nodes, 1.0);
            record.work.memory_bytes = Some((mib * f64::from(1 << 20)) as u64);
            forecast.learn(&record, &size("tet10", Some(nodes)));
        };
        [("a", 117, 21.6), ("b", 625, 26.4), ("c", 1813, 52.8)].iter().for_each(|(id, n, mib)| small(id, *n, *mib));
        let fitted = forecast.fitted();
        for (nodes, mib) in [(12_337, 351.5), (28_033, 998.6)] {
            let bytes = fitted.of("d", &size("tet10", Some(nodes))).memory_bytes.expect("a law") as f64;
            let ratio = bytes / (mib * f64::from(1 << 20));
            assert!((1.0..1.3).contains(&ratio), "{nodes} nodes: {ratio}");
        }
    }

    /// Seeds of one size, 825 and 850 nodes, whose costs scatter by 20 % and whose memory by 2 MB, in either direction. A case of 23 409 nodes is
    /// expected to take longer by the ratio of N^4/3, 83.3, and memory that grows in this way from the 20 MB of the process, but not less than
    /// observed.
    #[test]
    fn sizes_that_are_almost_one_show_no_power() {
        for [first, second] in [[0, 1], [1, 0]] {
            let mut forecast = Forecast::default();
            for (id, nodes, k) in [("a", 825, first), ("b", 850, second)] {
                let mut record = record(id, nodes, [1.0, 1.2][k]);
                (record.phases.build_s, record.work.memory_bytes) = ([0.1, 0.12][k], Some([24_000_000, 26_000_000][k]));
                forecast.learn(&record, &size("tet10", Some(nodes)));
            }
            let expected = forecast.fitted().of("c", &size("tet10", Some(23_409)));
            let [ratio, largest] = [825.0f64 * 850.0, 850.0 * 850.0].map(|squared| 23_409.0 / squared.sqrt());
            let cost = 1.2f64.sqrt() * (ratio.powf(4.0 / 3.0) + 0.1 * ratio);
            assert!((expected.cost_s.expect("a law") / cost - 1.0).abs() < 1e-12, "{expected:?}");
            let bytes = 2e7 + 6e6 * largest.powf(4.0 / 3.0);
            assert!((expected.memory_bytes.expect("a law") as f64 / bytes - 1.0).abs() < 1e-6, "{expected:?}");
        }
    }

    #[test]
    fn one_size_says_nothing_of_another() {
        let mut forecast = Forecast::default();
        [("a", 2.0), ("b", 3.0)].iter().for_each(|(id, s)| forecast.learn(&record(id, 1000, *s), &size("tet10", None)));
        let fitted = forecast.fitted();
        assert_eq!(fitted.of("d", &size("tet10", Some(1001))).cost_s, Some(3.0));
        assert_eq!(fitted.of("d", &size("tet10", Some(2000))).cost_s, None);
    }

    /// Stages of 1 s and 2 s in steps of 0.25 s are 12 steps; in steps of 0.025 s they are 120, for this case and for another one of its size, after a
    /// setup of 1 s.
    #[test]
    fn ten_times_the_steps_cost_ten_times_as_much_and_failures_say_nothing() {
        let in_steps = |dt: f64| Size { stages: vec![[1.0, dt], [2.0, dt]], ..size("tet10", Some(1000)) };
        let mut forecast = Forecast::default();
        let mut coarse = record("a", 1000, 2.4);
        (coarse.stage_dt_s, coarse.phases.build_s) = (vec![0.25; 2], 1.0);
        forecast.learn(&coarse, &in_steps(0.25));
        let mut failed = record("f", 1000, 900.0);
        failed.status = "StepTooSmall".into();
        forecast.learn(&failed, &in_steps(0.25));
        let fitted = forecast.fitted();
        for id in ["a", "d", "f"] {
            for (dt, seconds) in [(0.25, 3.4), (0.025, 25.0)] {
                let cost = fitted.of(id, &in_steps(dt)).cost_s.expect("a law");
                assert!((cost / seconds - 1.0).abs() < 1e-12, "{id} in steps of {dt} s: {cost} s");
            }
        }
    }
}
