//! The sheet on which a figure is drawn: sizes, type, colours and the few marks shared by all figures.
//!
//! One unit is a tenth of a typographic point, so that the integer coordinates of plotters are fine enough for print.

use crate::report::style;
use plotters::coord::Shift;
use plotters::prelude::*;
pub use plotters::style::RGBColor as RGB;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Units per millimetre.
const PER_MM: f64 = 720.0 / 25.4;
/// Type sizes of labels and of annotations \[units\].
pub const LABEL: i32 = 80;
pub const SMALL: i32 = 70;

/// Height of the tallest figure that fits on an A4 page with its caption \[mm\].
const TALLEST: f64 = 230.0;

pub const WHITE: RGBColor = RGBColor(0xff, 0xff, 0xff);
pub const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
pub const GREY: RGBColor = RGBColor(0x80, 0x80, 0x80);
pub const PALE: RGBColor = RGBColor(0xe4, 0xe4, 0xe4);
/// Colour of the remainder of a bar whose parts are only partly named.
pub const REMAINDER: RGBColor = RGBColor(0xd0, 0xd0, 0xd0);
/// Colours of Okabe & Ito 2008: blue, vermilion, bluish green, reddish purple, orange, sky blue, black.
pub const PALETTE: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0x00, 0x00, 0x00),
];

/// Colours of adjacent areas, which remain distinguishable in grey; the first three are the high-contrast set of Tol 2021.
pub const AREAS: [RGBColor; 7] = [
    RGBColor(0x00, 0x44, 0x88),
    RGBColor(0xdd, 0xaa, 0x33),
    RGBColor(0xbb, 0x55, 0x66),
    PALETTE[6],
    PALETTE[5],
    PALETTE[2],
    PALETTE[3],
];

pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub type Point = (i32, i32);

/// Returns the width of a figure of full width in the [style] \[mm\].
pub fn page_width() -> f64 {
    style::current().sheet()
}

/// Returns the height of the tallest figure of the [style] on its sheet \[mm\].
pub fn page_height() -> f64 {
    TALLEST / style::current().zoom(page_width())
}

/// Returns the number of columns of panels that fit on a sheet, at most `most`, each at least `least` wide \[mm\].
pub fn columns(most: usize, (left, gap, least): (f64, f64, f64)) -> usize {
    let fit = ((page_width() - left + gap) / (least + gap)).floor();
    (fit.max(1.0) as usize).min(most.max(1))
}

/// Converts millimetres to units.
pub fn mm(v: f64) -> i32 {
    (v * PER_MM).round() as i32
}

/// Marks around text that is set in italics.
pub const ITALIC: (char, char) = ('\u{e000}', '\u{e001}');
/// Marks around text that is raised, such as an exponent. `LOWERED` ends the lowered text that follows it.
pub const RAISED: (char, char) = ('\u{e002}', '\u{e003}');
const LOWERED: char = '\u{e004}';
/// Marks around text that is lowered, such as an index; the text after it is raised again until `LOWERED`.
pub const BELOW: (char, char) = ('\u{e005}', '\u{e006}');

/// Sets a symbol in italics; the part after a letter and `_` is its index: `J_m`.
pub fn italic(symbol: &str) -> String {
    let slanted = |text: &str| match text {
        "" => String::new(),
        text => format!("{}{text}{}", ITALIC.0, ITALIC.1),
    };
    let Some((letter, rest)) = symbol.split_once('_').filter(|(letter, _)| letter.chars().count() == 1) else {
        return slanted(symbol);
    };
    let (index, rest) = rest.split_at(rest.find(|c: char| !c.is_alphanumeric()).unwrap_or(rest.len()));
    format!("{}{}{index}{}{}", slanted(letter), BELOW.0, BELOW.1, slanted(rest))
}

/// Removes the marks from the text of a figure: an index follows `_` again.
pub fn unmarked(text: &str) -> String {
    text.replace([ITALIC.0, ITALIC.1, BELOW.1], "").replace(BELOW.0, "_")
}

/// Draws a figure of `width` × `height` \[mm\] on the sheet; `under` is raw SVG in units, placed below what `paint` draws.
pub fn figure(width: f64, height: f64, under: &str, paint: impl FnOnce(&Area)) -> String {
    let (w, h) = (mm(width) as u32, mm(height) as u32);
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, (w, h)).into_drawing_area();
        paint(&area);
        area.present().expect("a string accepts every write");
    }
    let head = format!("<svg width=\"{w}\" height=\"{h}\"");
    let zoom = style::current().zoom(width);
    let sized = format!("<svg width=\"{}mm\" height=\"{}mm\"", hundredths(zoom * width), hundredths(zoom * height));
    let svg = svg.replacen(&head, &sized, 1).replacen(">\n", &format!(">\n{under}"), 1);
    svg.replace("dy=\"0.5ex\"", "dy=\"0.35em\"")
        .replace("dy=\"-0.5ex\"", "dy=\"-0.25em\"")
        .replace(ITALIC.0, "<tspan font-style=\"italic\">")
        .replace(ITALIC.1, "</tspan>")
        .replace(RAISED.0, "<tspan dy=\"-0.45em\" font-size=\"0.7em\">")
        .replace(RAISED.1, "</tspan><tspan dy=\"0.315em\">")
        .replace(BELOW.0, "<tspan dy=\"0.2em\" font-size=\"0.7em\">")
        .replace(BELOW.1, "</tspan><tspan dy=\"-0.14em\">")
        .replace(LOWERED, "</tspan>")
}

fn hundredths(v: f64) -> f64 {
    (100.0 * v).round() / 100.0
}

/// Returns the width stated in a drawing \[mm\].
pub fn width_mm(svg: &str) -> f64 {
    svg.split('"').nth(1).and_then(|w| w.strip_suffix("mm")?.parse().ok()).unwrap_or(180.0)
}

/// The anchor of a text: the point of the text that is placed at the position.
#[derive(Clone, Copy)]
pub enum At {
    Left,
    Right,
    /// Centred on the point
    Middle,
    /// Centred below the point
    Below,
    /// Rotated by 90°, centred, left of the point
    Turned,
}

/// Draws an element; drawing on a string cannot fail.
fn put<'a, E>(area: &Area<'a>, element: E)
where
    for<'b> &'b E: plotters::element::PointCollection<'b, (i32, i32)>,
    E: plotters::element::Drawable<SVGBackend<'a>>,
{
    area.draw(&element).expect("a string accepts every write");
}

/// A text that can be part of a drawing: without control characters, and with balanced marks of italics and exponents.
fn printable(text: &str) -> String {
    let (mut out, mut open) = (String::with_capacity(text.len()), false);
    let (mut small, mut lowered) = (false, 0);
    for c in text.chars() {
        match c {
            _ if c == ITALIC.0 || c == ITALIC.1 => {
                if open != (c == ITALIC.0) {
                    open = !open;
                    out.push(c);
                }
            }
            _ if [RAISED.0, RAISED.1, BELOW.0, BELOW.1].contains(&c) => {
                if small != (c == RAISED.0 || c == BELOW.0) {
                    small = !small;
                    lowered += usize::from(!small);
                    out.push(c);
                }
            }
            LOWERED => {}
            _ if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => {}
            _ => out.push(c),
        }
    }
    if open {
        out.push(ITALIC.1);
    }
    if small {
        out.push(LOWERED);
    }
    out.extend(std::iter::repeat_n(LOWERED, lowered));
    out
}

pub fn text(area: &Area, s: &str, at: Point, anchor: At, size: i32, color: RGBColor) {
    let (h, v, turn) = match anchor {
        At::Left => (HPos::Left, VPos::Center, false),
        At::Right => (HPos::Right, VPos::Center, false),
        At::Middle => (HPos::Center, VPos::Center, false),
        At::Below => (HPos::Center, VPos::Top, false),
        At::Turned => (HPos::Center, VPos::Bottom, true),
    };
    // plotters writes the size divided by 1.24
    let mut look = TextStyle::from((style::current().family.css(), f64::from(size) * 1.24).into_font())
        .color(&color)
        .pos(Pos::new(h, v));
    if turn {
        look = look.transform(FontTransform::Rotate270);
    }
    put(area, Text::new(printable(s), at, look));
}

pub fn line(area: &Area, points: &[Point], color: RGBColor, width: u32) {
    if points.len() > 1 {
        put(area, PathElement::new(points.to_vec(), color.stroke_width(width)));
    }
}

/// Draws a line with dashes and gaps of equal length \[units\].
pub fn dashed(area: &Area, points: &[Point], color: RGBColor, width: u32, dash: f64) {
    let (mut piece, mut left, mut ink): (Vec<Point>, f64, bool) = (vec![], dash, true);
    for w in points.windows(2) {
        let (a, b) = ((f64::from(w[0].0), f64::from(w[0].1)), (f64::from(w[1].0), f64::from(w[1].1)));
        let length = (b.0 - a.0).hypot(b.1 - a.1);
        let mut s = 0.0;
        if piece.is_empty() {
            piece.push(w[0]);
        }
        while length - s > left {
            s += left;
            let k = s / length;
            let p = ((a.0 + k * (b.0 - a.0)).round() as i32, (a.1 + k * (b.1 - a.1)).round() as i32);
            piece.push(p);
            if ink {
                line(area, &piece, color, width);
            }
            (piece, left, ink) = (vec![p], dash, !ink);
        }
        left -= length - s;
        piece.push(w[1]);
    }
    if ink {
        line(area, &piece, color, width);
    }
}

pub fn fill(area: &Area, points: &[Point], color: RGBAColor) {
    put(area, Polygon::new(points.to_vec(), color.filled()));
}

/// Draws a filled rectangle between two corners.
pub fn block(area: &Area, a: Point, b: Point, color: RGBColor) {
    put(area, Rectangle::new([a, b], color.filled()));
}

/// Shapes that can be told apart without colour.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Mark {
    Circle,
    Square,
    Triangle,
    Diamond,
    Ring,
    Cross,
    Down,
}

pub const MARKS: [Mark; 7] =
    [Mark::Circle, Mark::Square, Mark::Triangle, Mark::Diamond, Mark::Ring, Mark::Down, Mark::Cross];

/// Draws the outline of a mark, white inside.
pub fn hollow(area: &Area, shape: Mark, at: Point, r: i32, color: RGBColor) {
    match shape {
        Mark::Ring | Mark::Cross => mark(area, shape, at, r, color),
        _ => {
            mark(area, shape, at, r, color);
            // The centre of a triangle is below the middle of its box
            let down = match shape {
                Mark::Triangle => 1,
                Mark::Down => -1,
                _ => 0,
            };
            mark(area, shape, (at.0, at.1 + down), r - if down == 0 { 7 } else { 11 }, WHITE);
        }
    }
}

pub fn mark(area: &Area, shape: Mark, (x, y): Point, r: i32, color: RGBColor) {
    let poly = |p: &[Point]| {
        let q: Vec<Point> = p.iter().map(|(a, b)| (x + a, y + b)).collect();
        fill(area, &q, color.to_rgba());
    };
    match shape {
        Mark::Circle => put(area, Circle::new((x, y), r, color.filled())),
        Mark::Ring => {
            put(area, Circle::new((x, y), r, WHITE.filled()));
            put(area, Circle::new((x, y), r - 3, color.stroke_width(10)));
        }
        Mark::Square => poly(&[(-r, -r), (r, -r), (r, r), (-r, r)].map(|(a, b)| (a * 9 / 10, b * 9 / 10))),
        Mark::Triangle => poly(&[(-r, r * 8 / 10), (r, r * 8 / 10), (0, -r)]),
        Mark::Down => poly(&[(-r, -r * 8 / 10), (r, -r * 8 / 10), (0, r)]),
        Mark::Diamond => poly(&[(-r, 0), (0, -r * 12 / 10), (r, 0), (0, r * 12 / 10)]),
        Mark::Cross => {
            line(area, &[(x - r, y - r), (x + r, y + r)], color, 10);
            line(area, &[(x - r, y + r), (x + r, y - r)], color, 10);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Luma of Rec. 601, as used by monochrome printers.
    fn grey(RGBColor(r, g, b): RGBColor) -> f64 {
        0.299 * f64::from(r) + 0.587 * f64::from(g) + 0.114 * f64::from(b)
    }

    #[test]
    fn an_index_is_lowered_and_every_mark_is_closed() {
        let of = |words: &str| {
            let svg = super::figure(20.0, 5.0, "", |area| text(area, words, (mm(1.0), mm(2.0)), At::Left, SMALL, INK));
            svg.split_once("<text").expect("a text").1.to_string()
        };
        let shown = of(&format!("{} [N]", italic("F_z*")));
        assert!(!shown.contains('_') && shown.contains(">z</tspan>"), "{shown}");
        assert_eq!(shown.matches("<tspan").count(), shown.matches("</tspan>").count(), "{shown}");
        let cut = of(&italic("F_z").chars().take(5).collect::<String>());
        assert_eq!(cut.matches("<tspan").count(), cut.matches("</tspan>").count(), "{cut}");
        assert_eq!(unmarked(&italic("F_z*")), "F_z*");
        assert_eq!(italic("tip_z_m"), format!("{}tip_z_m{}", ITALIC.0, ITALIC.1), "a name is no symbol");
    }

    #[test]
    fn areas_are_apart_in_grey() {
        let apart = |a: RGBColor, b: RGBColor| (grey(a) - grey(b)).abs() > 40.0;
        assert!(AREAS.windows(2).all(|pair| apart(pair[0], pair[1])));
        assert!(apart(AREAS[0], AREAS[2]));
    }
}
