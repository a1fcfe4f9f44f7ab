//! A scene as a forward model: it maps the unknowns θ to the values ŷ(θ) at the measured x and to ∂ŷ/∂θ.
//!
//! Between the steps of the protocol ŷ is the cubic through the four nearest steps (Lagrange), which is linear in the recorded values: the derivative
//! of the interpolation is the interpolation of the derivative. x is prescribed and does not depend on θ. Of several steps at the same x the last one
//! counts: a load that acts before x moves, such as the weight, is then already carried at the beginning of the curve.

use super::unknown::{Unknown, scene_table};
use super::{InverseError, Measured};
use crate::math::statistics::range;
use crate::scene::protocol::extremes;
use crate::scene::{
    Body, ParameterKey, Progress, Run, RunOptions, Scene, SceneSpec, SensitivityError, SensitivityRecorder, from_text,
    overrides,
};
use crate::solve::Status;
use nalgebra::DMatrix;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Deviation of the first y from the curve of the next ones, as a share of the range of y and as a multiple of the third-order term there, above
/// which it is a jump \[–\]
const JUMP: f64 = 0.01;
const BEYOND: f64 = 10.0;

/// A scene whose unknowns are varied.
#[derive(Clone)]
pub struct SceneModel {
    pub file: PathBuf,
    pub spec: SceneSpec,
    pub text: String,
    pub body: Arc<Body>,
    pub unknown: Vec<Unknown>,
    /// Signal or `t_s`
    pub x: String,
    /// Recorded column
    pub y: String,
}

/// Results of the model for some constants.
pub struct ModelAnswer {
    /// \[data points\]
    pub y: Vec<f64>,
    /// \[data points × constants\]
    pub sensitivities: DMatrix<f64>,
    /// \[data points\] dŷ/dx
    pub slope: Vec<f64>,
    /// x and y at the steps of the protocol
    pub curve: Vec<[f64; 2]>,
    pub run: Run,
    pub scene: Scene,
    /// Wall time of the run, and additional time of the derivatives \[s\]
    pub forward: f64,
    pub gradient: f64,
}

impl ModelAnswer {
    /// y at the beginning of the protocol.
    pub fn at_rest(&self) -> f64 {
        self.curve.first().map_or(0.0, |point| point[1])
    }
}

/// The reason why there is no answer for some constants.
pub enum Failure {
    /// The scene or the data are wrong, independently of the constants
    Input(InverseError),
    /// The scene cannot have these constants, or has no derivative at them
    Constants(String),
    /// The run did not finish
    Run(Status),
    /// Stopped from outside
    Interrupted,
}

impl SceneModel {
    /// The scene with these values of the unknowns \[SI\].
    pub fn scene(&self, values: &[f64]) -> Result<Scene, Failure> {
        let mut spec = self.spec.clone();
        for (u, value) in self.unknown.iter().zip(values) {
            let Some(of) = u.key.law_constant() else { continue };
            let table = spec.laws.get_mut(of.law).expect("the unknowns were looked up in these laws");
            table.insert(of.key.into(), u.written(*value));
            if let Err(why) = self.spec.known_laws.law(table) {
                return Err(Failure::Constants(why.to_string()));
            }
        }
        if self.unknown.iter().all(|u| u.key.law_constant().is_some()) {
            // Derivatives by differences start from the values of the text. A scene that was written in Rust has no text, and is refused there
            let text = self.changed(values).map_or_else(|_| self.text.clone(), |table| written(&table));
            let scene = Scene::build(&self.file, spec, text, self.body.clone());
            return scene.map_err(|e| Failure::Input(e.into()));
        }
        self.varied(values).map_err(Failure::Input)
    }

    /// The scene built from the text with these values of the unknowns.
    fn varied(&self, values: &[f64]) -> Result<Scene, InverseError> {
        let text = written(&self.changed(values)?);
        let read: SceneSpec = from_text(&self.file, &text, "")?;
        let spec = SceneSpec { known_laws: self.spec.known_laws.clone(), ..read };
        let body = match self.unknown.iter().any(|u| u.key.makes_mesh()) {
            true => Arc::new(self.body.varied(&self.file, &spec.mesh)?),
            false => self.body.clone(),
        };
        Ok(Scene::build(&self.file, spec, text, body)?)
    }

    /// The table of the text with these values of the unknowns.
    fn changed(&self, values: &[f64]) -> Result<toml::Table, InverseError> {
        let mut table = scene_table(&self.file, &self.text)?;
        for (u, value) in self.unknown.iter().zip(values) {
            overrides::apply(&mut table, u.key.path(), u.written(*value)).map_err(SensitivityError::from)?;
        }
        Ok(table)
    }

    fn start(&self) -> Vec<f64> {
        self.unknown.iter().map(|u| u.start).collect()
    }

    /// Refuses unknowns that change the coordinate over which a curve is compared.
    fn check_x(&self, scene: &Scene) -> Result<(), Failure> {
        let times: Vec<f64> = scene.spans.iter().flat_map(|s| (0..=s.steps()).map(|k| s.point(k))).collect();
        let x = self.position(scene, times.iter().copied()).map_err(Failure::Input)?;
        for (k, u) in self.unknown.iter().enumerate().filter(|(_, u)| u.key.law_constant().is_none()) {
            let start = self.start()[k];
            let step = 1e-3 * (u.bounds[1] - u.bounds[0]).min(if start == 0.0 { u.usual } else { start.abs() });
            let side = if start + step > u.bounds[1] { -1.0 } else { 1.0 };
            let vary = |by: f64| {
                let mut values = self.start();
                values[k] += by * side * step;
                self.varied(&values)
            };
            // Near the limit of what the scene allows, one side may be beyond it, or all but small steps
            let near = |why| [-1.0, 1e-3, -1e-3].into_iter().find_map(|by| vary(by).ok()).ok_or(why);
            let moved = vary(1.0).or_else(near).map_err(Failure::Input)?;
            if self.position(&moved, times.iter().copied()).map_err(Failure::Input)? != x {
                let (key, name) = (u.key.to_string(), self.x.clone());
                return Err(Failure::Input(InverseError::MovesX { key, name }));
            }
        }
        Ok(())
    }

    /// Runs the scene with these constants \[SI\], up to the step that reaches the last data point; the rest of the protocol needs no solution.
    /// `slack` is subtracted from the x of the data points \[unit of x\]; before the protocol begins, y is that of its start. `watch` is called after
    /// each step and stops the run by returning false.
    pub fn answer(
        &self,
        values: &[f64],
        x: &[f64],
        slack: f64,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<ModelAnswer, Failure> {
        self.solved(values, x, slack, watch).map_err(|failure| match failure {
            // An error of the scene itself already appears at its own constants
            Failure::Input(why) if values != self.start() || is_of_values(&why) => Failure::Constants(why.to_string()),
            failure => failure,
        })
    }

    fn solved(
        &self,
        values: &[f64],
        x: &[f64],
        slack: f64,
        watch: &mut dyn FnMut(Progress) -> bool,
    ) -> Result<ModelAnswer, Failure> {
        let scene = self.scene(values)?;
        let wanted: Vec<f64> = x.iter().map(|x| x - slack).collect();
        let constants: Vec<ParameterKey> = self.unknown.iter().map(|u| u.key.clone()).collect();
        let begin = Instant::now();
        let recorder = SensitivityRecorder::new(&scene, &constants).map_err(|e| Failure::Input(e.into()))?;
        let last = self.last(&scene, &wanted).map_err(Failure::Input)?;
        let mut is_enough = false;
        let mut on_row = |row: &[f64]| {
            is_enough = row[0] >= last;
            !is_enough
        };
        let options = RunOptions {
            on_progress: Some(watch),
            on_row: Some(&mut on_row),
            sensitivities: Some(recorder),
            undiagnosed: true,
            ..RunOptions::default()
        };
        let mut run = scene.run_with(options);
        let sensitivities = run.sensitivities.take().expect("the options ask for them");
        let column = |names: &[String]| names.iter().position(|c| *c == self.y);
        let Some(of_sensitivities) = column(&sensitivities.columns) else {
            let fact = match scene.check_column(&self.y) {
                Err(fact) => fact,
                Ok(()) => {
                    "this column has no exact derivative; take a position, an angle, a reaction or a tension".into()
                }
            };
            return Err(Failure::Input(InverseError::NoColumn { name: self.y.clone(), fact }));
        };
        let gradient = sensitivities.spent.wall_s;
        let forward = begin.elapsed().as_secs_f64() - gradient;
        match (&run.status, sensitivities.stopped) {
            (Status::Converged, None) => {}
            (Status::Interrupted { .. }, None) if is_enough => {}
            (Status::Interrupted { .. }, _) => return Err(Failure::Interrupted),
            (Status::Converged, Some((t, why))) => {
                return Err(Failure::Run(Status::StepTooSmall { t, why, by_force: false }));
            }
            (status, _) => return Err(Failure::Run(status.clone())),
        }
        let k = column(&run.columns).expect("a column with a derivative is recorded");
        let x: Vec<f64> = self.position(&scene, run.rows.iter().map(|row| row[0])).map_err(Failure::Input)?;
        let rows = last_of_equal(&x);
        let x: Vec<f64> = rows.iter().map(|row| x[*row]).collect();
        let sensitivities: Vec<&Vec<f64>> =
            rows.iter().map(|row| &sensitivities.rows[*row][of_sensitivities]).collect();
        let (weights, slopes) = weights(&self.x, &x, &wanted).map_err(Failure::Input)?;
        let mut used = weights.iter().flatten().filter(|(_, w)| *w != 0.0).map(|(row, _)| *row);
        if let Some(row) = used.find(|row| sensitivities[*row].iter().any(|d| d.is_nan())) {
            return Err(Failure::Input(InverseError::NoDerivative { name: self.y.clone(), t: run.rows[rows[row]][0] }));
        }
        let values: Vec<f64> = rows.iter().map(|row| run.rows[*row][k]).collect();
        let (n, p) = (wanted.len(), self.unknown.len());
        let sum = |row: &Stencil, of: &dyn Fn(usize) -> f64| {
            row.iter().filter(|(_, w)| *w != 0.0).map(|(i, w)| w * of(*i)).sum::<f64>()
        };
        let y = weights.iter().map(|row| sum(row, &|i| values[i])).collect();
        let sensitivities = DMatrix::from_fn(n, p, |i, j| sum(&weights[i], &|r| sensitivities[r][j]));
        let slope = slopes.iter().map(|row| sum(row, &|i| values[i])).collect();
        let curve = x.iter().zip(&values).map(|(x, y)| [*x, *y]).collect();
        Ok(ModelAnswer { y, sensitivities, slope, curve, run, scene, forward, gradient })
    }

    /// The curve of an answer, interpolated at other x.
    pub fn interpolated(&self, curve: &[[f64; 2]], x: &[f64]) -> Option<Vec<f64>> {
        let steps: Vec<f64> = curve.iter().map(|p| p[0]).collect();
        let (rows, _) = weights(&self.x, &steps, x).ok()?;
        Some(rows.iter().map(|row| row.iter().map(|(i, w)| w * curve[*i][1]).sum()).collect())
    }

    /// Time at which the protocol passes the last data point \[s\].
    fn last(&self, scene: &Scene, wanted: &[f64]) -> Result<f64, InverseError> {
        let Some(span) = scene.spans.last() else { return Ok(0.0) };
        let times: Vec<f64> =
            scene.spans.iter().flat_map(|s| (0..=s.steps()).map(|k| s.start + k as f64 * s.dt)).collect();
        let x = self.position(scene, times.iter().copied())?;
        let up = x.last() > x.first();
        let passes = |x: f64| wanted.iter().all(|v| if up { *v <= x } else { *v >= x });
        Ok(times.iter().zip(x).find(|(_, x)| passes(*x)).map_or(span.end, |(t, _)| *t))
    }

    /// x at these times.
    fn position(&self, scene: &Scene, times: impl Iterator<Item = f64>) -> Result<Vec<f64>, InverseError> {
        if self.x == "t_s" {
            return Ok(times.collect());
        }
        let found = scene.signals.iter().find(|s| s.name == self.x).ok_or_else(|| {
            let known = scene.signals.iter().map(|s| s.name.clone()).collect::<Vec<_>>().join(", ");
            InverseError::NoSignal { name: self.x.clone(), known }
        })?;
        Ok(times.map(|t| found.signal.at(t)).collect())
    }

    /// Whether the protocol reaches each data point.
    pub fn reached(&self, measured: &Measured) -> Result<Vec<bool>, Failure> {
        let scene = self.scene(&self.start())?;
        self.check_x(&scene)?;
        let ends = match scene.signals.iter().find(|s| s.name == self.x) {
            Some(found) => {
                let ((_, least), (_, most)) = extremes(&found.signal, &scene.spans);
                [least, most]
            }
            None => {
                self.position(&scene, std::iter::empty()).map_err(Failure::Input)?;
                [0.0, scene.spans.last().map_or(0.0, |s| s.end)]
            }
        };
        let slack = 1e-9 * (ends[1] - ends[0]);
        let inside: Vec<bool> = measured.x.iter().map(|v| (ends[0] - slack..=ends[1] + slack).contains(v)).collect();
        let rows = inside.iter().filter(|i| **i).count();
        if rows == 0 {
            let (name, from, to) = (self.x.clone(), ends[0], ends[1]);
            return Err(Failure::Input(InverseError::NoOverlap { name, from, to, rows }));
        }
        Ok(inside)
    }
}

fn written(table: &toml::Table) -> String {
    toml::to_string(table).expect("a table that was read can be written")
}

/// Whether the error may disappear at other constants: near the limit of what a scene allows, a small change leads beyond it, so that no derivative
/// exists.
fn is_of_values(why: &InverseError) -> bool {
    matches!(
        why,
        InverseError::Sensitivity(
            SensitivityError::Differs { .. } | SensitivityError::AtBound { .. } | SensitivityError::Stopped { .. }
        )
    )
}

/// Indices of the values that differ from the next one.
fn last_of_equal(x: &[f64]) -> Vec<usize> {
    (0..x.len()).filter(|k| x.get(k + 1) != Some(&x[*k])).collect()
}

/// Deviation of the first y of a curve from the curve through the next ones, as a share of the range of y; `None` if it may belong to the curve.
pub fn jump(curve: &[[f64; 2]]) -> Option<f64> {
    let ([x, y], next) = (*curve.first()?, curve.get(1..5)?);
    let cubic = lagrange(next, x);
    let off = (y - cubic).abs();
    let share = off / range(curve.iter().map(|point| point[1]));
    (share > JUMP && off > BEYOND * (cubic - lagrange(&next[..3], x)).abs()).then_some(share)
}

/// The value at `x` of the polynomial through these points.
fn lagrange(points: &[[f64; 2]], x: f64) -> f64 {
    let weight = |i: usize| {
        let others = (0..points.len()).filter(|j| *j != i);
        others.map(|j| (x - points[j][0]) / (points[i][0] - points[j][0])).product::<f64>()
    };
    (0..points.len()).map(|i| weight(i) * points[i][1]).sum()
}

/// Steps and weights of an interpolated value.
type Stencil = Vec<(usize, f64)>;

/// Lagrange weights of the four nearest steps for every wanted x, and the weights of the derivative with respect to x.
fn weights(name: &str, steps: &[f64], wanted: &[f64]) -> Result<(Vec<Stencil>, Vec<Stencil>), InverseError> {
    let n = steps.len();
    let up = steps.last() > steps.first();
    if n < 2 || !steps.windows(2).all(|w| if up { w[1] > w[0] } else { w[1] < w[0] }) {
        return Err(InverseError::NotMonotone { name: name.into() });
    }
    let one = |x: &f64| {
        if if up { *x < steps[0] } else { *x > steps[0] } {
            return (vec![(0, 1.0)], vec![]);
        }
        let next = steps.partition_point(|s| if up { s < x } else { s > x }).clamp(1, n - 1);
        let from = next.saturating_sub(2).min(n.saturating_sub(4));
        let own: Vec<usize> = (from..(from + 4).min(n)).collect();
        let part = |i: usize, j: usize| (x - steps[j]) / (steps[i] - steps[j]);
        let weight = |&i: &usize| own.iter().filter(|j| **j != i).map(|j| part(i, *j)).product::<f64>();
        let slope = |&i: &usize| {
            let without = |m: usize| own.iter().filter(|j| **j != i && **j != m).map(|j| part(i, *j)).product::<f64>();
            own.iter().filter(|m| **m != i).map(|m| without(*m) / (steps[i] - steps[*m])).sum::<f64>()
        };
        (own.iter().map(|i| (*i, weight(i))).collect(), own.iter().map(|i| (*i, slope(i))).collect())
    };
    Ok(wanted.iter().map(one).unzip())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The interpolation and its derivative are exact for cubics, up to rounding, also on an uneven grid that goes down.
    #[test]
    fn cubics_are_interpolated_exactly() {
        let f = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x - 0.3 * x * x * x;
        let steps: Vec<f64> = [0.0, 0.1, 0.25, 0.5, 0.7, 1.0].iter().map(|x| -x).collect();
        let x = vec![0.0, -0.05, -0.33, -0.66, -0.999, -1.0];
        let slope = |x: f64| -2.0 + x - 0.9 * x * x;
        let (values, slopes) = weights("x", &steps, &x).expect("monotone");
        let sum = |row: &Stencil| row.iter().map(|(i, w)| w * f(steps[*i])).sum::<f64>();
        for ((value, derivative), x) in values.iter().zip(&slopes).zip(&x) {
            assert!((sum(value) - f(*x)).abs() < 1e-14, "{x}: {}", sum(value));
            assert!((sum(derivative) - slope(*x)).abs() < 1e-12, "{x}: {}", sum(derivative));
        }
        assert!(weights("x", &[0.0, 1.0, 0.5], &x).is_err());
        // An x that never moves has one step
        assert!(weights("x", &[0.0], &x).is_err());
    }

    /// A stage in which the load settles at constant x keeps only its last row.
    #[test]
    fn of_steps_without_movement_the_last_one_counts() {
        assert_eq!(last_of_equal(&[0.0, 0.0, 0.0, 0.1, 0.2, 0.2]), [2, 3, 5]);
        assert_eq!(last_of_equal(&[0.0, 0.1, 0.2]), [0, 1, 2]);
        assert!(last_of_equal(&[]).is_empty());
    }

    /// A weight of a fifth of the force that is not carried in the first row is a jump; a bent curve, and one that begins steeply, have none.
    #[test]
    fn a_load_that_acts_from_the_beginning_shows_as_a_jump() {
        let curve = |of: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
            (0..11).map(|k| 0.1 * f64::from(k)).map(|x| [x, of(x)]).collect()
        };
        let bent = |x: f64| (1.0 + x) - (1.0 + x).powi(-2);
        assert_eq!(jump(&curve(&bent)), None);
        assert_eq!(jump(&curve(&|x: f64| (8.0 * x).tanh())), None);
        let share = jump(&curve(&|x: f64| bent(x) + if x > 0.0 { 0.4 } else { 0.0 })).expect("a jump");
        assert!((share - 0.4 / 2.15).abs() < 0.01, "{share}");
    }
}
