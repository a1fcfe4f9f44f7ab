//! Studies: cases, their stored results, the analysis over them and its report.
//!
//! | Step | File |
//! |---|---|
//! | From a study file to its cases | [`study_file`], the kind of the study in [`kinds`] with what kinds share in [`spec`] and [`axis`], [`expand`], [`case_list`] |
//! | One case, and its calibration task | [`case`], [`calibration_plan`] |
//! | Differences between cases that are overridden by changes of all cases | [`overridden`] |
//! | Additions to a study that has results: meshes by the user, cases by a search | [`extension`], [`rounds`] |
//! | The cases with their stored results and expected costs | [`listing`], [`forecast`], [`time_left`] |
//! | Computing cases | [`run`] |
//! | Storing, verifying and moving results | [`store`] |
//! | Packing cases for a scheduler, and the files for it | [`engine`] |
//! | Mesh, element and time step for a tolerance and a time budget, from coarse pilots | [`plan`] |
//! | Analysis, verdict, tables and figures | the kind of the study in [`kinds`] by the trait in [`kind`], on [`analysis`], [`estimate`], [`curve`], [`extremes`], [`case_outcome`] |
//! | Common parts of the reports of several kinds | [`content`], [`tables`], [`figures`], [`notes`], [`locking`] |
//! | Measured curves or markers laid over a run | [`overlay`] |
//! | Facts that limit how the numbers of one run may be used | [`limits`] |
//! | The page and `summary.json` | [`report`], [`page`], [`summary`] |
//! | The motion in three dimensions | [`view`] |
//! | Publishing a study with its inputs, and running it again | [`bundle`] |
//! | Comparing two results | [`changes`], by what they [claim] |
//! | Methods and references for a paper | [`paper`] |
//! | The studies of the catalogue, and new projects | [`shipped`], [`starters`] |
//! | The schemas of all files | [`schema`] |

pub mod analysis;
pub mod axis;
pub mod bundle;
pub mod calibration_plan;
pub mod case;
pub mod case_list;
pub mod case_outcome;
pub mod changes;
pub mod claim;
pub mod content;
pub mod curve;
pub mod engine;
pub mod estimate;
pub mod expand;
pub mod extension;
pub mod extremes;
pub mod figures;
pub mod forecast;
pub mod kind;
pub mod kinds;
pub mod limits;
pub mod listing;
pub mod locking;
pub mod notes;
pub mod overlay;
pub mod overridden;
pub mod page;
pub mod paper;
pub mod plan;
pub mod report;
pub mod rounds;
pub mod run;
pub mod schema;
pub mod shipped;
pub mod spec;
pub mod starters;
pub mod store;
pub mod study_file;
pub mod summary;
pub mod tables;
pub mod time_left;
pub mod view;
