//! Derivatives with respect to constants that are computed during the run of a case.

use crate::calibrate::inverse::InverseError;
use crate::scene::{ParameterKey, Scene, SensitivityRecorder};
use crate::study::run::error::CaseError;
use crate::study::run::task::Task;

/// The recorder of the derivatives that a task requests, if any. If they are only optional and the scene has none, a note says so.
pub(super) fn recorder<'a>(
    scene: &'a Scene,
    task: &'a Task,
    notes: &mut Vec<String>,
) -> Result<Option<SensitivityRecorder<'a>>, CaseError> {
    if task.constants.is_empty() {
        return Ok(None);
    }
    let made = match task.is_at_extremes() {
        true => SensitivityRecorder::at_extremes(scene, &task.constants),
        false => SensitivityRecorder::new(scene, &task.constants),
    };
    let asked = &task.case.derivatives;
    match made {
        Ok(recorder) => Ok(Some(recorder)),
        // Intervals of constants are optional; a scene without derivatives keeps its result
        Err(why) if task.input_uncertainty && task.constants.len() > asked.len() => {
            let added: Vec<ParameterKey> = task.constants.iter().filter(|key| !asked.contains(key)).cloned().collect();
            notes.push(left_out(&added, &why.to_string()));
            if asked.is_empty() {
                return Ok(None);
            }
            SensitivityRecorder::new(scene, asked).map(Some).map_err(|why| InverseError::from(why).into())
        }
        Err(why) => Err(InverseError::from(why).into()),
    }
}

/// The note that no error bar includes constants known within intervals.
fn left_out(constants: &[ParameterKey], why: &str) -> String {
    let names: Vec<String> = constants.iter().map(ToString::to_string).collect();
    format!(
        "the intervals of {} are in no error bar, as derivatives by them are not known here: {why}",
        names.join(", ")
    )
}
