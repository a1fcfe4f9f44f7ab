//! Stores the results of a study.
//!
//! | Subject | File |
//! |---|---|
//! | Inputs, files and build to which a result belongs | [`identity`], [`builds`] |
//! | Requests for more than curves | [`asked`] |
//! | The record of a case, and the parts of a run that it contains | [`record`], [`finished_run`], [`solver_record`], [`contact_record`], [`energy_record`], [`collapse_record`], [`sunk_record`], [`status`] |
//! | The record of a study, and its cases as they are read back | [`study_record`], [`series`] |
//! | Other files of a case | [`csv_text`], [`skin`], [`fields`], [`field_folder`], [`partial_series`] |
//! | The build that wrote a record which this build cannot read | [`other_build`] |
//! | Whether the text of a record is the one that was stored | [`seal`] |
//! | The folder: which files belong to a case, and whether they are intact | [`names`], [`case_files`], [`folder`] |
//! | Replacing an earlier result by a new one | [`placing`] |
//! | Results of inputs other than the present ones of the study | [`outdated`] |
//! | The files of the report, and whether it belongs to the present study | [`report_files`], [`superseded`] |
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
