//! Softening: from cyclic data to the constants of the effect `mullins`, next to a law of the first loading.
//!
//! [`fit_softening`] is the entry point. The files: `path` (rows of the first loading, and what each other row has seen), `fit` (the constants), `result`.

mod error;
mod fit;
mod path;
mod result;

pub use error::SofteningFitError;
pub use fit::{fit_softening, fit_softening_experiment};
pub use result::SofteningFit;
