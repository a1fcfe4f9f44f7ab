//! Motion of obstacles: a translation along a direction and a rotation about an axis, by signals.
//!
//! A point X moves to P + R(θ)(X − P) + s e, with R(θ) of [`rotation`](crate::scene::rotation). The four nodes that carry the obstacle are prescribed
//! accordingly at the end of each step. Within a step they move along straight lines, so that the obstacle is slightly smaller in between: cos(Δθ/2) of its
//! size. The rotation of a step is therefore limited.

use crate::effect::contact::placement::AffineFrame;
use crate::math::signal::{Clock, Signal};
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::notes::jump::{Impact, note_jump};
use crate::scene::parts::contact::spec::MotionSpec;
use crate::scene::rotation::{check_in_contact, unit_vector};

/// Prescribes the four nodes that carry an obstacle along its motion.
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
            let signal = builder.signal(place, column.clone(), displacement, Dimension::LENGTH)?;
            note_jump(builder, &column, &signal, Impact::FromPlace);
            Some((direction, signal))
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
    let turn = motion.turn.as_ref().map(|turn| turn.build(builder, place, format!("{name}_angle_rad"))).transpose()?;
    if let Some(turn) = &turn {
        check_in_contact(builder, place, &turn.angle)?;
    }
    let frame = AffineFrame { nodes, center, length: builder.body.mesh.diagonal() };
    for (node, at) in nodes.into_iter().zip(frame.rest()) {
        for i in 0..3 {
            let translation = along.iter().map(|(e, s)| Signal::Product(vec![Signal::Constant(e[i]), s.clone()]));
            let rotation = turn.iter().map(|turn| turn.displacement(at, i));
            builder.carried.push((3 * node + i as u32, Signal::Sum(translation.chain(rotation).collect())));
        }
    }
    Ok(frame)
}

/// The initial displacement \[dofs\] with the body at rest: a dynamic run starts with obstacles where their motions put them, a static run with obstacles at
/// their given positions.
pub(super) fn start(builder: &Builder) -> Vec<f64> {
    let mut x = vec![0.0; 3 * builder.nodes];
    if builder.spans.first().is_some_and(|first| !first.integrator.is_static()) {
        let inputs = builder.signal_builder.initial();
        let now = Clock { t: 0.0, inputs: &inputs };
        builder.carried.iter().for_each(|(dof, signal)| x[*dof as usize] = signal.at(now));
    }
    x
}
