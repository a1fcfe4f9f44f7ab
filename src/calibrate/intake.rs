//! Rows of a table as samples: what a cell holds becomes a stretch and a nominal stress.
//!
//! λ = 1 + e, eˣ of true strain, 1 + u/L of a displacement; P = σ/λ of true stress, as an incompressible piece has the area A/λ
//! under load, F/A of a force. In simple shear γ = e or u/L, and σ₁₂ = P₁₂.

use super::columns::Columns;
use super::names::{StrainKind, StressKind};
use super::table::{self, Decimal, Line};
use super::{Audit, AuditKind, Dimensions, FitError, Mode, RawRow, Sample, UnknownMode};

/// Strains beyond are not believed of a column without a unit \[–\]: rubbers break before, and percent reach there at once
const LARGEST: f64 = 20.0;

/// Stresses beyond are no measurement \[Pa\]: their squares would overflow in a fit
const LARGEST_STRESS: f64 = 1e30;
/// Stretches beyond, or below their inverse, are none either \[–\]
const LARGEST_STRETCH: f64 = 1e4;

/// Columns with the dimensions of the test piece.
pub struct Conversion<'a> {
    columns: &'a Columns,
    /// Gauge length \[m\], 1 where strain is recorded
    length: f64,
    /// Cross-section \[m²\], 1 where stress is recorded
    area: f64,
}

impl<'a> Conversion<'a> {
    /// Refuses forces without a cross-section and displacements without a gauge length.
    pub fn new(file: &str, columns: &'a Columns, dimensions: Dimensions, audit: &mut Audit) -> Result<Self, FitError> {
        let mut made = Self { columns, length: 1.0, area: 1.0 };
        let mut log = |message: String| audit.add(AuditKind::Intake, message, vec![]);
        for (e, p) in &columns.axes {
            match e.kind {
                StrainKind::True => log(format!("\"{}\" became stretch by λ = exp(true strain)", e.name)),
                StrainKind::Displacement => {
                    let absent = || FitError::NoLength { file: file.into(), column: e.name.clone() };
                    made.length = dimensions.gauge_length.ok_or_else(absent)?;
                    log(format!(
                        "\"{}\" became strain by division by the gauge length {:.6} mm",
                        e.name,
                        1e3 * made.length
                    ));
                }
                StrainKind::Stretch | StrainKind::Engineering => {}
            }
            match p.kind {
                StressKind::True => log(format!(
                    "\"{}\" became nominal stress by P = σ/λ, as the test piece is taken for incompressible",
                    p.name
                )),
                StressKind::Force => {
                    let (area, how) = dimensions.section(file, &p.name)?;
                    made.area = area;
                    log(format!("\"{}\" became nominal stress by division by the cross-section {how}", p.name));
                }
                StressKind::Nominal => {}
            }
        }
        Ok(made)
    }

    /// λ \[–\] of a number of the strain column.
    fn stretch(&self, axis: usize, x: f64, mode: Mode) -> Result<f64, String> {
        let e = &self.columns.axes[axis].0;
        let x = x * e.factor;
        if mode == Mode::SimpleShear && matches!(e.kind, StrainKind::Stretch | StrainKind::True) {
            return Err(format!(
                "column \"{}\" holds a {}; simple shear needs the shear strain γ",
                e.name,
                e.kind.words()
            ));
        }
        let stretch = match e.kind {
            StrainKind::Stretch => x,
            StrainKind::Engineering => mode.stretch(x),
            StrainKind::True => x.exp(),
            StrainKind::Displacement => mode.stretch(x / self.length),
        };
        if !(stretch > 0.0 && stretch.is_finite()) {
            return Err(format!("stretch {stretch} is not positive and finite"));
        }
        if (LARGEST_STRETCH.recip()..=LARGEST_STRETCH).contains(&stretch) {
            Ok(stretch)
        } else {
            Err(format!("stretch {stretch:e} is beyond {LARGEST_STRETCH:e}"))
        }
    }

    /// P \[Pa\] of a number of the stress column at λ.
    fn stress(&self, axis: usize, y: f64, mode: Mode, stretch: f64) -> Result<f64, String> {
        let p = &self.columns.axes[axis].1;
        let y = y * p.factor;
        let stress = match p.kind {
            StressKind::True if mode != Mode::SimpleShear => y / stretch,
            StressKind::Nominal | StressKind::True => y,
            StressKind::Force => y / self.area,
        };
        if stress.abs() <= LARGEST_STRESS {
            Ok(stress)
        } else {
            Err(format!("a stress of {stress:e} Pa is beyond {LARGEST_STRESS:e} Pa"))
        }
    }
}

/// Refuses rows with more numbers than there are names: their decimal commas were taken for delimiters.
pub fn check_cells(file: &str, names: &Line, body: &[Line], delimiter: char, decimal: Decimal) -> Result<(), FitError> {
    let too_many = |l: &&Line| {
        let beyond = l.cells.iter().skip(names.cells.len()).filter(|c| table::number(c, decimal).is_ok()).count();
        beyond > 0
    };
    match body.iter().find(too_many).filter(|_| delimiter == ',') {
        None => Ok(()),
        Some(line) => Err(FitError::Cells {
            file: file.into(),
            line: line.number,
            cells: line.cells.len(),
            names: names.cells.len(),
        }),
    }
}

/// Refuses strain that is percent by its size and has no unit.
pub fn check_percent(file: &str, columns: &Columns, samples: &[Sample]) -> Result<(), FitError> {
    let bare = columns.axes.iter().map(|(e, _)| e).find(|e| {
        matches!(e.kind, StrainKind::Stretch | StrainKind::Engineering | StrainKind::True) && e.unit == "1" && !e.stated
    });
    let largest = samples.iter().map(|s| s.stretch.max(s.second)).fold(0.0, f64::max);
    match bare {
        Some(e) if largest > 1.0 + LARGEST => {
            Err(FitError::Percent { file: file.into(), column: e.name.clone(), largest, kind: e.kind.words() })
        }
        _ => Ok(()),
    }
}

/// Samples and raw rows in the order of the file; rows that cannot be read are logged.
pub fn read_rows(
    file: &str,
    body: &[Line],
    conversion: &Conversion,
    decimal: Decimal,
    whole_file: Option<Mode>,
    audit: &mut Audit,
) -> Result<(Vec<Sample>, Vec<RawRow>), FitError> {
    let columns = conversion.columns;
    let (mut samples, mut raw, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    for line in body.iter().filter(|l| l.cells.iter().any(|c| !c.is_empty())) {
        let cell = |i: usize| line.cells.get(i).map_or("", String::as_str);
        let number = |i: usize| table::number(cell(i), decimal);
        let read = |i: usize, what: &str| number(i).map_err(|why| format!("column \"{what}\" {why}"));
        let numbers: Result<Vec<(f64, f64)>, String> =
            columns.axes.iter().map(|(e, p)| Ok((read(e.at, &e.name)?, read(p.at, &p.name)?))).collect();
        let numbers = match numbers {
            Ok(numbers) => numbers,
            Err(reason) => {
                left_out.push((line.number, reason));
                continue;
            }
        };
        let mode = match columns.mode {
            Some(i) => {
                Mode::from_word(cell(i)).ok_or_else(|| UnknownMode { line: Some(line.number), word: cell(i).into() })?
            }
            None => whole_file.ok_or_else(|| FitError::NoMode { file: file.into() })?,
        };
        if (mode == Mode::Biaxial) != (columns.axes.len() == 2) {
            return Err(FitError::BiaxialRow { file: file.into(), line: line.number });
        }
        let converted = |(k, (x, y)): (usize, &(f64, f64))| {
            let stretch = conversion.stretch(k, *x, mode)?;
            Ok((stretch, conversion.stress(k, *y, mode, stretch)?))
        };
        let converted: Vec<(f64, f64)> = match numbers.iter().enumerate().map(converted).collect() {
            Ok(converted) => converted,
            Err(reason) => {
                left_out.push((line.number, reason));
                continue;
            }
        };
        for (k, &(stretch, stress)) in converted.iter().enumerate() {
            let second = if mode == Mode::Biaxial { converted[1 - k].0 } else { 1.0 };
            samples.push(Sample { mode, stretch, second, stress, line: line.number, specimen: 0 });
        }
        let extra = |c: Option<(usize, f64)>| c.and_then(|(i, factor)| Some(number(i).ok()? * factor));
        raw.push(RawRow {
            line: line.number,
            specimen: 0,
            time: extra(columns.time.map(|i| (i, 1.0))),
            displacement: extra(columns.displacement),
            force: extra(columns.force),
        });
    }
    if samples.is_empty() {
        let first = left_out.first().map(|(line, reason)| format!("line {line}: {reason}"));
        let reason = first.unwrap_or("there are no data below the column names".into());
        return Err(FitError::NoRows { file: file.into(), reason });
    }
    for (number, reason) in left_out {
        audit.add(AuditKind::LeftOut, format!("line {number}: {reason}"), vec![number]);
    }
    Ok((samples, raw))
}
