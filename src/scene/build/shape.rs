//! Shapes of obstacles and rigid bodies of a scene.

use crate::effect::contact::shape::Shape;
use crate::math::tensor::{Mat3, Vec3};
use crate::math::units::{self, Dimension};
use crate::mesh::surface_file::read_surface;
use crate::scene::text::quantity::{Angle, Length};
use nalgebra::{Rotation3, Unit};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// An obstacle: a shape in space, a rigid body of the scene, or another part of the surface. A rigid body has one of the shapes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum ShapeSpec {
    /// The half-space below the plane through `point`
    Floor {
        /// Point of the plane
        point: [Length; 3],
        /// Outward normal of the half-space; its length does not matter
        normal: [f64; 3],
    },
    /// A box along the axes, or rotated about its centre by `turn`
    Box {
        /// Corner with the smallest coordinates
        min: [Length; 3],
        /// Corner with the largest coordinates
        max: [Length; 3],
        /// Rotation about its centre
        turn: Option<TurnSpec>,
    },
    /// A ball
    Sphere {
        /// Centre of the ball
        center: [Length; 3],
        /// Radius of the ball
        radius: Length,
    },
    /// A circular cylinder with flat ends
    Cylinder {
        /// Centre of one end
        from: [Length; 3],
        /// Centre of the other end
        to: [Length; 3],
        /// Radius of the cylinder
        radius: Length,
    },
    /// A closed surface from an STL or OBJ file, oriented outwards
    Surface {
        /// Path of the file, relative to the scene
        file: PathBuf,
        /// Unit of length of the file
        unit: String,
    },
    /// A rigid body of the scene
    Rigid {
        /// Name of the rigid body
        body: String,
    },
    /// Facets of a deformable body
    Region {
        /// Region of facets
        region: String,
    },
}

impl ShapeSpec {
    /// The kind of the shape and the name that it refers to, such as `floor` or `rigid ball`.
    pub fn words(&self) -> String {
        match self {
            Self::Floor { .. } => "floor".into(),
            Self::Box { .. } => "box".into(),
            Self::Sphere { .. } => "sphere".into(),
            Self::Cylinder { .. } => "cylinder".into(),
            Self::Surface { file, .. } => format!("surface {}", file.display()),
            Self::Rigid { body } => format!("rigid {body}"),
            Self::Region { region } => format!("region {region}"),
        }
    }
}

/// A rotation by the right-hand rule.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurnSpec {
    /// Direction of the axis; its length does not matter
    pub axis: [f64; 3],
    /// Angle of the rotation
    pub angle: Angle,
}

impl TurnSpec {
    pub(in crate::scene) fn axes(&self) -> Result<Mat3, ShapeFault> {
        let axis = Vec3::from(self.axis);
        if axis.norm() == 0.0 || !axis.norm().is_finite() {
            return Err(ShapeFault::Content("the axis of `turn` has no length".into(), "write for example [0, 1, 0]"));
        }
        Ok(Rotation3::from_axis_angle(&Unit::new_normalize(axis), self.angle.0).into_inner())
    }
}

/// Reason why a shape cannot be built.
pub(in crate::scene) enum ShapeFault {
    Content(String, &'static str),
    Part(Box<dyn std::error::Error + Send + Sync>),
}

fn vector(p: &[Length; 3]) -> Vec3 {
    Vec3::new(p[0].0, p[1].0, p[2].0)
}

impl ShapeSpec {
    /// Builds the shape, with the origin and axes of its frame.
    pub(in crate::scene) fn build(&self, base: &Path) -> Result<(Shape, Vec3, Mat3), ShapeFault> {
        let positive = |r: f64| {
            let fact = || ShapeFault::Content(format!("the radius is {} mm", r * 1e3), "it must be positive");
            if r > 0.0 { Ok(r) } else { Err(fact()) }
        };
        Ok(match self {
            Self::Floor { point, normal } => {
                let normal = Vec3::from(*normal);
                if normal.norm() == 0.0 || !normal.norm().is_finite() {
                    let remedy = "write for example [0, 0, 1]";
                    return Err(ShapeFault::Content("the normal has no length".into(), remedy));
                }
                (Shape::floor(), vector(point), turn(&Vec3::z(), &normal))
            }
            Self::Box { min, max, turn } => {
                let (low, high) = (vector(min), vector(max));
                if (0..3).any(|i| low[i] >= high[i]) {
                    let fact = "`min` is not below `max`".into();
                    return Err(ShapeFault::Content(fact, "give the lower corner as `min`"));
                }
                let axes = turn.as_ref().map_or(Ok(Mat3::identity()), TurnSpec::axes)?;
                (Shape::cuboid(0.5 * (high - low)), 0.5 * (low + high), axes)
            }
            Self::Sphere { center, radius } => (Shape::sphere(positive(radius.0)?), vector(center), Mat3::identity()),
            Self::Cylinder { from, to, radius } => {
                let axis = vector(to) - vector(from);
                if axis.norm() == 0.0 {
                    let fact = "`from` and `to` are the same point".into();
                    return Err(ShapeFault::Content(fact, "give the two ends of the axis"));
                }
                let shape = Shape::cylinder(0.5 * axis.norm(), positive(radius.0)?);
                (shape, 0.5 * (vector(from) + vector(to)), turn(&Vec3::y(), &axis))
            }
            Self::Surface { file, unit } => {
                let fault = |e: Box<dyn std::error::Error + Send + Sync>| ShapeFault::Part(e);
                let unit = units::parse(&format!("1 {unit}"), Dimension::LENGTH).map_err(|e| fault(e.into()))?;
                let surface = read_surface(&base.join(file), unit).map_err(|e| fault(e.into()))?;
                (Shape::surface(&surface).map_err(|e| fault(e.into()))?, Vec3::zeros(), Mat3::identity())
            }
            Self::Rigid { body: name } | Self::Region { region: name } => {
                let fact = format!("\"{name}\" is a body of the scene, and no shape in space");
                return Err(ShapeFault::Content(fact, "take a box, a sphere, a cylinder or a surface"));
            }
        })
    }
}

/// Rotation that turns `from` into the direction of `to`.
fn turn(from: &Vec3, to: &Vec3) -> Mat3 {
    // Opposite directions have no unique shortest rotation.
    let flip = || Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
    Rotation3::rotation_between(from, to).map_or_else(flip, |r| r.into_inner())
}
