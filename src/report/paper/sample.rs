//! A document of the generated parts alone, which shows that they compile and how they look.

use crate::report::latex::{PACKAGES, escape};

/// Tables and figures of a report by name, for the document that shows them.
pub struct Parts<'a> {
    pub title: &'a str,
    /// Folder of the tables next to `paper`, empty if the tables themselves are next to it; the figures are in `figures`
    pub tables_in: &'a str,
    pub tables: Vec<&'a str>,
    pub figures: Vec<&'a str>,
}

/// Returns an article that includes the methods, the first table, the first figure and the bibliography, with a comment for each further table and
/// figure; to be compiled in place.
pub fn document(parts: &Parts) -> String {
    let input = |folder: &str, names: &[&str]| {
        let folder = if folder.is_empty() { String::new() } else { format!("{folder}/") };
        let line =
            |(k, name): (usize, &&str)| format!("{}\\input{{../{folder}{name}.tex}}\n", if k == 0 { "" } else { "% " });
        names.iter().enumerate().map(line).collect::<String>()
    };
    format!(
        "% pdflatex paper && bibtex paper && pdflatex paper && pdflatex paper (or xelatex)\n\\documentclass[a4paper]{{article}}\n\\usepackage[margin=22mm]{{geometry}}\n{PACKAGES}\\graphicspath{{{{../figures/}}}}\n\\begin{{document}}\n\\title{{{}}}\n\\author{{}}\n\\date{{}}\n\\maketitle\n\\section*{{Methods}}\n\\input{{methods.tex}}\n\\section*{{Results}}\n{}{}\\bibliographystyle{{unsrt}}\n\\bibliography{{references}}\n\\end{{document}}\n",
        escape(parts.title),
        input(parts.tables_in, &parts.tables),
        input("figures", &parts.figures),
    )
}
