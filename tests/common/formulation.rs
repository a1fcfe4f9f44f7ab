//! The ways a law can meet an element.

use super::body;
use durometer::effect::{Elastic, MeanDilatation, MixedElastic, PointStress, PressureHosts, Stressed};
use durometer::material::Law;
use durometer::math::tensor::Mat3;
use durometer::mesh::{Order, TetMesh};
use durometer::system::{Effect, Prescribed, System};
use std::sync::Arc;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Formulation {
    Displacement,
    Mixed,
    MeanDilatation,
}

use Formulation::{Displacement, MeanDilatation as Mean, Mixed};

pub const FORMULATIONS: [(Order, Formulation); 5] = [
    (Order::Linear, Displacement),
    (Order::Linear, Mixed),
    (Order::Quadratic, Displacement),
    (Order::Quadratic, Mixed),
    (Order::Quadratic, Mean),
];

pub const LOCKING_FREE: [(Order, Formulation); 3] =
    [(Order::Linear, Mixed), (Order::Quadratic, Mixed), (Order::Quadratic, Mean)];

/// Name as in the records.
pub fn label(order: Order, formulation: Formulation) -> &'static str {
    match (order, formulation) {
        (Order::Linear, Displacement) => "tet4",
        (Order::Linear, _) => "tet4_up",
        (Order::Quadratic, Displacement) => "tet10",
        (Order::Quadratic, Mixed) => "tet10_up",
        (Order::Quadratic, Mean) => "tet10_p0",
    }
}

/// The elastic effect of a formulation on the whole body, and the hosts of its second field.
pub fn formulated(mesh: &TetMesh, law: Box<dyn Law>, formulation: Formulation) -> (Box<dyn Effect>, Vec<u32>) {
    let cells = body(mesh);
    match formulation {
        Displacement => (Box::new(Elastic::new("elastic".into(), mesh, &cells, law)), vec![]),
        Mean => (Box::new(mean(mesh, &cells, &*law)), vec![]),
        Mixed => (Box::new(mixed(mesh, &cells, &*law)), PressureHosts::new(mesh, &cells, &[]).nodes().collect()),
    }
}

/// The same effect, to look at its pressures.
pub fn stressed(mesh: &TetMesh, law: Box<dyn Law>, formulation: Formulation) -> Arc<dyn Stressed> {
    let cells = body(mesh);
    match formulation {
        Displacement => Arc::new(Elastic::new("elastic".into(), mesh, &cells, law)),
        Mean => Arc::new(mean(mesh, &cells, &*law)),
        Mixed => Arc::new(mixed(mesh, &cells, &*law)),
    }
}

fn mean(mesh: &TetMesh, cells: &[u32], law: &dyn Law) -> MeanDilatation {
    MeanDilatation::new("elastic".into(), mesh, cells, law).expect("tet10 and a split law")
}

fn mixed(mesh: &TetMesh, cells: &[u32], law: &dyn Law) -> MixedElastic {
    let hosts = PressureHosts::new(mesh, cells, &[]);
    MixedElastic::new("elastic".into(), mesh, cells, law, &hosts, 3 * mesh.points.len() as u32).expect("a split law")
}

/// A body of one law in this formulation, with its loads and supports.
pub fn solid(
    mesh: &TetMesh,
    law: Box<dyn Law>,
    formulation: Formulation,
    loads: Vec<Box<dyn Effect>>,
    prescribed: Vec<Prescribed>,
) -> System {
    let (effect, hosts) = formulated(mesh, law, formulation);
    let mut effects = vec![effect];
    effects.extend(loads);
    System::with_scalars(mesh.points.len(), &hosts, effects, vec![], prescribed).expect("a system")
}

/// Mean pressure p [Pa] of each cell at a state (positive in tension): the field of the mixed formulation, κ times the
/// cell mean of G in the others.
pub fn cell_pressures(mesh: &TetMesh, law: &dyn Law, formulation: Formulation, x: &[f64]) -> Vec<f64> {
    let cells = body(mesh);
    let (_, volumetric) = law.split().expect("a split law");
    if formulation == Mixed {
        let scale = law.small_strain().mu / mesh.h();
        let at = |k: &u32| scale * x[3 * mesh.points.len() + *k as usize];
        let hosts = PressureHosts::new(mesh, &cells, &[]);
        return hosts.of_cells.iter().map(|own| own.iter().map(at).sum::<f64>() / 4.0).collect();
    }
    let elastic = Elastic::new("points".into(), mesh, &cells, law.split().expect("a split law").0);
    let mean = |(_, points): (u32, Vec<(f64, Mat3)>)| {
        let volume: f64 = points.iter().map(|p| p.0).sum();
        let gap = |f: &Mat3| volumetric.gap(f.determinant() - 1.0).expect("J > 0").0;
        volumetric.kappa * points.iter().map(|(w, f)| w * gap(f)).sum::<f64>() / volume
    };
    elastic.points().deformation(x, 0..elastic.points().cells.len()).map(mean).collect()
}
