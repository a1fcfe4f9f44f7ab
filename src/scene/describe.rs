//! Kinds that can be declared, and the description of a declared effect: its region, law and form.

use super::parts::probes::{Headline, ProbeSpec};
use super::quantity::GuideRadius;
use super::spec::{ConstraintSpec, EffectSpec, FormulationSpec, LumpingSpec, ModuliSpec, SceneSpec, StiffnessSpec};
use crate::mesh::error::point;
use nalgebra::Vector3;

impl EffectSpec {
    /// Every kind.
    pub const KINDS: [&str; 11] = [
        "elastic",
        "inertia",
        "gravity",
        "mass_damping",
        "viscous_damping",
        "viscoelastic",
        "stiffness_damping",
        "edge_springs",
        "edge_dampers",
        "point_force",
        "traction",
    ];

    /// Name as in files.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Elastic { .. } => "elastic",
            Self::Inertia { .. } => "inertia",
            Self::Gravity { .. } => "gravity",
            Self::MassDamping { .. } => "mass_damping",
            Self::ViscousDamping { .. } => "viscous_damping",
            Self::Viscoelastic { .. } => "viscoelastic",
            Self::StiffnessDamping { .. } => "stiffness_damping",
            Self::EdgeSprings { .. } => "edge_springs",
            Self::EdgeDampers { .. } => "edge_dampers",
            Self::PointForce { .. } => "point_force",
            Self::Traction { .. } => "traction",
        }
    }

    /// Whether the effect acts on velocities or accelerations, so that it is at rest in static stages.
    pub(super) fn needs_rates(&self) -> bool {
        match self {
            Self::Inertia { .. }
            | Self::MassDamping { .. }
            | Self::ViscousDamping { .. }
            | Self::StiffnessDamping { .. }
            | Self::EdgeDampers { .. } => true,
            Self::Elastic { .. }
            | Self::Gravity { .. }
            | Self::Viscoelastic { .. }
            | Self::EdgeSprings { .. }
            | Self::PointForce { .. }
            | Self::Traction { .. } => false,
        }
    }

    /// `region body, law rubber, formulation mixed`
    pub fn words(&self) -> String {
        let mass = |mass: &LumpingSpec| match mass {
            LumpingSpec::Consistent => "consistent",
            LumpingSpec::Lumped => "lumped",
            LumpingSpec::Uniform => "uniform",
        };
        match self {
            Self::Elastic { region, law, formulation } => {
                let formulation = match formulation {
                    FormulationSpec::Displacement => "displacement",
                    FormulationSpec::Mixed => "mixed",
                    FormulationSpec::MeanDilatation => "mean_dilatation",
                };
                format!("region {region}, law {law}, formulation {formulation}")
            }
            Self::Inertia { region, density, mass: m } => {
                format!("region {region}, {} kg/m^3, mass {}", density.0, mass(m))
            }
            Self::Gravity { region, density, direction, .. } => {
                format!("region {region}, {} kg/m^3, towards {direction:?}", density.0)
            }
            Self::MassDamping { region, alpha, mass: m, .. } => {
                format!("region {region}, alpha = {} 1/s, mass {}", alpha.0, mass(m))
            }
            Self::ViscousDamping { region, eta } => format!("region {region}, eta = {} Pa s", eta.0),
            Self::Viscoelastic { region, law, moduli, prony } => {
                let moduli = match moduli {
                    ModuliSpec::LongTerm => "long_term",
                    ModuliSpec::Instantaneous => "instantaneous",
                };
                format!("region {region}, law {law}, moduli {moduli}, {} Prony terms", prony.len())
            }
            Self::StiffnessDamping { region, beta, stiffness } => {
                let stiffness = match stiffness {
                    StiffnessSpec::Initial => "initial",
                    StiffnessSpec::Last => "last",
                };
                format!("region {region}, beta = {} s, stiffness {stiffness}", beta.0)
            }
            Self::EdgeSprings { region, stiffness, modulus } => match (stiffness, modulus) {
                (Some(k), _) => format!("region {region}, {} N/m on every edge", k.0),
                (None, modulus) => format!("region {region}, E = {} Pa", modulus.map_or(0.0, |e| e.0)),
            },
            Self::EdgeDampers { region, damping } => format!("region {region}, {} N s/m", damping.0),
            Self::PointForce { point: at, radius, direction, .. } => {
                let at = point(&Vector3::new(at[0].0, at[1].0, at[2].0));
                let patch = match radius {
                    GuideRadius::Point => "on a point".to_string(),
                    GuideRadius::Ball(radius) => format!("on a ball of {:.4} mm", radius * 1e3),
                };
                format!("at {at}, {patch}, towards {direction:?}")
            }
            Self::Traction { region, skin, direction, .. } => match (region, skin) {
                (Some(region), _) => format!("region {region}, towards {direction:?}"),
                (None, skin) => format!("skin {}, towards {direction:?}", skin.as_deref().unwrap_or_default()),
            },
        }
    }
}

impl ConstraintSpec {
    /// Every kind.
    pub const KINDS: [&str; 4] = ["fixed", "prescribed", "cable", "cavity"];

    /// Name as in files.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Fixed { .. } => "fixed",
            Self::Prescribed { .. } => "prescribed",
            Self::Cable(_) => "cable",
            Self::Cavity { .. } => "cavity",
        }
    }
}

impl SceneSpec {
    /// The quantity by which runs are compared where nothing else is said: of the first probe that has one, else of the
    /// first cable or cavity.
    pub fn headline(&self) -> Option<Headline> {
        let of_constraint = |c: &ConstraintSpec| match c {
            ConstraintSpec::Cable(cable) => {
                let column = format!("{}_tension_N", cable.name);
                Some(Headline { column, label: "cable tension", symbol: "T", unit: "N" })
            }
            ConstraintSpec::Cavity { name, .. } => {
                Some(Headline { column: format!("{name}_pressure_Pa"), label: "pressure", symbol: "p", unit: "Pa" })
            }
            ConstraintSpec::Fixed { .. } | ConstraintSpec::Prescribed { .. } => None,
        };
        let of_probes = self.probes.iter().find_map(ProbeSpec::headline);
        of_probes.or_else(|| self.constraints.iter().find_map(of_constraint))
    }

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
