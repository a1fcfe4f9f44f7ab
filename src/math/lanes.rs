//! Numbers side by side: the same arithmetic on one number or on [`LANES`] of them, written once.
//!
//! A [`Lanes`] is an array; the compiler makes vector instructions of it. [`widest`] runs a kernel with those of the processor at
//! use. No product and sum are fused, so one lane has the bits of the arithmetic on one number, whatever the processor.

use std::ops::{Add, AddAssign, Mul, Sub};

/// Numbers in one [`Lanes`]: a vector register of AVX2, two of SSE2.
pub const LANES: usize = 4;

/// A number for each of [`LANES`] places.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub struct Lanes(pub [f64; LANES]);

/// Number type of a kernel: `f64` or [`Lanes`].
pub trait Real: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + AddAssign {
    /// The same number everywhere.
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

/// A piece of arithmetic without calls, marked `#[inline(always)]` all the way down.
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
