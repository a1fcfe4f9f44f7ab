//! Angle by which a direction has rotated from its direction at rest, continuous over any number of rotations.
//!
//! With a declared axis k it is the angle between the projections on the plane across k, with the sign of the right-hand rule, and each state takes the number
//! of whole rotations that brings it nearest to the state before. Without an axis it is α, the angle between the two directions, from 0 to 180°, continued
//! beyond:
//!
//! ```text
//! θ = 180° b + α  for b even,   180° (b + 1) − α  for b odd
//! ```
//!
//! where b counts how often the direction n has passed the opposite of its direction at rest n₀, or returned to n₀. It has passed such a pole when n₀ × n
//! points against its direction before n came near the pole, which is kept while n is within [`CAP`] of the pole. A motion that goes around a pole outside of
//! the cap does not pass it.
//!
//! The derivative of the angle with respect to n is that of ±α, or of the projected angle: b and the whole rotations are constants.

use crate::math::tensor::Vec3;

/// Sine of the angle to a pole within which the plane of the approaching direction is kept (30°).
const CAP: f64 = 0.5;

/// A direction at rest, and the axis about which its rotation is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Winding {
    pub rest: Vec3,
    /// Unit vector of the axis; if `None`, the axis follows from the motion
    pub axis: Option<Vec3>,
}

impl Winding {
    /// Size of the memory from one state to the next: θ \[deg\] and the axis n₀ × n/|n₀ × n| that is kept, zero if there is none.
    pub const MEMORY: usize = 4;

    /// Measures rotations from `rest`, a vector of any length; the axis is a unit vector.
    pub fn new(rest: Vec3, axis: Option<Vec3>) -> Self {
        Self { rest, axis }
    }

    /// Updates the memory with the direction of the next state.
    pub fn remember(&self, now: Vec3, memory: &mut [f64]) {
        match self.axis {
            Some(axis) => {
                let [sine, cosine] = self.across(axis, now);
                let angle = sine.atan2(cosine).to_degrees();
                memory[0] = angle + 360.0 * ((memory[0] - angle) / 360.0).round();
            }
            None => self.remember_freely(now, memory),
        }
    }

    fn remember_freely(&self, now: Vec3, memory: &mut [f64]) {
        let cross = self.rest.cross(&now);
        let angle = cross.norm().atan2(self.rest.dot(&now)).to_degrees();
        let (mut half_turns, axis) = (half_turns(memory[0]), Vec3::from_column_slice(&memory[1..]));
        let is_opposite = angle > 90.0;
        if sign(half_turns) * axis.dot(&cross) < 0.0 {
            let onwards = (sign(half_turns) > 0.0) == is_opposite;
            half_turns = (half_turns + if onwards { 1.0 } else { -1.0 }).max(0.0);
        }
        memory[0] =
            if sign(half_turns) > 0.0 { 180.0 * half_turns + angle } else { 180.0 * (half_turns + 1.0) - angle };
        let is_near = cross.norm() < CAP * self.rest.norm() * now.norm();
        let axis = match is_near {
            // The start does not count as a pole that can be passed: the angle of a first half turn has no sign.
            true if half_turns == 0.0 && !is_opposite => Vec3::zeros(),
            true if axis != Vec3::zeros() => axis,
            _ => cross.try_normalize(0.0).map_or(axis, |c| sign(half_turns) * c),
        };
        memory[1..].copy_from_slice(axis.as_slice());
    }

    /// Derivative of θ \[deg\] with respect to the direction; zero where it does not exist: at a pole, and with an axis along it.
    pub fn gradient(&self, now: Vec3, memory: &[f64]) -> Vec3 {
        match self.axis {
            Some(axis) => {
                let [sine, cosine] = self.across(axis, now);
                let size = sine.hypot(cosine);
                if size == 0.0 {
                    return Vec3::zeros();
                }
                let flat = self.flat(axis);
                (cosine / size * axis.cross(&flat) - sine / size * flat) * (1.0 / size).to_degrees()
            }
            None => sign(half_turns(memory[0])) * angle_gradient(self.rest, now),
        }
    }

    /// The direction at rest projected on the plane across the axis.
    fn flat(&self, axis: Vec3) -> Vec3 {
        self.rest - axis * axis.dot(&self.rest)
    }

    /// The components k·(p × n) and p·n, where p is the projection of the direction at rest.
    fn across(&self, axis: Vec3, now: Vec3) -> [f64; 2] {
        let flat = self.flat(axis);
        [axis.cross(&flat).dot(&now), flat.dot(&now)]
    }
}

/// Number of poles passed, b, from θ \[deg\].
fn half_turns(angle: f64) -> f64 {
    (angle / 180.0).floor()
}

/// Sign of dθ/dα.
fn sign(half_turns: f64) -> f64 {
    if half_turns % 2.0 == 0.0 { 1.0 } else { -1.0 }
}

/// Derivative \[deg\] of the angle between a fixed a and b with respect to b: dϑ = \[(a·b) d|a × b| − |a × b| a·db\]/(|a|²|b|²), d|a × b| = ((a × b) ×
/// a)·db/|a × b|. Zero where a and b are parallel, since the angle has a kink there.
fn angle_gradient(a: Vec3, b: Vec3) -> Vec3 {
    let cross = a.cross(&b);
    let sine = cross.norm();
    if sine == 0.0 {
        return Vec3::zeros();
    }
    let rate = cross.cross(&a) / sine;
    (a.dot(&b) * rate - sine * a) * (1.0 / (a.norm_squared() * b.norm_squared())).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::statistics::larger;

    /// The direction n₀ = e_x rotated by θ towards e_y, then raised towards e_z by β.
    fn direction(angle: f64, out: f64) -> Vec3 {
        let (angle, out) = (angle.to_radians(), out.to_radians());
        3.0 * Vec3::new(out.cos() * angle.cos(), out.cos() * angle.sin(), out.sin())
    }

    fn follow(winding: &Winding, path: impl Iterator<Item = Vec3>) -> Vec<f64> {
        let mut memory = [0.0; Winding::MEMORY];
        path.map(|n| {
            winding.remember(n, &mut memory);
            memory[0]
        })
        .collect()
    }

    /// In a plane the angle is that of the motion, forwards and back over three turns, in steps of 7° and of 85°.
    #[test]
    fn a_motion_in_a_plane_is_followed_over_any_number_of_rotations() {
        for axis in [None, Some(Vec3::z()), Some(-Vec3::z())] {
            let winding = Winding::new(0.2 * Vec3::x(), axis);
            for step in [7.0, 85.0] {
                let up = (0..).map(|k| step * f64::from(k)).take_while(|a| *a < 1100.0);
                let path: Vec<f64> = up.clone().chain(up.collect::<Vec<_>>().into_iter().rev()).collect();
                let found = follow(&winding, path.iter().map(|&a| direction(a, 0.0)));
                let turn = if axis == Some(-Vec3::z()) { -1.0 } else { 1.0 };
                for (found, exact) in found.iter().zip(&path) {
                    assert!((found - turn * exact).abs() < 1e-9, "{axis:?}, steps of {step}°: {found} at {exact}");
                }
            }
        }
    }

    /// Without an axis the angle has no sign in its first half turn; with one it has.
    #[test]
    fn only_an_axis_gives_the_first_half_turn_a_sign() {
        let path = [0.0, 40.0, 5.0, -5.0, -60.0, -100.0, -20.0, 10.0];
        let free = follow(&Winding::new(Vec3::x(), None), path.iter().map(|&a| direction(a, 0.0)));
        let signed = follow(&Winding::new(Vec3::x(), Some(Vec3::z())), path.iter().map(|&a| direction(a, 0.0)));
        for ((free, signed), exact) in free.iter().zip(signed).zip(path) {
            assert!((free - exact.abs()).abs() < 1e-9 && (signed - exact).abs() < 1e-9, "{free} {signed} {exact}");
        }
    }

    /// A direction passes the opposite pole at a distance of β in either sense, in steps far above and below β: the pole counts as passed in all cases, and
    /// the angle jumps by 2β, from 180° − β to 180° + β.
    #[test]
    fn a_pole_is_passed_whatever_the_steps() {
        let winding = Winding::new(Vec3::x(), None);
        for out in [2.0, -2.0] {
            for step in [10.0, 1.0, 0.1] {
                let path: Vec<f64> = (0..).map(|k| step * f64::from(k)).take_while(|a| *a < 230.0).collect();
                let found = follow(&winding, path.iter().map(|&a| direction(a, out * (a / 180.0).min(1.0))));
                assert!((found[found.len() - 1] - path[path.len() - 1]).abs() < 0.1, "{found:?}");
                let jump = found.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, larger);
                assert!(jump <= 2.0 * 2.0 + step + 1e-9, "{jump}");
            }
        }
    }

    /// A tilt of 120° that goes around the direction at rest remains a tilt of 120°.
    #[test]
    fn a_motion_around_a_pole_passes_nothing() {
        let winding = Winding::new(Vec3::x(), None);
        let tilt = |a: f64| (0.5 * a).min(120.0).to_radians();
        let round = |a: f64| (a - 240.0).max(0.0).to_radians();
        let at = |a: f64| Vec3::new(tilt(a).cos(), tilt(a).sin() * round(a).cos(), tilt(a).sin() * round(a).sin());
        let found = follow(&winding, (0..120).map(|k| at(10.0 * f64::from(k))));
        assert!(found[24..].iter().all(|a| (a - 120.0).abs() < 1e-9), "{found:?}");
    }

    /// The derivatives agree with central differences with a step of 1e-6 (error 1e-9 of the angle), in all half turns.
    #[test]
    fn derivatives_are_those_of_the_angle() {
        for axis in [None, Some(Vec3::new(0.1, -0.2, 1.0).normalize())] {
            let winding = Winding::new(Vec3::new(1.0, 0.1, -0.1), axis);
            let mut memory = [0.0; Winding::MEMORY];
            for angle in (0..60).map(|k| 13.0 * f64::from(k) + 1.0) {
                let now = direction(angle, 5.0);
                winding.remember(now, &mut memory);
                let exact = winding.gradient(now, &memory);
                for i in 0..3 {
                    let value = |h: f64| {
                        let mut memory = memory;
                        winding.remember(now + Vec3::ith(i, h), &mut memory);
                        memory[0]
                    };
                    let difference = (value(1e-6) - value(-1e-6)) / 2e-6;
                    assert!(
                        (exact[i] - difference).abs() < 1e-6 * exact.norm(),
                        "{axis:?} {angle}: {exact} {difference}"
                    );
                }
            }
        }
    }
}
