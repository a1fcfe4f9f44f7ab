//! Softening: from cyclic data to the constants of the effect `mullins`, together with a law of the first loading.
//!
//! [`fit_softening`] is the entry point, in `answer`. The other files: `path` (rows of the first loading, and the loading history of every other
//! row), `rows` (stresses and energies of the law at them), `search` (the constants), `fit` (intervals, and whether a set is shown), `stated` (errors
//! of the measurement in the intervals), `curves` (lines of the figure), `result`.

mod answer;
mod curves;
mod error;
mod fit;
mod path;
mod result;
mod rows;
mod search;
mod stated;

pub use answer::{fit_softening, fit_softening_experiment};
pub use error::SofteningFitError;
pub use result::SofteningFit;
