//! The rows at which columns have their extremes, with the corresponding states.

use super::extreme::is_as_far;
use crate::solve::{AcceptedStep, Integrator};
use crate::system::State;

/// A row and the step that ended there.
pub(in crate::scene) struct ExtremeRow {
    pub row: usize,
    pub integrator: Integrator,
    pub past: State,
    pub now: State,
    /// Residual at the end of the step \[unknowns\]
    pub residual: Vec<f64>,
    /// Memory of the recorders at the end of the step
    pub memory: Vec<f64>,
}

/// Follows the rows of a run, and keeps those that are the extreme of a column so far: at most one for each column.
pub(in crate::scene) struct ExtremeRows {
    /// Indices of the columns in a row
    columns: Vec<usize>,
    /// Row of the extreme so far \[columns\]
    at: Vec<usize>,
    kept: Vec<ExtremeRow>,
}

impl ExtremeRows {
    /// Follows the columns with these indices in a row.
    pub fn new(columns: Vec<usize>) -> Self {
        let at = vec![0; columns.len()];
        Self { columns, at, kept: Vec::new() }
    }

    /// Takes the row that was added to `rows` at the end of a step.
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

    /// The rows that are an extreme, in order; the first row of a run is never among them.
    pub fn into_rows(self) -> Vec<ExtremeRow> {
        self.kept
    }
}
