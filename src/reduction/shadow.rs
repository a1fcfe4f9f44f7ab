//! The error estimate of a running model that moves: a model of more modes and points that follows it, with one linear solution a step.
//!
//! With e the distance of the enriched solution from the model, in the enriched space, a step takes E q + e of the last step, evaluates the forces ρ that
//! the full model leaves there, inertia and all memory of the points included, and solves the error dynamics linearised about it,
//! (c_a M + c_v C + K) Δe = −ρ. The estimate of a quantity is its difference between both models.
//!
//! Hierarchical estimates: Bank & Smith, *SIAM J. Numer. Anal.* 30 (1993); for reduced models Hain, Ohlberger, Radic & Urban, *Adv. Comput.
//! Math.* 45 (2019). Limits: what lies outside of the enriched space is not seen, and enters the bar only by its calibration.

use super::dynamics::TimeEstimate;
use super::equations::Position;
use super::twin::{Twin, TwinState};
use crate::material::LawSpecError;

/// The enriched model with its distance from the model.
pub struct Shadow {
    twin: Box<Twin>,
    /// \[coordinates of the enriched model × coordinates of the model\]
    embedding: Vec<f64>,
    /// \[coordinates of the enriched model\] e
    distance: Vec<f64>,
    /// \[coordinates of the enriched model\] E y
    embedded: Vec<f64>,
    /// Whether a step had no result: there is no estimate before the next rest
    lost: bool,
}

/// The state of a [`Shadow`].
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowState {
    twin: TwinState,
    distance: Vec<f64>,
    lost: bool,
}

impl Shadow {
    pub fn new(of: &TimeEstimate) -> Result<Self, LawSpecError> {
        let n = of.enriched.sizes.coordinates();
        Ok(Self {
            twin: Box::new(Twin::new((*of.enriched).clone())?),
            embedding: of.embedding.clone(),
            distance: vec![0.0; n],
            embedded: vec![0.0; n],
            lost: false,
        })
    }

    /// Back to rest.
    pub fn reset(&mut self) {
        self.twin.reset();
        self.distance.fill(0.0);
        self.lost = false;
    }

    pub fn save(&self) -> ShadowState {
        ShadowState { twin: self.twin.save(), distance: self.distance.clone(), lost: self.lost }
    }

    pub fn restore(&mut self, state: &ShadowState) {
        self.twin.restore(&state.twin);
        self.distance.copy_from_slice(&state.distance);
        self.lost = state.lost;
    }

    /// Follows the model to the end of its step; the estimates are the quantities of the enriched model less `values`. False where there are none.
    pub fn follow(&mut self, inputs: &[f64], at: &Position, values: &[f64], estimates: &mut [f64]) -> bool {
        let Self { twin, embedding, distance, embedded, lost } = self;
        let rows = embedding.chunks_exact(at.y.len());
        for (sum, row) in embedded.iter_mut().zip(rows) {
            *sum = row.iter().zip(&at.y).map(|(e, y)| e * y).sum();
        }
        let start = embedded.iter().zip(distance.iter()).map(|(y, e)| y + e);
        *lost = *lost || !twin.follow(inputs, start, at);
        if *lost {
            return false;
        }
        let reached = distance.iter_mut().zip(&twin.position().y).zip(embedded.iter());
        reached.for_each(|((e, z), y)| *e = z - y);
        let differences = estimates.iter_mut().zip(twin.values()).zip(values);
        differences.for_each(|((estimate, other), value)| *estimate = other - value);
        estimates.iter().all(|e| e.is_finite())
    }
}
