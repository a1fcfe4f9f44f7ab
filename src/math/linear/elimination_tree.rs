//! The supernodes of a factor L as a tree, and its division into tasks for threads.
//!
//! A supernode is a range of columns of L with the same rows below them; its parent has the first of these rows among its columns. In a postorder
//! every subtree is contiguous. The elimination proceeds up the tree and the back-substitution down (Liu, SIAM Review 34, 1992): a supernode receives
//! only *messages* from its children, or from its parent, so that disjoint subtrees are independent.
//!
//! The tasks depend on operation counts, never on the number of threads, and messages are taken in the order of the children, so that the results are
//! bit-identical for any number of threads.

use crate::math::sparse::SymPattern;
use crate::math::threads;
use faer::Side;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use std::ops::Range;

/// Smallest share of all operations that is worth a task of its own.
const TASK_SHARE: f64 = 0.01;
/// Smallest number of operations that is worth a task of its own.
const TASK_LEAST: f64 = 1e6;

/// Consecutive columns of L with the same rows below them.
#[derive(Clone, Debug)]
pub(super) struct Supernode {
    pub columns: Range<usize>,
    /// Range of the rows below the columns, in [`EliminationTree::rows`]
    pub rows: Range<usize>,
    /// Range of its block of L, column after column: the rows of its own columns, then those below
    pub values: Range<usize>,
    /// Indices of the children, ascending
    pub children: Vec<usize>,
    /// First supernode of its subtree
    first: usize,
    /// Number of operations of its subtree
    operations: f64,
}

/// A subtree, and the parts of it that other threads may process.
#[derive(Clone, Debug)]
struct Task {
    supernodes: Range<usize>,
    /// Disjoint parts, ascending
    parts: Vec<Task>,
}

/// The elimination tree: its supernodes in postorder.
#[derive(Clone, Debug)]
pub(super) struct EliminationTree {
    pub supernodes: Vec<Supernode>,
    /// Rows below the columns of the supernodes, ascending within each
    pub rows: Vec<u32>,
    /// \[rows\] place of the row in the block of its parent: its columns come first, then the rows below them
    pub places: Vec<u32>,
    pub roots: Vec<usize>,
    all: Task,
}

impl EliminationTree {
    /// Builds the tree of a pattern whose columns are postordered; `None` if L has more entries than 32 bits can count.
    pub fn new(pattern: &SymPattern) -> Option<Self> {
        let n = pattern.n;
        let (col_ptr, row_idx) = pattern.upper();
        let matrix = SymbolicSparseColMatRef::new_checked(n, n, &col_ptr, None, &row_idx);
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(matrix, Side::Upper, SymmetricOrdering::Identity, params);
        let symbolic = symbolic.ok()?;
        let SymbolicCholeskyRaw::Supernodal(symbolic) = symbolic.raw() else {
            unreachable!("the supernodal path is forced");
        };
        let (begin, end) = (symbolic.supernode_begin(), symbolic.supernode_end());
        let (below, values) = (symbolic.col_ptr_for_row_idx(), symbolic.col_ptr_for_val());
        let range = |list: &[u32], s: usize| list[s] as usize..list[s + 1] as usize;
        let supernode = |s: usize| Supernode {
            columns: begin[s] as usize..end[s] as usize,
            rows: range(below, s),
            values: range(values, s),
            children: Vec::new(),
            first: s,
            operations: 0.0,
        };
        let supernodes = (0..symbolic.n_supernodes()).map(supernode).collect();
        let nothing = Task { supernodes: 0..0, parts: Vec::new() };
        let rows = symbolic.row_idx().to_vec();
        let mut tree = Self { supernodes, rows, places: Vec::new(), roots: Vec::new(), all: nothing };
        tree.connect(n);
        tree.divide();
        Some(tree)
    }

    /// Number of entries of L.
    pub fn nnz(&self) -> usize {
        self.supernodes.last().map_or(0, |s| s.values.end)
    }

    /// Number of additions and multiplications of one factorisation: the sum of the squared column lengths of L.
    pub fn operations(&self) -> f64 {
        self.roots.iter().map(|&root| self.supernodes[root].operations).sum()
    }

    /// Number of tasks that the tree is divided into.
    #[cfg(test)]
    pub fn tasks(&self) -> usize {
        fn count(task: &Task) -> usize {
            1 + task.parts.iter().map(count).sum::<usize>()
        }
        count(&self.all)
    }

    /// The largest total size of the messages that wait at the same time during an elimination on this number of threads \[entries\].
    pub fn waiting(&self, threads: usize) -> usize {
        self.waiting_in(&self.all, threads).0[threads]
    }

    /// \[threads + 1\] the largest total size of waiting messages within a task, for each number of threads, and the size of the messages that the
    /// task leaves.
    fn waiting_in(&self, task: &Task, threads: usize) -> (Vec<usize>, usize) {
        let of_parts: Vec<(Vec<usize>, usize)> = task.parts.iter().map(|part| self.waiting_in(part, threads)).collect();
        let left = of_parts.iter().map(|part| part.1).sum::<usize>();
        // Each thread is in one part, and the parts without a thread have left their messages
        let mut most = vec![left; threads + 1];
        for (in_part, of_part) in &of_parts {
            for all in (1..=threads).rev() {
                let with = |here: usize| most[all - here] + in_part[here] - of_part;
                most[all] = (1..=all).map(with).fold(most[all], usize::max);
            }
        }
        let (mut after, mut now) = (left, left);
        for s in task.between() {
            now += self.message(s);
            after = after.max(now);
            now -= self.supernodes[s].children.iter().map(|&child| self.message(child)).sum::<usize>();
        }
        (most.into_iter().map(|parts| parts.max(after)).collect(), now)
    }

    /// The largest total size of the messages that wait at the same time when one thread processes the supernodes in turn \[entries\].
    #[cfg(test)]
    pub fn waiting_in_turn(&self) -> usize {
        fn in_turn(task: &Task) -> Vec<usize> {
            task.parts.iter().flat_map(in_turn).chain(task.between()).collect()
        }
        let (mut most, mut now) = (0, 0);
        for s in in_turn(&self.all) {
            now += self.message(s);
            most = most.max(now);
            now -= self.supernodes[s].children.iter().map(|&child| self.message(child)).sum::<usize>();
        }
        most
    }

    /// Size of the message of a supernode \[entries\].
    fn message(&self, s: usize) -> usize {
        self.supernodes[s].rows.len().pow(2)
    }

    /// Sets the children, the operation counts, and the places of rows in the parents.
    fn connect(&mut self, n: usize) {
        let Self { supernodes, rows, places, roots, .. } = self;
        let mut owner = vec![0; n];
        for (s, supernode) in supernodes.iter().enumerate() {
            owner[supernode.columns.clone()].fill(s);
        }
        places.resize(rows.len(), 0);
        for s in 0..supernodes.len() {
            let Supernode { columns, rows: range, first, operations, .. } = supernodes[s].clone();
            let lengths = (range.len() + 1..=range.len() + columns.len()).map(|length| (length as f64).powi(2));
            let operations = operations + lengths.sum::<f64>();
            supernodes[s].operations = operations;
            let Some(&next) = rows[range.clone()].first() else {
                roots.push(s);
                continue;
            };
            let parent = &mut supernodes[owner[next as usize]];
            parent.children.push(s);
            parent.first = parent.first.min(first);
            parent.operations += operations;
            let (columns, above) = (&parent.columns, &rows[parent.rows.clone()]);
            let mut place = 0;
            for (to, &row) in places[range.clone()].iter_mut().zip(&rows[range]) {
                *to = if (row as usize) < columns.end {
                    row - columns.start as u32
                } else {
                    while above[place] < row {
                        place += 1;
                    }
                    (columns.len() + place) as u32
                };
            }
        }
    }

    fn divide(&mut self) {
        let worth = (TASK_SHARE * self.operations()).max(TASK_LEAST);
        let parts = self.parts(&self.roots, worth);
        self.all = Task { supernodes: 0..self.supernodes.len(), parts };
    }

    /// The subtrees of the supernodes `of` that are worth a task. If there is only one, its children are examined instead, and so on down the tree.
    fn parts(&self, of: &[usize], worth: f64) -> Vec<Task> {
        let mut of = of;
        loop {
            let large: Vec<usize> = of.iter().copied().filter(|&s| self.supernodes[s].operations > worth).collect();
            match large[..] {
                [] => return Vec::new(),
                [one] => of = &self.supernodes[one].children,
                _ => return large.into_iter().map(|s| self.task(s, worth)).collect(),
            }
        }
    }

    fn task(&self, root: usize, worth: f64) -> Task {
        let supernode = &self.supernodes[root];
        Task { supernodes: supernode.first..root + 1, parts: self.parts(&supernode.children, worth) }
    }

    /// Traverses the tree from the leaves to the roots: `visit` gets a supernode, its element of `data`, and the messages of its children, and
    /// returns its message to the parent. Returns the messages of the roots.
    pub fn up<D: Send, M: Send, E: Send>(
        &self,
        data: &mut [D],
        visit: &(impl Fn(&Supernode, &mut D, &[M]) -> Result<M, E> + Sync),
    ) -> Result<Vec<M>, E> {
        self.task_up(&self.all, data, visit)
    }

    fn task_up<D: Send, M: Send, E: Send>(
        &self,
        task: &Task,
        data: &mut [D],
        visit: &(impl Fn(&Supernode, &mut D, &[M]) -> Result<M, E> + Sync),
    ) -> Result<Vec<M>, E> {
        let Separated { mut between, of_parts } = task.separate(data);
        let pairs: Vec<_> = task.parts.iter().zip(of_parts).collect();
        let one = |(part, data): (&Task, &mut [D])| self.task_up(part, data, visit);
        let done: Result<Vec<Vec<M>>, E> = threads::map(pairs, one).into_iter().collect();
        let mut waiting = Vec::new();
        let mut done = done?.into_iter();
        for (first, own) in &mut between {
            for (supernode, data) in self.supernodes[*first..].iter().zip(own.iter_mut()) {
                let children = waiting.len() - supernode.children.len();
                let message = visit(supernode, data, &waiting[children..])?;
                waiting.truncate(children);
                waiting.push(message);
            }
            waiting.extend(done.next().into_iter().flatten());
        }
        Ok(waiting)
    }

    /// Traverses the tree from the roots to the leaves: `visit` gets a supernode, its element of `data`, and the message of its parent, or, for a
    /// root, its message in `waiting`; it pushes one message for each child, in the order of the children.
    pub fn down<D: Send, M: Send>(
        &self,
        data: &mut [D],
        waiting: Vec<M>,
        visit: &(impl Fn(&Supernode, &mut D, M, &mut Vec<M>) + Sync),
    ) {
        self.task_down(&self.all, data, waiting, visit);
    }

    fn task_down<D: Send, M: Send>(
        &self,
        task: &Task,
        data: &mut [D],
        mut waiting: Vec<M>,
        visit: &(impl Fn(&Supernode, &mut D, M, &mut Vec<M>) + Sync),
    ) {
        let Separated { mut between, of_parts } = task.separate(data);
        let mut messages = Vec::with_capacity(task.parts.len());
        for (gap, (first, own)) in between.iter_mut().enumerate().rev() {
            if gap < task.parts.len() {
                messages.push(waiting.pop().expect("the parent of a part has sent a message"));
            }
            for (supernode, data) in self.supernodes[*first..].iter().zip(own.iter_mut()).rev() {
                let message = waiting.pop().expect("a parent has sent a message, and a root has one");
                visit(supernode, data, message, &mut waiting);
            }
        }
        messages.reverse();
        let parts: Vec<_> = task.parts.iter().zip(of_parts).zip(messages).collect();
        threads::map(parts, |((part, data), message)| self.task_down(part, data, vec![message], visit));
    }
}

/// The data of the supernodes of a task.
struct Separated<'a, D> {
    /// The data before, between and after the parts of the task, each with the first supernode
    between: Vec<(usize, &'a mut [D])>,
    of_parts: Vec<&'a mut [D]>,
}

impl Task {
    /// The supernodes of the task that are in none of its parts.
    fn between(&self) -> impl Iterator<Item = usize> + '_ {
        self.supernodes.clone().filter(|s| !self.parts.iter().any(|part| part.supernodes.contains(s)))
    }

    /// Separates the data of the other supernodes of the task from those of its parts.
    fn separate<'a, D>(&self, mut data: &'a mut [D]) -> Separated<'a, D> {
        let (mut between, mut of_parts, mut next) = (Vec::new(), Vec::new(), self.supernodes.start);
        for part in &self.parts {
            let (before, rest) = data.split_at_mut(part.supernodes.start - next);
            let (own, rest) = rest.split_at_mut(part.supernodes.len());
            between.push((next, before));
            of_parts.push(own);
            (data, next) = (rest, part.supernodes.end);
        }
        between.push((next, data));
        Separated { between, of_parts }
    }
}
