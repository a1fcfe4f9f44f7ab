//! The terms of the potential in one state: which features are near, and with which multiplicity and weight.

use super::candidates::{Candidates, Pass};
use super::pair::Surfaces;
use super::pair_distance::PairDistance;
use super::surface::Edge;
use crate::effect::contact::SurfacePoint;
use crate::math::nearest::{Nearest, PARALLEL, between, on_segment, on_segments, on_triangle, to_triangle};
use crate::math::tensor::Vec3;

/// Weight of an edge as a guard where surfaces are flat, relative to its area \[–\].
const GUARD: f64 = 1e-2;
/// ε relative to |u|²|v|² at rest \[–\].
const BLUNT: f64 = 1e-3;

/// A distance and its weight.
#[derive(Clone, Debug)]
pub struct Term {
    pub distance: PairDistance,
    /// Pass and point; `None` for two edges
    pub point: Option<(usize, u32)>,
    /// ½ c W, or w \[m²\]
    pub weight: f64,
    /// ε of two edges \[m⁴\]; `None` for a point
    pub blunt: Option<f64>,
}

/// A feature of a triangle surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Feature {
    Corner(u32),
    Side([u32; 2]),
    Face(u32),
}

/// Returns all terms of the candidates that are nearer than `reach`.
pub(super) fn near(surfaces: &Surfaces, x: &[f64], of: &Candidates, reach: f64, tested: &mut usize) -> Vec<Term> {
    let mut found = Vec::new();
    let passes = surfaces.passes();
    for (k, (pass, pairs)) in passes.iter().zip(&of.points).enumerate() {
        for pairs in pairs.chunk_by(|a, b| a[0] == b[0]) {
            *tested += pairs.len();
            at_point(surfaces, x, pass, (k, pairs), reach, &mut found);
        }
    }
    let (first, second) = (&passes[0].points.edges, &passes[0].triangles.edges);
    for &[a, b] in &of.edges {
        *tested += 1;
        found.extend(at_edges(surfaces, x, &first[a as usize], &second[b as usize], reach));
    }
    found
}

/// Returns the nodes of the candidates that are nearer than `reach`, pair by pair.
pub(super) fn nodes_within(surfaces: &Surfaces, x: &[f64], of: &Candidates, reach: f64) -> Vec<Vec<u32>> {
    let mut found = Vec::new();
    let passes = surfaces.passes();
    for (pass, pairs) in passes.iter().zip(&of.points) {
        for &[p, t] in pairs {
            let (point, nodes) = (&pass.points.points[p as usize], pass.triangles.triangles[t as usize]);
            if to_triangle(&surfaces.place(x, point), &nodes.map(|k| surfaces.node(x, k))) < reach {
                found.push([&point.nodes[..], &nodes].concat());
            }
        }
    }
    let (first, second) = (&passes[0].points.edges, &passes[0].triangles.edges);
    for &[a, b] in &of.edges {
        let (a, b) = (first[a as usize].nodes, second[b as usize].nodes);
        if between(&a.map(|k| surfaces.node(x, k)), &b.map(|k| surfaces.node(x, k))) < reach {
            found.push([a, b].concat());
        }
    }
    found
}

/// The features near one point, from the triangles in `pairs`.
fn at_point(
    surfaces: &Surfaces,
    x: &[f64],
    pass: &Pass,
    (k, pairs): (usize, &[[u32; 2]]),
    reach: f64,
    found: &mut Vec<Term>,
) {
    let index = pairs[0][0];
    let point = &pass.points.points[index as usize];
    let p = surfaces.place(x, point);
    let mut features = Vec::<(Feature, i32)>::new();
    let mut count = |feature: Feature, often: i32| match features.iter_mut().find(|f| f.0 == feature) {
        Some(known) => known.1 += often,
        None => features.push((feature, often)),
    };
    let (mut sides, mut corners) = (Vec::new(), Vec::new());
    for &[_, t] in pairs {
        let nodes = pass.triangles.triangles[t as usize];
        let (nearest, weights) = on_triangle(&p, &nodes.map(|k| surfaces.node(x, k)));
        let at: Vec3 = nodes.iter().zip(weights).map(|(&k, w)| surfaces.node(x, k) * w).sum();
        if (p - at).norm() >= reach {
            continue;
        }
        let side = |i: usize| [nodes[i].min(nodes[(i + 1) % 3]), nodes[i].max(nodes[(i + 1) % 3])];
        count(
            match nearest {
                Nearest::Corner(i) => Feature::Corner(nodes[i]),
                Nearest::Side(i) => Feature::Side(side(i)),
                Nearest::Face => Feature::Face(t),
            },
            1,
        );
        sides.extend((0..3).map(side));
        corners.extend(nodes);
    }
    sides.sort_unstable();
    sides.dedup();
    for side in sides {
        let again = pass.triangles.at_side(&side, &point.nodes).saturating_sub(1) as i32;
        let [a, b] = side.map(|k| surfaces.node(x, k));
        let t = on_segment(&p, &a, &b);
        if again > 0 && (p - (a + (b - a) * t)).norm() < reach {
            let end = |k: usize| Feature::Corner(side[k]);
            count(
                if t == 0.0 {
                    end(0)
                } else if t == 1.0 {
                    end(1)
                } else {
                    Feature::Side(side)
                },
                -again,
            );
        }
    }
    corners.sort_unstable();
    corners.dedup();
    for corner in corners {
        let closes = pass.triangles.closes(corner, &point.nodes);
        if closes != 0 && (p - surfaces.node(x, corner)).norm() < reach {
            count(Feature::Corner(corner), closes);
        }
    }
    let term = |(feature, often): (Feature, i32)| Term {
        distance: at_feature(surfaces, x, &p, point, pass, feature),
        point: Some((k, index)),
        weight: 0.5 * f64::from(often) * point.area,
        blunt: None,
    };
    found.extend(features.into_iter().filter(|f| f.1 != 0).map(term));
}

/// Distance of a point from a feature.
fn at_feature(
    surfaces: &Surfaces,
    x: &[f64],
    p: &Vec3,
    point: &SurfacePoint,
    pass: &Pass,
    feature: Feature,
) -> PairDistance {
    let own = point.nodes.len();
    let still = |slopes: &[f64]| [vec![0.0; own], slopes.to_vec()].concat();
    let (nodes, weights, slopes): (Vec<u32>, Vec<f64>, Vec<Vec<f64>>) = match feature {
        Feature::Corner(k) => (vec![k], vec![1.0], vec![]),
        Feature::Side(side) => {
            let [a, b] = side.map(|k| surfaces.node(x, k));
            let t = on_segment(p, &a, &b);
            (side.to_vec(), vec![1.0 - t, t], vec![still(&[1.0, -1.0])])
        }
        Feature::Face(t) => {
            let nodes = pass.triangles.triangles[t as usize];
            let (_, weights) = on_triangle(p, &nodes.map(|k| surfaces.node(x, k)));
            (nodes.to_vec(), weights.to_vec(), vec![still(&[1.0, -1.0, 0.0]), still(&[1.0, 0.0, -1.0])])
        }
    };
    let shares = point.weights.iter().copied().chain(weights.iter().map(|w| -w)).collect();
    PairDistance::new([point.nodes.clone(), nodes].concat(), |k| surfaces.node(x, k), shares, slopes)
}

/// The term of two edges; `None` if they are parallel or too far apart.
fn at_edges(surfaces: &Surfaces, x: &[f64], first: &Edge, second: &Edge, reach: f64) -> Option<Term> {
    let ends = |e: &Edge| e.nodes.map(|k| surfaces.node(x, k));
    let ([a, b], [c, d]) = (ends(first), ends(second));
    let [s, t] = on_segments(&[a, b], &[c, d]);
    let (u, v) = (b - a, d - c);
    let apart = (a + u * s) - (c + v * t);
    let parallel = u.cross(&v).norm_squared() <= PARALLEL * u.norm_squared() * v.norm_squared();
    if apart.norm() >= reach || parallel {
        return None;
    }
    let free = |t: f64| t != 0.0 && t != 1.0;
    let slopes = [(free(s), vec![-1.0, 1.0, 0.0, 0.0]), (free(t), vec![0.0, 0.0, 1.0, -1.0])];
    let slopes = slopes.into_iter().filter(|s| s.0).map(|s| s.1).collect();
    let nodes = [first.nodes, second.nodes].concat();
    let distance = PairDistance::new(nodes, |k| surfaces.node(x, k), vec![1.0 - s, s, t - 1.0, -t], slopes);
    let square = |e: &Edge| (surfaces.rest[e.nodes[0] as usize] - surfaces.rest[e.nodes[1] as usize]).norm_squared();
    let blunt = Some(BLUNT * square(first) * square(second));
    let share = GUARD + (1.0 - GUARD) * first.sharp * second.sharp;
    Some(Term { distance, point: None, weight: 0.5 * share * (first.area + second.area), blunt })
}
