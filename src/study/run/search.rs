//! The search for the constants in a case of a calibration, which precedes its run.

use crate::calibrate::inverse::{
    Calibration, End, Failure, ObservedCurve, SceneModel, SearchWatch, Unknown, calibrate,
};
use crate::scene::{Body, OnProgress, Progress, SceneSpec};
use crate::study::calibration_plan::{CalibrationPlan, MeasuredPlan};
use crate::study::case::{Case, CaseScene};
use crate::study::run::error::CaseError;
use crate::study::store::folder::Store;
use crate::study::store::identity::Identity;
use crate::study::store::record::{NOT_DETERMINED, NOT_SETTLED, OUT_OF_TIME};
use std::sync::Arc;

/// The best values so far from a search with the same inputs that was stopped or ran out of time.
pub(super) fn unfinished(store: &Store, id: &str, identity: &Identity) -> Option<Vec<f64>> {
    let out_of_time = || {
        let record = store.record(id).filter(|r| r.status == OUT_OF_TIME && r.provenance.identity == *identity)?;
        Some(store.calibration(&record.id)?.values())
    };
    store.search(id, identity).or_else(out_of_time)
}

/// Follows the search of a case, and provides its start.
pub(super) struct SearchFollow<'a, 'b> {
    /// Initial values of the constants; `None` for those of the scene
    pub from: Option<&'a [f64]>,
    /// Receives the values of every better point
    pub keep: &'a mut dyn FnMut(&[f64]),
    pub go_on: &'a mut OnProgress<'b>,
}

/// The outcome of the search of a case, and the scene that is run after it.
pub(super) struct Searched {
    /// The constants found, in a case of a calibration
    pub found: Option<Calibration>,
    /// Why the search for them could not start
    pub unsearched: Option<String>,
    /// The scene with the constants found; unchanged if there are none
    pub spec: SceneSpec,
}

/// Finds the constants of a case on its body and those of its further curves, if it belongs to a calibration. `None` if it was stopped.
pub(super) fn find(
    case: &Case,
    (body, of_curves): (&Arc<Body>, Vec<Body>),
    follow: SearchFollow,
) -> Result<Option<Searched>, CaseError> {
    let SearchFollow { from, keep, go_on } = follow;
    let without = |unsearched| Ok(Some(Searched { found: None, unsearched, spec: case.spec.clone() }));
    let Some(plan) = &case.plan else { return without(None) };
    let bodies = std::iter::once(body.clone()).chain(of_curves.into_iter().map(Arc::new));
    let curves = curves(case, plan, bodies)?;
    let mut followed = Followed { progress: SearchProgress::new(curves.len()), go_on, keep };
    match calibrate(curves, &plan.settings, from, &mut followed) {
        Ok((calibration, scene)) => Ok(Some(Searched { found: Some(calibration), unsearched: None, spec: scene.spec })),
        Err(Failure::Input(error)) => Err(error.into()),
        Err(Failure::Interrupted) => Ok(None),
        Err(Failure::Constants(why)) => without(Some(why)),
        Err(Failure::Run(status)) => without(Some(status.to_string())),
    }
}

/// The reason why the constants of a search are not an answer, as a status with its detail.
pub(super) fn doubt(
    case: &str,
    found: Option<&Calibration>,
    unsearched: Option<&str>,
) -> Option<(&'static str, String)> {
    let cannot_begin = |why| format!("the search of case {case} cannot begin at the values of its scene: {why}");
    found.and_then(doubt_of_constants).or_else(|| Some((NOT_SETTLED, cannot_begin(unsearched?))))
}

fn doubt_of_constants(found: &Calibration) -> Option<(&'static str, String)> {
    match found.end {
        End::Settled | End::Stuck if found.constants.iter().any(|c| c.interval.is_none() && c.bound.is_free()) => {
            Some((NOT_DETERMINED, found.unidentified.join("; ")))
        }
        End::Settled => None,
        End::Stuck => Some((
            NOT_SETTLED,
            "the search for the constants did not come to its end; take another start, or fewer unknowns".into(),
        )),
        End::OutOfTime => Some((
            OUT_OF_TIME,
            format!(
                "its time was over after {} forward solves; run again to go on from the best answer so far",
                found.solves
            ),
        )),
    }
}

/// The curves of a case, each with its scene and body.
fn curves(
    case: &Case,
    plan: &CalibrationPlan,
    bodies: impl Iterator<Item = Arc<Body>>,
) -> Result<Vec<ObservedCurve>, CaseError> {
    let own = |((file, spec, text), body, curve): (CaseScene, Arc<Body>, &MeasuredPlan)| {
        let unknown = Unknown::all((file, &spec, text), &plan.constants, &plan.bounds)?;
        let (spec, x, y) = (spec.into_owned(), curve.x.clone(), curve.y.clone());
        let model = SceneModel { file: file.into(), spec, text: text.into(), body, unknown, x, y };
        let MeasuredPlan { name, measured, specimen, offsets, .. } = curve.clone();
        Ok(ObservedCurve { name, model, measured, specimen, offsets })
    };
    let measured = std::iter::once(&plan.curve).chain(plan.more.iter().map(|more| &more.curve));
    let scenes = case.scenes()?.into_iter().zip(bodies).zip(measured);
    scenes.map(|((scene, body), curve)| own((scene, body, curve))).collect()
}

/// Passes on the progress of a search and its better points.
struct Followed<'a, 'b> {
    progress: SearchProgress,
    go_on: &'a mut OnProgress<'b>,
    keep: &'a mut dyn FnMut(&[f64]),
}

impl SearchWatch for Followed<'_, '_> {
    fn progress(&mut self, now: Progress) -> bool {
        (self.go_on)(self.progress.of(now))
    }

    fn better(&mut self, values: &[f64]) {
        (self.keep)(values);
    }
}

/// Progress of a search as one long run: each expected forward solve has the same share of it.
struct SearchProgress {
    /// Number of forward solves expected in the whole search
    expected: usize,
    done: usize,
    /// Time of the last state in the current forward solve \[s\]
    last: f64,
}

impl SearchProgress {
    /// Forward solves per curve in a typical search
    const USUAL: usize = 6;

    fn new(curves: usize) -> Self {
        Self { expected: Self::USUAL * curves, done: 0, last: 0.0 }
    }

    fn of(&mut self, Progress { t, end }: Progress) -> Progress {
        if t < self.last {
            self.done += 1;
            self.expected = self.expected.max(self.done + 2);
        }
        self.last = t;
        let share = (self.done as f64 + t / end) / self.expected as f64;
        Progress { t: share.min(1.0) * end, end }
    }
}
