//! Effect `gravity`: the weight of a region.

use super::part::EffectPart;
use super::repeated::check_repeated;
use crate::effect::Gravity;
use crate::math::signal::Signal;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::signal::SignalSpec;
use crate::scene::text::quantity::Density;
use crate::system::Effect;
use schemars::JsonSchema;
use serde::Deserialize;

/// Weight of the cells of a region along a direction.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GravitySpec {
    /// Prefix of the signal; the region if absent
    pub name: Option<String>,
    /// Region of cells that have a weight
    pub region: String,
    /// Mass density at rest
    pub density: Density,
    /// Direction of the weight; its length does not matter
    pub direction: [f64; 3],
    /// Acceleration of free fall \[m/s²\], such as `"9.81 m/s^2"`
    pub acceleration: SignalSpec,
}

/// Number of times of a stage at which accelerations are compared; a prime, so that few periods coincide with it.
const SAMPLES: usize = 97;

impl GravitySpec {
    /// The column of the signal.
    fn column(&self) -> String {
        format!("{}_acceleration_m_s2", self.name.as_ref().unwrap_or(&self.region))
    }
}

impl EffectPart for GravitySpec {
    fn build(&self, place: &str, builder: &mut Builder) -> Result<Box<dyn Effect>, SceneError> {
        let direction = Vec3::from(self.direction);
        if direction.norm() == 0.0 || !direction.norm().is_finite() {
            return Err(builder.content(place, "the direction has no length", "write for example [0, 0, -1]"));
        }
        let density = builder.positive_density(place, self.density.0)?;
        self.name.iter().try_for_each(|name| builder.check_name(place, name))?;
        let acceleration = builder.signal(place, self.column(), &self.acceleration, Dimension::ACCELERATION)?;
        let cells = builder.cells(place, &self.region)?;
        Ok(Box::new(Gravity::new(&builder.body.mesh, cells, density, direction.normalize(), acceleration)))
    }

    fn words(&self) -> String {
        format!("region {}, {} kg/m^3, towards {:?}", self.region, self.density, self.direction)
    }

    /// Refuses an effect that repeats another one. Weights with different directions, or with different histories, are parts of one field.
    fn check(&self, number: usize, builder: &mut Builder) -> Result<(), SceneError> {
        let direction = Vec3::from(self.direction).normalize();
        let column = self.column();
        let known = builder.signals.iter().find(|s| s.name == column).map(|s| &s.signal);
        let signal = known.expect("built with the effect");
        let samples = samples(builder, direction, signal);
        let has_weight = samples.iter().flatten().any(|a| *a != 0.0);
        // Weights that are zero, or set during the run, are distinguished by their specification
        let which = match has_weight && !signal.has_inputs() {
            true => samples.iter().flatten().map(|a| format!("{a:.8e} ")).collect(),
            false => format!("{direction:?} {signal:?}"),
        };
        check_repeated(builder, number, "gravity", which, &self.region)
    }
}

/// Accelerations \[m/s²\] at times of all stages. Except for rounding they are the same for equal weights in other units, or with direction and signal both
/// reversed.
fn samples(builder: &Builder, direction: Vec3, signal: &Signal) -> Vec<[f64; 3]> {
    let times = builder
        .spans
        .iter()
        .flat_map(|s| (0..=SAMPLES).map(|k| s.start + (s.end - s.start) * k as f64 / SAMPLES as f64));
    // Adding zero removes the sign of −0
    times.map(|t| [0, 1, 2].map(|d| direction[d] * signal.at(t) + 0.0)).collect()
}
