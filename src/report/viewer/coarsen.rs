//! Simplifies a surface with very many facets by vertex clustering (Rossignac & Borrel 1993).

use crate::mesh::TetMesh;
use std::collections::{HashMap, HashSet};

/// Returns the facets that remain of `facets` if there are more than `most`, and their corners. The corners in one box of a regular grid are merged
/// into the node nearest to their mean; facets with two corners in one box vanish.
pub fn coarsen(mesh: &TetMesh, facets: Vec<u32>, most: usize) -> (Vec<u32>, Vec<[u32; 3]>) {
    let corners = |f: u32| -> [u32; 3] { std::array::from_fn(|k| mesh.facet(f as usize)[k]) };
    if facets.len() <= most {
        return (facets.clone(), facets.into_iter().map(corners).collect());
    }
    let (low, high) = mesh.bounding_box();
    let longest = (high - low).max();
    // The number of boxes on a surface grows with the square of their number along its longest side
    let mut divisions = (most as f64).sqrt();
    loop {
        let found = clustered(mesh, &facets, &corners, (low.into(), longest / divisions));
        if found.0.len() <= most || divisions < 2.0 {
            return found;
        }
        divisions *= 0.8;
    }
}

/// The facets whose corners are in three different boxes of this size, each triple once.
fn clustered(
    mesh: &TetMesh,
    facets: &[u32],
    corners: &impl Fn(u32) -> [u32; 3],
    (low, size): ([f64; 3], f64),
) -> (Vec<u32>, Vec<[u32; 3]>) {
    let key = |n: u32| -> [i64; 3] {
        let p = mesh.points[n as usize];
        std::array::from_fn(|i| ((p[i] - low[i]) / size).floor() as i64)
    };
    let mut means: HashMap<[i64; 3], ([f64; 3], f64)> = HashMap::new();
    let nodes: HashSet<u32> = facets.iter().flat_map(|&f| corners(f)).collect();
    let mut nodes: Vec<u32> = nodes.into_iter().collect();
    nodes.sort_unstable();
    for &n in &nodes {
        let (sum, count) = means.entry(key(n)).or_default();
        (0..3).for_each(|i| sum[i] += mesh.points[n as usize][i]);
        *count += 1.0;
    }
    let mut nearest: HashMap<[i64; 3], (f64, u32)> = HashMap::new();
    for &n in &nodes {
        let (sum, count) = means[&key(n)];
        let distance = (0..3).map(|i| (mesh.points[n as usize][i] - sum[i] / count).powi(2)).sum::<f64>();
        let best = nearest.entry(key(n)).or_insert((distance, n));
        if distance < best.0 {
            *best = (distance, n);
        }
    }
    let mut seen = HashSet::new();
    let is_new = |(_, c): &(u32, [u32; 3])| {
        let mut sorted = *c;
        sorted.sort_unstable();
        sorted[0] != sorted[1] && sorted[1] != sorted[2] && seen.insert(sorted)
    };
    facets.iter().map(|&f| (f, corners(f).map(|n| nearest[&key(n)].1))).filter(is_new).unzip()
}
