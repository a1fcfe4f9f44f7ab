//! Mark and colour of a family and of a formulation, the same in all figures of a report, and the entries of families in a legend.

use crate::report::canvas::{Mark, RGB};
use crate::report::figure::{Sample, family_label, style};
use crate::study::store::study_record::{FamilyRecord, Role};
use std::collections::BTreeSet;

/// A mark with its colour.
pub type Look = (Mark, RGB);

/// Returns the look of a family by its index in the study. Only filled marks are used: an open one is an alarm.
pub fn look(family: usize) -> Look {
    let marks = [Mark::Circle, Mark::Square, Mark::Triangle, Mark::Diamond, Mark::Down];
    (marks[family % marks.len()], style(family).1)
}

/// Returns legend entries for families given by their indices, each once and in the order of the study.
pub fn entries(families: &[FamilyRecord], shown: impl Iterator<Item = usize>) -> Vec<(Sample, String)> {
    let entry = |k: usize| {
        let ((mark, color), family) = (look(k), &families[k]);
        (Sample::Mark(mark, color), family_label(&family.name, &family.formulation))
    };
    shown.collect::<BTreeSet<usize>>().into_iter().map(entry).collect()
}

/// Returns the marks and colours of formulations: those of the first family of meshes of each formulation; a formulation without a family gets a look
/// that no family has.
pub fn looks(families: &[FamilyRecord], formulations: &[&str]) -> Vec<Look> {
    let is_of = |f: &FamilyRecord, formulation: &str| f.formulation == formulation && f.role != Role::TimeStep;
    let first = |formulation: &str| families.iter().position(|f| is_of(f, formulation));
    let number = |(k, formulation): (usize, &&str)| first(formulation).unwrap_or(families.len() + k);
    formulations.iter().enumerate().map(number).map(look).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_formulation_looks_like_its_first_family_of_meshes() {
        let family = |name: &str, role: Role, formulation: &str| {
            let (name, formulation) = (name.to_string(), formulation.to_string());
            FamilyRecord { name, role, formulation, cases: vec![], members: vec![] }
        };
        let families = [
            family("dt", Role::TimeStep, "tet4"),
            family("sizes", Role::Sizes, "tet4"),
            family("seeds", Role::Seeds, "tet4"),
            family("element", Role::Element, "tet10"),
        ];
        let shown = |(mark, color): Look| (std::mem::discriminant(&mark), color);
        let found = looks(&families, &["tet10", "tet4", "tet4_up"]).into_iter().map(shown);
        assert_eq!(found.collect::<Vec<_>>(), [look(3), look(1), look(6)].map(shown));
    }

    #[test]
    fn thirty_five_families_look_different() {
        let all = (0..35).map(look).map(|(mark, color)| format!("{:?} {color:?}", std::mem::discriminant(&mark)));
        assert_eq!(all.collect::<std::collections::BTreeSet<_>>().len(), 35);
    }
}
