//! The laws of a running model whose constants are inputs: brought to the present constants where these have changed.

use crate::reduction::constants::Constants;
use crate::reduction::points::Points;

/// Present constants, and the compliance that follows from them.
pub struct RunningLaws {
    /// Inputs that the laws are those of; not finite before the first
    present: Vec<f64>,
    /// \[tests or pressure modes × pressure modes\]
    pub compliance: Vec<f64>,
}

/// Which of the compliances of a part is meant.
pub type Share = fn(&crate::reduction::constants::PartCompliance) -> &Vec<f64>;

impl RunningLaws {
    /// The laws at the nominal constants, of `inputs` inputs.
    pub fn new(compliance: &[f64], inputs: usize) -> Self {
        Self { present: vec![f64::NAN; inputs], compliance: compliance.to_vec() }
    }

    /// Brings points and compliance to these inputs; false where a law is not defined there. A law is built anew only where a constant has changed, which
    /// is the one allocation of a step.
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
