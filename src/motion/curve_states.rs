//! The held and the final state of every curve of a record.

use super::curve::Curve;
use super::error::MotionError;
use super::plateau::Plateau;
use crate::calibrate::Bounded;
use crate::math::statistics::t_quantile;

/// A curve with its held and final states.
#[derive(Clone, Debug)]
pub struct EvaluatedCurve {
    pub curve: Curve,
    pub held: Option<Plateau>,
    pub last: Option<Plateau>,
    /// Final minus held mean with its 95 % interval, from the noise of this record only
    pub change: Option<Bounded>,
}

/// Evaluates the states of all curves in the windows of the held and the final state. A curve without values there, such as that of a hidden marker,
/// has no states.
pub fn with_states(
    curves: Vec<Curve>,
    windows: [Option<[f64; 2]>; 2],
    doubts: &mut Vec<String>,
) -> Result<Vec<EvaluatedCurve>, MotionError> {
    let mut over = |window: Option<[f64; 2]>| {
        let Some(window) = window else { return Ok(vec![None; curves.len()]) };
        let all: Vec<Result<Plateau, MotionError>> = curves.iter().map(|c| Plateau::over(c, window)).collect();
        let is_seen = all.iter().any(Result::is_ok);
        let one = |(c, found): (&Curve, Result<Plateau, MotionError>)| match found {
            Ok(plateau) => Ok(Some(plateau)),
            Err(why @ MotionError::TooShort { .. }) if is_seen => {
                doubts.push(format!("{}: {why}", c.name));
                Ok(None)
            }
            Err(why) => Err(why),
        };
        curves.iter().zip(all).map(one).collect::<Result<Vec<_>, _>>()
    };
    let (held, last) = (over(windows[0])?, over(windows[1])?);
    let one = |((curve, held), last): ((Curve, Option<Plateau>), Option<Plateau>)| {
        let change = held.as_ref().zip(last.as_ref()).map(|(a, b)| {
            let value = b.mean.value - a.mean.value;
            let free = (a.effective.min(b.effective) - 1.0).max(1.0) as usize;
            let half = t_quantile(0.95, free) * a.uncertainty.hypot(b.uncertainty);
            Bounded { value, interval: [value - half, value + half] }
        });
        EvaluatedCurve { curve, held, last, change }
    };
    Ok(curves.into_iter().zip(held).zip(last).map(one).collect())
}
