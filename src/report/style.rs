//! Style of figures: width on the page, size and family of the type.
//!
//! Figures are laid out on a sheet with 8-point type; the drawing is then scaled to the type size of the style. A column of 88 mm with 7-point type
//! is a sheet of 101 mm. A figure that needs a wider sheet is scaled down to the width of the style, together with its type.

use std::cell::Cell;

/// Size of labels on the sheet \[pt\].
const SHEET_PT: f64 = 8.0;

/// Font family, with embedded fonts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    Sans,
    Serif,
}

impl Family {
    /// Returns font names for a drawing that is shown where the fonts are not embedded.
    pub fn css(self) -> &'static str {
        match self {
            Self::Sans => "Liberation Sans, Arial, Helvetica, sans-serif",
            Self::Serif => "Liberation Serif, Times New Roman, Times, serif",
        }
    }
}

/// Appearance of all figures of a report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Width of the largest figures \[mm\]
    pub width_mm: f64,
    /// Size of labels \[pt\]; annotations have 7/8 of this size
    pub font_pt: f64,
    pub family: Family,
}

/// Styles by name.
pub const STYLES: [(&str, Style); 4] = [
    ("default", Style { width_mm: 180.0, font_pt: 8.0, family: Family::Sans }),
    ("one-column", Style { width_mm: 88.0, font_pt: 7.0, family: Family::Sans }),
    ("two-column", Style { width_mm: 180.0, font_pt: 7.0, family: Family::Sans }),
    ("slides", Style { width_mm: 254.0, font_pt: 16.0, family: Family::Sans }),
];

/// Range of type sizes that can be read on paper or from the last row \[pt\].
const SIZES: std::ops::RangeInclusive<f64> = 4.0..=48.0;

/// Error for a style that does not exist.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum StyleError {
    #[error("\"{0}\" is no style of figures; known: {known}", known = STYLES.map(|(name, _)| name).join(", "))]
    Unknown(String),
    #[error("a type of {pt} points cannot be read; give {} to {}", SIZES.start(), SIZES.end(), pt = .0)]
    Size(f64),
    #[error("\"{0}\" is no family of type that is embedded; known: sans, serif")]
    Family(String),
}

impl Style {
    /// Returns the style with this name, with another type size or family if given.
    ///
    /// # Errors
    /// Returns an error for a name, a size or a family that does not exist.
    pub fn named(name: &str, font_pt: Option<f64>, family: Option<&str>) -> Result<Self, StyleError> {
        let style = STYLES.iter().find(|(known, _)| *known == name).map(|(_, style)| *style);
        let mut style = style.ok_or_else(|| StyleError::Unknown(name.into()))?;
        if let Some(pt) = font_pt {
            style.font_pt = if SIZES.contains(&pt) { pt } else { return Err(StyleError::Size(pt)) };
        }
        style.family = match family {
            None => style.family,
            Some("sans") => Family::Sans,
            Some("serif") => Family::Serif,
            Some(other) => return Err(StyleError::Family(other.into())),
        };
        Ok(style)
    }

    /// Returns the width of the sheet for a figure of full width \[mm\].
    pub fn sheet(self) -> f64 {
        self.width_mm * SHEET_PT / self.font_pt
    }

    /// Returns the factor from a sheet of this width to the page.
    pub fn zoom(self, sheet: f64) -> f64 {
        (self.font_pt / SHEET_PT).min(self.width_mm / sheet)
    }
}

thread_local! {
    static STYLE: Cell<Style> = const { Cell::new(STYLES[0].1) };
}

/// Returns the style of the figures drawn by this thread.
pub fn current() -> Style {
    STYLE.get()
}

/// Runs `draw` in a style, which applies to all figures drawn in this thread.
pub fn within<T>(style: Style, draw: impl FnOnce() -> T) -> T {
    struct Back(Style);
    impl Drop for Back {
        fn drop(&mut self) {
            STYLE.set(self.0);
        }
    }
    let _back = Back(STYLE.replace(style));
    draw()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_style_ends_with_its_drawing() {
        let slides = Style::named("slides", Some(20.0), Some("serif")).expect("a style");
        assert_eq!((slides.width_mm, slides.font_pt, slides.family), (254.0, 20.0, Family::Serif));
        assert_eq!(within(slides, current), slides);
        assert_eq!(current(), STYLES[0].1);
        assert!(std::panic::catch_unwind(|| within(slides, || panic!("a bug"))).is_err());
        assert_eq!(current(), STYLES[0].1, "also after a panic");
    }

    #[test]
    fn mistakes_are_refused() {
        assert_eq!(Style::named("nature", None, None), Err(StyleError::Unknown("nature".into())));
        for pt in [f64::NAN, 0.0, -8.0, 1e9] {
            assert!(matches!(Style::named("default", Some(pt), None), Err(StyleError::Size(_))));
        }
        assert_eq!(Style::named("default", None, Some("x")), Err(StyleError::Family("x".into())));
    }
}
