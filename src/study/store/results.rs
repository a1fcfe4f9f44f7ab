//! Reads what a study run has left: `study.json`, `cases/<id>.json`, `.csv` and `.skin.json.gz`.

use crate::calibrate::inverse::Calibration;
use crate::report::error::ReportError;
use crate::report::files::{json, read_with};
use crate::report::viewer::pack::Packed;
use crate::report::viewer::page;
use crate::report::viewer::unpack::unpack;
use crate::storage::{self, DATA_LIMIT};
use crate::study::store::case_files::{PAGE, Unsound, check_in};
use crate::study::store::other_build::writer;
use crate::study::store::record::{CaseRecord, SCHEMA, Series, StoredCase, StudyRecord};
use crate::study::store::skin::Skin;
use std::collections::{BTreeMap, HashSet};
use std::io::ErrorKind;
use std::path::Path;

/// A study and the cases that have a result, in the order of its families.
pub struct Results {
    pub study: StudyRecord,
    pub cases: Vec<StoredCase>,
    /// Case id → surface, where one was stored
    pub skins: BTreeMap<String, Skin>,
    /// Case id → motion, where the scene records it
    pub motions: BTreeMap<String, Packed>,
    /// Case id → constants that were found there
    pub found: BTreeMap<String, Calibration>,
    /// Case id → derivatives of its columns by such constants, `d bending_angle_deg/d laws.rubber.mu`
    pub sensitivities: BTreeMap<String, Series>,
    /// Record of the work on all cases, [`StudyKind::derive`](crate::study::kind::StudyKind::derive)
    pub derived: Option<serde_json::Value>,
    /// Files that could not be read and are left out, in sentences
    pub damaged: Vec<String>,
}

/// Cases of the study that have no files yet are left out; a file that is there must be sound.
pub fn read(dir: &Path) -> Result<Results, ReportError> {
    let path = dir.join("study.json");
    let study: StudyRecord = json(&path)?.ok_or_else(|| ReportError::NotAStudy { path: path.clone() })?;
    if study.schema > SCHEMA {
        return Err(ReportError::Newer { path, found: study.schema, known: SCHEMA });
    }
    let (mut cases, mut skins): (Vec<StoredCase>, _) = (vec![], BTreeMap::new());
    let mut motions = BTreeMap::new();
    let (mut found, mut sensitivities, mut damaged) = (BTreeMap::new(), BTreeMap::new(), vec![]);
    let mut seen = HashSet::new();
    for id in study.families.iter().flat_map(|f| &f.cases) {
        if !seen.insert(id) {
            continue;
        }
        let file = |extension: &str| dir.join("cases").join(format!("{id}.{extension}"));
        let Some(record) = record(&file("json"))? else { continue };
        let unsound = check_in(dir, id).err().unwrap_or_default();
        // A surface that cannot be read is named below
        let worth_words = unsound.iter().filter(|file| !file.file.contains(".skin."));
        damaged.extend(worth_words.map(|Unsound { file, fact }| {
            format!("{file}: {fact}. The numbers of this case may be wrong; run the study again to compute it anew.")
        }));
        let curves = series(&file("csv"))?.unwrap_or_default();
        cases.push(StoredCase { record, series: curves });
        found.extend(json::<Calibration>(&file("fit.json"))?.map(|c| (id.clone(), c)));
        sensitivities.extend(series(&file("sensitivities.csv"))?.map(|s| (id.clone(), s)));
        // Unpacked by hand it is read too
        let skin = match read_with(&file("skin.json.gz"), Skin::unpacked) {
            Ok(None) => read_with(&file("skin.json"), Skin::unpacked),
            found => found,
        };
        match skin {
            Ok(Some(skin)) if sound(&skin) => _ = skins.insert(id.clone(), skin),
            Ok(None) => {}
            Ok(Some(_)) | Err(ReportError::Malformed { .. }) => {
                damaged.push(format!(
                    "The surface of case {id} is damaged and not drawn; run the study again to compute it anew."
                ));
            }
            Err(other) => return Err(other),
        }
        match motion(&file(PAGE)) {
            Some(Ok(packed)) => _ = motions.insert(id.clone(), packed),
            Some(Err(why)) => {
                damaged.push(format!("The motion of case {id} is not shown: {why}"));
            }
            None => {}
        }
    }
    if cases.is_empty() {
        return Err(ReportError::NoCases { path: dir.join("cases") });
    }
    Ok(Results { study, cases, skins, motions, found, sensitivities, derived: None, damaged })
}

/// A record; none if the file does not exist. One that another build wrote in another form is refused by the name of that build.
fn record(path: &Path) -> Result<Option<CaseRecord>, ReportError> {
    match json(path) {
        Err(ReportError::Malformed { path, source }) => match storage::read(&path, DATA_LIMIT).map(|b| writer(&b)) {
            Ok(Some(wrote)) => Err(ReportError::OtherBuild { path, wrote, source }),
            _ => Err(ReportError::Malformed { path, source }),
        },
        read => read,
    }
}

/// The motion of a case; none where its file does not exist.
fn motion(path: &Path) -> Option<Result<Packed, String>> {
    if !path.is_file() {
        return None;
    }
    let damaged =
        || format!("{}: its data do not fit together; run the study again to compute it anew", path.display());
    let read = page::read(path).map_err(|e| e.to_string());
    Some(read.and_then(|mut cases| cases.pop().filter(|c| unpack(c).is_some()).ok_or_else(damaged)))
}

/// A surface of finite numbers whose arrays fit together; another one is not drawn.
fn sound(s: &Skin) -> bool {
    let rigid_points = s.rigids.iter().flat_map(|r| &r.points);
    let mut points = s.points.iter().chain(&s.displacement).chain(s.cables.iter().flatten()).chain(rigid_points);
    if !points.all(|p| p.iter().all(|x| x.is_finite())) || !s.t_s.is_finite() {
        return false;
    }
    let n = s.points.len();
    let inside = |triangles: &[[u32; 3]], n: usize| triangles.iter().flatten().all(|k| (*k as usize) < n);
    let rigid = s.rigids.iter().all(|r| inside(&r.triangles, r.points.len()));
    s.displacement.len() == n && s.stretch.len() == n && inside(&s.triangles, n) && rigid
}

/// Columns of numbers under a header; the first one is `t_s`. An empty cell is not a number and reads as NaN.
fn series(path: &Path) -> Result<Option<Series>, ReportError> {
    let bytes = match storage::read(path, DATA_LIMIT) {
        Ok(bytes) => bytes,
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(ReportError::Unreadable { path: path.to_path_buf(), source }),
    };
    let bad = |line: usize, what: String| ReportError::BadSeries { path: path.to_path_buf(), line, what };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::Fields).from_reader(bytes.as_slice());
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
