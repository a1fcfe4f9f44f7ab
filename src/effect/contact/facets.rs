//! A closed triangle surface with the flat sides that its triangles form, and its [`Sheets`].

use super::sheet_numbers::Neighbours;
use super::sheets::Sheets;
use super::witness::{ON_SURFACE, Witness};
use crate::math::boxes::{from_parry, overlapping, widened};
use crate::math::tensor::{Mat3, Vec3};
use parry3d_f64::math::Vector;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

/// Largest angle between triangles of one flat side \[rad\]: in files of single precision, small triangles are rotated by 1e-5.
const FLAT: f64 = 1e-4;

/// A closed triangle surface and the flat sides that its triangles form.
pub struct Facets {
    pub(super) mesh: TriMesh,
    /// \[triangles\] the first triangle of the side to which it belongs
    pub(super) sides: Vec<u32>,
    /// `None` if one contact per point is sufficient
    pub(super) sheets: Option<Sheets>,
}

impl Facets {
    pub(super) fn new(points: Vec<Vector>, triangles: Vec<[u32; 3]>) -> Self {
        let mesh = TriMesh::with_flags(points, triangles, TriMeshFlags::ORIENTED).expect("a surface has triangles");
        let edges = |(t, corners): (usize, &[u32; 3])| {
            let [a, b, c] = *corners;
            [(a, b), (b, c), (c, a)].map(|edge| (edge, t as u32))
        };
        let neighbours: Neighbours = mesh.indices().iter().enumerate().flat_map(edges).collect();
        let normals: Vec<Vec3> = (0..mesh.indices().len() as u32).map(|t| normal(&mesh, t)).collect();
        let mut sides = vec![u32::MAX; normals.len()];
        for first in 0..sides.len() as u32 {
            let mut open = vec![first];
            while let Some(t) = open.pop() {
                if sides[t as usize] == u32::MAX && normals[t as usize].angle(&normals[first as usize]) <= FLAT {
                    sides[t as usize] = first;
                    let [a, b, c] = mesh.indices()[t as usize];
                    open.extend([(b, a), (c, b), (a, c)].iter().filter_map(|edge| neighbours.get(edge)));
                }
            }
        }
        let sheets = Sheets::of(&mesh, &normals, &neighbours);
        Self { mesh, sides, sheets }
    }

    /// The witness of y where interior kinks between its plane and the planes of the triangles that `belong` to it are rounded over `width` \[m\];
    /// unchanged if `width` is 0.
    pub(super) fn rounded(&self, y: &Vec3, nearest: Witness, width: f64, belong: impl Fn(u32) -> bool) -> Witness {
        // Only a face has zero curvature: seen from inside, the region of a sharp side or corner contains neither kinks nor faces.
        if !(width > 0.0 && nearest.gap < 0.0 && nearest.curvature == Mat3::zeros()) {
            return nearest;
        }
        let p = y - nearest.normal * nearest.gap;
        // Twice as far as the planes: the projection of y onto one of them may lie outside its face.
        let reach = 2.0 * (width - nearest.gap);
        let mut planes = vec![(nearest.gap, nearest.normal)];
        let near = overlapping(self.mesh.bvh(), widened((*y, *y), reach));
        for triangle in near.into_iter().filter(|&t| belong(t)) {
            let [a, b, c] = self.corners(triangle);
            let normal = (b - a).cross(&(c - a)).normalize();
            let gap = normal.dot(&(y - a));
            // Beyond a concave side, the plane cuts through the interior.
            let convex = normal.dot(&(p - a)) <= ON_SURFACE * (b - a).norm().max((c - a).norm());
            let known = |(_, n): &(f64, Vec3)| (n - normal).norm() < ON_SURFACE;
            if convex && gap > nearest.gap - width && !planes.iter().any(known) {
                planes.push((gap.min(nearest.gap), normal));
            }
        }
        smooth_maximum(planes, width)
    }

    /// Whether a triangle lies entirely behind the plane of a witness of y.
    pub(super) fn is_behind(&self, triangle: u32, y: &Vec3, Witness { gap, normal, .. }: &Witness) -> bool {
        let corners = self.corners(triangle);
        let size = (corners[1] - corners[0]).norm().max((corners[2] - corners[0]).norm());
        corners.iter().all(|corner| gap + normal.dot(&(corner - y)) <= ON_SURFACE * size)
    }

    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        let t = self.mesh.triangle(triangle);
        [t.a, t.b, t.c].map(from_parry)
    }
}

/// Outward unit normal of a triangle.
fn normal(mesh: &TriMesh, t: u32) -> Vec3 {
    let [a, b, c] = mesh.indices()[t as usize].map(|k| from_parry(mesh.vertices()[k as usize]));
    (b - a).cross(&(c - a)).normalize()
}

/// The smooth maximum of the distances from planes, each given with its normal.
fn smooth_maximum(mut planes: Vec<(f64, Vec3)>, width: f64) -> Witness {
    planes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut sum, mut level, mut held) = (0.0, 0.0, 0);
    for (k, (d, _)) in planes.iter().enumerate() {
        sum += d;
        let next = (sum - width) / (k + 1) as f64;
        if *d <= next {
            break;
        }
        (level, held) = (next, k + 1);
    }
    let planes = &planes[..held];
    let shares: Vec<f64> = planes.iter().map(|(d, _)| (d - level) / width).collect();
    let square: f64 = shares.iter().map(|s| s * s).sum();
    let gap = planes.iter().zip(&shares).map(|((d, _), s)| d * s).sum::<f64>() + 0.5 * width * (1.0 - square);
    let normal: Vec3 = planes.iter().zip(&shares).map(|((_, n), s)| n * *s).sum();
    let middle = planes.iter().map(|(_, n)| n).sum::<Vec3>() / held as f64;
    let spread = planes.iter().map(|(_, n)| (n - middle) * (n - middle).transpose()).sum::<Mat3>();
    Witness { gap, normal, curvature: spread / width }
}
