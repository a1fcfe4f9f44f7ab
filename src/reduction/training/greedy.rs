//! Greedy choice of training states: where the estimated error of the present model is largest.
//!
//! Source: Prud'homme et al., *J. Fluids Eng.* 124, 2002, and Grepl & Patera, *ESAIM: M2AN* 39, 2005, with the estimate along adjoint solutions in
//! place of a bound. Several states are chosen from one model, so that they can be computed in parallel; a minimum distance is kept between them,
//! because states close to the largest error lack the same forces. The estimate is of first order and is based on the existing states: where these
//! carry no information on the error, a large one may be missed.

use super::train::Training;
use crate::math::statistics::larger;
use crate::reduction::error::ReductionError;
use crate::reduction::inputs::Input;
use crate::reduction::running::twin::Twin;

/// Settings for the choice of states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Number of modes of the model whose error is estimated
    pub modes: usize,
    /// Tolerance of the selection of points; see [`Training::model`]
    pub sampling: Option<f64>,
    /// Number of states chosen at once
    pub batch: usize,
}

/// Candidates at which full solutions should be computed next.
#[derive(Clone, Debug, PartialEq)]
pub struct NextStates {
    /// Largest estimated error of a quantity at a candidate, relative to its largest change in the training states; infinite if the model has no
    /// equilibrium there, or no estimate
    pub largest: f64,
    /// Median over the candidates of the estimated error, relative in the same way
    pub median: f64,
    /// Indices of the candidates, that with the largest error first
    pub chosen: Vec<usize>,
}

/// Smallest distance between states chosen at once, relative to the ranges of the inputs \[–\].
const APART: f64 = 0.2;

impl Search {
    /// Chooses the candidates \[inputs in SI\] with the largest estimated errors.
    ///
    /// # Errors
    ///
    /// The errors of [`Training::model`].
    pub fn choose(&self, training: &Training, candidates: &[Vec<f64>]) -> Result<NextStates, ReductionError> {
        let mut twin = Twin::new(training.uncalibrated(self.modes, self.sampling)?)?;
        let errors: Vec<f64> = candidates.iter().map(|u| estimate(&mut twin, u)).collect();
        let mut sorted = errors.clone();
        sorted.sort_by(f64::total_cmp);
        let mut order: Vec<usize> = (0..candidates.len()).collect();
        order.sort_by(|&a, &b| errors[b].total_cmp(&errors[a]));
        let chosen = apart(&order, candidates, (&twin.model().inputs, self.batch));
        let at = |k: usize| sorted.get(k).copied().unwrap_or(0.0);
        Ok(NextStates { largest: at(sorted.len().saturating_sub(1)), median: at(sorted.len() / 2), chosen })
    }
}

/// Returns the largest estimated error of the quantities at these inputs, relative to their sizes; infinite if one is NaN.
fn estimate(twin: &mut Twin, inputs: &[f64]) -> f64 {
    twin.reset();
    if twin.step(inputs).is_err() {
        return f64::INFINITY;
    }
    let sizes = &twin.model().largest_changes;
    let shares = twin.bars().iter().zip(sizes).filter(|(_, size)| **size != 0.0).map(|(bar, size)| bar / size);
    let largest = shares.fold(0.0, larger);
    if largest.is_nan() { f64::INFINITY } else { largest }
}

/// Returns the first candidates in this order that keep the distance; if there are not enough, also the first of the others.
fn apart(order: &[usize], candidates: &[Vec<f64>], (inputs, count): (&[Input], usize)) -> Vec<usize> {
    let distance = |a: usize, b: usize| {
        let share = |(k, i): (usize, &Input)| (candidates[a][k] - candidates[b][k]) / (i.range[1] - i.range[0]);
        inputs.iter().enumerate().map(share).map(|d| d * d).sum::<f64>().sqrt()
    };
    let mut chosen: Vec<usize> = vec![];
    for &k in order {
        if chosen.len() < count && chosen.iter().all(|&other| distance(k, other) >= APART) {
            chosen.push(k);
        }
    }
    let others: Vec<usize> = order.iter().copied().filter(|k| !chosen.contains(k)).collect();
    let missing = count.saturating_sub(chosen.len());
    chosen.extend(others.into_iter().take(missing));
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The candidate with the largest error comes first, not followed by its neighbours unless nothing else is left.
    #[test]
    fn chosen_states_keep_apart() {
        let inputs = [Input::new("u", [0.0, 10.0])];
        let candidates: Vec<Vec<f64>> = [9.0, 8.5, 1.0, 5.0].map(|u| vec![u]).to_vec();
        let order = [0, 1, 2, 3];
        assert_eq!(apart(&order, &candidates, (&inputs, 3)), [0, 2, 3]);
        assert_eq!(apart(&order, &candidates, (&inputs, 4)), [0, 2, 3, 1]);
        assert_eq!(apart(&order, &candidates, (&inputs, 9)), [0, 2, 3, 1]);
    }
}
