//! Concave edges of a surface of triangles: a point meets each side, as if each were an obstacle of its own.

use crate::common::{Random, column, run};
use crate::surface::write;
use durometer::effect::contact::shape::Shape;
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::surface_file::Surface;
use durometer::scene::{Run, Scene, parse_scene};
use durometer::solve::Status;
use std::collections::BTreeMap;

/// A block, 80 mm wide and 120 mm long, with a groove of this slope along y, 40 mm wide, at its top; the bottom of the groove is the y axis.
pub fn groove(slope: f64) -> Surface {
    let high = 20.0 * slope;
    let profile = [(-40.0, -30.0), (40.0, -30.0), (40.0, high), (20.0, high), (0.0, 0.0), (-20.0, high), (-40.0, high)];
    let cap = [[0, 1, 4], [1, 2, 3], [1, 3, 4], [0, 4, 5], [0, 5, 6]];
    extruded(&profile, &cap)
}

/// A plate that is 110 mm wide and 120 mm long, its top at z = 0, with a wall of 30 mm at its end, from x = 40 mm on.
fn tray() -> Surface {
    let profile = [(-60.0, -10.0), (50.0, -10.0), (50.0, 30.0), (40.0, 30.0), (40.0, 0.0), (-60.0, 0.0)];
    extruded(&profile, &[[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]])
}

/// A prism from y = −60 mm to 60 mm with a profile in x and z \[mm\], of which `cap` are the triangles.
fn extruded(profile: &[(f64, f64)], cap: &[[u32; 3]]) -> Surface {
    let n = profile.len() as u32;
    let end = |y: f64| profile.iter().map(move |&(x, z)| Vec3::new(x, y, z) * 1e-3);
    let sides = (0..n).map(|k| (k, (k + 1) % n)).flat_map(|(i, j)| [[i, n + i, n + j], [i, n + j, j]]);
    let caps = cap.iter().flat_map(|&[a, b, c]| [[a, b, c], [n + a, n + c, n + b]]);
    Surface { points: end(-60.0).chain(end(60.0)).collect(), triangles: sides.chain(caps).collect() }
}

/// The cubes of 1 mm from the origin on, of these numbers each way, that are solid.
fn cubes([nx, ny, nz]: [i32; 3], is_solid: impl Fn(i32, i32, i32) -> bool) -> Surface {
    let solid =
        |[i, j, k]: [i32; 3]| (0..nx).contains(&i) && (0..ny).contains(&j) && (0..nz).contains(&k) && is_solid(i, j, k);
    let (mut surface, mut places) = (Surface::default(), BTreeMap::new());
    for (i, j, k, axis, up) in (0..nx * ny * nz * 6)
        .map(|f| (f % nx, f / nx % ny, f / (nx * ny) % nz, (f / (nx * ny * nz) % 3) as usize, f / (nx * ny * nz) / 3))
    {
        let cube = [i, j, k];
        let mut next = cube;
        next[axis] += 2 * up - 1;
        if !solid(cube) || solid(next) {
            continue;
        }
        let mut corner = |a: i32, b: i32| {
            let mut at = cube;
            at[axis] += up;
            at[(axis + 1) % 3] += a;
            at[(axis + 2) % 3] += b;
            *places.entry(at).or_insert_with(|| {
                surface.points.push(Vec3::from_fn(|i, _| 1e-3 * f64::from(at[i])));
                surface.points.len() as u32 - 1
            })
        };
        let mut corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
        if up == 0 {
            corners.reverse();
        }
        let [a, b, c, d] = corners;
        surface.triangles.extend([[a, b, c], [a, c, d]]);
    }
    surface
}

fn shape(surface: &Surface) -> Shape {
    Shape::surface(surface).expect("closed and outward")
}

/// Distances of a point, ascending.
fn distances(shape: &Shape, y: &Vec3) -> Vec<f64> {
    let mut gaps: Vec<f64> = shape.contacts(y, 0.0).iter().map(|(_, witness)| witness.gap).collect();
    gaps.sort_by(f64::total_cmp);
    gaps
}

/// Asserts that these are the distances of a point that are less than `reach`, to rounding of lengths of 100 mm.
fn assert_distances(shape: &Shape, y: &Vec3, mut expected: Vec<f64>, reach: f64) {
    expected.sort_by(f64::total_cmp);
    let mut found = distances(shape, y);
    found.retain(|gap| *gap < reach);
    expected.retain(|gap| *gap < reach);
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-15;
    assert!(
        found.len() == expected.len() && found.iter().zip(&expected).all(is_near),
        "{y:?}: {found:?} for {expected:?}"
    );
}

/// In a groove of 147°, 90° and 44° a point has the distances from the planes of both sides, in front of them, behind one or both, and beyond the end of the
/// triangle of either.
#[test]
fn a_point_in_a_groove_has_the_distances_of_both_sides() {
    let mut random = Random::seed(5);
    for slope in [0.3, 1.0, 2.5] {
        let groove = shape(&groove(slope));
        assert_eq!(groove.sheets(), 3);
        let [left, right] = [1.0, -1.0].map(|x| Vec3::new(slope * x, 0.0, 1.0).normalize());
        for _ in 0..1000 {
            let y = Vec3::from_fn(|_, _| random.around(0.002));
            assert_distances(&groove, &y, vec![left.dot(&y), right.dot(&y)], 5e-3);
        }
    }
}

/// In the corner of a box the three distances from its sides, whatever the point is in front of.
#[test]
fn a_point_in_a_corner_has_three_distances() {
    let mut random = Random::seed(6);
    let corner = shape(&cubes([2, 2, 2], |i, j, k| [i, j, k] != [1; 3]));
    for _ in 0..1000 {
        let y = Vec3::from_fn(|_, _| random.around(2e-4));
        assert_distances(&corner, &(y + Vec3::repeat(1e-3)), y.iter().copied().collect(), 1.0);
    }
}

/// Between the walls of a slot it has the distances from both, and from its floor.
#[test]
fn a_point_in_a_slot_has_three_distances() {
    let mut random = Random::seed(11);
    let slot = shape(&cubes([3, 5, 2], |i, _, k| k == 0 || i != 1));
    for _ in 0..1000 {
        let y = Vec3::new(random.around(6e-4), random.around(2e-3), random.around(2e-4));
        let expected = vec![5e-4 - y.x, 5e-4 + y.x, y.z];
        assert_distances(&slot, &(y + Vec3::new(1.5e-3, 2.5e-3, 1e-3)), expected, 1.0);
    }
}

/// Next to a post on a floor a point has the distance from the floor and that from the nearest place of the post, which may be its edge: also where the point is
/// below the floor by a little, where the post ends.
#[test]
fn a_post_goes_on_into_its_floor() {
    let mut random = Random::seed(7);
    let post = shape(&cubes([5, 5, 3], |i, j, k| k == 0 || (i, j) == (2, 2)));
    for _ in 0..1000 {
        let y = Vec3::new(random.around(4e-4), random.around(4e-4), random.around(1e-4));
        let beyond = [y.x.max(0.0), y.y.max(0.0)];
        if y.x.max(y.y) < 0.0 {
            continue;
        }
        let from_post = beyond[0].hypot(beyond[1]);
        assert_distances(&post, &(y + Vec3::new(3e-3, 3e-3, 1e-3)), vec![y.z, from_post], 1.0);
    }
}

/// Beyond the end of a groove a point has the distances from the edges of both of its sides, the nearer one and the other one alike.
#[test]
fn a_point_beyond_the_end_of_a_groove_has_two_distances() {
    let mut random = Random::seed(10);
    for groove in [groove(1.0), groove(2.5)] {
        let (shape, up) = (shape(&groove), Vec3::new(1.0, 0.0, groove.points[3].z / 0.02).normalize());
        for k in 0..1000 {
            let across = if k % 2 == 0 { 0.0 } else { random.around(1e-3) };
            let y = Vec3::new(across, 0.0605 + random.around(4e-4), 0.01);
            let from_edge = |x: f64| {
                let edge = Vec3::new(x * up.x, 0.0, up.z);
                let away = y - Vec3::new(0.0, 0.06, 0.0);
                (away - edge * edge.dot(&away)).norm()
            };
            assert_distances(&shape, &y, vec![from_edge(1.0), from_edge(-1.0)], 9e-3);
        }
    }
}

/// In the plane of a side, beyond the end of its sheet, no distance is that of a point inside: on the line of the concave edge of the tray, and in the planes of
/// its floor and of its wall, in front of the solid, of the hollow, and next to them.
#[test]
fn a_point_in_the_plane_of_a_side_is_outside() {
    let tray = shape(&tray());
    for away in [1e-9, 1e-5, 0.5e-3, 30e-3] {
        for y in [60e-3 + away, -60e-3 - away] {
            for (x, z) in
                [(40.0, 0.0), (40.0, -4.0), (40.0, 12.0), (45.0, 0.0), (-17.0, 0.0), (40.0, 1e-6), (40.0 - 1e-6, 0.0)]
            {
                let at = Vec3::new(1e-3 * x, y, 1e-3 * z);
                let found = distances(&tray, &at);
                let least = found[0];
                assert!((least / away - 1.0).abs() < 1e-6 || (least - away).abs() < 1e-13, "{at:?}: {found:?}");
            }
        }
    }
}

/// At convex edges, also where two sheets end, and everywhere else outside the nearest contact is the distance of the surface, and next to its surface away from
/// concave edges there is no other one.
#[test]
fn convex_edges_have_one_contact() {
    let mut random = Random::seed(8);
    for (surface, reach) in [(groove(1.0), 5e-3), (tray(), 5e-3)] {
        let shape = shape(&surface);
        let [low, high] = shape.bounds().expect("it has an end");
        let mut near = 0;
        while near < 2000 {
            let y = Vec3::from_fn(|i, _| {
                let (middle, half) = ((low[i] + high[i]) / 2.0, (high[i] - low[i]) / 2.0);
                middle + random.around(1.0) * (half + 2.0 * reach)
            });
            let gap = shape.gap(&y);
            let (x, z) = (y.x, y.z);
            let in_edge = |a: f64, b: f64| (x - a).hypot(z - b) < 3.0 * reach;
            if gap.abs() > reach || in_edge(0.0, 0.0) || in_edge(0.04, 0.0) {
                continue;
            }
            near += 1;
            assert_distances(&shape, &y, vec![gap], reach);
        }
    }
}

/// Outside of whatever surface, with edges that meet in all ways, the nearest contact has the distance of the surface.
#[test]
fn the_nearest_contact_has_the_distance() {
    let (mut random, mut seen) = (Random::seed(12), 0);
    while seen < 60 {
        let heights: Vec<f64> = (0..16).map(|_| 2.0 + random.around(1.5)).collect();
        let field = cubes([4, 4, 3], |i, j, k| f64::from(k) < heights[(i + 4 * j) as usize] - 0.5);
        // Cubes that have only an edge in common are no surface.
        let Ok(shape) = Shape::surface(&field) else { continue };
        seen += 1;
        for _ in 0..200 {
            let y = Vec3::new(2e-3, 2e-3, 1.5e-3) + Vec3::from_fn(|_, _| random.around(2.3e-3));
            let gap = shape.gap(&y);
            let least = distances(&shape, &y)[0];
            assert!(gap < 0.0 || (least - gap).abs() < 1e-15, "{y:?}: {least} for {gap}");
        }
    }
}

/// A ring of this many parts around, from the radius 1 to 2 mm.
fn ring(parts: u32) -> Surface {
    let point = |k: u32| {
        let (around, corner) = (std::f64::consts::TAU * f64::from(k / 4) / f64::from(parts), k % 4);
        let (radius, z) = ([1e-3, 2e-3, 2e-3, 1e-3][corner as usize], [0.0, 0.0, 1e-3, 1e-3][corner as usize]);
        Vec3::new(radius * around.cos(), radius * around.sin(), z)
    };
    let triangles = (0..4 * parts).flat_map(|k| {
        let next = |k: u32| (k + 4) % (4 * parts);
        let other = k / 4 * 4 + (k + 1) % 4;
        [[k, next(k), other], [other, next(k), next(other)]]
    });
    Surface { points: (0..4 * parts).map(point).collect(), triangles: triangles.collect() }
}

/// What is convex is one sheet, and what is hollow, where it is triangulated so finely that its facets turn by less than 20°.
#[test]
fn convex_and_smooth_surfaces_have_one_contact() {
    let convex = [Shape::cuboid(Vec3::repeat(1.0)), Shape::sphere(1.0), Shape::cylinder(1.0, 1.0)];
    for surface in convex.iter().filter_map(|shape| shape.triangles(24)) {
        assert_eq!(shape(&surface).sheets(), 1);
    }
    assert_eq!([24, 12].map(|parts| shape(&ring(parts)).sheets() > 1), [false, true]);
}

/// A rigid body, on which only these obstacles act.
struct Thrown<'a> {
    /// Shape and velocity
    body: &'a str,
    obstacles: &'a [String],
    response: &'a str,
    friction: f64,
    integrator: &'a str,
    seconds: f64,
}

impl Thrown<'_> {
    fn scene(&self) -> Scene {
        let Self { body, obstacles, response, friction, integrator, seconds } = self;
        let contact = |(k, obstacle): (usize, &String)| {
            format!(
                "[[contact]]\nname = \"c{k}\"\nregion = \"body_in_it\"\nobstacle = {obstacle}\nresponse = \"{response}\"\nfriction = {friction}\n"
            )
        };
        let contacts: String = obstacles.iter().enumerate().map(contact).collect();
        let text = format!(
            r#"
[mesh]
grid = {{ kind = "box", size = ["10 mm", "10 mm", "10 mm"], divisions = [1, 1, 1] }}
[laws.rubber]
law = "neo_hookean"
E = "1 MPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "inertia"
region = "body"
density = "1 g/cm^3"
mass = "lumped"
[[constraint]]
kind = "fixed"
region = "body"
[[rigid]]
name = "body_in_it"
{body}
density = "2 g/cm^3"
gravity = {{ direction = [0, 0, -1], acceleration = "9.81 m/s^2" }}
{contacts}
[[stage]]
integrator = {integrator}
duration = "{seconds} s"
dt = "1 ms"
[[probe]]
kind = "energy"
[numerics]
max_iterations = 200
"#
        );
        parse_scene(&text).unwrap_or_else(|e| panic!("{e}"))
    }
}

/// Floors with the sides of the groove of 90°, and of the tray.
const GROOVE: [&str; 2] = [
    r#"{ kind = "floor", point = ["0 mm", "0 mm", "0 mm"], normal = [1, 0, 1] }"#,
    r#"{ kind = "floor", point = ["0 mm", "0 mm", "0 mm"], normal = [-1, 0, 1] }"#,
];
const TRAY: [&str; 2] = [
    r#"{ kind = "floor", point = ["0 mm", "0 mm", "0 mm"], normal = [0, 0, 1] }"#,
    r#"{ kind = "floor", point = ["40 mm", "0 mm", "0 mm"], normal = [-1, 0, 0] }"#,
];

/// Runs against the surface.
fn run_on(surface: &Surface, scene: impl Fn(&[String]) -> Scene) -> Run {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("surface.obj");
    write(&file, surface, Vec3::zeros());
    let surface = format!(r#"{{ kind = "surface", file = "{}", unit = "mm" }}"#, file.display());
    run(&scene(&[surface]))
}

/// Runs against the surface, and against the floors.
fn runs(surface: &Surface, floors: [&str; 2], scene: impl Fn(&[String]) -> Scene) -> [Run; 2] {
    [run_on(surface, &scene), run(&scene(&floors.map(String::from)))]
}

/// The largest difference of a column over two runs, which have all of their steps.
fn difference([one, other]: &[Run; 2], name: &str, label: &str) -> f64 {
    for run in [one, other] {
        assert_eq!(run.status, Status::Converged, "{label}");
    }
    let [one, other] = [one, other].map(|run| column(run, name));
    assert_eq!(one.len(), other.len(), "{label}");
    one.iter().zip(&other).map(|(a, b)| (a - b).abs()).fold(0.0, larger)
}

const RULES: [&str; 4] = [
    r#""implicit_euler""#,
    r#""bdf2""#,
    r#"{ kind = "generalised_alpha", rho = 0.8 }"#,
    r#"{ kind = "newmark", beta = 0.3025, gamma = 0.6 }"#,
];

/// How far places may be off \[m\]. The contacts are the same to rounding, and so are the iterations: rounding of 40 mm is 1e-17 m, and grows over 100 steps.
const OFF: f64 = 1e-10;

/// A ball that falls into a groove next to its middle, and rolls and slides in it, or a block that slides along a tray until its wall stops it: with every rule,
/// with and without friction, the surface is as good as floors with its sides.
#[test]
fn rigid_bodies_meet_both_sides() {
    let ball = r#"shape = { kind = "sphere", center = ["0.3 mm", "-40 mm", "14.642135623730951 mm"], radius = "10 mm" }
velocity = ["0 m/s", "0.2 m/s", "0 m/s"]"#;
    let block = r#"shape = { kind = "box", min = ["10 mm", "-10 mm", "0.1 mm"], max = ["30 mm", "10 mm", "10.1 mm"] }
velocity = ["0.3 m/s", "0 m/s", "0 m/s"]"#;
    for (what, body, surface, floors) in [("ball", ball, groove(1.0), GROOVE), ("block", block, tray(), TRAY)] {
        for response in ["multiplier", "penalty"] {
            for (integrator, friction) in RULES.into_iter().flat_map(|rule| [(rule, 0.0), (rule, 0.3)]) {
                let label = format!("{what}, {response}, {integrator}, friction {friction}");
                let runs = runs(&surface, floors, |obstacles| {
                    Thrown { body, obstacles, response, friction, integrator, seconds: 0.1 }.scene()
                });
                let off = ["x", "y", "z"].map(|i| difference(&runs, &format!("body_in_it_{i}_m"), &label));
                let off = off.into_iter().fold(0.0, larger);
                println!("{label}: {off:.1e} m, {:?} iterations", runs.each_ref().map(|run| run.totals.iterations));
                assert!(off < OFF, "{label}: {off:e}");
            }
        }
    }
}

/// A ball that rolls out of a groove at its end tips over both of its edges at once and falls, and stays in the middle; one that rolls over the rim comes to rest
/// in the groove, 10 √2 mm above its bottom, up to what the penalty lets it sink in.
#[test]
fn a_ball_rolls_out_of_a_groove_and_into_it() {
    let cases =
        [("out", ["0 mm", "40 mm", "14.15 mm"], [0.0, 0.3]), ("in", ["28 mm", "0 mm", "30.05 mm"], [-0.3, 0.0])];
    for (what, [x, y, z], [u, v]) in cases {
        let body = format!(
            "shape = {{ kind = \"sphere\", center = [\"{x}\", \"{y}\", \"{z}\"], radius = \"10 mm\" }}\nvelocity = [\"{u} m/s\", \"{v} m/s\", \"0 m/s\"]"
        );
        for (response, integrator) in ["multiplier", "penalty"].into_iter().flat_map(|r| RULES.map(|rule| (r, rule))) {
            let label = format!("{what}, {response}, {integrator}");
            let run = run_on(&groove(1.0), |obstacles| {
                let thrown = Thrown { body: &body, obstacles, response, friction: 0.3, integrator, seconds: 0.3 };
                thrown.scene()
            });
            assert_eq!(run.status, Status::Converged, "{label}");
            let [x, z] = ["x", "z"].map(|i| *column(&run, &format!("body_in_it_{i}_m")).last().expect("a row"));
            println!("{label}: {x:e} {z:e}");
            assert!(x.abs() < 1e-7, "{label}: {x:e}");
            assert!(if what == "out" { z < -0.1 } else { (z - 0.01 * 2f64.sqrt()).abs() < 1e-6 }, "{label}: {z:e}");
        }
    }
}

/// A soft block on its edge, which is held around its opposite edge and pressed into the groove: the nodes of the edge press on both sides.
#[test]
fn a_soft_edge_meets_both_sides() {
    for (response, friction) in [("multiplier", 0.0), ("multiplier", 0.3), ("penalty", 0.0), ("penalty", 0.3)] {
        let scene = |obstacles: &[String]| {
            let contact = |(k, obstacle): (usize, &String)| {
                format!(
                    "[[contact]]\nname = \"c{k}\"\nregion = \"under\"\nobstacle = {obstacle}\nresponse = \"{response}\"\nfriction = {friction}\n"
                )
            };
            let contacts: String = obstacles.iter().enumerate().map(contact).collect();
            let text = format!(
                r#"
[mesh]
grid = {{ kind = "box", size = ["12 mm", "12 mm", "12 mm"], divisions = [4, 4, 4] }}
[[mesh.part]]
name = "p"
turn = {{ axis = [0, 1, 0], angle = "45 deg" }}
shift = ["-8.48528137423857 mm", "-6 mm", "8.78528137423857 mm"]
[mesh.regions.under]
kind = "union"
of = ["p.xmin", "p.zmin"]
pick = "facets"
[mesh.regions.tip]
kind = "box"
min = ["-2.5 mm", "-7 mm", "15 mm"]
max = ["2.5 mm", "7 mm", "17.5 mm"]
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.4
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "prescribed"
region = "tip"
components = "z"
displacement = {{ kind = "ramp", from = "0 mm", to = "-1.0 mm", end = "1 s" }}
[[constraint]]
kind = "fixed"
region = "tip"
components = "xy"
{contacts}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"
[[probe]]
kind = "reaction"
region = "tip"
[numerics]
max_iterations = 100
"#
            );
            parse_scene(&text).unwrap_or_else(|e| panic!("{e}"))
        };
        let label = format!("{response}, friction {friction}");
        let runs = runs(&groove(1.0), GROOVE, scene);
        let off = difference(&runs, "tip_reaction_z_N", &label) / column(&runs[1], "tip_reaction_z_N")[4].abs();
        println!("{label}: force off by {off:.1e}, {:?} iterations", runs.each_ref().map(|run| run.totals.iterations));
        assert!(off < 1e-9, "{label}: {off:e}");
    }
}
