//! Reads a triangulated surface: STL (binary or ASCII) and OBJ (convex faces with more than three corners become fans).
//!
//! Vertices of an STL at the same position are merged; there is no other cleaning, and the surface need not be closed.

use crate::math::tensor::Vec3;
use crate::mesh::error::MeshError;
use crate::mesh::geometry::bounds;
use crate::storage::{self, DATA_LIMIT};
use std::collections::HashMap;
use std::path::Path;

/// Vertices \[m\] and triangles of a surface.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Surface {
    pub points: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Corners of the bounding box of its vertices \[m\].
    pub fn bounds(&self) -> (Vec3, Vec3) {
        bounds(self.points.iter().copied())
    }

    /// Returns a third of the area of the triangles around each vertex \[m²\].
    pub fn areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.points.len()];
        for corners in &self.triangles {
            let [a, b, c] = corners.map(|k| self.points[k as usize]);
            let third = (b - a).cross(&(c - a)).norm() / 6.0;
            corners.iter().for_each(|&k| areas[k as usize] += third);
        }
        areas
    }
}

/// Reads a surface; `unit_m` is the length of one unit of the file in metres.
pub fn read_surface(path: &Path, unit_m: f64) -> Result<Surface, MeshError> {
    let unreadable = |e: std::io::Error| MeshError::Unreadable { file: path.into(), reason: e.to_string() };
    let data = storage::read(path, DATA_LIMIT).map_err(unreadable)?;
    let format = |fact: String| MeshError::Format {
        file: path.into(),
        fact,
        remedy: "give a triangulated surface as .stl or .obj".into(),
    };
    let mut surface = match path.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("stl") => stl(&data).map_err(format)?,
        Some("obj") => obj(&String::from_utf8_lossy(&data)).map_err(format)?,
        _ => return Err(format("this is no surface that is read".into())),
    };
    if surface.triangles.is_empty() {
        return Err(format("it holds no triangle".into()));
    }
    if let Some(k) = surface.points.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
        return Err(format(format!("vertex {} has a coordinate that is not finite", k + 1)));
    }
    surface.points.iter_mut().for_each(|p| *p *= unit_m);
    Ok(surface)
}

/// Reads an STL. Binary files have 84 + 50 n bytes, whatever their header, or some more if the file is not text.
fn stl(data: &[u8]) -> Result<Surface, String> {
    let count = data.get(80..84).map(|b| u32::from_le_bytes(b.try_into().expect("four bytes")) as usize);
    let is_text = data.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // Padding, not a triangle that the header does not count
    let is_padding = |rest: &[u8]| rest.len() < 50 || rest.iter().all(|byte| *byte == 0);
    let is_binary =
        |n: &usize| data.len() == 84 + 50 * n || !is_text && data.get(84 + 50 * n..).is_some_and(is_padding);
    let corners: Vec<[f32; 3]> = match count.filter(is_binary) {
        Some(n) => {
            let number = |b: &[u8]| f32::from_le_bytes(b.try_into().expect("four bytes"));
            // The normal is followed by three corners and two bytes
            let triangle = |t: &[u8]| [12, 24, 36].map(|at| [0, 4, 8].map(|k| number(&t[at + k..at + k + 4])));
            data[84..84 + 50 * n].chunks_exact(50).flat_map(triangle).collect()
        }
        None => {
            let text = String::from_utf8_lossy(data);
            let vertex = |line: &str| line.get(..6).is_some_and(|word| word.eq_ignore_ascii_case("vertex"));
            let lines = (1..).zip(text.lines().map(str::trim)).filter(|(_, line)| vertex(line));
            lines
                .map(|(n, line)| (n, &line[6..]))
                .map(|(n, rest)| three(rest).ok_or(format!("line {n} has no three coordinates")))
                .collect::<Result<_, _>>()?
        }
    };
    if !corners.len().is_multiple_of(3) {
        return Err(format!("{} corners are no whole number of triangles", corners.len()));
    }
    let (mut known, mut out) = (HashMap::new(), Surface::default());
    let index: Vec<u32> = (corners.iter())
        .map(|p| {
            // + 0: the two zeros are the same position
            *known.entry(p.map(|v| (v + 0.0).to_bits())).or_insert_with(|| {
                out.points.push(Vec3::from(p.map(f64::from)));
                out.points.len() as u32 - 1
            })
        })
        .collect();
    out.triangles = index.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    Ok(out)
}

fn three<T: std::str::FromStr>(text: &str) -> Option<[T; 3]> {
    let mut numbers = text.split_whitespace().map_while(|w| w.parse().ok());
    Some([numbers.next()?, numbers.next()?, numbers.next()?])
}

fn obj(text: &str) -> Result<Surface, String> {
    let mut out = Surface::default();
    for (n, line) in (1..).zip(text.lines()) {
        if let Some(rest) = line.strip_prefix("v ") {
            out.points.push(Vec3::from(three::<f64>(rest).ok_or(format!("line {n} has no three coordinates"))?));
        } else if let Some(rest) = line.strip_prefix("f ") {
            // `7/1/2`: vertex, texture, normal; a negative number counts from the last vertex
            let corner = |word: &str| {
                let k: i64 = word.split('/').next()?.parse().ok()?;
                let k = if k < 0 { out.points.len() as i64 + k } else { k - 1 };
                (0..out.points.len() as i64).contains(&k).then_some(k as u32)
            };
            let corners: Option<Vec<u32>> = rest.split_whitespace().map(corner).collect();
            let corners = corners.filter(|c| c.len() > 2).ok_or(format!("line {n} is no face of known vertices"))?;
            let fan: Vec<[u32; 3]> = corners[1..].windows(2).map(|w| [corners[0], w[0], w[1]]).collect();
            if turns(&out.points, &fan) {
                return Err(format!("the face of line {n} is concave or crosses itself: export it in triangles"));
            }
            out.triangles.extend(fan);
        }
    }
    Ok(out)
}

/// Whether a triangle of a fan is reversed, so that the fan does not represent the face.
fn turns(points: &[Vec3], fan: &[[u32; 3]]) -> bool {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|k| points[k as usize]);
        (b - a).cross(&(c - a))
    };
    // Not their sum, which is zero for a face that crosses itself in the middle
    let largest = fan.iter().map(area).max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    largest.is_some_and(|largest| fan.iter().any(|t| area(t).dot(&largest) < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An L-shaped face whose first corner sees the other corners, or does not.
    #[test]
    fn a_fan_is_the_face_or_is_refused() {
        let corners = ["0 0", "2 0", "2 1", "1 1", "1 2", "0 2"];
        let vertices: String = corners.iter().map(|xy| format!("v {xy} 0\n")).collect();
        let seen = obj(&format!("{vertices}f 4 5 6 1 2 3\n")).expect("every corner is seen from the inner one");
        assert!((seen.areas().iter().sum::<f64>() - 3.0).abs() < 1e-15);
        let why = obj(&format!("{vertices}f 2 3 4 5 6 1\n")).expect_err("a triangle is turned over");
        assert!(why.contains("line 7 is concave"), "{why}");
        let why = obj("v 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nf 1 2 3 4\n").expect_err("as much is turned over as is not");
        assert!(why.contains("line 5 is concave or crosses itself"), "{why}");
    }

    /// A unit square of two triangles has two triangles, four vertices and the area 1 in every format.
    #[test]
    fn the_formats_agree() {
        let corners =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, -0.0]];
        let mut binary = vec![0; 80];
        binary.extend(2u32.to_le_bytes());
        let mut ascii = "solid s\n".to_string();
        for t in corners.chunks(3) {
            binary.extend([0; 12]);
            t.iter().flatten().for_each(|v: &f32| binary.extend(v.to_le_bytes()));
            binary.extend([0; 2]);
            t.iter().for_each(|p| ascii += &format!("  vertex {} {} {}\n", p[0], p[1], p[2]));
        }
        let quad = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1 2/1/3 3 -1\n";
        let (padded, capitals) = ([&binary[..], b"pad."].concat(), ascii.to_uppercase());
        for surface in [stl(&binary), stl(&padded), stl(ascii.as_bytes()), stl(capitals.as_bytes()), obj(quad)] {
            let surface = surface.expect("a square");
            assert_eq!((surface.points.len(), surface.triangles.len()), (4, 2));
            assert!((surface.areas().iter().sum::<f64>() - 1.0).abs() < 1e-15);
        }
        assert!(obj("v 0 0 0\nf 1 2 3\n").expect_err("no such vertex").contains("line 2"));
        assert!(stl(b"solid\nvertex 1 2\n").expect_err("two coordinates").contains("line 2"));
    }
}
