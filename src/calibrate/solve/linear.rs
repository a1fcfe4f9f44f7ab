//! Laws that are linear in their constants: least squares as a convex QP with stability as second-order cones, by clarabel.
//!
//! min ½‖Ax − p̂‖² subject to Σₖ xₖ Qₖ(λ) − δ Q₀(λ) ⪰ 0 at sampled λ
//!
//! Qₖ is the second derivative of term k within Σ de = 0 (2 × 2, [`PrincipalDerivatives::in_plane`](PrincipalDerivatives::in_plane)), Q₀ that of the
//! neo-Hookean law fitted to the same rows: Drucker's stability with a margin δ. [\[a, b\], \[b, d\]] ⪰ 0 ⇔ a + d ≥ ‖(a − d, 2b)‖.
//!
//! With A = UΣVᵀ of columns scaled to length 1 the QP is written in y = ΣVᵀx, where its matrix is the identity. If the least-squares solution from
//! the same SVD satisfies every cone, it is the minimum of the convex problem and is used, because it is more accurate; the two solutions then have
//! to agree.

use super::rows::{WeightedRows, padded, side_by_side};
use super::solver_check::SolverCheck;
use crate::calibrate::{FitError, Mode};
use crate::material::FitTerms;
use crate::material::principal::PrincipalDerivatives;
use crate::material::registry::find;
use crate::math::convex::{SecondOrderConeT, minimum};
use crate::math::svd::svd;
use nalgebra::{DMatrix, DVector};

/// δ: smallest incremental stiffness relative to that of the neo-Hookean law \[–\]
const MARGIN: f64 = 1e-3;
/// Ratio to the largest singular value below which a singular value is rounding \[–\]
const RANK: f64 = 1e-12;
/// Largest relative difference of the stresses of the two solvers \[–\]
const AGREEMENT: f64 = 1e-7;
/// Tolerance of the QP \[–\]
const TOLERANCE: f64 = 1e-12;
/// The QP begins with every `SPARSE`-th point
const SPARSE: usize = 5;

/// Derivatives of term k with factor 1 at principal stretches.
type Derivatives = fn(usize, [f64; 3]) -> PrincipalDerivatives;

/// Modes and stretches at which the law has to be stable.
pub type Points = Vec<(Mode, f64)>;

/// Factors of the terms and the constraints that are active.
pub struct Linear {
    /// \[Pa\]
    pub values: Vec<f64>,
    /// `None`: the QP was not needed
    pub check: Option<SolverCheck>,
    /// Points at which least squares alone would give an unstable law
    pub active: Points,
}

/// (a + d, a − d, 2b) of each term and of the neo-Hookean law at a point.
struct Cone {
    terms: Vec<[f64; 3]>,
    reference: [f64; 3],
}

fn lorentz(s: &PrincipalDerivatives) -> [f64; 3] {
    let [a, b, d] = s.in_plane();
    [a + d, a - d, 2.0 * b]
}

/// The neo-Hookean law, linear in its one constant μ.
fn neo_hookean() -> Derivatives {
    match find("neo_hookean").ok().and_then(|entry| entry.fit).map(|form| form.terms) {
        Some(FitTerms::Linear(derivatives)) => derivatives,
        _ => unreachable!("the library has the law, with a form for fits"),
    }
}

impl Cone {
    fn at(derivatives: Derivatives, terms: usize, neo_hookean: Derivatives, (mode, stretch): (Mode, f64)) -> Self {
        let s = mode.stretches(stretch, 1.0);
        let reference = lorentz(&neo_hookean(0, s));
        Self { terms: (0..terms).map(|k| lorentz(&derivatives(k, s))).collect(), reference }
    }

    /// Slack relative to the stiffness of the neo-Hookean law \[–\]; negative outside the cone.
    fn slack(&self, x: &DVector<f64>) -> f64 {
        let part = |i: usize| self.terms.iter().zip(x).map(|(t, x)| t[i] * x).sum::<f64>() - MARGIN * self.reference[i];
        (part(0) - part(1).hypot(part(2))) / self.reference[0]
    }
}

/// Finds the factors of the terms. `always`: whether the QP is solved for comparison even if the least-squares solution satisfies every cone.
pub fn solve(
    derivatives: Derivatives,
    terms: usize,
    rows: &WeightedRows,
    stable: &[(Mode, f64)],
    always: bool,
) -> Result<Linear, FitError> {
    let columns: Vec<_> = (0..terms).map(|k| rows.column(|s| derivatives(k, s).tau)).collect();
    // A column of zeros keeps its length: no data point depends on the term, whatever its factor
    let length: Vec<f64> = columns.iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 }).collect();
    let scaled: Vec<_> = columns.iter().zip(&length).map(|(c, n)| c / *n).collect();
    let a = padded(&side_by_side(&scaled), terms);
    let target = rows.target.clone().resize_vertically(a.nrows(), 0.0);
    let svd = svd(a.clone(), true, true);
    let (u, sigma, vt) = (svd.u.expect("asked for"), svd.singular_values, svd.v_t.expect("asked for"));
    let d = u.transpose() * &target;
    let largest = sigma.max();
    let natural = |z: DVector<f64>| DVector::from_iterator(terms, z.iter().zip(&length).map(|(z, n)| z / n));
    let z = DVector::from_fn(terms, |k, _| if sigma[k] > RANK * largest { d[k] / sigma[k] } else { 0.0 });
    let free = natural(vt.transpose() * z);
    let neo_hookean = neo_hookean();
    let cones: Vec<Cone> = stable.iter().map(|p| Cone::at(derivatives, terms, neo_hookean, *p)).collect();
    let inside = cones.iter().all(|c| c.slack(&free) >= 0.0);
    let pascal = |x: &DVector<f64>| x.iter().map(|x| x * rows.unit).collect::<Vec<_>>();
    if inside && !always {
        return Ok(Linear { values: pascal(&free), check: None, active: vec![] });
    }
    // x = length⁻¹ V T⁻¹ y with T = Σ, but at least 1e-8 of the largest singular value
    let t = sigma.map(|s| s.max(1e-8 * largest));
    let back = DMatrix::from_fn(terms, terms, |k, j| vt[(j, k)] / (t[j] * length[k]));
    let g = sigma.component_div(&t);
    // Every few points at first; points that the answer violates are added until none is left
    let mut used: Vec<usize> = (0..cones.len()).step_by(SPARSE).collect();
    let mut held = &back * quadratic(&g, &d, &back, &cones, &used)?;
    loop {
        let missed = |k: &usize| !used.contains(k) && cones[*k].slack(&held) < 0.0;
        let missed: Vec<usize> = (0..cones.len()).filter(missed).collect();
        if inside || missed.is_empty() {
            break;
        }
        used.extend(missed);
        held = &back * quadratic(&g, &d, &back, &cones, &used)?;
    }
    let stress = |x: &DVector<f64>| columns.iter().zip(x).fold(DVector::zeros(rows.len()), |s, (c, x)| s + c * *x);
    if inside {
        let relative_difference = (stress(&held) - stress(&free)).norm();
        if relative_difference.is_nan() || relative_difference > AGREEMENT {
            return Err(FitError::Disagree { difference: relative_difference, tolerance: AGREEMENT });
        }
        let check = SolverCheck::Convex { relative_difference, allowed: AGREEMENT };
        return Ok(Linear { values: pascal(&free), check: Some(check), active: vec![] });
    }
    let active = stable.iter().zip(&cones).filter(|(_, c)| c.slack(&free) < 0.0).map(|(p, _)| *p).collect();
    Ok(Linear { values: pascal(&held), check: Some(SolverCheck::Constrained), active })
}

/// Minimises ½Σ(gₖyₖ)² − gₖdₖyₖ subject to the used cones in x = `back` y.
fn quadratic(
    g: &DVector<f64>,
    d: &DVector<f64>,
    back: &DMatrix<f64>,
    cones: &[Cone],
    used: &[usize],
) -> Result<DVector<f64>, FitError> {
    let n = g.len();
    // 1e-12: directions that no data point determines remain where the cones leave them, near zero
    let diagonal = DMatrix::from_diagonal(&g.map(|g| g * g + 1e-12));
    let q = -g.component_mul(d);
    // s = (a + d, a − d, 2b)(x) − δ(…)₀ in the cone: −C y + s = −δ(…)₀, each cone scaled by its reference
    let (mut rows, mut b) = (DMatrix::zeros(3 * used.len(), n), DVector::zeros(3 * used.len()));
    for (k, cone) in used.iter().map(|k| &cones[*k]).enumerate() {
        for i in 0..3 {
            let x = DVector::from_iterator(n, cone.terms.iter().map(|t| t[i] / cone.reference[0]));
            rows.set_row(3 * k + i, &-(back.transpose() * x).transpose());
            b[3 * k + i] = -MARGIN * cone.reference[i] / cone.reference[0];
        }
    }
    minimum((&diagonal, &q), (&rows, &b), &vec![SecondOrderConeT(3); used.len()], Some(TOLERANCE))
        .map_err(|e| FitError::Solver { solver: "clarabel", status: e.status })
}
