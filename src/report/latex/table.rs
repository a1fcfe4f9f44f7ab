//! A table as a float, or where it is long, as one that breaks across pages.

use super::letters::escape;
use super::packages::NEEDS;
use super::units::{Room, number, unit};
use crate::report::numbers::unsigned_zero;
use crate::report::table::Table;

/// Rows of a float; a longer table is set by `longtable`, which a page with two columns does not take.
const FLOAT_ROWS: usize = 40;
/// Characters of a line in the usual size of type.
const LINE: usize = 85;
/// Sizes of type with the characters of a line.
const SIZES: [(&str, usize); 4] =
    [("\\normalsize", LINE), ("\\small", 93), ("\\footnotesize", 105), ("\\scriptsize", 125)];

/// The table with its caption, its label `tab:<name>`, rules of booktabs, and columns of numbers aligned by siunitx.
pub fn table(t: &Table) -> String {
    let columns: Vec<Column> = (0..t.columns.len()).map(|k| Column::of(t, k)).collect();
    let spec: String = columns.iter().map(|c| c.spec.as_str()).collect();
    let head = row(columns.iter().map(|c| c.heading.clone()));
    let body: String =
        (t.rows.iter()).map(|cells| row(columns.iter().zip(cells).map(|(c, cell)| c.cell(cell)))).collect();
    let caption = format!("\\caption{{{}}}\\label{{tab:{}}}", escape(&t.caption), t.name);
    let wide = columns.iter().map(|c| c.width + 2).sum::<usize>();
    let size = SIZES.iter().find(|(_, line)| wide <= *line).map_or("\\tiny", |(size, _)| *size);
    if t.rows.len() > FLOAT_ROWS {
        let head = format!("  \\toprule\n{head}  \\midrule\n");
        return format!(
            "{NEEDS}\n\\begingroup{size}\\setlength{{\\tabcolsep}}{{3pt}}\n\\begin{{longtable}}{{{spec}}}\n  {caption}\\\\\n{head}  \\endfirsthead\n{head}  \\endhead\n  \\bottomrule\n  \\endfoot\n{body}\\end{{longtable}}\n\\endgroup\n"
        );
    }
    let rules =
        format!("\\begin{{tabular}}{{{spec}}}\n  \\toprule\n{head}  \\midrule\n{body}  \\bottomrule\n\\end{{tabular}}");
    // A table that is wider than any size of type takes becomes as wide as the text
    let inside = if size == "\\tiny" {
        format!("\\resizebox{{\\linewidth}}{{!}}{{%\n{rules}}}")
    } else {
        format!("{size}\n{rules}")
    };
    format!("{NEEDS}\n\\begin{{table}}[htbp]\n\\centering\n{caption}\n{inside}\n\\end{{table}}\n")
}

/// How a column is set.
struct Column {
    spec: String,
    heading: String,
    /// Cells are read by siunitx
    numbers: bool,
    /// Characters of its widest cell
    width: usize,
}

impl Column {
    fn of(t: &Table, k: usize) -> Self {
        let (name, si, is_number) = &t.columns[k];
        let cells = || t.rows.iter().filter_map(|row| row.get(k)).map(String::as_str);
        let read: Option<Vec<Option<String>>> = is_number
            .then(|| {
                cells()
                    .map(unsigned_zero)
                    .map(|c| if EMPTY.contains(&c) { Some(None) } else { number(c).map(Some) })
                    .collect()
            })
            .flatten();
        let numbers = read.filter(|read| read.iter().any(Option::is_some));
        let spec = match &numbers {
            Some(read) => read.iter().flatten().fold(Room::default(), |room, n| room.with(n)).column(),
            None if *is_number => "r".into(),
            None => "l".into(),
        };
        let si_text = if si.is_empty() { String::new() } else { unit(si).unwrap_or_else(|| escape(si)) };
        let heading = match (escape(name), si_text) {
            (name, si) if si.is_empty() => name,
            (name, si) => format!("{name} [{si}]"),
        };
        let heading = if numbers.is_some() { format!("{{{heading}}}") } else { heading };
        let title = name.chars().count() + if si.is_empty() { 0 } else { si.chars().count() + 3 };
        let width = cells().map(|c| c.chars().count()).max().unwrap_or(0).max(title);
        Self { spec, heading, numbers: numbers.is_some(), width }
    }

    fn cell(&self, cell: &str) -> String {
        let cell = unsigned_zero(cell);
        match number(cell) {
            Some(number) if self.numbers => number,
            _ if self.numbers => format!("{{{}}}", escape(cell)),
            _ => escape(cell),
        }
    }
}

/// Cells of a column of numbers that have no value.
const EMPTY: [&str; 3] = ["", "–", "-"];

fn row(cells: impl Iterator<Item = String>) -> String {
    format!("  {} \\\\\n", cells.collect::<Vec<_>>().join(" & "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::table::headings;

    fn of(rows: Vec<Vec<&str>>) -> String {
        let rows = rows.into_iter().map(|r| r.into_iter().map(String::from).collect()).collect();
        let columns = headings(&[("Case", "", false), ("Stress", "kPa", true), ("Share", "% of all", true)]);
        table(&Table { name: "t", caption: "100 % of μ".into(), columns, rows, pick: None })
    }

    #[test]
    fn columns_of_numbers_are_aligned_and_others_are_text() {
        let tex = of(vec![vec!["a_1", "-1.25", "3 %"], vec!["b", "–", "4"]]);
        assert!(tex.contains("{lS[table-format=-1.2]r}"), "{tex}");
        assert!(tex.contains("  Case & {Stress [\\unit{\\kilo\\pascal}]} & Share [\\% of all] \\\\"), "{tex}");
        assert!(tex.contains("  a\\_1 & -1.25 & 3 \\% \\\\") && tex.contains("  b & {--} & 4 \\\\"), "{tex}");
        assert!(tex.contains("\\caption{100 \\% of \\ensuremath{\\mu}}\\label{tab:t}"), "{tex}");
    }

    #[test]
    fn a_long_table_breaks_across_pages() {
        assert!(of(vec![vec!["a", "1", "2"]; FLOAT_ROWS]).contains("\\begin{table}[htbp]"));
        assert!(of(vec![vec!["a", "1", "2"]; FLOAT_ROWS + 1]).contains("\\begin{longtable}"));
    }
}
