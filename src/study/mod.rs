//! Studies: cases, their stored results, and the analysis over them.

pub mod axis;
pub mod band;
pub mod calibration;
mod check;
pub mod contact;
pub mod convergence;
pub mod cost;
pub mod curve;
pub mod fields;
pub mod inverse;
pub mod locking;
pub mod materials;
pub mod outcome;
pub mod overlay;
pub mod plan;
pub mod prices;
pub mod record;
pub mod robustness;
pub mod runner;
pub mod skin;
pub mod solver;
pub mod spec;
pub mod store;
pub mod sweep;
pub mod words;
pub mod work;
