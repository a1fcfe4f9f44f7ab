//! A reduced model that runs: its equations, its error estimate, and its inverse.

pub mod cable;
mod dense;
pub mod dynamics;
pub mod equations;
pub mod fallback;
pub mod inverse;
pub mod laws;
pub mod motion;
pub mod residual;
pub mod twin;
