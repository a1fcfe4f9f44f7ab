//! Cell indicators: where in the mesh of the run the change J⁺ − J of a quantity comes from (dual-weighted residual).
//!
//! Let r be the residual of the enriched equations at the prolonged state P u of the run, and z, μ the adjoint solution of the quantity
//! ([`crate::solve::adjoints`]) at the mean of P u and the enriched solution u⁺. Then
//!
//! ```text
//! J⁺ − J = Σ_i (φ − P I φ)_i r_i + remainder,   φ = −z at free dofs, the weight of the reaction at prescribed ones,
//! ```
//!
//! where I takes the values at the nodes of the run. By Galerkin orthogonality P I φ is orthogonal to r, except for other quadrature points and another
//! formulation, whose contribution stays with the nodes of the run. The share of a node is spread over the cells around it by their volume, a partition of
//! unity (Richter & Wick, *J. Comput. Appl. Math.* 279 (2015) 192–208), and from a cell to the cell of the run of which it is a part. The tangent at the mean
//! state leaves an error of third order in u⁺ − P u ([`CellErrors::remainder`], which also contains the changes due to the guides of cables, whose weights
//! depend on the mesh, and to other quadrature points).
//!
//! Source: Becker & Rannacher, *Acta Numerica* 10 (2001) 1–102, Sections 2 and 3.

use super::EstimateError;
use super::enrichment::EnrichedScene;
use super::kept_state::Solved;
use crate::scene::{Recorder, Scene};
use crate::solve::{Integrator, Step, adjoints};
use crate::system::{Dofs, Gradient, State, Want};

/// Shares of the cells of a run in the change J⁺ − J of one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct CellErrors {
    /// Recorded column
    pub column: String,
    /// Signed shares \[cells of the run\] \[unit of J\]
    pub signed: Vec<f64>,
    /// Shares of the magnitudes at the nodes, which do not cancel: the gain that refinement can achieve \[cells of the run\] \[unit of J\]
    pub size: Vec<f64>,
    /// J⁺ − J minus the sum of the signed shares \[unit of J\]
    pub remainder: f64,
}

/// The shares of the cells for columns, each given by its index among all, its name, and J of the run.
pub(super) fn localise(
    enriched: &EnrichedScene,
    solved: &Solved,
    columns: &[(usize, &str, f64)],
) -> Result<Vec<CellErrors>, EstimateError> {
    let scene = &enriched.scene;
    let (past, next) = (&solved.start, &solved.end);
    let mut middle = past.clone();
    let mean = |to: &mut [f64], from: &[f64]| to.iter_mut().zip(from).for_each(|(a, b)| *a = 0.5 * (*a + b));
    mean(&mut middle.x, &next.x);
    mean(&mut middle.lambda, &next.lambda);
    let step = Step { system: &scene.system, integrator: Integrator::Static, past, dt: 1.0 };
    let failed = |why: crate::solve::Failure| EstimateError::NoAdjoint { t: past.t, why: why.to_string() };
    let mut left = scene.system.workspace();
    let evaluated = scene.system.assemble(&step.at(past), &past.lambda, Want::Residual, None, &mut left);
    evaluated.map_err(|why| failed(crate::solve::Failure::Eval(why)))?;
    let all = gradients(scene, &middle, &solved.memory);
    let own = |(column, name, _): &(usize, &str, f64)| {
        all[*column].clone().ok_or_else(|| EstimateError::NoDerivative { column: (*name).into(), t: past.t })
    };
    let wanted: Vec<Gradient> = columns.iter().map(own).collect::<Result<_, _>>()?;
    let dual = adjoints(scene.method(), &step, &middle, &wanted).map_err(failed)?;
    let is_fixed = |dof: usize| scene.system.dofs.equation[dof] == Dofs::FIXED;
    let free: Vec<f64> = left.r.iter().enumerate().map(|(dof, r)| if is_fixed(dof) { 0.0 } else { *r }).collect();
    let spread = Spread::new(enriched);
    let shares = |((&(column, name, value), gradient), adjoint): ((&(usize, &str, f64), &Gradient), _)| {
        let adjoint: &crate::solve::Adjoint = adjoint;
        let mut phi: Vec<f64> = adjoint.z.iter().map(|z| -z).collect();
        let held = gradient.reaction.iter().filter(|(dof, _)| is_fixed(*dof as usize));
        held.for_each(|(dof, weight)| phi[*dof as usize] += weight);
        let mut share: Vec<f64> = phi.iter().zip(&free).map(|(phi, r)| phi * r).collect();
        enriched.for_each_weight(|at, of_run, weight| {
            let part = weight * phi[of_run] * free[at];
            share[at] -= part;
            share[of_run] += if is_fixed(of_run) { 0.0 } else { part };
        });
        let (signed, size) = spread.over_cells(&share);
        let change = solved.values[column] - value;
        CellErrors { column: name.into(), remainder: change - signed.iter().sum::<f64>(), signed, size }
    };
    Ok(columns.iter().zip(&wanted).zip(&dual).map(shares).collect())
}

/// Gradients of all recorded columns at a state; `None` for columns that have none there.
pub(super) fn gradients(scene: &Scene, state: &State, memory: &[f64]) -> Vec<Option<Gradient>> {
    let of = |(r, memory): (&dyn Recorder, &[f64])| {
        let mut own = r.gradients(&scene.body, state, memory);
        own.resize(r.columns().len(), None);
        own
    };
    // The first column is the time.
    std::iter::once(None).chain(scene.with_memories(memory).flat_map(of)).collect()
}

/// Map from shares of the enriched unknowns to shares of the cells of the run.
struct Spread<'a> {
    enriched: &'a EnrichedScene,
    /// Volume of the cells around each node \[nodes of the enriched mesh\] \[m³\]
    around: Vec<f64>,
    /// Volumes \[cells of the enriched mesh\] \[m³\]
    volumes: Vec<f64>,
}

impl<'a> Spread<'a> {
    fn new(enriched: &'a EnrichedScene) -> Self {
        let mesh = &enriched.scene.body.mesh;
        let volumes: Vec<f64> = (0..mesh.cell_count()).map(|c| mesh.cell_volume(c)).collect();
        let mut around = vec![0.0; mesh.points.len()];
        for (c, volume) in volumes.iter().enumerate() {
            mesh.cell(c).iter().for_each(|&node| around[node as usize] += volume);
        }
        Self { enriched, around, volumes }
    }

    /// Signed shares and magnitudes \[cells of the run\] from shares of the unknowns; unknowns that belong to no node of the mesh are left out.
    fn over_cells(&self, of_unknowns: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (mesh, parents) = (&self.enriched.scene.body.mesh, self.enriched.parents());
        let nodes = mesh.points.len();
        let mut of_nodes: Vec<f64> = of_unknowns[..3 * nodes].chunks_exact(3).map(|own| own.iter().sum()).collect();
        let mut sizes: Vec<f64> = of_nodes.iter().map(|share: &f64| share.abs()).collect();
        let first = 3 * self.enriched.scene.points.len();
        for (host, share) in self.enriched.pressure_nodes().zip(&of_unknowns[first..]) {
            of_nodes[host as usize] += share;
            sizes[host as usize] += share.abs();
        }
        let cells = 1 + parents.iter().copied().max().unwrap_or(0) as usize;
        let (mut signed, mut size) = (vec![0.0; cells], vec![0.0; cells]);
        for (c, volume) in self.volumes.iter().enumerate() {
            for &node in mesh.cell(c) {
                let part = volume / self.around[node as usize];
                signed[parents[c] as usize] += part * of_nodes[node as usize];
                size[parents[c] as usize] += part * sizes[node as usize];
            }
        }
        (signed, size)
    }
}
