//! SVG is the source of every figure; PNG and PDF are made from it with the embedded fonts only.

use crate::report::error::ReportError;
use crate::report::figure::Figure;
use crate::report::files::write;
use crate::report::latex;
use krilla::{Document, geom::Size, page::PageSettings};
use krilla_svg::{SurfaceExt, SvgSettings};
use resvg::{tiny_skia, usvg};
use std::panic::catch_unwind;
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// Resolution of the PNG \[dots per inch\].
const DPI: f32 = 300.0;
/// Resolution of the PNG in pixels per metre, for programs that place the picture.
const PER_METRE: u32 = 11_811;
/// Largest number of pixels of a PNG, eight times an A4 page.
const MOST_PIXELS: u64 = 64 << 20;
/// CSS pixels per inch, the unit of a parsed SVG.
const CSS_DPI: f32 = 96.0;
/// Points per inch, the unit of a PDF.
const POINTS: f32 = 72.0;

static REGULAR: &[u8] = include_bytes!("fonts/LiberationSans-Regular.ttf");
static ITALIC: &[u8] = include_bytes!("fonts/LiberationSans-Italic.ttf");
static SERIF: &[u8] = include_bytes!("fonts/LiberationSerif-Regular.ttf");
static SERIF_ITALIC: &[u8] = include_bytes!("fonts/LiberationSerif-Italic.ttf");

fn fonts() -> Arc<usvg::fontdb::Database> {
    static FONTS: OnceLock<Arc<usvg::fontdb::Database>> = OnceLock::new();
    let load = || {
        let mut db = usvg::fontdb::Database::new();
        db.load_font_data(REGULAR.to_vec());
        for font in [ITALIC, SERIF, SERIF_ITALIC] {
            db.load_font_data(font.to_vec());
        }
        db.set_serif_family("Liberation Serif");
        db.set_sans_serif_family("Liberation Sans");
        Arc::new(db)
    };
    FONTS.get_or_init(load).clone()
}

/// The drawing with a question mark in place of each character that the embedded font lacks, because its layout could fail.
fn with_glyphs(svg: &str) -> String {
    let has_glyph = |c: char| match c {
        // Latin, Greek and Cyrillic, without combining marks
        '\n'
        | '\r'
        | '\t'
        | ' '..='\u{2ff}'
        | '\u{370}'..='\u{482}'
        | '\u{48a}'..='\u{52f}'
        | '\u{1e00}'..='\u{1fff}' => c != '\u{ad}',
        // Punctuation, raised and lowered digits, letters of formulae, arrows, operators, shapes
        '\u{2010}'..='\u{2027}' | '\u{2030}'..='\u{205e}' | '\u{2070}'..='\u{20cf}' | '\u{2100}'..='\u{25ff}' => true,
        _ => false,
    };
    let shown = |c: char| match c {
        // Thin spaces have no glyph of their own
        '\u{2000}'..='\u{200a}' | '\u{202f}' => '\u{a0}',
        c if has_glyph(c) => c,
        _ => '?',
    };
    svg.chars().map(shown).collect()
}

fn parse(name: &str, svg: &str) -> Result<usvg::Tree, ReportError> {
    let options =
        usvg::Options { dpi: CSS_DPI, font_family: "Liberation Sans".into(), fontdb: fonts(), ..Default::default() };
    usvg::Tree::from_str(&with_glyphs(svg), &options)
        .map_err(|e| ReportError::Figure { name: name.into(), what: e.to_string() })
}

/// Renders a PNG at 300 dpi on white.
pub fn png(name: &str, svg: &str) -> Result<Vec<u8>, ReportError> {
    let refuse = |what: &str| ReportError::Figure { name: name.into(), what: what.into() };
    let tree = parse(name, svg)?;
    let scale = DPI / CSS_DPI;
    let size = tree.size().to_int_size().scale_by(scale).ok_or_else(|| refuse("it has no size"))?;
    if u64::from(size.width()) * u64::from(size.height()) > MOST_PIXELS {
        return Err(refuse("it is too large to rasterise"));
    }
    let mut map =
        tiny_skia::Pixmap::new(size.width(), size.height()).ok_or_else(|| refuse("it is too large to rasterise"))?;
    map.fill(tiny_skia::Color::WHITE);
    resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut map.as_mut());
    // The image is opaque, so the alpha channel carries nothing
    let rgb: Vec<u8> = map.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let mut out = vec![];
    let mut encoder = png::Encoder::new(&mut out, map.width(), map.height());
    encoder.set_color(png::ColorType::Rgb);
    // The best level saves a seventh, but takes most of the time of a report
    encoder.set_compression(png::Compression::Default);
    // Large areas of one colour compress best without a filter
    encoder.set_filter(png::FilterType::NoFilter);
    encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: PER_METRE, yppu: PER_METRE, unit: png::Unit::Meter }));
    let mut writer = encoder.write_header().map_err(|e| refuse(&e.to_string()))?;
    writer.write_image_data(&rgb).and_then(|()| writer.finish()).map_err(|e| refuse(&e.to_string()))?;
    Ok(out)
}

/// Renders a PDF of the size stated in the SVG, with the glyphs that it uses embedded. The same figure has the same bytes: no time is written.
pub fn pdf(name: &str, svg: &str) -> Result<Vec<u8>, ReportError> {
    let refuse = |what: String| ReportError::Figure { name: name.into(), what };
    // krilla-svg takes the tree of the usvg that resvg re-exports
    let tree = parse(name, svg)?;
    let points = POINTS / CSS_DPI;
    let size = Size::from_wh(tree.size().width() * points, tree.size().height() * points);
    let size = size.ok_or_else(|| refuse("it has no size".into()))?;
    let mut document = Document::new();
    let mut page = document.start_page_with(PageSettings::new(size));
    let mut surface = page.surface();
    let drawn = surface.draw_svg(&tree, size, SvgSettings::default());
    surface.finish();
    page.finish();
    let written = document.finish().map_err(|e| refuse(format!("{e:?}")))?;
    drawn.map(|()| written).ok_or_else(|| refuse("it has no PDF".into()))
}

/// A figure in all formats that are stored.
pub struct Pictures {
    svg: String,
    png: Vec<u8>,
    pdf: Vec<u8>,
}

impl Pictures {
    /// Converts a figure. Anything that the font layout or a converter cannot handle is an error of this figure alone.
    pub fn of(name: &str, svg: &str) -> Result<Self, ReportError> {
        let convert = || Ok(Self { svg: svg.into(), png: png(name, svg)?, pdf: pdf(name, svg)? });
        catch_unwind(convert).unwrap_or_else(|_| Err(ReportError::drawing(name)))
    }

    /// Writes `<name>.svg`, `.png`, `.pdf`, and `.tex` with the caption, into `dir`.
    pub fn save(&self, dir: &Path, figure: &Figure) -> Result<(), ReportError> {
        let name = &figure.name;
        write(&dir.join(format!("{name}.tex")), latex::figure(figure).as_bytes())?;
        write(&dir.join(format!("{name}.svg")), self.svg.as_bytes())?;
        write(&dir.join(format!("{name}.png")), &self.png)?;
        write(&dir.join(format!("{name}.pdf")), &self.pdf)
    }
}

/// Converts a figure and writes it into `dir`.
pub fn save(dir: &Path, figure: &Figure) -> Result<(), ReportError> {
    Pictures::of(&figure.name, &figure.svg)?.save(dir, figure)
}
