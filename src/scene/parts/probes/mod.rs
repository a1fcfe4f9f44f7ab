//! Probes: quantities of a run that a scene requests. Each kind has one file, and a line in each of the three lists below.
//!
//! Positions and directions are means over the area of a region, so that they do not depend on the mesh.

mod arc;
mod bending_angle;
mod centre_line;
mod energy;
mod markers;
mod mean;
mod moment;
mod part;
mod pose;
mod position;
mod reaction;
mod stretch;

pub use bending_angle::BendingAngle;
pub use centre_line::CentreLine;
pub use energy::Energy;
pub use markers::Markers;
pub use moment::ReactionMoment;
pub use pose::Pose;
pub use position::Position;
pub use reaction::Reaction;
pub use stretch::Stretch;

use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Headline, Recorder};
use crate::scene::text::kind::registry;
use part::Probe;

registry! {
Probe;
/// One recorded quantity. Cables record tension and length without a probe, and cavities pressure and volume.
pub enum ProbeSpec {
    BendingAngle(BendingAngle) = "bending_angle",
    Position(Position) = "position",
    Pose(Pose) = "pose",
    CentreLine(CentreLine) = "centre_line",
    Markers(Markers) = "markers",
    Reaction(Reaction) = "reaction",
    Moment(ReactionMoment) = "moment",
    Energy(Energy) = "energy",
    Stretch(Stretch) = "stretch",
}
}

impl ProbeSpec {
    /// The regions on which the probe depends.
    pub fn regions(&self) -> Vec<&str> {
        self.part().regions()
    }

    /// The quantity that represents the probe, if it has one.
    pub fn headline(&self) -> Option<Headline> {
        self.part().headline()
    }
}

/// Builds the recorders of all probes of a scene, in the order of the file.
pub(in crate::scene) fn build_probes(
    builder: &mut Builder,
    specs: &[ProbeSpec],
) -> Result<Vec<Box<dyn Recorder>>, SceneError> {
    let mut recorders = vec![];
    for (k, probe) in (1..).zip(specs) {
        let (place, part) = (format!("probe {k}"), probe.part());
        recorders.push(part.build(&place, builder)?);
        let note = part.note(&place, builder);
        builder.notes.extend(note);
    }
    Ok(recorders)
}
