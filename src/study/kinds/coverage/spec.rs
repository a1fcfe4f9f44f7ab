//! `[[material]]`, `[[formulation]]`, `[[truth]]`, `[[seed]]` and `[[problem]]` of a study of kind `coverage`, as families of cases.
//!
//! A family is one problem in one formulation with one seed; its members are the sizes, and its variants the materials. The families of the truth are
//! references: the errors of their cases are not estimated from their own runs.

use crate::scene::changes;
use crate::schema::AnyTable;
use crate::study::kind::{Expansion, RunRules};
use crate::study::kinds::coverage::record::{CoverageRecord, JudgedFamily, ProblemRecord};
use crate::study::spec::{FamilySpec, Mistake, VariantSpec, check_names};
use crate::study::store::record::{Role, StudyQuantity};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Keys of a coverage study.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoverageStudy {
    /// Materials in which every problem is posed
    #[serde(rename = "material", default)]
    pub materials: Vec<ChangesSpec>,
    /// Formulations whose error bars are judged
    #[serde(rename = "formulation", default)]
    pub formulations: Vec<ChangesSpec>,
    /// Formulations that determine the truth on finer meshes
    #[serde(rename = "truth", default)]
    pub truths: Vec<ChangesSpec>,
    /// Several meshes of the same size
    #[serde(rename = "seed", default)]
    pub seeds: Vec<ChangesSpec>,
    /// Boundary value problems
    #[serde(rename = "problem", default)]
    pub problems: Vec<ProblemSpec>,
}

/// Changes to a scene, with a name.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ChangesSpec {
    /// Part of the case ids
    pub name: String,
    /// Name in words; `name` if absent
    pub label: Option<String>,
    /// Changes by path
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// For a formulation, the series of sizes of a problem with which it is run
    pub sizes: Option<String>,
}

/// A boundary value problem without its constants and meshes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProblemSpec {
    /// Part of the case ids
    pub name: String,
    /// The set-up in one line
    pub label: String,
    /// Kind of body by which the counts are grouped
    pub body: String,
    /// Scene file, relative to the study
    pub scene: PathBuf,
    /// Whether no edge is singular
    #[serde(default)]
    pub smooth: bool,
    /// Whether the boundary is curved, so that linear cells cut it
    #[serde(default)]
    pub curved: bool,
    /// Whether it took no part in the choice of the bounds and rules that are judged; such problems are also counted separately
    #[serde(default)]
    pub fresh: bool,
    /// Whether it belongs to the quick half
    #[serde(default)]
    pub quick: bool,
    /// Quantities whose error bars are judged
    #[serde(rename = "quantity")]
    pub quantities: Vec<StudyQuantity>,
    /// Changes by label of a size, by name of a series of sizes; `truth` is the series of the truth
    #[serde(deserialize_with = "changes::of_series")]
    #[schemars(with = "BTreeMap<String, AnyTable>")]
    pub sizes: BTreeMap<String, toml::Table>,
}

/// Name of the series of sizes of the truth.
const TRUTH: &str = "truth";

/// Returns the families and the record of the problems, or the first mistake as place, fact and remedy.
pub fn expand(study: &CoverageStudy) -> Result<Expansion<CoverageRecord>, Mistake> {
    check(study)?;
    let variant = |m: &ChangesSpec| VariantSpec {
        name: m.name.clone(),
        label: m.label.clone(),
        group: None,
        set: m.set.clone(),
        quantities: vec![],
        scene: None,
    };
    let variants = study.materials.iter().map(variant).collect();
    let mut out = Expansion::new(variants, vec![], CoverageRecord::default());
    out.rules = RunRules { error_estimates: true, share_cases: false, ..RunRules::default() };
    for problem in &study.problems {
        let columns: Vec<String> = problem.quantities.iter().map(|q| q.name.clone()).collect();
        let mut add = |name: String, role: Role, set: toml::Table, members: toml::Table| {
            out.columns.insert(name.clone(), columns.clone());
            let scene = Some(problem.scene.clone());
            out.families.push(FamilySpec {
                name: name.clone(),
                role,
                variants: None,
                set,
                members,
                labels: BTreeMap::new(),
                own: BTreeMap::new(),
                scene,
            });
            name
        };
        let (mut judged, mut truths) = (vec![], vec![]);
        for f in &study.formulations {
            let members = series(problem, f, f.sizes.as_deref().unwrap_or(&f.name))?;
            for seed in &study.seeds {
                let set = f.set.clone().into_iter().chain(seed.set.clone()).collect();
                let name = format!("{}-{}-{}", problem.name, f.name, seed.name);
                judged.push(JudgedFamily {
                    family: add(name, Role::Sizes, set, members.clone()),
                    seed: seed.name.clone(),
                });
            }
        }
        for t in &study.truths {
            let name = format!("{}-{TRUTH}-{}", problem.name, t.name);
            truths.push(add(name, Role::Reference, t.set.clone(), series(problem, t, TRUTH)?));
        }
        let ProblemSpec { name, label, body, smooth, curved, fresh, quantities, .. } = problem.clone();
        out.details.problems.push(ProblemRecord {
            name,
            label,
            body,
            smooth,
            curved,
            fresh,
            quantities,
            judged,
            truths,
        });
    }
    Ok(out)
}

fn series(problem: &ProblemSpec, changes: &ChangesSpec, name: &str) -> Result<toml::Table, Mistake> {
    let fact = || format!("{} is run with the sizes \"{name}\", which it does not have", changes.name);
    let remedy = || format!("add sizes.{name} = {{ n2 = {{ \"mesh.grid.divisions\" = [2, 2, 2] }} }}");
    let found = problem.sizes.get(name).filter(|members| !members.is_empty()).cloned();
    found.ok_or_else(|| (format!("problem {}", problem.name), fact(), remedy()))
}

fn check(study: &CoverageStudy) -> Result<(), Mistake> {
    let lists = [
        ("material", &study.materials, 1),
        ("formulation", &study.formulations, 1),
        ("seed", &study.seeds, 1),
        ("truth", &study.truths, 2),
    ];
    for (what, list, least) in lists {
        if list.len() < least {
            let remedy = format!("add [[{what}]] with name and set; at least {least}");
            return Err((what.into(), format!("the study has {}", list.len()), remedy));
        }
        let names: Vec<String> = list.iter().map(|c| c.name.clone()).collect();
        check_names(&names).map_err(|(k, fact, remedy)| (format!("{what} {}", k + 1), fact, remedy.to_string()))?;
        let sized = list.iter().find(|c| c.sizes.is_some()).filter(|_| what != "formulation");
        if let Some(c) = sized {
            let place = format!("{what} {}", c.name);
            return Err((place, "`sizes` has no effect here".into(), "remove it".into()));
        }
    }
    match study.problems.iter().find(|p| p.quantities.is_empty()) {
        Some(p) => {
            let remedy = "add quantity = [{ name = …, label = …, symbol = …, unit = … }] with a recorded column";
            Err((format!("problem {}", p.name), "it judges no quantity".into(), remedy.into()))
        }
        None => Ok(()),
    }
}
