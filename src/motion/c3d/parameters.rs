//! Parameters of a C3D file: groups of named arrays.

use super::bytes::{BLOCK, Order};
use std::collections::BTreeMap;

/// Contents of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Texts of one length, without leading and trailing blanks
    Texts(Vec<String>),
    /// Bytes, words and floats; words also as unsigned numbers
    Numbers(Vec<f64>),
}

/// Parameters by group and name, in upper case.
#[derive(Clone, Debug, Default)]
pub struct Parameters(BTreeMap<(String, String), Value>);

impl Parameters {
    /// Reads the section that starts at byte `start`; parameters beyond the end of the file are missing.
    pub fn read(file: &[u8], start: usize, order: Order) -> Self {
        let blocks = usize::from(file.get(start + 2).copied().unwrap_or(0));
        // Some programs write no count; the offset of the last record ends the section
        let end = if blocks == 0 { file.len() } else { (start + blocks * BLOCK).min(file.len()) };
        let section = file.get(start + 4..end).unwrap_or_default();
        let mut groups: BTreeMap<i8, String> = BTreeMap::new();
        let mut found: Vec<(i8, String, Value)> = vec![];
        let mut at = 0;
        while let (Some(length), Some(id)) = (section.get(at), section.get(at + 1)) {
            let (length, id) = (usize::from(length.cast_signed().unsigned_abs()), id.cast_signed());
            let Some(name) = section.get(at + 2..at + 2 + length).filter(|n| !n.is_empty()) else { break };
            let name = String::from_utf8_lossy(name).trim().to_uppercase();
            let offset = usize::from(order.u16(section, at + 2 + length));
            if id < 0 {
                groups.insert(id, name);
            } else if let Some(value) = value(section, at + 4 + length, order) {
                found.push((id, name, value));
            }
            if offset == 0 {
                break;
            }
            at += 2 + length + offset;
        }
        let named =
            |(id, name, value): (i8, String, Value)| Some(((groups.get(&id.checked_neg()?)?.clone(), name), value));
        Self(found.into_iter().filter_map(named).collect())
    }

    fn get(&self, group: &str, name: &str) -> Option<&Value> {
        self.0.get(&(group.into(), name.into()))
    }

    pub fn texts(&self, group: &str, name: &str) -> &[String] {
        match self.get(group, name) {
            Some(Value::Texts(texts)) => texts,
            _ => &[],
        }
    }

    pub fn numbers(&self, group: &str, name: &str) -> &[f64] {
        match self.get(group, name) {
            Some(Value::Numbers(numbers)) => numbers,
            _ => &[],
        }
    }
}

/// The array at a position: type, number of dimensions, dimensions, entries.
fn value(section: &[u8], at: usize, order: Order) -> Option<Value> {
    let size = section.get(at)?.cast_signed();
    let count = usize::from(*section.get(at + 1)?);
    let dimensions = section.get(at + 2..at + 2 + count)?;
    let entries = dimensions.iter().try_fold(1_usize, |n, d| n.checked_mul(usize::from(*d)))?;
    let bytes = usize::from(size.unsigned_abs());
    let from = at + 2 + count;
    let data = section.get(from..from.checked_add(entries.checked_mul(bytes)?)?)?;
    let read = |k: usize| match size {
        1 => f64::from(data[k]),
        2 => f64::from(order.i16(data, 2 * k)),
        _ => f64::from(order.f32(data, 4 * k)),
    };
    match size {
        -1 => {
            let length = dimensions.first().map_or(1, |d| usize::from(*d));
            let text = |t: &[u8]| String::from_utf8_lossy(t).trim_matches([' ', '\0']).to_string();
            Some(Value::Texts(data.chunks(length.max(1)).map(text).collect()))
        }
        1 | 2 | 4 => Some(Value::Numbers((0..entries).map(read).collect())),
        _ => None,
    }
}
