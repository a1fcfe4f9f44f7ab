//! Elements and formulations: patch tests, closed forms, benchmarks of the field, orders of convergence, locking, and another program.

#[path = "../common/mod.rs"]
mod common;

mod analytic;
mod calculix;
mod convergence;
mod cook;
mod held_cells;
mod incompressible;
mod le10;
mod locking;
mod magnitudes;
mod manufactured;
mod nodal_stress;
mod patch;
mod stability_of_pairs;
