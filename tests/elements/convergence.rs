//! Manufactured solutions: the error of both elements falls with the order of theory, p + 1 in L2 and p in the H1 seminorm
//! (Ciarlet, *The Finite Element Method for Elliptic Problems*, 1978, th. 3.2.2 and 3.2.5).
//!
//! u_i = a sin(q_i·X + φ_i) on the unit cube, given on the surface, held by b_i = −A_iJkL ∂²u_k/∂X_J∂X_L. The two finest
//! meshes give the order; the next term of the error is one order of h higher, which with the smooth q used (a quarter
//! wave over the cube) stays below the ±0.1 allowed. Norms by the degree-5 rule.

use crate::common::field::errors;
use crate::common::{DeadLoad, elastic, law, move_to, ramp, statics, surface};
use durometer::material::{Law, Want};
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::Order;
use durometer::mesh::disturb::distort;
use durometer::mesh::structured::block;
use durometer::system::System;

/// u, its gradient and second derivatives.
struct Wave {
    amplitude: f64,
    q: [Vec3; 3],
    phase: [f64; 3],
}

impl Wave {
    fn new(amplitude: f64) -> Self {
        let q = [Vec3::new(1.3, 0.7, -0.5), Vec3::new(-0.6, 1.2, 0.9), Vec3::new(0.8, -0.9, 1.1)];
        Self { amplitude, q, phase: [0.3, 0.9, -0.4] }
    }

    fn u(&self, x: Vec3) -> Vec3 {
        Vec3::from_fn(|i, _| self.amplitude * (self.q[i].dot(&x) + self.phase[i]).sin())
    }

    fn gradient(&self, x: Vec3) -> Mat3 {
        Mat3::from_fn(|i, j| self.amplitude * (self.q[i].dot(&x) + self.phase[i]).cos() * self.q[i][j])
    }

    /// −Div P
    fn force(&self, law: &dyn Law, x: Vec3) -> Vec3 {
        let a = law.eval(&(Mat3::identity() + self.gradient(x)), Want::Tangent).unwrap().a;
        let u = self.u(x);
        let mut b = Vec3::zeros();
        for i in 0..3 {
            for j in 0..3 {
                for k in 0..3 {
                    for l in 0..3 {
                        // ∂²u_k/∂X_J∂X_L = −u_k q_kJ q_kL
                        b[i] += a[3 * i + j][3 * k + l] * u[k] * self.q[k][j] * self.q[k][l];
                    }
                }
            }
        }
        b
    }
}

/// Observed orders in L2 and H1 between meshes of n³ and (2n)³ boxes with inner nodes moved.
fn orders(name: &str, amplitude: f64, order: Order, n: usize) -> [f64; 2] {
    let run = |n: usize| {
        let mut mesh = block(n, n, n, 1.0, 1.0, 1.0, order);
        distort(&mut mesh, 5, 0.1);
        let (wave, law) = (Wave::new(amplitude), law(name, 1.0, 0.3));
        let load = DeadLoad::body(&mesh, ramp(1.0), |x| wave.force(law.as_ref(), x));
        let prescribed = move_to(&mesh, &surface(&mesh), |x| wave.u(x));
        let effects = vec![elastic(&mesh, law), Box::new(load) as _];
        let system = System::new(mesh.points.len(), effects, vec![], prescribed).unwrap();
        // 1e-10 of the internal forces: the smallest error of the fields is 1e-6.
        errors(&mesh, &statics(&mesh, &system, 1e-10, 1).0.x, |x| (wave.u(x), wave.gradient(x)))
    };
    let (coarse, fine) = (run(n), run(2 * n));
    let found = [0, 1].map(|k| f64::log2(coarse[k] / fine[k]));
    println!("{name} {order:?}: errors {fine:?} at n = {}, orders {found:?}", 2 * n);
    found
}

/// On coarse meshes of so many boxes a side for each element.
fn check(name: &str, amplitude: f64, boxes: [usize; 2]) {
    for ((order, p), n) in [(Order::Linear, 1.0), (Order::Quadratic, 2.0)].into_iter().zip(boxes) {
        let [l2, h1] = orders(name, amplitude, order, n);
        assert!((l2 - p - 1.0).abs() <= 0.1, "{name} {order:?}: order {l2} in L2");
        assert!((h1 - p).abs() <= 0.1, "{name} {order:?}: order {h1} in H1");
    }
}

#[test]
fn linear_law_converges_with_the_order_of_theory() {
    check("linear", 0.01, [6, 3]);
}

/// Strains of about 15 %.
#[test]
fn neo_hookean_law_converges_with_the_order_of_theory() {
    check("neo_hookean", 0.1, [8, 4]);
}
