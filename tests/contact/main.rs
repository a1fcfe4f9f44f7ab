//! Contact with rigid obstacles: derivatives, patch test, no crossing, and closed forms.

#[path = "../common/mod.rs"]
mod common;

mod concave;
mod deformable;
mod derivatives;
mod dynamics;
mod hertz;
mod limits;
mod loops;
mod motion;
mod rigid;
mod rolling;
mod setup;
mod start;
mod statics;
mod sticking;
mod surface;
mod tall;
