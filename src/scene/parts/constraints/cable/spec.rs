//! `[[constraint]]` of kind `cable`.

use crate::scene::builder::Builder;
use crate::scene::kind::by_kind;
use crate::scene::parts::constraints::part::ConstraintPart;
use crate::scene::quantity::{Force, GuideRadius, Length};
use crate::scene::recorder::Headline;
use crate::scene::signal::SignalSpec;
use serde::Deserialize;

by_kind!(CableDriveSpec);

/// A cable along a path through the body.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableSpec {
    #[serde(default = "cable")]
    pub name: String,
    /// Path of the body, or `guides` with `pull_point`
    pub path: Option<String>,
    pub guides: Option<Vec<[Length; 3]>>,
    pub pull_point: Option<[Length; 3]>,
    /// Points fixed in space between pull point and guides
    #[serde(default)]
    pub rings: Vec<RingSpec>,
    pub guide_radius: GuideRadius,
    pub drive: CableDriveSpec,
    /// Axial stiffness; a cable without one does not stretch
    #[serde(rename = "EA")]
    pub axial: Option<Force>,
    /// Tension at which a drive by length yields
    pub max_tension: Option<Force>,
    /// Coefficient of friction at guides and rings; none means the same tension everywhere
    pub friction: Option<f64>,
}

/// A ring fixed in space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RingSpec {
    pub at: [Length; 3],
    /// Number of guides between the pull point and the ring
    pub after: usize,
}

fn cable() -> String {
    "cable".into()
}

/// Drive of a cable at the pull point.
#[derive(Clone, Debug, Deserialize)]
#[serde(remote = "Self", rename_all = "snake_case", deny_unknown_fields)]
pub enum CableDriveSpec {
    /// Shortening of the cable
    Length {
        signal: SignalSpec,
    },
    Tension {
        signal: SignalSpec,
    },
}

impl CableDriveSpec {
    /// Whether the length is prescribed, and the tension follows.
    pub(super) fn is_by_length(&self) -> bool {
        matches!(self, Self::Length { .. })
    }
}

impl ConstraintPart for CableSpec {
    fn headline(&self) -> Option<Headline> {
        let column = format!("{}_tension_N", self.name);
        Some(Headline { column, label: "cable tension", symbol: "T", unit: "N" })
    }

    fn is_exact(&self) -> bool {
        self.friction.is_some() || self.drive.is_by_length()
    }

    fn has_friction(&self) -> bool {
        self.friction.is_some()
    }

    /// Notes a guide radius smaller than h; a cable through points has no limit as h → 0.
    fn note(&self, builder: &mut Builder) -> Option<String> {
        let (name, h) = (&self.name, builder.body.mesh.h());
        match self.guide_radius {
            GuideRadius::Point => return Some(format!("the {name} acts through points")),
            GuideRadius::Ball(r) if r < h => {
                let (r, h) = (r * 1e3, h * 1e3);
                builder.notes.push(format!("{name}: the guide radius {r:.3} mm is below h = {h:.3} mm"));
            }
            GuideRadius::Ball(_) => {}
        }
        None
    }
}
