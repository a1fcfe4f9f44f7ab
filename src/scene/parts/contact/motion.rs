//! Motion of obstacles: a translation along a direction and a rotation about an axis, by signals.
//!
//! A point X goes to P + R(θ)(X − P) + s e, with R(θ) v = v + (cos θ − 1)(v − k kᵀv) + sin θ k × v (Rodrigues). The four nodes that carry the
//! obstacle are prescribed so at the end of each step. Within a step they go straight, and the obstacle is a little smaller in
//! between: cos(Δθ/2) of its size.

use crate::effect::contact::placement::AffineFrame;
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::parts::contact::spec::{MotionSpec, TurningSpec};

/// The four nodes that carry an obstacle along its motion.
pub(in crate::scene) fn carry(
    builder: &mut Builder,
    place: &str,
    name: &str,
    motion: &MotionSpec,
    center: Vec3,
    nodes: [u32; 4],
) -> Result<AffineFrame, SceneError> {
    let along = match (&motion.direction, &motion.displacement) {
        (Some(direction), Some(displacement)) => {
            let direction = unit_vector(builder, place, "direction", *direction)?;
            let column = format!("{name}_displacement_m");
            Some((direction, builder.signal(place, column, displacement, Dimension::LENGTH)?))
        }
        (None, None) if motion.turn.is_some() => None,
        (None, None) => {
            return Err(builder.content(
                place,
                "the motion is empty",
                "give `direction` and `displacement`, or `turn`",
            ));
        }
        _ => {
            let fact = "one of `direction` and `displacement` is given without the other";
            return Err(builder.content(place, fact, "give both"));
        }
    };
    let turn = match &motion.turn {
        Some(TurningSpec { axis, about, angle }) => {
            let axis = unit_vector(builder, place, "axis", *axis)?;
            let signal = builder.signal(place, format!("{name}_angle_rad"), angle, Dimension::ANGLE)?;
            Some((axis, Vec3::from(about.map(|x| x.0)), signal))
        }
        None => None,
    };
    let frame = AffineFrame { nodes, center, length: builder.body.mesh.diagonal() };
    for (node, at) in nodes.into_iter().zip(frame.rest()) {
        for i in 0..3 {
            let translation = along.iter().map(|(e, s)| Signal::Product(vec![Signal::Constant(e[i]), s.clone()]));
            let rotation = turn.iter().map(|(axis, about, angle)| {
                let v = at - about;
                let (cosine, sine) = ((v - axis * axis.dot(&v))[i], axis.cross(&v)[i]);
                Signal::Turn { angle: Box::new(angle.clone()), cosine, sine }
            });
            builder.carried.push((3 * node + i as u32, Signal::Sum(translation.chain(rotation).collect())));
        }
    }
    Ok(frame)
}

fn unit_vector(builder: &Builder, place: &str, key: &str, v: [f64; 3]) -> Result<Vec3, SceneError> {
    let v = Vec3::from(v);
    if v.norm() > 0.0 && v.norm().is_finite() {
        return Ok(v.normalize());
    }
    Err(builder.content(place, format!("the {key} of the motion has no length"), "write for example [0, 0, 1]"))
}
