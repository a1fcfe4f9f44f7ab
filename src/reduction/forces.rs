//! Loads and cables of a scene in the coordinates of a reduced model: exact, without a selection of points.

use super::error::ReductionError;
use super::inputs::{Affine, Input};
use super::polynomial::Quadratic;
use super::training::basis::Basis;
use crate::effect::{Cable, Guide, Stressed};
use crate::math::tensor::Vec3;
use crate::math::vector::dot;
use crate::scene::Scene;
use crate::scene::parts::constraints::Drive;
use crate::system::{At, BlockValues, Blocks, ConstraintKind, Effect, EnergyRole, PolynomialLoad, Want};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A load s(u) f(q) with the potential s(u) φ(q).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Name of the effect
    pub name: String,
    pub intensity: Affine,
    /// ∂φ/∂q as a function of the displacement coordinates, per unit of intensity
    pub force: Quadratic,
}

/// A cable without friction, whose guides move by w = W q.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReducedCable {
    pub name: String,
    /// Position of a pull point that is fixed in space \[m\]; `None` if there is none
    pub pull_point: Option<[f64; 3]>,
    /// Positions of the guides at rest \[m\]
    pub guides: Vec<[f64; 3]>,
    /// W, row by row \[3 × guides, coordinates\]
    pub motion: Vec<f64>,
    pub drive: CableDrive,
}

/// Drive of a cable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum CableDrive {
    /// Tension \[N\]
    Tension(Affine),
    /// Free length \[m\], and its increase per unit of tension \[m/N\]
    Length { free: Affine, compliance: f64 },
}

impl ReducedCable {
    /// Builds the geometry of the cable, with the motions of the guides themselves as means.
    pub fn cable(&self) -> Cable {
        let guide = |(k, at): (usize, &[f64; 3])| Guide { point: Vec3::from(*at), weights: vec![(k as u32, 1.0)] };
        let guides = self.guides.iter().enumerate().map(guide).collect();
        Cable::through(self.name.clone(), self.pull_point.map(Vec3::from), guides)
    }

    /// Returns the rows of W for a basis.
    pub fn motion(cable: &Cable, modes: &[Vec<f64>]) -> Vec<f64> {
        let columns: Vec<Vec<f64>> = modes.iter().map(|mode| cable.means().of(mode)).collect();
        let rows = columns.first().map_or(0, Vec::len);
        (0..rows).flat_map(|row| columns.iter().map(move |column| column[row])).collect()
    }
}

pub(super) fn unsupported(what: String, why: &str, remedy: &str) -> ReductionError {
    ReductionError::Unsupported { what, why: why.into(), remedy: remedy.into() }
}

/// Refuses a scene with parts that have no reduced form in statics.
pub fn check(scene: &Scene) -> Result<(), ReductionError> {
    if scene.spans.iter().any(|span| !span.integrator.is_static()) {
        let why = "the states of a model that rests have no rates";
        return Err(unsupported("a dynamic stage".into(), why, "make the stages static, or train on runs in time"));
    }
    check_parts(scene, |effect| effect.role() == EnergyRole::Kinetic)
}

/// Refuses a scene with parts that have no reduced form; `takes` accepts rate-dependent effects that have one or do not act.
pub fn check_parts(scene: &Scene, takes: impl Fn(&dyn Effect) -> bool) -> Result<(), ReductionError> {
    let leave_out = "leave it out, or run the scene in full";
    if let Some(contact) = scene.contacts.first() {
        let why = "its error cannot be stated: the set of points that touch changes with the inputs at once, and with it the adjoint solutions that \
                   error bars are made of";
        return Err(unsupported(format!("contact {}", contact.name), why, leave_out));
    }
    if !scene.rigids.is_empty() || scene.system.ties.nodes().next().is_some() {
        return Err(unsupported("a rigid body".into(), "its motion is not one of the modes", leave_out));
    }
    if scene.system.prescribed.iter().any(|p| !p.signal.is_zero()) {
        return Err(unsupported(
            "a prescribed motion".into(),
            "the modes are at rest where the body is held",
            leave_out,
        ));
    }
    for effect in &scene.system.effects {
        let own = effect.blocks();
        // An elastic effect without a form at points is refused later, with its reason
        let blocks =
            |s: &Arc<dyn Stressed>| s.constitution().map_or(&s.points().blocks as *const _, |c| c.blocks as *const _);
        let is_elastic = scene.stressed.iter().any(|s| std::ptr::eq(blocks(s), own));
        let capabilities = effect.capabilities();
        let is_load =
            effect.role() == EnergyRole::Load && (capabilities.polynomial.is_some() || capabilities.means.is_some());
        if !(is_elastic || is_load || takes(&**effect)) {
            return Err(unsupported(format!("the effect {}", effect.name()), "it has no reduced form", leave_out));
        }
    }
    let cables = scene.cables.iter().filter(|c| c.friction || c.most < f64::INFINITY);
    if let Some(cable) = cables.into_iter().next() {
        let why = "friction and drives that yield are not reduced";
        return Err(unsupported(format!("cable {}", cable.name), why, "leave friction and max_tension out"));
    }
    let driven = scene.system.constraints.iter().find(|c| c.kind() != ConstraintKind::Unilateral);
    match driven {
        Some(c) => Err(unsupported(format!("the constraint {}", c.name()), "it is no cable", "drive it by pressure")),
        None => Ok(()),
    }
}

/// Returns the time at which a scene ends \[s\].
fn end(scene: &Scene) -> f64 {
    scene.spans.last().map_or(0.0, |span| span.end)
}

/// Returns the effects that are loads of a model, in their order.
pub fn effects_of_loads(scene: &Scene) -> impl Iterator<Item = (&dyn Effect, &dyn PolynomialLoad)> {
    scene.system.effects.iter().filter_map(|effect| Some((&**effect, effect.capabilities().polynomial?)))
}

/// Returns the loads of a scene; `steps` are the magnitudes of the displacement coordinates.
pub fn loads(scene: &Scene, basis: &Basis, inputs: &[Input], steps: &[f64]) -> Result<Vec<Load>, ReductionError> {
    let (mut out, end) = (vec![], end(scene));
    for (effect, load) in effects_of_loads(scene) {
        let name = effect.name().to_string();
        let intensity = Affine::identify(&name, inputs, end, |now| effect.intensity(now))?;
        let modes = &basis.modes[..basis.displacements];
        let force = reduced_force((effect.blocks(), load), modes, (modes, steps));
        out.push(Load { name, intensity, force });
    }
    Ok(out)
}

/// Returns the forces of a load per unit of intensity along `tests`, as polynomials of the coordinates of `modes`.
pub fn reduced_force(
    (blocks, load): (&Blocks, &dyn PolynomialLoad),
    tests: &[Vec<f64>],
    (modes, steps): (&[Vec<f64>], &[f64]),
) -> Quadratic {
    let force = |q: &[f64]| {
        let x = super::training::basis::combine(modes, q);
        let mut r = vec![0.0; x.len()];
        for b in 0..blocks.len() {
            let mut values = BlockValues::new(blocks.size(b));
            load.unit_residual(&x, b, &mut values);
            blocks.dofs(b).zip(&values.r).for_each(|(dof, force)| r[dof as usize] += force);
        }
        tests.iter().map(|v| dot(&r, v)).collect()
    };
    Quadratic::identify(load.degree(), steps, force)
}

/// Returns the residual of a single effect \[unknowns\].
pub(super) fn block_forces(effect: &dyn Effect, at: &At) -> Result<Vec<f64>, ReductionError> {
    let blocks = effect.blocks();
    let mut r = vec![0.0; at.x.len()];
    for b in 0..blocks.len() {
        let mut values = BlockValues::new(blocks.size(b));
        effect.eval(at, b, Want::Residual, &mut values).map_err(|e| ReductionError::Law(e.to_string()))?;
        blocks.dofs(b).zip(&values.r).for_each(|(dof, force)| r[dof as usize] += force);
    }
    Ok(r)
}

/// Returns the cables of a scene.
pub fn cables(scene: &Scene, modes: &[Vec<f64>], inputs: &[Input]) -> Result<Vec<ReducedCable>, ReductionError> {
    let (mut out, end) = (vec![], end(scene));
    for named in &scene.cables {
        let (pull_point, guides) = named.cable.path();
        let name = named.name.clone();
        let drive = match &named.drive {
            Drive::Prescribed(signal) => {
                CableDrive::Tension(Affine::identify(&name, inputs, end, |now| signal.at(now))?)
            }
            Drive::Multiplier(c) => {
                let constraint = &scene.system.constraints[*c];
                let free = Affine::identify(&name, inputs, end, |now| constraint.target(now))?;
                CableDrive::Length { free, compliance: constraint.compliance() }
            }
        };
        out.push(ReducedCable {
            name,
            pull_point: pull_point.map(Into::into),
            guides: guides.iter().map(|p| (*p).into()).collect(),
            motion: ReducedCable::motion(&named.cable, modes),
            drive,
        });
    }
    Ok(out)
}
