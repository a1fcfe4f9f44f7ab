//! `summary.json`: what other programs read. Keys and units are a traits; see `docs/explanation/convergence.md`.

use crate::study::claim::Claim;
use crate::study::content::Content;
use crate::study::extension::Extension;
use crate::study::store::record::{LockingRecord, MeshRecord, ProbeRecord, StoredCase};
use crate::study::store::results::Results;
use crate::study::store::solver::SolverRecord;
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Summary {
    pub study: String,
    pub kind: String,
    pub question: String,
    pub tolerance: f64,
    pub cases: Vec<CaseSummary>,
    /// Part of the summary that depends on the kind of the study
    pub analysis: Map<String, Value>,
    /// Values with their error bars, where the kind of the study states some
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<Claim>,
    pub warnings: Vec<String>,
    pub verdict: String,
    /// The mesh that would support a verdict where there is none, as `run --extend` adds it
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extension: Option<Extension>,
    pub version: String,
}

#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CaseSummary {
    pub id: String,
    pub family: String,
    pub variant: String,
    pub mesh: MeshRecord,
    pub formulation: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    pub dt_s: f64,
    pub status: String,
    /// `pass`, `stopped`, `inaccurate` or `fail`, where cases are judged one by one
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outcome: Option<&'static str>,
    pub solver: SolverRecord,
    pub wall_s: f64,
    pub cpu_s: f64,
    pub shared: bool,
    pub steps: usize,
    pub newton_iterations: usize,
    pub dofs: usize,
    pub factor_nnz: usize,
    pub effects: Vec<String>,
    pub locking: Option<LockingRecord>,
    pub probes: BTreeMap<String, ProbeRecord>,
}

impl CaseSummary {
    fn new(c: &StoredCase, outcome: Option<&'static str>) -> Self {
        let r = c.record.clone();
        Self {
            id: r.id,
            family: r.family,
            variant: r.variant,
            mesh: r.mesh,
            formulation: r.formulation,
            law: r.law.map(|l| l.name),
            dt_s: r.dt_s,
            status: r.status,
            outcome,
            solver: r.solver,
            wall_s: r.wall_s,
            cpu_s: r.cpu_s,
            shared: r.shared,
            steps: r.steps,
            newton_iterations: r.newton_iterations,
            dofs: r.dofs,
            factor_nnz: r.factor_nnz,
            effects: r.effects.into_iter().map(|e| e.name).collect(),
            locking: r.locking,
            probes: r.probes,
        }
    }
}

impl Summary {
    /// Case id → outcome, where cases are judged one by one.
    pub fn outcomes(&self) -> BTreeMap<&str, &'static str> {
        self.cases.iter().filter_map(|c| Some((c.id.as_str(), c.outcome?))).collect()
    }
}

pub fn summarise(store: &Results, content: &Content) -> Summary {
    let study = &store.study;
    Summary {
        study: study.study.clone(),
        kind: study.kind.clone(),
        question: study.question.clone(),
        tolerance: study.tolerance,
        cases: (store.cases.iter()).map(|c| CaseSummary::new(c, content.outcomes.get(&c.record.id).copied())).collect(),
        analysis: content.analysis.clone(),
        claims: content.claims.clone(),
        warnings: content.warnings.clone(),
        verdict: content.verdict.clone(),
        extension: content.extension.clone(),
        version: study.version.clone(),
    }
}
