//! Relaxation: from a test in time or frequency to a Prony series with intervals, for the effect `viscoelastic`.
//!
//! [`fit_relaxation`] is the entry point. The files: `table` (file → record), `response` (closed forms of a series in each test), `search` (times and
//! number of terms), `retardation` (creep → relaxation), `long_term` (evidence on the long-term modulus), `fit` (the whole fit), `result`.

mod error;
mod file;
mod fit;
mod long_term;
mod response;
mod result;
mod retardation;
mod search;
mod table;

pub use error::RelaxationError;
pub use file::series_table;
pub use fit::{fit_record, fit_relaxation};
pub use response::{Record, TestKind};
pub use result::{RelaxationFit, RelaxationTerm, RelaxationWarning};
pub use table::{RelaxationRequest, TermChoice};
