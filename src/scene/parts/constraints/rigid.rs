//! Constraint `rigid`: cells of a region that move as one rigid part of the body.

use super::part::{ConstraintPart, Motion, Moved};
use crate::effect::affine_body::Rigidity;
use crate::effect::contact::placement::AffineFrame;
use crate::effect::rigid_insert::Rigid;
use crate::math::tensor::Vec3;
use crate::mesh::Region;
use crate::mesh::error::point;
use crate::scene::body::Body;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::frame_motion;
use crate::scene::record::recorder::{Moment, Recorder};
use crate::system::State;
use schemars::JsonSchema;
use serde::Deserialize;

/// A region of cells that moves as a rigid body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigidInsertSpec {
    /// Prefix of the columns; `rigid` if absent
    #[serde(default = "insert")]
    pub name: String,
    /// Region of cells, which need no elastic effect
    pub region: String,
}

fn insert() -> String {
    "insert".into()
}

impl ConstraintPart for RigidInsertSpec {
    fn exact(&self) -> Option<&'static str> {
        Some("a rigid part")
    }

    fn moves(&self, number: usize) -> Option<Moved<'_>> {
        Some(Moved { region: &self.region, components: "xyz", motion: Motion::Rigid(number) })
    }
}

impl RigidInsertSpec {
    /// Ties the nodes of the region to the four nodes that start at `first`.
    pub(super) fn build(&self, builder: &mut Builder, place: &str, first: u32) -> Result<(), SceneError> {
        builder.check_name(place, &self.name)?;
        let body = builder.body.clone();
        let (mesh, cells) = (&body.mesh, builder.cells(place, &self.region)?.to_vec());
        if cells.len() == mesh.cell_count() {
            let fact = format!("region \"{}\" is the whole body", self.region);
            return Err(builder.content(place, fact, "take some of the cells; a rigid body of its own is a [[rigid]]"));
        }
        let (mut volume, mut center) = (0.0, Vec3::zeros());
        for &c in &cells {
            let own = mesh.cell_volume(c as usize);
            volume += own;
            center += mesh.position(c as usize, [0.25; 3]) * own;
        }
        let nodes = [0, 1, 2, 3].map(|k| first + k);
        let frame = AffineFrame { nodes, center: center / volume, length: volume.cbrt() };
        let inside = Region { cells: cells.clone(), ..Region::default() };
        let mut faults = Vec::new();
        for node in mesh.nodes_of(&inside) {
            let at = mesh.points[node as usize];
            if (0..3).any(|i| builder.motion(3 * node + i).is_some()) {
                faults.push(format!("the node at {} is prescribed", point(&at)));
            }
            let weights = frame.nodes.into_iter().zip(frame.weights(&at)).collect();
            if builder.tied.insert(node, weights).is_some() {
                faults.push(format!("the node at {} belongs to another rigid part", point(&at)));
            }
        }
        if !faults.is_empty() {
            let more = if faults.len() > 3 { ", …" } else { "" };
            let fact = format!(
                "{} of its nodes are held otherwise: {}{more}",
                faults.len(),
                faults[..faults.len().min(3)].join(", ")
            );
            let remedy = "leave a layer of cells between the two, or prescribe the whole part (kind = \"prescribed\") without `rigid`";
            return Err(builder.content(place, fact, remedy));
        }
        builder.rigid_cells.extend(&cells);
        let modulus = builder.gathered.laws.iter().map(|law| law.law.small_strain().e).fold(0.0, f64::max);
        let stiffness = Rigidity::tied(format!("{}_rigidity", self.name), frame.clone(), modulus * volume);
        builder.effects.push(Box::new(stiffness));
        builder.constraints.extend(Rigid::all(&self.name, &frame));
        builder.gathered.recorders.push(Box::new(Recorded { name: self.name.clone(), frame: frame.clone() }));
        builder.frames.push(frame);
        Ok(())
    }
}

/// The motion of a rigid part, as columns.
struct Recorded {
    name: String,
    frame: AffineFrame,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        frame_motion::columns(&self.name)
    }

    fn memory(&self) -> Vec<f64> {
        frame_motion::memory()
    }

    fn remember(&self, _: &Body, state: &State, memory: &mut [f64]) {
        frame_motion::remember(&self.frame, state, memory);
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        frame_motion::record(&self.frame, now)
    }
}

/// Refuses features that cannot follow the nodes of rigid parts: initial states, and effects that select their blocks.
pub(in crate::scene) fn check_tied(builder: &Builder, has_start: bool) -> Result<(), SceneError> {
    if builder.tied.is_empty() {
        return Ok(());
    }
    if has_start {
        let fact = "it moves nodes of a rigid part one by one";
        return Err(builder.content("start", fact, "start at rest, or without the constraint `rigid`"));
    }
    for effect in &builder.effects {
        let c = effect.capabilities();
        let selects = c.active.is_some() || c.skew.is_some() || c.step_limit.is_some() || c.contact_points.is_some();
        let blocks = effect.blocks();
        let is_tied = || (0..blocks.len()).any(|b| blocks.nodes(b).iter().any(|node| builder.tied.contains_key(node)));
        let may_be_tied = c.transient.is_some_and(|coupling| builder.tied.keys().any(|&node| coupling.may_have(node)));
        if may_be_tied || selects && is_tied() {
            let fact = format!(
                "contact, or a pressure with a free rim, acts on the nodes of a rigid part ({})",
                effect.name()
            );
            return Err(builder.content("constraint (rigid)", fact, "let its region end before the rigid part"));
        }
    }
    Ok(())
}
