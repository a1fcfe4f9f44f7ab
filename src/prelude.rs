//! The types and functions of most programs that use the library: `use durometer::prelude::*;`.
//!
//! The examples of the repository use nothing else, apart from [`scene::spec`](crate::scene::spec), which has the parts
//! of a scene for a program that writes one in Rust.

pub use crate::calibrate::{Experiment, FitError, FitOptions, FitRequest, FitResult, Mode, StretchRange, fit};
pub use crate::material::kinematics::Invariants;
pub use crate::material::{
    Law, LawEntry, LawError, LawInfo, Moduli, Parameter, Response, Want, check_law, law_from_table, moduli, register,
};
pub use crate::math::signal::{Clock, Signal};
pub use crate::math::tensor::{Mat3, Vec3};
pub use crate::math::units::{self, Dimension};
pub use crate::mesh::structured::block;
pub use crate::mesh::{MeshError, Order, TetMesh};
pub use crate::scene::control::{ControlError, Controller, Observation, Opening, Reply};
pub use crate::scene::output::{Field, FieldSpec};
pub use crate::scene::{
    Body, Checkpoint, CheckpointError, Moment, OnProgress, OnRow, OnSave, OnSized, OnState, Progress, Recorder, Run,
    RunOptions, Saved, Scene, SceneBuilder, SceneError, SceneSpec, open_scene, overrides, parse_scene, read_scene,
};
pub use crate::solve::Status;
pub use crate::study::expand::Study;
pub use crate::study::report::write_report;
pub use crate::study::run::growing::run_study;
pub use crate::study::run::runner::{Isolation, Options as StudyOptions, Watch};
pub use crate::study::store::record::CaseRecord;
pub use crate::study::summary::Summary;
pub use crate::system::{
    At, BlockValues, Blocks, Capabilities, Constraint, Effect, EnergyRole, EvalError, HistoryVariables, Means, Needs,
    Rates, State, System,
};
