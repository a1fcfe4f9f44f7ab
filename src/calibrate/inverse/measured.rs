//! A measured curve y(x) that a scene is to reproduce: two columns of a table, each with its unit, converted to the units of the columns that the
//! scene records.

use super::{InverseError, OffsetAxis};
use crate::calibrate::same_data;
use crate::calibrate::treatment::cycle::{self, Cycle};
use crate::calibrate::treatment::{hold, rupture};
use crate::math::units::{self, Dimension, UnitError};
use crate::scene::column;
use crate::storage::columns::Named;
use crate::storage::{self, DATA_LIMIT};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Location of a measured curve and the quantities it is compared with.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredSpec {
    /// Table, relative to the study
    pub file: PathBuf,
    /// Column of the coordinate over which the curve was measured, such as a displacement
    pub x: ColumnSpec,
    /// Column of the measured response, such as a force
    pub y: ColumnSpec,
    /// Smallest and largest x that count, with a unit; every row if absent
    pub range: Option<[String; 2]>,
    /// Loading to use if x reverses: `first-loading`, `last-loading`, a number from 1 on, or `all` including unloading
    #[schemars(with = "Option<String>", extend("examples" = ["first-loading"]))]
    pub cycle: Option<Cycle>,
    /// Name of the measured specimen; without a name the curve counts as a specimen of its own
    pub specimen: Option<String>,
    /// Additional unknown offsets: the slack of x, the zero of y
    #[serde(default)]
    pub offsets: Vec<OffsetAxis>,
}

/// A column of the table and its meaning in the scene.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColumnSpec {
    /// Name in the table
    pub column: String,
    /// Unit of its numbers; `1` if they have none
    pub unit: String,
    /// Factor on the numbers: a gauge length turns a strain into a displacement, an area turns a stress into a force
    pub times: Option<String>,
    /// Its quantity in the scene: for x a prescribed signal or `t_s`, for y a recorded column
    pub is: String,
}

/// Rows in the units of the scene's columns, in the order of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// File name
    pub file: String,
    pub sha256: String,
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// Line of each row in the file, counted from 1
    pub lines: Vec<u64>,
    /// Notes on data that were left out, with the reason
    pub notes: Vec<String>,
}

impl Measured {
    /// Refuses a curve whose numbers repeat those of another curve; each comes with its name.
    pub fn check_repeats<'a>(curves: impl Iterator<Item = (&'a str, &'a Self)>) -> Result<(), InverseError> {
        let (names, numbers): (Vec<_>, Vec<_>) =
            curves.map(|(name, m)| (format!("{name} ({})", m.file), [&m.x[..], &m.y].concat())).unzip();
        same_data::first_pair(&numbers).map_or(Ok(()), |[first, second]| {
            Err(InverseError::SameData { first: names[first].clone(), second: names[second].clone() })
        })
    }

    /// Reads the table of a study in the folder `base`.
    pub fn read(base: &Path, spec: &MeasuredSpec) -> Result<Self, InverseError> {
        let path = base.join(&spec.file);
        let bytes =
            storage::read(&path, DATA_LIMIT).map_err(|source| InverseError::Read { path: path.clone(), source })?;
        let names = [spec.x.column.as_str(), &spec.y.column];
        let table = Named::read(&path.display().to_string(), &bytes, &names, &[], units::is_unit)?;
        table.check_units(&[Some(&spec.x.unit), Some(&spec.y.unit)], "study", units::ratio)?;
        let factor = |c: &ColumnSpec| c.factor().map_err(|fact| refuse(&path, c, fact));
        let (fx, fy) = (factor(&spec.x)?, factor(&spec.y)?);
        let range = match &spec.range {
            None => [f64::NEG_INFINITY, f64::INFINITY],
            Some(ends) => {
                let end = |text: &String| spec.x.read(text).map_err(|fact| refuse(&path, &spec.x, fact));
                [end(&ends[0])?, end(&ends[1])?]
            }
        };
        let mut out = Self {
            file: path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned()),
            sha256: storage::sha256(&bytes),
            x: vec![],
            y: vec![],
            lines: vec![],
            notes: vec![],
        };
        let mut outside = 0;
        for line in &table.rows {
            match (table.number(line, 0), table.number(line, 1)) {
                (Ok(x), Ok(_)) if !(range[0]..=range[1]).contains(&(fx * x)) => outside += 1,
                (Ok(x), Ok(y)) => {
                    out.x.push(fx * x);
                    out.y.push(fy * y);
                    out.lines.push(line.number);
                }
                (Err(why), _) => out.notes.push(format!("line {} is left out: {} {why}", line.number, spec.x.column)),
                (_, Err(why)) => out.notes.push(format!("line {} is left out: {} {why}", line.number, spec.y.column)),
            }
        }
        if outside > 0 {
            out.notes.push(format!(
                "{outside} of {} data points lie outside the requested range and were left out",
                out.x.len() + outside
            ));
        }
        if out.x.is_empty() {
            let reason = out.notes.first().cloned().unwrap_or_else(|| "it has no data points".into());
            return Err(InverseError::NoRows { path, reason });
        }
        if spec.x.is != "t_s" {
            let is_force = [Dimension::FORCE, Dimension::ENERGY].contains(&column::dimension(&spec.y.is).0);
            out.keep_loading(spec.cycle, is_force)?;
        }
        Ok(out)
    }

    /// Keeps one loading if x reverses: unloading and later loadings are different curves from the first. For a force or a moment, the loading ends
    /// before a hold at its peak and before the rupture.
    fn keep_loading(&mut self, cycle: Option<Cycle>, is_force: bool) -> Result<(), InverseError> {
        let path: Vec<f64> = self.x.iter().map(|x| (x - self.x[0]).abs()).collect();
        let (rows, chosen) = (self.x.len(), cycle.unwrap_or(Cycle::FirstLoading));
        let mut kept = 0..rows;
        if let Some(loadings) = cycle::loadings_along(&path) {
            kept = cycle::pick(&self.file, &loadings, rows, chosen)
                .map_err(|why| InverseError::Cycle { why: why.to_string().replace("--cycle", "cycle =") })?;
            if kept.len() < rows {
                self.notes.push(format!(
                    "{} of {rows} data points are unloading or another loading, and were left out (cycle = \"{chosen}\" of {})",
                    rows - kept.len(),
                    loadings.len()
                ));
            }
        }
        if is_force && chosen != Cycle::All {
            kept = self.before_end(&path, kept);
        }
        (self.x, self.y, self.lines) =
            (self.x[kept.clone()].to_vec(), self.y[kept.clone()].to_vec(), self.lines[kept].to_vec());
        Ok(())
    }

    /// The rows of a loading before a hold at its peak and before the rupture; notes are added on the rows that are left out.
    fn before_end(&mut self, path: &[f64], loading: Range<usize>) -> Range<usize> {
        let changes: Vec<f64> = self.y.iter().map(|y| y - self.y[0]).collect();
        let (mut kept, sizes) = (loading, changes.iter().map(|c| c.abs()).collect::<Vec<f64>>());
        if let Some(found) = hold::along(path, &sizes, kept.clone()) {
            self.notes.push(format!(
                "{} data points of a hold at the peak were left out: the force relaxes by {:.1} % at constant x, which is no loading (cycle = \"all\" takes them)",
                found.rows.len(),
                100.0 * found.relaxed
            ));
            kept.end = kept.end.min(found.rows.start);
        }
        let peak = changes[kept.clone()].iter().fold(0.0_f64, |most, c| if c.abs() > most.abs() { *c } else { most });
        let side: Vec<f64> = changes[kept.clone()].iter().map(|c| c * peak.signum()).collect();
        let whole = kept.start + rupture::before_along(&path[kept.clone()], &side);
        if whole < kept.end {
            self.notes.push(format!(
                "{} data points after rupture were left out: the force falls below half of its largest level and does not return (cycle = \"all\" takes them)",
                kept.end - whole
            ));
            kept.end = whole;
        }
        kept
    }
}

fn refuse(path: &Path, c: &ColumnSpec, fact: UnitError) -> InverseError {
    InverseError::Unit { path: path.into(), column: c.column.clone(), is: c.is.clone(), fact }
}

impl ColumnSpec {
    /// Factor from a number of the table to the unit of the scene's column.
    fn factor(&self) -> Result<f64, UnitError> {
        let (unit, mut dimension) = units::quantity(&format!("1 {}", self.unit))?;
        let mut value = unit;
        if let Some(times) = &self.times {
            let (by, of) = units::quantity(times)?;
            value *= by;
            dimension = dimension.times(of, 1);
        }
        let (wanted, si) = column::dimension(&self.is);
        if dimension == wanted {
            return Ok(value / si);
        }
        let text = format!("1 {}{}", self.unit, self.times.as_ref().map_or(String::new(), |t| format!(" times {t}")));
        Err(UnitError::Wrong { text, wanted })
    }

    /// Converts a value with its unit to the unit of the scene's column.
    fn read(&self, text: &str) -> Result<f64, UnitError> {
        let (wanted, si) = column::dimension(&self.is);
        Ok(units::parse(text, wanted)? / si)
    }
}
