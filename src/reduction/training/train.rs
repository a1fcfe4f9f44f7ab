//! Training of a reduced model from states of the full model.

use super::adjoint_space::{AdjointSpace, adjoint_solutions, adjoint_space};
use super::basis::{Basis, strains, weighted};
use super::body_points::BodyPoints;
use super::fields_at_points::FieldsAtPoints;
use super::full_state::FullState;
use super::points_at::PointsAt;
use super::sampling::{Selection, select, stored};
use crate::math::statistics::larger;
use crate::math::vector::{dot, norm};
use crate::reduction::constants::{ConstantInputs, Constants};
use crate::reduction::error::ReductionError;
use crate::reduction::forces::{ReducedCable, cables, check, effects_of_loads, loads, reduced_force};
use crate::reduction::inputs::{Input, signals};
use crate::reduction::model::{AdjointEstimate, Bar, Origin, ReducedModel};
use crate::reduction::points::Sizes;
use crate::reduction::quantities::{choose, quantities};
use crate::reduction::running::twin::Twin;
use crate::scene::Scene;
use std::borrow::Cow;

/// States of a scene whose inputs are controlled signals, from which reduced models of various sizes can be made.
pub struct Training<'a> {
    scene: &'a Scene,
    points: BodyPoints<'a>,
    inputs: Vec<Input>,
    states: Cow<'a, [FullState]>,
    names: Vec<String>,
    constants: Constants,
    /// Adjoint solutions of the quantities
    space: AdjointSpace,
}

impl<'a> Training<'a> {
    /// Prepares a training from states at training inputs, for models that provide the recorded columns `names`.
    ///
    /// # Errors
    ///
    /// [`ReductionError`]: parts of the scene without a reduced form, or states that do not belong to the scene.
    pub fn new(scene: &'a Scene, states: &'a [FullState], names: &[String]) -> Result<Self, ReductionError> {
        Self::with_constants(scene, None, states, names)
    }

    /// Prepares a training as [`Training::new`] does, with constants of laws as additional inputs after the signals.
    ///
    /// # Errors
    ///
    /// The errors of [`Training::new`], and [`ReductionError::Unsupported`] for constants that cannot be inputs.
    pub fn with_constants(
        scene: &'a Scene,
        constants: Option<&ConstantInputs>,
        states: &'a [FullState],
        names: &[String],
    ) -> Result<Self, ReductionError> {
        check(scene)?;
        check_names(scene, states.iter(), names)?;
        let mut inputs = signals(scene, constants.map_or(0, |c| c.inputs.len()))?;
        let signals = inputs.len();
        inputs.extend(constants.iter().flat_map(|c| c.inputs.clone()));
        if let Some(other) = states.iter().find(|s| s.inputs.len() != inputs.len()) {
            return Err(ReductionError::OtherScene(format!("{} inputs, not {}", other.inputs.len(), inputs.len())));
        }
        let points = BodyPoints::of(scene)?;
        let of = constants.map(|c| Constants::of(c, scene, &points, signals)).transpose()?.unwrap_or_default();
        let found = adjoint_solutions((scene, &points), (constants, signals), states, names)?;
        let states = match found.states {
            None => Cow::Borrowed(states),
            Some(all) => states.iter().zip(all).map(|(s, x)| FullState { x, ..s.clone() }).collect(),
        };
        let space = adjoint_space(scene, &points, &states, &found.solutions)?;
        Ok(Self { scene, points, inputs, states, names: names.to_vec(), constants: of, space })
    }

    /// Builds the model with `modes` displacement modes, and as many pressure modes if there are pressures. Its forces differ from those of all
    /// points by at most the relative tolerance `sampling`; with `None` all points are used. The error bars hold for `held_back`, which are not used
    /// for training; without such states the model has no bars.
    ///
    /// # Errors
    ///
    /// [`ReductionError`]: points that do not reproduce the forces, undefined laws, too many held-back states without an equilibrium for an error
    /// bar, or an error bar that is not finite.
    pub fn model(
        &self,
        modes: usize,
        sampling: Option<f64>,
        held_back: &[FullState],
    ) -> Result<ReducedModel, ReductionError> {
        let (space, mut model) = self.without_estimate(modes, sampling)?;
        if !held_back.is_empty() {
            self.add_estimate(&mut model, &space)?;
            let bars = calibrated(&model, held_back)?;
            model.estimate.iter_mut().for_each(|e| e.bars.clone_from(&bars));
        }
        model.origin.held_back = held_back.len();
        model.sound()
    }

    /// Builds a model as [`Training::model`] does, but with the absolute values of the estimates as error bars, without held-back states; this is
    /// sufficient to find where the error is large.
    ///
    /// # Errors
    ///
    /// The errors of [`Training::model`].
    pub fn uncalibrated(&self, modes: usize, sampling: Option<f64>) -> Result<ReducedModel, ReductionError> {
        let (space, mut model) = self.without_estimate(modes, sampling)?;
        self.add_estimate(&mut model, &space)?;
        Ok(model)
    }

    /// Builds the model without an estimate, and returns it with its space.
    fn without_estimate(
        &self,
        modes: usize,
        sampling: Option<f64>,
    ) -> Result<(Projected, ReducedModel), ReductionError> {
        let Self { scene, points, states, .. } = self;
        let fields: Vec<&[f64]> = states.iter().map(|s| &s.x[..]).collect();
        let space = Projected::of(scene, points, &fields, modes)?;
        let Projected { basis, at_points, coordinates, amplitudes, .. } = &space;
        let selection = match sampling {
            Some(tolerance) => {
                let at = PointsAt::new(points, &self.constants, states)?;
                select((points, &at), at_points, basis, (coordinates, *amplitudes), tolerance)?
            }
            None => Selection::all(points.weights().len()),
        };
        let names = (&selection, &self.inputs[..], &self.names[..]);
        let mut model = assemble((scene, points), &space, names, (&mut states.iter(), self.origin()))?;
        if !self.constants.laws.is_empty() {
            model.constants.clone_from(&self.constants);
            model.constants.set_compliances(points, &basis.modes[basis.displacements..], &self.space.fields);
        }
        Ok((space, model))
    }

    /// Returns the singular values of the displacements and of the pressures of the states, relative to the first.
    ///
    /// # Errors
    ///
    /// The errors of [`Training::model`].
    pub fn singular_values(&self) -> Result<(Vec<f64>, Vec<f64>), ReductionError> {
        let fields: Vec<&[f64]> = self.states.iter().map(|s| &s.x[..]).collect();
        let basis = Basis::of(self.scene, &self.points, &fields, 1)?;
        Ok((basis.singular_values, basis.pressure_values))
    }

    fn origin(&self) -> Origin {
        Origin {
            version: env!("CARGO_PKG_VERSION").into(),
            scene: self.scene.text.clone(),
            cells: self.scene.body.mesh.cell_count(),
            dofs: self.scene.system.dofs.free.len(),
            points: self.points.weights().len(),
            training: self.states.len(),
            ..Origin::default()
        }
    }

    /// Adds the error estimate, with the estimates themselves as error bars.
    fn add_estimate(
        &self,
        model: &mut ReducedModel,
        Projected { basis, at_points: fields, steps, .. }: &Projected,
    ) -> Result<(), ReductionError> {
        let Self { scene, points, space, .. } = self;
        let n = basis.displacements;
        let tests = FieldsAtPoints::of(points, &space.fields);
        let selection = space.select(
            model,
            (points, &PointsAt::new(points, &self.constants, &self.states)?),
            (fields, &tests),
            &self.states,
        )?;
        let loads = effects_of_loads(scene)
            .map(|(effect, load)| reduced_force((effect.blocks(), load), &space.fields, (&basis.modes[..n], steps)))
            .collect();
        let pairs = space.fields.iter().flat_map(|z| basis.modes[n..].iter().map(move |p| (z, p)));
        let compliance = pairs.map(|(z, p)| points.compliance(z, p)).collect();
        model.sizes.tests = space.fields.len();
        model.estimate = Some(AdjointEstimate {
            points: stored(points, &selection, (fields, basis), Some(&tests)),
            loads,
            cables: scene.cables.iter().map(|c| ReducedCable::motion(&c.cable, &space.fields)).collect(),
            compliance,
            centres: space.centres.clone(),
            regimes: space.regimes.clone(),
            bars: vec![Bar { factor: 1.0, floor: 0.0 }; model.quantities.len()],
        });
        Ok(())
    }
}

/// Smallest number of training states.
const FEWEST: usize = 3;
/// Smallest magnitude of a coordinate for the identification of polynomials, relative to all coordinates \[–\].
const STEP: f64 = 1e-3;

/// Refuses names that the scene does not record, and states that are too few or belong to a different scene.
pub(super) fn check_names<'s>(
    scene: &Scene,
    states: impl Iterator<Item = &'s FullState>,
    names: &[String],
) -> Result<(), ReductionError> {
    let columns = scene.columns();
    if let Some(name) = names.iter().find(|name| !columns.contains(name)) {
        return Err(ReductionError::Quantity { name: name.clone(), known: columns[1..].join(", ") });
    }
    let (unknowns, mut count) = (scene.system.dofs.equation.len(), 0);
    for state in states {
        count += 1;
        if state.x.len() != unknowns {
            return Err(ReductionError::OtherScene(format!("{} unknowns, not {unknowns}", state.x.len())));
        }
    }
    if count < FEWEST { Err(ReductionError::TooFewStates(count, FEWEST)) } else { Ok(()) }
}

/// The space of a model, with the training states projected onto it.
pub(super) struct Projected {
    pub basis: Basis,
    pub at_points: FieldsAtPoints,
    /// \[states × coordinates\]
    pub coordinates: Vec<Vec<f64>>,
    /// Largest ‖q‖ of the states, for displacements and for pressures
    pub amplitudes: [f64; 2],
    /// \[displacement coordinates\] magnitudes with which polynomials are identified
    pub steps: Vec<f64>,
}

impl Projected {
    pub fn of(scene: &Scene, points: &BodyPoints, fields: &[&[f64]], modes: usize) -> Result<Self, ReductionError> {
        let basis = Basis::of(scene, points, fields, modes)?;
        let at_points = FieldsAtPoints::of(points, &basis.modes);
        let coordinates = project(points, &basis, fields);
        let n = basis.displacements;
        let largest = |keep: &dyn Fn(&Vec<f64>) -> f64| coordinates.iter().map(keep).fold(0.0, larger);
        let amplitudes = [largest(&|y| norm(&y[..n])), largest(&|y| norm(&y[n..]))];
        let steps: Vec<f64> = (0..n).map(|i| larger(largest(&|y| y[i].abs()), STEP * amplitudes[0])).collect();
        Ok(Self { basis, at_points, coordinates, amplitudes, steps })
    }
}

/// Builds the static model of a space without an estimate, whose forces are summed over the selection; the states determine the scales of the
/// quantities.
pub(super) fn assemble(
    (scene, points): (&Scene, &BodyPoints),
    space: &Projected,
    (selection, inputs, names): (&Selection, &[Input], &[String]),
    (states, origin): (&mut dyn Iterator<Item = &FullState>, Origin),
) -> Result<ReducedModel, ReductionError> {
    let Projected { basis, at_points, amplitudes, steps, .. } = space;
    let n = basis.displacements;
    let m = basis.modes.len() - n;
    let compliance = |k: usize| points.compliance(&basis.modes[n + k / m], &basis.modes[n + k % m]);
    let loads = loads(scene, basis, inputs, steps)?;
    let cables = cables(scene, &basis.modes[..n], inputs)?;
    let all = quantities(scene, basis, &cables, steps);
    let mut model = ReducedModel {
        title: scene.title.clone(),
        inputs: inputs.to_vec(),
        sizes: Sizes { displacements: n, pressures: m, tests: 0 },
        points: stored(points, selection, (at_points, basis), None),
        compliance: (0..m * m).map(compliance).collect(),
        loads,
        cables,
        quantities: choose(all, names)?,
        rest: vec![],
        largest_changes: vec![],
        amplitudes: *amplitudes,
        estimate: None,
        dynamics: None,
        estimate_in_time: None,
        constants: Constants::default(),
        origin: Origin { supremisers: basis.supremisers, ..origin },
    };
    model.rest = Twin::new(model.clone())?.values().to_vec();
    model.largest_changes = vec![0.0; names.len()];
    for state in states {
        for ((most, value), rest) in model.largest_changes.iter_mut().zip(&state.values).zip(&model.rest) {
            *most = larger(*most, (value - rest).abs());
        }
    }
    Ok(model)
}

/// Returns the coordinates of states in the basis, which is orthonormal.
pub fn project(points: &BodyPoints, basis: &Basis, states: &[&[f64]]) -> Vec<Vec<f64>> {
    let weights = points.weights();
    let (displacements, pressures) = basis.modes.split_at(basis.displacements);
    let of_displacements: Vec<Vec<f64>> = displacements.iter().map(|v| strains(points, &weights, v)).collect();
    let of_pressures: Vec<Vec<f64>> = pressures.iter().map(|p| weighted(points, &weights, p)).collect();
    let one = |state: &&[f64]| {
        let strain = strains(points, &weights, state);
        let pressure = weighted(points, &weights, state);
        let moved = of_displacements.iter().map(|v| dot(v, &strain));
        moved.chain(of_pressures.iter().map(|p| dot(p, &pressure))).collect()
    };
    states.iter().map(one).collect()
}

/// Returns the errors of the model at states that were not used for training, and their estimates: \[states × quantities\].
pub fn errors(model: &ReducedModel, states: &[FullState]) -> Result<Vec<Vec<(f64, f64)>>, ReductionError> {
    let mut twin = Twin::new(model.clone())?;
    let mut out = vec![];
    for state in states {
        let row = match twin.step(&state.inputs) {
            Ok(_) => {
                let pairs = state.values.iter().zip(twin.values()).zip(twin.estimates());
                pairs.map(|((full, value), estimate)| (full - value, *estimate)).collect()
            }
            Err(_) => vec![(f64::INFINITY, 0.0); state.values.len()],
        };
        out.push(row);
    }
    Ok(out)
}

/// Share of the median error that is added to an estimate, because this may vanish \[–\].
const FLOOR: f64 = 0.2;
/// Error relative to the size of a quantity up to which it counts as zero \[–\], as for the tension of a cable that is slack in both models.
pub const EXACT: f64 = 1e-9;

/// Share of further errors that a bar is to contain, and the confidence of this \[–\].
pub const COVERED: f64 = 0.95;

/// Returns how many of the largest of n ratios may be left out such that, with that confidence, at least [`COVERED`] of all further ones are below
/// the largest remaining one, for any distribution (Wilks, *Ann. Math. Stat.* 12, 1941): zero below n = 59, where even the largest ratio gives less
/// confidence.
pub fn left_out(n: usize) -> usize {
    let (mut tail, mut term) = (0.0, COVERED.powi(n as i32));
    for outside in 0..n {
        tail += term;
        if tail > 1.0 - COVERED {
            return outside.saturating_sub(1);
        }
        term *= (n - outside) as f64 / (outside + 1) as f64 * (1.0 - COVERED) / COVERED;
    }
    0
}

/// Returns the confidence of error bars that are based on this number of states or runs.
pub fn confidence(held_back: usize) -> f64 {
    (1.0 - COVERED.powi(i32::try_from(held_back).unwrap_or(i32::MAX))).min(COVERED)
}

/// Returns error bars that hold for states that were held back.
fn calibrated(model: &ReducedModel, held_back: &[FullState]) -> Result<Vec<Bar>, ReductionError> {
    let all = errors(model, held_back)?;
    let failed = all.iter().filter(|row| row.iter().any(|(error, _)| !error.is_finite())).count();
    if failed > left_out(all.len()) {
        return Err(ReductionError::NoEquilibrium { failed, states: all.len() });
    }
    let samples: Vec<&[_]> = all.iter().map(std::slice::from_ref).collect();
    Ok(bars(model, &samples))
}

/// Returns the error bar of a quantity of this size from its errors and their estimates in independent samples, \[samples\]\[states\]. It holds for a
/// sample if it contains the errors of all of its states. The floor is determined from the errors that do not count as zero: for a quantity that is
/// exact in most states it is that of the other states. An error or estimate that is NaN counts as an infinite error.
pub(in crate::reduction) fn bar(samples: &[Vec<(f64, f64)>], size: f64) -> Bar {
    let least = (EXACT * size).max(f64::MIN_POSITIVE);
    let errors = samples.iter().flatten().map(|(error, _)| error.abs());
    let mut sizes: Vec<f64> = errors.filter(|error| error.is_finite() && *error > least).collect();
    sizes.sort_by(f64::total_cmp);
    let floor = sizes.get(sizes.len() / 2).map_or(least, |median| (FLOOR * median).max(least));
    let ratio = |(error, estimate): &(f64, f64)| error.abs() / (estimate.abs() + floor);
    let worst = |of: &Vec<(f64, f64)>| of.iter().map(ratio).fold(0.0, larger);
    let mut ratios: Vec<f64> =
        samples.iter().map(worst).map(|ratio| if ratio.is_nan() { f64::INFINITY } else { ratio }).collect();
    ratios.sort_by(f64::total_cmp);
    Bar { factor: ratios[ratios.len() - 1 - left_out(ratios.len())].max(1.0), floor }
}

/// Returns the error bars of all quantities of a model from \[samples\]\[states × quantities\].
pub(in crate::reduction) fn bars(model: &ReducedModel, samples: &[&[Vec<(f64, f64)>]]) -> Vec<Bar> {
    let of = |k: usize| -> Vec<Vec<(f64, f64)>> {
        samples.iter().map(|rows| rows.iter().map(|row| row[k]).collect()).collect()
    };
    model.largest_changes.iter().enumerate().map(|(k, size)| bar(&of(k), *size)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a cable that is slack in both models in most states, the error bar is of the size of the errors where it is taut, and contains all of them
    /// except those that may be left out.
    #[test]
    fn a_quantity_that_is_exact_in_most_states_has_a_bar_of_the_size_of_its_errors() {
        for slack in [0, 30, 50, 58] {
            let error = |n: usize| if n < slack { 1e-17 * (n % 2) as f64 } else { 1e-3 * (1.0 + n as f64 / 59.0) };
            let samples: Vec<Vec<(f64, f64)>> = (0..59).map(|n| vec![(error(n), 0.0)]).collect();
            let Bar { factor, floor } = bar(&samples, 1.0);
            assert!((2e-4..4e-4).contains(&floor), "{slack} slack: {floor}");
            assert!(factor >= 1.0 && (1e-3..2e-2).contains(&(factor * floor)), "{slack} slack: {factor} × {floor}");
            assert!(samples.iter().flatten().all(|(e, _)| *e <= factor * floor * (1.0 + 1e-12)), "{slack} slack");
        }
    }

    /// If one of 59 errors, or its estimate, is NaN, there is no finite bar, as with an infinite error; of 120 samples it is among those that may be
    /// left out.
    #[test]
    fn an_error_that_is_not_a_number_is_as_bad_as_an_infinite_one() {
        for bad in
            [(f64::INFINITY, 1.0), (f64::NAN, 1.0), (-f64::NAN, 1.0), (1.0, f64::NAN), (f64::INFINITY, f64::INFINITY)]
        {
            let of = |n: usize| -> Vec<Vec<(f64, f64)>> {
                (0..n).map(|k| vec![(1.0, 1.0), if k == 7 { bad } else { (0.5, 1.0) }]).collect()
            };
            assert_eq!(bar(&of(59), 1.0).factor, f64::INFINITY, "{bad:?}");
            assert!(left_out(120) > 0 && bar(&of(120), 1.0).factor.is_finite(), "{bad:?}");
        }
    }

    /// Without any error, and for a quantity of zero size, the bar is finite.
    #[test]
    fn a_bar_is_finite_without_errors() {
        for (error, size) in [(0.0, 2.0), (1e-12, 2.0), (0.0, 0.0), (1e-300, 0.0)] {
            let Bar { factor, floor } = bar(&vec![vec![(error, 0.0)]; 59], size);
            assert!(factor.is_finite() && floor > 0.0 && floor <= EXACT * size.max(1.0), "{error}: {factor} × {floor}");
            assert!(error <= factor * floor * (1.0 + 1e-12), "{error}: {factor} × {floor}");
        }
    }
}
