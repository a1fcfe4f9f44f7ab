//! Probe `pose`: position and rotation of a region, in space or in the frame that moves with another region.
//!
//! The rotation is that of the rigid motion nearest to the one of the region, which minimises ∫ |x − x̄ − R (X − X̄)|² over its area, or over its
//! volume if it has cells: R of H = ∫ x ⊗ (X − X̄) by its singular values (Kabsch, *Acta Cryst. A* 32 (1976) 922–923). The rotation
//! vector takes the number of whole rotations that brings it nearest to the state before; the quaternion is that of the rotation vector, so that its sign
//! is continuous too. Limits: a motion that comes back to a whole rotation about changing axes begins again there, and there are no derivatives.

use super::mean::Mean;
use super::part::Probe;
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::{Region, TetMesh, element, quadrature};
use crate::scene::body::Body;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::recorder::{Headline, Moment, Recorder};
use crate::system::State;
use nalgebra::{Rotation3, UnitQuaternion};
use serde::Deserialize;
use std::f64::consts::TAU;

/// Least ratio of the second to the first principal moment of a region whose rotation is known.
const FLAT: f64 = 1e-8;

/// Position and rotation of a region.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    pub region: String,
    /// The region whose frame the pose is given in; space if absent
    pub relative_to: Option<String>,
    /// Prefix of the columns; the region if absent
    pub name: Option<String>,
}

impl Probe for Pose {
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        let frame = |name: &String| {
            let frame = Frame::new(&builder.body.mesh, builder.region(place, name)?);
            if frame.is_flat() {
                let fact = format!("the points of region \"{name}\" are on a line or few, so it has no rotation");
                return Err(builder.content(
                    place,
                    fact,
                    "take a region with an area or a volume, or the probe \"position\"",
                ));
            }
            Ok(frame)
        };
        let (of, reference) = (frame(&self.region)?, self.relative_to.as_ref().map(frame).transpose()?);
        Ok(Box::new(Recorded { name: self.prefix(), of, reference }))
    }

    fn headline(&self) -> Option<Headline> {
        Some(Headline { column: format!("{}_pose_x_m", self.prefix()), label: "position", symbol: "x", unit: "m" })
    }
}

impl Pose {
    fn prefix(&self) -> String {
        self.name.as_ref().unwrap_or(&self.region).clone()
    }
}

/// The rigid motion nearest to that of a region.
struct Frame {
    mean: Mean,
    /// (node, ∫ N (X − X̄)) \[m³\], or \[m⁴\] of cells
    moments: Vec<(u32, Vec3)>,
    /// H at rest
    rest: Mat3,
}

impl Frame {
    fn new(mesh: &TetMesh, region: &Region) -> Self {
        let mut shares: Vec<(Vec<(u32, f64)>, f64)> = Vec::new();
        if !region.facets.is_empty() {
            let rule = quadrature::tri(4);
            for &f in &region.facets {
                for (&xi, w) in rule.points.iter().zip(&rule.weights) {
                    let shape = element::facet_shape(mesh.order, xi);
                    let own = mesh.facet(f as usize).iter().copied().zip(shape).collect();
                    shares.push((own, w * mesh.facet_normal(f as usize, xi).norm()));
                }
            }
        } else if !region.cells.is_empty() {
            let rule = quadrature::tet(5);
            for &c in &region.cells {
                for (&xi, w) in rule.points.iter().zip(&rule.weights) {
                    let own = mesh.cell(c as usize).iter().copied().zip(element::cell_shape(mesh.order, xi)).collect();
                    shares.push((own, w * mesh.jacobian(c as usize, xi).determinant().abs()));
                }
            }
        } else {
            shares.extend(mesh.nodes_of(region).iter().map(|&node| (vec![(node, 1.0)], 1.0)));
        }
        let at = |own: &[(u32, f64)]| own.iter().map(|&(k, n)| mesh.points[k as usize] * n).sum::<Vec3>();
        let size: f64 = shares.iter().map(|(_, w)| w).sum();
        let middle = shares.iter().map(|(own, w)| at(own) * (w / size)).sum::<Vec3>();
        let mut weights = vec![0.0; mesh.points.len()];
        let mut moments = vec![Vec3::zeros(); mesh.points.len()];
        for (own, w) in &shares {
            let arm = at(own) - middle;
            for &(node, n) in own {
                weights[node as usize] += w * n / size;
                moments[node as usize] += arm * (w * n);
            }
        }
        let weights = (0..).zip(weights).filter(|(_, w)| *w != 0.0).collect();
        let moments: Vec<(u32, Vec3)> = (0..).zip(moments).filter(|(_, m)| *m != Vec3::zeros()).collect();
        let rest = moments.iter().map(|(k, m)| mesh.points[*k as usize] * m.transpose()).sum();
        Self { mean: Mean::of_point(middle, weights), moments, rest }
    }

    fn is_flat(&self) -> bool {
        let mut sizes = self.rest.symmetric_eigenvalues().as_slice().to_vec();
        sizes.sort_by(f64::total_cmp);
        sizes[1] <= FLAT * sizes[2]
    }

    /// R at displacement x.
    fn rotation(&self, x: &[f64]) -> Mat3 {
        let moved =
            self.moments.iter().map(|(k, m)| Vec3::from_column_slice(&x[3 * *k as usize..][..3]) * m.transpose());
        let svd = (self.rest + moved.sum::<Mat3>()).svd(true, true);
        let (u, v) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"));
        // Of the third direction, with the least singular value, only a rotation is taken.
        let least = svd.singular_values.imin();
        let mut signs = Vec3::repeat(1.0);
        signs[least] = (u.determinant() * v.determinant()).signum();
        u * Mat3::from_diagonal(&signs) * v
    }
}

struct Recorded {
    name: String,
    of: Frame,
    reference: Option<Frame>,
}

impl Recorded {
    /// Position and rotation, in the frame of the reference.
    fn pose(&self, x: &[f64]) -> (Vec3, Mat3) {
        let (at, rotation) = (self.of.mean.at(x), self.of.rotation(x));
        match &self.reference {
            None => (at, rotation),
            Some(reference) => {
                let back = reference.rotation(x).transpose();
                (back * (at - reference.mean.at(x)), back * rotation)
            }
        }
    }
}

/// The rotation vector of R with as many whole rotations as bring it nearest to the one `before` \[rad\].
fn nearest_vector(rotation: Mat3, before: Vec3) -> Vec3 {
    let base = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation)).scaled_axis();
    // About what axis a whole rotation was, only the states before it know.
    let axis = match base.norm() {
        angle if angle > 1e-9 => base / angle,
        _ => before.try_normalize(0.0).unwrap_or(Vec3::x()),
    };
    base + axis * (TAU * ((before - base).dot(&axis) / TAU).round())
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        let name = &self.name;
        let position = ["x", "y", "z"].map(|c| format!("{name}_pose_{c}_m"));
        let quaternion = ["w", "x", "y", "z"].map(|c| format!("{name}_quaternion_{c}"));
        let vector = ["x", "y", "z"].map(|c| format!("{name}_rotation_{c}_deg"));
        position.into_iter().chain(quaternion).chain(vector).collect()
    }

    /// The rotation vector \[rad\].
    fn memory(&self) -> Vec<f64> {
        vec![0.0; 3]
    }

    fn remember(&self, _: &Body, state: &State, memory: &mut [f64]) {
        let vector = nearest_vector(self.pose(&state.x).1, Vec3::from_column_slice(memory));
        memory.copy_from_slice(vector.as_slice());
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        let vector = Vec3::from_column_slice(now.memory);
        let half = 0.5 * vector.norm();
        let axis = vector.try_normalize(0.0).unwrap_or(Vec3::zeros()) * half.sin();
        let quaternion = [half.cos(), axis.x, axis.y, axis.z];
        let position = self.pose(&now.state.x).0;
        position.iter().copied().chain(quaternion).chain(vector.iter().map(|v| v.to_degrees())).collect()
    }
}
