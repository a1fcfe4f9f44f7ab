//! Derivatives of what a run records, against closed forms and differences of whole runs.

#[path = "../common/mod.rs"]
mod common;

mod adjoint;
mod in_time;
mod statics;
mod to_keys;
