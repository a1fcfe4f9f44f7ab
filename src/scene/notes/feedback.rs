//! Feedback of columns on signals that is itself unstable.
//!
//! A signal that is computed from columns of the run acts one step late. A loop that answers a change by a larger one of opposite sign therefore grows from
//! step to step, whatever the loads are, until no equilibrium is found.

use crate::scene::signal::protocol::NamedSignal;

/// Number of last changes of a signal that must alternate and grow.
const CHANGES: usize = 3;

/// A note for each signal with inputs whose last changes alternate and grow before the end of a run that stopped; `values`: \[rows × signals\] of `signals`.
pub fn growing_feedback(signals: &[NamedSignal], values: &[Vec<f64>]) -> Vec<String> {
    let fed_back = signals.iter().enumerate().filter(|(_, s)| s.signal.has_inputs());
    let growing = fed_back.filter(|(k, _)| {
        let changes: Vec<f64> = values.windows(2).map(|two| two[1][*k] - two[0][*k]).collect();
        let last = changes.len().checked_sub(CHANGES).map_or(&[][..], |from| &changes[from..]);
        !last.is_empty() && last.windows(2).all(|two| two[0] * two[1] < 0.0 && two[1].abs() > two[0].abs())
    });
    let note = |(_, signal): (usize, &NamedSignal)| {
        format!(
            "{} alternates by more from row to row before the end: what is computed from columns acts one step late, and this loop is unstable by itself, \
             whatever a limit point says of the loads; let it follow a part of its change in each step, or drive what it computes",
            signal.name
        )
    };
    growing.map(note).collect()
}
