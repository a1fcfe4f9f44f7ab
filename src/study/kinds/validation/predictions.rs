//! `predictions.toml`: every prediction with its interval and budget.

use crate::study::analysis::Analysis;
use crate::study::kinds::validation::budget::COVERAGE;
use crate::study::kinds::validation::findings::ValidationFindings;
use toml::{Table, Value};

/// Returns the text of the file.
pub fn text(a: &Analysis<ValidationFindings>, study: &str) -> String {
    let one = |p: &crate::study::kinds::validation::findings::Prediction| -> Value {
        let mut t = Table::new();
        t.insert("record".into(), p.experiment.clone().into());
        t.insert("quantity".into(), p.quantity.clone().into());
        t.insert("unit".into(), p.unit.clone().into());
        t.insert("value".into(), p.value.into());
        t.insert("low".into(), p.interval[0].into());
        t.insert("high".into(), p.interval[1].into());
        let budget = p.budget.iter().map(|c| (c.group.clone(), Value::from(COVERAGE * c.deviation)));
        t.insert("budget".into(), budget.collect::<Table>().into());
        t.into()
    };
    let mut all = Table::new();
    all.insert("study".into(), study.into());
    all.insert("confidence".into(), 0.95.into());
    all.insert("prediction".into(), a.predictions.iter().map(one).collect::<Vec<_>>().into());
    let body = toml::to_string(&all).unwrap_or_default();
    format!(
        "# Values with 95 % intervals of a further measurement; `budget` has the half-width that each group alone would give.\n{body}"
    )
}
