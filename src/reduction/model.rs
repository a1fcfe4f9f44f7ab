//! A reduced model: everything that its steps need, independent of the mesh.

use super::constants::Constants;
use super::error::ReductionError;
use super::forces::{CableDrive, Load, ReducedCable};
use super::inputs::Input;
use super::points::{Sizes, StoredPoints};
use super::quantities::ReducedQuantity;
use super::running::dynamics::Dynamics;
use crate::scene::FileDigest;
use serde::{Deserialize, Serialize};

/// A reduced model of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReducedModel {
    pub title: String,
    pub inputs: Vec<Input>,
    pub sizes: Sizes,
    /// The points from which forces are summed, one set per law
    pub points: Vec<StoredPoints>,
    /// \[pressure modes × pressure modes\] compliance \[J\]
    pub compliance: Vec<f64>,
    pub loads: Vec<Load>,
    pub cables: Vec<ReducedCable>,
    pub quantities: Vec<ReducedQuantity>,
    /// Value of each quantity at rest, with all inputs at zero or at the ends of their ranges nearest to zero
    pub rest: Vec<f64>,
    /// Largest change of each quantity from rest in the training states: the scale for its errors, independent of its origin
    pub largest_changes: Vec<f64>,
    /// Largest ‖q‖ of the training states, for displacements and for pressures
    pub amplitudes: [f64; 2],
    /// Error estimate of a static model
    pub estimate: Option<AdjointEstimate>,
    /// Inertia, damping and time stepping of a dynamic model
    pub dynamics: Option<Dynamics>,
    /// Error estimate of a dynamic model
    pub estimate_in_time: Option<TimeEstimate>,
    /// Constants of laws that are inputs
    #[serde(default)]
    pub constants: Constants,
    pub origin: Origin,
}

/// Origin of a model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Origin {
    /// Version of the program that made the model
    pub version: String,
    /// The scene as text
    pub scene: String,
    /// Numbers of cells, unknowns and points of the full model
    pub cells: usize,
    pub dofs: usize,
    pub points: usize,
    /// Number of displacement modes that are supremisers, which determine the pressures
    pub supremisers: usize,
    /// Changes by which this scene differs from that of the study, as a table of paths and values
    pub changes: String,
    /// Digest of the mesh
    pub mesh_sha256: String,
    /// Files named in the scene; empty in models of earlier versions
    pub files: Vec<FileDigest>,
    /// Number of states used for training, and held back for the error bars
    pub training: usize,
    pub held_back: usize,
}

/// The error estimate of a model: residual forces along adjoint solutions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdjointEstimate {
    /// Points from which the forces along the tests are summed, one set per law
    pub points: Vec<StoredPoints>,
    /// Loads along the tests
    pub loads: Vec<super::polynomial::Quadratic>,
    /// For each cable: motions of the guides in the tests \[3 × guides, tests\]
    pub cables: Vec<Vec<f64>>,
    /// \[tests × pressure modes\] compliance
    pub compliance: Vec<f64>,
    /// Centre and half-width of each input, which scale the powers
    pub centres: Vec<[f64; 2]>,
    /// The adjoint solutions, one set for each set of taut cables in the training states
    pub regimes: Vec<Regime>,
    /// For each quantity: the error bar is `factor` (|estimate| + `floor`)
    pub bars: Vec<Bar>,
}

/// The error estimate of a dynamic model: a second model with more modes and points, which follows the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeEstimate {
    pub enriched: Box<ReducedModel>,
    /// \[coordinates of the enriched model × coordinates of the model\] the modes of the model in terms of the modes of the enriched model
    pub embedding: Vec<f64>,
    /// For each quantity: the error bar is `factor` (|estimate| + `floor`)
    pub bars: Vec<Bar>,
    /// Number of runs held back for the bars, and number of steps of the longest one
    pub runs: usize,
    pub steps: usize,
}

/// The adjoint solutions for one set of taut cables, as polynomials of the inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Regime {
    /// \[cables\] whether the length of the cable constrains the body
    pub taut: Vec<bool>,
    /// \[terms × inputs\]
    pub exponents: Vec<Vec<u32>>,
    /// For each quantity: coefficients of the adjoint solution in the tests \[tests × terms\]
    pub adjoints: Vec<Vec<f64>>,
}

/// Constants by which an estimate becomes an error bar.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bar {
    pub factor: f64,
    /// Floor of the estimate, in the unit of the quantity
    pub floor: f64,
}

impl ReducedModel {
    /// Returns the model if its parts are consistent.
    ///
    /// # Errors
    ///
    /// [`ReductionError::Faulty`] with the reason if they are not.
    pub fn sound(self) -> Result<Self, ReductionError> {
        match self.fault() {
            None => Ok(self),
            Some(fact) => Err(ReductionError::Faulty(fact)),
        }
    }

    /// Returns the reason why the parts of the model are not consistent, if they are not.
    pub fn fault(&self) -> Option<&'static str> {
        let Self { sizes, inputs, loads, cables, .. } = self;
        let n = sizes.displacements;
        let cable = |c: &ReducedCable| {
            let affine = match &c.drive {
                CableDrive::Tension(affine) => affine.is_sound(inputs.len()),
                CableDrive::Length { free, compliance } => free.is_sound(inputs.len()) && *compliance >= 0.0,
            };
            let places = c.guides.iter().chain(&c.pull_point).flatten().chain(&c.motion).all(|x| x.is_finite());
            affine && places && c.motion.len() == 3 * c.guides.len() * n && !c.guides.is_empty()
        };
        let range = |i: &Input| i.range.iter().chain(&i.start).all(|x| x.is_finite()) && i.range[0] < i.range[1];
        let checks = [
            (n > 0 && n < MOST && sizes.pressures < MOST && sizes.tests < MOST, "it has no modes, or too many"),
            (!inputs.is_empty() && inputs.iter().all(range), "a range of an input is empty, or its start not finite"),
            (
                !self.points.is_empty() && self.points.iter().all(|p| p.is_sound(self.own_sizes())),
                "points and modes do not fit together",
            ),
            (self.compliance.len() == sizes.pressures * sizes.pressures, "the compliance has another size"),
            (
                loads.iter().all(|l| l.intensity.is_sound(inputs.len()) && l.force.is_sound(n, n)),
                "a load has another size",
            ),
            (cables.iter().all(cable), "a cable has another size"),
            (
                self.quantities.iter().all(|q| q.reading.is_sound(n, cables.len(), loads.len())),
                "a quantity has another size",
            ),
            (
                [&self.rest, &self.largest_changes].iter().all(|of| of.len() == self.quantities.len()),
                "the sizes of quantities are not known",
            ),
            (
                self.amplitudes.iter().all(|a| a.is_finite() && *a >= 0.0) && self.amplitudes[0] > 0.0,
                "it has no amplitude",
            ),
            (
                self.bars().unwrap_or_default().iter().all(|b| b.factor.is_finite() && b.floor.is_finite()),
                "an error bar is not a finite number",
            ),
            (self.estimate.as_ref().is_none_or(|e| self.fits(e)), "the error estimate has another size"),
            (
                self.constants.laws.is_empty()
                    || self.constants.is_sound(inputs.len(), self.points.len(), sizes.pressures),
                "the constants have another size",
            ),
        ];
        let fault = checks.into_iter().find(|(holds, _)| !holds).map(|(_, fact)| fact);
        fault.or_else(|| self.dynamics.as_ref().and_then(|d| d.fault(n, inputs.len()))).or_else(|| self.fault_in_time())
    }

    /// Returns the scale of a quantity with a target value: its change from rest at that value, but at least its largest change in the training
    /// states.
    pub fn size_at(&self, quantity: usize, value: f64) -> f64 {
        self.largest_changes[quantity].max((value - self.rest[quantity]).abs())
    }

    /// Returns, for each input, whether a search moves it by default: the driving inputs, or all inputs of a model without any.
    pub fn driving(&self) -> Vec<bool> {
        let drives = |(k, input): (usize, &Input)| !input.held && !self.constants.has(k);
        let all: Vec<bool> = self.inputs.iter().enumerate().map(drives).collect();
        if all.contains(&true) { all } else { vec![true; all.len()] }
    }

    /// Returns the constants of the error bars of all quantities; `None` without an estimate.
    pub fn bars(&self) -> Option<&[Bar]> {
        let in_time = self.estimate_in_time.as_ref().map(|e| &e.bars[..]);
        in_time.or(self.estimate.as_ref().map(|e| &e.bars[..]))
    }

    /// Returns the sizes of the points of the model itself, which have no tests.
    pub fn own_sizes(&self) -> Sizes {
        Sizes { tests: 0, ..self.sizes }
    }

    /// Returns the reason why the error estimate of a dynamic model does not belong to it, if it does not.
    fn fault_in_time(&self) -> Option<&'static str> {
        let Some(e) = &self.estimate_in_time else {
            let both = self.dynamics.is_some() && self.estimate.is_some();
            return both.then_some("it has an estimate for models that rest");
        };
        let (own, other) = (self.dynamics.as_ref(), e.enriched.dynamics.as_ref());
        let same_step = own.zip(other).is_some_and(|(a, b)| a.dt == b.dt && a.integrator == b.integrator);
        let sound = same_step
            && self.estimate.is_none()
            && e.enriched.estimate_in_time.is_none()
            && e.enriched.fault().is_none()
            && e.enriched.inputs == self.inputs
            && e.enriched.cables.len() == self.cables.len()
            && e.enriched.quantities.len() == self.quantities.len()
            && e.embedding.len() == e.enriched.sizes.coordinates() * self.sizes.coordinates()
            && e.embedding.iter().all(|x| x.is_finite())
            && e.bars.len() == self.quantities.len();
        (!sound).then_some("the error estimate has another size")
    }

    fn fits(&self, e: &AdjointEstimate) -> bool {
        let Self { sizes, inputs, quantities, .. } = self;
        let regime = |r: &Regime| {
            r.taut.len() == self.cables.len()
                && !r.exponents.is_empty()
                && r.exponents.iter().all(|x| x.len() == inputs.len())
                && r.adjoints.len() == quantities.len()
                && r.adjoints.iter().all(|a| a.len() == sizes.tests * r.exponents.len())
        };
        e.points.iter().all(|p| p.is_sound(*sizes))
            && e.loads.len() == self.loads.len()
            && e.loads.iter().all(|l| l.is_sound(sizes.displacements, sizes.tests))
            && e.cables.len() == self.cables.len()
            && e.cables.iter().zip(&self.cables).all(|(m, c)| m.len() == 3 * c.guides.len() * sizes.tests)
            && e.compliance.len() == sizes.tests * sizes.pressures
            && self.constants.parts.iter().all(|part| part.tests.len() == e.compliance.len())
            && e.centres.len() == inputs.len()
            && e.regimes.iter().all(regime)
            && e.bars.len() == quantities.len()
    }
}

/// Upper bound of the number of modes of any model.
const MOST: usize = 1000;
