//! The skew part A of the tangent: only effects that declare one have it, and then on few unknowns.

use super::{Assembled, At, BlockValues, Dofs, System};

impl System {
    /// Sums A at this state; what it makes of a prescribed `increment` goes into `lift`.
    pub(super) fn add_skew(&self, at: &At, increment: Option<&[f64]>, out: &mut Assembled) {
        out.skew.entries.clear();
        self.each_skew(at, |i, j, a| {
            let equation = |dof: u32| self.dofs.equation[dof as usize];
            match (equation(i), equation(j)) {
                (Dofs::FIXED, Dofs::FIXED) => {}
                (Dofs::FIXED, to) => out.lift[to as usize] -= increment.map_or(0.0, |d| a * d[i as usize]),
                (to, Dofs::FIXED) => out.lift[to as usize] += increment.map_or(0.0, |d| a * d[j as usize]),
                (i, j) => out.skew.entries.push((i, j, a)),
            }
        });
    }

    /// (i, j, A_ij) of every block in its order, i and j places in `State::x`; A_ji = −A_ij goes without saying.
    pub(super) fn each_skew(&self, at: &At, mut each: impl FnMut(u32, u32, f64)) {
        for skew in self.skewed.iter().filter_map(|&e| self.effects[e].capabilities().skew) {
            let mut local = BlockValues::new(skew.blocks().largest());
            for b in 0..skew.blocks().len() {
                let dofs: Vec<u32> = skew.blocks().dofs(b).collect();
                local.k.fill(0.0);
                skew.eval(at, b, &mut local);
                for (i, j) in (0..dofs.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
                    let a = local.k[i * dofs.len() + j];
                    if a != 0.0 {
                        each(dofs[i], dofs[j], a);
                    }
                }
            }
        }
    }
}
