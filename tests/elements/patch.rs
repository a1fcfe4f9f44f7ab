//! Patch tests: fields that the elements hold exactly come out exactly, on distorted meshes.
//!
//! Tolerances. The solution solves K u = f with a residual of 1e-13 of the internal forces; the meshes are so small (some
//! hundred unknowns) that the condition of K times ε stays below 1e-12 of the largest displacement.

use crate::common;
use crate::common::{DeadLoad, ORDERS, body, distorted_cube, example, law, move_to, ramp, statics, surface};
use durometer::effect::{Elastic, PointStress};
use durometer::material::{LAWS, Want};
use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::{Order, TetMesh};
use durometer::system::System;
use std::sync::Arc;

/// Largest error of the nodes inside, relative to the largest displacement.
fn inner_error(mesh: &TetMesh, x: &[f64], u: impl Fn(Vec3) -> Vec3) -> f64 {
    let on = surface(mesh);
    let inner: Vec<usize> = (0..mesh.points.len()).filter(|k| on.binary_search(&(*k as u32)).is_err()).collect();
    assert!(!inner.is_empty(), "a patch without an inner node tests nothing");
    let size = mesh.points.iter().map(|p| u(*p).norm()).fold(0.0, larger);
    let error = |k: usize| (Vec3::from_column_slice(&x[3 * k..3 * k + 3]) - u(mesh.points[k])).norm();
    inner.into_iter().map(error).fold(0.0, larger) / size
}

/// u = H X on the surface: u = H X inside, F = I + H and P(F) at every point, and reactions with Σ X ⊗ r = P V
/// (Gauss), for every law.
#[test]
fn affine_fields_are_exact() {
    let h = Mat3::new(0.12, 0.07, -0.05, 0.03, -0.09, 0.11, -0.06, 0.04, 0.1);
    for entry in LAWS {
        for order in ORDERS {
            let label = format!("{} {order:?}", entry.info.name);
            let mesh = distorted_cube(3, order, 0.15, 23);
            let effect = Arc::new(Elastic::new("elastic".into(), &mesh, &body(&mesh), example(entry.info.name)));
            let prescribed = move_to(&mesh, &surface(&mesh), |p| h * p);
            let system = System::new(mesh.points.len(), vec![Box::new(effect.clone())], vec![], prescribed).unwrap();
            let (state, sums) = statics(&mesh, &system, 1e-13, 1);
            let error = inner_error(&mesh, &state.x, |p| h * p);
            println!("affine {label}: {error:.1e}");
            assert!(error <= 1e-12, "{label}: {error:e}");
            let f = Mat3::identity() + h;
            // ∂N/∂X is of the size of ten displacements per edge.
            let all = 0..effect.points().cells.len();
            for (cell, points) in effect.points().deformation(&state.x, all) {
                for (_, got) in points {
                    assert!((got - f).norm() <= 1e-11, "{label}: F = {got} in cell {cell}");
                }
            }
            let p = example(entry.info.name).eval(&f, Want::Residual).unwrap().p;
            let moment: Mat3 = (mesh.points.iter().zip(sums.r.chunks_exact(3)))
                .map(|(x, r)| Vec3::from_column_slice(r) * x.transpose())
                .sum();
            let wanted = p * mesh.volume();
            assert!((moment - wanted).norm() <= 1e-11 * wanted.norm(), "{label}: {moment} is not P V = {wanted}");
        }
    }
}

/// u = quadratic in X with the constant body force that holds it, linear law: tet10 holds it exactly, tet4 does not.
#[test]
fn quadratic_fields_are_exact_on_tet10() {
    let g = [
        Mat3::new(0.03, 0.02, -0.01, 0.02, -0.04, 0.015, -0.01, 0.015, 0.02),
        Mat3::new(-0.02, 0.01, 0.03, 0.01, 0.05, -0.02, 0.03, -0.02, 0.01),
        Mat3::new(0.01, -0.03, 0.02, -0.03, 0.02, 0.01, 0.02, 0.01, -0.05),
    ];
    let u = |p: Vec3| Vec3::from_fn(|i, _| (p.transpose() * g[i] * p)[0]);
    let (e, nu) = (1e5, 0.3);
    let (mu, lambda) = (e / (2.0 * (1.0 + nu)), e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)));
    // Navier: b = −μ Δu − (λ + μ) ∇ div u, with u_i,JK = 2 g_i[J, K].
    let b = Vec3::from_fn(|i, _| {
        let divergence: f64 = (0..3).map(|k| 2.0 * g[k][(k, i)]).sum();
        -mu * 2.0 * g[i].trace() - (lambda + mu) * divergence
    });
    let error = |order| {
        let mesh = distorted_cube(3, order, 0.15, 29);
        let load = DeadLoad::body(&mesh, ramp(1.0), |_| b);
        let prescribed = move_to(&mesh, &surface(&mesh), u);
        let effects = vec![common::elastic(&mesh, law("linear", e, nu)), Box::new(load) as _];
        let system = System::new(mesh.points.len(), effects, vec![], prescribed).unwrap();
        inner_error(&mesh, &statics(&mesh, &system, 1e-13, 1).0.x, u)
    };
    let (linear, quadratic) = (error(Order::Linear), error(Order::Quadratic));
    println!("quadratic field: tet4 {linear:.1e}, tet10 {quadratic:.1e}");
    assert!(quadratic <= 1e-12, "tet10: {quadratic:e}");
    assert!(linear > 1e-3, "tet4 cannot hold a quadratic field, and shows {linear:e}");
}
