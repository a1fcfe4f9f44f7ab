//! Studies of kind `validation`.

mod algebraic;
mod beam;
mod intervals;
mod tracks;
