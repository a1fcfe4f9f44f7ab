//! Everything that a scene records, in the order of the columns.

use super::recorder::Recorder;

/// Recorders of probes, cables, cavities, rigid bodies and contacts.
pub(in crate::scene) fn recorders<'a, A: Recorder, B: Recorder, C: Recorder, D: Recorder>(
    probes: &'a [Box<dyn Recorder>],
    cables: &'a [A],
    cavities: &'a [B],
    rigids: &'a [C],
    contacts: &'a [D],
) -> impl Iterator<Item = &'a dyn Recorder> {
    probes.iter().map(|r| &**r).chain(each(cables)).chain(each(cavities)).chain(each(rigids)).chain(each(contacts))
}

fn each<T: Recorder>(all: &[T]) -> impl Iterator<Item = &dyn Recorder> {
    all.iter().map(|r| r as &dyn Recorder)
}

/// Names of all recorded columns: time first, iterations last.
pub(in crate::scene) fn columns<'a>(recorders: impl Iterator<Item = &'a dyn Recorder>) -> Vec<String> {
    let own = recorders.flat_map(|r| r.columns());
    std::iter::once("t_s".into()).chain(own).chain(std::iter::once("newton_iterations".into())).collect()
}
