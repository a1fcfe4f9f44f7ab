//! Keeps the results of a study.
//!
//! | Subject | File |
//! |---|---|
//! | Inputs, files and build that a result belongs to | [`identity`], [`builds`] |
//! | The record of a case, and what of a run goes into it | [`record`], [`outcome`], [`solver`], [`contact`], [`energy`], [`collapse`], [`status`] |
//! | The record of a study, and its cases as they are read back | [`study_record`], [`series`] |
//! | Its other files | [`csv_text`], [`skin`], [`fields`], [`partial_series`] |
//! | The build that wrote a record which this one cannot read | [`other_build`] |
//! | Whether the text of a record is the one that was stored | [`seal`] |
//! | The folder: which files belong to a case, and whether they are sound | [`case_files`], [`folder`] |
//! | Which results are of other inputs than the study has now | [`outdated`] |
//! | Several runs into one folder | [`lock`] |
//! | Verification, cleaning and archives | [`upkeep`], [`archive`] |
//! | Reading results back for a report | [`results`] |

pub mod archive;
pub mod builds;
pub mod case_files;
pub mod collapse;
pub mod contact;
pub mod csv_text;
pub mod energy;
pub mod fields;
pub mod folder;
pub mod identity;
pub mod lock;
pub mod other_build;
pub mod outcome;
pub mod outdated;
pub mod partial_series;
pub mod record;
pub mod results;
pub mod seal;
pub mod series;
pub mod skin;
pub mod solver;
pub mod states;
pub mod status;
pub mod study_record;
pub mod upkeep;
