//! Types from the values of a TOML file. In contrast to toml's own reader:
//!
//! - tables are given by their keys; serde's derived readers also take the values in the order of the fields from an array, whose meaning would change
//!   with every key that is added,
//! - enums are choices by [`kind`](super::kind),
//! - dates are texts,
//! - numbers are finite; TOML has `inf` and `nan` too,
//! - a list has no more values than its type accepts,
//! - [changes by path](super::changes) have whole paths as keys,
//! - one reader is compiled per type; toml compiles three, of which two are for values with their place and for dates.

use super::changes;
use super::kind::{Chosen, ExpectedKind};
use serde::de::value::StrDeserializer;
use serde::de::{DeserializeSeed, Deserializer, Error, Expected, MapAccess, SeqAccess, Unexpected, Visitor};
use std::fmt::{self, Display};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeInteger, DeString, DeTable, DeValue};

/// A mistake in a value, and the bytes of the text in which it occurs.
#[derive(Debug)]
pub(in crate::scene) struct ReadError {
    pub(in crate::scene) message: String,
    pub(in crate::scene) span: Option<Range<usize>>,
}

impl ReadError {
    /// The error at this position, unless a more precise one is known.
    fn at(mut self, span: Range<usize>) -> Self {
        self.span.get_or_insert(span);
        self
    }
}

impl Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for ReadError {}

impl Error for ReadError {
    fn custom<T: Display>(message: T) -> Self {
        Self { message: message.to_string(), span: None }
    }
}

type Result<T> = std::result::Result<T, ReadError>;

/// A value with its position in the text.
pub(in crate::scene) struct Reader<'de> {
    value: DeValue<'de>,
    span: Range<usize>,
}

impl<'de> From<Spanned<DeValue<'de>>> for Reader<'de> {
    fn from(value: Spanned<DeValue<'de>>) -> Self {
        Self { span: value.span(), value: value.into_inner() }
    }
}

impl<'de> From<Spanned<DeTable<'de>>> for Reader<'de> {
    fn from(table: Spanned<DeTable<'de>>) -> Self {
        Self { span: table.span(), value: DeValue::Table(table.into_inner()) }
    }
}

impl<'de> Deserializer<'de> for Reader<'de> {
    type Error = ReadError;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value> {
        let read = match self.value {
            DeValue::String(text) => visitor.visit_str(&text),
            DeValue::Integer(number) => match (integer(&number), whole(&number)) {
                (Some(number), _) => visitor.visit_i64(number),
                (_, Some(number)) => visitor.visit_u64(number),
                _ => Err(ReadError::custom(format!("{number} is beyond the whole numbers of 64 bits"))),
            },
            DeValue::Float(number) => float(number.as_str()).and_then(|number| visitor.visit_f64(number)),
            DeValue::Boolean(value) => visitor.visit_bool(value),
            DeValue::Datetime(date) => visitor.visit_str(&date.to_string()),
            DeValue::Array(list) => whole_list(list, visitor),
            DeValue::Table(table) => visitor.visit_map(Entries::of(table)),
        };
        read.map_err(|e| e.at(self.span))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value> {
        let Some(depth) = changes::depth(name) else { return visitor.visit_newtype_struct(self) };
        let twice = |path: Spanned<_>| {
            let fact = format!("`{}` is changed twice; leave one of the two out", path.get_ref());
            ReadError::custom(fact).at(path.span())
        };
        let value = changes::joined(self.value, depth).map_err(twice)?;
        visitor.visit_newtype_struct(Self { value, span: self.span })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value> {
        let read = match self.value {
            DeValue::Table(table) => visitor.visit_map(Entries::of(table)),
            other => Err(wrong_type(&other, &"a table")),
        };
        read.map_err(|e| e.at(self.span))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        kinds: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value> {
        let chosen = match self.value {
            DeValue::String(name) => Chosen::alone(&name, kinds, Entries::of(DeTable::new())),
            DeValue::Table(table) => Chosen::of(Entries::of(table), kinds),
            other => Err(wrong_type(&other, &ExpectedKind(kinds))),
        };
        chosen.and_then(|chosen| visitor.visit_enum(chosen)).map_err(|e| e.at(self.span))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct
        seq tuple tuple_struct map identifier ignored_any
    }
}

fn integer(number: &DeInteger) -> Option<i64> {
    i64::from_str_radix(number.as_str(), number.radix()).ok()
}

fn whole(number: &DeInteger) -> Option<u64> {
    u64::from_str_radix(number.as_str(), number.radix()).ok()
}

fn float(text: &str) -> Result<f64> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ if text.contains("inf") || text.contains("nan") => {
            Err(ReadError::custom(format!("{text} is not a finite number; give one")))
        }
        _ => Err(ReadError::custom(format!("{text} is beyond the numbers of double precision"))),
    }
}

fn wrong_type(value: &DeValue, expected: &dyn Expected) -> ReadError {
    let float = |text: &str| text.parse().unwrap_or(f64::NAN);
    let date;
    let found = match value {
        DeValue::String(text) => Unexpected::Str(text),
        DeValue::Integer(number) => integer(number).map_or(Unexpected::Other("whole number"), Unexpected::Signed),
        DeValue::Float(number) => Unexpected::Float(float(number.as_str())),
        DeValue::Boolean(value) => Unexpected::Bool(*value),
        DeValue::Datetime(value) => {
            date = value.to_string();
            Unexpected::Str(&date)
        }
        DeValue::Array(_) => Unexpected::Other("array"),
        DeValue::Table(_) => Unexpected::Map,
    };
    ReadError::invalid_type(found, expected)
}

/// Reads a value; a mistake that a type finds in what it has read is reported at the position of the value.
fn read<'de, S: DeserializeSeed<'de>>(seed: S, value: Spanned<DeValue<'de>>) -> Result<S::Value> {
    let span = value.span();
    seed.deserialize(Reader::from(value)).map_err(|e| e.at(span))
}

/// The value that a visitor makes of a list; refuses a list of which the visitor does not take all elements.
fn whole_list<'de, V: Visitor<'de>>(list: DeArray<'de>, visitor: V) -> Result<V::Value> {
    let given = list.len();
    let mut elements = Elements(list.into_iter());
    let value = visitor.visit_seq(&mut elements)?;
    match elements.0.len() {
        0 => Ok(value),
        left => Err(ReadError::invalid_length(given, &format!("an array of length {}", given - left).as_str())),
    }
}

/// The elements of an array.
struct Elements<'de>(<DeArray<'de> as IntoIterator>::IntoIter);

impl<'de> SeqAccess<'de> for Elements<'de> {
    type Error = ReadError;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>> {
        self.0.next().map(|value| read(seed, value)).transpose()
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

type Entry<'de> = (Spanned<DeString<'de>>, Spanned<DeValue<'de>>);

/// The keys of a table with their values, `kind` before all other keys.
struct Entries<'de> {
    kind: Option<Entry<'de>>,
    rest: <DeTable<'de> as IntoIterator>::IntoIter,
    value: Option<Spanned<DeValue<'de>>>,
}

impl<'de> Entries<'de> {
    fn of(mut table: DeTable<'de>) -> Self {
        Self { kind: table.remove_entry("kind"), rest: table.into_iter(), value: None }
    }
}

impl<'de> MapAccess<'de> for Entries<'de> {
    type Error = ReadError;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>> {
        let Some((key, value)) = self.kind.take().or_else(|| self.rest.next()) else { return Ok(None) };
        self.value = Some(value);
        let text: StrDeserializer<ReadError> = StrDeserializer::new(key.get_ref());
        seed.deserialize(text).map(Some).map_err(|e| e.at(key.span()))
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value> {
        read(seed, self.value.take().expect("serde asks for a value after its key"))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(usize::from(self.kind.is_some()) + self.rest.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use std::collections::BTreeMap;

    fn of<T: serde::de::DeserializeOwned>(text: &str) -> Result<T> {
        T::deserialize(Reader::from(DeTable::parse(text).expect(text)))
    }

    #[derive(Deserialize, Debug, PartialEq)]
    struct Numbers {
        seed: u64,
        size: f64,
        made: String,
        rest: toml::Table,
    }

    #[test]
    fn values_are_those_of_the_text() {
        let text =
            "seed = 0xffff_ffff_ffff_ffff\nsize = 3\nmade = 2026-11-29\nrest = { b = -1.5, a = [1, { kind = true }] }";
        let rest = toml::from_str("b = -1.5\na = [1, { kind = true }]").expect("TOML");
        let expected = Numbers { seed: u64::MAX, size: 3.0, made: "2026-11-29".into(), rest };
        assert_eq!(of::<Numbers>(text).expect(text), expected);
    }

    #[derive(Deserialize, Debug, PartialEq)]
    struct Changed {
        #[serde(default, deserialize_with = "changes::by_path")]
        set: toml::Table,
        #[serde(default, deserialize_with = "changes::of_members")]
        members: toml::Table,
        #[serde(default, deserialize_with = "changes::of_series")]
        sizes: BTreeMap<String, toml::Table>,
        #[serde(default, deserialize_with = "changes::by_path")]
        reference: Option<toml::Table>,
    }

    /// A dotted key is a path with and without quotation marks. A table that is written as one stays whole.
    #[test]
    fn dotted_keys_of_changes_are_paths() {
        let quoted = "set = { \"mesh.element\" = \"tet10\", \"stage.0.dt\" = \"1 s\", numerics = { line.search = true } }\n\
                      reference = { \"laws.rubber.nu\" = 0.4, \"mesh.disturb\" = { seed = 1 } }\n\
                      [members]\nfine = { \"mesh.grid.divisions\" = [4, 1] }\nwide = 3\n\
                      [sizes.all]\nfine = { \"mesh.cells\" = 9, \"mesh.seed\" = 1 }\n";
        let expected = of::<Changed>(quoted).expect(quoted);
        assert!(expected.set["numerics"]["line"].is_table(), "{expected:?}");
        let keys = |table: &toml::Table| table.keys().cloned().collect::<Vec<_>>();
        assert_eq!(keys(&expected.set), ["mesh.element", "stage.0.dt", "numerics"]);
        for text in [
            "set = { mesh.element = \"tet10\", stage.0.dt = \"1 s\", numerics = { line.search = true } }\n\
             reference = { laws.rubber.nu = 0.4, mesh.disturb = { seed = 1 } }\n\
             [members]\nfine = { mesh.grid.divisions = [4, 1] }\nwide = 3\n\
             [sizes]\nall.fine = { mesh.cells = 9, mesh.\"seed\" = 1 }\n",
            "members.fine.mesh.grid.divisions = [4, 1]\nmembers.wide = 3\n[set]\nmesh.element = \"tet10\"\n\
             stage.0.\"dt\" = \"1 s\"\n[set.numerics]\nline.search = true\n[reference]\n\"laws.rubber\".nu = 0.4\n\
             mesh.disturb = { seed = 1 }\n[sizes.all.fine]\nmesh.cells = 9\nmesh.seed = 1\n",
        ] {
            assert_eq!(of::<Changed>(text).expect(text), expected, "{text}");
        }
        let below = of::<Changed>("[set.mesh.disturb]\nseed = 1\n").expect("a table below an implied one");
        assert_eq!(keys(&below.set), ["mesh.disturb"]);
        let twice = "[set]\nmesh.element = \"tet4\"\n\"mesh.element\" = \"tet10\"\n";
        let e = of::<Changed>(twice).expect_err(twice);
        assert_eq!(e.message, "`mesh.element` is changed twice; leave one of the two out");
        assert_eq!(&twice[e.span.expect("a place")], "\"mesh.element\"");
    }

    /// A mistake has the position of the value, of the key, or of the table that lacks a key.
    #[test]
    fn a_mistake_has_its_place() {
        let rest = "seed = 1\nmade = \"\"\nrest = {}\n";
        for (text, message, at) in [
            (format!("{rest}size = 1e999"), "1e999 is beyond the numbers of double precision", "1e999"),
            (
                format!("{rest}size = 99999999999999999999"),
                "is beyond the whole numbers of 64 bits",
                "99999999999999999999",
            ),
            (format!("{rest}size = nan"), "nan is not a finite number; give one", "nan"),
            (format!("{rest}size = -inf"), "-inf is not a finite number; give one", "-inf"),
            (
                "seed = 1\nsize = 1.0\nmade = \"\"\nrest = { a = [1.0, inf] }".into(),
                "inf is not a finite number; give one",
                "inf",
            ),
            (format!("{rest}size = [1]"), "invalid type: sequence, expected f64", "[1]"),
            ("x = [1, 2.0, \"3\"]".into(), "invalid type: string \"3\", expected f64", "\"3\""),
            ("p = [[0, 1], [0]]".into(), "invalid length 1, expected an array of length 2", "[0]"),
            ("p = [[0, 1, 2, 3]]".into(), "invalid length 4, expected an array of length 2", "[0, 1, 2, 3]"),
        ] {
            let e = match &text[..1] {
                "x" => of::<BTreeMap<String, Vec<f64>>>(&text).expect_err(&text),
                "p" => of::<BTreeMap<String, Vec<[f64; 2]>>>(&text).expect_err(&text),
                _ => of::<Numbers>(&text).expect_err(&text),
            };
            assert!(e.message.contains(message), "{text}: {e}");
            assert_eq!(&text[e.span.expect("a place")], at);
        }
        let e = of::<Numbers>(rest).expect_err("no size");
        assert!(e.message.contains("missing field `size`"), "{e}");
    }
}
