//! Vectors of numbers: the same arithmetic on one number or on [`LANES`] of them, written once.
//!
//! A [`Lanes`] is an array, which the compiler turns into vector instructions. [`widest`] runs a kernel with the vector instructions of the current
//! processor. Products and sums are not fused, so that each lane is bit-identical to the arithmetic on one number, whatever the processor.

use std::ops::{Add, AddAssign, Mul, Sub};

/// Number of values in one [`Lanes`]: a vector register of AVX2, or two of SSE2.
pub const LANES: usize = 4;

/// A number in each of [`LANES`] lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes(pub [f64; LANES]);

/// Number type of a kernel: `f64` or [`Lanes`].
pub trait Real: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + AddAssign {
    /// Returns `x`, in every lane.
    fn of(x: f64) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn of(x: f64) -> Self {
        x
    }
}

impl Lanes {
    pub const ZERO: Self = Self([0.0; LANES]);
}

impl Real for Lanes {
    #[inline(always)]
    fn of(x: f64) -> Self {
        Self([x; LANES])
    }
}

macro_rules! lane_by_lane {
    ($trait:ident, $name:ident, $op:tt) => {
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let (a, b) = (self.0, other.0);
                Self([a[0] $op b[0], a[1] $op b[1], a[2] $op b[2], a[3] $op b[3]])
            }
        }
    };
}

lane_by_lane!(Add, add, +);
lane_by_lane!(Sub, sub, -);
lane_by_lane!(Mul, mul, *);

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// A piece of arithmetic without calls; everything in it is marked `#[inline(always)]`.
pub trait Kernel {
    fn run(self);
}

/// Runs a kernel with the widest vectors of the processor.
#[inline]
pub fn widest(kernel: impl Kernel) {
    pulp::Arch::new().dispatch(Vectorised(kernel));
}

struct Vectorised<K>(K);

impl<K: Kernel> pulp::WithSimd for Vectorised<K> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.0.run();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::WithSimd;

    /// Σ aᵢ bᵢ in the order of the numbers, lane by lane.
    struct Products<'a>(&'a [Lanes], &'a [Lanes], &'a mut Lanes);

    impl Kernel for Products<'_> {
        #[inline(always)]
        fn run(self) {
            self.0.iter().zip(self.1).for_each(|(&a, &b)| *self.2 += a * b);
        }
    }

    /// Fused products and sums would differ: the square of 1 + 2⁻³⁰ has 60 binary digits after the point.
    #[test]
    fn wide_vectors_and_plain_arithmetic_have_the_same_bits() {
        let digits = |k: usize| 1.0 + f64::powi(2.0, -30) * (k + 1) as f64;
        let a: Vec<Lanes> = (0..9).map(|k| Lanes([0, 1, 2, 3].map(|lane| digits(4 * k + lane)))).collect();
        let (mut wide, mut plain) = (Lanes([-9.0; LANES]), Lanes([-9.0; LANES]));
        widest(Products(&a, &a, &mut wide));
        Vectorised(Products(&a, &a, &mut plain)).with_simd(pulp::Scalar);
        let one_by_one: Vec<f64> =
            (0..LANES).map(|lane| a.iter().fold(-9.0, |sum, x| sum + x.0[lane] * x.0[lane])).collect();
        let fused: Vec<f64> =
            (0..LANES).map(|lane| a.iter().fold(-9.0, |sum, x| x.0[lane].mul_add(x.0[lane], sum))).collect();
        let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&wide.0), bits(&plain.0));
        assert_eq!(bits(&wide.0), bits(&one_by_one));
        assert_ne!(bits(&wide.0), bits(&fused), "the numbers tell fused arithmetic from plain one");
    }
}
