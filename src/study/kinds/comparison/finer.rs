//! The mesh error of the differences between members, judged by their change on a finer mesh.

use crate::math::statistics::larger;
use crate::report::numbers::percent;
use crate::study::analysis::ByQuantity;
use crate::study::kinds::comparison::findings::{ComparisonFindings, MemberDifferences};
use crate::study::store::record::StudyRecord;
use crate::wording::{all, distinct, few};

/// A member in a variant, the latter by its label.
type Place<'a> = (&'a str, &'a str);

/// Members that are compared with a reference, per variant, split by whether they and the reference were run on a finer mesh.
struct Judged<'a> {
    with: Vec<Place<'a>>,
    without: Vec<Place<'a>>,
}

impl<'a> Judged<'a> {
    /// A member counts as judged if every one of its differences in the variant has a value on a finer mesh.
    fn of(quantities: impl Iterator<Item = &'a ByQuantity<MemberDifferences>>, reference: &str) -> Self {
        let (mut with, mut without) = (vec![], vec![]);
        let members = quantities.flat_map(|q| q.members.iter().map(move |c| (c, q.variant_label.as_str())));
        for (c, variant) in members.filter(|(c, _)| c.member != reference) {
            let list = if c.mesh_drift.is_some() { &mut with } else { &mut without };
            if !list.contains(&(c.member.as_str(), variant)) {
                list.push((c.member.as_str(), variant));
            }
        }
        with.retain(|place| !without.contains(place));
        Self { with, without }
    }

    fn of_study(a: &'a ComparisonFindings) -> Self {
        Self::of(a.quantities.iter(), &a.reference)
    }

    /// The members of `list`, with their variants if `other` has the same members in other variants.
    fn names(study: &StudyRecord, list: &[Place], other: &[Place]) -> String {
        let name = |member: &str| {
            let variants: Vec<&str> = list.iter().filter(|place| place.0 == member).map(|place| place.1).collect();
            let is_in_both = other.iter().any(|place| place.0 == member);
            let within = if is_in_both { format!(" ({})", all(&variants)) } else { String::new() };
            study.member(member) + &within
        };
        few(&distinct(list.iter().map(|place| place.0)).into_iter().map(name).collect::<Vec<_>>())
    }
}

/// Whether a finer mesh shows the effect of the mesh on a difference.
pub fn is_judged(q: &MemberDifferences, reference: &str) -> bool {
    q.members.iter().any(|c| c.member != reference && c.mesh_drift.is_some())
}

/// States the largest change of a difference on the finer mesh and the members it covers; `None` if no member was run on one.
pub fn sentence(study: &StudyRecord, q: &ByQuantity<MemberDifferences>, reference: &str) -> Option<String> {
    let others = q.members.iter().filter(|c| c.member != reference);
    let largest = percent(others.filter_map(|c| c.mesh_drift).reduce(larger)?);
    let Judged { with: members, without } = Judged::of(std::iter::once(q), reference);
    let plural = if members.len() == 1 { "" } else { "s" };
    let of = Judged::names(study, &members, &without);
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

/// A warning naming the members for which the mesh error of the differences is unknown.
pub fn warning(study: &StudyRecord, a: &ComparisonFindings) -> Option<String> {
    let Judged { with, without } = Judged::of_study(a);
    let remedy = "a family of role \"finer\" has the reference and the members on a finer mesh";
    match (with.len(), without.len()) {
        (_, 0) => None,
        (0, _) => Some(format!("The error of the mesh in the differences between members is unknown: {remedy}.")),
        _ => Some(format!(
            "The error of the mesh in the differences of {} is unknown: {remedy}.",
            Judged::names(study, &without, &with)
        )),
    }
}

/// States the error bars of the differences, for the methods section of a paper.
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
            Judged::names(study, &with, &without),
            Judged::names(study, &without, &with)
        ),
    }
}
