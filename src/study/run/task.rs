//! Everything needed to compute one case, except the files that its scene names.

use crate::reduction;
use crate::scene::{ParameterKey, Scene, hint};
use crate::study::case::Case;
use crate::study::expand::Study;
use crate::study::overlay::markers::{self, MarkersError};
use crate::study::run::uncertain_constants::uncertain_constants;
use crate::study::store::asked::Asked;
use crate::study::store::record::CaseRecord;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A case and the requests of its study. It can be sent to another process.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Task {
    pub case: Case,
    /// Constants with respect to which the columns are differentiated
    pub constants: Vec<ParameterKey>,
    /// Number of runs, for the scatter of their times
    pub repeats: usize,
    pub estimates_errors: bool,
    /// Whether derivatives are optional: a scene without them keeps its result
    pub input_uncertainty: bool,
    /// Whether all derivatives are computed along the curves
    pub along_curves: bool,
    /// Whether a refused scene is a result
    pub keep_refusals: bool,
    /// Whether the states are kept
    pub keep_states: bool,
    /// Whether fields are written for ParaView
    pub vtu: bool,
    /// Columns that are judged
    pub columns: Vec<String>,
    /// Whether the columns are judged as curves over time
    pub over_time: bool,
    pub study_file: PathBuf,
    /// Contents that the files of its scenes must have whenever they are read, path → SHA-256; other files may have any content
    pub files: BTreeMap<PathBuf, String>,
}

/// A scene does not record what its study judges, or cannot run in a study.
#[derive(Debug, thiserror::Error)]
pub enum TaskError {
    #[error("{}: the signal {signal} waits for a controller, and a study has none; drive it by a signal", file.display())]
    Controlled { file: PathBuf, signal: String },
    #[error("{}: variant {variant}: {fact}", file.display())]
    Quantity { file: PathBuf, variant: String, fact: String },
    #[error("{}: {source}", file.display())]
    Markers { file: PathBuf, source: MarkersError },
}

impl Task {
    pub fn new(study: &Study, case: Case, constants: Vec<ParameterKey>, vtu: bool) -> Self {
        Self {
            constants,
            // A run that writes fields does not measure its cost
            repeats: if vtu { 1 } else { study.repeats(&case) },
            estimates_errors: study.estimates_errors(&case),
            input_uncertainty: study.rules.input_uncertainty,
            along_curves: study.rules.along_curves,
            keep_refusals: study.rules.keep_refusals,
            keep_states: study.rules.keep_states,
            vtu,
            columns: study.columns_of(&case),
            over_time: !study.columns.contains_key(&case.family),
            study_file: study.file.clone(),
            files: BTreeMap::new(),
            case,
        }
    }

    /// The task of a case with known inputs, including the derivatives that its study requests.
    pub fn of(study: &Study, case: &Case, vtu: bool) -> Self {
        let is_asked = study.rules.input_uncertainty && (!study.rules.along_curves || study.is_of_design(case));
        let uncertain = if is_asked { uncertain_constants(&case.spec) } else { vec![] };
        let uncertain = uncertain.into_iter().flat_map(|one| one.keys).filter(|key| !case.derivatives.contains(key));
        let constants = case.derivatives.iter().cloned().chain(uncertain);
        Self::new(study, case.clone(), constants.collect(), vtu)
    }

    /// Everything requested of the case in addition to its curves.
    pub fn asked(&self) -> Asked {
        Asked {
            estimates: if self.estimates_errors { self.columns.clone() } else { vec![] },
            constants: self.constants.iter().map(ToString::to_string).collect(),
            along_curves: !self.constants.is_empty() && !self.is_at_extremes(),
            repeats: self.repeats,
            states: self.keep_states,
        }
    }

    /// Whether derivatives are requested at extremes only. Only the analysis of the intervals of constants does so; all others use them along curves.
    pub fn is_at_extremes(&self) -> bool {
        self.input_uncertainty && self.case.derivatives.is_empty() && !self.along_curves
    }

    /// Checks that the scene records every judged column as a curve over time and leaves no signal to a controller.
    pub fn check(&self, scene: &Scene) -> Result<(), TaskError> {
        if let Some(signal) = scene.controls.controlled().pop() {
            return Err(TaskError::Controlled { file: self.case.scene_file.clone(), signal });
        }
        markers::read(scene).map_err(|source| TaskError::Markers { file: self.case.scene_file.clone(), source })?;
        let refuse = |fact| self.refusal(fact);
        if self.over_time {
            scene.check_time().map_err(refuse)?;
        }
        self.columns.iter().try_for_each(|column| scene.check_column(column)).map_err(refuse)?;
        if self.keep_states {
            reduction::check(scene, &self.columns).map_err(|why| refuse(why.to_string()))?;
        }
        Ok(())
    }

    /// Checks that a stored result, if it has any columns, has every judged one.
    pub fn check_record(&self, record: &CaseRecord) -> Result<(), TaskError> {
        let known: Vec<String> = record.probes.keys().cloned().collect();
        match self.columns.iter().find(|column| !known.is_empty() && !known.contains(column)) {
            None => Ok(()),
            Some(name) => Err(self.refusal(format!("the scene records no \"{name}\"; {}", hint(name, &known)))),
        }
    }

    fn refusal(&self, fact: String) -> TaskError {
        TaskError::Quantity { file: self.study_file.clone(), variant: self.case.variant.clone(), fact }
    }
}
