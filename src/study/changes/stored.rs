//! The part of a stored result that is used to compare two results.

use crate::report::numbers::space;
use crate::report::{ReportError, files};
use crate::study::claim::Claim;
use crate::study::kinds;
use crate::study::store::outdated::{check_summary, stored_identity};
use crate::study::store::record::{StudyQuantity, StudyRecord};
use crate::study::store::results;
use serde::Deserialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A stored result.
#[derive(Clone, Debug, Deserialize)]
pub struct StoredSummary {
    pub study: String,
    pub kind: String,
    pub tolerance: f64,
    pub cases: Vec<ComparedCase>,
    pub verdict: String,
    /// Absent in results of earlier versions
    #[serde(default)]
    supported: Option<bool>,
    /// Absent in results of earlier versions
    #[serde(default)]
    pub decisions: Option<BTreeMap<String, String>>,
    #[serde(default)]
    analysis: Value,
    pub version: String,
    /// Absent in results of earlier versions
    #[serde(default)]
    pub claims: Vec<Claim>,
    /// Variant → judged quantities, from `study.json`
    #[serde(skip)]
    pub quantities: BTreeMap<String, Vec<StudyQuantity>>,
    /// Settings that affect how values are judged, except the tolerance: name → setting, from `study.json`
    #[serde(skip)]
    pub settings: BTreeMap<String, String>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct ComparedCase {
    pub id: String,
    #[serde(default)]
    pub variant: String,
    pub status: String,
    pub mesh: StoredMesh,
    #[serde(default)]
    pub cpu_s: f64,
    #[serde(default)]
    pub probes: BTreeMap<String, StoredPeak>,
    /// Quantity → value by which it is judged; absent in results of earlier versions
    #[serde(default)]
    pub judged: BTreeMap<String, f64>,
    /// Digest of its inputs, from its record
    #[serde(skip)]
    pub identity: Option<String>,
}

#[derive(Clone, Debug, Deserialize)]
pub struct StoredMesh {
    pub cells: usize,
}

#[derive(Clone, Debug, Deserialize)]
pub struct StoredPeak {
    pub peak: f64,
}

impl ComparedCase {
    /// The recorded columns that a study judges, with the names of their values.
    pub fn values<'a>(&'a self, of: &'a StoredSummary) -> impl Iterator<Item = (&'a str, String)> + 'a {
        let judged = self.probes.keys().filter(|column| of.judged(self, column).is_some());
        judged.map(|column| (column.as_str(), format!("{}: {column}", self.id)))
    }
}

/// The settings that affect how a study judges values, except its tolerance: scalar values among its details, and absolute tolerances of quantities.
fn settings(study: &StudyRecord) -> BTreeMap<String, String> {
    let words = |value: &Value| match value {
        Value::String(words) => Some(words.clone()),
        Value::Null => Some("none".into()),
        Value::Array(_) | Value::Object(_) => None,
        number => Some(number.to_string()),
    };
    let details = study.details.as_object().into_iter().flatten();
    let own = details.filter_map(|(key, value)| Some((key.clone(), words(value)?)));
    let quantities = study.quantities.iter().flat_map(|(variant, all)| all.iter().map(move |q| (variant, q)));
    let tolerances = quantities.map(|(variant, q)| {
        let tolerance = q.absolute_tolerance.map_or("none".into(), |t| format!("{t}{}", space(&q.unit)));
        (format!("absolute tolerance of {}, {variant}", q.name), tolerance)
    });
    own.chain(tolerances).collect()
}

impl StoredSummary {
    /// Reads `summary.json`, the quantities of `study.json` and the identities in the records of a folder.
    ///
    /// # Errors
    /// Files that are missing, cannot be read or are not results of a study, and a summary that is older than the results.
    pub fn read(dir: &Path) -> Result<Self, ReportError> {
        let path = dir.join("summary.json");
        let mut summary: Self = files::json(&path)?.ok_or(ReportError::NoSummary { path })?;
        for case in &mut summary.cases {
            case.identity = stored_identity(dir, &case.id).filter(|digest| !digest.is_empty());
        }
        let study: Option<StudyRecord> = files::json(&dir.join("study.json"))?;
        if let Some(study) = study {
            check_summary(dir, &study)?;
            summary.judge(dir, &study);
            summary.settings = settings(&study);
            summary.quantities = study.quantities;
        }
        Ok(summary)
    }

    /// Computes the judged values of a summary that an earlier version wrote, from the stored curves.
    fn judge(&mut self, dir: &Path, study: &StudyRecord) {
        let Some(kind) = kinds::find(&study.kind) else { return };
        let without = self.cases.iter_mut().filter(|case| case.judged.is_empty());
        let (mut cases, stored): (Vec<_>, Vec<_>) = without
            .filter_map(|case| {
                let stored = results::stored(dir, &case.id).ok().flatten()?;
                (!stored.series.t_s.is_empty()).then_some((case, stored))
            })
            .unzip();
        for (case, judged) in cases.iter_mut().zip((kind.judged)(study, &stored)) {
            case.judged = judged;
        }
    }

    /// The quantity in a column of a case, if the study judges it.
    pub fn judged(&self, case: &ComparedCase, column: &str) -> Option<&StudyQuantity> {
        self.quantities.get(&case.variant)?.iter().find(|q| q.name == column)
    }

    /// Whether a value has an error bar.
    pub fn has_bar(&self, what: &str) -> bool {
        self.claims.iter().any(|c| c.what == what)
    }

    /// The names of all values, with and without error bars.
    fn names(&self) -> BTreeSet<String> {
        let of_cases = self.cases.iter().flat_map(|c| c.values(self).map(|(_, what)| what));
        self.claims.iter().map(|c| c.what.clone()).chain(of_cases).collect()
    }

    /// The values that both results have.
    pub fn in_both(&self, other: &Self) -> BTreeSet<String> {
        let (own, others) = (self.names(), other.names());
        own.intersection(&others).cloned().collect()
    }

    /// The values that the other result lacks, except those of the given cases.
    pub fn values_without(&self, other: &Self, cases: &[String]) -> Vec<String> {
        let is_of = |what: &String, case: &String| what.strip_prefix(case).is_some_and(|rest| rest.starts_with(':'));
        let (own, others) = (self.names(), other.names());
        own.difference(&others).filter(|what| !cases.iter().any(|case| is_of(what, case))).cloned().collect()
    }

    /// Whether only one of the two results has a verdict. Earlier versions say so only in the text of the verdict.
    pub fn differs_in_support(&self, other: &Self) -> bool {
        let refuses = |s: &Self| s.verdict.starts_with("No verdict");
        let stated = self.supported.zip(other.supported);
        stated.map_or_else(|| refuses(self) != refuses(other), |(own, other)| own != other)
    }

    /// A case of the recommended setting, if the study recommends one.
    pub fn recommended(&self) -> Option<&str> {
        self.analysis["recommended_case"].as_str()
    }

    /// Whether the setting of a case is within the tolerance, in a study that recommends settings; true for a setting that was not run.
    pub fn accepts(&self, case: &str) -> bool {
        let is_of = |setting: &&Value| setting["cases"].as_array().is_some_and(|ids| ids.iter().any(|id| id == case));
        let setting = self.analysis["settings"].as_array().and_then(|all| all.iter().find(is_of));
        setting.is_none_or(|s| s["worst"].as_f64().is_some_and(|bar| bar <= self.tolerance))
    }
}
