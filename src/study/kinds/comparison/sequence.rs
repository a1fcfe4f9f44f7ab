//! Cost of effects that are added one by one: a family of cumulative changes (role `cumulative`).
//!
//! A member has its own effects and those of all members before it:
//!
//! ```text
//! cost of a step      T/n            T CPU seconds of the run, n its steps
//! added               T/n of the member minus T/n of the previous one, including all consequences (iterations, factorisations)
//! evaluation          t T/(W n)      t wall seconds in the evaluations of one effect, W those of the run
//! ```
//!
//! The factor T/W removes, on average, the time taken by other programs on the machine.
//!
//! A member without a result has no addition. Its effects are counted in the next member that has a result, which is compared with the last one
//! before both.

use crate::report::numbers::{digits, percent};
use crate::study::analysis::without_result;
use crate::study::curve::peak;
use crate::study::store::record::{CaseRecord, Role, StoredCase, StudyRecord};
use crate::wording::{all, few};
use serde::Serialize;

/// The members of a variant in the order in which their effects are added.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Sequence {
    pub variant: String,
    /// The variant in words
    pub variant_label: String,
    pub additions: Vec<Addition>,
    /// Members after the last addition, which have no result
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<String>,
    pub sentence: String,
}

/// A scene with its effects, and the cost of a step.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Addition {
    pub member: String,
    pub case: String,
    /// Members without a result between this addition and the previous one; their effects are included
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<String>,
    /// Effects and constraints that the previous addition lacks
    pub new: Vec<String>,
    pub dofs: usize,
    pub steps: usize,
    /// Iterations, including those of rejected steps
    pub newton_iterations: usize,
    /// CPU time per step, T/n \[s\]
    pub step_s: f64,
    /// CPU time per step minus that of the previous addition \[s\]
    pub added_s: Option<f64>,
    /// Name and evaluation time per step of each effect and constraint \[s\]
    pub evaluation_s: Vec<(String, f64)>,
    /// Time of factorisations per step \[s\]
    pub factorisation_s: f64,
    /// Time of solutions with the factor per step \[s\]
    pub solve_s: f64,
    /// Column, peak, and change of the peak from the previous addition \[–\], by quantity
    pub quantities: Vec<(String, f64, Option<f64>)>,
}

impl Sequence {
    /// All members without a result, in words.
    fn without_result(&self, study: &StudyRecord) -> Option<String> {
        let missing: Vec<String> =
            self.additions.iter().flat_map(|r| &r.with).chain(&self.missing).map(|m| study.member(m)).collect();
        (!missing.is_empty()).then(|| format!("no result with {}", few(&missing)))
    }

    /// How far the members have results: `everything declared`, or `all up to damping`.
    pub fn extent(&self, study: &StudyRecord) -> String {
        let last = self.additions.last().filter(|_| !self.missing.is_empty());
        last.map_or("everything declared".into(), |last| format!("all up to {}", study.member(&last.member)))
    }
}

impl Addition {
    /// Names the member, with the members without a result whose effects it also adds: `gravity with inertia`.
    pub fn words(&self, study: &StudyRecord) -> String {
        let with: Vec<String> = self.with.iter().map(|m| study.member(m)).collect();
        let own = study.member(&self.member);
        if with.is_empty() { own } else { format!("{own} with {}", all(&with)) }
    }

    /// Returns the evaluation time per step of the effects that this member adds \[s\].
    pub fn new_evaluation_s(&self) -> f64 {
        self.evaluation_s.iter().filter(|(name, _)| self.new.contains(name)).map(|e| e.1).sum()
    }
}

/// Returns the sequence of every variant; a member without a converged case has no addition.
pub fn sequences(study: &StudyRecord, stored: &[StoredCase]) -> Vec<Sequence> {
    let of = |variant: &String| {
        let (mut additions, mut missing) = (vec![], vec![]);
        let mut before = None;
        for (member, case) in study.members_in(stored, Role::Cumulative, variant) {
            let Some(case) = case.filter(|c| c.record.steps > 0) else {
                missing.push(member.to_string());
                continue;
            };
            let with = std::mem::take(&mut missing);
            additions.push(Addition { with, ..addition(study, variant, (member, case), before) });
            before = Some(case);
        }
        let (variant, variant_label) = (variant.clone(), study.label(variant));
        let sequence = Sequence { variant, variant_label, additions, missing, sentence: String::new() };
        Sequence { sentence: sentence_of(study, &sequence), ..sequence }
    };
    let any = study.families.iter().any(|f| f.role == Role::Cumulative);
    if any { study.variants.iter().map(of).collect() } else { vec![] }
}

fn addition(
    study: &StudyRecord,
    variant: &String,
    (member, case): (&str, &StoredCase),
    before: Option<&StoredCase>,
) -> Addition {
    let r = &case.record;
    let step_s = |r: &CaseRecord| r.cpu_s / r.steps as f64;
    let part_s = |s: f64| s * step_s(r) / r.wall_s;
    // Names may repeat, for example for two cables
    let mut old: Vec<&str> = before.iter().flat_map(|c| &c.record.effects).map(|e| e.name.as_str()).collect();
    let mut new = vec![];
    for e in &r.effects {
        match old.iter().position(|name| *name == e.name) {
            Some(k) => drop(old.swap_remove(k)),
            None => new.push(e.name.clone()),
        }
    }
    let quantities = (study.quantities.get(variant).into_iter().flatten())
        .filter_map(|q| {
            let value = peak(case, &q.name)?;
            let change = before.and_then(|c| peak(c, &q.name)).filter(|b| *b != 0.0).map(|b| (value - b) / b.abs());
            Some((q.name.clone(), value, change))
        })
        .collect();
    Addition {
        member: member.into(),
        case: r.id.clone(),
        with: vec![],
        new,
        dofs: r.dofs,
        steps: r.steps,
        newton_iterations: r.all_iterations(),
        step_s: step_s(r),
        added_s: before.map(|c| step_s(r) - step_s(&c.record)),
        evaluation_s: r.effects.iter().map(|e| (e.name.clone(), part_s(e.wall_s))).collect(),
        factorisation_s: part_s(r.phases.factorisation_s),
        solve_s: part_s(r.phases.solve_s),
        quantities,
    }
}

/// Formats a time as `1.3 ms`.
pub fn milliseconds(s: f64) -> String {
    let ms = 1e3 * s;
    format!("{ms:.*} ms", digits(ms)).replace('-', "−")
}

fn sentence_of(study: &StudyRecord, sequence: &Sequence) -> String {
    let label = &sequence.variant_label;
    let [first, above @ ..] = &sequence.additions[..] else {
        return format!("{label}: no member has a converged case.");
    };
    let one = |r: &Addition| {
        let added = r.added_s.map_or(String::new(), |s| {
            let sign = if s < 0.0 { "−" } else { "+" };
            format!("{sign}{}", milliseconds(s.abs()))
        });
        format!("{} {added} (its evaluation {})", r.words(study), milliseconds(r.new_evaluation_s()))
    };
    let list: Vec<String> = above.iter().map(one).collect();
    let mut words = format!("{label}: a step of {} takes {}", first.words(study), milliseconds(first.step_s));
    if !list.is_empty() {
        words += &format!("; added one after the other, {}", list.join(", "));
    }
    words.extend(sequence.without_result(study).map(|missing| format!("; {missing}")));
    words + "."
}

/// The share of each evaluation in a step with all effects, or with those up to the last member that has a result.
pub fn verdict(study: &StudyRecord, sequences: &[Sequence], missing: usize) -> String {
    let mut parts = vec![];
    for sequence in sequences {
        let Some(top) = sequence.additions.last() else { continue };
        let mut all = top.evaluation_s.clone();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        let shares: Vec<String> = all.iter().map(|(n, s)| format!("{n} {}", percent(s / top.step_s))).collect();
        let factor = percent(top.factorisation_s / top.step_s);
        let without = sequence.without_result(study).map_or(String::new(), |missing| format!(" ({missing})"));
        parts.push(format!(
            "With {}{without}, {}, a step takes {}: {}, factorisations {factor}",
            sequence.extent(study),
            sequence.variant_label,
            milliseconds(top.step_s),
            shares.join(", ")
        ));
    }
    if parts.is_empty() {
        return "No verdict: no case converged.".into();
    }
    parts.join(". ") + "." + &without_result(missing)
}
