//! Files from outside: meshes, robots, what is refused, what is hostile, and what was cut off.

#[path = "../common/mod.rs"]
mod common;

mod cut_off;
mod gap;
mod hostile;
mod import;
mod mesh_files;
mod refuse;
mod robots;
