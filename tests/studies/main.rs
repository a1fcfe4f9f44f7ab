//! Studies: kinds without a program of their own, the store of results, and those who run them side by side.

#[path = "../common/mod.rs"]
mod common;

mod around;
mod asked;
mod bundle;
mod bundled_meshes;
mod calibrations;
mod compare;
mod cost;
mod earlier;
mod engines;
mod identity;
mod locks;
mod materials;
mod outage;
mod overridden;
mod parts;
mod places;
mod plan;
mod processes;
mod report_folder;
mod store;
mod sweep;
mod time_steps;
