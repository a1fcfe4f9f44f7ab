//! The rows at which some columns have their extremes, with the states that belong to them.

use super::extreme::is_as_far;
use crate::solve::{AcceptedStep, Integrator};
use crate::system::State;

/// A row and the step that ended there.
pub(in crate::scene) struct ExtremeRow {
    pub row: usize,
    pub integrator: Integrator,
    pub past: State,
    pub now: State,
    /// \[unknowns\] residual at the end
    pub residual: Vec<f64>,
    /// Numbers that the recorders keep, at the end
    pub memory: Vec<f64>,
}

/// Follows rows, and keeps those that are the extreme of a column so far: at most one for each column.
pub(in crate::scene) struct ExtremeRows {
    /// Positions of the columns in a row
    columns: Vec<usize>,
    /// \[columns\] row of the extreme so far
    at: Vec<usize>,
    kept: Vec<ExtremeRow>,
}

impl ExtremeRows {
    /// Follows the columns at these positions of a row.
    pub fn new(columns: Vec<usize>) -> Self {
        let at = vec![0; columns.len()];
        Self { columns, at, kept: Vec::new() }
    }

    /// A row was added to `rows` at the end of a step.
    pub fn add(&mut self, rows: &[Vec<f64>], step: &AcceptedStep, memory: &[f64]) {
        let row = rows.len() - 1;
        let mut is_extreme = false;
        for (&column, at) in self.columns.iter().zip(&mut self.at) {
            if is_as_far(rows[0][column], rows[row][column], rows[*at][column]) {
                (*at, is_extreme) = (row, true);
            }
        }
        if !is_extreme {
            return;
        }
        let AcceptedStep { integrator, past, now, sums, .. } = *step;
        let (past, now, residual, memory) = (past.clone(), now.clone(), sums.r.clone(), memory.to_vec());
        self.kept.push(ExtremeRow { row, integrator, past, now, residual, memory });
        self.kept.retain(|kept| self.at.contains(&kept.row));
    }

    /// The rows that are an extreme, in their order; the first row of a run is none of them.
    pub fn into_rows(self) -> Vec<ExtremeRow> {
        self.kept
    }
}
