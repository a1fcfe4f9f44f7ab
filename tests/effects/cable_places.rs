//! Places of cables that are doubtful: guides that are held, patches that reach across a slit or are cut by a plane of symmetry, pull points in the body.

use crate::common::scene;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::scene::{Scene, SceneError, parse_scene};

/// A bar of 60 mm with a cable of these keys; the region `root` is its first half.
fn text(mesh: &str, keys: &str, pull: &str) -> String {
    format!(
        "[mesh]\n{mesh}\nregions.root = {{ kind = \"box\", min = [\"-1 mm\", \"-1 mm\", \"-1 mm\"], max = [\"31 mm\", \"11 mm\", \"11 mm\"] }}\n\
         [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.4\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
         [[constraint]]\nkind = \"cable\"\nguide_radius = \"3 mm\"\n{keys}\n\
         drive = {{ kind = \"length\", signal = {{ kind = \"ramp\", from = \"0 mm\", to = \"{pull}\", end = \"1 s\" }} }}\n\
         [[constraint]]\nkind = \"fixed\"\nregion = \"root\"\n\
         [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.5 s\"\n"
    )
}

const BAR: &str = "grid = { kind = \"box\", size = [\"60 mm\", \"10 mm\", \"10 mm\"], divisions = [12, 2, 2] }";

fn bar(guides: &[f64], keys: &str, pull: &str) -> Result<Scene, SceneError> {
    let at = |x: &f64| format!("[\"{x} mm\", \"5 mm\", \"5 mm\"]");
    let guides: Vec<String> = guides.iter().map(at).collect();
    let keys = format!("pull_point = [\"-10 mm\", \"5 mm\", \"5 mm\"]\nguides = [{}]\n{keys}", guides.join(", "));
    parse_scene(&text(BAR, &keys, pull))
}

/// Between points that are held a cable has the length that it has. The part of the body that is held comes after the cable in the scene.
#[test]
fn a_cable_between_held_guides_cannot_get_shorter() {
    for keys in ["", "friction = 0.2", "max_tension = \"1 N\""] {
        let why = bar(&[5.0, 20.0], keys, "2 mm").err().unwrap_or_else(|| panic!("{keys} is taken")).to_string();
        assert!(why.contains("only 0.0000 mm of it can get shorter: all of its guides are held"), "{keys}: {why}");
    }
    // From the pull point to the second guide it is held, 30 mm; the other 30 mm are those of the body that moves.
    let why = bar(&[5.0, 20.0, 50.0], "", "31 mm").err().expect("too much").to_string();
    assert!(
        why.contains("shortened by 31.0000 mm at t = 1.0000 s, and only 30.0000 mm of it can get shorter"),
        "{why}"
    );
    for (guides, keys) in [(&[5.0, 20.0, 50.0][..], ""), (&[5.0, 20.0], "EA = \"10 N\"")] {
        let run = bar(guides, keys, "2 mm").unwrap_or_else(|e| panic!("{e}")).run();
        assert_eq!(run.status, durometer::solve::Status::Converged, "{guides:?} {keys}");
    }
}

/// A bar that is slit along its middle plane from x = 25 mm on: nodes there are doubled.
fn slit() -> TetMesh {
    let mut mesh = block(12, 2, 4, 0.06, 0.01, 0.01, Order::Linear);
    let is_cut = |x: f64, z: f64| x > 0.0251 && (z - 0.005).abs() < 1e-9;
    for node in 0..mesh.points.len() as u32 {
        let at = mesh.points[node as usize];
        if !is_cut(at.x, at.z) {
            continue;
        }
        mesh.points.push(at);
        let copy = mesh.points.len() as u32 - 1;
        for cell in mesh.cells.chunks_mut(4) {
            let middle = cell.iter().map(|&k| mesh.points[k as usize].z).sum::<f64>() / 4.0;
            if middle > 0.005 {
                cell.iter_mut().filter(|k| **k == node).for_each(|k| *k = copy);
            }
        }
        for facet in mesh.facets.chunks_mut(3) {
            let middle = facet.iter().map(|&k| mesh.points[k as usize].z).sum::<f64>() / 3.0;
            if middle > 0.005 {
                facet.iter_mut().filter(|k| **k == node).for_each(|k| *k = copy);
            }
        }
    }
    mesh
}

/// A ball of 3 mm around z = 3.5 mm reaches 1.5 mm across the slit at 5 mm, one around 1.9 mm ends before it. Where the body is whole, nothing is noted.
#[test]
fn a_patch_across_a_slit_is_noted() {
    let notes = |mesh: TetMesh, x: f64, z: f64| {
        let keys = format!(
            "pull_point = [\"-10 mm\", \"5 mm\", \"{z} mm\"]\nguides = [[\"10 mm\", \"5 mm\", \"{z} mm\"], [\"{x} mm\", \"5 mm\", \"{z} mm\"]]"
        );
        let scene = scene(mesh, &text("body = \"block\"", &keys, "1 mm"));
        scene.notes.iter().filter(|note| note.contains("across a gap")).cloned().collect::<Vec<_>>()
    };
    let found = notes(slit(), 45.0, 3.5);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].contains("cable: guides whose patches reach across a gap: guide 2 at ")
            && !found[0].contains("guide 1"),
        "{}",
        found[0]
    );
    let whole = block(12, 2, 4, 0.06, 0.01, 0.01, Order::Linear);
    for (mesh, z) in [(slit(), 1.9), (whole, 3.5)] {
        assert_eq!(notes(mesh, 45.0, z), Vec::<String>::new());
    }
}

/// A pull point is fixed in space: inside a part that moves it is noted, in front of the body and in a part that is held it is not.
#[test]
fn a_pull_point_in_the_body_is_noted() {
    let guides = "guides = [[\"45 mm\", \"5 mm\", \"5 mm\"], [\"55 mm\", \"5 mm\", \"5 mm\"]]";
    for (pull, expected) in [("38 mm", true), ("20 mm", false), ("-10 mm", false)] {
        let keys = format!("pull_point = [\"{pull}\", \"5 mm\", \"5 mm\"]\n{guides}");
        let scene = parse_scene(&text(BAR, &keys, "1 mm")).unwrap_or_else(|e| panic!("{e}"));
        let noted = scene.notes.iter().any(|note| note.contains("lies in the body, which moves through it"));
        assert_eq!(noted, expected, "{pull}: {:?}", scene.notes);
    }
}

/// A plane on which one component alone is held is one of symmetry: a ball that it cuts has other weights than half of a whole one. The first half of the bar is
/// held in all components, a ball of 3 mm around y = 5 mm does not reach the plane, and a cable through points has no ball.
#[test]
fn a_patch_that_a_plane_of_symmetry_cuts_is_noted() {
    let held = "[[constraint]]\nkind = \"fixed\"\nregion = \"ymin\"\ncomponents = \"y\"\n";
    let force = "[[effect]]\nkind = \"point_force\"\npoint = [\"50 mm\", \"0 mm\", \"5 mm\"]\nradius = \"3 mm\"\ndirection = [0, 0, 1]\nforce = \"1 mN\"\n";
    let notes = |y: f64, radius: &str, more: &str| {
        let at = |x: f64| format!("[\"{x} mm\", \"{y} mm\", \"5 mm\"]");
        let keys = format!("pull_point = {}\nguides = [{}, {}, {}]", at(-10.0), at(10.0), at(45.0), at(55.0));
        let text = text(BAR, &keys, "1 mm").replace("\"3 mm\"", &format!("\"{radius}\"")) + more;
        let scene = parse_scene(&text).unwrap_or_else(|e| panic!("{e}"));
        scene.notes.iter().filter(|note| note.contains("cut by a plane")).cloned().collect::<Vec<_>>()
    };
    let found = notes(0.0, "3 mm", &format!("{held}{force}"));
    let cut = "patches that are cut by a plane on which one component is held:";
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].starts_with(&format!("cable: {cut} guide 2 by y = 0.0000 mm")), "{found:?}");
    assert!(found[0].contains("guide 3 by y") && found[0].contains("guide_radius = \"point\""), "{found:?}");
    assert!(
        found[1].starts_with(&format!("point_force: {cut} the one at (50, 0, 5) mm by y = 0.0000 mm")),
        "{found:?}"
    );
    for (y, radius, more) in [(0.0, "3 mm", ""), (5.0, "3 mm", held), (0.0, "point", held)] {
        assert_eq!(notes(y, radius, more), Vec::<String>::new(), "{y} mm, {radius}");
    }
}
