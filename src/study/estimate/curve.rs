//! Curves f(t) of one family: norms of differences, phase lag, cycle defect, and a pointwise Richardson extrapolation.
//!
//! ```text
//! ‖d‖₂ = √(1/T ∫ d² dt),  ‖d‖∞ = max |d|        on the common time grid, d between neighbouring meshes
//! p from ‖f₃ − f₂‖₂/‖f₂ − f₁‖₂ (the fixed point of [`crate::study::estimate::richardson`], one p for the whole curve)
//! f*(t) = f₁ + (f₁ − f₂)/(r₂₁^p − 1),   GCI(t) = Fs·|f₁ − f₂|/(r₂₁^p − 1);   for two curves with p = 1
//! ```
//!
//! Nothing is extrapolated from curves whose differences are rounding of the solver.
//!
//! The common grid is that of the finest mesh, over the time that all curves cover. The other curves are interpolated linearly. The error of the
//! interpolation, a quarter of the defect when every second sample is left out, is reported.

use crate::math::statistics::larger;
use crate::study::curve::{Curve, l2, lag};
use crate::study::estimate::richardson::{
    CAUTIOUS_FACTOR, PAIR_FACTOR, ROUNDING, Triple, bound_of_pair, correction, safety_factor,
};
use serde::Serialize;

/// Norms of one curve relative to the next finer one of its family.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CurveNorms {
    pub id: String,
    /// Largest change from the start \[unit of f\]
    pub peak: f64,
    /// ‖f − f_finer‖₂ \[unit of f\], 0 for the finest
    pub l2_to_finer: f64,
    /// ‖f − f_finer‖∞ \[unit of f\]
    pub linf_to_finer: f64,
    /// ‖f − f*‖₂ relative to the norm of the changes of f* from its start \[–\]; `None` without an f*
    pub l2_error: Option<f64>,
    /// Lag behind the curve of the finest mesh \[s\], positive if later; `None` beyond the range of the first order
    pub lag_s: Option<f64>,
    /// Cycle defect, if the curve covers at least two cycles \[–\]
    pub cycle_defect: Option<f64>,
}

/// The curves of a family on one time grid.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct CurveStudy {
    pub norms: Vec<CurveNorms>,
    /// Order from the ratio of the L2 norms; `None` if the curves oscillate with the mesh
    pub observed_order: Option<f64>,
    /// Order with which f*(t) was extrapolated; assumed for two curves
    pub order_used: Option<f64>,
    pub convergence_ratio: Option<f64>,
    pub fs: f64,
    /// Largest GCI(t) relative to the largest change of f* from its start \[%\]
    pub gci_percent: Option<f64>,
    /// Largest error of the interpolation onto the common grid \[unit of f\]; 0 if all grids agree
    pub interpolation_error: f64,
    /// \[samples\] Common grid \[s\]
    #[serde(skip)]
    pub t: Vec<f64>,
    /// \[samples\] f*(t); empty if no order could be used
    #[serde(skip)]
    pub star: Vec<f64>,
    /// \[samples\] GCI(t) \[unit of f\]
    #[serde(skip)]
    pub gci: Vec<f64>,
}

/// Compares the curves of a family. `members` are (id, h, curve), finest first; `formal` is the formal order, of which two curves assume at most 2.
pub fn compare(members: &[(String, f64, Curve)], formal: f64) -> Option<CurveStudy> {
    let (_, h1, finest) = members.first()?;
    let end = members.iter().filter_map(|m| m.2.t.last()).copied().fold(f64::INFINITY, f64::min);
    let t: Vec<f64> = finest.t.iter().copied().filter(|t| *t <= end * (1.0 + 1e-12)).collect();
    if t.len() < 2 {
        return None;
    }
    let same = |c: &Curve| c.t.len() >= t.len() && c.t.iter().zip(&t).all(|(a, b)| (a - b).abs() <= 1e-9 * end.abs());
    let interpolation_error =
        members.iter().filter(|m| !same(&m.2)).map(|m| m.2.interpolation_error()).fold(0.0, larger);
    let on: Vec<Vec<f64>> = members.iter().map(|m| t.iter().map(|t| m.2.at(*t)).collect()).collect();
    let difference = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
    let differences: Vec<Vec<f64>> = on.windows(2).map(|w| difference(&w[1], &w[0])).collect();
    let norm: Vec<f64> = differences.iter().map(|d| l2(&t, d)).collect();
    let differ = norm.iter().take(2).any(|n| *n > ROUNDING * finest.peak().abs());
    // Curves that oscillate with the mesh have norms as if they converged
    let is_monotone =
        differences.windows(2).take(1).all(|d| d[0].iter().zip(&d[1]).map(|(a, b)| a * b).sum::<f64>() >= 0.0);

    let (mut observed_order, mut convergence_ratio, mut fs, mut used) = (None, None, CAUTIOUS_FACTOR, None);
    if let ([a, b, ..], true) = (&norm[..], differ) {
        // A scalar with the same differences: f₂ − f₁ = ‖f₂ − f₁‖, f₃ − f₂ = ‖f₃ − f₂‖
        let triple = Triple::new([*h1, members[1].1, members[2].1], [0.0, *a, a + b]);
        let sign = if is_monotone { 1.0 } else { -1.0 };
        (observed_order, convergence_ratio) = (triple.p.filter(|_| is_monotone), Some(sign * triple.ratio));
        if is_monotone && triple.is_sane(formal) {
            (fs, used) = (safety_factor(true), triple.p);
        }
    } else if members.len() == 2 && differ {
        (fs, used) = (PAIR_FACTOR, Some(formal.min(2.0)));
    }
    let (mut star, mut gci) = (vec![], vec![]);
    if let Some(p) = used {
        let r = members[1].1 / h1;
        star = on[0].iter().zip(&on[1]).map(|(f1, f2)| f1 + correction(f1 - f2, r, p)).collect();
        let index = |d: f64| if members.len() == 2 { bound_of_pair(d, r) } else { fs * correction(d.abs(), r, p) };
        gci = on[0].iter().zip(&on[1]).map(|(f1, f2)| index(f1 - f2)).collect();
    }
    let largest = |v: &[f64]| v.iter().fold(0.0, |m, x| larger(m, x.abs()));
    let changes: Vec<f64> = star.iter().map(|value| value - finest.start()).collect();
    let norms = (0..members.len())
        .map(|k| {
            let d = if k == 0 { vec![0.0; t.len()] } else { difference(&on[k], &on[k - 1]) };
            CurveNorms {
                id: members[k].0.clone(),
                peak: members[k].2.largest_change(),
                l2_to_finer: l2(&t, &d),
                linf_to_finer: largest(&d),
                l2_error: (!star.is_empty() && l2(&t, &changes) > 0.0)
                    .then(|| l2(&t, &difference(&on[k], &star)) / l2(&t, &changes)),
                lag_s: lag(&t, &on[k], &on[0]),
                cycle_defect: members[k].2.cycle_defect(),
            }
        })
        .collect();
    let gci_percent = (!gci.is_empty() && largest(&changes) > 0.0).then(|| 100.0 * largest(&gci) / largest(&changes));
    let order_used = used;
    Some(CurveStudy {
        norms,
        observed_order,
        order_used,
        convergence_ratio,
        fs,
        gci_percent,
        interpolation_error,
        t,
        star,
        gci,
    })
}
