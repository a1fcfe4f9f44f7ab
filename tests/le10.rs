//! NAFEMS LE10, the elliptic thick plate (NAFEMS, *The Standard NAFEMS Benchmarks*, 1990): σ_yy = −5.38 MPa at D.

mod common;

use common::mapped::mapped_block;
use common::{DeadLoad, elastic, hold, law, nodes, ramp, statics};
use durometer::effect::Elastic;
use durometer::material::Want;
use durometer::math::tensor::Vec3;
use durometer::mesh::Order;
use durometer::mesh::element::cell_shape;
use durometer::system::System;
use std::f64::consts::FRAC_PI_2;

/// σ_yy at D [Pa] with n cells along the short side and 2n along the ellipse. A quarter of the plate between the ellipses
/// x²/4 + y² = 1 and x²/3.25² + y²/2.75² = 1, |z| ≤ 0.3, curved tet10. The stress is extrapolated linearly from the four
/// points of each cell at D = (2, 0, 0.3) to D, and averaged over these cells.
fn stress(n: usize) -> f64 {
    let mesh = mapped_block([n, 2 * n, 2], Order::Quadratic, |p| {
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
    let points = Elastic::new("points".into(), &mesh, &common::body(&mesh), law()).points();
    let at_d = |c: usize| {
        mesh.cell(c)[..4].iter().position(|&k| (mesh.points[k as usize] - Vec3::new(2.0, 0.0, 0.3)).norm() < 1e-9)
    };
    // Barycentric coordinates at the points are a at three corners and b at the fourth: the linear field with the values
    // v_q there has (v_k − a Σ v)/(b − a) at corner k.
    let mut found = Vec::new();
    for (c, values) in points.deformation(&state.x) {
        let Some(corner) = at_d(c as usize) else { continue };
        let v: Vec<f64> =
            values.iter().map(|(_, f)| law().eval(f, Want::Residual).expect("linear").p[(1, 1)]).collect();
        let weights: Vec<f64> = points.reference().iter().map(|&xi| cell_shape(Order::Linear, xi)[corner]).collect();
        let k = (0..4).max_by(|&i, &j| weights[i].total_cmp(&weights[j])).expect("four points");
        let (b, a) = (weights[k], (1.0 - weights[k]) / 3.0);
        found.push((v[k] - a * v.iter().sum::<f64>()) / (b - a));
    }
    assert!(!found.is_empty(), "D is a node");
    found.iter().sum::<f64>() / found.len() as f64
}

#[test]
fn le10() {
    for n in [2, 4, 6, 8] {
        let t = std::time::Instant::now();
        println!("LE10 n {n}: {:.4e} {:?}", stress(n), t.elapsed());
    }
}
