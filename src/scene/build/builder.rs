//! Regions, laws, signals and prescribed motions of a scene on its mesh, and the results of the parts that are built on them. This module knows none of the
//! parts.

use super::held_rim::HeldRims;
use super::regions::{notes, regions};
use super::shape::{ShapeFault, ShapeSpec};
use super::skin::NamedSkin;
use crate::effect::contact::placement::AffineFrame;
use crate::effect::contact::shape::Shape;
use crate::effect::{CellPoints, FibreFamilies, Membrane, Mullins, Stressed, Viscoelastic, ViscousDamping};
use crate::material::{KnownLaws, Law};
use crate::math::signal::Signal;
use crate::math::tensor::{Mat3, Vec3};
use crate::math::units::Dimension;
use crate::mesh::Region;
use crate::mesh::cell_order::cell_order;
use crate::mesh::error::point;
use crate::scene::body::Body;
use crate::scene::control::SignalBuilder;
use crate::scene::control::spec::EventSpec;
use crate::scene::error::{SceneError, content, hint, part};
use crate::scene::notes::implausible::implausible_density;
use crate::scene::parts::selectors::SelectorSpec;
use crate::scene::record::recorder::Recorder;
use crate::scene::signal::SignalSpec;
use crate::scene::signal::protocol::NamedSignal;
use crate::scene::text::name::{REMEDY, is_name};
use crate::solve::{Integrator, TimeSpan};
use crate::system::{Constraint, Effect, Prescribed};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Makes a law.
pub type LawSource = Box<dyn Fn() -> Box<dyn Law>>;

/// Results of effects that later parts, the system, probes and the record need.
#[derive(Default)]
pub(in crate::scene) struct Gathered {
    /// The notes that are warnings
    pub(in crate::scene) warnings: Vec<String>,
    /// Effects with a stiffness, by their region: see [`Gathered::offer_stiffness`]
    pub(in crate::scene) stored: Vec<(String, Arc<dyn Effect>)>,
    /// Quadrature points of the cells of these effects
    pub(in crate::scene) points: Vec<Arc<CellPoints>>,
    /// Elastic effects, for their stresses
    pub(in crate::scene) stressed: Vec<Arc<dyn Stressed>>,
    /// Families of fibres, for their stresses
    pub(in crate::scene) reinforcing: Vec<Arc<FibreFamilies>>,
    /// Membranes, for their derivatives
    pub(in crate::scene) membranes: Vec<Arc<Membrane>>,
    /// Viscoelastic effects, for their derivatives
    pub(in crate::scene) relaxing: Vec<Arc<Viscoelastic>>,
    /// Viscous effects, for reduced models
    pub(in crate::scene) viscous: Vec<Arc<ViscousDamping>>,
    /// Softening effects, for their derivatives
    pub(in crate::scene) softening: Vec<Arc<Mullins>>,
    /// Group of each cell \[cells\]; the cells of a group share their pressures
    pub(in crate::scene) cell_groups: Vec<u32>,
    /// Nodes that host the second field
    pub(in crate::scene) hosts: Vec<u32>,
    /// Laws of the elastic effects, in order
    pub(in crate::scene) laws: Vec<ElasticLaw>,
    /// Cell → number of the effect that makes it relax
    pub(in crate::scene) relaxed: BTreeMap<u32, usize>,
    /// Cell → number of the effect that makes it soften
    pub(in crate::scene) softened: BTreeMap<u32, usize>,
    /// Number, kind, other keys that matter, and region of the effects that add up where they share cells
    pub(in crate::scene) additive: Vec<(usize, &'static str, String, String)>,
    /// Recorders of effects
    pub(in crate::scene) recorders: Vec<Box<dyn Recorder>>,
    /// Held rims of open cavities, for their reactions
    pub(in crate::scene) rims: HeldRims,
    /// Regions with a prescribed rotation
    pub(in crate::scene) turned: Vec<Turned>,
}

/// A region whose rotation is prescribed.
pub(in crate::scene) struct Turned {
    /// Place of the constraint in the scene, for messages
    pub(in crate::scene) place: String,
    /// Nodes, ascending
    pub(in crate::scene) nodes: Vec<u32>,
    /// Angle \[rad\]
    pub(in crate::scene) angle: Signal,
}

/// The law of an elastic effect.
pub(in crate::scene) struct ElasticLaw {
    /// Name of the table of the law
    pub(in crate::scene) name: String,
    /// Region of the effect
    pub(in crate::scene) region: String,
    pub(in crate::scene) law: Box<dyn Law>,
}

impl Gathered {
    /// Shares an effect that holds the cells of a region together: `stiffness_damping` of this region damps its tangent, and a scene with such an effect is
    /// not refused for lack of elasticity. Other effects that store energy, such as membranes and fibres, need not be shared.
    pub(in crate::scene) fn offer_stiffness(&mut self, region: &str, effect: impl Effect + 'static) -> Box<dyn Effect> {
        let shared: Arc<dyn Effect> = Arc::new(effect);
        self.stored.push((region.into(), shared.clone()));
        Box::new(shared)
    }

    /// Shares an effect with a law, with its points and stresses.
    pub(in crate::scene) fn solid(&mut self, region: &str, effect: impl Stressed + 'static) -> Box<dyn Effect> {
        let shared = Arc::new(effect);
        self.points.push(shared.points().clone());
        self.stressed.push(shared.clone());
        self.stored.push((region.into(), shared.clone()));
        Box::new(shared)
    }
}

/// Number of segments around a round body in drawings.
const ROUND: u32 = 48;

/// Builds the parts of a scene on its mesh.
pub(in crate::scene) struct Builder<'a> {
    /// Time at which building started
    pub(in crate::scene) begun: Instant,
    pub(in crate::scene) file: &'a Path,
    pub(in crate::scene) base: PathBuf,
    pub(in crate::scene) body: Arc<Body>,
    pub(in crate::scene) regions: BTreeMap<String, Region>,
    laws: &'a BTreeMap<String, toml::Table>,
    known_laws: &'a KnownLaws,
    /// Laws from Rust, by name
    own_laws: &'a BTreeMap<String, LawSource>,
    /// Dof → its motion and the part that prescribed it
    prescribed: BTreeMap<u32, (Signal, String)>,
    pub(in crate::scene) signals: Vec<NamedSignal>,
    pub(in crate::scene) signal_builder: SignalBuilder<'a>,
    /// First and last stage (start, end, whether by arc length), if signals continue beyond the protocol
    continued: Option<[(f64, f64, bool); 2]>,
    pub(in crate::scene) notes: Vec<String>,
    /// Reasons found while building why the solution has no limit as h → 0
    pub(in crate::scene) no_limits: Vec<String>,
    pub(in crate::scene) skins: Vec<NamedSkin>,
    /// Number of nodes: those of the mesh, and four for each moving obstacle
    pub(in crate::scene) nodes: usize,
    /// (dof, motion) of the nodes of obstacles
    pub(in crate::scene) carried: Vec<(u32, Signal)>,
    /// Nodes of rigid parts, with the nodes that they follow and the weights
    pub(in crate::scene) tied: BTreeMap<u32, Vec<(u32, f64)>>,
    /// Cells of the rigid parts
    pub(in crate::scene) rigid_cells: Vec<u32>,
    /// Frames of the rigid parts
    pub(in crate::scene) frames: Vec<AffineFrame>,
    /// Time spans of the stages
    pub(in crate::scene) spans: Vec<TimeSpan>,
    pub(in crate::scene) effects: Vec<Box<dyn Effect>>,
    pub(in crate::scene) constraints: Vec<Box<dyn Constraint>>,
    pub(in crate::scene) gathered: Gathered,
}

/// Tables of a scene that its parts refer to by name.
pub(in crate::scene) struct Tables<'a> {
    pub(in crate::scene) regions: &'a BTreeMap<String, SelectorSpec>,
    /// Tables of laws, with the laws that they may name
    pub(super) laws: (&'a BTreeMap<String, toml::Table>, &'a KnownLaws),
    /// Laws from Rust
    pub(super) own_laws: &'a BTreeMap<String, LawSource>,
    pub(in crate::scene) events: &'a [EventSpec],
}

impl<'a> Builder<'a> {
    /// A builder on a mesh; `carriers` is the number of bodies and obstacles that have a frame of four nodes.
    pub(in crate::scene) fn new(
        file: &'a Path,
        tables: &Tables<'a>,
        body: Arc<Body>,
        carriers: usize,
    ) -> Result<Self, SceneError> {
        let begun = Instant::now();
        let (mut regions, doubts) = regions(file, (&body.mesh, body.levels), tables.regions)?;
        let place = cell_order(&body.mesh);
        regions.values_mut().for_each(|region| region.cells.sort_unstable_by_key(|&c| place[c as usize]));
        let notes = [body.warnings.clone(), body.notes.clone(), doubts, notes(&regions, tables.regions)].concat();
        Ok(Self {
            file,
            begun,
            base: file.parent().unwrap_or(Path::new("")).to_path_buf(),
            nodes: body.mesh.points.len() + 4 * carriers,
            body,
            regions,
            laws: tables.laws.0,
            known_laws: tables.laws.1,
            own_laws: tables.own_laws,
            prescribed: BTreeMap::new(),
            signals: Vec::new(),
            signal_builder: SignalBuilder::new(tables.events),
            continued: None,
            notes,
            no_limits: Vec::new(),
            skins: Vec::new(),
            carried: Vec::new(),
            tied: BTreeMap::new(),
            rigid_cells: Vec::new(),
            frames: Vec::new(),
            spans: Vec::new(),
            effects: Vec::new(),
            constraints: Vec::new(),
            gathered: Gathered::default(),
        })
    }

    /// Whether a signal of this name is recorded.
    pub(in crate::scene) fn records(&self, name: &str) -> bool {
        self.signals.iter().any(|s| s.name == name)
    }

    /// The prescribed dofs, signals and notes gathered so far.
    pub(in crate::scene) fn finish(&mut self) -> (Vec<Prescribed>, Vec<NamedSignal>, Vec<String>) {
        let mut notes = std::mem::take(&mut self.notes);
        if self.prescribed.is_empty() {
            notes.push("nothing is held: in a static stage the body can move freely (add a `fixed` constraint)".into());
        }
        let of_body = std::mem::take(&mut self.prescribed).into_iter().map(|(dof, (signal, _))| (dof, signal));
        let prescribed =
            of_body.chain(std::mem::take(&mut self.carried)).map(|(dof, signal)| Prescribed { dof, signal }).collect();
        (prescribed, std::mem::take(&mut self.signals), notes)
    }

    pub(in crate::scene) fn content(
        &self,
        place: &str,
        fact: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SceneError {
        content(self.file, place, fact, remedy)
    }

    pub(in crate::scene) fn region(&self, place: &str, name: &str) -> Result<&Region, SceneError> {
        self.regions.get(name).ok_or_else(|| {
            let known: Vec<&String> = self.regions.keys().collect();
            self.content(place, format!("there is no region \"{name}\""), hint(name, &known))
        })
    }

    /// A region that is used for its nodes. A set of nodes may be empty even if there are cells of its name.
    pub(in crate::scene) fn region_with_nodes(&self, place: &str, name: &str) -> Result<&Region, SceneError> {
        let region = self.region(place, name)?;
        if region.is_node_set && region.nodes.is_empty() {
            let fact = format!("the node set or surface \"{name}\" of the mesh file has no node of the body");
            let remedy = "take another region; the cells of this name are a selector with pick = \"cells\"";
            return Err(self.content(place, fact, remedy));
        }
        Ok(region)
    }

    pub(in crate::scene) fn cells(&self, place: &str, name: &str) -> Result<&[u32], SceneError> {
        let cells = &self.region(place, name)?.cells;
        if cells.is_empty() {
            let fact = format!("region \"{name}\" holds no cells");
            return Err(self.content(place, fact, "take a volume region such as \"body\""));
        }
        Ok(cells)
    }

    /// A positive density, with a note if no body has a similar one.
    pub(in crate::scene) fn positive_density(&mut self, place: &str, density: f64) -> Result<f64, SceneError> {
        if density > 0.0 {
            self.notes.extend(implausible_density(place, density));
            return Ok(density);
        }
        Err(self.content(place, format!("the density is {density:.4} kg/m^3"), "give a positive one"))
    }

    pub(in crate::scene) fn law(&self, place: &str, name: &str) -> Result<Box<dyn Law>, SceneError> {
        if let Some(law) = self.own_laws.get(name) {
            return Ok(law());
        }
        let Some(table) = self.laws.get(name) else {
            let known: Vec<&String> = self.laws.keys().chain(self.own_laws.keys()).collect();
            let fact = format!("there is no table [laws.{name}]");
            return Err(self.content(place, fact, hint(name, &known)));
        };
        let place = format!("laws.{name}");
        self.known_laws.law(table).map_err(|e| part(self.file, place, e))
    }

    /// Prescribes `components` of the displacements of the nodes of a region; `motion` returns a component, by its index, of the displacement of a point, by
    /// its position at rest.
    pub(in crate::scene) fn prescribe(
        &mut self,
        place: &str,
        region: &str,
        components: &str,
        motion: impl Fn(Vec3, usize) -> Signal,
    ) -> Result<(), SceneError> {
        let valid = !components.is_empty() && components.chars().all(|c| "xyz".contains(c));
        if !valid {
            let fact = format!("components = \"{components}\"");
            return Err(self.content(place, fact, "write some of the letters x, y, z, for example \"yz\""));
        }
        for node in self.body.mesh.nodes_of(self.region_with_nodes(place, region)?) {
            let at = self.body.mesh.points[node as usize];
            for c in components.chars() {
                let component = c as u32 - 'x' as u32;
                let signal = motion(at, component as usize);
                // Two fixed regions may share an edge; two different motions contradict each other.
                let fresh = || (signal.clone(), place.to_string());
                let (known, by) = self.prescribed.entry(3 * node + component).or_insert_with(fresh);
                if *known != signal {
                    let at = point(&at);
                    let fact = format!("the {c} motion of the node at {at} is prescribed by {by} already");
                    let remedy = "take `components` or regions that do not overlap";
                    return Err(self.content(place, fact, remedy));
                }
            }
        }
        Ok(())
    }

    /// Dofs whose motion is prescribed, ascending.
    pub(in crate::scene) fn held_dofs(&self) -> impl Iterator<Item = usize> {
        self.prescribed.keys().map(|dof| *dof as usize)
    }

    /// The motion prescribed for a dof.
    pub(in crate::scene) fn motion(&self, dof: u32) -> Option<&Signal> {
        self.prescribed.get(&dof).map(|(signal, _)| signal)
    }

    /// Whether a node stays where it is.
    pub(in crate::scene) fn is_held(&self, node: u32) -> bool {
        (3 * node..3 * node + 3).all(|dof| self.motion(dof) == Some(&Signal::Constant(0.0)))
    }

    /// The part that prescribes a motion for which `is` holds, if there is one.
    pub(in crate::scene) fn moved_by(&self, is: impl Fn(&Signal) -> bool) -> Option<&str> {
        // Most nodes of a region share one signal
        let mut other: Option<&Signal> = None;
        let found = self.prescribed.values().find(|of_dof| {
            let signal = &of_dof.0;
            let found = other != Some(signal) && is(signal);
            other = (!found).then_some(signal);
            found
        });
        found.map(|(_, by)| by.as_str())
    }

    pub(in crate::scene) fn contact_facets(&self, place: &str, region: &str) -> Result<&[u32], SceneError> {
        let facets = &self.region(place, region)?.facets;
        if facets.is_empty() {
            let fact = format!("region \"{region}\" holds no facets");
            return Err(self.content(place, fact, "contact is of a part of the surface: take a facet region"));
        }
        Ok(facets)
    }

    /// A shape with the origin and axes of its frame.
    pub(in crate::scene) fn shape(&self, place: &str, spec: &ShapeSpec) -> Result<(Shape, Vec3, Mat3), SceneError> {
        spec.build(&self.base).map_err(|why| match why {
            ShapeFault::Content(fact, remedy) => self.content(place, fact, remedy),
            ShapeFault::Part(source) => part(self.file, place, source),
        })
    }

    /// Unit direction and signal of a dead load; the signal is recorded as `column`.
    pub(in crate::scene) fn dead(
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

    /// The signal of this name, which ends in its unit; it is recorded, and events can switch it by its name. Refuses a name that belongs to a different
    /// signal.
    pub(in crate::scene) fn signal(
        &mut self,
        place: &str,
        name: String,
        spec: &SignalSpec,
        d: Dimension,
    ) -> Result<Signal, SceneError> {
        let built = self.signal_builder.signal(&name, spec, d, &self.base);
        let signal = built.map_err(|(event, e)| part(self.file, event.unwrap_or_else(|| place.into()), e))?;
        let signal = self.continued(signal);
        match self.signals.iter().find(|s| s.name == name) {
            None => self.signals.push(NamedSignal { name, signal: signal.clone() }),
            // Two entries with the same motion of one region share one signal.
            Some(known) if known.signal == signal => {}
            Some(_) => {
                let fact = format!("another signal is called {name} too");
                let remedy = "keep one of the two, or give each a `name` or a region of its own";
                return Err(self.content(place, fact, remedy));
            }
        }
        Ok(signal)
    }

    /// Sets the time spans of the stages. If the first or last stage uses arc length, loads continue beyond its end of the protocol at their mean rate in that
    /// stage.
    pub(super) fn set_spans(&mut self, spans: Vec<TimeSpan>) {
        let end = |s: &TimeSpan| (s.start, s.end, matches!(s.integrator, Integrator::ArcLength { .. }));
        let ends = spans.first().map(end).zip(spans.last().map(end));
        self.continued = ends.filter(|(first, last)| first.2 || last.2).map(|(first, last)| [first, last]);
        self.spans = spans;
    }

    fn continued(&self, signal: Signal) -> Signal {
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

    /// Adds bodies and obstacles that are drawn in addition to the fields, like skins.
    pub(in crate::scene) fn draw(
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
        self.skins.push(NamedSkin { name: name.into(), surface, weights, reach: 0.0, outside: 0.0 });
        Ok(())
    }

    /// The skin of this name.
    pub(in crate::scene) fn skin(&self, place: &str, name: &str) -> Result<&NamedSkin, SceneError> {
        self.skins.iter().find(|s| s.name == name).ok_or_else(|| {
            let known: Vec<&String> = self.skins.iter().map(|s| &s.name).collect();
            self.content(place, format!("there is no skin \"{name}\""), hint(name, &known))
        })
    }

    /// Refuses a name that cannot be a part of the names of columns and files.
    pub(in crate::scene) fn check_name(&self, place: &str, name: &str) -> Result<(), SceneError> {
        if is_name(name) {
            return Ok(());
        }
        // The debug format keeps the name on one line
        let fact = format!("{name:?} cannot be part of the name of a column or a file");
        Err(self.content(place, fact, REMEDY))
    }
}
