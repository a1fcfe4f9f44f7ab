//! Knowledge of the error of the mesh in the differences between members: what a finer mesh changes in them.

use crate::report::numbers::percent;
use crate::study::kinds::comparison::findings::{ComparisonFindings, MemberDifferences};
use crate::study::store::record::StudyRecord;
use crate::wording::few;

/// Members that are compared with a reference, by whether they and it were run on a finer mesh.
struct Judged<'a> {
    with: Vec<&'a str>,
    without: Vec<&'a str>,
}

impl<'a> Judged<'a> {
    /// A member counts as judged where a finer mesh says so of each of its differences.
    fn of(quantities: impl Iterator<Item = &'a MemberDifferences>, reference: &str) -> Self {
        let (mut with, mut without) = (vec![], vec![]);
        for c in quantities.flat_map(|q| &q.members).filter(|c| c.member != reference) {
            let list = if c.mesh_drift.is_some() { &mut with } else { &mut without };
            if !list.contains(&c.member.as_str()) {
                list.push(c.member.as_str());
            }
        }
        with.retain(|member| !without.contains(member));
        Self { with, without }
    }

    fn of_study(a: &'a ComparisonFindings) -> Self {
        Self::of(a.quantities.iter().map(|q| &q.found), &a.reference)
    }
}

fn names(study: &StudyRecord, members: &[&str]) -> String {
    few(&members.iter().map(|member| study.member(member)).collect::<Vec<_>>())
}

/// Whether a finer mesh tells what the mesh does to a difference.
pub fn is_judged(q: &MemberDifferences, reference: &str) -> bool {
    q.members.iter().any(|c| c.member != reference && c.mesh_drift.is_some())
}

/// The largest change of a difference on the finer mesh, and whose; `None` where no member was run on one.
pub fn sentence(study: &StudyRecord, q: &MemberDifferences, reference: &str) -> Option<String> {
    let others = q.members.iter().filter(|c| c.member != reference);
    let largest = percent(others.filter_map(|c| c.mesh_drift).reduce(f64::max)?);
    let Judged { with: members, without } = Judged::of(std::iter::once(q), reference);
    let plural = if members.len() == 1 { "" } else { "s" };
    let of = names(study, &members);
    Some(match without.len() {
        0 => format!("A finer mesh changes these differences by at most {largest}"),
        1 => format!(
            "A finer mesh changes the difference{plural} of {of} by at most {largest}; the other member has no result on one"
        ),
        others => format!(
            "A finer mesh changes the difference{plural} of {of} by at most {largest}; the other {others} members have no result on one"
        ),
    })
}

/// The members of whose differences the error of the mesh is unknown.
pub fn warning(study: &StudyRecord, a: &ComparisonFindings) -> Option<String> {
    let Judged { with, without } = Judged::of_study(a);
    let remedy = "a family of role \"finer\" has the reference and the members on a finer mesh";
    match (with.len(), without.len()) {
        (_, 0) => None,
        (0, _) => Some(format!("The error of the mesh in the differences between members is unknown: {remedy}.")),
        _ => Some(format!(
            "The error of the mesh in the differences of {} is unknown: {remedy}.",
            names(study, &without)
        )),
    }
}

/// The error bars of the differences, for the methods of a paper.
pub fn errors(study: &StudyRecord, a: &ComparisonFindings) -> String {
    let Judged { with, without } = Judged::of_study(a);
    if with.is_empty() {
        return "No error bar is computed: the error of the mesh in the differences between members is unknown without results on a finer mesh.".into();
    }
    let rule = "A difference between members counts where it is larger than its change from one mesh to the next finer one, which \
                measures the discretisation error that both do not share.";
    match without.is_empty() {
        true => rule.into(),
        false => format!(
            "{rule} This change is known of {}, and unknown of {}.",
            names(study, &with),
            names(study, &without)
        ),
    }
}
