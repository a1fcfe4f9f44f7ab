//! Contact as complementarity, 0 ≤ d ⟂ λ ≥ 0 at every point, solved together with the equilibrium.
//!
//! A point has as many [contacts](super::shape::Shape::contacts) with its obstacle as sides of it may be in contact there, each with a separate
//! distance and multiplier. With a scalar y for each contact and a stiffness c, λ = c y, the augmented Lagrangian of Alart & Curnier, Comput. Methods
//! Appl. Mech. Eng. 92 (1991), §3, with a small compliance ε,
//!
//! ```text
//! L = Σ_q ½ c ((1 − ε) max(0, y − d)² − y²)      r_k = −c (1 − ε) max(0, y − d) s_k m      r_y = c ((1 − ε) max(0, y − d) − y)
//! ```
//!
//! is stationary where d = −ε (y − d) and λ ≥ 0, or λ = 0 and d ≥ 0. Newton's method on it is an active-set method: points with y > d are active. The
//! multiplier is a nodal force, so that any uniform stress is reproduced. c is a numerical parameter: the result does not depend on it. If a rigid
//! body rests on more points than it has rigid motions, as a box does on its corners, the points share the load with the least sum of squares.
//! Limits: the force is discontinuous where the active set changes. A step that passes through a thin obstacle goes undetected.

use super::friction::Coulomb;
use super::placement::{Pair, Placed};
use super::shape::Witness;
use super::{Contact, NormalForce, NormalForces};
use crate::math::tensor::{Mat3, Vec3};
use crate::system::friction::HISTORY;
use crate::system::{
    At, BlockValues, Blocks, Caches, Capabilities, ContactPoint, ContactPoints, Effect, EnergyRole, EvalError,
    NormalLaw, Want,
};
use std::sync::Arc;
use std::time::Instant;

/// ε, the penetration at an active point relative to N/c \[–\]: without it, the forces on redundant contact points of a rigid body are not unique,
/// and the tangent is singular.
const YIELDING: f64 = 1e-9;

pub struct Multiplier {
    pub contact: Arc<Contact>,
    /// c \[N/m\]
    pub stiffness: f64,
    /// Friction for contact corrections; in the equilibrium, friction is a separate effect
    pub friction: Option<Coulomb>,
}

/// One contact of a point.
struct UnilateralContact {
    pair: Pair,
    /// Index of its scalar in the state
    place: usize,
    /// Its scalar \[m\]
    y: f64,
    /// y − d if it is active, and 0 otherwise \[m\]
    held: f64,
}

impl Multiplier {
    /// N divided by y − d of an active point \[N/m\].
    fn pressed_stiffness(&self) -> f64 {
        (1.0 - YIELDING) * self.stiffness
    }

    /// Returns the contacts of point `b` at x \[contacts\].
    fn contacts(&self, x: &[f64], b: usize) -> Vec<UnilateralContact> {
        self.contacts_with(&self.contact.obstacle.at(x), x, b)
    }

    /// Returns the contacts of point `b` at x, with the obstacle already placed at x.
    fn contacts_with(&self, placed: &Placed, x: &[f64], b: usize) -> Vec<UnilateralContact> {
        let (at, radius) = (self.contact.position(x, b), self.contact.points[b].radius);
        let scalars = self.contact.blocks().scalars(b);
        let none = Witness { gap: f64::INFINITY, normal: Vec3::z(), curvature: Mat3::zeros() };
        let mut witnesses = vec![none; scalars.len()];
        for (number, witness) in self.contact.obstacle.shape.contacts(&placed.local(&at), 0.0) {
            witnesses[number] = witness;
        }
        let contact = |(witness, &place): (&Witness, &u32)| {
            let (pair, y) = (placed.pair(&at, witness, radius), x[place as usize]);
            UnilateralContact { held: (y - pair.gap).max(0.0), pair, place: place as usize, y }
        };
        witnesses.iter().zip(scalars).map(contact).collect()
    }

    /// Returns the existing contacts at x, in a step from displacement `old`.
    fn points_of(
        &self,
        [x, old]: [&[f64]; 2],
        dt: f64,
        is_taken: impl Fn(&UnilateralContact) -> bool,
    ) -> Vec<ContactPoint<'_>> {
        let (placed, turn) = (self.contact.obstacle.at(x), self.contact.obstacle.turn([x, old]));
        let mut points = Vec::new();
        for b in 0..self.contact.points.len() {
            let contacts = self.contacts_with(&placed, x, b);
            let taken = contacts.iter().enumerate().filter(|(_, contact)| is_taken(contact));
            points.extend(taken.map(|(number, contact)| self.point([x, old], dt, (b, number), contact, turn)));
        }
        points
    }

    /// Returns a contact of point `b` with its obstacle, which has rotated by the given rotation.
    fn point(
        &self,
        [x, old]: [&[f64]; 2],
        dt: f64,
        (b, number): (usize, usize),
        UnilateralContact { pair, held, .. }: &UnilateralContact,
        turn: Mat3,
    ) -> ContactPoint<'_> {
        let shares = pair.shares(&self.contact.points[b].weights);
        let [spot, sliding] = self.contact.contact_shares([x, old], b, &pair.normal, &shares);
        ContactPoint {
            nodes: self.contact.blocks().nodes(b).to_vec(),
            spot,
            sliding,
            shares,
            gap: pair.gap,
            normal: pair.normal,
            force: self.pressed_stiffness() * held,
            friction: self.friction.map(|law| (law.coefficient, law.threshold(dt))),
            history: HISTORY * (self.slips() * b + number),
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
        let n = self.contact.blocks().size(b);
        let own = &self.contact.points[b].weights;
        let contacts = self.contacts(at.x, b);
        for (row, UnilateralContact { pair, y, held, .. }) in (n - contacts.len()..).zip(&contacts) {
            out.energy += 0.5 * (pressed * held * held - c * y * y);
            out.r[row] = pressed * held - c * y;
            if want == Want::Tangent {
                out.k[row * n + row] = if *held > 0.0 { -YIELDING * c } else { -c };
            }
            if *held == 0.0 {
                continue;
            }
            pair.add(own, (-pressed * held, pressed), n, want, out);
            if want == Want::Tangent {
                for (k, s) in pair.shares(own).iter().enumerate() {
                    (0..3).for_each(|i| out.k[row * n + 3 * k + i] = -pressed * s * pair.normal[i]);
                }
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
        let points = self.points_of([x, old], dt, |_| true);
        let search = self.contact.search(caches);
        search.count([points.len(), points.len(), 0]);
        search.counts.search += start.elapsed();
        points
    }

    /// Sets y such that y − d = N/c(1 − ε) where there is a force; otherwise y = min(d, 0), which is zero unless the point is inside.
    fn set_forces(&self, x: &mut [f64], forces: &[f64], caches: &mut Caches) {
        for (b, forces) in forces.chunks(self.slips()).enumerate() {
            for (UnilateralContact { pair, place, .. }, force) in self.contacts(x, b).into_iter().zip(forces) {
                let is_held = *force > 0.0 && pair.gap.is_finite();
                x[place] = if is_held { pair.gap + force / self.pressed_stiffness() } else { pair.gap.min(0.0) };
            }
        }
        self.contact.search(caches).count([0, 0, forces.iter().filter(|f| **f > 0.0).count()]);
    }

    fn passed(&self, [x, old]: [&[f64]; 2], caches: &mut Caches) -> Option<(u32, f64)> {
        self.contact.passed([old, x], 0.0, caches)
    }

    fn inside(&self, x: &[f64], depth: f64) -> Vec<ContactPoint<'_>> {
        self.points_of([x, x], f64::INFINITY, |contact| contact.pair.gap < -depth)
    }
}

impl NormalForces for Multiplier {
    fn contact(&self) -> &Contact {
        &self.contact
    }

    fn reach(&self) -> f64 {
        f64::INFINITY
    }

    fn slips(&self) -> usize {
        self.contact.obstacle.shape.sheets()
    }

    fn normal_forces(&self, x: &[f64], b: usize) -> Vec<NormalForce> {
        let contacts = self.contacts(x, b).into_iter().enumerate();
        let press = |(number, UnilateralContact { pair, held, .. }): (usize, UnilateralContact)| {
            // N depends as much on the multiplier as on the distance.
            let own = &self.contact.points[b].weights;
            (held > 0.0).then(|| NormalForce::new(&pair, own, (self.pressed_stiffness() * held, 0.0), number))
        };
        contacts.filter_map(press).collect()
    }
}
