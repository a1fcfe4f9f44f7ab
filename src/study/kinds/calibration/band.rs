//! Uncertainty that the errors of constants and the mesh leave where a law is used: a band around a curve y(t).
//!
//! With the derivatives g = ∂y/∂θ at the constants found, C their covariance, δᵢ the change of θ in nuisance case i and d the drift with
//! the mesh of the specimen:
//!
//! ```text
//! data        ± t₀.₉₇₅ √(gᵀCg), C widened until the bootstrap has room in it
//! dimensions  from minᵢ g·δᵢ to maxᵢ g·δᵢ, 0 among them
//! specimen    ± |g·d|
//! mesh        |y(finest) − y(next)| of the scene itself, apart
//! ```
//!
//! Linear in θ: good while the band is narrow. The first three add up to the band of the constants.

use crate::calibrate::inverse::Calibration;
use crate::report::numbers::{digits, percent, space};
use crate::scene::{Extreme, ExtremeKind, extreme};
use crate::study::curve::Curve;
use crate::study::kinds::calibration::analysis::CalibratedVariant;
use crate::study::store::record::{Quantity, Role, Series, StoredCase, StudyRecord};
use serde::Serialize;
use std::collections::BTreeMap;

#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Band {
    /// Variant of the calibration
    pub variant: String,
    pub quantity: Quantity,
    /// Case on the finest mesh
    pub case: String,
    pub t_s: Vec<f64>,
    pub y: Vec<f64>,
    /// \[2\]\[t\] ends of the band of the constants
    pub constants: [Vec<f64>; 2],
    /// \[t\] change to the finest mesh from the next
    pub mesh: Option<Vec<f64>>,
    /// Largest |y − y₀|, and there: y, band of the constants relative to it \[–\], share of the mesh \[–\]
    pub peak: f64,
    pub peak_is: ExtremeKind,
    pub peak_t_s: f64,
    pub below: f64,
    pub above: f64,
    pub mesh_share: Option<f64>,
}

pub fn band(
    study: &StudyRecord,
    stored: &[StoredCase],
    found: &BTreeMap<String, Calibration>,
    sensitivities: &BTreeMap<String, Series>,
    answer: &CalibratedVariant,
) -> Option<Band> {
    let own = format!("use-{}", answer.variant);
    let quantity = study.quantities.get(&own)?.first()?.clone();
    let ids = study.families.iter().filter(|f| f.role == Role::Use).flat_map(|f| &f.cases);
    let mut cases: Vec<&StoredCase> = (ids.filter_map(|id| stored.iter().find(|c| c.record.id == *id)))
        .filter(|c| c.record.variant == own && c.record.converged())
        .collect();
    cases.sort_by_key(|c| c.record.mesh.cells);
    let finest = *cases.last()?;
    let y = Curve::of(&finest.series, &quantity.name)?;
    let of_case = sensitivities.get(&finest.record.id)?;
    let source = found.get(&answer.case)?;
    // ∂y/∂θ per constant: named by the law of this scene, in the order of the constants
    let columns: Vec<&Vec<f64>> = source
        .constants
        .iter()
        .map(|c| {
            let (start, end) = (format!("d {}/d ", quantity.name), format!(".{}", c.key.rsplit('.').next()?));
            of_case.columns.iter().find(|(n, _)| n.starts_with(&start) && n.ends_with(&end)).map(|(_, v)| v)
        })
        .collect::<Option<_>>()?;
    let along = |t: usize, d: &[f64]| columns.iter().zip(d).map(|(g, d)| g[t] * d).sum::<f64>();
    let covariance = source.covariance.as_ref()?;
    let half = |[a, b]: [f64; 2]| 0.5 * (b - a);
    let widest = |c: &crate::calibrate::inverse::Found| Some(half(c.widest()?) / c.std_error?);
    let wide = source.constants.iter().map(widest).collect::<Option<Vec<f64>>>()?.into_iter().fold(0.0, f64::max);
    let moved = moved(answer);
    let drift: Vec<f64> = answer.constants.iter().map(|c| c.drift.unwrap_or(0.0) * c.value.abs()).collect();
    let n = y.t.len();
    let mut ends = [Vec::with_capacity(n), Vec::with_capacity(n)];
    for (t, y) in y.f.iter().enumerate() {
        let variance: f64 = (columns.iter().zip(covariance))
            .map(|(g, row)| g[t] * columns.iter().zip(row).map(|(h, c)| h[t] * c).sum::<f64>())
            .sum();
        let symmetric = wide * variance.max(0.0).sqrt() + along(t, &drift).abs();
        let shifts = || moved.iter().map(|d| along(t, d));
        ends[0].push(y + shifts().fold(0.0, f64::min) - symmetric);
        ends[1].push(y + shifts().fold(0.0, f64::max) + symmetric);
    }
    let next = cases.len().checked_sub(2).and_then(|k| Curve::of(&cases[k].series, &quantity.name));
    let mesh: Option<Vec<f64>> = next.map(|c| y.t.iter().zip(&y.f).map(|(t, f)| (f - c.at(*t)).abs()).collect());
    let Extreme { at, value: peak, kind } = extreme(y.f.iter().copied())?;
    Some(Band {
        variant: answer.variant.clone(),
        case: finest.record.id.clone(),
        peak,
        peak_is: kind,
        peak_t_s: y.t[at],
        below: (peak - ends[0][at]) / peak.abs(),
        above: (ends[1][at] - peak) / peak.abs(),
        mesh_share: mesh.as_ref().map(|m| m[at] / peak.abs()),
        t_s: y.t,
        y: y.f,
        constants: ends,
        mesh,
        quantity,
    })
}

/// Change of the constants in every nuisance case from the size on its own mesh.
fn moved(answer: &CalibratedVariant) -> Vec<Vec<f64>> {
    let Some(first) = answer.constants.first() else { return vec![] };
    let nuisance = first.cases.iter().enumerate().filter(|(_, o)| o.role == Role::Nuisance);
    let near = |cells: usize| {
        let sizes = first.cases.iter().enumerate().filter(|(_, o)| o.role == Role::Sizes);
        sizes.min_by_key(|(_, o)| o.cells.abs_diff(cells)).map(|(k, _)| k)
    };
    let change = |(k, o): (usize, &crate::study::kinds::calibration::analysis::ConstantInCase)| {
        let base = near(o.cells)?;
        Some(answer.constants.iter().map(|c| c.cases[k].value - c.cases[base].value).collect())
    };
    nuisance.filter_map(change).collect()
}

impl Band {
    pub fn sentence(&self) -> String {
        let q = &self.quantity;
        let n = digits(1e-2 * self.peak);
        let mesh = self.mesh_share.map_or("; one mesh only".into(), |m| format!(", its own mesh {} more", percent(m)));
        format!(
            "Used in {}: {} {} {:.n$}{} at {:.3} s, of which the constants leave −{} to +{} open{mesh}.",
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
