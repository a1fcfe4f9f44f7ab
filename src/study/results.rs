//! Reads what a study run has left: `study.json`, `cases/<id>.json`, `.csv` and `.skin.json.gz`.

use crate::calibrate::inverse::Calibration;
use crate::report::error::ReportError;
use crate::report::files::{json, read_with};
use crate::study::record::{CaseRecord, SCHEMA, Series, StoredCase, StudyRecord};
use crate::study::skin::Skin;
use std::collections::{BTreeMap, HashSet};
use std::io::ErrorKind;
use std::path::Path;

/// A study and the cases that have a result, in the order of its families.
pub struct Results {
    pub study: StudyRecord,
    pub cases: Vec<StoredCase>,
    /// Case id → surface, where one was stored
    pub skins: BTreeMap<String, Skin>,
    /// Case id → constants that were found there
    pub found: BTreeMap<String, Calibration>,
    /// Case id → derivatives of its columns by such constants, `d bending_angle_deg/d laws.rubber.mu`
    pub sensitivities: BTreeMap<String, Series>,
}

/// Cases of the study that have no files yet are left out; a file that is there must be sound.
pub fn read(dir: &Path) -> Result<Results, ReportError> {
    let path = dir.join("study.json");
    let study: StudyRecord = json(&path)?.ok_or_else(|| ReportError::NotAStudy { path: path.clone() })?;
    if study.schema > SCHEMA {
        return Err(ReportError::Newer { path, found: study.schema, known: SCHEMA });
    }
    let (mut cases, mut skins): (Vec<StoredCase>, _) = (vec![], BTreeMap::new());
    let (mut found, mut sensitivities) = (BTreeMap::new(), BTreeMap::new());
    let mut seen = HashSet::new();
    for id in study.families.iter().flat_map(|f| &f.cases) {
        if !seen.insert(id) {
            continue;
        }
        let file = |extension: &str| dir.join("cases").join(format!("{id}.{extension}"));
        let Some(record) = json::<CaseRecord>(&file("json"))? else { continue };
        let curves = series(&file("csv"))?.unwrap_or_default();
        cases.push(StoredCase { record, series: curves });
        found.extend(json::<Calibration>(&file("fit.json"))?.map(|c| (id.clone(), c)));
        sensitivities.extend(series(&file("sensitivities.csv"))?.map(|s| (id.clone(), s)));
        // Unpacked by hand it is read too
        let skin = match read_with(&file("skin.json.gz"), Skin::unpacked)? {
            Some(skin) => Some(skin),
            None => read_with(&file("skin.json"), Skin::unpacked)?,
        };
        if let Some(skin) = skin.filter(sound) {
            skins.insert(id.clone(), skin);
        }
    }
    if cases.is_empty() {
        return Err(ReportError::NoCases { path: dir.join("cases") });
    }
    Ok(Results { study, cases, skins, found, sensitivities })
}

/// A surface whose arrays fit together; another one is not drawn.
fn sound(s: &Skin) -> bool {
    let n = s.points.len();
    let inside = |triangles: &[[u32; 3]], n: usize| triangles.iter().flatten().all(|k| (*k as usize) < n);
    let rigid = s.rigids.iter().all(|r| inside(&r.triangles, r.points.len()));
    s.displacement.len() == n && s.stretch.len() == n && inside(&s.triangles, n) && rigid
}

/// Columns of numbers under a header; the first one is `t_s`. An empty cell is not a number and reads as NaN.
fn series(path: &Path) -> Result<Option<Series>, ReportError> {
    let file = match std::fs::File::open(path) {
        Ok(file) => file,
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(ReportError::Unreadable { path: path.to_path_buf(), source }),
    };
    let bad = |line: usize, what: String| ReportError::BadSeries { path: path.to_path_buf(), line, what };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(std::io::BufReader::new(file));
    let names: Vec<String> = reader.headers().map_err(|e| bad(1, e.to_string()))?.iter().map(str::to_string).collect();
    if names.first().map(String::as_str) != Some("t_s") {
        return Err(bad(1, "the first column is not t_s".into()));
    }
    let mut columns: Vec<Vec<f64>> = vec![vec![]; names.len()];
    for (k, row) in reader.records().enumerate() {
        let row = row.map_err(|e| bad(k + 2, e.to_string()))?;
        for (column, (cell, name)) in columns.iter_mut().zip(row.iter().zip(&names)) {
            let value = if cell.is_empty() { Ok(f64::NAN) } else { cell.parse::<f64>() };
            column.push(value.map_err(|_| bad(k + 2, format!("{name} is \"{cell}\", not a number")))?);
        }
    }
    let t_s = columns.remove(0);
    Ok(Some(Series { t_s, columns: names.into_iter().skip(1).zip(columns).collect() }))
}
