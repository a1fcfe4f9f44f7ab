//! Lines of the audit log of an evaluation.

use super::body::Pose;
use super::curve::Curve;
use super::plateau::{PlateauDoubt, PlateauRule};
use super::registration::Registration;
use super::release::{Release, ReleaseRule};
use super::request::MotionRequest;
use super::ring_down::RingDown;
use crate::math::tensor::Vec3;
use crate::math::units::shown;
use crate::scene::column;

fn window([from, to]: [f64; 2]) -> String {
    format!("{from:.4} s to {to:.4} s")
}

fn millimetres(v: Vec3) -> String {
    format!("({:.3}, {:.3}, {:.3}) mm", 1e3 * v.x, 1e3 * v.y, 1e3 * v.z)
}

/// Formats a value of a curve with its unit; lengths are in mm.
pub fn amount(x: f64, curve: &str) -> String {
    match column::words(curve).1 {
        "m" => format!("{:.4} mm", 1e3 * x),
        unit => format!("{x:.4e} {unit}").trim_end().into(),
    }
}

/// The line on how the states are found.
pub fn states(guide: &Curve, rule: &PlateauRule) -> String {
    let tolerance = rule.tolerance_of(guide);
    format!(
        "states are found in {}, which moves most: range {}, noise {}, tolerance ±{}, at least {} s",
        guide.name,
        amount(guide.range(), &guide.name),
        amount(guide.noise(), &guide.name),
        amount(tolerance, &guide.name),
        shown(rule.least_s(guide))
    )
}

/// Lines on the windows of the held and final states.
pub fn windows(held: Option<[f64; 2]>, last: Option<[f64; 2]>) -> Vec<String> {
    let one = |(state, at): (&str, Option<[f64; 2]>)| {
        at.map_or(format!("there is no {state} state"), |w| format!("{state} state: {}", window(w)))
    };
    [("held", held), ("final", last)].map(one).to_vec()
}

/// The reason to doubt the level of a state of a curve.
pub fn doubt(curve: &str, state: &str, found: &PlateauDoubt) -> String {
    let PlateauDoubt::Drifts { change, duration_s, deviation } = found;
    format!(
        "{curve}, {state} state: the plateau drifts by {} in {duration_s:.3} s (deviation {}): its level depends on the window",
        amount(*change, curve),
        amount(*deviation, curve)
    )
}

/// Returns the reason to doubt states that are found in a curve which ends before the record does.
pub fn ends_early(guide: &Curve, time_s: &[f64]) -> Option<String> {
    let (last, end) = (guide.time_s.last()?, time_s.last()?);
    let fact = || {
        format!(
            "{}, in which the states are found, is last seen at {last} s, and the record ends at {end} s",
            guide.name
        )
    };
    (last < end).then(fact)
}

/// Returns the reason to doubt a registration or the motion of a body that refers to the final state, because no state is held.
pub fn without_held(held: Option<[f64; 2]>, last: Option<[f64; 2]>, request: &MotionRequest) -> Option<String> {
    let what = match (&request.reference, &request.body) {
        (Some(_), _) => {
            "the final state is registered onto the reference, which is right only for markers that do not move"
        }
        (None, Some(_)) => "the body is followed from its final state, in which its displacement is zero by definition",
        (None, None) => return None,
    };
    (held.is_none() && last.is_some())
        .then(|| format!("there is no held state: {what}; state the window of the held state if there is one"))
}

/// The line on the release.
pub fn release(guide: &str, found: &Release, rule: &ReleaseRule) -> String {
    let rule = match (rule.factor, rule.threshold) {
        (0.0, _) => "as given".into(),
        (factor, 0.0) => format!("{factor} standard deviations"),
        (factor, least) => format!("{factor} standard deviations, at least {}", amount(least, guide)),
    };
    format!(
        "release between {:.4} s and {:.4} s: the last row before {guide} leaves the held state by more than {} ({rule}) for three rows",
        found.time_s,
        found.next_s,
        amount(found.limit, guide)
    )
}

/// Lines on a registration.
pub fn registration(found: &Registration, names: &[String], reference: &str) -> Vec<String> {
    let turn = found.rotation_half_widths().map(f64::to_degrees);
    let mut lines = vec![format!(
        "the markers {} were registered onto {reference}: rms {:.4} mm, size ratio {:.5}, rotation ±({:.3}, {:.3}, {:.3})° (95 %, {} degrees of freedom)",
        names.join(", "),
        1e3 * found.rms,
        found.size_ratio,
        turn.x,
        turn.y,
        turn.z,
        found.free
    )];
    for ((name, e), left) in names.iter().zip(&found.residuals).zip(&found.leave_one_out) {
        let out = left.map_or("not predictable by the others".into(), |d| {
            format!("{:.4} mm from its prediction by the others", 1e3 * d)
        });
        lines.push(format!("residual of {name}: {}, {out}", millimetres(*e)));
    }
    lines
}

/// Lines on a body.
pub fn body(names: &[String], at: Vec3, poses: &[Pose]) -> Vec<String> {
    let worst = poses.iter().max_by(|a, b| a.rms.total_cmp(&b.rms));
    let worst =
        worst.map(|p| format!("the group deforms by {:.4} mm (rms) at most, at {:.4} s", 1e3 * p.rms, p.time_s));
    let mut lines = vec![format!("body of {}, followed at {} of its reference", names.join(", "), millimetres(at))];
    lines.extend(worst);
    lines
}

/// Returns the reason to doubt that a group is rigid, if it deforms by more than a twentieth of its size.
pub fn deformation(reference: &[Vec3], poses: &[Pose]) -> Option<String> {
    const RIGID: f64 = 0.05;
    let n = reference.len() as f64;
    let centre = reference.iter().sum::<Vec3>() / n;
    let size = (reference.iter().map(|x| (x - centre).norm_squared()).sum::<f64>() / n).sqrt();
    let worst = poses.iter().max_by(|a, b| a.rms.total_cmp(&b.rms)).filter(|p| p.rms > RIGID * size)?;
    Some(format!(
        "the group deforms by {:.0} % of its size ({:.4} mm of {:.4} mm, rms) at {:.4} s: it is not rigid, or a marker moved or was confused with another",
        1e2 * worst.rms / size,
        1e3 * worst.rms,
        1e3 * size,
        worst.time_s
    ))
}

/// Lines on a ring-down.
pub fn ring_down(name: &str, r: &RingDown) -> Vec<String> {
    vec![
        format!(
            "ring-down of {name} in {} with {}: {} rows, residual {} (rms), neighbours correlated by {:.2}",
            window(r.window_s),
            r.kind.words(),
            r.rows,
            amount(r.rms, name),
            r.correlation
        ),
        format!(
            "frequency {}, decay {}, amplitude at the release {} ± {}",
            r.frequency_hz.words("Hz"),
            r.decay_per_s.words("1/s"),
            amount(r.amplitude.value, name),
            amount(r.amplitude.half_width(), name)
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drift_has_the_unit_of_its_curve() {
        let drift = PlateauDoubt::Drifts { change: -8.579e-5, duration_s: 2.175, deviation: 2.77e-5 };
        assert_eq!(
            doubt("tip1_z_m", "final", &drift),
            "tip1_z_m, final state: the plateau drifts by -0.0858 mm in 2.175 s (deviation 0.0277 mm): its level depends on the window"
        );
    }
}
