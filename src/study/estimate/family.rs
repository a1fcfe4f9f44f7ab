//! Evidence of one family of meshes for one scalar: its limit f* and an uncertainty U(f*), with the reasons.
//!
//! | data | f* | U₁ of the finest | U(f*) |
//! |---|---|---|---|
//! | 4 or more meshes, sane p | φ₀ of the least squares | Eça–Hoekstra U | max of δ and (Fs − 1)ε₁ + σ + \|φ₁ − fit\|; U₁ if the orders of two triples differ |
//! | 3, monotone, sane p | Richardson | GCI, Fs = 1.25 | max of δ, \|f\*(p) − f\*(formal)\| and \|f\*(p) − f\*(2)\| |
//! | 2 | Richardson with p = min(formal, 2), 1 where a held face ends at a re-entrant edge | GCI of the first order, Fs = 4 | U₁ |
//! | any other p, not monotone, or noise above the differences | f₁ | 3·max(ΔM, noise) | U₁ |
//!
//! An order p is sane from ½ to 1.05 times the formal order; no other order is used for extrapolation. δ = |f₁ − f*|, ΔM = max |fᵢ − fⱼ|; the last row
//! of the table follows Eça & Hoekstra (Int. J. Numer. Meth. Fluids 2009).
//!
//! In an oscillating family, ΔM is that of the three finest meshes. A coarser mesh j counts with |f₁ − fⱼ| or, if this is less, with the error of f₁
//! for first-order convergence, |f₁ − fⱼ|/(hⱼ/h₁ − 1), so that a far coarser mesh hardly counts. With only three meshes, |f₁ − f₂|/(h₂/h₁ − 1) is
//! added, because three meshes do not distinguish an extremum from noise. In all other families with h_n/h₁ below 4/3, the factor 3 of ΔM is replaced
//! by that of first-order convergence, 1/(h_n/h₁ − 1): the differences of nearly equal meshes tend to zero, but their error does not.
//!
//! A reference that is closer to the finest value than that value is to its limit would rely on one power of h beyond its evidence; hence U(f*) ≥ δ.
//! Noise is the half-width of the 95 % interval of one value of the mesher, t s with the standard deviation s of n seeds; two seeds that agree by
//! chance therefore say little. It enters f* multiplied by √((1 + k)² + k²), k = 1/(r^p − 1), and is added to U(f*) for triples and pairs; in least
//! squares σ contains it. A family of nested meshes has no noise.
//!
//! Meshes that are not similar have no single h: the same estimate with the mean edge length in place of (V/N)^{1/3} gives another limit, and the
//! difference of the two limits is added to U(f*).

use crate::math::statistics::{larger, range};
use crate::mesh::wall::{LEAST_CELLS, shows_bending};
use crate::report::numbers::percent;
use crate::scene::ElementSpec;
use crate::study::estimate::curve::CurveStudy;
use crate::study::estimate::least_squares::{Fit, least_squares};
use crate::study::estimate::method::Method;
use crate::study::estimate::richardson::{
    CAUTIOUS_FACTOR, Convergence, LEAST_ORDER, LEAST_RATIO, PAIR_FACTOR, ROUNDING, Triple, bound_of_pair, correction,
    is_small_ratio, safety_factor,
};
use crate::study::estimate::tolerance::Tolerance;
use crate::study::locking;
use crate::study::store::record::{CaseRecord, Role};
use serde::Serialize;

/// Columns of a largest or smallest value within the body, by the ends of their names.
const LOCAL: [&str; 5] = ["min_j", "stretch_max", "stretch_min", "stress_max_Pa", "thickness_min_m"];

/// One mesh of a family.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Level {
    pub id: String,
    /// (V/N)^{1/3} \[m\]
    pub h: f64,
    /// Mean edge length \[m\], if it is known and is a measure of the family
    pub edge: Option<f64>,
    /// Mean extents of the cells along x, y and z, and their mean longest edge \[m\]; 0 if it is not a measure of the mesh
    pub extents: Option<[f64; 4]>,
    pub f: f64,
    /// Cells across the thinnest wall, if they were counted
    pub wall: Option<f64>,
    /// Whether its pressures raise the locking alarm
    pub locked: bool,
    /// Regions, defined by position, whose border runs through its cells
    pub cut: Vec<String>,
    /// Whether its value is a largest or smallest one within the body
    pub extreme: bool,
    /// Why the answer has no limit as h → 0
    pub no_limit: Option<String>,
    /// Whether a held face ends at a re-entrant edge
    pub glued: bool,
}

impl Level {
    /// Builds a level from the mesh of a case and the value f of a column; `column` is empty if f does not belong to a column.
    pub fn of(case: &CaseRecord, column: &str, f: f64) -> Self {
        let mesh = &case.mesh;
        Self {
            id: case.id.clone(),
            h: mesh.h_m,
            edge: mesh.edge_m,
            extents: mesh.extents_m,
            f,
            wall: mesh.wall_cells,
            locked: locking::alarm(case).is_some(),
            cut: case.cut_regions_of(column),
            extreme: LOCAL.iter().any(|end| column.ends_with(end)),
            no_limit: case.no_limit.clone(),
            glued: case.glued_edge,
        }
    }

    /// Builds a level from a case with time steps of `dt` \[s\], in a family on one mesh, where the cells across the walls and locking do not change.
    pub fn of_steps(case: &CaseRecord, f: f64, dt: f64) -> Self {
        Self { id: case.id.clone(), h: dt, f, ..Self::default() }
    }
}

/// The result for one family × variant × quantity.
#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Estimate {
    pub family: String,
    pub role: Role,
    pub formulation: String,
    /// \[meshes\] Case ids, finest first
    pub cases: Vec<String>,
    pub h_m: Vec<f64>,
    pub values: Vec<f64>,
    /// \[meshes − 1\] Ratios r of neighbouring sizes, finest first
    pub ratios: Vec<f64>,
    pub formal_order: f64,
    pub class: Convergence,
    pub convergence_ratio: Option<f64>,
    pub ratio_limit: Option<f64>,
    /// p of the three finest meshes
    pub observed_order: Option<f64>,
    /// p of the triple one mesh coarser
    pub observed_order_coarser: Option<f64>,
    /// Whether the two orders agree within 25 % and p ≤ formal; `None` with fewer than four meshes
    pub asymptotic: Option<bool>,
    /// \[meshes\] Cells across the thinnest wall, finest first; empty if they were not counted
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub wall_cells: Vec<f64>,
    /// Richardson value of the finest triple or pair
    pub richardson: Option<f64>,
    pub gci_percent: Option<f64>,
    pub fs: f64,
    pub fit: Option<Fit>,
    /// Order and limit with the mean edge length as h \[–, unit of f\]
    pub by_edge: Option<(Option<f64>, f64)>,
    /// f* and U(f*) \[unit of f\]
    pub extrapolated: f64,
    pub uncertainty: f64,
    /// U₁ of the finest mesh \[unit of f\]
    pub uncertainty_finest: f64,
    pub method: Method,
    /// Whether the cells keep their length in a direction
    #[serde(skip)]
    pub keeps_length: bool,
    /// Whether some objection would remain on any finer mesh
    #[serde(skip)]
    pub lasting: bool,
    /// Whether f* ± U(f*) is not a claim: the family diverges, locks, does not resolve the thinnest wall, keeps the length of the cells in a direction,
    /// has a region whose border runs through cells, or may have no limit
    pub refused: bool,
    /// Whether f* can be a reference: U(f*) is within the tolerance and there is no objection to the family
    pub defensible: bool,
    /// Objections to the limit, and what restricts it
    pub reasons: Vec<String>,
}

impl Estimate {
    /// The observed order with which f* is found: that of the least squares over all meshes, or that of the three finest. `None` if the order is
    /// assumed or nothing is extrapolated.
    pub fn order_of_limit(&self) -> Option<f64> {
        match self.method {
            Method::Richardson => self.observed_order,
            Method::LeastSquares { .. } => self.fit.as_ref().map(|fit| fit.p),
            _ => None,
        }
    }

    /// φ at size h by the power law with the order of the limit, whose limit is f*.
    pub fn power_law(&self, h: f64) -> Option<f64> {
        let p = self.order_of_limit()?;
        let fit = self.fit.as_ref().filter(|_| self.method != Method::Richardson);
        let from_finest = || self.extrapolated + (self.values[0] - self.extrapolated) * (h / self.h_m[0]).powf(p);
        Some(fit.map_or_else(from_finest, |fit| fit.at(h)))
    }

    /// Whether the limit is zero within its uncertainty and small compared with the values, so that errors relative to it are meaningless.
    pub fn is_near_zero(&self) -> bool {
        let (limit, largest) = (self.extrapolated, self.values.iter().fold(0.0_f64, |m, f| m.max(f.abs())));
        let is_small = limit.abs() <= 0.1 * largest || self.values.iter().any(|f| f * limit <= 0.0);
        limit == 0.0 || (limit.abs() <= self.uncertainty && is_small)
    }
}

/// Formal order of a functional, from the short name of element and formulation: twice the degree of the displacement (springs use linear cells).
pub fn formal_order(formulation: &str) -> f64 {
    if formulation.starts_with(ElementSpec::Tet10.name()) { 4.0 } else { 2.0 }
}

/// Estimates the limit as [`estimate_of_order`] does, with the formal order of the formulation.
pub fn estimate(
    of: (&str, Role, &str),
    levels: Vec<Level>,
    noise: Option<f64>,
    tolerance: impl Into<Tolerance>,
) -> Option<Estimate> {
    estimate_of_order(of, formal_order(of.2), levels, noise, tolerance)
}

/// Estimates the limit of a family and its uncertainty. `q` is the formal order; `levels` may be in any order; `noise` is the half-width of the 95 %
/// interval of one value over the seeds, if there are seeds.
pub fn estimate_of_order(
    (family, role, formulation): (&str, Role, &str),
    q: f64,
    mut levels: Vec<Level>,
    noise: Option<f64>,
    tolerance: impl Into<Tolerance>,
) -> Option<Estimate> {
    let tolerance = tolerance.into();
    levels.sort_by(|a, b| a.h.total_cmp(&b.h));
    levels.dedup_by(|a, b| (a.h / b.h - 1.0).abs() < 1e-6);
    if levels.len() < 2 {
        return None;
    }
    let (h, f): (Vec<f64>, Vec<f64>) = levels.iter().map(|l| (l.h, l.f)).unzip();
    let ratios: Vec<f64> = h.windows(2).map(|w| w[1] / w[0]).collect();
    let triple =
        |k: usize| (f.len() >= k + 3).then(|| Triple::new([h[k], h[k + 1], h[k + 2]], [f[k], f[k + 1], f[k + 2]]));
    let (first, coarser) = (triple(0), triple(1));
    let spread = range(f.iter().copied());
    let size = f.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let class = match first {
        Some(t) => t.class,
        None if spread <= ROUNDING * size => Convergence::Exact,
        None => Convergence::TwoMeshes,
    };
    let spread = if class == Convergence::Oscillatory { oscillation(&h, &f) } else { spread };
    let mut reasons: Vec<String> = small_ratios(&ratios).into_iter().collect();
    let p = first.and_then(|t| t.p);
    let asymptotic = first
        .zip(coarser)
        .map(|(a, b)| a.is_sane(q) && a.p.zip(b.p).is_some_and(|(x, y)| (x - y).abs() <= 0.25 * x.max(y)));
    let steps: Vec<f64> = f.windows(2).take(2).map(|w| (w[1] - w[0]).abs()).collect();
    let least = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let noise = noise.filter(|_| role != Role::Nested && class != Convergence::Exact);
    let noisy = noise.is_some_and(|s| s > least);

    let f1 = f[0];
    let mut e = Estimate {
        family: family.to_string(),
        role,
        formulation: formulation.to_string(),
        cases: levels.iter().map(|l| l.id.clone()).collect(),
        formal_order: q,
        class,
        convergence_ratio: first.map(|t| t.ratio),
        ratio_limit: first.map(|t| t.ratio_limit),
        observed_order: p,
        observed_order_coarser: coarser.and_then(|t| t.p),
        asymptotic,
        wall_cells: levels.iter().map(|l| l.wall).collect::<Option<_>>().unwrap_or_default(),
        richardson: None,
        gci_percent: None,
        fs: CAUTIOUS_FACTOR,
        fit: least_squares(&h, &f, q),
        by_edge: None,
        extrapolated: f1,
        uncertainty: 0.0,
        uncertainty_finest: 0.0,
        method: Method::Spread,
        keeps_length: length_objection(class, &levels).is_some(),
        lasting: false,
        refused: false,
        defensible: false,
        reasons: vec![],
        h_m: h,
        values: f,
        ratios,
    };
    let assumed = set_richardson(&mut e, first, levels[0].glued);
    set_uncertainty(&mut e, &Differences { spread, least, noise, noisy, assumed }, &mut reasons);
    add_other_size(&mut e, &levels, noise, tolerance);
    add_limits(&e, first.is_some_and(|t| t.is_sane(q)), &mut reasons);
    reasons.extend(judge(&mut e, &levels, noisy, tolerance));
    e.reasons = reasons;
    Some(e)
}

/// ΔM of an oscillating family, finest first: that of the three finest meshes, or a larger difference of a coarser mesh from the finest, which counts
/// at most as the first-order error of the finest. Three meshes alone do not distinguish an extremum, beyond which the limit lies, from noise: the
/// first-order error of the finest is added to their ΔM.
pub fn oscillation(h: &[f64], f: &[f64]) -> f64 {
    let by_first_order = |hj: f64| h[0] / (hj - h[0]);
    let coarser = h.iter().zip(f).skip(3).map(|(hj, fj)| (fj - f[0]).abs() * by_first_order(*hj).min(1.0));
    let alone = if f.len() == 3 { (f[1] - f[0]).abs() * by_first_order(h[1]) } else { 0.0 };
    coarser.fold(alone + range(f.iter().copied().take(3)), f64::max)
}

/// Order that two meshes assume if a held face ends at a re-entrant edge, where 2λ is 0.6 to 1.
const GLUED_ORDER: f64 = 1.0;

/// Diverging differences are ignored if three times their range is below this share of the tolerance.
const SMALL: f64 = 0.1;

/// Judges whether f* ± U(f*) is a claim and can be a reference; returns the objections.
fn judge(e: &mut Estimate, levels: &[Level], noisy: bool, tolerance: Tolerance) -> Vec<String> {
    let lasting = lasting_objections(e, levels);
    e.lasting = !lasting.is_empty();
    let mut against = objections(e, levels, noisy, tolerance);
    against.extend(lasting);
    e.refused = !against.is_empty();
    against.extend(imprecision(e, tolerance));
    against.extend(order_objection(e));
    e.defensible = against.is_empty();
    against
}

impl Estimate {
    /// Objects to a peak that is the same on every mesh where the curves differ by more than the tolerance: something prescribed cuts it off, and its
    /// agreement says nothing about them.
    pub fn check_curves(&mut self, curves: &CurveStudy, tolerance: Tolerance) {
        let apart = curves.norms.iter().map(|norms| norms.linf_to_finer).fold(0.0, larger);
        if self.class != Convergence::Exact || apart <= tolerance.allowed(self.extrapolated) {
            return;
        }
        (self.refused, self.defensible) = (true, false);
        self.reasons.push(format!(
            "the peak is the same on every mesh, but the curves differ by up to {:.1} % of it: a prescribed value or a limit cuts it off; choose a quantity that \
             nothing cuts off",
            100.0 * apart / self.extrapolated.abs()
        ));
    }
}

/// Objections for which f* ± U(f*) is not a claim, however wide, until a finer mesh removes them.
fn objections(e: &Estimate, levels: &[Level], noisy: bool, tolerance: Tolerance) -> Vec<String> {
    let mut out = vec![];
    let allowed = tolerance.allowed(e.extrapolated);
    if e.class == Convergence::Diverging && !noisy && e.uncertainty > SMALL * allowed {
        out.push(
            "a family that diverges has no limit to be near to; add a finer mesh, or seeds that show the scatter"
                .into(),
        );
    }
    out.extend(wall_objection(e));
    out.extend(length_objection(e.class, levels));
    if levels[0].locked {
        out.push("its finest mesh raises the locking alarm".into());
    }
    out
}

/// Objections for which f* ± U(f*) is not a claim, and that no finer mesh removes. A quantity that is independent of the mesh has a limit.
fn lasting_objections(e: &Estimate, levels: &[Level]) -> Vec<String> {
    if e.class == Convergence::Exact {
        return vec![];
    }
    let no_limit = levels.iter().find_map(|l| l.no_limit.as_ref());
    let mut out: Vec<String> =
        no_limit.map(|why| format!("{why}, so the answer has no limit as h → 0")).into_iter().collect();
    out.extend(region_objection(&levels[0].cut));
    // Three meshes may show an order even if there is no limit
    if levels[0].extreme && e.asymptotic != Some(true) {
        out.push(
            "a largest or smallest value within the body may lie at a clamped or re-entrant edge, where it has no limit and no mesh is fine enough; only four \
             meshes whose orders agree show one: take a percentile or a place of your choice"
                .into(),
        );
    }
    out
}

/// The reason why U(f*) is too large for a reference, if it is.
fn imprecision(e: &Estimate, tolerance: Tolerance) -> Option<String> {
    let (allowed, scale) = (tolerance.allowed(e.extrapolated), tolerance.scale(e.extrapolated));
    if tolerance.absolute == 0.0 && e.is_near_zero() {
        let why = "the value is zero within its uncertainty, and a relative tolerance means nothing there; give the quantity an \
                   absolute_tolerance";
        Some(why.into())
    } else if e.uncertainty > allowed || !e.uncertainty.is_finite() {
        let of = if tolerance.absolute > 0.0 { "of the scale" } else { "of the value" };
        let (share, limit) = (100.0 * e.uncertainty / scale, percent(tolerance.relative));
        Some(format!("its uncertainty, {share:.2} % {of}, is above the tolerance of {limit}"))
    } else {
        None
    }
}

/// The reason why two members alone support nothing: they may differ little next to an extremum, far from their limit, so that fewer than 95 % of the
/// pairs with a small U(f*) contain it.
pub fn order_objection(e: &Estimate) -> Option<String> {
    let why = "its two members show no order, and not that there is a limit; add a third";
    (e.class == Convergence::TwoMeshes).then(|| why.into())
}

/// Objects if the walls are not refined: an order says nothing about a wall that every mesh resolves by the same few cells. The count must reach
/// [`LEAST_CELLS`] on the finest mesh and grow by at least the square root of the size ratio. A quantity that is independent of the mesh needs no
/// order.
fn wall_objection(e: &Estimate) -> Option<String> {
    let (finest, coarsest) = (*e.wall_cells.first()?, *e.wall_cells.last()?);
    if e.class == Convergence::Exact {
        return None;
    }
    let counts = || e.wall_cells.iter().rev().map(|c| format!("{c:.1}")).collect::<Vec<_>>().join(", ");
    let refine = "refine the walls too";
    if !shows_bending(finest) {
        return Some(format!(
            "{} cells across the thinnest wall, from coarse to fine, are too few to show how it bends (at least \
             {LEAST_CELLS:.0} on the finest mesh); {refine}",
            counts()
        ));
    }
    let grows = finest / coarsest;
    let expected = (e.h_m[e.h_m.len() - 1] / e.h_m[0]).sqrt();
    (grows < expected)
        .then(|| format!("the cells across the thinnest wall hardly change over the family ({}); {refine}", counts()))
}

/// Objects if cells keep their length in a direction: an order in h says nothing about that direction. The extents of the cells along every axis and
/// their longest edges must shrink by at least the square root of the size ratio.
fn length_objection(class: Convergence, levels: &[Level]) -> Option<String> {
    if class == Convergence::Exact {
        return None;
    }
    let all: Vec<[f64; 4]> = levels.iter().map(|l| l.extents).collect::<Option<_>>()?;
    let (finest, coarsest) = (all.first()?, all.last()?);
    let expected = (levels.last()?.h / levels.first()?.h).sqrt();
    let is_in_both = |k: usize| finest[k] > 0.0 && coarsest[k] > 0.0;
    // Longest edges are no measure if other axes apply
    let has_same_axes = (0..3).all(|k| is_in_both(k) || finest[k] == coarsest[k]);
    let counts = |k: &usize| is_in_both(*k) && (*k < 3 || has_same_axes);
    let stays = (0..4).filter(counts).find(|&k| coarsest[k] / finest[k] < expected)?;
    let lengths: Vec<String> = all.iter().rev().map(|l| format!("{:.2}", 1e3 * l[stays])).collect();
    let what =
        ["the extents of the cells along x", "the extents of the cells along y", "the extents of the cells along z"];
    let what = what.get(stays).unwrap_or(&"the longest edges of the cells");
    Some(format!(
        "{what} hardly shrink over the family ({} mm, from coarse to fine), so that the error by them is not seen; refine every direction",
        lengths.join(", ")
    ))
}

/// Objects if the border of a region runs through cells: it moves by up to a cell from mesh to mesh, or is off by as much on all of them.
fn region_objection(cut: &[String]) -> Option<String> {
    (!cut.is_empty()).then(|| {
        format!(
            "the border of {} runs through cells, and its extent, which changes with the mesh (O(h)), is not seen; let it run along edges of \
             the cells, or take a region of the mesh",
            cut.join(", ")
        )
    })
}

/// Lists the size ratios of a family if any of them is smaller than recommended.
fn small_ratios(ratios: &[f64]) -> Option<String> {
    let list: Vec<String> = ratios.iter().map(|r| format!("{r:.2}")).collect();
    ratios
        .iter()
        .any(|r| is_small_ratio(*r))
        .then(|| format!("size ratios {} (Roache recommends at least {LEAST_RATIO})", list.join(", ")))
}

/// Finds the limit with the mean edge length as h; its distance from f* is added to U(f*).
fn add_other_size(e: &mut Estimate, levels: &[Level], noise: Option<f64>, tolerance: Tolerance) {
    let by_edge = |l: &Level| Some(Level { h: l.edge?, edge: None, ..l.clone() });
    let Some(others) = levels.iter().map(by_edge).collect::<Option<Vec<_>>>() else { return };
    let of = (e.family.as_str(), e.role, e.formulation.as_str());
    let Some(other) = estimate_of_order(of, e.formal_order, others, noise, tolerance) else { return };
    e.uncertainty += (e.extrapolated - other.extrapolated).abs();
    e.by_edge = Some((other.observed_order, other.extrapolated));
}

/// Sets Richardson's limit and the GCI of the finest triple or pair. Returns the order of the limit. For two meshes it is at most 2, which clamped
/// edges permit, or [`GLUED_ORDER`] if a held face ends at a re-entrant edge; their GCI is that of the first order.
fn set_richardson(e: &mut Estimate, first: Option<Triple>, glued: bool) -> Option<f64> {
    let (q, f1) = (e.formal_order, e.values[0]);
    let assumed = match first {
        Some(t) if t.is_sane(q) => {
            e.fs = safety_factor(true);
            t.p
        }
        Some(_) => None,
        None if e.class == Convergence::TwoMeshes => {
            e.fs = PAIR_FACTOR;
            Some(if glued { GLUED_ORDER } else { q.min(2.0) })
        }
        None => None,
    };
    if let Some(p) = assumed {
        let (difference, r) = (f1 - e.values[1], e.ratios[0]);
        let shift = correction(difference, r, p);
        let index = if first.is_some() { e.fs * shift.abs() } else { bound_of_pair(difference, r) };
        e.richardson = Some(f1 + shift);
        e.uncertainty_finest = index;
        e.gci_percent = (f1 != 0.0).then(|| 100.0 * index / f1.abs());
    }
    assumed
}

/// Properties of the values of a family that determine its uncertainty.
struct Differences {
    /// ΔM
    spread: f64,
    /// The smaller of the two differences between the three finest meshes
    least: f64,
    /// Half-width of the 95 % interval of one value over the seeds, if there are seeds
    noise: Option<f64>,
    /// Whether the noise exceeds the smaller difference
    noisy: bool,
    /// Order of Richardson's limit
    assumed: Option<f64>,
}

/// Sets the limit, its method and the uncertainties.
fn set_uncertainty(e: &mut Estimate, d: &Differences, reasons: &mut Vec<String>) {
    let (q, f1, r21) = (e.formal_order, e.values[0], e.ratios[0]);
    if e.class == Convergence::Exact {
        e.method = Method::Independent;
        e.uncertainty = d.spread;
        e.uncertainty_finest = d.spread;
    } else if d.noisy {
        let s = d.noise.unwrap_or(0.0);
        reasons.push(format!(
            "mesh noise {s:.3e} exceeds the difference {:.3e} of neighbouring meshes; where few seeds tell it, add some",
            d.least
        ));
        e.method = Method::Spread;
        e.uncertainty_finest = cautious(&e.h_m, e.class) * d.spread.max(s);
        e.uncertainty = e.uncertainty_finest;
    } else if let Some(fit) = e.fit.as_ref().filter(|fit| fit.has_sane_order()) {
        let (h1, u1) = (e.h_m[0], fit.uncertainty[0]);
        e.method = Method::LeastSquares { model: fit.model.clone(), weighted: fit.weighted };
        e.extrapolated = fit.f0;
        e.uncertainty_finest = u1;
        let beyond = if fit.good && e.asymptotic != Some(false) {
            (fit.fs - 1.0) * fit.error(h1) + fit.sigma + (f1 - fit.at(h1)).abs()
        } else {
            u1
        };
        e.uncertainty = larger(beyond, (f1 - fit.f0).abs());
    } else if let (Some(p), Some(star)) = (d.assumed, e.richardson) {
        let delta = (star - f1).abs();
        e.extrapolated = star;
        let k = 1.0 / (p * r21.ln()).exp_m1();
        let noise = d.noise.unwrap_or(0.0) * ((1.0 + k).powi(2) + k * k).sqrt();
        // One triple does not show that its p is the asymptotic one: that is 2 at singular edges, the formal order elsewhere
        let other = |p: f64| (star - f1 - correction(f1 - e.values[1], r21, p)).abs();
        e.uncertainty = noise
            + if e.fs < CAUTIOUS_FACTOR { delta.max(other(q)).max(other(q.min(2.0))) } else { e.uncertainty_finest };
        e.method = match e.convergence_ratio {
            Some(_) => Method::Richardson,
            None => Method::TwoMeshes { p },
        };
    } else {
        e.method = Method::Spread;
        e.uncertainty_finest = cautious(&e.h_m, e.class) * d.spread;
        e.uncertainty = e.uncertainty_finest;
    }
}

/// Factor of ΔM: 3, or that of first-order convergence, 1/(h_n/h₁ − 1), if the sizes lie closer together than 4/3 and their differences say less. In
/// oscillating families ΔM already contains the first order.
fn cautious(h: &[f64], class: Convergence) -> f64 {
    let first_order = (h[h.len() - 1] / h[0] - 1.0).recip();
    if class == Convergence::Oscillatory { CAUTIOUS_FACTOR } else { CAUTIOUS_FACTOR.max(first_order) }
}

/// Appends what limits the estimate: the kind of convergence, the observed orders, and the scatter about the fit.
fn add_limits(e: &Estimate, is_sane: bool, reasons: &mut Vec<String>) {
    let (q, p) = (e.formal_order, e.observed_order);
    match e.class {
        Convergence::Oscillatory => reasons.push(format!(
            "the three finest oscillate, ½(max − min) = {:.3e}",
            0.5 * range(e.values.iter().copied().take(3))
        )),
        Convergence::Diverging => {
            let how = match e.convergence_ratio {
                Some(ratio) if ratio < 0.0 => "oscillate with differences that do not shrink",
                _ => "diverge monotonically",
            };
            let [finer, coarser] = [0, 1].map(|k| e.values[k] - e.values[k + 1]);
            let limit = e.convergence_ratio.zip(e.ratio_limit).filter(|(ratio, _)| *ratio > 0.0 && ratio.is_finite());
            let limit = limit.map_or(String::new(), |(ratio, limit)| {
                format!(", a ratio of {ratio:.3} where these sizes must have one below {limit:.3}")
            });
            reasons.push(format!(
                "the three finest {how}: from coarse to fine they change by {coarser:.2e}, then by {finer:.2e}{limit}"
            ));
        }
        _ => {}
    }
    if let Some(p) = p.filter(|_| !is_sane) {
        let side = if p > q { "above the formal" } else { "below the least" };
        let limit = if p > q { q } else { LEAST_ORDER };
        reasons.push(format!("observed order {p:.2} is {side} order {limit}, and nothing is extrapolated with it"));
    }
    if let (Some(a), Some(b)) = (p, e.observed_order_coarser)
        && (a - b).abs() > 0.25 * a.max(b)
    {
        reasons.push(format!("orders {a:.2} and {b:.2} of the two triples differ by more than 25 %"));
    }
    if e.fit.as_ref().is_some_and(|f| f.sigma >= f.range) {
        reasons.push("the values scatter about the fit by more than they change from mesh to mesh".into());
    }
}
