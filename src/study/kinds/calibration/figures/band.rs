//! A law in use: the curve with the uncertainty left by constants and mesh.

use crate::report::canvas::{INK, RGB, figure, fill, italic, line, mm, page_width};
use crate::report::figure::{Figure, Sample, legend_inside};
use crate::report::plot::{Axis, Plot};
use crate::study::figures::axis_label;
use crate::study::kinds::calibration::band::Band;
use plotters::style::Color;

const LEFT: f64 = 15.0;
const TOP: f64 = 6.0;
const WIDE: f64 = 84.0;
const TALL: f64 = 56.0;
/// Pale versions of the blue and the orange of the palette
const CONSTANTS: RGB = RGB(0x8c, 0xb8, 0xd6);
const MESH: RGB = RGB(0xf2, 0xcd, 0xae);

pub fn draw(b: &Band) -> Figure {
    let wide = WIDE.min(page_width() - LEFT - 5.0);
    let svg = figure(LEFT + wide + 5.0, TOP + TALL + 11.0, "", |area| {
        let frame = [mm(LEFT), mm(TOP), mm(LEFT + wide), mm(TOP + TALL)];
        let [low, high] = &b.constants;
        let mesh = |k: usize| b.mesh.as_ref().map_or(0.0, |m| m[k]);
        let outer: [Vec<f64>; 2] = [
            low.iter().enumerate().map(|(k, v)| v - mesh(k)).collect(),
            high.iter().enumerate().map(|(k, v)| v + mesh(k)).collect(),
        ];
        let times = || b.t_s.iter().copied();
        let (start, end) = (times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max));
        let x = Axis::exact(start, end, &format!("time {} [s]", italic("t")));
        let y = Axis::linear(outer.iter().flatten().copied(), &axis_label(&b.quantity, ""));
        let plot = Plot { area, frame, x, y };
        plot.grid();
        let around = |ends: &[Vec<f64>; 2]| {
            let mut path = plot.path(&b.t_s, &ends[1]);
            path.extend(plot.path(&b.t_s, &ends[0]).into_iter().rev());
            path
        };
        fill(area, &around(&outer), MESH.to_rgba());
        fill(area, &around(&b.constants), CONSTANTS.to_rgba());
        line(area, &plot.path(&b.t_s, &b.y), INK, 9);
        plot.axes(true);
        let entries = [
            (Sample::Line(INK), "constants found, finest mesh".to_string()),
            (Sample::Block(CONSTANTS), "left open by the constants".into()),
            (Sample::Block(MESH), "and by the mesh".into()),
        ];
        legend_inside(area, frame, &[around(&outer), plot.path(&b.t_s, &b.y)], &entries);
    });
    let caption = format!(
        "The law in case {}: {} with the uncertainty from the constants (data, dimensions and mesh of the specimen) and from the mesh of this scene.",
        b.case, b.quantity.label
    );
    Figure { name: format!("band-{}", b.variant), svg, caption }
}
