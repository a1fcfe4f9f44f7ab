//! Values and errors estimated from several meshes or time steps: observed order, Richardson extrapolation, grid convergence
//! index, least squares, references, and the growth of costs.
//!
//! | Question | File |
//! |---|---|
//! | Order, limit and kind of convergence of three meshes; safety factors and thresholds | `richardson` |
//! | Order and limit of four meshes or more | `least_squares` |
//! | Accepted errors, relative and absolute | `tolerance` |
//! | f* ± U(f*) of one family, and its limitations | `family` |
//! | The method by which f* is found, in words | `method` |
//! | The reference among the families | `reference` |
//! | Curves over time instead of single numbers | `curve` |
//! | Sizes of time steps | `step_size` |
//! | Power laws of cost versus size | `power_law` |

pub mod curve;
pub mod family;
pub mod least_squares;
pub mod method;
pub mod power_law;
pub mod reference;
pub mod richardson;
pub mod step_size;
pub mod tolerance;
