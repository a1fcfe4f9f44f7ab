//! Predictions of a fit: stresses of its law at data points that were not fitted.

use super::misfit::{Misfit, Residual};
use crate::calibrate::{Mode, Prediction, PredictionKind, StretchRange};
use crate::math::statistics::extent;

/// Misfits over the data points outside the fitted range or modes.
pub fn predictions(all: &[Residual], modes: &[Mode], range: StretchRange) -> Vec<Prediction> {
    let mut found = Vec::new();
    let mut add = |kind, mode, rows: Vec<Residual>| {
        if let Some(misfit) = Misfit::of(&rows) {
            found.push(Prediction { kind, mode, stretch: extent(rows.iter().map(|r| r.reach)), misfit });
        }
    };
    for mode in Mode::ALL {
        let pick = |keep: &dyn Fn(&Residual) -> bool| {
            all.iter().filter(|r| r.mode == mode && keep(r)).copied().collect::<Vec<_>>()
        };
        if modes.contains(&mode) {
            add(PredictionKind::OutsideRange, mode, pick(&|r| !range.contains(r.reach)));
        } else {
            add(PredictionKind::OtherModeInRange, mode, pick(&|r| range.contains(r.reach)));
            if range != StretchRange::ALL {
                add(PredictionKind::OtherMode, mode, pick(&|_| true));
            }
        }
    }
    found
}
