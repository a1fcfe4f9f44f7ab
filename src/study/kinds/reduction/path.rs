//! Points in the ranges of the inputs, and the order in which runs pass through them.

use crate::math::random::SplitMix;

/// Returns points as fractions of the ranges: a grid from end to end for one input; the corners and a Latin hypercube for several.
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

/// Returns every combination of `each` fractions of each range, from end to end.
pub fn grid(inputs: usize, each: usize) -> Vec<Vec<f64>> {
    let value = |k: usize| k as f64 / (each - 1).max(1) as f64;
    let point = |n: usize| (0..inputs).map(|k| value(n / each.pow(k as u32) % each)).collect();
    (0..each.pow(inputs as u32)).map(point).collect()
}

/// Returns a Latin hypercube: one point in each of `points` strata of every input (McKay, Beckman & Conover, *Technometrics* 21, 1979).
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

/// Number of points per corner of the ranges from which the corners are included.
const CORNERS: usize = 3;

/// Returns fractions of the ranges, each drawn independently, like the steps of a later use.
pub fn random(inputs: usize, points: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = SplitMix(seed);
    (0..points).map(|_| (0..inputs).map(|_| random.unit()).collect()).collect()
}

/// Returns the same points along a path of short steps from `start`, each time to the nearest remaining point.
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

    /// One point in each stratum of every input, apart from the corners; the path visits all points once.
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
