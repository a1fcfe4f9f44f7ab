//! The laws of a running model whose constants are inputs: updated when the constants change.

use crate::reduction::constants::Constants;
use crate::reduction::points::Points;

/// Current constants, and the resulting compliance.
pub struct RunningLaws {
    /// Inputs to which the laws belong; NaN before the first update
    present: Vec<f64>,
    /// \[tests or pressure modes × pressure modes\]
    pub compliance: Vec<f64>,
}

/// Selects one of the compliances of a part.
pub type Share = fn(&crate::reduction::constants::PartCompliance) -> &Vec<f64>;

impl RunningLaws {
    /// Starts with the laws at the nominal constants, for a given number of inputs.
    pub fn new(compliance: &[f64], inputs: usize) -> Self {
        Self { present: vec![f64::NAN; inputs], compliance: compliance.to_vec() }
    }

    /// Updates points and compliance to these inputs; false if a law is undefined there. A law is rebuilt only if a constant has changed, which is
    /// the only allocation in a step.
    pub fn bring(&mut self, constants: &Constants, points: &mut [Points], inputs: &[f64], share: Share) -> bool {
        let mut changed = false;
        for law in &constants.laws {
            if law.inputs.values().all(|&k| inputs[k].to_bits() == self.present[k].to_bits()) {
                continue;
            }
            for &part in &law.parts {
                let Ok(own) = law.at(inputs) else { return false };
                points[part].set_law(own);
            }
            changed = true;
        }
        if changed {
            self.present.copy_from_slice(inputs);
            self.compliance.fill(0.0);
            for (part, points) in constants.parts.iter().zip(points) {
                let ratio = points.bulk_modulus().map_or(0.0, |kappa| part.kappa / kappa);
                self.compliance.iter_mut().zip(share(part)).for_each(|(all, own)| *all += ratio * own);
            }
        }
        true
    }
}
