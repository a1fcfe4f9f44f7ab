//! Greedy choice of training states: where the estimated error of the present model is largest.
//!
//! Source: Prud'homme et al., *J. Fluids Eng.* 124, 2002, and Grepl & Patera, *ESAIM: M2AN* 39, 2005, with the estimate along adjoint solutions in place of a bound.
//! Several states are chosen from one model, so that they can be computed side by side; they keep apart, because the same forces are missing next to the largest error.
//! The estimate is of first order and is made from the states that are there: where they say nothing about the error, a large one may be missed.

use super::train::Training;
use crate::math::statistics::larger;
use crate::reduction::error::ReductionError;
use crate::reduction::inputs::Input;
use crate::reduction::running::twin::Twin;

/// How states are to be chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Modes of the model whose error is estimated
    pub modes: usize,
    /// See [`Training::model`]
    pub sampling: Option<f64>,
    /// States that are chosen at once
    pub batch: usize,
}

/// Candidates at which full solutions are wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct NextStates {
    /// Largest estimated error of a quantity at a candidate, as a share of its largest change in the training states; infinite where the model has no
    /// equilibrium there, or no estimate
    pub largest: f64,
    /// Estimated error in the median of the candidates, as such a share
    pub median: f64,
    /// Indices of the candidates, the one of the largest error first
    pub chosen: Vec<usize>,
}

/// Distance of two states that are chosen at once, as a share of the ranges of the inputs, from which on they are apart.
const APART: f64 = 0.2;

impl Search {
    /// The candidates \[inputs in SI\] with the largest estimated errors.
    ///
    /// # Errors
    ///
    /// Those of [`Training::model`].
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

/// Largest estimated error of the quantities at these inputs, as a share of their sizes; infinite where one is not a number.
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

/// The first candidates in this order that keep apart; where there are not enough, the first of the others.
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

    /// The largest first, no neighbour of it next, and neighbours where nothing else is left.
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
