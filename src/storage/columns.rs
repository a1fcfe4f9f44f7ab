//! Numbers from the lines of a text table: the checks that all readers share, and columns selected by name.

use super::table::{DELIMITERS, Decimal, Line, bare, decode, is_number, number, split};
use crate::wording::{first, hint, joined, lines, nearest};
use std::ops::Range;

/// Relative difference below which two unit factors are equal \[–\].
const SAME: f64 = 1e-9;

/// Reason why the columns of a text table could not be read: the fact, the file with its lines, and the remedy.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum TableError {
    #[error("{file}: {what}, not a text table; export the data as CSV or as text with delimiters")]
    NotText { file: String, what: String },
    #[error("{file}: {}", absent(missing, known))]
    Columns { file: String, missing: Vec<String>, known: Vec<String> },
    #[error(
        "{file}: a quotation mark in {} or above is not closed, or a cell has several lines, so lines run together; remove it or export the table again",
        lines(at)
    )]
    Quote { file: String, at: Vec<u64> },
    #[error(
        "{file}: line {} has {cells} cells under {names} names{}: decimal commas cannot be distinguished from the commas between columns; \
         export it with ; or tab between the columns, or with decimal points",
        at[0], others(at)
    )]
    Cells { file: String, at: Vec<u64>, cells: usize, names: usize },
    #[error(
        "{file}: {} other numbers of cells than there are names, {names}; add or remove cells, and put those that hold a delimiter in quotation marks",
        have(at)
    )]
    Uneven { file: String, at: Vec<u64>, names: usize },
    #[error(
        "{file}: line {line}: \"{cell}\" may be a decimal fraction or a number of thousands, and no other cell tells which; write the numbers with \
         points and without separators"
    )]
    Decimal { file: String, line: u64, cell: String },
    #[error(
        "{file}: the decimal mark is a {decimal}, but {} {} the other one; write all numbers with one mark",
        first(cells), if cells.len() == 1 { "has" } else { "have" }
    )]
    TwoDecimals { file: String, cells: Vec<String>, decimal: &'static str },
    #[error("{file}: {}", not_numbers(cells))]
    Numbers { file: String, cells: Vec<String> },
    #[error("{file}: line {line} has {count} columns \"{name}\"; give each a name of its own, or remove all but one")]
    Twice { file: String, line: u64, name: String, count: usize },
    #[error("{file}: {}; correct one of them", facts.join("; "))]
    TwoUnits { file: String, facts: Vec<String> },
}

impl TableError {
    /// Whether the decimal mark of the table is ambiguous, so that stating it resolves the error.
    pub fn is_of_mark(&self) -> bool {
        matches!(self, Self::Decimal { .. } | Self::TwoDecimals { .. })
    }
}

fn absent(missing: &[String], known: &[String]) -> String {
    if let [one] = missing {
        return format!("there is no column \"{one}\"; {}", hint(one, known));
    }
    let named = |name: &String| match nearest(name, known) {
        Some(near) => format!("\"{name}\" (did you mean `{near}`?)"),
        None => format!("\"{name}\""),
    };
    let missing: Vec<String> = missing.iter().map(named).collect();
    let known = if known.is_empty() { "none is known".into() } else { format!("known: {}", joined(known)) };
    format!("there are no columns {}; {known}", joined(&missing))
}

fn others(at: &[u64]) -> String {
    if at.len() == 1 { String::new() } else { format!(", and too many are in {} as well", lines(&at[1..])) }
}

fn have(at: &[u64]) -> String {
    format!("{} {}", lines(at), if at.len() == 1 { "has" } else { "have" })
}

fn not_numbers(cells: &[String]) -> String {
    match cells {
        [one] => format!("{one} is not a finite number; correct or remove the line"),
        _ => format!("{} are no finite numbers; correct or remove the lines", first(cells)),
    }
}

/// Rows below the names of a table: no cell spans several lines, and no row has more numbers than there are names.
pub struct Rows<'a> {
    file: &'a str,
    /// Non-empty lines
    pub body: Vec<&'a Line>,
}

impl<'a> Rows<'a> {
    /// Checks and returns the rows from line `below` on, under the names in line `at`; both count from 0.
    pub fn under(
        file: &'a str,
        delimiter: char,
        lines: &'a [Line],
        at: usize,
        below: usize,
    ) -> Result<Self, TableError> {
        let body: Vec<&Line> = lines[below..].iter().filter(|l| !l.is_empty()).collect();
        let run_together = |l: &&Line| l.cells.iter().any(|c| c.contains('\n'));
        let quotes: Vec<u64> = lines[at..].iter().filter(run_together).map(|l| l.number).collect();
        if !quotes.is_empty() {
            return Err(TableError::Quote { file: file.into(), at: quotes });
        }
        // The decimal commas of such a row were taken for delimiters
        let names = lines[at].cells.len();
        let is_long = |l: &&&Line| delimiter == ',' && l.cells.iter().skip(names).any(|c| is_number(c));
        let long: Vec<&Line> = body.iter().filter(is_long).copied().collect();
        match long.first() {
            None => Ok(Self { file, body }),
            Some(line) => Err(TableError::Cells {
                file: file.into(),
                at: long.iter().map(|l| l.number).collect(),
                cells: line.cells.len(),
                names,
            }),
        }
    }

    /// The decimal mark of the columns at the indices `places`, or the stated one. Refuses numbers that do not determine the mark, and tables that
    /// use both marks: next to `0,7`, `1,700` is not one thousand seven hundred.
    pub fn decimal(&self, places: &[usize], stated: Option<Decimal>) -> Result<Decimal, TableError> {
        if let Some(decimal) = stated {
            return Ok(decimal);
        }
        let cell = |l: &&'a Line, k: &usize| Some((l.number, l.cells.get(*k)?.as_str()));
        let cells = || self.body.iter().flat_map(|l| places.iter().filter_map(move |k| cell(l, k)));
        let decimal = Decimal::of(cells().map(|(_, cell)| cell)).map_err(|open| {
            let line = cells().find(|(_, cell)| *cell == open).map_or(0, |(line, _)| line);
            TableError::Decimal { file: self.file.into(), line, cell: open }
        })?;
        let is_other = |(_, c): &(u64, &str)| c.contains(['.', ',']) && number(c, decimal).is_err() && is_number(c);
        let cells: Vec<String> = cells().filter(is_other).map(|(line, c)| format!("line {line} \"{c}\"")).collect();
        if cells.is_empty() {
            return Ok(decimal);
        }
        Err(TableError::TwoDecimals { file: self.file.into(), cells, decimal: decimal.name() })
    }
}

/// Index of the line of units below the names in line `at`, if the first non-empty line there is one.
pub fn units_below(lines: &[Line], at: usize, is_units: impl Fn(&Line) -> bool) -> Option<usize> {
    (at + 1..lines.len()).find(|k| !lines[*k].is_empty()).filter(|k| is_units(&lines[*k]))
}

/// A table with columns selected by name. A column is referred to by its index in the list of requested names.
#[derive(Clone, Debug)]
pub struct Named {
    file: String,
    names: Line,
    /// The line below the names, if it holds units
    units: Option<Line>,
    /// Non-empty lines below the names and units
    pub rows: Vec<Line>,
    places: Vec<usize>,
    decimal: Decimal,
}

impl Named {
    /// Reads the columns `numbers`, then the columns `texts`, below the first line that names all of them, whatever the encoding, the delimiter and
    /// the decimal mark. A requested name may lack the unit that follows it in brackets in the table.
    pub fn read(
        file: &str,
        bytes: &[u8],
        numbers: &[&str],
        texts: &[&str],
        is_unit: impl Fn(&str) -> bool,
    ) -> Result<Self, TableError> {
        let (text, _) = decode(bytes).map_err(|what| TableError::NotText { file: file.into(), what })?;
        let wanted = [numbers, texts].concat();
        let find = |delimiter: char| {
            let lines = split(&text, delimiter);
            let places = |l: &Line| wanted.iter().map(|name| places(&l.cells, name)).collect::<Option<Vec<_>>>();
            let (at, places) = lines.iter().enumerate().find_map(|(k, l)| Some((k, places(l)?)))?;
            Some((delimiter, lines, at, places))
        };
        let mut found = None;
        for one in DELIMITERS.into_iter().filter_map(find) {
            // A single name may be the beginning of a line that another delimiter divides
            let is_divided = one.1[one.2].cells.len() > 1;
            if found.is_none() || is_divided {
                found = Some(one);
            }
            if is_divided {
                break;
            }
        }
        let (delimiter, lines, at, places) = found.ok_or_else(|| missing(file, &text, &wanted))?;
        if let Some((same, name)) = places.iter().zip(&wanted).find(|(same, _)| same.len() > 1) {
            let (name, line) = ((*name).to_string(), lines[at].number);
            return Err(TableError::Twice { file: file.into(), line, name, count: same.len() });
        }
        let places = places.concat();
        let holds = |c: &String| bare(c).is_empty() || is_unit(bare(c));
        let units = units_below(&lines, at, |l| l.cells.iter().all(holds) && !l.cells.iter().any(|c| is_number(c)));
        let rows = Rows::under(file, delimiter, &lines, at, units.unwrap_or(at) + 1)?;
        let decimal = rows.decimal(&places[..numbers.len()], None)?;
        let (units, rows) = (units.map(|k| lines[k].clone()), rows.body.into_iter().cloned().collect());
        Ok(Self { file: file.into(), names: lines[at].clone(), units, rows, places, decimal })
    }

    /// The name of a column as written in the table.
    pub fn name(&self, column: usize) -> &str {
        &self.names.cells[self.places[column]]
    }

    /// The unit of a column, from the brackets of its name or from the line below.
    pub fn unit(&self, column: usize) -> Option<String> {
        let below = || self.units.as_ref()?.cells.get(self.places[column]).map(|c| bare(c).to_string());
        in_brackets(self.name(column)).map(String::from).or_else(below).filter(|u| !u.is_empty())
    }

    /// The cell of a column in a row; empty if the row is shorter.
    pub fn cell<'a>(&self, row: &'a Line, column: usize) -> &'a str {
        row.cells.get(self.places[column]).map_or("", String::as_str)
    }

    /// The number of a column in a row, or the reason why the cell is not a number.
    pub fn number(&self, row: &Line, column: usize) -> Result<f64, String> {
        number(self.cell(row, column), self.decimal)
    }

    /// \[column\]\[row\] The numbers of columns in some rows; refuses all cells that are not numbers in one error.
    pub fn numbers(&self, columns: Range<usize>, rows: &[&Line]) -> Result<Vec<Vec<f64>>, TableError> {
        let mut wrong = vec![];
        let mut one = |row: &Line, k: usize| {
            self.number(row, k).unwrap_or_else(|_| {
                let (line, cell, name) = (row.number, self.cell(row, k), self.name(k));
                wrong.push(format!("line {line}: \"{cell}\" in column {name}"));
                f64::NAN
            })
        };
        let numbers = columns.map(|k| rows.iter().map(|row| one(row, k)).collect()).collect();
        if wrong.is_empty() { Ok(numbers) } else { Err(TableError::Numbers { file: self.file.clone(), cells: wrong }) }
    }

    /// Refuses rows with fewer or more cells than there are names, because shifted cells would go unnoticed.
    pub fn check_lengths(&self) -> Result<(), TableError> {
        let names = self.names.cells.len();
        let at: Vec<u64> = self.rows.iter().filter(|l| l.cells.len() != names).map(|l| l.number).collect();
        if at.is_empty() { Ok(()) } else { Err(TableError::Uneven { file: self.file.clone(), at, names }) }
    }

    /// Refuses columns whose unit in the table differs from the stated one; any other text in brackets becomes a note. `ratio` returns the quotient
    /// of two units of one quantity.
    pub fn check_units(
        &self,
        stated: &[Option<&str>],
        by: &str,
        ratio: impl Fn(&str, &str) -> Option<f64>,
    ) -> Result<(), TableError> {
        let differs =
            |(k, stated): (usize, &Option<&str>)| of_two_units(self.name(k), &self.unit(k)?, ((*stated)?, by), &ratio);
        let facts: Vec<String> = stated.iter().enumerate().filter_map(differs).collect();
        if facts.is_empty() { Ok(()) } else { Err(TableError::TwoUnits { file: self.file.clone(), facts }) }
    }
}

/// A sentence saying that the unit of a column in the table contradicts the stated one; `None` if they are equal or belong to different quantities.
pub fn of_two_units(
    name: &str,
    own: &str,
    (stated, by): (&str, &str),
    ratio: impl Fn(&str, &str) -> Option<f64>,
) -> Option<String> {
    let fact = || format!("column \"{name}\" is in {own} by the table and in {stated} by the {by}");
    ((ratio(own, stated)? - 1.0).abs() > SAME).then(fact)
}

/// The requested names that the best-matching line lacks, and the names that it has.
fn missing(file: &str, text: &str, wanted: &[&str]) -> TableError {
    let count = |l: &Line| l.cells.iter().filter(|c| !c.is_empty()).count();
    let (mut absent, mut known): (Vec<&str>, Vec<String>) = (wanted.to_vec(), vec![]);
    for delimiter in DELIMITERS {
        let lines = split(text, delimiter);
        let names = lines.iter().find(|l| count(l) > 1).or_else(|| lines.iter().find(|l| !l.is_empty()));
        if let Some(names) = names.filter(|l| count(l) > known.len()) {
            absent = wanted.iter().filter(|name| places(&names.cells, name).is_none()).copied().collect();
            known = names.cells.iter().filter(|c| !c.is_empty()).cloned().collect();
        }
    }
    TableError::Columns { file: file.into(), missing: absent.into_iter().map(String::from).collect(), known }
}

/// The columns with exactly this name, or else without regard to case, or else the only column with this name if units are left out; `None` if no
/// column matches.
fn places(cells: &[String], name: &str) -> Option<Vec<usize>> {
    let same = |cell: &str| cell.trim().eq_ignore_ascii_case(name.trim());
    let all = |is: &dyn Fn(&str) -> bool| (0..cells.len()).filter(|k| is(&cells[*k])).collect::<Vec<usize>>();
    let found = |places: &Vec<usize>| !places.is_empty();
    let exact = Some(all(&|cell| cell.trim() == name.trim())).filter(found);
    let by_unit = || all(&|cell| same(cell.split(['(', '[']).next().unwrap_or_default()));
    exact.or_else(|| Some(all(&same)).filter(found)).or_else(|| Some(by_unit()).filter(|places| places.len() == 1))
}

/// The text in the brackets at the end of a name, if there are any.
pub fn in_brackets(name: &str) -> Option<&str> {
    let inside = name.trim_end().strip_suffix([')', ']'])?;
    Some(inside[inside.rfind(['(', '['])? + 1..].trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(text: &str, numbers: &[&str]) -> Result<Named, TableError> {
        Named::read("a.csv", text.as_bytes(), numbers, &[], |unit| ["mm", "N"].contains(&unit))
    }

    fn values(text: &str, names: &[&str]) -> Vec<Vec<f64>> {
        let table = named(text, names).unwrap_or_else(|e| panic!("{text}: {e}"));
        let rows: Vec<&Line> = table.rows.iter().collect();
        table.numbers(0..names.len(), &rows).unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    #[test]
    fn columns_are_found_by_their_names() {
        let both = vec![vec![1.5, 2.5], vec![2.0, 3.0]];
        assert_eq!(values("u,F\n1.5,2\n2.5,3\n", &["u", "F"]), both);
        assert_eq!(values("note;7\nF (N);u (mm)\n\n2;1,5\n3;2,5\n", &["u", "F"]), both);
        assert_eq!(values("u,F\nmm,N\n1.5,2\n2.5,3\n", &["u", "f"]), both);
        // Exact matches come before those without regard to case
        assert_eq!(values("m,M\n1.5,2\n", &["M"]), [[2.0]]);
        // A single name is not a line that commas divide
        assert_eq!(values("F (N),u (mm)\n1,5\n2,7\n", &["F"]), [[1.0, 2.0]]);
        assert_eq!(values("F (N)\n1,5\n2,25\n", &["F"]), [[1.5, 2.25]]);
    }

    #[test]
    fn all_offenders_are_named_at_once() {
        let refused = |text: &str, names: &[&str]| named(text, names).expect_err(text).to_string();
        let said = refused("u,F\n1,5,2,3\n2,5,2,9\n3,5,3,1\n", &["u", "F"]);
        assert!(said.contains("line 2 has 4 cells under 2 names, and too many are in lines 3, 4 as well"), "{said}");
        let said = refused("u;F\n1.5;2\n2,5;3\n3,5;4\n", &["u", "F"]);
        assert!(said.contains("is a point, but line 3 \"2,5\", line 4 \"3,5\" have the other one"), "{said}");
        let said = refused("a,b\n1,2\n", &["u", "b", "F"]);
        assert!(said.contains("there are no columns \"u\", \"F\"; known: a, b"), "{said}");
        let said = refused("strain,b\n1,2\n", &["strian", "F"]);
        assert!(said.contains("no columns \"strian\" (did you mean `strain`?), \"F\"; known: strain, b"), "{said}");
        assert!(refused("", &["u"]).contains("no column \"u\"; none is known"));
        let table = named("u (mm),F (N)\n1,x\ny,2\n", &["u", "F"]).expect("two columns");
        let rows: Vec<&Line> = table.rows.iter().collect();
        let said = table.numbers(0..2, &rows).expect_err("no numbers").to_string();
        assert!(said.contains("line 3: \"y\" in column u (mm), line 2: \"x\" in column F (N) are no finite"), "{said}");
        let ratio = |own: &str, _: &str| Some(if own == "mm" { 10.0 } else { 0.5 });
        let said = table.check_units(&[Some("cm"), Some("kN")], "study", ratio).expect_err("others").to_string();
        assert!(said.contains("in mm by the table and in cm by the study; column \"F (N)\" is in N"), "{said}");
        assert_eq!(table.check_units(&[None, None], "study", ratio), Ok(()));
        let said = refused("note\nu,F,u,F\n0,1,2,3\n", &["F", "u"]);
        assert!(said.contains("line 2 has 2 columns \"F\"; give each a name of its own"), "{said}");
        assert!(refused("u,U\n1,2\n", &["μ"]).contains("no column") && named("u,U\n1,2\n", &["U"]).is_ok());
        assert!(refused("f,g,f\n1,2,3\n", &["F"]).contains("has 2 columns \"F\""));
        assert_eq!(values("f,g,f\n1,2,3\n", &["g"]), [[2.0]]);
    }
}
