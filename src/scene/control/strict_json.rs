//! JSON without repeated keys in its objects.
//!
//! serde_json keeps only the last of several values of one key, so that the loss of the others would go unnoticed.

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};
use std::fmt;

/// A value in whose objects no key occurs twice.
pub struct Strict(pub Value);

impl<'de> Deserialize<'de> for Strict {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Keys).map(Self)
    }
}

/// Builds a value and checks its keys.
struct Keys;

impl<'de> Visitor<'de> for Keys {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(Number::from_f64(value).map_or(Value::Null, Value::Number))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(text.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut all = Vec::new();
        while let Some(Strict(item)) = items.next_element()? {
            all.push(item);
        }
        Ok(all.into())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut all = Map::new();
        while let Some(key) = entries.next_key::<String>()? {
            if all.contains_key(&key) {
                return Err(A::Error::custom(format!("the key \"{key}\" occurs twice")));
            }
            let Strict(value) = entries.next_value()?;
            all.insert(key, value);
        }
        Ok(all.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line without repeated keys gives exactly the value of serde_json, and a repeated key is named at any depth.
    #[test]
    fn a_repeated_key_is_refused_and_all_else_is_kept() {
        for line in [
            r#"{"a": 1, "b": [-2, 0.1, 1e300, {"a": null}], "c": {"a": true, "d": "x\ty"}, "e": 18446744073709551615}"#,
            "[]",
            "0.30000000000000004",
            r#"{"a": {"b": 1}, "b": {"a": 1}}"#,
        ] {
            let Strict(value) = serde_json::from_str(line).expect("every key once");
            assert_eq!(value, serde_json::from_str::<Value>(line).expect("JSON"), "{line}");
        }
        for line in [r#"{"a": 1, "b": 2, "a": 1}"#, r#"[{"b": [{"a": 1, "a": {}}]}]"#, r#"{"a": 1, "\u0061": 2}"#] {
            let message = serde_json::from_str::<Strict>(line).map(|_| ()).expect_err(line).to_string();
            assert!(message.starts_with("the key \"a\" occurs twice"), "{line}: {message}");
        }
        assert!(serde_json::from_str::<Strict>("{\"a\": 1} 2").is_err());
    }
}
