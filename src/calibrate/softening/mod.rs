//! Softening: from cyclic data to the constants of the effect `mullins`, next to a law of the first loading.
//!
//! [`fit_softening`] is the entry point. The files: `path` (rows of the first loading, and what each other row has seen), `rows` (what the law says about
//! them), `search` (the constants), `fit` (intervals, and whether a set is shown), `stated` (errors of the measurement in them), `curves` (lines of the
//! figure), `result`.

mod curves;
mod error;
mod fit;
mod path;
mod result;
mod rows;
mod search;
mod stated;

pub use error::SofteningFitError;
pub use fit::{fit_softening, fit_softening_experiment};
pub use result::SofteningFit;
