//! Record of a study, its families and its quantities: `study.json`.

use crate::report::names::title;
use crate::study::estimate::tolerance::Tolerance;
use crate::study::store::asked::Asks;
use crate::study::store::record::CaseRecord;
use crate::study::store::series::{Place, StoredCase};
use crate::study::store::status::NOT_RUN;
use crate::wording::all;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Description of a study and its cases: `study.json`, next to the folder `cases/`.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct StudyRecord {
    /// [`SCHEMA`](crate::study::store::record::SCHEMA) of the program that wrote it; 0 in files that precede it
    #[serde(default)]
    pub schema: u32,
    /// Name of the study, which is that of its folder
    pub study: String,
    /// `convergence`, `materials`, …
    pub kind: String,
    pub question: String,
    /// The expectation before the run
    pub expectation: String,
    /// Largest accepted error bar, as a fraction of the value \[–\]
    pub tolerance: f64,
    /// Variant → the quantities judged there; a prescribed quantity is not listed
    pub quantities: BTreeMap<String, Vec<StudyQuantity>>,
    /// Variants in the order of the report: `length`, `tension`
    pub variants: Vec<String>,
    /// Variant → its label, if one is given
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub labels: BTreeMap<String, String>,
    /// Variant → heading of its group, if one is given
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub groups: BTreeMap<String, String>,
    /// Member → its label, if one is given
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub members: BTreeMap<String, String>,
    pub families: Vec<FamilyRecord>,
    /// Further details stored by its kind
    #[serde(default, skip_serializing_if = "serde_json::Value::is_null")]
    pub details: serde_json::Value,
    pub version: String,
    /// Everything requested of the cases in addition to their curves; absent in files of earlier versions
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asks: Option<Asks>,
    /// Case → digest of its inputs without the mesh, as in its identity; cases that wait for constants are absent
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub inputs_sha256: BTreeMap<String, String>,
    /// Keys in which cases differ, and which are overridden by changes of every case
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub overridden: Vec<String>,
}

impl StudyRecord {
    /// Whether a result has other inputs than the study; false if one of the two does not say, and for a case that crashed, which has no numbers.
    pub fn is_of_others(&self, record: &CaseRecord) -> bool {
        let found = &record.provenance.identity.inputs_sha256;
        !found.is_empty() && !record.broke() && self.inputs_sha256.get(&record.id).is_some_and(|own| own != found)
    }

    /// The reason why it has no verdict, if changes of every case override differences between cases.
    pub fn without_verdict(&self) -> Option<String> {
        let keys: Vec<String> = self.overridden.iter().map(|key| format!("`{key}`")).collect();
        let keys = (!keys.is_empty()).then(|| all(&keys))?;
        Some(format!(
            "No verdict: cases of this study differ by {keys}, and a change of every case, by `--set`, overrides this difference. Leave the change out, or make it \
             in a copy of the study."
        ))
    }

    /// Columns of the quantities of all variants.
    pub fn columns(&self) -> Vec<&str> {
        self.quantities.values().flatten().map(|q| q.name.as_str()).collect()
    }

    /// Whether a case is a reference run.
    pub fn is_reference(&self, id: &str) -> bool {
        self.families.iter().any(|f| f.role == Role::Reference && f.cases.iter().any(|case| case == id))
    }

    /// Case → its places in the order of the families. `unsaid` provides variant and member of a case in a family that does not list them.
    pub fn places(&self, unsaid: impl Fn(&str) -> Option<VariantMember>) -> HashMap<String, Vec<Place>> {
        let mut places: HashMap<String, Vec<Place>> = HashMap::new();
        for family in &self.families {
            for (k, id) in family.cases.iter().enumerate() {
                let found = family.members.get(k).cloned().or_else(|| unsaid(id));
                let Some(VariantMember { variant, member }) = found else { continue };
                let place = Place { family: family.name.clone(), variant, member };
                let known = places.entry(id.clone()).or_default();
                if !known.contains(&place) {
                    known.push(place);
                }
            }
        }
        places
    }

    /// The members of the families with this role in a variant, in the order of the study.
    pub fn members_in<'a>(&'a self, stored: &'a [StoredCase], role: Role, variant: &'a str) -> Vec<Member<'a>> {
        let converged = |id: &String| stored.iter().find(|c| c.record.id == *id).filter(|c| c.record.converged());
        let mut all: Vec<Member> = vec![];
        for family in self.families.iter().filter(|f| f.role == role) {
            let said = family.cases.iter().zip(&family.members).filter(|(_, m)| m.variant == variant);
            all.extend(said.map(|(id, m)| (m.member.as_str(), converged(id))));
            // A file of an earlier version does not list its members
            if family.members.is_empty() {
                let cases = stored.iter().filter(|c| c.record.converged());
                all.extend(cases.flat_map(|c| c.members(&family.name, variant).map(move |member| (member, Some(c)))));
            }
        }
        all
    }

    /// The family under which a case is listed, in one variant or in all: the first that contains it, but families of seeds or time steps come last.
    pub fn family_of(&self, case: &StoredCase, variant: Option<&str>) -> Option<&FamilyRecord> {
        let is_own = |f: &&FamilyRecord| match variant {
            Some(variant) => case.is_in(&f.name, variant),
            None => case.is_of_family(&f.name),
        };
        let is_last = |f: &&FamilyRecord| match f.role {
            Role::Seeds => 2,
            Role::TimeStep => 1,
            _ => 0,
        };
        self.families.iter().filter(is_own).min_by_key(is_last)
    }

    /// The label of a variant, or its name.
    pub fn label(&self, variant: &str) -> String {
        self.labels.get(variant).cloned().unwrap_or_else(|| variant.to_string())
    }

    /// The label of a member, or else the title of the law or the integrator, or its name with spaces.
    pub fn member(&self, name: &str) -> String {
        self.members.get(name).cloned().unwrap_or_else(|| title(name))
    }

    /// Cases without a usable result, each with the reason.
    pub fn incomplete(&self, stored: &[StoredCase]) -> Vec<(String, String)> {
        let mut out: Vec<(String, String)> = vec![];
        let stored: HashMap<&str, &CaseRecord> = stored.iter().map(|c| (c.record.id.as_str(), &c.record)).collect();
        let mut seen = HashSet::new();
        for id in self.families.iter().flat_map(|f| &f.cases) {
            if !seen.insert(id) {
                continue;
            }
            match stored.get(id.as_str()) {
                None => out.push((id.clone(), NOT_RUN.into())),
                Some(r) if !r.converged() => {
                    let detail = r.status_detail.as_ref().map(|d| format!(": {d}")).unwrap_or_default();
                    out.push((id.clone(), format!("{}{detail}", r.status)));
                }
                Some(_) => {}
            }
        }
        out
    }
}

/// A member of a variant, with its case if that has converged.
pub type Member<'a> = (&'a str, Option<&'a StoredCase>);

/// A recorded quantity of interest: a column of `cases/<id>.csv`.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Debug, PartialEq, Default)]
#[serde(deny_unknown_fields)]
pub struct StudyQuantity {
    /// Column, with its unit as the suffix: `bending_angle_deg`
    pub name: String,
    /// Label in words: `bending angle`
    pub label: String,
    /// Symbol in formulae and on axes: `θ`
    pub symbol: String,
    /// Unit as printed: `°`
    pub unit: String,
    /// Quantity against which it is drawn in addition to time, if the loop between the two is meaningful: `cable_length_m`
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub against: Option<Box<StudyQuantity>>,
    /// Error accepted whatever the value, in the unit of the column; a quantity near zero needs one
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absolute_tolerance: Option<f64>,
    /// Whether it decides which setting a convergence study recommends; if no quantity of a variant does, all of them decide
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub deciding: bool,
    /// Whether it summarises a convergence study, in its variant
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub headline: bool,
}

impl StudyQuantity {
    /// The accepted error; `relative` is the tolerance of the study.
    pub fn tolerance(&self, relative: f64) -> Tolerance {
        Tolerance { relative, absolute: self.absolute_tolerance.unwrap_or(0.0) }
    }
}

/// A family of cases that differ in one respect only.
#[derive(Serialize, Deserialize, Clone, Debug)]
pub struct FamilyRecord {
    pub name: String,
    pub role: Role,
    /// Short name of element and formulation: `tet4`, `tet10_up`; that of the last variant if variants differ
    pub formulation: String,
    /// Ids of the cases in all variants, including those without a result
    pub cases: Vec<String>,
    /// Variant and member of each of these cases; empty in files of earlier versions, where the records contain them
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<VariantMember>,
}

impl FamilyRecord {
    /// Formulation of these members of the family. Variants may differ in it; if the members do, the finest mesh decides.
    pub fn formulation_of<'a>(&'a self, members: &[&'a StoredCase]) -> &'a str {
        let finest = members.iter().map(|c| &c.record).min_by(|a, b| a.mesh.h_m.total_cmp(&b.mesh.h_m));
        finest.map(|r| r.formulation.as_str()).filter(|own| !own.is_empty()).unwrap_or(&self.formulation)
    }
}

impl PartialEq for FamilyRecord {
    /// A record of an earlier version that does not list its members does not count as a different family for that reason.
    fn eq(&self, other: &Self) -> bool {
        let key = |f: &Self| (f.name.clone(), f.role, f.formulation.clone());
        let is_unsaid = self.members.is_empty() || other.members.is_empty();
        key(self) == key(other) && self.cases == other.cases && (is_unsaid || self.members == other.members)
    }
}

/// A member of a family in a variant.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct VariantMember {
    pub variant: String,
    pub member: String,
}

/// Purpose of a family of cases.
#[derive(Serialize, Deserialize, JsonSchema, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// The mesh sizes that the study examines, meshed separately
    Sizes,
    /// Each cell split into eight: one size ratio, no mesh noise
    Nested,
    /// Separately meshed with one size ratio
    Remeshed,
    /// One size, several seeds of the mesher, to measure the scatter
    Seeds,
    /// Another element at a few sizes
    Element,
    /// Adaptive meshes for several tolerances
    Adaptive,
    /// One mesh, several time steps
    TimeStep,
    /// One mesh, several laws, formulations or effects
    Members,
    /// The compared members on a finer mesh
    Finer,
    /// The points of a sweep
    Grid,
    /// Effects added one by one
    Cumulative,
    /// A dimension that is not known exactly, varied over its range
    Nuisance,
    /// One mesh, several settings of the solver
    Solver,
    /// A reference run, far finer than needed
    Reference,
    /// Uses of a law with the constants found, on meshes from coarse to fine
    Use,
    /// Scenes that are hard for simulators
    Suite,
    /// Points of a robustness map
    Map,
    /// Points of a response surface, with derivatives
    Design,
    /// Points that measure the error of a response surface
    Check,
    /// States from which a reduced model is built
    Training,
    /// States from which its error bars are determined
    HeldBack,
}

impl Role {
    /// The name of the role in a report.
    pub fn words(self) -> &'static str {
        match self {
            Self::Sizes => "sizes",
            Self::Nested => "nested",
            Self::Remeshed => "remeshed",
            Self::Seeds => "seeds",
            Self::Element => "element",
            Self::Adaptive => "adaptive",
            Self::TimeStep => "time step",
            Self::Members => "members",
            Self::Finer => "finer",
            Self::Grid => "grid",
            Self::Cumulative => "cumulative",
            Self::Nuisance => "nuisance",
            Self::Solver => "solver",
            Self::Reference => "reference",
            Self::Use => "use",
            Self::Suite => "suite",
            Self::Map => "map",
            Self::Design => "design",
            Self::Check => "check",
            Self::Training => "training",
            Self::HeldBack => "held back",
        }
    }
}
