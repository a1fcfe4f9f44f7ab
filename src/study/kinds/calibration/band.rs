//! Uncertainty of a curve y(t) where a law is used, due to the errors of the constants and the mesh.
//!
//! With the derivatives g = ∂y/∂θ at the constants found, C their covariance, and δ_fi the change of θ in member i of nuisance family f:
//!
//! ```text
//! data        ± t₀.₉₇₅ √(gᵀCg), C by the errors that the residuals show, widened by profiles that are wider
//! dimensions  from Σ_f minᵢ g·δ_fi to Σ_f maxᵢ g·δ_fi over the nuisance families f, 0 among them; from min g·δ to max g·δ where the corners were run
//! specimen    ± Σ|g U| with the uncertainties U of the constants by the mesh of the specimen and its time steps
//! mesh        |y(finest) − y(next)| of the scene itself, apart
//! ```
//!
//! The band is linear in θ: accurate as long as it is narrow. The first three add up to the band of the constants, which are those of the law that is
//! used. For a quantity that does not start at zero, the band is relative to its largest change.

use crate::calibrate::inverse::Calibration;
use crate::math::statistics::{larger, root};
use crate::report::numbers::{digits, percent, space};
use crate::scene::{Extreme, ExtremeKind, extreme};
use crate::study::calibration_plan::used_law;
use crate::study::curve::Curve;
use crate::study::kinds::calibration::corners;
use crate::study::kinds::calibration::findings::{CalibratedConstant, CalibratedVariant};
use crate::study::store::record::{Role, Series, StoredCase, StudyQuantity, StudyRecord};
use serde::Serialize;
use std::collections::BTreeMap;

#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Band {
    /// Variant of the calibration
    pub variant: String,
    pub quantity: StudyQuantity,
    /// Case on the finest mesh
    pub case: String,
    pub t_s: Vec<f64>,
    pub y: Vec<f64>,
    /// Lower and upper end of the band of the constants \[2\]\[t\]
    pub constants: [Vec<f64>; 2],
    /// Change from the next coarser mesh to the finest \[t\]
    pub mesh: Option<Vec<f64>>,
    /// y where |y − y₀| is largest; the bands of the constants and of the mesh below are relative to that change \[–\]
    pub peak: f64,
    pub peak_is: ExtremeKind,
    pub peak_t_s: f64,
    /// Value from which y changes; 0 if it starts at zero
    #[serde(skip_serializing_if = "is_zero")]
    pub start: f64,
    pub below: f64,
    pub above: f64,
    pub mesh_share: Option<f64>,
}

/// Returns the band; `None` if the constants have no band, or if the derivatives at the peak or the effects of the dimensions are unknown.
pub fn band(
    study: &StudyRecord,
    stored: &[StoredCase],
    found: &BTreeMap<String, Calibration>,
    sensitivities: &BTreeMap<String, Series>,
    answer: &CalibratedVariant,
) -> Option<Band> {
    if !answer.without_constants.is_empty() {
        return None;
    }
    let own = format!("use-{}", answer.variant);
    let quantity = study.quantities.get(&own)?.first()?.clone();
    let ids = study.families.iter().filter(|f| f.role == Role::Use).flat_map(|f| &f.cases);
    let mut cases: Vec<&StoredCase> = (ids.filter_map(|id| stored.iter().find(|c| c.record.id == *id)))
        .filter(|c| c.is_of(&own) && c.record.converged())
        .collect();
    cases.sort_by_key(|c| c.record.mesh.cells);
    let finest = *cases.last()?;
    let y = Curve::of(&finest.series, &quantity.name)?;
    let of_case = sensitivities.get(&finest.record.id)?;
    let source = found.get(&answer.case)?;
    let keys: Vec<&str> = source.constants.iter().map(|c| c.key.as_str()).collect();
    let (own, columns) = gradients(of_case, &quantity.name, &keys)?;
    let covariance = source.covariance.as_ref()?;
    let half = |[a, b]: [f64; 2]| 0.5 * (b - a);
    let widest = |c: &crate::calibrate::inverse::FittedConstant| Some(half(c.widest()?) / c.std_error?);
    let wide: Vec<f64> = own.iter().map(|k| widest(&source.constants[*k])).collect::<Option<_>>()?;
    let wide = wide.into_iter().fold(0.0, larger);
    let moved = Moved::of(answer, &own);
    let share = |c: &CalibratedConstant| c.mesh.unwrap_or(0.0) + c.steps.unwrap_or(0.0);
    let numerical = own.iter().map(|k| &answer.constants[*k]).map(|c| share(c) * c.value.abs());
    let numerical: Vec<f64> = numerical.collect();
    let n = y.t.len();
    let mut ends = [Vec::with_capacity(n), Vec::with_capacity(n)];
    for (t, y) in y.f.iter().enumerate() {
        let g: Vec<f64> = columns.iter().map(|column| column[t]).collect();
        let along = |change: &[f64]| g.iter().zip(change).map(|(g, d)| g * d).sum::<f64>();
        let row = |i: &usize| along(&own.iter().map(|j| covariance[*i][*j]).collect::<Vec<f64>>());
        let variance = along(&own.iter().map(row).collect::<Vec<f64>>());
        let of_specimen: f64 = g.iter().zip(&numerical).map(|(g, u)| (g * u).abs()).sum();
        let symmetric = wide * root(variance) + of_specimen;
        let [least, most] = moved.ends(along);
        ends[0].push(y + least - symmetric);
        ends[1].push(y + most + symmetric);
    }
    let next = cases.len().checked_sub(2).and_then(|k| Curve::of(&cases[k].series, &quantity.name));
    let mesh: Option<Vec<f64>> = next.map(|c| y.t.iter().zip(&y.f).map(|(t, f)| (f - c.at(*t)).abs()).collect());
    let Extreme { at, value: peak, kind } = extreme(y.f.iter().copied())?;
    let start = y.start();
    let scale = (peak - start).abs();
    if scale == 0.0 || !(ends[0][at] + ends[1][at]).is_finite() {
        return None;
    }
    Some(Band {
        variant: answer.variant.clone(),
        case: finest.record.id.clone(),
        peak,
        peak_is: kind,
        peak_t_s: y.t[at],
        start,
        below: (peak - ends[0][at]) / scale,
        above: (ends[1][at] - peak) / scale,
        mesh_share: mesh.as_ref().map(|m| m[at] / scale),
        t_s: y.t,
        y: y.f,
        constants: ends,
        mesh,
        quantity,
    })
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "as serde asks for it")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// The constants of the law that is used, by their indices among `keys` (`laws.rubber.mu`), with ∂y/∂θ of each, which is named by the law of the
/// scene that uses it.
fn gradients<'a>(of_case: &'a Series, quantity: &str, keys: &[&str]) -> Option<(Vec<usize>, Vec<&'a Vec<f64>>)> {
    let begin = format!("d {quantity}/d laws.");
    let there = of_case.columns.keys().find_map(|name| Some(name.strip_prefix(&begin)?.split_once('.')?.0))?;
    let used = format!("laws.{}.", used_law(keys.iter().copied(), there)?);
    let own = keys.iter().enumerate().filter_map(|(k, key)| Some((k, key.strip_prefix(&used)?)));
    own.map(|(k, constant)| Some((k, of_case.columns.get(&format!("{begin}{there}.{constant}"))?))).collect()
}

/// Changes of the constants in the cases of the dimensions, relative to the size on the same mesh.
struct Moved<'a> {
    /// Changes of each constant in each case of a family, by family
    single: BTreeMap<&'a str, Vec<Vec<f64>>>,
    /// Changes of each constant in each corner that was run
    corners: Vec<Vec<f64>>,
}

impl<'a> Moved<'a> {
    /// Collects the changes of the constants at these indices.
    fn of(answer: &'a CalibratedVariant, own: &[usize]) -> Self {
        let mut out = Self { single: BTreeMap::new(), corners: vec![] };
        let Some(first) = answer.constants.first() else { return out };
        let place = |id: &String| first.cases.iter().position(|o| o.case == *id);
        for (k, o) in first.cases.iter().enumerate().filter(|(_, o)| o.role == Role::Nuisance) {
            if let Some(base) = o.base.as_ref().and_then(place) {
                let constants = own.iter().map(|place| &answer.constants[*place].cases);
                let change = constants.map(|cases| cases[k].value - cases[base].value).collect();
                let is_corner = o.family == corners::FAMILY;
                if is_corner { &mut out.corners } else { out.single.entry(&o.family).or_default() }.push(change);
            }
        }
        out
    }

    /// The smallest and the largest change of a value due to the dimensions, to first order.
    fn ends(&self, along: impl Fn(&[f64]) -> f64) -> [f64; 2] {
        let changes = |all: &Vec<Vec<f64>>| all.iter().map(|change| along(change)).collect::<Vec<f64>>();
        let single = self.single.iter().map(|(family, all)| (*family, changes(all))).collect();
        corners::ends(&single, &changes(&self.corners))
    }
}

impl Band {
    pub fn sentence(&self) -> String {
        let q = &self.quantity;
        let n = digits(1e-2 * (self.peak - self.start));
        let mesh = self.mesh_share.map_or("; one mesh only".into(), |m| format!(", its own mesh {} more", percent(m)));
        let whole = match self.start {
            0.0 => "which".into(),
            start => format!("whose change from {start:.n$}{}", space(&q.unit)),
        };
        format!(
            "Used in {}: {} {} {:.n$}{} at {:.3} s, of {whole} the constants leave −{} to +{} open{mesh}.",
            self.case,
            self.peak_is.name(),
            q.label,
            self.peak,
            space(&q.unit),
            self.peak_t_s,
            percent(self.below),
            percent(self.above)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(names: &[&str]) -> Series {
        let columns = names.iter().enumerate().map(|(k, name)| ((*name).to_string(), vec![k as f64; 2]));
        Series { t_s: vec![0.0, 1.0], columns: columns.collect() }
    }

    /// The constants of the law that is used are found under any name: if two laws were calibrated, the law with the name in the scene; if one, that
    /// one.
    #[test]
    fn every_constant_has_its_own_derivative() {
        let of_case = series(&["d f_N/d laws.skin.mu", "d f_N/d laws.skin.nu", "d g_N/d laws.skin.mu", "f_N"]);
        let of = |keys: &[&str]| {
            gradients(&of_case, "f_N", keys).map(|(own, all)| (own, all.iter().map(|g| g[0]).collect()))
        };
        assert_eq!(of(&["laws.end.mu", "laws.skin.nu", "laws.skin.mu"]), Some((vec![1, 2], vec![1.0, 0.0])));
        assert_eq!(of(&["effect.0.density", "laws.rubber.mu"]), Some((vec![1], vec![0.0])));
        assert_eq!(of(&["laws.end.mu", "laws.rubber.mu"]), None::<(Vec<usize>, Vec<f64>)>);
        assert_eq!(of(&["laws.rubber.C10"]), None, "its derivative was not computed");
    }

    /// Two dimensions of ±2 % each give ±4 % at the corners, which replace the single dimensions.
    #[test]
    fn corners_that_were_run_replace_single_dimensions() {
        let single = || [("area", vec![vec![-2.0], vec![2.0]]), ("length", vec![vec![-2.0], vec![2.0]])].into();
        let along = |change: &[f64]| -0.5 * change[0];
        let sums = Moved { single: single(), corners: vec![] };
        assert_eq!(sums.ends(along), [-2.0, 2.0]);
        let run = Moved { single: single(), corners: vec![vec![-3.9], vec![0.1], vec![4.2]] };
        assert_eq!(run.ends(along), [-2.1, 1.95]);
    }
}
