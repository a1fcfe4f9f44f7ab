//! Errors of a case estimated from its run alone, which a study stores in addition to those from several meshes.

use crate::scene::{ErrorBounds, ErrorEstimator, EstimateError, Run};
use crate::solve::Status;
use crate::wording::all;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Errors estimated from one run, or the reason why there are none.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct OneRunRecord {
    /// Column → error
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub quantities: BTreeMap<String, OneRunError>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
    /// Requested columns for which no estimate can be made; they do not affect the others
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unestimated: Vec<String>,
    /// Number of equations of the enriched space
    #[serde(default)]
    pub dofs: usize,
    /// CPU time of the estimate \[s\], which no other time includes
    #[serde(default)]
    pub cpu_s: f64,
}

impl OneRunRecord {
    /// Why requested columns have no error, if known: the reason for the whole run, or their names.
    pub fn missing(&self) -> Option<String> {
        let are = if self.unestimated.len() == 1 { "is" } else { "are" };
        let columns =
            || format!("{} {are} not estimated, only columns with a derivative by the state", all(&self.unestimated));
        self.refused.clone().or_else(|| (!self.unestimated.is_empty()).then(columns))
    }

    /// Why some columns have no error that a plan on a given mesh can use, if known; an error of the body that the facets enclose is usable.
    pub fn unusable(&self) -> Option<String> {
        self.missing().or_else(|| self.without(|error| error.lacks.clone()))
    }

    /// The columns whose error bars are incomplete, and the missing parts.
    pub fn lacking(&self) -> Option<String> {
        self.without(OneRunError::lacks)
    }

    fn without(&self, parts: impl Fn(&OneRunError) -> Option<String>) -> Option<String> {
        let mut by_parts: BTreeMap<String, Vec<&String>> = BTreeMap::new();
        for (column, error) in &self.quantities {
            if let Some(parts) = parts(error) {
                by_parts.entry(parts).or_default().push(column);
            }
        }
        let of = |(parts, columns): (String, Vec<&String>)| {
            let (bar, is) = if columns.len() == 1 { ("bar", "is") } else { ("bars", "are") };
            format!("the error {bar} of {} from one run {is} without {parts}", all(&columns))
        };
        let clauses: Vec<String> = by_parts.into_iter().map(of).collect();
        (!clauses.is_empty()).then(|| clauses.join("; "))
    }

    /// The error of a column, if its error bar is complete except for curved facets.
    pub fn whole(&self, column: &str) -> Option<&OneRunError> {
        self.quantities.get(column).filter(|error| error.lacks.is_none())
    }
}

/// Error of the peak of a column \[unit of the column\].
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct OneRunError {
    /// Corrected minus computed value
    pub correction: f64,
    /// The part of the correction due to facets that approximate a curved boundary; `None` if it is not estimated
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry: Option<f64>,
    /// Half-width of the bounds of the exact value about the corrected one
    pub uncertainty: f64,
    /// Largest distance of the computed value from the exact one within the bounds
    pub bar: f64,
    /// Parts of the error missing in the error bar, in words, except those of curved facets
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lacks: Option<String>,
}

impl OneRunError {
    /// All parts of the error missing in the error bar, in words; `None` if it is complete.
    pub fn lacks(&self) -> Option<String> {
        let facets = self.geometry.is_none().then(|| "curved facets".to_string());
        let parts: Vec<String> = facets.into_iter().chain(self.lacks.clone()).collect();
        (!parts.is_empty()).then(|| all(&parts))
    }
}

/// Estimates the errors of these columns for a run that the estimator has followed.
pub fn one_run(estimator: Result<ErrorEstimator, EstimateError>, run: &Run, columns: &[String]) -> OneRunRecord {
    let refused = |why: String| OneRunRecord { refused: Some(why), ..OneRunRecord::default() };
    if run.status != Status::Converged {
        return refused("the run is not complete".into());
    }
    let estimator = match estimator {
        Ok(estimator) => estimator,
        Err(why) => return refused(why.to_string()),
    };
    let known = estimator.estimated_columns();
    let (estimated, unestimated): (Vec<String>, Vec<String>) =
        columns.iter().cloned().partition(|column| known.contains(column));
    if estimated.is_empty() {
        return OneRunRecord { unestimated, ..OneRunRecord::default() };
    }
    let found = match estimator.estimate(run, &estimated) {
        Ok(found) => found,
        Err(why) => return OneRunRecord { unestimated, ..refused(why.to_string()) },
    };
    let errors = found.quantities.iter().map(|q| {
        let ErrorBounds { correction, uncertainty, bar } = q.departure;
        let geometry = q.geometry.map(|g| g.change - g.start);
        let error = OneRunError { correction, geometry, uncertainty, bar, lacks: q.lacks_on_facets() };
        (q.column.clone(), error)
    });
    let is_finite = |(_, e): &(String, OneRunError)| [e.correction, e.uncertainty, e.bar].iter().all(|x| x.is_finite());
    let quantities = errors.filter(is_finite).collect();
    OneRunRecord { quantities, refused: None, unestimated, dofs: found.dofs, cpu_s: found.spent.cpu_s }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plan may not use an error bar with a missing part, and the sentence names all such parts.
    #[test]
    fn bars_with_parts_missing_are_named() {
        let whole = OneRunError { bar: 0.1, geometry: Some(0.0), ..OneRunError::default() };
        let near = OneRunError { lacks: Some("the extent of clamp".into()), ..whole.clone() };
        let of = |quantities: Vec<(&str, &OneRunError)>| {
            let quantities = quantities.into_iter().map(|(column, error)| (column.to_string(), error.clone()));
            OneRunRecord { quantities: quantities.collect(), ..OneRunRecord::default() }
        };
        let found = of(vec![("force_N", &whole), ("tip_x_m", &near)]);
        assert!(found.whole("force_N").is_some() && found.whole("tip_x_m").is_none() && found.whole("none").is_none());
        let words = "the error bar of tip_x_m from one run is without the extent of clamp";
        assert_eq!((found.lacking().as_deref(), found.missing()), (Some(words), None));
        let both = of(vec![("tip_y_m", &near), ("tip_x_m", &near)]).lacking().expect("two of them");
        assert!(both.starts_with("the error bars of tip_x_m and tip_y_m from one run are without"), "{both}");
        let edge = OneRunError { lacks: Some("the singular edge".into()), ..whole.clone() };
        let parts = of(vec![("tip_y_m", &near), ("m_1_x_m", &edge)]).lacking().expect("two parts");
        assert!(
            parts.contains("of tip_y_m from one run is without the extent of clamp; the error bar of m_1_x_m"),
            "{parts}"
        );
        assert_eq!(of(vec![("force_N", &whole)]).lacking(), None);
    }

    /// The error due to curved facets is not estimated if states depend on the path: a plan on a given mesh uses such an error bar, and a study says
    /// that it is incomplete.
    #[test]
    fn a_bar_without_the_error_of_facets_is_that_of_the_body_they_enclose() {
        let on_facets = OneRunError { bar: 0.1, ..OneRunError::default() };
        let near = OneRunError { lacks: Some("the extent of clamp".into()), ..on_facets.clone() };
        assert_eq!(on_facets.lacks().as_deref(), Some("curved facets"));
        assert_eq!(near.lacks().as_deref(), Some("curved facets and the extent of clamp"));
        let quantities = [("force_N".to_string(), on_facets)].into();
        let found = OneRunRecord { quantities, ..OneRunRecord::default() };
        assert!(found.whole("force_N").is_some() && found.unusable().is_none());
        let words = "the error bar of force_N from one run is without curved facets";
        assert_eq!(found.lacking().as_deref(), Some(words));
    }
}
