//! Error estimates: what they contain as often as they say, and what is refused.

#[path = "../common/mod.rs"]
mod common;

mod analysis;
mod coverage;
mod coverage_of_estimates;
mod error_estimate;
mod evidence;
mod interfaces;
mod meshes_of_a_family;
mod one_run_limits;
mod refine;
mod thin_wall;
