//! A model as a short JSON description and one packed block of numbers.
//!
//! The block is compressed as a whole by zlib. Before that, integers are replaced by their differences, and multi-byte numbers are stored byte by
//! byte, the first bytes of all numbers before the second ones, which improves compression. `viewer/src/data.js` reads it.

use super::limits::ROWS;
use super::model::{Arrows, Field, Model};
use super::modes::Modes;
use crate::scene::column;
use serde_json::{Value, json};
use std::collections::HashSet;
use std::io::Write;

/// Version of the page data; pages of a later version are refused.
pub const FORMAT: u64 = 2;

/// A model as stored in a page.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    pub head: Value,
    /// Numbers, compressed by zlib
    pub data: Vec<u8>,
}

impl Packed {
    /// Returns the title of the case.
    pub fn title(&self) -> &str {
        self.head["title"].as_str().unwrap_or_default()
    }

    /// Adds the labels of the columns, which pages of earlier versions lack.
    pub(super) fn labelled(mut self) -> Self {
        let curves = self.head.get_mut("curves").and_then(Value::as_object_mut);
        if let Some(curves) = curves.filter(|curves| !curves.contains_key("labels")) {
            let columns = curves.get("columns").into_iter().filter_map(Value::as_array).flatten();
            let columns: Vec<String> = columns.filter_map(Value::as_str).map(String::from).collect();
            curves.insert("labels".into(), json!(labels(&columns)));
        }
        self
    }

    /// Changes the title of the case.
    pub fn rename(&mut self, title: String) {
        self.head["title"] = title.into();
    }

    /// Adds a note to those on the page.
    pub fn add_note(&mut self, note: String) {
        if let Some(notes) = self.head["notes"].as_array_mut() {
            notes.push(note.into());
        }
    }

    /// Whether the page has more than one state of the case.
    pub fn moves(&self) -> bool {
        self.head["times"].as_array().is_some_and(|t| t.len() > 1)
    }

    /// Whether the page has the cells of the case, for sections.
    pub fn has_inside(&self) -> bool {
        self.head["cells"]["count"].as_u64().is_some_and(|n| n > 0)
    }

    /// Returns the notes on parts that are left out or simplified.
    pub fn notes(&self) -> Vec<&str> {
        self.head["notes"].as_array().into_iter().flatten().filter_map(Value::as_str).collect()
    }
}

/// Packs a model.
pub fn pack(model: &Model) -> Packed {
    let mut block = Block::default();
    let shape = &model.shape;
    let low: [f64; 3] = std::array::from_fn(|i| shape.points.iter().map(|p| p[i]).fold(f64::INFINITY, f64::min));
    let low = low.map(|v| if v.is_finite() { v } else { 0.0 });
    let relative = (0..3).flat_map(|i| shape.points.iter().map(move |p| (p[i] - low[i]) as f32));
    let points = block.floats(relative.collect());
    let parts: Vec<Value> = (shape.parts.iter())
        .map(|p| {
            let triangles = block.indices(p.triangles.iter().flatten().copied());
            json!({ "name": p.name, "kind": p.kind.name(), "first": p.first, "count": p.count, "triangles": triangles })
        })
        .collect();
    let marked: Vec<Value> = (shape.marked.iter())
        .map(|m| {
            let (facets, points) = (block.indices(m.facets.iter().copied()), block.indices(m.points.iter().copied()));
            json!({ "name": m.name, "kind": m.kind, "facets": facets, "points": points })
        })
        .collect();
    let head = json!({
        "format": FORMAT,
        "program": env!("CARGO_PKG_VERSION"),
        "title": model.title,
        "facts": model.facts,
        "notes": model.shape.notes.iter().chain(&model.notes).collect::<Vec<_>>(),
        "absent": model.absent,
        "still": model.still,
        "times": model.times,
        "origin": low,
        "points": points,
        "nodes": shape.nodes.len(),
        "nodeNumbers": numbers(&mut block, &shape.nodes),
        "ownNumbers": shape.has_own_numbers,
        "facetNodes": shape.facet_nodes,
        "facets": block.indices(shape.facets.iter().copied()),
        "facetCells": block.indices(shape.facet_cells.iter().copied()),
        "cellNodes": if shape.facet_nodes == 6 { 10 } else { 4 },
        "cells": block.indices(shape.cells.iter().copied()),
        "cellCount": shape.cell_numbers.len(),
        "cellNumbers": numbers(&mut block, &shape.cell_numbers),
        "parts": parts,
        "marked": marked,
        "motion": modes(&mut block, &model.motion),
        "fields": model.fields.iter().map(|f| field(&mut block, f)).collect::<Vec<_>>(),
        "arrows": model.arrows.iter().map(|a| arrows(&mut block, a)).collect::<Vec<_>>(),
        "curves": curves(&mut block, model),
    });
    Packed { head, data: block.compressed() }
}

/// Numbers in the mesh, unless they are 0, 1, 2, …
fn numbers(block: &mut Block, numbers: &[u32]) -> Value {
    let is_plain = numbers.iter().zip(0..).all(|(number, k)| *number == k);
    if is_plain { Value::Null } else { block.indices(numbers.iter().copied()) }
}

fn modes(block: &mut Block, modes: &Modes) -> Value {
    let count = modes.components.max(1);
    // Stored component by component, because neighbours are similar
    let sorted =
        |s: &Vec<i16>| (0..count).flat_map(|i| s.iter().skip(i).step_by(count).copied().collect::<Vec<_>>()).collect();
    let shapes: Vec<Value> = modes.shapes.iter().map(|s| block.shorts(sorted(s))).collect();
    json!({ "components": modes.components, "error": modes.error, "shapes": shapes, "amplitudes": modes.amplitudes })
}

fn field(block: &mut Block, field: &Field) -> Value {
    json!({ "name": field.name, "unit": field.unit, "nodal": field.at_nodes, "modes": modes(block, &field.modes) })
}

fn arrows(block: &mut Block, arrows: &Arrows) -> Value {
    let all = || arrows.states.iter().flatten();
    let counts = block.indices(arrows.states.iter().map(|s| s.len() as u32));
    let points = block.indices(all().map(|(p, _)| *p));
    let vectors = block.floats(all().flat_map(|(_, v)| *v).collect());
    json!({ "name": arrows.name, "unit": arrows.unit, "counts": counts, "points": points, "vectors": vectors })
}

/// The rows of the states, and as many others as a screen has points. Times are in double precision, because the page finds the row of a state by its
/// time.
fn curves(block: &mut Block, model: &Model) -> Value {
    let curves = &model.curves;
    let stride = curves.rows.len().div_ceil(ROWS).max(1);
    let last = curves.rows.len().saturating_sub(1);
    let of_states: HashSet<u64> = model.times.iter().map(|t| t.to_bits()).collect();
    let is_kept =
        |k: usize, row: &[f64]| k.is_multiple_of(stride) || k == last || of_states.contains(&row[0].to_bits());
    let rows: Vec<&Vec<f64>> =
        curves.rows.iter().enumerate().filter(|(k, row)| is_kept(*k, row)).map(|(_, row)| row).collect();
    let column = |k: usize| rows.iter().map(move |row| row[k]);
    let values: Vec<Value> = (0..curves.columns.len())
        .map(|k| if k == 0 { block.doubles(column(k)) } else { block.floats(column(k).map(|v| v as f32).collect()) })
        .collect();
    json!({ "columns": curves.columns, "labels": labels(&curves.columns), "values": values })
}

/// Words and unit of each column, as shown by the page.
fn labels(columns: &[String]) -> Vec<(String, &'static str)> {
    columns.iter().map(|column| column::words(column)).collect()
}

/// The bytes of all arrays, one after the other; the description stores the offset of each.
#[derive(Default)]
struct Block {
    bytes: Vec<u8>,
}

impl Block {
    fn planes<const N: usize>(&mut self, kind: &str, values: &[[u8; N]]) -> Value {
        let at = self.bytes.len();
        (0..N).for_each(|plane| self.bytes.extend(values.iter().map(|v| v[plane])));
        json!({ "kind": kind, "at": at, "count": values.len() })
    }

    fn doubles(&mut self, values: impl Iterator<Item = f64>) -> Value {
        let bytes: Vec<[u8; 8]> = values.map(f64::to_be_bytes).collect();
        self.planes("f64", &bytes)
    }

    fn floats(&mut self, values: Vec<f32>) -> Value {
        let bytes: Vec<[u8; 4]> = values.into_iter().map(f32::to_be_bytes).collect();
        self.planes("f32", &bytes)
    }

    fn shorts(&mut self, values: Vec<i16>) -> Value {
        let bytes: Vec<[u8; 2]> = values.into_iter().map(i16::to_be_bytes).collect();
        self.planes("i16", &bytes)
    }

    /// Stores the differences between successive values, with the sign in the last bit.
    fn indices(&mut self, values: impl Iterator<Item = u32>) -> Value {
        let mut past = 0i64;
        let difference = |v: u32| {
            let d = i64::from(v) - past;
            past = i64::from(v);
            (((d << 1) ^ (d >> 63)) as u32).to_be_bytes()
        };
        let bytes: Vec<[u8; 4]> = values.map(difference).collect();
        self.planes("u32", &bytes)
    }

    fn compressed(self) -> Vec<u8> {
        let mut out = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        out.write_all(&self.bytes).and_then(|()| out.finish()).expect("memory accepts every write")
    }
}
