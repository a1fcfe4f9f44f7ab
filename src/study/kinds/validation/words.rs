//! Sentences of a validation: its verdict, predictions, advice, and warnings of the calibration.

use crate::report::numbers::{capital, digits, minus_signs, space};
use crate::study::kinds::validation::budget::{COVERAGE, half_width};
use crate::study::kinds::validation::consistency::Consistency;
use crate::study::kinds::validation::findings::{FittedDatum, FoundScatter, Prediction, ValidationFindings};
use crate::study::kinds::validation::joint::Solution;
use crate::study::kinds::validation::plan::{UnknownPlan, ValidationPlan};
use crate::wording::count;
use std::collections::BTreeSet;

/// Largest number of predictions that a verdict names.
const SHOWN: usize = 4;
/// Standard deviations by which data may move an input without a warning.
const FAR: f64 = 2.0;
/// Degrees of freedom of a scatter below which a verdict states them.
const FEW: usize = 3;

/// The number of predictions that are compared, in words: `3 measured predictions`, or `3 predictions that COMSOL gives too`.
fn compared(found: &ValidationFindings, number: usize) -> String {
    match &found.reference {
        Some(reference) => format!("{} that {reference} gives too", count(number, "prediction")),
        None => count(number, "measured prediction"),
    }
}

/// States a prediction as `16.97 ± 0.71 mm (95 %: zero 0.68, load 0.12 mm)`, with at most six terms, and the value of the reference.
pub fn sentence(p: &Prediction, reference: &str) -> String {
    let n = digits(0.1 * (p.interval[1] - p.interval[0]));
    let (up, down) = (p.interval[1] - p.value, p.value - p.interval[0]);
    let half = if (up - down).abs() < 0.05 * (up + down) {
        format!("± {:.n$}", 0.5 * (up + down))
    } else {
        format!("+ {up:.n$} − {down:.n$}")
    };
    // A term that would be printed as zero is left out
    let shown = p.budget.iter().map(|c| (c, format!("{:.n$}", COVERAGE * c.deviation)));
    let terms = shown.filter(|(_, half)| half.contains(|c: char| c.is_ascii_digit() && c != '0'));
    let terms: Vec<String> = terms.take(6).map(|(c, half)| format!("{} {half}", c.group)).collect();
    let mut words = format!(
        "The {} of {} is predicted as {:.n$} {half}{} (95 %: {})",
        p.label,
        p.record_label,
        p.value,
        space(&p.unit),
        terms.join(", ")
    );
    if let Some(m) = p.measured {
        let place = match p.inside {
            Some(true) => "inside the interval".into(),
            Some(false) => "outside of the interval".into(),
            None => format!("not judged, since the interval lacks {}", p.lacks.join(" and ")),
        };
        words += &format!("; {reference} {m:.n$}{}, {place}", space(&p.unit));
    }
    minus_signs(&(words + "."))
}

pub fn verdict(found: &ValidationFindings) -> String {
    if found.predictions.is_empty() {
        return "No verdict: there is no prediction.".into();
    }
    let scored: Vec<bool> = found.predictions.iter().filter_map(|p| p.inside).collect();
    let mut words: Vec<String> = vec![];
    if !scored.is_empty() {
        let inside = scored.iter().filter(|i| **i).count();
        let lie = match (inside, scored.len()) {
            (1, _) | (_, 1) => "lies in its 95 % interval",
            _ => "lie in their 95 % intervals",
        };
        words.push(format!("{inside} of {} {lie}.", compared(found, scored.len())));
    }
    let unjudged: Vec<&Prediction> =
        found.predictions.iter().filter(|p| p.measured.is_some() && p.inside.is_none()).collect();
    if !unjudged.is_empty() {
        let of = if unjudged.len() == 1 {
            "is not judged, since its interval lacks"
        } else {
            "are not judged, since their intervals lack"
        };
        let lacks: BTreeSet<&str> = unjudged.iter().flat_map(|p| &p.lacks).map(String::as_str).collect();
        let lacks = lacks.into_iter().collect::<Vec<_>>().join(" or ");
        words.push(format!("{} {of} {lacks}.", compared(found, unjudged.len())));
    }
    words.extend(found.predictions.iter().take(SHOWN).map(|p| sentence(p, found.reference())));
    if found.predictions.len() > SHOWN {
        let more = match found.predictions.len() - SHOWN {
            1 => "One more prediction is in the table.".into(),
            n => format!("{n} more predictions are in the table."),
        };
        words.push(more);
    }
    words.extend(found.scatter.iter().filter(|s| s.freedom < FEW && s.deviation > 0.0).map(|s| {
        format!("The scatter of the {} is known with {} of freedom only.", of_scatter(s), count(s.freedom, "degree"))
    }));
    words.join(" ")
}

/// Names the quantity of a scatter, with its record if it has one.
pub fn of_scatter(s: &FoundScatter) -> String {
    s.record.as_ref().map_or(s.quantity.clone(), |record| format!("{} of {record}", s.quantity))
}

/// Adds warnings of repeats that are all equal, and of a record that scatters more than the others of its quantity.
pub fn warn_of_scatter(found: &[FoundScatter], warnings: &mut Vec<String>) {
    for s in found {
        let of = of_scatter(s);
        if s.deviation == 0.0 {
            let advice = "an error of the quantity has to contain the digits that are read";
            warnings
                .push(format!("All repeats of the {of} are equal, which tells nothing of their scatter: {advice}."));
        } else if s.record.is_some() {
            let fact = "more than those of its other records, beyond chance; this scatter counts there alone";
            warnings.push(format!("The repeats of the {of} scatter by {:.2e}{}, {fact}.", s.deviation, space(&s.unit)));
        }
    }
}

/// Returns the measurement that would narrow the interval of a prediction most.
pub fn advice(p: &Prediction) -> Option<String> {
    let largest = p.budget.first()?;
    let half = half_width(&p.budget);
    let n = digits(0.1 * half);
    Some(format!(
        "{} of {}: {} counts most; known exactly, it would leave ± {:.n$} of ± {half:.n$}{}.",
        capital(&p.label),
        p.record_label,
        largest.group,
        largest.without,
        space(&p.unit)
    ))
}

/// Adds warnings of constants outside their ranges, inputs that the data move far, and data that scatter more, or less, than expected.
pub fn warn_of_fit(solution: &Solution, consistency: &Consistency, plan: &ValidationPlan, warnings: &mut Vec<String>) {
    for (u, xi) in plan.unknowns.iter().zip(&solution.xi).filter(|(_, xi)| xi.abs() > 1.0) {
        warnings.push(format!(
            "{} ({}) is found at {:.4} {}, outside of its range {} to {}, where its response is extrapolated: widen the range.",
            capital(&u.label), u.key, u.at(*xi), u.unit, u.range[0], u.range[1]
        ));
    }
    for (input, s) in plan.inputs.iter().zip(&solution.s).filter(|(_, s)| s.abs() > FAR) {
        let fact = "its deviation is understated, or it makes up for something that the model misses";
        warnings.push(format!(
            "The records move the input \"{}\" by {s:+.1} of its standard deviations: {fact}.",
            input.name
        ));
    }
    if !consistency.holds() {
        warnings.push(format!(
            "The calibration records scatter {:.1} times as much as their errors say (χ² = {:.1} with {} of freedom): the model misses something, or errors are understated. All statistical parts of the intervals are widened by this factor.",
            consistency.birge(), consistency.chi2, count(consistency.freedom, "degree")
        ));
    }
    if consistency.agrees_too_well() {
        let why = "errors are overstated, or data share errors that count as independent. No interval is narrowed";
        warnings.push(format!(
            "The calibration records agree better than their errors say (χ² = {:.1} with {} of freedom, which chance gives in less than 1 %): {why}.",
            consistency.chi2,
            count(consistency.freedom, "degree")
        ));
    }
}

/// The refusal of a calibration that no value of a constant fits, naming the datum that is farthest off.
pub fn not_fitted(u: &UnknownPlan, fitted: &[FittedDatum]) -> String {
    let farthest = fitted.iter().max_by(|a, b| a.residual.abs().total_cmp(&b.residual.abs()));
    let datum = farthest.map_or(String::new(), |d| {
        let n = digits(1e-2 * d.measured);
        let (measured, closest) = (format!("{:.n$}", d.measured), format!("{:.n$}{}", d.fitted, space(&d.unit)));
        let fact =
            format!("{} of {} is measured as {measured} and comes no closer than {closest}", d.quantity, d.record);
        format!(": {fact}, {:.0} standard deviations off", d.residual.abs())
    });
    let [low, high] = u.range;
    minus_signs(&format!(
        "no value of {} ({}, {low} to {high}{}) fits the calibration records{datum}; look for a mistake in the measured values, their signs and units, or widen the range",
        u.label,
        u.key,
        space(&u.unit)
    ))
}

/// Replaces the indices of constants in a message by their names.
pub fn named(message: &str, plan: &ValidationPlan) -> String {
    plan.unknowns.iter().enumerate().fold(message.to_string(), |m, (k, u)| {
        m.replace(
            &format!("constant {k};"),
            &format!("{} ({}, {} to {} {});", u.label, u.key, u.range[0], u.range[1], u.unit),
        )
    })
}
