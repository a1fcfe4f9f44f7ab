//! The scene of a run on an enriched mesh.

use super::EstimateError;
use super::kept_state::{Kept, Solved};
use crate::effect::PressureHosts;
use crate::math::pcg::{Outcome, pcg};
use crate::math::vector::norm;
use crate::mesh::enrich::Enriched;
use crate::mesh::interface::{Interface, interfaces};
use crate::mesh::smooth_surface::{Smoothed, are_smooth, on_smooth_surface};
use crate::mesh::{Order, Region, TetMesh};
use crate::scene::body::Body;
use crate::scene::body::source_volume::SourceVolume;
use crate::scene::build::SceneBuilder;
use crate::scene::build::regions::regions;
use crate::scene::spec::{ConstraintSpec, EffectSpec, ElementSpec};
use crate::scene::{Energies, Run, RunOptions, Scene, SceneSpec};
use crate::solve::{Integrator, NonlinearSolver, Status, Step, TimeSpan};
use crate::system::{State, Want};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The method by which the space of a run is enriched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enrichment {
    /// Splits each cell into eight of the same order
    Split,
    /// Raises linear cells to quadratic ones
    Raise,
}

/// Lowest order in h with which quantities converge at singular edges: usually, and for reactions next to such an edge.
const LEAST_ORDERS: [f64; 2] = [1.0, 0.75];
/// Lowest order of any quantity if a held face ends at a re-entrant edge.
const LEAST_ORDER_AT_GLUED_EDGE: f64 = 0.5;
/// Largest share of the error of linear cells that remains with quadratic cells on the same mesh: usually, and for reactions next to a singular edge.
const SHARES_LEFT: [f64; 2] = [1.0 / 3.0, 0.5];
/// Largest number of times that the steps of an enriched run that may have jumped to another branch are halved.
const MOST_HALVINGS: usize = 2;
/// Largest number of iterations of an enriched run for each one of the run.
const MOST_ITERATIONS: usize = 10;
/// Number of iterations times n², to which the work of a factorisation with n unknowns grows, that an enriched run may take in any case: some ten seconds.
const FREE_WORK: f64 = 2e10;
/// Relative residual of the pressures that remains where the run has no pressures, and the largest number of matrix products to reach it.
const RELAXED: f64 = 1e-8;
const MOST_PRODUCTS: usize = 500;

impl Enrichment {
    /// The enrichment that is best for error estimates with cells of this order.
    pub fn usual(order: Order) -> Self {
        match order {
            Order::Linear => Self::Raise,
            Order::Quadratic => Self::Split,
        }
    }

    /// The factor from the change of a quantity to its error: smallest, likely, largest. The likely one is the middle of the usual bounds. `glued`: whether a
    /// held face of the body ends at a re-entrant edge.
    pub fn factors(self, order: Order, glued: bool) -> [f64; 3] {
        let formal = match order {
            Order::Linear => 2.0,
            Order::Quadratic => 4.0,
        };
        let split = |q: f64| 1.0 / (1.0 - (-q).exp2());
        let [usual, [least, most]] = match self {
            Self::Split => LEAST_ORDERS.map(|order| [split(formal), split(order)]),
            Self::Raise => SHARES_LEFT.map(|share| [1.0 / (1.0 + share), 1.0 / (1.0 - share)]),
        };
        let most = if glued && self == Self::Split { split(LEAST_ORDER_AT_GLUED_EDGE) } else { most };
        [least, 0.5 * (usual[0] + usual[1]), most]
    }

    /// Factor by which the enriched space shortens the contact lengths that follow from the cell size. The error due to them is of first order in them: its
    /// factor, 1/(1 − share), is within all bounds of [`Enrichment::factors`].
    fn share_of_contact_lengths(self) -> f64 {
        match self {
            Self::Split => 0.5,
            Self::Raise => 0.25,
        }
    }
}

/// The scene with explicit shorter contact lengths where these follow from the cell size, because raised cells keep their size.
fn with_shorter_contacts(scene: &Scene, enrichment: Enrichment) -> SceneSpec {
    let mut spec = scene.spec.clone();
    let share = enrichment.share_of_contact_lengths();
    for (contact, built) in spec.contacts.iter_mut().zip(&scene.contacts) {
        contact.distance.get_or_insert((share * built.scales.distance).into());
        contact.slip.get_or_insert((share * built.scales.friction.slip).into());
    }
    spec
}

/// The scene with quadratic cells; if `mixed`, also with a pressure field where the effect can have one: displacements alone may still lock.
fn raised(spec: &SceneSpec, mixed: bool) -> SceneSpec {
    let mut spec = spec.clone();
    spec.mesh.element = ElementSpec::Tet10;
    for effect in spec.effects.iter_mut().filter(|_| mixed) {
        if let EffectSpec::Elastic(elastic) = effect {
            elastic.take_pressure_field();
        }
    }
    spec
}

/// Number of negative eigenvalues of the tangent at the static state of a run at time `t` \[s\].
fn unstable_modes(run: &Run, t: f64) -> usize {
    let until = run.findings.unstable.iter().take_while(|(from, _)| *from <= t * (1.0 + 1e-9));
    until.last().map_or(0, |(_, modes)| *modes)
}

/// Refuses an enriched run that has an unstable static state up to time `t` \[s\] where the run has none.
pub(super) fn check_branch(enriched: &Run, of_run: &Run, t: f64) -> Result<(), EstimateError> {
    if unstable_modes(enriched, t) > unstable_modes(of_run, t) { Err(EstimateError::Unstable { t }) } else { Ok(()) }
}

/// Whether steps of a run were repeated on a path with indefinite tangents, so that it may have jumped to another branch.
fn was_forced(run: &Run) -> bool {
    run.shifted_factorisations > 0 && run.tried_iterations > run.totals.iterations
}

/// Whether shorter steps are needed to decide the branch of an enriched run up to time `t` \[s\], because it may have jumped. `has_jumped`: whether it may
/// have jumped in longer steps.
///
/// # Errors
///
/// Where the branch is not decided: it is unstable, or with these steps the run ends before time `t`.
fn asks_for_shorter_steps(enriched: &Run, of_run: &Run, has_jumped: bool, t: f64) -> Result<bool, EstimateError> {
    match enriched.status {
        Status::Converged if was_forced(enriched) && !was_forced(of_run) => Ok(true),
        Status::Converged => check_branch(enriched, of_run, t).map(|()| false),
        Status::NoEquilibrium { .. } | Status::StepTooSmall { .. } if has_jumped => Err(EstimateError::Unstable { t }),
        _ => Ok(false),
    }
}

/// Removes from regions given as nodes every new node between two of their nodes that their selector does not find too: on an edge from face to face of a
/// frame it does not, on one inside a box it does.
fn leave_out_nodes_beyond(scene: &Scene, map: &mut Enriched) {
    let specs = &scene.spec.mesh.regions;
    if specs.is_empty() {
        return;
    }
    let mut mesh = map.mesh.clone();
    mesh.regions.retain(|name, _| scene.body.mesh.regions.contains_key(name));
    let Ok((found, _)) = regions(&scene.file, (&mesh, scene.body.levels), specs) else { return };
    for name in specs.keys() {
        let (Some(own), Some(found)) = (scene.regions.get(name), found.get(name)) else { continue };
        let mut nodes = map.with_nodes_between(&own.nodes);
        nodes.retain(|node| own.nodes.binary_search(node).is_ok() || found.nodes.binary_search(node).is_ok());
        if let Some(region) = map.mesh.regions.get_mut(name) {
            region.nodes = nodes;
        }
    }
}

/// The facets between solids. Cell faces along the border of a region picked by position are not a surface of the body: if the interfaces have creases,
/// regions whose border cuts through cells are left out.
fn between_solids(scene: &Scene, mesh: &mut TetMesh) -> Vec<Interface> {
    let facets = mesh.facets.len();
    let all = interfaces(mesh, &solids(scene, |_| true));
    if are_smooth(mesh, &all) {
        return all;
    }
    mesh.facets.truncate(facets);
    interfaces(mesh, &solids(scene, |region| !region.depends_on_mesh))
}

/// The solid of each cell \[cells\]: the cells of a solid have the same laws and are held by the same rigid inserts. Only laws and inserts on regions for
/// which `counts` holds are considered.
fn solids(scene: &Scene, counts: impl Fn(&Region) -> bool) -> Vec<u32> {
    let mut regions: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for effect in &scene.spec.effects {
        if let Some((region, _)) = effect.resists() {
            regions.entry(effect.law().unwrap_or("springs")).or_default().push(region);
        }
    }
    for constraint in &scene.spec.constraints {
        if let ConstraintSpec::Rigid(rigid) = constraint {
            regions.entry("rigid").or_default().push(&rigid.region);
        }
    }
    let mut solids = vec![0; scene.body.mesh.cell_count()];
    for names in regions.values() {
        let own: Vec<&Region> = names.iter().filter_map(|name| scene.regions.get(*name)).collect();
        if !own.iter().all(|region| counts(region)) {
            continue;
        }
        let mut inside = vec![false; solids.len()];
        own.iter().flat_map(|region| &region.cells).for_each(|&c| inside[c as usize] = true);
        let mut numbers = HashMap::new();
        for (solid, is_inside) in solids.iter_mut().zip(inside) {
            let next = numbers.len() as u32;
            *solid = *numbers.entry((*solid, is_inside)).or_insert(next);
        }
    }
    solids
}

/// The nodes that host the pressures of a mixed effect in a region of a scene.
fn hosts(scene: &Scene, region: &str) -> PressureHosts {
    PressureHosts::new(&scene.body.mesh, &scene.regions[region].cells, &scene.cell_groups)
}

fn is_mixed(effect: &EffectSpec) -> bool {
    matches!(effect, EffectSpec::Elastic(elastic) if elastic.formulation.is_mixed())
}

/// The enriched mesh of a run on the smooth surface through its boundary nodes.
pub(super) enum SmoothSurface {
    /// The mesh has no curved boundary.
    Flat,
    /// Cells would fold on the surface.
    Folded,
    /// The surface is not that of the CAD, as the volumes of these solids show.
    Missed(Vec<SourceVolume>),
    /// The mesh, and the share of the distance to the surface by which its nodes were moved
    Curved(Box<Enriched>, f64),
}

/// The scene on the enriched mesh, and the map of states of the run to it.
pub(super) struct EnrichedScene {
    pub scene: Scene,
    enrichment: Enrichment,
    map: Enriched,
    /// The mesh of the run with facets between its solids, and these interfaces
    whole: Arc<(TetMesh, Vec<Interface>)>,
    /// Whether each effect has pressures in the run \[effects\]
    mixed_in_run: Vec<bool>,
    /// Flag that stops its solutions
    pub stop: Option<Arc<AtomicBool>>,
}

impl EnrichedScene {
    /// Builds a scene in its enriched space.
    ///
    /// # Errors
    ///
    /// Where a part of the scene cannot be built on the enriched mesh, or is refused there.
    pub fn new(scene: &Scene, enrichment: Enrichment) -> Result<Self, EstimateError> {
        // The regions of the run itself: picked again by position they would be different on smaller cells
        let mut own = TetMesh { regions: scene.regions.clone(), ..scene.body.mesh.clone() };
        let between = between_solids(scene, &mut own);
        let mut map = match enrichment {
            Enrichment::Split => Enriched::by_splitting(&own),
            Enrichment::Raise => Enriched::by_raising(&own),
        };
        leave_out_nodes_beyond(scene, &mut map);
        Self::on(scene, enrichment, map, Arc::new((own, between)))
    }

    /// The enriched mesh with its new nodes on the boundary and between solids moved to the smooth surfaces through those of the run.
    pub fn smooth_surface(&self, scene: &Scene) -> SmoothSurface {
        let (mesh, interfaces) = &*self.whole;
        let found = on_smooth_surface(mesh, interfaces, &self.map);
        let missed = self.missed_volumes(scene, &found);
        if !missed.is_empty() {
            return SmoothSurface::Missed(missed);
        }
        match found {
            Smoothed::Flat => SmoothSurface::Flat,
            Smoothed::Folded => SmoothSurface::Folded,
            Smoothed::Moved(map, part) => SmoothSurface::Curved(map, part),
        }
    }

    /// The enriched scene on another enriched mesh of the run; `None` if a part of the scene cannot be built there.
    pub fn with_map(&self, scene: &Scene, map: Enriched) -> Option<Self> {
        let other = Self::on(scene, self.enrichment, map, self.whole.clone()).ok()?;
        Some(Self { stop: self.stop.clone(), ..other })
    }

    /// Volumes of the CAD that the mesh of the run misses on the smooth surface as well.
    fn missed_volumes(&self, scene: &Scene, found: &Smoothed) -> Vec<SourceVolume> {
        let of = |mesh: &TetMesh, volume: &SourceVolume| match &volume.region {
            None => Some(mesh.volume()),
            Some(name) => mesh.regions.get(name).map(|region| mesh.volume_of(region)),
        };
        let gain = |volume: &SourceVolume| -> Option<f64> {
            let Smoothed::Moved(moved, part) = found else { return None };
            Some((of(&moved.mesh, volume)? / of(&self.map.mesh, volume)? - 1.0) / part)
        };
        let is_missed = |volume: &&SourceVolume| volume.is_missed(gain(volume).unwrap_or(0.0));
        scene.body.volumes.iter().filter(is_missed).cloned().collect()
    }

    /// The enriched scene with wider regions, which hold all nodes of the cells that have a node in them; `None` if it cannot be built.
    pub fn with_wider_regions(&self, scene: &Scene, names: &[String]) -> Option<Self> {
        let mut map = self.map.clone();
        for name in names {
            let nodes = &self.map.mesh.regions.get(name)?.nodes;
            let cells = self.map.mesh.cells.chunks_exact(self.map.mesh.order.cell_nodes());
            let reached = cells.filter(|cell| cell.iter().any(|node| nodes.binary_search(node).is_ok()));
            let mut wider: Vec<u32> = reached.flatten().copied().collect();
            wider.sort_unstable();
            wider.dedup();
            map.mesh.regions.get_mut(name)?.nodes = wider;
        }
        self.with_map(scene, map)
    }

    fn on(
        scene: &Scene,
        enrichment: Enrichment,
        map: Enriched,
        whole: Arc<(TetMesh, Vec<Interface>)>,
    ) -> Result<Self, EstimateError> {
        let Body { paths, source, sha256, notes, warnings, .. } = &*scene.body;
        let body = Body {
            paths: paths.clone(),
            notes: notes.clone(),
            warnings: warnings.clone(),
            ..Body::new(map.mesh.clone(), source.clone(), sha256.clone())
        };
        let body = Arc::new(body);
        let build = |mut spec: SceneSpec| {
            spec.mesh.regions.clear();
            SceneBuilder::new(spec).file(&scene.file).body(body.clone()).build()
        };
        let spec = with_shorter_contacts(scene, enrichment);
        let fine = match enrichment {
            Enrichment::Split => build(spec)?,
            Enrichment::Raise => build(raised(&spec, true)).or_else(|_| build(raised(&spec, false)))?,
        };
        let same = [
            ("effects", fine.system.effects.len() == scene.system.effects.len()),
            ("constraints", fine.system.constraints.len() == scene.system.constraints.len()),
            ("columns", fine.columns() == scene.columns()),
        ];
        match same.iter().find(|(_, same)| !same) {
            Some((what, _)) => Err(EstimateError::Additions { why: format!("its {what} differ") }),
            None => Ok(Self {
                enrichment,
                scene: fine,
                map,
                whole,
                mixed_in_run: scene.spec.effects.iter().map(is_mixed).collect(),
                stop: None,
            }),
        }
    }

    /// The state of another space on the same cells, transferred to this one. Constraints that hold more or fewer cells group them differently: each pressure
    /// is taken from the other space at the same corner of a cell.
    pub fn taken(&self, other: &Self, state: &State) -> State {
        let mut first = 3 * self.scene.points.len();
        let mut x = state.x[..first].to_vec();
        for ((own, _), (known, _)) in self.pressures_by_effect().zip(other.pressures_by_effect()) {
            let mut pressures = vec![0.0; own.places.len()];
            for (to, from) in own.of_cells.iter().flatten().zip(known.of_cells.iter().flatten()) {
                pressures[*to as usize] = state.x[first + *from as usize];
            }
            x.extend(pressures);
            first += known.places.len();
        }
        // The multipliers of contact follow
        x.extend_from_slice(&state.x[first..]);
        State { x, ..state.clone() }
    }

    /// The columns at a state of the enriched space as before the first step, without reactions.
    pub fn row_at(&self, state: &State, memory: &[f64]) -> Vec<f64> {
        let mut memory = memory.to_vec();
        self.scene.remember(state, &mut memory);
        self.scene.record(state, None, &vec![0.0; state.x.len()], Energies::default(), 0, &memory)
    }

    /// The columns at the equilibrium that Newton's method finds from a state of the enriched space, possibly on another surface; `None` if it finds none.
    /// Adds to the number of factorisations.
    pub fn columns_from(&self, start: &State, memory: &[f64], factorisations: &mut usize) -> Option<Vec<f64>> {
        let scene = &self.scene;
        let mut start = start.clone();
        self.prescribe(&mut start);
        let step = Step { system: &scene.system, integrator: Integrator::Static, past: &start, dt: 1.0 };
        let mut next = start.clone();
        let mut solver = self.solver();
        let found = solver.solve(&step, &mut next);
        *factorisations += solver.linear.factor.count;
        found.ok()?;
        let mut memory = memory.to_vec();
        scene.remember(&next, &mut memory);
        let residual = &solver.equations.sums.r;
        Some(scene.record(&next, Some(&step.at(&next)), residual, Energies::default(), 0, &memory))
    }

    /// The solver of its equations.
    pub fn solver(&self) -> NonlinearSolver {
        let mut solver = self.scene.driver().steps.solver;
        solver.equations.limit.stop.clone_from(&self.stop);
        solver
    }

    /// Runs the whole protocol.
    ///
    /// # Errors
    ///
    /// Where the enriched mesh has no solution, or the estimate was stopped.
    pub fn run(&self, of_run: &Run) -> Result<Run, EstimateError> {
        let run = self.scene.run_with(self.options(of_run, 0));
        let t = run.rows.last().map_or(0.0, |row| row[0]);
        if run.status == Status::Converged { Ok(run) } else { Err(self.without_solution(of_run, &run, t)) }
    }

    /// Largest number of iterations, failed ones included, in which the protocol of a run is solved in the enriched space: where there is no equilibrium, steps
    /// are cut again and again.
    fn most_iterations(&self, of_run: &Run) -> usize {
        let unknowns = self.scene.system.dofs.free.len().max(1) as f64;
        (MOST_ITERATIONS * of_run.tried_iterations).max((FREE_WORK / (unknowns * unknowns)) as usize)
    }

    /// The options of an enriched run, of which `earlier` iterations are over.
    fn options<'a>(&self, of_run: &Run, earlier: usize) -> RunOptions<'a> {
        RunOptions {
            stop: self.stop.clone(),
            most_iterations: Some(self.most_iterations(of_run).saturating_sub(earlier)),
            ..RunOptions::default()
        }
    }

    /// The reason why an enriched run has no solution at time `t` \[s\].
    fn without_solution(&self, of_run: &Run, enriched: &Run, t: f64) -> EstimateError {
        let is_stopped = self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed));
        match enriched.status {
            Status::Interrupted { .. } if !is_stopped => {
                EstimateError::TooLong { t, iterations: self.most_iterations(of_run), of_run: of_run.tried_iterations }
            }
            _ => EstimateError::NotSolved { t, status: enriched.status.name() },
        }
    }

    /// The solution at the time of `start`, found by running the protocol from its beginning, on the branch to which the loads lead. If the run may have
    /// jumped to another branch, its steps are halved.
    ///
    /// # Errors
    ///
    /// Where the enriched mesh has no solution, or one on an undecided branch.
    pub fn run_until(&mut self, of_run: &Run, start: State) -> Result<Solved, EstimateError> {
        let t = start.t;
        let mut spans = self.scene.spans.clone();
        spans.retain(|span| span.start < t);
        spans.iter_mut().for_each(|span| span.end = span.end.min(t));
        let (mut factorisations, mut iterations) = (0, 0);
        for halvings in 0..=MOST_HALVINGS {
            let (run, end) = self.run_in(spans.clone(), of_run, iterations);
            factorisations += run.factorisations;
            iterations += run.tried_iterations;
            if asks_for_shorter_steps(&run, of_run, halvings > 0, t)? {
                spans.iter_mut().for_each(|span| span.dt *= 0.5);
                continue;
            }
            if run.status != Status::Converged {
                return Err(self.without_solution(of_run, &run, t));
            }
            let (values, memory) = run.rows.into_iter().zip(run.memories).next_back().expect("a run has a first row");
            return Ok(Solved { start, end: end.expect("a run has a first state"), values, memory, factorisations });
        }
        Err(EstimateError::Unstable { t })
    }

    /// The run with these stages, of which `earlier` iterations are over, and its last state.
    fn run_in(&mut self, spans: Vec<TimeSpan>, of_run: &Run, earlier: usize) -> (Run, Option<State>) {
        let whole = std::mem::replace(&mut self.scene.spans, spans);
        let mut end = None;
        let mut keep = |state: &State| end = Some(state.clone());
        let run = self.scene.run_with(RunOptions { on_state: Some(&mut keep), ..self.options(of_run, earlier) });
        self.scene.spans = whole;
        (run, end)
    }

    /// A state of the run in the enriched space: the same displacements and pressures as functions, with the prescribed values of the enriched mesh.
    pub fn prolong(&self, from: &Scene, kept: &Kept) -> State {
        let mut state = self.interpolate(from, kept);
        self.prescribe(&mut state);
        if self.pressures_by_effect().any(|(_, in_run)| !in_run) {
            self.relax_pressures(&mut state);
        }
        state
    }

    /// The displacements and pressures of a state as functions in the enriched space, without prescribed values: a static run has none before its first step.
    pub fn interpolate(&self, from: &Scene, kept: &Kept) -> State {
        let Self { scene, map, .. } = self;
        let displacements = 3 * from.points.len();
        let of_mesh = 3 * from.body.mesh.points.len();
        let mut x = map.prolong(3, &kept.x[..of_mesh]);
        x.extend_from_slice(&kept.x[of_mesh..displacements]);
        x.extend(self.pressures(from, &kept.x[displacements..]));
        let rest = scene.system.rest();
        // The multipliers of contact, at points that differ from those of the run, start from zero
        x.resize(rest.x.len(), 0.0);
        let (lambda, inputs) = (kept.lambda.clone(), kept.inputs.clone());
        State { t: kept.t, x, lambda, inputs, ..rest }
    }

    fn prescribe(&self, state: &mut State) {
        for p in &self.scene.system.prescribed {
            state.x[p.dof as usize] = p.signal.at(state.clock());
        }
    }

    /// The scene, if its cells are the raised cells of the run: the corners of both have the same numbers.
    pub fn raised(&self) -> Option<&Scene> {
        (self.enrichment == Enrichment::Raise).then_some(&self.scene)
    }

    /// Cell of the run of which each cell is a part \[cells of the enriched mesh\]
    pub fn parents(&self) -> &[u32] {
        &self.map.parents
    }

    /// The hosts of the pressures of each mixed effect, in the order of the unknowns, and whether the effect is mixed in the run too.
    fn pressures_by_effect(&self) -> impl Iterator<Item = (PressureHosts, bool)> {
        let hosts = |(effect, of_run): (&EffectSpec, &bool)| match effect {
            EffectSpec::Elastic(elastic) if elastic.formulation.is_mixed() => {
                Some((hosts(&self.scene, &elastic.region), *of_run))
            }
            _ => None,
        };
        self.scene.spec.effects.iter().zip(&self.mixed_in_run).filter_map(hosts)
    }

    /// The nodes that host the pressures, in the order of the unknowns.
    pub fn pressure_nodes(&self) -> impl Iterator<Item = u32> {
        self.pressures_by_effect().flat_map(|(hosts, _)| hosts.nodes().collect::<Vec<_>>())
    }

    /// Calls `each` with every entry of P, the map of the unknowns of the run into the enriched space: (enriched unknown, enriched unknown at the same node of
    /// the run, weight).
    pub fn for_each_weight(&self, mut each: impl FnMut(usize, usize, f64)) {
        for (node, weights) in self.map.weights.iter().enumerate() {
            for (of_run, weight) in weights {
                (0..3).for_each(|d| each(3 * node + d, 3 * *of_run as usize + d, *weight));
            }
        }
        let mut first = 3 * self.scene.points.len();
        for (hosts, in_run) in self.pressures_by_effect() {
            for (k, (group, node)) in hosts.places.iter().enumerate().filter(|_| in_run) {
                for (of_run, weight) in &self.map.corner_weights[node] {
                    // A group that the run does not have may have no pressure there
                    if let Some(at) = hosts.number(*group, *of_run) {
                        each(first + k, first + at, *weight);
                    }
                }
            }
            first += hosts.places.len();
        }
    }

    /// Solves the equations of the pressures at fixed displacements, which are linear: −K_pp is a mass matrix divided by the bulk modulus.
    fn relax_pressures(&self, state: &mut State) {
        let system = &self.scene.system;
        let step = Step { system, integrator: Integrator::Static, past: &state.clone(), dt: 1.0 };
        let mut sums = system.workspace();
        if system.assemble(&step.at(state), &state.lambda, Want::Tangent, None, &mut sums).is_err() {
            return;
        }
        let first = system.dofs.displacements;
        // Without the multipliers of contact, which come after them
        let pressures = first..first + self.pressure_nodes().count() as u32;
        let of: Vec<usize> =
            (0..system.dofs.free.len()).filter(|&k| pressures.contains(&system.dofs.free[k])).collect();
        let multiply = |p: &[f64]| {
            let (mut whole, mut product) = (vec![0.0; system.dofs.free.len()], vec![0.0; system.dofs.free.len()]);
            of.iter().zip(p).for_each(|(&k, p)| whole[k] = -p);
            sums.pattern.multiply(&sums.k, &whole, &mut product);
            of.iter().map(|&k| product[k]).collect::<Vec<f64>>()
        };
        let left: Vec<f64> = of.iter().map(|&k| sums.r[system.dofs.free[k] as usize]).collect();
        let bound = RELAXED * norm(&left);
        if let (Outcome::Solved(change), _) = pcg(multiply, <[f64]>::to_vec, &left, bound, MOST_PRODUCTS) {
            of.iter().zip(change).for_each(|(&k, p)| state.x[system.dofs.free[k] as usize] += p);
        }
    }

    /// Pressures of the mixed effects, which are linear between corners; zero where the run has none. The unknown is p ℓ/μ with the mean cell size ℓ.
    fn pressures(&self, from: &Scene, values: &[f64]) -> Vec<f64> {
        let scale = self.scene.body.mesh.h() / from.body.mesh.h();
        let (mut out, mut first) = (Vec::new(), 0);
        for (before, now) in from.spec.effects.iter().zip(&self.scene.spec.effects) {
            let (EffectSpec::Elastic(before), EffectSpec::Elastic(now)) = (before, now) else { continue };
            if !now.formulation.is_mixed() {
                continue;
            }
            let enriched = hosts(&self.scene, &now.region);
            if !before.formulation.is_mixed() {
                out.resize(out.len() + enriched.places.len(), 0.0);
                continue;
            }
            let own = hosts(from, &now.region);
            let at = |group, node| values[first + own.number(group, node).expect("a corner between corners")];
            let groups = self.groups_of_run(from, &now.region, &enriched);
            let value = |(node, group): (u32, u32)| -> f64 {
                self.map.corner_weights[&node].iter().map(|(k, w)| w * at(group, *k)).sum()
            };
            out.extend(enriched.nodes().zip(groups).map(|place| scale * value(place)));
            first += own.places.len();
        }
        out
    }

    /// The group of cells of the run to which each pressure belongs \[pressures\], the first one if there are several: a selector may hold all nodes of a cell
    /// but not all of its enriched nodes.
    fn groups_of_run(&self, from: &Scene, region: &str, hosts: &PressureHosts) -> Vec<u32> {
        let mut groups = vec![u32::MAX; hosts.places.len()];
        for (&c, own) in self.scene.regions[region].cells.iter().zip(&hosts.of_cells) {
            let group = from.cell_groups[self.map.parents[c as usize] as usize];
            own.iter().for_each(|&k| groups[k as usize] = groups[k as usize].min(group));
        }
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::{larger, smaller};
    use crate::scene::parse_scene;

    /// All solutions in the enriched space end when `stop` is set, also those on the smooth surface through curved facets.
    #[test]
    fn solutions_end_where_they_are_stopped() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../studies/coverage/scenes/sphere-volume.toml");
        let scene = parse_scene(&std::fs::read_to_string(file).expect("the scene")).expect("a scene");
        let mut enriched = EnrichedScene::new(&scene, Enrichment::Raise).expect("an enriched scene");
        enriched.stop = Some(Arc::new(AtomicBool::new(true)));
        let run = scene.run_with(RunOptions { stop: enriched.stop.clone(), ..RunOptions::default() });
        assert!(matches!(enriched.run(&run), Err(EstimateError::NotSolved { status: "Interrupted", .. })));
        let SmoothSurface::Curved(map, _) = enriched.smooth_surface(&scene) else { panic!("a sphere is curved") };
        let moved = enriched.with_map(&scene, *map).expect("an enriched scene");
        for space in [&enriched, &moved] {
            assert!(space.solver().equations.limit.reached().is_some());
        }
    }

    /// An enriched run is refused where it takes too many iterations.
    #[test]
    fn enriched_runs_are_bounded() {
        let text = "[mesh]\nelement = \"tet4\"\ngrid = { kind = \"box\", size = [\"4 mm\", \"1 mm\", \"1 mm\"], divisions = [2, 1, 1] }\n\
                    [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n\
                    [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n[[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n\
                    [[constraint]]\nkind = \"prescribed\"\nregion = \"xmax\"\ncomponents = \"x\"\ndisplacement = { kind = \"ramp\", from = \"0 mm\", to = \"1 mm\", end = \"1 s\" }\n\
                    [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n";
        let scene = parse_scene(text).unwrap_or_else(|e| panic!("{e}"));
        let enriched = EnrichedScene::new(&scene, Enrichment::Raise).expect("an enriched scene");
        let of_run = scene.run();
        assert!(enriched.run(&of_run).is_ok());
        let run = enriched.scene.run_with(enriched.options(&of_run, enriched.most_iterations(&of_run) - 1));
        assert!(matches!(run.status, Status::Interrupted { .. }) && run.tried_iterations <= 1, "{}", run.status);
        assert!(matches!(enriched.without_solution(&of_run, &run, 0.0), EstimateError::TooLong { .. }));
    }

    /// A wider region that holds whole cells adds a group of pressures. A pressure that is linear in the numbers of the nodes is the same function in both
    /// spaces.
    #[test]
    fn a_state_is_the_same_where_wider_regions_have_other_pressures() {
        let text = "[mesh]\nelement = \"tet4\"\ngrid = { kind = \"box\", size = [\"8 mm\", \"1 mm\", \"1 mm\"], divisions = [4, 1, 1] }\n\
                    [mesh.regions]\nclamp = { kind = \"box\", min = [\"-1 mm\", \"-1 mm\", \"-1 mm\"], max = [\"1 mm\", \"2 mm\", \"2 mm\"] }\n\
                    [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n\
                    [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n[[constraint]]\nkind = \"fixed\"\nregion = \"clamp\"\n\
                    [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n";
        let scene = parse_scene(text).unwrap_or_else(|e| panic!("{e}"));
        let enriched = EnrichedScene::new(&scene, Enrichment::Raise).expect("an enriched scene");
        let wider = enriched.with_wider_regions(&scene, &["clamp".into()]).expect("wider regions");
        let numbered = |space: &EnrichedScene| {
            let mut state = space.scene.system.rest();
            let first = 3 * space.scene.points.len();
            state.x[first..].iter_mut().zip(space.pressure_nodes()).for_each(|(p, node)| *p = f64::from(node));
            state
        };
        let (known, expected) = (numbered(&enriched), numbered(&wider));
        assert!(known.x.len() < expected.x.len(), "{} {}", known.x.len(), expected.x.len());
        assert!(wider.taken(&enriched, &known).x == expected.x && enriched.taken(&wider, &expected).x == known.x);
    }

    /// A path that may have jumped is followed in shorter steps, even if it ended on an unstable branch. If these do not reach the end, or reach an unstable
    /// state, the branch is not decided.
    #[test]
    fn a_path_that_jumped_to_an_unstable_branch_is_followed_in_shorter_steps() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../studies/coverage/scenes/sphere-volume.toml");
        let scene = parse_scene(&std::fs::read_to_string(file).expect("the scene")).expect("a scene");
        let of_run = scene.run();
        assert_eq!(of_run.status, Status::Converged);
        let mut path = scene.run();
        let asks = |path: &Run, has_jumped| asks_for_shorter_steps(path, &of_run, has_jumped, 1.0);
        assert!(matches!(asks(&path, false), Ok(false)));
        path.findings.unstable.push((0.5, 1));
        assert!(matches!(asks(&path, true), Err(EstimateError::Unstable { .. })));
        (path.shifted_factorisations, path.tried_iterations) = (1, path.totals.iterations + 1);
        assert!(matches!(asks(&path, false), Ok(true)));
        path.status = Status::NoEquilibrium { t: 0.5, limit: 0.5, node: 0, in_contact: false, by_force: true };
        assert!(matches!(asks(&path, true), Err(EstimateError::Unstable { .. })));
        assert!(matches!(asks(&path, false), Ok(false)));
    }

    /// The smooth surface through the nodes of a hollow sphere has its volume. It is not a valid measure if the volume of the CAD differs, or belongs to a
    /// solid that it does not change.
    #[test]
    fn a_smooth_surface_is_that_of_the_volume() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../studies/coverage/scenes/sphere-volume.toml");
        let mut scene = parse_scene(&std::fs::read_to_string(file).expect("the scene")).expect("a scene");
        let mesh = scene.body.mesh.clone();
        let radii = mesh.points.iter().map(|point| point.norm());
        let [inner, outer] = [radii.clone().fold(f64::INFINITY, smaller), radii.fold(0.0, larger)];
        let octant = std::f64::consts::FRAC_PI_6 * (outer.powi(3) - inner.powi(3));
        let mut finds = |region: Option<&str>, enclosed: f64, straightened: bool| {
            let mut body = Body::of_mesh(mesh.clone());
            let volume = SourceVolume { region: region.map(Into::into), enclosed, mesh: mesh.volume(), straightened };
            body.volumes = vec![volume.clone()];
            scene.body = Arc::new(body);
            let enriched = EnrichedScene::new(&scene, Enrichment::Raise).expect("an enriched scene");
            match enriched.smooth_surface(&scene) {
                SmoothSurface::Curved(..) => true,
                SmoothSurface::Missed(missed) => missed != [volume],
                _ => panic!("a sphere is curved"),
            }
        };
        assert!(finds(None, octant, false) && !finds(None, 1.25 * octant, false) && !finds(None, 0.8 * octant, false));
        let mut solid = |share: f64, straightened| finds(Some("solid"), mesh.volume() / (1.0 + share), straightened);
        assert!(solid(-0.01, false) && solid(-0.001, true) && !solid(-0.03, false) && !solid(-0.003, true));
    }
}
