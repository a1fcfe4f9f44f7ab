//! Distance of a discrete field from a known one.

use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::element::{cell_gradients, cell_shape};
use durometer::mesh::{TetMesh, quadrature};

/// ‖u_h − u‖ and ‖∇u_h − ∇u‖ in L2, by the degree-5 rule.
pub fn errors(mesh: &TetMesh, x: &[f64], u: impl Fn(Vec3) -> (Vec3, Mat3)) -> [f64; 2] {
    let rule = quadrature::tet(5);
    let mut sums = [0.0; 2];
    for c in 0..mesh.cell_count() {
        for (&xi, w) in rule.points.iter().zip(&rule.weights) {
            let jacobian = mesh.jacobian(c, xi);
            let inverse = jacobian.try_inverse().unwrap();
            let (exact, gradient) = u(mesh.position(c, xi));
            let (mut d, mut g) = (-exact, -gradient);
            let shapes = cell_shape(mesh.order, xi).into_iter().zip(cell_gradients(mesh.order, xi));
            for (&k, (n, dn)) in mesh.cell(c).iter().zip(shapes) {
                let nodal = Vec3::from_column_slice(&x[3 * k as usize..][..3]);
                d += nodal * n;
                g += nodal * inverse.tr_mul(&Vec3::from(dn)).transpose();
            }
            let dv = w * jacobian.determinant();
            sums[0] += dv * d.norm_squared();
            sums[1] += dv * g.norm_squared();
        }
    }
    sums.map(f64::sqrt)
}
