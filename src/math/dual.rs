//! Dual numbers: a value with its rate of change, which every operation propagates.
//!
//! Forward differentiation (Wengert, *Commun. ACM* 7 (1964) 463–464): exact to rounding. Dual numbers of dual numbers give second derivatives.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number with the operations of a smooth formula: f64, or [`Dual`] of such numbers.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// A number that does not change.
    fn constant(value: f64) -> Self;

    /// The value without its rates.
    fn value(self) -> f64;

    /// √a, for a > 0.
    fn sqrt(self) -> Self;

    /// Angle of the point (`x`, self) from the x-axis \[rad\].
    fn atan2(self, x: Self) -> Self;
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    fn atan2(self, x: Self) -> Self {
        f64::atan2(self, x)
    }
}

/// A value and its rate of change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<T> {
    pub value: T,
    pub rate: T,
}

impl<T: Number> Dual<T> {
    /// The variable itself: its rate is 1.
    pub fn variable(value: T) -> Self {
        Self { value, rate: T::constant(1.0) }
    }

    /// A number that does not change with the variable.
    pub fn fixed(value: T) -> Self {
        Self { value, rate: T::constant(0.0) }
    }
}

impl<T: Number> Add for Dual<T> {
    type Output = Self;

    fn add(self, b: Self) -> Self {
        Self { value: self.value + b.value, rate: self.rate + b.rate }
    }
}

impl<T: Number> Sub for Dual<T> {
    type Output = Self;

    fn sub(self, b: Self) -> Self {
        Self { value: self.value - b.value, rate: self.rate - b.rate }
    }
}

impl<T: Number> Mul for Dual<T> {
    type Output = Self;

    fn mul(self, b: Self) -> Self {
        Self { value: self.value * b.value, rate: self.rate * b.value + self.value * b.rate }
    }
}

impl<T: Number> Div for Dual<T> {
    type Output = Self;

    fn div(self, b: Self) -> Self {
        let value = self.value / b.value;
        Self { value, rate: (self.rate - value * b.rate) / b.value }
    }
}

impl<T: Number> Neg for Dual<T> {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, rate: -self.rate }
    }
}

impl<T: Number> Number for Dual<T> {
    fn constant(value: f64) -> Self {
        Self::fixed(T::constant(value))
    }

    fn value(self) -> f64 {
        self.value.value()
    }

    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        Self { value, rate: self.rate / (value + value) }
    }

    fn atan2(self, x: Self) -> Self {
        let square = self.value * self.value + x.value * x.value;
        let rate = (self.rate * x.value - self.value * x.rate) / square;
        Self { value: self.value.atan2(x.value), rate }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First and second derivatives of √(1 + x²)/x + atan2(x, 2 − x), computed by hand at x = 0.7.
    #[test]
    fn derivatives_are_exact() {
        fn f<T: Number>(x: T) -> T {
            let [one, two] = [1.0, 2.0].map(T::constant);
            (one + x * x).sqrt() / x - (-x).atan2(two - x)
        }
        let x: f64 = 0.7;
        let found = f(Dual::variable(Dual::variable(x)));
        let (root, square) = ((1.0 + x * x).sqrt(), x * x + (2.0 - x).powi(2));
        let first = -1.0 / (x * x * root) + 2.0 / square;
        let second = (2.0 + 3.0 * x * x) / (x.powi(3) * root.powi(3)) - 2.0 * (4.0 * x - 4.0) / square.powi(2);
        assert!((found.rate.value - first).abs() < 1e-14, "{found:?}, {first}");
        assert!((found.rate.rate - second).abs() < 1e-14, "{found:?}, {second}");
        assert!((found.value() - f(x)).abs() == 0.0);
    }
}
