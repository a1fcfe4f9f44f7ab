//! Weighted points of a body from which the forces of a reduced model are summed, four points side by side.
//!
//! With F = I + Σ_i q_i ∂v_i/∂X and p = Σ_c π_c p_c at a point, the energy Σ w (ψ̃(F) + p G(J)) of weights w ≥ 0 has the gradient and the
//! symmetric Hessian that are summed here: energy-conserving sampling and weighting (Farhat, Avery, Chapman & Cortial, *Int. J. Numer. Meth.
//! Eng.* 98, 2014; Farhat, Chapman & Avery, 102, 2015), taken at quadrature points instead of cells (An, Kim & James, *ACM Trans. Graph.* 27, 2008).

pub(super) mod lanes;
pub(super) mod parted_law;
pub mod rate_points;

use crate::effect::{AddPressure, cofactor_by_rows};
use crate::material::{LaneResponse, Law, LawCard, LawError, LawSpecError, Volumetric, Want};
use crate::math::lanes::{Kernel, LANES, Lanes, Real, widest};
use crate::math::tensor::{Mat3, det_minus_one};
use lanes::contract;
use parted_law::parted;
use rate_points::{RatePoints, StoredRates};
use serde::{Deserialize, Serialize};

/// The points of one law as stored in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredPoints {
    pub law: LawCard,
    /// Whether a pressure field replaces the volumetric part of the law
    pub has_pressure: bool,
    /// Rate-dependent forces at the points; zero in statics
    pub rates: StoredRates,
    /// \[points\] w \[m³\]
    pub weights: Vec<f64>,
    /// \[points × displacement modes × 9\] ∂v/∂X row by row
    pub gradients: Vec<f64>,
    /// \[points × pressure modes\] p_c \[Pa\]
    pub pressures: Vec<f64>,
    /// \[points × tests × 9\] and \[points × tests\]: gradients and pressures of the fields along which an error estimate takes forces
    pub test_gradients: Vec<f64>,
    pub test_pressures: Vec<f64>,
}

/// Numbers of modes and tests that determine the sizes of the arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sizes {
    pub displacements: usize,
    pub pressures: usize,
    pub tests: usize,
}

impl Sizes {
    /// Number of displacement and pressure coordinates.
    pub fn coordinates(&self) -> usize {
        self.displacements + self.pressures
    }
}

impl StoredPoints {
    /// Whether the arrays have consistent sizes, with finite values and non-negative weights.
    pub fn is_sound(&self, sizes: Sizes) -> bool {
        let n = self.weights.len();
        let lengths = [
            (self.gradients.len(), 9 * sizes.displacements),
            (self.pressures.len(), sizes.pressures),
            (self.test_gradients.len(), 9 * sizes.tests),
            (self.test_pressures.len(), if self.has_pressure { sizes.tests } else { 0 }),
        ];
        let arrays = [&self.weights, &self.gradients, &self.pressures, &self.test_gradients, &self.test_pressures];
        lengths.iter().all(|(length, each)| *length == n * each)
            && arrays.iter().all(|v| v.iter().all(|x| x.is_finite()))
            && self.weights.iter().all(|w| *w >= 0.0)
            && self.rates.is_sound()
    }
}

/// The points of one law, ready to be summed.
pub struct Points {
    sizes: Sizes,
    law: Box<dyn Law>,
    volumetric: Option<Volumetric>,
    has_pressure: bool,
    /// \[groups\]
    weights: Vec<Lanes>,
    /// \[groups × modes\] ∂v/∂X row by row
    gradients: Vec<[Lanes; 9]>,
    /// \[groups × pressure modes\]
    pressures: Vec<Lanes>,
    test_gradients: Vec<[Lanes; 9]>,
    test_pressures: Vec<Lanes>,
    /// Rate-dependent forces in dynamic models
    rates: Option<RatePoints>,
}

/// Sums over points, in lanes, and the workspace of an evaluation.
pub struct Sums {
    /// \[coordinates\] or \[tests\]
    pub r: Vec<Lanes>,
    /// \[coordinates × coordinates\] row by row, column ≤ row
    pub k: Vec<Lanes>,
    response: LaneResponse,
    second: LaneResponse,
    /// \[displacement modes\] A ∂v/∂X
    products: Vec<[Lanes; 9]>,
}

impl Sums {
    pub fn new(sizes: Sizes) -> Self {
        let n = sizes.coordinates();
        Self {
            r: vec![Lanes::ZERO; n.max(sizes.tests)],
            k: vec![Lanes::ZERO; n * n],
            response: LaneResponse::default(),
            second: LaneResponse::default(),
            products: vec![[Lanes::ZERO; 9]; sizes.displacements],
        }
    }

    pub fn clear(&mut self, want: Want) {
        self.r.fill(Lanes::ZERO);
        if want == Want::Tangent {
            self.k.fill(Lanes::ZERO);
        }
    }
}

/// Sums the lanes in order.
pub fn total(lanes: &Lanes) -> f64 {
    lanes.0.iter().sum()
}

/// Arranges consecutive points in groups of four lanes; lanes without a point are zero.
fn in_lanes(values: &[f64], points: usize, each: usize) -> Vec<Lanes> {
    let mut out = vec![Lanes::ZERO; points.div_ceil(LANES) * each];
    for (point, values) in values.chunks_exact(each.max(1)).enumerate() {
        for (k, value) in values.iter().enumerate() {
            out[point / LANES * each + k].0[point % LANES] = *value;
        }
    }
    out
}

fn tensors(lanes: Vec<Lanes>) -> Vec<[Lanes; 9]> {
    lanes.chunks_exact(9).map(|c| std::array::from_fn(|n| c[n])).collect()
}

impl Points {
    /// Builds the points from a file, which must be [sound](StoredPoints::is_sound).
    pub fn new(stored: &StoredPoints, sizes: Sizes) -> Result<Self, LawSpecError> {
        let (law, volumetric) = parted(stored.law.build()?, stored.has_pressure);
        let points = stored.weights.len();
        Ok(Self {
            sizes,
            law,
            volumetric,
            has_pressure: stored.has_pressure,
            weights: in_lanes(&stored.weights, points, 1),
            gradients: tensors(in_lanes(&stored.gradients, points, 9 * sizes.displacements)),
            pressures: in_lanes(&stored.pressures, points, sizes.pressures),
            test_gradients: tensors(in_lanes(&stored.test_gradients, points, 9 * sizes.tests)),
            test_pressures: in_lanes(&stored.test_pressures, points, if stored.has_pressure { sizes.tests } else { 0 }),
            rates: None,
        })
    }

    /// Adds the rate-dependent forces stored in a file to the points, for a dynamic model with steps of `dt` \[s\].
    #[must_use]
    pub fn moving(mut self, of: &StoredRates, dt: f64) -> Self {
        if !of.is_none() {
            let whole = self.volumetric.is_none().then_some(&*self.law);
            self.rates = Some(RatePoints::new(of, whole, self.weights.len(), dt));
        }
        self
    }

    /// Size of the history of the points.
    pub fn memory(&self) -> usize {
        self.rates.as_ref().map_or(0, |rates| rates.size() * self.weights.len())
    }

    /// Starts a step from the displacement coordinates `q` with the history `memory` of the points there.
    pub fn begin(&mut self, q: &[f64], memory: &[f64]) {
        let Some(mut rates) = self.rates.take() else { return };
        let size = rates.size();
        for group in 0..self.weights.len() {
            rates.begin(group, &self.deformation(q, group), &memory[group * size..][..size]);
        }
        self.rates = Some(rates);
    }

    /// Computes the history of the points at the end of a step, at the displacement coordinates `q`.
    pub fn advance(&self, q: &[f64], memory: &[f64], next: &mut [f64], sums: &mut Sums) -> Result<(), LawError> {
        let Some(rates) = &self.rates else { return Ok(()) };
        let size = rates.size();
        for group in 0..self.weights.len() {
            let f = self.deformation(q, group);
            let (from, to) = (&memory[group * size..][..size], &mut next[group * size..][..size]);
            rates.advance(&*self.law, &f, &mut sums.second, (from, to))?;
        }
        Ok(())
    }

    /// Returns P row by row and G(J) for all points at the coordinates `y`.
    pub fn forces(&self, y: &[f64], sums: &mut Sums) -> Result<Vec<([f64; 9], f64)>, LawError> {
        let mut out = vec![];
        for group in 0..self.weights.len() {
            let place = self.place(y, group, Want::Residual, sums)?;
            let at = |lane: usize| (sums.response.p.map(|p| p.0[lane]), place.gap.0[lane]);
            out.extend((0..LANES).map(at));
        }
        Ok(out)
    }

    /// Returns F at four points.
    fn deformation(&self, q: &[f64], group: usize) -> [Lanes; 9] {
        let n = self.sizes.displacements;
        let mut f = [Lanes::ZERO; 9];
        widest(Deformation { gradients: &self.gradients[group * n..][..n], q, h: &mut f });
        [0, 4, 8].into_iter().for_each(|k| f[k] += Lanes::of(1.0));
        f
    }

    /// Replaces the law by another law of the same kind.
    pub fn set_law(&mut self, whole: Box<dyn Law>) {
        (self.law, self.volumetric) = parted(whole, self.has_pressure);
    }

    /// Returns the bulk modulus of the volumetric part that a pressure field replaces \[Pa\].
    pub fn bulk_modulus(&self) -> Option<f64> {
        self.volumetric.map(|volumetric| volumetric.kappa)
    }

    /// Adds ∂r/∂θ at the coordinates `y`, where `along` is the derivative of the law with respect to θ; returns the derivative of the bulk modulus if
    /// there are pressures, whose compliance depends on it.
    pub fn add_derivative(&self, y: &[f64], along: Box<dyn Law>, out: &mut Sums) -> Result<Option<f64>, LawError> {
        let (law, volumetric) = parted(along, self.has_pressure);
        let n = self.sizes.displacements;
        for group in 0..self.weights.len() {
            let gradients = &self.gradients[group * n..][..n];
            let f = self.deformation(&y[..n], group);
            law.eval_lanes(&f, Want::Residual, &mut out.response).map_err(|(_, why)| why)?;
            let place = Place { weight: self.weights[group], ..Place::default() };
            let (response, r) = (&out.response, &mut out.r[..]);
            widest(Forces { gradients, pressures: &[], place: &place, response, r, first_pressure: n });
        }
        Ok(volumetric.map(|volumetric| volumetric.kappa))
    }

    /// Adds r = ∂Π/∂y and K = ∂²Π/∂y² at the coordinates `y`, displacements first.
    pub fn add(&self, y: &[f64], want: Want, out: &mut Sums) -> Result<(), LawError> {
        let Sizes { displacements: n, pressures: m, .. } = self.sizes;
        for group in 0..self.weights.len() {
            let place = self.place(y, group, want, out)?;
            let (gradients, pressures) = (&self.gradients[group * n..][..n], &self.pressures[group * m..][..m]);
            let (response, r) = (&out.response, &mut out.r[..]);
            widest(Forces { gradients, pressures, place: &place, response, r, first_pressure: n });
            if want == Want::Tangent {
                let Sums { response, k, products, .. } = out;
                widest(Hessian { gradients, pressures, place: &place, response, k, products });
            }
        }
        Ok(())
    }

    /// Adds the forces along the tests at the coordinates `y`.
    pub fn add_tests(&self, y: &[f64], out: &mut Sums) -> Result<(), LawError> {
        let tests = self.sizes.tests;
        for group in 0..self.weights.len() {
            let place = self.place(y, group, Want::Residual, out)?;
            let gradients = &self.test_gradients[group * tests..][..tests];
            let none = self.test_pressures.is_empty();
            let pressures = if none { &[][..] } else { &self.test_pressures[group * tests..][..tests] };
            let (response, r) = (&out.response, &mut out.r[..]);
            widest(Forces { gradients, pressures, place: &place, response, r, first_pressure: 0 });
        }
        Ok(())
    }

    /// Computes the response of the law with the pressure at four points.
    fn place(&self, y: &[f64], group: usize, want: Want, sums: &mut Sums) -> Result<Place, LawError> {
        let Sums { response, second, .. } = sums;
        let Sizes { displacements: n, pressures: m, .. } = self.sizes;
        let (q, pi) = y.split_at(n);
        let mut h = [Lanes::ZERO; 9];
        widest(Deformation { gradients: &self.gradients[group * n..][..n], q, h: &mut h });
        let mut f = h;
        [0, 4, 8].into_iter().for_each(|k| f[k] += Lanes::of(1.0));
        self.law.eval_lanes(&f, want, response).map_err(|(_, why)| why)?;
        if let Some(rates) = &self.rates {
            rates.add(group, &f, want, (response, second))?;
        }
        let mut place = Place { weight: self.weights[group], ..Place::default() };
        let Some(volumetric) = self.volumetric else { return Ok(place) };
        let mut p = Lanes::ZERO;
        for (value, share) in pi.iter().zip(&self.pressures[group * m..][..m]) {
            p += Lanes::of(*value) * *share;
        }
        let (mut dg, mut d2g) = (Lanes::ZERO, Lanes::ZERO);
        for lane in 0..LANES {
            let h = Mat3::from_fn(|i, j| h[3 * i + j].0[lane]);
            (place.gap.0[lane], dg.0[lane], d2g.0[lane]) = volumetric.gap(det_minus_one(&h))?;
        }
        place.cofactor = cofactor_by_rows(&f).map(|cof| dg * cof);
        widest(AddPressure { f: &f, p, dg, d2g, want, response });
        Ok(place)
    }
}

/// The parts of the forces at four points that P and A do not contain.
struct Place {
    weight: Lanes,
    /// G(J)
    gap: Lanes,
    /// G′ cof F row by row
    cofactor: [Lanes; 9],
}

impl Default for Place {
    fn default() -> Self {
        Self { weight: Lanes::ZERO, gap: Lanes::ZERO, cofactor: [Lanes::ZERO; 9] }
    }
}

/// Kernel that computes Σ_i q_i ∂v_i/∂X.
struct Deformation<'a> {
    gradients: &'a [[Lanes; 9]],
    q: &'a [f64],
    h: &'a mut [Lanes; 9],
}

impl Kernel for Deformation<'_> {
    #[inline(always)]
    fn run(self) {
        let mut h = [Lanes::ZERO; 9];
        for (gradient, q) in self.gradients.iter().zip(self.q) {
            let q = Lanes::of(*q);
            for n in 0..9 {
                h[n] += q * gradient[n];
            }
        }
        *self.h = h;
    }
}

/// Kernel that computes r_i += w P : ∂v_i/∂X for the displacement modes and r_c += w p_c G for the pressure modes.
struct Forces<'a> {
    gradients: &'a [[Lanes; 9]],
    pressures: &'a [Lanes],
    place: &'a Place,
    response: &'a LaneResponse,
    r: &'a mut [Lanes],
    /// Index of the first pressure in `r`: after the displacements, or 0 if each field has both
    first_pressure: usize,
}

impl Kernel for Forces<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { gradients, pressures, place, response, r, first_pressure } = self;
        let weighted = response.p.map(|p| place.weight * p);
        for (r, gradient) in r.iter_mut().zip(gradients) {
            *r += contract(&weighted, gradient);
        }
        let gap = place.weight * place.gap;
        for (r, p) in r[first_pressure..].iter_mut().zip(pressures) {
            *r += gap * *p;
        }
    }
}

/// Kernel that computes K_ij += w ∂v_i/∂X : A : ∂v_j/∂X and K_ci += w p_c G′ cof F : ∂v_i/∂X.
struct Hessian<'a> {
    gradients: &'a [[Lanes; 9]],
    pressures: &'a [Lanes],
    place: &'a Place,
    response: &'a LaneResponse,
    k: &'a mut [Lanes],
    products: &'a mut [[Lanes; 9]],
}

impl Kernel for Hessian<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { gradients, pressures, place, response, k, products } = self;
        let n = gradients.len() + pressures.len();
        for (product, gradient) in products.iter_mut().zip(gradients) {
            for (to, row) in product.iter_mut().zip(&response.a) {
                *to = place.weight * contract(row, gradient);
            }
        }
        for (i, gradient) in gradients.iter().enumerate() {
            for (k, product) in k[i * n..=i * n + i].iter_mut().zip(&*products) {
                *k += contract(gradient, product);
            }
        }
        for (c, p) in pressures.iter().enumerate() {
            let share = place.weight * *p;
            let row = &mut k[(gradients.len() + c) * n..][..gradients.len()];
            for (k, gradient) in row.iter_mut().zip(gradients) {
                *k += share * contract(&place.cofactor, gradient);
            }
        }
    }
}
