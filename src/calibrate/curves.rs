//! Data for the figure of a fit; it is drawn elsewhere.

use super::{FittableLaw, Mode, Residual, Sample};
use serde::{Deserialize, Serialize};

/// Points and curves of one mode: `[λ, P]` with λ \[–\], P \[Pa\].
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct ModeCurves {
    pub mode: Mode,
    /// Name for the legend
    pub label: String,
    /// Samples that were fitted
    pub fitted: Vec<[f64; 2]>,
    /// Samples that were not fitted
    pub held_out: Vec<[f64; 2]>,
    /// The law from λ = 1 over all samples of the mode, ascending; empty for a biaxial test
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

/// Number of points of a curve over a window
const POINTS: usize = 201;

/// Stretches of a curve, ascending: over all samples, and over the fitted window, which has its own panel, as many again if it is less than half of
/// the range.
fn stretches(all: [f64; 2], fitted: [f64; 2]) -> Vec<f64> {
    let between = |[a, b]: [f64; 2]| (0..POINTS).map(move |k| a + (b - a) * k as f64 / (POINTS - 1) as f64);
    let window = [fitted[0].max(all[0]), fitted[1].min(all[1])];
    let mut of: Vec<f64> = between(all).collect();
    if window[0] < window[1] && window[1] - window[0] < 0.5 * (all[1] - all[0]) {
        of.extend(between(window));
    }
    of.sort_by(f64::total_cmp);
    of.dedup();
    of
}

impl FitCurves {
    pub(super) fn new(
        title: String,
        model: FittableLaw,
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
            // The stress of a biaxial test is not a function of one stretch
            let stretches = if mode == Mode::Biaxial { vec![] } else { stretches([low, high], fitted_stretch) };
            ModeCurves {
                mode,
                label: mode.words(),
                fitted: own().filter(|s| is_fitted(s)).map(point).collect(),
                held_out: own().filter(|s| !is_fitted(s)).map(point).collect(),
                curve: (stretches.into_iter())
                    .map(|stretch| [stretch, model.stress(values, mode, stretch)])
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

#[cfg(test)]
mod tests {
    use super::stretches;

    /// A window of a tenth of the data has as many points as the whole range, so that the law is not drawn as a polygon there.
    #[test]
    fn a_narrow_window_has_points_of_its_own() {
        let of = stretches([1.0, 17.0], [1.0, 1.6]);
        assert!(of.iter().filter(|s| **s <= 1.6).count() > 200, "{of:?}");
        assert!(of.windows(2).all(|pair| pair[0] < pair[1]) && of[0] == 1.0 && of.last() == Some(&17.0));
        assert_eq!(stretches([1.0, 2.0], [1.0, 2.0]).len(), 201);
    }
}
