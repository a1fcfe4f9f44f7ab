//! Curved meshes made without a mesher: blocks and prisms of Kuhn cells under a smooth map, with mid-nodes on the map.

use super::structured::block;
use crate::math::tensor::Vec3;
use crate::mesh::element::CELL_FACES;
use crate::mesh::file::assemble::add_body;
use crate::mesh::surface::boundary::add_boundary;
use crate::mesh::{Order, Region, TetMesh};
use std::collections::{BTreeMap, HashMap};

/// Builds a block of nx × ny × nz boxes under a map of the unit cube that keeps its sides distinct.
pub fn mapped_block([nx, ny, nz]: [usize; 3], order: Order, map: impl Fn(Vec3) -> Vec3) -> TetMesh {
    let mut mesh = block(nx, ny, nz, 1.0, 1.0, 1.0, order);
    mesh.points.iter_mut().for_each(|p| *p = map(*p));
    mesh
}

/// Builds `parts` triangular prisms, each the half s ≥ t of a block of n × n × layers boxes, mapped by (part, s, t, w) and joined where nodes
/// coincide. Faces s = t and t = 0 have matching diagonals, so that sectors of a disc fit together.
pub fn prisms(
    parts: usize,
    n: usize,
    layers: usize,
    order: Order,
    map: impl Fn(usize, f64, f64, f64) -> Vec3,
) -> TetMesh {
    let source = block(n, n, layers, 1.0, 1.0, 1.0, order);
    let mut mesh = TetMesh { order, points: vec![], cells: vec![], facets: vec![], regions: BTreeMap::new() };
    let mut known = HashMap::new();
    for part in 0..parts {
        for c in 0..source.cell_count() {
            let middle = source.position(c, [0.25; 3]);
            if middle.x < middle.y {
                continue;
            }
            for &k in source.cell(c) {
                let p = source.points[k as usize];
                let at = map(part, p.x, p.y, p.z);
                // Lengths are of order one: nodes closer than 1e-7 are merged.
                let key = [at.x, at.y, at.z].map(|x| (x * 1e7).round() as i64);
                let node = *known.entry(key).or_insert_with(|| {
                    mesh.points.push(at);
                    mesh.points.len() as u32 - 1
                });
                mesh.cells.push(node);
            }
        }
    }
    let mut faces: HashMap<[u32; 3], Option<Vec<u32>>> = HashMap::new();
    let mut keys = Vec::new();
    for c in 0..mesh.cell_count() {
        for face in CELL_FACES {
            let nodes: Vec<u32> = face[..order.facet_nodes()].iter().map(|&k| mesh.cell(c)[k]).collect();
            let mut key = [nodes[0], nodes[1], nodes[2]];
            key.sort_unstable();
            keys.push(key);
            faces.entry(key).and_modify(|f| *f = None).or_insert(Some(nodes));
        }
    }
    for nodes in keys.iter().filter_map(|key| faces[key].as_ref()) {
        mesh.facets.extend(nodes);
    }
    let cells = (0..mesh.cell_count() as u32).collect();
    mesh.regions.insert("body".into(), Region { cells, ..Region::default() });
    mesh
}

/// Builds an octant of a hollow sphere of radii a < b \[m\], with n cells along an edge of the spherical triangle: x = r l/|l| with the barycentric l
/// = (1 − s, s − t, t), r = a (b/a)^w. Regions `inner`, `outer` and the planes `xmin`, `ymin`, `zmin`.
pub fn octant(a: f64, b: f64, n: usize, layers: usize, order: Order) -> TetMesh {
    let ratio = b / a;
    let unit = prisms(1, n, layers, order, |_, s, t, w| Vec3::new(1.0 - s, s - t, t).normalize() * ratio.powf(w));
    let near = |value: f64, wanted: f64| (value - wanted).abs() < 1e-9;
    let mesh = scaled(unit, a);
    let planes = ["xmin", "ymin", "zmin"];
    let mesh = (0..3).fold(mesh, |mesh, axis| with_region(mesh, planes[axis], |p| near(p[axis] / a, 0.0)));
    let mesh = with_region(mesh, "inner", |p| near(p.norm() / a, 1.0));
    with_region(mesh, "outer", |p| near(p.norm() / b, 1.0))
}

/// Builds a cylinder of radius a and the given length along z \[m\]: six sectors, r = a s, angle (part + t/s) 60°. Regions `zmin`, `zmax` and `side`.
pub fn cylinder(a: f64, length: f64, n: usize, layers: usize, order: Order) -> TetMesh {
    let unit = prisms(6, n, layers, order, |part, s, t, w| {
        let angle = (part as f64 + if s > 0.0 { t / s } else { 0.0 }) * std::f64::consts::FRAC_PI_3;
        Vec3::new(s * angle.cos(), s * angle.sin(), length / a * w)
    });
    let near = |value: f64, wanted: f64| (value - wanted).abs() < 1e-9;
    let mesh = with_region(scaled(unit, a), "zmin", |p| near(p.z / length, 0.0));
    let mesh = with_region(mesh, "zmax", |p| near(p.z / length, 1.0));
    with_region(mesh, "side", |p| near(p.x.hypot(p.y) / a, 1.0))
}

/// Builds a tube about the z-axis with radii a < b and the given length \[m\]: `divisions` are the numbers of boxes across the wall, around and along
/// it. Regions `inner`, `outer`, `zmin` and `zmax`.
pub fn tube([a, b]: [f64; 2], length: f64, divisions: [usize; 3], order: Order) -> TetMesh {
    let flat = block(divisions[0], divisions[1], divisions[2], 1.0, 1.0, 1.0, order);
    let mut mesh = TetMesh { order, points: vec![], cells: vec![], facets: vec![], regions: BTreeMap::new() };
    let mut known = HashMap::new();
    // Lengths are of order one: the ends of the circle, y = 0 and 1, are merged.
    let key = |p: &Vec3| [p.x, p.y % 1.0, p.z].map(|x| (x * 1e7).round() as i64);
    for &k in &flat.cells {
        let p = flat.points[k as usize];
        let node = *known.entry(key(&p)).or_insert_with(|| {
            let ((sin, cos), r) = ((std::f64::consts::TAU * p.y).sin_cos(), a + (b - a) * p.x);
            mesh.points.push(Vec3::new(r * cos, r * sin, length * p.z));
            mesh.points.len() as u32 - 1
        });
        mesh.cells.push(node);
    }
    add_boundary(&mut mesh);
    add_body(&mut mesh);
    let near = |value: f64, wanted: f64| (value - wanted).abs() < 1e-9 * b;
    let mesh = with_region(mesh, "inner", |p| near(p.xy().norm(), a));
    let mesh = with_region(mesh, "outer", |p| near(p.xy().norm(), b));
    let mesh = with_region(mesh, "zmin", |p| near(p.z, 0.0));
    with_region(mesh, "zmax", |p| (p.z - length).abs() < 1e-9 * length)
}

/// Builds a bar of radius a \[m\] whose centre line is an arc of the given radius \[m\] and angle \[rad\], which starts at the origin along z and
/// bends towards x. Divisions as for a [`cylinder`]. Regions `start`, `end` and `side`.
pub fn bow(a: f64, (radius, angle): (f64, f64), [n, layers]: [usize; 2], order: Order) -> TetMesh {
    let mut mesh = cylinder(a, 1.0, n, layers, order);
    for p in &mut mesh.points {
        let (sin, cos) = (angle * p.z).sin_cos();
        *p = Vec3::new(radius - (radius - p.x) * cos, p.y, (radius - p.x) * sin);
    }
    for (old, new) in [("zmin", "start"), ("zmax", "end")] {
        let region = mesh.regions.remove(old).expect("a cylinder has it");
        mesh.regions.insert(new.into(), region);
    }
    mesh
}

/// Builds a plate of nx × ny × nz boxes over the quadrilateral with these corners \[m\], counter-clockwise from the image of (0, 0), bilinear in
/// between. Regions as for a block.
pub fn plate(corners: [[f64; 2]; 4], thickness: f64, divisions: [usize; 3], order: Order) -> TetMesh {
    let [a, b, c, d] = corners;
    let between =
        |k: usize, s: f64, t: f64| (1.0 - t) * ((1.0 - s) * a[k] + s * b[k]) + t * ((1.0 - s) * d[k] + s * c[k]);
    mapped_block(divisions, order, |p| Vec3::new(between(0, p.x, p.y), between(1, p.x, p.y), thickness * p.z))
}

/// Builds a quarter, x ≥ 0 and y ≥ 0, of a square plate of half edge w with a hole of radius a about the origin \[m\]: boxes along the radius, around
/// the quarter (an even number, so that the corner is a node) and through the thickness. Regions `hole`, the symmetry planes `xmin` and `ymin`, and
/// `xmax`, `ymax`, `zmin`, `zmax`.
pub fn hole(a: f64, w: f64, thickness: f64, divisions: [usize; 3], order: Order) -> TetMesh {
    let mut mesh = mapped_block(divisions, order, |p| {
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * p.y).sin_cos();
        let r = (1.0 - p.x) * a + p.x * w / cos.max(sin);
        Vec3::new(r * cos, r * sin, thickness * p.z)
    });
    let hole = mesh.regions.remove("xmin").expect("a block has it");
    mesh.regions.insert("hole".into(), hole);
    let near = |value: f64, wanted: f64| (value - wanted).abs() < 1e-9 * w;
    let sides = [("xmin", 0, 0.0), ("ymin", 1, 0.0), ("xmax", 0, w), ("ymax", 1, w)];
    sides.into_iter().fold(mesh, |mesh, (name, axis, at)| with_region(mesh, name, |p| near(p[axis], at)))
}

/// Builds a square plate of the given edge without its quadrant x, y > edge/2 \[m\], with n boxes across an arm. Regions `xmin`, `ymin`, the ends
/// `xmax` and `ymax` of the arms, `zmin`, `zmax`.
pub fn bracket(edge: f64, thickness: f64, [n, layers]: [usize; 2], order: Order) -> TetMesh {
    let square = block(2 * n, 2 * n, layers, edge, edge, thickness, order);
    let mesh = joined(&scaled(square, 1.0 / edge), |middle| middle.xy().amin() < 0.5);
    let mesh = scaled(mesh, edge);
    let near = |value: f64, wanted: f64| (value - wanted).abs() < 1e-9 * edge;
    let names = [["xmin", "xmax"], ["ymin", "ymax"], ["zmin", "zmax"]];
    let ends = [edge, edge, thickness];
    (0..6).fold(mesh, |mesh, k| {
        let (axis, end) = (k / 2, k % 2);
        with_region(mesh, names[axis][end], |p| near(p[axis], end as f64 * ends[axis]))
    })
}

/// Returns the cells of a mesh whose centres are `kept`, with coincident nodes merged; lengths are of order one. The only region is `body`.
fn joined(source: &TetMesh, kept: impl Fn(Vec3) -> bool) -> TetMesh {
    let order = source.order;
    let mut mesh = TetMesh { order, points: vec![], cells: vec![], facets: vec![], regions: BTreeMap::new() };
    let mut known = HashMap::new();
    let cells = (0..source.cell_count()).filter(|c| kept(source.position(*c, [0.25; 3])));
    for &k in cells.flat_map(|c| source.cell(c)) {
        let at = source.points[k as usize];
        // Nodes closer than 1e-7 are merged.
        let key = [at.x, at.y, at.z].map(|x| (x * 1e7).round() as i64);
        let node = *known.entry(key).or_insert_with(|| {
            mesh.points.push(at);
            mesh.points.len() as u32 - 1
        });
        mesh.cells.push(node);
    }
    add_boundary(&mut mesh);
    add_body(&mut mesh);
    mesh
}

fn scaled(mut mesh: TetMesh, factor: f64) -> TetMesh {
    mesh.points.iter_mut().for_each(|p| *p *= factor);
    mesh
}

/// Adds a region of the facets all of whose nodes satisfy `on`.
fn with_region(mut mesh: TetMesh, name: &str, on: impl Fn(Vec3) -> bool) -> TetMesh {
    let here = |f: &u32| mesh.facet(*f as usize).iter().all(|&k| on(mesh.points[k as usize]));
    let facets = (0..mesh.facet_count() as u32).filter(here).collect();
    mesh.regions.insert(name.into(), Region { facets, ..Region::default() });
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::file::validate::min_det;
    use std::f64::consts::PI;

    /// Volume, and areas of the sides; the area of the curved side with tet10 has an error of the fourth power of an angle of π/16.
    #[test]
    fn a_plate_with_a_hole_and_a_bracket_fill_their_bodies() {
        for order in [Order::Linear, Order::Quadratic] {
            let plate = hole(1.0, 3.0, 0.5, [4, 8, 1], order);
            let bracket = bracket(2.0, 0.5, [3, 2], order);
            let curved = if order == Order::Linear { 1e-2 } else { 1e-4 };
            let quarter = PI / 4.0;
            let sides = [
                ("hole", quarter),
                ("xmin", 1.0),
                ("ymin", 1.0),
                ("xmax", 1.5),
                ("ymax", 1.5),
                ("zmin", 9.0 - quarter),
            ];
            check(&plate, 0.5 * (9.0 - quarter), &sides, curved);
            let sides = [("xmin", 1.0), ("xmax", 0.5), ("ymin", 1.0), ("ymax", 0.5), ("zmin", 3.0), ("zmax", 3.0)];
            check(&bracket, 1.5, &sides, 1e-12);
        }
    }

    /// Volumes and areas of a tube, whose circumference closes, and of a bent bar, whose volume equals that of the straight one (Pappus).
    #[test]
    fn a_tube_and_a_bow_fill_their_bodies() {
        for (order, curved) in [(Order::Linear, 6e-2), (Order::Quadratic, 2e-3)] {
            let (ring, length) = (PI * (4.0 - 1.0), 3.0);
            let sides = [("zmin", ring), ("zmax", ring), ("inner", 2.0 * PI * length), ("outer", 4.0 * PI * length)];
            let tube = tube([1.0, 2.0], length, [2, 12, 3], order);
            check(&tube, ring * length, &sides, curved);
            let all: usize = sides.iter().map(|(name, _)| tube.regions[*name].facets.len()).sum();
            assert_eq!(all, tube.facet_count(), "no facet where the circumference closes");
            let (angle, radius) = (0.5 * PI, 3.0);
            let bow = bow(1.0, (radius, angle), [3, 6], order);
            let sides = [("start", PI), ("end", PI), ("side", 2.0 * PI * radius * angle)];
            check(&bow, PI * radius * angle, &sides, curved);
        }
    }

    fn check(mesh: &TetMesh, volume: f64, sides: &[(&str, f64)], tolerance: f64) {
        assert!((0..mesh.cell_count()).all(|c| min_det(mesh, c) > 0.0));
        assert!((mesh.volume() / volume - 1.0).abs() < tolerance, "{} {volume}", mesh.volume());
        for (name, area) in sides {
            let found = mesh.region_area(&mesh.regions[*name].facets);
            assert!((found / area - 1.0).abs() < tolerance, "{name}: {found} {area}");
        }
    }
}
