//! Held rims of open cavities: the part of their reactions that is not in the residual.

use super::drive::Drive;
use crate::effect::CavityRim;
use crate::scene::record::recorder::Moment;
use crate::system::{Gradient, State};
use std::sync::Arc;

/// The rim of an open cavity with its pressure p; p c is added to the residual there, see [`CavityRim`].
pub struct HeldRim {
    pub rim: CavityRim,
    pub drive: Drive,
}

/// All held rims of a scene.
#[derive(Clone, Default)]
pub struct HeldRims(Vec<Arc<HeldRim>>);

impl HeldRims {
    pub fn push(&mut self, rim: HeldRim) {
        self.0.push(Arc::new(rim));
    }

    /// The forces p c \[N\] as (unknown, force); an unknown can occur several times. Empty in the first row, before any assembly.
    pub fn forces(&self, now: &Moment) -> Vec<(u32, f64)> {
        let of = |held: &Arc<HeldRim>| {
            let p = held.drive.value(now.state);
            held.rim.excess(&now.state.x).into_iter().map(move |(dof, c)| (dof, p * c))
        };
        self.0.iter().filter(|_| now.step.is_some()).flat_map(of).collect()
    }

    /// Adds the derivatives of Σ w p c, with weights w of the unknowns, to those of a functional.
    pub fn add_gradient(&self, state: &State, weight: impl Fn(u32) -> f64, out: &mut Gradient) {
        for HeldRim { rim, drive } in self.0.iter().map(AsRef::as_ref) {
            let p = drive.value(state);
            out.x.extend(rim.gradient(&state.x, &weight).into_iter().map(|(dof, by_x)| (dof, p * by_x)));
            let sum: f64 = rim.excess(&state.x).into_iter().map(|(dof, c)| weight(dof) * c).sum();
            out.lambda.extend(drive.gradient().lambda.into_iter().map(|(c, by_lambda)| (c, by_lambda * sum)));
        }
    }
}
