//! From a [`SceneSpec`] to a [`System`]: meshes, regions, laws, effects, constraints.

use super::error::{SceneError, explain};
use super::overrides;
use super::probe::Probe;
use super::quantity::Length;
use super::spec::{
    ConstraintSpec, DriveSpec, EffectSpec, GuideRadius, IntegratorSpec, LumpingSpec, SceneSpec, SelectorSpec, StageSpec,
};
use crate::effect::{
    Cable, CableLength, CableTension, Elastic, Gravity, Guide, Inertia, Lumping, Mass, MassDamping, ViscousDamping,
};
use crate::material::{self, Law};
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::mesh::embed::{ball_weights, embed};
use crate::mesh::generate::CablePath;
use crate::mesh::select::{Pick, Selector};
use crate::mesh::{Region, TetMesh};
use crate::solve::{Integrator, Span};
use crate::system::{Constraint, Effect, Prescribed, System};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A mesh and what its maker says of it.
#[derive(Debug)]
pub struct Body {
    pub mesh: TetMesh,
    /// Cable paths by name
    pub paths: BTreeMap<String, CablePath>,
    /// File name, for provenance
    pub source: String,
    /// SHA-256 of the file
    pub sha256: String,
}

/// A scene ready to run.
pub struct Scene {
    pub title: String,
    pub body: Arc<Body>,
    pub system: System,
    /// For the record: law name and constants of the first elastic effect
    pub law: Box<dyn Law>,
    /// The same elastic effect and cables as in the system, for probes
    pub elastic: Vec<Arc<Elastic>>,
    pub cables: Vec<NamedCable>,
    pub probes: Vec<Probe>,
    pub spans: Vec<Span>,
    pub spec: SceneSpec,
    /// The scene as it was read, with its changes
    pub text: String,
    /// Regions that depend on the mesh, effects that rest in static stages, …
    pub remarks: Vec<String>,
    /// Why the answer has no limit as h → 0
    pub no_limit: Option<String>,
}

/// A cable with its drive, for probes.
pub struct NamedCable {
    pub name: String,
    pub cable: Arc<Cable>,
    pub drive: CableDrive,
}

/// Where the tension of a cable comes from.
pub enum CableDrive {
    /// Index of the constraint whose multiplier it is
    Multiplier(usize),
    Tension(Signal),
}

/// Reads a scene file, applies `key=value` changes and puts included laws in their place, so that the text that comes
/// back says it all. Errors carry file, line and remedy.
pub fn read_scene(file: &Path, changes: &[(String, toml::Value)]) -> Result<(SceneSpec, String), SceneError> {
    let (text, mut table) = read_table(file)?;
    let syntax = |e: toml::de::Error| SceneError::Syntax { file: file.into(), message: explain(&e) };
    // Errors of the file itself are reported with their line.
    toml::from_str::<SceneSpec>(&text).map_err(syntax)?;
    for (path, value) in changes {
        overrides::apply(&mut table, path, value.clone()).map_err(|e| part(file, "change", e))?;
    }
    let base = file.parent().unwrap_or(Path::new(""));
    for (name, law) in table.get_mut("laws").and_then(toml::Value::as_table_mut).into_iter().flatten() {
        let Some(law) = law.as_table_mut() else { continue };
        let Some(include) = law.remove("include") else { continue };
        let Some(include) = include.as_str() else {
            let place = format!("laws.{name}");
            let (fact, remedy) = ("`include` is not a file name".into(), "write include = \"law.toml\"".into());
            return Err(SceneError::Content { file: file.into(), place, fact, remedy });
        };
        let (_, mut included) = read_table(&base.join(include))?;
        included.extend(std::mem::take(law));
        *law = included;
    }
    let text = toml::to_string(&table).expect("a table that was read can be written");
    let spec = SceneSpec::deserialize(table).map_err(|e| SceneError::Syntax {
        file: file.into(),
        message: format!("after the changes of this case: {}", explain(&e)),
    })?;
    Ok((spec, text))
}

/// Text and table of a TOML file.
pub fn read_table(file: &Path) -> Result<(String, toml::Table), SceneError> {
    let unreadable = |e: std::io::Error| SceneError::Unreadable { file: file.into(), reason: e.to_string() };
    let text = std::fs::read_to_string(file).map_err(unreadable)?;
    let syntax = |e: toml::de::Error| SceneError::Syntax { file: file.into(), message: explain(&e) };
    let table = text.parse().map_err(syntax)?;
    Ok((text, table))
}

pub(super) fn part(
    file: &Path,
    place: impl Into<String>,
    source: impl Into<Box<dyn std::error::Error + Send + Sync>>,
) -> SceneError {
    SceneError::Part { file: file.into(), place: place.into(), source: source.into() }
}

impl Scene {
    /// Assembles the scene on its mesh. `file` is the scene file: paths are relative to it.
    pub fn build(file: &Path, spec: SceneSpec, text: String, body: Arc<Body>) -> Result<Self, SceneError> {
        let builder = Builder::new(file, &spec, body.clone())?;
        let spans = builder.spans(&spec.stages)?;
        builder.check_rates(&spec, &spans)?;
        let mut prescribed = Vec::new();
        let (mut effects, mut elastic, mut laws) = (Vec::<Box<dyn Effect>>::new(), Vec::new(), Vec::new());
        for (k, effect) in spec.effects.iter().enumerate() {
            effects.push(builder.effect(&format!("effect {}", k + 1), effect, &mut elastic, &mut laws)?);
        }
        let (mut constraints, mut cables) = (Vec::<Box<dyn Constraint>>::new(), Vec::new());
        for (k, constraint) in spec.constraints.iter().enumerate() {
            let place = format!("constraint {}", k + 1);
            match constraint {
                ConstraintSpec::Fixed { region, components } => {
                    builder.prescribe(&place, region, components, &Signal::Constant(0.0), &mut prescribed)?;
                }
                ConstraintSpec::Prescribed { region, components, displacement } => {
                    let signal = builder.signal(&place, displacement, Dimension::LENGTH)?;
                    builder.prescribe(&place, region, components, &signal, &mut prescribed)?;
                }
                ConstraintSpec::Cable { name, drive, .. } => {
                    let cable = Arc::new(builder.cable(&place, constraint)?);
                    let drive = match drive {
                        DriveSpec::Length(signal) => {
                            let shortening = builder.signal(&place, signal, Dimension::LENGTH)?;
                            let rest = cable.length(&vec![0.0; 3 * body.mesh.points.len()]);
                            constraints.push(Box::new(CableLength { cable: cable.clone(), shortening, rest }));
                            CableDrive::Multiplier(constraints.len() - 1)
                        }
                        DriveSpec::Tension(signal) => {
                            let tension = builder.signal(&place, signal, Dimension::FORCE)?;
                            effects.push(Box::new(CableTension { cable: cable.clone(), tension: tension.clone() }));
                            CableDrive::Tension(tension)
                        }
                    };
                    cables.push(NamedCable { name: name.clone(), cable, drive });
                }
            }
        }
        let Some(law) = laws.into_iter().next() else {
            return Err(builder.content("effect", "no effect is elastic", "add an [[effect]] with kind = \"elastic\""));
        };
        let nodes = body.mesh.points.len();
        let system = System::new(nodes, effects, constraints, prescribed).map_err(|e| part(file, "scene", e))?;
        let mut remarks: Vec<String> = builder
            .regions
            .iter()
            .filter(|(_, r)| r.depends_on_mesh)
            .map(|(name, _)| format!("region {name} is picked by a selector: its extent changes with the mesh (O(h))"))
            .collect();
        remarks.extend(builder.static_remarks(&spec, &spans));
        let (small, no_limit) = patches(&spec, body.mesh.h());
        remarks.extend(small);
        let probes = spec
            .probes
            .iter()
            .enumerate()
            .map(|(k, probe)| {
                Probe::new(probe, &body.mesh, &|name| builder.region(&format!("probe {}", k + 1), name).cloned())
            })
            .collect::<Result<_, _>>()?;
        Ok(Self {
            title: spec.title.clone(),
            body,
            system,
            law,
            elastic,
            cables,
            probes,
            spans,
            spec,
            text,
            remarks,
            no_limit,
        })
    }
}

/// Remark on patches smaller than h [m], and the reason why a cable through points has no limit.
fn patches(spec: &SceneSpec, h: f64) -> (Option<String>, Option<String>) {
    let radii = spec.constraints.iter().filter_map(|c| match c {
        ConstraintSpec::Cable { guide_radius, .. } => Some(*guide_radius),
        _ => None,
    });
    let (mut small, mut point) = (None, None);
    for radius in radii {
        match radius {
            GuideRadius::Point => point = Some("the cable acts through points".to_string()),
            GuideRadius::Ball(r) if r < h => {
                small = Some(format!("the guide radius {:.3} mm is below h = {:.3} mm", r * 1e3, h * 1e3));
            }
            GuideRadius::Ball(_) => {}
        }
    }
    (small, point)
}

struct Builder<'a> {
    file: &'a Path,
    base: PathBuf,
    body: Arc<Body>,
    regions: BTreeMap<String, Region>,
    laws: &'a BTreeMap<String, toml::Table>,
}

impl<'a> Builder<'a> {
    fn new(file: &'a Path, spec: &'a SceneSpec, body: Arc<Body>) -> Result<Self, SceneError> {
        let base = file.parent().unwrap_or(Path::new("")).to_path_buf();
        let mut regions = body.mesh.regions.clone();
        for (name, selector) in &spec.mesh.regions {
            let region = selector.selector().select(&body.mesh, Pick::Nodes);
            let region = region.map_err(|e| part(file, format!("mesh.regions.{name}"), e))?;
            regions.insert(name.clone(), region);
        }
        Ok(Self { file, base, body, regions, laws: &spec.laws })
    }

    fn content(&self, place: &str, fact: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::Content { file: self.file.into(), place: place.into(), fact: fact.into(), remedy: remedy.into() }
    }

    fn region(&self, place: &str, name: &str) -> Result<&Region, SceneError> {
        self.regions.get(name).ok_or_else(|| {
            let known = self.regions.keys().cloned().collect::<Vec<_>>().join(", ");
            self.content(place, format!("there is no region \"{name}\""), format!("the mesh has {known}"))
        })
    }

    fn cells(&self, place: &str, name: &str) -> Result<&[u32], SceneError> {
        let cells = &self.region(place, name)?.cells;
        if cells.is_empty() {
            let fact = format!("region \"{name}\" holds no cells");
            return Err(self.content(place, fact, "take a volume region such as \"body\""));
        }
        Ok(cells)
    }

    fn signal(&self, place: &str, spec: &super::signal::SignalSpec, d: Dimension) -> Result<Signal, SceneError> {
        spec.build(d, &self.base).map_err(|e| part(self.file, place, e))
    }

    fn law(&self, place: &str, name: &str) -> Result<Box<dyn Law>, SceneError> {
        let Some(table) = self.laws.get(name) else {
            let known = self.laws.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            let fact = format!("there is no law \"{name}\"");
            return Err(self.content(place, fact, format!("add a table [laws.{name}], or take one of: {known}")));
        };
        let place = format!("laws.{name}");
        material::law_from_table(table).map_err(|e| part(self.file, place, e))
    }

    fn effect(
        &self,
        place: &str,
        spec: &EffectSpec,
        elastic: &mut Vec<Arc<Elastic>>,
        laws: &mut Vec<Box<dyn Law>>,
    ) -> Result<Box<dyn Effect>, SceneError> {
        let mesh = &self.body.mesh;
        let mass = |region: &str, rho: f64, lumping: LumpingSpec| {
            if rho <= 0.0 {
                return Err(self.content(place, format!("the density is {rho} kg/m^3"), "give a positive one"));
            }
            Ok(Mass::new(mesh, self.cells(place, region)?, rho, lumping.into()))
        };
        Ok(match spec {
            EffectSpec::Elastic { region, law } => {
                let cells = self.cells(place, region)?;
                let effect = Arc::new(Elastic::new("elastic".into(), mesh, cells, self.law(place, law)?));
                laws.push(self.law(place, law)?);
                elastic.push(effect.clone());
                Box::new(effect)
            }
            EffectSpec::Inertia { region, density, mass: lumping } => {
                Box::new(Inertia { mass: mass(region, density.0, *lumping)? })
            }
            EffectSpec::MassDamping { region, density, mass: lumping, alpha } => {
                Box::new(MassDamping { alpha: alpha.0, mass: mass(region, density.0, *lumping)? })
            }
            EffectSpec::ViscousDamping { region, eta } => {
                if eta.0 < 0.0 {
                    return Err(self.content(place, format!("eta is {} Pa s", eta.0), "a viscosity is not negative"));
                }
                Box::new(ViscousDamping::new(mesh, self.cells(place, region)?, eta.0))
            }
            EffectSpec::Gravity { region, density, direction, acceleration } => {
                let direction = Vec3::from(*direction);
                if direction.norm() == 0.0 || !direction.norm().is_finite() {
                    return Err(self.content(place, "the direction has no length", "write for example [0, 0, -1]"));
                }
                let acceleration = self.signal(place, acceleration, Dimension::ACCELERATION)?;
                let cells = self.cells(place, region)?;
                Box::new(Gravity::new(mesh, cells, density.0, direction.normalize(), acceleration))
            }
        })
    }

    fn prescribe(
        &self,
        place: &str,
        region: &str,
        components: &str,
        signal: &Signal,
        out: &mut Vec<Prescribed>,
    ) -> Result<(), SceneError> {
        let valid = !components.is_empty() && components.chars().all(|c| "xyz".contains(c));
        if !valid {
            let fact = format!("components = \"{components}\"");
            return Err(self.content(place, fact, "write some of the letters x, y, z, for example \"yz\""));
        }
        for node in self.body.mesh.nodes_of(self.region(place, region)?) {
            for component in components.chars().map(|c| c as u32 - 'x' as u32) {
                let dof = 3 * node + component;
                // Two fixed regions may share an edge; two different motions contradict each other.
                match out.iter().find(|p| p.dof == dof) {
                    Some(p) if p.signal == *signal => {}
                    _ => out.push(Prescribed { dof, signal: signal.clone() }),
                }
            }
        }
        Ok(())
    }

    fn cable(&self, place: &str, spec: &ConstraintSpec) -> Result<Cable, SceneError> {
        let ConstraintSpec::Cable { name, path, guides, pull_point, guide_radius, .. } = spec else {
            unreachable!("called for cables only");
        };
        let vector = |p: &[Length; 3]| Vec3::new(p[0].0, p[1].0, p[2].0);
        let (points, pull) = match (path, guides, pull_point) {
            (Some(path), None, None) => {
                let Some(known) = self.body.paths.get(path) else {
                    let names = self.body.paths.keys().cloned().collect::<Vec<_>>().join(", ");
                    let fact = format!("the mesh has no path \"{path}\" (it has: {names})");
                    return Err(self.content(place, fact, "give `guides` and `pull_point` instead"));
                };
                (known.guides.iter().map(|p| Vec3::from(*p)).collect::<Vec<_>>(), Vec3::from(known.pull_point))
            }
            (None, Some(guides), Some(pull)) => (guides.iter().map(vector).collect(), vector(pull)),
            _ => {
                let fact = "a cable runs along a path";
                return Err(self.content(place, fact, "give either `path`, or both `guides` and `pull_point`"));
            }
        };
        if points.is_empty() {
            return Err(self.content(place, "the cable has no guide", "give at least one point inside the body"));
        }
        let mesh = &self.body.mesh;
        let guides = points
            .into_iter()
            .enumerate()
            .map(|(k, point)| {
                // A guide point must lie inside the body, also where a ball would still find some of it.
                let embedded =
                    embed(mesh, point).map_err(|e| part(self.file, format!("{place}: guide {}", k + 1), e))?;
                let weights = match guide_radius {
                    GuideRadius::Point => embedded.weights,
                    GuideRadius::Ball(radius) => ball_weights(mesh, point, *radius)
                        .map_err(|e| part(self.file, format!("{place}: guide {}", k + 1), e))?,
                };
                Ok(Guide { point, weights })
            })
            .collect::<Result<_, SceneError>>()?;
        Ok(Cable::new(name.clone(), pull, guides))
    }

    fn spans(&self, stages: &[StageSpec]) -> Result<Vec<Span>, SceneError> {
        let mut start = 0.0;
        let mut spans = Vec::new();
        for (k, stage) in stages.iter().enumerate() {
            let place = format!("stage {}", k + 1);
            if stage.dt.0 <= 0.0 || stage.duration.0 <= 0.0 {
                let fact = format!("dt = {} s, duration = {} s", stage.dt.0, stage.duration.0);
                return Err(self.content(&place, fact, "both must be positive"));
            }
            let integrator = match stage.integrator {
                IntegratorSpec::Static => Integrator::Static,
                IntegratorSpec::ImplicitEuler => Integrator::ImplicitEuler { linearised: false },
                IntegratorSpec::ImplicitEulerLinearised => Integrator::ImplicitEuler { linearised: true },
                IntegratorSpec::Bdf2 => Integrator::Bdf2,
                IntegratorSpec::GeneralisedAlpha { rho } if (0.0..=1.0).contains(&rho) => {
                    Integrator::GeneralisedAlpha { rho }
                }
                IntegratorSpec::GeneralisedAlpha { rho } => {
                    return Err(self.content(&place, format!("rho = {rho}"), "it lies between 0 and 1"));
                }
                IntegratorSpec::Newmark { beta, gamma, .. } => Integrator::Newmark { beta, gamma },
            };
            let end = start + stage.duration.0;
            spans.push(Span { integrator, start, end, dt: stage.dt.0.min(stage.duration.0) });
            start = end;
        }
        if spans.is_empty() {
            return Err(self.content(
                "stage",
                "the scene has no stage",
                "add a [[stage]] with integrator, duration, dt",
            ));
        }
        Ok(spans)
    }

    /// Rate effects need a dynamic stage, dynamic stages need inertia or damping, undamped rules and rows do not go together.
    fn check_rates(&self, spec: &SceneSpec, spans: &[Span]) -> Result<(), SceneError> {
        let dynamic = spans.iter().any(|s| !s.integrator.is_static());
        for (k, effect) in spec.effects.iter().enumerate().filter(|(_, e)| e.needs_rates()) {
            if !dynamic {
                let place = format!("effect {}", k + 1);
                let fact = format!("{} under the static integrator", effect.kind());
                return Err(self.content(
                    &place,
                    fact,
                    "remove the effect, or give a stage a dynamic integrator such as \"bdf2\"",
                ));
            }
        }
        let inertia = spec.effects.iter().any(|e| matches!(e, EffectSpec::Inertia { .. }));
        let length_driven =
            spec.constraints.iter().any(|c| matches!(c, ConstraintSpec::Cable { drive: DriveSpec::Length(_), .. }));
        for (k, (span, stage)) in spans.iter().zip(&spec.stages).enumerate() {
            let place = format!("stage {}", k + 1);
            let name = span.integrator.name();
            if span.integrator.needs_initial_acceleration() && !inertia {
                let fact = format!("{name} without inertia");
                return Err(self.content(&place, fact, "add an [[effect]] of kind \"inertia\", or take \"static\""));
            }
            let forced = matches!(stage.integrator, IntegratorSpec::Newmark { force: true, .. });
            if length_driven && span.integrator.rings_with_constraints() && !forced {
                return Err(self.content(
                    &place,
                    format!("{name} is undamped, and rings with a cable driven by length (Cardona & Géradin 1989)"),
                    "take \"bdf2\" or generalised_alpha with rho < 1, or set force = true in newmark",
                ));
            }
        }
        Ok(())
    }

    fn static_remarks(&self, spec: &SceneSpec, spans: &[Span]) -> Vec<String> {
        let static_stages = spans.iter().filter(|s| s.integrator.is_static()).count();
        let rates: Vec<&str> = spec.effects.iter().filter(|e| e.needs_rates()).map(EffectSpec::kind).collect();
        if static_stages == 0 || rates.is_empty() {
            return Vec::new();
        }
        vec![format!("{} rest in the {static_stages} static stage(s)", rates.join(", "))]
    }
}

impl EffectSpec {
    /// Name as in files.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Elastic { .. } => "elastic",
            Self::Inertia { .. } => "inertia",
            Self::Gravity { .. } => "gravity",
            Self::MassDamping { .. } => "mass_damping",
            Self::ViscousDamping { .. } => "viscous_damping",
        }
    }

    fn needs_rates(&self) -> bool {
        matches!(self, Self::Inertia { .. } | Self::MassDamping { .. } | Self::ViscousDamping { .. })
    }
}

impl From<LumpingSpec> for Lumping {
    fn from(spec: LumpingSpec) -> Self {
        match spec {
            LumpingSpec::Consistent => Self::Consistent,
            LumpingSpec::Lumped => Self::Lumped,
            LumpingSpec::Uniform => Self::Uniform,
        }
    }
}

impl SelectorSpec {
    fn selector(&self) -> Selector {
        let vector = |p: &[Length; 3]| Vec3::new(p[0].0, p[1].0, p[2].0);
        match self {
            Self::Box { min, max } => Selector::Box { min: vector(min), max: vector(max) },
            Self::Sphere { center, radius } => Selector::Sphere { center: vector(center), radius: radius.0 },
            Self::Plane { point, normal, tolerance } => {
                Selector::Plane { point: vector(point), normal: Vec3::from(*normal), tolerance: tolerance.0 }
            }
        }
    }
}
