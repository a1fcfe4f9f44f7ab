//! A table as a float or, if it is long, as a table that breaks across pages; both fit the text width.

use super::column::{Column, EMPTY};
use super::layout::{ColumnGroup, Layout, Size};
use super::letters::escape;
use super::packages::NEEDS;
use crate::report::numbers::minus_signs;
use crate::report::table::Table;

/// Largest number of lines of a float; a longer table is set by `longtable`, which does not work in two columns.
const FLOAT_LINES: usize = 40;

/// Returns the table with its caption, its label `tab:<name>`, booktabs rules, and number columns aligned by siunitx. It is no wider than the text of
/// an article.
pub fn table(t: &Table) -> String {
    let t = &with_minus_signs(t);
    let columns: Vec<Column> = (0..t.columns.len()).map(|k| Column::of(t, k)).collect();
    let Layout { size, parts, same } = Layout::of(t, &columns);
    let caption = format!("\\caption{{{}}}\\label{{tab:{}}}", escape(&caption(t, &same)), t.name);
    let gap = format!("{}\\setlength{{\\tabcolsep}}{{{}pt}}", size.command, size.gap);
    let parts: Vec<Rules> = parts.iter().map(|part| Rules::of(t, &columns, part, size)).collect();
    if parts.iter().map(|part| part.lines).sum::<usize>() > FLOAT_LINES {
        let continued = format!("\\caption*{{\\tablename~\\ref{{tab:{}}}, continued}}", t.name);
        let long = parts.iter().enumerate().map(|(k, part)| match k {
            0 => part.long(&caption),
            _ => format!("\\addtocounter{{table}}{{-1}}\n{}", part.long(&continued)),
        });
        return format!("{NEEDS}\n\\begingroup{gap}\n{}\\endgroup\n", long.collect::<String>());
    }
    let inside: Vec<String> = parts.iter().map(Rules::float).collect();
    let inside = inside.join("\n\\par\\medskip\n");
    format!("{NEEDS}\n\\begin{{table}}[htbp]\n\\centering\n{caption}\n{gap}\n{inside}\n\\end{{table}}\n")
}

/// The table with minus signs for reading; its CSV file keeps hyphens.
fn with_minus_signs(t: &Table) -> Table {
    let rows = t.rows.iter().map(|row| row.iter().map(|cell| minus_signs(cell)).collect()).collect();
    Table { name: t.name, caption: minus_signs(&t.caption), columns: t.columns.clone(), rows, pick: None }
}

/// The caption, including the columns that are equal in every row.
fn caption(t: &Table, same: &[(String, String)]) -> String {
    let (without, with): (Vec<_>, Vec<_>) = same.iter().partition(|(_, cell)| EMPTY.contains(&cell.as_str()));
    let with: Vec<String> = with.iter().map(|(heading, cell)| format!("{heading} {cell}")).collect();
    let without: Vec<&str> = without.iter().map(|(heading, _)| heading.as_str()).collect();
    let mut caption = if same.is_empty() { t.caption.clone() } else { t.sentence() };
    for (words, columns) in [("The same in every row", with.join("; ")), ("Without values", without.join("; "))] {
        if !columns.is_empty() {
            caption += &format!(" {words}: {columns}.");
        }
    }
    caption.trim_start().into()
}

/// Columns with their head and rows as LaTeX.
struct Rules {
    spec: String,
    head: String,
    body: String,
    /// Number of lines of the head and the rows
    lines: usize,
}

impl Rules {
    fn of(t: &Table, columns: &[Column], part: &ColumnGroup, size: Size) -> Self {
        let row = |cells: Vec<String>| format!("  {} \\\\\n", cells.join(" & "));
        let of = |(k, wide): &(usize, f64)| (&columns[*k], *k, *wide);
        let lines = |cells: &[String]| part.iter().map(of).map(|(c, k, wide)| c.lines(&cells[k], wide)).max();
        let heads: Vec<(usize, String)> = part.iter().map(of).map(|(c, _, wide)| c.head(wide)).collect();
        let tallest = heads.iter().map(|(lines, _)| *lines).max().unwrap_or(0);
        Self {
            spec: part.iter().map(of).map(|(c, _, wide)| c.spec(wide, size.scale)).collect(),
            head: row(heads.into_iter().map(|(_, head)| head).collect()),
            body: t
                .rows
                .iter()
                .map(|cells| row(part.iter().map(of).map(|(c, k, wide)| c.cell(&cells[k], wide)).collect()))
                .collect(),
            lines: tallest + t.rows.iter().filter_map(|cells| lines(cells)).sum::<usize>(),
        }
    }

    /// Sets a table that does not break and is no wider than the text of any document.
    fn float(&self) -> String {
        let Self { spec, head, body, .. } = self;
        let rules = format!(
            "\\begin{{tabular}}{{{spec}}}\n  \\toprule\n{head}  \\midrule\n{body}  \\bottomrule\n\\end{{tabular}}"
        );
        format!("\\resizebox{{\\ifdim\\width>\\linewidth\\linewidth\\else\\width\\fi}}{{!}}{{%\n{rules}}}")
    }

    /// Sets a table that breaks across pages.
    fn long(&self, caption: &str) -> String {
        let Self { spec, body, .. } = self;
        let head = format!("  \\toprule\n{}  \\midrule\n", self.head);
        format!(
            "\\begin{{longtable}}{{{spec}}}\n  {caption}\\\\\n{head}  \\endfirsthead\n{head}  \\endhead\n  \\bottomrule\n  \\endfoot\n{body}\\end{{longtable}}\n"
        )
    }
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
    fn ranges_have_minus_signs() {
        let tex = of(vec![vec!["-23.0 to -1.2", "-1", "3"], vec!["a-1", "2", "4"]]);
        assert!(
            tex.contains("  \\ensuremath{-}23.0 to \\ensuremath{-}1.2 & -1 & 3 ") && tex.contains("  a-1 & "),
            "{tex}"
        );
    }

    #[test]
    fn what_is_the_same_in_every_row_follows_the_caption_as_a_sentence() {
        let columns = headings(&[("Case", "", false), ("Coefficientofrestitution", "", true)]);
        let columns = columns.iter().cloned().chain(vec![columns[1].clone(); 5]).collect();
        let rows = ["a", "b"].map(|case| [case, "1", "1", "1", "1", "1", "1"].map(String::from).to_vec()).to_vec();
        let tex = table(&Table { name: "t", caption: "Noise of the record".into(), columns, rows, pick: None });
        assert!(tex.contains("\\caption{Noise of the record. The same in every row: "), "{tex}");
    }

    #[test]
    fn every_part_of_a_divided_table_tells_its_rows_apart() {
        let names = ["Quantity", "Variant"].into_iter().chain(["Coefficientofrestitution"; 6]);
        let columns = names.enumerate().map(|(k, name)| (name.to_string(), String::new(), k > 1)).collect();
        let pairs = [("angle", "length"), ("angle", "load"), ("tension", "length"), ("tension", "load")];
        let row = |(k, (quantity, variant)): (usize, (&str, &str))| {
            [quantity, variant].map(String::from).into_iter().chain(vec![k.to_string(); 6]).collect()
        };
        let rows = pairs.into_iter().enumerate().map(row).collect();
        let tex = table(&Table { name: "t", caption: String::new(), columns, rows, pick: None });
        let parts = tex.matches("\\begin{tabular}{").count();
        assert!(parts > 1, "{tex}");
        for (quantity, variant) in pairs {
            assert_eq!(tex.matches(&format!("  {quantity} & {variant} & ")).count(), parts, "{tex}");
        }
    }

    #[test]
    fn a_long_table_breaks_across_pages() {
        assert!(of(vec![vec!["a", "1", "2"]; FLOAT_LINES - 1]).contains("\\begin{table}[htbp]"));
        assert!(of(vec![vec!["a", "1", "2"]; FLOAT_LINES]).contains("\\begin{longtable}"));
    }
}
