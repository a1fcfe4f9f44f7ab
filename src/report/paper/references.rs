//! Publications that a methods paragraph cites, from `references.bib`.

use std::sync::OnceLock;

static FILE: &str = include_str!("references.bib");

/// A publication.
#[derive(Debug, PartialEq, Eq)]
pub struct Reference {
    /// Key of its BibTeX entry
    pub key: &'static str,
    /// Short form used by sources in the program: `Bonet & Wood 2008`
    pub short: &'static str,
    /// The BibTeX entry without the short form
    pub entry: String,
}

impl Reference {
    /// Returns all publications by their keys.
    pub fn all() -> &'static [Self] {
        static ALL: OnceLock<Vec<Reference>> = OnceLock::new();
        ALL.get_or_init(|| FILE.split("\n\n").filter_map(Self::read).collect())
    }

    fn read(entry: &'static str) -> Option<Self> {
        let key = entry.split_once('{')?.1.split_once(',')?.0;
        let line = entry.lines().find(|line| line.trim_start().starts_with("shorthand = {"))?;
        let short = line.split_once('{')?.1.strip_suffix("},")?;
        let entry: String = entry.lines().filter(|l| *l != line).map(|l| format!("{l}\n")).collect();
        Some(Self { key, short, entry })
    }

    pub fn of_key(key: &str) -> Option<&'static Self> {
        Self::all().iter().find(|r| r.key == key)
    }

    /// Returns the publications that a source names by author and year: `Yeoh 1993; modified invariant: Holzapfel 2000, ch. 6`.
    pub fn named_in(source: &str) -> Vec<&'static Self> {
        Self::all().iter().filter(|r| source.contains(r.short)).collect()
    }
}

/// Returns the reference under which the program itself is cited; its entry contains the version of the results.
pub fn program() -> &'static Reference {
    static PROGRAM: Reference = Reference { key: "durometer", short: "", entry: String::new() };
    &PROGRAM
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::LAWS;

    #[test]
    fn every_source_of_a_law_is_a_reference() {
        for law in LAWS {
            let info = law.info;
            let years = info.source.split(|c: char| !c.is_ascii_digit()).filter(|d| d.len() == 4).count();
            let found = Reference::named_in(info.source);
            // A manual has no year
            assert!(found.len() == years, "{}: {} has {years} years and {found:?}", info.name, info.source);
        }
    }

    #[test]
    fn entries_are_complete_and_sorted() {
        let all = Reference::all();
        assert_eq!(all.len(), FILE.matches("\n@").count() + 1);
        assert!(all.windows(2).all(|w| w[0].key < w[1].key));
        for r in all {
            assert!(
                r.entry.ends_with("}\n") && r.entry.contains("year = {") && !r.entry.contains("shorthand"),
                "{r:?}"
            );
            assert_eq!(r.entry.matches('{').count(), r.entry.matches('}').count(), "{}", r.key);
            assert!(r.entry.is_ascii(), "{}: BibTeX reads ASCII only", r.key);
        }
    }
}
