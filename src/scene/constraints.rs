//! Constraints of a scene: the registry of their kinds.

use super::builder::Builder;
use super::error::SceneError;
use super::parts::cable::{NamedCable, build_cable};
use super::parts::cavity::{NamedCavity, build_cavity};
use super::spec::{ConstraintSpec, SceneSpec};
use crate::math::signal::Signal;
use crate::math::units::Dimension;
use crate::solve::TimeSpan;
use crate::system::{Constraint, Effect};

/// Constraints of the system, with the cables and cavities among them.
pub(super) struct Constrained {
    pub(super) constraints: Vec<Box<dyn Constraint>>,
    pub(super) cables: Vec<NamedCable>,
    pub(super) cavities: Vec<NamedCavity>,
}

/// All constraints of a scene; drives that are loads are added to the effects, prescribed motions to the builder.
pub(super) fn build_constraints(
    builder: &mut Builder,
    spec: &SceneSpec,
    spans: &[TimeSpan],
    effects: &mut Vec<Box<dyn Effect>>,
) -> Result<Constrained, SceneError> {
    let (mut constraints, mut cables) = (Vec::<Box<dyn Constraint>>::new(), Vec::<NamedCable>::new());
    for (k, constraint) in spec.constraints.iter().enumerate() {
        let place = format!("constraint {} ({})", k + 1, constraint.kind());
        match constraint {
            ConstraintSpec::Fixed { region, components } => {
                builder.prescribe(&place, region, components, &Signal::Constant(0.0))?;
            }
            ConstraintSpec::Prescribed { region, components, displacement } => {
                let name = format!("{region}_{components}_displacement_m");
                let signal = builder.signal(&place, name, displacement, Dimension::LENGTH)?;
                builder.prescribe(&place, region, components, &signal)?;
            }
            ConstraintSpec::Cable(cable) => {
                if cables.iter().any(|c| c.name == cable.name) {
                    let fact = format!("another cable is called \"{}\" too", cable.name);
                    return Err(builder.content(&place, fact, "give each cable a `name` of its own"));
                }
                cables.push(build_cable(builder, &place, cable, spans, effects, &mut constraints)?);
            }
            // Built below: the held dofs decide whether a cavity may be open
            ConstraintSpec::Cavity { .. } => {}
        }
    }
    let mut cavities = Vec::<NamedCavity>::new();
    for (k, constraint) in spec.constraints.iter().enumerate() {
        if let ConstraintSpec::Cavity { name, .. } = constraint {
            let place = format!("constraint {} (cavity)", k + 1);
            if cavities.iter().any(|c| c.name == *name) || cables.iter().any(|c| c.name == *name) {
                let fact = format!("another cable or cavity is called \"{name}\" too");
                return Err(builder.content(&place, fact, "give each a `name` of its own"));
            }
            cavities.push(build_cavity(builder, &place, constraint, effects, &mut constraints)?);
        }
    }
    Ok(Constrained { constraints, cables, cavities })
}
