//! Keeps the results of a study.
//!
//! | Subject | File |
//! |---|---|
//! | Inputs, files and build that a result belongs to | [`identity`], [`builds`] |
//! | Requests for more than curves | [`asked`] |
//! | The record of a case, and what of a run goes into it | [`record`], [`finished_run`], [`solver_record`], [`contact_record`], [`energy_record`], [`collapse_record`], [`sunk_record`], [`status`] |
//! | The record of a study, and its cases as they are read back | [`study_record`], [`series`] |
//! | Its other files | [`csv_text`], [`skin`], [`fields`], [`field_folder`], [`partial_series`] |
//! | The build that wrote a record which this one cannot read | [`other_build`] |
//! | Whether the text of a record is the one that was stored | [`seal`] |
//! | The folder: which files belong to a case, and whether they are sound | [`names`], [`case_files`], [`folder`] |
//! | How a result takes the place of an earlier one | [`placing`] |
//! | Which results are of other inputs than the study has now | [`outdated`] |
//! | Which files belong to the report, and whether it is of the present study | [`report_files`], [`superseded`] |
//! | The study whose results a folder holds | [`origin`] |
//! | Several runs into one folder | [`lock`] |
//! | Verification, cleaning and archives | [`upkeep`], [`archive`] |
//! | Reading results back for a report | [`results`] |

pub mod archive;
pub mod asked;
pub mod builds;
pub mod case_files;
pub mod collapse_record;
pub mod contact_record;
pub mod csv_text;
pub mod energy_record;
pub mod field_folder;
pub mod fields;
pub mod finished_run;
pub mod folder;
pub mod identity;
pub mod lock;
pub mod names;
pub mod origin;
pub mod other_build;
pub mod outdated;
pub mod partial_series;
pub mod placing;
pub mod record;
pub mod report_files;
pub mod results;
pub mod seal;
pub mod series;
pub mod skin;
pub mod solver_record;
pub mod states;
pub mod status;
pub mod study_record;
pub mod sunk_record;
pub mod superseded;
pub mod upkeep;
