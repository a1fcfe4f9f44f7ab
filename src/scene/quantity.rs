//! Quantities in files as typed values: each refuses a missing or wrong unit where it stands.

use crate::math::units::{self, Dimension};
use serde::de::{Deserializer, Error, Visitor};
use std::fmt;

/// A value in SI whose dimension is part of its type.
macro_rules! quantity {
    ($($name:ident = $dimension:ident),* $(,)?) => {$(
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $name(pub f64);

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserializer.deserialize_any(Text(Dimension::$dimension)).map(Self)
            }
        }
    )*};
}

quantity! {
    Length = LENGTH,
    Force = FORCE,
    Time = TIME,
    Angle = ANGLE,
    Density = DENSITY,
    Modulus = PRESSURE,
    SpringStiffness = STIFFNESS,
    Damping = DAMPING,
    Viscosity = VISCOSITY,
    PerSecond = FREQUENCY,
    Speed = VELOCITY,
    Spin = ANGULAR_VELOCITY,
}

/// A quantity whose dimension is known later only; a bare number stands for itself and is refused where a unit is due.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityText(pub String);

impl<'de> serde::Deserialize<'de> for QuantityText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Bare).map(Self)
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
    Ball(f64),
}

impl<'de> serde::Deserialize<'de> for GuideRadius {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let QuantityText(text) = QuantityText::deserialize(deserializer)?;
        if text == "point" {
            return Ok(Self::Point);
        }
        units::parse(&text, Dimension::LENGTH).map(Self::Ball).map_err(Error::custom)
    }
}
