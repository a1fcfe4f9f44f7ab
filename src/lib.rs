//! Durometer: mesh-convergence studies, hyperelastic calibration and paper figures for soft-robot simulation.
//!
//! A module may use only modules to its left (a test enforces it):
//!
//! ```text
//! math → mesh → material → system → effect → solve → scene → calibrate → report → study → main
//! ```
//!
//! SI units everywhere inside the code; quantities carry their unit in files (`"18 kPa"`).

pub mod calibrate;
pub mod effect;
pub mod material;
pub mod math;
pub mod mesh;
pub mod report;
pub mod scene;
pub mod solve;
pub mod study;
pub mod system;
