//! The solver: accuracy, fast paths, threads, hard cases, stability, time integration, and control of a run.

#[path = "../common/mod.rs"]
mod common;

mod accuracy;
mod control;
mod dynamics;
mod energy;
mod fast_paths;
mod hard_cases;
mod instability;
mod iterative;
mod multigrid;
mod random_scenes;
mod robust;
mod stages;
mod start;
mod steps;
mod threads;
mod time_error;
