//! Regions of a scene: rules at the border of a place, sets, components, layers near a surface, and what is refused.

use crate::common::tools;
use durometer::mesh::{Order, Region, structured};
use durometer::scene::{Scene, SceneBuilder};
use std::path::Path;

/// A block of 4 × 2 × 2 boxes of 10 mm with these regions, in a folder.
fn block(folder: &Path, regions: &str) -> Result<Scene, String> {
    let text = format!(
        r#"
[mesh]
grid = {{ kind = "box", size = ["40 mm", "20 mm", "20 mm"], divisions = [4, 2, 2] }}
[mesh.regions]
{regions}
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
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#
    );
    let scene = SceneBuilder::parse(&text).map_err(|e| e.to_string())?;
    scene.file(folder.join("scene.toml")).build().map_err(|e| e.to_string())
}

fn here() -> &'static Path {
    Path::new("")
}

#[test]
fn sets_follow_set_theory() {
    let scene = block(
        here(),
        r#"
right = { kind = "box", min = ["19 mm", "-1 mm", "-1 mm"], max = ["41 mm", "21 mm", "21 mm"], pick = "cells", rule = "all" }
upper = { kind = "box", min = ["-1 mm", "-1 mm", "9 mm"], max = ["41 mm", "21 mm", "21 mm"], pick = "cells", rule = "all" }
both = { kind = "intersection", of = ["right", "upper"] }
either = { kind = "union", of = ["upper", "right"] }
left = { kind = "complement", of = ["right"] }
only_right = { kind = "difference", of = ["right", "upper"] }
again = { kind = "union", of = ["both", "only_right"] }
sides = { kind = "difference", of = ["skin", "xmin", "xmax"] }
rim = { kind = "intersection", of = ["sides", "xmax"], pick = "nodes" }
wall = { kind = "intersection", of = ["right", "skin"], pick = "facets" }
"#,
    )
    .expect("regions");
    let count = |name: &str| scene.regions[name].cells.len();
    // Eight of sixteen boxes lie on each side, six cells a box
    let found = ["right", "upper", "both", "either", "left", "only_right"].map(count);
    assert_eq!(found, [48, 48, 24, 72, 48, 24]);
    assert_eq!(scene.regions["again"].cells, scene.regions["right"].cells);
    assert_eq!(count("both") + count("only_right"), count("right"));
    // Two triangles a square: 80 squares in all, 4 at each end
    assert_eq!(scene.regions["skin"].facets.len(), 2 * (2 * 4 + 4 * 8));
    assert_eq!(scene.regions["sides"].facets.len(), 2 * 4 * 8);
    assert!(!scene.regions["sides"].depends_on_mesh && scene.regions["again"].depends_on_mesh);
    assert_eq!(scene.regions["rim"].nodes.len(), 8);
    // The end, and half of the sides
    assert_eq!(scene.regions["wall"].facets.len(), 2 * (4 + 4 * 4));
    let notes = scene.notes.iter().filter(|n| n.contains("is picked by a selector")).count();
    assert_eq!(notes, 8, "{:?}", scene.notes);
}

/// An open square of 2 × 2 triangles at x = 12 mm: the layer of 3 mm about it holds the nodes at 10 mm.
#[test]
fn a_layer_near_a_surface_is_found() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let square = "v 1.2 -1 -1\nv 1.2 3 -1\nv 1.2 3 3\nv 1.2 -1 3\nf 1 2 3\nf 1 3 4\n";
    std::fs::write(folder.path().join("sheet.obj"), square).expect("writable");
    let near = |tolerance: f64, pick: &str| {
        let text = format!(
            r#"near = {{ kind = "near", file = "sheet.obj", unit = "cm", tolerance = "{tolerance} mm", {pick} }}"#
        );
        block(folder.path(), &text).map(|scene| scene.regions["near"].clone())
    };
    let nodes = near(3.0, "pick = \"nodes\"").expect("a layer");
    assert_eq!(nodes.nodes.len(), 9);
    let refused = near(1.9, "pick = \"nodes\"").expect_err("no node is so near");
    assert!(refused.contains("mesh.regions.near: the layer within 1.9 mm of sheet.obj holds no nodes"), "{refused}");
    let cells = |rule: &str| near(8.5, &format!("pick = \"cells\", rule = \"{rule}\"")).expect("a layer").cells.len();
    // Nodes at 10 and 20 mm: cells between them, and those that touch them
    assert_eq!([cells("all"), cells("any")], [24, 72]);
}

/// The same sheet in metres, read as millimetres, is a speck at the origin, and as kilometres far away: both extents and the unit are told.
#[test]
fn a_surface_in_a_wrong_unit_is_told() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let square = "v 0 0 0.02\nv 0.04 0 0.02\nv 0.04 0.02 0.02\nv 0 0.02 0.02\nf 1 2 3\nf 1 3 4\n";
    std::fs::write(folder.path().join("sheet.obj"), square).expect("writable");
    let near = |unit: &str, tolerance: &str| {
        format!("near = {{ kind = \"near\", file = \"sheet.obj\", unit = \"{unit}\", tolerance = \"{tolerance}\" }}")
    };
    let skin = |unit: &str, reach: &str| {
        format!("[[skin]]\nname = \"cover\"\nfile = \"sheet.obj\"\nunit = \"{unit}\"\nreach = \"{reach}\"")
    };
    let sizes = "the surface fills (0, 0, 0.02) mm to (0.04, 0.02, 0.02) mm, the mesh fills (0, 0, 0) mm to (40, 20, 20) mm; unit = \"m\" would make \
                 them alike";
    let refused = block(folder.path(), &near("mm", "1e-3 mm")).map(|_| ()).expect_err("no node is so near");
    assert!(refused.ends_with(&format!("the layer within 0.001 mm of sheet.obj holds no nodes; {sizes}")), "{refused}");
    let notes = |regions: &str| block(folder.path(), regions).expect("a scene").notes;
    assert!(notes(&near("mm", "0.1 mm")).contains(&format!("region near: {sizes}")));
    assert!(notes(&skin("mm", "0.1 mm")).contains(&format!("skin cover: {sizes}")));
    for fits in [near("m", "0.1 mm"), skin("m", "0.1 mm")] {
        assert!(!notes(&fits).iter().any(|note| note.contains("alike")), "{fits}");
    }
    std::fs::write(folder.path().join("sheet.obj"), square.replace("0.0", "")).expect("writable");
    let refused = block(folder.path(), &skin("m", "0.1 mm")).map(|_| ()).expect_err("it is far outside");
    let sizes = "or give a larger `reach`; the surface fills (0, 0, 2000) mm to (4000, 2000, 2000) mm, the mesh fills (0, 0, 0) mm to (40, 20, 20) mm; \
                 unit = \"cm\" would make them alike";
    assert!(refused.ends_with(sizes), "{refused}");
}

/// A block that is hollow, and a copy of it: components of the surface and of the body.
#[test]
fn components_are_numbered_by_size() {
    let text = r#"
[mesh]
[[mesh.part]]
name = "large"
grid = { kind = "box", size = ["40 mm", "20 mm", "20 mm"], divisions = [4, 2, 2] }
[[mesh.part]]
name = "small"
grid = { kind = "box", size = ["10 mm", "10 mm", "10 mm"], divisions = [1, 1, 1] }
shift = ["60 mm", "0 mm", "0 mm"]
[mesh.regions]
first = { kind = "component", pick = "cells", which = 1 }
second = { kind = "component", pick = "cells", which = 2 }
outer = { kind = "component", pick = "facets", which = "outer" }
other = { kind = "component", pick = "facets", which = 2 }
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
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#;
    let scene = SceneBuilder::parse(text).expect("a scene").build().expect("components");
    let same = |a: &Region, b: &Region| (a.cells.clone(), a.facets.clone()) == (b.cells.clone(), b.facets.clone());
    assert!(same(&scene.regions["first"], &scene.regions["large.body"]));
    assert!(same(&scene.regions["second"], &scene.regions["small.body"]));
    assert!(same(&scene.regions["outer"], &scene.regions["skin"]));
    assert!(same(&scene.regions["other"], &scene.regions["small.skin"]));
    let refused = |which: &str| {
        let text = text.replace("which = 1", which);
        SceneBuilder::parse(&text).and_then(SceneBuilder::build).err().expect("no such component").to_string()
    };
    let listed = "there are 1: 96 cells, 16000.0000 mm^3; 2: 6 cells, 1000.0000 mm^3";
    assert!(refused("which = 3").contains(&format!("part 3 is not there; {listed}")), "{}", refused("which = 3"));
    assert!(refused("which = \"inner\"").contains(listed));
    assert!(refused("which = 0").contains("numbered from 1"));
}

/// A layer whose stiffness is added, against two regions side by side with the sum of the moduli; and what is refused.
#[test]
fn effects_that_overlap_are_declared() {
    let scene = |effects: &str| {
        let text = format!(
            r#"
[mesh]
grid = {{ kind = "box", size = ["40 mm", "20 mm", "20 mm"], divisions = [4, 2, 2] }}
[mesh.regions]
half = {{ kind = "box", min = ["-1 mm", "-1 mm", "-1 mm"], max = ["41 mm", "21 mm", "10 mm"], pick = "cells", rule = "all" }}
rest = {{ kind = "complement", of = ["half"] }}
[laws]
soft = {{ law = "neo_hookean", E = "100 kPa", nu = 0.3 }}
stiff = {{ law = "neo_hookean", E = "300 kPa", nu = 0.3 }}
both = {{ law = "neo_hookean", E = "400 kPa", nu = 0.3 }}
{effects}
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = {{ kind = "ramp", from = "0 mm", to = "8 mm", end = "1 s" }}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[[probe]]
kind = "reaction"
region = "xmax"
[numerics]
tolerance = 1e-12
"#
        );
        SceneBuilder::parse(&text).and_then(SceneBuilder::build).map_err(|e| e.to_string())
    };
    let elastic = |region: &str, law: &str, more: &str| {
        format!("[[effect]]\nkind = \"elastic\"\nregion = \"{region}\"\nlaw = \"{law}\"\n{more}\n")
    };
    let add = "overlap = \"add\"";
    let force = |effects: &str| {
        let scene = scene(effects).expect("a scene");
        let column = scene.run().column("xmax_reaction_x_N").expect("recorded");
        (column[column.len() - 1], scene.notes)
    };
    let (added, notes) = force(&(elastic("body", "soft", "") + &elastic("half", "stiff", add)));
    let (apart, _) = force(&(elastic("rest", "soft", "") + &elastic("half", "both", "")));
    // The two converge to the same equilibrium, to the tolerance of the solver
    assert!((added / apart - 1.0).abs() < 1e-9, "{added} {apart}");
    let (plain, _) = force(&elastic("body", "soft", ""));
    assert!(added > 1.5 * plain);
    let note = "the stiffnesses of two elastic effects add up in 48 cells (overlap = \"add\")";
    assert!(notes.iter().any(|n| n == note), "{notes:?}");

    let refused = |effects: &str| scene(effects).err().expect("refused");
    let twice = refused(&(elastic("body", "soft", "") + &elastic("half", "stiff", "")));
    let fact =
        "48 cells have the elastic effects 1 (region body, law soft, formulation displacement) and 2 (region half";
    assert!(twice.contains(fact) && twice.contains("overlap = \"add\""), "{twice}");
    let bare = refused(&(elastic("rest", "soft", "") + &elastic("half", "stiff", add)));
    let fact = "48 of 96 cells have no elastic effect, one of them at (";
    assert!(bare.contains(fact) && bare.contains("in 48 of them an effect with overlap = \"add\""), "{bare}");
}

/// Weights along two axes that are both zero, as inputs of a model or members of a family make them, are two.
#[test]
fn weights_of_zero_along_two_axes_are_no_repetition() {
    let weight = |name: &str, direction: &str| {
        format!(
            "[[effect]]\nkind = \"gravity\"\nname = \"{name}\"\nregion = \"body\"\ndensity = \"1 g/cm^3\"\n\
             direction = {direction}\nacceleration = \"0 m/s^2\"\n"
        )
    };
    let with =
        |direction: &str| block(here(), &(weight("down", "[0, 0, -1]") + &weight("other", direction))).map(|_| ());
    assert_eq!(with("[0, -1, 0]"), Ok(()));
    let said = with("[0, 0, -1]").expect_err("refused");
    assert!(said.contains("effect 1 is of the same kind on the same cells"), "{said}");
}

/// The public pneumatic finger: the stiff layer of its tutorial by the three rules, and the wall of its hollow.
#[test]
#[ignore = "reads public data outside of the project, from the folder that DUROMETER_SHARED names"]
fn the_stiff_layer_of_the_public_finger() {
    let file = tools::shared("data/robots/pneunetCut.vtk");
    let surface = tools::shared("data/robots/pneunetCavityCut.stl");
    let text = |rule: &str| {
        format!(
            r#"
[mesh]
file = "{}"
unit = "mm"
[mesh.regions]
layer = {{ kind = "box", min = ["-100 mm", "22.5 mm", "-8 mm"], max = ["-19 mm", "28 mm", "8 mm"], pick = "cells"{rule} }}
root = {{ kind = "box", min = ["-10 mm", "0 mm", "-20 mm"], max = ["0 mm", "30 mm", "20 mm"] }}
inner = {{ kind = "component", pick = "facets", which = "inner" }}
wall = {{ kind = "near", file = "{}", unit = "mm", tolerance = "1e-3 mm", pick = "facets", rule = "all" }}
[laws.rubber]
law = "neo_hookean"
E = "500 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "root"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#,
            file.display(),
            surface.display()
        )
    };
    let scene = |rule: &str| SceneBuilder::parse(&text(rule)).expect("a scene").build();
    for (rule, cells) in [("any", 763), ("centroid", 625), ("all", 9)] {
        let scene = scene(&format!(", rule = \"{rule}\"")).expect("a layer");
        assert_eq!(scene.regions["layer"].cells.len(), cells, "{rule}");
        assert_eq!(scene.regions["inner"].facets, scene.regions["wall"].facets);
        assert_eq!(scene.regions["inner"].facets.len(), 912);
    }
    let error = scene("").err().expect("no rule").to_string();
    assert!(error.contains("763 cells") && error.contains("625") && error.contains(": 9)"), "{error}");
}

/// Of two blocks one is held: the other one has a note with its place, also where it is held in part; none where both are held.
#[test]
fn a_part_that_nothing_holds_is_noted() {
    let mut mesh = structured::block(2, 2, 2, 0.02, 0.02, 0.02, Order::Linear);
    let mut other = structured::block(2, 2, 2, 0.02, 0.02, 0.02, Order::Linear);
    other.points.iter_mut().for_each(|p| p.x += 0.05);
    let first = mesh.points.len() as u32;
    mesh.points.extend(other.points);
    mesh.cells.extend(other.cells.iter().map(|node| node + first));
    mesh.facets.clear();
    mesh.regions.retain(|name, _| name == "body");
    let cells = mesh.cell_count() as u32;
    mesh.regions.get_mut("body").expect("the cells").cells = (0..cells).collect();
    let notes = |region: &str, components: &str| {
        let text = format!(
            "[mesh]\nbody = \"blocks\"\n[mesh.regions.one]\nkind = \"box\"\nmin = [\"-1 mm\", \"-1 mm\", \"-1 mm\"]\nmax = [\"1 mm\", \"21 mm\", \"21 mm\"]\npick = \"nodes\"\n\
             [mesh.regions.two]\nkind = \"box\"\nmin = [\"49 mm\", \"-1 mm\", \"-1 mm\"]\nmax = [\"51 mm\", \"21 mm\", \"21 mm\"]\npick = \"nodes\"\n\
             [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"1 MPa\"\nnu = 0.3\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
             [[constraint]]\nkind = \"fixed\"\nregion = \"one\"\n[[constraint]]\nkind = \"fixed\"\nregion = \"{region}\"\ncomponents = \"{components}\"\n\
             [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n[[probe]]\nkind = \"position\"\nregion = \"two\"\n"
        );
        let scene = crate::common::scene(mesh.clone(), &text);
        scene.notes.iter().filter(|note| note.contains("its place is arbitrary")).cloned().collect::<Vec<_>>()
    };
    let [note] = &notes("one", "xyz")[..] else { panic!("one note") };
    assert!(note.starts_with("no constraint holds the part of the body around (60, 10, 10) mm"), "{note}");
    let [note] = &notes("two", "x")[..] else { panic!("one note") };
    assert!(note.starts_with("what is held of the part around (60, 10, 10) mm leaves 3 of the six"), "{note}");
    assert!(notes("two", "xyz").is_empty());
}

/// A body whose supports leave rigid motions free has a note that counts them; one that is held at three points has none.
#[test]
fn motions_that_supports_leave_free_are_noted() {
    let held = |regions: &[(&str, &str)]| {
        let tables = regions.iter().map(|(region, components)| {
            format!("[[constraint]]\nkind = \"fixed\"\nregion = \"{region}\"\ncomponents = \"{components}\"\n")
        });
        let text = format!(
            "[mesh]\nbody = \"block\"\n[laws.rubber]\nlaw = \"neo_hookean\"\nE = \"1 MPa\"\nnu = 0.3\n[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n{}\n\
             [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n[[probe]]\nkind = \"position\"\nregion = \"xmax\"\n",
            tables.collect::<String>()
        );
        let scene = crate::common::scene(structured::block(2, 2, 2, 0.02, 0.02, 0.02, Order::Linear), &text);
        scene.notes.iter().find(|note| note.starts_with("what is held leaves")).cloned()
    };
    let free = |count: usize, found: Option<String>| {
        let start = format!("what is held leaves {count} of the six rigid motions free");
        assert!(found.as_ref().is_some_and(|note| note.starts_with(&start)), "{count}: {found:?}");
    };
    free(3, held(&[("zmin", "z")]));
    free(1, held(&[("zmin", "z"), ("ymin", "y")]));
    assert!(
        held(&[("zmin", "z"), ("ymin", "y")])
            .is_some_and(|note| note.contains("moves along (1, 0, 0)") || note.contains("moves along (-1, 0, 0)"))
    );
    assert_eq!(held(&[("zmin", "z"), ("ymin", "y"), ("xmin", "x")]), None);
    assert_eq!(held(&[("xmin", "xyz")]), None);
}

/// A layer at a whole flat face has its extent, however large its tolerance is against an edge. One that reaches further names the tolerance that would do, and one within the
/// body ends within cells.
#[test]
fn a_layer_that_holds_a_flat_face_does_not_depend_on_the_mesh() {
    let layer = |at: f64, tolerance: f64, pick: &str| {
        let text = format!(
            r#"layer = {{ kind = "plane", point = ["{at} mm", "0 mm", "0 mm"], normal = [1, 0, 0], tolerance = "{tolerance} mm", {pick} }}"#
        );
        let scene = block(here(), &text).expect("a layer");
        (scene.regions["layer"].depends_on_mesh, scene.notes.iter().any(|note| note.contains("with tolerance = ")))
    };
    for pick in [r#"pick = "facets", rule = "all""#, r#"pick = "nodes""#, r#"pick = "cells", rule = "any""#] {
        let is_grown = pick.contains("any");
        // Edges along x are 10 mm long
        for tolerance in [0.0, 1e-3, 0.1, 4.0] {
            assert_eq!(layer(0.0, tolerance, pick), (is_grown, false), "{pick} {tolerance}");
        }
    }
    let facets = r#"pick = "facets", rule = "all""#;
    assert_eq!(layer(0.0, 12.0, facets), (true, true), "a row of boxes, and the face alone with less");
    assert_eq!(layer(5.0, 7.0, facets), (true, false), "its middle plane holds nothing");
}
