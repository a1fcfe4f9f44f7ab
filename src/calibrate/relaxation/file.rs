//! `prony.toml`: a series that the effect `viscoelastic` includes, with its provenance.
//!
//! ```toml
//! prony = [{ g = 0.2, tau = "0.5 s" }]
//! [provenance]
//! data = "…"
//! ```

use super::error::RelaxationError;
use super::result::RelaxationFit;
use crate::calibrate::Bounded;
use crate::storage;
use std::path::Path;
use toml::{Table, Value};

impl RelaxationFit {
    /// Writes the file that the effect `viscoelastic` includes.
    pub fn write_series(&self, path: &Path) -> Result<(), RelaxationError> {
        storage::write(path, text(self).as_bytes())
            .map_err(|source| RelaxationError::Write { path: path.into(), source })
    }
}

/// The file without its provenance: (g, τ \[s\]) of each term.
pub fn series_table(terms: impl IntoIterator<Item = (f64, f64)>) -> Table {
    let term = |(g, tau): (f64, f64)| {
        Value::from(Table::from_iter([("g".to_string(), Value::from(g)), ("tau".to_string(), seconds(tau))]))
    };
    Table::from_iter([("prony".to_string(), terms.into_iter().map(term).collect::<Vec<_>>().into())])
}

fn seconds(t: f64) -> Value {
    Value::from(format!("{t} s"))
}

/// Text of the file. Numbers have all their digits; there is no date, so that the same fit gives the same file.
fn text(fit: &RelaxationFit) -> String {
    let ends = |b: &Bounded| Value::from(b.interval.to_vec());
    let mut root = series_table(fit.terms.iter().map(|t| (t.g.value, t.tau.value)));
    let mut p = Table::new();
    p.insert("data".into(), fit.data.clone().into());
    p.insert("sha256".into(), fit.data_sha256.clone().into());
    p.insert("experiment".into(), fit.experiment.name().into());
    if let Some(ramp) = fit.ramp {
        p.insert("ramp".into(), seconds(ramp));
    }
    p.insert("times".into(), Value::from(fit.span.map(seconds).to_vec()));
    p.insert("rows".into(), i64::try_from(fit.rows).expect("a table has fewer rows").into());
    p.insert("unit".into(), fit.unit.clone().into());
    for (name, b) in [
        ("instantaneous", &fit.instantaneous),
        ("long_term", &fit.long_term),
        ("long_term_share", &fit.long_term_share),
    ] {
        p.insert(name.into(), b.value.into());
        p.insert(format!("{name}_interval"), ends(b));
    }
    p.insert("g_intervals".into(), fit.terms.iter().map(|t| ends(&t.g)).collect::<Vec<_>>().into());
    p.insert("tau_intervals_s".into(), fit.terms.iter().map(|t| ends(&t.tau)).collect::<Vec<_>>().into());
    p.insert("terms".into(), fit.chosen_by.clone().into());
    p.insert("errors".into(), fit.errors.words(fit.experiment.responses()).into());
    p.insert("misfit".into(), fit.misfit.into());
    p.insert("determined".into(), fit.is_determined().into());
    p.insert("warnings".into(), fit.summary.messages.clone().into());
    p.insert("durometer".into(), fit.version.into());
    root.insert("provenance".into(), p.into());
    toml::to_string(&root).expect("a table of strings, numbers and arrays can be written")
}
