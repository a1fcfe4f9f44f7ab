//! Distances of other meshes and of the models from a finer mesh, at the same states.

use crate::reduction::{ReducedModel, Twin};
use crate::study::kinds::reduction::prepared::{Prepared, converged};
use crate::study::kinds::reduction::record::{Comparison, MeshesRecord, ReductionMeshRecord, ReductionRecord};
use crate::study::kinds::reduction::runs::at_points;
use crate::study::store::record::{Role, StoredCase};
use crate::study::store::results::Results;

/// Compares meshes and models; `None` unless the study has a reference and all its runs have results.
pub fn compare(
    results: &Results,
    record: &ReductionRecord,
    (prepared, models): (&Prepared, &[ReducedModel]),
) -> Option<Comparison> {
    let of = record.meshes.as_ref()?;
    let reference = *converged(results, Role::Reference)?.first()?;
    let own = converged(results, Role::HeldBack)?.into_iter().find(|c| c.record.member == of.member)?;
    let columns = |case: &StoredCase| changes(case, of, &prepared.names);
    let target = columns(reference)?;
    let states = record.held_back.get(&of.member)?;
    let mut meshes = vec![mesh("the mesh of the models", (own, states.len()), &columns(own)?, &target)];
    for case in converged(results, Role::Sizes)? {
        meshes.push(mesh(&case.record.member, (case, of.points), &columns(case)?, &target));
    }
    let points: Vec<Vec<f64>> = states.iter().take(of.points).map(|point| prepared.inputs(point)).collect();
    Some(Comparison {
        points: points.len(),
        reference_cells: reference.record.mesh.cells,
        reference_step_s: step(reference, of.points),
        sizes: target.iter().map(|of| of.iter().fold(0.0, |most: f64, v| most.max(v.abs()))).collect(),
        meshes,
        models: models.iter().map(|model| along(model, &points).map(|all| distances(&all, &target))).collect(),
    })
}

/// Changes of a case from its first row, at rest \[quantities × points\].
fn changes(case: &StoredCase, of: &MeshesRecord, names: &[String]) -> Option<Vec<Vec<f64>>> {
    let at = at_points(&case.series.t_s);
    let change = |name: &String| {
        let column = case.series.columns.get(name)?;
        let rows = at.get(..=of.points)?.iter().map(|&row| column.get(row).copied()).collect::<Option<Vec<f64>>>()?;
        Some(rows.get(1..)?.iter().map(|value| value - rows[0]).collect())
    };
    names.iter().map(change).collect()
}

/// Changes of a model from rest at the same points \[quantities × points\].
fn along(model: &ReducedModel, points: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let mut twin = Twin::new(model.clone()).ok()?;
    let mut out = vec![vec![]; model.quantities.len()];
    for point in points {
        twin.step(point).ok()?;
        let changes = twin.values().iter().zip(&model.rest).map(|(value, rest)| value - rest);
        out.iter_mut().zip(changes).for_each(|(out, change)| out.push(change));
    }
    Some(out)
}

fn mesh(
    name: &str,
    (case, states): (&StoredCase, usize),
    values: &[Vec<f64>],
    target: &[Vec<f64>],
) -> ReductionMeshRecord {
    let cells = case.record.mesh.cells;
    ReductionMeshRecord { name: name.into(), cells, step_s: step(case, states), errors: distances(values, target) }
}

/// Returns the CPU time from one of `states` states of a case to the next \[s\]; parts of cut steps are not counted separately.
pub fn step(case: &StoredCase, states: usize) -> f64 {
    case.record.cpu_s / states.max(1) as f64
}

/// The largest distance in each quantity.
fn distances(values: &[Vec<f64>], target: &[Vec<f64>]) -> Vec<f64> {
    let largest = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    values.iter().zip(target).map(largest).collect()
}
