//! Effects of a scene. Each kind has one file, and a line in each of the three lists below.

mod edge_dampers;
mod edge_springs;
mod elastic;
mod fibre;
mod fibre_family;
mod gravity;
mod inertia;
mod mass_damping;
mod membrane;
mod mullins;
mod of_law;
mod part;
mod point_force;
mod repeated;
mod stiffness_damping;
mod traction;
mod viscoelastic;
mod viscous_damping;

pub use edge_dampers::EdgeDampersSpec;
pub use edge_springs::EdgeSpringsSpec;
pub use elastic::{ElasticSpec, FormulationSpec};
pub use fibre::{FibreAlong, FibreSpec, Hand, HelixSpec};
pub use fibre_family::{DirectionSpec, FibreFamilySpec};
pub use gravity::GravitySpec;
pub use inertia::{InertiaSpec, LumpingSpec};
pub use mass_damping::MassDampingSpec;
pub use membrane::MembraneSpec;
pub use mullins::{MullinsSpec, SofteningSpec};
pub use point_force::PointForceSpec;
pub use stiffness_damping::{StiffnessDampingSpec, StiffnessSpec};
pub use traction::TractionSpec;
pub use viscoelastic::{ArmSpec, ModuliSpec, SeriesSpec, ViscoelasticSpec};
pub use viscous_damping::ViscousDampingSpec;

use crate::math::tensor::Vec3;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::text::kind::registry;
use part::EffectPart;
pub use part::OverlapSpec;
use std::collections::BTreeMap;

registry! {
EffectPart;
/// One effect of a scene.
pub enum EffectSpec {
    Elastic(ElasticSpec) = "elastic",
    Inertia(InertiaSpec) = "inertia",
    Gravity(GravitySpec) = "gravity",
    MassDamping(MassDampingSpec) = "mass_damping",
    ViscousDamping(ViscousDampingSpec) = "viscous_damping",
    Viscoelastic(ViscoelasticSpec) = "viscoelastic",
    Mullins(MullinsSpec) = "mullins",
    StiffnessDamping(StiffnessDampingSpec) = "stiffness_damping",
    Membrane(MembraneSpec) = "membrane",
    FibreFamily(FibreFamilySpec) = "fibre_family",
    Fibre(FibreSpec) = "fibre",
    EdgeSprings(EdgeSpringsSpec) = "edge_springs",
    EdgeDampers(EdgeDampersSpec) = "edge_dampers",
    PointForce(PointForceSpec) = "point_force",
    Traction(TractionSpec) = "traction",
}
}

impl EffectSpec {
    /// The keys of the effect in words: `region body, law rubber, formulation mixed`.
    pub fn words(&self) -> String {
        self.part().words()
    }

    /// The name of the law that the effect uses.
    pub(in crate::scene) fn law(&self) -> Option<&str> {
        self.part().law()
    }

    /// The region whose cells the effect makes elastic, and whether it adds to another effect there.
    pub(in crate::scene) fn resists(&self) -> Option<(&str, bool)> {
        self.part().resists()
    }

    /// The ball on which the effect acts, as its centre and its radius \[m\].
    pub(in crate::scene) fn ball(&self) -> Option<(Vec3, f64)> {
        self.part().ball()
    }

    /// Whether the effect acts on velocities or accelerations, so that it vanishes in static stages.
    pub(in crate::scene) fn needs_rates(&self) -> bool {
        self.part().needs_rates()
    }
}

/// Builds all effects of a scene, in the order of the file.
pub(in crate::scene) fn build_effects(builder: &mut Builder, specs: &[EffectSpec]) -> Result<(), SceneError> {
    let mut order: Vec<usize> = (0..specs.len()).collect();
    order.sort_by_key(|&k| specs[k].part().needs_others());
    let mut built = BTreeMap::new();
    for k in order {
        let place = format!("effect {} ({})", k + 1, specs[k].kind());
        built.insert(k, specs[k].part().build(&place, builder)?);
    }
    builder.effects.extend(built.into_values());
    specs.iter().enumerate().try_for_each(|(k, spec)| spec.part().check(k + 1, builder))
}

/// Adds notes on the effects of a scene in its stages.
pub(in crate::scene) fn note_effects(builder: &mut Builder, specs: &[EffectSpec]) {
    let stages = builder.spans.iter().filter(|s| s.integrator.is_static()).count();
    let resting: Vec<&str> = specs.iter().filter(|e| e.needs_rates()).map(EffectSpec::kind).collect();
    if stages > 0 && !resting.is_empty() {
        builder.notes.push(format!("{} rest in the {stages} static stage(s)", resting.join(", ")));
    }
    specs.iter().for_each(|spec| spec.part().note(builder));
}

/// The reason, from the effects of a scene, why the solution has no limit as h → 0.
pub(in crate::scene) fn no_limit(specs: &[EffectSpec]) -> Option<String> {
    specs.iter().find_map(|spec| spec.part().no_limit()).map(String::from)
}
