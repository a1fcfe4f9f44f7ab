//! Nonnegative least squares: min ‖Ac − y‖ over c ≥ 0.
//!
//! Columns | Function | Method |
//! |---|---|---|
//! A handful, solved often | [`few_weights`] | Every subset, exact |
//! | Dozens, nearly dependent | [`dense_weights`] | A convex program, then its active set |
//! Many, of which few are wanted | [`sparse_weights`] | Column by column, until a tolerance is met |

mod dense;
mod few;
mod sparse;

pub use dense::dense_weights;
pub use few::{few_weights, reduce};
pub use sparse::{SparseWeights, sparse_weights};
