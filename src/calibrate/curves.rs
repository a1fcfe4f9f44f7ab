//! Data of a figure of a fit; drawing is done elsewhere.

use super::{Mode, Model, Residual, Sample};
use serde::{Deserialize, Serialize};

/// Points and curves of one mode: `[λ, P]` with λ \[–\], P \[Pa\].
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct ModeCurves {
    pub mode: Mode,
    /// Name for the legend
    pub label: String,
    /// Samples that were fitted
    pub fitted: Vec<[f64; 2]>,
    /// Samples that were not
    pub held_out: Vec<[f64; 2]>,
    /// The law from λ = 1 over all samples of the mode, ascending; empty of a biaxial test
    pub curve: Vec<[f64; 2]>,
    /// `[λ, measured − law]` of all samples, ascending
    pub residuals: Vec<[f64; 2]>,
}

/// Labels, units and one entry per mode of the table.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct FitCurves {
    pub title: String,
    pub x_label: String,
    pub y_label: String,
    /// Unit of every stress
    pub y_unit: String,
    /// Smallest and largest fitted λ, for shading
    pub fitted_stretch: [f64; 2],
    pub modes: Vec<ModeCurves>,
}

/// Points of a curve
const POINTS: usize = 201;

impl FitCurves {
    pub(super) fn new(
        title: String,
        model: Model,
        values: &[f64],
        samples: &[Sample],
        all: &[Residual],
        is_fitted: impl Fn(&Sample) -> bool,
        fitted_stretch: [f64; 2],
    ) -> Self {
        let modes = Mode::ALL.into_iter().filter(|m| samples.iter().any(|s| s.mode == *m));
        let modes = modes.map(|mode| {
            let own = || samples.iter().filter(|s| s.mode == mode);
            let point = |s: &Sample| [s.stretch, s.stress];
            let low = own().map(|s| s.stretch).fold(1.0, f64::min);
            let high = own().map(|s| s.stretch).fold(1.0, f64::max);
            let at = |k: usize| low + (high - low) * k as f64 / (POINTS - 1) as f64;
            // The stress of a biaxial test is no function of one stretch
            let points = if mode == Mode::Biaxial { 0 } else { POINTS };
            ModeCurves {
                mode,
                label: mode.words(),
                fitted: own().filter(|s| is_fitted(s)).map(point).collect(),
                held_out: own().filter(|s| !is_fitted(s)).map(point).collect(),
                curve: (0..points)
                    .map(|k| [at(k), model.stress(values, mode, at(k))])
                    .filter(|p| p[1].is_finite())
                    .collect(),
                residuals: all.iter().filter(|r| r.mode == mode).map(|r| [r.stretch, r.residual]).collect(),
            }
        });
        Self {
            title,
            x_label: "stretch λ [–]".into(),
            y_label: "nominal stress P".into(),
            y_unit: "Pa".into(),
            fitted_stretch,
            modes: modes.collect(),
        }
    }
}
