//! Searches one after the other: along directions that are chosen anew at each answer, and once more where one came to where the data say nothing.

use super::Unknown;
use super::determined::{Coordinates, Searched};
use super::model::Failure;
use super::objective::{Objective, Point};
use super::search::{self, End, search};
use std::time::Instant;

/// Searches along directions that were chosen anew
const ROUNDS: usize = 20;
/// Part of a change of an unknown alone that the curves determine, below which they say nothing about it \[–\]
const SILENT: f64 = 0.5;

/// As [`rounds`]. Where the curves determine an unknown at the start and say nothing about it at the answer, such as a time that has become shorter than
/// their resolution, the misfit may have a lower minimum elsewhere: a second search begins with that unknown at its start and the others at the answer, and
/// the better one of the two counts.
pub(super) fn search_again(
    objective: &mut Objective,
    unknown: &[Unknown],
    accuracy: f64,
    start: Point,
    until: Option<Instant>,
    shares: &mut [f64],
) -> Result<search::Found, Failure> {
    let laws = &objective.curves[0].model.spec.laws;
    let is_silent = |point: &Point, size: f64| {
        let which = Searched::Determined { accuracy };
        let shares = Coordinates::new(unknown, laws, point, size, which).shares().to_vec();
        shares.into_iter().map(|share| share < SILENT).collect::<Vec<bool>>()
    };
    let (values, at_start) = (start.values.clone(), is_silent(&start, objective.size));
    let found = rounds(objective, unknown, accuracy, start, until, shares)?;
    let at_answer = is_silent(&found.point, objective.size);
    let is_lost = |k: &usize| at_answer[*k] && !at_start[*k];
    let lost: Vec<usize> = (0..values.len()).filter(is_lost).collect();
    if lost.is_empty() || found.end == End::OutOfTime {
        return Ok(found);
    }
    let mut back = found.point.values.clone();
    lost.iter().for_each(|&k| back[k] = values[k]);
    let again = match objective.at(&back) {
        Ok(point) => rounds(objective, unknown, accuracy, point, until, shares)?,
        Err(failure @ (Failure::Input(_) | Failure::Interrupted)) => return Err(failure),
        Err(Failure::Constants(_) | Failure::Run(_)) => return Ok(found),
    };
    Ok(if again.point.residual.norm() < found.point.residual.norm() { again } else { found })
}

/// Searches along the directions that are determined, then along those that the residuals of each answer tell, until they lead nowhere else.
/// `shares`: the largest part so far of a change of each unknown alone that was searched.
pub(super) fn rounds(
    objective: &mut Objective,
    unknown: &[Unknown],
    accuracy: f64,
    start: Point,
    until: Option<Instant>,
    shares: &mut [f64],
) -> Result<search::Found, Failure> {
    let (laws, curves) = (&objective.curves[0].model.spec.laws, objective.rows());
    let mut which = Searched::Determined { accuracy };
    let mut found = search::Found { bound: vec![0; start.values.len()], point: start, end: End::Stuck };
    for round in 0..=ROUNDS {
        let coordinates = Coordinates::new(unknown, laws, &found.point, objective.size, which);
        shares.iter_mut().zip(coordinates.shares()).for_each(|(most, share)| *most = most.max(*share));
        let before = found.point.values.clone();
        found = search(objective, &coordinates, found.point, until)?;
        if found.end == End::OutOfTime || (round > 0 && found.point.values == before) {
            return Ok(found);
        }
        which = Searched::Told { accuracy, curves: &curves };
    }
    Ok(search::Found { end: End::Stuck, ..found })
}
