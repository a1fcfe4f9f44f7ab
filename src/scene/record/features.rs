//! Columns as functions of a few polynomials of the displacement, from which a reduced model can also compute them.

use super::winding::Winding;

/// The polynomials of a recorder, and the functions by which its columns follow from them.
pub struct Features {
    /// Largest degree of the polynomials
    pub degree: usize,
    /// The columns, in order
    pub readings: Vec<Reading>,
}

/// A column as a function of polynomials of the displacement.
#[derive(Clone, Debug, PartialEq)]
pub enum Reading {
    /// The polynomial with this index
    Value(usize),
    /// The angle \[deg\] by which the direction given by three polynomials, from this index on, has rotated
    Turned(usize, Winding),
}
