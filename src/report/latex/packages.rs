//! Packages that the fragments use.

/// The packages that the fragments use, for the preamble of a paper.
pub const PACKAGES: &str = "\\usepackage{booktabs,graphicx,longtable}\n\\usepackage[group-minimum-digits=5]{siunitx}\n";

/// First line of every fragment.
pub const NEEDS: &str = "% needs \\usepackage{booktabs,graphicx,longtable,siunitx}";
