//! Cavities within a closed surface from a file: on the facets where it lies on them, mapped to the body where it does not.

use crate::common::tools;
use durometer::effect::{Cavity, CavityPressure, VolumeField};
use durometer::math::random::SplitMix;
use durometer::math::signal::Signal;
use durometer::math::statistics::larger;
use durometer::math::tensor::Vec3;
use durometer::mesh::attach::attach;
use durometer::mesh::boundary::boundary_facets;
use durometer::mesh::closed_surface::{closed, enclosed};
use durometer::mesh::enrich::Enriched;
use durometer::mesh::structured::block;
use durometer::mesh::surface_file::Surface;
use durometer::mesh::{Order, Region, TetMesh};
use durometer::scene::{Run, Scene, SceneBuilder};
use durometer::solve::Status;
use durometer::system::{At, BlockValues, Effect, Rates, Want};
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Arc;

/// Edge of a unit of the body \[m\].
const UNIT: f64 = 8e-3;

/// A bar of 5 × 3 × 3 units of 8 mm, hollow in the middle, with `fine` boxes along each edge of a unit.
fn bar(fine: usize, order: Order) -> TetMesh {
    let [nx, ny, nz] = [5, 3, 3].map(|n| n * fine);
    hollowed(&block(nx, ny, nz, 5.0 * UNIT, 3.0 * UNIT, 3.0 * UNIT, order))
}

/// A block without the cells in the middle of the bar.
fn hollowed(whole: &TetMesh) -> TetMesh {
    let order = whole.order;
    let nodes = order.cell_nodes();
    let middle = |cell: &[u32]| cell[..4].iter().map(|&k| whole.points[k as usize]).sum::<Vec3>() / 4.0;
    let is_hollow =
        |p: Vec3| p.x > UNIT && p.x < 4.0 * UNIT && [p.y, p.z].iter().all(|v| (UNIT..2.0 * UNIT).contains(v));
    let kept: Vec<&[u32]> = whole.cells.chunks(nodes).filter(|cell| !is_hollow(middle(cell))).collect();
    let mut numbers = HashMap::new();
    let (mut points, mut cells) = (vec![], vec![]);
    for &node in kept.iter().copied().flatten() {
        cells.push(*numbers.entry(node).or_insert_with(|| {
            points.push(whole.points[node as usize]);
            points.len() as u32 - 1
        }));
    }
    // The facets of the surface: faces that one cell has
    let facet = order.facet_nodes();
    let mut faces: BTreeMap<[u32; 3], Option<Vec<u32>>> = BTreeMap::new();
    for cell in cells.chunks(nodes) {
        for face in durometer::mesh::element::CELL_FACES {
            let face: Vec<u32> = face[..facet].iter().map(|&k| cell[k]).collect();
            let mut key = [face[0], face[1], face[2]];
            key.sort_unstable();
            faces.entry(key).and_modify(|f| *f = None).or_insert(Some(face));
        }
    }
    let facets: Vec<u32> = faces.into_values().flatten().flatten().collect();
    let body = Region { cells: (0..(cells.len() / nodes) as u32).collect(), ..Region::default() };
    TetMesh { order, points, cells, facets, regions: [("body".to_string(), body)].into() }
}

/// The wall of the hollow of the bar, which it has in the mesh.
fn wall(mesh: &TetMesh) -> Surface {
    let inside = |k: u32| {
        let p = mesh.points[k as usize];
        p.x > 0.5 * UNIT && p.x < 4.5 * UNIT && [p.y, p.z].iter().all(|v| *v > 0.5 * UNIT && *v < 2.5 * UNIT)
    };
    let corners = |f: u32| [0, 1, 2].map(|k| mesh.facet(f as usize)[k]);
    let triangles = boundary_facets(mesh).into_iter().map(corners).filter(|t| t.iter().all(|&k| inside(k))).collect();
    Surface { points: mesh.points.clone(), triangles }
}

/// The same wall by other triangles, with so many divisions of the long and of the short edges.
fn other_wall([long, short]: [usize; 2]) -> Surface {
    let grid = block(long, short, short, 3.0 * UNIT, UNIT, UNIT, Order::Linear);
    let corners: Vec<u32> =
        boundary_facets(&grid).iter().flat_map(|&f| [0, 1, 2].map(|k| grid.facet(f as usize)[k])).collect();
    let mut used = corners.clone();
    used.sort_unstable();
    used.dedup();
    let number = |k: &u32| used.binary_search(k).expect("a corner") as u32;
    let triangles = corners.chunks(3).map(|t| [number(&t[0]), number(&t[1]), number(&t[2])]).collect();
    // Mirrored, so that the diagonals are the other ones too
    let place = |p: Vec3| Vec3::new(4.0 * UNIT - p.x, UNIT + p.y, UNIT + p.z);
    let points = used.iter().map(|&k| place(grid.points[k as usize])).collect();
    Surface { points, triangles }
}

fn write(path: &Path, surface: &Surface) {
    let vertex = |p: &Vec3| format!("v {:e} {:e} {:e}\n", p.x * 1e3, p.y * 1e3, p.z * 1e3);
    let face = |t: &[u32; 3]| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    let text: String = surface.points.iter().map(vertex).chain(surface.triangles.iter().map(face)).collect();
    std::fs::write(path, text).expect("writable");
}

const WALLS: &str = r#"
inner = { kind = "component", pick = "facets", which = "inner" }
outer = { kind = "component", pick = "facets", which = "outer" }
"#;

/// The bar, held at one end, with a cavity.
fn scene(folder: &Path, mesh: TetMesh, cavity: &str) -> Result<Scene, String> {
    scene_of(folder, mesh, (WALLS, "0.01 mm"), cavity)
}

/// A body, held at one end, with these regions and a cavity; its skin has this reach.
fn scene_of(folder: &Path, mesh: TetMesh, (regions, reach): (&str, &str), cavity: &str) -> Result<Scene, String> {
    let text = format!(
        r#"
[mesh]
body = "block"
[mesh.regions]
root = {{ kind = "plane", point = ["0 mm", "0 mm", "0 mm"], normal = [1, 0, 0], tolerance = "0.01 mm" }}
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
region = "root"
[[skin]]
name = "air"
file = "air.obj"
unit = "mm"
reach = "{reach}"
[[constraint]]
kind = "cavity"
{cavity}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[numerics]
tolerance = 1e-12
"#
    );
    let builder = SceneBuilder::parse(&text).map_err(|e| e.to_string())?;
    builder.file(folder.join("scene.toml")).mesh(mesh).build().map_err(|e| e.to_string())
}

const PRESSURE: &str =
    r#"drive = { kind = "pressure", signal = { kind = "ramp", from = "0 kPa", to = "8 kPa", end = "1 s" } }"#;
const VOLUME: &str =
    r#"drive = { kind = "volume", signal = { kind = "ramp", from = "0 mm^3", to = "300 mm^3", end = "1 s" } }"#;

fn solved(scene: &Scene) -> Run {
    let run = scene.run();
    assert_eq!(run.status, Status::Converged);
    run
}

/// On the facets the skin is another name of the region: pressure and volume are the same to the last bit, and so within 1e-10.
#[test]
fn a_skin_on_the_facets_is_the_region() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for order in [Order::Linear, Order::Quadratic] {
        let mesh = bar(1, order);
        let mut surface = wall(&mesh);
        // Off by less than the reach, and turned the other way
        surface.points.iter_mut().enumerate().for_each(|(k, p)| p.y += 3e-6 * (k % 3) as f64);
        surface.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        write(&folder.path().join("air.obj"), &surface);
        for drive in [PRESSURE, VOLUME] {
            let of = |wall: &str| scene(folder.path(), mesh.clone(), &format!("{wall}\n{drive}")).expect("a scene");
            let (region, skin) = (of("region = \"inner\""), of("skin = \"air\""));
            let note = format!("cavity: the skin air lies on {} facets, which are its wall", surface.triangles.len());
            assert!(skin.notes.contains(&note), "{:?}", skin.notes);
            let (region, skin) = (solved(&region), solved(&skin));
            for column in ["cavity_pressure_Pa", "cavity_volume_m3"] {
                assert_eq!(region.column(column), skin.column(column), "{order:?} {column}");
            }
        }
    }
}

/// V ↔ ∂V/∂x ↔ ∂²V/∂x² of a mapped surface; the work on the nodes is p dV; a closed surface neither pushes nor turns. V is a cubic of the
/// step, so Richardson's central differences are exact to rounding.
#[test]
fn volume_force_and_tangent_are_dual() {
    for order in [Order::Linear, Order::Quadratic] {
        let mesh = bar(1, order);
        let mut surface = other_wall([4, 2]);
        // Some vertices inside the wall, some in the hollow
        let mut random = SplitMix(3);
        let mut around = |size: f64| size * (2.0 * random.unit() - 1.0);
        surface.points.iter_mut().for_each(|p| *p += Vec3::from_fn(|_, _| around(0.3e-3)));
        let triangles = closed(&surface).expect("closed");
        let attached = attach(&mesh, &surface.points, 1e-3).expect("near enough");
        assert!(attached.iter().any(|a| a.outside > 1e-5) && attached.iter().any(|a| a.outside == 0.0));
        let weights: Vec<_> = attached.into_iter().map(|a| a.weights).collect();
        let field = VolumeField::cones(Vec3::new(0.01, -0.02, 0.005));
        let cavity = Arc::new(Cavity::on_surface("c".into(), (&surface.points, &triangles), &weights, field));
        let n = 3 * mesh.points.len();
        let rest = cavity.volume(&vec![0.0; n]);
        assert!((rest / enclosed(&surface.points, &triangles) - 1.0).abs() < 1e-12);
        let mut list = |size: f64| (0..n).map(|_| around(size)).collect::<Vec<f64>>();
        let (x, dx) = (list(0.5e-3), list(1e-3));
        let moved = |s: f64| x.iter().zip(&dx).map(|(x, d)| x + s * d).collect::<Vec<f64>>();
        let slope = |s: f64| (cavity.volume(&moved(s)) - cavity.volume(&moved(-s))) / (2.0 * s);
        let exact = (4.0 * slope(0.5) - slope(1.0)) / 3.0;
        let gradient = |x: &[f64]| {
            let mut full = vec![0.0; n];
            cavity.volume_gradient(x).iter().for_each(|(dof, g)| full[*dof as usize] += g);
            full
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let g = gradient(&x);
        assert!((dot(&g, &dx) / exact - 1.0).abs() < 1e-10, "{order:?}: {} against {exact}", dot(&g, &dx));
        // Resultant and moment about the deformed places
        let forces: Vec<Vec3> = g.chunks(3).map(Vec3::from_column_slice).collect();
        let places: Vec<Vec3> =
            mesh.points.iter().zip(x.chunks(3)).map(|(p, u)| p + Vec3::from_column_slice(u)).collect();
        let size: f64 = forces.iter().map(|f| f.norm()).sum();
        assert!(forces.iter().sum::<Vec3>().norm() < 1e-13 * size);
        let moment: Vec3 = places.iter().zip(&forces).map(|(p, f)| p.cross(f)).sum();
        assert!(moment.norm() < 1e-13 * size * 0.04, "{moment}");
        // The load −p V: residual −p ∂V/∂x, tangent by differences of it
        let load = CavityPressure { cavity: cavity.clone(), pressure: Signal::Constant(2.0) };
        let mut product = vec![0.0; n];
        for b in 0..load.blocks().len() {
            let dofs: Vec<usize> = load.blocks().dofs(b).map(|d| d as usize).collect();
            let mut values = BlockValues::new(dofs.len());
            let none = vec![0.0; n];
            let (v, a) = (&none, &none);
            let at = At { t: 1.0, dt: 1.0, x: &x, v, a, old: &x, history: &[], inputs: &[], rates: Rates::default() };
            load.eval(&at, b, Want::Tangent, &mut values).expect("regular");
            let m = dofs.len();
            for row in 0..m {
                for column in 0..m {
                    let k = values.k[row.max(column) * m + row.min(column)];
                    product[dofs[row]] += k * dx[dofs[column]];
                }
            }
        }
        let (plus, minus) = (gradient(&moved(0.5)), gradient(&moved(-0.5)));
        // The gradient is quadratic: central differences of it are exact
        let scale = product.iter().fold(0.0, |s, v| larger(s, v.abs()));
        for k in 0..n {
            let difference = -2.0 * (plus[k] - minus[k]);
            assert!((product[k] - difference).abs() < 1e-10 * scale, "{order:?} {k}: {} {difference}", product[k]);
        }
    }
}

/// Growth of the volume under the pressure, with the notes of the scene.
fn growth(folder: &Path, mesh: TetMesh, wall: &str) -> (f64, Scene) {
    let scene = scene(folder, mesh, &format!("{wall}\n{PRESSURE}")).expect("a scene");
    let run = solved(&scene);
    let volume = run.column("cavity_volume_m3").expect("recorded");
    (volume[volume.len() - 1] - volume[0], scene)
}

/// Triangles of their own on the same wall, fine ones and coarse ones that are divided: the growth of the volume under a pressure tends to that on the facets with
/// the second order.
#[test]
fn a_mapped_skin_converges_to_the_facets() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let errors = |skin: &dyn Fn(usize) -> [usize; 2]| -> Vec<f64> {
        let of_mesh = |fine: usize| {
            write(&folder.path().join("air.obj"), &other_wall(skin(fine)));
            let of = |wall: &str| {
                let (growth, scene) = growth(folder.path(), bar(fine, Order::Linear), wall);
                let note = scene.notes.iter().any(|n| n.contains("lie on no facet; it follows the body"));
                assert_eq!(note, wall.starts_with("skin"), "{:?}", scene.notes);
                assert_eq!(scene.no_limit, None);
                growth
            };
            let (skin, facets) = (of("skin = \"air\""), of("region = \"inner\""));
            (skin / facets - 1.0).abs()
        };
        [1, 2, 4].into_iter().map(of_mesh).collect()
    };
    for errors in [errors(&|fine| [4 * fine, fine]), errors(&|_| [4, 1])] {
        println!("{errors:?}");
        assert!(errors[1] < 0.5 * errors[0] && errors[2] < 0.4 * errors[1] && errors[2] < 0.02, "{errors:?}");
    }
}

/// The facets of the coarsest mesh as a skin: on meshes whose cells are split it acts on the parts of these facets, as the region does.
#[test]
fn a_skin_on_the_facets_is_the_region_at_every_level() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (order, levels) in [(Order::Linear, 2), (Order::Quadratic, 1)] {
        let mut mesh = bar(1, order);
        write(&folder.path().join("air.obj"), &wall(&mesh));
        for level in 0..=levels {
            let of = |wall: &str| growth(folder.path(), mesh.clone(), wall).0;
            let (skin, region) = (of("skin = \"air\""), of("region = \"inner\""));
            assert!((skin / region - 1.0).abs() < 1e-9, "{order:?}, level {level}: {skin} and {region}");
            mesh = Enriched::by_splitting(&mesh).mesh;
        }
    }
}

/// Between its vertices a coarse skin of a round hollow is further off the body than these may be.
#[test]
fn a_skin_that_leaves_the_body_between_its_vertices_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut round = bar(4, Order::Linear);
    let middle = Vec3::new(2.5, 1.5, 1.5) * UNIT;
    let bulge = |p: &Vec3| {
        let part = |d: usize, half: f64| (1.0 - ((p[d] - middle[d]) / (half * UNIT)).powi(2)).max(0.0);
        let across = Vec3::new(0.0, p.y - middle.y, p.z - middle.z);
        *p + across * (0.3 * part(0, 2.5) * part(1, 1.5).powi(2) * part(2, 1.5).powi(2))
    };
    let mut coarse = other_wall([1, 1]);
    coarse.points.iter_mut().for_each(|p| *p = bulge(p));
    round.points.iter_mut().for_each(|p| *p = bulge(p));
    write(&folder.path().join("air.obj"), &coarse);
    let said = scene(folder.path(), round, &format!("skin = \"air\"\n{PRESSURE}")).err().expect("refused");
    assert!(said.contains("between its vertices the skin \"air\" leaves the body: at "), "{said}");
    assert!(said.contains("by more than reach = 0.0100 mm, the furthest by "), "{said}");
}

/// The triangles that close an open surface, between its rim and a corner of it.
fn cap(surface: &Surface) -> Vec<[u32; 3]> {
    let mut sides: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for [a, b, c] in &surface.triangles {
        [[a, b], [b, c], [c, a]].iter().for_each(|[a, b]| *sides.entry([**a.min(b), **a.max(b)]).or_default() += 1);
    }
    let rim: Vec<[u32; 2]> = sides.into_iter().filter(|(_, count)| *count == 1).map(|(side, _)| side).collect();
    let sum = |k: u32| surface.points[k as usize].sum();
    let corner = rim.iter().flatten().copied().min_by(|a, b| sum(*a).total_cmp(&sum(*b))).expect("a rim");
    rim.into_iter().filter(|side| !side.contains(&corner)).map(|[a, b]| [corner, a, b]).collect()
}

/// A half of the bar up to its middle plane, where the hollow is open. A surface that is closed by a cap there is the wall without the cap, to the bits of the
/// region, where the plane is held. It is refused where the plane is free, since the cap would follow the body, and where the other triangles lie on no facets.
#[test]
fn a_cap_in_a_plane_of_symmetry_is_no_wall() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let regions = r#"
middle = { kind = "plane", point = ["0 mm", "12 mm", "0 mm"], normal = [0, 1, 0], tolerance = "0.01 mm" }
inner = { kind = "box", min = ["7.9 mm", "7.9 mm", "7.9 mm"], max = ["32.1 mm", "12.1 mm", "16.1 mm"], pick = "facets", rule = "all" }
"#;
    let symmetric = "\n[[constraint]]\nkind = \"fixed\"\nregion = \"middle\"\ncomponents = \"y\"\n[[probe]]\nkind = \"reaction\"\nregion = \"middle\"\n";
    for order in [Order::Linear, Order::Quadratic] {
        let mesh = hollowed(&block(10, 3, 6, 5.0 * UNIT, 1.5 * UNIT, 3.0 * UNIT, order));
        let is_in = |p: &Vec3| {
            let is_within = |v: f64, low: f64, high: f64| v > low * UNIT - 1e-6 && v < high * UNIT + 1e-6;
            is_within(p.x, 1.0, 4.0) && is_within(p.y, 1.0, 1.5) && is_within(p.z, 1.0, 2.0)
        };
        let corners = |f: u32| [0, 1, 2].map(|k| mesh.facet(f as usize)[k]);
        let is_wall = |t: &[u32; 3]| t.iter().all(|&k| is_in(&mesh.points[k as usize]));
        let triangles = boundary_facets(&mesh).into_iter().map(corners).filter(is_wall).collect();
        let mut surface = Surface { points: mesh.points.clone(), triangles };
        let caps = cap(&surface);
        surface.triangles.extend(&caps);
        write(&folder.path().join("air.obj"), &surface);
        let within = |reach: &str, cavity: &str| scene_of(folder.path(), mesh.clone(), (regions, reach), cavity);
        let of = |cavity: &str| within("0.01 mm", cavity);
        for drive in [PRESSURE.to_string(), VOLUME.replace("300", "100")] {
            let [region, skin] = ["region = \"inner\"", "skin = \"air\""]
                .map(|wall| of(&format!("{wall}\n{drive}{symmetric}")).expect("a scene"));
            let note = format!("{} of {} triangles of the skin air close it", caps.len(), surface.triangles.len());
            let is_told = |n: &String| n.contains(&note) && n.contains("(y = 12.0000 mm)");
            assert!(skin.notes.iter().any(is_told), "{:?}", skin.notes);
            let (region, skin) = (solved(&region), solved(&skin));
            for column in ["cavity_pressure_Pa", "cavity_volume_m3", "middle_reaction_y_N"] {
                assert_eq!(region.column(column), skin.column(column), "{order:?} {column}");
            }
        }
        let said = of(&format!("skin = \"air\"\n{PRESSURE}")).err().expect("refused");
        assert!(said.contains("leaves the body: at "), "{said}");
        // Triangles of their own, with a cap within the reach
        let mut other = other_wall([4, 1]);
        other.points.iter_mut().for_each(|p| p.y = 0.5 * (p.y + UNIT));
        write(&folder.path().join("air.obj"), &other);
        let said = within("5 mm", &format!("skin = \"air\"\n{PRESSURE}{symmetric}")).err().expect("refused");
        assert!(said.contains("and the others lie on no facets"), "{said}");
    }
}

#[test]
fn bad_skins_are_refused_with_a_place() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let refused = |surface: &Surface, wall: &str| {
        write(&folder.path().join("air.obj"), surface);
        scene(folder.path(), bar(1, Order::Linear), &format!("{wall}\n{PRESSURE}")).err().expect("refused")
    };
    let whole = other_wall([4, 1]);
    let mut open = whole.clone();
    open.triangles.remove(0);
    let said = refused(&open, "skin = \"air\"");
    assert!(said.contains("the skin \"air\" is not closed: 3 edges are open, one of them at ("), "{said}");
    let mut far = whole.clone();
    far.points.iter_mut().for_each(|p| *p += Vec3::new(0.0, 0.5e-3, 0.5e-3));
    let said = refused(&far, "skin = \"air\"");
    assert!(
        said.contains(" vertices are further outside of the body than reach = 0.01 mm, the furthest by 0.5000 mm"),
        "{said}"
    );
    // All but one triangle of the wall, which the mesh could close
    let mut hole = wall(&bar(1, Order::Linear));
    hole.triangles.remove(5);
    let said = refused(&hole, "skin = \"air\"");
    assert!(said.contains("\"air\" is open, and its rim is free, or moved, at ("), "{said}");
    let said = refused(&whole, "skin = \"air\"\nregion = \"inner\"");
    assert!(said.contains("a cavity has one wall"), "{said}");
    let said = refused(&whole, "skin = \"aire\"");
    assert!(said.contains("there is no skin \"aire\"; did you mean `air`?"), "{said}");
    let outer = block(2, 1, 1, 5.0 * UNIT, 3.0 * UNIT, 3.0 * UNIT, Order::Linear);
    let triangles = boundary_facets(&outer).iter().map(|&f| [0, 1, 2].map(|k| outer.facet(f as usize)[k])).collect();
    let said = refused(&Surface { points: outer.points.clone(), triangles }, "skin = \"air\"");
    assert!(said.contains("has the body inside of it"), "{said}");
}

/// Facets that belong to two cavities, and more air than there is, are refused; a vacuum, which lets walls through each other, has a note.
#[test]
fn what_a_cavity_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write(&folder.path().join("air.obj"), &other_wall([4, 1]));
    let of = |cavity: &str| scene(folder.path(), bar(1, Order::Linear), cavity);
    let inner = |drive: &str| format!("region = \"inner\"\n{drive}");
    let said = of(&inner(&VOLUME.replace("300 mm^3", "-1600 mm^3"))).err().expect("refused");
    assert!(said.contains("1.6000 ml are taken out at t = 1.0000 s, and the cavity holds 1.5360 ml"), "{said}");
    assert!(of(&inner(&VOLUME.replace("300 mm^3", "-1500 mm^3"))).is_ok());
    let twice = format!("{}\n[[constraint]]\nkind = \"cavity\"\nname = \"other\"\n{}", inner(PRESSURE), inner(VOLUME));
    let said = of(&twice).err().expect("refused");
    assert!(said.contains("facets are those of cavity too, and the pressures would add up there"), "{said}");
    // The skin, which lies on no facets, has the same wall.
    for other in ["skin = \"air\"", "region = \"inner\""] {
        let twice = format!(
            "skin = \"air\"\n{PRESSURE}\n[[constraint]]\nkind = \"cavity\"\nname = \"other\"\n{other}\n{VOLUME}"
        );
        let said = of(&twice).err().expect("refused");
        assert!(said.contains("are those of cavity too, and the pressures would add up there"), "{other}: {said}");
    }
    let vacuum = of(&inner(&PRESSURE.replace("8 kPa", "-8 kPa"))).expect("a scene");
    let note = |scene: &Scene| {
        scene.notes.iter().any(|n| n.contains("cavity is under a vacuum of 8.0000 kPa at t = 1.0000 s"))
    };
    assert!(note(&vacuum) && !note(&of(&inner(PRESSURE)).expect("a scene")), "{:?}", vacuum.notes);
    // A contact of other parts of the surface keeps no wall of the cavity apart.
    let contact_of = |region: &str| {
        let contact = format!(
            "\n[[contact]]\nname = \"itself\"\nregion = \"{region}\"\nobstacle = {{ kind = \"region\", region = \"{region}\" }}\n\
             response = \"barrier\"\nfriction = 0\ndistance = \"0.01 mm\"\n"
        );
        of(&(inner(&PRESSURE.replace("8 kPa", "-8 kPa")) + &contact)).expect("a scene")
    };
    assert!(note(&contact_of("outer")) && !note(&contact_of("inner")));
}

/// The public pneumatic finger and the surface that belongs to it.
#[test]
#[ignore = "reads public data outside of the project, from the folder that DUROMETER_SHARED names"]
fn the_cavity_of_the_public_finger_lies_on_its_facets() {
    let (mesh, surface) =
        (tools::shared("data/robots/pneunetCut.vtk"), tools::shared("data/robots/pneunetCavityCut.stl"));
    let run = |wall: &str| {
        let text = format!(
            r#"
[mesh]
file = "{}"
unit = "mm"
[mesh.regions]
root = {{ kind = "box", min = ["-10 mm", "0 mm", "-20 mm"], max = ["0 mm", "30 mm", "20 mm"] }}
inner = {{ kind = "component", pick = "facets", which = "inner" }}
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
[[skin]]
name = "air"
file = "{}"
unit = "mm"
reach = "0.001 mm"
[[constraint]]
kind = "cavity"
{wall}
drive = {{ kind = "pressure", signal = {{ kind = "ramp", from = "0 kPa", to = "2 kPa", end = "1 s" }} }}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
"#,
            mesh.display(),
            surface.display()
        );
        let scene = SceneBuilder::parse(&text).and_then(SceneBuilder::build).expect("a scene");
        let run = solved(&scene);
        run.column("cavity_volume_m3").expect("recorded")
    };
    let (skin, region) = (run("skin = \"air\""), run("region = \"inner\""));
    for (a, b) in skin.iter().zip(&region) {
        assert!((a / b - 1.0).abs() < 1e-10, "{skin:?} {region:?}");
    }
}

/// A skin that holds a third more than the hollow in which the pressure is meant to act is a warning; one that fills it is a note.
#[test]
fn a_skin_of_another_volume_than_its_hollow_is_a_warning() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let kind = |scale: f64| {
        let middle = Vec3::new(2.5, 1.5, 1.5) * UNIT;
        let mut surface = other_wall([4, 1]);
        surface.points.iter_mut().for_each(|p| *p = middle + (*p - middle) * scale);
        write(&folder.path().join("air.obj"), &surface);
        let scene = scene(folder.path(), bar(1, Order::Linear), &format!("skin = \"air\"\n{PRESSURE}"));
        let scene = scene.unwrap_or_else(|e| panic!("{e}"));
        let note = scene.notes.iter().find(|note| note.contains("the skin holds")).expect("a note");
        (scene.kind_of_note(note), note.clone())
    };
    assert_eq!(kind(1.0).0, "note");
    let (warning, text) = kind(1.1);
    assert!(warning == "warning" && text.contains("(+33.100 %)") && text.contains("check file and unit"), "{text}");
}
