//! Sweeps: a scene over values of its keys.

pub mod analysis;
pub mod figures;
pub mod report;

use crate::scene::SceneError;
use crate::study::analysis::Analysis;
use crate::study::axis::{self, AxisSpec, Combine};
use crate::study::content::Content;
use crate::study::kind::{Expansion, StudyKind};
use crate::study::spec::{Mistake, VariantSpec, check_names, check_quantities, refuse};
use crate::study::store::record::StoredCase;
use crate::study::store::results::Results;
use analysis::{Judged, SweepFindings, SweepRecord, analyse};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;

/// Keys of a sweep.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepStudy {
    /// Variants: ways of driving the scene, with the quantities judged there
    #[serde(rename = "variant", default)]
    pub variants: Vec<VariantSpec>,
    /// The keys that are swept
    #[serde(rename = "axis", default)]
    pub axes: Vec<AxisSpec>,
    /// How several axes are combined
    #[serde(default)]
    pub combine: Combine,
    /// The value of a run that is judged
    #[serde(default)]
    pub judged: Judged,
}

impl SweepStudy {
    fn points(self, scene: &Path) -> Result<Expansion<SweepRecord>, Mistake> {
        check_quantities(&self.variants)?;
        let names: Vec<String> = self.axes.iter().map(|a| a.name.clone()).collect();
        check_names(&names).map_err(|(k, fact, remedy)| (format!("axis {}", k + 1), fact, remedy.to_string()))?;
        if self.axes.is_empty() {
            let remedy = "add an [[axis]] with name, keys, label, symbol, unit and values";
            return Err(("study".into(), "the sweep has no axis".into(), remedy.into()));
        }
        for v in &self.variants {
            axis::check_apart(&self.axes, &[(format!("variant {}", v.name), &v.set)], scene)?;
        }
        let axis::Expanded { family, axes, points } = axis::expand(&self.axes, self.combine)?;
        Ok(Expansion::new(self.variants, vec![family], SweepRecord { axes, points, judged: self.judged }))
    }
}

impl StudyKind for SweepStudy {
    const NAME: &'static str = "sweep";
    type Details = SweepRecord;
    type Findings = SweepFindings;

    fn expand(self, file: &Path, scene: &Path) -> Result<Expansion<SweepRecord>, SceneError> {
        self.points(scene).map_err(|mistake| refuse(file, mistake))
    }

    fn judged(case: &StoredCase, quantity: &str, sweep: &SweepRecord) -> Option<f64> {
        sweep.judged.of(case, quantity)
    }

    fn analyse(results: &Results, sweep: &SweepRecord) -> Analysis<SweepFindings> {
        analyse(&results.study, sweep, &results.cases)
    }

    fn report(results: &Results, analysis: &Analysis<SweepFindings>) -> Content {
        let errors = "No error bar is computed along a sweep; the error of the mesh is that of a convergence study of the same scene."
            .into();
        Content { errors, ..report::content(results, analysis) }
    }
}
