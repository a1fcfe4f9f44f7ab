//! Cost of effects that are added one by one: a family whose changes add up (role `cumulative`).
//!
//! A member has the effects of the members before it and its own:
//!
//! ```text
//! cost of a step      T/n            T CPU seconds of the run, n its steps
//! added               T/n of the member less that of the one before: with all that follows (iterations, factorisations)
//! evaluation          t T/(W n)      t wall seconds in the evaluations of one effect, W those of the run
//! ```
//!
//! The factor T/W takes out, on average, what other programs on the machine took.

use crate::report::numbers::{digits, percent};
use crate::study::analysis::without_result;
use crate::study::curve::peak;
use crate::study::store::record::{CaseRecord, Role, StoredCase, StudyRecord};
use serde::Serialize;

/// The members of a variant in the order in which their effects are added.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Sequence {
    pub variant: String,
    /// The variant in words
    pub variant_label: String,
    pub additions: Vec<Addition>,
    pub sentence: String,
}

/// A scene with its effects, and what a step of it costs.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Addition {
    pub member: String,
    pub case: String,
    /// Effects and constraints that the member before has not
    pub new: Vec<String>,
    pub dofs: usize,
    pub steps: usize,
    /// Iterations, with those of refused steps
    pub newton_iterations: usize,
    /// T/n \[s\]
    pub step_s: f64,
    /// T/n less that of the member before \[s\]
    pub added_s: Option<f64>,
    /// \[effects and constraints\] name and time in its evaluations, of a step \[s\]
    pub evaluation_s: Vec<(String, f64)>,
    /// Factorisations of a step \[s\]
    pub factorisation_s: f64,
    /// Solutions with the factor of a step \[s\]
    pub solve_s: f64,
    /// \[quantities\] column, peak, and its change from the member before \[–\]
    pub quantities: Vec<(String, f64, Option<f64>)>,
}

impl Addition {
    /// Time in the evaluations of what this member adds, of a step \[s\].
    pub fn new_evaluation_s(&self) -> f64 {
        self.evaluation_s.iter().filter(|(name, _)| self.new.contains(name)).map(|e| e.1).sum()
    }
}

/// The sequence of every variant that has one; a member without a converged case is left out.
pub fn sequences(study: &StudyRecord, stored: &[StoredCase]) -> Vec<Sequence> {
    let of = |variant: &String| {
        let members = study.members_in(stored, Role::Cumulative, variant).into_iter();
        let own: Vec<(&str, &StoredCase)> =
            members.filter_map(|(member, case)| Some((member, case.filter(|c| c.record.steps > 0)?))).collect();
        let before = |k: usize| k.checked_sub(1).map(|before| own[before].1);
        let additions: Vec<Addition> = (0..own.len()).map(|k| addition(study, variant, own[k], before(k))).collect();
        let variant_label = study.label(variant);
        let sentence = sentence_of(study, &variant_label, &additions);
        Sequence { variant: variant.clone(), variant_label, additions, sentence }
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
    // Two cables are two entries: names may repeat
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

/// `1.3 ms`
pub fn milliseconds(s: f64) -> String {
    let ms = 1e3 * s;
    format!("{ms:.*} ms", digits(ms)).replace('-', "−")
}

fn sentence_of(study: &StudyRecord, label: &str, additions: &[Addition]) -> String {
    let [first, above @ ..] = additions else { return format!("{label}: no member has a converged case.") };
    let one = |r: &Addition| {
        let added = r.added_s.map_or(String::new(), |s| {
            let sign = if s < 0.0 { "−" } else { "+" };
            format!("{sign}{}", milliseconds(s.abs()))
        });
        format!("{} {added} (its evaluation {})", study.member(&r.member), milliseconds(r.new_evaluation_s()))
    };
    let list: Vec<String> = above.iter().map(one).collect();
    let start = format!("{label}: a step of {} takes {}", study.member(&first.member), milliseconds(first.step_s));
    if list.is_empty() { start + "." } else { format!("{start}; added one after the other, {}.", list.join(", ")) }
}

/// Share of every evaluation in a step with all effects.
pub fn verdict(sequences: &[Sequence], missing: usize) -> String {
    let mut parts = vec![];
    for sequence in sequences {
        let Some(top) = sequence.additions.last() else { continue };
        let mut all = top.evaluation_s.clone();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        let shares: Vec<String> = all.iter().map(|(n, s)| format!("{n} {}", percent(s / top.step_s))).collect();
        let factor = percent(top.factorisation_s / top.step_s);
        parts.push(format!(
            "With everything declared, {}, a step takes {}: {}, factorisations {factor}",
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
