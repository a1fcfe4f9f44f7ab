//! The space of a reduced model: displacement and pressure modes from states of training runs.
//!
//! Proper orthogonal decomposition by the method of snapshots (Sirovich, *Quart. Appl. Math.* 45, 1987): the displacement modes are orthonormal in
//! (u, v) = ∫ ∂u/∂X : ∂v/∂X dV, which weights strains equally throughout the body; the pressure modes in ∫ p q dV.
//!
//! A pressure space of few modes needs displacements that couple to each of them, or its equations are singular: volume-preserving states do not
//! contain such displacements. For each pressure mode p, the supremiser s with (s, v) = ∫ p div v dV for all v is added (Rozza & Veroy, *Comput.
//! Methods Appl. Mech. Eng.* 196, 2007; Ballarin et al., *Int. J. Numer. Meth. Eng.* 102, 2015). The volume is then preserved in as many means as
//! there are pressure modes, which leaves the other displacements free: the space does not lock.

use super::body_points::BodyPoints;
use crate::effect::Elastic;
use crate::material::{Want, law_from_table};
use crate::math::linear::Factor;
use crate::math::tensor::Mat3;
use crate::math::vector::dot;
use crate::reduction::error::ReductionError;
use crate::scene::Scene;
use crate::system::{At, Effect, Rates, System};
use nalgebra::DMatrix;

/// Modes as fields of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Basis {
    /// \[modes × unknowns\] displacement modes, then pressure modes
    pub modes: Vec<Vec<f64>>,
    /// Number of displacement modes, including supremisers
    pub displacements: usize,
    /// Number of these that are supremisers
    pub supremisers: usize,
    /// Singular values of the displacements of the states, descending, relative to the first
    pub singular_values: Vec<f64>,
    /// Singular values of the pressures of the states, descending, relative to the first
    pub pressure_values: Vec<f64>,
}

/// Share of a field that must be linearly independent for it to become a mode \[–\].
const NEW: f64 = 1e-7;

impl Basis {
    /// Builds the basis with `modes` modes of displacement and of pressure, or with as many as the states provide; states are \[unknowns\].
    pub fn of(scene: &Scene, points: &BodyPoints, states: &[&[f64]], modes: usize) -> Result<Self, ReductionError> {
        let split = scene.system.dofs.displacements as usize;
        let half = |state: &&[f64], keep: std::ops::Range<usize>| {
            let mut field = vec![0.0; state.len()];
            field[keep.clone()].copy_from_slice(&state[keep]);
            field
        };
        let moved: Vec<Vec<f64>> = states.iter().map(|s| half(s, 0..split)).collect();
        let weights = points.weights();
        let (mut displacement, singular_values) =
            decompose(&moved, &moved.iter().map(|u| strains(points, &weights, u)).collect::<Vec<_>>(), modes);
        let own = displacement.len();
        let (mut pressure, mut pressure_values) = (vec![], vec![]);
        if points.has_pressure() {
            let loaded: Vec<Vec<f64>> = states.iter().map(|s| half(s, split..s.len())).collect();
            let values = loaded.iter().map(|p| weighted(points, &weights, p)).collect::<Vec<_>>();
            (pressure, pressure_values) = decompose(&loaded, &values, modes);
            displacement.extend(supremisers(scene, points, &pressure)?);
        }
        orthonormalise(&mut displacement, |u| strains(points, &weights, u));
        orthonormalise(&mut pressure, |p| weighted(points, &weights, p));
        let displacements = displacement.len();
        displacement.append(&mut pressure);
        let supremisers = displacements.saturating_sub(own);
        Ok(Self { modes: displacement, displacements, supremisers, singular_values, pressure_values })
    }

    /// Returns x from the coordinates.
    pub fn expand(&self, y: &[f64]) -> Vec<f64> {
        combine(&self.modes, y)
    }
}

/// Returns Σ y_k v_k.
pub fn combine(fields: &[Vec<f64>], y: &[f64]) -> Vec<f64> {
    let mut x = vec![0.0; fields.first().map_or(0, Vec::len)];
    for (field, y) in fields.iter().zip(y) {
        x.iter_mut().zip(field).for_each(|(x, v)| *x += y * v);
    }
    x
}

/// Returns √w ∂u/∂X at all points, whose scalar products are those of the fields.
pub fn strains(points: &BodyPoints, weights: &[f64], u: &[f64]) -> Vec<f64> {
    points.gradients(u).iter().zip(weights).flat_map(|(g, w)| g.map(|g| g * w.sqrt())).collect()
}

/// Returns √w p at all points.
pub fn weighted(points: &BodyPoints, weights: &[f64], p: &[f64]) -> Vec<f64> {
    points.pressures(p).iter().zip(weights).map(|(p, w)| p * w.sqrt()).collect()
}

/// Returns the fields that best represent `fields`, at most `most`, and all singular values; scalar products are those of `values`.
pub fn decompose(fields: &[Vec<f64>], values: &[Vec<f64>], most: usize) -> (Vec<Vec<f64>>, Vec<f64>) {
    let n = fields.len();
    if n == 0 {
        return (vec![], vec![]);
    }
    let gram = DMatrix::from_fn(n, n, |i, j| dot(&values[i.max(j)], &values[i.min(j)]));
    let eigen = gram.symmetric_eigen();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]));
    let size = |k: usize| eigen.eigenvalues[k].max(0.0).sqrt();
    let first = order.first().map_or(0.0, |&k| size(k));
    let kept = order.iter().take(most).filter(|&&k| size(k) > NEW * first);
    let mode = |&k: &usize| {
        let shares: Vec<f64> = eigen.eigenvectors.column(k).iter().map(|v| v / size(k)).collect();
        combine(fields, &shares)
    };
    let modes = kept.map(mode).collect();
    (modes, order.iter().map(|&k| if first > 0.0 { size(k) / first } else { 0.0 }).collect())
}

/// Gram–Schmidt orthonormalisation, applied twice; a field that depends linearly on the previous ones is omitted.
pub fn orthonormalise(fields: &mut Vec<Vec<f64>>, values: impl Fn(&[f64]) -> Vec<f64>) {
    let mut done: Vec<(Vec<f64>, Vec<f64>)> = vec![];
    for mut field in std::mem::take(fields) {
        let mut own = values(&field);
        let size = dot(&own, &own).sqrt();
        for _ in 0..2 {
            for (other, of_other) in &done {
                let share = dot(&own, of_other);
                field.iter_mut().zip(other).for_each(|(v, w)| *v -= share * w);
                own.iter_mut().zip(of_other).for_each(|(v, w)| *v -= share * w);
            }
        }
        let left = dot(&own, &own).sqrt();
        if left > NEW * size {
            field.iter_mut().for_each(|v| *v /= left);
            own.iter_mut().for_each(|v| *v /= left);
            done.push((field, own));
        }
    }
    *fields = done.into_iter().map(|(field, _)| field).collect();
}

/// Returns, for each pressure field, the displacement that couples to it most strongly, at rest.
fn supremisers(scene: &Scene, points: &BodyPoints, pressures: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, ReductionError> {
    // 2με : ε with μ = ½ is an equivalent norm to ∂u/∂X : ∂u/∂X (Korn), and is a law of the library
    let table = "law = 'linear'\nE = '1 Pa'\nnu = 0".parse().expect("a table");
    let mesh = &scene.body.mesh;
    let mut effects: Vec<Box<dyn Effect>> = vec![];
    for part in &points.parts {
        let law = law_from_table(&table)?;
        effects.push(Box::new(Elastic::new("norm".into(), mesh, &part.constitution.points.cells, law)));
    }
    let prescribed = scene.system.prescribed.clone();
    let unsupported = |e: crate::system::SystemError| ReductionError::OtherScene(e.to_string());
    let system = System::new(mesh.points.len(), effects, vec![], prescribed).map_err(unsupported)?;
    let rest = system.rest();
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
    let mut sums = system.workspace();
    let undefined = |e: crate::system::EvalError| ReductionError::Law(e.to_string());
    system.assemble(&at, &[], Want::Tangent, None, &mut sums).map_err(undefined)?;
    let mut factor = Factor::new(system.pattern.clone());
    let singular = |e| ReductionError::Adjoint(crate::solve::Failure::Linear(e));
    factor.factorise(&sums.k).map_err(singular)?;
    let mut out = vec![];
    for pressure in pressures {
        let mut force = vec![0.0; rest.x.len()];
        for (place, p) in points.places().zip(points.pressures(pressure)) {
            let cells = points.parts[place.part].constitution.points;
            let t = Mat3::identity() * (p * cells.weight(place.block, place.point));
            let nodes = cells.blocks.nodes(place.block);
            for (&node, f) in nodes.iter().zip(cells.contract(place.block, place.point, &t)) {
                (0..3).for_each(|i| force[3 * node as usize + i] += f[i]);
            }
        }
        let mut right = system.restrict(&force);
        factor.solve(&sums.k, &mut right).map_err(singular)?;
        let mut field = vec![0.0; pressure.len()];
        system.expand(&right, &mut field[..rest.x.len()]);
        out.push(field);
    }
    Ok(out)
}
