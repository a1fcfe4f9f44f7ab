//! Regions, laws, effects, cables and prescribed motions of a scene on its mesh.

use super::build::{Body, part};
use super::control::SignalBuilder;
use super::error::{SceneError, hint};
use super::mesh_spec::{PickSpec, SelectorSpec};
use super::protocol::NamedSignal;
use super::quantity::Length;
use super::shape::{ShapeFault, ShapeSpec};
use super::signal::SignalSpec;
use super::skin::NamedSkin;
use super::spec::{LumpingSpec, SceneSpec};
use crate::effect::contact::placement::AffineFrame;
use crate::effect::contact::shape::Shape;
use crate::effect::{CellPoints, Lumping, Stressed, Viscoelastic};
use crate::material::{self, Law};
use crate::math::signal::Signal;
use crate::math::tensor::{Mat3, Vec3};
use crate::math::units::Dimension;
use crate::mesh::Region;
use crate::mesh::error::point;
use crate::mesh::select::{Pick, Selector};
use crate::solve::{Integrator, TimeSpan};
use crate::system::{Effect, Prescribed};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Makes a law.
pub type LawSource = Box<dyn Fn() -> Box<dyn Law>>;

/// Results of effects for later ones, for the system, for probes and for the record.
#[derive(Default)]
pub(super) struct Gathered {
    /// Effects that store energy, by their region
    pub(super) stored: Vec<(String, Arc<dyn Effect>)>,
    /// Quadrature points of their cells
    pub(super) points: Vec<Arc<CellPoints>>,
    /// Elastic effects, for their stresses
    pub(super) stressed: Vec<Arc<dyn Stressed>>,
    /// Viscoelastic effects, for their derivatives
    pub(super) relaxing: Vec<Arc<Viscoelastic>>,
    /// Nodes that host the second field
    pub(super) hosts: Vec<u32>,
    pub(super) laws: Vec<Box<dyn Law>>,
}

impl Gathered {
    /// Shares an effect that stores energy.
    pub(super) fn store(&mut self, region: &str, effect: impl Effect + 'static) -> Box<dyn Effect> {
        let shared: Arc<dyn Effect> = Arc::new(effect);
        self.stored.push((region.into(), shared.clone()));
        Box::new(shared)
    }

    /// Shares an effect of a law with its points and stresses.
    pub(super) fn solid(&mut self, region: &str, effect: impl Effect + Stressed + 'static) -> Box<dyn Effect> {
        let shared = Arc::new(effect);
        self.points.push(shared.points().clone());
        self.stressed.push(shared.clone());
        self.stored.push((region.into(), shared.clone()));
        Box::new(shared)
    }
}

/// Parts around a round body that is drawn.
const ROUND: u32 = 48;

/// Reads the parts of a scene against its mesh.
pub(super) struct Builder<'a> {
    pub(super) file: &'a Path,
    pub(super) base: PathBuf,
    pub(super) body: Arc<Body>,
    regions: BTreeMap<String, Region>,
    laws: &'a BTreeMap<String, toml::Table>,
    /// Laws from Rust, by name
    own_laws: &'a BTreeMap<String, LawSource>,
    /// Dof → its motion and who prescribed it
    prescribed: BTreeMap<u32, (Signal, String)>,
    pub(super) signals: Vec<NamedSignal>,
    pub(super) signal_builder: SignalBuilder<'a>,
    /// Beyond the protocol: its first and last stage, where they are continued
    pub(super) continued: Option<[(f64, f64, bool); 2]>,
    pub(super) notes: Vec<String>,
    /// Why the answer has no limit as h → 0, found while building
    pub(super) no_limits: Vec<String>,
    pub(super) skins: Vec<NamedSkin>,
    /// Nodes of the mesh, and four of each obstacle that moves
    pub(super) nodes: usize,
    /// (dof, motion) of the nodes of obstacles
    pub(super) carried: Vec<(u32, Signal)>,
}

impl<'a> Builder<'a> {
    pub(super) fn new(
        file: &'a Path,
        spec: &'a SceneSpec,
        own_laws: &'a BTreeMap<String, LawSource>,
        body: Arc<Body>,
    ) -> Result<Self, SceneError> {
        let base = file.parent().unwrap_or(Path::new("")).to_path_buf();
        let mut regions = body.mesh.regions.clone();
        let mut notes = Vec::new();
        for (name, selector) in &spec.mesh.regions {
            let place = format!("mesh.regions.{name}");
            if regions.contains_key(name) {
                let (fact, remedy) = ("the mesh has a region of this name".into(), "choose another name".into());
                return Err(SceneError::Content { file: file.into(), place, fact, remedy });
            }
            selector.check().map_err(|(fact, remedy)| SceneError::Content {
                file: file.into(),
                place: place.clone(),
                fact,
                remedy: remedy.into(),
            })?;
            let region = selector.selector().select(&body.mesh, selector.pick()).map_err(|e| part(file, &place, e))?;
            regions.insert(name.clone(), region);
            notes.push(format!("region {name} is picked by a selector: its extent changes with the mesh (O(h))"));
        }
        let (prescribed, signals) = (BTreeMap::new(), Vec::new());
        let (no_limits, skins, continued) = (Vec::new(), Vec::new(), None);
        let signal_builder = SignalBuilder::new(&spec.events);
        let laws = &spec.laws;
        let moved = spec.contacts.iter().filter(|c| c.motion.is_some()).count();
        let nodes = body.mesh.points.len() + 4 * (spec.rigids.len() + moved);
        Ok(Self {
            file,
            base,
            body,
            regions,
            laws,
            own_laws,
            prescribed,
            signals,
            signal_builder,
            notes,
            continued,
            no_limits,
            skins,
            nodes,
            carried: Vec::new(),
        })
    }

    /// Whether a signal of this name is recorded.
    pub(super) fn records(&self, name: &str) -> bool {
        self.signals.iter().any(|s| s.name == name)
    }

    /// Prescribed dofs, signals and notes that were gathered.
    pub(super) fn finish(&mut self) -> (Vec<Prescribed>, Vec<NamedSignal>, Vec<String>) {
        let mut notes = std::mem::take(&mut self.notes);
        if self.prescribed.is_empty() {
            notes.push("nothing is held: in a static stage the body can move freely (add a `fixed` constraint)".into());
        }
        let of_body = std::mem::take(&mut self.prescribed).into_iter().map(|(dof, (signal, _))| (dof, signal));
        let prescribed =
            of_body.chain(std::mem::take(&mut self.carried)).map(|(dof, signal)| Prescribed { dof, signal }).collect();
        (prescribed, std::mem::take(&mut self.signals), notes)
    }

    pub(super) fn content(&self, place: &str, fact: impl Into<String>, remedy: impl Into<String>) -> SceneError {
        SceneError::Content { file: self.file.into(), place: place.into(), fact: fact.into(), remedy: remedy.into() }
    }

    pub(super) fn region(&self, place: &str, name: &str) -> Result<&Region, SceneError> {
        self.regions.get(name).ok_or_else(|| {
            let known: Vec<&String> = self.regions.keys().collect();
            self.content(place, format!("there is no region \"{name}\""), hint(name, &known))
        })
    }

    pub(super) fn cells(&self, place: &str, name: &str) -> Result<&[u32], SceneError> {
        let cells = &self.region(place, name)?.cells;
        if cells.is_empty() {
            let fact = format!("region \"{name}\" holds no cells");
            return Err(self.content(place, fact, "take a volume region such as \"body\""));
        }
        Ok(cells)
    }

    pub(super) fn positive_density(&self, place: &str, density: f64) -> Result<f64, SceneError> {
        if density > 0.0 {
            return Ok(density);
        }
        Err(self.content(place, format!("the density is {density:.4} kg/m^3"), "give a positive one"))
    }

    pub(super) fn law(&self, place: &str, name: &str) -> Result<Box<dyn Law>, SceneError> {
        if let Some(law) = self.own_laws.get(name) {
            return Ok(law());
        }
        let Some(table) = self.laws.get(name) else {
            let known: Vec<&String> = self.laws.keys().chain(self.own_laws.keys()).collect();
            let fact = format!("there is no table [laws.{name}]");
            return Err(self.content(place, fact, hint(name, &known)));
        };
        let place = format!("laws.{name}");
        material::law_from_table(table).map_err(|e| part(self.file, place, e))
    }

    pub(super) fn prescribe(
        &mut self,
        place: &str,
        region: &str,
        components: &str,
        signal: &Signal,
    ) -> Result<(), SceneError> {
        let valid = !components.is_empty() && components.chars().all(|c| "xyz".contains(c));
        if !valid {
            let fact = format!("components = \"{components}\"");
            return Err(self.content(place, fact, "write some of the letters x, y, z, for example \"yz\""));
        }
        for node in self.body.mesh.nodes_of(self.region(place, region)?) {
            for c in components.chars() {
                let dof = 3 * node + (c as u32 - 'x' as u32);
                // Two fixed regions may share an edge; two different motions contradict each other.
                let fresh = || (signal.clone(), place.to_string());
                let (known, by) = self.prescribed.entry(dof).or_insert_with(fresh);
                if known != signal {
                    let at = point(&self.body.mesh.points[node as usize]);
                    let fact = format!("the {c} motion of the node at {at} is prescribed by {by} already");
                    let remedy = "take `components` or regions that do not overlap";
                    return Err(self.content(place, fact, remedy));
                }
            }
        }
        Ok(())
    }

    /// The motion prescribed for a dof.
    pub(super) fn motion(&self, dof: u32) -> Option<&Signal> {
        self.prescribed.get(&dof).map(|(signal, _)| signal)
    }

    pub(super) fn contact_facets(&self, place: &str, region: &str) -> Result<&[u32], SceneError> {
        let facets = &self.region(place, region)?.facets;
        if facets.is_empty() {
            let fact = format!("region \"{region}\" holds no facets");
            return Err(self.content(place, fact, "contact is of a part of the surface: take a facet region"));
        }
        Ok(facets)
    }

    /// A shape with its frame in space.
    pub(super) fn shape(&self, place: &str, spec: &ShapeSpec) -> Result<(Shape, Vec3, Mat3), SceneError> {
        spec.build(&self.base).map_err(|why| match why {
            ShapeFault::Content(fact, remedy) => self.content(place, fact, remedy),
            ShapeFault::Part(source) => part(self.file, place, source),
        })
    }

    /// Unit direction and signal of a dead load; the signal is recorded as `column`.
    pub(super) fn dead(
        &mut self,
        place: &str,
        direction: [f64; 3],
        spec: &SignalSpec,
        dimension: Dimension,
        column: String,
    ) -> Result<(Vec3, Signal), SceneError> {
        let direction = Vec3::from(direction);
        if direction.norm() == 0.0 || !direction.norm().is_finite() {
            return Err(self.content(place, "the direction has no length", "write for example [0, 0, -1]"));
        }
        if self.records(&column) {
            let fact = format!("the signal {column} is recorded already");
            return Err(self.content(place, fact, "give each load a `name` of its own"));
        }
        let signal = self.signal(place, column, spec, dimension)?;
        Ok((direction.normalize(), signal))
    }

    /// The signal of this name, with the unit at its end; it is recorded and can be switched by it.
    pub(super) fn signal(
        &mut self,
        place: &str,
        name: String,
        spec: &SignalSpec,
        d: Dimension,
    ) -> Result<Signal, SceneError> {
        let built = self.signal_builder.signal(&name, spec, d, &self.base);
        let signal = built.map_err(|(event, e)| part(self.file, event.unwrap_or_else(|| place.into()), e))?;
        let signal = self.continued(signal);
        // The same motion of one region by two entries is one signal.
        if !self.signals.iter().any(|s| s.name == name) {
            self.signals.push(NamedSignal { name, signal: signal.clone() });
        }
        Ok(signal)
    }

    /// Loads of an arc-length stage go on beyond the first and the last time of the protocol, as they do in it on average.
    pub(super) fn continue_signals(&mut self, spans: &[TimeSpan]) {
        let end = |s: &TimeSpan| (s.start, s.end, matches!(s.integrator, Integrator::ArcLength { .. }));
        let ends = spans.first().map(end).zip(spans.last().map(end));
        self.continued = ends.filter(|(first, last)| first.2 || last.2).map(|(first, last)| [first, last]);
    }

    pub(super) fn continued(&self, signal: Signal) -> Signal {
        let Some([first, last]) = self.continued.filter(|_| !signal.has_inputs()) else { return signal };
        let slope = |(start, end, arc): (f64, f64, bool)| {
            if arc { (signal.at(end) - signal.at(start)) / (end - start) } else { 0.0 }
        };
        let (before, after) = (slope(first), slope(last));
        if before == 0.0 && after == 0.0 {
            return signal;
        }
        Signal::Continued { signal: Box::new(signal), from: first.0, to: last.1, before, after }
    }

    /// Bodies and obstacles are drawn in addition to the fields, like skins.
    pub(super) fn draw(
        &mut self,
        place: &str,
        name: &str,
        shape: &Shape,
        (origin, axes): (Vec3, Mat3),
        carried: Option<&AffineFrame>,
    ) -> Result<(), SceneError> {
        let Some(mut surface) = shape.triangles(ROUND) else { return Ok(()) };
        if self.skins.iter().any(|s| s.name == name) {
            let fact = format!("another surface is called \"{name}\" too");
            return Err(self.content(place, fact, "give each skin, rigid body and contact a `name` of its own"));
        }
        surface.points.iter_mut().for_each(|p| *p = origin + axes * *p);
        let weights = |p: &Vec3| {
            let of = |frame: &AffineFrame| frame.nodes.into_iter().zip(frame.weights(p)).collect();
            carried.map_or(Vec::new(), of)
        };
        let weights = surface.points.iter().map(weights).collect();
        self.skins.push(NamedSkin { name: name.into(), surface, weights });
        Ok(())
    }

    /// Names of bodies and contacts are parts of the names of columns and files.
    pub(super) fn check_name(&self, place: &str, name: &str) -> Result<(), SceneError> {
        let fits = |c: char| c.is_alphanumeric() || "_-".contains(c);
        if !name.is_empty() && name.chars().all(fits) {
            return Ok(());
        }
        let fact = format!("\"{name}\" cannot be part of a file name");
        Err(self.content(place, fact, "use letters, digits, \"-\" and \"_\""))
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
    pub(super) fn selector(&self) -> Selector {
        let vector = |p: &[Length; 3]| Vec3::new(p[0].0, p[1].0, p[2].0);
        match self {
            Self::Box { min, max, .. } => Selector::Box { min: vector(min), max: vector(max) },
            Self::Sphere { center, radius, .. } => Selector::Sphere { center: vector(center), radius: radius.0 },
            Self::Plane { point, normal, tolerance, .. } => {
                Selector::Plane { point: vector(point), normal: Vec3::from(*normal), tolerance: tolerance.0 }
            }
            Self::Normal { direction, angle } => Selector::Normal { direction: Vec3::from(*direction), angle: angle.0 },
        }
    }

    fn pick(&self) -> Pick {
        match self {
            Self::Box { pick, .. } | Self::Sphere { pick, .. } | Self::Plane { pick, .. } => match pick {
                PickSpec::Nodes => Pick::Nodes,
                PickSpec::Facets => Pick::Facets,
                PickSpec::Cells => Pick::Cells,
            },
            Self::Normal { .. } => Pick::Facets,
        }
    }

    /// Fact and remedy of a selector that cannot select.
    fn check(&self) -> Result<(), (String, &'static str)> {
        match self {
            Self::Box { min, max, .. } if min.iter().zip(max).any(|(a, b)| a.0 > b.0) => {
                Err(("`min` is beyond `max`".into(), "give the lower corner as `min`"))
            }
            Self::Sphere { radius, .. } if radius.0 <= 0.0 => {
                Err((format!("the radius is {} mm", radius.0 * 1e3), "it must be positive"))
            }
            Self::Plane { normal, .. } if Vec3::from(*normal).norm() == 0.0 => {
                Err(("the normal has no length".into(), "write for example [1, 0, 0]"))
            }
            Self::Plane { tolerance, .. } if tolerance.0 < 0.0 => {
                Err((format!("the tolerance is {} mm", tolerance.0 * 1e3), "it must not be negative"))
            }
            _ => Ok(()),
        }
    }
}
