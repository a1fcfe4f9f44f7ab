//! Changes of a scene as a study writes them: `set = { "mesh.element" = "tet10" }`. A dotted key is a path with or without quotation marks, `mesh.element =
//! "tet10"`; a value that is written as a table, `mesh = { … }`, replaces the table of the scene.

use serde::de::{Deserialize, Deserializer, Visitor};
use std::fmt;
use std::marker::PhantomData;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

/// Names by which the [`Reader`](super::reader::Reader) recognises a table of changes, a table of labels with changes, and a table of names with such tables.
const TABLES: [&str; 3] = ["changes by path", "members with changes", "series of members"];

/// Reads changes by path.
///
/// # Errors
///
/// Where the type cannot be read, or a path occurs twice.
pub fn by_path<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<T, D::Error> {
    deserializer.deserialize_newtype_struct(TABLES[0], Inner(PhantomData))
}

/// Reads labels with their changes.
///
/// # Errors
///
/// Where the type cannot be read, or a path occurs twice.
pub fn of_members<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<T, D::Error> {
    deserializer.deserialize_newtype_struct(TABLES[1], Inner(PhantomData))
}

/// Reads names, each with labels and their changes.
///
/// # Errors
///
/// Where the type cannot be read, or a path occurs twice.
pub fn of_series<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<T, D::Error> {
    deserializer.deserialize_newtype_struct(TABLES[2], Inner(PhantomData))
}

struct Inner<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for Inner<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a table of changes")
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, deserializer: D) -> Result<T, D::Error> {
        T::deserialize(deserializer)
    }
}

/// The number of tables around the changes in a value of this name; `None` if it has no changes.
pub(super) fn depth(name: &str) -> Option<usize> {
    TABLES.iter().position(|table| *table == name)
}

/// The value with each path of its changes as one key; the error is a key that leads to a path for the second time.
pub(super) fn joined(value: DeValue<'_>, depth: usize) -> Result<DeValue<'_>, Spanned<DeString<'_>>> {
    let DeValue::Table(table) = value else { return Ok(value) };
    let mut all = DeTable::new();
    for (key, value) in table {
        if depth > 0 {
            let span = value.span();
            all.insert(key, Spanned::new(span, joined(value.into_inner(), depth - 1)?));
        } else {
            join(key, value, &mut all)?;
        }
    }
    Ok(DeValue::Table(all))
}

/// Joins dotted keys to paths. A table that consists of dotted keys, or of headers of tables below it, has the position of its key; a table that is written as
/// one has its own position.
fn join<'de>(
    key: Spanned<DeString<'de>>,
    value: Spanned<DeValue<'de>>,
    all: &mut DeTable<'de>,
) -> Result<(), Spanned<DeString<'de>>> {
    let span = value.span();
    match value.into_inner() {
        DeValue::Table(below) if span == key.span() => below.into_iter().try_for_each(|(step, value)| {
            let path = Spanned::new(step.span(), format!("{}.{}", key.get_ref(), step.get_ref()).into());
            join(path, value, all)
        }),
        _ if all.contains_key(&**key.get_ref()) => Err(key),
        value => {
            all.insert(key, Spanned::new(span, value));
            Ok(())
        }
    }
}
