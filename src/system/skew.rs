//! The skew part A of the tangent, which few effects have, and only on few unknowns.

use super::{Assembled, At, BlockValues, Dofs, System};

/// Sums A at this state; its product with a prescribed `increment` is added to the forces of the increment.
pub(super) fn add(system: &System, at: &At, increment: Option<&[f64]>, out: &mut Assembled) {
    each_entry(system, at, |i, j, a| {
        let equation = |dof: u32| system.dofs.equation[dof as usize];
        match (equation(i), equation(j)) {
            (Dofs::FIXED, Dofs::FIXED) => {}
            (Dofs::FIXED, to) => out.increment_force[to as usize] -= increment.map_or(0.0, |d| a * d[i as usize]),
            (to, Dofs::FIXED) => out.increment_force[to as usize] += increment.map_or(0.0, |d| a * d[j as usize]),
            (i, j) => out.skew.entries.push((i, j, a)),
        }
    });
}

/// Calls `each` with (i, j, A_ij) for every block in order; i and j are indices in `State::x`, and A_ji = −A_ij is implied.
pub(super) fn each_entry(system: &System, at: &At, mut each: impl FnMut(u32, u32, f64)) {
    for skew in system.effects.iter().filter_map(|e| e.capabilities().skew) {
        let mut values = BlockValues::new(skew.blocks().largest());
        for b in 0..skew.blocks().len() {
            let dofs: Vec<u32> = skew.blocks().dofs(b).collect();
            values.k.fill(0.0);
            skew.eval(at, b, &mut values);
            for (i, j) in (0..dofs.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let a = values.k[i * dofs.len() + j];
                if a != 0.0 {
                    each(dofs[i], dofs[j], a);
                }
            }
        }
    }
}
