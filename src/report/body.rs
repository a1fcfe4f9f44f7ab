//! Draws the body of a scene at rest with its regions in colours, what is held, and its cables.

use crate::report::canvas::{At, GREY, INK, LABEL, Mark, PALETTE, RGB, figure, line, mark, mm, page_width, text};
use crate::report::figure::{Figure, Sample, legend};
use crate::report::surface::{Fit, Look, View, extent, surface};

/// Directions from which the body is seen: from the front, and from behind and below.
const EYES: [[f64; 3]; 2] = [[0.55, -1.0, 0.45], [-0.55, 1.0, -0.45]];
const PLAIN: RGB = RGB(0xdd, 0xe3, 0xe9);
/// Height of each view \[mm\].
const TALL: f64 = 78.0;
/// Marks of nodes are thinned out to about as many; those of held nodes leave the colour below them to be seen.
const MARKED: usize = 400;
const MARKED_HELD: usize = 100;

/// Content of the picture; positions \[m\].
pub struct BodyPicture {
    pub points: Vec<[f64; 3]>,
    /// Facets of the boundary, outward: three corners, and three mid-nodes where they are curved
    pub facets: Vec<Vec<u32>>,
    /// Name of a region, and its facets; a later one is drawn over an earlier one
    pub regions: Vec<(String, Vec<usize>)>,
    /// Name of a region of nodes, and their positions
    pub nodes: Vec<(String, Vec<[f64; 3]>)>,
    /// Nodes that are held or moved
    pub held: Vec<[f64; 3]>,
    /// Name of a cable, and its points from the pull point on
    pub cables: Vec<(String, Vec<[f64; 3]>)>,
}

/// The body from two sides, with a legend. Marks of nodes and cables are drawn over the body, also where it hides them.
pub fn draw(name: &str, body: &BodyPicture) -> Figure {
    // The cables, which are thin, have the strongest colours
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
        // Little, so that a region has the colour of the legend
        shade: 0.25,
    };
    let under: String = views.iter().map(|(view, fit)| surface(&body.points, &body.facets, view, fit, &look)).collect();
    let entries = entries(body);
    let rows = entries.len() as f64;
    let svg = figure(page_width(), EYES.len() as f64 * TALL + 8.0 + 4.2 * rows, &under, |area| {
        for (view, fit) in &views {
            let at = |p: &[f64; 3]| fit.at(view.project(*p));
            for (k, (_, nodes)) in body.nodes.iter().enumerate() {
                let color = color(cables + body.regions.len() + k);
                thinned(nodes, MARKED).for_each(|p| mark(area, Mark::Circle, at(p), 12, color));
            }
            thinned(&body.held, MARKED_HELD).for_each(|p| mark(area, Mark::Cross, at(p), 11, INK));
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

/// Every number-th color of the palette, paler in the second round and in the third, which is that of all later ones.
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

fn thinned(points: &[[f64; 3]], most: usize) -> impl Iterator<Item = &[f64; 3]> {
    points.iter().step_by(points.len().div_ceil(most).max(1))
}

fn entries(body: &BodyPicture) -> Vec<(Sample, String)> {
    let (regions, cables) = (body.regions.len(), body.cables.len());
    let mut entries: Vec<(Sample, String)> = Vec::new();
    for (k, (name, facets)) in body.regions.iter().enumerate() {
        entries.push((Sample::Block(color(cables + k)), format!("{name} ({} facets on the surface)", facets.len())));
    }
    for (k, (name, points)) in body.nodes.iter().enumerate() {
        entries.push((
            Sample::Mark(Mark::Circle, color(cables + regions + k)),
            format!("{name} ({} nodes)", points.len()),
        ));
    }
    if !body.held.is_empty() {
        entries.push((Sample::Mark(Mark::Cross, INK), format!("held or moved ({} nodes)", body.held.len())));
    }
    for (k, (name, points)) in body.cables.iter().enumerate() {
        entries.push((Sample::Line(color(k)), format!("{name} ({} points)", points.len())));
    }
    entries
}
