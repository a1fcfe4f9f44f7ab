//! `summary.json`: the results for other programs, so that its keys and units do not change; see `docs/explanation/convergence.md`.

use crate::study::case_outcome::CaseOutcome;
use crate::study::claim::Claim;
use crate::study::content::Content;
use crate::study::extension::Extension;
use crate::study::store::record::{CaseRecord, LockingRecord, MeshRecord, ProbeRecord, StoredCase};
use crate::study::store::results::Results;
use crate::study::store::solver_record::SolverRecord;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// The result of a study for other programs.
#[derive(Serialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct Summary {
    /// Name of the study
    pub study: String,
    /// Kind of the study
    pub kind: String,
    /// The question that the study answers
    pub question: String,
    /// Largest accepted error bar, relative to the value \[–\]
    pub tolerance: f64,
    /// Cases in the order of the study
    pub cases: Vec<CaseSummary>,
    /// Part of the summary that depends on the kind of the study
    pub analysis: Map<String, Value>,
    /// Values with their error bars, if the kind of the study states any
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<Claim>,
    /// Limits on how the numbers may be used, in words
    pub warnings: Vec<String>,
    /// The recommendation, or the reasons why the data support none
    pub verdict: String,
    /// Whether the data support a verdict; absent in results of earlier versions
    #[serde(skip_serializing_if = "Option::is_none")]
    pub supported: Option<bool>,
    /// Decisions of the study, by name, that depend only on results and not on costs: whether a member can replace the reference, whether a measured
    /// value is inside its interval, the outcome of a case; absent in results of earlier versions
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decisions: Option<BTreeMap<String, String>>,
    /// Stored files that are missing or differ from those that were stored, as sentences; a case does not count if its numbers are in such a file
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub damaged: Vec<String>,
    /// Cases that do not count because their stored results have other inputs than the study has now
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outdated: Vec<String>,
    /// The mesh that would support a verdict if there is none, as `run --extend` adds it
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extension: Option<Extension>,
    /// Why the study has no result although its cases have; absent if it has one
    #[serde(skip_serializing_if = "Option::is_none")]
    pub without_result: Option<String>,
    /// Why the verdict is not that of the present study: a run has found other inputs and did not complete; absent in a summary that has just been
    /// written
    #[serde(skip_serializing_if = "Option::is_none")]
    pub superseded: Option<String>,
    /// Version of the program
    pub version: String,
}

/// One case
#[derive(Serialize, JsonSchema, Clone, Debug, PartialEq)]
pub struct CaseSummary {
    /// Name of the case, `<family>-<variant>-<member>`
    pub id: String,
    /// Family of the case
    pub family: String,
    /// Variant of the case
    pub variant: String,
    /// Mesh of the case
    pub mesh: MeshRecord,
    /// Element and formulation, or `mass_spring`
    pub formulation: String,
    /// Name of the law; absent if springs are the only elastic part
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// Largest time step \[s\]
    pub dt_s: f64,
    /// End of the run: `Converged`, or the reason why it stopped
    pub status: String,
    /// `pass`, `unchecked`, `demanded`, `stopped`, `inaccurate` or `fail`, if cases are judged individually
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<String>")]
    pub outcome: Option<CaseOutcome>,
    /// Work of the solver
    pub solver: SolverRecord,
    /// Wall time of the solution \[s\]
    pub wall_s: f64,
    /// CPU time of the solution \[s\]
    pub cpu_s: f64,
    /// Whether another case ran at the same time, so that `wall_s` is not a measure of the cost
    pub shared: bool,
    /// Number of accepted steps
    pub steps: usize,
    /// Newton iterations in all steps
    pub newton_iterations: usize,
    /// Free degrees of freedom
    pub dofs: usize,
    /// Number of entries of the Cholesky factor
    pub factor_nnz: usize,
    /// Names of the assembled effects and constraints
    pub effects: Vec<String>,
    /// Signs of volumetric locking; absent if nothing moved
    pub locking: Option<LockingRecord>,
    /// Digest of the record of the case from which the summary was made; absent in results of earlier versions
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(default)]
    pub record_sha256: String,
    /// Peak and last value of every recorded column
    pub probes: BTreeMap<String, ProbeRecord>,
    /// Value of each quantity by which the study judges the case: its peak, its largest change if it does not start at zero, or its last value
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub judged: BTreeMap<String, f64>,
}

impl CaseSummary {
    fn new(c: &StoredCase, outcome: Option<CaseOutcome>, judged: BTreeMap<String, f64>) -> Self {
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
            record_sha256: r.provenance.record_sha256,
            probes: r.probes,
            judged,
        }
    }
}

impl Summary {
    /// The cases of a run that failed, or that crashed, in which case an earlier result may have been kept. If the study judges its cases individually,
    /// a status other than `Converged` may be the right outcome of a case.
    pub fn failed<'a>(&self, records: &'a [CaseRecord]) -> Vec<&'a CaseRecord> {
        let judged = self.cases.iter().filter_map(|c| Some((c.id.as_str(), c.outcome?)));
        let outcomes: BTreeMap<&str, CaseOutcome> = judged.collect();
        let has_failed = |r: &&CaseRecord| match outcomes.get(r.id.as_str()) {
            _ if r.broke() => true,
            Some(outcome) => *outcome == CaseOutcome::Fail,
            None => !r.converged(),
        };
        records.iter().filter(has_failed).collect()
    }

    /// The parts of the study that a run with these records has left incomplete: cases that failed, cases whose results differ from those in the
    /// summary, and a missing result of the study. Damaged stored files are listed in `damaged`.
    pub fn incomplete(&self, records: &[CaseRecord]) -> Vec<String> {
        let failed = self.failed(records).into_iter().map(CaseRecord::end);
        let other =
            |r: &CaseRecord| format!("{}: the report is not made of the result of this run; run the study again", r.id);
        failed.chain(self.others(records).into_iter().map(other)).chain(self.without_result.clone()).collect()
    }

    /// The cases of a run that did not crash and whose results are not those from which the summary was made.
    fn others<'a>(&self, records: &'a [CaseRecord]) -> Vec<&'a CaseRecord> {
        let used: BTreeMap<&str, &str> = self.cases.iter().map(|c| (c.id.as_str(), c.record_sha256.as_str())).collect();
        let is_other = |r: &&CaseRecord| {
            !r.broke() && used.get(r.id.as_str()).is_none_or(|digest| *digest != r.provenance.record_sha256)
        };
        records.iter().filter(is_other).collect()
    }
}

/// Builds the summary of results; `judged` holds the values by which the cases are judged, in the same order.
pub fn summarise(store: &Results, content: &Content, judged: Vec<BTreeMap<String, f64>>) -> Summary {
    let study = &store.study;
    let case = |(c, judged): (&StoredCase, _)| CaseSummary::new(c, content.outcomes.get(&c.record.id).copied(), judged);
    Summary {
        study: study.study.clone(),
        kind: study.kind.clone(),
        question: study.question.clone(),
        tolerance: study.tolerance,
        cases: store.cases.iter().zip(judged).map(case).collect(),
        analysis: content.analysis.clone(),
        claims: content.claims.clone(),
        warnings: content.warnings.clone(),
        verdict: content.verdict.clone(),
        supported: Some(content.supported),
        decisions: Some(content.decisions.clone()),
        damaged: store.damaged.clone(),
        outdated: store.outdated.clone(),
        extension: content.extension.clone(),
        without_result: content.without_result.clone(),
        superseded: None,
        version: study.version.clone(),
    }
}
