//! Energy that appears without work in the dynamic stages of a run.
//!
//! Elastic and kinetic energy can rise at most by the work done and by the energy that relaxing parts release. Numerical damping and dissipation only reduce
//! them. Any energy beyond that comes from the integrator, whose steps are too long for the motion.
//!
//! Dissipated energy is not added: its sum over long steps is far from the integral, so that no finding is based on it.

use crate::scene::record::recorder::Energies;

/// Energy without work, relative to the largest energy of a stage, above which it is a finding \[–\]. Work is a sum over steps, which in sound runs is off by
/// far less (`tests/solver/energy.rs`).
const FINDING: f64 = 0.1;
/// Number of steps with such an energy that make a finding: a single step far longer than the motion overshoots after a jump of a load, and returns.
const STEPS: usize = 3;
/// Energy relative to the energies before a stage below which that of the stage is rounding \[–\].
const ROUNDING: f64 = 1e-6;
/// Energy below which a body is at rest \[J\]: of the order of the thermal energy of a molecule.
const REST: f64 = 1e-20;

/// The largest energy without work in one stage.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct EnergyFromNothing {
    /// End of the last of three steps with at least this energy \[s\]
    pub t: f64,
    /// Their elastic and kinetic energy beyond that at the start of the stage, the work, and the energy that relaxing parts released \[J\]
    pub excess: f64,
    /// Largest energy of the stage: elastic and kinetic, or work \[J\]
    pub largest: f64,
}

impl EnergyFromNothing {
    /// The excess relative to the largest energy of the stage \[–\].
    pub fn share(&self) -> f64 {
        if self.excess > 0.0 { self.excess / self.largest } else { 0.0 }
    }
}

/// Follows the energies of a run, stage by stage.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub(in crate::scene) struct EnergyGrowth {
    /// Energies at the start of the stage
    start: Energies,
    /// The excesses above that of the stage, in descending order \[J\]
    above: [f64; STEPS - 1],
    stage: EnergyFromNothing,
    /// The worst of the previous stages
    worst: EnergyFromNothing,
}

impl EnergyGrowth {
    /// Length of [`EnergyGrowth::numbers`].
    pub const NUMBERS: usize = 12;

    /// Begins a stage at these energies.
    pub fn begin(&mut self, energies: Energies) {
        let stage = EnergyFromNothing { largest: REST.max(ROUNDING * largest(energies)), ..Default::default() };
        *self = Self { start: energies, above: [0.0; STEPS - 1], stage, worst: self.worst() };
    }

    /// Adds the energies at the end of a step of a dynamic stage.
    pub fn add(&mut self, t: f64, now: Energies) {
        let Energies { elastic, kinetic, dissipated, work } = self.start;
        let (work, given_back) = (now.work - work, (dissipated - now.dissipated).max(0.0));
        self.stage.largest = self.stage.largest.max(largest(Energies { work, ..now }));
        let excess = now.elastic + now.kinetic - elastic - kinetic - work - given_back;
        if excess > self.stage.excess {
            let [first, second] = self.above;
            let mut most = [first, second, excess];
            most.sort_by(|a, b| b.total_cmp(a));
            self.above = [most[0], most[1]];
            (self.stage.t, self.stage.excess) = (t, most[2]);
        }
    }

    fn worst(&self) -> EnergyFromNothing {
        if self.stage.share() > self.worst.share() { self.stage } else { self.worst }
    }

    /// The worst stage, if its energy without work is a finding.
    pub fn finding(&self) -> Option<EnergyFromNothing> {
        Some(self.worst()).filter(|worst| worst.share() > FINDING)
    }

    /// Its whole state as numbers.
    pub fn numbers(&self) -> [f64; Self::NUMBERS] {
        let Energies { elastic, kinetic, dissipated, work } = self.start;
        let [[a, b, c], [d, e, f]] = [self.stage, self.worst].map(|of| [of.t, of.excess, of.largest]);
        let [first, second] = self.above;
        [elastic, kinetic, dissipated, work, first, second, a, b, c, d, e, f]
    }

    /// Restores the state from its numbers.
    pub fn of_numbers(numbers: [f64; Self::NUMBERS]) -> Self {
        let [elastic, kinetic, dissipated, work, first, second, a, b, c, d, e, f] = numbers;
        let of = |t, excess, largest| EnergyFromNothing { t, excess, largest };
        let start = Energies { elastic, kinetic, dissipated, work };
        Self { start, above: [first, second], stage: of(a, b, c), worst: of(d, e, f) }
    }
}

/// The larger of the stored energy and the work \[J\].
fn largest(Energies { elastic, kinetic, work, .. }: Energies) -> f64 {
    (elastic.abs() + kinetic).max(work.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds steps with these elastic, kinetic and dissipated energies, and this work.
    fn add(growth: &mut EnergyGrowth, steps: &[[f64; 4]]) {
        for [elastic, kinetic, dissipated, work] in steps.iter().copied() {
            growth.add(growth.stage.t + 1.0, Energies { elastic, kinetic, dissipated, work });
        }
    }

    fn stage(start: [f64; 4], steps: &[[f64; 4]]) -> EnergyGrowth {
        let mut growth = EnergyGrowth::default();
        let [elastic, kinetic, dissipated, work] = start;
        growth.begin(Energies { elastic, kinetic, dissipated, work });
        add(&mut growth, steps);
        growth
    }

    #[test]
    fn only_energy_that_nothing_put_in_counts() {
        let start = [1.0, 0.0, 5.0, 6.0];
        // Oscillation, a load, numerical damping, a dissipation that is overestimated, and relaxing parts that release energy
        let sound = [[0.5, 0.5, 5.0, 6.0], [2.0, 1.0, 5.5, 8.5], [0.1, 0.1, 9.0, 8.5], [2.0, 3.0, 3.5, 8.5]];
        for one in sound {
            assert_eq!(stage(start, &[one; 5]).finding(), None, "{one:?}");
        }
        let found = stage(start, &[[3.5, 2.0, 5.5, 8.5]; 3]).finding().expect("it has 5.5 J and not 3.5 J");
        assert_eq!([found.excess, found.largest], [2.0, 5.5]);
    }

    #[test]
    fn a_step_that_overshoots_is_no_finding() {
        let (high, low) = ([0.0, 3.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0]);
        assert_eq!(stage([0.0; 4], &[high, low, low, high, low]).finding(), None);
        assert!(stage([0.0; 4], &[high, low, low, high, low, high, low]).finding().is_some());
    }

    #[test]
    fn a_later_stage_hides_nothing_and_starts_anew() {
        let mut growth = stage([0.0, 1.0, 0.0, 0.0], &[[0.0, 1.5, 0.0, 0.0]; 3]);
        let first = growth.finding();
        assert!(first.is_some());
        growth.begin(Energies::default());
        add(&mut growth, &[[50.0, 50.0, 0.0, 100.0]; 3]);
        assert_eq!(growth.finding(), first);
        assert_eq!(EnergyGrowth::of_numbers(growth.numbers()), growth);
        let rest = stage([0.0, 0.0, 0.0, 100.0], &[[0.0, 1e-12, 0.0, 100.0]; 3]);
        assert_eq!(rest.finding(), None, "rounding of a body at rest");
        let mut lost = stage([0.0, 10.0, 0.0, 0.0], &[[0.0, 1.0, 0.0, 0.0]; 3]);
        lost.begin(Energies { kinetic: 1.0, ..Energies::default() });
        add(&mut lost, &[[0.0, 2.0, 0.0, 0.0]; 3]);
        assert!(lost.finding().is_some(), "what one stage lost is no reserve of the next one");
    }
}
