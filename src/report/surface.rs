//! Draws a triangle surface: orthographic, back faces removed, far triangles first, flat shading, thin edges. A triangle with mid-nodes is drawn
//! through them; its orientation is that of its corners.
//!
//! Triangles are ordered by the depth of their centroids. That is sufficient for slim bodies of triangles that are small compared with the features
//! of the body; long triangles next to small ones may be drawn in the wrong order.

use crate::report::canvas::RGB;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

type V = [f64; 3];

/// Depth relative to the extent of the body by which a facet must be in front of a node to hide it: more than a curved facet deviates from its
/// corners.
const BEHIND: f64 = 2e-3;

fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn unit(a: V) -> V {
    let n = dot(a, a).sqrt().max(f64::MIN_POSITIVE);
    a.map(|v| v / n)
}

/// Camera: unit vectors to the right, up, and towards the eye.
#[derive(Clone, Copy)]
pub struct View {
    right: V,
    up: V,
    eye: V,
}

impl View {
    /// Returns the view from the direction `eye`, with z upwards.
    pub fn from(eye: V) -> Self {
        let eye = unit(eye);
        let right = unit(cross([0.0, 0.0, 1.0], eye));
        Self { right, up: cross(eye, right), eye }
    }

    /// Returns the position in the picture, y downwards \[unit of x\].
    pub fn project(&self, x: V) -> (f64, f64) {
        (dot(x, self.right), -dot(x, self.up))
    }
}

/// Maps projected positions into a box of the sheet.
#[derive(Clone, Copy)]
pub struct Fit {
    scale: f64,
    offset: (f64, f64),
}

/// Returns the extent of projected points: left, top, right, bottom.
pub fn extent(points: impl Iterator<Item = (f64, f64)>) -> [f64; 4] {
    points.fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |b, (x, y)| {
        [b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)]
    })
}

impl Fit {
    /// Fits `from`, centred, into `to`, both given as left, top, right, bottom.
    pub fn new(from: [f64; 4], to: [i32; 4]) -> Self {
        let to = to.map(f64::from);
        let scale = ((to[2] - to[0]) / (from[2] - from[0])).min((to[3] - to[1]) / (from[3] - from[1]));
        let middle = |k: usize| 0.5 * (to[k] + to[k + 2]) - scale * 0.5 * (from[k] + from[k + 2]);
        Self { scale, offset: (middle(0), middle(1)) }
    }

    pub fn at(&self, p: (f64, f64)) -> (i32, i32) {
        let unit = |v: f64| v.round().clamp(-1e6, 1e6) as i32;
        (unit(self.scale * p.0 + self.offset.0), unit(self.scale * p.1 + self.offset.1))
    }
}

/// Appearance of a surface.
pub struct Look<'a> {
    /// Colour of triangle k before shading
    pub color: &'a dyn Fn(usize) -> RGB,
    /// Colour and width of all edges \[units\]; with `None`, edges take the colour of their triangle
    pub edge: Option<(RGB, f64)>,
    /// Colour and width of silhouette and sharp edges only \[units\]
    pub outline: Option<(RGB, f64)>,
    /// Strength of the shading, from 0 (flat colour) to 1 (full shading)
    pub shade: f64,
}

fn hex(c: RGB) -> String {
    format!("#{:02x}{:02x}{:02x}", c.0, c.1, c.2)
}

/// The corners of a facet, in outward order.
fn corners(facet: &impl AsRef<[u32]>) -> [u32; 3] {
    let nodes = facet.as_ref();
    [nodes[0], nodes[1], nodes[2]]
}

/// The nodes from a corner of a facet to the next one, exclusive: including the mid-node if the facet has one.
fn side(facet: &impl AsRef<[u32]>, corner: usize) -> impl Iterator<Item = u32> {
    let nodes = facet.as_ref();
    std::iter::once(nodes[corner]).chain(nodes.get(3 + corner).copied())
}

/// Moves the pen through points, starting at the first one.
fn through(path: &mut String, places: impl IntoIterator<Item = (i32, i32)>) {
    let mut last = None;
    for (x, y) in places {
        let _ = match last {
            None => write!(path, "M{x} {y}"),
            Some((a, b)) => write!(path, "l{} {}", x - a, y - b),
        };
        last = Some((x, y));
    }
}

/// Draws the surface as SVG paths, with neighbours of one colour in one path. Facets are given by three corners, plus three mid-nodes if they are
/// curved.
pub fn surface<F: AsRef<[u32]>>(points: &[V], facets: &[F], view: &View, fit: &Fit, look: &Look) -> String {
    let light = unit([
        0.75 * view.eye[0] - 0.4 * view.right[0] + 0.6 * view.up[0],
        0.75 * view.eye[1] - 0.4 * view.right[1] + 0.6 * view.up[1],
        0.75 * view.eye[2] - 0.4 * view.right[2] + 0.6 * view.up[2],
    ]);
    let mut seen: Vec<(f64, usize, f64)> = (facets.iter().enumerate())
        .filter_map(|(k, facet)| {
            let [a, b, c] = corners(facet).map(|i| points[i as usize]);
            let n = unit(cross(sub(b, a), sub(c, a)));
            (dot(n, view.eye) > 0.0).then(|| (dot(a, view.eye) + dot(b, view.eye) + dot(c, view.eye), k, dot(n, light)))
        })
        .collect();
    seen.sort_by(|a, b| a.0.total_cmp(&b.0));
    let sides = if look.outline.is_some() { feature_sides(points, facets, view) } else { vec![] };
    let edge = look.edge.map(|(c, w)| format!(" stroke=\"{}\" stroke-width=\"{w}\"", hex(c)));
    let mut svg = format!("<g stroke-linejoin=\"round\"{}>\n", edge.clone().unwrap_or_default());
    let (mut path, mut last) = (String::new(), String::new());
    let flush = |svg: &mut String, path: &mut String, color: &str| {
        if !path.is_empty() {
            let own = if edge.is_none() { format!(" stroke=\"{color}\" stroke-width=\"2\"") } else { String::new() };
            let _ = writeln!(svg, "<path fill=\"{color}\"{own} d=\"{path}\"/>");
            path.clear();
        }
    };
    for (_, k, lit) in seen {
        // Sixteen grades of light keep the file small
        let grade = (lit.max(0.0) * 16.0).round() / 16.0;
        let factor = 1.0 - look.shade * 0.5 * (1.0 - grade);
        let base = (look.color)(k);
        let c = hex(RGB(scale(base.0, factor), scale(base.1, factor), scale(base.2, factor)));
        if c != last {
            flush(&mut svg, &mut path, &last);
            last = c;
        }
        let place = |i: u32| fit.at(view.project(points[i as usize]));
        through(&mut path, (0..3).flat_map(|corner| side(&facets[k], corner)).map(place));
        path.push('z');
        if let Some((color, width)) = look.outline.filter(|_| sides[k] != 0) {
            // Drawn with its triangle, so that nearer triangles cover it
            flush(&mut svg, &mut path, &last);
            let mut d = String::new();
            for corner in (0..3).filter(|corner| sides[k] & (1 << corner) != 0) {
                let end = facets[k].as_ref()[(corner + 1) % 3];
                through(&mut d, side(&facets[k], corner).chain([end]).map(place));
            }
            let color = hex(color);
            let _ =
                writeln!(svg, "<path stroke=\"{color}\" stroke-width=\"{width}\" stroke-linecap=\"round\" d=\"{d}\"/>");
        }
    }
    flush(&mut svg, &mut path, &last);
    svg + "</g>\n"
}

/// Draws the outline of the whole surface, filled with one pale colour; `name` is an id of the page.
pub fn ghost<F: AsRef<[u32]>>(
    points: &[V],
    facets: &[F],
    view: &View,
    fit: &Fit,
    colors: (RGB, RGB),
    name: &str,
) -> String {
    let mut path = String::new();
    for facet in facets {
        let x = corners(facet).map(|i| points[i as usize]);
        if dot(cross(sub(x[1], x[0]), sub(x[2], x[0])), view.eye) > 0.0 {
            let nodes = (0..3).flat_map(|corner| side(facet, corner));
            through(&mut path, nodes.map(|i| fit.at(view.project(points[i as usize]))));
            path.push('z');
        }
    }
    // All edges are drawn wide in the line colour, then all triangles on top: the rest of the lines is the outline
    let used = |c: RGB, width: u32| {
        let c = hex(c);
        format!(
            "<use href=\"#{name}\" fill=\"{c}\" stroke=\"{c}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"/>\n"
        )
    };
    format!("<defs><path id=\"{name}\" d=\"{path}\"/></defs>\n{}{}", used(colors.0, 18), used(colors.1, 3))
}

fn scale(v: u8, factor: f64) -> u8 {
    (f64::from(v) * factor).round().clamp(0.0, 255.0) as u8
}

/// The sides of each facet that are silhouette or sharp (above 35°), as bits (bit k: the side from corner k).
fn feature_sides<F: AsRef<[u32]>>(points: &[V], facets: &[F], view: &View) -> Vec<u8> {
    // Triangles of each edge: normal, number, side
    type Users = Vec<(V, usize, u8)>;
    let mut edges: BTreeMap<(u32, u32), Users> = BTreeMap::new();
    for (k, t) in facets.iter().map(corners).enumerate() {
        let [a, b, c] = t.map(|i| points[i as usize]);
        let n = unit(cross(sub(b, a), sub(c, a)));
        for (side, (i, j)) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])].into_iter().enumerate() {
            edges.entry((i.min(j), i.max(j))).or_default().push((n, k, 1 << side));
        }
    }
    let mut sides = vec![0; facets.len()];
    for users in edges.values() {
        let sharp = users.len() != 2 || dot(users[0].0, users[1].0) < 35.0_f64.to_radians().cos();
        let front = users.iter().filter(|u| dot(u.0, view.eye) > 0.0).count();
        if sharp || front != users.len() {
            users.iter().for_each(|(_, k, side)| sides[*k] |= side);
        }
    }
    sides
}

/// Returns the nodes that are hidden behind the surface, as seen by the eye.
pub fn hidden<F: AsRef<[u32]>>(points: &[V], facets: &[F], nodes: &[u32], view: &View) -> BTreeSet<u32> {
    let seen = |x: V| [dot(x, view.right), dot(x, view.up), dot(x, view.eye)];
    let depths = points.iter().map(|x| seen(*x));
    let (low, high) = depths.fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), x| {
        ([0, 1, 2].map(|k| low[k].min(x[k])), [0, 1, 2].map(|k| high[k].max(x[k])))
    });
    let behind = BEHIND * dot(sub(high, low), sub(high, low)).sqrt();
    let is_in_front = |[a, b, c]: &[V; 3], p: V| {
        let twice = |a: &V, b: &V, c: &V| (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        let area = twice(a, b, c);
        let shares = [twice(&p, b, c) / area, twice(a, &p, c) / area, twice(a, b, &p) / area];
        let depth = shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2];
        area > 0.0 && shares.iter().all(|s| *s > -1e-9) && depth > p[2] + behind
    };
    let triangles: Vec<[V; 3]> = facets.iter().map(|f| corners(f).map(|i| seen(points[i as usize]))).collect();
    let is_hidden = |k: &u32| {
        let p = seen(points[*k as usize]);
        triangles.iter().any(|triangle| is_in_front(triangle, p))
    };
    nodes.iter().copied().filter(is_hidden).collect()
}

/// Returns the colour of viridis (van der Walt & Smith 2015) from nine stops, for s in \[0, 1\].
pub fn viridis(s: f64) -> RGB {
    const STOPS: [[f64; 3]; 9] = [
        [68.0, 1.0, 84.0],
        [71.0, 44.0, 122.0],
        [59.0, 81.0, 139.0],
        [44.0, 113.0, 142.0],
        [33.0, 144.0, 141.0],
        [39.0, 173.0, 129.0],
        [92.0, 200.0, 99.0],
        [170.0, 220.0, 50.0],
        [253.0, 231.0, 37.0],
    ];
    let x = if s.is_finite() { s.clamp(0.0, 1.0) * 8.0 } else { 0.0 };
    let k = (x.floor() as usize).min(7);
    let t = x - k as f64;
    let mix = |c: usize| (STOPS[k][c] * (1.0 - t) + STOPS[k + 1][c] * t).round() as u8;
    RGB(mix(0), mix(1), mix(2))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a tetrahedron with a corner towards the eye, the node behind its facets is hidden, and those of its outline are not.
    #[test]
    fn nodes_behind_the_surface_are_hidden() {
        let view = View::from([0.0, -1.0, 0.0]);
        let points = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 4.0], [1.0, -2.0, 1.0], [1.0, 0.0, 1.0]];
        let facets = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 2, 1]];
        assert_eq!(hidden(&points, &facets, &[0, 1, 2, 3, 4], &view), BTreeSet::from([4]));
        let from_behind = View::from([0.0, 1.0, 0.0]);
        assert_eq!(hidden(&points, &facets, &[0, 1, 2, 3, 4], &from_behind), BTreeSet::from([3]));
    }

    /// A facet that is seen from above is drawn through its mid-nodes, and so is its outline.
    #[test]
    fn a_curved_facet_is_drawn_through_its_mid_nodes() {
        let view = View::from([0.0, -1.0, 0.0]);
        let points =
            [[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 0.0, 8.0], [4.0, 0.0, -1.0], [5.0, 0.0, 5.0], [-1.0, 0.0, 4.0]];
        let fit = Fit::new([0.0, -8.0, 8.0, 0.0], [0, 0, 8, 8]);
        let look = Look { color: &|_| RGB(9, 9, 9), edge: None, outline: Some((RGB(1, 1, 1), 2.0)), shade: 0.0 };
        let flat = surface(&points, &[[0, 1, 2]], &view, &fit, &look);
        assert!(flat.contains("d=\"M0 8l8 0l-8 -8z\"") && flat.contains("d=\"M0 8l8 0M8 8l-8 -8M0 0l0 8\""), "{flat}");
        let curved = surface(&points, &[[0, 1, 2, 3, 4, 5]], &view, &fit, &look);
        assert!(curved.contains("d=\"M0 8l4 1l4 -1l-3 -5l-5 -3l-1 4z\""), "{curved}");
        assert!(curved.contains("d=\"M0 8l4 1l4 -1M8 8l-3 -5l-5 -3M0 0l-1 4l1 4\""), "{curved}");
    }
}
