//! Studies: cases, their stored results, the analysis over them and its report.
//!
//! | Step | File |
//! |---|---|
//! | From a study file to its cases | [`expand`], and the kind of the study in [`kinds`] |
//! | Meshes added to a study that has results | [`extension`] |
//! | The cases with what is stored of them, and what they are expected to cost | [`listing`], [`forecast`], [`time_left`] |
//! | Cases are computed | [`run`] |
//! | Results are kept, verified and moved | [`store`] |
//! | Cases packed for a scheduler, and the files that it takes | [`engine`] |
//! | Analysis, verdict, tables and figures | the kind of the study in [`kinds`], on [`estimate`], [`outcome`] |
//! | The page and `summary.json` | [`report`], [`page`], [`summary`] |
//! | The motion in three dimensions | [`view`] |
//! | Published with its inputs, and run again | [`bundle`] |
//! | Two results compared | [`changes`], by what they [claim] |
//! | Methods and references of a paper | [`paper`] |
//! | The studies of the catalogue, and new projects | [`shipped`], [`starters`] |

pub mod analysis;
pub mod axis;
pub mod bundle;
pub mod case;
pub mod changes;
pub mod claim;
pub mod content;
pub mod curve;
pub mod engine;
pub mod estimate;
pub mod expand;
pub mod extension;
pub mod figures;
pub mod forecast;
pub mod growth;
pub mod inverse;
pub mod kind;
pub mod kinds;
pub mod listing;
pub mod locking;
pub mod notes;
pub mod outcome;
pub mod overlay;
pub mod overridden;
pub mod page;
pub mod paper;
pub mod plan;
pub mod report;
pub mod run;
pub mod schema;
pub mod shipped;
pub mod spec;
pub mod starters;
pub mod store;
pub mod summary;
pub mod tables;
pub mod time_left;
pub mod view;
