//! `[[constraint]]` of kind `cable`.

use crate::scene::build::builder::Builder;
use crate::scene::parts::constraints::part::ConstraintPart;
use crate::scene::parts::patch::note_radius;
use crate::scene::record::recorder::Headline;
use crate::scene::signal::SignalSpec;
use crate::scene::text::quantity::{Force, GuideRadius, Length};
use crate::schema::any_of;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Unexpected, Visitor};
use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;

/// A cable along a path through the body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CableSpec {
    /// Prefix of the columns; `cable` if absent
    #[serde(default = "cable")]
    pub name: String,
    /// Path of the body, in place of `guides` with `pull_point`
    pub path: Option<String>,
    /// Guides in order from the pull point: points, or a file
    pub guides: Option<GuidesSpec>,
    /// Point at which the cable is pulled
    pub pull_point: Option<PullPointSpec>,
    /// Distance from the body up to which guides outside of it are moved to its surface
    pub reach: Option<Length>,
    /// Points fixed in space between pull point and guides
    #[serde(default)]
    pub rings: Vec<RingSpec>,
    /// Radius of the patches over which guides spread their forces, or `"point"`
    pub guide_radius: GuideRadius,
    /// How the cable is driven at the pull point
    pub drive: CableDriveSpec,
    /// Axial stiffness EA; a cable without it does not stretch
    #[serde(rename = "EA")]
    pub axial: Option<Force>,
    /// Tension at which a drive by length yields
    pub max_tension: Option<Force>,
    /// Coefficient of friction at guides and rings; if absent or 0, the tension is the same everywhere
    pub friction: Option<f64>,
}

/// Guides in order from the pull point.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub enum GuidesSpec {
    /// Points of one cable.
    List(Vec<[Length; 3]>),
    /// A file with the guides of one cable or of several, each of which takes the other keys of the entry
    File(GuideFile),
}

/// A file of guides.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GuideFile {
    /// Path of the CSV or JSON file
    pub file: PathBuf,
    /// Unit of length of the file
    pub unit: String,
    /// Name of the only cable to be taken from the file
    pub cable: Option<String>,
}

/// Point at which a cable is pulled.
#[derive(Clone, Debug)]
pub enum PullPointSpec {
    /// A point fixed in space
    At([Length; 3]),
    /// The first of the guides, fixed in space
    First,
    /// The first of the guides, which moves with the body
    Moving,
}

impl<'de> Deserialize<'de> for GuidesSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ListOrFile)
    }
}

struct ListOrFile;

impl<'de> Visitor<'de> for ListOrFile {
    type Value = GuidesSpec;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a list of points, or a table of `file` and `unit`")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<GuidesSpec, A::Error> {
        Deserialize::deserialize(SeqAccessDeserializer::new(list)).map(GuidesSpec::List)
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<GuidesSpec, A::Error> {
        Deserialize::deserialize(MapAccessDeserializer::new(table)).map(GuidesSpec::File)
    }
}

impl<'de> Deserialize<'de> for PullPointSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(PointOrFirst)
    }
}

impl JsonSchema for PullPointSpec {
    fn schema_name() -> Cow<'static, str> {
        "PullPointSpec".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        any_of(&[generator.subschema_for::<[Length; 3]>(), json_schema!({ "enum": ["first", "moving"] })])
    }
}

struct PointOrFirst;

impl<'de> Visitor<'de> for PointOrFirst {
    type Value = PullPointSpec;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "a point, or \"first\" where the first of the guides is the pull point, or \"moving\" where it moves with the body too"
        )
    }

    fn visit_seq<A: SeqAccess<'de>>(self, point: A) -> Result<PullPointSpec, A::Error> {
        Deserialize::deserialize(SeqAccessDeserializer::new(point)).map(PullPointSpec::At)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<PullPointSpec, E> {
        match text {
            "first" => Ok(PullPointSpec::First),
            "moving" => Ok(PullPointSpec::Moving),
            _ => Err(E::invalid_value(Unexpected::Str(text), &self)),
        }
    }
}

/// A ring fixed in space.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RingSpec {
    /// Point of the ring
    pub at: [Length; 3],
    /// Number of guides between the pull point and the ring
    pub after: usize,
}

fn cable() -> String {
    "cable".into()
}

/// Drive of a cable at the pull point.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[schemars(tag = "kind", transform = crate::schema::kind_alone)]
pub enum CableDriveSpec {
    /// Shortening of the cable
    Length {
        /// Length that is pulled in \[m\]
        signal: SignalSpec,
    },
    /// Tension at the pull point
    Tension {
        /// Force in the cable \[N\]
        signal: SignalSpec,
    },
}

impl CableDriveSpec {
    /// Whether the length is prescribed, so that the tension follows.
    pub(super) fn is_by_length(&self) -> bool {
        matches!(self, Self::Length { .. })
    }
}

impl CableSpec {
    /// Name of the cable, which is the name in the file of guides if one cable is taken from it.
    fn label(&self) -> &str {
        match &self.guides {
            Some(GuidesSpec::File(GuideFile { cable: Some(name), .. })) => name,
            _ => &self.name,
        }
    }

    /// The coefficient of the capstan law; `None` for a cable with the same tension everywhere, as with the coefficient 0.
    pub(super) fn capstan(&self) -> Option<f64> {
        self.friction.filter(|mu| *mu != 0.0)
    }
}

impl ConstraintPart for CableSpec {
    fn headline(&self) -> Option<Headline> {
        // If there are several cables, their names are in the file.
        if matches!(&self.guides, Some(GuidesSpec::File(GuideFile { cable: None, .. }))) {
            return None;
        }
        let column = format!("{}_tension_N", self.label());
        Some(Headline { column, label: "cable tension", symbol: "T", unit: "N" })
    }

    fn exact(&self) -> Option<&'static str> {
        match (self.capstan(), self.drive.is_by_length()) {
            (_, true) => Some("a cable driven by length"),
            (Some(_), false) => Some("a cable with friction"),
            (None, false) => None,
        }
    }

    fn has_friction(&self) -> bool {
        self.capstan().is_some()
    }

    /// Adds a note if the guide radius is smaller than h; returns the reason why a cable through points has no limit as h → 0.
    fn note(&self, builder: &mut Builder) -> Option<String> {
        match self.guide_radius {
            GuideRadius::Point => Some(format!("the {} acts through points", self.label())),
            GuideRadius::Ball(radius) => {
                note_radius(builder, self.label(), "the guide radius", radius);
                None
            }
        }
    }
}
