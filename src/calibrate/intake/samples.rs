//! Converts rows of a table to samples: a stretch and a nominal stress.
//!
//! λ = 1 + e, or eˣ for a true strain x, or 1 + u/L for a displacement. P = σ/λ for a true stress, because an incompressible piece has the area A/λ
//! under load, or σλ_t² with the lateral stretch λ_t for a compressible law; P = F/A for a force. In simple shear γ = e or u/L, and σ₁₂ = P₁₂.

use super::columns::{Column, Columns};
use super::names::{StrainKind, StressKind};
use super::table::{self, Decimal, Line};
use super::{
    accuracy::SharedError,
    audit::{Audit, AuditKind},
    dimensions::Dimensions,
};
use crate::calibrate::{FitError, Mode, RawRow, Sample, UnknownMode};

/// Stress above which a number is not a measurement \[Pa\]: its square would overflow in a fit
const LARGEST_STRESS: f64 = 1e30;
/// Stretch above which, or below whose inverse, a number is not a measurement \[–\]
const LARGEST_STRETCH: f64 = 1e4;

/// Columns with the dimensions of the test piece.
pub struct Conversion<'a> {
    columns: &'a Columns,
    /// Gauge length \[m\], 1 if strain is recorded
    length: f64,
    /// Cross-section \[m²\], 1 if stress is recorded
    area: f64,
    /// Strain of machine and grips per nominal stress, CA/L \[1/Pa\]
    compliance: f64,
}

impl<'a> Conversion<'a> {
    /// Refuses forces without a cross-section and displacements without a gauge length.
    pub fn new(file: &str, columns: &'a Columns, dimensions: Dimensions, audit: &mut Audit) -> Result<Self, FitError> {
        let mut made = Self { columns, length: 1.0, area: 1.0, compliance: 0.0 };
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
                StressKind::True => log(match &columns.lateral {
                    Some(lateral) => {
                        format!("\"{}\" became nominal stress by P = σλ_t² with \"{}\"", p.name, lateral.name)
                    }
                    None => format!(
                        "\"{}\" became nominal stress by P = σ/λ, as the test piece is taken for incompressible",
                        p.name
                    ),
                }),
                StressKind::Force => {
                    let (area, how) = dimensions.section(file, &p.name)?;
                    made.area = area;
                    log(format!("\"{}\" became nominal stress by division by the cross-section {how}", p.name));
                }
                StressKind::Nominal => {}
            }
        }
        if let Some(compliance) = dimensions.compliance {
            let area = dimensions.needed_section(SharedError::Compliance)?;
            let length = dimensions.needed_length(SharedError::Compliance)?;
            made.compliance = compliance * area / length;
            let message = format!(
                "every strain was reduced by {:.6} per MPa of nominal stress: the compliance of the machine, {:.6} mm/N",
                1e6 * made.compliance,
                1e3 * compliance
            );
            audit.add(AuditKind::Changed, message, vec![]);
        }
        Ok(made)
    }

    /// λ and P \[–, Pa\] of the numbers of one direction. The cross-section under load follows from the stretch without the part of the machine.
    /// `section`: the measured cross-section under load relative to the undeformed one.
    fn point(&self, axis: usize, x: f64, y: f64, mode: Mode, section: Option<f64>) -> Result<(f64, f64), String> {
        // Each pass reduces the error of a true stress to the share CσA/(Lλ²), and of a force to zero; the share reaches 1 where λ is half of the measured stretch
        const PASSES: usize = 1000;
        const SETTLED: f64 = 4.0 * f64::EPSILON;
        let at = |stretch: f64| -> Result<(f64, f64), String> {
            Ok((stretch, self.stress(axis, y, mode, section.unwrap_or(stretch.recip()))?))
        };
        let measured = self.stretch(axis, x, mode)?;
        let mut point = at(measured)?;
        if self.compliance <= 0.0 {
            return Ok(point);
        }
        for _ in 0..PASSES {
            let stretch = mode.stretch(mode.strain(measured) - self.compliance * point.1);
            if !(stretch > 0.0 && stretch.is_finite()) {
                return Err(format!(
                    "stretch {stretch} without the compliance of the machine is not positive and finite"
                ));
            }
            let change = (stretch - point.0).abs();
            point = at(stretch)?;
            if change <= SETTLED * stretch {
                return Ok(point);
            }
        }
        Err("the stretch without the compliance of the machine is not found: the compliance is too large for the stress"
            .into())
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

    /// Cross-section under load relative to the undeformed one, λ_t², from a number of the column of lateral strain.
    fn section(&self, lateral: &Column<StrainKind>, x: f64, mode: Mode) -> Result<f64, String> {
        if mode != Mode::Uniaxial {
            return Err(format!("a lateral strain gives no nominal stress of a true one in {mode} tests"));
        }
        let x = x * lateral.factor;
        let stretch = match lateral.kind {
            StrainKind::Stretch => x,
            StrainKind::True => x.exp(),
            StrainKind::Engineering | StrainKind::Displacement => 1.0 + x,
        };
        if stretch > 0.0 && stretch.is_finite() {
            Ok(stretch * stretch)
        } else {
            Err(format!("lateral stretch {stretch} is not positive and finite"))
        }
    }

    /// P \[Pa\] of a number of the stress column, given the cross-section under load relative to the undeformed one.
    fn stress(&self, axis: usize, y: f64, mode: Mode, section: f64) -> Result<f64, String> {
        let p = &self.columns.axes[axis].1;
        let y = y * p.factor;
        let stress = match p.kind {
            StressKind::True if mode != Mode::SimpleShear => y * section,
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

/// Words of lines below the data that summarise them.
const SUMMARY: [&str; 12] = [
    "mean",
    "average",
    "median",
    "maximum",
    "minimum",
    "max",
    "min",
    "std",
    "sd",
    "mittelwert",
    "standardabweichung",
    "moyenne",
];

/// The samples of a table.
#[derive(Default)]
pub struct Table {
    pub samples: Vec<Sample>,
    pub raw: Vec<RawRow>,
    /// Lines that were left out, with the reason
    left_out: Vec<(u64, String)>,
    /// Lines with neither strain nor stress
    empty: Vec<u64>,
}

impl Table {
    /// Reads the lines of one specimen.
    pub fn read(
        &mut self,
        file: &str,
        lines: &[&Line],
        specimen: usize,
        conversion: &Conversion,
        decimal: Decimal,
        whole_file: Option<Mode>,
    ) -> Result<(), FitError> {
        let columns = conversion.columns;
        let timed =
            columns.time.map(|i| (i, lines.iter().filter(|l| is_number_at(l, i, decimal)).count() * 2 > lines.len()));
        for line in lines.iter().filter(|l| !l.is_empty()) {
            let cell = |i: usize| line.cells.get(i).map_or("", String::as_str);
            let number = |i: usize| table::number(cell(i), decimal);
            if columns.numeric().all(|i| cell(i).is_empty()) {
                self.empty.push(line.number);
                continue;
            }
            let summary = line.cells.iter().find(|c| SUMMARY.contains(&c.to_lowercase().trim_end_matches([':', '.'])));
            let untimed = timed
                .filter(|(i, numbers)| *numbers && !cell(*i).is_empty() && number(*i).is_err())
                .map(|(i, _)| cell(i));
            if let Some(word) = summary.map(String::as_str).or(untimed) {
                self.left_out.push((line.number, format!("\"{word}\" is no data point of a test")));
                continue;
            }
            let read = |i: usize, what: &str| number(i).map_err(|why| format!("column \"{what}\" {why}"));
            let numbers: Result<Vec<(f64, f64)>, String> =
                columns.axes.iter().map(|(e, p)| Ok((read(e.at, &e.name)?, read(p.at, &p.name)?))).collect();
            let numbers = match numbers {
                Ok(numbers) => numbers,
                Err(reason) => {
                    self.left_out.push((line.number, reason));
                    continue;
                }
            };
            let mode = match columns.mode {
                Some(i) => Mode::from_word(cell(i))
                    .ok_or_else(|| UnknownMode { line: Some(line.number), word: cell(i).into() })?,
                None => whole_file.ok_or_else(|| FitError::NoMode { file: file.into() })?,
            };
            if (mode == Mode::Biaxial) != (columns.axes.len() == 2) {
                return Err(FitError::BiaxialRow { file: file.into(), line: line.number });
            }
            let section =
                columns.lateral.as_ref().map(|t| conversion.section(t, read(t.at, &t.name)?, mode)).transpose();
            match section.and_then(|section| convert(conversion, &numbers, mode, section)) {
                Ok(converted) => {
                    for (k, &(stretch, stress)) in converted.iter().enumerate() {
                        let second = if mode == Mode::Biaxial { converted[1 - k].0 } else { 1.0 };
                        self.samples.push(Sample { mode, stretch, second, stress, line: line.number, specimen });
                    }
                }
                Err(reason) => {
                    self.left_out.push((line.number, reason));
                    continue;
                }
            }
            let extra = |c: Option<(usize, f64)>| c.and_then(|(i, factor)| Some(number(i).ok()? * factor));
            self.raw.push(RawRow {
                line: line.number,
                specimen,
                time: extra(columns.time.map(|i| (i, 1.0))),
                displacement: extra(columns.displacement),
                force: extra(columns.force),
            });
        }
        Ok(())
    }

    /// Logs the lines that are not data points; refuses a table without any.
    pub fn finish(&mut self, file: &str, audit: &mut Audit) -> Result<(), FitError> {
        if self.samples.is_empty() {
            let first = self.left_out.first().map(|(line, reason)| format!("line {line}: {reason}"));
            let reason = first.unwrap_or("there are no data below the column names".into());
            return Err(FitError::NoRows { file: file.into(), reason });
        }
        for (number, reason) in std::mem::take(&mut self.left_out) {
            audit.add(AuditKind::LeftOut, format!("line {number}: {reason}"), vec![number]);
        }
        audit.add_rows(AuditKind::Intake, "lines without strain and stress", std::mem::take(&mut self.empty));
        Ok(())
    }
}

fn is_number_at(line: &Line, i: usize, decimal: Decimal) -> bool {
    line.cells.get(i).is_some_and(|c| table::number(c, decimal).is_ok())
}

/// λ and P of each direction.
fn convert(
    conversion: &Conversion,
    numbers: &[(f64, f64)],
    mode: Mode,
    section: Option<f64>,
) -> Result<Vec<(f64, f64)>, String> {
    numbers.iter().enumerate().map(|(k, (x, y))| conversion.point(k, *x, *y, mode, section)).collect()
}
