//! Columns as functions of a few polynomials of the displacement, from which a model of few unknowns reads them too.

use super::winding::Winding;

/// The polynomials of a recorder, and how its columns follow from them.
pub struct Features {
    /// Largest degree of the polynomials
    pub degree: usize,
    /// In the order of the columns
    pub readings: Vec<Reading>,
}

/// A column as a function of polynomials of the displacement.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// The polynomial of this index
    Value(usize),
    /// The angle \[deg\] by which the direction of three polynomials, from this index on, has turned
    Turned(usize, Winding),
}
