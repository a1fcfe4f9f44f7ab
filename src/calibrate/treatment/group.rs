//! Data points of one specimen in one mode, which are treated together, and their parts on either side of rest.

use crate::calibrate::sample::sides;
use crate::calibrate::{Experiment, Mode, Sample};
use std::collections::HashSet;

/// One specimen in one mode, or one side of it.
#[derive(Clone, Debug)]
pub struct Group {
    pub specimen: usize,
    pub mode: Mode,
    /// One side of rest alone: tension (`true`) or compression (`false`)
    side: Option<bool>,
    /// The mode, with the specimen if there are several
    pub name: String,
}

impl Group {
    /// All groups that occur in a table.
    pub fn all(table: &Experiment) -> Vec<Self> {
        let present: HashSet<(usize, Mode)> = table.samples.iter().map(|s| (s.specimen, s.mode)).collect();
        let of = |(specimen, file): (usize, &String)| {
            let modes = Mode::ALL.into_iter().filter(|mode| present.contains(&(specimen, *mode)));
            let name =
                |mode: Mode| if table.specimens.len() > 1 { format!("{mode} ({file})") } else { mode.to_string() };
            modes.map(|mode| Self { specimen, mode, side: None, name: name(mode) }).collect::<Vec<_>>()
        };
        table.specimens.iter().enumerate().flat_map(of).collect()
    }

    /// Its data points in tension and in compression, which have their own loadings and ends, if it has both; otherwise the group itself. Shear in
    /// both directions is one load.
    pub fn by_side(&self, samples: &[Sample]) -> Vec<Self> {
        if !Mode::PULLED.contains(&self.mode) || sides(samples.iter().filter(|s| self.has(s))) != [true, true] {
            return vec![self.clone()];
        }
        let of = |(tension, words): (bool, &str)| {
            let name = format!("{} in {words}", self.name);
            Self { side: Some(tension), name, ..self.clone() }
        };
        [(true, "tension"), (false, "compression")].map(of).into()
    }

    /// The side of rest, if the group is one side alone: `true` for tension, `false` for compression.
    pub fn tension(&self) -> Option<bool> {
        self.side
    }

    pub fn has(&self, s: &Sample) -> bool {
        let is_on_side = self.side.is_none_or(|tension| (s.stretch >= 1.0) == tension);
        s.specimen == self.specimen && s.mode == self.mode && is_on_side
    }

    /// Its data points in their order.
    pub fn of(&self, samples: &[Sample]) -> Vec<Sample> {
        samples.iter().filter(|s| self.has(s)).copied().collect()
    }

    /// The indices of its data points.
    pub fn places(&self, samples: &[Sample]) -> Vec<usize> {
        (0..samples.len()).filter(|k| self.has(&samples[*k])).collect()
    }
}
