//! Constants of laws as inputs of a reduced model: the laws at given inputs, their derivatives, and the compliance of their pressures.
//!
//! Modes and weights are unchanged, and the law at each point is built with the current constants. The compliance of a pressure field on quadratic
//! cells is ∫ N_c N_d /κ dV, so that it follows from that of the nominal law by the ratio of the bulk moduli.

use super::error::ReductionError;
use super::inputs::Input;
use super::training::body_points::BodyPoints;
use crate::material::registry::given;
use crate::material::{Law, LawCard, LawSpecError, Values, find, sensitivity};
use crate::math::units::Dimension;
use crate::mesh::Order;
use crate::scene::spec::EffectSpec;
use crate::scene::{ParameterKey, Scene};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Constants that are inputs of a training, in addition to its signals.
pub struct ConstantInputs<'a> {
    pub keys: Vec<ParameterKey>,
    /// \[keys\] their names and ranges in SI
    pub inputs: Vec<Input>,
    /// Builds the scene with the constants at these values in SI; everything else is as in the scene of the training
    pub build: &'a dyn Fn(&[f64]) -> Result<Scene, ReductionError>,
}

impl ConstantInputs<'_> {
    /// Builds the scene at inputs in which the constants follow `signals` signals.
    pub fn scene(&self, inputs: &[f64], signals: usize) -> Result<Scene, ReductionError> {
        (self.build)(&inputs[signals..])
    }
}

/// A law whose constants are inputs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VariableLaw {
    /// Name of its table under `laws` in the scene
    pub name: String,
    /// Name in the registry of laws
    pub law: String,
    /// Values given in the scene, in SI
    pub given: Values,
    pub options: BTreeMap<String, String>,
    /// Key of the constant → index of the input
    pub inputs: BTreeMap<String, usize>,
    /// Indices of the parts of the body with this law
    pub parts: Vec<usize>,
}

impl VariableLaw {
    /// Builds the law at these inputs.
    ///
    /// # Errors
    ///
    /// The errors of a law file, such as a value outside its bounds.
    pub fn at(&self, inputs: &[f64]) -> Result<Box<dyn Law>, LawSpecError> {
        find(&self.law)?.build(&self.values(inputs), &self.options)
    }

    /// Returns the derivative of the law with respect to input `k`; `None` if the law does not depend on it.
    pub fn derivative(&self, k: usize, inputs: &[f64]) -> Option<Box<dyn Law>> {
        let (key, _) = self.inputs.iter().find(|(_, input)| **input == k)?;
        sensitivity::derivative_of(find(&self.law).ok()?, &self.values(inputs), &self.options, key).ok()
    }

    fn values(&self, inputs: &[f64]) -> Values {
        let mut values = self.given.clone();
        values.extend(self.inputs.iter().map(|(key, &input)| (key.clone(), inputs[input])));
        values
    }
}

/// The compliance of the pressures of one part, for its nominal law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartCompliance {
    /// Bulk modulus of the nominal law \[Pa\], zero for a part without pressures
    pub kappa: f64,
    /// \[pressure modes × pressure modes\] \[J\]
    pub own: Vec<f64>,
    /// \[tests × pressure modes\]
    pub tests: Vec<f64>,
}

/// All constants of laws that are inputs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Constants {
    pub laws: Vec<VariableLaw>,
    /// \[parts\]
    pub parts: Vec<PartCompliance>,
}

impl Constants {
    /// Finds the laws of the scene that have these constants. `signals` is the number of inputs before them.
    ///
    /// # Errors
    ///
    /// [`ReductionError::Unsupported`] for constants on which nothing in the body depends, and for constants that affect more than the laws at
    /// points.
    pub fn of(of: &ConstantInputs, scene: &Scene, points: &BodyPoints, signals: usize) -> Result<Self, ReductionError> {
        let unsupported = |what: &ParameterKey, why: &str, remedy: &str| ReductionError::Unsupported {
            what: format!("the input {what}"),
            why: why.into(),
            remedy: remedy.into(),
        };
        let mut laws: BTreeMap<&str, VariableLaw> = BTreeMap::new();
        for (k, key) in of.keys.iter().enumerate() {
            let Some(constant) = key.law_constant() else {
                return Err(unsupported(key, "it is no constant of a law", "write for example laws.rubber.mu"));
            };
            let Some(table) = scene.spec.laws.get(constant.law) else {
                return Err(unsupported(key, "the scene has no such law", "name one of its laws"));
            };
            let (entry, values, options) = given(table)?;
            if !values.contains_key(constant.key) {
                let why = "the scene gives its law by other constants, and two sets cannot both be held";
                return Err(unsupported(key, why, "take a constant that the scene gives"));
            }
            let new = || VariableLaw {
                name: constant.law.into(),
                law: entry.info.name.into(),
                given: values,
                options,
                inputs: BTreeMap::new(),
                parts: parts(scene, constant.law),
            };
            let law = laws.entry(constant.law).or_insert_with(new);
            if law.parts.is_empty() {
                return Err(unsupported(key, "no elastic effect consists of this law", "take one of its laws"));
            }
            let is_linear = scene.body.mesh.order == Order::Linear;
            if is_linear && law.parts.iter().any(|&part| points.parts[part].constitution.pressure.is_some()) {
                let why = "the stabilisation of pressures on tet4 depends on it in a way of its own";
                return Err(unsupported(key, why, "take element = \"tet10\", or formulation = \"displacement\""));
            }
            law.inputs.insert(constant.key.into(), signals + k);
        }
        Ok(Self { laws: laws.into_values().collect(), parts: vec![] })
    }

    /// Computes the compliances of all parts for pressure modes and tests.
    pub fn set_compliances(&mut self, points: &BodyPoints, modes: &[Vec<f64>], tests: &[Vec<f64>]) {
        let of_part = |(k, part): (usize, &super::training::body_points::ElasticPoints)| {
            let pairs = |fields: &[Vec<f64>]| {
                let all = fields.iter().flat_map(|a| modes.iter().map(move |b| (a.clone(), b)));
                all.map(|(a, b)| points.compliance_of(k, &a, b)).collect::<Vec<f64>>()
            };
            PartCompliance { kappa: part.bulk_modulus().unwrap_or(0.0), own: pairs(modes), tests: pairs(tests) }
        };
        self.parts = points.parts.iter().enumerate().map(of_part).collect();
    }

    /// Returns the law cards of the parts whose law varies, at these inputs.
    pub fn cards(&self, inputs: &[f64]) -> Result<Vec<(usize, LawCard)>, LawSpecError> {
        let of_law = |law: &VariableLaw| {
            let card = LawCard::of(law.at(inputs)?.as_ref());
            Ok(law.parts.iter().map(|&part| (part, card.clone())).collect::<Vec<_>>())
        };
        Ok(self.laws.iter().map(of_law).collect::<Result<Vec<_>, LawSpecError>>()?.concat())
    }

    /// Returns the first input of a law that is undefined at these inputs, if there is one.
    pub fn undefined(&self, inputs: &[f64]) -> Option<usize> {
        self.laws.iter().find(|law| law.at(inputs).is_err()).and_then(|law| law.inputs.values().next().copied())
    }

    /// Returns the changes that give a scene these constants in SI, the values of the inputs from `signals` on.
    pub fn changes(&self, signals: usize, constants: &[f64]) -> Vec<(String, toml::Value)> {
        let text = |law: &VariableLaw, key: &str, value: f64| {
            let constant = find(&law.law).ok().and_then(|entry| entry.keys.iter().find(|p| p.name == key));
            if constant.is_some_and(|p| p.dimension == Dimension::PRESSURE) {
                format!("{value} Pa").into()
            } else {
                toml::Value::from(value)
            }
        };
        let of_law = |law: &VariableLaw| {
            let change = |(key, &input): (&String, &usize)| {
                (format!("laws.{}.{key}", law.name), text(law, key, constants[input - signals]))
            };
            law.inputs.iter().map(change).collect::<Vec<_>>()
        };
        self.laws.iter().flat_map(of_law).collect()
    }

    /// Whether an input is a constant.
    pub fn has(&self, input: usize) -> bool {
        self.laws.iter().any(|law| law.inputs.values().any(|k| *k == input))
    }

    /// Whether the constants belong to a model of these sizes.
    pub fn is_sound(&self, inputs: usize, parts: usize, pressures: usize) -> bool {
        self.laws.iter().all(|law| {
            law.inputs.values().all(|k| *k < inputs) && law.parts.iter().all(|p| *p < parts) && !law.parts.is_empty()
        }) && self.parts.len() == parts
            && self.parts.iter().all(|part| {
                let numbers = || part.own.iter().chain(&part.tests).chain([&part.kappa]);
                part.own.len() == pressures * pressures && numbers().all(|x| x.is_finite())
            })
    }
}

/// Returns the elastic effects with the law of this name, as indices of the parts of the body.
fn parts(scene: &Scene, law: &str) -> Vec<usize> {
    let laws = scene.spec.effects.iter().filter_map(|effect| match effect {
        EffectSpec::Elastic(solid) => Some(&solid.law),
        _ => None,
    });
    laws.enumerate().filter(|(_, name)| *name == law).map(|(k, _)| k).collect()
}
