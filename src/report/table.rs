//! Tables as data, written as CSV and LaTeX and embedded in the page.

use crate::report::numbers::{minus_signs, unsigned_zero};
use crate::report::page::escape;

/// Columns with a heading and a unit; cells are text that is ready to print.
pub struct Table {
    pub name: &'static str,
    pub caption: String,
    /// Columns as (heading, unit, whether they hold numbers)
    pub columns: Vec<(String, String, bool)>,
    pub rows: Vec<Vec<String>>,
    /// First cell of the row that is the answer
    pub pick: Option<String>,
}

/// Builds columns from literals: heading, unit, and whether they hold numbers.
pub fn headings(columns: &[(&str, &str, bool)]) -> Vec<(String, String, bool)> {
    columns.iter().map(|(heading, unit, number)| (heading.to_string(), unit.to_string(), *number)).collect()
}

/// Largest number of rows of a table on the page; a browser takes seconds for ten thousand of them
const SHOWN: usize = 500;

impl Table {
    /// Returns the heading of column `k` with its unit.
    pub fn heading(&self, k: usize) -> String {
        let (name, unit, _) = &self.columns[k];
        if unit.is_empty() { name.clone() } else { format!("{name} [{unit}]") }
    }

    /// Returns the caption as a complete sentence, to which another can be appended.
    pub fn sentence(&self) -> String {
        let ends = self.caption.is_empty() || self.caption.ends_with(['.', '?', '!']);
        if ends { self.caption.clone() } else { format!("{}.", self.caption) }
    }

    /// Returns the table for the page; a long one shows the first rows and the answer, and says where the others are.
    pub fn html(&self) -> String {
        let class = |k: usize| if self.columns[k].2 { " class=\"n\"" } else { "" };
        // Many columns may be wider than the text
        let wide = if self.columns.len() > 8 { " wide" } else { "" };
        let is_pick = |row: &[String]| self.pick.as_ref().is_some_and(|p| row.first() == Some(p));
        let mut caption = escape(&self.caption);
        if self.rows.len() > SHOWN {
            let (all, name) = (self.rows.len(), self.name);
            caption = escape(&self.sentence());
            caption += &format!(" Shown are {SHOWN} of {all} rows; all are in <code>tables/{name}.csv</code>.");
        }
        let mut h = format!("<p class=\"caption\">{caption}</p>\n<div class=\"scroll{wide}\"><table>\n<tr>");
        for k in 0..self.columns.len() {
            h += &format!("<th{}>{}</th>", class(k), escape(&self.heading(k)));
        }
        for (_, row) in self.rows.iter().enumerate().filter(|(k, row)| *k < SHOWN || is_pick(row)) {
            let pick = if is_pick(row) { " class=\"pick\"" } else { "" };
            h += &format!("</tr>\n<tr{pick}>");
            for (k, cell) in row.iter().enumerate() {
                h += &format!("<td{}>{}</td>", class(k), escape(&minus_signs(unsigned_zero(cell))));
            }
        }
        h + "</tr>\n</table></div>\n"
    }

    pub fn csv(&self) -> String {
        let line = |cells: Vec<String>| cells.iter().map(|c| quoted(c)).collect::<Vec<_>>().join(",") + "\n";
        let mut out = line((0..self.columns.len()).map(|k| self.heading(k)).collect());
        for row in &self.rows {
            out += &line(row.iter().map(|cell| unsigned_zero(cell).to_string()).collect());
        }
        out
    }
}

/// Returns a cell of a CSV table, quoted by RFC 4180 if it contains a separator.
pub fn quoted(cell: &str) -> String {
    let divides = cell.contains([',', '"', '\n', '\r']) || cell.trim() != cell;
    if divides { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_table_is_cut_on_the_page_and_whole_in_its_file() {
        let rows: Vec<Vec<String>> = (0..3 * SHOWN).map(|k| vec![format!("case {k}")]).collect();
        let last = rows.last().expect("rows")[0].clone();
        let table = Table {
            name: "cases",
            caption: String::new(),
            columns: headings(&[("Case", "", false)]),
            rows,
            pick: Some(last.clone()),
        };
        let page = table.html();
        assert_eq!(page.matches("<td>").count(), SHOWN + 1);
        assert!(
            page.contains(&last) && page.contains("tables/cases.csv"),
            "the answer is shown, and where the rest is"
        );
        assert_eq!(table.csv().lines().count(), 3 * SHOWN + 1);
    }
}
