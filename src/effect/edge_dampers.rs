//! Dampers on the edges of a mesh, the damping part of a mass–spring–damper body: r_j = c l̇ τ with l̇ = (l − lₙ)/Δt,
//! K = (c/Δt)(ττᵀ + (1 − lₙ/l)(I − ττᵀ)).
//!
//! Objective, with an exact symmetric tangent (it derives from the incremental potential ½ c Δt l̇²); first-order accurate in Δt with every
//! integrator, as is viscous damping. The usual l̇ = τ·(v_j − v_i) has an unsymmetric tangent. At the start of a stage, when no time has passed, that
//! rate is used: there x = xₙ, and τ and l belong to xₙ.

use super::damping_work::work;
use super::edges::{Edges, add_force, longer};
use crate::mesh::TetMesh;
use crate::system::{
    At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Needs, PastDerivative, Perturbation, Want,
};

/// A linear damper on each edge.
pub struct EdgeDampers {
    edges: Edges,
    /// \[N s/m\]
    c: f64,
}

impl EdgeDampers {
    /// Puts dampers with the constant c \[N s/m\] on all edges of some cells.
    pub fn new(mesh: &TetMesh, cells: &[u32], c: f64) -> Self {
        Self { edges: Edges::of_cells(mesh, cells).0, c }
    }
}

impl Effect for EdgeDampers {
    fn name(&self) -> &str {
        "edge_dampers"
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Dissipative
    }

    fn blocks(&self) -> &Blocks {
        &self.edges.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        if at.is_static() {
            return Ok(());
        }
        let (rest, before) = (self.edges.rest(b), self.edges.stretching(at.old, b));
        if at.is_start() {
            let (_, tau) = self.edges.direction(self.name(), b, rest + before)?;
            let n = self.c * tau.dot(&self.edges.stretching(at.v, b));
            add_force(tau, n, 0.0, 0.0, Want::Residual, out);
            return Ok(());
        }
        let now = self.edges.stretching(at.x, b);
        let (l, tau) = self.edges.direction(self.name(), b, rest + now)?;
        let slope = self.c / at.dt;
        let n = slope * longer(rest + before, now - before);
        add_force(tau, n, slope, n / l, want, out);
        out.energy = work(&self.edges.blocks, at, b, out);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            needs: Needs { velocity: true, acceleration: false },
            past: Some(self),
            ..Capabilities::default()
        }
    }
}

impl PastDerivative for EdgeDampers {
    /// Adds the change of the force by −(c/Δt) dlₙ, dlₙ = τₙ·(duₙ_j − duₙ_i); at the start of a stage n τ with n = c τ·(v_j − v_i) changes by dn τ +
    /// n dτ.
    fn along(&self, at: &At, direction: &Perturbation, b: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        if at.is_static() {
            return Ok(());
        }
        let rest = self.edges.rest(b);
        let toward = |x: &[f64]| self.edges.direction(self.name(), b, rest + self.edges.stretching(x, b));
        let ((_, tau), (l, before)) = (toward(at.x)?, toward(at.old)?);
        let moved = self.edges.stretching(direction.old, b);
        let longer = before.dot(&moved);
        if at.is_start() {
            let (rate, change) = (self.edges.stretching(at.v, b), self.edges.stretching(direction.v, b));
            let turn = (moved - before * longer) / l;
            add_force(before, self.c * (turn.dot(&rate) + before.dot(&change)), 0.0, 0.0, Want::Residual, out);
            add_force(turn, self.c * before.dot(&rate), 0.0, 0.0, Want::Residual, out);
            return Ok(());
        }
        add_force(tau, -self.c / at.dt * longer, 0.0, 0.0, Want::Residual, out);
        Ok(())
    }
}
