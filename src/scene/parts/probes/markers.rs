//! Probe `markers`: `<name>_<k>_{x,y,z}_m`, the positions of points embedded in the body, counted from 1.

use super::mean::Mean;
use super::part::Probe;
use crate::math::tensor::Vec3;
use crate::mesh::embed::embed;
use crate::scene::body::Body;
use crate::scene::build::builder::Builder;
use crate::scene::error::{SceneError, part};
use crate::scene::record::recorder::{Headline, Moment, Recorder};
use crate::scene::text::quantity::Length;
use crate::system::{Gradient, State};
use schemars::JsonSchema;
use serde::Deserialize;

/// Positions of points embedded in the body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Markers {
    /// Prefix of the columns
    pub name: String,
    /// Points in the body at rest, each as three lengths
    pub points: Vec<[Length; 3]>,
}

impl Probe for Markers {
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        builder.check_name(place, &self.name)?;
        let marker = |p: &[Length; 3]| {
            let origin = Vec3::new(p[0].0, p[1].0, p[2].0);
            let embedded = embed(&builder.body.mesh, origin).map_err(|e| part(builder.file, place, e))?;
            Ok(Mean::of_point(origin, embedded.weights))
        };
        let points = self.points.iter().map(marker).collect::<Result<_, SceneError>>()?;
        Ok(Box::new(Recorded { name: self.name.clone(), points }))
    }

    fn headline(&self) -> Option<Headline> {
        Some(Headline { column: format!("{}_1_x_m", self.name), label: "position", symbol: "x", unit: "m" })
    }
}

struct Recorded {
    name: String,
    points: Vec<Mean>,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        let name = &self.name;
        (1..=self.points.len()).flat_map(|k| ["x", "y", "z"].map(|c| format!("{name}_{k}_{c}_m"))).collect()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        self.points.iter().flat_map(|p| p.at(&now.state.x).data.0[0]).collect()
    }

    fn gradients(&self, _: &Body, _: &State, _: &[f64]) -> Vec<Option<Gradient>> {
        self.points.iter().flat_map(Mean::gradients).map(Some).collect()
    }

    fn is_differentiable(&self) -> bool {
        true
    }
}
