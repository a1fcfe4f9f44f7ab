//! Polylines in space: straight parts cut to a spacing, and helices about an axis.

use crate::math::tensor::Vec3;
use std::f64::consts::TAU;

/// Number of segments per turn of a helix, at least: the polyline is then within 0.9 % of the radius of the helix, and at most 0.3 % shorter.
const SEGMENTS_PER_TURN: f64 = 24.0;

/// Divides every part of a line into equal segments no longer than `spacing` \[m\].
pub fn cut(line: &[Vec3], spacing: f64) -> Vec<Vec3> {
    let mut out = line[..1].to_vec();
    for pair in line.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let count = ((to - from).norm() / spacing * (1.0 - 1e-12)).ceil().max(1.0);
        let at = |k: usize| from + (to - from) * (k as f64 / count);
        out.extend((1..=count as usize).map(at));
    }
    out
}

/// A helix about the axis from `start` to `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Helix {
    /// \[m\]
    pub start: Vec3,
    /// \[m\]
    pub end: Vec3,
    /// \[m\]
    pub radius: f64,
    /// Revolutions from `start` to `end`; positive if right-handed
    pub turns: f64,
    /// Angle of the first point about the axis \[rad\], measured from the x-axis, or from the y-axis if the axis is within 45° of x
    pub phase: f64,
}

impl Helix {
    /// Returns a polyline with vertices on the helix and segments no longer than `spacing` \[m\].
    pub fn points(&self, spacing: f64) -> Vec<Vec3> {
        let axis = self.end - self.start;
        let length = axis.norm().hypot(TAU * self.radius * self.turns);
        let count = (length / spacing).max(SEGMENTS_PER_TURN * self.turns.abs()).ceil().max(1.0);
        let along = axis.normalize();
        let from = if along.x.abs() > std::f64::consts::FRAC_1_SQRT_2 { Vec3::y() } else { Vec3::x() };
        let first = (from - along * along.dot(&from)).normalize();
        let second = along.cross(&first);
        let at = |k: usize| {
            let share = k as f64 / count;
            let (sin, cos) = (self.phase + TAU * self.turns * share).sin_cos();
            self.start + axis * share + (first * cos + second * sin) * self.radius
        };
        (0..=count as usize).map(at).collect()
    }
}
