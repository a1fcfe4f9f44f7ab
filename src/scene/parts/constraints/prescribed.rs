//! Constraint `prescribed`: components of the displacement of a region follow a signal, or the whole region moves by a rotation and a translation.

use super::part::{ConstraintPart, Motion, Moved};
use crate::math::signal::Signal;
use crate::math::units::Dimension;
use crate::scene::build::builder::{Builder, Turned};
use crate::scene::error::SceneError;
use crate::scene::notes::jump::{Impact, note_jump};
use crate::scene::rotation::RotationSpec;
use crate::scene::signal::SignalSpec;
use crate::scene::signal::protocol::extremes;
use schemars::JsonSchema;
use serde::Deserialize;

/// A region with a prescribed motion: a displacement, or a rotation, a translation or both.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrescribedSpec {
    /// Region that is moved
    pub region: String,
    /// Components prescribed: "x", "yz", …; with a rotation all of them if absent
    #[serde(default)]
    pub components: String,
    /// Displacement of each of the components
    pub displacement: Option<SignalSpec>,
    /// A finite rotation: every node is on its circle at all times
    pub rotation: Option<RotationSpec>,
    /// Components of a translation, after the rotation if there is one
    pub translation: Option<[SignalSpec; 3]>,
}

impl PrescribedSpec {
    /// Prescribes the motion of the nodes of the region.
    pub(super) fn build(&self, builder: &mut Builder, place: &str) -> Result<(), SceneError> {
        let Self { region, components, displacement, rotation, translation } = self;
        match (displacement, rotation, translation) {
            (Some(displacement), None, None) => {
                let name = format!("{region}_{components}_displacement_m");
                let signal = builder.signal(place, name.clone(), displacement, Dimension::LENGTH)?;
                note_jump(builder, &name, &signal, Impact::FromPlace);
                builder.prescribe(place, region, components, |_, _| signal.clone())
            }
            (None, None, None) => {
                Err(builder.content(place, "it has no motion", "give `displacement`, `rotation` or `translation`"))
            }
            (None, ..) => self.build_motion(builder, place),
            (Some(_), ..) => {
                let other = if rotation.is_some() { "rotation" } else { "translation" };
                let fact = format!("it has a `displacement` and a `{other}`");
                let remedy = "give the rotation some `components`, and the displacement the others in a constraint of its own; or give both \
                              together as `rotation` and `translation`";
                Err(builder.content(place, fact, remedy))
            }
        }
    }

    /// The components that are prescribed.
    fn components(&self) -> &str {
        if self.components.is_empty() { "xyz" } else { &self.components }
    }

    /// Prescribes a rotation, a translation or both.
    fn build_motion(&self, builder: &mut Builder, place: &str) -> Result<(), SceneError> {
        let region = &self.region;
        let components = self.components();
        let turning = self.rotation.as_ref().map(|r| r.build(builder, place, format!("{region}_rotation_rad")));
        let turning = turning.transpose()?;
        let mut shifts = Vec::new();
        for (signal, letter) in self.translation.iter().flatten().zip(["x", "y", "z"]) {
            let name = format!("{region}_translation_{letter}_m");
            let shift = builder.signal(place, name.clone(), signal, Dimension::LENGTH)?;
            note_jump(builder, &name, &shift, Impact::FromPlace);
            shifts.push(shift);
        }
        builder.prescribe(place, region, components, |at, i| match (&turning, shifts.get(i)) {
            (Some(turning), None) => turning.displacement(at, i),
            (Some(turning), Some(shift)) => Signal::Sum(vec![turning.displacement(at, i), shift.clone()]),
            (None, shift) => shift.cloned().unwrap_or(Signal::Constant(0.0)),
        })?;
        self.check_components(builder, place, &shifts)?;
        if let Some(turning) = turning {
            let nodes = builder.body.mesh.nodes_of(builder.region(place, region)?);
            builder.gathered.turned.push(Turned { place: place.into(), nodes, angle: turning.angle });
        }
        Ok(())
    }

    /// Refuses a motion in a component that `components` leaves out: a component of the translation, or any part of a rotation.
    fn check_components(&self, builder: &Builder, place: &str, shifts: &[Signal]) -> Result<(), SceneError> {
        let components = self.components();
        let is_left_out = |letter: &str, shift: &Signal| !components.contains(letter) && !is_zero(builder, shift);
        let left_out = ["x", "y", "z"].into_iter().zip(shifts).find(|(letter, shift)| is_left_out(letter, shift));
        if let Some((letter, _)) = left_out {
            let fact =
                format!("the translation along {letter} is given, and components = \"{components}\" leaves it free");
            return Err(builder.content(
                place,
                fact,
                format!("write \"0 mm\" for it, or add {letter} to `components`"),
            ));
        }
        let Some(RotationSpec { axis, .. }) = &self.rotation else { return Ok(()) };
        let is_across = |k: usize| (0..3).any(|other| other != k && axis[other] != 0.0);
        if ["x", "y", "z"].into_iter().enumerate().any(|(k, letter)| components.contains(letter) && is_across(k)) {
            return Ok(());
        }
        let fact = format!("a rotation about the {components} axis moves nothing along {components}");
        Err(builder.content(place, fact, "add the components across the axis to `components`, or remove the rotation"))
    }
}

/// Whether a signal is zero at all times.
fn is_zero(builder: &Builder, signal: &Signal) -> bool {
    let ((_, least), (_, most)) = extremes(signal, &builder.spans);
    !signal.has_inputs() && least == 0.0 && most == 0.0
}

impl ConstraintPart for PrescribedSpec {
    fn moves(&self, number: usize) -> Option<Moved<'_>> {
        Some(Moved { region: &self.region, components: self.components(), motion: Motion::Prescribed(number) })
    }

    fn note(&self, builder: &mut Builder) -> Option<String> {
        let (mesh, region) = (&builder.body.mesh, builder.regions.get(&self.region)?);
        let nodes = mesh.nodes_of(region);
        let is_own = |node: &u32| nodes.binary_search(node).is_ok();
        let holds_parts = !region.is_node_set && (!region.facets.is_empty() || !region.cells.is_empty());
        let has_surface = holds_parts || (0..mesh.facet_count()).any(|f| mesh.facet(f)[..3].iter().all(is_own));
        (!has_surface).then(|| {
            format!(
                "the motion of {} is prescribed at single nodes, where the finer the mesh the smaller the force",
                self.region
            )
        })
    }
}
