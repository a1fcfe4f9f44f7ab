//! Products of the tangent with a change of the state: the change of the reactions at the prescribed dofs, and the change of the equations due to
//! prescribed motions.

use super::contribution::Contribution;
use super::{At, BlockValues, Dofs, EvalError, System, Want, skew};

/// Rows of a product that are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WantedRows {
    /// Rows of the prescribed dofs, which give the change of the reactions
    Prescribed,
    /// Rows of the free dofs; the change is then one of prescribed dofs
    Free,
}

/// Adds (K + A) dx + Σ h dλ, for each (dx, dλ), to the wanted rows of its `r` \[unknowns\]. Only blocks with a prescribed dof are evaluated.
pub fn add_products(
    system: &System,
    at: &At,
    lambda: &[f64],
    rows: WantedRows,
    changes: &[(&[f64], &[f64])],
    r: &mut [Vec<f64>],
) -> Result<(), EvalError> {
    for e in 0..system.effects.len() {
        let changes: Vec<_> = changes.iter().map(|&(dx, _)| (dx, 0.0)).collect();
        add(system, &system.effect(e), &system.inputs_of(e, at), rows, &changes, r)?;
    }
    skew::each_entry(system, at, |i, j, a| {
        for (&(dx, _), r) in changes.iter().zip(&mut *r) {
            for (to, value) in [(i, a * dx[j as usize]), (j, -a * dx[i as usize])] {
                r[to as usize] += if rows.have(system, to) { value } else { 0.0 };
            }
        }
    });
    for (c, &lambda) in lambda.iter().enumerate() {
        let changes: Vec<_> = changes.iter().map(|&(dx, dlambda)| (dx, dlambda[c])).collect();
        add(system, &system.constraint(c, lambda), at, rows, &changes, r)?;
    }
    Ok(())
}

/// Sets the rows of free dofs to zero, since they hold no reaction.
pub fn keep_prescribed(system: &System, r: &mut [f64]) {
    let all = r.iter_mut().enumerate().filter(|(dof, _)| !is_fixed(system, *dof as u32));
    all.for_each(|(_, value)| *value = 0.0);
}

/// Returns Σ h·dx of every constraint, for each dx.
pub fn constraint_changes(system: &System, at: &At, changes: &[&[f64]]) -> Result<Vec<Vec<f64>>, EvalError> {
    let mut out = vec![vec![0.0; system.constraints.len()]; changes.len()];
    let mut values = BlockValues::new(system.largest());
    for c in 0..system.constraints.len() {
        let of = system.constraint(c, 1.0);
        let x = of.positions(at.x);
        let along: Vec<_> = changes.iter().map(|dx| of.positions(dx)).collect();
        let blocks = of.kernel.blocks();
        for b in 0..blocks.len() {
            values.reset(blocks.size(b), Want::Residual);
            of.kernel.eval(&At { x: &x, ..*at }, b, Want::Residual, &mut values)?;
            for (out, dx) in out.iter_mut().zip(&along) {
                out[c] += blocks.dofs(b).zip(&values.r).map(|(dof, h)| h * dx[dof as usize]).sum::<f64>();
            }
        }
    }
    Ok(out)
}

fn is_fixed(system: &System, dof: u32) -> bool {
    system.dofs.equation[dof as usize] == Dofs::FIXED
}

impl WantedRows {
    fn have(self, system: &System, dof: u32) -> bool {
        is_fixed(system, dof) == (self == Self::Prescribed)
    }
}

/// Adds the products of one contribution, for each (dx, dλ) with its own multiplier.
fn add(
    system: &System,
    of: &Contribution,
    at: &At,
    rows: WantedRows,
    changes: &[(&[f64], f64)],
    r: &mut [Vec<f64>],
) -> Result<(), EvalError> {
    let (fixed, wanted) = (|dof: u32| is_fixed(system, dof), |dof: u32| rows.have(system, dof));
    let (blocks, weight) = (of.kernel.blocks(), of.weight.unwrap_or(0.0));
    let mut values = BlockValues::new(system.largest());
    let Some(means) = of.means() else {
        for b in (0..blocks.len()).filter(|&b| blocks.dofs(b).any(fixed)) {
            let dofs: Vec<u32> = blocks.dofs(b).collect();
            values.reset(dofs.len(), Want::Tangent);
            of.kernel.eval(at, b, Want::Tangent, &mut values)?;
            for (&(dx, dlambda), r) in changes.iter().zip(&mut *r) {
                values.add_product(&dofs, wanted, weight, dx, r);
                let entries = dofs.iter().zip(&values.r).filter(|(dof, _)| wanted(**dof));
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
        means.spread(force, |dof, force| r[dof as usize] += if wanted(dof) { force } else { 0.0 });
    }
    Ok(())
}
