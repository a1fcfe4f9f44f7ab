//! The figures, one file each: stored results in, SVG out.

pub mod band;
pub mod bodies;
pub mod calibration;
pub mod cost;
pub mod curves;
pub mod errors;
pub mod fit;
pub mod formulations;
pub mod growth;
pub mod laws;
pub mod matrix;
pub mod overlay;
pub mod prices;
pub mod region;
pub mod sweep;
pub mod time;
pub mod work;
pub mod wreck;

use super::canvas::{Area, At, INK, Mark, Point, RGB, SMALL, line, mark, mm, text};
use super::store::Store;
use crate::study::convergence::Analysis;
use crate::study::record::Quantity;

/// A drawn figure: file name, SVG, and what it shows.
pub struct Figure {
    pub name: String,
    pub svg: String,
    pub caption: String,
}

/// Every figure of a convergence study that the stored data allow.
pub fn convergence(store: &Store, analysis: &Analysis) -> Vec<Figure> {
    let mut out = vec![];
    out.extend(bodies::meshes(store));
    out.extend(bodies::bent(store, analysis));
    out.extend(store.study.variants.iter().filter_map(|v| curves::draw(store, analysis, v)));
    out.extend(formulations::draw(store, analysis));
    out.extend(errors::against_h(store, analysis));
    out.extend(errors::against_cost(store, analysis));
    out.extend(cost::draw(store, analysis));
    out.extend(time::draw(store, analysis));
    out
}

/// What the sample of a legend looks like.
pub enum Sample {
    Line(RGB),
    Dashed(RGB),
    Mark(Mark, RGB),
    Hollow(Mark, RGB),
    Block(RGB),
}

/// A legend downwards from a point, outside of the data.
pub fn legend(area: &Area, (x, mut y): Point, entries: &[(Sample, String)]) {
    for (sample, words) in entries {
        let (a, b) = ((x, y), (x + mm(5.0), y));
        match sample {
            Sample::Line(c) => line(area, &[a, b], *c, 12),
            Sample::Dashed(c) => super::canvas::dashed(area, &[a, b], *c, 12, 28.0),
            Sample::Mark(m, c) => mark(area, *m, (x + mm(2.5), y), 26, *c),
            Sample::Hollow(m, c) => super::canvas::hollow(area, *m, (x + mm(2.5), y), 24, *c),
            Sample::Block(c) => super::canvas::block(area, (x, y - mm(1.1)), (x + mm(5.0), y + mm(1.1)), *c),
        }
        text(area, words, (x + mm(6.5), y), At::Left, SMALL, INK);
        y += mm(4.2);
    }
}

/// `sizes (tet4)`, but `tet10` for a family named after its element.
pub fn family_label(family: &str, formulation: &str) -> String {
    if family == formulation { family.into() } else { format!("{} ({formulation})", family.replace('_', " ")) }
}

/// `bending angle θ [°]`, for an axis.
pub fn axis_label(q: &Quantity, prefix: &str) -> String {
    let unit = if q.unit.is_empty() { String::new() } else { format!(" [{}]", q.unit) };
    format!("{prefix}{} {}{unit}", q.label, super::canvas::italic(&q.symbol))
}
