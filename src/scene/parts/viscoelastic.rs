//! The viscoelastic effect of a scene: its series, and the elastic effect that it belongs to.

use crate::effect::Viscoelastic;
use crate::material::{Arm, Constants, Prony};
use crate::scene::build::part;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::spec::{ArmSpec, EffectSpec, ModuliSpec, SceneSpec};
use crate::solve::TimeSpan;

pub(in crate::scene) fn build_viscoelastic(
    builder: &Builder,
    place: &str,
    region: &str,
    law: &str,
    moduli: ModuliSpec,
    prony: &[ArmSpec],
) -> Result<Viscoelastic, SceneError> {
    let constants = match moduli {
        ModuliSpec::LongTerm => Constants::LongTerm,
        ModuliSpec::Instantaneous => Constants::Instantaneous,
    };
    let arms: Vec<Arm> = prony.iter().map(|arm| Arm { g: arm.g, tau: arm.tau.0 }).collect();
    let prony = Prony::new(&arms, constants).map_err(|e| part(builder.file, place, e))?;
    let (cells, law) = (builder.cells(place, region)?, builder.law(place, law)?);
    Viscoelastic::new(&builder.body.mesh, cells, &*law, prony).map_err(|e| part(builder.file, place, e))
}

/// Each cell of a viscoelastic effect is elastic with the same law, and belongs to one such effect only.
pub(in crate::scene) fn check_viscoelastic(builder: &Builder, spec: &SceneSpec) -> Result<(), SceneError> {
    let mut relaxing = vec![0; builder.body.mesh.cell_count()];
    for (k, effect) in spec.effects.iter().enumerate() {
        let EffectSpec::Viscoelastic { region, law, .. } = effect else { continue };
        let place = format!("effect {} ({})", k + 1, effect.kind());
        let mut elastic = vec![false; relaxing.len()];
        for other in &spec.effects {
            if let EffectSpec::Elastic { region, law: its, .. } = other
                && its == law
            {
                builder.cells(&place, region)?.iter().for_each(|&c| elastic[c as usize] = true);
            }
        }
        for &c in builder.cells(&place, region)? {
            if !elastic[c as usize] {
                let fact = format!("cell {c} of region \"{region}\" has no elastic effect with the law \"{law}\"");
                let remedy = "give `law` and `region` of an [[effect]] of kind \"elastic\"";
                return Err(builder.content(&place, fact, remedy));
            }
            let other = std::mem::replace(&mut relaxing[c as usize], k + 1);
            if other > 0 {
                let fact = format!("cell {c} of region \"{region}\" relaxes by effect {other} already");
                return Err(builder.content(&place, fact, "put all terms into the `prony` of one effect"));
            }
        }
    }
    Ok(())
}

/// Notes the meaning of the constants, and the stages in which the effect does not act.
pub(in crate::scene) fn note_viscoelastic(builder: &mut Builder, spec: &SceneSpec, spans: &[TimeSpan]) {
    for effect in &spec.effects {
        let EffectSpec::Viscoelastic { law, moduli, prony, .. } = effect else { continue };
        let kept = 1.0 - prony.iter().map(|arm| arm.g).sum::<f64>();
        let given = match moduli {
            ModuliSpec::LongTerm => format!("of the long term, {:.4} of them act at once", 1.0 / kept),
            ModuliSpec::Instantaneous => format!("of the instant, {kept:.4} of them are left in the long run"),
        };
        builder.notes.push(format!("viscoelastic: the constants of {law} are those {given}"));
        if spans.iter().any(|s| s.integrator.is_static()) {
            builder.notes.push("viscoelastic: static stages see the long-term response".into());
        }
        let shortest = prony.iter().map(|arm| arm.tau.0).fold(f64::INFINITY, f64::min);
        for (k, span) in spans.iter().enumerate().filter(|(_, s)| !s.integrator.is_static() && s.dt > shortest) {
            let dt = span.dt;
            builder.notes.push(format!("viscoelastic: dt = {dt} s of stage {} is above tau = {shortest} s", k + 1));
        }
    }
}
