//! Measured tracks of markers laid over recorded points, and the distances between them.
//!
//! The distance at a measured time within the run is |x − m|, with the recorded position x interpolated linearly. Its root mean square and its maximum
//! are taken over all rows in which the marker is seen.

use crate::motion::{MotionError, MotionRequest, ReadOptions, Tracks, evaluate};
use crate::scene::{MeasuredTracks, Run, Scene};
use crate::study::curve::Curve;
use crate::study::overlay::distance::MarkerDistance;
use std::collections::BTreeMap;

/// Reason why tracks are not compared.
#[derive(Debug, thiserror::Error)]
#[error("compare.markers {file}: {source}")]
pub struct MarkersError {
    file: String,
    source: Box<MotionError>,
}

/// A marker and its recorded point over the time of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    pub marker: String,
    /// \[rows\] Times \[s\] and positions \[m\] of the marker in the rows where it is seen
    pub measured: Vec<(f64, [f64; 3])>,
    /// Coordinates x, y and z of the recorded point \[m\]
    pub simulated: [Curve; 3],
    /// `None` if no row is within the run
    pub distance: Option<MarkerDistance>,
}

/// All markers of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerOverlay {
    pub source: String,
    pub pairs: Vec<Pair>,
    /// Note on where the run starts in the tracks
    pub note: Option<String>,
}

/// Tracks relative to the start of the run.
#[derive(Clone, Debug)]
pub struct Timed {
    tracks: Tracks,
    note: Option<String>,
}

/// Reads all tracks with which the scene is compared, relative to the start of the run.
///
/// # Errors
/// Tracks that cannot be read or registered, or that lack a named marker.
pub fn read(scene: &Scene) -> Result<Vec<Timed>, MarkersError> {
    scene
        .measured
        .tracks
        .iter()
        .map(|t| one(t).map_err(|e| MarkersError { file: t.source.clone(), source: e.into() }))
        .collect()
}

fn one(t: &MeasuredTracks) -> Result<Timed, MotionError> {
    let request = MotionRequest {
        file: t.path.clone(),
        read: ReadOptions { unit: t.unit.clone(), record: t.record.clone(), ..ReadOptions::default() },
        guides: t.points.iter().map(|(marker, _)| marker.clone()).collect(),
        reference: t.reference.clone(),
        held_s: t.held_s,
        ..MotionRequest::default()
    };
    let found = evaluate(&request)?;
    let mut tracks = found.tracks;
    let names: Vec<String> = t.points.iter().map(|(marker, _)| marker.clone()).collect();
    tracks.select(&names)?;
    let first = tracks.time_s.first().copied().unwrap_or(0.0);
    let known = t.start_s.or(found.release.map(|r| r.time_s));
    let start = known.unwrap_or(first);
    tracks.time_s.iter_mut().for_each(|t| *t -= start);
    let note = known.is_none().then(|| {
        format!(
            "no release is found in {}: the run is compared from its first time on, {first} s; state `start`, or the window `held`",
            t.source
        )
    });
    Ok(Timed { tracks, note })
}

/// The overlays that the scene requests.
///
/// # Errors
/// The errors of [`read`].
pub fn overlays(scene: &Scene, run: &Run) -> Result<Vec<MarkerOverlay>, MarkersError> {
    let column = |name: String| Curve {
        t: run.column("t_s").unwrap_or_default(),
        f: run.column(&name).expect("checked when the scene was built"),
    };
    let overlay = |(t, Timed { tracks, note }): (&MeasuredTracks, Timed)| {
        let by_name: BTreeMap<&str, _> = tracks.markers.iter().map(|m| (m.name.as_str(), &m.points)).collect();
        let pair = |(marker, point): &(String, String)| {
            let rows = tracks.time_s.iter().zip(by_name[marker.as_str()]);
            let measured: Vec<(f64, [f64; 3])> = rows.filter_map(|(t, p)| Some((*t, (*p)?))).collect();
            let simulated = ["x", "y", "z"].map(|axis| column(format!("{point}_{axis}_m")));
            let distance = distance((marker, point, &t.source), &measured, &simulated);
            Pair { marker: marker.clone(), measured, simulated, distance }
        };
        MarkerOverlay { source: t.source.clone(), pairs: t.points.iter().map(pair).collect(), note }
    };
    Ok(scene.measured.tracks.iter().zip(read(scene)?).map(overlay).collect())
}

fn distance(
    (marker, point, file): (&str, &str, &str),
    measured: &[(f64, [f64; 3])],
    simulated: &[Curve; 3],
) -> Option<MarkerDistance> {
    let (first, last) = (*simulated[0].t.first()?, *simulated[0].t.last()?);
    let slack = 1e-9 * last.abs();
    let within = measured.iter().filter(|(t, _)| *t >= first - slack && *t <= last + slack);
    let off = |(t, m): &(f64, [f64; 3])| {
        let squares: f64 = simulated.iter().zip(m).map(|(c, m)| (c.at(*t) - m).powi(2)).sum();
        (*t, squares.sqrt())
    };
    let all: Vec<(f64, f64)> = if simulated[0].t.len() < 2 { vec![] } else { within.map(off).collect() };
    let largest = all.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    Some(MarkerDistance {
        marker: marker.into(),
        point: point.into(),
        file: file.into(),
        rows: all.len(),
        from_s: all.first()?.0,
        to_s: all.last()?.0,
        rms_m: (all.iter().map(|(_, d)| d * d).sum::<f64>() / all.len() as f64).sqrt(),
        largest_m: largest.1,
        largest_at_s: largest.0,
    })
}

/// The distance in words: `tip1 of tracks.csv is off tip_1 by 0.520 mm (rms), 1.300 mm at 0.310 s (largest), over 40 rows`.
pub fn words(d: &MarkerDistance) -> String {
    let [rms, largest] = [d.rms_m, d.largest_m].map(|v| 1e3 * v);
    format!(
        "{} of {} is off {} by {rms:.3} mm (rms), {largest:.3} mm at {:.3} s (largest), over {} rows",
        d.marker, d.file, d.point, d.largest_at_s, d.rows
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point that moves along x at 2 m/s, and a marker 3 mm away from it in y and, in one row, also 4 mm in z: distances 3 mm and 5 mm. Rows outside
    /// the run do not count.
    #[test]
    fn distances_of_a_straight_motion() {
        let curve = |f: [f64; 2]| Curve { t: vec![0.0, 1.0], f: f.to_vec() };
        let simulated = [curve([0.0, 2.0]), curve([0.0, 0.0]), curve([0.0, 0.0])];
        let measured = [(-0.5, [9.0; 3]), (0.25, [0.5, 0.003, 0.0]), (0.5, [1.0, -0.003, 0.004]), (1.5, [9.0; 3])];
        let d = distance(("m", "p", "f"), &measured, &simulated).expect("two rows");
        assert_eq!((d.rows, d.from_s, d.to_s, d.largest_at_s), (2, 0.25, 0.5, 0.5));
        assert!((d.largest_m - 0.005).abs() < 1e-15 && (d.rms_m - 17e-6_f64.sqrt()).abs() < 1e-15, "{d:?}");
        assert_eq!(distance(("m", "p", "f"), &measured[..1], &simulated), None);
    }
}
