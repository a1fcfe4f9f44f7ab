//! Curved meshes without a mesher: prisms of Kuhn cells under a smooth map, mid-nodes on the map.

use durometer::math::tensor::Vec3;
use durometer::mesh::element::CELL_FACES;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, Region, TetMesh};
use std::collections::{BTreeMap, HashMap};

/// A block of nx × ny × nz boxes under a map of the unit cube that keeps its sides apart.
pub fn mapped_block([nx, ny, nz]: [usize; 3], order: Order, map: impl Fn(Vec3) -> Vec3) -> TetMesh {
    let mut mesh = block(nx, ny, nz, 1.0, 1.0, 1.0, order);
    mesh.points.iter_mut().for_each(|p| *p = map(*p));
    mesh
}

/// `parts` triangular prisms, each the half s ≥ t of a block of n × n × layers boxes, mapped by (part, s, t, w) and joined
/// where nodes coincide. Faces s = t and t = 0 have the same diagonals, so sectors of a disc fit together.
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
                // Lengths are of the size of one: nodes closer than 1e-7 are one.
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

/// One octant of a hollow sphere of radii a < b, n cells along an edge of the spherical triangle: x = r l/|l| with the
/// barycentric l = (1 − s, s − t, t), r = a (b/a)^w.
pub fn octant(a: f64, b: f64, n: usize, layers: usize, order: Order) -> TetMesh {
    prisms(1, n, layers, order, |_, s, t, w| Vec3::new(1.0 - s, s - t, t).normalize() * (a * (b / a).powf(w)))
}

/// A cylinder of radius a and this length along z: six sectors, r = a s, angle (part + t/s) 60°.
pub fn cylinder(a: f64, length: f64, n: usize, layers: usize, order: Order) -> TetMesh {
    prisms(6, n, layers, order, |part, s, t, w| {
        let angle = (part as f64 + if s > 0.0 { t / s } else { 0.0 }) * std::f64::consts::FRAC_PI_3;
        Vec3::new(a * s * angle.cos(), a * s * angle.sin(), length * w)
    })
}

/// Nodes on the surface at which `on` holds.
pub fn surface_nodes(mesh: &TetMesh, on: impl Fn(Vec3) -> bool) -> Vec<u32> {
    super::surface(mesh).into_iter().filter(|&k| on(mesh.points[k as usize])).collect()
}
