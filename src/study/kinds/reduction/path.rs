//! Points in the ranges of the inputs, and the order in which runs go through them.

use crate::math::random::SplitMix;

/// Shares of the ranges: a grid from end to end for one input; for several the corners and a Latin hypercube.
pub fn spread(inputs: usize, points: usize, seed: u64) -> Vec<Vec<f64>> {
    if inputs == 1 {
        return grid(1, points);
    }
    let corners = if inputs < 8 && CORNERS << inputs <= points { 1_usize << inputs } else { 0 };
    let corner = |c: usize| (0..inputs).map(|k| (c >> k & 1) as f64).collect();
    let mut out: Vec<Vec<f64>> = (0..corners).map(corner).collect();
    out.extend(hypercube(inputs, points - corners, seed));
    out
}

/// Every combination of `each` shares of each range, from end to end.
pub fn grid(inputs: usize, each: usize) -> Vec<Vec<f64>> {
    let value = |k: usize| k as f64 / (each - 1).max(1) as f64;
    let point = |n: usize| (0..inputs).map(|k| value(n / each.pow(k as u32) % each)).collect();
    (0..each.pow(inputs as u32)).map(point).collect()
}

/// A Latin hypercube: one point in each of as many strata of every input (McKay, Beckman & Conover, *Technometrics* 21, 1979).
pub fn hypercube(inputs: usize, points: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = SplitMix(seed);
    let columns: Vec<Vec<f64>> = (0..inputs)
        .map(|_| {
            let mut strata: Vec<usize> = (0..points).collect();
            for k in (1..points).rev() {
                strata.swap(k, random.below(k + 1));
            }
            strata.into_iter().map(|s| (s as f64 + random.unit()) / points as f64).collect()
        })
        .collect();
    (0..points).map(|p| columns.iter().map(|column| column[p]).collect()).collect()
}

/// Points for each corner of the ranges that are needed for the corners to be among them.
const CORNERS: usize = 3;

/// Shares of the ranges, each drawn by itself, as the steps of a later use are.
pub fn random(inputs: usize, points: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = SplitMix(seed);
    (0..points).map(|_| (0..inputs).map(|_| random.unit()).collect()).collect()
}

/// The same points along a way of short steps from `start`, each to the nearest that is left.
pub fn ordered(mut points: Vec<Vec<f64>>, start: &[f64]) -> Vec<Vec<f64>> {
    let (mut out, mut here) = (Vec::with_capacity(points.len()), start.to_vec());
    while !points.is_empty() {
        let distance = |p: &Vec<f64>| p.iter().zip(&here).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let nearest = (0..points.len()).min_by(|&a, &b| distance(&points[a]).total_cmp(&distance(&points[b])));
        here = points.remove(nearest.expect("a point is left"));
        out.push(here.clone());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One point in each of the strata of every input, apart from the corners; all points once along the way.
    #[test]
    fn every_stratum_has_a_point() {
        let points = spread(2, 32, 5);
        assert_eq!(points[..4], [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|p| p.to_vec()));
        for k in 0..2 {
            let mut strata: Vec<usize> = points[4..].iter().map(|p| (p[k] * 28.0) as usize).collect();
            strata.sort_unstable();
            assert_eq!(strata, (0..28).collect::<Vec<_>>());
        }
        assert_eq!(grid(2, 3)[..4], [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.0, 0.5]].map(|p| p.to_vec()));
        assert_eq!((grid(3, 4).len(), grid(1, 1)), (64, vec![vec![0.0]]));
        let way = ordered(points.clone(), &[0.0, 0.0]);
        assert!(way.len() == points.len() && points.iter().all(|p| way.contains(p)));
        assert_eq!(way[0], vec![0.0, 0.0]);
    }
}
