//! Short descriptions of a scene: the quantity that represents it, and its formulation.

use super::parts::constraints::ConstraintSpec;
use super::parts::effects::EffectSpec;
use super::parts::probes::ProbeSpec;
use super::record::recorder::Headline;
use super::spec::SceneSpec;
use std::collections::BTreeSet;

impl SceneSpec {
    /// Names of the laws that its effects use.
    pub fn laws_in_use(&self) -> BTreeSet<&str> {
        self.effects.iter().filter_map(EffectSpec::law).collect()
    }

    /// The default quantity for comparing runs: that of the first probe that has one, otherwise that of the first cable or cavity.
    pub fn headline(&self) -> Option<Headline> {
        let of_probes = self.probes.iter().find_map(ProbeSpec::headline);
        of_probes.or_else(|| self.constraints.iter().find_map(ConstraintSpec::headline))
    }

    /// Element and formulation in one word: `tet4`, `tet10`, `tet4_up`, `tet10_up`, `tet10_p0`; `mass_spring` if springs are the only elastic effects.
    pub fn formulation(&self) -> String {
        let of = |e: &EffectSpec| match e {
            EffectSpec::Elastic(elastic) => Some(elastic.formulation),
            _ => None,
        };
        let elastic = self.effects.iter().find_map(of);
        if elastic.is_none() && self.effects.iter().any(|e| matches!(e, EffectSpec::EdgeSprings(_))) {
            return "mass_spring".into();
        }
        format!("{}{}", self.mesh.element.name(), elastic.map_or("", |formulation| formulation.suffix()))
    }
}
