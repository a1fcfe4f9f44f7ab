//! C3D files: the positions of labelled points; analog channels are skipped.
//!
//! Source: The C3D File Format User Guide, Motion Lab Systems (2021): header, parameters, and point data as scaled integers or floats in the byte
//! order of Intel, DEC or MIPS processors.

mod bytes;
mod layout;
mod parameters;

use super::error::MotionError;
use super::track::{Raw, ReadOptions, Track};
use crate::wording::numbered;
use bytes::Order;
use layout::Layout;
use std::collections::BTreeMap;

/// Whether a file begins as a C3D file: the second byte is 0x50, and the first one is not a text character, or is the offset of parameters that name
/// a processor.
pub fn is_c3d(file: &[u8]) -> bool {
    let [block, 0x50, ..] = *file else { return false };
    let pointed = (usize::from(block).max(1) - 1) * bytes::BLOCK;
    let has_processor = file.get(pointed + 3).is_some_and(|code| Order::of(*code).is_some());
    file.len() > bytes::BLOCK && (has_processor || (block < b' ' && !block.is_ascii_whitespace()))
}

/// Reads the bytes of a C3D file.
pub fn read(file: &str, bytes: &[u8], options: &ReadOptions) -> Result<Raw, MotionError> {
    let damaged = |what: String| MotionError::Damaged { file: file.into(), what };
    let layout = Layout::read(bytes).map_err(damaged)?;
    let (labels, renamed) = distinct(&layout.labels());
    let rate = options.rate_hz.unwrap_or(layout.rate);
    if !(rate > 0.0 && rate.is_finite()) {
        return Err(MotionError::Rate { file: file.into(), rate });
    }
    let data = bytes.get(layout.start..).unwrap_or_default();
    let found = data.len().checked_div(layout.frame_bytes()).unwrap_or(0);
    let told = layout.frames.unwrap_or(found);
    if found < told {
        return Err(MotionError::Truncated { file: file.into(), told, markers: layout.points, found });
    }
    let mut markers: Vec<Track> = labels.into_iter().map(|name| Track { name, points: vec![] }).collect();
    let mut zeros = 0;
    for frame in data.chunks_exact(layout.frame_bytes().max(1)).take(told) {
        for (k, marker) in markers.iter_mut().enumerate() {
            let point = layout.point(frame, k);
            zeros += usize::from(point == Some([0.0; 3]));
            marker.points.push(point.filter(|p| *p != [0.0; 3]));
        }
    }
    let mut log = vec![layout.words()];
    log.extend(renamed);
    if zeros > 0 {
        log.push(format!("{zeros} points exactly at the origin are taken as not seen"));
    }
    let first = layout.first_frame.max(1) - 1;
    let time_s = (0..told).map(|k| (first + k) as f64 / rate).collect();
    Ok(Raw { format: "C3D", unit: layout.unit, time_s, samples: vec![1.0; told], markers, log })
}

/// Returns the labels made distinct, with a 2 after the second occurrence of a name and so on, and a line on each name that occurs several times.
fn distinct(labels: &[String]) -> (Vec<String>, Vec<String>) {
    let found = numbered(labels, " ");
    let mut renamed = BTreeMap::<&String, Vec<String>>::new();
    for (label, name) in labels.iter().zip(&found).filter(|(label, name)| label != name) {
        renamed.entry(label).or_default().push(format!("\"{name}\""));
    }
    let line = |(label, names): (&String, Vec<String>)| {
        format!(
            "the label \"{label}\" occurs {} times; after the first the points are named {}",
            names.len() + 1,
            names.join(", ")
        )
    };
    let lines = renamed.into_iter().map(line).collect();
    (found, lines)
}
