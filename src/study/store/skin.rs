//! The boundary of a body at the peak of the protocol, for pictures.

use crate::storage;
use serde::{Deserialize, Serialize};
use std::io::Write;

/// Boundary of the body in the reference state and at the peak of the protocol, for pictures: `cases/<id>.skin.json.gz`. Numbers are stored with five
/// digits relative to the largest one, far below the resolution of print.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct Skin {
    /// \[nodes\] Reference positions \[m\]
    pub points: Vec<[f64; 3]>,
    /// \[triangles\] Corner nodes, oriented outwards
    pub triangles: Vec<[u32; 3]>,
    /// \[triangles\] Mid-nodes of the sides, if the body is curved at rest
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub middles: Vec<[u32; 3]>,
    /// Time of the state below \[s\]
    pub t_s: f64,
    /// \[nodes\] Displacement \[m\]
    pub displacement: Vec<[f64; 3]>,
    /// \[nodes\] Largest principal stretch, volume-weighted mean over the cells at the node \[–\]
    pub stretch: Vec<f64>,
    /// Polyline of each cable at that time \[m\], pull point first
    pub cables: Vec<Vec<[f64; 3]>>,
    /// Rigid bodies and obstacles at that time
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigids: Vec<Rigid>,
}

/// A rigid body or an obstacle.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct Rigid {
    /// \[vertices\] Positions \[m\]
    pub points: Vec<[f64; 3]>,
    /// \[triangles\] Corners, oriented outwards
    pub triangles: Vec<[u32; 3]>,
}

impl Skin {
    /// The nodes of each facet: three corners, and three mid-nodes if the body is curved at rest.
    pub fn facets(&self) -> Vec<Vec<u32>> {
        let middles = |k: usize| self.middles.get(k).map_or(&[][..], |middles| middles);
        self.triangles.iter().enumerate().map(|(k, corners)| [corners, middles(k)].concat()).collect()
    }

    /// The skin as gzipped JSON; equal skins give equal bytes.
    pub fn packed(&self) -> Vec<u8> {
        let grid = |values: &[Vec<f64>]| {
            let largest = values.iter().flatten().filter(|v| v.is_finite()).fold(0.0f64, |m, v| m.max(v.abs()));
            if largest > 0.0 { (5.0 - largest.log10().ceil()).clamp(0.0, 15.0) as usize } else { 0 }
        };
        let rows = |v: &[[f64; 3]]| v.iter().map(|x| x.to_vec()).collect::<Vec<_>>();
        // Lengths share one number of decimals, so that the shapes fit together
        let decimals = grid(&rows(&self.points)).max(grid(&rows(&self.displacement)));
        let round = |v: f64, n: usize| format!("{v:.n$}").parse().unwrap_or(v);
        let points = |v: &[[f64; 3]]| v.iter().map(|x| x.map(|c| round(c, decimals))).collect::<Vec<_>>();
        let skin = Self {
            points: points(&self.points),
            triangles: self.triangles.clone(),
            middles: self.middles.clone(),
            t_s: self.t_s,
            displacement: points(&self.displacement),
            stretch: self.stretch.iter().map(|s| round(*s, 5)).collect(),
            cables: self.cables.iter().map(|c| points(c)).collect(),
            rigids: (self.rigids.iter())
                .map(|r| Rigid { points: points(&r.points), triangles: r.triangles.clone() })
                .collect(),
        };
        let json = serde_json::to_vec(&skin).expect("numbers and string keys only");
        let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        let all = out.write_all(&json).and_then(|()| out.finish());
        all.expect("memory accepts every write")
    }

    /// Reads the output of [`Skin::packed`], or plain JSON.
    pub fn unpacked(bytes: &[u8]) -> Result<Self, serde_json::Error> {
        if storage::is_packed(bytes) {
            serde_json::from_slice(&storage::unpacked(bytes).map_err(serde_json::Error::io)?)
        } else {
            serde_json::from_slice(bytes)
        }
    }
}
