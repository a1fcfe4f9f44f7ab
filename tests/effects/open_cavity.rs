//! Pressure on an open surface with a free rim: tangent, resultant, a cantilever against the elastica under the same load.

use crate::common;
use crate::common::{Random, column, distorted_cube, elastic, hold, largest, law, newton, nodes, ramp, scene};
use durometer::effect::{Cavity, CavityPressure, OpenCavityPressure, VolumeField};
use durometer::math::signal::Clock;
use durometer::math::tensor::Vec3;
use durometer::math::vector::norm;
use durometer::mesh::rim::rim;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::solve::{Driver, Integrator, Status, Step, StepSettings, TimeSpan};
use durometer::system::{
    Assembled, At, BlockValues, Blocks, Effect, EnergyRole, EvalError, Prescribed, Rates, State, System, Want,
};
use std::sync::Arc;

/// p(t) on facets of a mesh, with a free rim.
fn pressure(mesh: &TetMesh, facets: &[u32], p: f64) -> OpenCavityPressure {
    let cavity = Arc::new(Cavity::new("cavity".into(), mesh, facets, VolumeField::cones(Vec3::zeros())));
    OpenCavityPressure::new(cavity, mesh, facets, ramp(p))
}

/// Two sides of a distorted cube that meet in an edge.
fn angle(mesh: &TetMesh) -> Vec<u32> {
    let mut facets = mesh.regions["zmax"].facets.clone();
    facets.extend(&mesh.regions["xmin"].facets);
    facets
}

/// The sums at t = 1 of a system that reads x alone.
fn assemble(system: &System, x: &[f64], increment: Option<&[f64]>) -> Assembled {
    let mut sums = system.workspace();
    let zero = vec![0.0; x.len()];
    let rates = Rates::default();
    let at = At { t: 1.0, dt: f64::INFINITY, x, v: &zero, a: &zero, old: x, history: &[], inputs: &[], rates };
    system.assemble(&at, &[], Want::Tangent, increment, &mut sums).expect("regular");
    sums
}

fn along(x: &[f64], d: &[f64], h: f64) -> Vec<f64> {
    x.iter().zip(d).map(|(x, d)| x + h * d).collect()
}

/// (K + A) d against a central difference, which is exact: r is quadratic in x. Half of the rim is prescribed, and what it
/// moves is in the lift. Rounding of forces of 1 over a step of 0.1, sums of some ten terms: 1e-13.
#[test]
fn symmetric_and_skew_part_make_the_tangent() {
    for order in common::ORDERS {
        let mesh = distorted_cube(2, order, 0.1, 3);
        let facets = angle(&mesh);
        let held = hold(&nodes(&mesh, "ymin"), &[0, 1, 2]);
        let load = pressure(&mesh, &facets, 2.0);
        let system = System::new(mesh.points.len(), vec![Box::new(load)], vec![], held).expect("a system");
        let mut random = Random::seed(8);
        let n = 3 * mesh.points.len();
        let (x, d) = (random.vector(n, 0.05), random.vector(n, 1.0));
        let mut increment = d.clone();
        system.dofs.free.iter().for_each(|&dof| increment[dof as usize] = 0.0);
        let sums = assemble(&system, &x, Some(&increment));
        let free = system.restrict(&d);
        let (mut symmetric, mut skew) = (vec![0.0; free.len()], vec![0.0; free.len()]);
        system.pattern.multiply(&sums.k, &free, &mut symmetric);
        sums.skew.add_product(&free, &mut skew);
        let force = |h: f64| system.restrict(&assemble(&system, &along(&x, &d, h), None).r);
        let (up, down) = (force(0.1), force(-0.1));
        for i in 0..free.len() {
            let exact = (up[i] - down[i]) / 0.2;
            let sum = symmetric[i] + skew[i] + sums.increment_force[i];
            assert!((sum - exact).abs() < 1e-13, "{order:?} {i}: {sum}, {exact}");
        }
        assert!(
            norm(&skew) > 0.05 * norm(&symmetric) && norm(&sums.increment_force) > 0.05 * norm(&symmetric),
            "{order:?}"
        );
        // Only unknowns of the rim
        let rim: Vec<u32> = rim(&mesh, &facets).concat();
        let of_rim = |e: u32| rim.contains(&(system.dofs.free[e as usize] / 3));
        assert!(sums.skew.entries.iter().all(|&(i, j, _)| of_rim(i) && of_rim(j)));
    }
}

/// Σ r = p ∫ n dA = ½p ∮ x × dx along the rim, at any state. On a quadratic edge the integrand has degree 3, two points.
#[test]
fn the_force_is_the_pressure_times_the_vector_area() {
    for order in common::ORDERS {
        let mesh = distorted_cube(2, order, 0.1, 9);
        let facets = angle(&mesh);
        let load = pressure(&mesh, &facets, 2.0);
        let system = System::new(mesh.points.len(), vec![Box::new(load)], vec![], vec![]).expect("a system");
        let x = Random::seed(5).vector(3 * mesh.points.len(), 0.05);
        let sum: Vec3 = assemble(&system, &x, None).r.chunks_exact(3).map(Vec3::from_column_slice).sum();
        let at = |k: u32| mesh.points[k as usize] + Vec3::from_column_slice(&x[3 * k as usize..][..3]);
        let mut area = Vec3::zeros();
        for edge in rim(&mesh, &facets) {
            let (a, b) = (at(edge[0]), at(edge[1]));
            let bulge = edge.get(2).map_or(Vec3::zeros(), |&k| at(k) - (a + b) / 2.0);
            for s in [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()] {
                let point = a + s * (b - a) + 4.0 * s * (1.0 - s) * bulge;
                area += 0.25 * point.cross(&(b - a + (4.0 - 8.0 * s) * bulge));
            }
        }
        assert!((sum - 2.0 * area).norm() < 1e-13 && sum.norm() > 1.0, "{order:?}: {sum} {area}");
    }
}

/// What is swept on a straight way grows by the force along it: a cubic of the way, so that Richardson of two central
/// differences is exact.
#[test]
fn the_energy_is_the_work_of_the_step() {
    let mesh = distorted_cube(2, Order::Quadratic, 0.1, 9);
    let load = pressure(&mesh, &angle(&mesh), 1.0);
    let mut random = Random::seed(2);
    let n = 3 * mesh.points.len();
    let (old, d, zero) = (random.vector(n, 0.05), random.vector(n, 0.1), vec![0.0; n]);
    let eval = |b: usize, x: &[f64]| {
        let rates = Rates::default();
        let at = At { t: 1.0, dt: f64::INFINITY, x, v: &zero, a: &zero, old: &old, history: &[], inputs: &[], rates };
        let mut out = BlockValues::new(Effect::blocks(&load).size(b));
        load.eval(&at, b, Want::Residual, &mut out).expect("regular");
        out
    };
    for b in 0..Effect::blocks(&load).len() {
        let energy = |s: f64| eval(b, &along(&old, &d, 0.7 + s)).energy;
        let slope = |h: f64| (energy(h) - energy(-h)) / (2.0 * h);
        let exact = (4.0 * slope(0.1) - slope(0.2)) / 3.0;
        let now = eval(b, &along(&old, &d, 0.7));
        let force: f64 = Effect::blocks(&load).dofs(b).zip(&now.r).map(|(dof, r)| r * d[dof as usize]).sum();
        assert!((force - exact).abs() < 1e-14 && force != 0.0, "block {b}: {force}, {exact}");
    }
}

const LENGTH: f64 = 1.0;
const THICKNESS: f64 = 0.02;
const WIDTH: f64 = 0.05;

/// A strip along x, ν = 0 and E = 1, held at x = 0.
fn strip(boxes: usize) -> (TetMesh, Vec<Prescribed>) {
    let mesh = block(boxes, 1, 1, LENGTH, WIDTH, THICKNESS, Order::Quadratic);
    let held = hold(&nodes(&mesh, "xmin"), &[0, 1, 2]);
    (mesh, held)
}

/// Pressure on the upper side that makes p b L³/EI this.
fn scaled(load: f64) -> f64 {
    load * THICKNESS.powi(3) / (12.0 * LENGTH.powi(3))
}

fn cantilever(boxes: usize, load: f64) -> (TetMesh, System) {
    let (mesh, held) = strip(boxes);
    let effects: Vec<Box<dyn Effect>> = vec![
        elastic(&mesh, law("neo_hookean", 1.0, 0.0)),
        Box::new(pressure(&mesh, &mesh.regions["zmax"].facets, scaled(load))),
    ];
    let system = System::new(mesh.points.len(), effects, vec![], held).expect("a system");
    (mesh, system)
}

fn end(mesh: &TetMesh, system: &System, integrator: Integrator, steps: usize) -> State {
    let mut driver = Driver::new(system, newton(system, 1e-9, mesh.diagonal()), StepSettings::default());
    let mut state = system.rest();
    let span = TimeSpan { integrator, start: 0.0, end: 1.0, dt: 1.0 / steps as f64 };
    let status = driver.run(span, &mut state, &mut ());
    assert_eq!(status, Status::Converged);
    println!("{steps} steps: {} iterations, {} cuts", driver.totals.iterations, driver.totals.cuts);
    state
}

/// Middle of the end of the strip.
fn tip(mesh: &TetMesh, state: &State) -> Vec3 {
    let place = |k: usize| mesh.points[k] + Vec3::from_column_slice(&state.x[3 * k..][..3]);
    let corners = nodes(mesh, "xmax").into_iter().map(|k| k as usize);
    let ends = corners.filter(|&k| {
        let p = mesh.points[k];
        (p.y == 0.0 || p.y == WIDTH) && (p.z == 0.0 || p.z == THICKNESS)
    });
    ends.map(place).sum::<Vec3>() / 4.0
}

/// Tip (x, z) and its angle of an inextensible rod of bending stiffness EI, clamped along x, under a load q per length of the
/// loaded side, along its current normal. In the frame of the section, with N the force on it, T along, Q across:
///
/// T′ = κQ, Q′ = −κT + q(1 − κh/2), EI κ′ = −Q, θ′ = κ, all zero at the free end.
///
/// The load follows, so a turned solution is one too: integrated from the free end with θ = 0 there, and turned until θ = 0 at
/// the clamp; nothing is left to shoot for. Classical Runge–Kutta, 2000 steps, error below 1e-10.
fn elastica(load: f64) -> (f64, f64, f64) {
    let n = 2000;
    let ds = -LENGTH / n as f64;
    // T, Q, κ, θ, x, z in units of EI and L; bent downwards, κ < 0 and the upper side is stretched by −κh/2
    let slope = |y: &[f64; 6]| {
        let [t, q, kappa, theta, ..] = *y;
        let force = -load * (1.0 - 0.5 * kappa * THICKNESS);
        [kappa * q, -kappa * t - force, -q, kappa, theta.cos(), theta.sin()]
    };
    let step = |y: &[f64; 6], k: &[f64; 6], h: f64| -> [f64; 6] { std::array::from_fn(|i| y[i] + h * k[i]) };
    let mut y = [0.0; 6];
    for _ in 0..n {
        let a = slope(&y);
        let b = slope(&step(&y, &a, 0.5 * ds));
        let c = slope(&step(&y, &b, 0.5 * ds));
        let d = slope(&step(&y, &c, ds));
        y = std::array::from_fn(|i| y[i] + ds / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    let [.., theta, x, z] = y;
    let (sin, cos) = (-theta).sin_cos();
    (-(cos * x - sin * z), -(sin * x + cos * z), -theta)
}

/// The strip is bent beyond a right angle. Left of the elastica: shear and the mesh, (h/L)² and less.
#[test]
fn a_strip_follows_the_elastica() {
    for load in [2.0, 12.0] {
        let (mesh, system) = cantilever(24, load);
        let state = end(&mesh, &system, Integrator::Static, 6);
        let found = tip(&mesh, &state);
        let (x, z, angle) = elastica(load);
        let wanted = Vec3::new(x, found.y, z + THICKNESS / 2.0);
        let error = (found - wanted).norm() / (wanted - Vec3::new(LENGTH, found.y, THICKNESS / 2.0)).norm();
        println!(
            "pbL³/EI = {load}: tip ({:.5}, {:.5}), elastica ({x:.5}, {z:.5}), angle {:.1}°, error {error:.1e}",
            found.x,
            found.z - THICKNESS / 2.0,
            angle.to_degrees()
        );
        assert!(error < 0.01);
    }
}

/// The end of a static run does not depend on the steps that lead there, and arc length comes to the same state. Newton
/// stops at 1e-9 of the forces of cells, which in a strip are some hundred times the load.
#[test]
fn the_end_does_not_depend_on_the_steps() {
    let (mesh, system) = cantilever(10, 8.0);
    let fine = end(&mesh, &system, Integrator::Static, 20);
    let size = largest(&fine.x);
    for (integrator, steps) in
        [(Integrator::Static, 3), (Integrator::Static, 8), (Integrator::ArcLength { max_steps: 100 }, 10)]
    {
        let other = end(&mesh, &system, integrator, steps);
        let apart = largest(&along(&other.x, &fine.x, -1.0)) / size;
        println!("{integrator:?}, {steps} steps: {apart:.1e}");
        assert!(apart < 1e-6);
    }
}

/// The load without its skew part.
struct Symmetrised(OpenCavityPressure);

impl Effect for Symmetrised {
    fn name(&self) -> &str {
        self.0.name()
    }
    fn blocks(&self) -> &Blocks {
        Effect::blocks(&self.0)
    }
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        self.0.eval(at, b, want, out)
    }
    fn role(&self) -> EnergyRole {
        self.0.role()
    }
    fn intensity(&self, now: Clock) -> f64 {
        self.0.intensity(now)
    }
}

/// ‖x₁ − x‖ of one iteration of Newton's method from x₀ = (1 + δ) x, for both δ. x is the equilibrium; the linearised step is
/// one iteration, and without inertia and damping it is one of statics.
fn after_one_iteration(load: impl Fn(OpenCavityPressure) -> Box<dyn Effect>, deltas: [f64; 2]) -> [f64; 2] {
    let (mesh, held) = strip(10);
    let applied = pressure(&mesh, &mesh.regions["zmax"].facets, scaled(10.0));
    let effects = vec![elastic(&mesh, law("neo_hookean", 1.0, 0.0)), load(applied)];
    let system = System::new(mesh.points.len(), effects, vec![], held).expect("a system");
    let mut driver = Driver::new(&system, newton(&system, 1e-12, mesh.diagonal()), StepSettings::default());
    let mut state = system.rest();
    let span = TimeSpan { integrator: Integrator::Static, start: 0.0, end: 1.0, dt: 0.05 };
    assert_eq!(driver.run(span, &mut state, &mut ()), Status::Converged);
    driver.steps.solver.settings.tolerance = 1e-16;
    let mut iterate = |x: Vec<f64>| {
        let mut next = State { x, ..state.clone() };
        let integrator = Integrator::ImplicitEuler { linearised: true };
        let step = Step { system: &system, integrator, past: &state, dt: 1.0 };
        assert_eq!(driver.steps.solver.solve(&step, &mut next).map(|solved| solved.iterations), Ok(1));
        next.x
    };
    // 1e-12 of the forces of cells is 1e-6 of a motion as soft as this; what is left is taken away.
    let exact = (0..3).fold(state.x.clone(), |x, _| iterate(x));
    deltas.map(|delta| norm(&along(&iterate(along(&exact, &exact, delta)), &exact, -1.0)) / norm(&exact))
}

/// A tenth of the distance leaves a hundredth of the error, and a tenth without the skew part. At distances above 1e-5 the
/// next orders count, in which stretching is a thousand times stiffer than bending; rounding is 1e-13.
#[test]
fn newton_converges_quadratically() {
    let deltas = [1e-6, 1e-7];
    let full = after_one_iteration(|load| Box::new(load), deltas);
    let half = after_one_iteration(|load| Box::new(Symmetrised(load)), deltas);
    println!("left of {deltas:?}: {full:?}, without the skew part {half:?}");
    assert!((full[0] / full[1] - 100.0).abs() < 5.0, "{full:?}");
    assert!((half[0] / half[1] - 10.0).abs() < 0.5 && half[1] > 10.0 * full[1], "{half:?}");
}

/// Where the whole rim is held the load is that of a cavity with a potential. Solved to 1e-9 of the forces, with the softest
/// motion a hundred times softer than a cell.
#[test]
fn a_held_rim_makes_it_symmetric() {
    let mesh = block(6, 6, 1, 1.0, 1.0, 0.1, Order::Quadratic);
    let facets = mesh.regions["zmax"].facets.clone();
    let rim = ["xmin", "xmax", "ymin", "ymax"].map(|side| nodes(&mesh, side)).concat();
    let held: Vec<Prescribed> = {
        let mut rim = rim;
        rim.sort_unstable();
        rim.dedup();
        hold(&rim, &[0, 1, 2])
    };
    let run = |load: Box<dyn Effect>| {
        let effects = vec![elastic(&mesh, law("neo_hookean", 1.0, 0.3)), load];
        let system = System::new(mesh.points.len(), effects, vec![], held.clone()).expect("a system");
        end(&mesh, &system, Integrator::Static, 2)
    };
    let cavity = Arc::new(Cavity::new("cavity".into(), &mesh, &facets, VolumeField::cones(Vec3::zeros())));
    let closed = run(Box::new(CavityPressure { cavity, pressure: ramp(0.01) }));
    let open = run(Box::new(pressure(&mesh, &facets, 0.01)));
    let apart = largest(&along(&open.x, &closed.x, -1.0)) / largest(&closed.x);
    println!("deflection {:.3}, apart {apart:.1e}", largest(&closed.x));
    assert!(apart < 1e-7 && largest(&closed.x) > 0.05);
}

const SCENE: &str = r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cavity"
region = "zmax"
open = true
drive = { kind = "pressure", signal = { kind = "ramp", from = "0 kPa", to = "0.04 kPa", end = "1 s" } }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.1 s"
[[probe]]
kind = "position"
region = "xmax"
[[probe]]
kind = "reaction"
region = "xmin"
[[probe]]
kind = "energy"
"#;

fn beam() -> TetMesh {
    block(6, 1, 1, 0.1, 0.01, 0.01, Order::Quadratic)
}

/// What the load puts in is what the body stores: the trapezoidal rule over the steps leaves an error of second order.
#[test]
fn the_work_of_the_pressure_is_stored() {
    let gap = |dt: &str| {
        let run = common::run(&scene(beam(), &SCENE.replace("dt = \"0.1 s\"", &format!("dt = \"{dt} s\""))));
        let [work, stored] = ["work_J", "elastic_J"].map(|name| *column(&run, name).last().expect("rows"));
        (work / stored - 1.0).abs()
    };
    let (coarse, fine) = (gap("0.1"), gap("0.05"));
    println!("work against energy: {coarse:.1e}, {fine:.1e}");
    assert!(coarse < 1e-2 && (3.5..4.5).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
}

/// Slopes by both constants against differences of whole runs, those of the reactions at the held part of the rim too.
#[test]
fn derivatives_see_the_skew_part() {
    let law: toml::Table = "law = \"neo_hookean\"\nmu = \"40 kPa\"\nnu = 0.3".parse().expect("TOML");
    let start = SCENE.find("[laws.rubber]").expect("a law");
    let end = SCENE.find("[[effect]]").expect("an effect");
    let rest = format!("{}{}", &SCENE[..start], &SCENE[end..]).replace("dt = \"0.1 s\"", "dt = \"0.5 s\"");
    let numerics = "[numerics]\ntolerance = 1e-12\nreuse_factor = false\n[laws.rubber]\n";
    let build =
        |law: &toml::Table| scene(beam(), &format!("{rest}{numerics}{}", toml::to_string(law).expect("a table")));
    println!("worst {:.1e}", common::sensitivities::check("open cavity", &law, &build));
}

/// A constraint in addition to it: the tension that a length of cable asks for, prescribed as a load, gives the same state.
#[test]
fn a_cable_with_it_is_dual() {
    let end = |drive: &str| {
        let cable = format!(
            r#"
[[constraint]]
kind = "cable"
pull_point = ["0 mm", "5 mm", "7 mm"]
guides = [["50 mm", "5 mm", "7 mm"], ["95 mm", "5 mm", "7 mm"]]
guide_radius = "4 mm"
drive = {drive}
[numerics]
tolerance = 1e-10
"#
        );
        let run = common::run(&scene(beam(), &format!("{SCENE}{cable}")));
        assert_eq!(run.status, Status::Converged);
        ["cable_tension_N", "xmax_x_m", "xmax_z_m"].map(|name| *column(&run, name).last().expect("rows"))
    };
    let [tension, x, z] =
        end(r#"{ kind = "length", signal = { kind = "ramp", from = "0 mm", to = "3 mm", end = "1 s" } }"#);
    let same = end(&format!(
        "{{ kind = \"tension\", signal = {{ kind = \"ramp\", from = \"0 N\", to = \"{tension:?} N\", end = \"1 s\" }} }}"
    ));
    println!("tension {tension:.4} N, tip ({x:.6}, {z:.6}) m, back {same:?}");
    assert!(tension > 0.0 && (same[1] - x).abs() < 1e-8 && (same[2] - z).abs() < 1e-8);
}
