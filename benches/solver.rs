//! Parts of a step: assembly per cell, one factorisation, one converged step of the finger. Prints ratios that do
//! not depend on the machine; nothing is asserted.

use cpu_time::ThreadTime;
use criterion::measurement::{Measurement, ValueFormatter, WallTime};
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use durometer::math::linear::Factor;
use durometer::scene::{Body, Scene, overrides, read_scene};
use durometer::system::{At, Rates, State, Want};
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/studies/finger-convergence/scene.toml");

fn scene(changes: &[&str]) -> Scene {
    let file = Path::new(SCENE);
    let changes: Vec<_> = changes.iter().map(|c| overrides::parse(c).expect("key=value")).collect();
    let (spec, text) = read_scene(file, &changes).expect("the scene of the main job is valid");
    let body = Body::load(file, &spec.mesh, &mut |_| {}).expect("its meshes are committed");
    Scene::build(file, spec, text, body.into()).expect("the scene of the main job is valid")
}

const MESHES: [(&str, &[&str]); 3] = [
    ("tet4 16.2k", &["mesh.cells=16200"]),
    ("tet4 36.6k", &["mesh.cells=36600"]),
    ("tet10 4.5k", &["mesh.cells=4500", "mesh.element=tet10"]),
];

/// A smooth bent state without inversion.
fn bent(scene: &Scene) -> State {
    let mesh = &scene.body.mesh;
    let mut state = State::rest(mesh.points.len(), scene.system.constraints.len());
    for (k, p) in mesh.points.iter().enumerate() {
        state.x[3 * k + 2] = -2.0 * p.x * p.x;
    }
    state.lambda.fill(3.0);
    state
}

/// Time of the processor in this thread: what other programs take of it does not count.
struct CpuTime;

impl Measurement for CpuTime {
    type Intermediate = ThreadTime;
    type Value = Duration;

    fn start(&self) -> ThreadTime {
        ThreadTime::now()
    }

    fn end(&self, start: ThreadTime) -> Duration {
        start.elapsed()
    }

    fn add(&self, a: &Duration, b: &Duration) -> Duration {
        *a + *b
    }

    fn zero(&self) -> Duration {
        Duration::ZERO
    }

    fn to_f64(&self, value: &Duration) -> f64 {
        WallTime.to_f64(value)
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        WallTime.formatter()
    }
}

fn assembly(c: &mut Criterion<CpuTime>) {
    let mut group = c.benchmark_group("assembly");
    for (name, changes) in MESHES {
        let scene = scene(changes);
        let state = bent(&scene);
        let mut sums = scene.system.workspace();
        group.throughput(Throughput::Elements(scene.body.mesh.cell_count() as u64));
        for (what, want) in [("residual", Want::Residual), ("tangent and residual", Want::Tangent)] {
            group.bench_function(BenchmarkId::new(what, name), |b| {
                b.iter(|| {
                    let rates = Rates::default();
                    let at = At {
                        t: 0.5,
                        dt: 0.1,
                        x: &state.x,
                        v: &state.v,
                        a: &state.a,
                        old: &state.x,
                        history: &state.history,
                        inputs: &[],
                        rates,
                    };
                    scene.system.assemble(&at, &state.lambda, want, None, black_box(&mut sums)).expect("not inverted");
                });
            });
        }
    }
    group.finish();
}

fn linear(c: &mut Criterion<CpuTime>) {
    let mut group = c.benchmark_group("linear");
    group.sample_size(10);
    for (name, changes) in MESHES {
        let scene = scene(changes);
        let state = bent(&scene);
        let mut sums = scene.system.workspace();
        let rates = Rates::default();
        let rest = vec![0.0; state.x.len()];
        let at = At { t: 0.0, dt: 0.1, x: &rest, v: &rest, a: &rest, old: &rest, history: &[], inputs: &[], rates };
        scene.system.assemble(&at, &[0.0], Want::Tangent, None, &mut sums).expect("the rest state is not inverted");
        let mut factor = Factor::new(scene.system.pattern.clone());
        println!(
            "{name}: {} unknowns, {} entries in the tangent, {} in L, {:.3e} operations",
            scene.system.dofs.free.len(),
            scene.system.pattern.nnz(),
            factor.nnz(),
            factor.flops()
        );
        group.bench_function(BenchmarkId::new("factorisation", name), |b| {
            b.iter(|| factor.factorise(black_box(&sums.k)).expect("stable at rest"));
        });
        let rhs = scene.system.restrict(&state.x);
        group.bench_function(BenchmarkId::new("checked solve", name), |b| {
            b.iter(|| factor.solve(&sums.k, black_box(&mut rhs.clone())).expect("accurate"));
        });
    }
    group.finish();
}

fn step(c: &mut Criterion<CpuTime>) {
    let mut group = c.benchmark_group("protocol");
    group.sample_size(10);
    for (name, changes) in MESHES {
        let scene = scene(changes);
        let steps = 40;
        group.throughput(Throughput::Elements(steps));
        group.bench_function(BenchmarkId::new("converged steps", name), |b| {
            b.iter(|| scene.run().totals.steps);
        });
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().with_measurement(CpuTime);
    targets = assembly, linear, step
}
criterion_main!(benches);
