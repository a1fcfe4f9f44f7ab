//! Lists in messages.

use std::fmt::Display;

/// Entries of a list that a message shows.
const SHOWN: usize = 8;

/// The first entries of a list and the number of the others: "1, 2, 3 and 12 more".
pub(crate) fn first<T: Display>(items: &[T]) -> String {
    let shown: Vec<String> = items.iter().take(SHOWN).map(T::to_string).collect();
    match items.len() - shown.len() {
        0 => shown.join(", "),
        others => format!("{} and {others} more", shown.join(", ")),
    }
}

/// Numbers of lines: "line 4", or "lines 4, 7 and 9 more".
pub(crate) fn lines(numbers: &[u64]) -> String {
    format!("{} {}", if numbers.len() == 1 { "line" } else { "lines" }, first(numbers))
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
}
