//! Element and formulation of a scene in one word.

use super::spec::{EffectSpec, FormulationSpec, SceneSpec};

impl SceneSpec {
    /// Element and formulation in one word: `tet4`, `tet10`, `tet4_up`, `tet10_up`, `tet10_p0`; `mass_spring` where springs
    /// are all that is elastic.
    pub fn formulation(&self) -> String {
        let of = |e: &EffectSpec| match e {
            EffectSpec::Elastic { formulation, .. } => Some(*formulation),
            _ => None,
        };
        let elastic = self.effects.iter().find_map(of);
        if elastic.is_none() && self.effects.iter().any(|e| matches!(e, EffectSpec::EdgeSprings { .. })) {
            return "mass_spring".into();
        }
        let suffix = match elastic {
            Some(FormulationSpec::Mixed) => "_up",
            Some(FormulationSpec::MeanDilatation) => "_p0",
            _ => "",
        };
        format!("{}{suffix}", self.mesh.element.name())
    }
}
