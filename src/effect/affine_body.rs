//! A free rigid body as an affine one that is very stiff (Lan et al., Affine body dynamics, ACM TOG 41, 2022, §3): four nodes
//! p_a carry it by x = Σ_a w_a(X) p_a, and only changes of length are resisted.
//!
//! ```text
//! M_ab = ∫ ρ w_a w_b dV        Ψ = K ‖E‖², E = ½(AᵀA − I), A = ∂x/∂X        ∂Ψ/∂A = 2 K A E
//! ```
//!
//! M is constant and exact: momentum and moment of momentum are those of the rigid body, and there is no rotation to update. K \[J\]
//! is numerics: under a pressure p on its faces the body of volume V strains by about p V/2K.
//! Limits: no large deformation is meant; a step turns the body by less than a radian or so.

use super::contact::placement::AffineFrame;
use crate::math::tensor::{Mat3, Vec3};
use crate::system::{
    At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Needs, PastDerivative, Perturbation, Want,
};

/// Mass and its second moments.
pub struct AffineInertia {
    name: String,
    blocks: Blocks,
    /// M_ab \[kg\]
    mass: [[f64; 4]; 4],
}

impl AffineInertia {
    /// Of a body with its centre of mass at C, and the inertia tensor I \[kg m²\] about it.
    pub fn new(name: String, frame: &AffineFrame, mass: f64, inertia: &Mat3) -> Self {
        // J = ∫ ρ (X − C)(X − C)ᵀ dV, I = tr J − J
        let second = (Mat3::identity() * (0.5 * inertia.trace()) - inertia) / frame.length.powi(2);
        let mut m = [[0.0; 4]; 4];
        m[0][0] = mass + second.sum();
        for i in 0..3 {
            (m[0][i + 1], m[i + 1][0]) = (-second.row(i).sum(), -second.row(i).sum());
            (0..3).for_each(|j| m[i + 1][j + 1] = second[(i, j)]);
        }
        Self { name, blocks: Blocks::new(std::iter::once(&frame.nodes[..])), mass: m }
    }

    /// r += c M y, K += rate M; returns ½ y·My.
    fn apply(&self, y: &[f64], c: f64, rate: f64, want: Want, out: &mut BlockValues) -> f64 {
        let y: Vec<f64> = self.blocks.dofs(0).map(|dof| y[dof as usize]).collect();
        let mut energy = 0.0;
        for (a, row) in self.mass.iter().enumerate() {
            for (b, m) in row.iter().enumerate() {
                for i in 0..3 {
                    out.r[3 * a + i] += c * m * y[3 * b + i];
                    energy += 0.5 * m * y[3 * a + i] * y[3 * b + i];
                    if want == Want::Tangent && b <= a {
                        out.k[(3 * a + i) * 12 + 3 * b + i] += rate * m;
                    }
                }
            }
        }
        energy
    }
}

impl Effect for AffineInertia {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Kinetic
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, _: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        out.energy = self.apply(at.v, 0.0, 0.0, Want::Energy, out);
        self.apply(at.a, 1.0, at.rates.ca, want, out);
        Ok(())
    }

    fn capabilities(&self) -> Capabilities<'_> {
        Capabilities {
            needs: Needs { velocity: true, acceleration: true },
            past: Some(self),
            ..Capabilities::default()
        }
    }
}

impl PastDerivative for AffineInertia {
    fn along(&self, _: &At, direction: &Perturbation, _: usize, out: &mut BlockValues) -> Result<(), EvalError> {
        self.apply(direction.a, 1.0, 0.0, Want::Residual, out);
        Ok(())
    }
}

/// Stiffness against changes of length.
pub struct Rigidity {
    name: String,
    frame: AffineFrame,
    blocks: Blocks,
    /// K \[J\]
    stiffness: f64,
}

impl Rigidity {
    pub fn new(name: String, frame: AffineFrame, stiffness: f64) -> Self {
        let blocks = Blocks::new(std::iter::once(&frame.nodes[..]));
        Self { name, frame, blocks, stiffness }
    }
}

impl Effect for Rigidity {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Stored
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, _: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let a = self.frame.gradient(&self.frame.positions(at.x));
        let e = 0.5 * (a.tr_mul(&a) - Mat3::identity());
        out.energy = self.stiffness * e.norm_squared();
        let p = a * e * (2.0 * self.stiffness);
        let gradients: [Vec3; 4] =
            [0, 1, 2, 3].map(|k| if k == 0 { Vec3::repeat(-1.0) } else { Vec3::ith(k - 1, 1.0) } / self.frame.length);
        for (k, g) in gradients.iter().enumerate() {
            out.r[3 * k..3 * k + 3].copy_from_slice((p * g).as_slice());
        }
        if want < Want::Tangent {
            return Ok(());
        }
        for (l, g) in gradients.iter().enumerate() {
            for j in 0..3 {
                let change = Vec3::ith(j, 1.0) * g.transpose();
                let strain = a.tr_mul(&change);
                let dp = (change * e + a * (strain + strain.transpose()) * 0.5) * (2.0 * self.stiffness);
                for (k, h) in gradients.iter().enumerate().skip(l) {
                    let column = dp * h;
                    (0..3).for_each(|i| out.k[(3 * k + i) * 12 + 3 * l + j] = column[i]);
                }
            }
        }
        Ok(())
    }
}
