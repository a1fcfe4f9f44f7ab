//! Derivatives of what a run records, against closed forms and differences of whole runs.

#[path = "../common/mod.rs"]
mod common;

mod adjoint;
mod contacts;
mod in_time;
mod inexact_laws;
mod statics;
mod to_keys;
