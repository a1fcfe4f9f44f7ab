//! Measured values from marker tracks: positions, displacements, frequency and decay, with the errors that the tracks themselves show.
//!
//! | Term | From |
//! |---|---|
//! | noise | 95 % interval of the mean of a plateau, or of the fitted frequency and decay, over 1.96 |
//! | plateau drift | change over the plateau/√12: a level that is anywhere within it (JCGM 100:2008, 4.3.7) |
//! | registration | six errors of the rigid motion, which all values of a file share: δy = ω × (y − ȳ) + τ |
//!
//! A drift counts if its interval does not contain zero. Values of several files are repeats; registrations are independent between files. Limit: the
//! effect of a registration on frequency and decay, which is of second order in ω, is neglected.

use crate::math::tensor::{Mat3, Vec3};
use crate::math::units;
use crate::motion::plateau::{Plateau, PlateauRule};
use crate::motion::registration::Registration;
use crate::motion::repeats::check_distinct;
use crate::motion::ring_down::{Creep, RingDown, ring_down};
use crate::motion::{EvaluatedCurve, MotionError, MotionRequest, evaluate};
use crate::scene::in_unit_of;
use crate::study::kinds::validation::budget::COVERAGE;
use crate::study::kinds::validation::plan::{ErrorPlan, TracksPlan};
use crate::study::kinds::validation::spec::{Evaluation, QuantitySpec, TracksSpec};
use crate::study::kinds::validation::tracks_request::{TracksError, request};
use std::path::Path;

/// One evaluated file.
struct File {
    name: String,
    evaluation: crate::motion::Evaluation,
}

/// The evaluated tracks of a record, one file per repeat.
pub struct RecordTracks {
    files: Vec<File>,
}

/// A value of one file with its errors \[unit of the curve\].
struct Reading {
    value: f64,
    noise: f64,
    drift: f64,
    /// Effect of each of the six errors of its registration, in standard deviations
    registration: [f64; 6],
}

impl RecordTracks {
    /// Reads and evaluates the files of a record, which are given relative to `base`; `curves` are measured in them, and their markers tell the states.
    pub fn read(base: &Path, spec: &TracksSpec, curves: &[&String]) -> Result<Self, TracksError> {
        let marker = |curve: &&String| Some(curve.strip_suffix("_m")?.rsplit_once('_')?.0.to_string());
        let guides = curves.iter().filter_map(marker).collect();
        let request = MotionRequest { guides, ..request(base, spec)? };
        if spec.files.is_empty() {
            return Err(TracksError::NoFile);
        }
        let one = |file: &std::path::PathBuf| {
            let name = file.display().to_string();
            let evaluation = evaluate(&MotionRequest { file: base.join(file), ..request.clone() })
                .map_err(|source| TracksError::Motion { file: name.clone(), source })?;
            Ok(File { name, evaluation })
        };
        let files: Vec<File> = spec.files.iter().map(one).collect::<Result<_, _>>()?;
        let named: Vec<_> = files.iter().map(|f| (f.name.clone(), &f.evaluation.tracks)).collect();
        check_distinct(&named).map_err(TracksError::Repeats)?;
        Ok(Self { files })
    }

    /// Returns the audit of every file of a record.
    pub fn plans(&self, record: &str) -> Vec<TracksPlan> {
        let one = |f: &File| TracksPlan {
            record: record.into(),
            file: f.name.clone(),
            sha256: f.evaluation.tracks.sha256.clone(),
            log: f.evaluation.log.clone(),
            doubts: f.evaluation.doubts.clone(),
        };
        self.files.iter().map(one).collect()
    }

    /// Returns the values of a curve, one per file, and their errors in the unit of the quantity. `window` is the window of a ring-down, counted from
    /// the release \[s\].
    pub fn quantity(
        &self,
        curve: &str,
        q: &QuantitySpec,
        window: Option<[f64; 2]>,
    ) -> Result<(Vec<f64>, Vec<ErrorPlan>), TracksError> {
        let rings = matches!(q.value, Evaluation::Frequency | Evaluation::Decay);
        let of_curve = || in_unit_of(curve, &format!("1 {}", q.unit).as_str().into()).map(|own| 1.0 / own);
        let factor = if rings { units::in_unit("1 Hz", &q.unit) } else { of_curve() };
        let unit = |e: units::UnitError| TracksError::Unit { curve: curve.into(), why: e.to_string() };
        let factor = q.times * factor.map_err(unit)?;
        let readings = self.files.iter().map(|f| f.reading(curve, q.value, window)).collect::<Result<Vec<_>, _>>()?;
        let n = readings.len() as f64;
        let names: Vec<&str> = self.files.iter().map(|f| f.name.as_str()).collect();
        let error = |group: &str, deviation: f64, source: String, shared| ErrorPlan {
            group: group.into(),
            deviation,
            source,
            shared,
        };
        let noise = readings.iter().map(|r| r.noise.powi(2)).sum::<f64>().sqrt() / n;
        let drift = readings.iter().map(|r| r.drift).sum::<f64>() / n;
        let files = names.join(", ");
        let mut errors = vec![
            error("noise of the tracks", factor.abs() * noise, format!("interval of the mean in {files}"), None),
            error("plateau drift", factor.abs() * drift, format!("change over the plateau in {files}"), None),
        ];
        for (reading, file) in readings.iter().zip(&names) {
            for (k, amount) in reading.registration.iter().enumerate() {
                let source = format!("residuals of the registration of {file}");
                errors.push(error("registration", factor * amount / n, source, Some(format!("{file} {}", k + 1))));
            }
        }
        errors.retain(|e| e.deviation != 0.0);
        Ok((readings.iter().map(|r| factor * r.value).collect(), errors))
    }
}

impl File {
    fn reading(&self, curve: &str, value: Evaluation, window: Option<[f64; 2]>) -> Result<Reading, TracksError> {
        let curves = &self.evaluation.curves;
        let known = || curves.iter().map(|c| c.curve.name.clone()).collect();
        let absent = || self.motion(MotionError::NoCurve { asked: curve.into(), known: known() });
        let at = curves.iter().position(|c| c.curve.name == curve).ok_or_else(absent)?;
        match value {
            Evaluation::Final => self.level(at, false),
            Evaluation::Change => self.level(at, true),
            Evaluation::Frequency => self.ringing(&curves[at], window, |r| r.frequency_hz),
            Evaluation::Decay => self.ringing(&curves[at], window, |r| r.decay_per_s),
        }
    }

    fn motion(&self, source: MotionError) -> TracksError {
        TracksError::Motion { file: self.name.clone(), source }
    }

    /// The final level of a curve, or its change from the held level.
    fn level(&self, at: usize, is_change: bool) -> Result<Reading, TracksError> {
        let c = &self.evaluation.curves[at];
        let value = if is_change { "change" } else { "final" };
        let missing =
            |state| TracksError::NoState { file: self.name.clone(), curve: c.curve.name.clone(), state, value };
        let last = c.last.as_ref().ok_or_else(|| missing("final"))?;
        let mut drift = self.drift(c, last, "final")?;
        // Without a held state a body would be measured from its final state, in which it has not moved
        if !self.evaluation.poses.is_empty() && c.held.is_none() {
            return Err(missing("held"));
        }
        let mean = if is_change {
            let held = c.held.as_ref().ok_or_else(|| missing("held"))?;
            drift = drift.hypot(self.drift(c, held, "held")?);
            c.change.ok_or_else(|| missing("held"))?
        } else {
            last.mean
        };
        let registration = self.evaluation.registration.as_ref().map_or([0.0; 6], |r| self.carried(r, at, is_change));
        Ok(Reading { value: mean.value, noise: mean.half_width() / COVERAGE, drift, registration })
    }

    /// The error of a level due to its drift; refused if the curve does not come to rest.
    fn drift(&self, c: &EvaluatedCurve, plateau: &Plateau, state: &'static str) -> Result<f64, TracksError> {
        let tolerance = PlateauRule::default().tolerance_of(&c.curve);
        let (file, curve) = (self.name.clone(), c.curve.name.clone());
        if plateau.deviation > tolerance {
            return Err(TracksError::Moves { file, curve, state, deviation: plateau.deviation, limit: tolerance });
        }
        if plateau.doubt().is_none() {
            return Ok(0.0);
        }
        let [from, to] = plateau.window_s;
        let (change, limit) = ((plateau.drift.value * (to - from)).abs(), 2.0 * tolerance);
        if change > limit {
            return Err(TracksError::Drifts { file, curve, state, change, duration_s: to - from, limit });
        }
        Ok(change / 12_f64.sqrt())
    }

    /// Changes of a level by one standard deviation of each independent error of the registration, widened from Student's t to a normal distribution.
    fn carried(&self, r: &Registration, at: usize, is_change: bool) -> [f64; 6] {
        // Curves come in triples of x, y and z: positions of a marker, or displacements or rotations of a body
        let (first, axis) = (at - at % 3, at % 3);
        let level = |k: usize| {
            let c = &self.evaluation.curves[first + k];
            let change = c.change.as_ref().filter(|_| is_change).map(|b| b.value);
            change.or_else(|| c.last.as_ref().map(|l| l.mean.value)).unwrap_or(0.0)
        };
        let is_position = !is_change && self.evaluation.poses.is_empty();
        let arm = Vec3::from_fn(|k, _| level(k)) - if is_position { r.centre } else { Vec3::zeros() };
        let by_turn = -arm.cross_matrix();
        let by_shift = if is_position { Mat3::identity() } else { Mat3::zeros() };
        let root = |k: usize| {
            let own: Mat3 = r.covariance.fixed_view::<3, 3>(k, k).into_owned();
            own.cholesky().map_or_else(Mat3::zeros, |c| c.l()) * (r.quantile() / COVERAGE)
        };
        let (turn, shift) = (by_turn * root(0), by_shift * root(3));
        std::array::from_fn(|k| if k < 3 { turn[(axis, k)] } else { shift[(axis, k - 3)] })
    }

    fn ringing(
        &self,
        c: &EvaluatedCurve,
        window: Option<[f64; 2]>,
        of: fn(&RingDown) -> crate::calibrate::Bounded,
    ) -> Result<Reading, TracksError> {
        let release = self.evaluation.release.as_ref();
        let origin = release.ok_or_else(|| TracksError::NoRelease { file: self.name.clone() })?.time_s;
        let window = window.unwrap_or_default().map(|t| origin + t);
        let found = of(&ring_down(&c.curve, window, origin, Creep::default()).map_err(|e| self.motion(e))?);
        Ok(Reading { value: found.value, noise: found.half_width() / COVERAGE, drift: 0.0, registration: [0.0; 6] })
    }
}
