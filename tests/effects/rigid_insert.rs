//! Rigid parts: against the same part of a stiff law, distances and rotations, balance of forces, the mass in free fall.

use crate::common;
use crate::common::{body, column, run_with_states, scene};
use durometer::math::tensor::Vec3;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, Region, TetMesh};
use durometer::scene::Run;
use durometer::system::State;

/// A beam whose outer half is the region `hard`, the inner one `soft`.
fn beam(order: Order) -> TetMesh {
    let mut mesh = block(8, 2, 2, 0.08, 0.02, 0.02, order);
    let (hard, soft): (Vec<u32>, Vec<u32>) =
        body(&mesh).into_iter().partition(|&c| mesh.position(c as usize, [0.25; 3]).x > 0.04);
    mesh.regions.insert("hard".into(), Region { cells: hard, ..Region::default() });
    mesh.regions.insert("soft".into(), Region { cells: soft, ..Region::default() });
    mesh
}

const BEAM: &str = r#"
[mesh]
body = "beam"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.4
[[effect]]
kind = "elastic"
region = "soft"
law = "rubber"
[[effect]]
kind = "traction"
region = "xmax"
direction = [0, 1, -2]
traction = { kind = "ramp", from = "0 Pa", to = "400 Pa", end = "1 s" }
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.2 s"
[[probe]]
kind = "position"
region = "xmax"
[[probe]]
kind = "reaction"
region = "xmin"
"#;

const RIGID: &str = "[[constraint]]\nkind = \"rigid\"\nregion = \"hard\"\n";

fn bent(order: Order, hard: &str) -> (Run, State) {
    let mut last = None;
    let scene = scene(beam(order), &format!("{BEAM}{hard}"));
    let run = run_with_states(&scene, &mut |state| last = Some(state.clone()));
    assert!(run.rows.len() == 6, "{:?}", run.status);
    (run, last.expect("a state"))
}

fn at_end(run: &Run, prefix: &str) -> Vec3 {
    Vec3::from(["x", "y", "z"].map(|c| {
        let name =
            run.columns.iter().find(|n| n.starts_with(prefix) && n.contains(&format!("_{c}_"))).expect("a column");
        *column(run, name).last().expect("a row")
    }))
}

/// Between stiffness ratios of 1e3 and 1e5 the beam tends to the one with a rigid half, as 1/E: the difference shrinks by 100 within 5 %.
#[test]
fn a_stiff_part_tends_to_a_rigid_one() {
    for order in common::ORDERS {
        let rigid = at_end(&bent(order, RIGID).0, "xmax_");
        let away = ["100 MPa", "10 GPa"].map(|modulus| {
            let stiff = format!(
                "[laws.stiff]\nlaw = \"neo_hookean\"\nE = \"{modulus}\"\nnu = 0.4\n\
                 [[effect]]\nkind = \"elastic\"\nregion = \"hard\"\nlaw = \"stiff\"\n"
            );
            (at_end(&bent(order, &stiff).0, "xmax_") - rigid).norm()
        });
        println!("{order:?}: {away:?} m");
        let ratio = away[0] / away[1];
        assert!((ratio / 100.0 - 1.0).abs() < 0.05, "{order:?}: {away:?}");
    }
}

/// Distances between nodes of the part stay, to the accuracy of steps; the columns give its centre and rotation; reactions are the load, in
/// force and in moment.
#[test]
fn a_rigid_part_keeps_its_shape_and_the_balance() {
    for order in common::ORDERS {
        let mesh = beam(order);
        let (run, state) = bent(order, RIGID);
        let place = |k: u32| mesh.points[k as usize] + Vec3::from_column_slice(&state.x[3 * k as usize..][..3]);
        let part = mesh.nodes_of(&mesh.regions["hard"]);
        for pair in part.windows(2) {
            let rest = (mesh.points[pair[1] as usize] - mesh.points[pair[0] as usize]).norm();
            let now = (place(pair[1]) - place(pair[0])).norm();
            assert!((now / rest - 1.0).abs() < 1e-7, "{order:?}: {now} m, at rest {rest} m");
        }
        let load = Vec3::new(0.0, 1.0, -2.0).normalize() * (400.0 * 0.02 * 0.02);
        let reaction = at_end(&run, "xmin_reaction");
        assert!((reaction + load).norm() < 1e-6 * load.norm(), "{order:?}: {reaction}");
        // The centre and the corner follow one rotation.
        let center = at_end(&run, "insert_");
        let rotation =
            Vec3::from(["x", "y", "z"].map(|c| *column(&run, &format!("insert_rotation_{c}_deg")).last().unwrap()));
        let turn = nalgebra::Rotation3::from_scaled_axis(rotation.map(f64::to_radians));
        assert!(rotation.norm() > 5.0, "the part turns: {rotation}");
        let corner = part[part.len() - 1];
        let expected = center + turn * (mesh.points[corner as usize] - Vec3::new(0.06, 0.01, 0.01));
        assert!((place(corner) - expected).norm() < 1e-8, "{order:?}: {} {expected}", place(corner));
    }
}

/// A free beam falls: with implicit Euler every node has moved by n(n + 1)/2 g Δt² after n steps, so the mass of the part is that of its cells.
#[test]
fn a_free_body_with_a_rigid_part_falls() {
    let text = r#"
[mesh]
body = "beam"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.4
[[effect]]
kind = "elastic"
region = "soft"
law = "rubber"
[[effect]]
kind = "inertia"
region = "body"
density = "1000 kg/m^3"
mass = "consistent"
[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = "10 m/s^2"
[[constraint]]
kind = "rigid"
region = "hard"
[[stage]]
integrator = "implicit_euler"
duration = "40 ms"
dt = "10 ms"
[[probe]]
kind = "position"
region = "xmin"
[[probe]]
kind = "position"
region = "xmax"
"#;
    for order in common::ORDERS {
        let run = common::run(&scene(beam(order), text));
        for end in ["xmin", "xmax", "insert"] {
            let z =
                column(&run, run.columns.iter().find(|n| n.starts_with(end) && n.contains("_z_")).expect("a column"));
            let fallen = z[0] - z[z.len() - 1];
            assert!((fallen / (10.0 * 10.0 * 1e-4) - 1.0).abs() < 1e-6, "{order:?} {end}: {fallen} m");
        }
    }
    let told = |text: &str| {
        let of_inertia = |note: &String| note.contains("moments of inertia of rigid parts too large");
        scene(beam(Order::Linear), text).notes.iter().any(of_inertia)
    };
    let lumped = text.replace("\"consistent\"", "\"lumped\"");
    assert!(!told(text) && told(&lumped) && !told(&lumped.replace("region = \"body\"", "region = \"soft\"")));
}

/// Derivatives by the constants of the soft half, with a rigid one, against differences of runs.
#[test]
fn derivatives_go_through_a_rigid_part() {
    let table: toml::Table = "law = \"neo_hookean\"\nE = \"100.0 kPa\"\nnu = 0.4".parse().expect("a table");
    let (head, rest) = BEAM.split_once("[laws.rubber]").expect("a law");
    let rest = rest.split_once("[[effect]]").expect("an effect").1;
    let build = |table: &toml::Table| {
        let law = toml::to_string(table).expect("a table");
        let numerics = "[numerics]\ntolerance = 1e-12\nreuse_factor = false\n";
        common::scene(beam(Order::Linear), &format!("{head}[[effect]]{rest}{RIGID}{numerics}[laws.rubber]\n{law}"))
    };
    let worst = common::sensitivities::check("rigid", &table, &build);
    println!("{worst:.1e}");
}

/// A part that a soft end carries along turns by the angle that is prescribed there, beyond whole rotations. Nothing else acts on it: bound by the tolerance of steps.
#[test]
fn whole_rotations_of_a_part_are_counted() {
    let text = r#"
[mesh]
body = "beam"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.4
[[effect]]
kind = "elastic"
region = "soft"
law = "rubber"
[[constraint]]
kind = "prescribed"
region = "xmin"
rotation = { axis = [1, 0, 0], about = ["0 mm", "10 mm", "10 mm"], angle = { kind = "ramp", from = "0 deg", to = "-400 deg", end = "1 s" } }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.05 s"
[numerics]
tolerance = 1e-10
"#;
    let run = scene(beam(Order::Linear), &format!("{text}{RIGID}")).run();
    let (t, angle) = (column(&run, "t_s"), column(&run, "insert_rotation_x_deg"));
    assert_eq!(angle.len(), 21, "{:?}", run.status);
    for (t, angle) in t.iter().zip(&angle) {
        assert!((angle + 400.0 * t).abs() < 1e-3, "{angle}° at {t} s");
    }
}

/// Within one rigid part a cable has the length that it has; one that goes on into the soft part has not.
#[test]
fn a_cable_within_a_rigid_part_cannot_get_shorter() {
    let of = |first: f64| {
        let cable = format!(
            "[[constraint]]\nkind = \"cable\"\npull_point = \"moving\"\nguides = [[\"{first} mm\", \"10 mm\", \"15 mm\"], [\"70 mm\", \"10 mm\", \"15 mm\"]]\n\
             guide_radius = \"3 mm\"\ndrive = {{ kind = \"length\", signal = {{ kind = \"ramp\", from = \"0 mm\", to = \"1 mm\", end = \"1 s\" }} }}\n"
        );
        let text = format!("{BEAM}{cable}{RIGID}").replace("body = \"beam\"", "grid = { kind = \"box\", size = [\"80 mm\", \"20 mm\", \"20 mm\"], divisions = [8, 2, 2] }\n\
            regions.hard = { kind = \"box\", pick = \"cells\", rule = \"centroid\", min = [\"40 mm\", \"-1 mm\", \"-1 mm\"], max = [\"81 mm\", \"21 mm\", \"21 mm\"] }\n\
            regions.soft = { kind = \"complement\", of = [\"hard\"] }");
        durometer::scene::parse_scene(&text).map(|_| ()).map_err(|e| e.to_string())
    };
    let said = of(55.0).expect_err("refused");
    assert!(
        said.contains("only 0.0000 mm of it can get shorter: all of its guides are held, or in one rigid part"),
        "{said}"
    );
    assert_eq!(of(15.0), Ok(()));
}
