//! Effect `fibre_family`: fibres spread over the cells of a region, which stiffen them in one direction.

use super::fibre::Hand;
use super::part::EffectPart;
use crate::effect::FibreFamilies;
use crate::material::fibre_family::FibreFamily;
use crate::math::tensor::Vec3;
use crate::mesh::error::point;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::recorder::{Moment, Recorder};
use crate::scene::text::quantity::{Angle, Length, Modulus};
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Families of fibres with the same constants.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FibreFamilySpec {
    /// Prefix of the columns; `fibre_family` if absent
    #[serde(default = "fibre_family")]
    pub name: String,
    /// Region of cells
    pub region: String,
    /// Stiffness k₁ of the fibres
    pub k1: Modulus,
    /// Exponential stiffening k₂ of the fibres \[–\]
    pub k2: f64,
    /// Dispersion, from 0 (aligned) to 1/3 (isotropic)
    pub kappa: f64,
    /// Directions of the families at rest
    pub direction: DirectionSpec,
}

fn fibre_family() -> String {
    "fibre_family".into()
}

/// Directions of families at rest.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum DirectionSpec {
    /// The same directions everywhere; one family for each vector
    Constant {
        /// Direction of each family; its length does not matter
        vectors: Vec<[f64; 3]>,
    },
    /// Along helices about an axis; one family for each hand
    Helical {
        /// Two points of the axis
        axis: [[Length; 3]; 2],
        /// Angle between the fibres and the axis
        angle: Angle,
        /// Hand of the helices
        hand: Hand,
    },
}

/// A function of the position X \[m\] that returns a unit vector for each family.
type Directions = Box<dyn Fn(Vec3) -> Vec<Vec3>>;

impl FibreFamilySpec {
    fn constants(&self, builder: &Builder, place: &str) -> Result<FibreFamily, SceneError> {
        let Self { k1, k2, kappa, .. } = *self;
        let mut faults = Vec::new();
        if k1.0 <= 0.0 {
            faults.push(format!("k1 is {} Pa: it is positive", k1.0));
        }
        if !(k2 >= 0.0 && k2.is_finite()) {
            faults.push(format!("k2 is {k2}: it is not negative"));
        }
        if !(0.0..=1.0 / 3.0).contains(&kappa) {
            faults.push(format!("kappa is {kappa}: it is from 0 to 1/3"));
        }
        if faults.is_empty() {
            return Ok(FibreFamily { k1: k1.0, k2, kappa });
        }
        Err(builder.content(place, faults.join("; "), "correct the constants"))
    }

    fn directions(&self, builder: &Builder, place: &str) -> Result<Directions, SceneError> {
        match &self.direction {
            DirectionSpec::Constant { vectors } => {
                let vectors: Vec<Vec3> = vectors.iter().map(|v| Vec3::from(*v)).collect();
                if vectors.is_empty() || vectors.iter().any(|v| !(v.norm() > 0.0 && v.norm().is_finite())) {
                    let fact = "a direction is missing, or has no length";
                    return Err(builder.content(place, fact, "write for example vectors = [[0, 0, 1]]"));
                }
                let vectors: Vec<Vec3> = vectors.iter().map(|v| v.normalize()).collect();
                Ok(Box::new(move |_| vectors.clone()))
            }
            DirectionSpec::Helical { axis, angle, hand } => {
                let [start, end] = axis.map(|p| Vec3::from(p.map(|x| x.0)));
                if start == end {
                    let fact = "the axis of the helices has no length";
                    return Err(builder.content(place, fact, "give two points that are apart"));
                }
                if !(0.0..=FRAC_PI_2).contains(&angle.0) {
                    let fact = format!("the angle between the fibres and the axis is {}°", angle.0.to_degrees());
                    return Err(builder.content(place, fact, "give one from 0° to 90°, and `hand` for the direction"));
                }
                let along = (end - start).normalize();
                let (sin, cos) = angle.0.sin_cos();
                let hands = hand.signs();
                Ok(Box::new(move |at| {
                    let away = (at - start) - along * along.dot(&(at - start));
                    let round = along.cross(&away).normalize();
                    hands.iter().map(|hand| along * cos + round * (hand * sin)).collect()
                }))
            }
        }
    }

    /// Refuses cells on the axis, where the circumferential direction is not defined.
    fn check_axis(&self, builder: &Builder, place: &str, cells: &[u32]) -> Result<(), SceneError> {
        let DirectionSpec::Helical { axis, angle, .. } = &self.direction else { return Ok(()) };
        let [start, end] = axis.map(|p| Vec3::from(p.map(|x| x.0)));
        let mesh = &builder.body.mesh;
        let (along, rounding) = ((end - start).normalize(), 1e-6 * mesh.diagonal());
        let away = |c: u32| (mesh.position(c as usize, [0.25; 3]) - start).cross(&along).norm();
        let on_axis = cells.iter().find(|&&c| away(c) < rounding);
        match on_axis.filter(|_| angle.0 > 0.0) {
            None => Ok(()),
            Some(&c) => {
                let at = point(&mesh.position(c as usize, [0.25; 3]));
                let fact = format!("the axis of the helices goes through the cell at {at}");
                Err(builder.content(place, fact, "take a region around the axis, or another axis"))
            }
        }
    }

    /// Adds a note on fibres that are stiff compared with the bulk modulus K of the material between them: in tension along the fibres 1/E is 1/(9K) + 1/(3G +
    /// 4k₁ (1 − 3κ)²).
    fn note_stiff(&self, builder: &mut Builder, place: &str) -> Result<(), SceneError> {
        let cells: BTreeSet<u32> = builder.cells(place, &self.region)?.iter().copied().collect();
        let between = builder.gathered.stressed.iter().filter(|of| of.points().cells.iter().any(|c| cells.contains(c)));
        let bulk = between.map(|of| of.moduli().kappa).fold(f64::INFINITY, f64::min);
        let added = 4.0 * self.k1.0 * (1.0 - 3.0 * self.kappa).powi(2);
        if added >= bulk {
            builder.notes.push(format!(
                "{}: fibres that add up to {added:.3e} Pa are stiff against the bulk modulus {bulk:.3e} Pa of the material between them: growth of volume relieves \
                 them, and they add less; take nearly incompressible constants, or the effect fibre",
                self.name
            ));
        }
        Ok(())
    }
}

impl EffectPart for FibreFamilySpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        builder.check_name(place, &self.name)?;
        let (constants, directions) = (self.constants(builder, place)?, self.directions(builder, place)?);
        let cells = builder.cells(place, &self.region)?;
        self.check_axis(builder, place, cells)?;
        let effect = FibreFamilies::new(self.name.clone(), &builder.body.mesh, cells, constants, directions);
        let effect = Arc::new(effect);
        builder.gathered.reinforcing.push(effect.clone());
        builder.gathered.recorders.push(Box::new(Recorded { name: self.name.clone(), effect: effect.clone() }));
        Ok(Box::new(effect))
    }

    fn words(&self) -> String {
        let Self { name, region, k1, k2, kappa, direction } = self;
        let direction = match direction {
            DirectionSpec::Constant { vectors } => format!("{} constant direction(s)", vectors.len()),
            DirectionSpec::Helical { angle, .. } => format!("helices at {:.4}° to the axis", angle.0.to_degrees()),
        };
        format!("{name}, region {region}, k1 = {} Pa, k2 = {k2}, kappa = {kappa}, {direction}", k1)
    }

    fn check(&self, number: usize, builder: &mut Builder) -> Result<(), SceneError> {
        let place = format!("effect {number} (fibre_family)");
        let mut elastic = vec![false; builder.body.mesh.cell_count()];
        let points = builder.gathered.points.iter().flat_map(|points| &points.cells);
        points.for_each(|&c| elastic[c as usize] = true);
        match builder.cells(&place, &self.region)?.iter().find(|&&c| !elastic[c as usize]) {
            None => self.note_stiff(builder, &place),
            Some(c) => {
                let fact = format!("cell {c} of region \"{}\" has no elastic effect", self.region);
                let remedy =
                    "fibres do not resist shear: add an [[effect]] of kind \"elastic\" for the material between them";
                Err(builder.content(&place, fact, remedy))
            }
        }
    }
}

/// Columns of families: `<name>_stretch_{min,max}`.
struct Recorded {
    name: String,
    effect: Arc<FibreFamilies>,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        ["stretch_min", "stretch_max"].map(|c| format!("{}_{c}", self.name)).into()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (least, most) = self.effect.stretches(&now.state.x).fold(ends, |(a, b), s| (a.min(s), b.max(s)));
        vec![least, most]
    }
}
