//! Probe `bending_angle`. `bending_angle_deg`: angle between the area-mean normals of `tip` now and at the start;
//! `chord_angle_deg`: angle of the line from the mean position of `root` to the one of `tip`.

use super::mean::Mean;
use super::part::Probe;
use crate::math::tensor::Vec3;
use crate::mesh::{TetMesh, element, quadrature};
use crate::scene::body::Body;
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::recorder::{Headline, Moment, Recorder};
use crate::system::{Gradient, State};
use serde::Deserialize;

/// Angle by which a tip has turned and moved about a root.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BendingAngle {
    pub root: String,
    pub tip: String,
}

impl Probe for BendingAngle {
    fn build(&self, place: &str, builder: &Builder) -> Result<Box<dyn Recorder>, SceneError> {
        let mesh = &builder.body.mesh;
        let (root, tip) = (builder.region(place, &self.root)?, builder.region(place, &self.tip)?);
        let facets = tip.facets.clone();
        Ok(Box::new(Recorded { root: Mean::new(mesh, root), tip: Mean::new(mesh, tip), facets }))
    }

    fn headline(&self) -> Option<Headline> {
        Some(Headline { column: "bending_angle_deg".into(), label: "bending angle", symbol: "θ", unit: "°" })
    }
}

struct Recorded {
    root: Mean,
    tip: Mean,
    /// Of the tip; without them there is no bending angle, only the chord
    facets: Vec<u32>,
}

impl Recorder for Recorded {
    fn columns(&self) -> Vec<String> {
        let all: &[&str] = &["bending_angle_deg", "chord_angle_deg"];
        let own = if self.facets.is_empty() { &all[1..] } else { all };
        own.iter().map(ToString::to_string).collect()
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        let (mesh, x) = (&now.body.mesh, &now.state.x);
        let Self { root, tip, facets } = self;
        let chord = angle(tip.origin - root.origin, tip.at(x) - root.at(x));
        if facets.is_empty() {
            return vec![chord];
        }
        let rest = vec![0.0; x.len()];
        vec![angle(area_vector(mesh, facets, &rest), area_vector(mesh, facets, x)), chord]
    }

    fn gradients(&self, body: &Body, state: &State) -> Option<Vec<Gradient>> {
        let (mesh, x) = (&body.mesh, &state.x);
        let Self { root, tip, facets } = self;
        let along = angle_gradient(tip.origin - root.origin, tip.at(x) - root.at(x));
        let chord = [tip.along(along), root.along(-along)].concat();
        if facets.is_empty() {
            return Some(vec![Gradient::of_displacements(chord)]);
        }
        let rest = area_vector(mesh, facets, &vec![0.0; x.len()]);
        let along = angle_gradient(rest, area_vector(mesh, facets, x));
        Some([area_gradient(mesh, facets, x, along), chord].map(Gradient::of_displacements).into())
    }

    fn is_differentiable(&self) -> bool {
        true
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

/// Derivatives of c·∫ n dA by the unknowns \[m\]: c·(da × b + a × db) = da·(b × c) + db·(c × a) with the tangents a and b.
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

/// Angle between two directions \[deg\], 0 to 180.
fn angle(a: Vec3, b: Vec3) -> f64 {
    a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
}

/// Derivative of the angle between a fixed a and b \[deg\] by b: dϑ = \[(a·b) d|a × b| − |a × b| a·db\]/(|a|²|b|²),
/// d|a × b| = ((a × b) × a)·db/|a × b|. Zero where a and b are parallel: the angle has a kink there.
fn angle_gradient(a: Vec3, b: Vec3) -> Vec3 {
    let cross = a.cross(&b);
    let sine = cross.norm();
    if sine == 0.0 {
        return Vec3::zeros();
    }
    let rate = cross.cross(&a) / sine;
    (a.dot(&b) * rate - sine * a) * (1.0 / (a.norm_squared() * b.norm_squared())).to_degrees()
}
