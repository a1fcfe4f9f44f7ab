//! The force on one contact point whose distance and sliding depend on that force: d = q_n + w_n p_n, u = q_t + w_t p_t, where q includes the effect
//! of all other forces, and c is the compliance of a unilateral point.
//!
//! ```text
//! 0 ≤ d + c p_n ⟂ p_n ≥ 0 or p_n = −A φ′(d)      p_t = −μ p_n f(|u|/ε) u/|u|
//! ```

use crate::system::friction::{Resistance, resistance};
use crate::system::{ContactPoint, NormalLaw};
use nalgebra::{Matrix3, Vector3};

/// Largest number of iterations for the distance of a point with a potential.
const ITERATIONS: usize = 200;

/// The contact law of one point: normal force and friction.
#[derive(Clone, Copy)]
pub(super) struct ContactLaw<'a> {
    normal: NormalLaw<'a>,
    /// μ |m| \[–\] and ε \[m\]
    pub friction: Option<(f64, f64)>,
}

impl<'a> ContactLaw<'a> {
    pub fn new(point: &ContactPoint<'a>) -> Self {
        let size = point.normal.norm();
        let friction = point.friction.map(|(coefficient, epsilon)| (coefficient * size, epsilon));
        Self { normal: point.law, friction }
    }

    /// The law of a point with the compliance `yielding` \[m/N\] when it is pressed, whatever its own normal law; with its friction.
    pub fn unilateral(point: &ContactPoint, yielding: f64) -> Self {
        let ContactLaw { friction, .. } = ContactLaw::new(point);
        Self { normal: NormalLaw::Unilateral { yielding }, friction }
    }

    /// Returns p and ∂p/∂q; without friction the sliding components are zero. `w` \[m/N\] is that of the normal component, and that of sliding.
    pub fn force(&self, q: &Vector3<f64>, w: [f64; 2]) -> (Vector3<f64>, Matrix3<f64>) {
        let (normal, by_gap) = self.normal_force(q.x, w[0]);
        let (mut p, mut slope) = (Vector3::new(normal, 0.0, 0.0), Matrix3::zeros());
        slope[(0, 0)] = by_gap;
        let size = q.y.hypot(q.z);
        let Some((coefficient, epsilon)) = self.friction else { return (p, slope) };
        let Resistance { force, by_sliding, by_limit } = resistance(size, w[1], coefficient * normal, epsilon);
        let along = if size > 0.0 { [q.y / size, q.z / size] } else { [0.0; 2] };
        // At zero sliding the ratio is the derivative
        let share = if size > 0.0 { force / size } else { by_sliding };
        for i in 0..2 {
            p[i + 1] = -force * along[i];
            slope[(i + 1, 0)] = -by_limit * coefficient * by_gap * along[i];
            for j in 0..2 {
                let same = if i == j { share } else { 0.0 };
                slope[(i + 1, j + 1)] = -same - (by_sliding - share) * along[i] * along[j];
            }
        }
        (p, slope)
    }

    /// Factor by which the forces of the law at the displacements q + w p are more wrong than p itself, for the normal component and for sliding: 1 +
    /// w s for a law of stiffness s, with ∂p/∂q = −s/(1 + w s). It is 1 for the normal force of a unilateral point, which is an unknown of its own.
    pub fn amplification(&self, slope: &Matrix3<f64>, w: [f64; 2]) -> [f64; 2] {
        let of = |w: f64, give: f64| 1.0 / (1.0 - w * give).max(f64::EPSILON);
        let normal = match self.normal {
            NormalLaw::Unilateral { .. } => 1.0,
            NormalLaw::Potential(..) => of(w[0], -slope[(0, 0)]),
        };
        let (mean, half) = (0.5 * (slope[(1, 1)] + slope[(2, 2)]), 0.5 * (slope[(1, 1)] - slope[(2, 2)]));
        [normal, of(w[1], half.hypot(slope[(1, 2)]) - mean)]
    }

    /// Returns p_n and ∂p_n/∂q_n.
    fn normal_force(&self, free: f64, w: f64) -> (f64, f64) {
        let (potential, area) = match self.normal {
            NormalLaw::Unilateral { yielding } if free < 0.0 => return (-free / (w + yielding), -1.0 / (w + yielding)),
            NormalLaw::Unilateral { .. } => return (0.0, 0.0),
            NormalLaw::Potential(potential, area) => (potential, area),
        };
        let reach = potential.reach();
        if free >= reach {
            return (0.0, 0.0);
        }
        // d − free + A w φ′(d) increases with d
        let (mut low, mut high) = (free, reach);
        let mut d = 0.5 * (low.max(0.0) + high);
        let (mut force, mut stiffness) = (0.0, 0.0);
        for _ in 0..ITERATIONS {
            let Some([_, first, second]) = potential.potential(d) else {
                low = d;
                d = 0.5 * (low + high);
                continue;
            };
            (force, stiffness) = (-first * area, second * area);
            let excess = d - free - w * force;
            match excess < 0.0 {
                true => low = d,
                false => high = d,
            }
            let newton = d - excess / (1.0 + w * stiffness);
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - d).abs() <= f64::EPSILON * reach.max(d.abs()) {
                break;
            }
            d = next;
        }
        (force, -stiffness / (1.0 + w * stiffness))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::tensor::Vec3;
    use crate::system::ContactPotential;

    /// φ = −κ (d − r)² ln(d/r) for 0 < d < r
    struct Barrier;

    const REACH: f64 = 1e-4;

    impl ContactPotential for Barrier {
        fn reach(&self) -> f64 {
            REACH
        }

        fn potential(&self, d: f64) -> Option<[f64; 3]> {
            if d <= 0.0 {
                return None;
            }
            let (e, ln) = ((d - REACH).min(0.0), (d / REACH).ln());
            let first = -1e9 * e * (2.0 * ln + e / d);
            let second = -1e9 * (2.0 * ln + 4.0 * e / d - (e / d).powi(2));
            Some([-1e9 * e * e * ln, first, if e < 0.0 { second } else { 0.0 }])
        }
    }

    /// \[m/N\], large enough to matter compared with w
    const YIELDING: f64 = 1e-5;

    fn laws() -> [ContactLaw<'static>; 3] {
        let friction = Some((0.4, 2e-6));
        let barrier = NormalLaw::Potential(&Barrier, 3e-6);
        [
            ContactLaw { normal: NormalLaw::Unilateral { yielding: YIELDING }, friction },
            ContactLaw { normal: barrier, friction },
            ContactLaw { normal: barrier, friction: None },
        ]
    }

    const W: [f64; 2] = [2e-4, 5e-4];

    /// From far inside to out of reach, sticking and sliding
    fn displacements() -> impl Iterator<Item = Vec3> {
        let gaps = [-3e-3, -1e-5, 2e-5, 0.9e-4, 1.2e-4];
        let slidings = [(0.0, 0.0), (1e-7, -3e-7), (2e-6, 1e-6), (-4e-4, 1e-3)];
        gaps.into_iter().flat_map(move |gap| slidings.map(|(a, b)| Vec3::new(gap, a, b)))
    }

    /// The law gives the same force at the distance and the sliding that the force leaves. The distance is solved for to the rounding of the reach,
    /// over which the force of the barrier changes by at most itself times reach over distance: 1e-9.
    #[test]
    fn forces_obey_both_laws() {
        for law in laws() {
            for q in displacements() {
                let (p, _) = law.force(&q, W);
                let gap = q.x + W[0] * p.x;
                match law.normal {
                    NormalLaw::Unilateral { yielding } => {
                        let open = gap + yielding * p.x;
                        assert!(p.x >= 0.0 && open >= -1e-18 && p.x * open.abs() < 1e-15, "{q:?}: {p:?}");
                    }
                    NormalLaw::Potential(potential, area) => {
                        let force = -potential.potential(gap).expect("outside")[1] * area;
                        assert!((p.x - force).abs() <= 1e-9 * (p.x + 1e-6), "{q:?}: {} for {force}", p.x);
                    }
                }
                let Some((coefficient, epsilon)) = law.friction else { continue };
                let left = Vec3::new(0.0, q.y + W[1] * p.y, q.z + W[1] * p.z);
                let y = (left.norm() / epsilon).min(1.0);
                let size = coefficient * p.x * (2.0 - y) * y;
                let force = p.y.hypot(p.z);
                // y is known to the rounding of q over ε
                assert!((force - size).abs() <= 1e-9 * (size + p.x), "{q:?}: {force} for {size}");
                assert!(p.y * left.z - p.z * left.y <= 1e-9 * force * left.norm(), "against the sliding");
            }
        }
    }

    /// The force of the law at q + w p changes by the amplification times a small change of p alone: h is 1e-6 of the lengths over which the laws
    /// change, as below.
    #[test]
    fn forces_of_the_displacements_are_off_by_the_amplification() {
        let law = ContactLaw { normal: NormalLaw::Potential(&Barrier, 3e-6), friction: Some((0.4, 2e-6)) };
        for q in displacements() {
            let (p, slope) = law.force(&q, W);
            let [normal, sliding] = law.amplification(&slope, W);
            // Without w, the force is that at the displacement itself
            let end = Vec3::new(q.x + W[0] * p.x, q.y + W[1] * p.y, q.z + W[1] * p.z);
            let stiffness = -law.force(&end, [0.0; 2]).1;
            let of_gap = 1.0 + W[0] * stiffness[(0, 0)];
            let tangential = stiffness.fixed_view::<2, 2>(1, 1).symmetric_eigenvalues().max();
            assert!((normal / of_gap - 1.0).abs() < 1e-6, "{q:?}: {normal} for {of_gap}");
            let of_sliding = 1.0 + W[1] * tangential;
            assert!((sliding / of_sliding - 1.0).abs() < 1e-6, "{q:?}: {sliding} for {of_sliding}");
        }
    }

    /// Compared with central differences over h = 1e-6 of the lengths over which the laws change, with errors of h² and of rounding over h.
    #[test]
    fn derivatives_are_those_of_the_force() {
        for law in laws() {
            for q in displacements() {
                let (p, slope) = law.force(&q, W);
                for (j, length) in [(0, 1e-5), (1, 1e-6), (2, 1e-6)] {
                    let h = 1e-6 * length;
                    let at = |h: f64| law.force(&(q + Vec3::ith(j, h)), W).0;
                    let difference = (at(h) - at(-h)) / (2.0 * h);
                    for i in 0..3 {
                        let bound = 1e-4 * (slope.column(j).norm() + 1e-9 / W[0]) + 1e-9 * p.norm() / length;
                        let error = (difference[i] - slope[(i, j)]).abs();
                        assert!(error <= bound, "{q:?}, {i} by {j}: {} for {}", slope[(i, j)], difference[i]);
                    }
                }
            }
        }
    }
}
