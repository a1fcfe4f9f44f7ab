//! Derivatives of what a run records, against closed forms and differences of whole runs.

#[path = "../common/mod.rs"]
mod common;

mod adjoint;
mod contacts;
mod doubtful;
mod in_time;
mod inexact_laws;
mod rigid_parts;
mod statics;
mod to_keys;
