//! Softening of a rubber by the largest stored energy in its history (Mullins effect), as pseudo-elasticity.
//!
//! With the isochoric energy W at the state and its largest value so far W_m ≥ W, the isochoric stress of the law is multiplied by
//!
//! η = 1 − (1/r) erf((W_m − W)/(m + βW_m))
//!
//! On the first loading W = W_m and η = 1. On unloading and reloading below W_m the stress is smaller, and the energy ∫₀^{W_m} (1 − η) dW is lost.
//!
//! Source: Ogden & Roxburgh, Proc. R. Soc. Lond. A 455, 1999, 2861–2877, eq. 3.20 to 3.27, with m + βW_m as in Abaqus (`*MULLINS EFFECT`); β = 0
//! gives the model of the paper.

use libm::erf;
use std::f64::consts::PI;

/// Constants of softening.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Softening {
    /// r \[–\]: at most the share 1/r of the stress is lost
    pub r: f64,
    /// m \[Pa\]: constant part of the energy density that scales W_m − W
    pub m: f64,
    /// β \[–\]: part of that energy density that is proportional to W_m, as a share of W_m
    pub beta: f64,
}

/// Constants that do not describe softening.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum SofteningError {
    #[error(
        "r = {r} is not above 1: more than the whole stress would be lost; 1/r is the largest share of the stress that is lost"
    )]
    Share { r: f64 },
    #[error("m = {m} Pa is not a density of energy of zero or more")]
    Energy { m: f64 },
    #[error("beta = {beta} is not a number of zero or more")]
    Beta { beta: f64 },
    #[error(
        "m and beta are both zero: give at least one of them a positive value, m for the softening of small stretches, beta for that in proportion to the largest energy"
    )]
    Both,
}

/// η and its derivatives.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Softened {
    pub eta: f64,
    /// ∂η/∂W \[1/Pa\]
    pub by_energy: f64,
    /// ∂η/∂W_m \[1/Pa\]
    pub by_peak: f64,
}

/// ∫₀ˣ erf s ds = x erf x + (e^{−x²} − 1)/√π.
fn erf_integral(x: f64) -> f64 {
    x * erf(x) + (-x * x).exp_m1() / PI.sqrt()
}

impl Softening {
    /// Refuses constants that are out of range.
    pub fn new(r: f64, m: f64, beta: f64) -> Result<Self, SofteningError> {
        match () {
            () if !(r > 1.0 && r.is_finite()) => Err(SofteningError::Share { r }),
            () if !(m >= 0.0 && m.is_finite()) => Err(SofteningError::Energy { m }),
            () if !(beta >= 0.0 && beta.is_finite()) => Err(SofteningError::Beta { beta }),
            () if m == 0.0 && beta == 0.0 => Err(SofteningError::Both),
            () => Ok(Self { r, m, beta }),
        }
    }

    fn scale(&self, peak: f64) -> f64 {
        self.m + self.beta * peak
    }

    /// η at W below W_m; at and above it η = 1, with derivatives of zero.
    pub fn at(&self, energy: f64, peak: f64) -> Softened {
        match energy >= peak {
            true => Softened { eta: 1.0, by_energy: 0.0, by_peak: 0.0 },
            false => self.continued(energy, peak),
        }
    }

    /// η continued smoothly above W_m, by the same formula as below it.
    pub fn continued(&self, energy: f64, peak: f64) -> Softened {
        let d = self.scale(peak);
        if d <= 0.0 {
            return Softened { eta: 1.0, by_energy: 0.0, by_peak: 0.0 };
        }
        let x = (peak - energy) / d;
        let slope = 2.0 / PI.sqrt() * (-x * x).exp() / (self.r * d);
        Softened { eta: 1.0 - erf(x) / self.r, by_energy: slope, by_peak: -slope * (1.0 - self.beta * x) }
    }

    /// ∫₀^W (1 − η) dW \[J/m³\] on unloading from W_m to W.
    pub fn missing(&self, energy: f64, peak: f64) -> f64 {
        let d = self.scale(peak);
        if d <= 0.0 {
            return 0.0;
        }
        d / self.r * (erf_integral(peak / d) - erf_integral((peak - energy.min(peak)) / d))
    }

    /// Energy lost since the beginning \[J/m³\] at a point whose largest energy was W_m.
    pub fn lost(&self, peak: f64) -> f64 {
        self.missing(peak, peak)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOFT: [Softening; 3] = [
        Softening { r: 1.6, m: 2e3, beta: 0.1 },
        Softening { r: 3.0, m: 500.0, beta: 0.0 },
        Softening { r: 1.1, m: 0.0, beta: 0.4 },
    ];

    /// Central differences with steps of 1e-5 W_m have an error of (1e-5)²/6 times a third derivative of at most (W_m/m)³ = 18³: 1e-7.
    #[test]
    fn derivatives_are_those_of_differences() {
        for soft in SOFT {
            for (w, peak) in [(100.0, 9e3), (4e3, 9e3), (8.9e3, 9e3), (1.0, 20.0)] {
                let (h, found) = (1e-5 * peak, soft.at(w, peak));
                let by_w = (soft.at(w + h, peak).eta - soft.at(w - h, peak).eta) / (2.0 * h);
                let by_peak = (soft.at(w, peak + h).eta - soft.at(w, peak - h).eta) / (2.0 * h);
                let missing = (soft.missing(w + h, peak) - soft.missing(w - h, peak)) / (2.0 * h);
                assert!((found.by_energy - by_w).abs() * peak < 1e-7, "{soft:?} {w} {peak}");
                assert!((found.by_peak - by_peak).abs() * peak < 1e-7, "{soft:?} {w} {peak}");
                assert!((1.0 - found.eta - missing).abs() < 1e-8, "{soft:?} {w} {peak}");
                assert!(found.eta >= 1.0 - 1.0 / soft.r && found.eta < 1.0 && found.by_peak <= 0.0);
            }
        }
    }

    /// The lost energy grows with W_m and stays below W_m/r.
    #[test]
    fn a_larger_load_loses_more() {
        for soft in SOFT {
            let lost: Vec<f64> = (0..50).map(|k| soft.lost(300.0 * f64::from(k))).collect();
            assert!(lost[0] == 0.0 && lost.windows(2).all(|w| w[1] > w[0]), "{soft:?}");
            assert!(lost.iter().zip(0..).all(|(l, k)| *l <= 300.0 * f64::from(k) / soft.r));
        }
    }

    /// The integral by Simpson's rule with 2000 intervals: (2/2000)⁴/180 of the fourth derivative of at most 8 leaves 1e-13.
    #[test]
    fn integral_by_simpson() {
        let (n, x) = (2000, 2.0);
        let weight = |k: i32| if k == 0 || k == n { 1.0 } else { 2.0 + 2.0 * f64::from(k % 2) };
        let sum: f64 = (0..=n).map(|k| weight(k) * erf(x * f64::from(k) / f64::from(n))).sum();
        assert!((erf_integral(x) - sum * x / f64::from(n) / 3.0).abs() < 1e-12);
    }

    #[test]
    fn refuses_what_is_no_softening() {
        assert_eq!(Softening::new(1.0, 1.0, 0.0), Err(SofteningError::Share { r: 1.0 }));
        assert!(matches!(Softening::new(f64::NAN, 1.0, 0.0), Err(SofteningError::Share { .. })));
        assert_eq!(Softening::new(2.0, -1.0, 0.0), Err(SofteningError::Energy { m: -1.0 }));
        assert_eq!(Softening::new(2.0, 1.0, f64::INFINITY), Err(SofteningError::Beta { beta: f64::INFINITY }));
        assert_eq!(Softening::new(2.0, 0.0, 0.0), Err(SofteningError::Both));
    }
}
