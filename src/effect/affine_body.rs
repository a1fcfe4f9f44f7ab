//! A free rigid body modelled as a very stiff affine body (Lan et al., Affine body dynamics, ACM TOG 41, 2022, §3): its motion x = Σ_a w_a(X) p_a is
//! that of four nodes p_a, and a stiff energy resists strain.
//!
//! ```text
//! M_ab = ∫ ρ w_a w_b dV        Ψ = K ‖E‖², E = ½(AᵀA − I), A = ∂x/∂X        ∂Ψ/∂A = 2 K A E
//! ```
//!
//! M is constant and exact: momentum and angular momentum are those of the rigid body, and there is no rotation to update. K \[J\] is a numerical
//! parameter: under a pressure p on its faces, a body of volume V strains by about p V/2K. A Newton direction that rotates the body by θ would
//! stretch it by θ²/2, which K resists; increments are therefore applied as rotations ([`TurningBody`]).
//!
//! Limits: large deformation is not intended, and a step rotates the body by less than about a radian. A step to det A ≤ 0 is refused, because the
//! mirror image of the body also has zero strain.

use super::contact::placement::{AffineFrame, displacement};
use crate::math::tensor::{Mat3, Vec3};
use crate::system::{
    At, BlockValues, Blocks, Capabilities, Effect, EnergyRole, EvalError, Needs, PastDerivative, Perturbation, Strain,
    TurningBody, Want,
};

/// ‖dA‖² below which the strain due to a rotation is rounding \[–\].
const ROUNDING: f64 = 1e-14;

/// Inertia of an affine body: mass and second moments.
pub struct AffineInertia {
    name: String,
    blocks: Blocks,
    /// M_ab \[kg\]
    mass: [[f64; 4]; 4],
}

impl AffineInertia {
    /// The inertia of a body with its centre of mass at C and the inertia tensor I \[kg m²\] about C.
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

    /// Adds r += c M y and K += rate M; returns ½ y·My.
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

/// Stiffness of an affine body against strain.
pub struct Rigidity {
    name: String,
    frame: AffineFrame,
    blocks: Blocks,
    /// K \[J\]
    stiffness: f64,
    /// Whether increments are applied as rotations
    turns: bool,
}

impl Rigidity {
    /// The stiffness of a free body, moved by its four nodes alone: increments are applied as rotations.
    pub fn free(name: String, frame: AffineFrame, stiffness: f64) -> Self {
        Self { turns: true, ..Self::tied(name, frame, stiffness) }
    }

    /// The stiffness of a part to which nodes of a mesh are tied. Increments are linear, so that the tied nodes follow them.
    pub fn tied(name: String, frame: AffineFrame, stiffness: f64) -> Self {
        let blocks = Blocks::new(std::iter::once(&frame.nodes[..]));
        Self { name, frame, blocks, stiffness, turns: false }
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
        let a = self.frame.gradient_of(at.x);
        let j = a.determinant();
        if j <= 0.0 {
            return Err(EvalError::InsideOut { effect: self.name.clone(), j });
        }
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

    fn capabilities(&self) -> Capabilities<'_> {
        let turning: Option<&dyn TurningBody> = if self.turns { Some(self) } else { None };
        Capabilities { turning, ..Capabilities::default() }
    }
}

impl TurningBody for Rigidity {
    /// Changes the increment such that A' = R U, with R the rotation of A + dA (polar decomposition) and U² = I + 2E'.
    fn turn(&self, x: &[f64], dx: &mut [f64], strain: Strain) {
        let a = self.frame.gradient_of(x);
        let moved = self.frame.nodes.map(|node| displacement(dx, node));
        let change = self.frame.gradient(&moved);
        if change.norm_squared() < ROUNDING {
            return;
        }
        let linear = a.tr_mul(&change);
        let mut stretch = a.tr_mul(&a);
        if strain == Strain::Linear {
            stretch += linear + linear.transpose();
        }
        let eigen = stretch.symmetric_eigen();
        let svd = (a + change).svd(true, true);
        let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return };
        let rotation = u * v;
        if eigen.eigenvalues.min() <= 0.0 || rotation.determinant() <= 0.0 {
            return;
        }
        let root = Mat3::from_diagonal(&eigen.eigenvalues.map(f64::sqrt));
        let turned = rotation * eigen.eigenvectors * root * eigen.eigenvectors.transpose();
        for i in 0..3 {
            let arm: Vec3 = (turned - a).column(i) * self.frame.length;
            let to = moved[0] + arm;
            dx[3 * self.frame.nodes[i + 1] as usize..][..3].copy_from_slice(to.as_slice());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::system::State;
    use nalgebra::Rotation3;

    /// A body of 20 mm at A = R (I + E), and its displacements.
    fn body(turn: &Vec3, strain: f64) -> (Rigidity, Vec<f64>) {
        let frame = AffineFrame { nodes: [1, 2, 3, 4], center: Vec3::new(0.05, 0.01, -0.04), length: 0.02 };
        let rotation = Rotation3::new(*turn);
        let a =
            rotation.matrix() * (Mat3::identity() + Mat3::new(1.0, 0.5, 0.0, 0.5, -2.0, 0.3, 0.0, 0.3, 1.0) * strain);
        let mut x = vec![0.0; 15];
        for (i, rest) in frame.rest().iter().enumerate() {
            let to = frame.center + Vec3::new(3e-3, -1e-3, 2e-3) + a * (rest - frame.center);
            x[3 * (i + 1)..][..3].copy_from_slice((to - rest).as_slice());
        }
        (Rigidity::free("body".into(), frame, 1.0), x)
    }

    fn strain(body: &Rigidity, x: &[f64]) -> Mat3 {
        let a = body.frame.gradient(&body.frame.positions(x));
        0.5 * (a.tr_mul(&a) - Mat3::identity())
    }

    /// dx = ω × (p − p_0) + v + stretch on the four nodes
    fn motion(body: &Rigidity, x: &[f64], omega: &Vec3, stretch: f64) -> Vec<f64> {
        let positions = body.frame.positions(x);
        let mut dx = vec![0.0; 15];
        for (i, p) in positions.iter().enumerate() {
            let arm = p - positions[0];
            let d = Vec3::new(1e-3, 2e-3, 0.0) + omega.cross(&arm) + Vec3::new(arm.x, 0.5 * arm.y, arm.x) * stretch;
            dx[3 * (i + 1)..][..3].copy_from_slice(d.as_slice());
        }
        dx
    }

    fn moved(x: &[f64], dx: &[f64]) -> Vec<f64> {
        x.iter().zip(dx).map(|(x, d)| x + d).collect()
    }

    /// As a linear motion, a rotation by θ = 0.3 stretches by θ²/2 = 0.045; applied as a rotation, it has the intended strain, to rounding.
    #[test]
    fn a_turn_does_not_stretch() {
        let (body, x) = body(&Vec3::new(0.4, -1.1, 0.7), 1e-3);
        let omega = Vec3::new(0.1, 0.2, -0.2);
        let linear = motion(&body, &x, &omega, 2e-4);
        let before = strain(&body, &x);
        assert!((strain(&body, &moved(&x, &linear)) - before).norm() > 0.03);
        let mut kept = linear.clone();
        body.turn(&x, &mut kept, Strain::Kept);
        assert!((strain(&body, &moved(&x, &kept)) - before).norm() < 1e-14);
        let mut turned = linear.clone();
        body.turn(&x, &mut turned, Strain::Linear);
        let h = 1e-7;
        let small: Vec<f64> = linear.iter().map(|d| h * d).collect();
        let expected = before + (strain(&body, &moved(&x, &small)) - before) / h;
        // Forward difference: h times the second derivative, about 1.
        assert!((strain(&body, &moved(&x, &turned)) - expected).norm() < 1e-6);
        assert_eq!(turned[3..6], linear[3..6], "the centre moves as before");
        assert_eq!(turned[..3], [0.0; 3], "other nodes are not changed");
    }

    /// The mirror image of a body has no strain but is not a rigid motion of it.
    #[test]
    fn a_mirror_image_is_refused() {
        let (body, x) = body(&Vec3::new(0.4, -1.1, 0.7), 0.0);
        let mut mirrored = x.clone();
        let positions = body.frame.positions(&x);
        (0..3).for_each(|i| mirrored[3 * 4 + i] -= 2.0 * (positions[3] - positions[0])[i]);
        assert!(strain(&body, &mirrored).norm() < 1e-14);
        let eval = |x: &[f64]| {
            let still = State::rest(5, 0);
            body.eval(&At { x, ..still.at() }, 0, Want::Residual, &mut BlockValues::new(12))
        };
        assert!(eval(&x).is_ok());
        let Err(EvalError::InsideOut { j, .. }) = eval(&mirrored) else { panic!("it is accepted") };
        assert!((j + 1.0).abs() < 1e-14, "{j}");
    }

    /// The change is of second order, and zero below rounding.
    #[test]
    fn a_small_motion_stays_as_it_is() {
        let (body, x) = body(&Vec3::new(0.4, -1.1, 0.7), 1e-3);
        let change = |size: f64| {
            let linear = motion(&body, &x, &(Vec3::new(1.0, 2.0, -2.0) * size), 0.1 * size);
            let mut turned = linear.clone();
            body.turn(&x, &mut turned, Strain::Linear);
            turned.iter().zip(&linear).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
        };
        let ratio = change(2e-3) / change(1e-3);
        assert!((ratio - 4.0).abs() < 0.05, "{ratio}");
        assert_eq!(change(1e-9), 0.0);
    }
}
