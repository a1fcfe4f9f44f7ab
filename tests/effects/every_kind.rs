//! One test over every effect and constraint: residual, tangent, energy, balance of momentum. A kind that a scene can
//! declare and that has no sample here does not compile.
//!
//! Finite differences as in `derivatives.rs`: Richardson's D₆ of steps s, s/2, s/4 along a random direction d. The cells
//! have edges of about ½ and the states move nodes by up to 0.05, so F and J stay regular within |s| ≈ ρ = 0.05 of
//! directions of size 1. With s = 1e-3 the truncation is at most (s/ρ)⁶/64 · M/ρ ≈ 2e-11 M, the rounding 6.6 k ε M/s ≈
//! 1.5e-12 k M with k up to 100 for the sums behind an entry: the bound is 1e-9 M, M the largest value on the stencil plus
//! the derivative itself.

use crate::common;
use crate::common::{Random, distorted_cube, scene};
use durometer::effect::{Cavity, VolumeField};
use durometer::material::{LAWS, Want};
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::Order;
use durometer::scene::Scene;
use durometer::scene::spec::{ConstraintSpec, EffectSpec};
use durometer::solve::Integrator;
use durometer::system::{At, BlockValues, Effect, EnergyRole, Means, Needs, Perturbation, State, System};
use std::sync::Arc;

const INTEGRATORS: [Integrator; 7] = [
    Integrator::Static,
    Integrator::ImplicitEuler { linearised: false },
    Integrator::ImplicitEuler { linearised: true },
    Integrator::Bdf2,
    Integrator::GeneralisedAlpha { rho: 0.6 },
    Integrator::GeneralisedAlpha { rho: 0.0 },
    Integrator::Newmark { beta: 0.25, gamma: 0.5 },
];

const DT: f64 = 0.02;
const TIME: f64 = 0.3;
const BOUND: f64 = 1e-9;

/// Number of the kind: a new kind has no arm, and this file says where its sample belongs.
fn effect_kind(spec: &EffectSpec) -> usize {
    match spec {
        EffectSpec::Elastic(_) => 0,
        EffectSpec::Inertia(_) => 1,
        EffectSpec::Gravity(_) => 2,
        EffectSpec::MassDamping(_) => 3,
        EffectSpec::ViscousDamping(_) => 4,
        EffectSpec::StiffnessDamping(_) => 5,
        EffectSpec::EdgeSprings(_) => 6,
        EffectSpec::EdgeDampers(_) => 7,
        EffectSpec::Viscoelastic(_) => 8,
        EffectSpec::PointForce(_) => 9,
        EffectSpec::Traction(_) => 10,
        EffectSpec::Fibre(_) => 11,
        EffectSpec::Membrane(_) => 12,
        EffectSpec::FibreFamily(_) => 13,
        EffectSpec::Mullins(_) => 14,
    }
}

fn constraint_kind(spec: &ConstraintSpec) -> usize {
    match spec {
        ConstraintSpec::Fixed(_) => 0,
        ConstraintSpec::Prescribed(_) => 1,
        ConstraintSpec::Cable(_) => 2,
        ConstraintSpec::Cavity(_) => 3,
        ConstraintSpec::Rigid(_) => 4,
    }
}

/// Regions of the masses of each form: one effect of inertia on the cells of another is refused.
const MASSES: [&str; 3] = ["body", "lower", "upper"];

/// Springs with each stiffness, and dampers.
const EDGES: &str = r#"
[[effect]]
kind = "edge_springs"
overlap = "add"
region = "body"
stiffness = "30 kN/m"
[[effect]]
kind = "edge_springs"
overlap = "add"
region = "body"
E = "100 kPa"
[[effect]]
kind = "edge_dampers"
region = "body"
damping = "500 N s/m"
"#;

/// Loads, dampers, constraints and the stage.
const LOADS_AND_CONSTRAINTS: &str = r#"[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [1, -2, 3]
acceleration = { kind = "ramp", from = "0 m/s^2", to = "30 m/s^2", end = "1 s" }
[[effect]]
kind = "point_force"
point = ["0.6 m", "0.5 m", "0.4 m"]
radius = "0.3 m"
direction = [1, 1, -1]
force = { kind = "ramp", from = "0 N", to = "9 kN", end = "1 s" }
[[effect]]
kind = "traction"
region = "ymax"
direction = [0, 2, 1]
traction = { kind = "ramp", from = "0 kPa", to = "9 kPa", end = "1 s" }
[[effect]]
kind = "fibre"
along = { kind = "helix", axis = [["0.5 m", "0.5 m", "0.1 m"], ["0.5 m", "0.5 m", "0.9 m"]], radius = "0.3 m", turns = 1, hand = "both" }
EA = "40 kN"
compression = true
spacing = "0.4 m"
[[effect]]
kind = "membrane"
region = "zmax"
law = "sheet"
thickness = "0.1 m"
[laws.sheet]
law = "neo_hookean"
E = "90 kPa"
nu = 0.4
[[effect]]
kind = "fibre_family"
region = "body"
k1 = "20 kPa"
k2 = 0.5
kappa = 0.3333333333333333
direction = { kind = "constant", vectors = [[1, 1, 0], [1, -1, 0]] }
[[effect]]
kind = "mass_damping"
region = "body"
density = "900 kg/m^3"
mass = "consistent"
alpha = "3 /s"
[[effect]]
kind = "viscous_damping"
region = "body"
eta = "2 kPa s"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "xz"
displacement = { kind = "ramp", from = "0 mm", to = "80 mm", end = "1 s" }
[[constraint]]
kind = "cable"
name = "by_length"
guides = [["0.05 m", "0.8 m", "0.3 m"], ["0.5 m", "0.7 m", "0.5 m"], ["0.9 m", "0.8 m", "0.6 m"]]
pull_point = ["-0.3 m", "0.9 m", "0.2 m"]
guide_radius = "0.2 m"
drive = { kind = "length", signal = "10 mm" }
[[constraint]]
kind = "cable"
name = "by_tension"
guides = [["0.3 m", "0.2 m", "0.3 m"], ["0.9 m", "0.3 m", "0.6 m"]]
pull_point = ["-0.3 m", "0.1 m", "0.2 m"]
guide_radius = "point"
drive = { kind = "tension", signal = { kind = "ramp", from = "0 N", to = "5 kN", end = "1 s" } }
[[constraint]]
kind = "cavity"
name = "by_pressure"
region = "low"
drive = { kind = "pressure", signal = { kind = "ramp", from = "0 kPa", to = "20 kPa", end = "1 s" } }
[[constraint]]
kind = "cavity"
name = "by_volume"
region = "high"
drive = { kind = "volume", signal = "10 ml" }
[[stage]]
integrator = "bdf2"
duration = "1 s"
dt = "0.1 s"
"#;

/// Every kind but mullins once (the viscoelastic one where the law has an isochoric part), inertia with each lumping, springs with each
/// stiffness, the law given, a sheet with a law that has a plane stress at every state; what acts on edges on tet4 only. Moduli, densities and viscosities make forces of one size.
fn sample(law: &str, order: Order) -> Scene {
    let relaxing = r#"
[[effect]]
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "instantaneous"
prony = [{ g = 0.3, tau = "10 ms" }, { g = 0.2, tau = "0.1 s" }]
"#;
    let isochoric = LAWS.iter().any(|entry| entry.info.name == law && entry.info.isochoric);
    sample_with(law, order, if isochoric { relaxing } else { "" })
}

/// The same with softening in the place of relaxation.
fn softening_sample(law: &str, order: Order) -> Scene {
    let softening = r#"
[[effect]]
kind = "mullins"
region = "body"
law = "rubber"
softening = { r = 3, m = "20 kPa", beta = 0.1 }
"#;
    sample_with(law, order, softening)
}

fn sample_with(law: &str, order: Order, remembering: &str) -> Scene {
    let masses = [("consistent", MASSES[0]), ("lumped", MASSES[1]), ("uniform", MASSES[2])].map(|(m, region)| {
        format!("[[effect]]\nkind = \"inertia\"\nregion = \"{region}\"\ndensity = \"900 kg/m^3\"\nmass = \"{m}\"\n")
    });
    let edges = if order == Order::Linear { EDGES } else { "" };
    let text = format!(
        r#"
[mesh]
body = "block"
[mesh.regions]
lower = {{ kind = "box", min = ["-1 m", "-1 m", "-1 m"], max = ["2 m", "2 m", "0.7 m"], pick = "cells", rule = "all" }}
upper = {{ kind = "complement", of = ["lower"] }}
low = {{ kind = "box", min = ["-0.1 m", "-1 m", "-1 m"], max = ["0.1 m", "2 m", "0.7 m"], pick = "facets", rule = "all" }}
high = {{ kind = "difference", of = ["xmin", "low"] }}
[[effect]]
kind = "stiffness_damping"
region = "body"
beta = "20 ms"
stiffness = "initial"
[[effect]]
kind = "stiffness_damping"
region = "body"
beta = "20 ms"
stiffness = "last"
[laws.rubber]
{}
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
{}{}
{edges}
{LOADS_AND_CONSTRAINTS}"#,
        common::example_table(law),
        masses.concat(),
        remembering,
    );
    scene(distorted_cube(2, order, 0.1, 17), &text)
}

/// Each law with tet10, one with tet4 besides.
fn over_scenes(check: impl Fn(&str, &Scene)) {
    for entry in LAWS {
        check(&format!("{} tet10", entry.info.name), &sample(entry.info.name, Order::Quadratic));
    }
    check("neo_hookean_split tet4", &sample("neo_hookean_split", Order::Linear));
    check("yeoh tet10 that softens", &softening_sample("yeoh", Order::Quadratic));
    check("ogden tet4 that softens", &softening_sample("ogden", Order::Linear));
}

/// The state before a step of an integrator, at random rates and with a random history (stresses of the size that these
/// displacements give; largest energies of none or well above those of these displacements, between which the tangent jumps), and a displacement after it.
fn states(integrator: Integrator, system: &System, first: bool, random: &mut Random) -> (State, Vec<f64>) {
    let mut past = system.rest();
    let n = past.x.len();
    past.history = random.vector(past.history.len(), 5e3);
    if system.effects.iter().any(|e| e.name() == "mullins") {
        past.history.iter_mut().for_each(|peak| *peak = if *peak > 0.0 { 2e4 + *peak } else { 0.0 });
    }
    past.x = random.vector(n, 0.03);
    past.v = random.vector(n, 1.0);
    past.a = random.vector(n, 10.0);
    integrator.begin(&mut past);
    if !first {
        past.memory = random.vector(if integrator == Integrator::Bdf2 { 2 * n } else { past.memory.len() }, 0.05);
        past.dt = 0.7 * DT;
    }
    let x = past.x.iter().map(|x| x + random.around(0.02)).collect();
    (past, x)
}

/// What a step of an integrator sees at displacement x. One effect at most has a history: it is that of the state.
fn with_at<T>(integrator: Integrator, past: &State, x: &[f64], use_it: impl FnOnce(&At) -> T) -> T {
    let (mut v, mut a) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    integrator.kinematics(past, DT, x, &mut v, &mut a);
    let dt = if integrator.is_static() { f64::INFINITY } else { DT };
    use_it(&At {
        t: TIME,
        dt,
        x,
        v: &v,
        a: &a,
        old: &past.x,
        history: &past.history,
        inputs: &[],
        rates: integrator.rates(past, DT),
    })
}

/// What an effect or a row sees of a vector over all dofs: that of its means, if it has some.
fn seen(means: Option<&Arc<Means>>, all: &[f64]) -> Vec<f64> {
    means.map_or(all.to_vec(), |means| means.of(all))
}

fn eval(effect: &(dyn Effect + 'static), at: &At, b: usize, want: Want) -> BlockValues {
    let mut out = BlockValues::new(3 * effect.blocks().nodes(b).len());
    effect
        .eval(&At { x: &seen(effect.capabilities().means, at.x), ..*at }, b, want, &mut out)
        .expect("the state is regular");
    out
}

/// r of block `b` as forces on nodes; a node of several means comes with each.
fn forces(effect: &(dyn Effect + 'static), at: &At, b: usize) -> Vec<(u32, Vec3)> {
    let (nodes, r) = (effect.blocks().nodes(b), eval(effect, at, b, Want::Residual).r);
    let of_block = nodes.iter().zip(r.chunks_exact(3)).map(|(&node, f)| (node, Vec3::from_column_slice(f)));
    let Some(means) = effect.capabilities().means else { return of_block.collect() };
    let mut of_means = vec![0.0; means.of(at.x).len()];
    of_block.for_each(|(k, f)| of_means[3 * k as usize..][..3].copy_from_slice(f.as_slice()));
    let mut out = Vec::new();
    means.spread(&of_means, |dof, f| out.push((dof / 3, f * Vec3::ith(dof as usize % 3, 1.0))));
    out
}

/// The dofs of a block out of a vector over all.
fn gather(nodes: &[u32], all: &[f64]) -> Vec<f64> {
    nodes.iter().flat_map(|&k| all[3 * k as usize..3 * k as usize + 3].to_vec()).collect()
}

/// K d with the lower triangle read as a symmetric matrix.
fn times(k: &[f64], d: &[f64]) -> Vec<f64> {
    let n = d.len();
    (0..n).map(|i| (0..n).map(|j| k[i.max(j) * n + i.min(j)] * d[j]).sum()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn absolute(a: &[f64]) -> Vec<f64> {
    a.iter().map(|a| a.abs()).collect()
}

/// D₆ of g at 0, component by component, and the size of g on the stencil.
fn difference(g: impl Fn(f64) -> Vec<f64>) -> (Vec<f64>, f64) {
    let (s, mut size) = (1e-3, 0.0_f64);
    let [d1, d2, d4] = [s, s / 2.0, s / 4.0].map(|s| {
        let (plus, minus) = (g(s), g(-s));
        size = [&plus, &minus].into_iter().map(|g| common::largest(g)).fold(size, larger);
        plus.iter().zip(&minus).map(|(p, m)| (p - m) / (2.0 * s)).collect::<Vec<_>>()
    });
    let d: Vec<f64> = (0..d1.len()).map(|i| (64.0 * d4[i] - 20.0 * d2[i] + d1[i]) / 45.0).collect();
    let total = size + common::largest(&d);
    (d, total)
}

fn assert_close(label: &str, got: &[f64], (d, size): &(Vec<f64>, f64)) {
    for (i, (got, want)) in got.iter().zip(d).enumerate() {
        assert!((got - want).abs() <= BOUND * size, "{label}[{i}] = {got:e}, differences say {want:e} (size {size:e})");
    }
}

fn along(x: &[f64], d: &[f64], s: f64) -> Vec<f64> {
    x.iter().zip(d).map(|(x, d)| x + s * d).collect()
}

#[test]
fn the_samples_cover_every_kind() {
    let scene = sample("neo_hookean_split", Order::Linear);
    let softens = softening_sample("yeoh", Order::Linear);
    let mut seen = [false; 15];
    scene.spec.effects.iter().chain(&softens.spec.effects).for_each(|e| seen[effect_kind(e)] = true);
    assert_eq!(seen, [true; 15]);
    let mut seen = [false; 4];
    scene.spec.constraints.iter().for_each(|c| seen[constraint_kind(c)] = true);
    assert_eq!(seen, [true; 4]);
}

/// K_e = ∂r/∂x + cv ∂r/∂v + ca ∂r/∂a, symmetric (only one triangle is stored: a wrong symmetry fails here), under every
/// integrator, in its first step and in the later ones.
#[test]
fn tangent_is_the_derivative_of_the_residual_under_every_integrator() {
    over_scenes(|name, scene| {
        let mut random = Random::seed(1);
        for integrator in INTEGRATORS {
            for first in [true, false] {
                let n = scene.system.dofs.equation.len();
                let (past, x) = states(integrator, &scene.system, first, &mut random);
                let d = random.vector(n, 1.0);
                for (e, effect) in scene.system.effects.iter().map(AsRef::as_ref).enumerate() {
                    for b in (0..effect.blocks().len()).step_by(5) {
                        let nodes = effect.blocks().nodes(b);
                        let k = with_at(integrator, &past, &x, |at| eval(effect, at, b, Want::Tangent).k);
                        let differences = difference(|s| {
                            with_at(integrator, &past, &along(&x, &d, s), |at| eval(effect, at, b, Want::Residual).r)
                        });
                        let label = format!("{name}: effect {e} {}, block {b}, {integrator:?}: (K d)", effect.name());
                        assert_close(
                            &label,
                            &times(&k, &gather(nodes, &seen(effect.capabilities().means, &d))),
                            &differences,
                        );
                    }
                }
            }
        }
    });
}

/// What an effect reads beyond x has its derivative: r and the new history along random directions of v, a, x of the last
/// step, the history and, for the new history, x.
#[test]
fn derivatives_by_what_came_before() {
    over_scenes(|name, scene| {
        let (mut random, n) = (Random::seed(3), scene.system.dofs.equation.len());
        let (past, x) = states(Integrator::Bdf2, &scene.system, false, &mut random);
        let [dx, dv, da, dold] = [1.0, 30.0, 300.0, 1.0].map(|size| random.vector(n, size));
        let dhistory = random.vector(past.history.len(), 1e5);
        let direction = Perturbation { x: &dx, v: &dv, a: &da, old: &dold, history: &dhistory };
        for (e, effect) in scene.system.effects.iter().map(AsRef::as_ref).enumerate() {
            if effect.capabilities().history_size() == 0 && effect.capabilities().needs == Needs::default() {
                assert!(effect.capabilities().past.is_none(), "{}", effect.name());
                continue;
            }
            let known = effect.capabilities().past.unwrap_or_else(|| panic!("{} has no derivative", effect.name()));
            for b in (0..effect.blocks().len()).step_by(5) {
                let label = format!("{name}: effect {e} {}, block {b}", effect.name());
                with_at(Integrator::Bdf2, &past, &x, |at| {
                    let moved = |s: f64, use_it: &dyn Fn(&At) -> Vec<f64>| {
                        let [v, a] = [along(at.v, &dv, s), along(at.a, &da, s)];
                        let [old, history] = [along(at.old, &dold, s), along(at.history, &dhistory, s)];
                        let history = if effect.capabilities().history_size() > 0 { &history } else { at.history };
                        use_it(&At { v: &v, a: &a, old: &old, history, ..*at })
                    };
                    let mut out = BlockValues::new(3 * effect.blocks().nodes(b).len());
                    known.along(at, &direction, b, &mut out).expect("the state is regular");
                    let force = difference(|s| moved(s, &|at| eval(effect, at, b, Want::Residual).r));
                    assert_close(&label, &out.r, &force);
                    let place =
                        b * effect.capabilities().history_size()..(b + 1) * effect.capabilities().history_size();
                    let mut new = dhistory.get(place.clone()).map_or(Vec::new(), <[f64]>::to_vec);
                    known.advance_along(at, &direction, b, &mut new).expect("the state is regular");
                    let history = difference(|s| {
                        moved(s, &|at| {
                            let mut new = at.history.get(place.clone()).map_or(Vec::new(), <[f64]>::to_vec);
                            if let Some(history) = effect.capabilities().history {
                                history.advance(&At { x: &along(&x, &dx, s), ..*at }, b, &mut new).expect("regular");
                            }
                            new
                        })
                    });
                    assert_close(&label, &new, &history);
                });
            }
        }
    });
}

/// Stored: r = ∂E/∂x. Load: r = s(t) ∂φ/∂x. Kinetic: E = ½v·Mv with the M of r = M a. Dissipative: E = r·(x − old),
/// positive over the body (a damper that turns more than it stretches may take a little of it back).
#[test]
fn energy_belongs_to_the_residual() {
    over_scenes(|name, scene| {
        let mut random = Random::seed(2);
        let n = scene.system.dofs.equation.len();
        let integrator = Integrator::ImplicitEuler { linearised: false };
        let (past, x) = states(integrator, &scene.system, true, &mut random);
        let d = random.vector(n, 1.0);
        for (e, effect) in scene.system.effects.iter().map(AsRef::as_ref).enumerate() {
            let mut dissipated = 0.0;
            for b in 0..effect.blocks().len() {
                let local = gather(effect.blocks().nodes(b), &seen(effect.capabilities().means, &d));
                let label = format!("{name}: effect {e} {}, block {b}", effect.name());
                let now = with_at(integrator, &past, &x, |at| eval(effect, at, b, Want::Residual));
                match effect.role() {
                    EnergyRole::Stored | EnergyRole::Contact | EnergyRole::Load => {
                        let s = if effect.role() == EnergyRole::Load { effect.intensity(TIME.into()) } else { 1.0 };
                        assert!(s > 0.0, "{label}: a load of no intensity tests nothing");
                        let energy = difference(|h| {
                            let x = along(&x, &d, h);
                            vec![s * with_at(integrator, &past, &x, |at| eval(effect, at, b, Want::Energy).energy)]
                        });
                        assert_close(&label, &[dot(&now.r, &local)], &energy);
                    }
                    EnergyRole::Kinetic => {
                        with_at(integrator, &past, &x, |at| {
                            let force = eval(effect, &At { a: at.v, ..*at }, b, Want::Residual).r;
                            let energy = difference(|h| {
                                let v = along(at.v, &d, h);
                                vec![eval(effect, &At { v: &v, ..*at }, b, Want::Energy).energy]
                            });
                            assert_close(&label, &[dot(&force, &local)], &energy);
                            let half = 0.5 * dot(&force, &gather(effect.blocks().nodes(b), at.v));
                            assert!(half > 0.0 && (half - now.energy).abs() <= 1e-13 * half, "{label}: ½v·Mv");
                        });
                    }
                    EnergyRole::Dissipative | EnergyRole::Friction => {
                        let step: Vec<f64> = x.iter().zip(&past.x).map(|(x, old)| x - old).collect();
                        let step = gather(effect.blocks().nodes(b), &step);
                        let (work, size) = (dot(&now.r, &step), dot(&absolute(&now.r), &absolute(&step)));
                        assert!((work - now.energy).abs() <= 1e-13 * size, "{label}: {work}, booked {}", now.energy);
                        dissipated += work;
                    }
                    EnergyRole::Follower => unreachable!("{label}: those with a rim are in open_cavity.rs"),
                    // What is dissipated is a function of the state: D + E has the gradient r
                    EnergyRole::Relaxing if effect.name() == "mullins" => {
                        assert!(now.dissipated >= 0.0, "{label}");
                        let sum = difference(|h| {
                            let out =
                                with_at(integrator, &past, &along(&x, &d, h), |at| eval(effect, at, b, Want::Energy));
                            vec![out.energy + out.dissipated]
                        });
                        assert_close(&label, &[dot(&now.r, &local)], &sum);
                    }
                    EnergyRole::Relaxing => {
                        // With f = r − ∂E/∂x the step dissipates ½(fₙ + f)·s(x − old) at old + s(x − old): what is left
                        // without the half of f is linear in s.
                        let step: Vec<f64> = x.iter().zip(&past.x).map(|(x, old)| x - old).collect();
                        let local = gather(effect.blocks().nodes(b), &step);
                        let mut size = 0.0_f64;
                        let mut of_the_start = |s: f64| {
                            let at = |s: f64, want| {
                                with_at(integrator, &past, &along(&past.x, &step, s), |at| eval(effect, at, b, want))
                            };
                            let (slope, error) = difference(|h| vec![at(s + h, Want::Energy).energy]);
                            let now = at(s, Want::Residual);
                            size = [error, now.dissipated.abs()].into_iter().fold(size, larger);
                            now.dissipated - 0.5 * s * (dot(&now.r, &local) - slope[0])
                        };
                        let (half, whole) = (of_the_start(0.5), of_the_start(1.0));
                        assert!(whole != 0.0 && (whole - 2.0 * half).abs() <= BOUND * size, "{label}: {whole}, {half}");
                    }
                }
            }
            let name = effect.name();
            assert!(effect.role() != EnergyRole::Dissipative || dissipated > 0.0, "{name} dissipates {dissipated} J");
        }
    });
}

/// Σ r = 0 for forces inside the body, and Σ x × r = 0 where the law is objective; Σ r = m a, α m v and −m g for the
/// others under a uniform field. Rounding of sums of a thousand terms (ε times that at worst): 1e-12 of the sum of sizes.
#[test]
fn momentum_balances() {
    over_scenes(|name, scene| {
        let mut random = Random::seed(3);
        let system = &scene.system;
        let mesh = &scene.body.mesh;
        let n = system.dofs.equation.len();
        let integrator = Integrator::ImplicitEuler { linearised: false };
        let (past, x) = states(integrator, &scene.system, true, &mut random);
        let uniform = Vec3::new(0.3, -0.7, 0.2);
        let field: Vec<f64> = (0..n).map(|i| uniform[i % 3]).collect();
        let volume = mesh.volume();
        let mut masses = MASSES.map(|region| mesh.region_volume(&scene.regions[region].cells)).into_iter();
        for (e, effect) in system.effects.iter().map(AsRef::as_ref).enumerate() {
            let (mut force, mut moment, mut size, mut arm) = (Vec3::zeros(), Vec3::zeros(), 0.0, 0.0);
            with_at(integrator, &past, &x, |at| {
                // The uniform velocity costs a stiffness nothing: it is tested with the one of the step.
                let v = if effect.name() == "stiffness_damping" { at.v } else { &field };
                let at = At { v, a: &field, ..*at };
                for b in 0..effect.blocks().len() {
                    for (node, f) in forces(effect, &at, b) {
                        let p = mesh.points[node as usize] + Vec3::from_column_slice(&x[3 * node as usize..][..3]);
                        force += f;
                        moment += p.cross(&f);
                        size += f.norm();
                        arm += p.norm() * f.norm();
                    }
                }
            });
            let label = format!("{name}: effect {e} {}: Σr = {force}, Σx×r = {moment}", effect.name());
            let (expected, twistless) = match effect.name() {
                "elastic" => (Vec3::zeros(), scene.law.as_ref().expect("an elastic effect").info().objective),
                "viscous_damping" | "viscoelastic" | "mullins" | "edge_springs" | "edge_dampers" | "membrane"
                | "fibre" | "fibre_family" => (Vec3::zeros(), true),
                "stiffness_damping" => (Vec3::zeros(), false),
                "inertia" => (uniform * 900.0 * masses.next().expect("one of three"), false),
                "mass_damping" => (uniform * 3.0 * 900.0 * volume, false),
                "gravity" => (Vec3::new(1.0, -2.0, 3.0).normalize() * (-1000.0 * 9.0 * volume), false),
                // Weights of a patch sum up to 1, those of a surface to its area.
                "point_force" => (Vec3::new(1.0, 1.0, -1.0).normalize() * -2700.0, false),
                "traction" => {
                    let area = mesh.region_area(&mesh.regions["ymax"].facets);
                    (Vec3::new(0.0, 2.0, 1.0).normalize() * (-2700.0 * area), false)
                }
                // The pull point holds the other end: T times the direction of the first segment.
                "by_tension" => {
                    let line = scene.cables[1].cable.polyline(&x);
                    ((line[1] - line[0]).normalize() * effect.intensity(TIME.into()), false)
                }
                // A translation t changes the cones over an open surface by −⅓ t·∫n dA; so does −t of their origin.
                "by_pressure" => {
                    let volume = |o: Vec3| {
                        Cavity::new("c".into(), mesh, &scene.regions["low"].facets, VolumeField::cones(o)).volume(&x)
                    };
                    let area = Vec3::from_fn(|k, _| 3.0 * (volume(Vec3::ith(k, 1.0)) - volume(Vec3::zeros())));
                    (area / 3.0 * effect.intensity(TIME.into()), false)
                }
                other => panic!("say what the forces of {other} sum up to"),
            };
            assert!((force - expected).norm() <= 1e-12 * size, "{label}, expected {expected}");
            assert!(!twistless || moment.norm() <= 1e-12 * arm, "{label}");
        }
    });
}

/// What has a rate rests in statics, whatever the step did: the result of statics must not depend on dt.
#[test]
fn rate_effects_rest_in_statics() {
    let scene = sample("neo_hookean", Order::Quadratic);
    let mut random = Random::seed(4);
    let (past, x) = states(Integrator::Static, &scene.system, true, &mut random);
    for effect in scene
        .system
        .effects
        .iter()
        .map(AsRef::as_ref)
        .filter(|e| e.capabilities().needs.velocity || e.capabilities().needs.acceleration)
    {
        for b in 0..effect.blocks().len() {
            let local = with_at(Integrator::Static, &past, &x, |at| eval(effect, at, b, Want::Tangent));
            assert!(local.r.iter().chain(&local.k).all(|v| *v == 0.0), "{} in statics", effect.name());
            assert_eq!(local.energy, 0.0, "{} in statics", effect.name());
        }
    }
    let rates: Vec<_> =
        scene.system.effects.iter().filter(|e| e.capabilities().needs.velocity).map(|e| e.name()).collect();
    let named = ["stiffness_damping", "stiffness_damping", "inertia", "inertia", "inertia", "mass_damping"];
    assert_eq!(rates, [&named[..], &["viscous_damping"]].concat());
}

/// c ↔ ∂c/∂x ↔ ∂²c/∂x² of every exact row.
#[test]
fn rows_are_consistent() {
    over_scenes(|name, scene| {
        let mut random = Random::seed(5);
        let n = scene.system.dofs.equation.len();
        assert!(!scene.system.constraints.is_empty());
        for constraint in &scene.system.constraints {
            let (x, d) = (random.vector(n, 0.03), random.vector(n, 1.0));
            for b in 0..constraint.blocks().len() {
                let nodes = constraint.blocks().nodes(b);
                let at = |x: &[f64]| {
                    let mut out = BlockValues::new(3 * nodes.len());
                    constraint
                        .eval(&seen(constraint.means(), x), b, Want::Tangent, &mut out)
                        .expect("the guides are apart");
                    out
                };
                let (now, local) = (at(&x), gather(nodes, &seen(constraint.means(), &d)));
                let label = format!("{name}: {}, segment {b}", constraint.name());
                assert_close(&label, &[dot(&now.r, &local)], &difference(|s| vec![at(&along(&x, &d, s)).energy]));
                assert_close(&label, &times(&now.k, &local), &difference(|s| at(&along(&x, &d, s)).r));
            }
        }
    });
}

/// The sums: K on the free dofs, `lift` and `carried` along the prescribed ones, the gradient of the rows.
#[test]
fn assembled_tangent_is_the_derivative_of_the_assembled_residual() {
    over_scenes(|name, scene| {
        let system: &System = &scene.system;
        let mut random = Random::seed(6);
        for integrator in INTEGRATORS {
            let n = system.dofs.equation.len();
            let (past, x) = states(integrator, &scene.system, false, &mut random);
            let lambda = [700.0, 9e3];
            let (mut free, mut held) = (random.vector(n, 1.0), random.vector(n, 1.0));
            for p in &system.prescribed {
                free[p.dof as usize] = 0.0;
            }
            system.dofs.free.iter().for_each(|&dof| held[dof as usize] = 0.0);
            let sums = |x: &[f64], want: Want, increment: Option<&[f64]>| {
                let mut out = system.workspace();
                with_at(integrator, &past, x, |at| system.assemble(at, &lambda, want, increment, &mut out))
                    .unwrap_or_else(|e| panic!("{name}: {e}"));
                out
            };
            let now = sums(&x, Want::Tangent, Some(&held));
            let residual = |d: &[f64]| difference(|s| system.restrict(&sums(&along(&x, d, s), Want::Residual, None).r));
            let mut product = vec![0.0; system.dofs.free.len()];
            system.pattern.multiply(&now.k, &system.restrict(&free), &mut product);
            assert_close(&format!("{name}, {integrator:?}: K d"), &product, &residual(&free));
            assert_close(&format!("{name}, {integrator:?}: lift"), &now.increment_force, &residual(&held));
            let row = |d: &[f64]| difference(|s| vec![-sums(&along(&x, d, s), Want::Residual, None).g[0]]);
            let slope = dot(&now.gradient[0], &system.restrict(&free));
            assert_close(&format!("{name}, {integrator:?}: h·d"), &[slope], &row(&free));
            assert!(now.increment_gap[0] != 0.0, "a guide next to the fixed face is carried by it");
            assert_close(&format!("{name}, {integrator:?}: carried"), &now.increment_gap, &row(&held));
        }
    });
}
