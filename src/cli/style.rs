//! Flags for the style of figures.

use durometer::report::style::{Style, StyleError};

/// Style of the figures of a command.
#[derive(clap::Args)]
pub struct StyleArgs {
    /// Width of the figures and font size: default (180 mm, 8 pt), one-column (88 mm, 7 pt), two-column (180 mm, 7 pt), slides (254 mm,
    /// 16 pt)
    #[arg(long, value_name = "NAME", default_value = "default")]
    style: String,
    /// Font size of the labels in points, instead of that of the style
    #[arg(long, value_name = "POINTS")]
    font_size: Option<f64>,
    /// Font family: sans or serif
    #[arg(long, value_name = "FAMILY")]
    font: Option<String>,
}

impl StyleArgs {
    /// Returns the style that the flags select.
    pub fn style(&self) -> Result<Style, StyleError> {
        Style::named(&self.style, self.font_size, self.font.as_deref())
    }
}
