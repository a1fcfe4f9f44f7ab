//! Reduced models: equal to the full model where nothing is left out, near to it where little is, with bars that hold.

#[path = "../common/mod.rs"]
mod common;

mod bar;
mod constants;
mod dynamics;
mod fallback;
mod files;
mod greedy;
mod origin;
mod statics;
mod study;
