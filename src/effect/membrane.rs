//! Membrane: a thin sheet in plane stress that follows facets of the body.
//!
//! ```text
//! F = f₁⊗E₁ + f₂⊗E₂ + g⊗E₃    f_α = E_α + Σ_a u_a ∂N_a/∂s_α    g such that P E₃ = 0        w(f₁, f₂) = min_g ψ(F)
//! Π = t ∫ w dA    r_a = t ∫ P E_α ∂N_a/∂s_α dA    K_ab = t ∫ Â_αβ ∂N_a/∂s_α ∂N_b/∂s_β dA    Â_αβ = A_αβ − A_α3 A₃₃⁻¹ A_3β
//! ```
//!
//! with the tangents E₁, E₂ and the normal E₃ of the facet at rest, coordinates s along the tangents, and A_αβ = ∂(P E_α)/∂f_β. g, the image of the
//! normal, contains the change of thickness; it is found at each point by Newton's method and eliminated by static condensation, which is exact
//! because P E₃ = 0 (Holzapfel, *Nonlinear Solid Mechanics*, 2000, ch. 6; Bonet & Wood, *Nonlinear Continuum Mechanics*, 2008, §8: membranes). Any
//! law can be used; for an isotropic law g is normal to the sheet.
//!
//! Limits: no bending stiffness and no mass, so that a compressed sheet wrinkles at the scale of its facets ([`wrinkling`](super::wrinkling)).

use crate::material::{Law, LawError, Response};
use crate::math::tensor::{Mat3, Vec3, perpendicular};
use crate::mesh::boundary::facet_cells;
use crate::mesh::{Order, TetMesh, element, quadrature};
use crate::system::{At, BlockValues, Blocks, Effect, EnergyRole, EvalError, Want};
use std::sync::Arc;

/// Largest number of Newton iterations for g; three or four are usual.
const MOST_ITERATIONS: usize = 60;
/// Change of g at which the iteration ends: the next change, its square, is below rounding \[–\].
const ENOUGH: f64 = 1e-8;

/// Tangents, normal and weight at a point of a facet at rest.
struct Point {
    /// E₁, E₂, E₃
    frame: [Vec3; 3],
    /// w dA \[m²\]
    area: f64,
    /// ∂N_a/∂s_α of each node \[1/m\]
    gradients: [[f64; 2]; 6],
}

/// Response of the law at a point of the sheet, with the g that balances it.
struct Balanced {
    g: Vec3,
    response: Response,
}

/// Tangents, thickness and stress at a point of the sheet in a given state.
struct StressedPoint {
    /// f₁, f₂
    tangents: [Vec3; 2],
    /// Current thickness \[m\]
    thickness: f64,
    /// Principal Cauchy stresses; one of them is zero, across the sheet \[Pa\]
    stress: Vec3,
}

/// A membrane on facets; each block is a facet.
pub struct Membrane {
    name: String,
    law: Box<dyn Law>,
    /// t \[m\]
    thickness: f64,
    blocks: Blocks,
    /// \[blocks\] cell that the facet bounds, for messages
    cells: Vec<u32>,
    /// \[blocks × points\]
    points: Vec<Point>,
}

/// Extreme values of stretch, thickness and stress over a sheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MembraneExtremes {
    /// Smallest and largest principal stretch in the plane of the sheet
    pub stretch: [f64; 2],
    /// Smallest thickness \[m\]
    pub thickness: f64,
    /// Largest principal Cauchy stress \[Pa\]
    pub stress: f64,
}

impl Membrane {
    /// Builds a membrane on facets, with one point per linear facet and three per quadratic facet, which is exact for the linear stiffness of
    /// straight facets.
    pub fn new(name: String, mesh: &TetMesh, facets: &[u32], law: Box<dyn Law>, thickness: f64) -> Self {
        let rule = quadrature::tri(if mesh.order == Order::Linear { 1 } else { 2 });
        let of_facet = |&f: &u32| {
            let nodes = mesh.facet(f as usize);
            rule.points.iter().zip(&rule.weights).map(move |(&xi, w)| {
                let local = element::facet_gradients(mesh.order, xi);
                let along =
                    |d: usize| -> Vec3 { nodes.iter().zip(&local).map(|(&k, g)| mesh.points[k as usize] * g[d]).sum() };
                let (u, v) = (along(0), along(1));
                let normal = u.cross(&v);
                let e3 = normal.normalize();
                let e1 = perpendicular(&e3);
                let e2 = e3.cross(&e1);
                // ∂s/∂ξ of the tangents, and its inverse
                let jacobian = nalgebra::Matrix2::new(e1.dot(&u), e1.dot(&v), e2.dot(&u), e2.dot(&v));
                let inverse = jacobian.try_inverse().expect("a valid mesh has no flat facet");
                let gradients =
                    local.map(|g| [0, 1].map(|alpha| g[0] * inverse[(0, alpha)] + g[1] * inverse[(1, alpha)]));
                Point { frame: [e1, e2, e3], area: w * normal.norm(), gradients }
            })
        };
        let points = facets.iter().flat_map(of_facet).collect();
        let owners = facet_cells(mesh);
        let cells = facets.iter().map(|&f| owners[f as usize].0).collect();
        let blocks = Blocks::new(facets.iter().map(|&f| mesh.facet(f as usize)));
        Self { name, law, thickness, blocks, cells, points }
    }

    /// Returns ∂/∂θ of the sheet on its blocks, from ∂/∂θ of its law ([`Law::along`]): its residual is ∂r/∂θ at fixed x.
    pub fn along(self: &Arc<Self>, law: Box<dyn Law>) -> Box<dyn Effect> {
        Box::new(MembraneAlong { of: self.clone(), law })
    }

    /// Returns the extremes over the points of the sheet at displacement x; `None` if the stress cannot be balanced by any thickness.
    pub fn extremes(&self, x: &[f64]) -> Option<MembraneExtremes> {
        let mut out =
            MembraneExtremes { stretch: [f64::INFINITY, 0.0], thickness: f64::INFINITY, stress: f64::NEG_INFINITY };
        for b in 0..self.blocks.len() {
            for point in self.of_block(b) {
                let StressedPoint { tangents: [f1, f2], thickness, stress } = self.stressed(x, b, point)?;
                let metric = nalgebra::Matrix2::new(f1.dot(&f1), f1.dot(&f2), f1.dot(&f2), f2.dot(&f2));
                for square in metric.symmetric_eigenvalues().iter() {
                    out.stretch[0] = out.stretch[0].min(square.max(0.0).sqrt());
                    out.stretch[1] = out.stretch[1].max(square.max(0.0).sqrt());
                }
                out.thickness = out.thickness.min(thickness);
                out.stress = out.stress.max(stress.max());
            }
        }
        Some(out)
    }

    /// Number of facets.
    pub(super) fn facets(&self) -> usize {
        self.blocks.len()
    }

    /// Nodes of facet `b`, corners first.
    pub(super) fn facet_nodes(&self, b: usize) -> &[u32] {
        self.blocks.nodes(b)
    }

    /// Area of facet `b` at rest \[m²\].
    pub(super) fn area(&self, b: usize) -> f64 {
        self.of_block(b).iter().map(|point| point.area).sum()
    }

    /// Returns the largest compressive force per length in facet `b` at displacement x \[N/m\], 0 in tension; `None` if the stress cannot be balanced
    /// by any thickness.
    pub(super) fn compression(&self, x: &[f64], b: usize) -> Option<f64> {
        self.of_block(b).iter().try_fold(0.0_f64, |most, point| {
            let StressedPoint { thickness, stress, .. } = self.stressed(x, b, point)?;
            Some(most.max(-stress.min() * thickness))
        })
    }

    /// Tangents, thickness and stress at a point of block `b` at displacement x.
    fn stressed(&self, x: &[f64], b: usize, point: &Point) -> Option<StressedPoint> {
        let h = self.gradients(x, b, point);
        let Balanced { g, response } = self.balance(b, point, h, Want::Residual).ok()?;
        let f = deformation(point, h, &g);
        let tangents @ [f1, f2] = [h[0] + point.frame[0], h[1] + point.frame[1]];
        let thickness = self.thickness * g.dot(&f1.cross(&f2).normalize());
        let cauchy = response.p * f.transpose() / f.determinant();
        let stress = ((cauchy + cauchy.transpose()) * 0.5).symmetric_eigenvalues();
        Some(StressedPoint { tangents, thickness, stress })
    }

    /// Points of block `b`.
    fn of_block(&self, b: usize) -> &[Point] {
        let count = self.points.len() / self.blocks.len();
        &self.points[b * count..][..count]
    }

    /// Returns f_α − E_α.
    fn gradients(&self, x: &[f64], b: usize, point: &Point) -> [Vec3; 2] {
        [0, 1].map(|alpha| {
            let of_node = |(&k, g): (&u32, &[f64; 2])| Vec3::from_column_slice(&x[3 * k as usize..][..3]) * g[alpha];
            self.blocks.nodes(b).iter().zip(&point.gradients).map(of_node).sum()
        })
    }

    /// Returns g with P E₃ = 0, found by Newton's method on ψ, where steps that would increase ψ are halved, and the response there.
    fn balance(&self, b: usize, point: &Point, h: [Vec3; 2], want: Want) -> Result<Balanced, EvalError> {
        let fail = |e: LawError| EvalError::of_law(&self.name, self.cells[b] as usize, e);
        let unbalanced = || EvalError::NoThickness { effect: self.name.clone(), cell: self.cells[b] as usize };
        let at = |g: &Vec3, want| self.law.eval(&deformation(point, h, g), want);
        let e3 = point.frame[2];
        let normal = (h[0] + point.frame[0]).cross(&(h[1] + point.frame[1]));
        // Initial value: the volume is conserved.
        let mut g = normal / normal.norm_squared();
        if !g.iter().all(|x| x.is_finite()) {
            return Err(unbalanced());
        }
        let mut now = at(&g, Want::Tangent).map_err(fail)?;
        for _ in 0..MOST_ITERATIONS {
            let slope = now.p * e3;
            let Some(inverse) = contract(&now, &e3, &e3).try_inverse() else { return Err(unbalanced()) };
            let mut step = -(inverse * slope);
            if slope.dot(&step) > 0.0 {
                step = -step;
            }
            let enough = step.norm() <= ENOUGH * g.norm();
            let size = now.psi.abs().max(self.law.small_strain().mu * f64::EPSILON);
            let mut tried = at(&(g + step), Want::Tangent);
            let mut halvings = 0;
            while !enough && !tried.as_ref().is_ok_and(|r| r.psi <= now.psi + 1e-12 * size) {
                halvings += 1;
                if halvings > 40 {
                    return Err(unbalanced());
                }
                step *= 0.5;
                tried = at(&(g + step), Want::Tangent);
            }
            g += step;
            now = tried.map_err(fail)?;
            if enough {
                let response = if want == Want::Tangent { now } else { at(&g, want).map_err(fail)? };
                return Ok(Balanced { g, response });
            }
        }
        Err(unbalanced())
    }
}

/// Returns F from f_α = E_α + h_α and g.
fn deformation(point: &Point, h: [Vec3; 2], g: &Vec3) -> Mat3 {
    let [e1, e2, e3] = &point.frame;
    Mat3::identity() + h[0] * e1.transpose() + h[1] * e2.transpose() + (g - e3) * e3.transpose()
}

/// Returns ∂(P a)/∂(F b) = Σ A_iJkL a_J b_L.
fn contract(response: &Response, a: &Vec3, b: &Vec3) -> Mat3 {
    Mat3::from_fn(|i, k| {
        let row = |j: usize| (0..3).map(|l| response.a[3 * i + j][3 * k + l] * b[l]).sum::<f64>();
        (0..3).map(|j| a[j] * row(j)).sum()
    })
}

impl Effect for Membrane {
    fn name(&self) -> &str {
        &self.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Stored
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let size = self.blocks.size(b);
        let nodes = size / 3;
        for point in self.of_block(b) {
            let Balanced { response, .. } = self.balance(b, point, self.gradients(at.x, b, point), want)?;
            let volume = point.area * self.thickness;
            out.energy += volume * response.psi;
            if want == Want::Energy {
                continue;
            }
            let [e1, e2, e3] = &point.frame;
            let stress = [response.p * e1, response.p * e2];
            for (a, ga) in point.gradients[..nodes].iter().enumerate() {
                let force = (stress[0] * ga[0] + stress[1] * ga[1]) * volume;
                (0..3).for_each(|i| out.r[3 * a + i] += force[i]);
            }
            if want < Want::Tangent {
                continue;
            }
            let cell = self.cells[b] as usize;
            let inverse = contract(&response, e3, e3)
                .try_inverse()
                .ok_or_else(|| EvalError::NoThickness { effect: self.name.clone(), cell })?;
            let condensed = |a: &Vec3, b: &Vec3| {
                contract(&response, a, b) - contract(&response, a, e3) * inverse * contract(&response, e3, b)
            };
            let tangent = [e1, e2].map(|a| [e1, e2].map(|b| condensed(a, b) * volume));
            for (a, ga) in point.gradients[..nodes].iter().enumerate() {
                for (c, gc) in point.gradients[..=a].iter().enumerate() {
                    let k = (tangent[0][0] * gc[0] + tangent[0][1] * gc[1]) * ga[0]
                        + (tangent[1][0] * gc[0] + tangent[1][1] * gc[1]) * ga[1];
                    for i in 0..3 {
                        (0..3).for_each(|j| out.k[(3 * a + i) * size + 3 * c + j] += k[(i, j)]);
                    }
                }
            }
        }
        Ok(())
    }
}

/// The derivative ∂/∂θ of a sheet: w changes by ∂ψ/∂θ at fixed g, and P E_α by ∂P/∂θ E_α − A_α3 A₃₃⁻¹ ∂P/∂θ E₃.
struct MembraneAlong {
    of: Arc<Membrane>,
    law: Box<dyn Law>,
}

impl Effect for MembraneAlong {
    fn name(&self) -> &str {
        &self.of.name
    }

    fn role(&self) -> EnergyRole {
        EnergyRole::Stored
    }

    fn blocks(&self) -> &Blocks {
        &self.of.blocks
    }

    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let of = &self.of;
        let nodes = of.blocks.nodes(b).len();
        for point in of.of_block(b) {
            let h = of.gradients(at.x, b, point);
            let Balanced { g, response } = of.balance(b, point, h, Want::Tangent)?;
            let fail = |e| EvalError::of_law(&of.name, of.cells[b] as usize, e);
            let change = self.law.eval(&deformation(point, h, &g), Want::Residual).map_err(fail)?;
            let volume = point.area * of.thickness;
            out.energy += volume * change.psi;
            if want == Want::Energy {
                continue;
            }
            let [e1, e2, e3] = &point.frame;
            let cell = of.cells[b] as usize;
            let inverse = contract(&response, e3, e3)
                .try_inverse()
                .ok_or_else(|| EvalError::NoThickness { effect: of.name.clone(), cell })?;
            let moved = inverse * (change.p * e3);
            let stress = [e1, e2].map(|a| change.p * a - contract(&response, a, e3) * moved);
            for (a, ga) in point.gradients[..nodes].iter().enumerate() {
                let force = (stress[0] * ga[0] + stress[1] * ga[1]) * volume;
                (0..3).for_each(|i| out.r[3 * a + i] += force[i]);
            }
        }
        Ok(())
    }
}
