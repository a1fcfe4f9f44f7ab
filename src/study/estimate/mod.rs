//! Values and errors estimated from several meshes or time steps: observed order, Richardson extrapolation, grid convergence
//! index, least squares, references, and the growth of costs.

pub mod curve;
pub mod family;
pub mod fit;
pub mod growth;
pub mod order;
pub mod reference;
