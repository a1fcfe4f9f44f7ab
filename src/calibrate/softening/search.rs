//! The search for the constants of softening: Levenberg–Marquardt within bounds, from a grid of starts.

use super::rows::{FirstLoading, Point, Row};
use crate::material::Softening;
use libm::erf;
use nalgebra::{DMatrix, DVector, Matrix4, Vector4};
use std::f64::consts::PI;

/// Largest number of iterations of a search, and the relative decrease of the sum of squares below which it ends
const ITERATIONS: usize = 200;
const SETTLED: f64 = 1e-14;
/// Largest 1/r \[–\], so that r stays above 1
const MOST: f64 = 0.999;
/// Smallest m relative to the largest W_m if β is zero \[–\]: one of the two is positive
const LEAST: f64 = 1e-6;
/// Largest share of the largest ln λ that may remain as a set \[–\]
const MOST_SET: f64 = 0.9;
/// Step of the set for its derivative \[–\]
const STEP: f64 = 1e-6;

/// 1/r, m, β and the share of the largest ln λ that remains, in units of 1, the largest W_m, 1 and 1.
#[derive(Clone, Copy, Debug)]
pub struct SofteningSolution {
    pub u: [f64; 4],
    /// Whether a set is an unknown
    set: bool,
}

impl SofteningSolution {
    /// Whether r is at its bound.
    pub fn at_bound(&self) -> bool {
        self.u[0] >= MOST
    }
}

/// A search with its data points.
pub struct Search<'a> {
    first: &'a FirstLoading,
    rows: &'a [Row],
    /// Points without a set
    plain: Vec<Point>,
    /// Largest W_m \[J/m³\]
    unit: f64,
    /// Whether β is an unknown
    pub beta: bool,
}

impl<'a> Search<'a> {
    pub fn new(first: &'a FirstLoading, rows: &'a [Row], plain: Vec<Point>, unit: f64, beta: bool) -> Self {
        Self { first, rows, plain, unit, beta }
    }

    pub fn softening(&self, answer: &SofteningSolution) -> Softening {
        let u = &answer.u;
        Softening { r: 1.0 / u[0].max(1e-12), m: u[1] * self.unit, beta: u[2] }
    }

    /// The solution without softening and without a set.
    pub fn elastic(&self) -> SofteningSolution {
        SofteningSolution { u: [0.0, 1.0, 0.0, 0.0], set: false }
    }

    /// Points at a set; the stress is NaN at a state where the law is not defined.
    fn points(&self, set: f64) -> Vec<Point> {
        let nowhere = |p: &Point| Point { stress: f64::NAN, ..*p };
        if set == 0.0 {
            return self.plain.clone();
        }
        self.first.points(self.rows, set).unwrap_or_else(|_| self.plain.iter().map(nowhere).collect())
    }

    /// η P_law of each row \[Pa\].
    fn stress(&self, answer: &SofteningSolution, points: &[Point]) -> DVector<f64> {
        let soft = self.softening(answer);
        DVector::from_iterator(points.len(), points.iter().map(|p| soft.at(p.energy, p.peak).eta * p.stress))
    }

    /// P − η P_law of each row \[Pa\].
    pub fn residual(&self, answer: &SofteningSolution) -> DVector<f64> {
        let measured = DVector::from_iterator(self.rows.len(), self.rows.iter().map(|r| r.sample.stress));
        measured - self.stress(answer, &self.points(answer.u[3]))
    }

    /// ∂(η P_law)/∂u (n × 4): −erf x, s 2/√π e^{−x²} x/(m + βW_m) times 1 and W_m with s = 1/r, and finite differences for the set.
    pub fn jacobian(&self, answer: &SofteningSolution) -> DMatrix<f64> {
        let (soft, u) = (self.softening(answer), &answer.u);
        let points = self.points(u[3]);
        let row = |p: &Point| {
            let d = soft.m + soft.beta * p.peak;
            if p.energy >= p.peak || d <= 0.0 {
                return [0.0; 4];
            }
            let x = (p.peak - p.energy) / d;
            let slope = u[0] * 2.0 / PI.sqrt() * (-x * x).exp() * x / d;
            [-erf(x) * p.stress, slope * self.unit * p.stress, slope * p.peak * p.stress, 0.0]
        };
        let entries: Vec<f64> = points.iter().flat_map(row).collect();
        let mut j = DMatrix::from_row_slice(points.len(), 4, &entries);
        if answer.set {
            let [low, high] = [(u[3] - STEP).max(0.0), u[3] + STEP];
            let at = |set: f64| self.stress(answer, &self.points(set));
            j.set_column(3, &((at(high) - at(low)) / (high - low)));
        }
        j
    }

    /// ∂(η P_law)/∂θ for the constants of the law (n × constants), by central differences, to 1e-8; zero for a constant that cannot be changed.
    pub fn by_law(&self, answer: &SofteningSolution) -> DMatrix<f64> {
        let n = self.rows.len();
        let column = |moved: Option<([FirstLoading; 2], f64)>| {
            let Some((laws, step)) = moved else { return DVector::zeros(n) };
            let [low, high] = laws.map(|law| law.points(self.rows, answer.u[3]).map(|p| self.stress(answer, &p)));
            match (low, high) {
                (Ok(low), Ok(high)) => (high - low) / (2.0 * step),
                _ => DVector::zeros(n),
            }
        };
        let columns: Vec<DVector<f64>> = self.first.moved().into_iter().map(column).collect();
        DMatrix::from_columns(&columns)
    }

    /// Unknowns whose errors count. An unknown that ends at its bound is included, because the data leave open how far from the bound it is.
    pub fn free(&self, answer: &SofteningSolution) -> Vec<usize> {
        let is_free = [true, true, self.beta, answer.set];
        (0..4).filter(|k| is_free[*k]).collect()
    }

    fn inside(&self, u: [f64; 4], set: bool) -> SofteningSolution {
        let beta = if self.beta { u[2].max(0.0) } else { 0.0 };
        let m = u[1].max(if beta > LEAST { 0.0 } else { LEAST });
        let share = if set { u[3].clamp(0.0, MOST_SET) } else { 0.0 };
        SofteningSolution { u: [u[0].clamp(0.0, MOST), m, beta, share], set }
    }

    /// Levenberg–Marquardt within the bounds; unknowns that a step would push beyond their bound are held.
    fn search(&self, from: SofteningSolution) -> (SofteningSolution, f64) {
        let mut own = self.inside(from.u, from.set);
        let (mut r, mut damping) = (self.residual(&own), 1e-3);
        for _ in 0..ITERATIONS {
            let (j, u) = (self.jacobian(&own), own.u);
            let g = j.tr_mul(&r);
            let held = |k: usize| match k {
                0 => (u[0] >= MOST && g[0] > 0.0) || (u[0] <= 0.0 && g[0] < 0.0),
                1 => u[1] <= LEAST && g[1] < 0.0,
                2 => !self.beta || (u[2] <= 0.0 && g[2] < 0.0),
                _ => !own.set || (u[3] <= 0.0 && g[3] < 0.0),
            };
            let rests: [bool; 4] = std::array::from_fn(held);
            let h = j.tr_mul(&j);
            let before = r.norm_squared();
            let mut better = false;
            while damping < 1e12 {
                let free = |k: usize| f64::from(u8::from(!rests[k]));
                let a = Matrix4::from_fn(|i, k| {
                    let own = free(i) * free(k) * h[(i, k)];
                    if i == k {
                        own + damping * h[(i, i)].max(1e-300) + (1.0 - free(i)) * h[(i, i)].max(1.0)
                    } else {
                        own
                    }
                });
                let rhs = Vector4::from_fn(|k, _| free(k) * g[k]);
                let Some(step) = a.lu().solve(&rhs) else {
                    damping *= 10.0;
                    continue;
                };
                let next = self.inside(std::array::from_fn(|k| u[k] + step[k]), own.set);
                let found = self.residual(&next);
                if found.norm_squared() < before {
                    (own, r, better, damping) = (next, found, true, (0.2 * damping).max(1e-12));
                    break;
                }
                damping *= 10.0;
            }
            if !better || before - r.norm_squared() <= SETTLED * before {
                break;
            }
        }
        (own, r.norm_squared())
    }

    /// The best of the searches from a grid of starts, without a set.
    pub fn best(&self) -> SofteningSolution {
        let betas: &[f64] = if self.beta { &[0.0, 0.1, 0.6] } else { &[0.0] };
        let grid = [0.2, 0.5, 0.8].into_iter().flat_map(|s| [0.02, 0.1, 0.5].map(|m| (s, m)));
        let starts =
            grid.flat_map(|(s, m)| betas.iter().map(move |b| SofteningSolution { u: [s, m, *b, 0.0], set: false }));
        let found = starts.map(|from| self.search(from));
        found.min_by(|a, b| a.1.total_cmp(&b.1)).expect("the grid has points").0
    }

    /// The best of the searches with a set as an unknown, starting from an answer without a set and from constants in its neighbourhood, because a
    /// set that was hidden in the softening has moved them.
    pub fn with_set(&self, from: SofteningSolution) -> SofteningSolution {
        let start = |(share, set): (f64, f64)| {
            let [s, m, b, _] = from.u;
            self.search(SofteningSolution { u: [share * s, m, b, set], set: true })
        };
        let starts = [(1.0, 1e-3), (1.0, 0.05), (0.7, 0.05), (0.7, 0.15)];
        let found = starts.map(start).into_iter().filter(|f| f.1.is_finite());
        found.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(SofteningSolution { set: true, ..from }, |f| f.0)
    }
}
