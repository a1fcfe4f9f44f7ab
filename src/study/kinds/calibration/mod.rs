//! Calibration: the constants of a law from a scene that reproduces measured curves.

pub mod analysis;
pub mod band;
pub mod corners;
pub mod figures;
pub mod findings;
mod methods;
pub mod report;
mod words;

use crate::calibrate::inverse::MeasuredSpec;
use crate::scene::{SceneError, changes};
use crate::schema::AnyTable;
use crate::study::analysis::Analysis;
use crate::study::calibration_plan::{CalibrationPlan, CalibrationSpec, CurveSpec, UseSpec};
use crate::study::content::Content;
use crate::study::kind::{Expansion, StudyKind};
use crate::study::spec::{FamilySpec, VariantSpec, check_quantities, refuse};
use crate::study::store::record::{Role, StudyQuantity};
use crate::study::store::results::Results;
use analysis::analyse;
use findings::CalibrationFindings;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;

/// Keys of a calibration.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationStudy {
    /// The constants to be found
    pub calibration: CalibrationSpec,
    /// Variants: ways of driving the scene, with the quantities judged there
    #[serde(rename = "variant", default)]
    pub variants: Vec<MeasuredVariantSpec>,
    /// Families of cases that differ in one respect
    #[serde(rename = "family", default)]
    pub families: Vec<FamilySpec>,
    /// Scene in which the law is used afterwards
    #[serde(rename = "use")]
    pub usage: Option<UseSpec>,
}

/// A variant with the curve that its scene is to reproduce.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredVariantSpec {
    /// Part of the case ids
    pub name: String,
    /// Name in words, for sentences and figures; `name` if absent
    pub label: Option<String>,
    /// Changes by path
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// Quantities that are reported
    #[serde(rename = "quantity", default)]
    pub quantities: Vec<StudyQuantity>,
    /// Measured curve that the scene is to reproduce
    pub measured: MeasuredSpec,
    /// Further curves that depend on the same constants
    #[serde(rename = "curve", default)]
    pub curves: Vec<CurveSpec>,
}

impl StudyKind for CalibrationStudy {
    const NAME: &'static str = "calibration";
    type Details = ();
    type Findings = CalibrationFindings;
    const ROLES: &'static [Role] = &[Role::Sizes, Role::TimeStep, Role::Nuisance];

    fn expand(self, file: &Path, _: &Path) -> Result<Expansion<()>, SceneError> {
        let Self { calibration, variants, mut families, usage } = self;
        if calibration.unknown.is_empty() {
            let remedy = "name constants of the scene, such as \"laws.rubber.mu\"";
            let mistake = ("calibration.unknown".into(), "nothing is to be found".into(), remedy.into());
            return Err(refuse(file, mistake));
        }
        let is_used = usage.as_ref().map_or(Ok(()), |usage| usage.check(&calibration.unknown));
        is_used.map_err(|mistake| refuse(file, mistake))?;
        let base = file.parent().unwrap_or(Path::new(""));
        let plan = |v: &MeasuredVariantSpec| {
            let plan = CalibrationPlan::new(base, &calibration, (&v.name, &v.measured), &v.curves).map_err(|e| {
                SceneError::Part { file: file.into(), place: format!("variant {}", v.name), source: e.into() }
            })?;
            Ok((v.name.clone(), Arc::new(plan)))
        };
        let plans = variants.iter().map(plan).collect::<Result<_, SceneError>>()?;
        let plain = |v: MeasuredVariantSpec| {
            let MeasuredVariantSpec { name, label, set, quantities, .. } = v;
            VariantSpec { name, label, group: None, set, quantities, scene: None }
        };
        let variants: Vec<VariantSpec> = variants.into_iter().map(plain).collect();
        check_quantities(&variants).map_err(|mistake| refuse(file, mistake))?;
        if calibration.corners {
            families.push(corners::family(&families).map_err(|mistake| refuse(file, mistake))?);
        }
        Ok(Expansion { plans, usage, ..Expansion::new(variants, families, ()) })
    }

    fn analyse(results: &Results, (): &()) -> Analysis<CalibrationFindings> {
        analyse(&results.study, &results.cases, &results.found)
    }

    fn report(results: &Results, analysis: &Analysis<CalibrationFindings>) -> Content {
        Content { errors: methods::errors(analysis), ..report::content(results, analysis) }
    }
}
