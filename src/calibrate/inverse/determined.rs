//! Coordinates of a search: the directions of the constants that the curves determine, as their sensitivities show.
//!
//! u = ln θ for constants that are positive by their law. For others u = θ/z, where z is the range over which the constant can change: half of the
//! range between its bounds; otherwise, for a constant in pascal, the shear modulus at rest (or |θ| if larger), and for a number 1 (or |θ|). In the
//! SVD w∂ŷ/∂u/‖wy‖ = UΣVᵀ the directions with
//!
//! ```text
//! σ_k ≤ 4 ε      ε the accuracy to which the scene can reproduce the curve
//! ```
//!
//! are not determined: an error ε of the curve leaves more than a quarter of the range of these constants open. They get no interval, but the search
//! does not stop at them: u = u₀ + Bw, B = V diag(1/σ), includes the directions that are determined at first, and, in each further search from the
//! previous answer, also the directions
//!
//! - with σ_k > 4 ε_k, ε_k the change of the curve that the scatter of the residuals leaves open at 95 % ([`super::scatter`]);
//! - along which the misfit falls by more than that scatter.
//!
//! The answer is therefore independent of the start wherever the data determine it within their own scatter, and along a direction about which they
//! say nothing it stays where it was. Whether a direction is determined is judged at the last answer. If the data determine a modulus at rest instead
//! of two constants, it is named: E, for example, if it does not change along the open direction.

use super::Unknown;
use super::bound::Bound;
use super::objective::Point;
use super::scatter::{self, Along};
use crate::calibrate::judgement::identify::changes;
use crate::calibrate::solve::rows::padded;
use crate::material::Moduli;
use crate::math::svd::svd;
use crate::math::units::Dimension;
use crate::scene::SceneSpec;
use nalgebra::{DMatrix, DVector};

/// Share of the range of the constants that an error of the curve may leave open along a direction that counts as determined \[–\]
const QUARTER: f64 = 0.25;
/// Relative change of a modulus along a direction, divided by that of the constants, below which the modulus counts as unchanged \[–\]
const STAYS: f64 = 0.1;
/// Singular value below which a direction is only rounding of the forward solves \[–\]
const ROUNDING: f64 = 1e-9;
/// Ratio to the largest singular value below which a direction does not move the held constants \[–\]
const NULL: f64 = 1e-10;
/// Distance in u at which a bound counts as reached
const TOUCH: f64 = 1e-12;

/// Directions along which a search moves.
#[derive(Clone, Copy, Debug)]
pub enum Searched<'a> {
    /// The directions that the curves determine, if they are reproduced to this accuracy \[–\]
    Determined { accuracy: f64 },
    /// The determined directions, those that the scatter of the residuals determines, and those along which the misfit falls by more than it;
    /// `curves`: rows in order of x
    Told { accuracy: f64, curves: &'a [Vec<usize>] },
    /// All directions that the curves depend on, except this unknown
    But(usize),
}

/// A direction that is not determined.
struct Open {
    /// \[unknowns\], in u
    along: DVector<f64>,
    /// Whether the scatter of the residuals would determine it
    is_told: bool,
}

/// The map from u to the values, and the directions that are searched.
pub struct Coordinates {
    /// For each unknown: whether u = ln θ, and otherwise the unit of u
    kinds: Vec<(bool, f64)>,
    /// Bounds of u
    ends: Vec<[f64; 2]>,
    /// \[unknowns × directions\]
    basis: DMatrix<f64>,
    open: Vec<Open>,
    /// \[unknowns\] part of a change of each unknown alone that is searched: 1 for all of it, 0 for none
    shares: Vec<f64>,
}

impl Coordinates {
    /// Chooses the coordinates at a point. `unknown`: the constants; any further values are offsets of single curves.
    pub fn new(unknown: &[Unknown], spec: &SceneSpec, start: &Point, size: f64, which: Searched) -> Self {
        let p = start.values.len();
        let kind = |k: usize| {
            let value = start.values[k];
            let Some(Unknown { parameter, bounds: [low, high], key, usual, .. }) = unknown.get(k) else {
                let length = start.jacobian.column(k).norm();
                return (false, if length > 0.0 { size / length } else { 1.0 });
            };
            if parameter.bounds.0 >= 0.0 && value > 0.0 {
                return (true, 1.0);
            }
            let law = || spec.known_laws.law(spec.laws.get(key.law_constant()?.law)?).ok();
            let modulus = || Some(law()?.small_strain().mu);
            let usual = if parameter.dimension == Dimension::PRESSURE { modulus().unwrap_or(*usual) } else { *usual };
            let width = 0.5 * (high - low);
            (false, if width.is_finite() { width } else { value.abs().max(usual) })
        };
        let kinds: Vec<(bool, f64)> = (0..p).map(kind).collect();
        let ends = (0..p).map(|k| {
            let of = |value: f64| if kinds[k].0 { value.max(0.0).ln() } else { value / kinds[k].1 };
            unknown.get(k).map_or([f64::NEG_INFINITY, f64::INFINITY], |q| q.bounds.map(of))
        });
        let mut own = Self { ends: ends.collect(), kinds, basis: DMatrix::zeros(p, 0), open: vec![], shares: vec![] };
        let mut j = &start.jacobian * own.rates(&own.of(&start.values)) / size;
        if let Searched::But(held) = which {
            j.column_mut(held).fill(0.0);
        }
        own.choose(&j, &start.residual, size, which);
        own
    }

    /// Chooses the directions by the sensitivities w∂ŷ/∂u/‖wy‖.
    fn choose(&mut self, j: &DMatrix<f64>, residual: &DVector<f64>, size: f64, which: Searched) {
        let p = j.ncols();
        let svd = svd(padded(j, p), true, true);
        let (sigma, v) = (svd.singular_values, svd.v_t.expect("asked for").transpose());
        let seen: Vec<usize> = (0..p).filter(|k| sigma[*k] > ROUNDING).collect();
        let mut all: Vec<Option<Along>> = vec![None; p];
        if let Searched::Told { curves, .. } = which {
            let changes = svd.u.expect("asked for").rows(0, j.nrows()).select_columns(&seen);
            let along = scatter::along(&changes, residual, size, curves);
            seen.iter().zip(along).for_each(|(k, along)| all[*k] = Some(along));
        }
        let is_told = |k: usize| all[k].is_some_and(|a| sigma[k] > a.open / QUARTER);
        let is_searched = |k: &usize| match which {
            Searched::Determined { accuracy } => sigma[*k] > accuracy / QUARTER,
            Searched::Told { accuracy, .. } => {
                sigma[*k] > accuracy / QUARTER || is_told(*k) || all[*k].is_some_and(|a| a.falls)
            }
            Searched::But(_) => true,
        };
        let told: Vec<usize> = seen.into_iter().filter(is_searched).collect();
        self.basis = DMatrix::from_fn(p, told.len(), |i, k| v[(i, told[k])] / sigma[told[k]]);
        self.shares = (0..p).map(|i| told.iter().map(|k| v[(i, *k)].powi(2)).sum()).collect();
        let (Searched::Determined { accuracy } | Searched::Told { accuracy, .. }) = which else { return };
        let open = (0..p).filter(|k| sigma[*k] <= accuracy / QUARTER);
        self.open = open.map(|k| Open { along: v.column(k).into_owned(), is_told: is_told(k) }).collect();
    }

    /// u at these values.
    pub fn of(&self, values: &[f64]) -> DVector<f64> {
        let one = |(x, (ln, unit)): (&f64, &(bool, f64))| if *ln { x.ln() } else { x / unit };
        DVector::from_iterator(values.len(), values.iter().zip(&self.kinds).map(one))
    }

    /// Values at u.
    pub fn values(&self, u: &DVector<f64>) -> Vec<f64> {
        let one = |(u, (ln, unit)): (&f64, &(bool, f64))| if *ln { u.exp() } else { u * unit };
        u.iter().zip(&self.kinds).map(one).collect()
    }

    /// ∂θ/∂u, a diagonal matrix.
    pub fn rates(&self, u: &DVector<f64>) -> DMatrix<f64> {
        let one = |(u, (ln, unit)): (&f64, &(bool, f64))| if *ln { u.exp() } else { *unit };
        DMatrix::from_diagonal(&DVector::from_iterator(u.len(), u.iter().zip(&self.kinds).map(one)))
    }

    /// u, moved back onto a bound that it exceeds by rounding.
    pub fn within(&self, u: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(u.len(), u.iter().zip(&self.ends).map(|(u, [low, high])| u.clamp(*low, *high)))
    }

    /// The share of a change of u at which constant `k` reaches a bound; 0 if it is on the bound and the change leads beyond it, `None` if it reaches
    /// none.
    pub fn crosses(&self, u: &DVector<f64>, change: &DVector<f64>, k: usize) -> Option<f64> {
        let end = if change[k] > 0.0 { self.ends[k][1] } else { self.ends[k][0] };
        if change[k].abs() <= TOUCH || !end.is_finite() {
            return None;
        }
        let share = (end - u[k]) / change[k];
        if (end - u[k]).abs() <= TOUCH { Some(0.0) } else { Some(share).filter(|s| *s < 1.0) }
    }

    /// Basis of the directions that move none of the constants that are held at a bound \[unknowns × directions\].
    pub fn free(&self, bound: &[Bound]) -> DMatrix<f64> {
        let held: Vec<usize> = (0..bound.len()).filter(|k| !bound[*k].is_free()).collect();
        if held.is_empty() || self.basis.ncols() == 0 {
            return self.basis.clone();
        }
        let rows = self.basis.select_rows(&held);
        let m = rows.ncols();
        let svd = svd(padded(&rows, m), false, true);
        let (sigma, v) = (svd.singular_values, svd.v_t.expect("asked for").transpose());
        let kept: Vec<usize> = (0..m).filter(|k| sigma[*k] <= NULL * sigma.max()).collect();
        &self.basis * v.select_columns(&kept)
    }

    /// \[unknowns\] part of a change of each unknown alone that is searched \[–\]
    pub fn shares(&self) -> &[f64] {
        &self.shares
    }

    /// Whether an open direction, followed as far as its constants can change, moves this constant by more than the accuracy.
    pub fn is_open(&self, k: usize, accuracy: f64) -> bool {
        self.open.iter().any(|open| open.along[k].abs() > accuracy)
    }

    /// Describes the open directions.
    pub fn words(&self, unknown: &[Unknown], spec: &SceneSpec, values: &[f64], accuracy: f64) -> Vec<String> {
        let one = |Open { along: v, is_told }: &Open| {
            let p = unknown.len();
            let names: Vec<&str> = unknown.iter().map(|q| q.parameter.symbol).collect();
            let relative: Vec<f64> = (0..p)
                .map(|k| {
                    if self.kinds[k].0 { v[k] } else { v[k] * self.kinds[k].1 / values[k].abs().max(f64::MIN_POSITIVE) }
                })
                .collect();
            let known = self.staying(unknown, spec, values, v);
            let better = match is_told {
                true => {
                    "; the scatter of the data alone would tell it: if the scene is as good as that, state its `accuracy`"
                }
                false => "",
            };
            format!(
                "the data do not determine {}: an error of the curve of {} % leaves it open{}; add a curve that tells \
                 these constants apart, or give one of them{better}",
                changes(&relative, &names, &values[..p]),
                100.0 * accuracy,
                known.map_or(String::new(), |m| format!("; they determine {m}"))
            )
        };
        self.open.iter().map(one).collect()
    }

    /// The modulus at rest that does not change along a direction of unknowns of one law.
    fn staying(&self, unknown: &[Unknown], spec: &SceneSpec, values: &[f64], v: &DVector<f64>) -> Option<String> {
        const H: f64 = 1e-4;
        let of: Vec<_> = unknown.iter().map(|q| q.key.law_constant()).collect::<Option<_>>()?;
        let law = of.first()?.law;
        if unknown.len() < 2 || of.iter().any(|c| c.law != law) {
            return None;
        }
        let table = spec.laws.get(law)?;
        let at = |by: f64| -> Option<Moduli> {
            let there = self.values(&(self.of(values) + v * by));
            let mut table = table.clone();
            for ((q, of), value) in unknown.iter().zip(&of).zip(&there) {
                table.insert(of.key.into(), q.written(*value));
            }
            Some(spec.known_laws.law(&table).ok()?.small_strain())
        };
        // At the limit of what the law allows, one side lies beyond it
        let (here, there) = (at(0.0)?, at(H).or_else(|| at(-H))?);
        let moved = |of: fn(&Moduli) -> f64| (of(&there) / of(&here)).ln().abs() / H;
        let all: [(&str, f64, f64); 3] = [
            ("E, Young's modulus at rest", here.e, moved(|m| m.e)),
            ("μ, the shear modulus at rest", here.mu, moved(|m| m.mu)),
            ("κ, the bulk modulus at rest", here.kappa, moved(|m| m.kappa)),
        ];
        let (name, value, least) = all.into_iter().min_by(|a, b| a.2.total_cmp(&b.2))?;
        (least < STAYS).then(|| format!("{name}: {:.4} kPa at the answer", value / 1e3))
    }
}
