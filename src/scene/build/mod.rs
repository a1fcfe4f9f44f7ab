//! From a [`SceneSpec`] to a [`System`]: meshes, regions, laws, effects, constraints.

pub(super) mod additions;
pub(super) mod before_meshing;
pub(super) mod builder;
pub(super) mod cover;
pub(super) mod drive;
pub(super) mod held_planes;
pub(super) mod held_rim;
pub(super) mod open;
pub(super) mod patches;
pub(super) mod regions;
pub(super) mod rules;
pub(super) mod shape;
pub(super) mod skin;

use super::body::Body;
use super::control::{Controls, build_controls};
use super::error::{SceneError, content, hint, part};
use super::notes::first_layer::note_first_layer;
use super::notes::stable::note_stability;
use super::notes::unheld::note_free_motions;
use super::numerics::check_numerics;
use super::parts::constraints::{
    ConstraintSpec, NamedCable, NamedCavity, build_constraints, check_tied, group_cells, note_constraints, note_places,
    note_vacuum,
};
use super::parts::contact::{NamedContact, build_contacts};
use super::parts::effects::{EffectSpec, build_effects, no_limit, note_effects};
use super::parts::probes::build_probes;
use super::parts::rigid::RigidBody;
use super::parts::skin::attach_skins;
use super::read::{changed_scene, from_text, read_scene};
use super::record::compare::{MeasuredData, read_measured};
use super::record::output::check_output;
use super::record::recorded::{columns, recorders};
use super::record::recorder::Recorder;
use super::run::identity::simulated;
use super::run::start::check_start;
use super::signal::protocol::NamedSignal;
use super::spec::SceneSpec;
use super::stages::{build_spans, check_continued, check_stages};
use super::text::name::is_column;
use crate::effect::contact::placement::AffineFrame;
use crate::effect::{CellPoints, FibreFamilies, Membrane, Mullins, Stressed, Viscoelastic, ViscousDamping};
use crate::material::Law;
use crate::math::tensor::Vec3;
use crate::mesh::generate::MeshStore;
use crate::mesh::wall::Wall;
use crate::mesh::{Region, TetMesh};
use crate::solve::{Integrator, TimeSpan};
use crate::system::{Effect, System, SystemError, SystemParts, Ties};
use additions::Additions;
use builder::{Builder, LawSource, Tables};
use cover::check_cover;
use skin::NamedSkin;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

/// A scene ready to run.
pub struct Scene {
    pub title: String,
    /// The file of the scene, for messages and relative paths
    pub file: PathBuf,
    pub body: Arc<Body>,
    /// Regions of the mesh, the whole surface `skin`, and the regions of the file
    pub regions: BTreeMap<String, Region>,
    pub system: System,
    /// \[nodes\] X \[m\]: the nodes of the mesh, then four of each rigid body and of each moving obstacle
    pub points: Vec<Vec3>,
    /// Law of the first elastic effect, for the record; `None` if springs are the only elastic effects
    pub law: Option<Box<dyn Law>>,
    /// Group of each cell \[cells\], for mixed formulations; the cells of a group share their pressures
    pub(super) cell_groups: Vec<u32>,
    /// Points of the cells on which elastic effects and springs act, for probes
    pub elastic: Vec<Arc<CellPoints>>,
    /// The elastic effects, for their stresses
    pub stressed: Vec<Arc<dyn Stressed>>,
    /// The families of fibres, for their stresses
    pub reinforcing: Vec<Arc<FibreFamilies>>,
    /// The membranes, for their derivatives
    pub membranes: Vec<Arc<Membrane>>,
    /// The viscoelastic effects, for their derivatives
    pub relaxing: Vec<Arc<Viscoelastic>>,
    /// The viscous effects, for reduced models
    pub viscous: Vec<Arc<ViscousDamping>>,
    /// The softening effects, for their derivatives
    pub softening: Vec<Arc<Mullins>>,
    pub cables: Vec<NamedCable>,
    pub cavities: Vec<NamedCavity>,
    pub contacts: Vec<NamedContact>,
    pub rigids: Vec<RigidBody>,
    pub probes: Vec<Box<dyn Recorder>>,
    /// Surfaces that follow the body
    pub skins: Vec<NamedSkin>,
    pub spans: Vec<TimeSpan>,
    /// Signals prescribed over time: shortenings, tensions, displacements, accelerations
    pub signals: Vec<NamedSignal>,
    /// Decisions during the run: events and inputs
    pub controls: Controls,
    /// Measured curves and tracks to compare with
    pub measured: MeasuredData,
    pub spec: SceneSpec,
    /// The scene as it was read, with its changes
    pub text: String,
    /// Digest of everything that a run depends on apart from the mesh, with the contents of the files at the time of building
    pub(super) simulated: String,
    /// Notes on regions that depend on the mesh, effects that rest in static stages, …
    pub notes: Vec<String>,
    /// The notes that are warnings, without those of the body
    pub(super) warnings: Vec<String>,
    /// Reason why the solution has no limit as h → 0
    pub no_limit: Option<String>,
    /// Time spent on building the scene, a part of its `time_budget`
    pub(super) set_up: Duration,
    /// The thinnest wall, computed on demand
    pub(super) wall: OnceLock<Option<Wall>>,
}

/// Builds a scene from its specification, and optionally from laws, effects, recorders and a mesh of the caller.
///
/// ```
/// use durometer::prelude::*;
///
/// let text = "[mesh]\ngrid = { kind = 'box', size = ['20 mm', '10 mm', '10 mm'], divisions = [2, 1, 1] }\n\
///     [laws.rubber]\nlaw = 'neo_hookean'\nE = '100 kPa'\nnu = 0.3\n\
///     [[effect]]\nkind = 'elastic'\nregion = 'body'\nlaw = 'rubber'\n\
///     [[constraint]]\nkind = 'fixed'\nregion = 'xmin'\n\
///     [[constraint]]\nkind = 'prescribed'\nregion = 'xmax'\ncomponents = 'x'\ndisplacement = { kind = 'ramp', from = '0 mm', to = '2 mm', end = '1 s' }\n\
///     [[stage]]\nintegrator = 'static'\nduration = '1 s'\ndt = '1 s'\n\
///     [[probe]]\nkind = 'reaction'\nregion = 'xmax'";
/// let run = SceneBuilder::parse(text)?.build()?.run();
/// let force = run.column("xmax_reaction_x_N").expect("the probe records it");
/// assert!(force.last().is_some_and(|last| *last > 0.0));
/// # Ok::<(), SceneError>(())
/// ```
pub struct SceneBuilder {
    spec: SceneSpec,
    file: PathBuf,
    text: Option<String>,
    /// The text from which the specification was read; `None` if it was written in Rust
    source: Option<String>,
    body: Option<Arc<Body>>,
    /// The body that `[mesh]` names, once it has been loaded
    loaded: Option<Arc<Body>>,
    store: Option<MeshStore>,
    additions: Additions,
}

impl SceneBuilder {
    /// Starts from a specification.
    pub fn new(spec: SceneSpec) -> Self {
        let (file, additions) = (PathBuf::from("scene"), Additions::default());
        Self { spec, file, text: None, source: None, body: None, loaded: None, store: None, additions }
    }

    /// Starts from a specification that was read from a text.
    fn read(file: &Path, (spec, text): (SceneSpec, String)) -> Self {
        Self { source: Some(text.clone()), ..Self::new(spec).file(file).text(text) }
    }

    /// Starts from a scene file; paths in it are relative to the file.
    ///
    /// # Errors
    ///
    /// Where the file, or a law file that it includes, cannot be read or is not a valid scene.
    pub fn open(file: &Path) -> Result<Self, SceneError> {
        Ok(Self::read(file, read_scene(file, &[])?))
    }

    /// Starts from the text of a scene in TOML. Paths in it are relative to the current folder; laws are given in the text itself, without `include`.
    ///
    /// # Errors
    ///
    /// Where the text is not a valid scene, with the line.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let file = Path::new("scene.toml");
        Ok(Self::read(file, (from_text(file, text, "")?, text.into())))
    }

    /// Changes a value of a scene that was opened or parsed, by its path, as `--set` does on the command line. Quantities are strings with their unit. Each
    /// step of a path is a key, or the `name`, `kind` or number of an entry of a list; [`overrides`](super::text::overrides) has the rules.
    ///
    /// ```
    /// use durometer::prelude::*;
    ///
    /// let text = "[mesh]\ngrid = { kind = 'box', size = ['20 mm', '10 mm', '10 mm'], divisions = [2, 1, 1] }\n\
    ///     [laws.rubber]\nlaw = 'neo_hookean'\nE = '100 kPa'\nnu = 0.3\n\
    ///     [[effect]]\nkind = 'elastic'\nregion = 'body'\nlaw = 'rubber'\n\
    ///     [[stage]]\nintegrator = 'static'\nduration = '1 s'\ndt = '1 s'";
    /// let builder = SceneBuilder::parse(text)?.set("laws.rubber.E", "80 kPa")?.set("mesh.grid.divisions", vec![4, 2, 2])?;
    /// let scene = builder.set("stage.0.dt", "0.5 s")?.build()?;
    /// assert_eq!((scene.body.mesh.points.len(), scene.spans[0].steps()), (45, 2));
    /// # Ok::<(), SceneError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Where the path leads nowhere, or the changed scene is refused; also for a specification that was written in Rust, which the caller changes before
    /// passing it.
    pub fn set(self, path: &str, value: impl Into<toml::Value>) -> Result<Self, SceneError> {
        let Some(source) = &self.source else {
            let fact = format!("\"{path}\" is to be changed in a scene that was written in Rust");
            let remedy = "change the SceneSpec before it is given to SceneBuilder::new, or begin with open or parse";
            return Err(content(&self.file, "change", fact, remedy));
        };
        let changes = [(path.into(), value.into())];
        let (spec, text) = changed_scene(&self.file, source, &changes, &self.spec.known_laws)?;
        Ok(Self { spec, source: Some(text.clone()), text: Some(text), loaded: None, ..self })
    }

    /// Sets the file of the scene, for messages; paths in the scene are relative to it.
    pub fn file(self, file: impl Into<PathBuf>) -> Self {
        Self { file: file.into(), ..self }
    }

    /// Sets the text of the scene for the record; by default it is the specification as Rust prints it. The text does not change the scene, which is that of
    /// the specification.
    pub fn text(self, text: impl Into<String>) -> Self {
        Self { text: Some(text.into()), ..self }
    }

    /// Sets a body that replaces the one that `[mesh]` names.
    pub fn body(self, body: Arc<Body>) -> Self {
        Self { body: Some(body), ..self }
    }

    /// Sets a mesh that replaces the one that `[mesh]` names.
    pub fn mesh(self, mesh: TetMesh) -> Self {
        self.body(Arc::new(Body::of_mesh(mesh)))
    }

    /// Sets the store of bodies and of meshes that were made; by default [`MeshStore::find`] finds it.
    pub fn store(self, store: MeshStore) -> Self {
        Self { store: Some(store), ..self }
    }

    /// Adds a law that effects of the scene use by this name; `make` is called once or twice for each of them.
    pub fn law(mut self, name: impl Into<String>, make: impl Fn() -> Box<dyn Law> + 'static) -> Self {
        self.additions.laws.insert(name.into(), Box::new(make));
        self
    }

    /// Adds an effect to those of the specification.
    pub fn effect(mut self, effect: Box<dyn Effect>) -> Self {
        self.additions.effects.push(effect);
        self
    }

    /// Adds a recorder, whose columns follow those of the probes.
    pub fn recorder(mut self, recorder: Box<dyn Recorder>) -> Self {
        self.additions.recorders.push(recorder);
        self
    }

    /// The body of the scene, which is read or made at the first call: effects of the caller are built on its mesh.
    ///
    /// # Errors
    ///
    /// Where the mesh cannot be read or made.
    pub fn load(&mut self) -> Result<Arc<Body>, SceneError> {
        if let Some(body) = self.body.as_ref().or(self.loaded.as_ref()) {
            return Ok(body.clone());
        }
        let body = Body::load_from(&self.file, &self.spec.mesh, self.store.as_ref(), &mut |_| {})?;
        Ok(self.loaded.insert(Arc::new(body)).clone())
    }

    /// Builds the scene, ready to run.
    ///
    /// # Errors
    ///
    /// Where the mesh cannot be read or made, or a part of the scene does not fit the mesh or the other parts: place, fact and remedy.
    pub fn build(mut self) -> Result<Scene, SceneError> {
        let body = self.load()?;
        let Self { spec, file, text, additions, .. } = self;
        let text = text.unwrap_or_else(|| format!("{spec:#?}"));
        Scene::assemble(&file, (spec, text), body, additions, SystemParts::system)
    }
}

impl Scene {
    /// The kind of a note: `warning` if it is about a doubtful body or a part of the scene that does not fit it, otherwise `note`.
    pub fn kind_of_note(&self, note: &String) -> &'static str {
        if self.body.warnings.contains(note) || self.warnings.contains(note) { "warning" } else { "note" }
    }

    /// Builds a scene from its specification, with the mesh that it names; paths are relative to the current folder.
    ///
    /// # Errors
    ///
    /// Fails as [`SceneBuilder::build`] does.
    pub fn new(spec: SceneSpec) -> Result<Self, SceneError> {
        SceneBuilder::new(spec).build()
    }

    /// Builds a scene that was read from `file` on its mesh; paths are relative to the file. `text` is kept for the record, as by [`SceneBuilder::text`].
    ///
    /// # Errors
    ///
    /// Fails as [`SceneBuilder::build`] does.
    pub fn build(file: &Path, spec: SceneSpec, text: String, body: Arc<Body>) -> Result<Self, SceneError> {
        SceneBuilder::new(spec).file(file).text(text).body(body).build()
    }

    /// The scene of another specification with the numbering of the equations of this one, for residuals only; effects that do not `vary` are left out of its
    /// system.
    pub(super) fn variant(
        &self,
        spec: SceneSpec,
        body: Arc<Body>,
        vary: impl Fn(usize) -> bool,
    ) -> Result<Self, SceneError> {
        let number = |parts: SystemParts| parts.variant(&self.system, vary);
        let additions = Additions { is_variant: true, ..Additions::default() };
        Self::assemble(&self.file, (spec, String::new()), body, additions, number)
    }

    fn assemble(
        file: &Path,
        (spec, text): (SceneSpec, String),
        body: Arc<Body>,
        additions: Additions,
        number: impl FnOnce(SystemParts) -> Result<System, SystemError>,
    ) -> Result<Self, SceneError> {
        let simulated = identity(file, (&spec, &text), &body, &additions);
        let Additions { laws: own_laws, effects: own_effects, recorders: own_recorders, is_variant } = additions;
        let tables = tables(&spec, &own_laws);
        let (carriers, inserts) = frames(&spec);
        let mut built = Builder::new(file, &tables, body.clone(), carriers + inserts)?;
        let builder = &mut built;
        prepare(builder, &spec)?;
        build_effects(builder, &spec.effects)?;
        let (cables, cavities) = build_constraints(builder, &spec.constraints, carriers)?;
        let (rigids, mut contacts) = build_contacts(builder, &spec.rigids, &spec.contacts)?;
        check_elastic(builder, &spec.effects, own_effects.is_empty())?;
        builder.effects.extend(own_effects);
        check_tied(builder, spec.start.is_some())?;
        if !is_variant {
            note_limits(builder, &cables, &cavities, &contacts);
        }
        check_start(builder, spec.start.as_ref())?;
        note_first_layer(builder, spec.start.is_some());
        let mut probes = build_probes(builder, &spec.probes)?;
        probes.extend(builder.gathered.recorders.drain(..).chain(own_recorders));
        note_effects(builder, &spec.effects);
        let no_limit = reasons_of_no_limit(builder, &spec);
        check_stages(builder, &spec.stages)?;
        check_output(file, &builder.spans, &spec.output)?;
        let columns = columns(recorders(&probes, &cables, &cavities, &rigids, &contacts));
        let measured = read_measured(builder, &spec.comparisons, &columns)?;
        check_continued(builder, !spec.events.is_empty())?;
        let controls = build_controls(builder, &columns, &cables, &cavities)?;
        let points = points(&body.mesh, &rigids, &contacts, builder);
        let (prescribed, signals, notes) = builder.finish();
        let Builder { nodes, regions, effects, constraints, gathered, spans, skins, tied, begun, .. } = built;
        let parts =
            SystemParts { nodes, hosts: gathered.hosts, effects, constraints, prescribed, ties: Ties::new(tied) };
        let system = number(parts).map_err(|e| part(file, "scene", e))?;
        contacts.iter_mut().for_each(|c| c.history = system.elastic_slips_of(&c.name).unwrap_or_default());
        check_columns(file, &columns)?;
        Ok(Self {
            title: spec.title.clone(),
            file: file.into(),
            body,
            regions,
            system,
            points,
            law: gathered.laws.into_iter().next().map(|l| l.law),
            cell_groups: gathered.cell_groups,
            elastic: gathered.points,
            stressed: gathered.stressed,
            reinforcing: gathered.reinforcing,
            membranes: gathered.membranes,
            relaxing: gathered.relaxing,
            viscous: gathered.viscous,
            softening: gathered.softening,
            cables,
            cavities,
            contacts,
            rigids,
            probes,
            skins,
            spans,
            signals,
            controls,
            measured,
            spec,
            simulated,
            text,
            notes,
            warnings: gathered.warnings,
            no_limit,
            set_up: begun.elapsed(),
            wall: OnceLock::new(),
        })
    }

    /// The equations, the body and the recorders, in the order of their columns, of a scene that is not run itself.
    pub(super) fn into_parts(self) -> (System, Arc<Body>, Vec<Box<dyn Recorder>>) {
        fn boxed<T: Recorder + 'static>(all: Vec<T>) -> impl Iterator<Item = Box<dyn Recorder>> {
            all.into_iter().map(|r| Box::new(r) as Box<dyn Recorder>)
        }
        let Self { body, system, probes, cables, cavities, rigids, contacts, .. } = self;
        let others = boxed(cables).chain(boxed(cavities)).chain(boxed(rigids)).chain(boxed(contacts));
        (system, body, probes.into_iter().chain(others).collect())
    }

    /// Refuses a scene whose time may run backwards, where curves over time are to be compared.
    ///
    /// # Errors
    ///
    /// Where a stage follows its path by arc length: the reason and what to do, as text.
    pub fn check_time(&self) -> Result<(), String> {
        if self.spans.iter().all(|s| !matches!(s.integrator, Integrator::ArcLength { .. })) {
            return Ok(());
        }
        Err("time runs back where a path by arc length turns, and a study compares curves over time; drive by volume or \
             displacement, or use `durometer simulate`"
            .into())
    }

    /// Refuses a quantity that the scene does not record, and names the nearest one that it records.
    ///
    /// # Errors
    ///
    /// Where no column has this name: the fact and the nearest name, as text.
    pub fn check_column(&self, name: &str) -> Result<(), String> {
        let columns = self.columns();
        if columns[1..].iter().any(|c| c == name) {
            return Ok(());
        }
        Err(format!("the scene records no \"{name}\"; {}", hint(name, &columns[1..])))
    }
}

/// Sets the times and skins of a scene, checks the rules between its parts, and groups its cells by its constraints, before its effects are built.
fn prepare(builder: &mut Builder, spec: &SceneSpec) -> Result<(), SceneError> {
    let file = builder.file;
    builder.set_spans(build_spans(file, &spec.stages)?);
    check_numerics(file, &spec.numerics)?;
    rules::check(file, spec, &builder.spans)?;
    attach_skins(builder, &spec.skins)?;
    group_cells(builder, &spec.constraints);
    Ok(())
}

/// Digest of everything that a run depends on, apart from the mesh.
fn identity(file: &Path, (spec, text): (&SceneSpec, &str), body: &Body, additions: &Additions) -> String {
    let end = spec.stages.iter().map(|stage| stage.duration.0).sum();
    simulated(file, text, spec, &additions.identity(body.mesh.diagonal(), end))
}

/// Positions at rest of the nodes of the mesh and of all frames.
fn points(mesh: &TetMesh, rigids: &[RigidBody], contacts: &[NamedContact], builder: &Builder) -> Vec<Vec3> {
    let frames = rigids.iter().map(|b| &b.frame).chain(contacts.iter().filter_map(NamedContact::moving));
    let frames = frames.chain(&builder.frames).flat_map(AffineFrame::rest);
    mesh.points.iter().copied().chain(frames).collect()
}

/// Number of moving bodies and obstacles, and number of rigid inserts: each has a frame of four nodes.
fn frames(spec: &SceneSpec) -> (usize, usize) {
    let obstacles = spec.contacts.iter().filter(|c| c.motion.is_some()).count();
    let inserts = spec.constraints.iter().filter(|c| matches!(c, ConstraintSpec::Rigid(_))).count();
    (spec.rigids.len() + obstacles, inserts)
}

/// The tables of a scene that its parts refer to, with the laws from Rust.
fn tables<'a>(spec: &'a SceneSpec, own_laws: &'a BTreeMap<String, LawSource>) -> Tables<'a> {
    let laws = (&spec.laws, &spec.known_laws);
    Tables { regions: &spec.mesh.regions, laws, own_laws, events: &spec.events }
}

/// Adds notes on laws that become unstable, doubtful positions of cables, parts that no contact keeps apart, and motions of the body that nothing resists.
fn note_limits(builder: &mut Builder, cables: &[NamedCable], cavities: &[NamedCavity], contacts: &[NamedContact]) {
    note_stability(builder);
    note_places(builder, cables);
    note_vacuum(builder, cavities, contacts);
    if cables.is_empty() && contacts.is_empty() && builder.tied.is_empty() {
        note_free_motions(builder);
    }
}

/// Refuses a scene in which some cell has no resistance to deformation.
fn check_elastic(builder: &mut Builder, effects: &[EffectSpec], is_from_file: bool) -> Result<(), SceneError> {
    if !builder.gathered.stored.is_empty() {
        return check_cover(builder, effects);
    }
    if is_from_file {
        let remedy = "add an [[effect]] with kind = \"elastic\", or \"edge_springs\"";
        return Err(builder.content("effect", "no effect is elastic", remedy));
    }
    Ok(())
}

/// Reasons why the response has no limit as h → 0, joined into one text.
fn reasons_of_no_limit(builder: &mut Builder, spec: &SceneSpec) -> Option<String> {
    let causes = [note_constraints(builder, &spec.constraints), no_limit(&spec.effects)];
    let causes: Vec<String> = causes.into_iter().flatten().chain(std::mem::take(&mut builder.no_limits)).collect();
    (!causes.is_empty()).then(|| causes.join(", "))
}

/// Refuses a column that would be recorded twice, or whose name, which begins with that of a region, is not valid.
fn check_columns(file: &Path, columns: &[String]) -> Result<(), SceneError> {
    let refuse = |fact: String, remedy: &str| {
        Err(SceneError::Content { file: file.into(), place: "probe".into(), fact, remedy: remedy.into() })
    };
    if let Some(wrong) = columns.iter().find(|c| !is_column(c)) {
        return refuse(format!("{wrong:?} cannot be the name of a column"), "give the region another name");
    }
    match columns.iter().enumerate().find(|(k, c)| columns[..*k].contains(c)) {
        None => Ok(()),
        Some((_, twice)) => {
            refuse(format!("the column {twice} would be recorded twice"), "remove one of the two [[probe]]s")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCENE: &str = "[mesh]\ngrid = { kind = 'box', size = ['20 mm', '10 mm', '10 mm'], divisions = [2, 1, 1] }\n\
        [laws.rubber]\nlaw = 'neo_hookean'\nE = '100 kPa'\nnu = 0.3\n[[effect]]\nkind = 'elastic'\nregion = 'body'\nlaw = 'rubber'\n\
        [[stage]]\nintegrator = 'static'\nduration = '1 s'\ndt = '1 s'\n";

    /// A changed value takes effect in the specification, in the text of the record and in the mesh, also in a mesh that was loaded before; the identity is
    /// that of a text with the value.
    #[test]
    fn a_changed_value_is_that_of_the_text() {
        let mut builder = SceneBuilder::parse(SCENE).expect("a scene");
        assert_eq!(builder.load().expect("a grid").mesh.points.len(), 12);
        let builder = builder.set("mesh.grid.divisions", vec![4, 2, 2]).and_then(|b| b.set("laws.rubber.E", "80 kPa"));
        let changed = builder.and_then(SceneBuilder::build).expect("a scene");
        let text = SCENE.replace("[2, 1, 1]", "[4, 2, 2]").replace("100 kPa", "80 kPa");
        let written = SceneBuilder::parse(&text).and_then(SceneBuilder::build).expect("a scene");
        assert_eq!(changed.body.mesh.points, written.body.mesh.points);
        assert_eq!(changed.simulated, written.simulated);
        assert!(changed.text.contains("80 kPa"), "{}", changed.text);
        assert_ne!(changed.simulated, SceneBuilder::parse(SCENE).and_then(SceneBuilder::build).expect("one").simulated);
    }

    #[test]
    fn a_change_that_leads_nowhere_is_refused() {
        let refused = |builder: SceneBuilder, path: &str| builder.set(path, 1).err().expect("refused").to_string();
        let parsed = || SceneBuilder::parse(SCENE).expect("a scene");
        assert!(refused(parsed(), "laws.ruber.nu").contains("did you mean `rubber`?"));
        assert!(refused(parsed(), "laws.rubber").contains("with the changes laws.rubber"));
        let in_rust = refused(SceneBuilder::new(SceneSpec::default()), "mesh.cells");
        assert!(in_rust.contains("change the SceneSpec before it is given to SceneBuilder::new"), "{in_rust}");
    }
}
