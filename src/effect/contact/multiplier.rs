//! Contact as complementarity, 0 ≤ d ⟂ λ ≥ 0 at every point, solved with the equilibrium.
//!
//! With a scalar y for each point and a stiffness c, λ = c y, the augmented Lagrangian of Alart & Curnier, Comput. Methods Appl.
//! Mech. Eng. 92 (1991), §3, with a small yielding ε,
//!
//! ```text
//! L = Σ_q ½ c ((1 − ε) max(0, y − d)² − y²)      r_k = −c (1 − ε) max(0, y − d) s_k m      r_y = c ((1 − ε) max(0, y − d) − y)
//! ```
//!
//! is stationary where d = −ε (y − d) and λ ≥ 0, or λ = 0 and d ≥ 0. Newton's method on it is an active set: points with y > d are held.
//! The multiplier is a force at a node, so that any uniform stress comes out. c is numerics: the answer does not depend on it.
//! More points than a rigid body has motions, as the corners of a box on a floor, share its weight with the least sum of squares.
//! Limits: the force has a step where the active set changes. A step that passes through a thin obstacle is not seen.

use super::friction::Coulomb;
use super::placement::{Pair, Placed};
use super::{Contact, NormalForce, NormalForces};
use crate::math::tensor::Mat3;
use crate::system::friction::HISTORY;
use crate::system::{
    At, BlockValues, Blocks, Caches, Capabilities, ContactPoint, ContactPoints, Effect, EnergyRole, EvalError,
    NormalLaw, Want,
};
use std::sync::Arc;
use std::time::Instant;

/// ε, the depth at a point that is pressed, as a share of N/c \[–\]: without it, forces of points that a rigid body presses on more than
/// one way have no unique values, and the tangent has no inverse.
const YIELDING: f64 = 1e-9;

pub struct Multiplier {
    pub contact: Arc<Contact>,
    /// c \[N/m\]
    pub stiffness: f64,
    /// Friction for corrections; in the equilibrium friction is an effect of its own
    pub friction: Option<Coulomb>,
}

impl Multiplier {
    /// N over y − d of a point that is pressed \[N/m\]
    fn pressed_stiffness(&self) -> f64 {
        (1.0 - YIELDING) * self.stiffness
    }

    fn scalar(&self, x: &[f64], b: usize) -> f64 {
        x[self.contact.blocks().scalars(b)[0] as usize]
    }

    fn pair(&self, x: &[f64], b: usize) -> Pair {
        self.pair_with(&self.contact.obstacle.at(x), x, b)
    }

    /// The same with the obstacle where it is at x.
    fn pair_with(&self, placed: &Placed, x: &[f64], b: usize) -> Pair {
        let at = self.contact.position(x, b);
        let witness = self.contact.obstacle.shape.nearest(&placed.local(&at));
        placed.pair(&at, &witness, self.contact.points[b].radius)
    }

    /// These contact points at x, in a step from displacement `old`.
    fn points_of(&self, [x, old]: [&[f64]; 2], dt: f64, of: impl Iterator<Item = usize>) -> Vec<ContactPoint<'_>> {
        let (placed, turn) = (self.contact.obstacle.at(x), self.contact.obstacle.turn([x, old]));
        of.map(|b| self.point([x, old], dt, b, (&placed, turn))).collect()
    }

    /// A point with its obstacle at x, which has turned by so much.
    fn point(&self, [x, old]: [&[f64]; 2], dt: f64, b: usize, (placed, turn): (&Placed, Mat3)) -> ContactPoint<'_> {
        let pair = self.pair_with(placed, x, b);
        let shares = pair.shares(&self.contact.points[b].weights);
        let [spot, sliding] = self.contact.contact_shares([x, old], b, &pair.normal, &shares);
        ContactPoint {
            nodes: self.contact.blocks().nodes(b).to_vec(),
            spot,
            sliding,
            shares,
            gap: pair.gap,
            normal: pair.normal,
            force: self.pressed_stiffness() * (self.scalar(x, b) - pair.gap).max(0.0),
            friction: self.friction.map(|law| (law.coefficient, law.threshold(dt))),
            history: HISTORY * b,
            turn,
            law: NormalLaw::Unilateral { yielding: YIELDING / self.pressed_stiffness() },
        }
    }
}

impl Effect for Multiplier {
    fn name(&self) -> &str {
        &self.contact.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Contact
    }

    fn blocks(&self) -> &Blocks {
        self.contact.blocks()
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let (c, pressed) = (self.stiffness, self.pressed_stiffness());
        let y = self.scalar(at.x, b);
        let n = self.contact.blocks().size(b);
        let pair = self.pair(at.x, b);
        let held = (y - pair.gap).max(0.0);
        out.energy = 0.5 * (pressed * held * held - c * y * y);
        out.r[n - 1] = pressed * held - c * y;
        if held == 0.0 {
            if want == Want::Tangent {
                out.k[n * n - 1] = -c;
            }
            return Ok(());
        }
        let own = &self.contact.points[b].weights;
        pair.add(own, (-pressed * held, pressed), n, want, out);
        if want == Want::Tangent {
            out.k[n * n - 1] = -YIELDING * c;
            for (k, s) in pair.shares(own).iter().enumerate() {
                (0..3).for_each(|i| out.k[(n - 1) * n + 3 * k + i] = -pressed * s * pair.normal[i]);
            }
        }
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities { contact_points: Some(self), ..Capabilities::default() }
    }
}

impl ContactPoints for Multiplier {
    fn has_friction(&self) -> bool {
        self.friction.is_some()
    }

    fn points(&self, [x, old]: [&[f64]; 2], dt: f64, _: f64, caches: &mut Caches) -> Vec<ContactPoint<'_>> {
        let start = Instant::now();
        let points = self.points_of([x, old], dt, 0..self.contact.points.len());
        let search = self.contact.search(caches);
        search.count([points.len(), points.len(), 0]);
        search.counts.search += start.elapsed();
        points
    }

    /// y − d is N/c(1 − ε) where there is a force, and y = 0 where there is none and the point is not inside.
    fn set_forces(&self, x: &mut [f64], forces: &[f64], caches: &mut Caches) {
        for (b, force) in forces.iter().enumerate() {
            let gap = self.contact.gap(x, b);
            x[self.contact.blocks().scalars(b)[0] as usize] =
                if *force > 0.0 { gap + force / self.pressed_stiffness() } else { gap.min(0.0) };
        }
        self.contact.search(caches).count([0, 0, forces.iter().filter(|f| **f > 0.0).count()]);
    }

    fn passed(&self, [x, old]: [&[f64]; 2], caches: &mut Caches) -> Option<(u32, f64)> {
        self.contact.passed([old, x], 0.0, caches)
    }

    fn inside(&self, x: &[f64], depth: f64) -> Vec<ContactPoint<'_>> {
        let inside = (0..self.contact.points.len()).filter(|&b| self.contact.gap(x, b) < -depth);
        self.points_of([x, x], f64::INFINITY, inside)
    }
}

impl NormalForces for Multiplier {
    fn contact(&self) -> &Contact {
        &self.contact
    }

    fn reach(&self) -> f64 {
        f64::INFINITY
    }

    fn normal_forces(&self, x: &[f64], b: usize) -> Vec<NormalForce> {
        let pair = self.pair(x, b);
        let force = self.pressed_stiffness() * (self.scalar(x, b) - pair.gap).max(0.0);
        let press = (force > 0.0).then(|| {
            // N depends on the multiplier as much as on the distance.
            NormalForce::new(&pair, &self.contact.points[b].weights, (force, 0.0))
        });
        press.into_iter().collect()
    }
}
