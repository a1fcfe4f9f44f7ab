//! Intake: from a file of a testing machine to an [`Experiment`](crate::calibrate::Experiment), typed samples with an audit log.

pub(super) mod accuracy;
pub(super) mod audit;
pub(super) mod card;
pub(super) mod columns;
pub(super) mod dimensions;
pub(super) mod experiment;
pub(super) mod meaning;
pub(crate) mod names;
pub(super) mod parts;
pub(super) mod piece;
pub(crate) mod roles;
pub(super) mod samples;
pub(crate) use crate::storage::table;
pub(super) mod tables;
pub(super) mod unusual;
