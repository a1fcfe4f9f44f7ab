//! What is recorded of a contact: force on its points, least distance, points that are pressed and their area.

use super::contact_spec::ResponseSpec;
use crate::effect::contact::friction::ContactFriction;
use crate::effect::contact::placement::AffineFrame;
use crate::effect::contact::{Contact, Pressing};
use crate::math::tensor::Vec3;
use crate::system::{At, Effect, Local, Want};
use std::sync::Arc;

/// A contact of the system, for what is recorded.
pub struct NamedContact {
    pub name: String,
    pub response: ResponseSpec,
    pub(super) pressing: Arc<dyn Pressing>,
    pub(super) moves: bool,
    pub(super) friction: Option<Arc<ContactFriction>>,
}

/// What a contact is at one state.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactMoment {
    /// On the points [N]
    pub force: Vec3,
    /// Least distance [m]
    pub gap: f64,
    /// Points that are pressed
    pub pressed: usize,
    /// Their area [m²]
    pub area: f64,
}

impl NamedContact {
    /// Names of its columns.
    pub fn columns(&self) -> Vec<String> {
        let ends = ["force_x_N", "force_y_N", "force_z_N", "gap_m", "points", "area_m2"];
        let normal: &[&str] = if self.slides() { &["normal_x_N", "normal_y_N", "normal_z_N"] } else { &[] };
        ends.iter().chain(normal).map(|end| format!("{}_{end}", self.name)).collect()
    }

    /// The four nodes of an obstacle with a motion.
    pub(super) fn moving(&self) -> Option<&AffineFrame> {
        self.contact().obstacle.body.as_ref().filter(|_| self.moves)
    }

    /// Has it friction?
    pub fn slides(&self) -> bool {
        self.friction.is_some()
    }

    pub fn contact(&self) -> &Contact {
        self.pressing.contact()
    }

    /// Sums over the points; friction is there where a step led to the state.
    pub fn moment(&self, x: &[f64], step: Option<&At>) -> ContactMoment {
        let contact = self.contact();
        let forces = self.forces(x, step);
        let reach = self.pressing.reach();
        let least = 1e-9 * forces.iter().map(|f| f.1.norm()).fold(0.0, f64::max);
        let pressed = forces.iter().filter(|f| f.1.norm() > least);
        // An empty sum is −0.
        let area = pressed.clone().map(|f| contact.points[f.0].area).sum::<f64>() + 0.0;
        let gap = contact.deepest(x).map_or(reach, |d| d.1);
        ContactMoment { force: forces.iter().map(|f| f.1).sum(), gap, pressed: pressed.count(), area }
    }

    /// (point, force [N]) of the points that feel the obstacle.
    pub fn forces(&self, x: &[f64], step: Option<&At>) -> Vec<(usize, Vec3)> {
        let contact = self.contact();
        let mut local = Local::new(contact.blocks().largest());
        let mut force = |b: usize| {
            let presses = self.pressing.presses(x, b);
            let mut sum: Vec3 = presses.iter().map(|p| p.normal * p.force).sum();
            if let (Some(friction), Some(at)) = (&self.friction, step) {
                local.r.fill(0.0);
                friction.eval(at, b, Want::Residual, &mut local).expect("friction is defined wherever contact is");
                sum -= local.r[..3 * contact.own()].chunks_exact(3).map(Vec3::from_column_slice).sum::<Vec3>();
            }
            (b, sum)
        };
        let near: Vec<u32> = match self.pressing.reach() {
            f64::INFINITY => (0..contact.points.len() as u32).collect(),
            reach => contact.near(x, reach),
        };
        near.into_iter().map(|b| force(b as usize)).filter(|(_, f)| *f != Vec3::zeros()).collect()
    }

    /// Values of its columns; with friction, the resultant without it too.
    pub fn record(&self, x: &[f64], step: Option<&At>) -> Vec<f64> {
        let ContactMoment { force, gap, pressed, area } = self.moment(x, step);
        let mut values = vec![force.x, force.y, force.z, gap, pressed as f64, area];
        if self.slides() {
            let normal: Vec3 = self.forces(x, None).iter().map(|f| f.1).sum();
            values.extend(normal.iter());
        }
        values
    }

    /// [3 × nodes] forces at the nodes [N].
    pub fn nodal(&self, x: &[f64], step: Option<&At>, nodes: &mut [f64]) {
        for (b, force) in self.forces(x, step) {
            let p = &self.contact().points[b];
            for (&node, w) in p.nodes.iter().zip(&p.weights) {
                // Nodes of a rigid body are not in the mesh.
                let of_mesh = nodes.get_mut(3 * node as usize..3 * node as usize + 3).into_iter().flatten();
                of_mesh.zip(force.iter()).for_each(|(sum, f)| *sum += w * f);
            }
        }
    }
}
