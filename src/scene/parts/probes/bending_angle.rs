//! Probe `bending_angle`. `bending_angle_deg`: angle between the area-mean normals of `tip` now and at the start;
//! `chord_angle_deg`: angle of the line from the mean position of `root` to the one of `tip`.

use super::mean::Mean;
use super::part::Probe;
use crate::math::tensor::Vec3;
use crate::mesh::{TetMesh, element, quadrature};
use crate::scene::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::recorder::{Change, Headline, Moment, Recorder};
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

    fn derivative(&self, by: &Change) -> Option<Vec<f64>> {
        let (mesh, x, dx) = (&by.body.mesh, &by.state.x, &by.change.x);
        let Self { root, tip, facets } = self;
        let chord = turned(tip.origin - root.origin, tip.at(x) - root.at(x), tip.moved(dx) - root.moved(dx));
        if facets.is_empty() {
            return Some(vec![chord]);
        }
        let rest = area_vector(mesh, facets, &vec![0.0; x.len()]);
        Some(vec![turned(rest, area_vector(mesh, facets, x), area_turned(mesh, facets, x, dx)), chord])
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

/// Change of ∫ n dA \[m²\] with the motion dx: the cross product of the tangents is linear in each.
fn area_turned(mesh: &TetMesh, facets: &[u32], x: &[f64], dx: &[f64]) -> Vec3 {
    let rule = quadrature::tri(2);
    let mut sum = Vec3::zeros();
    for &f in facets {
        for (&xi, w) in rule.points.iter().zip(&rule.weights) {
            let gradients = element::facet_gradients(mesh.order, xi);
            let [mut a, mut b, mut da, mut db] = [Vec3::zeros(); 4];
            for (&k, g) in mesh.facet(f as usize).iter().zip(gradients) {
                let at = |v: &[f64]| Vec3::from_column_slice(&v[3 * k as usize..][..3]);
                let (p, dp) = (mesh.points[k as usize] + at(x), at(dx));
                a += p * g[0];
                b += p * g[1];
                da += dp * g[0];
                db += dp * g[1];
            }
            sum += (da.cross(&b) + a.cross(&db)) * *w;
        }
    }
    sum
}

/// Angle between two directions \[deg\], 0 to 180.
fn angle(a: Vec3, b: Vec3) -> f64 {
    a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
}

/// Change of the angle between a fixed a and b \[deg\] with db: dϑ = \[(a·b) d|a × b| − |a × b| a·db\]/(|a|²|b|²),
/// d|a × b| = (a × b)·(a × db)/|a × b|.
fn turned(a: Vec3, b: Vec3, db: Vec3) -> f64 {
    let cross = a.cross(&b);
    let (sine, along) = (cross.norm(), a.cross(&db));
    // Where a and b are parallel the angle grows whatever the direction.
    let rate = if sine > 0.0 { cross.dot(&along) / sine } else { along.norm() };
    ((a.dot(&b) * rate - sine * a.dot(&db)) / (a.norm_squared() * b.norm_squared())).to_degrees()
}
