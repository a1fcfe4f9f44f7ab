//! Unusual features of a table: data points that are used unchanged, and reasons to doubt all of it.

use super::audit::{Audit, AuditKind};
use super::columns::Columns;
use super::names::{self, StrainKind};
use crate::calibrate::{Mode, Sample};
use std::collections::HashMap;

/// Logs unusual data points, which are used unchanged.
pub fn data_points(audit: &mut Audit, samples: &[Sample]) {
    let mut seen: HashMap<(Mode, u64), f64> = HashMap::new();
    let mut last: HashMap<Mode, f64> = HashMap::new();
    let (mut twice, mut repeats, mut back, mut against, mut offset) = (vec![], vec![], vec![], vec![], vec![]);
    // The two samples of a biaxial data point share a line, and either direction may be held or reversed
    for s in samples.iter().filter(|s| s.mode != Mode::Biaxial) {
        match seen.insert((s.mode, s.stretch.to_bits()), s.stress) {
            Some(p) if p == s.stress => twice.push(s.line),
            Some(_) => repeats.push(s.line),
            None => {}
        }
        if last.insert(s.mode, s.stretch).is_some_and(|before| s.stretch < before) {
            back.push(s.line);
        }
        if s.stretch == 1.0 && s.stress != 0.0 {
            offset.push(s.line);
        } else if s.stress * (s.stretch - 1.0) < 0.0 {
            against.push(s.line);
        }
    }
    let kept = AuditKind::Kept;
    audit.add_rows(kept, "data point occurs before with the same stretch and stress; each occurrence counts", twice);
    audit.add_rows(kept, "stretch occurs before with another stress; both count", repeats);
    audit.add_rows(
        kept,
        "stretch is smaller than in the data point before (order of the file or unloading); the order does not enter the fit, \
         unloading would",
        back,
    );
    audit.add_rows(kept, "stress has the sign against its stretch (negative under tension)", against);
    audit.add_rows(kept, "stress is not zero at stretch 1; the offset was not subtracted", offset);
}

pub fn doubts(
    audit: &mut Audit,
    samples: &[Sample],
    columns: &Columns,
    measured: Option<&str>,
    header: &[(String, String)],
) {
    let stated = measured.map(str::to_lowercase);
    let said = header.iter().find(|(key, value)| {
        let (key, value) = (key.to_lowercase(), value.to_lowercase());
        value.contains("crosshead") || key.contains("crosshead") || (key == "strain measurement" && value == "global")
    });
    let strains = || columns.axes.iter().map(|(e, _)| e);
    let raw = strains().find(|e| e.kind == StrainKind::Displacement);
    let named = strains().find(|e| e.kind == StrainKind::Engineering && names::is_travel(&e.name));
    let source = match (&stated, said, raw) {
        (Some(word), _, _) => word.contains("crosshead").then(|| "as stated".to_string()),
        (None, Some((k, v)), _) => Some(format!("by the header, \"{k}: {v}\"")),
        (None, None, Some(e)) => Some(format!(
            "which is what a column \"{}\" usually holds; if it is the travel of an extensometer pass --strain-from extensometer",
            e.name
        )),
        (None, None, None) => named.map(|e| format!("by the name of column \"{}\"", e.name)),
    };
    if let Some(source) = source {
        audit.add(
            AuditKind::Doubt,
            format!(
                "strain comes from crosshead travel ({source}): it counts the stretch of the wide ends as if it were \
                 the gauge length's, so the fitted stiffness is too low; only a fit of the whole specimen corrects it"
            ),
            vec![],
        );
    }
    let unread = samples.len() + audit.of(AuditKind::LeftOut).count();
    if samples.len() * 10 < unread * 9 {
        let message = format!("{} of {unread} data points could not be read", unread - samples.len());
        audit.add(AuditKind::Doubt, message, vec![]);
    }
}
