//! The words on a contact before it runs: its scales, the force that it begins with, and obstacles that its points do not see.

use crate::common::{column, scene, try_scene};
use crate::setup::CUBE;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{Scene, SunkenFacet};
use durometer::solve::Status;

/// A cube of 10 mm, with more of a scene.
fn cube(rest: &str) -> Scene {
    let text = format!("{CUBE}{rest}\n[[stage]]\nintegrator = \"implicit_euler\"\nduration = \"1 s\"\ndt = \"1 s\"\n");
    scene(block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear), &text)
}

/// An obstacle with a motion begins where its motion has it in a dynamic run: the cube ends at 10 mm, the box begins at 9 mm and is moved from there,
/// or at 12 mm and is moved into the cube.
#[test]
fn an_obstacle_begins_where_its_motion_has_it() {
    let (massless, _) = CUBE.split_once("[[effect]]\nkind = \"inertia\"").expect("the mass comes last");
    let built = |at: &str, displacement: &str, integrator: &str| {
        let cube = if integrator == "static" { massless } else { CUBE };
        let text = format!(
            r#"{cube}
[[constraint]]
kind = "fixed"
region = "xmin"
[[contact]]
name = "wall"
region = "xmax"
obstacle = {{ kind = "box", min = ["{at}", "-20 mm", "-20 mm"], max = ["40 mm", "30 mm", "30 mm"] }}
motion = {{ direction = [1, 0, 0], displacement = "{displacement}" }}
response = "penalty"
friction = 0
[[stage]]
integrator = "{integrator}"
duration = "2 ms"
dt = "1 ms"
"#
        );
        try_scene(block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear), &text)
    };
    let apart = built("9 mm", "5 mm", "implicit_euler").expect("4 mm apart").run();
    assert_eq!(column(&apart, "wall_force_x_N"), [0.0; 3]);
    for (at, displacement, integrator, says) in [
        ("12 mm", "-3 mm", "implicit_euler", "1.0000 mm inside of the obstacle at"),
        ("12 mm", "-15 mm", "implicit_euler", "inside of the obstacle at"),
        ("9 mm", "5 mm", "static", "1.0000 mm inside of the obstacle, at its given place"),
    ] {
        let told = built(at, displacement, integrator).err().expect("refused");
        assert!(told.contains(says), "{told}");
    }
}

/// A cube 1 µm above a floor, within 0.1 mm of a barrier of 1 MPa: it begins with −κ (d − d̂)(2 ln(d/d̂) + (d − d̂)/d) a unit of its area.
#[test]
fn a_start_within_the_reach_of_a_barrier_is_noted() {
    let notes = |response: &str, distance: &str| -> Vec<String> {
        let contact = format!(
            r#"
[[contact]]
name = "floor"
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-0.001 mm"], normal = [0, 0, 1] }}
response = "{response}"
friction = 0
distance = "{distance}"
modulus = "1 MPa"
"#
        );
        cube(&contact).notes.into_iter().filter(|note| note.contains("reach of the barrier")).collect()
    };
    let found = notes("barrier", "0.1 mm");
    let [note] = &found[..] else { panic!("{found:?}") };
    assert!(note.starts_with("floor: ") && note.contains("gap 0.0010 mm, distance 0.1000 mm"), "{note}");
    let (d, reach) = (1e-6f64, 1e-4);
    let force = 1e6 / reach * (reach - d) * (2.0 * (d / reach).ln() + (d - reach) / d).abs() * 1e-4;
    let said: f64 = note
        .split("a force of ")
        .nth(1)
        .and_then(|n| n.strip_suffix(" N"))
        .expect("a force")
        .parse()
        .expect("a number");
    assert!((said / force - 1.0).abs() < 1e-3, "{said} N for {force} N");
    assert_eq!(notes("barrier", "0.9 um"), Vec::<String>::new(), "it begins beyond the reach");
    assert_eq!(notes("penalty", "0.1 mm"), Vec::<String>::new(), "a penalty acts from the surface on");
}

/// A block of rubber with a hard part of 200 GPa on one side: the modulus of a contact is that of the law behind most of its area, on two equal halves the larger.
#[test]
fn the_modulus_is_that_of_the_law_at_the_region() {
    let modulus = |region: &str, hard: &str| {
        let text = format!(
            r#"
[mesh]
body = "block"
[mesh.regions.hard]
kind = "box"
min = ["-1 mm", "-1 mm", "-1 mm"]
max = ["{hard}", "11 mm", "11 mm"]
pick = "cells"
rule = "centroid"
[mesh.regions.soft]
kind = "complement"
of = ["hard"]
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3
[laws.metal]
law = "neo_hookean"
E = "200 GPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "soft"
law = "rubber"
[[effect]]
kind = "elastic"
region = "hard"
law = "metal"
[[constraint]]
kind = "fixed"
region = "xmin"
[[contact]]
region = "{region}"
obstacle = {{ kind = "box", min = ["-30 mm", "-30 mm", "-30 mm"], max = ["-20 mm", "-20 mm", "-20 mm"] }}
response = "penalty"
friction = 0
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#
        );
        scene(block(4, 2, 2, 0.01, 0.01, 0.01, Order::Linear), &text).contacts[0].scales.modulus
    };
    for (region, hard, wanted) in [
        ("zmin", "2.5 mm", 1e5),
        ("xmax", "7.5 mm", 1e5),
        ("zmin", "5 mm", 2e11),
        ("zmin", "7.5 mm", 2e11),
        ("xmin", "2.5 mm", 2e11),
    ] {
        let found = modulus(region, hard);
        assert!((found / wanted - 1.0).abs() < 1e-12, "{region} {hard}: {found} Pa for {wanted} Pa");
    }
}

/// Scales that are not given are those of the scene: Young's modulus is 100 kPa, the diagonal of the cube 17.32 mm.
#[test]
fn the_scales_of_a_contact_are_said() {
    let words = |response: &str, rest: &str| {
        let contact = format!(
            r#"
[[contact]]
region = "zmin"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-1 mm"], normal = [0, 0, 1] }}
response = "{response}"
{rest}
"#
        );
        let contact = &cube(&contact).contacts[0];
        contact.scales.words(contact.response)
    };
    assert_eq!(words("multiplier", "friction = 0"), "modulus 100000 Pa");
    assert_eq!(words("penalty", "friction = 0\ndistance = \"0.2 mm\""), "distance 0.2 mm, modulus 100000 Pa");
    let friction = words("barrier", "friction = 0.5\ndistance = \"0.2 mm\"\nmodulus = \"2 kPa\"\nslip = \"4 um\"");
    assert_eq!(friction, "distance 0.2 mm, modulus 2000 Pa, stick_velocity 0.0173205081 mm/s, slip 0.004 mm");
}

/// A plate of 20 × 20 × 2 mm above a peg of 10 mm comes down on it between its eight corner points, but not on a table, and a ball is felt all around. The
/// four corners of its face are 28.28 mm apart across it: a peg of 28 mm fits between them too, one of 29 mm does not.
#[test]
fn an_obstacle_between_the_points_of_a_rigid_body_is_noted() {
    let plate = r#"{ kind = "box", min = ["-10 mm", "-10 mm", "35 mm"], max = ["10 mm", "10 mm", "37 mm"] }"#;
    let ball = r#"{ kind = "sphere", center = ["0 mm", "0 mm", "45 mm"], radius = "10 mm" }"#;
    let peg =
        r#"{ kind = "cylinder", from = ["0 mm", "0 mm", "12 mm"], to = ["0 mm", "0 mm", "30 mm"], radius = "5 mm" }"#;
    let table = r#"{ kind = "box", min = ["-30 mm", "-30 mm", "20 mm"], max = ["30 mm", "30 mm", "30 mm"] }"#;
    let floor = r#"{ kind = "floor", point = ["0 mm", "0 mm", "30 mm"], normal = [0, 0, 1] }"#;
    let [wide, wider] =
        ["14 mm", "14.5 mm"].map(|radius| peg.replace("radius = \"5 mm\"", &format!("radius = \"{radius}\"")));
    for (body, obstacle, noted) in [
        (plate, peg, Some("10.0000 mm wide")),
        (plate, &wide, Some("28.0000 mm wide")),
        (plate, &wider, None),
        (plate, table, None),
        (plate, floor, None),
        (ball, peg, None),
    ] {
        let rest = format!(
            r#"
[[rigid]]
name = "piece"
shape = {body}
density = "1000 kg/m^3"
[[contact]]
name = "peg"
region = "piece"
obstacle = {obstacle}
response = "barrier"
friction = 0.3
"#
        );
        let notes = cube(&rest).notes;
        let found = notes.iter().find(|note| note.contains("fits between the contact points of piece"));
        assert_eq!(found.is_some(), noted.is_some(), "{body} on {obstacle}: {notes:?}");
        let says = |note: &String| note.contains(noted.unwrap_or_default()) && note.contains("28.2843 mm apart");
        assert!(found.is_none_or(says), "{notes:?}");
    }
}

/// A ball of 6 mm comes down on a cube of 10 mm that is held below: between the four points of one cell it meets nothing, 2.5 mm deep; those of cells of
/// 1.25 mm feel it, 1 mm deep.
#[test]
fn a_facet_that_ends_inside_of_an_obstacle_is_found() {
    let (massless, _) = CUBE.split_once("[[effect]]\nkind = \"inertia\"").expect("the mass comes last");
    let text = format!(
        r#"{massless}
[[constraint]]
kind = "fixed"
region = "zmin"
[[contact]]
name = "ball"
region = "zmax"
obstacle = {{ kind = "sphere", center = ["5 mm", "5 mm", "13.1 mm"], radius = "3 mm" }}
motion = {{ direction = [0, 0, -1], displacement = {{ kind = "ramp", from = "0 mm", to = "DOWN mm", end = "1 s" }} }}
response = "multiplier"
friction = 0
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.1 s"
"#
    );
    let run = |parts: usize, down: &str| {
        let text = text.replace("DOWN", down);
        let run = scene(block(parts, parts, parts, 0.01, 0.01, 0.01, Order::Linear), &text).run();
        assert_eq!(run.status, Status::Converged, "{parts}");
        run.sunken
    };
    let found = run(1, "2.6");
    let [SunkenFacet { contact, t, depth, at }] = &found[..] else { panic!("{found:?}") };
    assert!(contact == "ball" && (t - 1.0).abs() < 1e-12, "{found:?}");
    // Its lowest point is the deepest place, which is found to an eighth of the depth that counts
    assert!((2.4e-3..=2.5001e-3).contains(depth), "{found:?}");
    assert!((at[0] - 5e-3).abs() < 1e-3 && (at[1] - 5e-3).abs() < 1e-3 && (at[2] - 1e-2).abs() < 1e-9, "{found:?}");
    assert_eq!(run(8, "1.1"), []);
}

/// Facets of 20 mm × 0.5 mm are as large as those of an edge of 5 mm, and hide a ball of 11 mm as those of 20 mm do.
#[test]
fn an_obstacle_between_slender_facets_is_noted() {
    let contact = r#"
[[contact]]
name = "ball"
region = "xmax"
obstacle = { kind = "sphere", center = ["60 mm", "10 mm", "10 mm"], radius = "RADIUS mm" }
response = "multiplier"
friction = 0
[[stage]]
integrator = "implicit_euler"
duration = "1 s"
dt = "1 s"
"#;
    let notes = |parts: usize, radius: &str| {
        let text = format!("{CUBE}{}", contact.replace("RADIUS", radius));
        scene(block(1, 1, parts, 0.02, 0.02, 0.02, Order::Linear), &text).notes
    };
    let is_narrow =
        |note: &String| note.contains("11.0000 mm wide, is narrow against the distance of the contact points");
    assert!(notes(40, "5.5").iter().any(is_narrow), "{:?}", notes(40, "5.5"));
    let is_any = |note: &String| note.contains("is narrow against");
    assert!(!notes(40, "25").iter().any(is_any), "{:?}", notes(40, "25"));
}

/// A block of 100 × 100 × 10 mm whose cells are 1 mm wide at one corner and 19 mm at the other: a ball of 20 mm is narrow against these, and not against those.
#[test]
fn an_obstacle_is_compared_with_the_facets_that_are_nearest_to_it() {
    let mut mesh = block(10, 10, 1, 0.1, 0.1, 0.01, Order::Linear);
    mesh.points.iter_mut().for_each(|at| (at.x, at.y) = (at.x * at.x / 0.1, at.y * at.y / 0.1));
    for (corner, noted) in [(0, false), (100, true)] {
        let text = format!(
            r#"{CUBE}
[[contact]]
name = "ball"
region = "zmax"
obstacle = {{ kind = "sphere", center = ["{corner} mm", "{corner} mm", "21 mm"], radius = "10 mm" }}
response = "multiplier"
friction = 0
[[stage]]
integrator = "implicit_euler"
duration = "1 s"
dt = "1 s"
"#
        );
        let notes = scene(mesh.clone(), &text).notes;
        assert_eq!(notes.iter().any(|note| note.contains("is narrow against")), noted, "{corner}: {notes:?}");
    }
}

/// A cylinder has balls inside that roll where it is as long as it is wide; a shorter one rolls on the points of its rims.
#[test]
fn a_flat_cylinder_is_noted_as_a_prism() {
    for (half_length, noted) in [(10.0, false), (10.1, false), (9.9, true)] {
        let rest = format!(
            r#"
[[rigid]]
name = "roll"
shape = {{ kind = "cylinder", from = ["0 mm", "{} mm", "40 mm"], to = ["0 mm", "{half_length} mm", "40 mm"], radius = "10 mm" }}
density = "1000 kg/m^3"
[[contact]]
name = "plane"
region = "roll"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "20 mm"], normal = [0, 0, 1] }}
response = "multiplier"
friction = 0.3
"#,
            -half_length
        );
        let scene = cube(&rest);
        assert_eq!(
            scene.notes.iter().any(|note| note.contains("rolls as a prism")),
            noted,
            "{half_length}: {:?}",
            scene.notes
        );
        let points = &scene.contacts[0].points().expect("points").points;
        assert_eq!(points.iter().any(|point| point.radius > 0.0), !noted, "{half_length}");
    }
}

/// An obstacle that begins inside of a body is refused although no contact point is inside of it: a box in a cube of many cells, a ball that reaches through the
/// faces of a rigid cube, and a bar across another; what rests on a
/// face of the body is not.
#[test]
fn an_obstacle_that_begins_inside_of_a_body_is_refused() {
    let built = |parts: usize, region: &str, obstacle: &str, rest: &str| {
        let text = format!(
            r#"{CUBE}
{rest}
[[contact]]
name = "meets"
region = "{region}"
obstacle = {obstacle}
response = "penalty"
friction = 0
[[stage]]
integrator = "implicit_euler"
duration = "1 s"
dt = "1 s"
"#
        );
        try_scene(block(parts, parts, parts, 0.02, 0.02, 0.02, Order::Linear), &text).err()
    };
    let inner = |top: &str| {
        format!(r#"{{ kind = "box", min = ["4 mm", "4 mm", "5 mm"], max = ["16 mm", "16 mm", "{top} mm"] }}"#)
    };
    let under = r#"{ kind = "box", min = ["-4 mm", "4 mm", "-5 mm"], max = ["16 mm", "16 mm", "0 mm"] }"#;
    let rigid = |low: &str, high: &str| {
        format!(
            "[[rigid]]\nname = \"piece\"\ndensity = \"1000 kg/m^3\"\nshape = {{ kind = \"box\", min = {low}, max = {high} }}"
        )
    };
    let cube = rigid(r#"["90 mm", "-10 mm", "0 mm"]"#, r#"["110 mm", "10 mm", "20 mm"]"#);
    let bar = rigid(r#"["70 mm", "-5 mm", "0 mm"]"#, r#"["130 mm", "5 mm", "10 mm"]"#);
    let ball = |z: &str| format!(r#"{{ kind = "sphere", center = ["100 mm", "0 mm", "{z} mm"], radius = "13 mm" }}"#);
    let across = |top: &str| {
        format!(r#"{{ kind = "box", min = ["85 mm", "-40 mm", "-9 mm"], max = ["115 mm", "40 mm", "{top} mm"] }}"#)
    };
    for (refused, told) in [
        (Some("mm inside of the body at"), built(6, "zmax", &inner("15"), "")),
        (Some("is 5.0000 mm inside of the body at"), built(6, "xmax", &inner("15"), "")),
        (None, built(6, "zmax", under, "")),
        (Some("mm inside of \"piece\" at"), built(1, "piece", &ball("10"), &cube)),
        (None, built(1, "piece", &ball("-13"), &cube)),
        (Some("mm inside of \"piece\" at"), built(1, "piece", &across("6"), &bar)),
        (None, built(1, "piece", &across("0"), &bar)),
    ] {
        match refused {
            Some(says) => assert!(told.as_ref().is_some_and(|told| told.contains(says)), "{says}: {told:?}"),
            None => assert_eq!(told, None),
        }
    }
}
