//! Notes of the cases of a study. Notes that differ between cases only in numbers, such as the position of a mesh point, are merged into one note with
//! the ranges of these numbers.

use crate::study::store::record::StoredCase;

/// The notes of the cases, in the order of first appearance.
pub fn notes(stored: &[StoredCase]) -> Vec<String> {
    merged(stored.iter().map(|c| c.record.notes.as_slice()))
}

/// Notes with the same wording, and the range of each number in them.
struct Group<'a> {
    /// The texts around the numbers
    words: Vec<&'a str>,
    /// Number of preceding notes with this wording in the same case, which are about other things
    before: usize,
    /// The smallest and largest value of each number, as written
    ranges: Vec<[&'a str; 2]>,
}

impl<'a> Group<'a> {
    fn widen(&mut self, numbers: &[&'a str]) {
        for ([low, high], number) in self.ranges.iter_mut().zip(numbers) {
            if value(number) < value(low) {
                *low = number;
            }
            if value(number) > value(high) {
                *high = number;
            }
        }
    }

    fn text(&self) -> String {
        let number = |[low, high]: &[&str; 2]| if low == high { low.to_string() } else { format!("{low} to {high}") };
        let after = self.ranges.iter().zip(&self.words[1..]).map(|(range, words)| number(range) + words);
        self.words[0].to_string() + &after.collect::<String>()
    }
}

fn merged<'a>(cases: impl Iterator<Item = &'a [String]>) -> Vec<String> {
    let mut groups: Vec<Group> = vec![];
    for notes in cases {
        let mut own: Vec<Vec<&str>> = vec![];
        for note in notes {
            let (words, numbers) = parts(note);
            let before = own.iter().filter(|other| **other == words).count();
            own.push(words.clone());
            match groups.iter_mut().find(|g| g.before == before && g.words == words) {
                Some(group) => group.widen(&numbers),
                None => groups.push(Group { words, before, ranges: numbers.iter().map(|n| [*n; 2]).collect() }),
            }
        }
    }
    let mut out: Vec<String> = vec![];
    for text in groups.iter().map(Group::text) {
        if !out.contains(&text) {
            out.push(text);
        }
    }
    out
}

/// Splits a note into the texts around its numbers, and the numbers. Digits within names are text.
fn parts(note: &str) -> (Vec<&str>, Vec<&str>) {
    let is_of_name = |c: char| c.is_alphanumeric() || "_.+-−".contains(c);
    let (mut words, mut numbers, mut from, mut end) = (vec![], vec![], 0, 0);
    while let Some(more) = note[end..].find(is_of_name) {
        let start = end + more;
        end = note[start..].find(|c| !is_of_name(c)).map_or(note.len(), |length| start + length);
        let token = note[start..end].trim_end_matches('.');
        if value(token).is_some() {
            words.push(&note[from..start]);
            numbers.push(token);
            from = start + token.len();
        }
    }
    words.push(&note[from..]);
    (words, numbers)
}

/// The value of a number; `None` for a name.
fn value(token: &str) -> Option<f64> {
    let plain = token.replace('−', "-");
    let is_number = plain.trim_start_matches('-').starts_with(|c: char| c.is_ascii_digit());
    is_number.then(|| plain.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(cases: &[&[&str]]) -> Vec<String> {
        let cases: Vec<Vec<String>> =
            cases.iter().map(|notes| notes.iter().map(ToString::to_string).collect()).collect();
        merged(cases.iter().map(Vec::as_slice))
    }

    #[test]
    fn notes_that_differ_in_numbers_alone_are_one() {
        let cones = |z: &str| {
            format!("cavity is open: its volume counts from the cones between the rim and (0.0, −1.5, {z}) mm")
        };
        let [a, b, c] = ["3.8459", "3.6795", "3.8135"].map(cones);
        assert_eq!(of(&[&[&a], &[&b], &[&a], &[&c]]), [cones("3.6795 to 3.8459")]);
        assert_eq!(of(&[&["1 step(s) were cut", "a"], &["6 step(s) were cut"]]), ["1 to 6 step(s) were cut", "a"]);
        assert_eq!(of(&[&["least −2e-3."], &["least −4e-3."]]), ["least −4e-3 to −2e-3."]);
    }

    /// Two stages of one case are different things, and so are regions with other names.
    #[test]
    fn notes_of_other_things_stay_apart() {
        let stages: &[&str] = &["stage 1 is slow", "stage 2 is slow"];
        assert_eq!(of(&[stages, stages]), stages);
        let regions: &[&str] = &["tip2 is small", "tip3 is small", "ring-4 is small", "ring-5 is small"];
        assert_eq!(of(&[&regions[..2], &regions[1..]]), regions);
        assert_eq!(of(&[&["same 1", "same 1"]]), ["same 1"]);
    }
}
