//! Memory that is taken: a step of a reduced model allocates nothing, so that a controller has no pauses of the allocator, and a checkpoint is
//! written without a copy of the factored tangent. A program of its own, whose tests run one at a time, as it counts for the whole process.

use durometer::math::threads::locked;
use durometer::reduction::{FullState, ReducedModel, Training, TransientTraining, Twin};
use durometer::scene::control::{ControlError, Controller, Observation, Reply};
use durometer::scene::{Checkpoint, RunOptions, Scene, parse_scene};
use durometer::system::State;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);
/// Bytes in use, and the most since it was set.
static IN_USE: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);
/// Held by the test that counts.
static ALONE: Mutex<()> = Mutex::new(());

// SAFETY: every call is handed to the allocator of the system as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        let in_use = IN_USE.fetch_add(layout.size(), Ordering::Relaxed) + layout.size();
        MOST.fetch_max(in_use, Ordering::Relaxed);
        // SAFETY: the same layout
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        IN_USE.fetch_sub(layout.size(), Ordering::Relaxed);
        // SAFETY: the same place and layout
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

struct Way(usize);

impl Controller for Way {
    fn step(&mut self, _: &Observation, signals: &mut [f64]) -> Result<Reply, ControlError> {
        self.0 += 1;
        signals[0] = 4e-3 * self.0 as f64 / 20.0;
        Ok(Reply::default())
    }
}

/// A bar that a cable bends; `parts` are effects by rates or settings, and `stage` is its stage.
fn bar(divisions: [usize; 3], parts: &str, stage: &str) -> Scene {
    let text = format!(
        r#"
[mesh]
grid = {{ kind = "box", size = ["40 mm", "10 mm", "10 mm"], divisions = {divisions:?} }}
element = "tet10"
[laws.rubber]
law = "neo_hookean_split"
mu = "60 kPa"
nu = 0.49
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "mixed"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["15 mm", "5 mm", "2 mm"], ["35 mm", "5 mm", "2 mm"]]
pull_point = ["-10 mm", "5 mm", "2 mm"]
guide_radius = "5 mm"
drive = {{ kind = "length", signal = {{ kind = "controlled", initial = "0 mm", range = ["0 mm", "4 mm"] }} }}
{parts}
[[stage]]
{stage}
[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
"#
    );
    parse_scene(&text).unwrap_or_else(|e| panic!("{e}"))
}

/// The states of a run.
fn states(scene: &Scene, names: &[String]) -> Vec<FullState> {
    let mut all: Vec<State> = vec![];
    let mut on_state = |state: &State| all.push(state.clone());
    let mut way = Way(0);
    let run = scene.run_with(RunOptions {
        on_state: Some(&mut on_state),
        controller: Some(&mut way),
        ..RunOptions::default()
    });
    let columns: Vec<Vec<f64>> = names.iter().map(|n| run.column(n).expect("it is recorded")).collect();
    let state = |(k, s): (usize, &State)| FullState {
        inputs: vec![4e-3 * k as f64 / 20.0],
        x: s.x.clone(),
        lambda: s.lambda.clone(),
        values: columns.iter().map(|c| c[k]).collect(),
    };
    all.iter().enumerate().skip(1).map(state).collect()
}

/// Allocations in five runs of 20 steps from rest with inputs that change, sensitivities included.
fn allocations(model: ReducedModel, input: impl Fn(i32) -> f64) -> usize {
    let mut twin = Twin::new(model).expect("a law of the library");
    let mut sensitivities = [0.0; 2];
    // Those of the steps, without those of the return to rest
    let mut run = || {
        twin.reset();
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        for k in 1..=20 {
            twin.step(&[input(k)]).expect("an equilibrium");
            twin.sensitivities(&mut sensitivities);
        }
        ALLOCATIONS.load(Ordering::Relaxed) - before
    };
    run();
    let allocated = (0..5).map(|_| run()).sum();
    assert!(twin.bars().iter().all(|bar| bar.is_finite()));
    allocated
}

const RATES: &str = r#"
[[effect]]
kind = "inertia"
region = "body"
density = "1100 kg/m^3"
mass = "consistent"
[[effect]]
kind = "viscous_damping"
region = "body"
eta = "100 Pa s"
[[effect]]
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "instantaneous"
prony = [{ g = 0.2, tau = "20 ms" }]
"#;

#[test]
fn a_step_allocates_nothing() {
    let _alone = locked(&ALONE);
    let names = ["bending_angle_deg", "cable_tension_N"].map(String::from);
    let scene = bar([4, 1, 1], "", "integrator = \"static\"\nduration = \"20 s\"\ndt = \"1 s\"");
    let known = states(&scene, &names);
    let model = Training::new(&scene, &known, &names)
        .and_then(|t| t.model(4, Some(1e-3), &known))
        .unwrap_or_else(|e| panic!("{e}"));
    let input = |k: i32| 1e-3 + 3e-3 * (f64::from(k) * 0.37).sin().abs();
    assert_eq!(allocations(model, input), 0, "allocations in 100 steps");

    for integrator in ["\"implicit_euler\"", "\"bdf2\"", "{ kind = \"generalised_alpha\", rho = 0.8 }"] {
        let stage = format!("integrator = {integrator}\nduration = \"0.2 s\"\ndt = \"10 ms\"");
        let scene = bar([4, 1, 1], RATES, &stage);
        let known = vec![states(&scene, &names)];
        let model = TransientTraining::new(&scene, &known, &names)
            .and_then(|t| t.model(4, Some(1e-3), &known))
            .unwrap_or_else(|e| panic!("{e}"));
        // The runs change by 0.2 mm a step
        let input = |k: i32| 2e-3 - 2e-3 * (f64::from(k) * 0.09).cos();
        assert_eq!(allocations(model, input), 0, "allocations in 100 steps, {integrator}");
    }
}

/// The file holds some 40 arrays, of which the tangent is by far the largest; what is written at a time is 64 KiB.
#[test]
fn a_checkpoint_is_written_without_a_copy() {
    let _alone = locked(&ALONE);
    let scene =
        bar([24, 6, 6], "[numerics]\nreuse_threshold = 0", "integrator = \"static\"\nduration = \"2 s\"\ndt = \"1 s\"");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("saved.state");
    let mut taken = 0;
    let mut save = |checkpoint: &Checkpoint, _: &str| {
        let before = IN_USE.load(Ordering::Relaxed);
        MOST.store(before, Ordering::Relaxed);
        checkpoint.write(&file).unwrap_or_else(|e| panic!("{e}"));
        taken = MOST.load(Ordering::Relaxed) - before;
    };
    let mut way = Way(0);
    scene.run_with(RunOptions {
        save_at: vec![1.0],
        on_save: Some(&mut save),
        controller: Some(&mut way),
        ..RunOptions::default()
    });
    let bytes = std::fs::metadata(&file).expect("saved").len() as usize;
    assert!(bytes > 4 << 20, "it holds a tangent: {bytes} bytes");
    assert!(taken < bytes / 8, "{taken} bytes were taken for a file of {bytes}");
}
