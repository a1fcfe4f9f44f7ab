//! Families of fibres spread over cells: Π = Σ_f ∫ ψ_f(F, a_f) dV, in addition to the elastic effect of the material between them.
//!
//! The direction a_f at rest is given at each quadrature point, so that it can follow a curved body. Formulae: [`FibreFamily`].

use super::cell::CellPoints;
use super::stress::PointStress;
use crate::material::fibre_family::FibreFamily;
use crate::material::{LawError, Response};
use crate::math::tensor::{Mat3, Vec3};
use crate::mesh::TetMesh;
use crate::system::{At, BlockValues, Blocks, Effect, EnergyRole, EvalError, Want};
use std::sync::Arc;

/// Families of fibres with the same constants on the cells of a region.
pub struct FibreFamilies {
    name: String,
    points: Arc<CellPoints>,
    constants: FibreFamily,
    /// \[cells × points\] unit vectors at rest, one for each family
    directions: Vec<Vec<Vec3>>,
}

impl FibreFamilies {
    /// Builds families on cells; `directions` returns the unit vectors of the families at a position X \[m\].
    pub fn new(
        name: String,
        mesh: &TetMesh,
        cells: &[u32],
        constants: FibreFamily,
        directions: impl Fn(Vec3) -> Vec<Vec3>,
    ) -> Self {
        let points = Arc::new(CellPoints::new(mesh, cells));
        let places = cells.iter().flat_map(|&c| points.reference().iter().map(move |&xi| (c, xi)));
        let directions = places.map(|(c, xi)| directions(mesh.position(c as usize, xi))).collect();
        Self { name, points, constants, directions }
    }

    /// Stretches of all families at all points at displacement x.
    pub fn stretches<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let all = self.points.deformation(x, 0..self.points.cells.len()).flat_map(|(_, points)| points);
        all.zip(&self.directions).flat_map(|((_, f), directions)| directions.iter().map(move |a| (f * a).norm()))
    }

    /// Sum of the responses of the families at point `q` of block `b`.
    fn response(&self, f: &Mat3, b: usize, q: usize, want: Want) -> Result<Response, LawError> {
        let mut sum = Response::energy(0.0);
        for a in &self.directions[b * self.points.points() + q] {
            let one = self.constants.eval(a, f, want)?;
            sum.psi += one.psi;
            sum.p += one.p;
            sum.a.as_flattened_mut().iter_mut().zip(one.a.as_flattened()).for_each(|(to, from)| *to += from);
        }
        Ok(sum)
    }
}

impl Effect for FibreFamilies {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Stored
    }

    fn blocks(&self) -> &Blocks {
        &self.points.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        for q in 0..self.points.points() {
            let f = self.points.deformation_gradient(at.x, b, q);
            let fail = |e| EvalError::of_law(&self.name, self.points.cells[b] as usize, e);
            let response = self.response(&f, b, q, want).map_err(fail)?;
            out.energy += self.points.weight(b, q) * response.psi;
            if want > Want::Energy {
                self.points.scatter(b, q, self.points.blocks.size(b), &response.p, &response.a, want, out);
            }
        }
        Ok(())
    }
}

impl PointStress for FibreFamilies {
    fn points(&self) -> &Arc<CellPoints> {
        &self.points
    }

    fn stress(&self, x: &[f64], b: usize) -> Result<Vec<Mat3>, LawError> {
        let at = |q| Ok(self.response(&self.points.deformation_gradient(x, b, q), b, q, Want::Residual)?.p);
        (0..self.points.points()).map(at).collect()
    }
}
