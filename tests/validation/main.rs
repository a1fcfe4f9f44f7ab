//! Studies of kind `validation`.

#[path = "../common/mod.rs"]
mod common;

mod algebraic;
mod beam;
mod families;
mod intervals;
mod law_files;
mod markers;
mod motion;
mod motion_files;
mod repeats;
mod time_steps;
mod tracks;
