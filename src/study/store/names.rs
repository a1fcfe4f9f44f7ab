//! Names in a folder of results: those of the files of a case, and those of folders.

use std::collections::BTreeSet;

/// Suffix of the file with the best values so far of a search that has no record yet.
pub const SEARCH: &str = "search.json";
/// Suffixes of the files of a case, `<id>.<suffix>`. The record is last, because it is written last.
pub const ENDS: [&str; 9] =
    ["csv", "fit.json", SEARCH, "sensitivities.csv", "skin.json", "skin.json.gz", PAGE, STATES, "json"];
/// Suffix of the page that shows the motion of a case.
pub const PAGE: &str = "view.html";
/// Suffix of the file with the states of a case.
pub const STATES: &str = "states.cbor";
/// Largest length of an id \[bytes\]: the names of its files and locks, including numbers and names of runs, then have at most 255 bytes, which all
/// common file systems support.
pub const MOST_BYTES: usize = 180;
/// Name of the folder that lists the cases whose results have other inputs than the study has now.
pub const OUTDATED: &str = "outdated";
/// Name of the folder with files that are about to be moved to their places.
pub const NEXT: &str = "next";

/// Whether this is the name of a file that is not yet completely written.
pub fn is_part(name: &str) -> bool {
    name.starts_with('.') && name.ends_with(".part")
}

/// Splits the name of a file of a case into id and suffix. `known` resolves names that fit several ids, such as `a.fit` with `json` and `a` with
/// `fit.json`.
pub fn parts_of<'a>(name: &'a str, known: &BTreeSet<&str>) -> Option<(&'a str, &'static str)> {
    let fits = |end: &'static str| Some((name.strip_suffix(end)?.strip_suffix('.')?, end));
    let mut all = ENDS.into_iter().filter_map(fits).filter(|(id, _)| !id.is_empty() && !id.starts_with('.'));
    let found: Vec<(&str, &str)> = all.by_ref().collect();
    let of_study = found.iter().find(|(id, _)| known.contains(id));
    of_study.or_else(|| found.iter().min_by_key(|(id, _)| id.len())).copied()
}

/// Whether the files of a case with this id could be mistaken for files of another case, such as those of `b.fit` and `b`.
pub fn is_ambiguous(id: &str) -> bool {
    let is_shorter = |name: &str| parts_of(name, &BTreeSet::new()).is_some_and(|(found, _)| found.len() < id.len());
    let is_set_aside = id.rsplit_once(".damaged-").is_some_and(|(_, n)| n.chars().all(|c| c.is_ascii_digit()));
    is_set_aside || is_shorter(id) || ENDS.iter().any(|end| is_shorter(&format!("{id}.{end}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_belongs_to_the_case_that_exists() {
        let none = BTreeSet::new();
        assert_eq!(parts_of("a-b-1.5.csv", &none), Some(("a-b-1.5", "csv")));
        assert_eq!(parts_of("a.skin.json.gz", &none), Some(("a", "skin.json.gz")));
        assert_eq!(parts_of("a.fit.json", &none), Some(("a", "fit.json")));
        assert_eq!(parts_of("a.view.html", &none), Some(("a", PAGE)));
        assert_eq!(parts_of("a.fit.json", &BTreeSet::from(["a.fit"])), Some(("a.fit", "json")));
        for id in ["b.fit", "b.search", "b.skin", "b.skin.json", "b.sensitivities", "b.csv", "b.json", "b.damaged-1"] {
            assert!(is_ambiguous(id), "{id}");
        }
        for id in ["b", "a-b-1.5", "b.view", "b.fitted", "skin", "b.damaged-x"] {
            assert!(!is_ambiguous(id), "{id}");
        }
        for other in ["notes.txt", ".x.part", "json", ".json", "a.json.damaged"] {
            assert_eq!(parts_of(other, &none), None, "{other}");
        }
    }

    #[test]
    fn the_names_of_all_files_of_a_case_are_short_enough() {
        let longest = ENDS.iter().map(|end| end.len()).max().expect("ends");
        let set_aside = ".damaged-1000000.".len() + longest;
        // A lock, its guard with the name of a run, and the guard of that guard
        let guards = ".json".len() + 2 * ".after-0123456789abcdef".len();
        assert!(MOST_BYTES + set_aside.max(guards) <= 255);
    }
}
