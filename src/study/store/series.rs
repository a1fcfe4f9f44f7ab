//! A stored case with its time series.

use crate::study::store::record::CaseRecord;
use std::collections::BTreeMap;

/// A case that was read from the folder of results: its record and its time series.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredCase {
    pub record: CaseRecord,
    pub series: Series,
}

/// Time series of a case, as `cases/<id>.csv` holds it: the columns over `t_s`.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Series {
    /// \[samples\] time \[s\]
    pub t_s: Vec<f64>,
    /// Column name → \[samples\], unit in the name
    pub columns: BTreeMap<String, Vec<f64>>,
}
