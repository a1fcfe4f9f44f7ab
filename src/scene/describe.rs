//! Short descriptions of a scene: the quantity that represents it, its formulation.

use super::parts::constraints::ConstraintSpec;
use super::parts::effects::EffectSpec;
use super::parts::probes::ProbeSpec;
use super::record::recorder::Headline;
use super::spec::SceneSpec;
use std::collections::BTreeSet;

impl SceneSpec {
    /// Names of the laws that its effects take.
    pub fn laws_in_use(&self) -> BTreeSet<&str> {
        self.effects.iter().filter_map(EffectSpec::law).collect()
    }

    /// The quantity by which runs are compared where nothing else is said: of the first probe that has one, else of the
    /// first cable or cavity.
    pub fn headline(&self) -> Option<Headline> {
        let of_probes = self.probes.iter().find_map(ProbeSpec::headline);
        of_probes.or_else(|| self.constraints.iter().find_map(ConstraintSpec::headline))
    }

    /// Element and formulation in one word: `tet4`, `tet10`, `tet4_up`, `tet10_up`, `tet10_p0`; `mass_spring` where springs
    /// are all that is elastic.
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
