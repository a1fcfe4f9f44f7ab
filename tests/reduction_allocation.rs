//! A step of a reduced model allocates nothing: a controller has no pauses of the allocator. The only test of this program, as it counts for
//! the whole process.

use durometer::reduction::{FullState, Training, Twin};
use durometer::scene::control::{ControlError, Controller, Observation, Reply};
use durometer::scene::{RunOptions, parse_scene};
use durometer::system::State;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call is handed to the allocator of the system as it is.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the same layout
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
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

#[test]
fn a_step_allocates_nothing() {
    let scene = parse_scene(
        r#"
[mesh]
grid = { kind = "box", size = ["40 mm", "10 mm", "10 mm"], divisions = [4, 1, 1] }
element = "tet10"
[laws.rubber]
law = "neo_hookean"
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
drive = { kind = "length", signal = { kind = "controlled", initial = "0 mm", range = ["0 mm", "4 mm"] } }
[[stage]]
integrator = "static"
duration = "20 s"
dt = "1 s"
[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
"#,
    )
    .unwrap_or_else(|e| panic!("{e}"));
    let names = ["bending_angle_deg", "cable_tension_N"].map(String::from);
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
    let states: Vec<FullState> = all.iter().enumerate().skip(1).map(state).collect();
    let model = Training::new(&scene, &states, &names)
        .and_then(|t| t.model(4, Some(1e-3), &states))
        .unwrap_or_else(|e| panic!("{e}"));
    let mut twin = Twin::new(model).expect("a law of the library");
    let mut sensitivities = [0.0; 2];
    let mut step = |u: f64| {
        twin.step(&[u]).expect("an equilibrium");
        twin.sensitivities(&mut sensitivities);
    };
    step(1e-3);
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    for k in 0..100 {
        step(1e-3 + 3e-3 * (f64::from(k) * 0.37).sin().abs());
    }
    let allocated = ALLOCATIONS.load(Ordering::Relaxed) - before;
    assert!(twin.bars().iter().all(|bar| bar.is_finite()));
    assert_eq!(allocated, 0, "allocations in 100 steps");
}
