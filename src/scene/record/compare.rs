//! Measured curves and tracks of markers in files, to be compared with recorded ones.

use super::measured_curve;
use super::measured_curve::{MeasuredColumnSpec, Wanted};
use crate::scene::build::builder::Builder;
use crate::scene::error::{SceneError, hint, part};
use crate::scene::text::quantity::Time;
use crate::schema::any_of;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Serialize, de};
use std::borrow::Cow;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// All comparisons of a scene: `[[compare]]` and `[[compare.markers]]`.
#[derive(Clone, Debug, Default)]
pub struct Comparisons {
    pub curves: Vec<CompareSpec>,
    pub markers: Vec<MarkersSpec>,
}

impl<'de> Deserialize<'de> for Comparisons {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ComparisonsVisitor)
    }
}

impl JsonSchema for Comparisons {
    fn schema_name() -> Cow<'static, str> {
        "Comparisons".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        any_of(&[generator.subschema_for::<Vec<CompareSpec>>(), generator.subschema_for::<OnlyMarkers>()])
    }
}

/// Reads a list of curves, the last of which may have `markers` below it, or a table with only `markers`, as TOML writes `[[compare.markers]]`.
struct ComparisonsVisitor;

/// Measured tracks of markers without a measured curve
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct OnlyMarkers {
    /// Measured tracks of markers, one entry for each file
    markers: Vec<MarkersSpec>,
}

impl<'de> Visitor<'de> for ComparisonsVisitor {
    type Value = Comparisons;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("[[compare]] or [[compare.markers]]")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut all: A) -> Result<Self::Value, A::Error> {
        let mut found = Comparisons::default();
        while let Some(mut curve) = all.next_element::<CompareSpec>()? {
            found.markers.append(&mut curve.markers);
            found.curves.push(curve);
        }
        Ok(found)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        let OnlyMarkers { markers } = OnlyMarkers::deserialize(de::value::MapAccessDeserializer::new(map))?;
        Ok(Comparisons { curves: vec![], markers })
    }
}

/// Measured tracks of markers.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MarkersSpec {
    /// Path of a C3D or TRC file or a table, relative to the scene
    pub file: PathBuf,
    /// Marker of the file → recorded point, such as `tip_1` for `tip_1_x_m`, `tip_1_y_m`, `tip_1_z_m`
    pub points: BTreeMap<String, String>,
    /// Unit of the coordinates; the one that the file states if absent
    pub unit: Option<String>,
    /// Record to be used from a table that holds several
    pub record: Option<String>,
    /// Table of marker positions in the frame of the scene, to which the held state is registered
    pub reference: Option<PathBuf>,
    /// Time window of the held state, in the time of the tracks; detected if absent
    pub held: Option<[Time; 2]>,
    /// Time of the tracks at which the run starts; if absent, the release, or otherwise the first time
    pub start: Option<Time>,
}

/// Tracks of markers to be compared with recorded points.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredTracks {
    pub path: PathBuf,
    /// File name as in the scene
    pub source: String,
    /// Pairs of a marker and a recorded point
    pub points: Vec<(String, String)>,
    pub unit: Option<String>,
    pub record: Option<String>,
    pub reference: Option<PathBuf>,
    /// Time window of the held state \[s\]
    pub held_s: Option<[f64; 2]>,
    pub start_s: Option<f64>,
}

/// A measured curve of a recorded column.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompareSpec {
    /// Recorded column that was measured
    pub column: String,
    /// Recorded column over which it was measured
    #[serde(default = "time")]
    pub over: String,
    /// Path of the file, relative to the scene
    pub file: PathBuf,
    /// Column of the file with the independent variable
    pub x: MeasuredColumnSpec,
    /// Column of the file with the measured values
    pub y: MeasuredColumnSpec,
    /// Column of the file with the half-widths of the 95 % intervals of the measured values
    pub uncertainty: Option<MeasuredColumnSpec>,
    /// `[[compare.markers]]` that follow it in the file
    #[serde(default)]
    pub markers: Vec<MarkersSpec>,
}

impl CompareSpec {
    fn columns_of_file(&self) -> String {
        let with_unit = |c: &MeasuredColumnSpec| match &c.unit {
            Some(unit) => format!("{} [{unit}]", c.column),
            None => c.column.clone(),
        };
        let width = self.uncertainty.as_ref().map_or(String::new(), |width| format!(" ± {}", with_unit(width)));
        format!("{}{width} over {}", with_unit(&self.y), with_unit(&self.x))
    }
}

fn time() -> String {
    "t_s".into()
}

/// A measured curve in the units of the recorded columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Recorded columns by name
    pub column: String,
    pub over: String,
    pub source: String,
    /// Columns of the file with the units that the scene states, `F [mN] ± U [mN] over angle [deg]`; empty in records of earlier versions of the program
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub columns: String,
    /// Independent variable \[samples\]
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// Half-widths of the 95 % intervals of y; empty if none were given
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub half_widths: Vec<f64>,
}

/// All measured data with which recorded columns are compared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeasuredData {
    pub curves: Vec<Measured>,
    pub tracks: Vec<MeasuredTracks>,
}

/// Reads the measured curves and tracks, which are compared with some of `columns`.
pub(in crate::scene) fn read_measured(
    builder: &Builder,
    specs: &Comparisons,
    columns: &[String],
) -> Result<MeasuredData, SceneError> {
    let curves = curves(builder, &specs.curves, columns)?;
    Ok(MeasuredData { curves, tracks: tracks(builder, &specs.markers, columns)? })
}

fn curves(builder: &Builder, specs: &[CompareSpec], columns: &[String]) -> Result<Vec<Measured>, SceneError> {
    let one = |(k, spec): (usize, &CompareSpec)| {
        let place = format!("compare {} ({})", k + 1, spec.column);
        for name in [&spec.column, &spec.over] {
            if !columns.contains(name) {
                let fact = format!("the scene records no \"{name}\"");
                return Err(builder.content(&place, fact, hint(name, columns)));
            }
        }
        let (x, y) = ((&spec.x, &spec.over, false), (&spec.y, &spec.column, false));
        let columns = [x, y].into_iter().chain(spec.uncertainty.as_ref().map(|width| (width, &spec.column, true)));
        let wanted = columns.map(|(column, recorded, is_width)| {
            Wanted::new(column, recorded, is_width).map_err(|e| part(builder.file, format!("{place}: {recorded}"), e))
        });
        let all = wanted.collect::<Result<Vec<_>, _>>()?;
        let path = builder.file.parent().unwrap_or(Path::new("")).join(&spec.file);
        let read = measured_curve::read(&path, &all).map_err(|e| part(builder.file, &place, e))?;
        let [x, y, half_widths] = std::array::from_fn(|k| read.get(k).cloned().unwrap_or_default());
        let (column, over, source) = (spec.column.clone(), spec.over.clone(), spec.file.display().to_string());
        Ok(Measured { column, over, source, columns: spec.columns_of_file(), x, y, half_widths })
    };
    specs.iter().enumerate().map(one).collect()
}

/// The tracks that are compared with points among `columns`. Their files are read when the scene runs.
fn tracks(builder: &Builder, specs: &[MarkersSpec], columns: &[String]) -> Result<Vec<MeasuredTracks>, SceneError> {
    let base = builder.file.parent().unwrap_or(Path::new(""));
    let one = |(k, spec): (usize, &MarkersSpec)| {
        let place = format!("compare.markers {} ({})", k + 1, spec.file.display());
        let parts = |point: &String| ["x", "y", "z"].map(|axis| format!("{point}_{axis}_m"));
        let is_recorded = |point: &String| parts(point).iter().all(|c| columns.contains(c));
        let absent: Vec<String> =
            spec.points.values().filter(|p| !is_recorded(p)).map(|p| format!("\"{p}\"")).collect();
        if !absent.is_empty() {
            let known: Vec<String> =
                columns.iter().filter_map(|c| c.strip_suffix("_x_m")).map(String::from).filter(is_recorded).collect();
            let fact = format!("the scene records no positions of {}", absent.join(", "));
            let remedy = "add a probe \"position\" or \"markers\", and name its columns without \"_x_m\"";
            let known = if known.is_empty() { String::new() } else { format!("; known are {}", known.join(", ")) };
            return Err(builder.content(&place, fact, format!("{remedy}{known}")));
        }
        if spec.points.is_empty() {
            return Err(builder.content(&place, "it names no points", "give points = { tip1 = \"tip_1\" }"));
        }
        if let Some([from, to]) = spec.held.filter(|[from, to]| from.0.partial_cmp(&to.0) != Some(Ordering::Less)) {
            let fact = format!("the held state ends at {} s, before it begins at {} s", to.0, from.0);
            return Err(builder.content(&place, fact, "exchange the times of `held`"));
        }
        Ok(MeasuredTracks {
            path: base.join(&spec.file),
            source: spec.file.display().to_string(),
            points: spec.points.clone().into_iter().collect(),
            unit: spec.unit.clone(),
            record: spec.record.clone(),
            reference: spec.reference.as_ref().map(|path| base.join(path)),
            held_s: spec.held.map(|w| w.map(|t| t.0)),
            start_s: spec.start.map(|t| t.0),
        })
    };
    specs.iter().enumerate().map(one).collect()
}
