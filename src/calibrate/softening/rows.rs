//! Rows below the largest stretch, with stress and energies of the law of the first loading for a given permanent set.

use super::error::SofteningFitError;
use crate::calibrate::{FitResult, FittableLaw, Sample};
use crate::material::{Law, Want};
use crate::math::tensor::Mat3;

/// A row below the largest previous stretch.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub sample: Sample,
    /// Largest previous stretch \[–\]
    pub peak: f64,
}

/// Stress of the first loading and energies \[J/m³\] of a row.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Stress of the first loading at this stretch \[Pa\]
    pub stress: f64,
    /// W and W_m
    pub energy: f64,
    pub peak: f64,
}

/// The law of the first loading.
pub struct FirstLoading {
    model: FittableLaw,
    values: Vec<f64>,
    part: Box<dyn Law>,
}

impl FirstLoading {
    /// Builds the law of the first loading from a fit; refuses a law without an isochoric part.
    pub fn of(law: &FitResult) -> Result<Self, SofteningFitError> {
        let model = FittableLaw::new(law.law, Some(law.terms))?;
        Self::with(model, law.parameters.iter().map(|p| p.value).collect())
    }

    fn with(model: FittableLaw, values: Vec<f64>) -> Result<Self, SofteningFitError> {
        // Only the isochoric part is used, which is independent of κ
        let whole = model.law(&values, 1e9)?;
        let info = whole.info();
        let (part, _) =
            whole.split().filter(|_| info.isochoric).ok_or(SofteningFitError::NotIsochoric { law: info.name })?;
        Ok(Self { model, values, part })
    }

    /// This law with each constant decreased and increased by a step, with the step; `None` for constants that cannot be changed.
    pub fn moved(&self) -> Vec<Option<([Self; 2], f64)>> {
        const H: f64 = 1e-5;
        let one = |k: usize| {
            let step = H * self.values[k].abs().max(f64::MIN_POSITIVE);
            let at = |by: f64| {
                let mut values = self.values.clone();
                values[k] += by;
                Self::with(self.model, values).ok()
            };
            Some(([at(-step)?, at(step)?], step))
        };
        (0..self.values.len()).map(one).collect()
    }

    /// Points of rows whose unloaded state has kept the share `set` of the largest ln λ: ln λ_e = (ln λ − s ln λ_m)/(1 − s), which is zero at the set
    /// and equals ln λ_m at the peak. Below its set a specimen is slack.
    pub fn points(&self, rows: &[Row], set: f64) -> Result<Vec<Point>, SofteningFitError> {
        let one = |Row { sample, peak }: &Row| {
            let stretch = elastic_stretch(sample.stretch, *peak, set);
            let undefined = SofteningFitError::Undefined { stretch: *peak, line: sample.line };
            let stress = self.stress(&Sample { stretch, ..*sample });
            match (self.energy(sample, stretch), self.energy(sample, *peak)) {
                (Some(energy), Some(peak)) if stress.is_finite() => Ok(Point { stress, energy, peak }),
                _ => Err(undefined),
            }
        };
        rows.iter().map(one).collect()
    }

    /// Stress of the first loading at a sample \[Pa\].
    pub fn stress(&self, sample: &Sample) -> f64 {
        self.model.at(&self.values, sample)
    }

    fn energy(&self, s: &Sample, stretch: f64) -> Option<f64> {
        let f = Mat3::from_diagonal(&s.mode.stretches(stretch, 1.0).into());
        self.part.eval(&f, Want::Energy).ok().map(|r| r.psi).filter(|w| w.is_finite())
    }
}

/// λ_e of a stretch, given a set.
fn elastic_stretch(stretch: f64, peak: f64, set: f64) -> f64 {
    if set == 0.0 {
        return stretch;
    }
    let (e, largest) = (stretch.ln(), peak.ln());
    let elastic = (e - set * largest) / (1.0 - set);
    if elastic * largest > 0.0 { elastic.exp() } else { 1.0 }
}
