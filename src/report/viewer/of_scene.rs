//! Geometry of a scene: its body with regions and supports, its cables, rigid bodies, obstacles and skins.

use super::shape::{Limits, PartKind, Shape};
use crate::effect::contact::placement::AffineFrame;
use crate::math::tensor::Vec3;
use crate::mesh::Region;
use crate::mesh::boundary::facet_cells;
use crate::scene::spec::ConstraintSpec;
use crate::scene::{NamedSkin, Scene};
use std::collections::BTreeSet;

/// Relative size below which forces are left out.
const SMALL: f64 = 1e-3;

/// Returns the shape of a scene at rest.
pub fn shape(scene: &Scene, limits: &Limits) -> Shape {
    let mesh = &scene.body.mesh;
    let mut shape = Shape::of_mesh(mesh, limits);
    mark(scene, &mut shape);
    let rest = scene.system.rest();
    for cable in &scene.cables {
        shape.add_part(&cable.name, PartKind::Cable, &places(&cable.cable.polyline(&rest.x)), vec![]);
    }
    for skin in &scene.skins {
        let kind = if is_rigid(scene, &skin.name) { PartKind::Rigid } else { PartKind::Skin };
        shape.add_part(&skin.name, kind, &moved(skin, &rest.x), skin.surface.triangles.clone());
    }
    for floor in floors(scene) {
        shape.add_part(floor.name, PartKind::Floor, &floor.at(&rest.x), vec![[0, 1, 2], [0, 2, 3]]);
    }
    shape
}

/// Returns the positions of the points of all parts at the displacement x \[m\], in the order of [`shape`].
pub fn parts(scene: &Scene, x: &[f64]) -> Vec<[f64; 3]> {
    let cables = scene.cables.iter().flat_map(|c| places(&c.cable.polyline(x)));
    let skins = scene.skins.iter().flat_map(|skin| moved(skin, x));
    cables.chain(skins).chain(floors(scene).iter().flat_map(|floor| floor.at(x))).collect()
}

/// A finite piece of the plane of an unbounded obstacle.
struct Floor<'a> {
    name: &'a str,
    /// Corners, counter-clockwise about the normal, next to the body \[m\]
    corners: [Vec3; 4],
    /// Frame that carries it along, without rotation
    body: Option<&'a AffineFrame>,
}

impl Floor<'_> {
    /// Its corners at the displacement x \[m\].
    fn at(&self, x: &[f64]) -> [[f64; 3]; 4] {
        let shift = self.body.map_or(Vec3::zeros(), |body| body.positions(x)[0] - body.rest()[0]);
        self.corners.map(|p| (p + shift).into())
    }
}

/// The floors of a scene; a fixed plane shared by several contacts counts once.
fn floors(scene: &Scene) -> Vec<Floor<'_>> {
    let mesh = &scene.body.mesh;
    let (low, high) = mesh.bounding_box();
    // The extent of the shape, which sets the tolerances, remains that of the body
    let half = 0.1 * mesh.diagonal();
    let mut out: Vec<Floor> = vec![];
    for contact in &scene.contacts {
        let Some(obstacle) = contact.points().map(|points| &points.obstacle).filter(|o| o.shape.bounds().is_none())
        else {
            continue;
        };
        let [along, across, normal] = [0, 1, 2].map(|i| obstacle.axes.column(i).into_owned());
        let middle = 0.5 * (low + high);
        let foot = middle - normal * normal.dot(&(middle - obstacle.origin));
        let corner = |(a, b): (f64, f64)| foot + (along * a + across * b) * half;
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner);
        let body = obstacle.body.as_ref();
        let is_same = |f: &Floor| f.corners.iter().zip(&corners).all(|(p, q)| (p - q).norm() < 1e-9 * half);
        if !out.iter().any(|f| f.body.is_none() && body.is_none() && is_same(f)) {
            out.push(Floor { name: &contact.name, corners, body });
        }
    }
    out
}

/// Returns the points of the shape with contact forces, and these forces \[N\], without friction.
pub fn contact_forces(scene: &Scene, shape: &Shape, x: &[f64]) -> Vec<(u32, [f32; 3])> {
    if scene.contacts.is_empty() {
        return vec![];
    }
    let mut forces = vec![0.0; 3 * scene.body.mesh.points.len()];
    scene.contacts.iter().for_each(|c| c.nodal(x, None, &mut forces));
    let force = |n: u32| Vec3::from_column_slice(&forces[3 * n as usize..3 * n as usize + 3]);
    let largest = shape.nodes.iter().map(|&n| force(n).norm()).fold(0.0, f64::max);
    let acts = |(k, &n): (usize, &u32)| {
        let f = force(n);
        (f.norm() > SMALL * largest).then(|| (k as u32, [f.x as f32, f.y as f32, f.z as f32]))
    };
    shape.nodes.iter().enumerate().filter_map(acts).collect()
}

/// Names the regions, the walls of cavities and the supports.
fn mark(scene: &Scene, shape: &mut Shape) {
    let mesh = &scene.body.mesh;
    let cells = facet_cells(mesh);
    let whole = |name: &str| ["body", "skin"].iter().any(|end| name == *end || name.ends_with(&format!(".{end}")));
    let on = |region: &Region| {
        let (facets, of_cells): (BTreeSet<u32>, BTreeSet<u32>) =
            (region.facets.iter().copied().collect(), region.cells.iter().copied().collect());
        let cells = &cells;
        move |f: u32| facets.contains(&f) || of_cells.contains(&cells[f as usize].0)
    };
    for (name, region) in scene.regions.iter().filter(|(name, _)| !whole(name)) {
        shape.mark(name, "region", on(region), &region.nodes);
    }
    for constraint in &scene.spec.constraints {
        if let ConstraintSpec::Cavity(cavity) = constraint
            && let Some(region) = cavity.region.as_ref().and_then(|name| scene.regions.get(name))
        {
            shape.mark(&cavity.name, "cavity", on(region), &region.nodes);
        }
    }
    let held: BTreeSet<u32> = scene.system.prescribed.iter().map(|p| p.dof / 3).collect();
    let held: Vec<u32> = held.into_iter().filter(|&n| (n as usize) < mesh.points.len()).collect();
    if !held.is_empty() {
        shape.mark("held or moved", "held", |_| false, &held);
    }
}

fn is_rigid(scene: &Scene, name: &str) -> bool {
    scene.rigids.iter().any(|r| r.name == name) || scene.contacts.iter().any(|c| c.name == name)
}

fn places(points: &[Vec3]) -> Vec<[f64; 3]> {
    points.iter().map(|p| [p.x, p.y, p.z]).collect()
}

fn moved(skin: &NamedSkin, x: &[f64]) -> Vec<[f64; 3]> {
    let u = skin.displacement(x);
    skin.surface.points.iter().zip(u.chunks_exact(3)).map(|(p, u)| [p.x + u[0], p.y + u[1], p.z + u[2]]).collect()
}
