//! Sets of integers with fast ranks: one bit for each integer of the range, and running counts by words. A rank takes constant time, whereas a search
//! in a sorted list takes logarithmic time. Building takes time proportional to the number of integers plus 1/64 of the range, so that the range
//! should not be many times as large as the set.

/// Number of bits of a word.
const BITS: u32 = u64::BITS;

/// A set of integers within a range.
pub struct RankedSet {
    /// Smallest member, rounded down to a multiple of the bits of a word
    start: u32,
    words: Vec<u64>,
    /// \[words + 1\] number of members before each word
    before: Vec<u32>,
}

impl RankedSet {
    /// Builds the set of these integers, given in any order and possibly repeated.
    pub fn new(members: impl Iterator<Item = u32> + Clone) -> Self {
        let (Some(least), Some(largest)) = (members.clone().min(), members.clone().max()) else {
            return Self { start: 0, words: Vec::new(), before: vec![0] };
        };
        let start = least / BITS * BITS;
        let mut words = vec![0u64; ((largest - start) / BITS) as usize + 1];
        members.for_each(|m| words[((m - start) / BITS) as usize] |= 1 << (m % BITS));
        let mut before = Vec::with_capacity(words.len() + 1);
        before.push(0);
        words.iter().for_each(|word| before.push(before[before.len() - 1] + word.count_ones()));
        Self { start, words, before }
    }

    /// Number of members.
    pub fn count(&self) -> usize {
        self.before[self.words.len()] as usize
    }

    /// Number of members that are smaller than `member`, which has to be in the set.
    pub fn rank(&self, member: u32) -> usize {
        let at = ((member - self.start) / BITS) as usize;
        let smaller = self.words[at] & ((1 << (member % BITS)) - 1);
        (self.before[at] + smaller.count_ones()) as usize
    }

    /// All members, ascending.
    pub fn members(&self) -> Vec<u32> {
        let mut out = Vec::with_capacity(self.count());
        for (first, &word) in (self.start..).step_by(BITS as usize).zip(&self.words) {
            let mut left = word;
            while left != 0 {
                out.push(first + left.trailing_zeros());
                left &= left - 1;
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;

    /// Compared with binary search in a sorted list, for a range that begins and ends within a word.
    #[test]
    fn ranks_are_positions_in_the_sorted_list() {
        let mut random = SplitMix(3);
        for (least, spread, count) in [(0, 64, 5), (1000, 1, 3), (77, 10_000, 800), (63, 130, 400)] {
            let list: Vec<u32> = (0..count).map(|_| least + (random.unit() * f64::from(spread)) as u32).collect();
            let mut sorted = list.clone();
            sorted.sort_unstable();
            sorted.dedup();
            let set = RankedSet::new(list.iter().copied());
            assert_eq!((set.members(), set.count()), (sorted.clone(), sorted.len()));
            assert!(sorted.iter().enumerate().all(|(k, &member)| set.rank(member) == k));
        }
    }

    #[test]
    fn an_empty_set_has_no_members() {
        let set = RankedSet::new(std::iter::empty());
        assert_eq!((set.members(), set.count()), (vec![], 0));
    }
}
