//! Checks that a column of strain holds what its name and unit say: percent or fractions, strain or stretch, tension or compression.
//!
//! Strains of rubbers in fractions and in percent overlap between 2 and 20: a column without a unit that reaches this range is read only where
//! another column of the table agrees with it. A stretch begins at 1 with hardly any stress, a strain at 0.
//!
//! Where the numbers are ambiguous, the shape of the curve decides: the stress of a rubber is straight at small strains, and bends down in tension
//! and up in compression. The curve of a foam of one term may bend either way; its strain across the load tells tension and compression apart. If
//! another reading misses the data points by less than half as much as the reading that is taken, a doubt is logged.

use super::columns::{Column, Columns, Sign};
use super::names::{self, StrainKind};
use super::table::{self, Decimal, Line};
use super::{
    audit::{Audit, AuditKind},
    columns::ColumnChoice,
};
use crate::calibrate::constant_format::stretch_text;
use crate::calibrate::sample::sides;
use crate::calibrate::{FitError, Mode, Sample};
use crate::math::statistics::mean;

/// Strain above which a column without a unit is not believed \[–\]: rubbers break before, and percent exceed it at once
const LARGEST: f64 = 20.0;
/// Strain above which a column without a unit may hold fractions or percent \[–\]
const DOUBTFUL: f64 = 2.0;
/// Largest strain of a column in percent below which it is suspiciously small for a test of rubber \[–\]
const SMALL: f64 = 0.1;
/// Ratio of the largest strains of two columns of one test up to which their units agree, and the ratios at which they differ by percent against
/// fractions
const AGREE: f64 = 2.5;
const HUNDRED: std::ops::RangeInclusive<f64> = 30.0..=300.0;
/// Largest strain of a column without a unit from which on it may be in percent: half a percent \[–\]
const PERCENT: f64 = 0.5;
/// Misfit of a straight line up to which a curve counts as straight \[–\]
const STRAIGHT: f64 = 0.05;
/// Misfit of the chosen reading above which another one may be better, and the share of it below which the other one is better \[–\]
const MISSES: f64 = 0.03;
const BETTER: f64 = 0.5;
/// Largest strain that may be compressive \[–\]
const FLAT: f64 = 0.95;
/// Least correlation at which a strain across the load counts as growing with the strain along it \[–\]
const GROWS: f64 = 0.5;
/// Largest exponent of the foam that a curve is compared with \[–\]
const EXPONENT: i32 = 25;
/// Strain from which on a column is a stretch if the stress has hardly begun \[–\]
const BEGIN: f64 = 0.9;

/// The table, and the samples that were read from it.
pub struct Read<'a> {
    pub file: &'a str,
    /// Names of all columns
    pub names: &'a [String],
    pub body: &'a [Line],
    pub decimal: Decimal,
    pub columns: &'a Columns,
    pub samples: &'a [Sample],
}

impl Read<'_> {
    /// Refuses or doubts a column of strain that contradicts its name.
    pub fn check(&self, choice: &ColumnChoice, audit: &mut Audit) -> Result<(), FitError> {
        for (e, _) in self.columns.axes.iter().filter(|(e, _)| e.kind != StrainKind::Displacement) {
            self.percent(e, choice, audit)?;
            self.against_the_name(e, choice, audit);
        }
        if choice.strain_kind.is_none() && choice.strain.is_none() && self.columns.axes.len() == 1 {
            self.begin(&self.columns.axes[0].0)?;
        }
        Ok(())
    }

    fn percent(&self, e: &Column<StrainKind>, choice: &ColumnChoice, audit: &mut Audit) -> Result<(), FitError> {
        let largest = self.samples.iter().map(|s| s.stretch.max(s.second) - 1.0).fold(0.0, f64::max);
        let refuse = || {
            let (file, column) = (self.file.into(), e.name.clone());
            Err(FitError::Percent { file, column, largest: 1.0 + largest, kind: e.kind.words() })
        };
        let ratios: Vec<(f64, &String)> =
            self.others(e).filter(|(other, _)| *other > 0.0).map(|(other, name)| (largest / other, name)).collect();
        let agrees = ratios.iter().find(|(r, _)| (1.0 / AGREE..=AGREE).contains(r));
        let hundredfold = ratios.iter().find(|(r, _)| HUNDRED.contains(r) || HUNDRED.contains(&(1.0 / r)));
        if !e.stated && largest > LARGEST {
            return refuse();
        }
        if !e.stated && e.kind != StrainKind::Stretch && largest > DOUBTFUL {
            let Some((_, other)) = agrees else { return refuse() };
            let message =
                format!("column \"{}\" holds fractions, as column \"{other}\" has strains of the same size", e.name);
            audit.add(AuditKind::Intake, message, vec![]);
            return Ok(());
        }
        if let (Some((_, other)), None, None) = (hundredfold, agrees, &choice.strain_unit) {
            return Err(FitError::Meaning {
                file: self.file.into(),
                column: e.name.clone(),
                fact: format!(
                    "reaches a strain of {largest:.4}, and column \"{other}\" of the same test one that differs by a factor of about 100"
                ),
                remedy: "pass --strain-unit % or --strain-unit 1".into(),
            });
        }
        let is_open = !e.stated && e.kind != StrainKind::Stretch && agrees.is_none() && largest >= PERCENT;
        let misfits = [self.misfit(|s| neo_hookean(s.mode, s.stretch)), self.misfit(|s| s.stretch - 1.0)];
        let straight = better(misfits).filter(|[_, other]| *other < 100.0 * STRAIGHT);
        if let Some([taken, other]) = straight.filter(|_| is_open) {
            let message = format!(
                "column \"{}\" has no unit and was read in fractions, up to {} %, but its stresses rise in a straight line (within {other:.1} % rms, a Neo-Hookean law \
                 within {taken:.1} %), as those of strains up to {} % do: pass --strain-unit % if its numbers are percent, --strain-unit 1 if they are fractions",
                e.name,
                stretch_text(100.0 * largest),
                stretch_text(largest)
            );
            audit.add(AuditKind::Doubt, message, vec![]);
        }
        let reach = |s: &Sample| (s.stretch - 1.0).abs().max((s.second - 1.0).abs());
        let reached = self.samples.iter().map(reach).fold(0.0, f64::max);
        if e.factor.abs() == 0.01 && choice.strain_unit.is_none() && reached < SMALL {
            let message = format!(
                "column \"{}\" reaches {:.3} %, which is small for a test of rubber: if its numbers are fractions, pass --strain-unit 1",
                e.name,
                100.0 * reached
            );
            audit.add(AuditKind::Doubt, message, vec![]);
        }
        Ok(())
    }

    /// Doubts a requested unit that contradicts the unit in the name, if the strain is plausible for a test of rubber in the unit of the name and
    /// hardly in the requested one.
    fn against_the_name(&self, e: &Column<StrainKind>, choice: &ColumnChoice, audit: &mut Audit) {
        let own = names::unit(&e.name).and_then(|unit| Some((names::strain_factor(&unit)?, unit)));
        let (Some((factor, own)), Some(asked), StrainKind::Engineering) = (own, &choice.strain_unit, e.kind) else {
            return;
        };
        let reached = self.samples.iter().map(|s| (s.stretch - 1.0).abs()).fold(0.0, f64::max);
        let by_name = reached * factor / e.factor.abs();
        let is_usual = |strain: f64, most: f64| (SMALL..=most).contains(&strain);
        if factor != e.factor.abs() && !is_usual(reached, DOUBTFUL) && is_usual(by_name, LARGEST) {
            let message = format!(
                "column \"{}\" reaches a strain of {reached:.4} in the unit {asked} that was asked for, and {by_name:.4} in {own}, which its name gives: leave \
                 --strain-unit out if the name is right",
                e.name
            );
            audit.add(AuditKind::Doubt, message, vec![]);
        }
    }

    /// Misfit \[–\] of a curve with the best factor to the stresses of the pulled modes.
    fn misfit(&self, curve: impl Fn(&Sample) -> f64) -> f64 {
        let own = || self.samples.iter().filter(|s| Mode::PULLED.contains(&s.mode) && s.is_informative());
        let product = |a: &dyn Fn(&Sample) -> f64| own().map(|s| a(s) * curve(s)).sum::<f64>();
        let factor = product(&|s| s.stress) / product(&curve);
        let left = own().map(|s| (s.stress - factor * curve(s)).powi(2)).sum::<f64>();
        (left / own().map(|s| s.stress * s.stress).sum::<f64>()).sqrt()
    }

    /// Misfit \[–\] of a neo-Hookean law to a uniaxial curve whose strains and stresses are multiplied by `side`; with a given ratio, the misfit of a
    /// foam of one term with the best exponent.
    fn misfit_as(&self, choice: &ColumnChoice, side: f64) -> f64 {
        let at = |s: &Sample| 1.0 + side * (s.stretch - 1.0);
        let Some(nu) = choice.ratio else { return self.misfit(|s| side * neo_hookean(s.mode, at(s))) };
        let exponents = (1..=EXPONENT).flat_map(|a| [f64::from(a), -f64::from(a)]);
        let foam = |a: f64| self.misfit(|s| side * (at(s).powf(a) - at(s).powf(-a * nu)) / (a * at(s)));
        exponents.map(foam).fold(f64::INFINITY, f64::min)
    }

    /// The column of strain across the load that grows with the strain along it, by their correlation, which neither an offset nor noise about it
    /// produces.
    fn growing_across(&self) -> Option<&String> {
        let (e, across) = (&self.columns.axes[0].0, self.columns.across?);
        let number = |line: &Line, at: usize| table::number(line.cells.get(at)?, self.decimal).ok();
        let pair = |line: &Line| Some((e.factor * number(line, e.at)?, number(line, across)?));
        let (along, lateral): (Vec<f64>, Vec<f64>) = self.body.iter().filter_map(pair).unzip();
        let (x, y) = (mean(&along), mean(&lateral));
        let sum = |of: &dyn Fn(f64, f64) -> f64| along.iter().zip(&lateral).map(|(a, b)| of(a - x, b - y)).sum::<f64>();
        let scale = (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt();
        (sum(&|a, b| a * b) > GROWS * scale).then(|| &self.names[across])
    }

    /// Largest strain of each other column of strain, with its name.
    fn others(&self, own: &Column<StrainKind>) -> impl Iterator<Item = (f64, &String)> {
        let own = own.at;
        let chosen = move |i: &usize| *i != own && !self.columns.axes.iter().any(|(e, _)| e.at == *i);
        (0..self.names.len()).filter(chosen).filter_map(|i| {
            let (_, kind) = names::strain(&self.names[i]).filter(|(_, kind)| *kind != StrainKind::Displacement)?;
            let factor = names::strain_factor(names::unit(&self.names[i]).as_deref().unwrap_or("1"))?;
            let cells = self.body.iter().filter_map(|l| table::number(l.cells.get(i)?, self.decimal).ok());
            let largest = cells.fold(0.0, f64::max) * factor;
            let strain = match kind {
                StrainKind::True => largest.exp() - 1.0,
                StrainKind::Stretch => largest - 1.0,
                _ => largest,
            };
            strain.is_finite().then_some((strain, &self.names[i]))
        })
    }

    /// Refuses a strain that begins like a stretch, and a stretch that begins like a strain.
    fn begin(&self, e: &Column<StrainKind>) -> Result<(), FitError> {
        let pulled = |s: &&Sample| matches!(s.mode, Mode::Uniaxial | Mode::Equibiaxial | Mode::Planar);
        let by_stretch = |a: &&Sample, b: &&Sample| a.stretch.total_cmp(&b.stretch);
        let own = || self.samples.iter().filter(pulled);
        let (Some(first), Some(last)) = (own().min_by(by_stretch), own().max_by(by_stretch)) else { return Ok(()) };
        let refuse = |fact: String, remedy: &str| {
            Err(FitError::Meaning { file: self.file.into(), column: e.name.clone(), fact, remedy: remedy.into() })
        };
        let rise = first.stress / last.stress;
        let negative = own().filter(|s| s.stress < 0.0).count();
        match e.kind {
            // A strain from 0.9 on would already have the larger part of its stress
            StrainKind::Engineering | StrainKind::Displacement
                if first.stretch >= 1.0 + BEGIN
                    && last.stretch > first.stretch
                    && rise < 0.5 * neo_hookean(first.mode, first.stretch) / neo_hookean(first.mode, last.stretch) =>
            {
                let fact = format!(
                    "begins at a strain of {:.4} with {:.1} % of the largest stress, as a stretch or a position of the machine does",
                    first.stretch - 1.0,
                    100.0 * rise
                );
                refuse(
                    fact,
                    "pass --strain-kind stretch, or engineering if it is strain; of a position subtract the first value",
                )
            }
            StrainKind::Stretch if first.stretch < 0.5 && negative * 10 <= own().count() && last.stress > 0.0 => {
                let fact = format!("begins at {:.4} without compressive stress, as a strain does", first.stretch);
                refuse(fact, "pass --strain-kind engineering, or stretch if it is one")
            }
            _ => Ok(()),
        }
    }

    /// Refuses tensile data under a header or a mode that says compression; doubts them if the file name says so or a law of compression fits better.
    pub fn check_compression(
        &self,
        choice: &ColumnChoice,
        header: &[(String, String)],
        audit: &mut Audit,
    ) -> Result<(), FitError> {
        let [compression, _] = sides(self.samples);
        let sheared = self.samples.iter().any(|s| s.mode == Mode::SimpleShear);
        if compression || sheared || choice.positive.is_some() {
            return Ok(());
        }
        let speaks = |text: &str| {
            let text = text.to_lowercase();
            ["compress", "d575", "iso 7743", "druckversuch"].iter().any(|w| text.contains(w))
        };
        let said = header.iter().find(|(key, value)| speaks(value) || (speaks(key) && value.is_empty()));
        let named = |i: usize| self.body.iter().filter_map(|l| l.cells.get(i)).any(|cell| speaks(cell));
        let said = match said {
            Some((key, value)) => Some(format!("the header speaks of compression (\"{key}: {value}\")")),
            None if choice.compression || self.columns.mode.is_some_and(named) => {
                Some("the mode is compression".into())
            }
            None => None,
        };
        if let Some(said) = said {
            return Err(FitError::Compression { file: self.file.into(), said });
        }
        let uniaxial = self.samples.iter().all(|s| s.mode == Mode::Uniaxial && s.stretch < 1.0 + FLAT);
        let is_strain = self.columns.axes.iter().all(|(e, _)| e.kind != StrainKind::Stretch);
        let is_open = uniaxial && is_strain;
        let why = if speaks(self.file) || names::is_compressive(self.file) {
            format!("the file is called {}", self.file)
        } else if let Some(across) = self.growing_across().filter(|_| is_open) {
            format!("column \"{across}\" grows with them, as a strain across the load does in compression")
        } else if let Some([taken, other]) =
            better([1.0, -1.0].map(|side| self.misfit_as(choice, side))).filter(|_| is_open)
        {
            let law = if choice.ratio.is_some() { "a foam of one term" } else { "a Neo-Hookean law" };
            format!("{law} follows them within {other:.1} % rms as compression, and within {taken:.1} % as tension")
        } else {
            return Ok(());
        };
        let message = format!(
            "the strains are positive and were read as tension, but {why}: pass --positive compression if the machine counts compression as positive, --positive tension if not"
        );
        audit.add(AuditKind::Doubt, message, vec![]);
        Ok(())
    }
}

/// Changes the sign of columns that count compression as positive: as stated, otherwise by the words of their names.
///
/// A column with a word such as "compressive" whose numbers are mostly positive changes its sign, and the other column of its test follows.
pub fn turn_compression(columns: &mut Columns, body: &[Line], decimal: Decimal, choice: &ColumnChoice) {
    let positive = |at: usize| {
        let numbers = body.iter().filter_map(|l| table::number(l.cells.get(at)?, decimal).ok());
        let signs =
            numbers.fold([0_usize; 2], |[up, down], x| [up + usize::from(x > 0.0), down + usize::from(x < 0.0)]);
        signs[0] > signs[1]
    };
    let Columns { axes, notes, .. } = columns;
    for (e, p) in axes {
        let can_turn = [e.kind != StrainKind::Stretch, true];
        let named = [names::is_compressive(&e.name) && can_turn[0], names::is_compressive(&p.name)];
        let up = [can_turn[0] && positive(e.at), positive(p.at)];
        let by_name = named[0] && up[0] || named[1] && up[1];
        let asked = [choice.positive, choice.stress_positive.or(choice.positive)];
        let turned: [bool; 2] = std::array::from_fn(|k| match asked[k] {
            Some(sign) => can_turn[k] && sign == Sign::Compression,
            None => by_name && up[k],
        });
        let names = [&e.name, &p.name];
        for (k, factor) in [&mut e.factor, &mut p.factor].into_iter().enumerate() {
            let (name, reason) = (names[k], if asked[k].is_some() { "as requested" } else { "by its name" });
            if turned[k] {
                *factor = -*factor;
                notes
                    .push(format!("column \"{name}\" counts compression as positive ({reason}); its sign was changed"));
            } else if named[k] && asked[k].is_some() {
                notes.push(format!(
                    "column \"{name}\" counts tension as positive as requested, although it is called compressive"
                ));
            }
        }
        if turned == [false; 2] && named != [false; 2] && asked == [None; 2] {
            notes
                .push(format!("column \"{}\" or \"{}\" is called compressive and is negative already", e.name, p.name));
        }
    }
}

/// Misfits \[%\] of the chosen reading and of another one, if the other one is clearly better.
fn better([taken, other]: [f64; 2]) -> Option<[f64; 2]> {
    (taken > MISSES && other < BETTER * taken).then_some([100.0 * taken, 100.0 * other])
}

/// P of a neo-Hookean law with μ = 1.
fn neo_hookean(mode: Mode, l: f64) -> f64 {
    mode.nominal(mode.stretches(l, 1.0).map(|x| x * x), l)
}
