//! Groups (aggregates) of strongly coupled nodes, each of which becomes a node of the next level.
//!
//! ```text
//! i and j are strongly coupled where ‖A_ij‖² > θ² ‖A_ii‖ ‖A_jj‖
//! ```
//!
//! Source: Vaněk, Mandel & Brezina, Computing 56, 1996, algorithm 2: a node whose strong neighbours are all free forms a group with them; each
//! remaining node joins the group of its strongest neighbour, or forms a new group. Limits: the groups depend on the order of the nodes.

use super::blocks::{Block, BlockMatrix};

const FREE: u32 = u32::MAX;

/// Returns \[nodes\] the group of each node, and the number of groups.
pub fn aggregate<const B: usize>(a: &BlockMatrix<B, B>, theta: f64) -> (Vec<u32>, usize) {
    let size = |block: &Block<B, B>| block.iter().flatten().map(|v| v * v).sum::<f64>();
    let n = a.rows();
    let own: Vec<f64> = (0..n).map(|i| size(&a.values[a.diagonal(i)]).sqrt()).collect();
    let own = &own;
    let strong = move |i: usize| {
        a.row(i)
            .map(move |(j, block)| (j, size(block)))
            .filter(move |&(j, s)| j != i && s > theta * theta * own[i] * own[j])
    };
    let mut group = vec![FREE; n];
    let mut groups = 0;
    for i in 0..n {
        if group[i] == FREE && strong(i).all(|(j, _)| group[j] == FREE) {
            group[i] = groups;
            strong(i).for_each(|(j, _)| group[j] = groups);
            groups += 1;
        }
    }
    let first = group.clone();
    for i in (0..n).filter(|&i| first[i] == FREE) {
        let known = strong(i).filter(|&(j, _)| first[j] != FREE);
        if let Some((j, _)) = known.max_by(|a, b| a.1.total_cmp(&b.1)) {
            group[i] = first[j];
        }
    }
    for i in 0..n {
        if group[i] == FREE {
            group[i] = groups;
            strong(i).filter(|&(j, _)| group[j] == FREE).map(|(j, _)| j).collect::<Vec<_>>().into_iter().for_each(
                |j| {
                    group[j] = groups;
                },
            );
            groups += 1;
        }
    }
    (group, groups as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of nodes with couplings −1, and ε between its halves.
    fn chain(n: usize, weak: f64) -> BlockMatrix<1, 1> {
        let mut m = BlockMatrix { columns: n, row_ptr: vec![0], ..BlockMatrix::default() };
        let couple = |i: usize| if i == n / 2 { -weak } else { -1.0 };
        for i in 0..n {
            let entries =
                [(i.checked_sub(1), couple(i)), (Some(i), 2.0), (Some(i + 1).filter(|&j| j < n), couple(i + 1))];
            for (j, value) in entries.into_iter().filter_map(|(j, v)| Some((j?, v))) {
                m.col.push(j as u32);
                m.values.push([[value]]);
            }
            m.row_ptr.push(m.col.len() as u32);
        }
        m
    }

    /// Every node is in one group, groups consist of neighbours, about three each, and none extends over a weak coupling.
    #[test]
    fn groups_are_of_strong_neighbours() {
        let (group, groups) = aggregate(&chain(60, 1e-3), 0.08);
        assert!(group.iter().all(|&g| (g as usize) < groups));
        assert_eq!(groups, 20);
        assert!(group[..30].iter().all(|g| !group[30..].contains(g)));
        for g in 0..groups as u32 {
            let nodes: Vec<usize> = (0..60).filter(|&i| group[i] == g).collect();
            assert!((2..=5).contains(&nodes.len()) && nodes[nodes.len() - 1] - nodes[0] == nodes.len() - 1);
        }
    }
}
