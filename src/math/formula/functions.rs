//! Functions and constants that formulas can use.

use crate::math::statistics::{larger, smaller};
use std::f64::consts::{E, LN_2, LN_10, PI, TAU};

/// Constants with their names.
pub const CONSTANTS: [(&str, f64); 6] = [("PI", PI), ("π", PI), ("TAU", TAU), ("τ", TAU), ("E", E), ("e", E)];

/// A function of one argument.
pub struct Function {
    pub name: &'static str,
    pub value: fn(f64) -> f64,
    /// `None` for a function with kinks or jumps
    pub derivative: Option<fn(f64) -> f64>,
}

const fn smooth(name: &'static str, value: fn(f64) -> f64, derivative: fn(f64) -> f64) -> Function {
    Function { name, value, derivative: Some(derivative) }
}

const fn kinked(name: &'static str, value: fn(f64) -> f64) -> Function {
    Function { name, value, derivative: None }
}

/// The known functions of one argument.
pub static FUNCTIONS: [Function; 26] = [
    smooth("sin", f64::sin, f64::cos),
    smooth("cos", f64::cos, |a| -a.sin()),
    smooth("tan", f64::tan, |a| 1.0 + a.tan().powi(2)),
    smooth("asin", f64::asin, |a| (1.0 - a * a).sqrt().recip()),
    smooth("acos", f64::acos, |a| -(1.0 - a * a).sqrt().recip()),
    smooth("atan", f64::atan, |a| (1.0 + a * a).recip()),
    smooth("sinh", f64::sinh, f64::cosh),
    smooth("cosh", f64::cosh, f64::sinh),
    smooth("tanh", f64::tanh, |a| 1.0 - a.tanh().powi(2)),
    smooth("asinh", f64::asinh, |a| (a * a + 1.0).sqrt().recip()),
    smooth("acosh", f64::acosh, |a| (a * a - 1.0).sqrt().recip()),
    smooth("atanh", f64::atanh, |a| (1.0 - a * a).recip()),
    smooth("exp", f64::exp, f64::exp),
    smooth("sqrt", f64::sqrt, |a| 0.5 / a.sqrt()),
    smooth("cbrt", f64::cbrt, |a| (3.0 * a.cbrt().powi(2)).recip()),
    smooth("ln", f64::ln, f64::recip),
    smooth("log", f64::ln, f64::recip),
    smooth("log2", f64::log2, |a| (a * LN_2).recip()),
    smooth("log10", f64::log10, |a| (a * LN_10).recip()),
    kinked("abs", f64::abs),
    kinked("signum", f64::signum),
    kinked("floor", f64::floor),
    kinked("ceil", f64::ceil),
    kinked("round", f64::round),
    kinked("trunc", f64::trunc),
    kinked("fract", f64::fract),
];

/// An operation on two values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Operation {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Min,
    Max,
    /// atan2(y, x), the angle of the point (x, y)
    Atan2,
}

/// Functions of two arguments; `min` and `max` also take more.
pub const PAIRS: [(&str, Operation); 3] =
    [("min", Operation::Min), ("max", Operation::Max), ("atan2", Operation::Atan2)];

impl Operation {
    pub fn value(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::Power => a.powf(b),
            Self::Min => smaller(a, b),
            Self::Max => larger(a, b),
            Self::Atan2 => a.atan2(b),
        }
    }

    /// Derivatives with respect to both arguments; NaN for `min` and `max`, which have kinks.
    pub fn derivatives(self, a: f64, b: f64) -> [f64; 2] {
        match self {
            Self::Add => [1.0, 1.0],
            Self::Subtract => [1.0, -1.0],
            Self::Multiply => [b, a],
            Self::Divide => [b.recip(), -a / (b * b)],
            Self::Power => [if b == 0.0 { 0.0 } else { b * a.powf(b - 1.0) }, a.ln() * a.powf(b)],
            Self::Min | Self::Max => [f64::NAN; 2],
            Self::Atan2 => [b / (a * a + b * b), -a / (a * a + b * b)],
        }
    }
}
