//! Studies: cases, their stored results, the analysis over them and its report.
//!
//! [`expand`] expands a study file into cases, [`runner`] runs them, [`store`] and [`record`] say what is kept, [`results`] reads it
//! back, and [`report`] has the kind of the study ([`kinds`]) analyse and draw it.

pub mod analysis;
pub mod axis;
pub mod case;
pub mod contact;
pub mod content;
pub mod curve;
pub mod estimate;
pub mod expand;
pub mod fields;
pub mod figures;
pub mod inverse;
pub mod kind;
pub mod kinds;
pub mod locking;
pub mod outcome;
pub mod overlay;
pub mod page;
pub mod plan;
pub mod record;
pub mod report;
pub mod results;
pub mod runner;
pub mod skin;
pub mod solver;
pub mod spec;
pub mod store;
pub mod summary;
pub mod tables;
pub mod work;
