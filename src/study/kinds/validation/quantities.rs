//! Quantities of a validation with their measured values from the study file, tables and tracks, and the errors of these values.

use crate::math::units::{self, Dimension};
use crate::scene::{hint, in_unit_of};
use crate::study::kinds::validation::measured::{MeasuredTable, table};
use crate::study::kinds::validation::plan::{ErrorPlan, QuantityPlan};
use crate::study::kinds::validation::scatter::Repeats;
use crate::study::kinds::validation::spec::{Evaluation, Purpose, QuantitySpec, RecordSpec, ValidationStudy};
use crate::study::kinds::validation::tracks::RecordTracks;
use std::collections::BTreeMap;
use std::path::Path;

/// Measured values by record, and the errors that tracks give them.
type Measured = (BTreeMap<String, Vec<f64>>, BTreeMap<String, Vec<ErrorPlan>>);

/// The sources of measured values.
pub struct Sources<'a> {
    /// Folder of the study file
    pub base: &'a Path,
    pub study: &'a ValidationStudy,
    /// Evaluated tracks by record
    pub tracks: &'a BTreeMap<String, RecordTracks>,
}

impl Sources<'_> {
    /// Reads a quantity over its records; mistakes are added to `wrong`.
    pub fn quantity(&self, q: &QuantitySpec, wrong: &mut Vec<String>) -> QuantityPlan {
        let before = wrong.len();
        let (factor, window) = numbers(q, wrong);
        let errors = errors(q, wrong);
        let (records, by_record) = self.measured(q, window, wrong);
        let (repeats, own) = (Repeats::of(&records), |all: &[ErrorPlan]| all.iter().any(|e| e.shared.is_none()));
        let has_own =
            |r: &str| own(&errors) || by_record.get(r).is_some_and(|e| own(e)) || repeats.in_record(r).is_some();
        let bare: Vec<&str> = records.keys().map(String::as_str).filter(|r| !has_own(r)).collect();
        if !bare.is_empty() && before == wrong.len() {
            let fact = "no error of its own in every record; add an [[quantity.error]] that is not shared, or repeats that differ";
            wrong.push(format!("quantity {}: it has {fact} ({})", q.name, bare.join(", ")));
        }
        QuantityPlan {
            name: q.name.clone(),
            label: q.label.clone(),
            symbol: q.symbol.clone(),
            unit: q.unit.clone(),
            column: q.column.clone(),
            value: q.value,
            factor,
            window,
            records,
            errors,
            by_record,
        }
    }

    /// Measured values by record, empty for one that is only predicted, and the errors that tracks give them.
    fn measured(&self, q: &QuantitySpec, window: Option<[f64; 2]>, wrong: &mut Vec<String>) -> Measured {
        let known: Vec<String> = self.study.records.iter().map(|r| r.name.clone()).collect();
        let wanted = q.records.clone().unwrap_or_else(|| known.clone());
        for name in wanted.iter().chain(q.measured.keys()).filter(|n| !known.contains(n)) {
            wrong.push(format!("quantity {}: there is no record \"{name}\"; {}", q.name, hint(name, &known)));
        }
        for name in q.measured.keys().filter(|n| known.contains(n) && !wanted.contains(n)) {
            let remedy = "add it to them, or remove the value";
            wrong.push(format!(
                "quantity {}: record {name} has a measured value and is none of its `records`; {remedy}",
                q.name
            ));
        }
        let from_table = q.table.as_ref().map(|spec| table(self.base, spec, &q.unit)).transpose();
        let table = from_table.as_ref().ok().and_then(Option::as_ref);
        let (mut records, mut by_record) = (BTreeMap::new(), BTreeMap::new());
        for r in self.study.records.iter().filter(|r| wanted.contains(&r.name)) {
            match self.values(q, r, table, window) {
                Ok((values, errors)) => {
                    if values.is_empty() && r.purpose == Purpose::Calibration && from_table.is_ok() {
                        let fact = "has no measured value of it";
                        wrong.push(format!("quantity {}: the calibration record {} {fact}", q.name, r.name));
                    }
                    if !errors.is_empty() {
                        by_record.insert(r.name.clone(), errors);
                    }
                    records.insert(r.name.clone(), values);
                }
                Err(why) => wrong.push(format!("quantity {}, record {}: {why}", q.name, r.name)),
            }
        }
        if let Err(why) = from_table {
            wrong.push(format!("quantity {}: {why}", q.name));
        }
        (records, by_record)
    }

    /// Measured values of one record with the errors of its tracks.
    fn values(
        &self,
        q: &QuantitySpec,
        r: &RecordSpec,
        table: Option<&MeasuredTable>,
        window: Option<[f64; 2]>,
    ) -> Result<(Vec<f64>, Vec<ErrorPlan>), String> {
        let mut values = q.measured.get(&r.name).map_or(vec![], |v| v.values());
        let in_table = table.map_or(Ok(vec![]), |t| t.values(r.experiment()))?;
        if !values.is_empty() && !in_table.is_empty() {
            return Err("its value is in its table and is typed in too; remove one of the two".into());
        }
        values.extend(in_table);
        let (Some(curve), Some(tracks)) = (&q.curve, self.tracks.get(&r.name)) else { return Ok((values, vec![])) };
        if !values.is_empty() {
            return Err("its value is in its tracks and is typed in too; remove one of the two".into());
        }
        tracks.quantity(curve, q, window).map_err(|e| e.to_string())
    }
}

fn errors(q: &QuantitySpec, wrong: &mut Vec<String>) -> Vec<ErrorPlan> {
    let mut errors = vec![];
    for e in &q.errors {
        match units::in_unit(&e.deviation, &q.unit) {
            Ok(deviation) if deviation > 0.0 => {
                let (group, source) = (e.group.clone(), e.source.clone());
                let shared = e.shared.then(|| format!("{} {group}", q.name));
                errors.push(ErrorPlan { group, deviation, source, shared });
            }
            Ok(_) => wrong.push(format!("quantity {}, error {}: the deviation is not above zero", q.name, e.group)),
            Err(why) => wrong.push(format!("quantity {}, error {}: {why}", q.name, e.group)),
        }
    }
    errors
}

/// The factor from the column to the quantity, and the window of a ring-down \[s\].
fn numbers(q: &QuantitySpec, wrong: &mut Vec<String>) -> (f64, Option<[f64; 2]>) {
    let rings = matches!(q.value, Evaluation::Frequency | Evaluation::Decay);
    let unit = if rings {
        units::in_unit("1 Hz", &q.unit)
    } else {
        in_unit_of(&q.column, &format!("1 {}", q.unit).as_str().into()).map(|own| 1.0 / own)
    };
    let mut mistake = |why: String| wrong.push(format!("quantity {}: {why}", q.name));
    let factor = unit.unwrap_or_else(|why| {
        mistake(format!("unit: {why}"));
        1.0
    });
    let time = |text: &String| units::parse(text, Dimension::TIME);
    let window = match (&q.window, rings) {
        (Some([a, b]), true) => match (time(a), time(b)) {
            (Ok(a), Ok(b)) if a < b => Some([a, b]),
            (Ok(_), Ok(_)) => {
                mistake("the window ends before it begins".into());
                None
            }
            (Err(why), _) | (_, Err(why)) => {
                mistake(format!("window: {why}"));
                None
            }
        },
        (None, true) => {
            mistake("a ring-down needs a window, [\"0.3 s\", \"1.6 s\"]".into());
            None
        }
        (Some(_), false) => {
            mistake("only ring-downs have a window; remove it".into());
            None
        }
        (None, false) => None,
    };
    (q.times * factor, window)
}
