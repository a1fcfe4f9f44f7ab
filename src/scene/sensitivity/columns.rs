//! Derivatives of the rows of a run, computed in the same pass.

use super::error::SensitivityError;
use super::parameter_key::ParameterKey;
use super::{RowDerivatives, Sensitivity, StepEnd};
use crate::math::stopwatch::{Spent, Stopwatch};
use crate::scene::build::Scene;
use crate::scene::record::column::largest_of_unit;
use crate::scene::record::extreme_rows::{ExtremeRow, ExtremeRows};
use crate::solve::{AcceptedStep, Failure, SpanStart};
use crate::system::State;

/// Derivatives of the rows of a [`Run`](crate::scene::Run) with respect to keys of its scene.
pub struct Sensitivities {
    /// Columns of the run that have a derivative, in their order: all but t_s, newton_iterations and the columns of contacts, rigid bodies, rigid parts, the
    /// probes `energy`, `stretch` and `moment`, fibres and membranes
    pub columns: Vec<String>,
    pub keys: Vec<ParameterKey>,
    /// Derivatives \[rows × columns × keys\] in the unit of the column per SI unit of the key; one entry for each of `Run::rows`, or fewer for the reason in
    /// `stopped`. NaN where a column has no derivative, such as the curvature of a straight line, and in the rows that [`SensitivityRecorder::at_extremes`]
    /// leaves out
    pub rows: Vec<Vec<Vec<f64>>>,
    /// Largest estimated error of a derivative over the rows \[columns × keys\]; zero for exact derivatives
    pub errors: Vec<Vec<f64>>,
    /// Largest sum over the rows of the magnitudes of the terms of a derivative \[columns × keys\], for example of the nodal terms of a reaction. It is far
    /// above the derivative if the terms cancel
    pub terms: Vec<Vec<f64>>,
    /// Largest value over the rows of all columns with the same unit \[columns\]
    pub column_sizes: Vec<f64>,
    /// Magnitude of the value of each key \[keys\] \[SI\]; 0 if its derivative is exact
    pub key_sizes: Vec<f64>,
    /// Time \[s\] from which there is no derivative, because of a bifurcation or a limit point, with the reason; for derivatives at extremes, the first such
    /// time
    pub stopped: Option<(f64, Failure)>,
    /// Number of numeric factorisations, and of right-hand sides solved, for the derivatives, in addition to those of the run
    pub factorisations: usize,
    pub solves: usize,
    /// Time spent on the derivatives, which is not included in the phases of the run
    pub spent: Spent,
}

/// Error of a derivative, relative to its largest value over the rows, above which it is called doubtful.
pub const DOUBTFUL: f64 = 1e-6;
/// Relative error below which a derivative counts as exact: relative to its terms, and, multiplied by the magnitude of the key, relative to the largest value
/// of the column.
const NEGLIGIBLE: f64 = 1e-9;

impl Sensitivities {
    /// Derivatives of a column with respect to a key, one per row; `None` if there is no such column or key.
    pub fn derivative(&self, column: &str, key: &ParameterKey) -> Option<Vec<f64>> {
        let (c, k) = (self.columns.iter().position(|n| n == column)?, self.keys.iter().position(|n| n == key)?);
        Some(self.rows.iter().map(|row| row[c][k]).collect())
    }

    /// Keys for which every derivative of every row is exactly zero: they change none of the columns. Empty if the derivatives end early, before a load or a
    /// contact might make the keys matter.
    pub fn idle(&self) -> impl Iterator<Item = &ParameterKey> {
        let is_complete = self.stopped.is_none();
        let is_idle = move |k: usize| is_complete && self.rows.iter().flatten().all(|by_keys| by_keys[k] == 0.0);
        self.keys.iter().enumerate().filter(move |(k, _)| is_idle(*k)).map(|(_, key)| key)
    }

    /// Column, key and relative error of the derivatives whose estimated error is above 1e-6 of their largest value and exceeds rounding: it is above 1e-9 of
    /// the terms of the derivative, and, multiplied by the magnitude of the key, above 1e-9 of the column.
    pub fn doubtful(&self) -> Vec<(&str, &ParameterKey, f64)> {
        let largest = |c: usize, k: usize| self.rows.iter().map(|row| row[c][k].abs()).fold(0.0, f64::max);
        let matters = |c: usize, k: usize| {
            let error = self.errors[c][k];
            error > NEGLIGIBLE * self.terms[c][k] && error * self.key_sizes[k] > NEGLIGIBLE * self.column_sizes[c]
        };
        let pairs = (0..self.columns.len()).flat_map(|c| (0..self.keys.len()).map(move |k| (c, k)));
        let of = |(c, k): (usize, usize)| (&*self.columns[c], &self.keys[k], self.errors[c][k] / largest(c, k));
        pairs.filter(|(c, k)| matters(*c, *k)).map(of).filter(|(_, _, error)| *error > DOUBTFUL).collect()
    }
}

/// Computes the derivatives of the rows while a scene runs: [`RunOptions::sensitivities`](crate::scene::RunOptions::sensitivities).
///
/// ```
/// use durometer::scene::{ParameterKey, RunOptions, SensitivityRecorder, parse_scene};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let scene = parse_scene(
///     r#"
///     [mesh.grid]
///     kind = "box"
///     size = ["30 mm", "10 mm", "10 mm"]
///     divisions = [3, 1, 1]
///     [laws.rubber]
///     law = "neo_hookean"
///     E = "1 MPa"
///     nu = 0.3
///     [[effect]]
///     kind = "elastic"
///     region = "body"
///     law = "rubber"
///     [[effect]]
///     kind = "gravity"
///     region = "body"
///     density = "1100 kg/m^3"
///     direction = [0, 0, -1]
///     acceleration = "9.81 m/s^2"
///     [[constraint]]
///     kind = "fixed"
///     region = "xmin"
///     [[stage]]
///     integrator = "static"
///     duration = "1 s"
///     dt = "1 s"
///     [[probe]]
///     kind = "position"
///     region = "xmax"
///     "#,
/// )?;
/// let keys: Vec<ParameterKey> = vec!["effect.gravity.density".parse()?, "mesh.grid.size.0".parse()?];
/// let recorder = SensitivityRecorder::new(&scene, &keys)?;
/// let run = scene.run_with(RunOptions { sensitivities: Some(recorder), ..RunOptions::default() });
/// let found = run.sensitivities.expect("the options ask for them");
/// // ∂z/∂ρ of the tip [m per kg/m³], one value per row: it sinks
/// let by_density = found.derivative("xmax_z_m", &keys[0]).expect("a column and a key of it");
/// assert!(by_density[1] < 0.0);
/// assert!(found.doubtful().is_empty());
/// # Ok(())
/// # }
/// ```
pub struct SensitivityRecorder<'a> {
    sensitivity: Sensitivity<'a>,
    sensitivities: Sensitivities,
    /// Rows whose derivatives are computed at the end of the run; `None` if derivatives are computed step by step
    extremes: Option<ExtremeRows>,
}

impl<'a> SensitivityRecorder<'a> {
    /// A recorder of derivatives with respect to keys of the scene. They are exact for constants of laws with a known derivative, and finite differences of
    /// the equations for all other keys, including the parts of contacts and rigid bodies that depend on a law.
    ///
    /// # Errors
    ///
    /// Where a key does not lead to a number of the scene, or the scene has no derivative with respect to it.
    pub fn new(scene: &'a Scene, keys: &[ParameterKey]) -> Result<Self, SensitivityError> {
        Self::of(scene, keys, false)
    }

    /// A recorder of derivatives only at the first row and at the [extremes](crate::scene::extreme) of the columns, if steps do not depend on each other: in
    /// statics without history. This saves a factorisation for every other row. In all other cases it is the recorder of [`SensitivityRecorder::new`].
    ///
    /// # Errors
    ///
    /// Fails as [`SensitivityRecorder::new`] does.
    pub fn at_extremes(scene: &'a Scene, keys: &[ParameterKey]) -> Result<Self, SensitivityError> {
        let mut recorder = Self::of(scene, keys, false)?;
        let rest = scene.system.rest();
        if !scene.spans.iter().any(|span| Sensitivity::needs_past(span.integrator, &rest)) {
            let (all, own) = (scene.columns(), &recorder.sensitivities.columns);
            let positions = own.iter().filter_map(|name| all.iter().position(|column| column == name));
            recorder.extremes = Some(ExtremeRows::new(positions.collect()));
        }
        Ok(recorder)
    }

    /// A recorder of derivatives that uses finite differences for constants of laws too.
    ///
    /// # Errors
    ///
    /// Fails as [`SensitivityRecorder::new`] does.
    pub fn by_differences(scene: &'a Scene, keys: &[ParameterKey]) -> Result<Self, SensitivityError> {
        Self::of(scene, keys, true)
    }

    /// Recorded columns that have a derivative, in their order.
    pub fn columns(&self) -> &[String] {
        &self.sensitivities.columns
    }

    fn of(scene: &'a Scene, keys: &[ParameterKey], by_differences: bool) -> Result<Self, SensitivityError> {
        let sensitivity = Sensitivity::new(scene, keys, by_differences)?;
        let (columns, keys) = (sensitivity.columns(), keys.to_vec());
        let mut sensitivities = Sensitivities {
            errors: vec![vec![0.0; keys.len()]; columns.len()],
            terms: vec![vec![0.0; keys.len()]; columns.len()],
            column_sizes: vec![0.0; columns.len()],
            key_sizes: sensitivity.key_sizes(),
            columns,
            keys,
            rows: vec![],
            stopped: None,
            factorisations: 0,
            solves: 0,
            spent: Spent::default(),
        };
        sensitivities.add(sensitivity.start());
        Ok(Self { sensitivity, sensitivities, extremes: None })
    }

    /// Starts a stage at `state`.
    pub(in crate::scene) fn begin(&mut self, start: &SpanStart, state: &State) {
        if self.sensitivities.stopped.is_none() {
            self.timed(state.t, |sensitivity| sensitivity.solver.begin(start, state).map(|()| None));
        }
    }

    /// Takes an accepted step, with which the memory of the recorders has been updated.
    pub(in crate::scene) fn step(&mut self, step: &AcceptedStep, memory: &[f64], recorded: bool) {
        if self.extremes.is_some() || self.sensitivities.stopped.is_some() {
            return;
        }
        let AcceptedStep { integrator, past, now, sums, .. } = *step;
        let end = StepEnd { integrator, past, now, residual: &sums.r, memory };
        let row = self.timed(now.t, |sensitivity| sensitivity.step(&end, recorded));
        row.into_iter().for_each(|row| self.sensitivities.add(row));
    }

    /// Takes the row that was added to `rows` at the end of a step.
    pub(in crate::scene) fn recorded(&mut self, rows: &[Vec<f64>], step: &AcceptedStep, memory: &[f64]) {
        self.extremes.iter_mut().for_each(|extremes| extremes.add(rows, step, memory));
    }

    /// The derivatives; if the run ended early, those of its rows so far.
    pub(in crate::scene) fn finish(mut self, columns: &[String], rows: &[Vec<f64>]) -> Sensitivities {
        if let Some(extremes) = self.extremes.take() {
            self.compute(extremes, rows.len());
        }
        let factor = &self.sensitivity.solver.factor;
        let (factorisations, solves) = (factor.count, factor.solves);
        let own = self.sensitivities.columns.iter();
        let column_sizes = own.map(|name| largest_of_unit(columns, rows, name)).collect();
        Sensitivities { factorisations, solves, column_sizes, ..self.sensitivities }
    }

    /// Computes the derivatives at the extremes of a run with this number of rows.
    fn compute(&mut self, extremes: ExtremeRows, rows: usize) {
        let Sensitivities { columns, keys, .. } = &self.sensitivities;
        let none = vec![vec![f64::NAN; keys.len()]; columns.len()];
        self.sensitivities.rows.resize(rows, none);
        for ExtremeRow { row, integrator, past, now, residual, memory } in extremes.into_rows() {
            let end = StepEnd { integrator, past: &past, now: &now, residual: &residual, memory: &memory };
            let Some(found) = self.timed(now.t, |sensitivity| sensitivity.step(&end, true)) else { continue };
            self.sensitivities.note_quality(&found);
            self.sensitivities.rows[row] = found.values;
        }
    }

    fn timed(
        &mut self,
        t: f64,
        work: impl FnOnce(&mut Sensitivity) -> Result<Option<RowDerivatives>, Failure>,
    ) -> Option<RowDerivatives> {
        let stopwatch = Stopwatch::start();
        let row = work(&mut self.sensitivity).unwrap_or_else(|why| {
            self.sensitivities.stopped.get_or_insert((t, why));
            None
        });
        self.sensitivities.spent += stopwatch.spent();
        row
    }
}

impl Sensitivities {
    fn add(&mut self, row: RowDerivatives) {
        self.note_quality(&row);
        self.rows.push(row.values);
    }

    /// Updates the largest errors and terms with those of one row.
    fn note_quality(&mut self, row: &RowDerivatives) {
        for (most, of_row) in [(&mut self.errors, &row.errors), (&mut self.terms, &row.terms)] {
            for (most, value) in most.iter_mut().flatten().zip(of_row.iter().flatten()) {
                // NaN is not a derivative, and has neither error nor terms
                *most = most.max(*value);
            }
        }
    }
}
