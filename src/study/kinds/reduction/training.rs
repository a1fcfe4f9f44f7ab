//! Plans of training states: how many, and where.

use crate::math::units;
use crate::study::kinds::reduction::path::{grid, hypercube, spread};
use crate::study::kinds::reduction::record::GreedyRecord;
use crate::study::spec::Mistake;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use std::fmt;

/// Number of states that the models are made of, or a plan.
#[derive(Clone, Debug, PartialEq, JsonSchema)]
#[schemars(untagged)]
pub enum TrainingSpec {
    /// A grid for one input, corners and a Latin hypercube for several
    States(usize),
    Plan(PlanSpec),
}

/// A plan of training states.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum PlanSpec {
    /// Every combination of `each` values of each input, ends included
    Grid {
        /// Number of values of each input
        each: usize,
    },
    /// One state in each stratum of every input
    LatinHypercube {
        /// Number of states, and of strata
        states: usize,
    },
    /// A few states, then batches of states where the estimated error of the present model is largest
    Greedy(GreedySpec),
}

/// Keys of a greedy plan.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GreedySpec {
    /// Largest number of states
    pub states: usize,
    /// Number of states to begin with; default a quarter of `states`, but at least two per input plus one
    pub start: Option<usize>,
    /// Number of states that are computed in parallel
    #[serde(default = "batch")]
    pub batch: usize,
    /// Number of points at which errors are estimated
    #[serde(default = "candidates")]
    pub candidates: usize,
    /// Largest estimated error at which the search ends, relative to the largest change: `"0.2 %"`; default a tenth of the tolerance of the study
    pub tolerance: Option<String>,
}

fn batch() -> usize {
    4
}

fn candidates() -> usize {
    256
}

impl<'de> Deserialize<'de> for TrainingSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(TrainingVisitor)
    }
}

struct TrainingVisitor;

impl<'de> Visitor<'de> for TrainingVisitor {
    type Value = TrainingSpec;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number of states, or a plan such as { kind = \"greedy\", states = 40 }")
    }

    fn visit_i64<E: Error>(self, states: i64) -> Result<TrainingSpec, E> {
        let states =
            usize::try_from(states).map_err(|_| E::custom(format!("{states} states; give a positive number")))?;
        Ok(TrainingSpec::States(states))
    }

    fn visit_u64<E: Error>(self, states: u64) -> Result<TrainingSpec, E> {
        Ok(TrainingSpec::States(states as usize))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TrainingSpec, A::Error> {
        PlanSpec::deserialize(MapAccessDeserializer::new(map)).map(TrainingSpec::Plan)
    }
}

/// Largest number of states of a plan; more is taken to be a typing error.
const MOST: usize = 100_000;

impl TrainingSpec {
    /// Returns the largest number of states that the plan can have when it is complete.
    pub fn states(&self, inputs: usize) -> usize {
        match self {
            Self::States(states) | Self::Plan(PlanSpec::LatinHypercube { states }) => *states,
            Self::Plan(PlanSpec::Grid { each }) => each.checked_pow(inputs as u32).unwrap_or(usize::MAX),
            Self::Plan(PlanSpec::Greedy(greedy)) => greedy.states,
        }
    }

    /// Refuses an impossible plan.
    pub fn check(&self, inputs: usize) -> Result<(), Mistake> {
        let mistake = |fact: String, remedy: &str| Err(("training".into(), fact, remedy.into()));
        if self.states(inputs) > MOST {
            return mistake(format!("more than {MOST} states"), "give fewer states, or fewer values of each input");
        }
        let Self::Plan(PlanSpec::Greedy(greedy)) = self else { return Ok(()) };
        let start = self.start(inputs);
        if start < 3 || start > greedy.states {
            let fact = format!("start = {start} of {} states", greedy.states);
            return mistake(fact, "begin with three or more, and with fewer than `states`");
        }
        if greedy.batch == 0 || greedy.candidates < greedy.batch {
            let fact = format!("batches of {} among {} candidates", greedy.batch, greedy.candidates);
            return mistake(fact, "take a batch of 1 or more, and many more candidates");
        }
        greedy_tolerance(greedy).map(drop)
    }

    /// Number of states that are computed together at the start.
    fn start(&self, inputs: usize) -> usize {
        match self {
            Self::Plan(PlanSpec::Greedy(greedy)) => {
                greedy.start.unwrap_or((greedy.states / 4).max(2 * inputs + 1).min(greedy.states))
            }
            _ => self.states(inputs),
        }
    }

    /// Returns the states that are computed first, as fractions of the ranges of the inputs.
    pub fn points(&self, inputs: usize, seed: u64) -> Vec<Vec<f64>> {
        match self {
            Self::Plan(PlanSpec::Grid { each }) => grid(inputs, *each),
            Self::Plan(PlanSpec::LatinHypercube { states }) => hypercube(inputs, *states, seed),
            _ => spread(inputs, self.start(inputs), seed),
        }
    }

    /// Returns the greedy plan as stored in the record of the study.
    pub fn greedy(&self, tolerance: &str) -> Result<Option<GreedyRecord>, Mistake> {
        let Self::Plan(PlanSpec::Greedy(greedy)) = self else { return Ok(None) };
        let own = greedy_tolerance(greedy)?;
        let of_study = || units::parse(tolerance, units::Dimension::NONE).map(|t| SHARE * t).unwrap_or(0.0);
        Ok(Some(GreedyRecord {
            states: greedy.states,
            batch: greedy.batch,
            candidates: greedy.candidates,
            tolerance: own.unwrap_or_else(of_study),
        }))
    }
}

/// Fraction of the tolerance of the study at which a search ends by default: errors are estimated, not known.
const SHARE: f64 = 0.1;

fn greedy_tolerance(greedy: &GreedySpec) -> Result<Option<f64>, Mistake> {
    let Some(text) = &greedy.tolerance else { return Ok(None) };
    let wrong = |fact: String| ("training".to_string(), fact, "write tolerance = \"0.2 %\"".to_string());
    let value = units::parse(text, units::Dimension::NONE).map_err(|e| wrong(e.to_string()))?;
    if value > 0.0 && value < 1.0 { Ok(Some(value)) } else { Err(wrong(format!("tolerance = \"{text}\""))) }
}
