//! Calibration: direct fits from tables, inverse analysis, and the intervals and verdicts of both.

#[path = "../common/mod.rs"]
mod common;

mod fit_corrections;
mod fit_coverage;
mod fit_error_models;
mod fit_ill_posed;
mod fit_intake;
mod fit_intervals;
mod fit_law_correlation;
mod fit_law_file;
mod fit_laws;
mod fit_measurement;
mod fit_preparation;
mod fit_ranges;
mod fit_report;
mod fit_row_order;
mod fit_treloar;
mod fit_verdicts;
mod inverse;
mod inverse_keys;
mod inverse_start;
mod inverse_study;
mod inverse_weights;
mod law_library;
mod neo_hookean;
mod prony;
mod volume;
