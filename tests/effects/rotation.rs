//! Prescribed rotations: exact positions at every time, a rigid rotation without energy, and torsion of a cylinder.

use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::scene::{Body, Run, RunOptions, Scene, SceneSpec};
use durometer::solve::Status;
use durometer::system::State;
use std::path::Path;
use std::sync::Arc;

fn build(text: &str) -> Result<Scene, String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scene.toml");
    let spec = SceneSpec::from_text(&file, text, "").map_err(|e| e.to_string())?;
    let body = Body::load(&file, &spec.mesh, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
    Scene::build(&file, spec, text.into(), Arc::new(body)).map_err(|e| e.to_string())
}

fn cylinder(element: &str, nu: f64, formulation: &str, constraints: &str) -> String {
    format!(
        r#"
[mesh]
grid = {{ kind = "cylinder", radius = "10 mm", length = "10 mm", divisions = [4, 4] }}
element = "{element}"
[laws.rubber]
law = "neo_hookean_split"
E = "1 MPa"
nu = {nu}
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "{formulation}"
{constraints}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.125 s"
[[probe]]
kind = "energy"
[[probe]]
kind = "reaction"
region = "zmax"
[numerics]
tolerance = 1e-10
"#
    )
}

fn rotation(region: &str, more: &str, [axis, about, to]: [&str; 3]) -> String {
    format!(
        r#"
[[constraint]]
kind = "prescribed"
region = "{region}"
{more}
rotation = {{ axis = {axis}, about = {about}, angle = {{ kind = "ramp", from = "0 deg", to = "{to}", end = "1 s" }} }}
"#
    )
}

/// Both ends turn by the same angle about an axis outside of the body: after each step all nodes are on their circles, and no energy
/// is stored.
#[test]
fn a_rigid_rotation_stores_no_energy() {
    let about = ["[1, 2, -1]", "[\"30 mm\", \"0 mm\", \"5 mm\"]", "150 deg"];
    let ends = [rotation("zmin", "", about), rotation("zmax", "", about)].concat();
    let scene = build(&cylinder("tet10", 0.45, "displacement", &ends)).unwrap_or_else(|e| panic!("{e}"));
    let (axis, center) = (Vec3::new(1.0, 2.0, -1.0).normalize(), Vec3::new(0.03, 0.0, 0.005));
    let mut worst = 0.0_f64;
    let mut each = |state: &State| {
        let turn =
            nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_unchecked(axis), state.t * 150_f64.to_radians());
        for (x, now) in scene.body.mesh.points.iter().zip(scene.positions(&state.x)) {
            worst = larger(worst, (center + turn * (x - center) - now).norm());
        }
    };
    let run = scene.run_with(RunOptions { on_state: Some(&mut each), ..RunOptions::default() });
    assert_eq!(run.status, Status::Converged);
    let energy = run.column("elastic_J").unwrap_or_else(|| panic!("{:?}", run.columns));
    let scale = 1e6 * scene.body.mesh.volume();
    let most = energy.iter().fold(0.0, |m, e| larger(m, e.abs()));
    println!("off by {worst:e} m, energy {:e} of E V", most / scale);
    // Forces are solved to 1e-10 of the largest: an energy of (1e-10)², and positions of 1e-10 of 10 mm; the arm is four times that.
    assert!(worst < 1e-11 && most < 1e-15 * scale);
}

/// Torsion by ψ per length with both ends plane and held in z is Rivlin's pure torsion of an incompressible cylinder: N = −¼πμψ²A⁴
/// (Rivlin 1948). The ring of the end goes on exact circles. M = ½πμψA⁴ is W′(ψ)/L of the energy W = ¼πμψ²A⁴L.
#[test]
fn torsion_has_the_closed_form() {
    let fixed = "[[constraint]]\nkind = \"fixed\"\nregion = \"zmin\"\n";
    let top = rotation("zmax", "", ["[0, 0, 1]", "[\"0 mm\", \"0 mm\", \"0 mm\"]", "18 deg"]);
    let scene = build(&cylinder("tet10", 0.4999, "mixed", &[fixed, &top].concat())).unwrap_or_else(|e| panic!("{e}"));
    let run: Run = scene.run();
    assert_eq!(run.status, Status::Converged);
    let last = |name: &str| *run.column(name).unwrap_or_else(|| panic!("{:?}", run.columns)).last().expect("rows");
    let (mu, a, length, psi) = (1e6 / (2.0 * 1.4999), 0.01_f64, 0.01, 18_f64.to_radians() / 0.01);
    let pi = std::f64::consts::PI;
    let energy = last("elastic_J") / (0.25 * pi * mu * psi.powi(2) * a.powi(4) * length);
    let normal = last("zmax_reaction_z_N") / (-0.25 * pi * mu * psi.powi(2) * a.powi(4));
    // The moment is linear in the angle, so that the work of one step of 18° is the energy; along the chords it would be 1.6 % less.
    let text = cylinder("tet10", 0.4999, "mixed", &[fixed, &top].concat()).replace("0.125 s", "1 s");
    let at_once = build(&text).unwrap_or_else(|e| panic!("{e}")).run();
    let [work, stored] = ["work_J", "elastic_J"].map(|name| at_once.column(name).expect("an energy")[1]);
    println!("work {:.6} of the energy", work / stored);
    assert!((work / stored - 1.0).abs() < 1e-3, "{work} {stored}");
    println!("W {energy:.5}, N {normal:.5} of the closed form");
    // tests/elements/incompressible.rs: 0.5 % of M and N on this mesh
    assert!((energy - 1.0).abs() < 0.005 && (normal - 1.0).abs() < 0.005, "{energy} {normal}");
}

/// The components that a rotation leaves to another constraint, and what is refused.
#[test]
fn components_and_bad_input() {
    let about = ["[0, 0, 1]", "[\"0 mm\", \"0 mm\", \"0 mm\"]", "20 deg"];
    let fixed = "[[constraint]]\nkind = \"fixed\"\nregion = \"zmin\"\n";
    let pulled =
        "[[constraint]]\nkind = \"prescribed\"\nregion = \"zmax\"\ncomponents = \"z\"\ndisplacement = \"1 mm\"\n";
    let both = [fixed, &rotation("zmax", "components = \"xy\"", about), pulled].concat();
    let run = build(&cylinder("tet4", 0.3, "displacement", &both)).unwrap_or_else(|e| panic!("{e}")).run();
    assert_eq!(run.status, Status::Converged);
    let nothing = "[[constraint]]\nkind = \"prescribed\"\nregion = \"zmax\"\n";
    let twice = rotation("zmax", "components = \"xy\"\ndisplacement = \"1 mm\"", about);
    let flat = rotation("zmax", "", ["[0, 0, 0]", about[1], about[2]]);
    let moved =
        |z: &str| rotation("zmax", &format!("components = \"xy\"\ntranslation = [\"1 mm\", \"0 mm\", {z}]"), about);
    let at_rest = moved("{ kind = \"ramp\", from = \"0 mm\", to = \"0 mm\", end = \"1 s\" }");
    assert!(build(&cylinder("tet4", 0.3, "displacement", &at_rest)).is_ok());
    for (constraint, says) in [
        (nothing, "give `displacement`, `rotation` or `translation`"),
        (&twice, "constraint of its own"),
        (&flat, "no length"),
        (&moved("\"1 mm\""), "the translation along z is given, and components = \"xy\" leaves it free"),
        (&rotation("zmax", "components = \"z\"", about), "a rotation about the z axis moves nothing along z"),
        // 270° in one second are 33.75° a step of 0.125 s, 1440° are 180°.
        (&rotation("zmax", "", [about[0], about[1], "1440 deg"]), "180° within the step at t = 0.000000 s"),
    ] {
        let told = build(&cylinder("tet4", 0.3, "displacement", constraint)).err().expect("refused");
        assert!(told.contains(says), "{told}");
    }
}
