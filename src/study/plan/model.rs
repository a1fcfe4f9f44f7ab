//! Predicts a run that has not been made from pilots: its error by a power law in h, its time from counted work.
//!
//! ```text
//! error    e(h) = α hᵖ through |f(hᵢ) − f*|/|f*| of the pilots of one element; if these do not decrease and are within U(f*), their largest
//! time     T = n k (a N + r) + F Φ(flops) + s nnz(L)     per run, scaled to CPU seconds
//! ```
//!
//! Here n is the number of steps, k of Newton iterations per step, N of cells, F of factorisations and s of solves; the numbers per step are those of
//! the largest pilot. So are a and r \[s\], for one iteration and cell, and the time per solve; Φ is the time of one factorisation as a power law of
//! its operations through all pilots of the element, since large supernodes run faster. The flops and nnz(L) of the run itself are counted on its own
//! mesh by symbolic factorisation. Limits: one power of h; a number of iterations that grows with the mesh is not accounted for.

use crate::study::estimate::power_law::{PowerLaw, power_law};
use crate::study::estimate::richardson::{ORDER_SLACK, ROUNDING};
use crate::study::store::record::CaseRecord;
use serde::Serialize;

/// Smallest number of meshes for which an element has a limit and an error law: two values agree by chance too easily.
pub const LEAST_PILOTS: usize = 3;

/// Size of a run, counted before the run is made.
#[derive(Serialize, Clone, Copy, Debug, PartialEq)]
pub struct Counted {
    pub cells: usize,
    pub dofs: usize,
    pub h_m: f64,
    pub steps: usize,
    pub factor_nnz: usize,
    pub factor_flops: f64,
}

/// Model of the time of runs with one element.
#[derive(Clone, Debug)]
pub struct Clock {
    /// Time of one factorisation versus its operations
    factorisation: PowerLaw,
    /// Newton iterations per step
    iterations: f64,
    factorisations: f64,
    solves: f64,
    /// Assembly and the rest, per iteration and cell \[s\]
    cell_s: f64,
    /// Time of a solve per entry of L \[s\]
    entry_s: f64,
}

impl Clock {
    /// Builds the model from the pilots of one element; `None` with fewer than two meshes.
    pub fn new(pilots: &[&CaseRecord]) -> Option<Self> {
        let one = |r: &CaseRecord| {
            let seconds = r.phases.factorisation_s * quiet(r) / r.work.factorisations.max(1) as f64;
            (r.work.factor_flops, seconds)
        };
        let factorisation = power_law(&pilots.iter().map(|r| one(r)).collect::<Vec<_>>())?;
        let largest = pilots.iter().max_by_key(|r| r.mesh.cells)?;
        let (steps, iterations) = (largest.steps.max(1) as f64, largest.all_iterations().max(1) as f64);
        let linear = largest.phases.factorisation_s + largest.phases.solve_s;
        let solves = largest.work.solves.max(1) as f64;
        Some(Self {
            factorisation,
            iterations: iterations / steps,
            factorisations: largest.work.factorisations as f64 / steps,
            solves: solves / steps,
            cell_s: (largest.wall_s - linear).max(0.0) * quiet(largest) / (iterations * largest.mesh.cells as f64),
            entry_s: largest.phases.solve_s * quiet(largest) / (solves * largest.factor_nnz as f64),
        })
    }

    /// Predicts the CPU seconds of a run.
    pub fn predict(&self, run: &Counted) -> f64 {
        let step = self.iterations * self.cell_s * run.cells as f64
            + self.factorisations * self.factorisation.at(run.factor_flops)
            + self.solves * self.entry_s * run.factor_nnz as f64;
        run.steps as f64 * step
    }
}

/// Factor from wall to CPU seconds of a run, at most 1: phases are wall seconds, and CPU seconds are what an undisturbed machine would need.
fn quiet(r: &CaseRecord) -> f64 {
    if r.wall_s > 0.0 { (r.cpu_s / r.wall_s).min(1.0) } else { 1.0 }
}

/// Fits e(h) of one element and quantity through its pilots, for a limit that is known to `known` \[–\]. Errors that do not decrease with h are
/// attributed to the limit if they are within `known`, and so are values that agree with it: such errors count as `known`, or as the largest error if
/// that is less, so that the law is constant if all errors are within `known`. `None` if the error does not decrease even then.
pub fn error_law(errors: &[(f64, f64)], formal: f64, known: f64) -> Option<PowerLaw> {
    let largest = errors.iter().map(|e| e.1).fold(ROUNDING, f64::max);
    let known = known.max(ROUNDING);
    let told: Vec<(f64, f64)> = errors.iter().map(|(h, e)| (*h, e.max(known.min(largest)))).collect();
    falling(errors, formal).or_else(|| if largest <= known { law(&told) } else { falling(&told, formal) })
}

/// Fits a power law that decreases with h. Errors that decrease faster than the formal order allows belong to values that cross the limit: the law then
/// has the formal order and passes through the largest of the errors scaled with it.
fn falling(errors: &[(f64, f64)], formal: f64) -> Option<PowerLaw> {
    let law = law(errors).filter(|g| g.q > 0.0)?;
    if law.q <= ORDER_SLACK * formal {
        return Some(law);
    }
    let largest = errors.iter().map(|(h, e)| e / h.powf(formal)).fold(0.0, f64::max);
    power_law(&errors.iter().map(|(h, _)| (*h, largest * h.powf(formal))).collect::<Vec<_>>())
}

fn law(errors: &[(f64, f64)]) -> Option<PowerLaw> {
    power_law(errors).filter(|g| g.points >= LEAST_PILOTS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::store::record::PhaseRecord;

    /// A machine of 1 Gflop/s that speeds up with the power ¹⁄₁₀, takes 1 µs per cell and iteration and 2 ns per entry, and is slowed down by half.
    fn record(cells: usize) -> CaseRecord {
        let mut r = CaseRecord::default();
        let n = cells as f64;
        (r.mesh.cells, r.steps, r.newton_iterations) = (cells, 10, 40);
        (r.work.factorisations, r.work.solves) = (20, 50);
        (r.work.factor_flops, r.factor_nnz) = (1e3 * n * n, 100 * cells);
        let (f, s, a) = (20.0 * time(r.work.factor_flops), 50.0 * 2e-9 * r.factor_nnz as f64, 40.0 * 1e-6 * n);
        r.cpu_s = f + s + a;
        r.wall_s = 1.5 * r.cpu_s;
        r.phases = PhaseRecord {
            assembly_s: 1.2 * a,
            factorisation_s: 1.5 * f,
            solve_s: 1.5 * s,
            contact_forces_s: 0.0,
            output_s: 0.0,
            build_s: 0.0,
        };
        r
    }

    fn time(flops: f64) -> f64 {
        1e-9 * flops * (flops / 1e9).powf(-0.1)
    }

    #[test]
    fn counted_work_gives_the_time_of_a_larger_run() {
        let pilots = [record(1000), record(2000), record(4000)];
        let clock = Clock::new(&pilots.iter().collect::<Vec<_>>()).expect("three pilots");
        let (n, steps) = (30_000, 25);
        let run = Counted {
            cells: n,
            dofs: 3 * n,
            h_m: 1e-3,
            steps,
            factor_nnz: 100 * n,
            factor_flops: 1e3 * (n as f64).powi(2),
        };
        let exact =
            steps as f64 * (2.0 * time(run.factor_flops) + 5.0 * 2e-9 * run.factor_nnz as f64 + 4.0 * 1e-6 * n as f64);
        // The model is exact here; only rounding remains
        assert!((clock.predict(&run) / exact - 1.0).abs() < 1e-9, "{} for {exact}", clock.predict(&run));
    }

    #[test]
    fn an_error_that_does_not_fall_has_no_law() {
        let law = error_law(&[(4.0, 0.16), (2.0, 0.04), (1.0, 0.01)], 2.0, 0.0).expect("order 2");
        assert!((law.q - 2.0).abs() < 1e-12 && (law.at(0.5) - 0.0025).abs() < 1e-12);
        assert!(error_law(&[(4.0, 0.01), (2.0, 0.02), (1.0, 0.04)], 2.0, 0.01).is_none());
        assert!(error_law(&[(4.0, 0.16), (2.0, 0.04)], 2.0, 0.0).is_none(), "two points show no law");
    }

    #[test]
    fn errors_that_the_limit_hides_are_constant() {
        // The limit is the value of the finest mesh
        let hidden = [(4.0, 0.0021), (3.0, 0.0014), (2.0, 0.0025), (1.0, 0.0)];
        for known in [0.0075, 0.0025] {
            let law = error_law(&hidden, 2.0, known).expect("nothing is told of them");
            assert!([4.0, 1.0, 0.1].iter().all(|h| (law.at(*h) / 0.0025 - 1.0).abs() < 1e-12), "{law:?}");
        }
        // The largest error is resolved, and the law falls to what is known
        let law = error_law(&[(4.0, 0.04), (2.0, 0.02), (1.0, 0.0)], 2.0, 0.01).expect("it falls");
        assert!((law.q - 1.0).abs() < 1e-12 && (law.at(1.0) - 0.01).abs() < 1e-12, "{law:?}");
        let equal = error_law(&[(4.0, 0.0), (2.0, 0.0), (1.0, 0.0)], 2.0, 0.0).expect("every mesh has the limit");
        assert!(equal.at(0.5) <= 1.001 * ROUNDING, "{equal:?}");
    }

    #[test]
    fn a_value_that_crosses_its_limit_does_not_make_finer_meshes_exact() {
        let law = error_law(&[(4.0, 0.16), (2.0, 0.04), (1.0, 1e-6)], 2.0, 0.0).expect("it falls");
        assert!((law.q - 2.0).abs() < 1e-12 && (law.at(0.5) - 0.0025).abs() < 1e-12, "{law:?}");
    }
}
