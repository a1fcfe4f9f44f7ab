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

/// Derivatives of the rows of a [`Run`](crate::scene::Run) by some keys of its scene.
pub struct Sensitivities {
    /// Columns of the run that have a derivative, in their order: all but t_s, newton_iterations and those of contacts, rigid bodies, rigid parts, the probes
    /// `energy`, `stretch` and `moment`, and fibres and membranes
    pub columns: Vec<String>,
    pub keys: Vec<ParameterKey>,
    /// \[rows × columns × keys\] in the unit of the column per SI unit of the key; one entry for each of `Run::rows`,
    /// fewer only where `stopped` says why. NaN where a column has no derivative, like the curvature of a straight line, and in the rows
    /// that [`SensitivityRecorder::at_extremes`] leaves out
    pub rows: Vec<Vec<Vec<f64>>>,
    /// \[columns × keys\] largest estimated error of a derivative over the rows, zero where it is exact
    pub errors: Vec<Vec<f64>>,
    /// \[columns × keys\] largest sum over the rows of the sizes of the terms that a derivative is the sum of: of a reaction those of the
    /// nodes. It is far above the derivative where they cancel
    pub terms: Vec<Vec<f64>>,
    /// \[columns\] largest value over the rows, of all columns of the same unit
    pub column_sizes: Vec<f64>,
    /// \[keys\] size of the value of a key \[SI\], 0 where its derivative is exact
    pub key_sizes: Vec<f64>,
    /// Time \[s\] from which on there is no derivative: a bifurcation, or a limit point. Of the derivatives at extremes, the first one without
    pub stopped: Option<(f64, Failure)>,
    /// Numeric factorisations and right sides solved for the derivatives, in addition to those of the run
    pub factorisations: usize,
    pub solves: usize,
    /// Time of the derivatives; the phases of the run do not contain it
    pub spent: Spent,
}

/// Error of a derivative, relative to its largest value over the rows, from which on it is called doubtful.
pub const DOUBTFUL: f64 = 1e-6;
/// Error below which a derivative does not matter: relative to the terms that it is the sum of, and as a change of the column over a change of the key by
/// its own size, relative to the largest value.
const NEGLIGIBLE: f64 = 1e-9;

impl Sensitivities {
    /// Derivatives of a column by a key, one per row; none of a column or key that is not there.
    pub fn derivative(&self, column: &str, key: &ParameterKey) -> Option<Vec<f64>> {
        let (c, k) = (self.columns.iter().position(|n| n == column)?, self.keys.iter().position(|n| n == key)?);
        Some(self.rows.iter().map(|row| row[c][k]).collect())
    }

    /// Keys by which every derivative of every row is exactly zero: they change none of the columns. None is known where the derivatives end early,
    /// before a load or a contact may make them matter.
    pub fn idle(&self) -> impl Iterator<Item = &ParameterKey> {
        let is_complete = self.stopped.is_none();
        let is_idle = move |k: usize| is_complete && self.rows.iter().flatten().all(|by_keys| by_keys[k] == 0.0);
        self.keys.iter().enumerate().filter(move |(k, _)| is_idle(*k)).map(|(_, key)| key)
    }

    /// Column, key and relative error of the derivatives whose estimated error is above 1e-6 of their largest value, where it is more than rounding:
    /// more than 1e-9 of the terms of the derivative, and of the column over a change of the key by its own size.
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
    /// The rows of which derivatives are computed, at the end of the run; none where they are computed step by step
    extremes: Option<ExtremeRows>,
}

impl<'a> SensitivityRecorder<'a> {
    /// A recorder of derivatives by keys of the scene, exact by constants of laws whose derivative is known and by differences of its equations by others, as are
    /// those of contacts and rigid bodies that follow a law; an error where there are none.
    ///
    /// # Errors
    ///
    /// Where a key names no number of the scene, or one by which it has no derivative.
    pub fn new(scene: &'a Scene, keys: &[ParameterKey]) -> Result<Self, SensitivityError> {
        Self::of(scene, keys, false)
    }

    /// The same at the [extremes](crate::scene::extreme) of the columns and at the first row only, where the steps do not need each other: in statics without history.
    /// This saves a factorisation for every other row.
    ///
    /// # Errors
    ///
    /// Those of [`SensitivityRecorder::new`].
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

    /// The same by differences for constants of laws, too.
    ///
    /// # Errors
    ///
    /// Those of [`SensitivityRecorder::new`].
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

    /// A stage begins at `state`.
    pub(in crate::scene) fn begin(&mut self, start: &SpanStart, state: &State) {
        if self.sensitivities.stopped.is_none() {
            self.timed(state.t, |sensitivity| sensitivity.solver.begin(start, state).map(|()| None));
        }
    }

    /// A step was accepted, which the recorders have taken over into their memory.
    pub(in crate::scene) fn step(&mut self, step: &AcceptedStep, memory: &[f64], recorded: bool) {
        if self.extremes.is_some() || self.sensitivities.stopped.is_some() {
            return;
        }
        let AcceptedStep { integrator, past, now, sums, .. } = *step;
        let end = StepEnd { integrator, past, now, residual: &sums.r, memory };
        let row = self.timed(now.t, |sensitivity| sensitivity.step(&end, recorded));
        row.into_iter().for_each(|row| self.sensitivities.add(row));
    }

    /// A row was added to `rows` at the end of a step.
    pub(in crate::scene) fn recorded(&mut self, rows: &[Vec<f64>], step: &AcceptedStep, memory: &[f64]) {
        self.extremes.iter_mut().for_each(|extremes| extremes.add(rows, step, memory));
    }

    /// The derivatives, of the rows so far where the run ended early.
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

    /// Computes the derivatives at the extremes of a run of so many rows.
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

    /// Takes the errors and the terms at one row into account.
    fn note_quality(&mut self, row: &RowDerivatives) {
        for (most, of_row) in [(&mut self.errors, &row.errors), (&mut self.terms, &row.terms)] {
            for (most, value) in most.iter_mut().flatten().zip(of_row.iter().flatten()) {
                // A value that is not a number is no derivative, and has neither
                *most = most.max(*value);
            }
        }
    }
}
