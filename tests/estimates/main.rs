//! Error estimates: what they contain as often as they say, and what is refused.

#[path = "../common/mod.rs"]
mod common;

mod algebraic_error;
mod convergence_report;
mod convergence_verdicts;
mod coverage;
mod coverage_of_estimates;
mod error_estimate;
mod evidence;
mod finer_meshes;
mod interfaces;
mod limits_of_families;
mod meshes_of_a_family;
mod one_run_limits;
mod refine;
mod thin_wall;
