//! Data points of one specimen in one mode, which are treated together.

use crate::calibrate::{Experiment, Mode, Sample};
use std::collections::HashSet;

/// One specimen in one mode.
#[derive(Clone, Debug)]
pub struct Group {
    pub specimen: usize,
    pub mode: Mode,
    /// The mode, and the specimen where there are several
    pub name: String,
}

impl Group {
    /// All that occur in a table.
    pub fn all(table: &Experiment) -> Vec<Self> {
        let present: HashSet<(usize, Mode)> = table.samples.iter().map(|s| (s.specimen, s.mode)).collect();
        let of = |(specimen, file): (usize, &String)| {
            let modes = Mode::ALL.into_iter().filter(|mode| present.contains(&(specimen, *mode)));
            let name =
                |mode: Mode| if table.specimens.len() > 1 { format!("{mode} ({file})") } else { mode.to_string() };
            modes.map(|mode| Self { specimen, mode, name: name(mode) }).collect::<Vec<_>>()
        };
        table.specimens.iter().enumerate().flat_map(of).collect()
    }

    pub fn has(&self, s: &Sample) -> bool {
        s.specimen == self.specimen && s.mode == self.mode
    }

    /// Its data points in their order.
    pub fn of(&self, samples: &[Sample]) -> Vec<Sample> {
        samples.iter().filter(|s| self.has(s)).copied().collect()
    }

    /// The places of its data points.
    pub fn places(&self, samples: &[Sample]) -> Vec<usize> {
        (0..samples.len()).filter(|k| self.has(&samples[*k])).collect()
    }
}
