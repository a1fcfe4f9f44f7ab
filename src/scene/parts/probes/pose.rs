//! Probe `pose`: position and rotation of a region or a skin, in space or in a frame that moves with another region.
//!
//! The rotation is that of the rigid motion nearest to the motion of the region, which minimises ∫ |x − x̄ − R (X − X̄)|² over its area, or over its volume if
//! it has cells: R follows from the singular value decomposition of H = ∫ x ⊗ (X − X̄) (Kabsch, *Acta Cryst. A* 32 (1976) 922–923). With S = RᵀH, which is
//! symmetric, the rotation changes by dR = R \[ω\]× with
//!
//! ```text
//! (tr S I − S) ω = axial vector of RᵀdH − dHᵀR
//! ```
//!
//! and the rotation vector r by J(r)⁻¹ R ω, J⁻¹ = I − ½ \[r\]× + (1/|r|² − cot(½|r|)/(2|r|)) \[r\]×² (Solà, Deray & Atchuthan, *A micro Lie theory*,
//! arXiv:1812.01537 (2018), Eq. 146).
//!
//! The rotation vector includes the number of whole rotations that brings it nearest to the state before; the quaternion is computed from the rotation vector,
//! so that its sign is continuous too. Limits: a motion that returns to a whole rotation about changing axes starts again there, and has no derivative at a
//! whole rotation.

use super::mean::Mean;
use super::part::Probe;
use crate::math::rotation::nearest_vector;
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::{Region, TetMesh, element, quadrature};
use crate::scene::body::Body;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Headline, Moment, Recorder};
use crate::scene::text::quantity::Length;
use crate::system::{Gradient, State};
use schemars::JsonSchema;
use serde::Deserialize;

/// Smallest ratio of the second to the first principal moment of a region whose rotation is defined.
const FLAT: f64 = 1e-8;

/// Smallest ratio of tr S − S to S at which the rotation has a derivative.
const TURNABLE: f64 = 1e-10;

/// Sine of half the angle below which a rotation counts as a whole rotation.
const WHOLE: f64 = 1e-8;

/// Position and rotation of a region or a skin.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pose {
    /// Region of facets whose pose is recorded
    pub region: Option<String>,
    /// Surface from a file, instead of a region
    pub skin: Option<String>,
    /// Region in whose frame the pose is given; space if absent
    pub relative_to: Option<String>,
    /// Prefix of the columns; the region or skin if absent
    pub name: Option<String>,
    /// Points that move rigidly with the region, inside or outside of the body, such as markers on stalks
    #[serde(default)]
    pub points: Vec<[Length; 3]>,
}

impl Probe for Pose {
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        self.name.iter().try_for_each(|name| builder.check_name(place, name))?;
        let mesh = &builder.body.mesh;
        let of_region = |name: &String| {
            let frame = Frame::new(mesh, shares_of_region(mesh, builder.region_with_nodes(place, name)?));
            self.checked(place, builder, "region", name, frame)
        };
        let of = match (&self.region, &self.skin) {
            (Some(region), None) => of_region(region)?,
            (None, Some(name)) => {
                let skin = builder.skin(place, name)?;
                let frame = Frame::new(mesh, skin.weights.iter().cloned().zip(skin.surface.areas()).collect());
                self.checked(place, builder, "skin", name, frame)?
            }
            _ => {
                let fact = "a pose is that of one `region` or of one `skin`";
                return Err(builder.content(place, fact, "give one of the two keys"));
            }
        };
        let reference = self.relative_to.as_ref().map(of_region).transpose()?;
        let middle = of.mean.at(&vec![0.0; 3 * mesh.points.len()]);
        let points = self.points.iter().map(|p| Vec3::from_iterator(p.iter().map(|c| c.0)) - middle).collect();
        Ok(Box::new(Recorded { name: self.prefix(), of, reference, points }))
    }

    fn regions(&self) -> Vec<&str> {
        self.region.iter().chain(&self.relative_to).map(String::as_str).collect()
    }

    fn headline(&self) -> Option<Headline> {
        Some(Headline { column: format!("{}_pose_x_m", self.prefix()), label: "position", symbol: "x", unit: "m" })
    }
}

impl Pose {
    fn prefix(&self) -> String {
        self.name.iter().chain(&self.region).chain(&self.skin).next().cloned().unwrap_or_default()
    }

    /// The frame; refuses a region whose rotation is not defined.
    fn checked(
        &self,
        place: &str,
        builder: &Builder,
        kind: &str,
        name: &str,
        frame: Frame,
    ) -> Result<Frame, SceneError> {
        if !frame.is_flat() {
            return Ok(frame);
        }
        let fact = format!("the points of {kind} \"{name}\" are on a line or few, so it has no rotation");
        Err(builder.content(place, fact, "take one with an area or a volume, or the probe \"position\""))
    }
}

/// The rigid motion nearest to the motion of a region.
struct Frame {
    mean: Mean,
    /// First moments (node, ∫ N (X − X̄)) \[m³\], or \[m⁴\] for cells
    moments: Vec<(u32, Vec3)>,
    /// H at rest
    rest: Mat3,
}

/// Points of a region as weights of nodes, with the area or volume of each.
fn shares_of_region(mesh: &TetMesh, region: &Region) -> Vec<(Vec<(u32, f64)>, f64)> {
    let mut shares: Vec<(Vec<(u32, f64)>, f64)> = Vec::new();
    let facets = mesh.facets_of(region);
    if !facets.is_empty() {
        let rule = quadrature::tri(4);
        for &f in facets {
            for (&xi, w) in rule.points.iter().zip(&rule.weights) {
                let shape = element::facet_shape(mesh.order, xi);
                let own = mesh.facet(f as usize).iter().copied().zip(shape).collect();
                shares.push((own, w * mesh.facet_normal(f as usize, xi).norm()));
            }
        }
    } else if !region.cells.is_empty() && !region.is_node_set {
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
    shares
}

impl Frame {
    /// A frame of points, given by their weights of nodes, with a weight for each point.
    fn new(mesh: &TetMesh, shares: Vec<(Vec<(u32, f64)>, f64)>) -> Self {
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
        // The moments sum to zero except for rounding, which would matter far from the origin
        let rest = moments.iter().map(|(k, m)| (mesh.points[*k as usize] - middle) * m.transpose()).sum();
        Self { mean: Mean::of_point(middle, weights), moments, rest }
    }

    fn is_flat(&self) -> bool {
        let mut sizes = self.rest.symmetric_eigenvalues().as_slice().to_vec();
        sizes.sort_by(f64::total_cmp);
        sizes[1] <= FLAT * sizes[2]
    }

    /// The moment H at displacement x.
    fn moment(&self, x: &[f64]) -> Mat3 {
        let moved =
            self.moments.iter().map(|(k, m)| Vec3::from_column_slice(&x[3 * *k as usize..][..3]) * m.transpose());
        self.rest + moved.sum::<Mat3>()
    }

    /// The rotation R at displacement x.
    fn rotation(&self, x: &[f64]) -> Mat3 {
        let svd = self.moment(x).svd(true, true);
        let (u, v) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"));
        // The sign of the third direction, with the smallest singular value, is chosen so that R is a rotation.
        let least = svd.singular_values.imin();
        let mut signs = Vec3::repeat(1.0);
        signs[least] = (u.determinant() * v.determinant()).signum();
        u * Mat3::from_diagonal(&signs) * v
    }

    /// Derivatives of the rotation with respect to the displacements, as vectors R ω in space; `None` where they are unbounded.
    fn spin(&self, x: &[f64], rotation: &Mat3) -> Option<Vec<(u32, Vec3)>> {
        let stretch = rotation.transpose() * self.moment(x);
        let stretch = 0.5 * (stretch + stretch.transpose());
        let system = Mat3::from_diagonal_element(stretch.trace()) - stretch;
        let least = system.symmetric_eigenvalues().iter().fold(f64::INFINITY, |m, v| m.min(v.abs()));
        let inverse = system.try_inverse().filter(|_| least > TURNABLE * stretch.norm())?;
        // RᵀdH − dHᵀR = a mᵀ − m aᵀ = [m × a]× with a = Rᵀe_i
        let by = |k: u32, m: &Vec3, i: usize| {
            (3 * k + i as u32, rotation * (inverse * m.cross(&rotation.row(i).transpose())))
        };
        Some(self.moments.iter().flat_map(|(k, m)| (0..3).map(move |i| by(*k, m, i))).collect())
    }
}

struct Recorded {
    name: String,
    of: Frame,
    reference: Option<Frame>,
    /// Points that move with the region, from its mean position at rest
    points: Vec<Vec3>,
}

impl Recorded {
    /// Position and rotation in the frame of the reference.
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

    /// Derivatives of the pose with respect to the displacements, in the frame of the reference.
    fn rates(&self, x: &[f64]) -> Option<Rates> {
        let (position, spin) = (self.of.mean.rates(), self.of.spin(x, &self.of.rotation(x))?);
        let Some(reference) = &self.reference else { return Some(Rates { position, spin }) };
        let frame = reference.rotation(x);
        let (back, arm) = (frame.transpose(), self.of.mean.at(x) - reference.mean.at(x));
        let carried = reference.spin(x, &frame)?;
        let turned =
            |of: &[(u32, Vec3)], sign: f64| of.iter().map(|(dof, v)| (*dof, back * v * sign)).collect::<Vec<_>>();
        let swept: Vec<(u32, Vec3)> = carried.iter().map(|(dof, v)| (*dof, v.cross(&arm))).collect();
        let position = [turned(&position, 1.0), turned(&reference.mean.rates(), -1.0), turned(&swept, -1.0)].concat();
        Some(Rates { position, spin: [turned(&spin, 1.0), turned(&carried, -1.0)].concat() })
    }
}

/// Derivatives of a pose with respect to the displacements: (unknown, derivative of the position, or of the rotation as a vector in the frame).
struct Rates {
    position: Vec<(u32, Vec3)>,
    spin: Vec<(u32, Vec3)>,
}

/// The matrix J(r)⁻¹ that maps a rotation in space to the change of the rotation vector; `None` at a whole rotation.
fn inverse_jacobian(r: Vec3) -> Option<Mat3> {
    let (angle, skew) = (r.norm(), r.cross_matrix());
    let half = 0.5 * angle;
    let factor = match angle {
        // The next term of the series is angle⁴/30240.
        small if small < 1e-2 => 1.0 / 12.0 + angle * angle / 720.0,
        _ if half.sin().abs() < WHOLE => return None,
        _ => (1.0 - half / half.tan()) / (angle * angle),
    };
    Some(Mat3::identity() - skew * 0.5 + skew * skew * factor)
}

/// The unit quaternion (w, x, y, z) of a rotation vector.
fn quaternion(vector: Vec3) -> [f64; 4] {
    let half = 0.5 * vector.norm();
    let axis = vector.try_normalize(0.0).unwrap_or(Vec3::zeros()) * half.sin();
    [half.cos(), axis.x, axis.y, axis.z]
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        let name = &self.name;
        let position = ["x", "y", "z"].map(|c| format!("{name}_pose_{c}_m"));
        let quaternion = ["w", "x", "y", "z"].map(|c| format!("{name}_quaternion_{c}"));
        let vector = ["x", "y", "z"].map(|c| format!("{name}_rotation_{c}_deg"));
        let points = (1..=self.points.len()).flat_map(|k| ["x", "y", "z"].map(|c| format!("{name}_point_{k}_{c}_m")));
        position.into_iter().chain(quaternion).chain(vector).chain(points).collect()
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
        let (position, rotation) = self.pose(&now.state.x);
        let points = self.points.iter().flat_map(|p| <[f64; 3]>::from(position + rotation * p));
        let pose = position.iter().copied().chain(quaternion(vector)).chain(vector.iter().map(|v| v.to_degrees()));
        pose.chain(points).collect()
    }

    /// The gradients. The rotation has none where the region is folded so far that its rotation is not defined, and the rotation vector has none at a whole
    /// rotation.
    fn gradients(&self, _: &Body, state: &State, memory: &[f64]) -> Vec<Option<Gradient>> {
        let vector = Vec3::from_column_slice(memory);
        let Some(Rates { position, spin }) = self.rates(&state.x) else {
            return vec![None; 10 + 3 * self.points.len()];
        };
        let along = |of: &dyn Fn(&Vec3) -> f64, rates: &[(u32, Vec3)]| {
            Some(Gradient::of_displacements(rates.iter().map(|(dof, v)| (*dof, of(v))).collect()))
        };
        let place = (0..3).map(|i| along(&|v| v[i], &position));
        // dq = ½ (0, ω) q
        let [w, x, y, z] = quaternion(vector);
        let rows = [Vec3::new(-x, -y, -z), Vec3::new(w, z, -y), Vec3::new(-z, w, x), Vec3::new(y, -x, w)];
        let of_quaternion = rows.iter().map(|row| along(&|v| 0.5 * row.dot(v), &spin));
        let jacobian = inverse_jacobian(vector);
        let of_vector = (0..3).map(|i| jacobian.and_then(|j| along(&|v| (j.row(i) * v)[0].to_degrees(), &spin)));
        let rotation = self.pose(&state.x).1;
        let of_points = self.points.iter().flat_map(|p| {
            let arm = rotation * p;
            let swept = spin.iter().map(|(dof, v)| (*dof, v.cross(&arm)));
            let rates: Vec<(u32, Vec3)> = position.iter().copied().chain(swept).collect();
            [0, 1, 2].map(|i| along(&|v| v[i], &rates))
        });
        place.chain(of_quaternion).chain(of_vector).chain(of_points).collect()
    }

    fn is_differentiable(&self) -> bool {
        true
    }
}
