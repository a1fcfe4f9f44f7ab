//! Numerical inf–sup test (Chapelle & Bathe 1993; Bathe 2001): the smallest eigenvalue of (B A⁻¹Bᵀ + C) q = β² (M/μ) q on a
//! sequence of meshes. A is the stiffness of the law without its volumetric part, B the coupling of J and p, M the mass of
//! the pressures, C the stabilisation (Elman, Silvester & Wathen, *Finite Elements and Fast Iterative Solvers*, 2014, ch. 3).
//!
//! A and B are what the code assembles at rest, on the unit cube with one face clamped and the others free: no constant
//! pressure has to be taken out. Bounded below: stable.

use crate::common;
use crate::common::formulation::{Formulation, formulated};
use crate::common::{hold, law, nodes};
use durometer::effect::{Elastic, MixedElastic, PressureHosts};
use durometer::material::Law;
use durometer::math::linear::Factor;
use durometer::math::vector::dot;
use durometer::mesh::disturb::distort;
use durometer::mesh::element::cell_shape;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh, quadrature};
use durometer::system::{At, BlockValues, Dofs, Effect, Rates, System, Want};
use nalgebra::DMatrix;

/// μ = 1, κ = 1: B and M do not depend on κ.
fn rubber() -> Box<dyn Law> {
    law("neo_hookean_split", 9.0 / 4.0, 1.0 / 8.0)
}

/// Tangent at rest, in the equations of the system.
fn tangent(system: &System) -> Vec<f64> {
    let (rest, mut sums) = (system.rest(), system.workspace());
    let at = At {
        t: 0.0,
        dt: f64::INFINITY,
        x: &rest.x,
        v: &rest.v,
        a: &rest.a,
        old: &rest.x,
        history: &rest.history,
        inputs: &[],
        rates: Rates::default(),
    };
    system.assemble(&at, &[], Want::Tangent, None, &mut sums).expect("at rest");
    sums.k
}

/// The system of A alone.
fn shear(mesh: &TetMesh) -> System {
    let rest = rubber().split().expect("a split law").0;
    let effect = Elastic::new("shear".into(), mesh, &common::body(mesh), rest);
    let held = hold(&nodes(mesh, "xmin"), &[0, 1, 2]);
    System::new(mesh.points.len(), vec![Box::new(effect)], vec![], held).expect("a system")
}

/// Columns Bᵀ of the corner pressures, in the equations of `shear`, and M: from the mixed effect and by quadrature.
fn continuous(mesh: &TetMesh, shear: &System) -> (Vec<Vec<f64>>, DMatrix<f64>, DMatrix<f64>) {
    let cells = common::body(mesh);
    let first = 3 * mesh.points.len() as u32;
    let hosts = PressureHosts::new(mesh, &cells, &[]);
    let effect = MixedElastic::new("mixed".into(), mesh, &cells, &*rubber(), &hosts, first).expect("a split law");
    let of_nodes: Vec<u32> = hosts.nodes().collect();
    let held = hold(&nodes(mesh, "xmin"), &[0, 1, 2]);
    let system =
        System::with_scalars(mesh.points.len(), &of_nodes, vec![Box::new(effect)], vec![], held).expect("a system");
    let k = tangent(&system);
    let n = of_nodes.len();
    // p = π/h: the code's rows are per π.
    let scale = mesh.h();
    let equation = |c: usize| system.dofs.equation[first as usize + c];
    let (mut columns, mut block) = (Vec::new(), DMatrix::zeros(n, n));
    for c in 0..n {
        let (mut unit, mut image) = (vec![0.0; system.pattern.n], vec![0.0; system.pattern.n]);
        unit[equation(c) as usize] = scale;
        system.pattern.multiply(&k, &unit, &mut image);
        columns.push(shear.dofs.free.iter().map(|&d| image[system.dofs.equation[d as usize] as usize]).collect());
        (0..n).for_each(|d| block[(d, c)] = scale * image[equation(d) as usize]);
    }
    let mut mass = DMatrix::zeros(n, n);
    let rule = quadrature::tet(5);
    for c in 0..mesh.cell_count() {
        let places = hosts.of_cells[c].map(|k| k as usize);
        for (&xi, w) in rule.points.iter().zip(&rule.weights) {
            let (shape, dv) = (cell_shape(Order::Linear, xi), w * mesh.jacobian(c, xi).determinant());
            for (a, &i) in places.iter().enumerate() {
                places.iter().enumerate().for_each(|(b, &j)| mass[(i, j)] += dv * shape[a] * shape[b]);
            }
        }
    }
    // The pressure block of the code is −(M/κ + C), with κ = 1.
    (columns, -block - &mass, mass)
}

/// Columns Bᵀ of the cell pressures of the mean dilatation and M = diag V. Its tangent at rest is A_e + (κ/V) b bᵀ.
fn per_cell(mesh: &TetMesh, shear: &System) -> (Vec<Vec<f64>>, DMatrix<f64>) {
    let (mean, _) = formulated(mesh, rubber(), Formulation::MeanDilatation);
    let x = vec![0.0; 3 * mesh.points.len()];
    let at = At {
        t: 0.0,
        dt: f64::INFINITY,
        x: &x,
        v: &x,
        a: &x,
        old: &x,
        history: &[],
        inputs: &[],
        rates: Rates::default(),
    };
    let element = |effect: &dyn Effect, c: usize| {
        let mut local = BlockValues::new(30);
        effect.eval(&at, c, Want::Tangent, &mut local).expect("at rest");
        local.k
    };
    let (mut columns, mut mass) = (Vec::new(), DMatrix::zeros(mesh.cell_count(), mesh.cell_count()));
    for c in 0..mesh.cell_count() {
        let volume = mesh.cell_volume(c);
        let (with, without) = (element(&*mean, c), element(&*shear.effects[0], c));
        // Entries with column ≤ row are given; row j = the row of the largest diagonal entry gives b up to its size.
        let outer = |i: usize, j: usize| (with[i.max(j) * 30 + i.min(j)] - without[i.max(j) * 30 + i.min(j)]) * volume;
        let j = (0..30).max_by(|&a, &b| outer(a, a).total_cmp(&outer(b, b))).expect("thirty rows");
        let mut column = vec![0.0; shear.dofs.free.len()];
        for (i, dof) in mean.blocks().dofs(c).enumerate() {
            let equation = shear.dofs.equation[dof as usize];
            if equation != Dofs::FIXED {
                column[equation as usize] = outer(i, j) / outer(j, j).sqrt();
            }
        }
        columns.push(column);
        mass[(c, c)] = volume;
    }
    (columns, mass)
}

/// √ of the smallest eigenvalue of S q = β² M q, S = B A⁻¹Bᵀ + C.
fn beta(shear: &System, columns: &[Vec<f64>], c: Option<&DMatrix<f64>>, mass: DMatrix<f64>) -> f64 {
    let k = tangent(shear);
    let mut factor = Factor::new(shear.pattern.clone());
    factor.factorise(&k).expect("positive definite");
    let mut solved = columns.concat();
    factor.solve(&k, &mut solved).expect("accurate");
    let solved: Vec<&[f64]> = solved.chunks_exact(shear.pattern.n).collect();
    let mut s = DMatrix::from_fn(columns.len(), columns.len(), |i, j| dot(&columns[i], solved[j]));
    if let Some(c) = c {
        s += c;
    }
    let l = mass.cholesky().expect("a mass").l();
    let half = l.solve_lower_triangular(&s).expect("regular");
    let whole = l.solve_lower_triangular(&half.transpose()).expect("regular");
    // Rounding may leave a zero eigenvalue slightly negative.
    (0.5 * (&whole + whole.transpose())).symmetric_eigenvalues().min().max(0.0).sqrt()
}

fn cubes<const N: usize>(order: Order, sizes: [usize; N]) -> [TetMesh; N] {
    sizes.map(|n| {
        let mut mesh = block(n, n, n, 1.0, 1.0, 1.0, order);
        distort(&mut mesh, 3, 0.1);
        mesh
    })
}

/// Bounded below: the last halving of h takes less than 5 % off, and the value itself is of order one.
fn assert_bounded(name: &str, betas: &[f64]) {
    let [.., before, last] = betas else { panic!("two meshes at least") };
    assert!(*last > 0.3 && last / before > 0.95, "{name}: {betas:?}");
}

#[test]
fn taylor_hood_is_stable() {
    let betas = cubes(Order::Quadratic, [1, 2, 4]).map(|mesh| {
        let a = shear(&mesh);
        let (b, c, m) = continuous(&mesh, &a);
        assert!(c.amax() <= 1e-12 * m.amax(), "it needs no stabilisation");
        beta(&a, &b, None, m)
    });
    println!("inf-sup tet10_up: {betas:.3?} at n = 1, 2, 4");
    assert_bounded("tet10_up", &betas);
}

/// Equal order has pressures that no displacement sees (β = 0 up to √ε); the projection gives them a stiffness.
#[test]
fn equal_order_is_stable_by_its_stabilisation_only() {
    let betas = cubes(Order::Linear, [2, 3, 6]).map(|mesh| {
        let a = shear(&mesh);
        let (b, c, m) = continuous(&mesh, &a);
        [beta(&a, &b, None, m.clone()), beta(&a, &b, Some(&c), m)]
    });
    let (bare, stabilised) = (betas.map(|b| b[0]), betas.map(|b| b[1]));
    println!("inf-sup tet4 without stabilisation: {bare:?}, tet4_up: {stabilised:.3?} at n = 2, 3, 6");
    assert!(bare.iter().all(|b| *b < 1e-6), "{bare:?}");
    assert_bounded("tet4_up", &stabilised);
}

/// P2/P0 on tetrahedra has no unknown that moves one face along its normal (that takes the bubble of the face), and here β
/// falls with h: no pressure is spurious, β > 0, but there is no bound. Displacements converge (tests/elements/manufactured.rs), at
/// the cost of the largest pressure error of the three.
#[test]
fn cell_pressures_have_no_spurious_mode_and_no_bound() {
    let betas = cubes(Order::Quadratic, [1, 2, 4]).map(|mesh| {
        let a = shear(&mesh);
        let (b, m) = per_cell(&mesh, &a);
        beta(&a, &b, None, m)
    });
    println!("inf-sup tet10_p0: {betas:.3?} at n = 1, 2, 4");
    assert!(betas.iter().all(|b| *b > 0.05) && betas.windows(2).all(|b| b[1] < 0.8 * b[0]), "{betas:?}");
}
