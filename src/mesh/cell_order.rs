//! Breadth-first order of the cells, in which consecutive cells share nodes.
//!
//! Nodes are numbered breadth-first from an end of the body (Cuthill & McKee, Proc. 24th Nat. Conf. ACM, 1969), cells by their nodes. Meshers number
//! cells in no spatial order, so that consecutive cells share few entries of K. The order depends only on the connectivity, so that it does not
//! change when a mesh is deformed.

use super::TetMesh;
use crate::math::sparse::accumulate;
use std::cmp::Reverse;

/// Returns the position of each cell in the order \[cells\].
pub fn cell_order(mesh: &TetMesh) -> Vec<u32> {
    let rank = ranks(mesh);
    let key = |c: u32| {
        let mut own: [u32; 4] = std::array::from_fn(|k| rank[mesh.cell(c as usize)[k] as usize]);
        own.sort_unstable();
        (own, c)
    };
    let mut order: Vec<u32> = (0..mesh.cell_count() as u32).collect();
    order.sort_by_cached_key(|&c| key(c));
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(k, &c)| place[c as usize] = k as u32);
    place
}

/// Returns the number of each corner \[nodes\] in a breadth-first search of every part of the mesh from one of its ends.
fn ranks(mesh: &TetMesh) -> Vec<u32> {
    let corners = |c: u32| &mesh.cell(c as usize)[..4];
    let mut offsets = vec![0_usize; mesh.points.len() + 1];
    for c in 0..mesh.cell_count() as u32 {
        corners(c).iter().for_each(|&n| offsets[n as usize + 1] += 1);
    }
    accumulate(&mut offsets);
    let (mut next, mut cells) = (offsets.clone(), vec![0_u32; offsets[mesh.points.len()]]);
    for c in 0..mesh.cell_count() as u32 {
        for &n in corners(c) {
            cells[next[n as usize]] = c;
            next[n as usize] += 1;
        }
    }
    let cells_of = |n: u32| &cells[offsets[n as usize]..offsets[n as usize + 1]];
    let search = |from: u32, rank: &mut [u32], first: u32| -> Vec<u32> {
        let mut found = vec![from];
        rank[from as usize] = first;
        let mut k = 0;
        while k < found.len() {
            for &c in cells_of(found[k]) {
                for &n in corners(c) {
                    if rank[n as usize] == UNKNOWN {
                        rank[n as usize] = first + found.len() as u32;
                        found.push(n);
                    }
                }
            }
            k += 1;
        }
        found
    };
    let (mut rank, mut first) = (vec![UNKNOWN; mesh.points.len()], 0);
    for start in 0..mesh.points.len() as u32 {
        if rank[start as usize] != UNKNOWN || cells_of(start).is_empty() {
            continue;
        }
        // The node found last is at an end, where a corner belongs to few cells.
        let part = search(start, &mut rank, first);
        let last = part[part.len() * 15 / 16..].iter().copied();
        let end = last.min_by_key(|&n| (cells_of(n).len(), Reverse(rank[n as usize]))).unwrap_or(start);
        part.iter().for_each(|&n| rank[n as usize] = UNKNOWN);
        first += search(end, &mut rank, first).len() as u32;
    }
    rank
}

const UNKNOWN: u32 = u32::MAX;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;
    use crate::mesh::Order;
    use crate::mesh::made::structured;
    use std::collections::BTreeSet;

    /// Number of pairs of corners in groups of 256 cells, per cell: 10 for a single cell.
    fn pairs(mesh: &TetMesh, order: &[u32]) -> f64 {
        let of_group = |group: &[u32]| {
            let pairs = group.iter().flat_map(|&c| {
                let nodes = &mesh.cell(c as usize)[..4];
                nodes.iter().flat_map(move |&a| nodes.iter().map(move |&b| (a.min(b), a.max(b))))
            });
            pairs.collect::<BTreeSet<_>>().len()
        };
        order.chunks(256).map(of_group).sum::<usize>() as f64 / order.len() as f64
    }

    #[test]
    fn cells_that_follow_each_other_have_nodes_in_common() {
        let mesh = structured::block(24, 6, 6, 4.0, 1.0, 1.0, Order::Linear);
        let mut random = SplitMix(3);
        let mut shuffled: Vec<u32> = (0..mesh.cell_count() as u32).collect();
        shuffled.sort_by_cached_key(|_| random.unit().to_bits());
        let place = cell_order(&mesh);
        let mut ordered = shuffled.clone();
        ordered.sort_by_key(|&c| place[c as usize]);
        let mut all = place.clone();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..mesh.cell_count() as u32), "a permutation");
        let (before, after) = (pairs(&mesh, &shuffled), pairs(&mesh, &ordered));
        assert!(before > 6.0 && after < 3.0, "{before:.1} pairs a cell in a random order, {after:.1} breadth-first");
    }
}
