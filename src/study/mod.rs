//! Studies: cases, their stored results, and the analysis over them.

pub mod convergence;
pub mod fields;
pub mod record;
pub mod runner;
pub mod spec;
pub mod store;
