//! One measurement in two files: they differ in bytes but hold the same numbers.

/// Relative difference of equal numbers in different units \[–\]
const ROUNDING: f64 = 1e-9;

/// Whether two lists of numbers hold one measurement, up to the rounding of units.
pub fn are_same_numbers(a: &[f64], b: &[f64]) -> bool {
    let is_same = |(a, b): (&f64, &f64)| (a - b).abs() <= ROUNDING * a.abs().max(b.abs());
    a.len() == b.len() && a.iter().zip(b).all(is_same)
}

/// Indices of the first two lists with the same numbers; empty lists do not count.
pub fn first_pair(lists: &[Vec<f64>]) -> Option<[usize; 2]> {
    let earlier = |k: usize| (0..k).find(|j| are_same_numbers(&lists[*j], &lists[k])).map(|j| [j, k]);
    (0..lists.len()).filter(|k| !lists[*k].is_empty()).find_map(earlier)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_spellings_do_not_make_another_measurement() {
        let kilopascals = [0.0, 1.25, 2.371, -0.004];
        let pascals = kilopascals.map(|p| p * 1e3);
        let megapascals = kilopascals.map(|p| p / 1e3);
        assert!(are_same_numbers(&pascals, &megapascals.map(|p| p * 1e6)));
        let last_digit = [0.0, 1250.0, 2372.0, -4.0];
        assert!(!are_same_numbers(&pascals, &last_digit) && !are_same_numbers(&pascals, &pascals[..3]));
        let lists = [last_digit.to_vec(), pascals.to_vec(), vec![], vec![], pascals.to_vec()];
        assert_eq!((first_pair(&lists), first_pair(&lists[..4])), (Some([1, 4]), None));
    }
}
