//! Constraints of a scene. Each kind has one file or folder, a line in each of the three lists below, and its place in `build_constraints`.

mod cable;
mod cavity;
mod cavity_rim;
mod cavity_wall;
mod cell_groups;
mod fixed;
mod part;
mod prescribed;
mod rigid;

pub use crate::scene::build::drive::Drive;
pub use cable::{
    CableDriveSpec, CableEvent, CableSpec, Condition, GuideFile, GuidesSpec, NamedCable, PullPointSpec, RingSpec,
};
pub(in crate::scene) use cable::{CableLog, note_places, pulling};
pub(in crate::scene) use cavity::note_vacuum;
pub use cavity::{CavityDriveSpec, CavitySpec, NamedCavity};
pub use fixed::FixedSpec;
pub use prescribed::PrescribedSpec;
pub use rigid::RigidInsertSpec;
pub(in crate::scene) use rigid::check_tied;

use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::Headline;
use crate::scene::text::kind::registry;
use cable::{build_cables, check_shortening};
use cavity::build_cavity;
use cell_groups::cell_groups;
use part::{ConstraintPart, Motion, Moved};

registry! {
ConstraintPart;
/// One constraint of a scene.
pub enum ConstraintSpec {
    Fixed(FixedSpec) = "fixed",
    Prescribed(PrescribedSpec) = "prescribed",
    Cable(CableSpec) = "cable",
    Cavity(CavitySpec) = "cavity",
    Rigid(RigidInsertSpec) = "rigid",
}
}

impl ConstraintSpec {
    /// The quantity by which runs are compared, if the constraint has one.
    pub(in crate::scene) fn headline(&self) -> Option<Headline> {
        self.part().headline()
    }

    /// A name for the constraint if it is enforced exactly, so that an undamped integrator rings.
    pub(in crate::scene) fn exact(&self) -> Option<&'static str> {
        self.part().exact()
    }

    /// Whether the constraint has friction, so that its forces depend on the path.
    pub(in crate::scene) fn has_friction(&self) -> bool {
        self.part().has_friction()
    }

    /// The region whose displacements the constraint prescribes, and the prescribed components.
    pub(in crate::scene) fn held(&self) -> Option<(&str, &str)> {
        let Moved { region, components, motion } = self.part().moves(0)?;
        (!matches!(motion, Motion::Rigid(_))).then_some((region, components))
    }
}

/// Groups the cells of a scene by the cause of their deformation.
pub(in crate::scene) fn group_cells(builder: &mut Builder, specs: &[ConstraintSpec]) {
    let moved = specs.iter().enumerate().filter_map(|(number, spec)| spec.part().moves(number));
    builder.gathered.cell_groups = cell_groups(&builder.body.mesh, &builder.regions, moved);
}

/// Builds all constraints of a scene; returns the cables and cavities among them. `carriers` is the number of bodies and obstacles whose four nodes each
/// precede those of rigid parts.
pub(in crate::scene) fn build_constraints(
    builder: &mut Builder,
    specs: &[ConstraintSpec],
    carriers: usize,
) -> Result<(Vec<NamedCable>, Vec<NamedCavity>), SceneError> {
    let (mut cables, mut places) = (Vec::<NamedCable>::new(), Vec::new());
    for (k, constraint) in specs.iter().enumerate() {
        let place = format!("constraint {} ({})", k + 1, constraint.kind());
        match constraint {
            ConstraintSpec::Fixed(fixed) => fixed.build(builder, &place)?,
            ConstraintSpec::Prescribed(prescribed) => prescribed.build(builder, &place)?,
            ConstraintSpec::Cable(cable) => {
                let built = build_cables(builder, &place, cable, &cables)?;
                cables.extend(built);
                places.resize(cables.len(), place);
            }
            // Built below, because the held dofs decide whether a cavity may be open
            ConstraintSpec::Cavity(_) | ConstraintSpec::Rigid(_) => {}
        }
    }
    let mut first = (builder.body.mesh.points.len() + 4 * carriers) as u32;
    let mut names = Vec::new();
    for (k, constraint) in specs.iter().enumerate() {
        if let ConstraintSpec::Rigid(rigid) = constraint {
            let place = format!("constraint {} (rigid)", k + 1);
            if names.contains(&&rigid.name) {
                let fact = format!("another rigid part is called \"{}\" too", rigid.name);
                return Err(builder.content(&place, fact, "give each a `name` of its own"));
            }
            names.push(&rigid.name);
            rigid.build(builder, &place, first)?;
            first += 4;
        }
    }
    for (cable, place) in cables.iter().zip(&places) {
        check_shortening(builder, place, cable)?;
    }
    let mut cavities = Vec::<NamedCavity>::new();
    for (k, constraint) in specs.iter().enumerate() {
        if let ConstraintSpec::Cavity(cavity) = constraint {
            let (place, name) = (format!("constraint {} (cavity)", k + 1), &cavity.name);
            if cavities.iter().any(|c| c.name == *name) || cables.iter().any(|c| c.name == *name) {
                let fact = format!("another cable or cavity is called \"{name}\" too");
                return Err(builder.content(&place, fact, "give each a `name` of its own"));
            }
            let built = build_cavity(builder, &place, cavity, &cavities)?;
            cavities.push(built);
        }
    }
    note_law(builder, &cables, &cavities);
    Ok((cables, cavities))
}

/// Adds a note on a law whose stress does not rotate with the body under forces that do: the tangent then has the stiffness of the forces, but lacks that of
/// the stress with which they are in balance.
fn note_law(builder: &mut Builder, cables: &[NamedCable], cavities: &[NamedCavity]) {
    let law =
        builder.gathered.laws.iter().find(|l| !l.law.info().objective).map(|l| (l.name.clone(), l.law.info().name));
    let force = cables.first().map(|c| &c.name).into_iter().chain(cavities.first().map(|c| &c.name)).next();
    if let (Some((law, kind)), Some(force)) = (law, force) {
        builder.notes.push(format!(
            "{law} is {kind}, and the force of {force} turns with the body: deflections are wrong by about the load over the buckling load of the body, also \
             at small rotations; corotational has the stiffness that is missing"
        ));
    }
}

/// Adds notes on the constraints of a scene; returns a reason why the solution has no limit as h → 0, if there is one.
pub(in crate::scene) fn note_constraints(builder: &mut Builder, specs: &[ConstraintSpec]) -> Option<String> {
    specs.iter().fold(None, |why, spec| spec.part().note(builder).or(why))
}
