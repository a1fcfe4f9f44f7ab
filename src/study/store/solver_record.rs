//! Work of the solver in a case, and where it stopped, as stored in its record and in `summary.json`.

use crate::math::signal::Clock;
use crate::math::tensor::Vec3;
use crate::scene::{
    LinearWork, Run, Scene, beyond_data_notes, friction_at_limit, growing_feedback, half_turns, lost_volumes,
    wrinkle_notes,
};
use crate::solve::{Status, TurningPoint};
use crate::study::store::collapse_record::CollapseRecord;
use crate::study::store::energy_record::EnergyRecord;
use crate::study::store::sunk_record::SunkenRecord;
use crate::wording::count;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Work of the solver in a case.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq, Default)]
pub struct SolverRecord {
    /// Steps whose tangent was shifted towards positive definiteness
    pub shifted_steps: usize,
    /// Steps that succeeded only with projected tangents
    pub projected_steps: usize,
    /// Dynamic steps that were solved, and repeated in parts because their time error was too large
    #[serde(default)]
    pub repeated_steps: usize,
    /// Dynamic steps with a time error above `time_error` that could not be cut any further
    #[serde(default)]
    pub coarse_steps: usize,
    /// Algebraic error: the largest estimated correction that an accepted state would still need, relative to its largest displacement; 0 if no step
    /// was judged by one
    #[serde(default)]
    pub algebraic_error: f64,
    /// Accepted steps that `algebraic_error` does not cover: arc length, contact corrections, linearised steps
    #[serde(default)]
    pub steps_without_algebraic_error: usize,
    /// Newton iterations in steps that were not accepted
    #[serde(default)]
    pub lost_iterations: usize,
    /// Factorisations of shifted tangents, in accepted and rejected steps
    #[serde(default)]
    pub shifted_factorisations: usize,
    /// Steps that ended at a state whose constrained tangent has negative eigenvalues
    pub unstable_steps: usize,
    /// Accepted states without a count of negative eigenvalues, whose stability is therefore unknown
    #[serde(default)]
    pub uncounted_steps: usize,
    /// How linear systems were solved
    #[serde(default)]
    pub linear: LinearRecord,
    /// A dynamic stage in which more than a tenth of the energy came from nothing
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub energy_from_nothing: Option<EnergyRecord>,
    /// Cavities whose walls have passed through each other
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub collapsed_cavities: Vec<CollapseRecord>,
    /// Contacts with facets that lie inside the obstacle between their contact points
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sunken_facets: Vec<SunkenRecord>,
    /// With arc length: states at which the loads were largest or smallest
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub turning_points: Vec<TurningRecord>,
    /// Where and why the run stopped, if its status is not `Converged`
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop: Option<StopRecord>,
}

/// The method by which linear systems were solved, and the reason.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq, Default)]
pub struct LinearRecord {
    /// `direct` or `iterative`
    pub path: String,
    /// Reason for this method, in words
    pub why: String,
    /// The last multigrid hierarchy; `None` on the direct path
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub multigrid: Option<MultigridRecord>,
}

/// The last hierarchy of the iterative path, and the work of the Krylov method with it.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct MultigridRecord {
    /// Number of levels, including the coarsest
    pub levels: usize,
    /// Entries of the matrices of all levels, relative to those of the finest
    pub operator_complexity: f64,
    /// Right-hand sides solved to full accuracy
    pub full_solves: usize,
    /// Iterations for these right-hand sides
    pub full_iterations: usize,
    /// Factorisations made because the Krylov method met negative curvature or was slow
    pub factorised: usize,
}

impl LinearRecord {
    fn new(run: &Run) -> Self {
        let LinearWork { why, hierarchy, gradients, fallbacks } = &run.linear;
        let multigrid = hierarchy.map(|size| MultigridRecord {
            levels: size.levels,
            operator_complexity: size.complexity,
            full_solves: gradients.solves,
            full_iterations: gradients.iterations,
            factorised: *fallbacks,
        });
        let path = if multigrid.is_some() { "iterative" } else { "direct" };
        Self { path: path.into(), why: why.clone(), multigrid }
    }
}

/// A state at which the loads on a path of equilibria have an extremum.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct TurningRecord {
    /// Time of the state \[s\]
    pub t_s: f64,
    /// Whether the loads are largest there; otherwise they are smallest
    pub highest: bool,
    /// Prescribed values at this state, by name with the unit
    pub signals: BTreeMap<String, f64>,
}

/// The location and the reason of the end of a run.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq, Default)]
pub struct StopRecord {
    /// Time of the last accepted state \[s\]
    pub t_s: f64,
    /// The fact, in words
    pub fact: String,
    /// The remedy, in words
    pub remedy: String,
    /// Name of the effect that caused it, if any
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effect: Option<String>,
    /// Index of the cell in the mesh
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<usize>,
    /// Index of the node in the mesh
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<u32>,
    /// Position of the cell or node at rest \[m\]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place_m: Option<[f64; 3]>,
    /// The largest loads on the path, by name with the unit
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub limit: BTreeMap<String, f64>,
}

impl SolverRecord {
    pub fn new(scene: &Scene, run: &Run) -> Self {
        let turning = |p: &TurningPoint| TurningRecord {
            t_s: p.t,
            highest: p.highest,
            signals: signals(scene, Clock { t: p.t, inputs: &p.inputs }),
        };
        Self {
            shifted_steps: run.totals.regularised,
            projected_steps: run.totals.projected,
            repeated_steps: run.totals.repeated,
            coarse_steps: run.totals.coarse,
            algebraic_error: run.totals.correction,
            steps_without_algebraic_error: run.totals.without_correction,
            lost_iterations: run.tried_iterations.saturating_sub(run.totals.iterations),
            shifted_factorisations: run.shifted_factorisations,
            unstable_steps: run.totals.unstable,
            uncounted_steps: run.totals.uncounted,
            energy_from_nothing: run.energy_from_nothing.map(|found| EnergyRecord::new(found, &scene.spans)),
            collapsed_cavities: run.collapsed.iter().map(Into::into).collect(),
            sunken_facets: run.sunken.iter().map(Into::into).collect(),
            linear: LinearRecord::new(run),
            turning_points: run.findings.turning_points.iter().map(turning).collect(),
            stop: stop(scene, run),
        }
    }
}

fn signals(scene: &Scene, now: Clock) -> BTreeMap<String, f64> {
    scene.signals.iter().map(|s| (s.name.clone(), s.signal.at(now))).collect()
}

/// The signals at the limit of the loads, with the inputs of the step that failed; empty if the run ended otherwise.
fn limit(scene: &Scene, run: &Run) -> BTreeMap<String, f64> {
    let at = |t| signals(scene, Clock { t, inputs: &run.last.inputs });
    run.status.limit().map(at).unwrap_or_default()
}

fn stop(scene: &Scene, run: &Run) -> Option<StopRecord> {
    let status = &run.status;
    let mesh = &scene.body.mesh;
    let culprit = status.culprit();
    let node = |k: &u32| mesh.points.get(*k as usize).copied();
    let middle = |c: usize| mesh.position(c, [0.25; 3]);
    let place: Option<Vec3> = culprit.cell.map(middle).or(culprit.node.as_ref().and_then(node));
    Some(StopRecord {
        t_s: status.t()?,
        fact: status.fact(),
        remedy: status.remedy().into(),
        effect: culprit.effect,
        cell: culprit.cell,
        node: culprit.node,
        place_m: place.map(Into::into),
        limit: limit(scene, run),
    })
}

/// Status with the loads of a limit point in numbers and the cables that pull; `None` if the status has no time.
pub fn detail(scene: &Scene, run: &Run) -> Option<String> {
    if let Some(why) = &run.failure {
        return Some(why.to_string());
    }
    let status = &run.status;
    status.t()?;
    let values: Vec<String> = limit(scene, run).iter().map(|(name, value)| format!("{name} = {value:.6e}")).collect();
    let stated = if values.is_empty() { String::new() } else { format!(" (largest loads: {})", values.join(", ")) };
    let pulling = run.pulling.as_ref().map_or(String::new(), |told| format!("; {told}"));
    Some(format!("{status}{stated}{pulling}"))
}

/// Strain of an elastic cable above which its tension depends on the definition of strain \[–\]: between ln(1 + ε) and ε + ½ε², with equal EA, tensions
/// differ from EA ε by ½ε, here a twentieth.
const LARGE_STRAIN: f64 = 0.1;

/// Notes on elastic cables whose strain becomes large.
fn stretched(scene: &Scene, run: &Run) -> Vec<String> {
    let cables = scene.cables.iter().filter(|cable| cable.softness > 0.0);
    let notes = cables.filter_map(|cable| {
        let columns = cable.tension_columns();
        let tensions = columns.iter().filter_map(|name| run.column(name));
        let rows = tensions.flat_map(|all| all.into_iter().enumerate());
        let (row, most) = rows.max_by(|a, b| a.1.total_cmp(&b.1))?;
        let strain = cable.softness * most;
        (strain > LARGE_STRAIN).then(|| {
            format!(
                "{} is stretched by {:.1} % at t = {:.6} s (T/EA): from {:.0} % on its tension depends by more than {:.0} % on how its strain is defined, and EA alone \
                 does not determine it",
                cable.name,
                100.0 * strain,
                run.rows[row][0],
                100.0 * LARGE_STRAIN,
                50.0 * LARGE_STRAIN
            )
        })
    });
    notes.collect()
}

/// Notes on a path that becomes unstable or ends. Elements with pressures may lose a stability that the body itself has.
fn lost_stability(scene: &Scene, run: &Run) -> Vec<String> {
    let has_pressures = scene.stressed.iter().any(|effect| !effect.displacement_only());
    let unstable = run.findings.unstable.first().map(|(t, modes)| {
        let end = if has_pressures { "" } else { ", and a real body takes another path" };
        format!(
            "from t = {t:.6} s on the equilibrium is unstable ({} of the tangent): a bifurcation or \
             a limit point was passed{end}",
            count(*modes, "negative eigenvalue")
        )
    });
    let ends = matches!(run.status, Status::NoEquilibrium { .. } | Status::LimitPoint { .. });
    let doubt = has_pressures && (ends || unstable.is_some());
    let confirm = doubt.then(|| {
        "elements with pressures (mixed, mean_dilatation) may lose their stability, under tension as under compression, where the body keeps it: confirm it by \
         formulation = \"displacement\" with mesh.element = \"tet10\""
            .to_string()
    });
    unstable.into_iter().chain(confirm).collect()
}

/// Notes on the path for the reader, in words.
pub fn notes(scene: &Scene, run: &Run) -> Vec<String> {
    let mut out = lost_stability(scene, run);
    out.extend(beyond_data_notes(scene, &run.peak.x));
    out.extend(wrinkle_notes(scene, &run.peak.x));
    out.extend(lost_volumes(scene, &run.peak.x).map(|lost| lost.note()));
    out.extend(half_turns(&scene.signals, &run.signals));
    out.extend(run.controllers.iter().skip(1).map(|c| {
        format!("from t = {} s on the controlled signals are set by another controller than before", c.from_t_s)
    }));
    if run.status != Status::Converged {
        out.extend(growing_feedback(&scene.signals, &run.signals));
        out.extend(friction_at_limit(scene, &run.last));
    }
    out.extend(stretched(scene, run));
    let linear = LinearRecord::new(run);
    if let Some(m) = linear.multigrid {
        let hierarchy = match m.levels {
            0 => "no matrix of the run was definite enough for one, and all were factorised".into(),
            levels => format!("{levels} levels, operator complexity {:.2}", m.operator_complexity),
        };
        out.push(format!(
            "linear systems were solved by a Krylov method with a multigrid hierarchy ({}): {hierarchy}",
            linear.why
        ));
    }
    if run.totals.uncounted > 0 {
        let n = run.totals.uncounted;
        out.push(format!(
            "whether the states of {n} step(s) are stable is not known: the iterative path counts no eigenvalues; linear = \"direct\" does"
        ));
    }
    if run.totals.coarse > 0 {
        let n = run.totals.coarse;
        out.push(format!(
            "{n} step(s) had a time error above time_error and could not be cut any more: shorten dt or raise `cuts`"
        ));
    }
    if run.totals.projected > 0 {
        let n = run.totals.projected;
        out.push(format!("{n} step(s) came through with projected tangents only: look whether the body snapped there"));
    }
    out
}
