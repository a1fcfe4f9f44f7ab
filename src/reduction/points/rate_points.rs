//! Rate-dependent forces at the points of a reduced model: viscosity and relaxation of the material, with the history of the points.
//!
//! They are the forces of the effects [`ViscousDamping`](crate::effect::ViscousDamping) and [`Viscoelastic`](crate::effect::Viscoelastic), written
//! for four points side by side and steps of constant length:
//!
//! P += η/(2Δt) F (FᵀF − FₙᵀFₙ), P += (Σ β_α d_α − ρ) ∂W/∂F + m(FH − ⅓q G), H = Σ β_α d_α (d_α hₙ_α − S̃ₙ), d_α = e^{−Δt/2τ_α},
//!
//! with m = J^{−2/3}, q = H:C, G = F⁻ᵀ. Both are gradients of potentials of F over a step, so that the tangent is symmetric.

use super::lanes::contract;
use crate::effect::{cofactor_by_rows, viscous_stress};
use crate::material::{LaneResponse, Law, LawError, Prony, Want};
use crate::math::lanes::{Kernel, LANES, Lanes, Real, widest};
use serde::{Deserialize, Serialize};

/// Rate-dependent forces at the points of one law as stored in a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StoredRates {
    /// η \[Pa s\]
    pub viscosity: f64,
    /// Prony series by which the isochoric part of the law relaxes
    pub relaxation: Option<Prony>,
}

impl StoredRates {
    /// Whether there are no rate-dependent forces.
    pub fn is_none(&self) -> bool {
        self.viscosity == 0.0 && self.relaxation.is_none()
    }

    /// Whether the values are valid for a viscosity and a Prony series.
    pub fn is_sound(&self) -> bool {
        let series = |p: &Prony| {
            let arm = |(beta, tau): &(f64, f64)| *beta > 0.0 && beta.is_finite() && *tau > 0.0 && tau.is_finite();
            (0.0..1.0).contains(&p.relaxed) && !p.arms.is_empty() && p.arms.iter().all(arm)
        };
        self.viscosity >= 0.0 && self.viscosity.is_finite() && self.relaxation.as_ref().is_none_or(series)
    }
}

/// Stored components of a symmetric tensor, as indices into the full tensor row by row.
const KEPT: [usize; 6] = [0, 4, 8, 5, 2, 1];
/// For each component of the full tensor, its index among the stored components.
const PLACE: [usize; 9] = [0, 5, 4, 5, 1, 3, 4, 3, 2];

/// Rate-dependent forces at the points of one law, over steps of constant length.
pub struct RatePoints {
    /// η/(2Δt)
    viscous: f64,
    /// \[groups\] F at the start of the step
    old: Vec<[Lanes; 9]>,
    relaxation: Option<Relaxation>,
}

struct Relaxation {
    /// W, if it differs from the law of the points; `None` otherwise
    part: Option<Box<dyn Law>>,
    /// Σ β d − ρ
    factor: f64,
    /// (β, d)
    arms: Vec<(f64, f64)>,
    /// \[groups\] H
    remembered: Vec<[Lanes; 6]>,
}

impl RatePoints {
    /// Builds the points in `groups` for steps of `dt` \[s\]; `whole` is the law of the points, unless this is already its isochoric part.
    pub fn new(of: &StoredRates, whole: Option<&dyn Law>, groups: usize, dt: f64) -> Self {
        let relaxation = of.relaxation.as_ref().map(|series| {
            let arms: Vec<(f64, f64)> =
                series.arms.iter().map(|&(beta, tau)| (beta, (-0.5 * dt / tau).exp())).collect();
            Relaxation {
                part: whole.and_then(Law::split).map(|(part, _)| part),
                factor: arms.iter().map(|(beta, d)| beta * d).sum::<f64>() - series.relaxed,
                arms,
                remembered: vec![[Lanes::ZERO; 6]; groups],
            }
        });
        Self { viscous: 0.5 * of.viscosity / dt, old: vec![[Lanes::ZERO; 9]; groups], relaxation }
    }

    /// Size of the history of each group of points: S̃, then h of each arm, lane by lane.
    pub fn size(&self) -> usize {
        self.relaxation.as_ref().map_or(0, |r| 6 * LANES * (1 + r.arms.len()))
    }

    /// Starts a step of a group, with F and the history there.
    pub fn begin(&mut self, group: usize, f: &[Lanes; 9], memory: &[f64]) {
        self.old[group] = *f;
        let Some(Relaxation { arms, remembered, .. }) = &mut self.relaxation else { return };
        for (k, h) in remembered[group].iter_mut().enumerate() {
            let at = |tensor: usize| in_lanes(memory, 6 * tensor + k);
            *h = Lanes::ZERO;
            for (arm, (beta, d)) in arms.iter().enumerate() {
                *h += Lanes::of(beta * d) * (Lanes::of(*d) * at(1 + arm) - at(0));
            }
        }
    }

    /// Adds the rate-dependent P and A at F to those of the law of the points.
    pub fn add(
        &self,
        group: usize,
        f: &[Lanes; 9],
        want: Want,
        (response, second): (&mut LaneResponse, &mut LaneResponse),
    ) -> Result<(), LawError> {
        if let Some(relaxation) = &self.relaxation {
            match &relaxation.part {
                Some(part) => {
                    part.eval_lanes(f, want, second).map_err(|(_, why)| why)?;
                    widest(AddTimes { factor: relaxation.factor, of: second, want, response });
                }
                None => {
                    second.p = response.p;
                    if want == Want::Tangent {
                        second.a = response.a;
                    }
                    widest(AddTimes { factor: relaxation.factor, of: second, want, response });
                }
            }
            widest(AddRemembered { f, powers: powers(f), h: &relaxation.remembered[group], want, response });
        }
        if self.viscous != 0.0 {
            widest(AddViscous { f, old: &self.old[group], c: self.viscous, want, response });
        }
        Ok(())
    }

    /// Computes the history of a group at the end of a step at F, with the law of the points; `second` is workspace.
    pub fn advance(
        &self,
        law: &dyn Law,
        f: &[Lanes; 9],
        second: &mut LaneResponse,
        (memory, next): (&[f64], &mut [f64]),
    ) -> Result<(), LawError> {
        let Some(Relaxation { part, arms, .. }) = &self.relaxation else { return Ok(()) };
        part.as_deref().unwrap_or(law).eval_lanes(f, Want::Residual, second).map_err(|(_, why)| why)?;
        let mut stress = [Lanes::ZERO; 9];
        widest(Unscaled { f, powers: powers(f), p: &second.p, stress: &mut stress });
        for (k, &whole) in KEPT.iter().enumerate() {
            let transposed = 3 * (whole % 3) + whole / 3;
            let now = Lanes::of(0.5) * (stress[whole] + stress[transposed]);
            let change = now - in_lanes(memory, k);
            next[LANES * k..][..LANES].copy_from_slice(&now.0);
            for (arm, (_, d)) in arms.iter().enumerate() {
                let place = 6 * (1 + arm) + k;
                let h = Lanes::of(*d) * (Lanes::of(*d) * in_lanes(memory, place) + change);
                next[LANES * place..][..LANES].copy_from_slice(&h.0);
            }
        }
        Ok(())
    }
}

fn in_lanes(memory: &[f64], k: usize) -> Lanes {
    Lanes(std::array::from_fn(|lane| memory[LANES * k + lane]))
}

/// Returns 1/J and J^{−2/3}; requires J > 0.
fn powers(f: &[Lanes; 9]) -> (Lanes, Lanes) {
    let cof = cofactor_by_rows(f);
    let j = f[0] * cof[0] + f[1] * cof[1] + f[2] * cof[2];
    (Lanes(j.0.map(f64::recip)), Lanes(j.0.map(|j| j.powf(-2.0 / 3.0))))
}

/// Kernel that computes P += c P′ and A += c A′.
struct AddTimes<'a> {
    factor: f64,
    of: &'a LaneResponse,
    want: Want,
    response: &'a mut LaneResponse,
}

impl Kernel for AddTimes<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { factor, of, want, response } = self;
        let factor = Lanes::of(factor);
        for (p, other) in response.p.iter_mut().zip(&of.p) {
            *p += factor * *other;
        }
        if want == Want::Tangent {
            for (a, other) in response.a.as_flattened_mut().iter_mut().zip(of.a.as_flattened()) {
                *a += factor * *other;
            }
        }
    }
}

/// Kernel that computes P += m(FH − ⅓q G) and A += m\[δ_ik H_LJ − ⅔((FH)_iJ G_kL + G_iJ (FH)_kL) + (2/9) q G_iJ G_kL + ⅓q G_iL G_kJ\].
struct AddRemembered<'a> {
    f: &'a [Lanes; 9],
    powers: (Lanes, Lanes),
    h: &'a [Lanes; 6],
    want: Want,
    response: &'a mut LaneResponse,
}

impl Kernel for AddRemembered<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { f, powers: (inverse, m), h, want, response } = self;
        let h: [Lanes; 9] = std::array::from_fn(|n| h[PLACE[n]]);
        let g = cofactor_by_rows(f).map(|cof| cof * inverse);
        let fh: [Lanes; 9] = std::array::from_fn(|n| {
            let (i, j) = (n / 3, n % 3);
            f[3 * i] * h[j] + f[3 * i + 1] * h[3 + j] + f[3 * i + 2] * h[6 + j]
        });
        let q = contract(f, &fh);
        let third = m * q * Lanes::of(1.0 / 3.0);
        for n in 0..9 {
            response.p[n] += m * fh[n] - third * g[n];
        }
        if want < Want::Tangent {
            return;
        }
        let minus = Lanes::of(-2.0 / 3.0) * m;
        for (row, a) in response.a.iter_mut().enumerate() {
            let (i, j) = (row / 3, row % 3);
            for (column, a) in a.iter_mut().enumerate() {
                let (k, l) = (column / 3, column % 3);
                let dyads = minus * (fh[row] * g[column] + g[row] * fh[column]);
                let squares = third * (Lanes::of(2.0 / 3.0) * g[row] * g[column] + g[3 * i + l] * g[3 * k + j]);
                *a += dyads + squares;
                if i == k {
                    *a += m * h[3 * l + j];
                }
            }
        }
    }
}

struct AddViscous<'a> {
    f: &'a [Lanes; 9],
    old: &'a [Lanes; 9],
    c: f64,
    want: Want,
    response: &'a mut LaneResponse,
}

impl Kernel for AddViscous<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { f, old, c, want, response } = self;
        let (mut p, mut a) = ([Lanes::ZERO; 9], [[Lanes::ZERO; 9]; 9]);
        viscous_stress(f, old, c, want, &mut p, &mut a);
        for (to, p) in response.p.iter_mut().zip(p) {
            *to += p;
        }
        if want == Want::Tangent {
            for (to, a) in response.a.as_flattened_mut().iter_mut().zip(a.as_flattened()) {
                *to += *a;
            }
        }
    }
}

/// Kernel that computes J^{2/3} F⁻¹ P.
struct Unscaled<'a> {
    f: &'a [Lanes; 9],
    powers: (Lanes, Lanes),
    p: &'a [Lanes; 9],
    stress: &'a mut [Lanes; 9],
}

impl Kernel for Unscaled<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { f, powers: (inverse, scale), p, stress } = self;
        let cof = cofactor_by_rows(f);
        for (n, to) in stress.iter_mut().enumerate() {
            let (i, j) = (n / 3, n % 3);
            *to = inverse * (cof[i] * p[j] + cof[3 + i] * p[3 + j] + cof[6 + i] * p[6 + j]);
        }
        let scale = Lanes(scale.0.map(f64::recip));
        stress.iter_mut().for_each(|s| *s = scale * *s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{Arm, Constants, law_from_table};
    use crate::math::random::SplitMix;

    /// The tangent is symmetric and equals central differences of P with h = 1e-5: truncation h² and rounding 1e-16/h leave 1e-10 of it.
    #[test]
    fn the_tangent_is_symmetric_and_the_derivative_of_the_stress() {
        let table = "law = 'neo_hookean'\nmu = '1 Pa'\nnu = 0.3".parse().expect("a table");
        let law = law_from_table(&table).expect("a law");
        let arms = [Arm { g: 0.3, tau: 0.02 }, Arm { g: 0.2, tau: 0.3 }];
        let relaxation = Prony::new(&arms, Constants::Instantaneous).ok();
        let stored = StoredRates { viscosity: 0.05, relaxation };
        assert!(stored.is_sound() && !stored.is_none());
        let mut points = RatePoints::new(&stored, Some(&*law), 1, 0.01);
        let mut random = SplitMix(3);
        let mut tensor = |size: f64| -> [Lanes; 9] {
            std::array::from_fn(|n| {
                Lanes(std::array::from_fn(|_| f64::from(n % 4 == 0) + size * (random.unit() - 0.5)))
            })
        };
        let (old, f) = (tensor(0.6), tensor(0.6));
        let memory: Vec<f64> = tensor(1.0).iter().chain(&tensor(1.0)).flat_map(|l| l.0).take(points.size()).collect();
        assert_eq!(memory.len(), points.size());
        points.begin(0, &old, &memory);
        let eval = |f: &[Lanes; 9], want: Want| {
            let (mut response, mut second) = (LaneResponse::default(), LaneResponse::default());
            points.add(0, f, want, (&mut response, &mut second)).expect("J > 0");
            response
        };
        let exact = eval(&f, Want::Tangent);
        let h = 1e-5;
        for column in 0..9 {
            let moved = |sign: f64| {
                let mut f = f;
                f[column] += Lanes::of(sign * h);
                eval(&f, Want::Residual).p
            };
            let (plus, minus) = (moved(1.0), moved(-1.0));
            for row in 0..9 {
                for lane in 0..LANES {
                    let a = exact.a[row][column].0[lane];
                    let difference = (plus[row].0[lane] - minus[row].0[lane]) / (2.0 * h);
                    let mirrored = exact.a[column][row].0[lane];
                    assert!(
                        (a - difference).abs() < 1e-7 * (1.0 + a.abs()),
                        "A[{row}][{column}]: {a} and {difference}"
                    );
                    assert!((a - mirrored).abs() < 1e-12 * (1.0 + a.abs()), "A[{row}][{column}]: {a} and {mirrored}");
                }
            }
        }
    }
}
