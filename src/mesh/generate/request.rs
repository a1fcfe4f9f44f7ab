//! The request to the mesher (geometry and size), and its hash, which names the resulting mesh.

use super::GenerateError;
use super::body::ParametricBody;
use super::referred::digest;
use super::size_field::SizeField;
use crate::mesh::file::format::recognise;
use crate::storage;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Incremented when the conversion of mesh files changes.
const CONVERTER: u32 = 7;

/// A mesh to be made. Lengths are in metres.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshRequest {
    pub source: Source,
    #[serde(default)]
    pub generator: Generator,
    /// `None` only if CGAL's criteria determine the size
    pub size: Option<Size>,
    /// Number of times that each cell is split into 8 (gmsh)
    #[serde(default)]
    pub levels: u32,
    #[serde(default)]
    pub grading: Vec<Grading>,
    /// Order of the cells, 1 or 2
    pub order: u8,
    /// Selects a different mesh of the same size (gmsh)
    #[serde(default)]
    pub seed: u64,
    pub optimise: bool,
    /// CGAL's criteria and optimisers by name; numbers and switches
    #[serde(default)]
    pub cgal: BTreeMap<String, Value>,
    /// Factor of the edge length as a function of position (gmsh)
    #[serde(default)]
    pub field: Option<SizeField>,
    /// Time after which the mesher is ended \[s\]; not part of the hash
    #[serde(default = "time_limit")]
    pub time_limit_s: f64,
}

/// Default time limit of the mesher for one mesh \[s\].
pub const TIME_LIMIT_S: f64 = 600.0;

fn time_limit() -> f64 {
    TIME_LIMIT_S
}

/// The geometry to be meshed.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Source {
    /// A parametric body; parameters in SI, with defaults for those that are missing
    Body { name: String, parameters: BTreeMap<String, f64> },
    /// CAD or a closed surface; `unit_m` is the length of its unit in metres
    File { path: PathBuf, unit_m: f64 },
}

#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Generator {
    #[default]
    Gmsh,
    Cgal,
}

#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Size {
    /// Edge length \[m\]
    Length(f64),
    /// Number of cells, reached to a relative tolerance
    Cells { count: u64, tolerance: f64 },
}

/// Local refinement: the edge length is `length` \[m\] within `distance` \[m\] of a place.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Grading {
    #[serde(flatten)]
    pub near: GradedPlace,
    pub length: f64,
    pub distance: f64,
}

/// The place at which cells are smaller.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GradedPlace {
    /// A named feature of the body
    Feature(String),
    /// Points \[m\]
    Points(Vec<[f64; 3]>),
    /// Lower and upper corner of an axis-aligned box \[m\]
    Box([[f64; 3]; 2]),
}

impl MeshRequest {
    /// Builds a request for a body, meshed by gmsh with order 1 and seed 0, optimised.
    pub fn body(name: &str, size: Size) -> Self {
        let source = Source::Body { name: name.into(), parameters: BTreeMap::new() };
        let (generator, cgal) = (Generator::Gmsh, BTreeMap::new());
        Self {
            source,
            generator,
            size: Some(size),
            levels: 0,
            grading: vec![],
            order: 1,
            seed: 0,
            optimise: true,
            cgal,
            field: None,
            time_limit_s: TIME_LIMIT_S,
        }
    }

    /// Returns the version, incremented when the mesher would answer a request with a different mesh, so that earlier meshes are made again. Zero is
    /// not part of the name: committed meshes keep theirs.
    pub(super) fn version(&self) -> u32 {
        let is_at_feature = |grading: &Grading| matches!(grading.near, GradedPlace::Feature(_));
        match self.generator {
            Generator::Gmsh => u32::from(self.grading.iter().any(is_at_feature)),
            Generator::Cgal => 2,
        }
    }

    /// Returns the folder of the body's committed meshes under `meshes/`.
    pub(super) fn folder(&self) -> &str {
        match &self.source {
            Source::Body { name, .. } => name,
            Source::File { .. } => "file",
        }
    }

    /// Returns the request as the mesher reads it, with all defaults filled in, and its name: the first 16 digits of the SHA-256 of its canonical
    /// JSON. A file is identified by its content and that of the files to which it refers, not by its path.
    pub fn resolve(&self, home: &Path) -> Result<(Value, String), GenerateError> {
        if !matches!(self.order, 1 | 2) {
            return Err(GenerateError::Request {
                fact: format!("order = {}", self.order),
                remedy: "use 1 or 2".into(),
            });
        }
        let mut request = json!({
            "generator": self.generator, "order": self.order, "seed": self.seed, "optimise": self.optimise,
            "grading": self.grading,
        });
        let mut content = Value::Null;
        match &self.source {
            Source::Body { name, parameters } => {
                let body = ParametricBody::load(home, name)?;
                self.grading.iter().try_for_each(|g| match &g.near {
                    GradedPlace::Feature(name) => body.check_feature(name),
                    GradedPlace::Points(_) | GradedPlace::Box(_) => Ok(()),
                })?;
                request["body"] = json!(name);
                request["version"] = json!(body.version);
                request["parameters"] = json!(body.resolve(parameters)?);
            }
            Source::File { path, unit_m } => {
                let (path, text) = full_path(path)?;
                let (kind, format) = recognise(&path)?.reader.shape();
                request["body"] = json!("file");
                request["parameters"] = json!({ "path": text, "unit_m": unit_m, "kind": kind, "format": format });
                content = json!({ "sha256": digest("", &path, format)?, "unit_m": unit_m });
            }
        }
        let size = match self.size {
            Some(Size::Length(length)) => json!({ "length": length, "levels": self.levels }),
            Some(Size::Cells { count, tolerance }) => {
                json!({ "cells": count, "tolerance": tolerance, "levels": self.levels })
            }
            None => json!({ "levels": self.levels }),
        };
        request["size"] = size;
        if !self.cgal.is_empty() {
            request["cgal"] = json!(self.cgal);
        }
        if let Some(field) = &self.field {
            request["field"] = json!(field);
        }
        let mut named = without_field(&request);
        if !content.is_null() {
            named["parameters"] = content;
        }
        if self.version() > 0 {
            named["mesher"] = json!(self.version());
        }
        let name = storage::sha256(canonical(&named))[..16].to_string();
        Ok((request, name))
    }
}

/// Returns an absolute path, also as the text that a request can contain.
fn full_path(path: &Path) -> Result<(PathBuf, String), GenerateError> {
    let path = std::path::absolute(path).map_err(|e| GenerateError::io(path, &e))?;
    match path.to_str().map(str::to_string) {
        Some(text) => Ok((path, text)),
        None => Err(GenerateError::Request {
            fact: format!("the path {} is not UTF-8, which the mesher needs", path.display()),
            remedy: "rename the file or its folder".into(),
        }),
    }
}

/// Returns the request to convert a mesh file, without its output, and its name: the first 16 digits of the SHA-256 of the content of the file and of
/// those to which it refers.
pub(super) fn conversion(path: &Path, format: &str) -> Result<(Value, String), GenerateError> {
    let (path, text) = full_path(path)?;
    let name = digest(&format!("conversion {CONVERTER} from {format}"), &path, format)?[..16].to_string();
    Ok((json!({ "path": text, "format": format }), name))
}

/// Returns the request with its size field replaced by the hash of the field.
pub(super) fn without_field(request: &Value) -> Value {
    let mut named = request.clone();
    if let Some(field) = request.get("field").filter(|field| !field.is_null()) {
        named["field"] = json!({ "sha256": storage::sha256(canonical(field)) });
    }
    named
}

/// Returns JSON with sorted keys and without spaces. Numbers are written as by `serde_json`: the shortest form that reads back identically.
fn canonical(value: &Value) -> String {
    match value {
        Value::Object(map) => {
            let sorted: BTreeMap<&String, &Value> = map.iter().collect();
            let entries: Vec<String> =
                sorted.into_iter().map(|(k, v)| format!("{}:{}", json!(k), canonical(v))).collect();
            format!("{{{}}}", entries.join(","))
        }
        Value::Array(list) => format!("[{}]", list.iter().map(canonical).collect::<Vec<_>>().join(",")),
        other => other.to_string(),
    }
}
