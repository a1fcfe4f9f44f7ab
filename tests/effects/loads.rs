//! Loads with a place, and markers: what an embedded point moves and what a force on it does are transposes of one map.

use crate::common;
use crate::common::{Random, scene};
use durometer::material::Want;
use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::disturb::distort;
use durometer::mesh::embed::embed;
use durometer::mesh::enrich::Enriched;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::scene::Scene;
use durometer::solve::Status;
use durometer::system::{At, BlockValues, Rates};

const AT: [f64; 3] = [0.62, 0.45, 0.38];

/// A unit cube with flat sides and inner nodes moved.
fn cube(order: Order) -> TetMesh {
    let mut mesh = block(2, 2, 2, 1.0, 1.0, 1.0, order);
    distort(&mut mesh, 5, 0.1);
    mesh
}

fn loaded(order: Order, radius: &str, extra: &str) -> Scene {
    loaded_on(cube(order), radius, extra)
}

fn loaded_on(mesh: TetMesh, radius: &str, extra: &str) -> Scene {
    let text = format!(
        r#"
[mesh]
body = "block"
[laws.rubber]
law = "linear"
E = "100 kPa"
nu = 0
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "point_force"
point = ["{} m", "{} m", "{} m"]
radius = "{radius}"
direction = [2, -1, 2]
force = {{ kind = "ramp", from = "0 N", to = "300 N", end = "1 s" }}
{extra}
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
[[probe]]
kind = "markers"
name = "eye"
points = [["{} m", "{} m", "{} m"], ["0.1 m", "0.2 m", "0.3 m"]]
[[probe]]
kind = "reaction"
region = "xmin"
"#,
        AT[0], AT[1], AT[2], AT[0], AT[1], AT[2]
    );
    scene(mesh, &text)
}

fn column(run: &durometer::scene::Run, name: &str) -> f64 {
    let k = run.columns.iter().position(|c| c == name).unwrap_or_else(|| panic!("{name}: {:?}", run.columns));
    run.rows.last().expect("a row")[k]
}

/// f·v of the embedded point, interpolated by the shape functions of the cell it is found in, against −r·v over the nodes,
/// for random velocities: sums of ten terms, rounding 1e-14 of the sum of sizes. A force on a ball has the power of the mean
/// velocity over it, which for an affine field is that of its centre.
#[test]
fn power_at_the_point_is_power_at_the_nodes() {
    for order in common::ORDERS {
        for radius in ["point", "0.25 m"] {
            let scene = loaded(order, radius, "");
            let mesh = &scene.body.mesh;
            let (n, mut random) = (3 * mesh.points.len(), Random::seed(11));
            assert_eq!(scene.system.effects[1].name(), "point_force");
            let r = residual(&scene, 1, 0.7);
            let force = Vec3::new(2.0, -1.0, 2.0) / 3.0 * 210.0;
            let (slope, shift) = (matrix(&mut random), Vec3::new(0.3, -0.2, 0.9));
            let v: Vec<f64> = match radius {
                "point" => random.vector(n, 1.0),
                _ => mesh.points.iter().flat_map(|p| (slope * p + shift).data.0[0]).collect(),
            };
            let velocity = match radius {
                "point" => (embed(mesh, AT.into()).expect("inside").weights.iter())
                    .map(|&(k, w)| w * Vec3::from_column_slice(&v[3 * k as usize..][..3]))
                    .sum::<Vec3>(),
                _ => slope * Vec3::from(AT) + shift,
            };
            let power: f64 = -r.iter().zip(&v).map(|(r, v)| r * v).sum::<f64>();
            let size: f64 = r.iter().zip(&v).map(|(r, v)| (r * v).abs()).sum();
            let off = (power - force.dot(&velocity)).abs();
            // The weights of a ball follow affine fields to 1e-12 of its size (mesh/ball.rs)
            let bound = if radius == "point" { 1e-14 } else { 1e-11 };
            assert!(off <= bound * size, "{order:?}, {radius}: {power}, {}", force.dot(&velocity));
        }
    }
}

fn matrix(random: &mut Random) -> Mat3 {
    Mat3::from_fn(|_, _| random.around(1.0))
}

/// Nodal forces of an effect at rest and time t.
fn residual(scene: &Scene, effect: usize, t: f64) -> Vec<f64> {
    let effect = &scene.system.effects[effect];
    let zero = vec![0.0; 3 * scene.body.mesh.points.len()];
    let rates = Rates::default();
    let at = At { t, dt: 1.0, x: &zero, v: &zero, a: &zero, old: &zero, history: &[], inputs: &[], rates };
    let mut r = zero.clone();
    for b in 0..effect.blocks().len() {
        let mut out = BlockValues::new(3);
        effect.eval(&at, b, Want::Residual, &mut out).expect("a load is defined everywhere");
        effect.blocks().dofs(b).zip(&out.r).for_each(|(dof, f)| r[dof as usize] += f);
    }
    r
}

/// The held face carries the whole force; the marker on the loaded point moves with it, and the work of the force,
/// ½ f·u of a linear body, is the elastic energy (Clapeyron), at the residual of Newton's method, 1e-8.
#[test]
fn the_force_is_carried_and_does_its_work() {
    for order in common::ORDERS {
        let scene = loaded(order, "point", "[[probe]]\nkind = \"energy\"");
        let run = scene.run();
        assert_eq!(run.status, Status::Converged);
        let vector =
            |name: &str, unit: &str| Vec3::from(["x", "y", "z"].map(|c| column(&run, &format!("{name}_{c}_{unit}"))));
        let force = Vec3::new(2.0, -1.0, 2.0) * 100.0;
        let reaction = vector("xmin_reaction", "N");
        assert!((reaction + force).norm() <= 1e-6 * force.norm(), "{order:?}: {reaction}");
        let u = vector("eye_1", "m") - Vec3::from(AT);
        let work = 0.5 * force.dot(&u);
        assert!(work > 0.0 && (work - column(&run, "elastic_J")).abs() <= 1e-6 * work, "{order:?}: {work}");
        assert!(scene.no_limit.is_some(), "a force on a point has no limit");
    }
}

/// A skin of two triangles, 0.2 m by 0.3 m and so not larger than facets, half a millimetre outside of the tip: its vertices move as the affine motion says to
/// 1e-13, and the power of a traction on it, p·A times the mean velocity of its vertices (thirds of two equal triangles),
/// is that of the nodal forces.
#[test]
fn a_skin_follows_and_returns_its_traction() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("patch.obj");
    let obj = "v 1000.5 200 300\nv 1000.5 400 300\nv 1000.5 400 600\nv 1000.5 200 600\nf 1 2 3 4\n";
    std::fs::write(&file, obj).expect("a temporary file");
    let extra = format!(
        "[[skin]]\nname = \"patch\"\nfile = {:?}\nunit = \"mm\"\nreach = \"1 mm\"\n[[effect]]\nkind = \"traction\"\nskin = \"patch\"\ndirection = [0, 0, -1]\ntraction = \"500 Pa\"\n",
        file.display().to_string()
    );
    for order in common::ORDERS {
        let scene = loaded(order, "0.25 m", &extra);
        let mesh = &scene.body.mesh;
        let n = 3 * mesh.points.len();
        let mut random = Random::seed(23);
        let (slope, shift) = (matrix(&mut random), Vec3::new(0.1, 0.2, -0.3));
        let x: Vec<f64> = mesh.points.iter().flat_map(|p| (slope * p + shift).data.0[0]).collect();
        let u = scene.skins[0].displacement(&x);
        for (p, u) in scene.skins[0].surface.points.iter().zip(u.chunks(3)) {
            assert!((slope * p + shift - Vec3::from_column_slice(u)).norm() < 1e-13, "{order:?} at {p}");
        }
        // Any motion, not only an affine one
        let v = random.vector(n, 1.0);
        let moved = scene.skins[0].displacement(&v);
        let mean = |k: usize| Vec3::from_column_slice(&moved[3 * k..3 * k + 3]);
        let triangles = [(mean(0) + mean(1) + mean(2)) / 3.0, (mean(0) + mean(2) + mean(3)) / 3.0];
        let want = Vec3::new(0.0, 0.0, -500.0).dot(&(triangles[0] + triangles[1])) * 0.03;
        let r = residual(&scene, 2, 1.0);
        let power: f64 = -r.iter().zip(&v).map(|(r, v)| r * v).sum::<f64>();
        let size: f64 = r.iter().zip(&v).map(|(r, v)| (r * v).abs()).sum();
        assert!((power - want).abs() <= 1e-13 * size, "{order:?}: {power}, {want}");
    }
}

/// The two triangles of one side of a cube of six cells, which are split again and again: a traction on them as a skin has the nodal forces of the region. On
/// other triangles of the same side it has the same resultant and moment.
#[test]
fn a_traction_on_a_skin_is_that_on_the_facets_below_at_every_level() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("side.obj");
    let of = |mesh: &TetMesh, on: &str| {
        let load = format!("{on}\ndirection = [0, 3, -4]\ntraction = \"500 Pa\"\n");
        let skin = format!(
            "[[skin]]\nname = \"side\"\nfile = {:?}\nunit = \"m\"\nreach = \"0.001 mm\"\n",
            file.display().to_string()
        );
        let scene = loaded_on(mesh.clone(), "0.25 m", &format!("{skin}[[effect]]\nkind = \"traction\"\n{load}"));
        assert_eq!(scene.no_limit, None);
        residual(&scene, 2, 1.0)
    };
    let sum = |mesh: &TetMesh, r: &[f64]| {
        let forces = || r.chunks(3).map(Vec3::from_column_slice);
        [forces().sum::<Vec3>(), mesh.points.iter().zip(forces()).map(|(p, f)| p.cross(&f)).sum()]
    };
    for (order, levels) in [(Order::Linear, 3), (Order::Quadratic, 2)] {
        let mut mesh = block(1, 1, 1, 1.0, 1.0, 1.0, order);
        for level in 0..=levels {
            for faces in ["f 1 2 3\nf 1 3 4", "f 1 2 4\nf 2 3 4"] {
                std::fs::write(&file, format!("v 1 0 0\nv 1 1 0\nv 1 1 1\nv 1 0 1\n{faces}\n")).expect("writable");
                let [region, skin] = ["region = \"xmax\"", "skin = \"side\""].map(|on| of(&mesh, on));
                if faces.starts_with("f 1 2 3") {
                    let off = skin.iter().zip(&region).fold(0.0, |off, (a, b)| larger(off, (a - b).abs()));
                    assert!(off < 1e-10, "{order:?}, level {level}: {off}");
                }
                for (a, b) in sum(&mesh, &skin).iter().zip(sum(&mesh, &region)) {
                    assert!((a - b).norm() < 1e-10, "{order:?}, level {level}: {a} and {b}");
                }
                let largest = |r: &[f64]| r.iter().fold(0.0, |most, v| larger(most, v.abs()));
                assert!(largest(&skin) < 4.0 * largest(&region), "{order:?}, level {level}: a force on a point");
            }
            mesh = Enriched::by_splitting(&mesh).mesh;
        }
    }
}

/// A bar of the linear law with ν = 0 under a traction σ along its axis: u = σ X/E, whatever the mesh; 10 kPa over
/// 100 kPa. The point force is off.
#[test]
fn a_traction_stretches_a_bar() {
    let traction = "[[effect]]\nkind = \"traction\"\nregion = \"xmax\"\ndirection = [5, 0, 0]\ntraction = { kind = \"ramp\", from = \"0 kPa\", to = \"10 kPa\", end = \"1 s\" }";
    for order in common::ORDERS {
        let off = |text: &str| text.replace("to = \"300 N\"", "to = \"0 N\"");
        let scene = loaded(order, "0.25 m", traction);
        let text = off(&scene.text);
        let scene = common::scene(cube(order), &text);
        let run = scene.run();
        assert_eq!(run.status, Status::Converged);
        for (k, x) in [(1, AT), (2, [0.1, 0.2, 0.3])] {
            let want = [1.1 * x[0], x[1], x[2]];
            for (c, want) in ["x", "y", "z"].into_iter().zip(want) {
                let got = column(&run, &format!("eye_{k}_{c}_m"));
                // 1e-8 of the forces in the residual
                assert!((got - want).abs() <= 1e-8, "{order:?}, marker {k}: {c} = {got}, not {want}");
            }
        }
        assert_eq!(scene.no_limit, None);
    }
}
