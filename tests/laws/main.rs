//! Laws of materials: derivatives, closed forms, memory of the material, and their keywords in other programs.

#[path = "../common/mod.rs"]
mod common;

mod derivatives;
mod foam;
mod keywords;
mod mullins;
mod own_law;
mod parameters;
mod stress_fields;
mod viscoelastic;
