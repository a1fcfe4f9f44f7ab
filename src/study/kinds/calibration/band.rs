//! Uncertainty that the errors of constants and the mesh leave where a law is used: a band around a curve y(t).
//!
//! With the derivatives g = ∂y/∂θ at the constants found, C their covariance, and δ_fi the change of θ in member i of nuisance family f:
//!
//! ```text
//! data        ± t₀.₉₇₅ √(gᵀCg), C by the errors that the residuals show, widened by profiles that are wider
//! dimensions  from Σ_f minᵢ g·δ_fi to Σ_f maxᵢ g·δ_fi over the nuisance families f, 0 among them
//! specimen    ± Σ|g U| with the uncertainties U of the constants by the mesh of the specimen and its time steps
//! mesh        |y(finest) − y(next)| of the scene itself, apart
//! ```
//!
//! Linear in θ: good while the band is narrow. The first three add up to the band of the constants.

use crate::calibrate::inverse::Calibration;
use crate::report::numbers::{digits, percent, space};
use crate::scene::{Extreme, ExtremeKind, extreme};
use crate::study::curve::Curve;
use crate::study::kinds::calibration::analysis::{CalibratedConstant, CalibratedVariant};
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

/// None where the constants have no band, or what the dimensions change is not known.
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
    let share = |c: &CalibratedConstant| c.mesh.unwrap_or(0.0) + c.steps.unwrap_or(0.0);
    let numerical: Vec<f64> = answer.constants.iter().map(|c| share(c) * c.value.abs()).collect();
    let n = y.t.len();
    let mut ends = [Vec::with_capacity(n), Vec::with_capacity(n)];
    for (t, y) in y.f.iter().enumerate() {
        let variance: f64 = (columns.iter().zip(covariance))
            .map(|(g, row)| g[t] * columns.iter().zip(row).map(|(h, c)| h[t] * c).sum::<f64>())
            .sum();
        let of_specimen: f64 = columns.iter().zip(&numerical).map(|(g, u)| (g[t] * u).abs()).sum();
        let symmetric = wide * variance.max(0.0).sqrt() + of_specimen;
        let corner = |end: fn(f64, f64) -> f64| -> f64 {
            moved.values().map(|all| all.iter().map(|d| along(t, d)).fold(0.0, end)).sum()
        };
        ends[0].push(y + corner(f64::min) - symmetric);
        ends[1].push(y + corner(f64::max) + symmetric);
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

/// Nuisance family → change of the constants in each of its cases from the size on its own mesh.
fn moved(answer: &CalibratedVariant) -> BTreeMap<String, Vec<Vec<f64>>> {
    let mut out: BTreeMap<String, Vec<Vec<f64>>> = BTreeMap::new();
    let Some(first) = answer.constants.first() else { return out };
    let sizes = || first.cases.iter().enumerate().filter(|(_, o)| o.role == Role::Sizes);
    for (k, o) in first.cases.iter().enumerate().filter(|(_, o)| o.role == Role::Nuisance) {
        if let Some((base, _)) = sizes().min_by_key(|(_, s)| s.cells.abs_diff(o.cells)) {
            let change = answer.constants.iter().map(|c| c.cases[k].value - c.cases[base].value).collect();
            out.entry(o.family.clone()).or_default().push(change);
        }
    }
    out
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
