//! Least squares over four or more meshes, after L. Eça & M. Hoekstra, A procedure for the estimation of the numerical
//! uncertainty of CFD calculations based on grid refinement studies, J. Comput. Phys. 262 (2014) 104–130.
//!
//! ```text
//! models (formal order q; the paper has q = 2)   φ = φ₀ + αh^p;   αh^{q/2};   αh^q;   αh^{q/2} + βh^q
//! σ = √(Σ n·wᵢ (φᵢ − fit(hᵢ))² / (n − m)),   wᵢ = 1/n  or  wᵢ = hᵢ⁻¹/Σ hⱼ⁻¹,   m unknowns
//! Δφ = (max φ − min φ)/(n − 1),   ε(h) = |fit(h) − φ₀|
//! U = Fs·ε + σ + |φ − fit|             if σ < Δφ, Fs = 1.25 for ½ ≤ p < 1.05·q, else 3
//! U = 3(σ/Δφ)(ε + σ + |φ − fit|)       if σ ≥ Δφ
//! ```
//!
//! The model αh^p is kept while its p is sane. An order above the sane range is replaced by αh^{q/2} or αh^q, one below ½ by any of the three models
//! with fixed exponents. Each is fitted with and without weights, and the fit with the smallest σ is taken.

use crate::study::estimate::richardson::{CAUTIOUS_FACTOR, LEAST_ORDER, ORDER_SLACK, safety_factor};
use serde::Serialize;

/// The chosen model, and its uncertainty for each mesh.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Fit {
    /// `αh^p`, `αh`, `αh²`, `αh+βh²` (with the formal order in place of 2)
    pub model: String,
    pub weighted: bool,
    pub f0: f64,
    pub alpha: f64,
    /// Coefficient of the second power; 0 if there is only one
    pub beta: f64,
    /// Exponents of α and β
    pub powers: (f64, f64),
    /// Order of the free fit αh^p, whichever model was chosen
    pub p: f64,
    /// Standard deviation of the fit \[unit of φ\]
    pub sigma: f64,
    /// Δφ \[unit of φ\]
    pub range: f64,
    pub fs: f64,
    /// Whether σ < Δφ and p is sane
    pub good: bool,
    /// \[meshes\] U of each value \[unit of φ\]
    pub uncertainty: Vec<f64>,
}

impl Fit {
    /// Whether the order of the model is that of the free fit and lies between ½ and 1.05 times the formal one.
    pub fn has_sane_order(&self) -> bool {
        self.fs < CAUTIOUS_FACTOR
    }

    /// φ at size h, in the unit of the fit.
    pub fn at(&self, h: f64) -> f64 {
        self.f0
            + self.alpha * h.powf(self.powers.0)
            + if self.beta == 0.0 { 0.0 } else { self.beta * h.powf(self.powers.1) }
    }

    /// ε(h) = |fit − φ₀|.
    pub fn error(&self, h: f64) -> f64 {
        (self.at(h) - self.f0).abs()
    }
}

struct Candidate {
    c: [f64; 3],
    powers: Vec<f64>,
    weighted: bool,
    sigma: f64,
}

/// Fits the values `f` on four or more meshes of sizes `h`, in any order, with the formal order `q`. `None` with fewer meshes or equal sizes.
pub fn least_squares(h: &[f64], f: &[f64], q: f64) -> Option<Fit> {
    let n = h.len();
    if n < 4 || n != f.len() {
        return None;
    }
    // Sizes relative to the finest keep the unit of f for α and β and the scaling of the normal equations.
    let h1 = h.iter().copied().fold(f64::INFINITY, f64::min);
    let x: Vec<f64> = h.iter().map(|v| v / h1).collect();
    let (lo, hi) = f.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let range = (hi - lo) / (n - 1) as f64;
    if x.iter().all(|v| *v < 1.0 + 1e-6) || range == 0.0 {
        return None;
    }
    let free: Vec<Candidate> = [false, true].into_iter().filter_map(|w| free_order(&x, f, w, q)).collect();
    let sane = |c: &&Candidate| (LEAST_ORDER..ORDER_SLACK * q).contains(&c.powers[0]);
    let smallest = |a: &&Candidate, b: &&Candidate| a.sigma.total_cmp(&b.sigma);
    let p_of = free.iter().min_by(smallest)?.powers[0];
    let others: Vec<Candidate>;
    let (chosen, p, sane_p) = match free.iter().filter(sane).min_by(smallest) {
        Some(c) => (c, c.powers[0], true),
        None => {
            let mut models = vec![vec![q / 2.0], vec![q]];
            if p_of < LEAST_ORDER {
                models.push(vec![q / 2.0, q]);
            }
            others = models.iter().flat_map(|m| [false, true].map(|w| linear(&x, f, m, w))).flatten().collect();
            (others.iter().min_by(smallest)?, p_of, false)
        }
    };
    let good = sane_p && chosen.sigma < range;
    let fs = safety_factor(sane_p);
    let scale = |k: usize| chosen.powers.get(k).map_or(0.0, |p| chosen.c[k + 1] / h1.powf(*p));
    let mut fit = Fit {
        model: model_name(&chosen.powers, sane_p, q),
        weighted: chosen.weighted,
        f0: chosen.c[0],
        alpha: scale(0),
        beta: scale(1),
        powers: (chosen.powers[0], chosen.powers.get(1).copied().unwrap_or(0.0)),
        p,
        sigma: chosen.sigma,
        range,
        fs,
        good,
        uncertainty: vec![],
    };
    fit.uncertainty = h
        .iter()
        .zip(f)
        .map(|(h, f)| {
            let (e, off) = (fit.error(*h), (f - fit.at(*h)).abs());
            if fit.sigma < range {
                fs * e + fit.sigma + off
            } else {
                CAUTIOUS_FACTOR * fit.sigma / range * (e + fit.sigma + off)
            }
        })
        .collect();
    Some(fit)
}

fn model_name(powers: &[f64], free: bool, q: f64) -> String {
    let power = |p: f64| match p as u32 {
        1 => "h".to_string(),
        2 => "h²".to_string(),
        4 => "h⁴".to_string(),
        _ => format!("h^{p}"),
    };
    match (free, powers.len()) {
        (true, _) => "αh^p".to_string(),
        (_, 1) => format!("α{}", power(powers[0])),
        _ => format!("α{}+β{}", power(q / 2.0), power(q)),
    }
}

/// Fits αh^p by a scan and golden-section search over p; φ₀ and α are linear.
fn free_order(x: &[f64], f: &[f64], weighted: bool, q: f64) -> Option<Candidate> {
    let at = |p: f64| linear(x, f, &[p], weighted).map(|c| c.sigma).unwrap_or(f64::INFINITY);
    let (step, top) = (0.05, 2.0 * q + 4.0);
    let count = (top / step) as usize;
    let best = (1..=count).map(|k| k as f64 * step).min_by(|a, b| at(*a).total_cmp(&at(*b)))?;
    let (mut a, mut b) = ((best - step).max(1e-3), best + step);
    let g = 0.5 * (5.0_f64.sqrt() - 1.0);
    while b - a > 1e-12 {
        let (c, d) = (b - g * (b - a), a + g * (b - a));
        if at(c) < at(d) {
            b = d
        } else {
            a = c
        }
        if b - a < 1e-9 * b {
            break;
        }
    }
    let mut c = linear(x, f, &[0.5 * (a + b)], weighted)?;
    // Three unknowns: φ₀, α, p
    let n = x.len() as f64;
    c.sigma *= ((n - 2.0) / (n - 3.0)).sqrt();
    Some(c)
}

/// Fits φ₀ and the coefficients of the given powers, by weighted normal equations with centred columns.
fn linear(x: &[f64], f: &[f64], powers: &[f64], weighted: bool) -> Option<Candidate> {
    let n = x.len();
    let total: f64 = x.iter().map(|v| 1.0 / v).sum();
    let w: Vec<f64> = x.iter().map(|v| if weighted { 1.0 / (v * total) } else { 1.0 / n as f64 }).collect();
    let mean = |y: &[f64]| y.iter().zip(&w).map(|(y, w)| y * w).sum::<f64>();
    let columns: Vec<Vec<f64>> = powers.iter().map(|p| x.iter().map(|v| v.powf(*p)).collect()).collect();
    let means: Vec<f64> = columns.iter().map(|c| mean(c)).collect();
    let f_mean = mean(f);
    let dot = |i: usize, y: &[f64], y_mean: f64| -> f64 {
        (0..n).map(|k| w[k] * (columns[i][k] - means[i]) * (y[k] - y_mean)).sum()
    };
    let mut c = [0.0; 3];
    match powers.len() {
        1 => c[1] = dot(0, f, f_mean) / dot(0, &columns[0], means[0]),
        _ => {
            let (a, b, d) =
                (dot(0, &columns[0], means[0]), dot(0, &columns[1], means[1]), dot(1, &columns[1], means[1]));
            let (u, v) = (dot(0, f, f_mean), dot(1, f, f_mean));
            let det = a * d - b * b;
            c[1] = (u * d - v * b) / det;
            c[2] = (a * v - b * u) / det;
        }
    }
    c[0] = f_mean - (0..powers.len()).map(|k| c[k + 1] * means[k]).sum::<f64>();
    let square: f64 = (0..n)
        .map(|k| {
            let fit = c[0] + (0..powers.len()).map(|j| c[j + 1] * columns[j][k]).sum::<f64>();
            n as f64 * w[k] * (f[k] - fit).powi(2)
        })
        .sum();
    let unknowns = powers.len() + 1;
    let sigma = (square / (n - unknowns) as f64).sqrt();
    sigma.is_finite().then_some(Candidate { c, powers: powers.to_vec(), weighted, sigma })
}
