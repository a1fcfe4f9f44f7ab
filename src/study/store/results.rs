//! Reads the results of a study run: `study.json`, `cases/<id>.json`, `.csv` and `.skin.json.gz`.

use crate::calibrate::inverse::Calibration;
use crate::report::error::ReportError;
use crate::report::files::{json, read_with};
use crate::report::viewer::pack::Packed;
use crate::report::viewer::page;
use crate::report::viewer::unpack::unpack;
use crate::storage::{self, DATA_LIMIT};
use crate::study::extremes::align;
use crate::study::store::case_files::{PAGE, Unsound, check_in};
use crate::study::store::other_build::writer;
use crate::study::store::outdated::is_outdated;
use crate::study::store::record::{CaseRecord, SCHEMA, Series, StoredCase, StudyRecord, VariantMember};
use crate::study::store::skin::Skin;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::ErrorKind;
use std::path::Path;

/// A study and the cases that have a result, in the order of its families.
pub struct Results {
    pub study: StudyRecord,
    pub cases: Vec<StoredCase>,
    /// Case id → surface, if one was stored
    pub skins: BTreeMap<String, Skin>,
    /// Case id → motion, if the scene records it
    pub motions: BTreeMap<String, Packed>,
    /// Case id → constants found in the case
    pub found: BTreeMap<String, Calibration>,
    /// Case id → derivatives of its columns with respect to such constants, `d bending_angle_deg/d laws.rubber.mu`, at the times of its series
    pub sensitivities: BTreeMap<String, Series>,
    /// Record of the work on all cases, see [`StudyKind::derive`](crate::study::kind::StudyKind::derive)
    pub derived: Option<serde_json::Value>,
    /// Files that could not be read and are left out, as sentences
    pub damaged: Vec<String>,
    /// Cases that are left out because their stored results have other inputs than the study has now
    pub outdated: Vec<String>,
}

/// Reads the results in a folder. Cases are left out if they have no files yet, if their numbers differ from those that were stored, or if their inputs
/// are no longer those of the study.
pub fn read(dir: &Path) -> Result<Results, ReportError> {
    let path = dir.join("study.json");
    let study: StudyRecord = json(&path)?.ok_or_else(|| ReportError::NotAStudy { path: path.clone() })?;
    if study.schema > SCHEMA {
        return Err(ReportError::Newer { path, found: study.schema, known: SCHEMA });
    }
    let ids: Vec<String> = study.families.iter().flat_map(|f| f.cases.iter().cloned()).collect();
    let mut results = Results::without_cases(study);
    let mut seen = HashSet::new();
    for id in ids.iter().filter(|id| seen.insert(*id)) {
        if let Err(why) = results.add(dir, id) {
            results.leave_out(why)?;
        }
    }
    results.place();
    align(&results.study, &mut results.cases);
    match results.cases.is_empty() {
        true if !results.damaged.is_empty() => Err(ReportError::NoSoundCase { facts: results.damaged }),
        true => Err(ReportError::NoCases { path: dir.join("cases") }),
        false => Ok(results),
    }
}

/// The record of a case with its time series, intact or not; `None` if there is no record.
pub fn stored(dir: &Path, id: &str) -> Result<Option<StoredCase>, ReportError> {
    let file = |extension: &str| dir.join("cases").join(format!("{id}.{extension}"));
    let Some(record) = record(&file("json"))? else { return Ok(None) };
    Ok(Some(StoredCase::new(record, series(&file("csv"))?.unwrap_or_default())))
}

impl Results {
    /// Results of a study without any finished case.
    pub fn without_cases(study: StudyRecord) -> Self {
        let (cases, derived, damaged, outdated) = (vec![], None, vec![], vec![]);
        let (skins, motions) = (BTreeMap::new(), BTreeMap::new());
        let (found, sensitivities) = (BTreeMap::new(), BTreeMap::new());
        Self { study, cases, skins, motions, found, sensitivities, derived, damaged, outdated }
    }

    /// Reports a file that cannot be read, whose case does not count; other errors concern the whole folder.
    fn leave_out(&mut self, why: ReportError) -> Result<(), ReportError> {
        let fact = match why {
            ReportError::Malformed { path, source } => {
                format!("{}: it is not a valid record: {source}", path.display())
            }
            ReportError::Unreadable { path, source } => format!("{}: it cannot be read: {source}", path.display()),
            ReportError::BadSeries { path, line, what } => format!("{}, line {line}: {what}", path.display()),
            other => return Err(other),
        };
        self.damaged.push(format!("{fact}. The case does not count; run the study again to compute it anew."));
        Ok(())
    }

    /// Assigns to every case its families, variants and members in the study.
    fn place(&mut self) {
        let named: HashMap<String, VariantMember> = (self.cases.iter())
            .map(|StoredCase { record: r, .. }| {
                (r.id.clone(), VariantMember { variant: r.variant.clone(), member: r.member.clone() })
            })
            .collect();
        let places = self.study.places(|id| named.get(id).cloned());
        let cases = std::mem::take(&mut self.cases).into_iter();
        self.cases =
            cases.map(|case| if let Some(of) = places.get(&case.record.id) { case.at(of) } else { case }).collect();
    }

    /// Reads the files of a case, if it has any.
    fn add(&mut self, dir: &Path, id: &str) -> Result<(), ReportError> {
        let file = |extension: &str| dir.join("cases").join(format!("{id}.{extension}"));
        let Some(mut record) = record(&file("json"))? else { return Ok(()) };
        if is_outdated(dir, &self.study, &record) {
            self.outdated.push(id.into());
            return Ok(());
        }
        self.study.asks.iter().for_each(|asks| record.restrict(*asks, self.study.is_reference(id)));
        // A file that was removed to save space does not make the numbers in the others wrong, except for the series: peaks are counted from its first
        // value
        let is_series = |f: &Unsound| f.file == format!("cases/{id}.csv");
        let is_spared = |f: &Unsound| !is_series(f) && !dir.join(&f.file).exists();
        let (missing, changed): (Vec<Unsound>, Vec<Unsound>) =
            check_in(dir, id).err().unwrap_or_default().into_iter().partition(is_spared);
        let (pictures, numbers): (Vec<Unsound>, Vec<Unsound>) = changed.into_iter().partition(is_picture);
        let sentence = |Unsound { file, fact }: &Unsound, what: &str| {
            format!("{file}: {fact}. {what}; run the study again to compute it anew.")
        };
        self.damaged.extend(numbers.iter().map(|f| sentence(f, "The case does not count")));
        if !numbers.is_empty() {
            return Ok(());
        }
        let pages = pictures.iter().filter(|f| f.file.ends_with(PAGE));
        self.damaged.extend(pages.map(|f| sentence(f, "The motion is not shown")));
        let missing = missing.iter().filter(|f| !is_picture(f));
        self.damaged.extend(missing.map(|f| sentence(f, "The case is without what it holds")));
        let series_of_case = series(&file("csv"))?.unwrap_or_default();
        // They have the rows of every step; the series may have fewer
        let sensitivities = series(&file("sensitivities.csv"))?.map(|s| s.at(&series_of_case.t_s));
        let found = json::<Calibration>(&file("fit.json"))?;
        self.cases.push(StoredCase::new(record, series_of_case));
        self.found.extend(found.map(|c| (id.to_string(), c)));
        self.sensitivities.extend(sensitivities.map(|s| (id.to_string(), s)));
        self.add_pictures(dir, id, &pictures);
        Ok(())
    }

    /// Reads the drawable files of a case, except those that differ from the stored ones.
    fn add_pictures(&mut self, dir: &Path, id: &str, changed: &[Unsound]) {
        let file = |extension: &str| dir.join("cases").join(format!("{id}.{extension}"));
        let is_changed = |end: &str| changed.iter().any(|f| f.file == format!("cases/{id}.{end}"));
        // The file is also read if it was unpacked by hand
        let skin = match read_with(&file("skin.json.gz"), Skin::unpacked) {
            Ok(None) => read_with(&file("skin.json"), Skin::unpacked),
            found => found,
        };
        match skin {
            Ok(Some(skin)) if sound(&skin) && !is_changed("skin.json.gz") => _ = self.skins.insert(id.into(), skin),
            Ok(None) => {}
            Ok(Some(_)) | Err(_) => {
                self.damaged.push(format!(
                    "The surface of case {id} is damaged and not drawn; run the study again to compute it anew."
                ));
            }
        }
        match motion(&file(PAGE)) {
            Some(Ok(_)) if is_changed(PAGE) => {}
            Some(Ok(packed)) => _ = self.motions.insert(id.into(), packed),
            Some(Err(why)) => self.damaged.push(format!("The motion of case {id} is not shown: {why}")),
            None => {}
        }
    }
}

/// Whether a file is only drawn and no number comes from it.
fn is_picture(file: &Unsound) -> bool {
    file.file.contains(".skin.") || file.file.ends_with(&format!(".{PAGE}"))
}

/// Reads a record; `None` if the file does not exist. A record that another build wrote in another form is refused with the name of that build.
fn record(path: &Path) -> Result<Option<CaseRecord>, ReportError> {
    match json(path) {
        Err(ReportError::Malformed { path, source }) => match storage::read(&path, DATA_LIMIT).map(|b| writer(&b)) {
            Ok(Some(wrote)) => Err(ReportError::OtherBuild { path, wrote, source }),
            _ => Err(ReportError::Malformed { path, source }),
        },
        read => read,
    }
}

/// The motion of a case; `None` if its file does not exist.
fn motion(path: &Path) -> Option<Result<Packed, String>> {
    if !path.is_file() {
        return None;
    }
    let damaged =
        || format!("{}: its data do not fit together; run the study again to compute it anew", path.display());
    let read = page::read(path).map_err(|e| e.to_string());
    Some(read.and_then(|mut cases| cases.pop().filter(|c| unpack(c).is_some()).ok_or_else(damaged)))
}

/// Whether a surface has only finite numbers and consistent arrays; otherwise it is not drawn.
fn sound(s: &Skin) -> bool {
    let rigid_points = s.rigids.iter().flat_map(|r| &r.points);
    let mut points = s.points.iter().chain(&s.displacement).chain(s.cables.iter().flatten()).chain(rigid_points);
    if !points.all(|p| p.iter().all(|x| x.is_finite())) || !s.t_s.is_finite() {
        return false;
    }
    let n = s.points.len();
    let inside = |triangles: &[[u32; 3]], n: usize| triangles.iter().flatten().all(|k| (*k as usize) < n);
    let rigid = s.rigids.iter().all(|r| inside(&r.triangles, r.points.len()));
    let curved = inside(&s.middles, n) && [0, s.triangles.len()].contains(&s.middles.len());
    s.displacement.len() == n && s.stretch.len() == n && inside(&s.triangles, n) && curved && rigid
}

/// Reads columns of numbers under a header; the first column is `t_s`. An empty cell reads as NaN.
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
