//! A study as it stands in a TOML file, and the cases that follow from it.

use crate::calibrate::inverse::MeasuredSpec;
use crate::math::units::{self, Dimension};
use crate::scene::{SceneError, SceneSpec, from_text, hint, read_scene, read_table};
use crate::study::axis::{self, AxisSpec, Combine};
use crate::study::check::{check_axes, check_names, check_roles};
use crate::study::inverse::{After, CalibrationSpec, Plan, UseSpec};
use crate::study::kinds::robustness::around::around;
use crate::study::kinds::robustness::spec::{self as stability, MapSpec, SuiteSpec};
use crate::study::record::{FamilyRecord, Quantity, Role, StudyRecord};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// `studies/<name>/study.toml`
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudySpec {
    pub kind: Kind,
    pub question: String,
    /// What is expected, written before the run
    pub expectation: String,
    /// Scene file, relative to the study
    pub scene: PathBuf,
    /// Largest error bar that is accepted, as a fraction or in %
    pub tolerance: String,
    #[serde(rename = "variant", default)]
    pub variants: Vec<VariantSpec>,
    #[serde(rename = "family", default)]
    pub families: Vec<FamilySpec>,
    /// `materials`: the member that the others are compared with
    pub reference: Option<String>,
    /// `sweep`: the keys that are swept
    #[serde(rename = "axis", default)]
    pub axes: Vec<AxisSpec>,
    /// `sweep`: how several axes go together
    #[serde(default)]
    pub combine: Combine,
    /// `cost`: how often a case is run, for the scatter of its price; once if absent
    pub repeats: Option<usize>,
    /// `calibration`: what is to be found
    pub calibration: Option<CalibrationSpec>,
    /// `calibration`: where the law is used afterwards
    #[serde(rename = "use")]
    pub usage: Option<UseSpec>,
    /// `stability`: scenes that break simulators
    #[serde(rename = "suite", default)]
    pub suites: Vec<SuiteSpec>,
    /// `stability`: where a scene holds
    #[serde(rename = "map", default)]
    pub maps: Vec<MapSpec>,
}

/// The analyses; one of a kind, one line.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Convergence,
    Materials,
    Sweep,
    Prices,
    Cost,
    Calibration,
    Robustness,
}

impl Kind {
    /// As it stands in `study.json`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Convergence => "convergence",
            Self::Materials => "materials",
            Self::Sweep => "sweep",
            Self::Prices => "prices",
            Self::Cost => "cost",
            Self::Calibration => "calibration",
            Self::Robustness => "robustness",
        }
    }

    /// What a family can be there for.
    pub(super) fn roles(self) -> &'static [Role] {
        match self {
            Self::Convergence => {
                &[Role::Sizes, Role::Nested, Role::Remeshed, Role::Seeds, Role::Element, Role::TimeStep]
            }
            Self::Materials => &[Role::Laws, Role::Finer],
            Self::Sweep => &[Role::Grid],
            Self::Prices => &[Role::Ladder],
            Self::Cost => &[Role::Sizes, Role::Element, Role::TimeStep, Role::Solver, Role::Overkill],
            Self::Calibration => &[Role::Sizes, Role::Nuisance],
            Self::Robustness => &[Role::Suite, Role::Map],
        }
    }
}

/// The scene driven in one way, and the quantities judged there.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VariantSpec {
    pub name: String,
    /// In words, for sentences and figures; `<name> control` if absent
    pub label: Option<String>,
    /// Changes by path
    #[serde(default)]
    pub set: toml::Table,
    #[serde(rename = "quantity", default)]
    pub quantities: Vec<Quantity>,
    /// `calibration`: the curve that the scene is to reproduce
    pub measured: Option<MeasuredSpec>,
}

/// Cases that differ in one thing only.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FamilySpec {
    pub name: String,
    pub role: Role,
    /// Variants it is run in, all if absent
    pub variants: Option<Vec<String>>,
    /// Changes for all members
    #[serde(default)]
    pub set: toml::Table,
    /// Label of a member → its changes
    pub members: toml::Table,
    /// Another scene than the study's
    #[serde(skip)]
    pub scene: Option<PathBuf>,
}

/// One scene to be run.
#[derive(Clone, Debug)]
pub struct Case {
    pub id: String,
    pub family: String,
    pub variant: String,
    pub member: String,
    pub scene_file: PathBuf,
    pub spec: SceneSpec,
    /// The scene with all its changes
    pub text: String,
    /// Constants to be found; without them the scene is run as it is
    pub plan: Option<Arc<Plan>>,
    /// Waits for the constants of a calibration
    pub after: Option<After>,
}

/// A study and its cases.
#[derive(Clone, Debug)]
pub struct Study {
    pub name: String,
    pub file: PathBuf,
    pub record: StudyRecord,
    pub cases: Vec<Case>,
}

impl Study {
    /// Reads `study.toml` and expands it. `changes` are made to every case, last.
    pub fn read(file: &Path, changes: &[(String, toml::Value)]) -> Result<Self, SceneError> {
        Self::read_around(file, None, changes)
    }

    /// The same; of kind `stability` with its maps drawn around another scene instead of its own.
    pub fn read_around(
        file: &Path,
        scene: Option<&Path>,
        changes: &[(String, toml::Value)],
    ) -> Result<Self, SceneError> {
        let (text, table) = read_table(file)?;
        if table.contains_key("mesh") && !table.contains_key("family") {
            let (place, fact) = ("file".into(), "this is a scene, not a study".into());
            let remedy = "run it with: durometer simulate".into();
            return Err(SceneError::Content { file: file.into(), place, fact, remedy });
        }
        let mut spec: StudySpec = from_text(file, &text, "")?;
        let base = file.parent().unwrap_or(Path::new(""));
        let name = std::path::absolute(base)
            .ok()
            .and_then(|p| p.file_name().map(|n| n.to_string_lossy().into_owned()))
            .unwrap_or_else(|| "study".into());
        let content = |place: String, fact: String, remedy: &str| SceneError::Content {
            file: file.into(),
            place,
            fact,
            remedy: remedy.into(),
        };
        let tolerance = units::parse(&spec.tolerance, Dimension::NONE)
            .map_err(|e| content("tolerance".into(), e.to_string(), "write for example \"2 %\""))?;
        if !(tolerance > 0.0 && tolerance < 1.0) {
            let fact = format!("it is {tolerance}");
            return Err(content("tolerance".into(), fact, "it lies between 0 and 1; write for example \"2 %\""));
        }
        if let Some(scene) = scene {
            if spec.kind != Kind::Robustness {
                let fact = format!("a study of kind \"{}\" has its own scenes", spec.kind.name());
                return Err(content("--scene".into(), fact, "run hard-cases around a scene of your own"));
            }
            let scene = std::path::absolute(scene).unwrap_or_else(|_| scene.into());
            let own = around(&scene, changes)?;
            (spec.scene, spec.variants, spec.suites, spec.maps) = (scene, own.variants, own.suites, own.maps);
        }
        check_axes(&spec).map_err(|(place, fact, remedy)| content(place, fact, &remedy))?;
        let (mut axes, mut points) = (vec![], BTreeMap::new());
        if spec.kind == Kind::Sweep {
            let expanded = axis::expand(&spec.axes, spec.combine);
            let expanded = expanded.map_err(|(place, fact, remedy)| content(place, fact, &remedy))?;
            spec.families = vec![expanded.family];
            (axes, points) = (expanded.axes, expanded.points);
        }
        let mut hard = stability::Expanded::default();
        if spec.kind == Kind::Robustness {
            hard = stability::expand(&spec).map_err(|(place, fact, remedy)| content(place, fact, &remedy))?;
            spec.families = std::mem::take(&mut hard.families);
        }
        let known: Vec<String> = spec.variants.iter().map(|v| v.name.clone()).collect();
        let labels: Vec<String> = spec.families.iter().map(|f| f.name.clone()).collect();
        for (what, names) in [("variant", &known), ("family", &labels)] {
            check_names(names).map_err(|(k, fact, remedy)| content(format!("{what} {}", k + 1), fact, remedy))?;
        }
        if let Some(variant) = spec.variants.iter().find(|v| v.quantities.is_empty() && spec.kind != Kind::Robustness) {
            let place = format!("variant {}", variant.name);
            let remedy = "add quantity = [{ name = …, label = …, symbol = …, unit = … }] with a recorded column";
            return Err(content(place, "it judges no quantity".into(), remedy));
        }
        check_roles(&spec).map_err(|(place, fact, remedy)| content(place, fact, &remedy))?;
        let scene_file = base.join(&spec.scene);
        read_table(&scene_file).map_err(|e| SceneError::Part {
            file: file.into(),
            place: "scene".into(),
            source: e.into(),
        })?;
        let plans = plans(file, base, &spec)?;
        let mut cases: Vec<Case> = Vec::new();
        let mut families = Vec::new();
        for family in &spec.families {
            let scene_file = family.scene.as_ref().map_or_else(|| scene_file.clone(), |own| base.join(own));
            let wanted = family.variants.as_ref().unwrap_or(&known);
            if let Some(unknown) = wanted.iter().find(|w| !known.contains(w)) {
                let place = format!("family {}", family.name);
                let fact = format!("there is no variant \"{unknown}\"");
                return Err(content(place, fact, &hint(unknown, &known)));
            }
            let members: Vec<String> = family.members.keys().cloned().collect();
            let place = format!("family {}: members", family.name);
            check_names(&members).map_err(|(_, fact, remedy)| content(place, fact, remedy))?;
            let mut ids: Vec<String> = Vec::new();
            let mut formulation = String::new();
            for variant in spec.variants.iter().filter(|v| wanted.contains(&v.name)) {
                // The changes of the rungs below, on a ladder
                let mut below: Vec<(String, toml::Value)> = Vec::new();
                for (label, member) in &family.members {
                    let place = format!("family {}, member {label}, variant {}", family.name, variant.name);
                    let Some(member) = member.as_table() else {
                        return Err(content(place, "it is not a table".into(), "write { \"mesh.cells\" = 4500 }"));
                    };
                    let pairs = |set: &toml::Table| set.clone().into_iter().collect::<Vec<_>>();
                    let own = [pairs(&variant.set), pairs(&family.set), below.clone(), pairs(member)].concat();
                    if family.role == Role::Ladder {
                        below.extend(pairs(member));
                    }
                    // What is drawn around a scene varies the scene with the changes
                    let all = if scene.is_some() { [changes, &own[..]] } else { [&own[..], changes] }.concat();
                    let (scene, text) = read_scene(&scene_file, &all).map_err(|e| {
                        // Whose fault is it: the scene's, the member's, or the command line's?
                        let sound = |changes: &[_]| read_scene(&scene_file, changes).is_ok();
                        if sound(&[]) && !sound(&own) { e.caused_by(file, &place) } else { e }
                    })?;
                    formulation = scene.formulation();
                    // The same scene in two families is run once; a hard case is judged under its own name.
                    let shared = |c: &&Case| c.text == text && (plans.is_empty() || c.variant == variant.name);
                    if let Some(same) = cases.iter().find(shared).filter(|_| spec.kind != Kind::Robustness) {
                        ids.push(same.id.clone());
                        continue;
                    }
                    let id = format!("{}-{}-{label}", family.name, variant.name);
                    if cases.iter().any(|c| c.id == id) {
                        let fact = format!("another case is called {id} too");
                        return Err(content(place, fact, "rename the family, the variant or the member"));
                    }
                    ids.push(id.clone());
                    let (family, variant) = (family.name.clone(), variant.name.clone());
                    let (member, scene_file) = (label.clone(), scene_file.clone());
                    let plan = plans.get(&variant).cloned();
                    cases.push(Case { id, family, variant, member, scene_file, spec: scene, text, plan, after: None });
                }
            }
            families.push(FamilyRecord { name: family.name.clone(), role: family.role, formulation, cases: ids });
        }
        let mut quantities: BTreeMap<String, Vec<Quantity>> =
            spec.variants.iter().map(|v| (v.name.clone(), v.quantities.clone())).collect();
        if let Some(usage) = &spec.usage {
            let more = uses(file, base, usage, &known, changes)?;
            let (ids, formulation) = (more.iter().map(|c| c.id.clone()).collect(), more[0].spec.formulation());
            families.push(FamilyRecord { name: "use".into(), role: Role::Use, formulation, cases: ids });
            quantities.extend(more.iter().map(|c| (c.variant.clone(), vec![usage.quantity.clone()])));
            cases.extend(more);
        }
        if cases.is_empty() {
            let fact = "it has no case".to_string();
            let remedy = "a study needs a [[variant]] and a [[family]] with at least one member";
            return Err(content("study".into(), fact, remedy));
        }
        let named = |v: &VariantSpec| Some((v.name.clone(), v.label.clone()?));
        let record = StudyRecord {
            study: name.clone(),
            kind: spec.kind.name().into(),
            question: spec.question,
            expectation: spec.expectation,
            tolerance,
            quantities,
            variants: known,
            labels: spec.variants.iter().filter_map(named).collect(),
            families,
            reference: spec.reference,
            axes,
            points,
            repeats: spec.repeats.unwrap_or(1),
            suites: hard.suites,
            maps: hard.maps,
            version: env!("CARGO_PKG_VERSION").into(),
        };
        Ok(Self { name, file: file.into(), record, cases })
    }

    /// A scene that is refused is a result, and the other cases go on.
    pub fn keeps_refusals(&self) -> bool {
        self.record.kind == Kind::Robustness.name()
    }

    /// Only the quick half of a study of kind `stability`.
    pub fn quick(mut self) -> Self {
        let record = &mut self.record;
        record.suites.retain(|s| s.quick);
        record.maps.clear();
        record.families.retain(|f| record.suites.iter().any(|s| s.family == f.name));
        self.cases.retain(|c| record.families.iter().any(|f| f.cases.contains(&c.id)));
        self
    }
}

/// Cases of `[use]`, one per variant and member.
fn uses(
    file: &Path,
    base: &Path,
    usage: &UseSpec,
    variants: &[String],
    changes: &[(String, toml::Value)],
) -> Result<Vec<Case>, SceneError> {
    let content = |fact: String, remedy: &str| SceneError::Content {
        file: file.into(),
        place: "use".into(),
        fact,
        remedy: remedy.into(),
    };
    let scene_file = base.join(&usage.scene);
    let members: Vec<String> = usage.members.keys().cloned().collect();
    check_names(&members).map_err(|(_, fact, remedy)| content(fact, remedy))?;
    let mut cases = vec![];
    for variant in variants {
        for (label, member) in &usage.members {
            let Some(member) = member.as_table() else {
                return Err(content(format!("member {label} is not a table"), "write { \"mesh.cells\" = 4500 }"));
            };
            let own = [&usage.set, member].into_iter().flatten().map(|(k, v)| (k.clone(), v.clone()));
            let all: Vec<_> = own.chain(changes.iter().cloned()).collect();
            let (spec, text) = read_scene(&scene_file, &all)?;
            if !spec.laws.contains_key(&usage.law) {
                let known: Vec<&String> = spec.laws.keys().collect();
                return Err(content(format!("its scene has no law \"{}\"", usage.law), &hint(&usage.law, &known)));
            }
            let after = Some(After { variant: variant.clone(), law: usage.law.clone() });
            let (id, family, variant) = (format!("use-{variant}-{label}"), "use".into(), format!("use-{variant}"));
            let (member, scene_file) = (label.clone(), scene_file.clone());
            cases.push(Case { id, family, variant, member, scene_file, spec, text, plan: None, after });
        }
    }
    match cases.is_empty() {
        true => Err(content("it has no member".into(), "add [use.members] with one mesh at least, two for its share")),
        false => Ok(cases),
    }
}

/// What is to be found in each variant.
fn plans(file: &Path, base: &Path, spec: &StudySpec) -> Result<BTreeMap<String, Arc<Plan>>, SceneError> {
    let Some(calibration) = &spec.calibration else { return Ok(BTreeMap::new()) };
    let one = |v: &VariantSpec| {
        let measured = v.measured.as_ref().expect("checked with the roles");
        let plan = Plan::new(base, calibration, measured).map_err(|e| SceneError::Part {
            file: file.into(),
            place: format!("variant {}", v.name),
            source: e.into(),
        })?;
        Ok((v.name.clone(), Arc::new(plan)))
    };
    spec.variants.iter().map(one).collect()
}
