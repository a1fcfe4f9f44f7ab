//! Draws the body of a scene at rest with its coloured regions, its supports and its cables.

use crate::report::canvas::{At, GREY, INK, LABEL, Mark, PALETTE, RGB, figure, line, mark, mm, page_width, text};
use crate::report::figure::{Figure, Sample, legend};
use crate::report::surface::{Fit, Look, View, extent, hidden, surface};
use crate::wording::count;
use std::collections::{BTreeMap, BTreeSet};

/// Directions from which the body is seen: from the front, and from behind and below.
const EYES: [[f64; 3]; 2] = [[0.55, -1.0, 0.45], [-0.55, 1.0, -0.45]];
const PLAIN: RGB = RGB(0xdd, 0xe3, 0xe9);
/// Height of each view \[mm\].
const TALL: f64 = 78.0;
/// Approximate number of marks to which nodes are thinned out; over regions of facets there are fewer, so that the colour below remains visible.
const MARKED: usize = 400;
const MARKED_HELD: usize = 100;
/// Size of the mark of a visible node, and of one hidden by the body
const SEEN: i32 = 12;
const HIDDEN: i32 = 5;

/// Content of the picture, with positions in \[m\].
pub struct BodyPicture {
    pub points: Vec<[f64; 3]>,
    /// Outward facets of the boundary: three corners, plus three mid-nodes if they are curved
    pub facets: Vec<Vec<u32>>,
    /// Regions by name, with their facets; later ones are drawn over earlier ones
    pub regions: Vec<(String, Vec<usize>)>,
    /// Regions of nodes by name, with the node numbers; later ones are drawn over earlier ones
    pub nodes: Vec<(String, Vec<u32>)>,
    /// Nodes that are held or moved
    pub held: BTreeSet<u32>,
    /// Cables by name, with their points starting at the pull point
    pub cables: Vec<(String, Vec<[f64; 3]>)>,
}

/// Nodes with the same mark.
struct Marked {
    shape: Mark,
    color: RGB,
    /// Nodes that are drawn
    nodes: Vec<u32>,
    words: String,
}

/// Draws the body from two sides, with a legend. Marks of nodes and cables are drawn over the body, marks of hidden nodes small.
pub fn draw(name: &str, body: &BodyPicture) -> Figure {
    // Cables are thin and get the strongest colours
    let cables = body.cables.len();
    let mut colors = vec![PLAIN; body.facets.len()];
    for (k, (_, facets)) in body.regions.iter().enumerate() {
        facets.iter().for_each(|&t| colors[t] = color(cables + k));
    }
    let views: Vec<(View, Fit)> = (0..EYES.len()).map(|k| fitted(body, k)).collect();
    let look = Look {
        color: &|t| colors[t],
        edge: Some((RGB(0x66, 0x70, 0x7c), 1.0)),
        outline: Some((RGB(0x22, 0x2a, 0x33), 5.0)),
        // Weak shading, so that a region keeps the colour of the legend
        shade: 0.25,
    };
    let under: String = views.iter().map(|(view, fit)| surface(&body.points, &body.facets, view, fit, &look)).collect();
    let marked = marked(body);
    let drawn: Vec<u32> = marked.iter().flat_map(|m| m.nodes.iter().copied()).collect();
    let hidden: Vec<BTreeSet<u32>> =
        views.iter().map(|(view, _)| hidden(&body.points, &body.facets, &drawn, view)).collect();
    let entries = entries(body, &marked, hidden.iter().any(|nodes| !nodes.is_empty()));
    let rows = entries.len() as f64;
    let svg = figure(page_width(), EYES.len() as f64 * TALL + 8.0 + 4.2 * rows, &under, |area| {
        for ((view, fit), hidden) in views.iter().zip(&hidden) {
            let at = |p: &[f64; 3]| fit.at(view.project(*p));
            for Marked { shape, color, nodes, .. } in &marked {
                for k in nodes {
                    let size = if hidden.contains(k) { HIDDEN } else { SEEN };
                    mark(area, *shape, at(&body.points[*k as usize]), size, *color);
                }
            }
            for (k, (_, points)) in body.cables.iter().enumerate() {
                let path: Vec<(i32, i32)> = points.iter().map(at).collect();
                let color = color(k);
                line(area, &path, color, 14);
                path.iter().for_each(|p| mark(area, Mark::Circle, *p, 18, color));
            }
        }
        text(area, "from the front", (mm(2.0), mm(4.0)), At::Left, LABEL, GREY);
        text(area, "from behind and below", (mm(2.0), mm(TALL + 4.0)), At::Left, LABEL, GREY);
        legend(area, (mm(4.0), mm(EYES.len() as f64 * TALL + 6.0)), &entries);
    });
    Figure { name: name.into(), svg, caption: "The body at rest with its regions.".into() }
}

/// The colour of number `k` of the palette, paler in the second and in the third round; all later rounds repeat the third.
fn color(k: usize) -> RGB {
    let RGB(r, g, b) = PALETTE[k % PALETTE.len()];
    let round = (k / PALETTE.len()).min(2);
    let pale = |v: u8| (255.0 - (255.0 - f64::from(v)) * 0.6_f64.powi(round as i32)) as u8;
    RGB(pale(r), pale(g), pale(b))
}

fn fitted(body: &BodyPicture, k: usize) -> (View, Fit) {
    let view = View::from(EYES[k]);
    let all = body.points.iter().chain(body.cables.iter().flat_map(|(_, points)| points));
    let top = k as f64 * TALL;
    let to = [mm(4.0), mm(top + 7.0), mm(page_width() - 4.0), mm(top + TALL - 3.0)];
    (view, Fit::new(extent(all.map(|p| view.project(*p))), to))
}

/// The marks of regions of nodes, and of held nodes outside them. A node has one mark, in the colour of its last region: a cross if it is held or
/// moved.
fn marked(body: &BodyPicture) -> Vec<Marked> {
    let of_regions = body.nodes.iter().enumerate().flat_map(|(k, (_, nodes))| nodes.iter().map(move |node| (*node, k)));
    let last: BTreeMap<u32, usize> = of_regions.collect();
    let mut all = Vec::new();
    let mut add = |shape, color, most: usize, (nodes, words): (Vec<u32>, String)| {
        let step = nodes.len().div_ceil(most).max(1);
        let thinned = if step > 1 { format!(", one in {step} is drawn") } else { String::new() };
        all.push(Marked { shape, color, nodes: nodes.into_iter().step_by(step).collect(), words: words + &thinned });
    };
    for (k, (name, nodes)) in body.nodes.iter().enumerate() {
        let color = color(body.cables.len() + body.regions.len() + k);
        for (shape, held) in [(Mark::Circle, ""), (Mark::Cross, ", held or moved")] {
            let own: Vec<u32> =
                nodes.iter().copied().filter(|node| body.held.contains(node) != held.is_empty()).collect();
            if !own.is_empty() {
                let words = format!("{name}: {}{held}", count(own.len(), "node"));
                add(shape, color, MARKED, (own.into_iter().filter(|node| last[node] == k).collect(), words));
            }
        }
    }
    let others: Vec<u32> = body.held.iter().copied().filter(|node| !last.contains_key(node)).collect();
    if !others.is_empty() {
        let more = if others.len() < body.held.len() { "other " } else { "" };
        let words = format!("held or moved: {}", count(others.len(), &format!("{more}node")));
        add(Mark::Cross, INK, MARKED_HELD, (others, words));
    }
    all
}

fn entries(body: &BodyPicture, marked: &[Marked], any_hidden: bool) -> Vec<(Sample, String)> {
    let cables = body.cables.len();
    let mut entries: Vec<(Sample, String)> = Vec::new();
    for (k, (name, facets)) in body.regions.iter().enumerate() {
        entries.push((Sample::Block(color(cables + k)), format!("{name} ({} facets on the surface)", facets.len())));
    }
    entries.extend(marked.iter().map(|m| (Sample::Mark(m.shape, m.color), m.words.clone())));
    if any_hidden {
        entries.push((Sample::Nothing, "small marks: nodes that the body hides".into()));
    }
    for (k, (name, points)) in body.cables.iter().enumerate() {
        entries.push((Sample::Line(color(k)), format!("{name} ({} points)", points.len())));
    }
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A node has one mark, even if it is in several regions and held; the legend counts the nodes of each, and says what is left out.
    #[test]
    fn every_node_has_one_mark() {
        let body = |held: u32| BodyPicture {
            points: (0..1000).map(|k| [f64::from(k), f64::from(k * k % 7), f64::from(k % 5)]).collect(),
            facets: vec![],
            regions: vec![],
            nodes: vec![("end".into(), (0..119).collect()), ("tip".into(), (100..130).collect())],
            held: (0..held).collect(),
            cables: vec![],
        };
        let found = marked(&body(119));
        let words: Vec<&str> = found.iter().map(|m| m.words.as_str()).collect();
        assert_eq!(words, ["end: 119 nodes, held or moved", "tip: 11 nodes", "tip: 19 nodes, held or moved"]);
        let mut nodes: Vec<u32> = found.iter().flat_map(|m| m.nodes.clone()).collect();
        nodes.sort_unstable();
        assert_eq!(nodes, (0..130).collect::<Vec<_>>());
        let last = marked(&body(350)).pop().expect("held nodes in no region");
        assert_eq!((last.words.as_str(), last.nodes.len()), ("held or moved: 220 other nodes, one in 3 is drawn", 74));
        assert!(draw("regions", &body(350)).svg.contains("one in 3 is drawn"));
    }
}
