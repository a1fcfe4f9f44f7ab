//! Contact of a scene: which points, which obstacle, which response, and what is recorded of it.

use super::build::part;
use super::builder::{Builder, Gathered};
use super::error::SceneError;
use super::quantity::{Length, Modulus, Speed};
use super::rigid::{RigidBody, ShapeSpec, TurnSpec};
use super::signal::SignalSpec;
use super::spec::SceneSpec;
use crate::effect::contact::barrier::Barrier;
use crate::effect::contact::friction::ContactFriction;
use crate::effect::contact::multiplier::Multiplier;
use crate::effect::contact::penalty::Penalty;
use crate::effect::contact::placement::{AffineFrame, Obstacle};
use crate::effect::contact::pressed::{Pressed, Response};
use crate::effect::contact::{Contact, Point, Pressing, Sampling, points};
use crate::math::signal::Signal;
use crate::math::tensor::{Mat3, Vec3};
use crate::math::units::Dimension;
use crate::mesh::validate::point;
use crate::solve::{Integrator, Span};
use crate::system::{At, Effect, Local, Want};
use serde::Deserialize;
use std::sync::Arc;

/// A part of the surface, or a rigid body, against an obstacle.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactSpec {
    #[serde(default = "contact")]
    pub name: String,
    /// Facets of the body, or the name of a rigid body
    pub region: String,
    pub obstacle: ObstacleSpec,
    /// How the obstacle moves; it stays where it is if absent
    pub motion: Option<MotionSpec>,
    pub response: ResponseSpec,
    /// Coulomb's coefficient, 0 without friction
    pub friction: f64,
    /// Length in which the response acts; a hundredth of h if absent
    pub distance: Option<Length>,
    /// Pressure that the response is scaled with; Young's modulus of the stiffest law if absent
    pub modulus: Option<Modulus>,
    /// Speed below which a point counts as sticking; a thousandth of the size of the body per second if absent
    pub creep: Option<Speed>,
    /// The same over a static step; a thousandth of h if absent
    pub slip: Option<Length>,
}

fn contact() -> String {
    "contact".into()
}

/// What is met: a shape in space, or a rigid body of the scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum ObstacleSpec {
    /// What is below the plane through `point`
    Floor {
        point: [Length; 3],
        normal: [f64; 3],
    },
    /// Turned about its middle, along the axes if `turn` is absent
    Box {
        min: [Length; 3],
        max: [Length; 3],
        turn: Option<TurnSpec>,
    },
    Sphere {
        center: [Length; 3],
        radius: Length,
    },
    Cylinder {
        from: [Length; 3],
        to: [Length; 3],
        radius: Length,
    },
    /// STL or OBJ, closed and outward
    Surface {
        file: std::path::PathBuf,
        unit: String,
    },
    Rigid {
        body: String,
    },
}

/// A translation.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionSpec {
    pub direction: [f64; 3],
    pub displacement: SignalSpec,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum ResponseSpec {
    Barrier,
    Penalty,
    Multiplier,
}

impl ResponseSpec {
    /// Name as in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Barrier => "barrier",
            Self::Penalty => "penalty",
            Self::Multiplier => "multiplier",
        }
    }
}

/// A contact of the system, for what is recorded.
pub struct NamedContact {
    pub name: String,
    pub response: ResponseSpec,
    pressing: Arc<dyn Pressing>,
    moves: bool,
    friction: Option<Arc<ContactFriction>>,
}

/// What a contact is at one state.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactMoment {
    /// On the points [N]
    pub force: Vec3,
    /// Least distance [m]
    pub gap: f64,
    /// Points that are pressed
    pub pressed: usize,
    /// Their area [m²]
    pub area: f64,
}

impl NamedContact {
    /// Names of its columns.
    pub fn columns(&self) -> Vec<String> {
        let ends = ["force_x_N", "force_y_N", "force_z_N", "gap_m", "points", "area_m2"];
        ends.map(|end| format!("{}_{end}", self.name)).into()
    }

    /// The four nodes of an obstacle with a motion.
    pub(super) fn moving(&self) -> Option<&AffineFrame> {
        self.contact().obstacle.body.as_ref().filter(|_| self.moves)
    }

    /// Has it friction?
    pub fn slides(&self) -> bool {
        self.friction.is_some()
    }

    pub fn contact(&self) -> &Contact {
        self.pressing.contact()
    }

    /// Sums over the points; friction is there where a step led to the state.
    pub fn moment(&self, x: &[f64], step: Option<&At>) -> ContactMoment {
        let contact = self.contact();
        let forces = self.forces(x, step);
        let reach = self.pressing.reach();
        let least = 1e-9 * forces.iter().map(|f| f.1.norm()).fold(0.0, f64::max);
        let pressed = forces.iter().filter(|f| f.1.norm() > least);
        let area = pressed.clone().map(|f| contact.points[f.0].area).sum();
        let gap = contact.deepest(x).map_or(reach, |d| d.1);
        ContactMoment { force: forces.iter().map(|f| f.1).sum(), gap, pressed: pressed.count(), area }
    }

    /// (point, force [N]) of the points that feel the obstacle.
    pub fn forces(&self, x: &[f64], step: Option<&At>) -> Vec<(usize, Vec3)> {
        let contact = self.contact();
        let mut local = Local::new(contact.blocks().largest());
        let mut force = |b: usize| {
            let presses = self.pressing.presses(x, b);
            let mut sum: Vec3 = presses.iter().map(|p| p.normal * p.force).sum();
            if let (Some(friction), Some(at)) = (&self.friction, step) {
                local.r.fill(0.0);
                friction.eval(at, b, Want::Residual, &mut local).expect("friction is defined wherever contact is");
                sum -= local.r[..3 * contact.own()].chunks_exact(3).map(Vec3::from_column_slice).sum::<Vec3>();
            }
            (b, sum)
        };
        let near: Vec<u32> = match self.pressing.reach() {
            f64::INFINITY => (0..contact.points.len() as u32).collect(),
            reach => contact.near(x, reach),
        };
        near.into_iter().map(|b| force(b as usize)).filter(|(_, f)| *f != Vec3::zeros()).collect()
    }

    /// Values of its columns.
    pub fn record(&self, x: &[f64], step: Option<&At>) -> Vec<f64> {
        let ContactMoment { force, gap, pressed, area } = self.moment(x, step);
        vec![force.x, force.y, force.z, gap, pressed as f64, area]
    }

    /// [3 × nodes] forces at the nodes [N].
    pub fn nodal(&self, x: &[f64], step: Option<&At>, nodes: &mut [f64]) {
        for (b, force) in self.forces(x, step) {
            let p = &self.contact().points[b];
            for (&node, w) in p.nodes.iter().zip(&p.weights) {
                // Nodes of a rigid body are not in the mesh.
                let of_mesh = nodes.get_mut(3 * node as usize..3 * node as usize + 3).into_iter().flatten();
                of_mesh.zip(force.iter()).for_each(|(sum, f)| *sum += w * f);
            }
        }
    }
}

impl Builder<'_> {
    /// All rigid bodies and contacts, with their effects.
    pub(super) fn contacts(
        &mut self,
        spec: &SceneSpec,
        spans: &[Span],
        gathered: &mut Gathered,
        effects: &mut Vec<Box<dyn Effect>>,
    ) -> Result<(Vec<RigidBody>, Vec<NamedContact>), SceneError> {
        let mut next = self.body.mesh.points.len() as u32;
        let mut four = || {
            next += 4;
            [next - 4, next - 3, next - 2, next - 1]
        };
        let stiffest = gathered.laws.iter().map(|law| law.small_strain().e).fold(0.0, f64::max);
        let mut bodies = Vec::<RigidBody>::new();
        for (k, rigid) in spec.rigids.iter().enumerate() {
            let place = format!("rigid {} ({})", k + 1, rigid.name);
            if bodies.iter().any(|b| b.name == rigid.name) {
                let fact = format!("another rigid body is called \"{}\" too", rigid.name);
                return Err(self.content(&place, fact, "give each a `name` of its own"));
            }
            bodies.push(self.rigid(&place, rigid, four(), (spans, stiffest), effects)?);
        }
        let mut contacts = Vec::<NamedContact>::new();
        for (k, contact) in spec.contacts.iter().enumerate() {
            let place = format!("contact {} ({})", k + 1, contact.name);
            if contacts.iter().any(|c| c.name == contact.name) {
                let fact = format!("another contact is called \"{}\" too", contact.name);
                return Err(self.content(&place, fact, "give each a `name` of its own"));
            }
            if let Some(k) = spans.iter().position(|s| matches!(s.integrator, Integrator::ArcLength { .. })) {
                let fact = format!("a continuation beside contact (stage {})", k + 1);
                return Err(self.content(&place, fact, "take integrator = \"static\" without `continuation`"));
            }
            let moved = contact.motion.as_ref().map(|_| four());
            contacts.push(self.contact(&place, contact, (&bodies, moved), gathered, effects)?);
        }
        Ok((bodies, contacts))
    }

    /// A contact with its effects, the pressing one first.
    pub(super) fn contact(
        &mut self,
        place: &str,
        spec: &ContactSpec,
        (bodies, moved): (&[RigidBody], Option<[u32; 4]>),
        gathered: &mut Gathered,
        effects: &mut Vec<Box<dyn Effect>>,
    ) -> Result<NamedContact, SceneError> {
        self.check_name(place, &spec.name)?;
        if !(spec.friction >= 0.0 && spec.friction.is_finite()) {
            let fact = format!("friction = {}", spec.friction);
            return Err(self.content(place, fact, "a coefficient of friction is not negative"));
        }
        let h = self.body.mesh.h();
        let distance = self.positive(place, "distance", spec.distance.map(|l| l.0), 0.01 * h)?;
        let stiffest = gathered.laws.iter().map(|law| law.small_strain().e).fold(0.0, f64::max);
        if stiffest == 0.0 && spec.modulus.is_none() {
            let fact = "no law of the scene gives the pressure that the response is scaled with";
            return Err(self.content(place, fact, "give modulus, of the size of Young's modulus of the body"));
        }
        let modulus = self.positive(place, "modulus", spec.modulus.map(|m| m.0), stiffest)?;
        let size = self.body.mesh.diagonal();
        let creep = self.positive(place, "creep", spec.creep.map(|s| s.0), 1e-3 * size)?;
        let slip = self.positive(place, "slip", spec.slip.map(|l| l.0), 1e-3 * h)?;
        let sampling = if spec.response == ResponseSpec::Multiplier { Sampling::Nodes } else { Sampling::Pressures };
        let points = self.contact_points(place, &spec.region, bodies, sampling)?;
        let obstacle = self.obstacle(place, spec, bodies, moved)?;
        let name = spec.name.clone();
        let scalars = (spec.response == ResponseSpec::Multiplier).then(|| {
            let first = (3 * self.nodes + gathered.hosts.len()) as u32;
            gathered.hosts.extend(points.iter().map(|p| p.nodes[0]));
            first
        });
        let contact = Arc::new(Contact::with_scalars(name.clone(), points, obstacle, scalars));
        self.check_apart(place, &contact, spec.response)?;
        let pressing: Arc<dyn Pressing> = match spec.response {
            ResponseSpec::Barrier => {
                press(&contact, Barrier { distance, stiffness: modulus / distance }, effects)
            }
            ResponseSpec::Penalty => press(&contact, Penalty { stiffness: modulus / distance }, effects),
            ResponseSpec::Multiplier => {
                let shared = Arc::new(Multiplier { contact, stiffness: modulus * h });
                effects.push(Box::new(shared.clone()));
                shared
            }
        };
        let friction = (spec.friction > 0.0).then(|| {
            let (name, pressing) = (format!("{name}_friction"), pressing.clone());
            let friction = Arc::new(ContactFriction { name, pressing, coefficient: spec.friction, creep, slip });
            effects.push(Box::new(friction.clone()));
            friction
        });
        Ok(NamedContact { name, response: spec.response, pressing, moves: spec.motion.is_some(), friction })
    }

    pub(super) fn positive(
        &self,
        place: &str,
        key: &str,
        given: Option<f64>,
        otherwise: f64,
    ) -> Result<f64, SceneError> {
        match given {
            None => Ok(otherwise),
            Some(value) if value > 0.0 && value.is_finite() => Ok(value),
            Some(value) => Err(self.content(place, format!("{key} = {value} (SI)"), "it must be positive")),
        }
    }

    fn contact_points(
        &self,
        place: &str,
        region: &str,
        bodies: &[RigidBody],
        sampling: Sampling,
    ) -> Result<Vec<Point>, SceneError> {
        if let Some(body) = bodies.iter().find(|b| b.name == region) {
            return Ok(body.points());
        }
        let facets = &self.region(place, region)?.facets;
        if facets.is_empty() {
            let fact = format!("region \"{region}\" holds no facets");
            return Err(self.content(place, fact, "contact is of a part of the surface: take a facet region"));
        }
        Ok(points(&self.body.mesh, facets, sampling))
    }

    fn obstacle(
        &mut self,
        place: &str,
        spec: &ContactSpec,
        bodies: &[RigidBody],
        moved: Option<[u32; 4]>,
    ) -> Result<Obstacle, SceneError> {
        let shape = match &spec.obstacle {
            ObstacleSpec::Rigid { body: name } => {
                let Some(body) = bodies.iter().find(|b| b.name == *name) else {
                    let known: Vec<&str> = bodies.iter().map(|b| b.name.as_str()).collect();
                    let fact = format!("there is no [[rigid]] \"{name}\"");
                    return Err(self.content(place, fact, super::error::hint(name, &known)));
                };
                if spec.region == *name {
                    return Err(self.content(place, format!("\"{name}\" meets itself"), "take another obstacle"));
                }
                if spec.motion.is_some() {
                    let fact = format!("\"{name}\" is free, and has a motion");
                    return Err(self.content(place, fact, "remove `motion`, or give a shape in space"));
                }
                let (shape, origin, axes) = self.shape(place, &body.shape)?;
                return Ok(Obstacle { shape, origin, axes, body: Some(body.frame.clone()) });
            }
            ObstacleSpec::Floor { point, normal } => {
                ShapeSpec::Floor { point: *point, normal: *normal }
            }
            ObstacleSpec::Box { min, max, turn } => {
                ShapeSpec::Box { min: *min, max: *max, turn: turn.clone() }
            }
            ObstacleSpec::Sphere { center, radius } => ShapeSpec::Sphere { center: *center, radius: *radius },
            ObstacleSpec::Cylinder { from, to, radius } => {
                ShapeSpec::Cylinder { from: *from, to: *to, radius: *radius }
            }
            ObstacleSpec::Surface { file, unit } => ShapeSpec::Surface { file: file.clone(), unit: unit.clone() },
        };
        let (shape, origin, axes) = self.shape(place, &shape)?;
        let body: Option<AffineFrame> = match (&spec.motion, moved) {
            (Some(motion), Some(nodes)) => Some(self.carry(place, &spec.name, motion, origin, nodes)?),
            _ => None,
        };
        self.draw(place, &spec.name, &shape, (origin, axes), body.as_ref())?;
        Ok(Obstacle { shape, origin, axes, body })
    }

    /// The four nodes that carry an obstacle along its motion.
    fn carry(
        &mut self,
        place: &str,
        name: &str,
        motion: &MotionSpec,
        center: Vec3,
        nodes: [u32; 4],
    ) -> Result<AffineFrame, SceneError> {
        let direction = Vec3::from(motion.direction);
        if direction.norm() == 0.0 || !direction.norm().is_finite() {
            return Err(self.content(place, "the direction has no length", "write for example [0, 0, -1]"));
        }
        let direction = direction.normalize();
        let column = format!("{name}_displacement_m");
        let signal = self.signal(place, column, &motion.displacement, Dimension::LENGTH)?;
        for node in nodes {
            for i in 0..3 {
                let along = match direction[i] {
                    0.0 => Signal::Constant(0.0),
                    d => Signal::Product(vec![Signal::Constant(d), signal.clone()]),
                };
                self.carried.push((3 * node + i as u32, along));
            }
        }
        Ok(AffineFrame { nodes, center, length: self.body.mesh.diagonal() })
    }

    /// Refuses bodies that are inside of each other at rest, or touch where a barrier keeps them apart.
    fn check_apart(&self, place: &str, contact: &Contact, response: ResponseSpec) -> Result<(), SceneError> {
        let rest = vec![0.0; 3 * self.nodes];
        let Some((b, gap)) = contact.deepest(&rest) else { return Ok(()) };
        let rounding = 1e-9 * self.body.mesh.diagonal();
        let at = point(&contact.points[b].at);
        if gap < -rounding {
            let fact = format!("the surface is {:.4} mm inside of the obstacle at {at}", -gap * 1e3);
            return Err(self.content(place, fact, "move one of the two apart"));
        }
        if gap <= rounding && response == ResponseSpec::Barrier {
            let fact = format!("the surface touches the obstacle at {at}, and a barrier keeps them apart");
            return Err(self.content(place, fact, "leave a gap, for example of `distance`, or take another response"));
        }
        Ok(())
    }

    /// A shape with its frame in space.
    pub(super) fn shape(
        &self,
        place: &str,
        spec: &ShapeSpec,
    ) -> Result<(crate::effect::contact::shape::Shape, Vec3, Mat3), SceneError> {
        spec.build(&self.base).map_err(|why| match why {
            super::rigid::ShapeFault::Content(fact, remedy) => self.content(place, fact, remedy),
            super::rigid::ShapeFault::Part(source) => part(self.file, place, source),
        })
    }
}

fn press<R: Response + 'static>(
    contact: &Arc<Contact>,
    response: R,
    effects: &mut Vec<Box<dyn Effect>>,
) -> Arc<dyn Pressing> {
    let shared = Arc::new(Pressed { contact: contact.clone(), response });
    effects.push(Box::new(shared.clone()));
    shared
}
