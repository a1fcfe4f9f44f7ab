//! Jumps of exactly prescribed values in dynamic stages: of motions, lengths of cables and volumes of cavities.
//!
//! A mass m that must move by a distance d within one step of length Δt gains an energy of the order m d²/Δt²: the impact has no limit as Δt → 0. A load that
//! jumps has a limit, as do an elastic cable and a drive that yields.

use crate::math::signal::Signal;
use crate::scene::build::builder::Builder;
use crate::solve::TimeSpan;
use crate::system::EnergyRole;

/// Ratio of a change within one step to the changes in the steps before and after it above which it is a jump.
const SUDDEN: f64 = 10.0;
/// Relative change below which changes are rounding \[–\].
const ROUNDING: f64 = 1e-9;

/// The changes of a signal that move the body.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::scene) enum Impact {
    /// All changes, including the one from zero to the first value
    Any,
    /// Increases only, including the one from zero to the first value: a cable that is let out goes slack
    Growing,
    /// All changes from the first value on, at which a run starts
    FromPlace,
}

/// Adds a note if a signal that is recorded under this name jumps and anything has mass. A signal that is decided during the run is not checked.
pub(in crate::scene) fn note_jump(builder: &mut Builder, name: &str, signal: &Signal, impact: Impact) {
    if signal.has_inputs() || builder.effects.iter().all(|effect| effect.role() != EnergyRole::Kinetic) {
        return;
    }
    let found = builder.spans.iter().enumerate().find_map(|(k, span)| Some((k, jump(signal, span, impact)?)));
    if let Some((k, (t, change))) = found {
        let note = format!(
            "stage {}: {name} changes by {change:.4e} within one step, at t = {t:.6} s: an impact that grows without a limit the shorter dt is; let it change \
             over several steps",
            k + 1
        );
        builder.notes.extend(Some(note).filter(|note| !builder.notes.contains(note)));
    }
}

/// The first jump in a dynamic stage: the time at which it starts, and the change.
fn jump(signal: &Signal, span: &TimeSpan, impact: Impact) -> Option<(f64, f64)> {
    if span.integrator.is_static() {
        return None;
    }
    let at = |t: f64| match impact {
        Impact::Any | Impact::Growing if t <= 0.0 => 0.0,
        _ => signal.at(t.max(0.0)),
    };
    (0..span.steps().min(100_000)).find_map(|k| {
        let (start, end) = (span.point(k), span.point(k + 1));
        let (from, to) = (at(start), at(end));
        let change = to - from;
        let around = (from - at(start - span.dt)).abs().max((signal.at(end + span.dt) - to).abs());
        let moves = if impact == Impact::Growing { change } else { change.abs() };
        (moves > SUDDEN * around && moves > ROUNDING * from.abs().max(to.abs())).then_some((start, change))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solve::Integrator;

    #[test]
    fn changes_within_one_step_are_jumps() {
        let span = TimeSpan { integrator: Integrator::Bdf2, start: 0.0, end: 1.0, dt: 0.01 };
        let found = |signal: &Signal, impact| jump(signal, &span, impact).map(|(t, s)| (t, (1e9 * s).round() / 1e9));
        let ramp = |start: f64, end: f64| Signal::Ramp { from: 0.0, to: 2.0, start, end };
        let falling = Signal::Ramp { from: 2.0, to: 0.0, start: 0.5, end: 0.505 };
        let cosine = Signal::RaisedCosine { amplitude: 2.0, frequency: 3.0 };
        for smooth in [ramp(0.0, 0.1), ramp(0.3, 0.35), cosine, Signal::Constant(0.0)] {
            for impact in [Impact::Any, Impact::Growing, Impact::FromPlace] {
                assert_eq!(found(&smooth, impact), None, "{smooth:?}");
            }
        }
        assert_eq!(found(&ramp(0.3, 0.305), Impact::Growing), Some((0.3, 2.0)));
        assert_eq!(found(&falling, Impact::FromPlace), Some((0.5, -2.0)));
        assert_eq!(found(&Signal::Constant(2.0), Impact::Growing), Some((0.0, 2.0)), "it is not there at rest");
        assert_eq!(found(&Signal::Constant(2.0), Impact::FromPlace), None, "the body begins there");
        let released = Signal::Ramp { from: 2.0, to: 0.0, start: 0.5, end: 0.505 };
        let pulled = Signal::Hold { signal: Box::new(ramp(0.0, 0.4)), at: 0.3 };
        let both = Signal::Product(vec![pulled, released]);
        assert_eq!(found(&both, Impact::Growing), None, "a cable that is let go");
        assert!(found(&both, Impact::Any).is_some());
        let statics = TimeSpan { integrator: Integrator::Static, ..span };
        assert_eq!(jump(&Signal::Constant(2.0), &statics, Impact::Any), None);
    }
}
