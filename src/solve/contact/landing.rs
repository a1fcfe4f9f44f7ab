//! Impacts with integrators that remember an acceleration (generalised-α, Newmark): before the step, velocities that would carry points into their
//! obstacles are replaced by velocities that carry them just to the obstacles.
//!
//! ```text
//! v' = v + M⁻¹ Hᵀ p      0 ≤ p_n ⟂ d + Δt H_n v' ≥ 0      p_t = −μ p_n f(|g_t|/ε) g_t/|g_t|,   g_t = Δt H_t v'
//! ```
//!
//! Here d are the distances of the points from the reach of their contact, with the friction of the contact. With obstacles at rest, kinetic energy
//! does not increase: with W = H M⁻¹ Hᵀ, p_n(H_n v' + d/Δt) = 0 and p_t·g_t ≤ 0, ½ v'ᵀMv' − ½ vᵀMv = −½ pᵀWp + pᵀHv' ≤ −½ pᵀWp − p_nᵀd/Δt. p is found
//! by [`gauss_seidel`](super::gauss_seidel). For free rigid bodies v' is a rigid motion: M⁻¹Hᵀ alone would strain them, and their stiffness would,
//! within the step, give the points velocities different from v'. The step then finds the points at their final positions, and no acceleration of an
//! impact enters its memory, from which later steps would throw the points back. An impact has no rebound of its own: bodies rebound because of their
//! elasticity. A contact whose potential is so soft that the steps resolve the vibration on it is left to the integrator.
//!
//! BDF2 would carry the velocity before an impact along in its formula, and throw a rigid body back with 1.6 times its energy or more, at every Δt.
//! It is restarted with implicit Euler when such a body is about to hit an obstacle or another rigid body, until the body has come to rest on it
//! ([`StepSolver::hits`]; Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, 1993, §II.6). Points of deformable bodies are left
//! to the integrator.
//!
//! Source: Deuflhard, Krause & Ertel, *Int. J. Numer. Meth. Eng.* 73 (2008), the prediction of the contact-stabilised Newmark method. Limits: not
//! between deformable surfaces; constraints and the stiffness of rigid parts of a body respond within the step, not to the impact itself; no recorded
//! force includes the impulse.

use super::free_bodies::FreeBody;
use super::gauss_seidel::Contacts;
use super::law::ContactLaw;
use crate::math::tensor::Vec3;
use crate::solve::start::Start;
use crate::solve::step_solver::StepSolver;
use crate::solve::{Failure, Integrator, Limit, Step};
use crate::system::{ContactPoint, Dofs, NormalLaw, State, System};
use std::collections::BTreeSet;

/// Distance within which points are included, in multiples of the motion of a step: two bodies may move, each by √3 times its largest component.
const MARGIN: f64 = 4.0;
/// Distance that a point may move beyond the obstacle, relative to the largest motion of a step \[–\]; its square is a share of the energy.
const SLOW: f64 = 1e-3;
/// Distance that a point may move beyond the obstacle, relative to the length of the body, if everything is at rest \[–\].
const STILL: f64 = 1e-10;
/// Δt² W A φ″, the squared phase angle per step of the vibration on a contact with a potential, below which the step resolves the vibration \[–\].
const RESOLVED: f64 = 1.0;
/// Sliding up to which friction increases in a landing for which no impulses are found with the elastic slip of the contact, relative to the largest
/// motion of the step \[–\]; the step itself uses the friction of the contact.
const STICKING: f64 = 1e-2;
/// Compliance of a point, relative to its response \[–\]: if there are more points than a body has motions, their impulses then have the least sum of
/// squares.
const YIELDING: f64 = 1e-9;
/// Largest number of points that land together: W is dense.
const MANY: usize = 500;
/// Number of steps, at the velocities and accelerations at the start, within which a rigid body counts as about to hit something.
const AHEAD: f64 = 1.5;

impl<'a> StepSolver<'a> {
    /// The state from which a step of the integrator to `t` starts instead if points would land in the step; `None` if none would.
    pub(in crate::solve) fn landed(
        &mut self,
        integrator: Integrator,
        state: &State,
        t: f64,
    ) -> Result<Option<State>, Failure> {
        let system = self.system;
        if !integrator.needs_initial_acceleration() || system.with_contact_points().next().is_none() {
            return Ok(None);
        }
        let approach = self.approach(integrator, state, t, (1.0, 0.0));
        let mut landing = self.points_near(&approach, state);
        landing.retain(|point| approach.passes(point));
        if landing.is_empty() {
            return Ok(None);
        }
        let (limit, places) = (self.solver.equations.limit.clone(), self.points);
        let mass = self.mass(state)?;
        let bodies = FreeBody::all(system, mass, places, &state.x);
        let (mut landed, mut approach) = (state.clone(), approach);
        for points in landing.chunks(MANY) {
            let found = impulses((&mut *mass, &bodies), system, points, &approach, &limit)?;
            for Impulse { response, size, .. } in found.into_iter().flatten() {
                landed.v.iter_mut().zip(&response).for_each(|(v, z)| *v += z * size / approach.dt);
                approach.motion.iter_mut().zip(&response).for_each(|(d, z)| *d += z * size);
            }
        }
        Ok(Some(landed))
    }

    /// Whether a multi-step rule is restarted with the step to `t`: a rigid body is about to hit an obstacle or another rigid body, or it has done so
    /// in the step before, with which the rule was restarted, and is still moving towards it. Contacts that the steps resolve do not count.
    pub(in crate::solve) fn hits(&mut self, integrator: Integrator, state: &State, t: f64) -> bool {
        let system = self.system;
        if integrator != Integrator::Bdf2 || system.turning_bodies().next().is_none() {
            return false;
        }
        let bodies: BTreeSet<u32> = system.turning_bodies().flatten().copied().collect();
        let is_free = |node: u32| (0..3).any(|i| system.dofs.equation[3 * node as usize + i] != Dofs::FIXED);
        let is_rigid = |point: &ContactPoint| {
            let mut moving = point
                .nodes
                .iter()
                .zip(&point.shares)
                .filter(|(node, share)| **share != 0.0 && is_free(**node))
                .peekable();
            moving.peek().is_some() && moving.all(|(node, _)| bodies.contains(node))
        };
        let anew = integrator.begins_at(state);
        // With BDF2, the acceleration of a step with an impact is that of the impact, and points away from the obstacle
        let accelerated = if anew && integrator == Integrator::Bdf2 { 0.0 } else { 0.5 };
        let approach = self.approach(integrator, state, t, (AHEAD, accelerated));
        let mut hit = self.points_near(&approach, state);
        hit.retain(|point| approach.passes(point) && (anew || point.gap >= point.reach()) && is_rigid(point));
        if hit.is_empty() {
            return false;
        }
        let (limit, places) = (self.solver.equations.limit.clone(), self.points);
        let Ok(mass) = self.mass(state) else { return true };
        let bodies = FreeBody::all(system, mass, places, &state.x);
        let is_stopped = |points| {
            let found = impulses((&mut *mass, &bodies), system, points, &approach, &limit);
            let stops = |all: Vec<Impulse>| all.iter().any(|impulse| impulse.is_normal && impulse.size > 0.0);
            found.ok().flatten().is_none_or(stops)
        };
        hit.chunks(MANY).any(is_stopped)
    }

    /// Motion over `ahead` steps of the length of the step to `t`, from the velocity at its start, and from `accelerated` times Δt times the
    /// acceleration; for prescribed dofs, the motion of the step.
    fn approach(&self, integrator: Integrator, state: &State, t: f64, (ahead, accelerated): (f64, f64)) -> Approach {
        let dt = t - state.t;
        let way = |(v, a): (&f64, &f64)| ahead * dt * (v + accelerated * dt * a);
        let mut motion: Vec<f64> = state.v.iter().zip(&state.a).map(way).collect();
        let step = Step { system: self.system, integrator, past: state, dt };
        for (dof, value) in step.targets(&State { t, ..state.clone() }) {
            motion[dof] = ahead * (value - state.x[dof]);
        }
        // Multipliers that are dofs do not count as motion; the limits of the other integrators were found with them
        let dofs = if integrator == Integrator::Bdf2 { self.system.dofs.displacements as usize } else { motion.len() };
        let size = motion[..dofs].iter().fold(0.0, |m: f64, d| m.max(d.abs()));
        Approach { slow: (SLOW * size).max(STILL * self.solver.equations.length), motion, size, dt }
    }

    /// The contact points that the motion may bring to their obstacles.
    fn points_near(&mut self, approach: &Approach, state: &State) -> Vec<ContactPoint<'a>> {
        let caches = &mut self.solver.equations.sums.caches;
        let margin = MARGIN * approach.size;
        self.system.contact_points([&state.x, &state.x], approach.dt, margin, caches).into_iter().flatten().collect()
    }

    /// M with its factor, computed at first use.
    fn mass(&mut self, state: &State) -> Result<&mut Start, Failure> {
        if self.mass.is_none() {
            let rest = State { inputs: state.inputs.clone(), ..self.system.rest() };
            self.mass = Some(Start::new(self.solver.linear.method.clone(), self.system, &rest, &rest.a)?);
        }
        Ok(self.mass.as_mut().expect("it was made"))
    }
}

/// The motion that a step is expected to make.
struct Approach {
    /// \[unknowns\] motion of all dofs \[m\]
    motion: Vec<f64>,
    /// Largest component of the motion \[m\]
    size: f64,
    /// Distance that a point may move beyond its obstacle \[m\]
    slow: f64,
    /// Length of the step \[s\]
    dt: f64,
}

impl Approach {
    fn passes(&self, point: &ContactPoint) -> bool {
        room(point, &self.motion) < -self.slow
    }
}

/// Distance from the reach of the contact that remains after a motion \[m\].
fn room(point: &ContactPoint, motion: &[f64]) -> f64 {
    (point.gap - point.reach()).max(0.0) + along(point, motion)
}

/// Change of the distance due to a motion \[m\].
fn along(point: &ContactPoint, motion: &[f64]) -> f64 {
    point.normal.dot(&point.motion(&point.shares, motion))
}

/// A φ″ in the middle of the reach, or inside the obstacle if the reach is 0 \[N/m\]; 0 for a unilateral point.
fn stiffness(point: &ContactPoint) -> f64 {
    let NormalLaw::Potential(potential, area) = point.law else { return 0.0 };
    potential.potential(0.5 * potential.reach() - f64::MIN_POSITIVE).map_or(0.0, |[_, _, second]| area * second)
}

/// A direction in which an impulse acts on a point: along its normal, or tangentially if there is friction.
struct Component<'p> {
    point: &'p ContactPoint<'p>,
    shares: &'p [f64],
    direction: Vec3,
}

impl<'p> Component<'p> {
    /// The normal component, followed by the tangential ones.
    fn all(point: &'p ContactPoint) -> impl Iterator<Item = Self> {
        let across = point.friction.map(|_| point.across()).into_iter().flatten();
        let sliding = across.map(move |direction| Self { point, shares: &point.spot, direction });
        std::iter::once(Self { point, shares: &point.shares, direction: point.normal }).chain(sliding)
    }

    /// Displacement in this direction due to a motion \[m\].
    fn along(&self, motion: &[f64]) -> f64 {
        self.direction.dot(&self.point.motion(self.shares, motion))
    }

    /// Computes M⁻¹ Hᵀ, for free `bodies` as rigid motions.
    fn response(&self, mass: &mut Start, bodies: &[FreeBody], system: &System, n: usize) -> Result<Vec<f64>, Failure> {
        let mut against = vec![0.0; n];
        for (&node, share) in self.point.nodes.iter().zip(self.shares) {
            (0..3).for_each(|i| against[3 * node as usize + i] -= share * self.direction[i]);
        }
        let mut response = mass.solve(system, Some(system.restrict(&against)), vec![0.0; n])?;
        bodies.iter().for_each(|body| body.make_rigid(&mut response));
        Ok(response)
    }
}

/// An impulse on a point in one direction.
struct Impulse {
    /// Response M⁻¹ Hᵀ
    response: Vec<f64>,
    /// Impulse times the step, Δt p
    size: f64,
    is_normal: bool,
}

/// The impulses on the points that are stopped, except points whose normal motion is prescribed, and contacts so soft that the step resolves them.
/// `None` if no impulses satisfy all points; then the step itself stops them, without a landing.
fn impulses(
    (mass, bodies): (&mut Start, &[FreeBody]),
    system: &System,
    points: &[ContactPoint],
    approach: &Approach,
    limit: &Limit,
) -> Result<Option<Vec<Impulse>>, Failure> {
    let Approach { motion, dt, .. } = approach;
    let mut responses = Vec::new();
    let normals: Vec<Component> = points.iter().filter_map(|point| Component::all(point).next()).collect();
    for normal in &normals {
        responses.push(normal.response(mass, bodies, system, motion.len())?);
    }
    let stiffness: Vec<f64> = points.iter().map(stiffness).collect();
    let stops = |k: &usize| {
        let w = |j: usize| normals[*k].along(&responses[j]);
        let stiff: f64 = stiffness.iter().enumerate().map(|(j, stiffness)| w(j).abs() * stiffness).sum();
        w(*k) > 0.0 && (matches!(points[*k].law, NormalLaw::Unilateral { .. }) || dt * dt * stiff >= RESOLVED)
    };
    let stopped: Vec<usize> = (0..points.len()).filter(stops).collect();
    let (mut components, mut impulses) = (Vec::new(), Vec::new());
    for &k in &stopped {
        for (i, component) in Component::all(&points[k]).enumerate() {
            let is_normal = i == 0;
            let response = match is_normal {
                true => std::mem::take(&mut responses[k]),
                false => component.response(mass, bodies, system, motion.len())?,
            };
            impulses.push(Impulse { response, size: 0.0, is_normal });
            components.push(component);
        }
    }
    let w: Vec<Vec<f64>> =
        components.iter().map(|row| impulses.iter().map(|column| row.along(&column.response)).collect()).collect();
    let free = components.iter().zip(&impulses).map(|(component, impulse)| match impulse.is_normal {
        true => room(component.point, motion),
        false => component.along(motion),
    });
    let normal_rows = (0..w.len()).filter(|&row| impulses[row].is_normal);
    let laws =
        stopped.iter().zip(normal_rows).map(|(&k, row)| ContactLaw::unilateral(&points[k], YIELDING * w[row][row]));
    let (laws, free): (Vec<ContactLaw>, Vec<f64>) = (laws.collect(), free.collect());
    let settled = |slip: f64| {
        let laws = laws.iter().map(|law| {
            let mut law = *law;
            law.friction = law.friction.map(|(coefficient, epsilon)| (coefficient, epsilon.max(slip)));
            law
        });
        let mut contacts = Contacts::with_response(laws, free.clone(), w.clone());
        contacts.settle(|_| Ok(Vec::new()), &[], (limit, f64::INFINITY)).map(|_| contacts.p)
    };
    let mut found = settled(0.0);
    if matches!(found, Err(Failure::Complementarity)) {
        found = settled(STICKING * approach.size);
    }
    if matches!(found, Err(Failure::Complementarity)) {
        return Ok(None);
    }
    impulses.iter_mut().zip(&found?).for_each(|(impulse, p)| impulse.size = *p);
    Ok(Some(impulses))
}
