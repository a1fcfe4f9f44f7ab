//! Probe `bending_angle`. `bending_angle_deg`: angle by which the area-mean normal of `tip` has rotated since the start; `chord_angle_deg`: angle by which the
//! line from the mean position of `root` to that of `tip` has rotated.

use super::mean::Mean;
use super::part::Probe;
use crate::math::tensor::Vec3;
use crate::mesh::{TetMesh, element, quadrature};
use crate::scene::body::Body;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::record::features::{Features, Reading};
use crate::scene::record::recorder::{Headline, Moment, Recorder};
use crate::scene::record::winding::Winding;
use crate::system::{Gradient, State};
use schemars::JsonSchema;
use serde::Deserialize;

/// Smallest sine of the angle between the axis and a direction whose rotation about it is counted (5.7°).
const ACROSS: f64 = 0.1;
/// Smallest distance between root and tip relative to the diagonal of the body.
const APART: f64 = 1e-9;

/// Area vector relative to the area below which the normals of a region cancel, and share of the area below which its direction is doubtful.
const CANCELLED: f64 = 1e-6;
const DOUBTFUL: f64 = 0.1;

/// Angle by which a tip has rotated and moved about a root.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BendingAngle {
    /// Region of facets from which the chord to the tip starts
    pub root: String,
    /// Region of facets whose angle is recorded
    pub tip: String,
    /// Axis about which the angles are counted, with a sign by the right-hand rule
    pub axis: Option<[f64; 3]>,
}

impl Probe for BendingAngle {
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        let mesh = &builder.body.mesh;
        let (root, tip) = (builder.region_with_nodes(place, &self.root)?, builder.region_with_nodes(place, &self.tip)?);
        let facets = tip.facets.clone();
        let (root, tip) = (Mean::new(mesh, root), Mean::new(mesh, tip));
        let chord = tip.origin - root.origin;
        if chord.norm() <= APART * mesh.diagonal() {
            let fact = format!("the mean positions of root \"{}\" and tip \"{}\" are the same", self.root, self.tip);
            return Err(builder.content(
                place,
                fact,
                "give two regions with a line between them, whose rotation is recorded",
            ));
        }
        let normal = area_vector(mesh, &facets, &vec![0.0; 3 * mesh.points.len()]);
        let area = mesh.region_area(&facets);
        if !facets.is_empty() && normal.norm() <= CANCELLED * area {
            let fact = format!("the normals of the facets of tip \"{}\" cancel, so that it has no direction", self.tip);
            return Err(builder.content(
                place,
                fact,
                "name the end face alone, not a closed surface or two opposite faces",
            ));
        }
        let directions = [("the line from root to tip", chord), ("the normal of the tip", normal)];
        let axis = self.checked_axis(place, builder, &directions[..if facets.is_empty() { 1 } else { 2 }])?;
        let windings = [Winding::new(normal, axis), Winding::new(chord, axis)];
        Ok(Box::new(Recorded { root, tip, facets, windings }))
    }

    fn note(&self, place: &str, builder: &Builder) -> Option<String> {
        let tip = &self.tip;
        let facets = &builder.region(place, tip).ok()?.facets;
        if facets.is_empty() {
            return Some(format!(
                "bending_angle: region \"{tip}\" holds no facets, so that bending_angle_deg is not recorded, only chord_angle_deg; \
                 where it is a selector, add pick = \"facets\" and a `rule`"
            ));
        }
        let mesh = &builder.body.mesh;
        let share = area_vector(mesh, facets, &vec![0.0; 3 * mesh.points.len()]).norm() / mesh.region_area(facets);
        (share < DOUBTFUL).then(|| {
            format!(
                "bending_angle: the normals of the facets of \"{tip}\" cancel but for {:.1} % of their area, and bending_angle_deg is the rotation of that rest; name the end face alone",
                100.0 * share
            )
        })
    }

    fn regions(&self) -> Vec<&str> {
        vec![&self.root, &self.tip]
    }

    fn headline(&self) -> Option<Headline> {
        Some(Headline { column: "bending_angle_deg".into(), label: "bending angle", symbol: "θ", unit: "°" })
    }
}

impl BendingAngle {
    /// The axis as a unit vector; refuses an axis to which these directions are nearly parallel.
    fn checked_axis(
        &self,
        place: &str,
        builder: &Builder,
        directions: &[(&str, Vec3)],
    ) -> Result<Option<Vec3>, SceneError> {
        let Some(given) = self.axis else { return Ok(None) };
        let Some(axis) = Vec3::from(given).try_normalize(0.0).filter(|a| a.iter().all(|v| v.is_finite())) else {
            return Err(builder.content(place, "the axis has no length", "write for example axis = [0, 1, 0]"));
        };
        let along = |(_, d): &&(&str, Vec3)| axis.cross(d).norm() < ACROSS * d.norm();
        match directions.iter().find(along) {
            None => Ok(Some(axis)),
            Some((what, _)) => {
                let fact = format!("the axis {given:?} is along {what}, whose rotations about it cannot be seen");
                Err(builder.content(place, fact, "give the axis about which the body bends, across the body"))
            }
        }
    }
}

struct Recorded {
    root: Mean,
    tip: Mean,
    /// Facets of the tip; without them there is no bending angle, only a chord angle
    facets: Vec<u32>,
    /// Windings of the normal and of the chord
    windings: [Winding; 2],
}

impl Recorded {
    /// The normal of the tip, which is zero without facets, and the chord.
    fn directions(&self, mesh: &TetMesh, x: &[f64]) -> [Vec3; 2] {
        [area_vector(mesh, &self.facets, x), self.tip.at(x) - self.root.at(x)]
    }

    /// The memories of the normal and of the chord.
    fn memories<'m>(&self, memory: &'m [f64]) -> [&'m [f64]; 2] {
        memory.split_at(Winding::MEMORY).into()
    }
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        let all: &[&str] = &["bending_angle_deg", "chord_angle_deg"];
        let own = if self.facets.is_empty() { &all[1..] } else { all };
        own.iter().map(ToString::to_string).collect()
    }

    fn memory(&self) -> Vec<f64> {
        vec![0.0; 2 * Winding::MEMORY]
    }

    fn remember(&self, body: &Body, state: &State, memory: &mut [f64]) {
        let directions = self.directions(&body.mesh, &state.x);
        for ((winding, now), own) in self.windings.iter().zip(directions).zip(memory.chunks_mut(Winding::MEMORY)) {
            winding.remember(now, own);
        }
    }

    /// The recorded angles, which include the whole turns of the states before.
    fn memory_at(&self, body: &Body, state: &State, recorded: &[Option<f64>]) -> Vec<f64> {
        let mut memory = self.memory();
        self.remember(body, state, &mut memory);
        let of_columns = memory.chunks_mut(Winding::MEMORY).skip(usize::from(self.facets.is_empty()));
        of_columns.zip(recorded).for_each(|(own, angle)| own[0] = angle.unwrap_or(own[0]));
        memory
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        let [normal, chord] = self.memories(now.memory).map(|own| own[0]);
        if self.facets.is_empty() { vec![chord] } else { vec![normal, chord] }
    }

    fn gradients(&self, body: &Body, state: &State, memory: &[f64]) -> Vec<Option<Gradient>> {
        let (mesh, x) = (&body.mesh, &state.x);
        let Self { root, tip, facets, windings: [of_normal, of_chord] } = self;
        let [normal, chord] = self.directions(mesh, x);
        let [normal_memory, chord_memory] = self.memories(memory);
        let along = of_chord.gradient(chord, chord_memory);
        let chord = [tip.along(along), root.along(-along)].concat();
        if facets.is_empty() {
            return vec![Some(Gradient::of_displacements(chord))];
        }
        let along = of_normal.gradient(normal, normal_memory);
        [area_gradient(mesh, facets, x, along), chord].map(|x| Some(Gradient::of_displacements(x))).into()
    }

    fn is_differentiable(&self) -> bool {
        true
    }

    fn features(&self) -> Option<Features> {
        let [normal, chord] = self.windings.clone();
        let all = [Reading::Turned(0, normal), Reading::Turned(3, chord)];
        let first = usize::from(self.facets.is_empty());
        Some(Features { degree: 2, readings: all[first..].to_vec() })
    }

    fn feature_values(&self, body: &Body, x: &[f64]) -> Vec<f64> {
        self.directions(&body.mesh, x).iter().flat_map(|d| <[f64; 3]>::from(*d)).collect()
    }
}

/// ∫ n dA over deformed facets \[m²\].
fn area_vector(mesh: &TetMesh, facets: &[u32], x: &[f64]) -> Vec3 {
    let rule = quadrature::tri(2);
    let mut sum = Vec3::zeros();
    for &f in facets {
        let nodes = mesh.facet(f as usize);
        for (&xi, w) in rule.points.iter().zip(&rule.weights) {
            let gradients = element::facet_gradients(mesh.order, xi);
            let (mut a, mut b) = (Vec3::zeros(), Vec3::zeros());
            for (&k, g) in nodes.iter().zip(gradients) {
                let p = mesh.points[k as usize] + Vec3::from_column_slice(&x[3 * k as usize..][..3]);
                a += p * g[0];
                b += p * g[1];
            }
            sum += a.cross(&b) * *w;
        }
    }
    sum
}

/// Derivatives of c·∫ n dA with respect to the unknowns \[m\]: c·(da × b + a × db) = da·(b × c) + db·(c × a) with the tangents a and b.
fn area_gradient(mesh: &TetMesh, facets: &[u32], x: &[f64], c: Vec3) -> Vec<(u32, f64)> {
    let rule = quadrature::tri(2);
    let mut out = Vec::new();
    for &f in facets {
        let nodes = mesh.facet(f as usize);
        let mut sums = vec![Vec3::zeros(); nodes.len()];
        for (&xi, w) in rule.points.iter().zip(&rule.weights) {
            let gradients = element::facet_gradients(mesh.order, xi);
            let (mut a, mut b) = (Vec3::zeros(), Vec3::zeros());
            for (&k, g) in nodes.iter().zip(&gradients) {
                let p = mesh.points[k as usize] + Vec3::from_column_slice(&x[3 * k as usize..][..3]);
                a += p * g[0];
                b += p * g[1];
            }
            let (of_a, of_b) = (b.cross(&c) * *w, c.cross(&a) * *w);
            sums.iter_mut().zip(&gradients).for_each(|(sum, g)| *sum += of_a * g[0] + of_b * g[1]);
        }
        out.extend(nodes.iter().zip(sums).flat_map(|(&k, sum)| (0..3).map(move |i| (3 * k + i, sum[i as usize]))));
    }
    out
}
