//! Random laws, rotations and deformation gradients, for checks of laws.

use super::entry::LawEntry;
use super::law::Law;
use super::parameter::{Choice, LawSpecError, Parameter};
use crate::math::random::SplitMix;
use crate::math::tensor::{Mat3, Vec3};
use crate::math::units::Dimension;

/// A rotation: a random unit quaternion.
pub fn rotation(random: &mut SplitMix) -> Mat3 {
    let [w, i, j, k] = std::array::from_fn(|_| random.between(-1.0, 1.0));
    let q = nalgebra::Quaternion::new(w, i, j, k);
    nalgebra::UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner()
}

/// Draws a law: parameters inside their bounds, moduli of either sign if that is allowed, any number of the optional parameters, any option; repeated
/// until the shear modulus at F = I is positive.
pub(super) fn law(random: &mut SplitMix, entry: &LawEntry) -> Result<Box<dyn Law>, String> {
    let info = entry.info;
    for _ in 0..1000 {
        let absent = (random.unit() * (info.optional as f64 + 1.0)) as usize;
        let mut values = Vec::new();
        for (k, p) in info.parameters[..info.parameters.len() - absent].iter().enumerate() {
            values.push(value(random, p, entry.sample.get(k).copied().unwrap_or_default()));
        }
        let option = |c: &Choice, r: f64| c.options[(r * c.options.len() as f64) as usize];
        let options: Vec<_> = info.choices.iter().map(|c| option(c, random.unit())).collect();
        match entry.build_with(&values, &options) {
            Ok(law) => return Ok(law),
            Err(LawSpecError::NotStable { .. } | LawSpecError::NoBulk { .. }) => {}
            // Half of a pair (μ, α) remains
            Err(LawSpecError::Missing { .. }) if absent > 0 => {}
            Err(e) => return Err(format!("{e} from {values:?}, which are inside their bounds")),
        }
    }
    Err("no draw of constants inside their bounds has a positive shear modulus".into())
}

/// Draws a number inside its bounds: a modulus over three decades, any other number up to ten; near the value of the example if the bounds exclude
/// these.
fn value(random: &mut SplitMix, p: &Parameter, example: f64) -> f64 {
    let (lower, upper) = p.bounds;
    let drawn = if p.dimension == Dimension::PRESSURE {
        let sign = if lower < 0.0 && random.unit() < 0.4 { -1.0 } else { 1.0 };
        let (least, most) = if sign < 0.0 { (-upper, -lower) } else { (lower, upper) };
        let (a, b) = ((1.002 * least).max(1e3), (0.9985 * most).min(1e6));
        (a < b).then(|| sign * a * (b / a).powf(random.unit()))
    } else {
        let (a, b) = (lower.max(-10.0), upper.min(10.0));
        (a < b).then(|| random.between(a + 0.002 * (b - a), b - 0.0015 * (b - a)))
    };
    drawn.unwrap_or_else(|| example + (random.unit() - 0.5) * (example - lower).min(upper - example))
}

/// Draws F with principal stretches in [0.3, 3], inverted on request, and returns it with its distance ρ to the nearest singularity of any law.
pub fn gradient(random: &mut SplitMix, inverted: bool) -> (Mat3, f64) {
    gradient_within(random, inverted, 1.0)
}

/// Draws F like [`gradient`], with the logarithms of the stretches scaled by `range`.
pub(super) fn gradient_within(random: &mut SplitMix, inverted: bool, range: f64) -> (Mat3, f64) {
    let mut s = [0, 1, 2].map(|_| (0.3 * 10_f64.powf(random.unit())).powf(range));
    s.sort_by(f64::total_cmp);
    if inverted {
        s[1] = s[1].max(s[0] + 0.3);
        s[2] = s[2].max(s[1]);
        s[0] = -s[0];
    }
    let rho = s[0].abs().min(s[0] + s[1]).min(1.0);
    (rotation(random) * Mat3::from_diagonal(&Vec3::from(s)) * rotation(random), rho)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gels are softer, and composites stiffer, than most laws that are drawn.
    #[test]
    fn numbers_are_drawn_inside_any_bounds() {
        let mut random = SplitMix(3);
        for (bounds, example) in [
            ((0.0, 1e3), 400.0),
            ((1e6, 1e9), 1e7),
            ((-500.0, 500.0), 100.0),
            ((-1e4, -2e3), -5e3),
            ((2e3, 3e3), 2.5e3),
            (Parameter::POSITIVE, 1e5),
        ] {
            for dimension in [Dimension::PRESSURE, Dimension::NONE] {
                let p = Parameter::new("a", "a", dimension, bounds, "a number");
                for _ in 0..100 {
                    let drawn = value(&mut random, &p, example);
                    assert!(bounds.0 < drawn && drawn < bounds.1, "{drawn} in {bounds:?}");
                }
            }
        }
    }
}
