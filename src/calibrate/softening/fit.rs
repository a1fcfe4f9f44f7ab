//! Constants of softening by least squares: P = η(W(λ), W_m) P_law(λ), with the law of the first loading.

use super::error::SofteningFitError;
use super::path::divide;
use super::result::{SofteningFit, summary};
use crate::calibrate::judgement::errors;
use crate::calibrate::judgement::statistics::t_quantile;
use crate::calibrate::{
    Bounded, Experiment, FitOptions, FitRequest, FitResult, Model, Sample, SlackChoice, fit_experiment,
};
use crate::material::{Law, Softening, Want};
use crate::math::tensor::Mat3;
use libm::erf;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::f64::consts::PI;

/// Rows below the largest stretch that a fit needs
const ROWS: usize = 6;
/// Peaks W_m of this ratio tell m and β apart \[–\]
const APART: f64 = 1.2;
/// Iterations of a search, and the relative decrease of the sum of squares that ends it
const ITERATIONS: usize = 200;
const SETTLED: f64 = 1e-14;
/// Largest 1/r \[–\]: r stays above 1
const MOST: f64 = 0.999;
/// Part of the stress below which the residual is rounding \[–\]
const ROUNDING: f64 = 1e-9;

/// A row below the largest stretch, with what the law says about it.
struct Point {
    sample: Sample,
    /// Stress of the first loading at this stretch \[Pa\]
    stress: f64,
    /// W and W_m \[J/m³\]
    energy: f64,
    peak: f64,
}

/// Reads the table of a request; fits its law to the rows of the first loading, and softening to the others.
pub fn fit_softening(request: &FitRequest) -> Result<(FitResult, SofteningFit), SofteningFitError> {
    let stated = match request.options.modes[..] {
        [one] => Some(one),
        _ => None,
    };
    let files = std::iter::once(&request.data).chain(&request.more);
    let one = |path: &std::path::PathBuf| Experiment::read(path, request.card.as_deref(), &request.columns, stated);
    let parts: Vec<Experiment> = files.map(one).collect::<Result<_, _>>()?;
    for part in &parts {
        let own = part.card.as_ref().map(|c| &c.preparation);
        for asked in own.into_iter().chain([&request.preparation]) {
            let treatments = [
                ("a cycle", asked.cycle.is_some()),
                ("zeroing", asked.zero.is_some()),
                ("toe compensation", asked.toe.is_some()),
            ];
            let slack = ("slack", request.options.slack == SlackChoice::Yes);
            if let Some((what, _)) = treatments.into_iter().chain([slack]).find(|t| t.1) {
                return Err(SofteningFitError::Treated { file: part.file.clone(), what });
            }
        }
    }
    let experiment = Experiment::pool(parts)?;
    fit_softening_experiment(&experiment, &request.options)
}

/// The same of a table that was read already.
pub fn fit_softening_experiment(
    experiment: &Experiment,
    options: &FitOptions,
) -> Result<(FitResult, SofteningFit), SofteningFitError> {
    let path = divide(experiment)?;
    let rows = path.softened.len();
    if rows < ROWS {
        return Err(SofteningFitError::NoUnloading { file: experiment.file.clone(), rows, needed: ROWS });
    }
    let first = Experiment { samples: path.virgin, alternatives: vec![], ..experiment.clone() };
    let law = fit_experiment(&first, &FitOptions { slack: SlackChoice::No, ..options.clone() })?;
    let points = points(&law, &path.softened)?;
    let softening = fit(&law, &points)?;
    Ok((law, softening))
}

/// Rows with stress and energy by the law.
fn points(law: &FitResult, rows: &[(Sample, f64)]) -> Result<Vec<Point>, SofteningFitError> {
    let model = Model::new(law.law, Some(law.terms))?;
    let values: Vec<f64> = law.parameters.iter().map(|p| p.value).collect();
    // Only the isochoric part is used, which κ does not change
    let whole = model.law(&values, 1e9)?;
    let info = whole.info();
    let (part, _) =
        whole.split().filter(|_| info.isochoric).ok_or(SofteningFitError::NotIsochoric { law: info.name })?;
    let energy = |s: &Sample, stretch: f64| energy(&*part, s.mode.stretches(stretch, 1.0));
    let one = |(s, peak): &(Sample, f64)| {
        let undefined = SofteningFitError::Undefined { stretch: *peak, line: s.line };
        let stress = model.at(&values, s);
        match (energy(s, s.stretch), energy(s, *peak)) {
            (Some(w), Some(peak)) if stress.is_finite() => Ok(Point { sample: *s, stress, energy: w, peak }),
            _ => Err(undefined),
        }
    };
    rows.iter().map(one).collect()
}

fn energy(law: &dyn Law, stretches: [f64; 3]) -> Option<f64> {
    law.eval(&Mat3::from_diagonal(&stretches.into()), Want::Energy).ok().map(|r| r.psi).filter(|w| w.is_finite())
}

/// 1/r, m and β, in units of 1, the largest W_m and 1.
type Unknowns = [f64; 3];

/// A search with its data points.
struct Search<'a> {
    points: &'a [Point],
    /// Largest W_m \[J/m³\]
    unit: f64,
    /// Whether β is an unknown
    beta: bool,
}

impl Search<'_> {
    fn softening(&self, u: Unknowns) -> Softening {
        Softening { r: 1.0 / u[0].max(1e-12), m: u[1] * self.unit, beta: u[2] }
    }

    /// P − η P_law of each row \[Pa\].
    fn residual(&self, u: Unknowns) -> DVector<f64> {
        let soft = self.softening(u);
        let one = |p: &Point| p.sample.stress - soft.at(p.energy, p.peak).eta * p.stress;
        DVector::from_iterator(self.points.len(), self.points.iter().map(one))
    }

    /// ∂(η P_law)/∂u, (n, 3): −erf x, and s 2/√π e^{−x²} x/(m + βW_m) times 1 and W_m, s = 1/r.
    fn jacobian(&self, u: Unknowns) -> DMatrix<f64> {
        let soft = self.softening(u);
        let row = |p: &Point| {
            let d = soft.m + soft.beta * p.peak;
            if p.energy >= p.peak || d <= 0.0 {
                return [0.0; 3];
            }
            let x = (p.peak - p.energy) / d;
            let slope = u[0] * 2.0 / PI.sqrt() * (-x * x).exp() * x / d;
            [-erf(x) * p.stress, slope * self.unit * p.stress, slope * p.peak * p.stress]
        };
        let entries: Vec<f64> = self.points.iter().flat_map(row).collect();
        DMatrix::from_row_slice(self.points.len(), 3, &entries)
    }

    fn inside(&self, u: Unknowns) -> Unknowns {
        let beta = if self.beta { u[2].max(0.0) } else { 0.0 };
        // One of m and β is positive
        let m = u[1].max(if beta > 1e-6 { 0.0 } else { 1e-6 });
        [u[0].clamp(0.0, MOST), m, beta]
    }

    /// Levenberg & Marquardt within the bounds; unknowns at a bound that is pressed on rest.
    fn search(&self, from: Unknowns) -> (Unknowns, f64) {
        let mut u = self.inside(from);
        let (mut r, mut damping) = (self.residual(u), 1e-3);
        for _ in 0..ITERATIONS {
            let j = self.jacobian(u);
            let g = j.tr_mul(&r);
            let held = |k: usize| match k {
                0 => (u[0] >= MOST && g[0] > 0.0) || (u[0] <= 0.0 && g[0] < 0.0),
                1 => u[1] <= 1e-6 && g[1] < 0.0,
                _ => !self.beta || (u[2] <= 0.0 && g[2] < 0.0),
            };
            let rests: [bool; 3] = std::array::from_fn(held);
            let h = j.tr_mul(&j);
            let before = r.norm_squared();
            let mut better = false;
            while damping < 1e12 {
                let free = |k: usize| f64::from(u8::from(!rests[k]));
                let a = Matrix3::from_fn(|i, k| {
                    let own = free(i) * free(k) * h[(i, k)];
                    if i == k {
                        own + damping * h[(i, i)].max(1e-300) + (1.0 - free(i)) * h[(i, i)].max(1.0)
                    } else {
                        own
                    }
                });
                let rhs = Vector3::from_fn(|k, _| free(k) * g[k]);
                let Some(step) = a.lu().solve(&rhs) else {
                    damping *= 10.0;
                    continue;
                };
                let next = self.inside(std::array::from_fn(|k| u[k] + step[k]));
                let found = self.residual(next);
                if found.norm_squared() < before {
                    (u, r, better, damping) = (next, found, true, (0.2 * damping).max(1e-12));
                    break;
                }
                damping *= 10.0;
            }
            if !better || before - r.norm_squared() <= SETTLED * before {
                break;
            }
        }
        (u, r.norm_squared())
    }

    /// The best of searches from a grid.
    fn best(&self) -> Unknowns {
        let betas: &[f64] = if self.beta { &[0.0, 0.1, 0.6] } else { &[0.0] };
        let grid = [0.2, 0.5, 0.8].into_iter().flat_map(|s| [0.02, 0.1, 0.5].map(|m| (s, m)));
        let starts: Vec<Unknowns> = grid.flat_map(|(s, m)| betas.iter().map(move |b| [s, m, *b])).collect();
        let found = starts.into_iter().map(|u| self.search(u));
        found.min_by(|a, b| a.1.total_cmp(&b.1)).expect("the grid has points").0
    }
}

/// Criterion of Schwarz with first-order autocorrelated errors of a residual and `constants` constants.
fn criterion(residual: &DVector<f64>, curves: &[Vec<usize>], constants: usize, floor: f64) -> f64 {
    let rows = residual.len() as f64;
    let whole = |rho: f64| {
        let sum = (1.0 - rho * rho) * errors::whitened(residual, curves, rho).iter().map(|w| w * w).sum::<f64>();
        rows * (sum.max(floor) / rows).ln() - curves.len() as f64 * (1.0 - rho * rho).ln()
    };
    (0..100).map(|k| whole(f64::from(k) / 100.0)).fold(f64::INFINITY, f64::min) + constants as f64 * rows.ln()
}

fn fit(law: &FitResult, points: &[Point]) -> Result<SofteningFit, SofteningFitError> {
    let samples: Vec<Sample> = points.iter().map(|p| p.sample).collect();
    let [low, high] = points.iter().fold([f64::INFINITY, 0.0_f64], |[a, b], p| [a.min(p.peak), b.max(p.peak)]);
    let search = Search { points, unit: high, beta: high > APART * low };
    let u = search.best();
    let residual = search.residual(u);
    let size = samples.iter().map(|s| s.stress * s.stress).sum::<f64>();
    let (curves, floor) = (errors::curves(&samples), ROUNDING * ROUNDING * size);
    let constants = if search.beta { 3 } else { 2 };
    let softening = criterion(&residual, &curves, constants, floor);
    let elastic = criterion(&search.residual([0.0, 1.0, 0.0]), &curves, 0, floor);
    if elastic <= softening {
        return Err(SofteningFitError::None { file: law.data.clone(), elastic, softening });
    }
    let rounding = residual.norm_squared() <= floor;
    let free: Vec<usize> =
        [true, u[1] > 1e-6, search.beta && u[2] > 0.0].iter().enumerate().filter(|p| *p.1).map(|p| p.0).collect();
    let own = errors::of(&search.jacobian(u).select_columns(&free), &residual, &samples, rounding);
    let t = if own.free > 0 { t_quantile(0.95, own.free) } else { f64::INFINITY };
    let half = |k: usize| match free.iter().position(|f| *f == k) {
        Some(at) if !rounding => t * own.deviations[at],
        _ => 0.0,
    };
    let soft = search.softening(u);
    let ends = |k: usize| [(u[k] - half(k)).max(0.0), u[k] + half(k)];
    let [low_s, high_s] = ends(0);
    let found = SofteningFit {
        data: law.data.clone(),
        data_sha256: law.data_sha256.clone(),
        law: law.law,
        constants: law.parameters.clone(),
        version: env!("CARGO_PKG_VERSION"),
        rows: points.len(),
        first_loading: law.rows,
        r: Bounded { value: soft.r, interval: [1.0 / high_s.min(1.0), 1.0 / low_s] },
        m: Bounded { value: soft.m, interval: ends(1).map(|end| high * end) },
        beta: Bounded { value: soft.beta, interval: ends(2) },
        at_bound: u[0] >= MOST,
        one_peak: !search.beta,
        errors: own.model,
        degrees: own.free,
        misfit: residual.norm() / size.sqrt(),
        largest_energy: high,
        lost: soft.lost(high) / high,
        summary: summary(),
    };
    let fitted =
        points.iter().zip(residual.iter()).map(|(p, r)| (p.sample.stretch, p.sample.stress, p.sample.stress - r));
    Ok(found.with_words(law, &fitted.collect::<Vec<_>>()))
}
