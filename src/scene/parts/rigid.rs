//! Rigid bodies of a scene: their shape, mass, weight, and the points that come into contact.

use crate::effect::affine_body::{AffineInertia, Rigidity};
use crate::effect::contact::SurfacePoint;
use crate::effect::contact::placement::AffineFrame;
use crate::effect::contact::shape::Shape;
use crate::effect::dead_load::DeadLoad;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::scene::body::Body;
use crate::scene::build::builder::Builder;
use crate::scene::build::shape::ShapeSpec;
use crate::scene::error::SceneError;
use crate::scene::record::frame_motion;
use crate::scene::record::recorder::{Moment, Recorder};
use crate::scene::signal::SignalSpec;
use crate::scene::text::quantity::{Density, Speed, Spin};
use crate::system::State;
use schemars::JsonSchema;
use serde::Deserialize;

/// Stiffness of a rigid body as a multiple of Young's modulus of the stiffest law \[–\].
const STIFF: f64 = 1e4;
/// Number of points around the rim of a cylinder.
pub(in crate::scene) const RIM: usize = 24;
/// Share of the radius by which the rims of a cylinder with balls inside are reduced \[–\], so that on its side it rolls on the balls alone.
const INSET: f64 = 0.01;
/// Length relative to the radius below which it is rounding \[–\].
const ROUNDING: f64 = 1e-9;

/// A body that moves as a whole.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidSpec {
    /// Name by which contacts refer to the body, and prefix of the columns
    pub name: String,
    /// Shape of the body
    pub shape: ShapeSpec,
    /// Mass density
    pub density: Density,
    /// Weight; no weight if absent
    pub gravity: Option<WeightSpec>,
    /// Velocity at the start
    pub velocity: Option<[Speed; 3]>,
    /// Angular velocity at the start
    pub spin: Option<[Spin; 3]>,
}

/// Weight of a rigid body
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeightSpec {
    /// Direction of the weight; its length does not matter
    pub direction: [f64; 3],
    /// Acceleration of free fall \[m/s²\], such as `"9.81 m/s^2"`
    pub acceleration: SignalSpec,
}

/// A rigid body of the system.
pub struct RigidBody {
    pub name: String,
    pub shape: ShapeSpec,
    pub frame: AffineFrame,
    /// Velocity of the nodes at the start \[m/s\]
    pub(in crate::scene) start: [Vec3; 4],
    /// Points of its surface at rest, each with the radius of a ball about it \[m\]
    surface: Vec<(Vec3, f64)>,
    /// Largest distance of two points of one face \[m\]; 0 for a sphere, on which contact acts all around
    pub(in crate::scene) spacing: f64,
}

impl Recorder for RigidBody {
    fn columns(&self) -> Vec<String> {
        frame_motion::columns(&self.name)
    }

    fn memory(&self) -> Vec<f64> {
        frame_motion::memory()
    }

    fn remember(&self, _: &Body, state: &State, memory: &mut [f64]) {
        frame_motion::remember(&self.frame, state, memory);
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        frame_motion::record(&self.frame, now)
    }
}

impl RigidBody {
    /// Whether some of its points have balls.
    pub(in crate::scene) fn has_balls(&self) -> bool {
        self.surface.iter().any(|(_, radius)| *radius > 0.0)
    }

    /// The points of its surface that can be in contact.
    pub(in crate::scene) fn points(&self) -> Vec<SurfacePoint> {
        let area = self.frame.length.powi(2);
        let point = |(at, radius): &(Vec3, f64)| SurfacePoint {
            at: *at,
            nodes: self.frame.nodes.to_vec(),
            weights: self.frame.weights(at).to_vec(),
            area: area / self.surface.len() as f64,
            sides: Vec::new(),
            radius: *radius,
            carrier: (*radius > 0.0).then(|| self.frame.clone()),
        };
        self.surface.iter().map(point).collect()
    }
}

/// Builds a rigid body on its four nodes, with its effects.
pub(in crate::scene) fn build_rigid(
    builder: &mut Builder,
    place: &str,
    spec: &RigidSpec,
    nodes: [u32; 4],
    modulus: f64,
) -> Result<RigidBody, SceneError> {
    if spec.density.0 <= 0.0 {
        let fact = format!("the density is {} kg/m^3: a body without mass moves under no law", spec.density.0);
        return Err(builder.content(place, fact, "give a positive one"));
    }
    if builder.body.mesh.regions.contains_key(&spec.name) {
        let fact = format!("the mesh has a region \"{}\" too", spec.name);
        return Err(builder.content(place, fact, "choose another name"));
    }
    builder.check_name(place, &spec.name)?;
    if let ShapeSpec::Floor { .. } = spec.shape {
        return Err(builder.content(place, "a floor has no end, and no mass", "take a box"));
    }
    let (shape, origin, axes) = builder.shape(place, &spec.shape)?;
    let (mass, center, inertia) = shape.mass(spec.density.0);
    let (center, inertia) = (origin + axes * center, axes * inertia * axes.transpose());
    let volume = mass / spec.density.0;
    let frame = AffineFrame { nodes, center, length: volume.cbrt() };
    builder.effects.push(Box::new(AffineInertia::new(format!("{}_inertia", spec.name), &frame, mass, &inertia)));
    let stiffness = STIFF * modulus * volume;
    builder.effects.push(Box::new(Rigidity::free(format!("{}_rigidity", spec.name), frame.clone(), stiffness)));
    if let Some(WeightSpec { direction, acceleration }) = &spec.gravity {
        let column = format!("{}_acceleration_m_s2", spec.name);
        let (direction, signal) = builder.dead(place, *direction, acceleration, Dimension::ACCELERATION, column)?;
        let name = format!("{}_weight", spec.name);
        builder.effects.push(Box::new(DeadLoad::new(name, &[(nodes[0], mass)], direction, signal)));
    }
    builder.draw(place, &spec.name, &shape, (origin, axes), Some(&frame))?;
    let surface = corners(&spec.shape, &shape).into_iter().map(|(p, r)| (origin + axes * p, r)).collect();
    let spacing = spacing(&spec.shape, &shape);
    let velocity = spec.velocity.map_or(Vec3::zeros(), |v| Vec3::from(v.map(|v| v.0)));
    let spin = spec.spin.map_or(Vec3::zeros(), |w| Vec3::from(w.map(|w| w.0)));
    let start = frame.rest().map(|p| velocity + spin.cross(&(p - center)));
    Ok(RigidBody { start, name: spec.name.clone(), shape: spec.shape.clone(), frame, surface, spacing })
}

/// Points that represent a shape in its frame, with the radii of balls about them.
fn corners(spec: &ShapeSpec, shape: &Shape) -> Vec<(Vec3, f64)> {
    let Some([low, high]) = shape.bounds() else { return Vec::new() };
    match spec {
        ShapeSpec::Sphere { radius, .. } => vec![(Vec3::zeros(), radius.0)],
        ShapeSpec::Cylinder { .. } => {
            // The largest balls inside the cylinder are tangent to its side all around, and to one end at its centre.
            let (radius, inner) = (high.x, high.y - high.x);
            let balls = match inner / radius {
                below if below < -ROUNDING => vec![],
                none if none <= ROUNDING => vec![0.0],
                _ => vec![-inner, inner],
            };
            let around = if balls.is_empty() { radius } else { (1.0 - INSET) * radius };
            let angle = |k: usize| std::f64::consts::TAU * k as f64 / RIM as f64;
            let rim = |y: f64| (0..RIM).map(move |k| Vec3::new(around * angle(k).cos(), y, around * angle(k).sin()));
            let rims = rim(low.y).chain(rim(high.y)).map(|p| (p, 0.0));
            rims.chain(balls.into_iter().map(|y| (Vec3::new(0.0, y, 0.0), radius))).collect()
        }
        ShapeSpec::Surface { .. } => shape.triangles(0).into_iter().flat_map(|s| s.points).map(|v| (v, 0.0)).collect(),
        _ => {
            let corner = |k: usize| Vec3::from_fn(|i, _| if k >> i & 1 == 0 { low[i] } else { high[i] });
            (0..8).map(|k| (corner(k), 0.0)).collect()
        }
    }
}

/// Largest distance of two points of one face of a shape \[m\]: anything narrower can pass between them.
fn spacing(spec: &ShapeSpec, shape: &Shape) -> f64 {
    match spec {
        ShapeSpec::Sphere { .. } => 0.0,
        ShapeSpec::Surface { .. } => {
            let surface = shape.triangles(0).expect("a surface has triangles");
            let edge = |a: u32, b: u32| (surface.points[a as usize] - surface.points[b as usize]).norm();
            surface.triangles.iter().flat_map(|&[a, b, c]| [edge(a, b), edge(b, c), edge(c, a)]).fold(0.0, f64::max)
        }
        ShapeSpec::Box { .. } => shape.bounds().map_or(0.0, |[low, high]| {
            let size = high - low;
            (size.norm_squared() - size.min().powi(2)).sqrt()
        }),
        _ => shape.bounds().map_or(0.0, |[low, high]| (high - low).max()),
    }
}
