//! Fill-reducing elimination orders: approximate minimum degree (Amestoy, Davis & Duff 1996) and, for large graphs, nested dissection by METIS
//! (Karypis & Kumar 1998). The order with fewer operations, by a symbolic count, is used.
//!
//! Limits: METIS uses the random number generator of the C library, so that only one call runs at a time.

use super::sparse::SymPattern;
use super::threads;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::cholesky::simplicial::{
    prefactorize_symbolic_cholesky, prefactorize_symbolic_cholesky_scratch,
};
use faer::sparse::linalg::{amd, qr};
use std::sync::Mutex;

/// Number of vertices from which nested dissection is tried.
const LARGE: usize = 8_000;
/// Number of vertices from which minimum degree is no longer tried: it needed three to five times the operations there, and takes as long to compute.
const VERY_LARGE: usize = 100_000;

/// Fill-reducing order of a graph: `order[k]` is the vertex eliminated at step k.
pub fn fill_reducing(graph: &SymPattern) -> Vec<u32> {
    if graph.n < LARGE {
        return minimum_degree(graph);
    }
    if graph.n >= VERY_LARGE {
        return postorder(graph, &nested_dissection(graph));
    }
    let orders = threads::map(vec![minimum_degree, nested_dissection], |order| order(graph));
    let found = threads::map(orders.iter().collect(), |order| analyse(graph, order));
    let [by_degree, by_dissection] = [found[0].operations, found[1].operations];
    if by_degree <= by_dissection { orders[0].clone() } else { found[1].postordered(&orders[1]) }
}

/// Returns an approximate minimum degree order, postordered by the elimination tree that the algorithm has found.
pub fn minimum_degree(graph: &SymPattern) -> Vec<u32> {
    let n = graph.n;
    let (mut order, mut inverse) = (vec![0u32; n], vec![0u32; n]);
    let matrix = SymbolicSparseColMatRef::new_checked(n, n, &graph.col_ptr, None, &graph.row_idx);
    let mut memory = MemBuffer::new(amd::order_maybe_unsorted_scratch::<u32>(n, graph.nnz()));
    amd::order_maybe_unsorted(&mut order, &mut inverse, matrix, amd::Control::default(), MemStack::new(&mut memory))
        .expect("a graph of fewer than 2^31 edges can be ordered");
    order
}

/// Returns an order with the same fill in which every subtree of the elimination tree is contiguous.
pub fn postorder(graph: &SymPattern, order: &[u32]) -> Vec<u32> {
    analyse(graph, order).postordered(order)
}

/// Returns an order by nested dissection (METIS), not postordered.
fn nested_dissection(graph: &SymPattern) -> Vec<u32> {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let n = graph.n;
    let mut lists = vec![Vec::new(); n];
    for j in 0..n {
        for &i in &graph.row_idx[graph.col_ptr[j] as usize..graph.col_ptr[j + 1] as usize] {
            if i as usize != j {
                lists[j].push(i as i32);
                lists[i as usize].push(j as i32);
            }
        }
    }
    let mut first = vec![0i32];
    first.extend(lists.iter().scan(0, |end, list| {
        *end += list.len() as i32;
        Some(*end)
    }));
    let mut neighbours: Vec<i32> = lists.concat();
    let (mut order, mut inverse) = (vec![0i32; n], vec![0i32; n]);
    let _one = ONE_AT_A_TIME.lock().expect("METIS does not panic");
    let mut vertices = n as i32;
    // SAFETY: `first` has n + 1 entries, which are ascending offsets into `neighbours`; `order` and `inverse` have room for n. METIS
    // reads the first two, writes the last two, and keeps none of the pointers. Null means unit weights and default options.
    let status = unsafe {
        metis_sys::METIS_NodeND(
            &mut vertices,
            first.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            std::ptr::null_mut(),
            std::ptr::null_mut(),
            order.as_mut_ptr(),
            inverse.as_mut_ptr(),
        )
    };
    assert_eq!(status, metis_sys::rstatus_et_METIS_OK, "METIS orders a graph that is one");
    order.into_iter().map(|v| v as u32).collect()
}

/// The postorder of the elimination tree of an order, and the cost of the factorisation.
struct Analysis {
    /// The steps in an order that makes every subtree contiguous
    post: Vec<u32>,
    /// Σ of the squared lengths of the columns of the factor
    operations: f64,
}

impl Analysis {
    fn postordered(&self, order: &[u32]) -> Vec<u32> {
        self.post.iter().map(|&k| order[k as usize]).collect()
    }
}

fn analyse(graph: &SymPattern, order: &[u32]) -> Analysis {
    let n = graph.n;
    let mut step = vec![0u32; n];
    order.iter().enumerate().for_each(|(k, &v)| step[v as usize] = k as u32);
    let permuted = SymPattern::from_pairs(n, graph.entries().map(|(i, j)| (step[i], step[j])));
    let (col_ptr, row_idx) = permuted.upper();
    let matrix = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
    let (mut parents, mut lengths, mut post) = (vec![0i32; n], vec![0u32; n], vec![0u32; n]);
    let request = prefactorize_symbolic_cholesky_scratch::<u32>(n, row_idx.len()).or(qr::postorder_scratch::<u32>(n));
    let mut memory = MemBuffer::new(request);
    let stack = MemStack::new(&mut memory);
    let tree = prefactorize_symbolic_cholesky(&mut parents, &mut lengths, matrix, stack);
    qr::postorder(&mut post, tree, stack);
    let operations = lengths.iter().map(|&l| f64::from(l).powi(2)).sum();
    Analysis { post, operations }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube of n³ vertices with their neighbours along the axes.
    fn grid(n: u32) -> SymPattern {
        let at = |i: u32, j: u32, k: u32| (i * n + j) * n + k;
        let cells = (0..n).flat_map(move |i| (0..n).flat_map(move |j| (0..n).map(move |k| (i, j, k))));
        let pairs = cells.flat_map(|(i, j, k)| {
            let ahead = [(i + 1, j, k), (i, j + 1, k), (i, j, k + 1)].into_iter();
            let inside = ahead.filter(|&(a, b, c)| a < n && b < n && c < n);
            inside.map(|(a, b, c)| (at(i, j, k), at(a, b, c))).collect::<Vec<_>>()
        });
        SymPattern::from_pairs((n * n * n) as usize, pairs)
    }

    /// Elimination tree by its definition: the parent is the first step below the diagonal in the column of L, and inherits the rest of the column.
    fn parents(graph: &SymPattern, order: &[u32]) -> Vec<Option<usize>> {
        let mut step = vec![0; graph.n];
        order.iter().enumerate().for_each(|(k, &v)| step[v as usize] = k);
        let mut columns = vec![std::collections::BTreeSet::new(); graph.n];
        for j in 0..graph.n {
            for &i in &graph.row_idx[graph.col_ptr[j] as usize..graph.col_ptr[j + 1] as usize] {
                let (a, b) = (step[i as usize], step[j]);
                columns[a.min(b)].insert(a.max(b));
            }
        }
        let mut parents = vec![None; graph.n];
        for k in 0..graph.n {
            let below: Vec<usize> = columns[k].iter().copied().filter(|&i| i > k).collect();
            if let Some(&parent) = below.first() {
                columns[parent].extend(below);
                parents[k] = Some(parent);
            }
        }
        parents
    }

    fn check_permutation(graph: &SymPattern, order: &[u32]) {
        let mut sorted = order.to_vec();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..graph.n as u32));
    }

    /// Each step is preceded by all the steps of its subtree, without others in between.
    fn check_postorder(graph: &SymPattern, order: &[u32]) {
        let parents = parents(graph, order);
        let mut first: Vec<usize> = (0..graph.n).collect();
        for (k, parent) in parents.iter().enumerate() {
            if let Some(parent) = *parent {
                assert!(parent > k);
                first[parent] = first[parent].min(first[k]);
            }
        }
        for (k, first) in first.into_iter().enumerate() {
            assert!(parents[first..k].iter().all(|p| p.is_some_and(|p| p <= k)), "subtree of step {k}");
        }
    }

    #[test]
    fn orders_are_permutations_and_dissection_is_postordered() {
        for graph in [grid(5), grid(14)] {
            check_permutation(&graph, &minimum_degree(&graph));
            let order = nested_dissection(&graph);
            let order = analyse(&graph, &order).postordered(&order);
            check_permutation(&graph, &order);
            check_postorder(&graph, &order);
        }
    }

    /// On a cube of n³ vertices nested dissection has the best order, O(n⁶) operations (George 1973); it is chosen, and is the same when several
    /// threads ask at once.
    #[test]
    fn dissection_is_taken_where_it_is_better() {
        let graph = grid(24);
        let [by_degree, chosen] =
            [minimum_degree(&graph), fill_reducing(&graph)].map(|order| analyse(&graph, &order).operations);
        assert!(chosen < 0.8 * by_degree, "{chosen:e} against {by_degree:e}");
        let orders: Vec<Vec<u32>> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..3).map(|_| scope.spawn(|| fill_reducing(&graph))).collect();
            threads.into_iter().map(|t| t.join().expect("no panic")).collect()
        });
        assert!(orders.iter().all(|order| *order == orders[0]));
    }
}
