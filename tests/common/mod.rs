//! Shared by the test programs: seeded numbers, distorted blocks, a dead load, one-call solves; in files of their own what belongs to one subject.

// Each test program uses a part of it.
#![allow(dead_code)]

pub mod cook;
pub mod coverage;
pub mod disk;
pub mod elastic_block;
pub mod field;
pub mod files;
pub mod formulation;
pub mod made;
pub mod mapped;
pub mod program;
pub mod renumbered;
pub mod sensitivities;
pub mod stores;
pub mod studies;
pub mod synthetic;
pub mod tables;
pub mod threads;
pub mod tools;

use durometer::effect::Elastic;
use durometer::material::{Law, registry};
use durometer::math;
use durometer::math::random::SplitMix;
use durometer::math::signal::{Clock, Signal};
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::element::{CELL_EDGES, cell_shape, facet_shape};
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh, quadrature};
use durometer::scene::{Body, Run, RunOptions, Scene, overrides, read_scene};
use durometer::solve::{Driver, Integrator, NewtonSettings, NonlinearSolver, Status, StepSettings, TimeSpan};
use durometer::system::{At, BlockValues, Blocks, Effect, EnergyRole, EvalError, Prescribed, State, System, Want};
use std::ops::{Deref, DerefMut};
use std::path::Path;
use std::sync::Arc;

/// A folder of this name for files of a test, in that of the build.
pub fn folder(name: &str) -> std::path::PathBuf {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Seeded draws for tests.
pub struct Random(SplitMix);

impl Deref for Random {
    type Target = SplitMix;

    fn deref(&self) -> &SplitMix {
        &self.0
    }
}

impl DerefMut for Random {
    fn deref_mut(&mut self) -> &mut SplitMix {
        &mut self.0
    }
}

impl Random {
    pub fn seed(seed: u64) -> Self {
        Self(SplitMix(seed))
    }

    /// Uniform in [−size, size].
    pub fn around(&mut self, size: f64) -> f64 {
        size * (2.0 * self.unit() - 1.0)
    }

    pub fn vector(&mut self, n: usize, size: f64) -> Vec<f64> {
        (0..n).map(|_| self.around(size)).collect()
    }
}

pub const ORDERS: [Order; 2] = [Order::Linear, Order::Quadratic];

/// The law of this name with E [Pa] and ν.
pub fn law(name: &str, e: f64, nu: f64) -> Box<dyn Law> {
    registry::find(name).and_then(|entry| entry.build_from(&[e, nu])).expect("a law of the registry")
}

/// The table of the example of this law.
pub fn example_table(name: &str) -> toml::Table {
    registry::find(name).unwrap_or_else(|e| panic!("{e}")).example_table()
}

/// The example of this law.
pub fn example(name: &str) -> Box<dyn Law> {
    registry::find(name).and_then(|entry| entry.example()).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// A unit cube of n³ boxes, every corner node moved by up to `amount` h in each direction, also on the surface; edges
/// stay straight.
pub fn distorted_cube(n: usize, order: Order, amount: f64, seed: u64) -> TetMesh {
    let mut mesh = block(n, n, n, 1.0, 1.0, 1.0, order);
    let mut random = Random::seed(seed);
    let corners = (n + 1).pow(3);
    for point in &mut mesh.points[..corners] {
        *point += Vec3::from_fn(|_, _| random.around(amount / n as f64));
    }
    straighten(&mut mesh);
    mesh
}

/// Puts the mid-nodes of quadratic cells halfway between their corners.
pub fn straighten(mesh: &mut TetMesh) {
    if mesh.order == Order::Linear {
        return;
    }
    for c in 0..mesh.cell_count() {
        let nodes = mesh.cell(c).to_vec();
        for (e, [a, b]) in CELL_EDGES.into_iter().enumerate() {
            mesh.points[nodes[4 + e] as usize] =
                (mesh.points[nodes[a] as usize] + mesh.points[nodes[b] as usize]) / 2.0;
        }
    }
}

/// All cells.
pub fn body(mesh: &TetMesh) -> Vec<u32> {
    mesh.regions["body"].cells.clone()
}

/// Nodes of a region.
pub fn nodes(mesh: &TetMesh, region: &str) -> Vec<u32> {
    mesh.nodes_of(&mesh.regions[region])
}

/// Nodes on the surface.
pub fn surface(mesh: &TetMesh) -> Vec<u32> {
    let mut nodes = mesh.facets.clone();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The elastic effect of a law on the whole body.
pub fn elastic(mesh: &TetMesh, law: Box<dyn Law>) -> Box<dyn Effect> {
    Box::new(Elastic::new("elastic".into(), mesh, &body(mesh), law))
}

/// Holds components of nodes at zero.
pub fn hold(nodes: &[u32], components: &[u32]) -> Vec<Prescribed> {
    let one = |&n: &u32| components.iter().map(move |c| Prescribed { dof: 3 * n + c, signal: Signal::Constant(0.0) });
    nodes.iter().flat_map(one).collect()
}

/// Linear from 0 at t = 0 to `to` at t = 1.
pub fn ramp(to: f64) -> Signal {
    Signal::Ramp { from: 0.0, to, start: 0.0, end: 1.0 }
}

/// Moves nodes to u(X) by t = 1.
pub fn move_to(mesh: &TetMesh, nodes: &[u32], u: impl Fn(Vec3) -> Vec3) -> Vec<Prescribed> {
    let mut out = Vec::new();
    for &n in nodes {
        let value = u(mesh.points[n as usize]);
        out.extend((0..3).map(|c| Prescribed { dof: 3 * n + c, signal: ramp(value[c as usize]) }));
    }
    out
}

/// Dead load of fixed nodal forces, r = −s(t) f: body forces and tractions of known solutions.
pub struct DeadLoad {
    blocks: Blocks,
    /// [3 × blocks] f [N]
    force: Vec<f64>,
    intensity: Signal,
}

impl DeadLoad {
    /// Forces on nodes [nodes].
    pub fn new(nodal: &[Vec3], intensity: Signal) -> Self {
        let loaded: Vec<u32> = (0..nodal.len() as u32).filter(|&k| nodal[k as usize] != Vec3::zeros()).collect();
        let force = loaded.iter().flat_map(|&k| nodal[k as usize].iter().copied().collect::<Vec<_>>()).collect();
        Self { blocks: Blocks::new(loaded.chunks(1)), force, intensity }
    }

    /// ∫ N_a b(X) dV with the degree-5 rule.
    pub fn body(mesh: &TetMesh, intensity: Signal, b: impl Fn(Vec3) -> Vec3) -> Self {
        let rule = quadrature::tet(5);
        let mut nodal = vec![Vec3::zeros(); mesh.points.len()];
        for c in 0..mesh.cell_count() {
            for (&xi, w) in rule.points.iter().zip(&rule.weights) {
                let value = b(mesh.position(c, xi)) * (w * mesh.jacobian(c, xi).determinant());
                for (&k, n) in mesh.cell(c).iter().zip(cell_shape(mesh.order, xi)) {
                    nodal[k as usize] += value * n;
                }
            }
        }
        Self::new(&nodal, intensity)
    }

    /// ∫ N_a t dA over a facet region, with total force `force`.
    pub fn traction(mesh: &TetMesh, region: &str, intensity: Signal, force: Vec3) -> Self {
        let facets = &mesh.regions[region].facets;
        let traction = force / mesh.region_area(facets);
        Self::surface(mesh, facets, intensity, |_, _| traction)
    }

    /// ∫ N_a t(X, N) dA over facets with the degree-4 rule, N the outward unit normal.
    pub fn surface(mesh: &TetMesh, facets: &[u32], intensity: Signal, t: impl Fn(Vec3, Vec3) -> Vec3) -> Self {
        let rule = quadrature::tri(4);
        let mut nodal = vec![Vec3::zeros(); mesh.points.len()];
        for &f in facets {
            for (&xi, w) in rule.points.iter().zip(&rule.weights) {
                let (normal, shape) = (mesh.facet_normal(f as usize, xi), facet_shape(mesh.order, xi));
                let area = normal.norm();
                let at = mesh.facet(f as usize).iter().zip(shape).map(|(&k, n)| mesh.points[k as usize] * n).sum();
                let force = t(at, normal / area) * (w * area);
                for (&k, n) in mesh.facet(f as usize).iter().zip(shape) {
                    nodal[k as usize] += force * n;
                }
            }
        }
        Self::new(&nodal, intensity)
    }

    /// The nodes and their forces at intensity 1 [N].
    pub fn forces(&self) -> impl Iterator<Item = (u32, Vec3)> {
        (0..self.blocks.len()).map(|b| (self.blocks.nodes(b)[0], Vec3::from_column_slice(&self.force[3 * b..][..3])))
    }
}

impl Effect for DeadLoad {
    fn name(&self) -> &str {
        "dead_load"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Load
    }

    fn intensity(&self, now: Clock) -> f64 {
        self.intensity.at(now)
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, b: usize, _: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let (dof, s) = (3 * self.blocks.nodes(b)[0] as usize, self.intensity.at(at.clock()));
        for i in 0..3 {
            out.energy -= self.force[3 * b + i] * at.x[dof + i];
            out.r[i] = -s * self.force[3 * b + i];
        }
        Ok(())
    }
}

/// Newton at this tolerance, on a body of this length [m].
pub fn newton(system: &System, tolerance: f64, length: f64) -> NonlinearSolver {
    NonlinearSolver::new(system, NewtonSettings { tolerance, ..NewtonSettings::default() }, length)
}

/// Quasi-static loading from rest to t = 1 in equal steps; the state and the sums there. Panics with the status if the
/// run does not converge.
pub fn statics(mesh: &TetMesh, system: &System, tolerance: f64, steps: usize) -> (State, durometer::system::Assembled) {
    let mut driver = Driver::new(system, newton(system, tolerance, mesh.diagonal()), StepSettings::default());
    let mut state = system.rest();
    let span = TimeSpan { integrator: Integrator::Static, start: 0.0, end: 1.0, dt: 1.0 / steps as f64 };
    let status = driver.run(span, &mut state, &mut ());
    assert_eq!(status, Status::Converged);
    (state, driver.steps.solver.equations.sums)
}

/// Sum of the reactions at nodes [N].
pub fn reaction(sums: &durometer::system::Assembled, nodes: &[u32]) -> Vec3 {
    nodes.iter().map(|&k| Vec3::from_column_slice(&sums.r[3 * k as usize..][..3])).sum()
}

/// A scene from its text on a mesh that is not in a file.
pub fn scene(mesh: TetMesh, text: &str) -> Scene {
    try_scene(mesh, text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The same, or why it is refused.
pub fn try_scene(mesh: TetMesh, text: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).expect("a temporary file");
    let (spec, text) = read_scene(&file, &[]).map_err(|e| e.to_string())?;
    let body = Body { source: "block".into(), sha256: String::new(), ..Body::of_mesh(mesh) };
    Scene::build(&file, spec, text, Arc::new(body)).map_err(|e| e.to_string())
}

/// The scene of a study in `studies`, with these changes; its mesh is committed.
pub fn shipped_scene(study: &str, changes: &[&str]) -> Scene {
    changed_scene(&format!("studies/{study}/scene.toml"), changes)
}

/// A scene file of the project with these changes.
pub fn changed_scene(file: &str, changes: &[&str]) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let changes: Vec<_> = changes.iter().map(|c| overrides::parse(c).expect("key=value")).collect();
    let (spec, text) = read_scene(&file, &changes).unwrap_or_else(|e| panic!("{e}"));
    let body = Body::load(&file, &spec.mesh, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
    Scene::build(&file, spec, text, body.into()).unwrap_or_else(|e| panic!("{e}"))
}

/// Runs a scene to its end.
pub fn run(scene: &Scene) -> Run {
    scene.run()
}

/// Runs a scene to its end; each state on the time grid goes to `on_state`.
pub fn run_with_states<'a>(scene: &Scene, on_state: &'a mut (dyn FnMut(&State) + 'a)) -> Run {
    scene.run_with(RunOptions { on_state: Some(on_state), ..RunOptions::default() })
}

/// A column of a run by its name.
pub fn column(run: &Run, name: &str) -> Vec<f64> {
    run.column(name).unwrap_or_else(|| panic!("no {name} in {:?}", run.columns))
}

/// Largest absolute value; not a number where one of the values is none.
pub fn largest(v: &[f64]) -> f64 {
    v.iter().fold(0.0, |m, x| larger(m, x.abs()))
}
