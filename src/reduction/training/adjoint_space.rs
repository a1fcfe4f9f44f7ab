//! The space of the adjoint solutions of a reduced model, and the points from which forces along them are summed.

use super::basis::{decompose, orthonormalise, strains, weighted};
use super::body_points::BodyPoints;
use super::fields_at_points::FieldsAtPoints;
use super::full_state::FullState;
use super::points_at::PointsAt;
use super::sampling::{Selection, of_rows};
use crate::math::signal::Known;
use crate::math::svd::svd;
use crate::math::vector::{dot, norm};
use crate::reduction::constants::ConstantInputs;
use crate::reduction::error::ReductionError;
use crate::reduction::model::{ReducedModel, Regime};
use crate::reduction::running::residual::terms;
use crate::reduction::running::twin::Twin;
use crate::scene::parts::constraints::Drive;
use crate::scene::{Recorder, Scene};
use crate::solve::{Integrator, Step, adjoints};
use crate::system::{Gradient, State};
use nalgebra::{DMatrix, DVector};

/// Fields that represent the adjoint solutions of all quantities, and their coefficients as polynomials of the inputs.
pub struct AdjointSpace {
    /// \[tests × unknowns\]
    pub fields: Vec<Vec<f64>>,
    /// Centre and half-width of each input
    pub centres: Vec<[f64; 2]>,
    pub regimes: Vec<Regime>,
    /// \[states\] index of the regime
    of_states: Vec<usize>,
}

/// Share of an adjoint solution below which a field is omitted \[–\].
const SMALL: f64 = 1e-3;
/// Error of the forces along the adjoint solutions, relative to the ranges of the quantities \[–\].
const ACCURACY: f64 = 1e-5;
/// Number of states per coefficient of a polynomial.
const STATES: usize = 3;
/// Largest total degree of a polynomial in the inputs.
const DEGREE: u32 = 6;

/// Adjoint solutions of quantities at states.
pub struct AdjointSolutions {
    /// \[quantities × states × unknowns\]
    pub solutions: Vec<Vec<Vec<f64>>>,
    /// \[states × unknowns\] the states themselves, in the units of the scene of the training, if constants of laws are inputs
    pub states: Option<Vec<Vec<f64>>>,
}

/// Computes the adjoint solutions of the quantities with these names at states; if constants are inputs, each with the laws of its state.
pub fn adjoint_solutions(
    (scene, points): (&Scene, &BodyPoints),
    (constants, signals): (Option<&ConstantInputs>, usize),
    states: &[FullState],
    names: &[String],
) -> Result<AdjointSolutions, ReductionError> {
    let mut solutions: Vec<Vec<Vec<f64>>> = vec![vec![]; names.len()];
    let mut rescaled = constants.map(|_| vec![]);
    for state in states {
        let own = constants.map(|c| c.scene(&state.inputs, signals)).transpose()?;
        let own = own.as_ref().unwrap_or(scene);
        let at = full(own, state, signals);
        if at.x.len() != scene.system.rest().x.len() {
            return Err(ReductionError::OtherScene(format!("{} unknowns", at.x.len())));
        }
        let gradients = gradients(own, &at, (names, &state.values));
        let step = Step { system: &own.system, integrator: Integrator::Static, past: &at, dt: 1.0 };
        let mut found = adjoints(own.method(), &step, &at, &gradients).map_err(ReductionError::Adjoint)?;
        if let Some(rescaled) = &mut rescaled {
            let own_points = BodyPoints::of(own)?;
            found.iter_mut().for_each(|found| found.z = points.rescaled(&own_points, &found.z));
            rescaled.push(points.rescaled(&own_points, &state.x));
        }
        solutions.iter_mut().zip(found).for_each(|(all, found)| all.push(found.z));
    }
    Ok(AdjointSolutions { solutions, states: rescaled })
}

/// Builds the space of adjoint solutions at the training states.
pub fn adjoint_space(
    scene: &Scene,
    points: &BodyPoints,
    training: &[FullState],
    solutions: &[Vec<Vec<f64>>],
) -> Result<AdjointSpace, ReductionError> {
    let weights = points.weights();
    let split = scene.system.dofs.displacements as usize;
    let (mut moved, mut pressed) = (vec![], vec![]);
    for of_quantity in solutions {
        let largest = of_quantity.iter().map(|z| norm(&strains(points, &weights, z))).fold(0.0, f64::max);
        for z in of_quantity.iter().filter(|_| largest > 0.0) {
            let scaled: Vec<f64> = z.iter().map(|z| z / largest).collect();
            let (mut a, mut b) = (scaled.clone(), scaled);
            a[split..].fill(0.0);
            b[..split].fill(0.0);
            moved.push(a);
            pressed.push(b);
        }
    }
    let mut fields = largest_fields(&moved, |u| strains(points, &weights, u));
    if points.has_pressure() {
        fields.extend(largest_fields(&pressed, |p| weighted(points, &weights, p)));
    }
    let centres = centres(training);
    let patterns: Vec<Vec<bool>> = training.iter().map(|state| taut(scene, state)).collect();
    let mut regimes: Vec<Regime> = vec![];
    for pattern in &patterns {
        if regimes.iter().any(|r| r.taut == *pattern) {
            continue;
        }
        let own: Vec<usize> = (0..training.len()).filter(|&k| patterns[k] == *pattern).collect();
        let exponents = exponents(centres.len(), own.len());
        let adjoints = fit((points, &weights, split), &fields, solutions, (training, &own), (&centres, &exponents));
        regimes.push(Regime { taut: pattern.clone(), exponents, adjoints });
    }
    let place = |pattern: &Vec<bool>| regimes.iter().position(|r| r.taut == *pattern).expect("it has its regime");
    let of_states = patterns.iter().map(place).collect();
    Ok(AdjointSpace { fields, centres, regimes, of_states })
}

/// Returns which cables constrain the body by their lengths.
fn taut(scene: &Scene, state: &FullState) -> Vec<bool> {
    let drives = scene.cables.iter().map(|cable| &cable.drive);
    drives.map(|drive| matches!(drive, Drive::Multiplier(c) if state.lambda[*c] > 0.0)).collect()
}

/// Converts the state to one of the scene.
fn full(scene: &Scene, of: &FullState, signals: usize) -> State {
    let inputs = of.inputs[..signals].iter().map(|&u| Known::constant(u)).collect();
    State { x: of.x.clone(), lambda: of.lambda.clone(), inputs, ..scene.system.rest() }
}

/// Returns the gradients of recorded columns at a state, given their values there.
fn gradients(scene: &Scene, state: &State, (names, values): (&[String], &[f64])) -> Vec<Gradient> {
    let value = |column: &String| names.iter().zip(values).find(|(name, _)| *name == column).map(|(_, value)| *value);
    let of = |recorder: &dyn Recorder| {
        let columns = recorder.columns();
        let recorded: Vec<Option<f64>> = columns.iter().map(value).collect();
        let memory = recorder.memory_at(&scene.body, state, &recorded);
        columns.into_iter().zip(recorder.gradients(&scene.body, state, &memory)).collect::<Vec<_>>()
    };
    let all: Vec<(String, Option<Gradient>)> = scene.recorders().flat_map(of).collect();
    let find = |name: &String| all.iter().find(|(column, _)| column == name).and_then(|(_, g)| g.clone());
    names.iter().map(|name| find(name).unwrap_or_default()).collect()
}

/// Returns orthonormal fields that represent all `fields` except for a small share.
fn largest_fields(fields: &[Vec<f64>], values: impl Fn(&[f64]) -> Vec<f64>) -> Vec<Vec<f64>> {
    let of: Vec<Vec<f64>> = fields.iter().map(|f| values(f)).collect();
    let (modes, sizes) = decompose(fields, &of, fields.len());
    let count = sizes.iter().take_while(|s| **s > SMALL).count();
    let mut modes: Vec<Vec<f64>> = modes.into_iter().take(count).collect();
    orthonormalise(&mut modes, values);
    modes
}

/// Returns centres and half-widths of the inputs.
fn centres(training: &[FullState]) -> Vec<[f64; 2]> {
    let range = |k: usize| {
        let all = training.iter().map(|s| s.inputs[k]);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), u| (l.min(u), h.max(u)));
        let half = 0.5 * (high - low);
        [0.5 * (low + high), if half > 0.0 { half } else { 1.0 }]
    };
    (0..training.first().map_or(0, |s| s.inputs.len())).map(range).collect()
}

/// Returns the exponents of all terms up to the largest total degree that this number of states determines.
fn exponents(inputs: usize, states: usize) -> Vec<Vec<u32>> {
    let all = (0..=DEGREE).map(|degree| terms_up_to(inputs, degree));
    let determined = all.take_while(|terms| terms.len() == 1 || STATES * terms.len() <= states);
    determined.last().expect("a constant is one term")
}

fn terms_up_to(inputs: usize, degree: u32) -> Vec<Vec<u32>> {
    if inputs == 0 {
        return vec![vec![]];
    }
    let with =
        |first: u32| terms_up_to(inputs - 1, degree - first).into_iter().map(move |rest| [vec![first], rest].concat());
    (0..=degree).flat_map(with).collect()
}

/// Fits the coefficients of the adjoint solutions in the fields as polynomials of the inputs, by least squares.
fn fit(
    (points, weights, split): (&BodyPoints, &[f64], usize),
    fields: &[Vec<f64>],
    solutions: &[Vec<Vec<f64>>],
    (training, own): (&[FullState], &[usize]),
    (centres, exponents): (&[[f64; 2]], &[Vec<u32>]),
) -> Vec<Vec<f64>> {
    let is_motion = |field: &Vec<f64>| field[..split].iter().any(|v| *v != 0.0);
    let values = |field: &Vec<f64>| {
        if is_motion(field) { strains(points, weights, field) } else { weighted(points, weights, field) }
    };
    let of_fields: Vec<Vec<f64>> = fields.iter().map(values).collect();
    let motions = fields.iter().filter(|f| is_motion(f)).count();
    let mut row = vec![0.0; exponents.len()];
    let rows = own.iter().flat_map(|&k| {
        terms(centres, exponents, &training[k].inputs, &mut row);
        row.clone()
    });
    let design = DMatrix::from_row_iterator(own.len(), exponents.len(), rows);
    let decomposed = svd(design, true, true);
    let one = |of_quantity: &Vec<Vec<f64>>| {
        let shares: Vec<Vec<f64>> = own
            .iter()
            .map(|&k| {
                let z = &of_quantity[k];
                let (strain, pressure) = (strains(points, weights, z), weighted(points, weights, z));
                let share = |(k, of): (usize, &Vec<f64>)| dot(of, if k < motions { &strain } else { &pressure });
                of_fields.iter().enumerate().map(share).collect()
            })
            .collect();
        let of_test = |test: usize| {
            let right = DVector::from_iterator(shares.len(), shares.iter().map(|s| s[test]));
            decomposed.solve(&right, 1e-10).map_or_else(|_| vec![0.0; exponents.len()], |c| c.as_slice().to_vec())
        };
        (0..fields.len()).flat_map(of_test).collect()
    };
    solutions.iter().map(one).collect()
}

impl AdjointSpace {
    /// Returns the coefficients of the adjoint solution of a quantity at the inputs of a training state.
    fn coefficients(&self, quantity: usize, state: usize, inputs: &[f64]) -> Vec<f64> {
        let Regime { exponents, adjoints, .. } = &self.regimes[self.of_states[state]];
        let mut row = vec![0.0; exponents.len()];
        terms(&self.centres, exponents, inputs, &mut row);
        adjoints[quantity].chunks_exact(row.len()).map(|c| dot(c, &row)).collect()
    }

    /// Selects points from which the forces of the model at the training inputs are summed along the adjoint solutions.
    pub fn select(
        &self,
        model: &ReducedModel,
        (points, at): (&BodyPoints, &PointsAt),
        (fields, tests): (&FieldsAtPoints, &FieldsAtPoints),
        training: &[FullState],
    ) -> Result<Selection, ReductionError> {
        let weights = points.weights();
        let ranges: Vec<f64> = (0..model.quantities.len())
            .map(|k| {
                let all = training.iter().map(|s| s.values[k]);
                let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
                if high > low { high - low } else { 1.0 }
            })
            .collect();
        let mut twin = Twin::new(model.clone())?;
        let mut rows = vec![];
        for (number, state) in training.iter().enumerate() {
            if twin.step(&state.inputs).is_err() {
                continue;
            }
            let forces = at.forces(number, fields, &twin.position().y)?;
            for (k, range) in ranges.iter().enumerate() {
                let z = self.coefficients(k, number, &state.inputs);
                let work = |p: usize| {
                    let along = |(test, z): (usize, &f64)| z * tests.work(test, p, weights[p], &forces[p]);
                    z.iter().enumerate().map(along).sum::<f64>() / range
                };
                rows.push((0..weights.len()).map(work).collect::<Vec<f64>>());
            }
        }
        let volume: f64 = weights.iter().sum();
        rows.push(weights.iter().map(|w| w / volume).collect());
        of_rows(&rows, ACCURACY)
    }
}
