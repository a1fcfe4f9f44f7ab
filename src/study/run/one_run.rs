//! Errors of a case estimated from its run alone, which a study keeps next to those from several meshes.

use crate::scene::{ErrorBounds, ErrorEstimator, EstimateError, Run};
use crate::solve::Status;
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
    /// Equations of the enriched space
    #[serde(default)]
    pub dofs: usize,
    /// CPU time of the estimate \[s\], which is part of no other time
    #[serde(default)]
    pub cpu_s: f64,
}

/// Error of the peak of a column \[unit of the column\].
#[derive(Serialize, Deserialize, Clone, Copy, Debug, PartialEq)]
pub struct OneRunError {
    /// Corrected less computed value
    pub correction: f64,
    /// The part of it by facets that cut a curved boundary; none where it is not estimated
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geometry: Option<f64>,
    /// Half width of the bounds of the exact value about the corrected one
    pub uncertainty: f64,
    /// Largest distance of the computed value from the exact one within the bounds
    pub bar: f64,
}

/// The errors of these columns of a run that the estimator has followed.
pub fn one_run(estimator: Result<ErrorEstimator, EstimateError>, run: &Run, columns: &[String]) -> OneRunRecord {
    let refused = |why: String| OneRunRecord { refused: Some(why), ..OneRunRecord::default() };
    if run.status != Status::Converged {
        return refused("the run is not complete".into());
    }
    let found = match estimator.and_then(|e| e.estimate(run, columns)) {
        Ok(found) => found,
        Err(why) => return refused(why.to_string()),
    };
    let errors = found.quantities.iter().map(|q| {
        let ErrorBounds { correction, uncertainty, bar } = q.of_departure();
        let geometry = q.geometry.map(|g| g.change - g.start);
        let error = OneRunError { correction, geometry, uncertainty, bar };
        (q.column.clone(), error)
    });
    let is_finite = |(_, e): &(String, OneRunError)| [e.correction, e.uncertainty, e.bar].iter().all(|x| x.is_finite());
    OneRunRecord { quantities: errors.filter(is_finite).collect(), refused: None, dofs: found.dofs, cpu_s: found.cpu }
}
