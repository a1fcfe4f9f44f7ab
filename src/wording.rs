//! Lists, names and suggestions in messages.

use std::collections::{HashMap, HashSet};
use std::fmt::Display;

/// Number of entries of a list that [`first`] shows.
const SHOWN: usize = 8;
/// Number of entries of a list that [`few`] names.
pub const NAMED: usize = 3;
/// Lowest similarity at which a known word is suggested.
const LIKE: f64 = 0.7;
/// Lowest similarity at which a word counts as misspelt: one edit in four letters.
const MISSPELT: f64 = 0.75;

/// All entries, separated by commas: "1, 2, 3".
pub fn joined<T: Display>(items: &[T]) -> String {
    items.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}

/// All entries within a sentence: "a", "a and b", "a, b and c".
pub fn all<T: Display>(items: &[T]) -> String {
    match items {
        [] => String::new(),
        [one] => one.to_string(),
        [first @ .., last] => format!("{} and {last}", joined(first)),
    }
}

/// Alternatives within a sentence, the first three of many: "a", "a or b", "a, b, c or 2 more".
pub fn either<T: Display>(items: &[T]) -> String {
    match (items.len().saturating_sub(NAMED), items) {
        (0, [first @ .., last]) if !first.is_empty() => format!("{} or {last}", joined(first)),
        (0, _) => all(items),
        (others, _) => format!("{} or {others} more", joined(&items[..NAMED])),
    }
}

/// Distinct values in the order of their first appearance.
pub fn distinct<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    values.fold(vec![], |mut all, v| {
        if !all.contains(&v) {
            all.push(v);
        }
        all
    })
}

/// The names made unique: a name that has occurred before gets the next number, from 2 on, with which it equals no other name.
pub fn numbered(names: &[String], between: &str) -> Vec<String> {
    let mut taken: HashSet<String> = names.iter().cloned().collect();
    let mut last: HashMap<&String, usize> = HashMap::new();
    let mut found = vec![];
    for name in names {
        let number = last.entry(name).or_default();
        *number += 1;
        let mut own = name.clone();
        while *number > 1 {
            own = format!("{name}{between}{number}");
            if taken.insert(own.clone()) {
                break;
            }
            *number += 1;
        }
        found.push(own);
    }
    found
}

/// The first three entries within a sentence and the number of the others: "a, b, c and 2 more".
pub fn few<T: Display>(items: &[T]) -> String {
    match items.len().saturating_sub(NAMED) {
        0 => all(items),
        others => format!("{} and {others} more", joined(&items[..NAMED])),
    }
}

/// The first entries of a list and the number of the others: "1, 2, 3 and 12 more".
pub fn first<T: Display>(items: &[T]) -> String {
    match items.len().saturating_sub(SHOWN) {
        0 => joined(items),
        others => format!("{} and {others} more", joined(&items[..SHOWN])),
    }
}

/// A count with its noun: "1 marker", "3 markers".
pub fn count(n: usize, thing: &str) -> String {
    if n == 1 { format!("1 {thing}") } else { format!("{n} {thing}s") }
}

/// Line numbers in words: "line 4", "lines 4, 7", or the first of many and the number of the others.
pub fn lines(numbers: &[u64]) -> String {
    format!("{} {}", if numbers.len() == 1 { "line" } else { "lines" }, first(numbers))
}

/// The known word that is most similar to this one; `None` if no word is similar enough.
pub fn nearest<'a, T: AsRef<str>>(word: &str, known: &'a [T]) -> Option<&'a str> {
    let word = word.to_lowercase();
    let scored = known.iter().map(AsRef::as_ref).map(|k| (strsim::jaro_winkler(&word, &k.to_lowercase()), k));
    scored.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(likeness, _)| *likeness > LIKE).map(|(_, k)| k)
}

/// The known word that this one equals except for a few letters, capitals or hyphens.
pub fn misspelt<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let word = word.to_lowercase().replace(['-', ' '], "_");
    let is_like = |known: &&&str| strsim::normalized_damerau_levenshtein(&word, known) >= MISSPELT;
    known.iter().find(is_like).copied()
}

/// A suggestion with the list of known words: "did you mean `size`? (known: cells, size)".
pub fn hint<T: AsRef<str>>(word: &str, known: &[T]) -> String {
    let list = joined(&known.iter().map(AsRef::as_ref).collect::<Vec<&str>>());
    match nearest(word, known) {
        Some(near) => format!("did you mean `{near}`? (known: {list})"),
        None if known.is_empty() => "none is known".into(),
        None => format!("known: {list}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_end_with_the_number_of_the_others() {
        let numbers: Vec<u64> = (1..=20).collect();
        assert_eq!(lines(&numbers[..1]), "line 1");
        assert_eq!(lines(&numbers[..3]), "lines 1, 2, 3");
        assert_eq!(first(&numbers[..8]), "1, 2, 3, 4, 5, 6, 7, 8");
        assert_eq!(first(&numbers), "1, 2, 3, 4, 5, 6, 7, 8 and 12 more");
    }

    #[test]
    fn few_entries_are_named() {
        let named = |n: usize| few(&["a", "b", "c", "d", "e"][..n]);
        assert_eq!([0, 1, 2, 3, 5].map(named), ["", "a", "a and b", "a, b and c", "a, b, c and 2 more"]);
        assert_eq!(all(&["a", "b", "c", "d", "e"]), "a, b, c, d and e");
        let alternatives = |n: usize| either(&["a", "b", "c", "d", "e"][..n]);
        assert_eq!([0, 1, 2, 3, 5].map(alternatives), ["", "a", "a or b", "a, b or c", "a, b, c or 2 more"]);
        assert_eq!(distinct(["b", "a", "b"].into_iter()), ["b", "a"]);
    }

    #[test]
    fn a_repeated_name_has_a_number_that_makes_it_no_other_name() {
        let of = |names: &[&str]| numbered(&names.iter().map(ToString::to_string).collect::<Vec<_>>(), "-");
        assert_eq!(of(&["x", "y", "x", "x"]), ["x", "y", "x-2", "x-3"]);
        assert_eq!(of(&["x", "x", "x-2", "x-2"]), ["x", "x-3", "x-2", "x-2-2"]);
    }

    #[test]
    fn a_misspelt_word_is_told_from_another_one() {
        let known = ["gauge_length", "width", "area"];
        for (word, meant) in [("gage_length", 0), ("Gauge-Length", 0), ("widht", 1), ("Area", 2)] {
            assert_eq!(misspelt(word, &known), Some(known[meant]), "{word}");
        }
        for word in ["grip_length", "length", "weight", "shape", "date"] {
            assert_eq!(misspelt(word, &known), None, "{word}");
        }
    }

    #[test]
    fn the_nearest_word_is_suggested_and_no_far_one() {
        let known = ["cells", "size"];
        assert_eq!(hint("Cell", &known), "did you mean `cells`? (known: cells, size)");
        assert_eq!(hint("xyz", &known), "known: cells, size");
        assert_eq!(hint::<&str>("xyz", &[]), "none is known");
        assert_eq!(nearest("siez", &known), Some("size"));
        assert_eq!(nearest("palm", &["notches"]), None);
    }
}
