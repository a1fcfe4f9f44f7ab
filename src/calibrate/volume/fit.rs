//! From a request to Poisson's ratio, ln λ_t = c − ν ln λ, or to the bulk modulus, p = c − κ U′(J)/κ.

use super::error::VolumeError;
use super::line::{Line, Points, line};
use super::request::{VolumeRequest, VolumeTest};
use super::result::{Data, Tried, VolumeFit, words};
use crate::calibrate::StretchRange;
use crate::calibrate::intake::columns::Sign;
use crate::calibrate::intake::names::{self, VolumeKind};
use crate::calibrate::intake::roles::{self, ReadColumn, Role, Wanted};
use crate::calibrate::same_data;
use crate::material::{Volumetric, VolumetricKind};

/// Least number of rows
const ROWS: usize = 4;
/// Change below which a column is constant: of a stretch, of a volume relative to that at rest, or of a pressure relative to itself \[–\]
const LEAST_CHANGE: f64 = 1e-9;
/// Largest relative distance from the undeformed volume of the nearest data point of a bulk test \[–\]
const NEAR: f64 = 0.5;

/// Reads the tables and fits Poisson's ratio or the bulk modulus.
pub fn fit_volume(request: &VolumeRequest) -> Result<VolumeFit, VolumeError> {
    let parts = parts(request)?;
    let flags = [("range", request.range.is_some()), ("positive", request.positive.is_some())];
    if let Some((flag, _)) = flags.into_iter().find(|(_, is_given)| *is_given && request.test == VolumeTest::Bulk) {
        return Err(VolumeError::Idle { flag });
    }
    let mut data = Data::default();
    let (mut across, mut along, mut numbers) = (vec![], vec![], vec![]);
    for (specimen, path) in std::iter::once(&request.data).chain(&request.more).enumerate() {
        let table = read(request, path)?;
        numbers.push([&table.x[..], &table.y].concat());
        data.specimen.extend(vec![specimen; table.x.len()]);
        across.extend(table.x);
        along.extend(table.y);
        data.files.push(table.file);
        data.sha256.push(table.sha256);
        data.notes.extend(table.notes);
    }
    if let Some(pair) = same_data::first_pair(&numbers) {
        let [first, second] = pair.map(|k| data.files[k].clone());
        return Err(VolumeError::SameData { first, second });
    }
    let points = |x: Vec<f64>| Points { x, y: along.clone(), specimen: data.specimen.clone() };
    let sign = |fact: String, remedy| VolumeError::Sign { file: data.files.join(", "), fact, remedy };
    match request.test {
        VolumeTest::Lateral => {
            let points = points(across.iter().map(|l| l.ln()).collect());
            let points = Points { y: along.iter().map(|l| l.ln()).collect(), ..points };
            let line = line(&points);
            if line.slope.interval[0] > 0.0 {
                let fact =
                    format!("the lateral strain grows with the axial one (Poisson's ratio {:.3})", -line.slope.value);
                let remedy = "pass --positive compression where the table counts a compression as positive; \
                              if contraction counts as positive in it, give it a minus sign";
                return Err(sign(fact, remedy));
            }
            Ok(words(data, request.test, &[], &points, line))
        }
        VolumeTest::Bulk => {
            let one = |kind: &VolumetricKind| {
                let unit = Volumetric { kind: *kind, kappa: 1.0 };
                let points = points(across.iter().map(|j| unit.du(*j)).collect());
                let line = line(&points);
                (*kind, points, line)
            };
            let mut fits: Vec<_> = parts.iter().map(one).collect();
            fits.sort_by(|a, b| a.2.misfit.total_cmp(&b.2.misfit));
            let (_, points, best) = &fits[0];
            let allowed = |f: &&(VolumetricKind, Points, Line)| best.allows(&f.2);
            let tried: Vec<Tried> = fits.iter().map(|f| Tried::of(f.0, &f.2, allowed(&f))).collect();
            let line = fits.iter().filter(allowed).fold(best.clone(), |all, f| all.with(&f.2));
            if line.slope.interval[0] > 0.0 {
                let fact = "the volume grows with the pressure".to_string();
                return Err(sign(fact, "give a change of volume as negative under pressure, or the ratio V/V0"));
            }
            Ok(words(data, request.test, &tried, points, line))
        }
    }
}

/// One table: stretch and lateral stretch, or volume ratio and pressure \[Pa\].
struct Table {
    file: String,
    sha256: String,
    x: Vec<f64>,
    y: Vec<f64>,
    notes: Vec<String>,
}

fn read(request: &VolumeRequest, path: &std::path::Path) -> Result<Table, VolumeError> {
    let all: &[Role] = match request.test {
        VolumeTest::Lateral => &[Role::Strain, Role::Lateral],
        VolumeTest::Bulk => &[Role::Pressure, Role::Volume],
    };
    let wanted = Wanted { all, one: &[], columns: &request.columns, units: &request.units, unitless: &[] };
    let mut table = roles::read(path, &wanted)?;
    let file = table.file.clone();
    let (x, y) = match request.test {
        VolumeTest::Lateral => (Role::Strain, Role::Lateral),
        VolumeTest::Bulk => (Role::Volume, Role::Pressure),
    };
    let strain = &mut table.columns.get_mut(&x).expect("it was read");
    if request.test == VolumeTest::Lateral && is_turned(strain, request.positive) {
        strain.turn(&mut table.notes);
    }
    let range = request.range.unwrap_or(StretchRange::ALL);
    let checked = |role: Role, what: &'static str| {
        let values = ratios(&table.columns[&role], role);
        let is_bad = |p: &(&u64, &f64)| *p.1 <= 0.0;
        let bad: Vec<u64> = table.lines.iter().zip(&values).filter(is_bad).map(|p| *p.0).collect();
        if bad.is_empty() { Ok(values) } else { Err(VolumeError::Impossible { file: file.clone(), what, lines: bad }) }
    };
    let (x, y): (Vec<f64>, Vec<f64>) = match request.test {
        VolumeTest::Lateral => {
            let (x, y) = (checked(x, "strain")?, checked(y, "lateral strain")?);
            x.into_iter().zip(y).filter(|p| range.contains(p.0)).unzip()
        }
        VolumeTest::Bulk => {
            let volumes = checked(x, "volume")?;
            check_volume(&file, &table.columns[&x], &volumes)?;
            (volumes, table.columns[&y].values.clone())
        }
    };
    if x.len() < ROWS {
        return Err(VolumeError::TooFewRows { file, rows: x.len() });
    }
    let varies = |values: &[f64]| values.iter().any(|v| (v - values[0]).abs() > LEAST_CHANGE * v.abs());
    let names = match request.test {
        VolumeTest::Lateral => ["strain", "lateral strain"],
        VolumeTest::Bulk => ["volume", "pressure"],
    };
    let still = names.into_iter().zip([&x, &y]).find(|(_, values)| !varies(values)).map(|(what, _)| what);
    match still {
        Some(what) => Err(VolumeError::Constant { file, what }),
        None => Ok(Table { file, sha256: table.sha256, x, y, notes: table.notes }),
    }
}

/// Whether a column of strain counts compression as positive.
fn is_turned(column: &ReadColumn, positive: Option<Sign>) -> bool {
    !column.is_stretch()
        && match positive {
            Some(sign) => sign == Sign::Compression,
            None => names::is_compressive(&column.name) && column.is_positive(),
        }
}

/// The volumetric parts that are tried.
fn parts(request: &VolumeRequest) -> Result<Vec<VolumetricKind>, VolumeError> {
    let Some(name) = &request.volumetric else { return Ok(VolumetricKind::ALL.to_vec()) };
    if request.test == VolumeTest::Lateral {
        return Err(VolumeError::Contradiction);
    }
    let found = VolumetricKind::ALL.into_iter().find(|k| k.name() == name);
    Ok(vec![found.ok_or_else(|| VolumeError::Part { name: name.clone() })?])
}

/// Stretches, or volumes relative to the undeformed one.
fn ratios(column: &ReadColumn, role: Role) -> Vec<f64> {
    let is_ratio = match role {
        Role::Volume => names::volume(&column.name) == Some(VolumeKind::Ratio),
        _ => names::is_stretch(&column.name) || column.is_stretch(),
    };
    let one = |v: &f64| match (is_ratio, names::is_true(&column.name)) {
        (true, _) => *v,
        (_, true) => v.exp(),
        _ => 1.0 + v,
    };
    column.values.iter().map(one).collect()
}

/// Refuses volumes of which none is near the undeformed one: a ratio was taken for a change, or a change for a ratio.
fn check_volume(file: &str, column: &ReadColumn, ratios: &[f64]) -> Result<(), VolumeError> {
    let nearest = ratios.iter().copied().min_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs())).unwrap_or(1.0);
    if (nearest - 1.0).abs() <= NEAR {
        return Ok(());
    }
    let remedy = match names::volume(&column.name) {
        Some(VolumeKind::Ratio) => "if its numbers are changes, call it \"volume change\"",
        _ => "if its numbers are V/V0, call it \"volume ratio\"",
    };
    Err(VolumeError::FarVolume { file: file.into(), column: column.name.clone(), nearest, remedy })
}
