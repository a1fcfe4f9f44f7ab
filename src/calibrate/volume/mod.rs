//! Change of volume: Poisson's ratio from lateral strain, or the bulk modulus from pressure over volume.
//!
//! [`fit_volume`] is the entry point; `line` is the method, `fit` applies it to each test, `result` holds the descriptions and the file.

mod error;
mod fit;
mod line;
mod request;
mod result;

pub use error::VolumeError;
pub use fit::fit_volume;
pub use request::{VolumeRequest, VolumeTest};
pub use result::VolumeFit;
