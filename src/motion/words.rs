//! Lines of the audit log of an evaluation.

use super::body::Pose;
use super::curve::Curve;
use super::plateau::PlateauRule;
use super::registration::Registration;
use super::release::{Release, ReleaseRule};
use super::ring_down::RingDown;
use crate::math::tensor::Vec3;

fn window([from, to]: [f64; 2]) -> String {
    format!("{from:.4} s to {to:.4} s")
}

fn millimetres(v: Vec3) -> String {
    format!("({:.3}, {:.3}, {:.3}) mm", 1e3 * v.x, 1e3 * v.y, 1e3 * v.z)
}

/// The line on how the states are found.
pub fn states(guide: &Curve, rule: &PlateauRule) -> String {
    let tolerance = rule.tolerance_of(guide);
    format!(
        "states are found in {}, which moves most: range {:.4e}, noise {:.2e}, tolerance ±{tolerance:.2e}, at least {} s",
        guide.name,
        guide.range(),
        guide.noise(),
        rule.least_s
    )
}

/// Lines on the windows of the states.
pub fn windows(held: Option<[f64; 2]>, last: Option<[f64; 2]>) -> Vec<String> {
    let one = |(state, at): (&str, Option<[f64; 2]>)| {
        at.map_or(format!("there is no {state} state"), |w| format!("{state} state: {}", window(w)))
    };
    [("held", held), ("final", last)].map(one).to_vec()
}

/// The line on the release.
pub fn release(guide: &str, found: &Release, rule: &ReleaseRule) -> String {
    format!(
        "release between {:.4} s and {:.4} s: the last row before {guide} leaves the held state by more than {:.3e} ({} deviations, at least {:.3e}) for three rows",
        found.time_s, found.next_s, found.limit, rule.factor, rule.threshold
    )
}

/// Lines on a registration.
pub fn registration(found: &Registration, names: &[String], reference: &str) -> Vec<String> {
    let turn = found.rotation_half_widths().map(f64::to_degrees);
    let mut lines = vec![format!(
        "the held state of {} was registered onto {reference}: rms {:.4} mm, size ratio {:.5}, rotation ±({:.3}, {:.3}, {:.3})° (95 %, {} degrees of freedom)",
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
    let mut lines = vec![format!("body of {}, followed at {} of the held state", names.join(", "), millimetres(at))];
    lines.extend(worst);
    lines
}

/// Lines on a ring-down.
pub fn ring_down(name: &str, r: &RingDown) -> Vec<String> {
    vec![
        format!(
            "ring-down of {name} in {} with {}: {} rows, residual {:.3e} (rms), neighbours correlated by {:.2}",
            window(r.window_s),
            r.kind.words(),
            r.rows,
            r.rms,
            r.correlation
        ),
        format!(
            "frequency {}, decay {}, amplitude at the release {:.4e} ± {:.1e}",
            r.frequency_hz.words("Hz"),
            r.decay_per_s.words("1/s"),
            r.amplitude.value,
            r.amplitude.half_width()
        ),
    ]
}
