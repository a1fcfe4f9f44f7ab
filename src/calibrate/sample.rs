//! A measured stress, and the recorded quantities of the machine in one row.

use super::Mode;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// One measured stress. A row of a biaxial table yields two samples.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct Sample {
    pub mode: Mode,
    /// λ \[–\] in the loaded direction; in simple shear the principal stretch, γ = λ − λ⁻¹
    pub stretch: f64,
    /// λ₂ \[–\] of a biaxial test; 1 if the mode determines it
    pub second: f64,
    /// Nominal stress P \[Pa\]: force over undeformed area
    pub stress: f64,
    /// Line of the file, counted from 1
    pub line: u64,
    /// Index of its file, counted from 0
    pub specimen: usize,
}

impl Sample {
    /// False at λ = 1 with P = 0: every law passes through this point, and the test was zeroed there.
    pub fn is_informative(&self) -> bool {
        !self.is_at_rest() || self.stress != 0.0
    }

    /// Whether the strain is zero: every law is stress-free there, and a measured stress is an error of the machine.
    pub fn is_at_rest(&self) -> bool {
        self.stretch == 1.0 && self.second == 1.0
    }

    /// The stretch \[–\] in the plane of the test that is farthest from rest, by |ln λ|. It is the same for both directions of a biaxial state, so
    /// that a range includes both or neither.
    pub fn reach(&self) -> f64 {
        let amount = |l: f64| (l.ln().abs(), l);
        if amount(self.second) > amount(self.stretch) { self.second } else { self.stretch }
    }

    /// Principal stretches \[–\] (loaded, second, free) if the free directions follow this Poisson's ratio, ½ for incompressible materials.
    pub fn stretches(&self, nu: f64) -> [f64; 3] {
        self.mode.stretches_with(nu, self.stretch, self.second)
    }
}

/// Share of the largest |ln λ| on one side of rest from which on data points on the other side count as a test there; less is noise or the zero of
/// the machine \[–\]
const SIDE: f64 = 0.1;

/// Whether samples are in compression, and whether any are in tension; those near rest count for neither.
pub fn sides<'a>(samples: impl IntoIterator<Item = &'a Sample>) -> [bool; 2] {
    let amounts = samples.into_iter().map(|s| s.reach().ln());
    let [low, high] = amounts.fold([0.0_f64; 2], |[low, high], e| [low.min(e), high.max(e)]);
    let least = SIDE * high.max(-low);
    [-low > least, high > least]
}

/// A mode with a side of rest: tension and compression are two tests, shear in both directions is one.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Serialize, Deserialize)]
pub struct Test {
    pub mode: Mode,
    pub compression: bool,
    /// Whether the mode was tested on the other side of rest, too
    pub both: bool,
}

impl Test {
    /// Whether tension and compression are different tests; shear in both directions is one test, and so is a biaxial one.
    pub fn has_sides(self) -> bool {
        Mode::PULLED.contains(&self.mode)
    }
}

impl fmt::Display for Test {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let side = match (self.both, self.compression) {
            (false, _) => "",
            (true, false) => " in tension",
            (true, true) => " in compression",
        };
        write!(f, "{}{side}", self.mode)
    }
}

/// The test of each sample. Samples of a specimen that noise places on the other side of rest belong to the side of the other samples.
pub fn tests(samples: &[Sample]) -> Vec<Test> {
    let mut curves: BTreeMap<(usize, Mode), Vec<&Sample>> = BTreeMap::new();
    samples.iter().for_each(|s| curves.entry((s.specimen, s.mode)).or_default().push(s));
    let sides: BTreeMap<(usize, Mode), [bool; 2]> = curves
        .into_iter()
        .map(|(of, own)| (of, sides(own)))
        .filter(|((_, mode), _)| Mode::PULLED.contains(mode))
        .collect();
    let has = |mode: Mode, side: usize| sides.iter().any(|((_, own), sides)| *own == mode && sides[side]);
    let both = Mode::ALL.map(|mode| has(mode, 0) && has(mode, 1));
    let one = |s: &Sample| {
        let compression = match sides.get(&(s.specimen, s.mode)) {
            Some([true, true]) => s.stretch < 1.0,
            Some([true, false]) => true,
            _ => false,
        };
        Test { mode: s.mode, compression, both: both[s.mode as usize] }
    };
    samples.iter().map(one).collect()
}

/// The samples of each test.
pub fn by_test(samples: &[Sample]) -> BTreeMap<Test, Vec<Sample>> {
    let mut found: BTreeMap<Test, Vec<Sample>> = BTreeMap::new();
    tests(samples).into_iter().zip(samples).for_each(|(test, s)| found.entry(test).or_default().push(*s));
    found
}

/// The recorded quantities of the machine in one row, unchanged, if the table has them.
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct RawRow {
    /// Line of the file, counted from 1
    pub line: u64,
    /// Index of its file, counted from 0
    pub specimen: usize,
    /// Time in the unit of the table
    pub time: Option<f64>,
    /// \[m\]
    pub displacement: Option<f64>,
    /// \[N\]
    pub force: Option<f64>,
}
