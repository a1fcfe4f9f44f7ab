//! A measured curve with the scene that is to reproduce it, and the origin of the data points of several curves.

use super::Measured;
use super::model::SceneModel;
use super::offset::OffsetAxis;
use crate::calibrate::judgement::origin::Origin;

/// A scene with the curve that it is to reproduce.
pub struct ObservedCurve {
    /// Name for messages
    pub name: String,
    pub model: SceneModel,
    pub measured: Measured,
    /// Measured specimen; without a name the curve counts as a specimen of its own
    pub specimen: Option<String>,
    /// Coordinates whose offset is an unknown
    pub offsets: Vec<OffsetAxis>,
}

/// Specimen, test and curve of each data point: curves with the same x and y of one scene file belong to one test. The curves are in the order of
/// their x.
pub fn origin(curves: &[ObservedCurve]) -> Origin {
    let place = |k: usize, is_same: &dyn Fn(&ObservedCurve) -> bool| curves[..k].iter().position(is_same).unwrap_or(k);
    let one = |(k, c): (usize, &ObservedCurve)| {
        let test =
            |o: &ObservedCurve| (&o.model.file, &o.model.x, &o.model.y) == (&c.model.file, &c.model.x, &c.model.y);
        let specimen = place(k, &|o| c.specimen.is_some() && o.specimen == c.specimen);
        vec![(specimen, place(k, &test)); c.measured.x.len()]
    };
    let (specimen, test) = curves.iter().enumerate().flat_map(one).unzip();
    let mut start = 0;
    let ordered = |c: &ObservedCurve| {
        let x = &c.measured.x;
        let mut order: Vec<usize> = (0..x.len()).collect();
        order.sort_by(|a, b| x[*a].total_cmp(&x[*b]));
        start += x.len();
        order.into_iter().map(|i| start - x.len() + i).collect()
    };
    Origin { specimen, test, curves: curves.iter().map(ordered).collect() }
}
