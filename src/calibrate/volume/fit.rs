//! From a request to Poisson's ratio, ln λ_t = c − ν ln λ, or to the bulk modulus, p = c − κ U′(J)/κ.

use super::error::VolumeError;
use super::line::line;
use super::request::{VolumeRequest, VolumeTest};
use super::result::{VolumeFit, words};
use crate::calibrate::intake::names::{self, StrainKind};
use crate::calibrate::intake::roles::{self, ReadColumn, Role, Wanted};
use crate::material::{Volumetric, VolumetricKind};

/// Rows that a fit needs
const ROWS: usize = 4;
/// Reads a table and fits Poisson's ratio or the bulk modulus.
pub fn fit_volume(request: &VolumeRequest) -> Result<VolumeFit, VolumeError> {
    let all: &[Role] = match request.test {
        VolumeTest::Lateral => &[Role::Strain, Role::Lateral],
        VolumeTest::Bulk => &[Role::Pressure, Role::Volume],
    };
    let parts = parts(request)?;
    let wanted = Wanted { all, one: &[], columns: &request.columns, units: &request.units, unitless: &[] };
    let table = roles::read(&request.data, &wanted)?;
    let (file, lines) = (&table.file, &table.lines);
    if lines.len() < ROWS {
        return Err(VolumeError::TooFewRows { file: file.clone(), rows: lines.len() });
    }
    let ratios = |role: Role, what: &'static str| {
        let values: Vec<f64> = ratios(&table.columns[&role], role);
        let bad: Vec<u64> = lines.iter().zip(&values).filter(|p| *p.1 <= 0.0).map(|p| *p.0).collect();
        let varies = values.iter().any(|v| (v - values[0]).abs() > 1e-9);
        match (bad.is_empty(), varies) {
            (false, _) => Err(VolumeError::Impossible { file: file.clone(), what, lines: bad }),
            (_, false) => Err(VolumeError::Constant { file: file.clone(), what }),
            _ => Ok(values),
        }
    };
    let sign = |fact: String, remedy| VolumeError::Sign { file: file.clone(), fact, remedy };
    let fitted = match request.test {
        VolumeTest::Lateral => {
            let axial: Vec<f64> = ratios(Role::Strain, "strain")?.iter().map(|l| l.ln()).collect();
            let lateral: Vec<f64> = ratios(Role::Lateral, "lateral strain")?.iter().map(|l| l.ln()).collect();
            let line = line(&axial, &lateral);
            if line.slope.interval[0] > 0.0 {
                let fact =
                    format!("the lateral strain grows with the axial one (Poisson's ratio {:.3})", -line.slope.value);
                return Err(sign(fact, "if contraction counts as positive in the table, give it a minus sign"));
            }
            words(&table, request.test, None, &axial, &lateral, line)
        }
        VolumeTest::Bulk => {
            let volume = ratios(Role::Volume, "volume")?;
            let pressure = &table.columns[&Role::Pressure].values;
            let one = |kind: &VolumetricKind| {
                let unit = Volumetric { kind: *kind, kappa: 1.0 };
                let x: Vec<f64> = volume.iter().map(|j| unit.du(*j)).collect();
                let line = line(&x, pressure);
                (*kind, x, line)
            };
            let mut fits: Vec<_> = parts.iter().map(one).collect();
            fits.sort_by(|a, b| a.2.misfit.total_cmp(&b.2.misfit));
            let others: Vec<(VolumetricKind, f64, f64)> =
                fits.iter().map(|f| (f.0, -f.2.slope.value, f.2.misfit)).collect();
            let (_, x, line) = fits.swap_remove(0);
            if line.slope.interval[0] > 0.0 {
                let fact = "the volume grows with the pressure".to_string();
                return Err(sign(fact, "give a change of volume as negative under pressure, or the ratio V/V0"));
            }
            words(&table, request.test, Some(others), &x, pressure, line)
        }
    };
    Ok(fitted)
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

/// Stretches, or volumes over the undeformed one.
fn ratios(column: &ReadColumn, role: Role) -> Vec<f64> {
    let lower = column.name.to_lowercase();
    let is_ratio = match role {
        Role::Volume => lower.contains("ratio") || lower.contains("v/v0") || lower.starts_with('j'),
        _ => lower.contains("stretch") || names::strain(&column.name).is_some_and(|r| r.1 == StrainKind::Stretch),
    };
    let is_true = ["true", "log", "hencky"].iter().any(|w| lower.contains(w));
    let one = |v: &f64| match (is_ratio, is_true) {
        (true, _) => *v,
        (_, true) => v.exp(),
        _ => 1.0 + v,
    };
    column.values.iter().map(one).collect()
}
