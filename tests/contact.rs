//! Contact with rigid obstacles: derivatives, patch test, no crossing, and closed forms.

mod common;

#[path = "contact/derivatives.rs"]
mod derivatives;
#[path = "contact/dynamics.rs"]
mod dynamics;
#[path = "contact/hertz.rs"]
mod hertz;
#[path = "contact/limits.rs"]
mod limits;
#[path = "contact/loops.rs"]
mod loops;
#[path = "contact/motion.rs"]
mod motion;
#[path = "contact/rigid.rs"]
mod rigid;
#[path = "contact/setup.rs"]
mod setup;
#[path = "contact/statics.rs"]
mod statics;
#[path = "contact/surface.rs"]
mod surface;
