//! Studies: cases, their stored results, the analysis over them and its report.
//!
//! | Step | File |
//! |---|---|
//! | From a study file to its cases | [`expand`], and the kind of the study in [`kinds`] |
//! | Meshes added to a study that has results | [`extension`] |
//! | Which cases run, and which stored result is reused | [`only`], [`waiting`], [`runner`] |
//! | The cases with what is stored of them, and what they are expected to cost | [`listing`], [`forecast`] |
//! | One case: what is asked, its computation, its process | [`task`], [`compute`], [`worker`] |
//! | Errors from one run and derivatives by constants, kept with a result | [`one_run`], [`inputs`] |
//! | Inputs, files and build that a result belongs to | [`identity`], [`builds`] |
//! | Content of a stored result, and where it is kept | [`record`], [`store`] |
//! | Several runs into one store | [`lock`] |
//! | Memory of cases that run side by side | [`memory`] |
//! | Cases packed for a scheduler, and the files that it takes | [`batches`], [`engine`] |
//! | Verification, cleaning and archives of stored results | [`case_files`], [`upkeep`], [`archive`] |
//! | Reading stored results back | [`results`] |
//! | Analysis, verdict, tables and figures | the kind of the study in [`kinds`], on [`estimate`] |
//! | The page and `summary.json` | [`report`], [`page`], [`summary`] |

pub mod analysis;
pub mod archive;
pub mod axis;
pub mod batches;
pub mod builds;
pub mod case;
pub mod case_files;
pub mod compute;
pub mod contact;
pub mod content;
pub mod curve;
pub mod engine;
pub mod estimate;
pub mod expand;
pub mod extension;
pub mod fields;
pub mod figures;
pub mod forecast;
pub mod identity;
pub mod inputs;
pub mod inverse;
pub mod kind;
pub mod kinds;
pub mod listing;
pub mod lock;
pub mod locking;
pub mod memory;
pub mod one_run;
pub mod only;
pub mod outcome;
pub mod overlay;
pub mod page;
pub mod partial_series;
pub mod plan;
pub mod record;
pub mod refinement;
pub mod report;
pub mod results;
pub mod runner;
pub mod skin;
pub mod solver;
pub mod spec;
pub mod store;
pub mod summary;
pub mod tables;
pub mod task;
pub mod upkeep;
pub mod waiting;
pub mod work;
pub mod worker;
