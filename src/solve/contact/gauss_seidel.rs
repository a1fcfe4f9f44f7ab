//! Forces p of points on planes under complementarity and friction, by Gauss–Seidel iteration over the points (Jourdan, Alart & Jean, Comput. Methods
//! Appl. Mech. Eng. 155, 1998); all constraints of the system form one additional block, whose multipliers are solved for exactly.
//!
//! ```text
//! g = g_free + W p      W = H K⁻¹ Hᵀ      0 ≤ g_n + c p_n ⟂ p_n ≥ 0 or p_n = −A φ′(g_n)      p_t = −μ p_n f(|g_t|/ε) g_t/|g_t|
//! ```
//!
//! The laws of one point are in [`contact_law`](super::law). Sweeps alone converge slowly if points share a load: from time to time Newton's method
//! for the fixed point of all of them is tried, and continued as long as it converges. If neither is going to converge, as with friction that jams or
//! without a solution, both are given up. If more points hold a body than it needs, W is singular: their compliance c, and the elastic slip of
//! friction, keep the tangent of Newton's method regular.
//!
//! Limits: W is dense, so that the method is suited for some hundreds of points. If more points hold a body than it needs, the sum of their forces is
//! exact, but the forces themselves are only as accurate as the compliance is resolved.

use super::law::ContactLaw;
use crate::math::statistics::larger;
use crate::math::tensor::Vec3;
use crate::math::vector::dot;
use crate::solve::Failure;
use crate::solve::limit::Limit;
use crate::solve::linear::multipliers::Schur;
use crate::system::{ContactPoint, Dofs, System};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Largest number of sweeps.
const SWEEPS: usize = 20_000;
/// Relative change of the value of a constraint for the numerical derivative of λ' \[–\].
const DIFFERENCE: f64 = 1e-3;
/// Accuracy: change of a gap over the last sweep relative to the largest gap, and of a force relative to the largest force \[–\].
const EXACT: f64 = 1e-10;

/// Number of sweeps after which Newton's method is first tried; it is tried again each time this number has doubled \[–\].
const TRIED: usize = 8;
/// Number of sweeps after which they must be converging \[–\].
const WATCHED: usize = 2048;
/// Largest number of iterations of Newton's method, and the share of the defect by which a full step has to reduce it; a shorter step, in proportion
/// \[–\].
const NEWTON: (usize, f64) = (30, 0.5);
/// Smallest share of a Newton step that is tried \[–\].
const SHORTEST: f64 = 0.05;

/// A point under pressure.
pub(super) struct Pressed<'a> {
    /// Index in the list of all contact points
    pub place: usize,
    /// Index of its normal component; two tangential ones follow if there is friction
    pub first: usize,
    law: ContactLaw<'a>,
}

/// The points under pressure, and the response to their forces; one entry for each force component.
#[derive(Default)]
pub(super) struct Contacts<'a> {
    pub points: Vec<Pressed<'a>>,
    /// H as lists of (equation, entry)
    h: Vec<Vec<(usize, f64)>>,
    /// Columns of K⁻¹ Hᵀ \[equations\]
    pub z: Vec<Vec<f64>>,
    /// g, or the sliding, without the effects of p and λ' − λ \[m\]
    free: Vec<f64>,
    /// Rows of W
    w: Vec<Vec<f64>>,
    /// \[constraints\] ∂c/∂x K⁻¹ Hᵀ, and H K⁻¹ ∂c/∂x
    cross: Vec<Vec<f64>>,
    back: Vec<Vec<f64>>,
    /// Forces p \[N\]
    pub p: Vec<f64>,
    /// Time spent on the forces, and multiplications
    pub time: Duration,
    pub work: f64,
}

/// Largest changes within the last two series of sweeps, each twice as long as the one before, to judge how fast the changes decrease.
#[derive(Default)]
struct Changes {
    earlier: f64,
    recent: f64,
}

impl Changes {
    /// Adds the change of this sweep.
    fn add(&mut self, sweep: usize, change: f64) {
        if (sweep - 1).is_power_of_two() {
            (self.earlier, self.recent) = (self.recent, 0.0);
        }
        self.recent = larger(self.recent, change);
    }

    /// Whether all sweeps would suffice if they continued as until `sweep`, a power of two s. The changes of the last s/2 sweeps are compared with
    /// those of the s/4 sweeps before, which are s/4 sweeps older, and extrapolated as a geometric sequence.
    fn lead_to(&self, enough: f64, sweep: usize) -> bool {
        let quarters = (SWEEPS - sweep / 2) as f64 / (sweep / 4) as f64;
        self.recent * (self.recent / self.earlier).powf(quarters) <= enough
    }
}

/// The equations p − P(q(p)) = 0, evaluated at some forces p.
struct Defect {
    /// Defect p − P(q(p)) \[N\]
    forces: DVector<f64>,
    /// Derivative with respect to p
    tangent: DMatrix<f64>,
    /// [`ContactLaw::amplification`] of each component
    amplification: Vec<f64>,
}

impl<'a> Contacts<'a> {
    /// Builds points with these laws and without constraints, each with its distance without forces, and with its sliding if it has friction, and the
    /// response W \[rows\] to forces on all of them.
    pub fn with_response(laws: impl Iterator<Item = ContactLaw<'a>>, free: Vec<f64>, w: Vec<Vec<f64>>) -> Self {
        let n = free.len();
        let mut first = 0;
        let point = |(place, law): (usize, ContactLaw<'a>)| {
            let own = first;
            first += if law.friction.is_some() { 3 } else { 1 };
            Pressed { place, first: own, law }
        };
        let points = laws.enumerate().map(point).collect();
        Self { points, free, w, back: vec![Vec::new(); n], p: vec![0.0; n], ..Self::default() }
    }

    /// Adds a point with its gap and its displacement since the start of the step \[m\], both without the contributions of the solution.
    pub fn add(&mut self, system: &System, place: usize, point: &ContactPoint<'a>, (gap, displacement): (f64, Vec3)) {
        let row = |shares: &[f64], direction: &Vec3| -> Vec<(usize, f64)> {
            let entries = point.nodes.iter().zip(shares).flat_map(|(&node, share)| {
                (0..3).map(move |i| (system.dofs.equation[3 * node as usize + i], share * direction[i]))
            });
            let free = entries.filter(|(equation, _)| *equation != Dofs::FIXED);
            free.map(|(equation, entry)| (equation as usize, entry)).collect()
        };
        let normal = row(&point.shares, &point.normal);
        // A point whose motion is prescribed completely cannot be corrected
        if normal.is_empty() {
            return;
        }
        let first = self.h.len();
        self.h.push(normal);
        self.free.push(gap);
        if point.friction.is_some() {
            for along in point.across() {
                self.h.push(row(&point.spot, &along));
                self.free.push(along.dot(&displacement));
            }
        }
        self.points.push(Pressed { place, first, law: ContactLaw::new(point) });
    }

    /// Hᵀ of the components that were added last, column by column.
    pub fn columns(&self, equations: usize) -> Vec<f64> {
        let fresh = &self.h[self.z.len()..];
        let mut columns = vec![0.0; fresh.len() * equations];
        for (column, row) in columns.chunks_exact_mut(equations).zip(fresh) {
            row.iter().for_each(|&(equation, entry)| column[equation] += entry);
        }
        columns
    }

    /// Adds the response to these components, `columns` = K⁻¹ Hᵀ; y = K⁻¹ (−r).
    pub fn respond(&mut self, columns: &[f64], y: &[f64], schur: &Schur, gradient: &[Vec<f64>]) {
        let along = |row: &[(usize, f64)], v: &[f64]| row.iter().map(|&(e, entry)| entry * v[e]).sum::<f64>();
        let known = self.z.len();
        self.z.extend(columns.chunks_exact(y.len()).map(<[f64]>::to_vec));
        self.p.resize(self.z.len(), 0.0);
        for i in known..self.z.len() {
            self.free[i] += along(&self.h[i], y);
            self.cross.push(gradient.iter().map(|h| dot(h, &self.z[i])).collect());
            self.back.push(schur.z.chunks_exact(y.len()).map(|z| along(&self.h[i], z)).collect());
        }
        self.w = self.h.iter().map(|row| self.z.iter().map(|z| along(row, z)).collect()).collect();
    }

    /// Solves for the forces p. `multipliers` returns λ' for given changes of the values of the constraints due to p. Returns λ'. Stops if the
    /// `limit` is reached, if neither the sweeps nor Newton's method are going to converge, and after `most` multiplications.
    pub fn settle(
        &mut self,
        multipliers: impl Fn(&[f64]) -> Result<Vec<f64>, Failure>,
        old: &[f64],
        (limit, most): (&Limit, f64),
    ) -> Result<Vec<f64>, Failure> {
        let start = Instant::now();
        let settled = self.sweep(multipliers, old, (limit, most));
        self.time += start.elapsed();
        settled
    }

    fn sweep(
        &mut self,
        multipliers: impl Fn(&[f64]) -> Result<Vec<f64>, Failure>,
        old: &[f64],
        (limit, most): (&Limit, f64),
    ) -> Result<Vec<f64>, Failure> {
        let size = self.p.len() as f64;
        let enough = EXACT * self.free.iter().fold(0.0, |m: f64, g| m.max(g.abs()));
        let (mut changes, mut is_lost) = (Changes::default(), false);
        for sweep in 1..=SWEEPS {
            if limit.reached().is_some() {
                return Err(Failure::LimitReached);
            }
            if self.work > most {
                return Err(Failure::Complementarity);
            }
            self.work += size * size;
            let lambda = multipliers(&self.crossing())?;
            let mut change = 0.0;
            for k in 0..self.points.len() {
                let (range, p, _) = self.force_on(k, &lambda, old);
                for (i, p) in range.zip(&p) {
                    change = larger(change, self.w[i][i] * (self.p[i] - p).abs());
                    self.p[i] = *p;
                }
            }
            if change <= enough {
                self.iterate(&multipliers, old, f64::INFINITY)?;
                return multipliers(&self.crossing());
            }
            if is_lost {
                break;
            }
            changes.add(sweep, change);
            if sweep >= TRIED && sweep.is_power_of_two() {
                self.iterate(&multipliers, old, most)?;
                // The next sweep shows whether Newton's method has found the forces
                is_lost = sweep >= WATCHED && !changes.lead_to(enough, sweep);
            }
        }
        Err(Failure::Complementarity)
    }

    /// Changes of the values of the constraints due to p.
    fn crossing(&self) -> Vec<f64> {
        let constraints = self.cross.first().map_or(0, Vec::len);
        (0..constraints).map(|c| self.cross.iter().zip(&self.p).map(|(cross, p)| cross[c] * p).sum()).collect()
    }

    /// Returns the components of point `k`, the force on it given those on all others, and its derivative with respect to the displacement without
    /// it.
    fn force_on(&self, k: usize, lambda: &[f64], old: &[f64]) -> (Range<usize>, Vector3<f64>, Matrix3<f64>) {
        let Pressed { first: n, law, .. } = &self.points[k];
        let range = *n..n + if law.friction.is_some() { 3 } else { 1 };
        let own = self.own(k);
        let mut q = Vector3::zeros();
        for (component, i) in range.clone().enumerate() {
            let by_rows: f64 =
                self.back[i].iter().zip(lambda.iter().zip(old)).map(|(b, (new, old))| b * (new - old)).sum();
            q[component] =
                self.free[i] - by_rows + dot(&self.w[i], &self.p) - own[usize::from(component > 0)] * self.p[i];
        }
        let (p, slope) = law.force(&q, own);
        (range, p, slope)
    }

    /// The response w of point `k` to its own force, for the normal component and for sliding; for sliding, the larger eigenvalue represents both
    /// directions.
    fn own(&self, k: usize) -> [f64; 2] {
        let Pressed { first: n, law, .. } = &self.points[k];
        let w = |i: usize, j: usize| self.w[n + i][n + j];
        let sliding = law.friction.map_or(0.0, |_| {
            0.5 * (w(1, 1) + w(2, 2)) + (0.25 * (w(1, 1) - w(2, 2)).powi(2) + w(1, 2) * w(2, 1)).sqrt()
        });
        [w(0, 0), sliding]
    }

    /// Applies Newton's method to p − P(q(p)) = 0, where P are the forces on all points as functions of their displacements q without them, as long
    /// as it converges: sweeps alone converge slowly if points share a load. It ends when the laws give the forces p at the displacements that p
    /// leaves, or at their rounding level, where the defect no longer decreases, or after `most` multiplications.
    fn iterate(
        &mut self,
        multipliers: impl Fn(&[f64]) -> Result<Vec<f64>, Failure>,
        old: &[f64],
        most: f64,
    ) -> Result<(), Failure> {
        let count = self.p.len() as f64;
        let mut defect = self.defect(&multipliers, old)?;
        for _ in 0..NEWTON.0 {
            let off = defect.forces.iter().zip(&defect.amplification).map(|(d, times)| (d * times).abs());
            if off.fold(0.0, larger) <= EXACT * self.p.iter().fold(0.0, |m: f64, p| m.max(p.abs())) {
                return Ok(());
            }
            // An LU decomposition, and the tangent
            let work = count.powi(3) / 3.0 + count * count;
            if self.work + work > most {
                return Ok(());
            }
            self.work += work;
            let size = self.size(&defect.forces);
            let Some(step) = defect.tangent.lu().solve(&defect.forces) else { return Ok(()) };
            let (before, mut share) = (self.p.clone(), 1.0);
            loop {
                self.p.iter_mut().zip(&before).zip(step.iter()).for_each(|((p, old), d)| *p = old - share * d);
                defect = self.defect(&multipliers, old)?;
                // NaN is not smaller
                if self.size(&defect.forces) <= (1.0 - NEWTON.1 * share) * size {
                    break;
                }
                share *= 0.5;
                if share < SHORTEST {
                    self.p = before;
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Largest displacement that corresponds to a defect of p.
    fn size(&self, defect: &DVector<f64>) -> f64 {
        (0..defect.len()).map(|i| self.w[i][i] * defect[i].abs()).fold(0.0, larger)
    }

    /// Computes the defect of the current forces.
    fn defect(
        &self,
        multipliers: impl Fn(&[f64]) -> Result<Vec<f64>, Failure>,
        old: &[f64],
    ) -> Result<Defect, Failure> {
        let (n, crossing) = (self.p.len(), self.crossing());
        let lambda = multipliers(&crossing)?;
        // λ' is piecewise linear in the values of the constraints
        let mut by_value = Vec::new();
        for c in 0..crossing.len() {
            let mut other = crossing.clone();
            let step = DIFFERENCE * other[c].abs().max(f64::MIN_POSITIVE.sqrt());
            other[c] += step;
            let changed = multipliers(&other)?;
            by_value.push(changed.iter().zip(&lambda).map(|(new, old)| (new - old) / step).collect::<Vec<f64>>());
        }
        let mut forces = DVector::from_column_slice(&self.p);
        let (mut tangent, mut amplification) = (DMatrix::identity(n, n), vec![0.0; n]);
        for k in 0..self.points.len() {
            let (range, p, slope) = self.force_on(k, &lambda, old);
            let own = self.own(k);
            let times = self.points[k].law.amplification(&slope, own);
            for (a, i) in range.clone().enumerate() {
                forces[i] -= p[a];
                amplification[i] = times[usize::from(a > 0)];
            }
            for j in 0..n {
                // Derivative of λ' − λ with respect to p_j
                let by_force = |row: usize| -> f64 {
                    by_value.iter().zip(&self.cross[j]).map(|(by_value, cross)| by_value[row] * cross).sum()
                };
                let moved: Vec<f64> = (0..crossing.len()).map(by_force).collect();
                for (b, i) in range.clone().enumerate() {
                    let alone = if i == j { own[usize::from(b > 0)] } else { 0.0 };
                    let q = self.w[i][j] - alone - dot(&self.back[i], &moved);
                    for (a, row) in range.clone().enumerate() {
                        tangent[(row, j)] -= slope[(a, b)] * q;
                    }
                }
            }
        }
        Ok(Defect { forces, tangent, amplification })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::NormalLaw;
    use std::cell::Cell;

    /// A point that is pressed, with friction.
    fn alone() -> ContactPoint<'static> {
        ContactPoint {
            nodes: vec![],
            shares: vec![],
            spot: vec![],
            sliding: vec![],
            gap: -1.0,
            normal: Vec3::z(),
            force: 0.0,
            friction: Some((1.0, 1e-9)),
            history: 0,
            turn: Matrix3::identity(),
            law: NormalLaw::Unilateral { yielding: 0.0 },
        }
    }

    /// A geometric sequence needs ln(10⁻¹⁰)/ln ρ sweeps: 11 500 with ρ = 0.998, 23 000 with 0.999. A cycle and a growing sequence never end.
    #[test]
    fn sweeps_that_do_not_shrink_fast_enough_are_seen() {
        let lead = |change: &dyn Fn(usize) -> f64, until: usize| {
            let mut changes = Changes::default();
            (1..=until).for_each(|sweep| changes.add(sweep, change(sweep)));
            changes.lead_to(EXACT, until)
        };
        for until in [128, 1024, 8192] {
            assert!(lead(&|s| 0.998f64.powi(s as i32), until), "{until}");
            assert!(!lead(&|s| 0.999f64.powi(s as i32), until), "{until}");
            assert!(!lead(&|s| [1e-3, 0.7, 2e-6][s % 3], until), "{until}");
            assert!(!lead(&|s| 1.5f64.powi(s as i32), until), "{until}");
        }
    }

    /// Four corners of a rigid square under an off-centre weight: three motions for four forces. The compliance distributes the weight with the least
    /// sum of squares, p_i = N/4 + (a x_i + b y_i)/4 with its moments a and b, after Newton's method instead of thousands of sweeps.
    #[test]
    fn points_that_share_a_load_settle_at_once() {
        let point = ContactPoint { law: NormalLaw::Unilateral { yielding: 1e-12 }, friction: None, ..alone() };
        let corners = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let (weight, a, b) = (2.0, 0.3, -0.5);
        let w = |[x, y]: [f64; 2], [u, v]: [f64; 2]| 1e-3 * (1.0 + 3.0 * x * u + 3.0 * y * v);
        let mut contacts = Contacts {
            points: (0..4).map(|k| Pressed { place: k, first: k, law: ContactLaw::new(&point) }).collect(),
            h: vec![vec![]; 4],
            z: vec![vec![]; 4],
            free: corners.map(|[x, y]| -1e-3 * (weight + 3.0 * (a * x + b * y))).to_vec(),
            w: corners.map(|p| corners.map(|q| w(p, q)).to_vec()).to_vec(),
            back: vec![vec![]; 4],
            p: vec![0.0; 4],
            ..Contacts::default()
        };
        let sweeps = Cell::new(0);
        let none = |_: &[f64]| {
            sweeps.set(sweeps.get() + 1);
            Ok(vec![])
        };
        contacts.settle(none, &[], (&Limit::default(), f64::INFINITY)).expect("forces");
        for (p, [x, y]) in contacts.p.iter().zip(corners) {
            let exact = (weight + a * x + b * y) / 4.0;
            // The compliance is 1e-9 of W, and the rounding of W is 1e-16 of it: 1e-7 of a force
            assert!((p - exact).abs() < 1e-5 * weight, "{p} for {exact}");
        }
        assert!(sweeps.get() < 50, "{} sweeps", sweeps.get());
    }

    /// A sliding point whose friction presses it on by more than the pressure itself pushes it off, W = [[1, 1.2], [1.2, 1]] and μ = 1: no force
    /// lifts it. The sweeps end soon, however rounding affects the growing forces, and sooner where few multiplications are allowed: nine a sweep.
    #[test]
    fn forces_without_a_solution_are_given_up() {
        let point = alone();
        for (most, count) in [(f64::INFINITY, 4000), (1e3, 500)] {
            let mut contacts = Contacts {
                points: vec![Pressed { place: 0, first: 0, law: ContactLaw::new(&point) }],
                h: vec![vec![]; 3],
                z: vec![vec![]; 3],
                free: vec![-1.0, 1e3, 0.0],
                w: vec![vec![1.0, 1.2, 0.0], vec![1.2, 1.0, 0.0], vec![0.0, 0.0, 1.0]],
                back: vec![vec![]; 3],
                p: vec![0.0; 3],
                ..Contacts::default()
            };
            let sweeps = Cell::new(0);
            let none = |_: &[f64]| {
                sweeps.set(sweeps.get() + 1);
                Ok(vec![])
            };
            let settled = contacts.settle(none, &[], (&Limit::default(), most));
            assert!(matches!(settled, Err(Failure::Complementarity)), "{:?}", contacts.p);
            assert!(sweeps.get() < count, "{} sweeps", sweeps.get());
        }
    }
}
