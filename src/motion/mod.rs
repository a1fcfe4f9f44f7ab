//! Measured motion: tracks of markers read, registered and evaluated.
//!
//! [`Tracks::read`] reads C3D, TRC and tables; [`registration::rigid`] transforms points to another frame, with its uncertainty; [`body::pose`]
//! computes the rigid motion of a group of markers. A measured or simulated [`Curve`] has plateaus ([`plateau`]), a release ([`release`]) and a
//! ring-down ([`ring_down`]); repeats are pooled ([`repeats`]). [`evaluate`] does all of this for one file and logs its decisions.

mod audit_log;
pub mod body;
mod c3d;
mod curve;
mod curve_states;
mod error;
mod evaluation;
mod knock;
pub mod plateau;
pub mod registration;
pub mod release;
pub mod repeats;
mod request;
pub mod ring_down;
mod ring_down_start;
mod swap;
mod table;
mod table_columns;
mod table_names;
mod track;
mod tracks;
mod trc;
mod vibration;

pub(crate) use audit_log::amount;
pub use curve::Curve;
pub use curve_states::EvaluatedCurve;
pub use error::{MotionError, Swap};
pub use evaluation::{Evaluation, evaluate, evaluate_tracks};
pub use request::{BodyRequest, MotionRequest};
pub use track::{ReadOptions, Track};
pub use tracks::{LARGEST, SMALLEST, Tracks};
