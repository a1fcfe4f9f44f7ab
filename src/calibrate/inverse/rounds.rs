//! Successive searches: along directions that are chosen again at each answer, and a second time if the first search ended where the data say
//! nothing.

use super::Unknown;
use super::bound::Bound;
use super::determined::{Coordinates, Searched};
use super::model::Failure;
use super::objective::{Objective, Point};
use super::search::{self, End, search};
use std::time::Instant;

/// Largest number of searches with newly chosen directions
const ROUNDS: usize = 20;
/// Part of a change of an unknown alone that the curves determine, below which they are silent about it \[–\]
const SILENT: f64 = 0.25;
/// Relative decrease of the misfit from which on a second answer is better than the first \[–\]
const BETTER: f64 = 1e-6;

/// Searches as [`rounds`] does, with a second search if needed. If the curves determine an unknown at the `first` values but not at the answer, such
/// as a time that has become shorter than their resolution, or if an unknown is held at a bound, the misfit may have a lower minimum elsewhere: a
/// second search begins with that unknown at its first value and the others at the answer, and the better of the two counts. The first values are
/// those of the file or of the gauge length, even if the search continues from other values.
pub(super) fn search_again(
    objective: &mut Objective,
    unknown: &[Unknown],
    accuracy: f64,
    (start, first): (Point, &[f64]),
    until: Option<Instant>,
    shares: &mut [f64],
) -> Result<search::SearchResult, Failure> {
    let spec = &objective.curves[0].model.spec;
    let size = objective.size();
    let is_silent = |point: &Point| -> Vec<bool> {
        let coordinates = Coordinates::new(unknown, spec, point, size, Searched::Determined { accuracy });
        coordinates.shares().iter().map(|share| *share < SILENT).collect()
    };
    let at_start = (start.values == first).then(|| is_silent(&start));
    let found = rounds(objective, unknown, accuracy, start, until, shares)?;
    let at_answer = is_silent(&found.point);
    let is_silent_somewhere = at_answer.contains(&true);
    if found.end == End::OutOfTime || !is_silent_somewhere && found.bound.iter().all(|b| b.is_free()) {
        return Ok(found);
    }
    let is_over = || until.is_some_and(|until| Instant::now() > until);
    let at_start = match at_start {
        Some(known) => known,
        None if !is_silent_somewhere => vec![false; at_answer.len()],
        None if is_over() => return Ok(search::SearchResult { end: End::OutOfTime, ..found }),
        None => match ended(objective.at(first))? {
            Some(point) => is_silent(&point),
            None => return Ok(found),
        },
    };
    let mut back = found.point.values.clone();
    let returns = |k: &usize| !found.bound[*k].is_free() || at_answer[*k] && !at_start[*k];
    (0..back.len()).filter(returns).for_each(|k| back[k] = first[k]);
    if back == found.point.values {
        return Ok(found);
    }
    if is_over() {
        return Ok(search::SearchResult { end: End::OutOfTime, ..found });
    }
    let Some(point) = ended(objective.at(&back))? else { return Ok(found) };
    let mut own = shares.to_vec();
    let again = rounds(objective, unknown, accuracy, point, until, &mut own)?;
    if again.point.residual.norm() < (1.0 - BETTER) * found.point.residual.norm() {
        shares.copy_from_slice(&own);
        return Ok(again);
    }
    let end = if again.end == End::OutOfTime { End::OutOfTime } else { found.end };
    Ok(search::SearchResult { end, ..found })
}

/// A forward solve; `None` for values that the scene cannot have.
fn ended(solve: Result<Point, Failure>) -> Result<Option<Point>, Failure> {
    match solve {
        Ok(point) => Ok(Some(point)),
        Err(failure @ (Failure::Input(_) | Failure::Interrupted)) => Err(failure),
        Err(Failure::Constants(_) | Failure::Run(_)) => Ok(None),
    }
}

/// Searches along the directions that are determined, then along those that the residuals of each answer reveal, until no new ones appear. `shares`:
/// the largest part so far of a change of each unknown alone that was searched.
pub(super) fn rounds(
    objective: &mut Objective,
    unknown: &[Unknown],
    accuracy: f64,
    start: Point,
    until: Option<Instant>,
    shares: &mut [f64],
) -> Result<search::SearchResult, Failure> {
    let (spec, curves) = (&objective.curves[0].model.spec, objective.origin.curves.clone());
    objective.begin_at(&start);
    let mut which = Searched::Determined { accuracy };
    let mut found =
        search::SearchResult { bound: vec![Bound::Free; start.values.len()], point: start, end: End::Stuck };
    for round in 0..=ROUNDS {
        let coordinates = Coordinates::new(unknown, spec, &found.point, objective.size(), which);
        shares.iter_mut().zip(coordinates.shares()).for_each(|(most, share)| *most = most.max(*share));
        let before = found.point.values.clone();
        found = search(objective, &coordinates, found.point, until)?;
        if found.end == End::OutOfTime || (round > 0 && found.point.values == before) {
            return Ok(found);
        }
        which = Searched::Told { accuracy, curves: &curves };
    }
    Ok(search::SearchResult { end: End::Stuck, ..found })
}
