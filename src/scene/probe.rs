//! What is recorded at every accepted step: one function of the state per column, unit in the name.
//!
//! Positions and directions are means over the area of a region, so they do not depend on the mesh.

use super::build::{Drive, NamedCable, NamedCavity, Scene};
use super::contact_record::NamedContact;
use super::error::SceneError;
use super::quantity::Length;
use super::rigid::RigidBody;
use super::spec::ProbeSpec;
use crate::effect::CellPoints;
use crate::math::tensor::Vec3;
use crate::mesh::embed::{EmbedError, embed};
use crate::mesh::{Region, TetMesh, element, quadrature};
use crate::system::State;
use std::sync::Arc;

/// Energies since the start \[J\]: stored and kinetic at the state, dissipated and put in along the path.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Energies {
    pub elastic: f64,
    pub kinetic: f64,
    pub dissipated: f64,
    pub work: f64,
}

/// What a probe may look at.
pub struct Moment<'a> {
    pub state: &'a State,
    /// \[3 × nodes\] residual: at prescribed dofs the reaction \[N\]
    pub residual: &'a [f64],
    pub energies: Energies,
    pub scene: &'a Scene,
}

/// Area mean over facets as weights of nodes; for regions without facets the plain mean of the nodes.
#[derive(Clone, Debug)]
pub struct Mean {
    weights: Vec<(u32, f64)>,
    pub(super) origin: Vec3,
}

impl Mean {
    fn new(mesh: &TetMesh, region: &Region) -> Self {
        let mut weights = vec![0.0; mesh.points.len()];
        if region.facets.is_empty() {
            mesh.nodes_of(region).iter().for_each(|&k| weights[k as usize] = 1.0);
        }
        let rule = quadrature::tri(4);
        for &f in &region.facets {
            for (&xi, w) in rule.points.iter().zip(&rule.weights) {
                let area = w * mesh.facet_normal(f as usize, xi).norm();
                for (&node, n) in mesh.facet(f as usize).iter().zip(element::facet_shape(mesh.order, xi)) {
                    weights[node as usize] += area * n;
                }
            }
        }
        let total: f64 = weights.iter().sum();
        let weights: Vec<(u32, f64)> =
            (0..).zip(weights).filter(|(_, w)| *w != 0.0).map(|(k, w)| (k, w / total)).collect();
        let origin = weights.iter().map(|&(k, w)| mesh.points[k as usize] * w).sum();
        Self { weights, origin }
    }

    /// Change of the mean position with the motion dx \[m\].
    pub(super) fn moved(&self, dx: &[f64]) -> Vec3 {
        self.weights.iter().map(|&(k, w)| w * Vec3::from_column_slice(&dx[3 * k as usize..][..3])).sum()
    }

    /// Mean position at displacement x \[m\].
    pub(super) fn at(&self, x: &[f64]) -> Vec3 {
        self.weights.iter().fold(self.origin, |p, &(k, w)| p + w * Vec3::from_column_slice(&x[3 * k as usize..][..3]))
    }
}

/// A recorded quantity, ready to be evaluated.
pub enum Probe {
    BendingAngle { root: Mean, tip: Mean, facets: Vec<u32> },
    Position { name: String, mean: Mean },
    Markers { name: String, points: Vec<Mean> },
    Reaction { name: String, nodes: Vec<u32> },
    Energy,
    Stretch,
}

impl Probe {
    pub(super) fn new(
        spec: &ProbeSpec,
        mesh: &TetMesh,
        region: &dyn Fn(&str) -> Result<Region, SceneError>,
        refuse: &dyn Fn(EmbedError) -> SceneError,
    ) -> Result<Self, SceneError> {
        Ok(match spec {
            ProbeSpec::BendingAngle { root, tip } => {
                let (root, tip) = (region(root)?, region(tip)?);
                Self::BendingAngle {
                    root: Mean::new(mesh, &root),
                    tip: Mean::new(mesh, &tip),
                    facets: tip.facets.clone(),
                }
            }
            ProbeSpec::Position { region: name } => {
                Self::Position { name: name.clone(), mean: Mean::new(mesh, &region(name)?) }
            }
            ProbeSpec::Markers { name, points } => {
                let marker = |p: &[Length; 3]| {
                    let origin = Vec3::new(p[0].0, p[1].0, p[2].0);
                    embed(mesh, origin).map(|e| Mean { weights: e.weights, origin }).map_err(refuse)
                };
                Self::Markers { name: name.clone(), points: points.iter().map(marker).collect::<Result<_, _>>()? }
            }
            ProbeSpec::Reaction { region: name } => {
                Self::Reaction { name: name.clone(), nodes: mesh.nodes_of(&region(name)?) }
            }
            ProbeSpec::Energy {} => Self::Energy,
            ProbeSpec::Stretch {} => Self::Stretch,
        })
    }

    /// Names of its columns, with the unit at the end.
    pub fn columns(&self) -> Vec<String> {
        let names = |list: &[&str]| list.iter().map(ToString::to_string).collect();
        match self {
            Self::BendingAngle { facets, .. } if facets.is_empty() => names(&["chord_angle_deg"]),
            Self::BendingAngle { .. } => names(&["bending_angle_deg", "chord_angle_deg"]),
            Self::Position { name, .. } => ["x", "y", "z"].map(|c| format!("{name}_{c}_m")).into(),
            Self::Markers { name, points } => {
                (1..=points.len()).flat_map(|k| ["x", "y", "z"].map(|c| format!("{name}_{k}_{c}_m"))).collect()
            }
            Self::Reaction { name, .. } => ["x", "y", "z"].map(|c| format!("{name}_reaction_{c}_N")).into(),
            Self::Energy => names(&["elastic_J", "kinetic_J", "dissipated_J", "work_J"]),
            Self::Stretch => names(&["stretch_median", "stretch_p95", "stretch_max", "min_j"]),
        }
    }

    /// Values of its columns.
    pub fn record(&self, now: &Moment) -> Vec<f64> {
        let x = &now.state.x;
        match self {
            Self::BendingAngle { root, tip, facets } => {
                let mesh = &now.scene.body.mesh;
                let chord = angle(tip.origin - root.origin, tip.at(x) - root.at(x));
                if facets.is_empty() {
                    return vec![chord];
                }
                let rest = vec![0.0; x.len()];
                vec![angle(area_vector(mesh, facets, &rest), area_vector(mesh, facets, x)), chord]
            }
            Self::Position { mean, .. } => mean.at(x).as_slice().to_vec(),
            Self::Markers { points, .. } => points.iter().flat_map(|p| p.at(x).data.0[0]).collect(),
            Self::Reaction { nodes, .. } => {
                let sum = |i: usize| nodes.iter().map(|&k| now.residual[3 * k as usize + i]).sum();
                (0..3).map(sum).collect()
            }
            Self::Energy => {
                let Energies { elastic, kinetic, dissipated, work } = now.energies;
                vec![elastic, kinetic, dissipated, work]
            }
            Self::Stretch => stretches(&now.scene.elastic, x),
        }
    }
}

/// Names of all recorded columns, time first.
pub(super) fn columns(
    probes: &[Probe],
    cables: &[NamedCable],
    cavities: &[NamedCavity],
    (rigids, contacts): (&[RigidBody], &[NamedContact]),
) -> Vec<String> {
    let probes = probes.iter().flat_map(Probe::columns);
    let cables = cables.iter().flat_map(NamedCable::columns);
    let cavities = cavities.iter().flat_map(cavity_columns);
    let rigids = rigids.iter().flat_map(RigidBody::columns);
    let contacts = rigids.chain(contacts.iter().flat_map(NamedContact::columns));
    let last = std::iter::once("newton_iterations".to_string());
    std::iter::once("t_s".to_string()).chain(probes).chain(cables).chain(cavities).chain(contacts).chain(last).collect()
}

/// Columns of a cavity: pressure and volume.
pub fn cavity_columns(cavity: &NamedCavity) -> [String; 2] {
    [format!("{}_pressure_Pa", cavity.name), format!("{}_volume_m3", cavity.name)]
}

/// Pressure \[Pa\] and volume \[m³\] of a cavity.
pub fn record_cavity(cavity: &NamedCavity, state: &State) -> [f64; 2] {
    let pressure = match &cavity.drive {
        Drive::Multiplier(c) => state.lambda[*c],
        Drive::Prescribed(signal) => signal.at(state.clock()),
    };
    [pressure, cavity.cavity.volume(&state.x)]
}

/// ∫ n dA over deformed facets \[m²\].
pub(super) fn area_vector(mesh: &TetMesh, facets: &[u32], x: &[f64]) -> Vec3 {
    let rule = quadrature::tri(2);
    let mut sum = Vec3::zeros();
    for &f in facets {
        let nodes = mesh.facet(f as usize);
        for (&xi, w) in rule.points.iter().zip(&rule.weights) {
            let gradients = element::facet_gradients(mesh.order, xi);
            let (mut a, mut b) = (Vec3::zeros(), Vec3::zeros());
            for (&k, g) in nodes.iter().zip(gradients) {
                let p = mesh.points[k as usize] + Vec3::from_column_slice(&x[3 * k as usize..][..3]);
                a += p * g[0];
                b += p * g[1];
            }
            sum += a.cross(&b) * *w;
        }
    }
    sum
}

/// Angle between two directions \[deg\], 0 to 180.
fn angle(a: Vec3, b: Vec3) -> f64 {
    a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
}

/// Median, 95th percentile and maximum of the largest principal stretch, by volume, and the smallest J.
pub fn stretches(elastic: &[Arc<CellPoints>], x: &[f64]) -> Vec<f64> {
    let mut values: Vec<(f64, f64)> = Vec::new();
    let mut min_j = f64::INFINITY;
    for (_, points) in elastic.iter().flat_map(|e| e.deformation(x)) {
        for (weight, f) in points {
            values.push((largest_stretch(&f), weight));
            min_j = min_j.min(f.determinant());
        }
    }
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = values.iter().map(|v| v.1).sum();
    let quantile = |q: f64| {
        let mut below = 0.0;
        let found = values.iter().find(|v| {
            below += v.1;
            below >= q * total
        });
        found.or(values.last()).map_or(f64::NAN, |v| v.0)
    };
    vec![quantile(0.5), quantile(0.95), quantile(1.0), min_j]
}

/// Largest singular value of F.
pub fn largest_stretch(f: &crate::math::tensor::Mat3) -> f64 {
    f.tr_mul(f).symmetric_eigenvalues().max().max(0.0).sqrt()
}
