//! Change of the reactions at the prescribed dofs.

use super::contribution::Contribution;
use super::{At, BlockValues, Dofs, EvalError, System, Want, skew};

/// Adds (K + A) dx + Σ h dλ at the prescribed dofs, for each (dx, dλ), to its `r` \[unknowns\]: the change of the reactions.
/// Only blocks with a prescribed dof are evaluated.
pub fn add_reactions(
    system: &System,
    at: &At,
    lambda: &[f64],
    changes: &[(&[f64], &[f64])],
    r: &mut [Vec<f64>],
) -> Result<(), EvalError> {
    for e in 0..system.effects.len() {
        let changes: Vec<_> = changes.iter().map(|&(dx, _)| (dx, 0.0)).collect();
        add(system, &system.effect(e), &system.inputs_of(e, at), &changes, r)?;
    }
    skew::each_entry(system, at, |i, j, a| {
        for (&(dx, _), r) in changes.iter().zip(&mut *r) {
            for (to, value) in [(i, a * dx[j as usize]), (j, -a * dx[i as usize])] {
                r[to as usize] += if is_fixed(system, to) { value } else { 0.0 };
            }
        }
    });
    for (c, &lambda) in lambda.iter().enumerate() {
        let changes: Vec<_> = changes.iter().map(|&(dx, dlambda)| (dx, dlambda[c])).collect();
        add(system, &system.constraint(c, lambda), at, &changes, r)?;
    }
    Ok(())
}

fn is_fixed(system: &System, dof: u32) -> bool {
    system.dofs.equation[dof as usize] == Dofs::FIXED
}

/// Of one contribution, for each (dx, dλ) with its own multiplier.
fn add(
    system: &System,
    of: &Contribution,
    at: &At,
    changes: &[(&[f64], f64)],
    r: &mut [Vec<f64>],
) -> Result<(), EvalError> {
    let fixed = |dof: u32| is_fixed(system, dof);
    let (blocks, weight) = (of.kernel.blocks(), of.weight.unwrap_or(0.0));
    let mut values = BlockValues::new(system.largest());
    let Some(means) = of.means() else {
        for b in (0..blocks.len()).filter(|&b| blocks.dofs(b).any(fixed)) {
            let dofs: Vec<u32> = blocks.dofs(b).collect();
            values.reset(dofs.len(), Want::Tangent);
            of.kernel.eval(at, b, Want::Tangent, &mut values)?;
            for (&(dx, dlambda), r) in changes.iter().zip(&mut *r) {
                values.add_product(&dofs, fixed, weight, dx, r);
                let entries = dofs.iter().zip(&values.r).filter(|(dof, _)| fixed(**dof));
                entries.for_each(|(&dof, h)| r[dof as usize] += h * dlambda);
            }
        }
        return Ok(());
    };
    if !means.nodes().any(|node| (3 * node..3 * node + 3).any(fixed)) {
        return Ok(());
    }
    let (w, changes_w): (Vec<f64>, Vec<_>) = (means.of(at.x), changes.iter().map(|(dx, _)| means.of(dx)).collect());
    let mut forces = vec![vec![0.0; w.len()]; changes.len()];
    for b in 0..blocks.len() {
        let dofs: Vec<u32> = blocks.dofs(b).collect();
        values.reset(dofs.len(), Want::Tangent);
        of.kernel.eval(&At { x: &w, ..*at }, b, Want::Tangent, &mut values)?;
        for ((dw, force), (_, dlambda)) in changes_w.iter().zip(&mut forces).zip(changes) {
            values.add_product(&dofs, |_| true, weight, dw, force);
            dofs.iter().zip(&values.r).for_each(|(&dof, h)| force[dof as usize] += h * dlambda);
        }
    }
    for (force, r) in forces.iter().zip(r) {
        means.spread(force, |dof, force| r[dof as usize] += if fixed(dof) { force } else { 0.0 });
    }
    Ok(())
}
