//! Quantities as typed values: with their unit in files, and in SI in Rust ([`Length::metres`] or `0.01.into()`).

use crate::math::units::{self, Dimension, UnitError};
use crate::schema::any_of;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Deserializer, Error, Visitor};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// Declares a value in SI whose dimension is part of its type.
macro_rules! quantity {
    ($($name:ident = $dimension:ident by $unit:ident: $what:literal),* $(,)?) => {$(
        #[doc = $what]
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Default)]
        pub struct $name(pub f64);

        impl $name {
            /// The quantity with this value in SI.
            pub const fn $unit(value: f64) -> Self {
                Self(value)
            }
        }

        impl From<f64> for $name {
            fn from(value: f64) -> Self {
                Self(value)
            }
        }

        /// Displays the number in SI.
        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
                units::shown(self.0).fmt(f)
            }
        }

        impl FromStr for $name {
            type Err = UnitError;

            fn from_str(text: &str) -> Result<Self, UnitError> {
                units::parse(text, Dimension::$dimension).map(Self)
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_any(Text(Dimension::$dimension)).map(Self)
            }
        }

        impl JsonSchema for $name {
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                text_schema($what, Dimension::$dimension)
            }
        }
    )*};
}

quantity! {
    Length = LENGTH by metres: "A length (m).",
    Force = FORCE by newtons: "A force (N).",
    Time = TIME by seconds: "A time (s).",
    Angle = ANGLE by radians: "An angle (rad).",
    Density = DENSITY by kilograms_per_cubic_metre: "A mass density (kg/m³).",
    Modulus = PRESSURE by pascals: "A modulus or pressure (Pa).",
    SpringStiffness = STIFFNESS by newtons_per_metre: "A stiffness of a spring (N/m).",
    Damping = DAMPING by newton_seconds_per_metre: "A coefficient of a damper (N s/m).",
    Viscosity = VISCOSITY by pascal_seconds: "A dynamic viscosity (Pa s).",
    PerSecond = FREQUENCY by hertz: "A rate (1/s).",
    Speed = VELOCITY by metres_per_second: "A component of a velocity (m/s).",
    Spin = ANGULAR_VELOCITY by radians_per_second: "A component of an angular velocity (rad/s).",
}

/// The schema of a string with a number and a unit.
fn text_schema(what: &str, dimension: Dimension) -> Schema {
    let example = format!("1 {}", dimension.example());
    json_schema!({ "type": "string", "pattern": units::pattern(), "description": what, "examples": [example] })
}

/// A quantity whose dimension follows from its context.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// A text as in files, such as `"15 mm"`; a bare number is refused if a unit is needed
    Text(String),
    /// A value in SI, from Rust
    Si(f64),
}

impl Quantity {
    /// The value in SI.
    ///
    /// # Errors
    ///
    /// Where the text is not a number with a unit of this dimension.
    pub fn value(&self, dimension: Dimension) -> Result<f64, UnitError> {
        match self {
            Self::Text(text) => units::parse(text, dimension),
            Self::Si(value) => Ok(*value),
        }
    }
}

impl From<f64> for Quantity {
    fn from(value: f64) -> Self {
        Self::Si(value)
    }
}

impl From<&str> for Quantity {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl<'de> serde::Deserialize<'de> for Quantity {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Bare).map(Self::Text)
    }
}

impl JsonSchema for Quantity {
    fn schema_name() -> Cow<'static, str> {
        "Quantity".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let what = "A quantity in quotes with its unit; a number alone where it has no unit.";
        json_schema!({ "type": ["string", "number"], "pattern": units::pattern(), "description": what })
    }
}

struct Bare;

impl Visitor<'_> for Bare {
    type Value = String;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a quantity in quotes with its unit, such as \"4 mm\"")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<String, E> {
        Ok(text.into())
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<String, E> {
        Ok(value.to_string())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<String, E> {
        Ok(value.to_string())
    }
}

struct Text(Dimension);

impl Visitor<'_> for Text {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a quantity such as \"1 {}\"", self.0.example())
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<f64, E> {
        units::parse(text, self.0).map_err(E::custom)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<f64, E> {
        self.visit_str(&value.to_string())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<f64, E> {
        self.visit_str(&value.to_string())
    }
}

/// Radius of the guide patches, or `"point"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GuideRadius {
    Point,
    /// Radius in m
    Ball(f64),
}

impl<'de> serde::Deserialize<'de> for GuideRadius {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = deserializer.deserialize_any(Bare)?;
        if text == "point" {
            return Ok(Self::Point);
        }
        units::parse(&text, Dimension::LENGTH).map(Self::Ball).map_err(Error::custom)
    }
}

impl JsonSchema for GuideRadius {
    fn schema_name() -> Cow<'static, str> {
        "GuideRadius".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        any_of(&[generator.subschema_for::<Length>(), json_schema!({ "const": "point" })])
    }
}
