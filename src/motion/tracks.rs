//! Tracks of markers over time, read from a file, in SI units.

use super::error::MotionError;
use super::track::{Raw, ReadOptions, Track};
use super::{c3d, table, trc};
use crate::calibrate::intake::names;
use crate::math::statistics::{extent, median};
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::storage::{self, DATA_LIMIT};
use crate::wording::count;
use std::path::{Path, PathBuf};

/// Largest plausible coordinate of a tracked body \[m\]; millimetres read as metres exceed it
pub const LARGEST: f64 = 50.0;
/// Smallest plausible extent of the coordinates of a file \[m\]
pub const SMALLEST: f64 = 1e-6;

/// Tracks of the markers of one record.
#[derive(Clone, Debug, PartialEq)]
pub struct Tracks {
    /// Name of the file
    pub source: String,
    /// SHA-256 of the file, hexadecimal
    pub sha256: String,
    pub time_s: Vec<f64>,
    /// Number of samples averaged in each row
    pub samples: Vec<f64>,
    pub markers: Vec<Track>,
    /// Decisions and facts from reading the file, in sentences
    pub log: Vec<String>,
}

impl Tracks {
    /// Reads a C3D or TRC file or a table. The format is determined by the content, not by the file extension.
    ///
    /// # Errors
    /// A file that is damaged or has no markers, no unit (and none in `options`), or coordinates of an impossible size.
    pub fn read(path: &Path, options: &ReadOptions) -> Result<Self, MotionError> {
        let bytes =
            storage::read(path, DATA_LIMIT).map_err(|source| MotionError::Read { path: path.into(), source })?;
        let file = path.file_name().map_or_else(|| path.into(), PathBuf::from).display().to_string();
        Self::parse(&file, &bytes, options)
    }

    /// Reads the bytes of a file with this name.
    ///
    /// # Errors
    /// The errors of [`Tracks::read`].
    pub fn parse(file: &str, bytes: &[u8], options: &ReadOptions) -> Result<Self, MotionError> {
        let raw = if c3d::is_c3d(bytes) {
            only_of_tables(file, options)?;
            c3d::read(file, bytes, options)?
        } else if trc::is_trc(bytes) {
            only_of_tables(file, options)?;
            trc::read(file, bytes, options)?
        } else {
            table::read(file, bytes, options)?
        };
        let Raw { format, unit, time_s, samples, mut markers, mut log } = raw;
        if markers.is_empty() || time_s.is_empty() {
            return Err(MotionError::NoMarkers { file: file.into() });
        }
        if let (Some(asked), Some(own)) = (&options.unit, &unit)
            && asked != own
        {
            log.push(format!("the unit is {asked} as requested, the file says {own}"));
        }
        let unit = options.unit.clone().or(unit).ok_or_else(|| MotionError::NoUnit { file: file.into() })?;
        let factor = length_factor(file, &unit)?;
        for point in markers.iter_mut().flat_map(|m| m.points.iter_mut()).flatten() {
            *point = point.map(|x| factor * x);
        }
        log.insert(0, intake(format, &unit, &time_s, &markers));
        check_size(file, &markers)?;
        check_zeros(file, &markers)?;
        log.extend(gaps(&markers));
        Ok(Self { source: file.into(), sha256: storage::sha256(bytes), time_s, samples, markers, log })
    }

    /// Returns the markers with these names, in this order.
    ///
    /// # Errors
    /// Some names do not exist; the error lists all of them.
    pub fn select(&self, names: &[String]) -> Result<Vec<&Track>, MotionError> {
        let find = |name: &String| self.markers.iter().find(|m| m.name == *name);
        let absent: Vec<String> = names.iter().filter(|n| find(n).is_none()).cloned().collect();
        if absent.is_empty() {
            return Ok(names.iter().filter_map(find).collect());
        }
        Err(MotionError::UnknownMarkers { asked: absent, known: self.markers.iter().map(|m| m.name.clone()).collect() })
    }

    /// Returns the mean position of each named marker over times `from` to `to` \[s\], weighted by the samples of the rows; `None` for a marker that
    /// is not visible there.
    ///
    /// # Errors
    /// Some names do not exist; the error lists all of them.
    pub fn mean(&self, names: &[String], [from, to]: [f64; 2]) -> Result<Vec<Option<[f64; 3]>>, MotionError> {
        let one = |track: &Track| {
            let rows = (0..self.time_s.len()).filter(|k| (from..=to).contains(&self.time_s[*k]));
            let seen: Vec<(f64, [f64; 3])> =
                rows.filter_map(|k| track.points[k].map(|p| (self.samples[k], p))).collect();
            let weight: f64 = seen.iter().map(|s| s.0).sum();
            (weight > 0.0).then(|| [0, 1, 2].map(|i| seen.iter().map(|(w, p)| w * p[i]).sum::<f64>() / weight))
        };
        Ok(self.select(names)?.into_iter().map(one).collect())
    }
}

/// Refuses options of tables for a file of another format.
fn only_of_tables(file: &str, options: &ReadOptions) -> Result<(), MotionError> {
    let refuse = |option, fact| Err(MotionError::Unused { file: file.into(), option, fact });
    if options.record.is_some() {
        return refuse("--record", "C3D and TRC files hold one record");
    }
    if options.time_unit.is_some() {
        return refuse("--time-unit", "times of C3D and TRC files are in seconds");
    }
    Ok(())
}

/// Returns the factor to metres of a unit in the spellings that programs use.
fn length_factor(file: &str, unit: &str) -> Result<f64, MotionError> {
    let plain = match unit.trim().to_lowercase().as_str() {
        "millimeters" | "millimetres" | "millimeter" | "millimetre" => "mm".to_string(),
        "centimeters" | "centimetres" | "centimeter" | "centimetre" => "cm".to_string(),
        "meters" | "metres" | "meter" | "metre" => "m".to_string(),
        "inches" => "in".to_string(),
        lower @ ("mm" | "cm" | "m") => lower.to_string(),
        _ => unit.trim().to_string(),
    };
    let refused = || MotionError::Unit { file: file.into(), unit: unit.into(), of: "length", example: "mm" };
    names::factor(&plain, Dimension::LENGTH).ok_or_else(refused)
}

/// A line on the format, the unit, the times and the markers.
fn intake(format: &str, unit: &str, time_s: &[f64], markers: &[Track]) -> String {
    let names: Vec<&str> = markers.iter().map(|m| m.name.as_str()).collect();
    let span = match time_s {
        [first, .., last] => {
            let steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
            let median = median(&steps);
            let uneven = if steps.iter().any(|s| (s - median).abs() > 0.01 * median) { ", uneven steps" } else { "" };
            format!("{first} s to {last} s, {:.6} Hz{uneven}", 1.0 / median)
        }
        _ => "one time".into(),
    };
    let (rows, markers) = (count(time_s.len(), "row"), count(names.len(), "marker"));
    format!("{format}, coordinates in {unit}; {rows}, {span}; {markers}: {}", names.join(", "))
}

/// Refuses coordinates of an impossible size.
fn check_size(file: &str, markers: &[Track]) -> Result<(), MotionError> {
    let sizes = || {
        markers.iter().flat_map(|m| m.points.iter().flatten()).map(|p| p.iter().fold(0.0, |a: f64, x| a.max(x.abs())))
    };
    let largest_m = sizes().fold(0.0, f64::max);
    let samples = sizes().filter(|s| *s > LARGEST).count();
    if samples > 0 {
        return Err(MotionError::Large { file: file.into(), largest_m, samples, limit_m: LARGEST });
    }
    if sizes().next().is_some() && largest_m < SMALLEST {
        return Err(MotionError::Small { file: file.into(), largest_m, limit_m: SMALLEST });
    }
    Ok(())
}

/// Refuses zeros in place of gaps: a marker that is exactly at the origin in some rows, with steps there that are all longer than any other of its
/// steps.
fn check_zeros(file: &str, markers: &[Track]) -> Result<(), MotionError> {
    for Track { name, points } in markers {
        let seen: Vec<Vec3> = points.iter().flatten().copied().map(Vec3::from).collect();
        let found = seen.iter().filter(|p| **p == Vec3::zeros()).count();
        let (jumps, steps): (Vec<_>, Vec<_>) =
            seen.windows(2).partition(|w| (w[0] == Vec3::zeros()) != (w[1] == Vec3::zeros()));
        let lengths = |of: &[&[Vec3]]| extent(of.iter().map(|w| (w[1] - w[0]).norm()));
        let ([shortest, _], [_, longest]) = (lengths(&jumps), lengths(&steps));
        if !jumps.is_empty() && steps.len() > jumps.len() && shortest > longest {
            return Err(MotionError::Zeros { file: file.into(), name: name.clone(), found, rows: points.len() });
        }
    }
    Ok(())
}

/// Lines on markers that are not always visible; gaps are not filled.
fn gaps(markers: &[Track]) -> Vec<String> {
    let one = |m: &Track| {
        let missing = m.points.iter().filter(|p| p.is_none()).count();
        let inner = m.points.windows(2).filter(|w| w[0].is_some() && w[1].is_none()).count();
        let all = m.points.len();
        (missing > 0).then(|| {
            format!(
                "marker {} is not seen in {missing} of {all} rows ({inner} gaps after it was seen); none is filled",
                m.name
            )
        })
    };
    markers.iter().filter_map(one).collect()
}
