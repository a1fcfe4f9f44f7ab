//! Constraint `cavity`: facets, closed or with a rim that is held or declared free, with air or liquid behind them; or a closed skin.

use super::cavity_rim::{Planes, caps, is_in_planes, rim_planes};
use super::cavity_wall::{Wall, wall};
use crate::scene::build::drive::Drive;

use super::part::ConstraintPart;
use crate::effect::{
    Cavity, CavityPressure, CavityRim, CavityVolume, OpenCavityPressure, VolumeField, middle_of_edges,
};
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::{Decimals, Dimension};
use crate::mesh::TetMesh;
use crate::mesh::error::point;
use crate::scene::body::Body;
use crate::scene::build::builder::Builder;
use crate::scene::build::held_rim::HeldRim;
use crate::scene::error::SceneError;
use crate::scene::notes::jump::{Impact, note_jump};
use crate::scene::parts::contact::NamedContact;
use crate::scene::record::recorder::{Headline, Moment, Recorder};
use crate::scene::signal::SignalSpec;
use crate::scene::signal::protocol::extremes;
use crate::system::{Gradient, State};
use schemars::JsonSchema;
use serde::Deserialize;
use std::f64::consts::PI;
use std::sync::Arc;

/// Air or liquid behind the facets of a region, or within a skin; exactly one of `region` and `skin` is given.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CavitySpec {
    /// Prefix of the columns; `cavity` if absent
    #[serde(default = "cavity")]
    pub name: String,
    /// Facets of the mesh
    pub region: Option<String>,
    /// A closed surface, in place of a region
    pub skin: Option<String>,
    /// How the cavity is driven
    pub drive: CavityDriveSpec,
    /// Whether the surface is open and its rim free
    #[serde(default)]
    pub open: bool,
}

fn cavity() -> String {
    "cavity".into()
}

/// Drive of a cavity.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum CavityDriveSpec {
    /// Pressure relative to the surroundings
    Pressure {
        /// Pressure \[Pa\]
        signal: SignalSpec,
    },
    /// Increase of the volume
    Volume {
        /// Increase of the volume \[m³\]
        signal: SignalSpec,
    },
}

impl CavityDriveSpec {
    /// Whether the volume is prescribed, so that the pressure follows.
    fn is_by_volume(&self) -> bool {
        matches!(self, Self::Volume { .. })
    }
}

impl ConstraintPart for CavitySpec {
    fn headline(&self) -> Option<Headline> {
        let column = format!("{}_pressure_Pa", self.name);
        Some(Headline { column, label: "pressure", symbol: "p", unit: "Pa" })
    }

    fn exact(&self) -> Option<&'static str> {
        self.drive.is_by_volume().then_some("a cavity driven by volume")
    }
}

/// A cavity with its drive, for probes.
pub struct NamedCavity {
    pub name: String,
    pub cavity: Arc<Cavity>,
    pub drive: Drive,
    /// Facets of its wall, or facets next to a skin that does not lie on facets, ascending
    facets: Vec<u32>,
    /// Whether its wall is a skin that does not lie on facets
    follows: bool,
    /// Volume between the cones from which the volume counts and the caps across the held parts of its rim \[m³\]
    caps: f64,
    /// Whether its volume is enclosed on all sides: the wall is closed, or cut by planes of symmetry
    pub(in crate::scene) encloses: bool,
}

/// Builds a cavity with its load or its constraint; `before`: the cavities built so far. To be called when everything that is held is known.
pub(in crate::scene) fn build_cavity(
    builder: &mut Builder,
    place: &str,
    spec: &CavitySpec,
    before: &[NamedCavity],
) -> Result<NamedCavity, SceneError> {
    let CavitySpec { name, drive, open, .. } = spec;
    builder.check_name(place, name)?;
    let body = builder.body.clone();
    let mesh = &body.mesh;
    let (surface, wall) = wall(builder, place, name, (spec.region.as_deref(), spec.skin.as_deref()))?;
    check_shared(builder, place, &wall, before)?;
    let rim = wall.rim(mesh);
    let planes = check_rim(builder, place, (surface, *open, drive), mesh, &rim)?;
    let Some(field) = volume_field(apex(builder, mesh, &wall, &rim), planes.as_ref().unwrap_or(&Planes::default()))
    else {
        let fact = format!("the rim of the surface \"{surface}\" slides in parallel planes along x, y and z");
        return Err(builder.content(place, fact, "hold a part of the rim (kind = \"fixed\"), or close the surface"));
    };
    let cavity = Arc::new(wall.cavity(name.clone(), mesh, field));
    let rest = cavity.volume(&vec![0.0; 3 * mesh.points.len()]);
    if rim.is_empty() && rest <= 0.0 {
        let fact =
            format!("the surface \"{surface}\" encloses {:.4} mm^3: the body is inside of it", Decimals(rest * 1e9));
        return Err(builder.content(place, fact, "take the surface of a hollow, with the body around it"));
    }
    let across = |planes| caps(builder, mesh, &rim, (planes, &field, wall.area(mesh)));
    let caps = planes.as_ref().map_or(0.0, across);
    if !rim.is_empty() {
        builder.notes.push(format!("{name} is open: its volume {}{}", counted(&field), capped(caps)));
    }
    if planes.is_none() {
        let note = "has a free rim: the tangent is not symmetric, and the stability of equilibria is not judged";
        builder.notes.push(format!("{name} {note}"));
    }
    let drive = match drive {
        CavityDriveSpec::Pressure { signal } => {
            let pressure = builder.signal(place, format!("{name}_imposed_pressure_Pa"), signal, Dimension::PRESSURE)?;
            builder.effects.push(match (&planes, &wall) {
                (None, Wall::Facets(facets)) => {
                    Box::new(OpenCavityPressure::new(cavity.clone(), mesh, facets, pressure.clone()))
                }
                _ => Box::new(CavityPressure { cavity: cavity.clone(), pressure: pressure.clone() }),
            });
            Drive::Prescribed(pressure)
        }
        CavityDriveSpec::Volume { signal } => {
            let column = format!("{name}_growth_m3");
            let growth = builder.signal(place, column.clone(), signal, Dimension::VOLUME)?;
            note_jump(builder, &column, &growth, Impact::Any);
            if rim.is_empty() {
                check_growth(builder, place, &growth, rest)?;
            }
            // No other surface of this area holds as much as the sphere
            let scale = wall.area(mesh).powf(1.5) / (6.0 * PI.sqrt());
            builder.constraints.push(Box::new(CavityVolume { cavity: cavity.clone(), growth, rest, scale }));
            Drive::Multiplier(builder.constraints.len() - 1)
        }
    };
    if planes.is_some() && !rim.is_empty() {
        builder.gathered.rims.push(HeldRim { rim: CavityRim::new(mesh, &rim, field), drive: drive.clone() });
    }
    let (follows, mut facets) = (wall.follows(), wall.facets().to_vec());
    facets.sort_unstable();
    let encloses = rest > 0.0 && planes.is_some_and(|planes| is_in_planes(mesh, &rim, &planes));
    Ok(NamedCavity { name: name.clone(), cavity, drive, facets, follows, caps, encloses })
}

/// Share of the facets next to a skin that may also be next to another wall \[–\]: at a thin wall between two hollows some facets are nearest to both.
const FEW: f64 = 0.1;

/// Refuses a wall that an earlier cavity already has, because the two pressures would add up there.
fn check_shared(builder: &Builder, place: &str, wall: &Wall, before: &[NamedCavity]) -> Result<(), SceneError> {
    let (facets, follows) = (wall.facets(), wall.follows());
    let shared = |other: &NamedCavity| {
        let count = facets.iter().filter(|f| other.facets.binary_search(f).is_ok()).count();
        let least = facets.len().min(other.facets.len()) as f64;
        let few = if follows || other.follows { FEW * least } else { 0.0 };
        (count as f64 > few).then_some(count)
    };
    let Some((other, shared)) = before.iter().find_map(|other| Some((other, shared(other)?))) else { return Ok(()) };
    let all = match (facets.len(), follows) {
        (of, false) => format!("its {of} facets"),
        (of, true) => format!("the {of} facets next to it"),
    };
    let fact = format!("{shared} of {all} are those of {} too, and the pressures would add up there", other.name);
    Err(builder.content(place, fact, "give each cavity a wall of its own, or keep one with the sum"))
}

/// Adds a note on a vacuum: only a contact keeps the walls of a cavity apart.
pub(in crate::scene) fn note_vacuum(builder: &mut Builder, cavities: &[NamedCavity], contacts: &[NamedContact]) {
    for NamedCavity { name, drive, facets, .. } in cavities {
        let Drive::Prescribed(pressure) = drive else { continue };
        let nodes = || facets.iter().flat_map(|&f| builder.body.mesh.facet(f as usize)).copied();
        if !facets.is_empty() && contacts.iter().any(|contact| contact.keeps_apart(nodes())) {
            continue;
        }
        let ((t, least), _) = extremes(pressure, &builder.spans);
        if !pressure.has_inputs() && least < 0.0 {
            let note = format!(
                "{name} is under a vacuum of {:.4} kPa at t = {:.4} s: its walls may pass through each other unless a [[contact]] keeps them apart",
                Decimals(-least / 1e3),
                Decimals(t)
            );
            builder.notes.push(note);
        }
    }
}

/// Refuses to take more out of a closed cavity than it holds. A signal that is decided during the run is not checked here.
fn check_growth(builder: &Builder, place: &str, growth: &Signal, rest: f64) -> Result<(), SceneError> {
    if growth.has_inputs() {
        return Ok(());
    }
    let ((t, least), _) = extremes(growth, &builder.spans);
    // A signal without a finite value is refused with its formula.
    if -least < rest || !least.is_finite() {
        return Ok(());
    }
    let fact = format!(
        "{:.4} ml are taken out at t = {:.4} s, and the cavity holds {:.4} ml",
        Decimals(-least * 1e6),
        Decimals(t),
        Decimals(rest * 1e6)
    );
    Err(builder.content(place, fact, "take out less: its walls would pass through each other"))
}

/// Checks whether a cavity with this surface can be driven in this way. Returns the planes in which its rim slides; `None` if the rim is free.
fn check_rim(
    builder: &Builder,
    place: &str,
    (region, open, drive): (&str, bool, &CavityDriveSpec),
    mesh: &TetMesh,
    rim: &[Vec<u32>],
) -> Result<Option<Planes>, SceneError> {
    let by_volume = drive.is_by_volume();
    let remedy = "close the surface, hold the rim (kind = \"fixed\"), or let it slide in planes of symmetry \
                  (hold components = \"z\" where such a plane is z = const)";
    match rim_planes(builder, mesh, rim) {
        _ if open && rim.is_empty() => {
            let fact = format!("open = true, and the surface \"{region}\" is closed");
            Err(builder.content(place, fact, "remove `open`"))
        }
        Ok(_) if open => {
            let fact = format!("open = true, and no part of the rim of the surface \"{region}\" is free");
            Err(builder.content(place, fact, "remove `open`"))
        }
        Ok(planes) => Ok(Some(planes)),
        Err(_) if open && !by_volume => Ok(None),
        Err(at) => {
            let fact = format!("the surface \"{region}\" is open, and its rim is free, or moved, at {}", point(&at));
            if by_volume {
                let fact = format!("{fact}: it holds no volume that could be given");
                return Err(builder.content(
                    place,
                    fact,
                    format!("drive it by pressure with open = true, or {remedy}"),
                ));
            }
            Err(builder.content(place, fact, format!("set open = true if it is to stay free; or {remedy}")))
        }
    }
}

/// The centroid of the held part of the rim: behind a flat rim V is then the volume up to its plane, whatever nodes the mesh has. If the wall is closed, or
/// all of its rim slides in planes, V does not depend on this point, and the centroid keeps the cones short and the rounding small.
fn apex(builder: &Builder, mesh: &TetMesh, wall: &Wall, rim: &[Vec<u32>]) -> Vec3 {
    let is_held = |edge: &&Vec<u32>| edge.iter().all(|&node| builder.is_held(node));
    let held: Vec<&Vec<u32>> = rim.iter().filter(is_held).collect();
    let edges = if held.is_empty() { rim.iter().collect() } else { held };
    middle_of_edges(mesh, &edges).unwrap_or_else(|| wall.middle(mesh))
}

/// The vector field whose flux measures the volume. Its origin lies in the planes, and at `middle` in the directions without a single plane. It has no flux
/// through parallel planes; `None` if there are parallel planes along every axis.
fn volume_field(middle: Vec3, planes: &Planes) -> Option<VolumeField> {
    let origin = Vec3::from_fn(|k, _| if let [level] = planes[k][..] { level } else { middle[k] });
    VolumeField::across(origin, std::array::from_fn(|k| planes[k].len() > 1))
}

/// The origin of the volume of an open cavity, for a note.
fn counted(field: &VolumeField) -> String {
    let [x, y, z] = [field.origin.x, field.origin.y, field.origin.z].map(|v| 1e3 * v);
    let closed: Vec<&str> =
        ["x", "y", "z"].into_iter().zip(field.weights.iter()).filter(|(_, w)| **w == 0.0).map(|a| a.0).collect();
    let from = format!("({x:.4}, {y:.4}, {z:.4}) mm");
    match closed[..] {
        [] => format!("counts from the cones between the rim and {from}"),
        [axis] => format!("counts from the axis along {axis} through {from}"),
        _ => format!("counts from the plane along {} through {from}", closed.join(" and ")),
    }
}

/// The contribution of caps to the volume of an open cavity \[m³\], for a note.
fn capped(caps: f64) -> String {
    if caps == 0.0 {
        String::new()
    } else {
        format!(", and caps across what is held of the rim are part of it ({:.4} mm^3)", caps * 1e9)
    }
}

impl NamedCavity {
    /// The volume \[m³\] at displacement x, including the caps.
    pub fn volume(&self, x: &[f64]) -> f64 {
        self.cavity.volume(x) + self.caps
    }
}

impl Recorder for NamedCavity {
    /// The columns: pressure and volume.
    fn columns(&self) -> Vec<String> {
        vec![format!("{}_pressure_Pa", self.name), format!("{}_volume_m3", self.name)]
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        vec![self.drive.value(now.state), self.volume(&now.state.x)]
    }

    fn gradients(&self, _: &Body, state: &State, _: &[f64]) -> Vec<Option<Gradient>> {
        let volume = Gradient::of_displacements(self.cavity.volume_gradient(&state.x));
        vec![Some(self.drive.gradient()), Some(volume)]
    }

    fn is_differentiable(&self) -> bool {
        true
    }
}
