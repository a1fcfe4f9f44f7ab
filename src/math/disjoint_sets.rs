//! Disjoint sets of numbers (union–find; Tarjan, J. ACM 22, 1975): numbers that occur in one list are in one set.

/// The numbers 0..n, each initially in a set of its own.
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    pub fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect() }
    }

    /// Merges all sets that contain a number of the list.
    pub fn join(&mut self, list: &[u32]) {
        for &member in list {
            let (a, b) = (self.first(list[0]), self.first(member));
            self.parent[a.max(b) as usize] = a.min(b);
        }
    }

    /// Returns the smallest number of the set that contains `k`.
    pub fn first(&mut self, mut k: u32) -> u32 {
        while self.parent[k as usize] != k {
            self.parent[k as usize] = self.parent[self.parent[k as usize] as usize];
            k = self.parent[k as usize];
        }
        k
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_with_a_common_number_are_one_set() {
        let mut sets = DisjointSets::new(7);
        [&[5, 3][..], &[1, 6], &[], &[2], &[6, 5]].iter().for_each(|list| sets.join(list));
        assert_eq!([0, 1, 2, 3, 4, 5, 6].map(|k| sets.first(k)), [0, 1, 2, 1, 4, 1, 1]);
    }
}
