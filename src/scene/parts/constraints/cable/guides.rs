//! Guide points of cables from a CSV or JSON file.
//!
//! A CSV file has one point per row, x, y, z, and the name of its cable in a fourth column if it holds several cables. Columns are separated by commas,
//! semicolons (decimal commas are then allowed), tabs or blanks. `#` begins a comment at the start of a line or after a blank outside of quotes; in a name
//! only if a blank follows it too. A header is optional; with one, the columns `x`, `y`, `z` and `name` or `cable` may come in any order, among others, and a
//! unit in their brackets must be that of the scene. A JSON file is a list of points, a list of such lists, or an object of such lists by name.

use crate::math::tensor::Vec3;
use crate::math::units;
use crate::scene::error::hint;
use crate::storage::columns::{in_brackets, of_two_units};
use crate::storage::{self, DATA_LIMIT};
use crate::wording;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Points \[unit of the file\] of one cable, with its name if the file has one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Listed {
    pub name: Option<String>,
    pub points: Vec<Vec3>,
}

/// Reason why no guides can be read from a file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(super) enum GuideFileError {
    #[error("{}: cannot be read: {reason}; {}", file.display(), path_remedy(file))]
    Unreadable { file: PathBuf, reason: String },
    #[error("{}: line {line} is not UTF-8; save the file as UTF-8", file.display())]
    Encoding { file: PathBuf, line: usize },
    #[error("{}: this is no file of guides that is read; give a .csv or a .json", file.display())]
    Format { file: PathBuf },
    #[error("{}: {}; {remedy}", file.display(), wording::first(faults))]
    Rows { file: PathBuf, faults: Vec<String>, remedy: &'static str },
    #[error("{}: it has no cable \"{name}\"; {hint}", file.display())]
    NoCable { file: PathBuf, name: String, hint: String },
}

fn path_remedy(file: &Path) -> &'static str {
    match file.to_string_lossy().contains('\\') {
        true => "write / in place of \\ in paths: a scene is the same on every system",
        false => "check the path, which is relative to the scene",
    }
}

/// Reads a file, whose header must not state a unit different from that of the scene; all faults of its rows are in one error. With `only`, returns only the
/// cable of this name.
pub(super) fn read_guides(file: &Path, unit: &str, only: Option<&str>) -> Result<Vec<Listed>, GuideFileError> {
    let unreadable = |e: std::io::Error| GuideFileError::Unreadable { file: file.into(), reason: e.to_string() };
    let text = decoded(&storage::read(file, DATA_LIMIT).map_err(unreadable)?)
        .map_err(|line| GuideFileError::Encoding { file: file.into(), line })?;
    let cables = match file.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("csv" | "txt") => csv(&text, unit),
        Some("json") => json(&text)
            .map_err(|faults| (faults, "give [[x, y, z], …], a list of these, or { \"name\": [[x, y, z], …], … }")),
        _ => return Err(GuideFileError::Format { file: file.into() }),
    };
    let mut cables = cables.map_err(|(faults, remedy)| GuideFileError::Rows { file: file.into(), faults, remedy })?;
    if let Some(name) = only {
        let names: Vec<String> = cables.iter().filter_map(|c| c.name.clone()).collect();
        cables.retain(|c| c.name.as_deref() == Some(name));
        if cables.is_empty() {
            let hint = if names.is_empty() { "its cables have no names".into() } else { hint(name, &names) };
            return Err(GuideFileError::NoCable { file: file.into(), name: name.into(), hint });
        }
    }
    Ok(cables)
}

/// Decodes UTF-8 with or without a byte order mark, or UTF-16 with one; the error is the number of the first line that is neither.
fn decoded(bytes: &[u8]) -> Result<String, usize> {
    let wide = |units: fn([u8; 2]) -> u16| {
        let units = bytes[2..].chunks_exact(2).map(|b| units([b[0], b[1]]));
        char::decode_utf16(units).collect::<Result<String, _>>().map_err(|_| 1)
    };
    match bytes {
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes),
        _ => {
            let bytes = bytes.strip_prefix(&[0xef, 0xbb, 0xbf]).unwrap_or(bytes);
            let line = |at: usize| 1 + bytes[..at].iter().filter(|b| **b == b'\n').count();
            std::str::from_utf8(bytes).map(String::from).map_err(|e| line(e.valid_up_to()))
        }
    }
}

/// Facts, and the remedy.
type Faults = (Vec<String>, &'static str);

const ROW: &str = "a row is x, y, z, and a name if there are several cables";

/// Indices of the columns.
struct Columns {
    of: [usize; 3],
    name: Option<usize>,
    /// Number of cells of a row
    count: usize,
}

impl Columns {
    /// The columns of a header: its names with their units in brackets, which must be that of the scene.
    fn named(cells: &[String], unit: &str) -> Result<Self, Faults> {
        let title = |cell: &String| cell.split(['[', '(']).next().unwrap_or_default().trim().to_lowercase();
        let titles: Vec<String> = cells.iter().map(title).collect();
        let find = |name: &str| titles.iter().position(|t| t == name);
        let [Some(x), Some(y), Some(z)] = ["x", "y", "z"].map(find) else {
            return Err((vec![format!("its header ({}) has no columns x, y and z", cells.join(", "))], ROW));
        };
        let differs = |k: usize| of_two_units(&cells[k], in_brackets(&cells[k])?, (unit, "scene"), units::ratio);
        let facts: Vec<String> = [x, y, z].into_iter().filter_map(differs).collect();
        if !facts.is_empty() {
            return Err((facts, "correct one of them"));
        }
        Ok(Self { of: [x, y, z], name: find("name").or_else(|| find("cable")), count: cells.len() })
    }

    /// The columns of a first row without a header: three numbers, with a name before or after them. Four numbers do not show which of them is the name.
    fn of_row(cells: &[String]) -> Result<Self, Faults> {
        if cells.len() == 4 && cells.iter().all(|cell| number(cell).is_some()) {
            let fact = format!("its rows have four numbers ({}) and no header", cells.join(", "));
            return Err((vec![fact], "give a header such as `id, x, y, z` or `x, y, z, name`"));
        }
        let after = Self { of: [0, 1, 2], name: (cells.len() == 4).then_some(3), count: cells.len().clamp(3, 4) };
        let named_first = cells.len() == 4 && number(&cells[0]).is_none();
        Ok(if named_first { Self { of: [1, 2, 3], name: Some(0), ..after } } else { after })
    }
}

/// A line without its comment, which begins with a `#` after a blank outside of quotes; in the column of names a blank must follow the `#` too.
fn without_comment(line: &str, separator: Option<char>, names: Option<usize>) -> &str {
    let (mut column, mut is_quoted, mut before) = (0, false, ' ');
    for (at, c) in line.char_indices() {
        let begins_column = separator.map_or(before.is_whitespace() && !c.is_whitespace() && at > 0, |s| c == s);
        column += usize::from(begins_column);
        is_quoted ^= c == '"';
        let is_in_name = names == Some(column) && !line[at + c.len_utf8()..].starts_with(char::is_whitespace);
        if c == '#' && before.is_whitespace() && !is_quoted && !is_in_name {
            return line[..at].trim_end();
        }
        before = c;
    }
    line
}

fn csv(text: &str, unit: &str) -> Result<Vec<Listed>, Faults> {
    let rows = (1..).zip(text.lines().map(str::trim));
    let mut rows = rows.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')).peekable();
    let Some(&(_, first)) = rows.peek() else { return Err((vec!["it has no row".into()], ROW)) };
    let first = without_comment(first, None, None);
    let separator = [';', '\t', ','].into_iter().find(|c| first.contains(*c));
    let split = |line: &str| -> Vec<String> {
        let trim = |cell: &str| cell.trim().trim_matches('"').to_string();
        match separator {
            Some(';') => line.split(';').map(|cell| trim(cell).replace(',', ".")).collect(),
            Some(c) => line.split(c).map(trim).collect(),
            None => line.split_whitespace().map(trim).collect(),
        }
    };
    let cells = split(first);
    let numbers = cells.iter().filter(|cell| number(cell).is_some()).count();
    let columns = match numbers {
        0 => {
            rows.next();
            Columns::named(&cells, unit)?
        }
        _ => Columns::of_row(&cells)?,
    };
    let (mut cables, mut faults) = (Vec::<Listed>::new(), Vec::new());
    for (line, row) in rows {
        let row = without_comment(row, separator, columns.name);
        let cells = split(row);
        if cells.len() != columns.count {
            faults.push(format!("line {line} has {} columns instead of {}", cells.len(), columns.count));
            continue;
        }
        match columns.of.map(|k| number(&cells[k])) {
            [Some(x), Some(y), Some(z)] => add(&mut cables, columns.name.map(|k| cells[k].clone()), Vec3::new(x, y, z)),
            _ => faults.push(format!("line {line} (\"{row}\") has no three numbers")),
        }
    }
    if cables.is_empty() && faults.is_empty() {
        faults.push("it has no row below its header".into());
    }
    if faults.is_empty() { Ok(cables) } else { Err((faults, ROW)) }
}

fn number(cell: &str) -> Option<f64> {
    cell.parse::<f64>().ok().filter(|v| v.is_finite())
}

/// Adds a point to the cable of this name, which is created if it is new.
fn add(cables: &mut Vec<Listed>, name: Option<String>, point: Vec3) {
    match cables.iter_mut().find(|c| c.name == name) {
        Some(cable) => cable.points.push(point),
        None => cables.push(Listed { name, points: vec![point] }),
    }
}

fn json(text: &str) -> Result<Vec<Listed>, Vec<String>> {
    let value: Value = serde_json::from_str(text).map_err(|e| vec![format!("it is no JSON: {e}")])?;
    let mut faults = Vec::new();
    let is_point = |v: &Value| v.as_array().is_some_and(|a| a.iter().all(Value::is_number));
    let cables: Vec<Listed> = match &value {
        Value::Array(points) if points.iter().all(is_point) => {
            vec![Listed { name: None, points: points_of("point", points, &mut faults) }]
        }
        Value::Array(lists) => {
            let one = |(k, list): (usize, &Value)| list_of(format!("list {}", k + 1), None, list, &mut faults);
            lists.iter().enumerate().map(one).collect()
        }
        Value::Object(lists) => {
            let one = |(name, list): (&String, &Value)| list_of(name.clone(), Some(name.clone()), list, &mut faults);
            lists.iter().map(one).collect()
        }
        _ => return Err(vec!["it holds neither a list nor an object".into()]),
    };
    if cables.iter().all(|c| c.points.is_empty()) && faults.is_empty() {
        faults.push("it has no point".into());
    }
    if faults.is_empty() { Ok(cables) } else { Err(faults) }
}

fn list_of(place: String, name: Option<String>, list: &Value, faults: &mut Vec<String>) -> Listed {
    let Some(points) = list.as_array() else {
        faults.push(format!("{place} is no list of points"));
        return Listed { name, points: Vec::new() };
    };
    Listed { name, points: points_of(&format!("{place}, point"), points, faults) }
}

fn points_of(place: &str, points: &[Value], faults: &mut Vec<String>) -> Vec<Vec3> {
    let mut out = Vec::new();
    for (k, point) in points.iter().enumerate() {
        let numbers: Option<Vec<f64>> =
            point.as_array().and_then(|all| all.iter().map(|v| v.as_f64().filter(|v| v.is_finite())).collect());
        match numbers.as_deref() {
            Some([x, y, z]) => out.push(Vec3::new(*x, *y, *z)),
            _ => faults.push(format!("{place} {} ({point}) is not three numbers", k + 1)),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(name: &str, content: &[u8]) -> Result<Vec<Listed>, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join(name);
        std::fs::write(&file, content).expect("writable");
        read_guides(&file, "mm", None).map_err(|e| e.to_string())
    }

    fn listed(name: Option<&str>, points: &[[f64; 3]]) -> Listed {
        Listed { name: name.map(String::from), points: points.iter().map(|p| Vec3::from(*p)).collect() }
    }

    #[test]
    fn the_usual_forms_are_read() {
        let one = vec![listed(None, &[[1.0, 2.0, 3.5], [-4.0, 5.0, 6e-1]])];
        let forms: [&[u8]; 7] = [
            b"1,2,3.5\n-4,5,0.6\n",
            b"x,y,z\r\n1,2,3.5\r\n-4,5,6e-1\r\n",
            b"\xef\xbb\xbfx [mm];y [mm];z [mm]\n1;2;3,5\n-4;5;0,6",
            b"# a comment\n1 2 3.5\n\n  -4  5 0.6 # the last\n",
            b"z\tx\ty\ttag\n3.5\t1\t2\ta\n0.6\t-4\t5\tb\n",
            b"\"x\",\"y\",\"z\"\n\"1\",\"2\",\"3.5\"\n-4,5,.6\n",
            b"\xff\xfe1\0,\x002\0,\x003\0.\x005\0\n\0-\x004\0,\x005\0,\x000\0.\x006\0",
        ];
        for form in forms {
            assert_eq!(read("a.csv", form), Ok(one.clone()), "{}", String::from_utf8_lossy(form));
        }
        assert_eq!(read("a.json", b"[[1, 2, 3.5], [-4, 5, 0.6]]"), Ok(one));
        let two =
            vec![listed(Some("east"), &[[1.0, 2.0, 3.0]]), listed(Some("west"), &[[4.0, 5.0, 6.0], [7.0, 8.0, 9.0]])];
        let rows = b"cable,x,y,z\neast,1,2,3\nwest,4,5,6\nwest,7,8,9\n";
        assert_eq!(read("a.csv", rows), Ok(two.clone()));
        assert_eq!(read("a.CSV", &rows[12..]), Ok(two.clone()));
        let object = b"{\"east\": [[1, 2, 3]], \"west\": [[4, 5, 6], [7, 8, 9]]}";
        assert_eq!(read("a.json", object), Ok(two.clone()));
        let unnamed: Vec<Listed> = two.into_iter().map(|c| Listed { name: None, ..c }).collect();
        assert_eq!(read("a.json", b"[[[1, 2, 3]], [[4, 5, 6], [7, 8, 9]]]"), Ok(unnamed));
    }

    /// Numbers of points before the coordinates are not read as the first coordinate, nor heights as names of cables.
    #[test]
    fn four_numbers_need_a_header() {
        let rows = b"1, 10, 20, 30\n2, 40, 50, 60\n";
        let told = read("a.csv", rows).expect_err("ambiguous");
        assert!(
            told.contains("its rows have four numbers (1, 10, 20, 30) and no header; give a header such as"),
            "{told}"
        );
        let points = vec![listed(None, &[[10.0, 20.0, 30.0], [40.0, 50.0, 60.0]])];
        assert_eq!(read("a.csv", &[&b"id, x, y, z\n"[..], rows].concat()), Ok(points));
        let named = read("a.csv", &[&b"x, y, z, name\n"[..], rows].concat()).expect("names");
        assert_eq!(named[0], listed(Some("30"), &[[1.0, 10.0, 20.0]]));
    }

    /// Names may contain a `#`; after numbers and quotes it begins a comment.
    #[test]
    fn names_may_hold_a_number_sign() {
        let cables = ["cable #1", "cable #2"].map(|name| listed(Some(name), &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]));
        let forms: [&[u8]; 5] = [
            b"x,y,z,name # four\n1,2,3,cable #1\n4,5,6,cable #1\n1,2,3,cable #2\n4,5,6,cable #2\n",
            b"1,2,3,cable #1\n4,5,6,cable #1\n# more\n  # and more\n1,2,3,cable #2\n4,5,6,cable #2\n",
            b"cable;x;y;z\ncable #1;1;2;3\ncable #1;4;5;6 # the end\ncable #2;1;2;3\ncable #2;4;5;6\n",
            b"name\tx\ty\tz\ncable #1\t1\t2\t3\ncable #1\t4\t5\t6\t# the end\ncable #2\t1\t2\t3\ncable #2\t4\t5\t6\n",
            b"x,y,z,name\n1,2,3,\"cable #1\"\n4,5,6,\"cable #1\"\n1,2,3,\"cable #2\"\n4,5,6,\"cable #2\"\n",
        ];
        for form in forms {
            assert_eq!(read("a.csv", form), Ok(cables.to_vec()), "{}", String::from_utf8_lossy(form));
        }
        let blanks = read("a.csv", b"1 2 3 #a\n4 5 6\n").expect("a comment");
        assert_eq!(blanks, [listed(None, &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])]);
        let named = read("a.csv", b"x y z name\n1 2 3 #1 # a comment\n").expect("a name");
        assert_eq!(named, [listed(Some("#1"), &[[1.0, 2.0, 3.0]])]);
        let told = read("a.csv", b"1,2,3,north # tip\n4,5,6,north # root\n").expect("a name");
        assert_eq!(told, [listed(Some("north"), &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])]);
    }

    #[test]
    fn all_faults_are_in_one_message() {
        let says = |name: &str, content: &[u8], parts: &[&str]| {
            let error = read(name, content).expect_err("faults");
            assert!(parts.iter().all(|part| error.contains(part)), "{error}");
        };
        says(
            "a.csv",
            b"1,2,3\n4,5\n6,7,eight\n9,nan,1\n",
            &["line 2 has 2 columns instead of 3", "line 3 (\"6,7,eight\")", "line 4"],
        );
        says("a.csv", b"a,b,c\n1,2,3\n", &["its header (a, b, c) has no columns x, y and z"]);
        says("a.csv", b"x,y,z\n", &["no row below its header"]);
        let [x, z] = ["x [m]", "z (cm)"].map(|name| format!("column \"{name}\" is in "));
        let both = [&*x, &*z, "m by the table and in mm by the scene", "correct one of them"];
        says("a.csv", b"x [m],y [millimeter],z (cm)\n20,10,15\n", &both);
        says("a.csv", b"", &["it has no row"]);
        says("a.csv", b"1,2,3\n4,5,6 \xb5\n", &["line 2 is not UTF-8"]);
        says("a.json", b"[[1, 2], [1, 2, 3], [1, 2, \"3\"]]", &["is not three numbers"]);
        says(
            "a.json",
            b"{\"a\": [[1, 2]], \"b\": 3}",
            &["a, point 1 ([1,2]) is not three numbers", "b is no list of points"],
        );
        says("a.json", b"[[1, 2, 3]", &["it is no JSON", "line 1"]);
        says("a.xlsx", b"", &["give a .csv or a .json"]);
        let windows = read_guides(Path::new("..\\no\\guides.csv"), "mm", None).expect_err("no file").to_string();
        assert!(windows.contains("write / in place of \\"), "{windows}");
        let many = "1,2\n".repeat(40);
        says("a.csv", format!("1,2,3\n{many}").as_bytes(), &["line 9 has 2 columns", "and 32 more"]);
    }
}
