//! NAFEMS LE10, the elliptic thick plate (NAFEMS, *The Standard NAFEMS Benchmarks*, 1990): σ_yy = −5.38 MPa at D.

use crate::common;
use crate::common::{DeadLoad, elastic, hold, law, nodes, ramp, statics};
use durometer::effect::{Elastic, PointStress};
use durometer::material::Want;
use durometer::math::tensor::Vec3;
use durometer::mesh::Order;
use durometer::mesh::curved::mapped_block;
use durometer::system::System;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::FRAC_PI_2;

/// σ_yy at D [Pa] with n cells along the short side, 2n along the ellipse and `layers` through the thickness. A quarter of
/// the plate between the ellipses x²/4 + y² = 1 and x²/3.25² + y²/2.75² = 1, |z| ≤ 0.3, curved tet10.
///
/// Recovery: a quadratic polynomial fitted by least squares to the stress at the points of the cells around D and of their
/// neighbours, at D = (2, 0, 0.3) (Zienkiewicz & Zhu 1992).
fn stress(n: usize, layers: usize) -> f64 {
    let mesh = mapped_block([n, 2 * n, layers], Order::Quadratic, |p| {
        let (s, c) = (FRAC_PI_2 * p.y).sin_cos();
        Vec3::new((2.0 + 1.25 * p.x) * c, (1.0 + 1.75 * p.x) * s, 0.6 * (p.z - 0.5))
    });
    let law = || law("linear", 210e9, 0.3);
    let top = &mesh.regions["zmax"].facets;
    let load = DeadLoad::traction(&mesh, "zmax", ramp(1.0), Vec3::new(0.0, 0.0, -1e6 * mesh.region_area(top)));
    // Outer face: u_x = u_y = 0, and u_z = 0 on its middle line; planes of symmetry y = 0 and x = 0.
    let outer = nodes(&mesh, "xmax");
    let mut prescribed = hold(&outer, &[0, 1]);
    let middle: Vec<u32> = outer.iter().copied().filter(|&k| mesh.points[k as usize].z.abs() < 1e-9).collect();
    prescribed.extend(hold(&middle, &[2]));
    for (side, component) in [("ymin", 1), ("ymax", 0)] {
        let free: Vec<u32> = nodes(&mesh, side).into_iter().filter(|k| outer.binary_search(k).is_err()).collect();
        prescribed.extend(hold(&free, &[component]));
    }
    let effects = vec![elastic(&mesh, law()), Box::new(load) as _];
    let system = System::new(mesh.points.len(), effects, vec![], prescribed).expect("a system");
    let (state, _) = statics(&mesh, &system, 1e-8, 1);
    let elastic = Elastic::new("points".into(), &mesh, &common::body(&mesh), law());
    let points = elastic.points();
    let d = Vec3::new(2.0, 0.0, 0.3);
    let near: Vec<u32> = (0..mesh.cell_count())
        .filter(|&c| mesh.cell(c)[..4].iter().any(|&k| (mesh.points[k as usize] - d).norm() < 1e-9))
        .flat_map(|c| mesh.cell(c)[..4].to_vec())
        .collect();
    assert!(!near.is_empty(), "D is a node");
    let (mut rows, mut values) = (Vec::new(), Vec::new());
    for (c, gradients) in points.deformation(&state.x, 0..points.cells.len()) {
        if !mesh.cell(c as usize)[..4].iter().any(|k| near.contains(k)) {
            continue;
        }
        for (&xi, (_, f)) in points.reference().iter().zip(gradients) {
            let q = mesh.position(c as usize, xi) - d;
            rows.extend([1.0, q.x, q.y, q.z, q.x * q.x, q.y * q.y, q.z * q.z, q.x * q.y, q.y * q.z, q.z * q.x]);
            values.push(law().eval(&f, Want::Residual).expect("linear").p[(1, 1)]);
        }
    }
    let fit = DMatrix::from_row_slice(values.len(), 10, &rows).svd(true, true);
    fit.solve(&DVector::from_vec(values), 1e-12).expect("both factors")[0]
}

/// Within 2 % on a mesh of 12 × 24 × 4 boxes, and nearer than on the coarse one.
#[test]
fn thick_plate_has_the_published_stress() {
    let errors = [(4, 2), (6, 4), (8, 4), (12, 4)].map(|(n, layers)| {
        let stress = stress(n, layers);
        let error = stress / -5.38e6 - 1.0;
        println!("LE10 {n} x {} x {layers} boxes: {:.3} MPa, error {error:.1e}", 2 * n, 1e-6 * stress);
        error.abs()
    });
    assert!(errors[3] <= 0.02 && errors[3] < errors[0], "{errors:?}");
}
