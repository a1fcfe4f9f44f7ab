//! Probes: quantities of a run that a scene asks for. One file per kind, and one line below.
//!
//! Positions and directions are means over the area of a region, so they do not depend on the mesh.

pub mod bending_angle;
pub mod energy;
pub mod markers;
pub mod mean;
pub mod position;
pub mod reaction;
pub mod stretch;

use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::kind::by_kind;
use crate::scene::recorder::Recorder;
use serde::Deserialize;

/// A quantity by which runs of one scene are compared where a study names none.
#[derive(Clone, Debug, PartialEq)]
pub struct Headline {
    /// Recorded column
    pub column: String,
    pub label: &'static str,
    pub symbol: &'static str,
    pub unit: &'static str,
}

/// Specification of a probe.
pub(in crate::scene) trait Probe {
    /// The recorder on the mesh of the scene.
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError>;

    /// The quantity that represents the probe, if it has one.
    fn headline(&self) -> Option<Headline> {
        None
    }
}

/// Declares the registry of probes: variant, module and type of each kind.
macro_rules! registry {
    ($(#[$attribute:meta])* pub enum $registry:ident { $($kind:ident in $module:ident,)* }) => {
        $(pub use $module::$kind;)*

        $(#[$attribute])*
        #[derive(Clone, Debug, Deserialize)]
        #[serde(remote = "Self", rename_all = "snake_case")]
        pub enum $registry {
            $(
                #[allow(missing_docs)]
                $kind($kind),
            )*
        }

        by_kind!($registry);

        impl $registry {
            pub(in crate::scene) fn part(&self) -> &dyn Probe {
                match self {
                    $(Self::$kind(part) => part,)*
                }
            }
        }

        $(
            impl From<$kind> for $registry {
                fn from(part: $kind) -> Self {
                    Self::$kind(part)
                }
            }
        )*
    };
}

registry! {
/// One recorded quantity. Cables record tension and length without a probe, cavities pressure and volume.
pub enum ProbeSpec {
    BendingAngle in bending_angle,
    Position in position,
    Markers in markers,
    Reaction in reaction,
    Energy in energy,
    Stretch in stretch,
}
}

impl ProbeSpec {
    /// The quantity that represents the probe, if it has one.
    pub fn headline(&self) -> Option<Headline> {
        self.part().headline()
    }
}
