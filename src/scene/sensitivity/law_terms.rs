//! ∂r/∂θ with respect to a constant of a law, from the derivative of the law ([`crate::material::derivative`]) in every effect that uses it: elastic,
//! membrane, viscoelastic, mullins, stiffness damping.

use super::error::SensitivityError;
use super::parameter_key::LawConstant;
use crate::effect::StiffnessDamping;
use crate::material::sensitivity::derivative_of;
use crate::scene::build::Scene;
use crate::scene::error::hint;
use crate::scene::spec::EffectSpec;
use crate::system::{Effect, ParameterDerivative};
use std::sync::Arc;

/// Whether the derivative of a law with respect to a constant has a closed form. Also true for a law that does not exist: [`law_terms`] reports the mistake.
pub(in crate::scene) fn is_exact(scene: &Scene, constant: &LawConstant) -> bool {
    let law = scene.spec.laws.get(constant.law).map(|table| scene.spec.known_laws.law(table));
    !matches!(law, Some(Ok(law)) if !law.is_differentiated_exactly())
}

/// Whether more than the effects of [`law_terms`] depends on laws: contacts without a modulus of their own, and rigid bodies, use that of a law.
pub(super) fn others_follow_laws(scene: &Scene) -> bool {
    !scene.spec.rigids.is_empty() || scene.spec.contacts.iter().any(|contact| contact.modulus.is_none())
}

/// ∂/∂θ of every effect that uses the law of a constant.
pub(in crate::scene) fn law_terms(
    scene: &Scene,
    constant: &LawConstant,
) -> Result<Vec<ParameterDerivative>, SensitivityError> {
    let (laws, mesh) = (&scene.spec.laws, &scene.body.mesh);
    let name = format!("laws.{}.{}", constant.law, constant.key);
    let table = laws.get(constant.law).ok_or_else(|| {
        let known: Vec<&String> = laws.keys().collect();
        SensitivityError::NoLaw { constant: name.clone(), hint: hint(constant.law, &known) }
    })?;
    let along = || {
        let given = scene.spec.known_laws.given(table);
        let along = given.and_then(|(entry, values, options)| derivative_of(entry, &values, &options, constant.key));
        along.map_err(|source| SensitivityError::Law { constant: name.clone(), source })
    };
    let (mut stressed, mut relaxing) = (scene.stressed.iter(), scene.relaxing.iter());
    let (mut membranes, mut softening) = (scene.membranes.iter(), scene.softening.iter());
    let mut found = Vec::new();
    // For stiffness damping: the region, and ∂/∂θ of the elastic effect there
    let mut elastic: Vec<(&str, Arc<dyn Effect>)> = Vec::new();
    for (of, spec) in scene.spec.effects.iter().enumerate() {
        match spec {
            EffectSpec::Elastic(solid) => {
                let effect = stressed.next().expect("one for each elastic effect");
                if solid.law == constant.law {
                    let shared: Arc<dyn Effect> = effect.along(mesh, along()?).into();
                    elastic.push((&solid.region, shared.clone()));
                    found.push(ParameterDerivative { of, effect: Box::new(shared) });
                }
            }
            EffectSpec::Viscoelastic(viscoelastic) => {
                let effect = relaxing.next().expect("one for each viscoelastic effect");
                if viscoelastic.law == constant.law {
                    found.push(ParameterDerivative { of, effect: effect.along(&*along()?) });
                }
            }
            EffectSpec::Mullins(mullins) => {
                let effect = softening.next().expect("one for each softening effect");
                if mullins.law == constant.law {
                    found.push(ParameterDerivative { of, effect: effect.along(&*along()?) });
                }
            }
            EffectSpec::Membrane(sheet) => {
                let effect = membranes.next().expect("one for each membrane");
                if sheet.law == constant.law {
                    found.push(ParameterDerivative { of, effect: effect.along(along()?) });
                }
            }
            _ => {}
        }
    }
    if found.is_empty() {
        return Err(SensitivityError::Unused { constant: name });
    }
    for (of, spec) in scene.spec.effects.iter().enumerate() {
        let EffectSpec::StiffnessDamping(spec) = spec else { continue };
        let damped = elastic.iter().filter(|(of, _)| *of == spec.region).map(|(_, effect)| effect.clone()).collect();
        let damping = StiffnessDamping::new(damped, spec.beta.0, spec.stiffness.into(), &mesh.points);
        found.push(ParameterDerivative { of, effect: Box::new(damping.expect("built once already")) });
    }
    let tied =
        |ParameterDerivative { of, effect }| ParameterDerivative { of, effect: scene.system.ties.effect(effect) };
    Ok(found.into_iter().map(tied).collect())
}
