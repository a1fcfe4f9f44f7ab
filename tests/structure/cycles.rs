//! Groups of files that use each other, directly or through others (Tarjan 1972).

use crate::names::Edge;

/// Strongly connected components with more than one file, by the indices of the files.
pub fn cycles(files: usize, edges: &[Edge]) -> Vec<Vec<usize>> {
    let mut next = vec![Vec::new(); files];
    for edge in edges {
        next[edge.from].push(edge.to);
    }
    let mut search = Search {
        next: &next,
        order: vec![None; files],
        low: vec![0; files],
        open: Vec::new(),
        count: 0,
        found: vec![],
    };
    for file in 0..files {
        if search.order[file].is_none() {
            search.visit(file);
        }
    }
    search.found
}

struct Search<'a> {
    next: &'a [Vec<usize>],
    order: Vec<Option<usize>>,
    low: Vec<usize>,
    open: Vec<usize>,
    count: usize,
    found: Vec<Vec<usize>>,
}

impl Search<'_> {
    fn visit(&mut self, file: usize) {
        let own = self.count;
        self.order[file] = Some(own);
        self.low[file] = own;
        self.count += 1;
        self.open.push(file);
        for &other in &self.next[file] {
            match self.order[other] {
                None => {
                    self.visit(other);
                    self.low[file] = self.low[file].min(self.low[other]);
                }
                Some(order) if self.open.contains(&other) => self.low[file] = self.low[file].min(order),
                Some(_) => {}
            }
        }
        if self.low[file] == own {
            let start = self.open.iter().position(|&f| f == file).expect("the file is open");
            let mut group = self.open.split_off(start);
            group.sort_unstable();
            if group.len() > 1 {
                self.found.push(group);
            }
        }
    }
}
