//! Contact of deformable surfaces: derivatives at random states, the distances themselves, momentum, symmetry, the limits of stiff
//! and heavy partners, and no crossing, by a test that knows nothing of the code it checks.

use crate::common;
use crate::common::{Random, column, largest, threads};
use durometer::effect::contact::barrier::Barrier;
use durometer::effect::contact::friction::Coulomb;
use durometer::effect::contact::surfaces::friction::SurfaceFriction;
use durometer::effect::contact::surfaces::pressed::PressedSurfaces;
use durometer::effect::contact::surfaces::surface::Surface;
use durometer::effect::contact::surfaces::{Surfaces, Term};
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::boundary::boundary_facets;
use durometer::mesh::element::CELL_FACES;
use durometer::mesh::parts::{image, side_by_side};
use durometer::mesh::structured::block;
use durometer::mesh::{Order, Region, TetMesh};
use durometer::scene::{Body, Checkpoint, Run, RunOptions, Scene, read_scene};
use durometer::solve::Status;
use durometer::system::friction::HISTORY;
use durometer::system::{At, BlockValues, Caches, Effect, Rates, Want};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Two cubes of six cells each, turned at random, near each other.
fn two_cells(random: &mut Random, order: Order) -> TetMesh {
    let mesh = block(1, 1, 1, 1.0, 1.0, 1.0, order);
    let turn = |random: &mut Random| {
        nalgebra::Rotation3::from_euler_angles(random.around(3.0), random.around(1.5), random.around(3.0)).into_inner()
    };
    let (a, b) = (turn(random), turn(random));
    let away = Vec3::new(1.6, 0.0, 0.0) + Vec3::from_fn(|_, _| random.around(0.3));
    let middle = |m: &TetMesh| m.points.iter().sum::<Vec3>() / m.points.len() as f64;
    let centred = |m: TetMesh, to: Vec3| {
        let from = middle(&m);
        image(&m, &nalgebra::Matrix3::identity(), &(to - from))
    };
    let first = centred(image(&mesh, &a, &Vec3::zeros()), Vec3::zeros());
    let second = centred(image(&mesh, &b, &Vec3::zeros()), away);
    let with_skin = |mut m: TetMesh| {
        let facets = boundary_facets(&m);
        m.regions.insert("skin".into(), Region { facets, ..Region::default() });
        m
    };
    side_by_side(&[("a".into(), with_skin(first)), ("b".into(), with_skin(second))]).expect("two")
}

fn pressed(mesh: &TetMesh, reach: f64) -> PressedSurfaces {
    let surface = |name: &str| Surface::new(mesh, &mesh.regions[name].facets);
    let surfaces = Surfaces::new("c".into(), surface("a.skin"), Some(surface("b.skin")), mesh.points.clone(), reach);
    PressedSurfaces::new(surfaces, Barrier { distance: reach, stiffness: 3.0 })
}

/// Energy, force at all nodes, and K, all terms together.
fn whole(pressed: &PressedSurfaces, x: &[f64], want: Want) -> (f64, Vec<f64>, Vec<Vec<f64>>) {
    let n = x.len();
    let rows = if want == Want::Tangent { n } else { 0 };
    let (mut energy, mut r, mut k) = (0.0, vec![0.0; n], vec![vec![0.0; n]; rows]);
    for term in pressed.surfaces.terms(x, &mut Caches::default()).iter() {
        let local = eval(pressed, x, term, want);
        energy += local.energy;
        let dofs: Vec<usize> =
            term.distance.nodes.iter().flat_map(|&k| [0, 1, 2].map(|i| 3 * k as usize + i)).collect();
        for (i, &to) in dofs.iter().enumerate() {
            r[to] += local.r[i];
            if want == Want::Tangent {
                for (j, &from) in dofs.iter().enumerate() {
                    k[to][from] += local.k[i.max(j) * dofs.len() + i.min(j)];
                }
            }
        }
    }
    (energy, r, k)
}

fn eval(pressed: &PressedSurfaces, x: &[f64], term: &Term, want: Want) -> BlockValues {
    let mut local = BlockValues::new(3 * term.distance.nodes.len());
    pressed.add(x, term, want, &mut local).expect("apart");
    local
}

/// r is −∂ of the energy and K is that of r, of everything that two bodies feel, at random states: central differences. Their error is
/// h²/6 of the next derivative but one, which near a corner grows like 1/d², hence the bound of d, and where the nearest feature changes
/// within h, ∂²d jumps: K is compared where it is the same on both sides. All kinds of features and edges that are blunt must occur.
#[test]
fn forces_and_tangents_are_derivatives() {
    let mut random = Random::seed(11);
    let mut kinds = BTreeMap::<String, usize>::new();
    let h = 1e-6;
    for (order, cases) in [(Order::Linear, 60), (Order::Quadratic, 6)] {
        for case in 0..cases {
            let mesh = two_cells(&mut random, order);
            let pressed = pressed(&mesh, 0.6);
            let x = random.vector(3 * mesh.points.len(), 0.02);
            let terms = pressed.surfaces.terms(&x, &mut Caches::default());
            if terms.is_empty() || terms.iter().any(|t| t.distance.gap() < 0.05) {
                continue;
            }
            for t in terms.iter() {
                let kind = match (t.point, t.distance.nodes.len(), t.weight > 0.0) {
                    (None, ..) => "edges".to_string(),
                    (_, n, positive) => format!("{n} nodes, {}", if positive { "+" } else { "-" }),
                };
                *kinds.entry(kind).or_default() += 1;
            }
            let (_, r, k) = whole(&pressed, &x, Want::Tangent);
            let (scale, stiff) = (1.0 + largest(&r), k.iter().map(|row| largest(row)).fold(1.0, larger));
            let at = |dof: usize, s: f64| {
                let mut moved = x.clone();
                moved[dof] += s;
                moved
            };
            for dof in (0..x.len()).filter(|dof| (dof + case) % if order == Order::Linear { 3 } else { 17 } == 0) {
                let (low, high) = (at(dof, -h), at(dof, h));
                let (below, above) = (whole(&pressed, &low, Want::Tangent), whole(&pressed, &high, Want::Tangent));
                let slope = (above.0 - below.0) / (2.0 * h);
                assert!((slope - r[dof]).abs() < 1e-6 * scale, "{order:?} {case}, r[{dof}]: {slope} and {}", r[dof]);
                let jumps = (0..x.len()).any(|i| (above.2[i][dof] - below.2[i][dof]).abs() > 1e-3 * stiff);
                if jumps {
                    continue;
                }
                for (i, row) in k.iter().enumerate() {
                    let (slope, entry) = ((above.1[i] - below.1[i]) / (2.0 * h), row[dof]);
                    assert!(
                        (slope - entry).abs() < 1e-5 * stiff,
                        "{order:?} {case}, K[{i}, {dof}]: {slope} and {entry}"
                    );
                }
            }
            balance(&mesh, &x, &r);
        }
    }
    for kind in ["2 nodes, +", "3 nodes, +", "4 nodes, +", "edges", "9 nodes, +"] {
        assert!(kinds.get(kind).is_some_and(|n| *n > 5), "{kind}: {kinds:?}");
    }
}

/// Forces and moments of all nodes cancel to rounding.
fn balance(mesh: &TetMesh, x: &[f64], r: &[f64]) {
    let force = |k: usize| Vec3::from_column_slice(&r[3 * k..3 * k + 3]);
    let place = |k: usize| mesh.points[k] + Vec3::from_column_slice(&x[3 * k..3 * k + 3]);
    let n = mesh.points.len();
    let total: Vec3 = (0..n).map(force).sum();
    let moment: Vec3 = (0..n).map(|k| place(k).cross(&force(k))).sum();
    let size: f64 = 1.0 + (0..n).map(|k| force(k).norm()).sum::<f64>();
    assert!(total.norm() < 1e-13 * size && moment.norm() < 1e-12 * size, "{total:?} {moment:?} of {size}");
}

/// A point over a flat surface feels one distance wherever it is, over faces, sides and corners: the potential is that of the plane,
/// W b(d)/2, up to the guards of the other bodies' edges. A point over an edge or a corner of a box feels the nearest place once.
#[test]
fn every_point_feels_a_flat_surface_once() {
    let mesh = block(4, 4, 2, 1.0, 1.0, 0.5, Order::Linear);
    let cell = block(1, 1, 1, 0.1, 0.1, 0.1, Order::Linear);
    let mut random = Random::seed(5);
    let barrier = Barrier { distance: 0.1, stiffness: 3.0 };
    let one = |d: f64| if d < 0.1 { -3.0 * (d - 0.1f64).powi(2) * (d / 0.1).ln() } else { 0.0 };
    for _ in 0..300 {
        // A box on its corner
        let turn = nalgebra::Rotation3::from_euler_angles(0.7, 0.6, random.around(3.0)).into_inner();
        let mut tip = image(&cell, &turn, &Vec3::zeros());
        let lowest = tip.points.iter().copied().min_by(|a, b| a.z.total_cmp(&b.z)).expect("nodes");
        let place = match random.unit() {
            u if u < 0.3 => Vec3::new(0.5, 0.5, 0.0),
            u if u < 0.5 => Vec3::new(0.5, random.unit(), 0.0),
            _ => Vec3::new(random.around(0.6) + 0.5, random.around(0.6) + 0.5, 0.0),
        };
        let d = 0.03 + 0.06 * random.unit();
        tip = image(&tip, &nalgebra::Matrix3::identity(), &(place + Vec3::z() * (0.5 + d) - lowest));
        let skin = |mut m: TetMesh| {
            let facets = boundary_facets(&m);
            m.regions.insert("skin".into(), Region { facets, ..Region::default() });
            m
        };
        let both = side_by_side(&[("a".into(), skin(mesh.clone())), ("b".into(), skin(tip))]).expect("two");
        let surface = |name: &str| Surface::new(&both, &both.regions[name].facets);
        let surfaces = Surfaces::new("c".into(), surface("b.skin"), Some(surface("a.skin")), both.points.clone(), 0.1);
        let pressed = PressedSurfaces::new(surfaces, barrier);
        let x = vec![0.0; 3 * both.points.len()];
        let mut sums = BTreeMap::<u32, f64>::new();
        for term in pressed.surfaces.terms(&x, &mut Caches::default()).iter() {
            if let Some((0, point)) = term.point {
                *sums.entry(point).or_default() += eval(&pressed, &x, term, Want::Energy).energy;
            }
        }
        for (k, point) in pressed.surfaces.first().points.iter().enumerate() {
            let beyond = |v: f64, l: f64| (v - v.clamp(0.0, l)).abs();
            let own = point.nodes.iter().zip(&point.weights);
            let p: Vec3 = own.map(|(&k, w)| both.points[k as usize] * *w).sum();
            let d = Vec3::new(beyond(p.x, 1.0), beyond(p.y, 1.0), beyond(p.z, 0.5)).norm();
            let wanted = 0.5 * point.area * one(d);
            let found = sums.get(&(k as u32)).copied().unwrap_or(0.0);
            assert!((found - wanted).abs() < 1e-12 * (1.0 + wanted), "{p:?}: {found} and {wanted}");
        }
    }
}

/// |F_t| ≤ μ N of every term, and both bodies feel the same: the forces of friction balance.
#[test]
fn friction_balances() {
    let mut random = Random::seed(2);
    let mut slid = 0;
    for _ in 0..20 {
        let mesh = two_cells(&mut random, Order::Linear);
        let pressed = Arc::new(pressed(&mesh, 0.6));
        let law = Coulomb { coefficient: 0.4, stick_velocity: 1e-3, slip: 1e-3, most: f64::INFINITY };
        let friction = SurfaceFriction::new("f".into(), pressed.clone(), law);
        let x = random.vector(3 * mesh.points.len(), 0.02);
        let old = random.vector(3 * mesh.points.len(), 0.02);
        let rates = Rates::default();
        let history = random.vector(HISTORY * friction.blocks().len(), 0.5);
        let at = At { t: 0.0, dt: 1.0, x: &x, v: &old, a: &old, old: &old, history: &history, inputs: &[], rates };
        for term in pressed.surfaces.terms(&x, &mut Caches::default()).iter().filter(|t| t.weight > 0.0) {
            let mut local = BlockValues::new(3 * term.distance.nodes.len());
            friction.add(&at, term, Want::Residual, &mut local);
            let Some(press) = pressed.normal_force(&x, term) else { continue };
            let force = |k: usize| Vec3::from_column_slice(&local.r[3 * k..3 * k + 3]);
            let n = term.distance.nodes.len();
            let total: Vec3 = (0..n).map(force).sum();
            assert!(total.norm() < 1e-13 * (1.0 + press.force));
            let own = force(0);
            assert!(own.norm() <= 0.4 * press.force * (1.0 + 1e-12) && own.dot(&press.normal).abs() < 1e-12);
            slid += usize::from(own.norm() > 0.39 * press.force);
        }
    }
    assert!(slid > 20, "{slid}");
}

/// At multiples of 2⁻²⁰ the nodes are exact at both places. Displacements added to far places would be rounded to 6e-11 of a cube, over gaps of a
/// twentieth; seen from the middle of the nodes, only differences of about 1 are rounded.
#[test]
fn forces_do_not_depend_on_the_origin() {
    let mut random = Random::seed(5);
    let mut compared = 0;
    for _ in 0..40 {
        let mut mesh = two_cells(&mut random, Order::Linear);
        mesh.points.iter_mut().for_each(|p| *p = p.map(|v| (v * f64::from(1 << 20)).round() / f64::from(1 << 20)));
        let far = image(&mesh, &nalgebra::Matrix3::identity(), &Vec3::new(3e5, -2e5, 1e5));
        let x = random.vector(3 * mesh.points.len(), 0.02);
        let near = pressed(&mesh, 0.6);
        if near.surfaces.terms(&x, &mut Caches::default()).iter().any(|t| t.distance.gap() < 0.05) {
            continue;
        }
        let [a, b] = [&near, &pressed(&far, 0.6)].map(|p| whole(p, &x, Want::Residual).1);
        let scale = largest(&a);
        compared += usize::from(scale > 0.0);
        for (a, b) in a.iter().zip(&b) {
            assert!((a - b).abs() <= 1e-11 * scale, "{a} {b} {scale}");
        }
    }
    assert!(compared > 10, "{compared}");
}

fn load(text: &str) -> Scene {
    try_load(text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The same, or why it is refused.
fn try_load(text: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).expect("writable");
    let (spec, text) = read_scene(&file, &[]).map_err(|e| e.to_string())?;
    let body = Body::load(&file, &spec.mesh, &mut |_| {}).map_err(|e| e.to_string())?;
    Scene::build(&file, spec, text, Arc::new(body)).map_err(|e| e.to_string())
}

/// Two blocks of 10 mm, `apart` above each other, with different meshes.
fn blocks(lower: [usize; 3], upper: [usize; 3], apart: &str, element: &str, rest: &str) -> Scene {
    load(&text_of_blocks(lower, upper, apart, element, rest))
}

fn text_of_blocks(lower: [usize; 3], upper: [usize; 3], apart: &str, element: &str, rest: &str) -> String {
    format!(
        r#"
[mesh]
element = "{element}"
[[mesh.part]]
name = "lower"
grid = {{ kind = "box", size = ["10 mm", "10 mm", "10 mm"], divisions = {lower:?} }}
[[mesh.part]]
name = "upper"
grid = {{ kind = "box", size = ["10 mm", "10 mm", "10 mm"], divisions = {upper:?} }}
shift = ["0 mm", "0 mm", "{apart}"]
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
{rest}
"#
    )
}

const ELASTIC: &str = "[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n";

fn contact(friction: f64, extra: &str) -> String {
    format!(
        r#"
[[contact]]
name = "between"
region = "upper.skin"
obstacle = {{ kind = "region", region = "lower.skin" }}
response = "barrier"
friction = {friction}
{extra}
"#
    )
}

/// Pressed by 1 mm between walls without friction. (Free edges that lie exactly above each other slip off each other by the reach.)
fn squeezed(lower: [usize; 3], upper: [usize; 3], element: &str, friction: f64, extra: &str) -> Scene {
    let fixed = |region: &str, c: &str| {
        format!("[[constraint]]\nkind = \"fixed\"\nregion = \"{region}\"\ncomponents = \"{c}\"\n")
    };
    let rest = format!(
        r#"{ELASTIC}{}{}{}
[[constraint]]
kind = "prescribed"
region = "upper.zmax"
components = "z"
displacement = {{ kind = "ramp", from = "0 mm", to = "-1.1 mm", end = "1 s" }}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"
[[probe]]
kind = "reaction"
region = "upper.zmax"
{}"#,
        ["xmin", "xmax"].map(|r| fixed(r, "x")).concat(),
        ["ymin", "ymax"].map(|r| fixed(r, "y")).concat(),
        fixed("lower.zmin", "z"),
        contact(friction, extra)
            .replace("skin", "ZZ")
            .replace("upper.ZZ", "upper.zmin")
            .replace("lower.ZZ", "lower.zmax")
    );
    blocks(lower, upper, "10.1 mm", element, &rest)
}

fn last(run: &Run, name: &str) -> f64 {
    *column(run, name).last().expect("a row")
}

/// How often an edge of the deformed surface goes through a triangle of it that shares no node with it: Möller & Trumbore over all
/// pairs; of `two` bodies, which may fold in themselves where no contact is declared, an edge of one and a triangle of the other.
fn crossings(mesh: &TetMesh, x: &[f64], two: bool) -> usize {
    let lower: BTreeSet<u32> =
        if two { mesh.nodes_of(&mesh.regions["lower.body"]).into_iter().collect() } else { BTreeSet::new() };
    let at = |k: u32| mesh.points[k as usize] + Vec3::from_column_slice(&x[3 * k as usize..3 * k as usize + 3]);
    let pieces: &[[usize; 3]] = match mesh.order {
        Order::Linear => &[[0, 1, 2]],
        Order::Quadratic => &[[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]],
    };
    let (mut triangles, mut edges) = (Vec::new(), BTreeSet::new());
    for f in boundary_facets(mesh) {
        let nodes = mesh.facet(f as usize);
        for piece in pieces {
            let t = piece.map(|k| nodes[k]);
            for [i, j] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
                edges.insert([i.min(j), i.max(j)]);
            }
            triangles.push(t);
        }
    }
    let corners: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(at)).collect();
    let through = |[i, j]: &[u32; 2]| {
        let (p, q) = (at(*i), at(*j));
        let hit = |(t, [a, b, c]): (&[u32; 3], &[Vec3; 3])| {
            if t.contains(i) || t.contains(j) || two && lower.contains(i) == lower.contains(&t[0]) {
                return false;
            }
            let (u, v, w) = (b - a, c - a, q - p);
            let normal = w.cross(&v);
            let det = u.dot(&normal);
            let s = (p - a).dot(&normal) / det;
            let r = w.dot(&(p - a).cross(&u)) / det;
            let l = v.dot(&(p - a).cross(&u)) / det;
            det != 0.0 && s >= 0.0 && r >= 0.0 && s + r <= 1.0 && (0.0..=1.0).contains(&l)
        };
        triangles.iter().zip(&corners).filter(|pair| hit(*pair)).count()
    };
    edges.iter().map(through).sum()
}

/// Reference: a uniform stress, in which the interface stays plane. Of the points of one surface each carries p ∫ N_a dA, whatever the mesh; what the
/// other one gets from them is a sum over points instead of an integral, on tet10 with the weights of flat triangles. Where meshes match only the
/// sharp edges at the corners disturb it. The force is that of the reaction. Bounds: a few times what was measured, which is what is claimed.
#[test]
fn a_uniform_pressure_through_meshes_that_do_not_match() {
    for (element, lower, upper, bound, pressed) in [
        ("tet4", [3, 3, 3], [3, 3, 3], 2e-3, 0.9),
        ("tet4", [3, 3, 3], [4, 4, 3], 1e-2, 0.9),
        ("tet10", [2, 2, 2], [3, 3, 2], 5e-2, 0.7),
    ] {
        let scene = squeezed(lower, upper, element, 0.0, "");
        let run = common::run(&scene);
        assert_eq!(run.status, Status::Converged, "{element}");
        let (force, held) = (last(&run, "between_force_z_N"), last(&run, "upper.zmax_reaction_z_N"));
        // The tolerance of the equilibrium: 1e-8 of the sum of all forces, some hundred times that of the interface.
        assert!((force / -held - 1.0).abs() < 1e-6, "{element}: {force} {held}");
        // The whole face, 10 × 10 mm, as far as its points press: on tet10 those within the facets of the other mesh lift off. Guards have no area.
        let area = last(&run, "between_area_m2") / 1e-4;
        assert!(area > pressed && area < 1.0 + 1e-9, "{element}: {area}");
        // In uniform stress the interface stays plane; it is shortened by 1 mm.
        let mesh = &scene.body.mesh;
        let uz = |k: u32| run.last.x[3 * k as usize + 2];
        let plane = |name: &str| mesh.nodes_of(&mesh.regions[name]);
        let size = 1e-3;
        let even = |name: &str| {
            let nodes = plane(name);
            let mean = nodes.iter().map(|&k| uz(k)).sum::<f64>() / nodes.len() as f64;
            nodes.iter().map(|&k| (uz(k) - mean).abs()).fold(0.0, larger) / size
        };
        let uneven = larger(even("lower.zmax"), even("upper.zmin"));
        println!(
            "{element} {lower:?} {upper:?}: uneven by {uneven:.2e} of the shortening, {} iterations",
            run.totals.iterations
        );
        assert!(uneven < bound, "{element} {lower:?} {upper:?}: {uneven:.2e}");
        assert_eq!(crossings(mesh, &run.last.x, true), 0);
    }
}

/// Friction acts within the plane; both surfaces carry a half of the pressure.
#[test]
fn the_normal_force_is_that_of_both_surfaces() {
    let run = common::run(&squeezed([2, 2, 2], [3, 3, 2], "tet4", 0.3, ""));
    assert_eq!(run.status, Status::Converged);
    let (force, normal) = (last(&run, "between_force_z_N"), last(&run, "between_normal_z_N"));
    assert!(force > 0.1 && (normal / force - 1.0).abs() < 1e-3, "{normal} {force}");
}

/// Surfaces that begin within `distance` are noted with the force of the first row, which is along z; beyond it nothing is noted.
#[test]
fn a_start_within_the_reach_is_noted() {
    let start = |apart: &str| {
        let rest = "[[constraint]]\nkind = \"fixed\"\nregion = \"lower.zmin\"\n[[constraint]]\nkind = \"fixed\"\nregion = \"upper.zmax\"\n\
                    [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n";
        let plates = contact(0.0, "distance = \"0.1 mm\"\nmodulus = \"1 kPa\"")
            .replace("upper.skin", "upper.zmin")
            .replace("lower.skin", "lower.zmax");
        let scene = blocks([2, 2, 2], [3, 3, 2], apart, "tet4", &[ELASTIC, &plates, rest].concat());
        let force = column(&common::run(&scene), "between_force_z_N")[0];
        let notes = scene.notes.into_iter().filter(|note| note.contains("reach of the barrier"));
        (notes.collect::<Vec<String>>(), force)
    };
    let (notes, force) = start("10.05 mm");
    let [note] = &notes[..] else { panic!("{notes:?}") };
    assert!(note.starts_with("between: ") && note.contains("gap 0.0500 mm, distance 0.1000 mm"), "{note}");
    let said = note.split("a force of ").nth(1).and_then(|n| n.strip_suffix(" N")).expect("a force");
    let said: f64 = said.parse().expect("a number");
    assert!(force > 0.0 && (said / force - 1.0).abs() < 1e-3, "{said} N for {force} N");
    assert_eq!(start("10.11 mm").0, Vec::<String>::new());
}

/// A rigid part in the upper block, 5 mm above its lower side: it holds no node that is in contact. One that reaches this side is refused. A load of 1 N
/// on it is carried by the contact.
#[test]
fn a_body_with_a_rigid_part_rests_on_another() {
    let sideways = "[[constraint]]\nkind = \"fixed\"\nregion = \"upper.zmin\"\ncomponents = \"xy\"";
    let with_part = |from: &str, sideways: &str| {
        let rest = format!(
            r#"{ELASTIC}
[mesh.regions.part]
kind = "box"
min = ["-1 mm", "-1 mm", "{from}"]
max = ["11 mm", "11 mm", "30 mm"]
pick = "cells"
rule = "all"
[[constraint]]
kind = "fixed"
region = "lower.zmin"
{sideways}
[[constraint]]
kind = "rigid"
region = "part"
[[effect]]
kind = "traction"
region = "upper.zmax"
direction = [0, 0, -1]
traction = {{ kind = "ramp", from = "0 kPa", to = "10 kPa", end = "1 s" }}
{}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"
[numerics]
max_iterations = 200
"#,
            contact(0.3, "distance = \"0.1 mm\"")
                .replace("upper.skin", "upper.zmin")
                .replace("lower.skin", "lower.zmax")
        );
        try_load(&text_of_blocks([2, 2, 2], [3, 3, 4], "10.09 mm", "tet4", &rest))
    };
    let run = common::run(&with_part("14 mm", sideways).unwrap_or_else(|e| panic!("{e}")));
    assert_eq!(run.status, Status::Converged);
    let force = last(&run, "between_force_z_N");
    assert!((force - 1.0).abs() < 1e-5, "{force} N");
    let told = with_part("10 mm", "").err().expect("refused");
    assert!(told.contains("acts on the nodes of a rigid part (between)"), "{told}");
}

/// A block whose partner is a thousand times stiffer, and ten thousand times, feels what a rigid floor is: the difference of the
/// forces is that of the strain of the partner, 1/ratio, apart from a thousandth by the two methods of weighting the gap.
#[test]
fn a_stiff_partner_is_a_rigid_obstacle() {
    let laws = |ratio: f64| {
        format!(
            r#"
[laws.stiff]
law = "neo_hookean"
E = "{} kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "upper.body"
law = "rubber"
[[effect]]
kind = "elastic"
region = "lower.body"
law = "stiff"
[[constraint]]
kind = "fixed"
region = "lower.zmin"
[[constraint]]
kind = "fixed"
region = "upper.zmax"
components = "xy"
[[constraint]]
kind = "prescribed"
region = "upper.zmax"
components = "z"
displacement = {{ kind = "ramp", from = "0 mm", to = "-1.1 mm", end = "1 s" }}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"
"#,
            100.0 * ratio
        )
    };
    let force = |ratio: f64, obstacle: &str| {
        let met = contact(0.0, "modulus = \"100 kPa\"\ndistance = \"0.02 mm\"").replace("upper.skin", "upper.zmin");
        let met = met.replace("kind = \"region\", region = \"lower.skin\"", obstacle);
        let scene = blocks([3, 3, 3], [4, 4, 3], "10.1 mm", "tet4", &(laws(ratio) + &met));
        let run = common::run(&scene);
        assert_eq!(run.status, Status::Converged, "{ratio} {obstacle}");
        last(&run, "between_force_z_N")
    };
    let floor = "kind = \"floor\", point = [\"0 mm\", \"0 mm\", \"10 mm\"], normal = [0, 0, 1]";
    let rigid = force(1.0, floor);
    let error = |ratio: f64| (force(ratio, "kind = \"region\", region = \"lower.skin\"") / rigid - 1.0).abs();
    let (soft, stiff) = (error(10.0), error(1e3));
    println!("off by {soft:.2e} at 10, {stiff:.2e} at 1000");
    assert!(stiff < 3e-3 && stiff < 0.1 * soft, "{soft} {stiff}");
}

/// The upper block, so many times heavier, is thrown at the lower one; both are free.
fn impact(ratio: f64, friction: f64) -> Scene {
    let inertia = |region: &str, density: f64| {
        format!(
            "[[effect]]\nkind = \"inertia\"\nregion = \"{region}\"\ndensity = \"{density} kg/m^3\"\nmass = \"lumped\"\n"
        )
    };
    let rest = format!(
        r#"{ELASTIC}{}{}{}
[start]
kind = "moving"
region = "upper.body"
velocity = ["0.05 m/s", "0.1 m/s", "-1 m/s"]
[[stage]]
integrator = "implicit_euler"
duration = "3 ms"
dt = "0.1 ms"
[[probe]]
kind = "energy"
[numerics]
max_iterations = 200
tolerance = 1e-11
"#,
        inertia("lower.body", 1000.0),
        inertia("upper.body", 1000.0 * ratio),
        contact(friction, ""),
    );
    blocks([2, 2, 2], [3, 3, 3], "10.5 mm", "tet4", &rest)
}

/// Two blocks that hit each other, the upper one fast and with a spin of its shape: momentum stays to 1e-8 of that of the first state, and
/// no energy comes from the contact; equal masses and a thousandfold one.
#[test]
fn momentum_stays_and_energy_does_not_grow() {
    for (ratio, friction) in [(1.0, 0.0), (1e3, 0.3)] {
        let scene = impact(ratio, friction);
        let mut momentum = Vec::<Vec3>::new();
        let masses = masses(&scene.body.mesh, ratio);
        let mut take = |state: &durometer::system::State| {
            let v = |k: usize| Vec3::from_column_slice(&state.v[3 * k..3 * k + 3]);
            momentum.push(masses.iter().enumerate().map(|(k, m)| v(k) * *m).sum());
        };
        let run = common::run_with_states(&scene, &mut take);
        assert_eq!(run.status, Status::Converged, "{ratio}");
        assert!(column(&run, "between_points").iter().any(|n| *n > 0.0));
        let first = momentum[0];
        let drift = momentum.iter().map(|p| (p - first).norm() / first.norm()).fold(0.0, larger);
        assert!(drift < 1e-8, "{ratio}: {drift:.1e}");
        let [elastic, kinetic] = ["elastic_J", "kinetic_J"].map(|c| column(&run, c));
        // ½ m v² of the upper block, whose volume is 1 cm³.
        let whole = 0.5e-3 * ratio * (1.0 + 0.1f64.powi(2) + 0.05f64.powi(2));
        let worst = elastic.iter().zip(&kinetic).map(|(e, k)| (e + k) / whole).fold(0.0, larger);
        assert!(worst < 1.0 + 1e-8, "{ratio}: {worst}");
        println!("mass ratio {ratio}: momentum {drift:.1e}, energy {worst:.6}, {} iterations", run.totals.iterations);
        assert_eq!(crossings(&scene.body.mesh, &run.last.x, true), 0);
    }
}

/// A quarter of each cell to its nodes.
fn masses(mesh: &TetMesh, ratio: f64) -> Vec<f64> {
    let mut masses = vec![0.0; mesh.points.len()];
    let upper: BTreeSet<u32> = mesh.regions["upper.body"].cells.iter().copied().collect();
    for c in 0..mesh.cell_count() {
        let density = if upper.contains(&(c as u32)) { 1000.0 * ratio } else { 1000.0 };
        mesh.cell(c).iter().for_each(|&k| masses[k as usize] += 0.25 * density * mesh.cell_volume(c));
    }
    masses
}

/// Random drops of a turned block on another, with corners and edges first: nothing crosses, on both elements.
#[test]
fn nothing_crosses_in_random_drops() {
    let mut random = Random::seed(9);
    for case in 0..6 {
        let element = if case < 5 { "tet4" } else { "tet10" };
        let (axis, angle) = ([random.around(1.0), random.around(1.0), random.around(1.0)], 180.0 * random.unit());
        let away = [random.around(4.0), random.around(4.0)];
        let n = if element == "tet4" { 2 } else { 1 };
        let text = format!(
            r#"
[mesh]
element = "{element}"
[[mesh.part]]
name = "lower"
grid = {{ kind = "box", size = ["10 mm", "10 mm", "10 mm"], divisions = [{n}, {n}, {n}] }}
shift = ["-5 mm", "-5 mm", "-10 mm"]
[[mesh.part]]
name = "upper"
grid = {{ kind = "box", size = ["6 mm", "6 mm", "6 mm"], divisions = [{n}, {n}, {n}] }}
turn = {{ axis = {axis:?}, angle = "{angle} deg" }}
shift = ["{} mm", "{} mm", "11 mm"]
[laws.rubber]
law = "neo_hookean"
E = "50 kPa"
nu = 0.3
{ELASTIC}
[[effect]]
kind = "inertia"
region = "body"
density = "1000 kg/m^3"
mass = "consistent"
[[constraint]]
kind = "fixed"
region = "lower.zmin"
[start]
kind = "moving"
region = "upper.body"
velocity = ["0 m/s", "0 m/s", "-4 m/s"]
[[stage]]
integrator = "implicit_euler"
duration = "6 ms"
dt = "0.2 ms"
{}
[numerics]
max_iterations = 200
"#,
            away[0],
            away[1],
            contact(0.2, "")
        );
        let scene = load(&text);
        let (mut crossed, mut states) = (0, 0);
        let mut take = |state: &durometer::system::State| {
            states += 1;
            if states % 4 == 0 {
                crossed += crossings(&scene.body.mesh, &state.x, true);
            }
        };
        let run = common::run_with_states(&scene, &mut take);
        assert_eq!(run.status, Status::Converged, "{case}");
        assert_eq!(crossed + crossings(&scene.body.mesh, &run.last.x, true), 0, "{case}");
        assert!(column(&run, "between_points").iter().any(|n| *n > 0.0), "{case}: no contact");
    }
}

/// The cells of a mesh whose middle is kept, with the boundary as the region `skin`.
fn carved(mesh: &TetMesh, keep: impl Fn(Vec3) -> bool) -> TetMesh {
    let middle = |c: usize| mesh.position(c, [0.25; 3]);
    let cells: Vec<u32> =
        (0..mesh.cell_count()).filter(|&c| keep(middle(c))).flat_map(|c| mesh.cell(c).to_vec()).collect();
    let used: BTreeSet<u32> = cells.iter().copied().collect();
    let number: BTreeMap<u32, u32> = used.iter().copied().zip(0..).collect();
    let points = used.iter().map(|&k| mesh.points[k as usize]).collect();
    let cells: Vec<u32> = cells.iter().map(|k| number[k]).collect();
    let n = mesh.order.cell_nodes();
    let mut faces = BTreeMap::<[u32; 3], Vec<Vec<u32>>>::new();
    for cell in cells.chunks_exact(n) {
        for face in CELL_FACES {
            let nodes: Vec<u32> = face[..mesh.order.facet_nodes()].iter().map(|&k| cell[k]).collect();
            let mut key = [nodes[0], nodes[1], nodes[2]];
            key.sort_unstable();
            faces.entry(key).or_default().push(nodes);
        }
    }
    let facets: Vec<u32> = faces.into_values().filter(|f| f.len() == 1).flatten().flatten().collect();
    let count = (facets.len() / mesh.order.facet_nodes()) as u32;
    let all = Region { cells: (0..(cells.len() / n) as u32).collect(), ..Region::default() };
    let skin = Region { facets: (0..count).collect(), ..Region::default() };
    let regions = BTreeMap::from([("body".to_string(), all), ("skin".to_string(), skin)]);
    TetMesh { order: mesh.order, points, cells, facets, regions }
}

/// Two blocks 5 mm apart whose surface is in contact with itself: the gap is that between the blocks, not that of facets next to each other.
#[test]
fn the_gap_of_self_contact_is_that_of_facing_parts() {
    for (element, lower, upper) in [("tet4", [4, 4, 4], [5, 5, 5]), ("tet10", [2, 2, 2], [3, 3, 3])] {
        let held = |region: &str| format!("[[constraint]]\nkind = \"fixed\"\nregion = \"{region}\"\n");
        let rest = format!(
            "{ELASTIC}{}{}{}\n[[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n",
            held("lower.zmin"),
            held("upper.zmax"),
            contact(0.0, "").replace("upper.skin", "skin").replace("lower.skin", "skin")
        );
        let run = common::run(&blocks(lower, upper, "15 mm", element, &rest));
        let gap = column(&run, "between_gap_m")[0];
        assert!((gap - 5e-3).abs() < 1e-12, "{element}: {gap}");
    }
}

/// A U whose legs are pressed together by 5 mm over a gap of 3 mm: it closes on itself, and the two legs stay mirror images in their forces.
fn closing(order: Order, friction: f64) -> Scene {
    let grid = block(5, 1, 6, 0.015, 0.004, 0.018, order);
    let mesh = carved(&grid, |p| p.z < 0.003 || !(0.006..0.009).contains(&p.x));
    let top = |name: &str, x: f64| {
        format!(
            "[mesh.regions.{name}]\nkind = \"box\"\nmin = [\"{} mm\", \"-1 mm\", \"14 mm\"]\nmax = [\"{} mm\", \"9 mm\", \"19 mm\"]\n",
            x - 0.1,
            x + 0.1
        )
    };
    let push = |region: &str, to: f64| {
        format!(
            "[[constraint]]\nkind = \"prescribed\"\nregion = \"{region}\"\ncomponents = \"x\"\ndisplacement = {{ kind = \"ramp\", from = \"0 mm\", to = \"{to} mm\", end = \"1 s\" }}\n"
        )
    };
    let text = format!(
        r#"
[mesh]
body = "block"
{}{}
[mesh.regions.foot]
kind = "box"
min = ["-1 mm", "-1 mm", "-1 mm"]
max = ["99 mm", "99 mm", "0.1 mm"]
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
{ELASTIC}
[[constraint]]
kind = "fixed"
region = "foot"
{}{}
[[contact]]
name = "itself"
region = "skin"
obstacle = {{ kind = "region", region = "skin" }}
response = "barrier"
friction = {friction}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.1 s"
[[probe]]
kind = "reaction"
region = "left"
[[probe]]
kind = "reaction"
region = "right"
[numerics]
max_iterations = 100
"#,
        top("left", 0.0),
        top("right", 15.0),
        push("left", 2.5),
        push("right", -2.5)
    );
    common::scene(mesh, &text)
}

#[test]
fn a_body_that_closes_on_itself_does_not_cross() {
    // With friction the quadratic one stops at 94 % of the way, where sharp edges of the legs slide on each other.
    for (order, friction) in [(Order::Linear, 0.2), (Order::Quadratic, 0.0)] {
        let scene = closing(order, friction);
        let mut crossed = 0;
        let run = common::run_with_states(&scene, &mut |state| crossed += crossings(&scene.body.mesh, &state.x, false));
        assert_eq!(run.status, Status::Converged, "{order:?}");
        assert_eq!(crossed, 0, "{order:?}");
        assert!(last(&run, "itself_points") > 0.0, "{order:?}: the legs do not meet");
        let gap = column(&run, "itself_gap_m");
        assert!((gap[0] - 3e-3).abs() < 1e-12, "{order:?}: the legs are 3 mm apart, not {} m", gap[0]);
        // What a body does to itself balances; the legs push back alike, up to a mesh that is no mirror image.
        assert!(last(&run, "itself_force_x_N").abs() < 1e-9 * last(&run, "left_reaction_x_N").abs());
        let balance = last(&run, "left_reaction_x_N") / -last(&run, "right_reaction_x_N");
        assert!((balance - 1.0).abs() < 0.2, "{order:?}: {balance}");
    }
}

/// The same bits from one thread and from three, and from a run that is made twice: 450 cells of 30 unknowns are several groups, which threads share.
#[test]
fn thread_counts_do_not_matter() {
    let scene = squeezed([3, 3, 3], [4, 4, 3], "tet10", 0.0, "");
    let bits = |count: usize| {
        let run = threads::on(count, || common::run(&scene));
        assert_eq!(run.status, Status::Converged);
        run.last.x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>()
    };
    let one = bits(1);
    assert_eq!(one, bits(3));
    assert_eq!(one, bits(1));
}

/// A run that goes on from any point of its grid has the bits of the whole run: the room in the tangent follows from the state.
#[test]
fn a_restart_has_the_bits_of_the_whole_run() {
    let scene = squeezed([2, 2, 2], [3, 3, 2], "tet4", 0.0, "");
    let whole = common::run(&scene);
    let mut checkpoints = Vec::new();
    let mut saved = |checkpoint: &Checkpoint, _: &str| checkpoints.push(checkpoint.clone());
    let save_at = whole.rows.iter().map(|row| row[0]).collect();
    let options = RunOptions { save_at, on_save: Some(&mut saved), ..RunOptions::default() };
    scene.run_with(options);
    assert_eq!(checkpoints.len(), whole.rows.len());
    for from in checkpoints {
        let options = RunOptions { restart: Some(from), ..RunOptions::default() };
        let again = scene.run_with(options);
        let bits = |run: &Run| run.last.x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert!(again.status == Status::Converged && bits(&again) == bits(&whole));
        assert_eq!(again.rows, whole.rows);
    }
}

/// Two equal blocks with meshes that are mirror images in the plane between them move as mirror images, up to the tolerance of the equilibrium.
#[test]
fn symmetric_blocks_stay_symmetric() {
    let scene = load(&format!(
        r#"
[mesh]
grid = {{ kind = "box", size = ["10 mm", "10 mm", "10 mm"], divisions = [3, 3, 3] }}
[[mesh.part]]
name = "upper"
shift = ["0 mm", "0 mm", "0.05 mm"]
[[mesh.part]]
name = "lower"
mirror = [0, 0, 1]
shift = ["0 mm", "0 mm", "-0.05 mm"]
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.4
{ELASTIC}
[[constraint]]
kind = "fixed"
region = "zmax"
components = "xy"
[[constraint]]
kind = "prescribed"
region = "upper.zmax"
components = "z"
displacement = {{ kind = "ramp", from = "0 mm", to = "-1 mm", end = "1 s" }}
[[constraint]]
kind = "prescribed"
region = "lower.zmax"
components = "z"
displacement = {{ kind = "ramp", from = "0 mm", to = "1 mm", end = "1 s" }}
{}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"
"#,
        contact(0.3, "")
    ));
    let run = common::run(&scene);
    assert_eq!(run.status, Status::Converged);
    let n = scene.body.mesh.points.len() / 2;
    let size = largest(&run.last.x);
    for k in 0..n {
        let (u, v) = (&run.last.x[3 * k..3 * k + 3], &run.last.x[3 * (k + n)..3 * (k + n) + 3]);
        let away = largest(&[u[0] - v[0], u[1] - v[1], u[2] + v[2]]);
        assert!(away < 1e-6 * size, "node {k}: {away:.1e}");
    }
    assert!(last(&run, "between_force_z_N") > 0.1);
}
