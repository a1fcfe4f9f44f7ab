//! Search for motions without resistance, and their description in words.
//!
//! The rigid motions of a part are searched for first ([`super::rigid_motions`]). A motion of a mechanism, which is not rigid, is found by inverse
//! iteration on K + s diag K (Parlett, The Symmetric Eigenvalue Problem, 1998, ch. 4).
//!
//! Limits: a motion of several parts together that leaves a constraint unchanged is only found as a mechanism. K is that of the given state; at rest
//! it is zero on every rigid motion, while under a load it may resist, as for a pendulum.

use super::rigid_motions::{NONE, ROUNDING, RigidPartMotions, null_space, parts, right_vectors};
use crate::math::linear::LinearError;
use crate::math::tensor::Vec3;
use crate::math::vector::{dot, norm};
use crate::solve::Step;
use crate::solve::nonlinear_solver::NonlinearSolver;
use crate::system::{Assembled, Dofs, State, System, Want};
use nalgebra::{DMatrix, DVector};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotionKind {
    Translation,
    Rotation,
    /// A motion that is not rigid
    Mechanism,
}

/// A motion without resistance.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    pub kind: MotionKind,
    /// Unit vector: direction, axis of the rotation, or motion of the node
    pub direction: [f64; 3],
    /// The node that moves most
    pub node: u32,
    /// Whether the whole body moves, not only a part of it
    pub whole: bool,
}

/// Finds motions without stiffness at this state of a static step; rigid ones are found if `points` \[nodes\] is not empty.
pub fn free_motions(solver: &mut NonlinearSolver, step: &Step, state: &State, points: &[Vec3]) -> Vec<Motion> {
    if solver.equations.evaluate(step, &mut state.clone(), Want::Tangent, None).is_err() {
        return Vec::new();
    }
    let mut motions = Vec::new();
    let parts = if points.is_empty() { Vec::new() } else { parts(step.system, points.len()) };
    for nodes in &parts {
        let part = RigidPartMotions::new(nodes, points, &state.x);
        motions = free(&part, step.system, &solver.equations.sums, parts.len() == 1);
        if !motions.is_empty() {
            break;
        }
    }
    if motions.is_empty() {
        motions.extend(mechanism(solver, step.system));
    }
    motions
}

/// Finds a mechanism by inverse iteration with s at the rounding level of K: the Rayleigh quotient of a free motion is at most of the size of s,
/// while that of a slender body is still a thousand times larger.
fn mechanism(solver: &mut NonlinearSolver, system: &System) -> Option<Motion> {
    let NonlinearSolver { equations, linear, .. } = solver;
    linear.fit(system, &equations.sums);
    let (pattern, k) = (&equations.sums.pattern, &equations.sums.k);
    let mut diagonal = pattern.diagonal(k);
    let largest = diagonal.iter().fold(0.0, |m: f64, d| m.max(d.abs()));
    // A direction without any stiffness would have no weight, and would not be found
    diagonal.iter_mut().for_each(|d| *d = d.abs().max(ROUNDING * largest));
    let mut shifted = k.clone();
    for j in 0..pattern.n {
        shifted[pattern.on_diagonal(j)] += ROUNDING * diagonal[j];
    }
    let mut mode: Vec<f64> = (1..=pattern.n).map(|i| (i as f64 * 0.618_033_988_75).fract()).collect();
    let factorised = linear.factor.factorise(&shifted);
    if factorised.as_ref().is_err_and(|why| *why != LinearError::Singular) {
        return None;
    }
    if factorised.is_ok() {
        for _ in 0..3 {
            let size = norm(&mode);
            mode.iter_mut().zip(&diagonal).for_each(|(x, d)| *x *= d / size);
            if linear.factor.solve(&shifted, &mut mode).is_err() {
                break;
            }
        }
        let mut force = vec![0.0; pattern.n];
        pattern.multiply(k, &mode, &mut force);
        let yardstick: f64 = mode.iter().zip(&diagonal).map(|(x, d)| d * x * x).sum();
        if dot(&mode, &force).abs() > ROUNDING * yardstick {
            return None;
        }
    }
    let moving = |e: &usize| !system.dofs.is_scalar(*e);
    let most = (0..pattern.n).filter(moving).max_by(|a, b| mode[*a].abs().total_cmp(&mode[*b].abs()))?;
    let node = system.dofs.free[most] / 3;
    let component = |i: u32| match system.dofs.equation[(3 * node + i) as usize] {
        Dofs::FIXED => 0.0,
        e => mode[e as usize],
    };
    let direction = unit([0, 1, 2].map(component).into())?;
    Some(Motion { kind: MotionKind::Mechanism, direction: direction.into(), node, whole: false })
}

/// Whether a load pushes in a direction e of translation without resistance, so that no equilibrium exists: Σ r·e over the free dofs, compared with
/// the scale of the forces.
pub(in crate::solve) fn pushes(solver: &mut NonlinearSolver, step: &Step, state: &State, motions: &[Motion]) -> bool {
    const BALANCED: f64 = 1e-6;
    if solver.equations.evaluate(step, &mut state.clone(), Want::Residual, None).is_err() {
        return false;
    }
    let along = |m: &Motion| {
        let dofs = step.system.dofs.free.iter().filter(|dof| **dof < step.system.dofs.displacements);
        dofs.map(|&dof| solver.equations.sums.r[dof as usize] * m.direction[dof as usize % 3]).sum::<f64>()
    };
    let translations = motions.iter().filter(|m| m.kind == MotionKind::Translation && m.whole);
    translations.into_iter().any(|m| along(m).abs() > BALANCED * solver.equations.sums.scale)
}

/// The free motions of a part, by kind.
fn free(part: &RigidPartMotions, system: &System, sums: &Assembled, whole: bool) -> Vec<Motion> {
    let basis = part.unresisted(system, sums, 0.0);
    let turns = basis.rows(3, 3).into_owned();
    let mut motions = Vec::new();
    // Combinations without rotation are translations; the axes of the others are the range of Ω
    let still = null_space(&turns, NONE);
    for direction in directions(&(&basis * &still).rows(0, 3).into_owned()) {
        motions.push(Motion { kind: MotionKind::Translation, direction: direction.into(), node: part.nodes[0], whole });
    }
    for axis in directions(&turns) {
        let weights = turns.clone().svd(true, true).solve(&DVector::from_column_slice(axis.as_slice()), NONE);
        let c = &basis * weights.expect("both factors were asked for");
        let size = |i: &usize| part.motion(*i, &c).norm();
        let most = (0..part.nodes.len()).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or(0);
        motions.push(Motion { kind: MotionKind::Rotation, direction: axis.into(), node: part.nodes[most], whole });
    }
    motions
}

/// Unit vectors that span the same space as the columns \[3 × m\], coordinate axes first.
fn directions(columns: &DMatrix<f64>) -> Vec<Vec3> {
    let (mut rest, mut found) = (range(columns), Vec::new());
    for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
        if (rest.transpose() * axis).norm() >= 1.0 - NONE {
            found.push(axis);
            let axis = DMatrix::from_column_slice(3, 1, axis.as_slice());
            rest = range(&(&rest - &axis * (axis.transpose() * &rest)));
        }
    }
    // Of the two signs, the one with a positive largest component
    let sign = |v: Vec3| v * v[v.iamax()].signum();
    found.extend(rest.column_iter().map(|c| sign(Vec3::new(c[0], c[1], c[2]))));
    found
}

/// Orthonormal basis of the range of the columns \[3 × rank\], which are of size 1 or zero.
fn range(columns: &DMatrix<f64>) -> DMatrix<f64> {
    right_vectors(&columns.transpose(), |s| s > NONE)
}

fn unit(v: Vec3) -> Option<Vec3> {
    v.try_normalize(f64::MIN_POSITIVE)
}

/// A sentence such as `nothing holds the body: it can translate in x and y and rotate about z`.
pub(in crate::solve) fn sentence(motions: &[Motion]) -> String {
    let first = &motions[0];
    if first.kind == MotionKind::Mechanism {
        let along = name(&first.direction);
        return format!(
            "node {} can move along {along} without resistance: the parts around it form a mechanism",
            first.node
        );
    }
    let of = |kind: MotionKind| {
        let names: Vec<String> =
            motions.iter().filter(|m| m.kind == kind && m.whole == first.whole).map(|m| name(&m.direction)).collect();
        match names.split_last() {
            None => String::new(),
            Some((last, [])) => last.clone(),
            Some((last, others)) => format!("{} and {last}", others.join(", ")),
        }
    };
    let (shifts, turns) = (of(MotionKind::Translation), of(MotionKind::Rotation));
    let mut can = Vec::new();
    if !shifts.is_empty() {
        can.push(format!("translate in {shifts}"));
    }
    if !turns.is_empty() {
        can.push(format!("rotate about {turns}"));
    }
    let what = if first.whole { "the body".into() } else { format!("the part at node {}", first.node) };
    format!("nothing holds {what}: it can {}", can.join(" and "))
}

/// The name of a direction, `x`, or `(0.71, 0.71, 0.00)`.
fn name(direction: &[f64; 3]) -> String {
    let axis = (0..3).find(|&i| direction[i].abs() >= 1.0 - NONE);
    match axis {
        Some(i) => ["x", "y", "z"][i].into(),
        None => {
            // Adding zero removes the sign of a negative zero
            let [x, y, z] = direction.map(|v| (100.0 * v).round() / 100.0 + 0.0);
            format!("({x:.2}, {y:.2}, {z:.2})")
        }
    }
}
