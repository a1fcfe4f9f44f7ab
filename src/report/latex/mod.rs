//! LaTeX that both pdflatex and xelatex compile: text, numbers with units, tables and figures with their captions.
//!
//! A fragment needs `booktabs`, `graphicx`, `longtable` and `siunitx` (version 3); [`PACKAGES`] loads them.

mod column;
mod commands;
mod formula;
mod layout;
mod letters;
mod packages;
mod table;
mod units;
mod widths;

pub use formula::formula;
pub use letters::escape;
pub use packages::PACKAGES;
pub use table::table;
pub use units::{power_of_ten, quantity, unit};

use crate::report::figure::Figure;
use crate::report::numbers::minus_signs;
use packages::NEEDS;

/// Width above which a figure spans both columns of a page \[mm\].
const ONE_COLUMN_MM: f64 = 95.0;

/// Returns a figure environment with caption and label; the PDF has its own size, or less if the text is narrower.
pub fn figure(figure: &Figure) -> String {
    let mm = figure.width_mm();
    let environment = if mm > ONE_COLUMN_MM { "figure*" } else { "figure" };
    format!(
        "{NEEDS}\n\\begin{{{environment}}}[htbp]\n  \\centering\n  \\includegraphics[width=\\ifdim{mm}mm>\\linewidth\\linewidth\\else{mm}mm\\fi]{{{0}}}\n  \\caption{{{1}}}\n  \\label{{fig:{0}}}\n\\end{{{environment}}}\n",
        figure.name,
        escape(&minus_signs(&figure.caption))
    )
}
