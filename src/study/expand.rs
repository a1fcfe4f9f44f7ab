//! A study file expanded into cases.

use crate::material;
use crate::math::units::{self, Dimension};
use crate::scene::{SceneError, from_text, hint, read_scene, read_table};
use crate::storage;
use crate::study::calibration_plan::{CalibrationPlan, Member, UseSpec};
use crate::study::case::{After, Case};
use crate::study::extension::{AddedLines, AddedMeshes, at_line};
use crate::study::kind::{Extent, RunRules, StoredExpansion};
use crate::study::kinds::KINDS;
use crate::study::overridden::Differences;
use crate::study::rounds::{self, Rounds};
use crate::study::spec::{FamilySpec, MOST_CASES, VariantSpec, check_names, refuse};
use crate::study::store::case_files::is_ambiguous;
use crate::study::store::record::{FamilyRecord, Place, Quantity, Role, SCHEMA, StudyRecord, VariantMember};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error};
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The keys of `studies/<name>/study.toml` that every kind has.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct StudySpec {
    /// Kind of the study
    pub kind: KindName,
    /// The question that the study answers
    pub question: String,
    /// The expectation, written before the run
    pub expectation: String,
    /// Scene file, relative to the study
    pub scene: PathBuf,
    /// Largest error bar that is accepted, as a fraction or in %
    pub tolerance: String,
}

/// A name in the registry of kinds.
#[derive(Clone, Debug)]
pub struct KindName(pub String);

impl JsonSchema for KindName {
    fn schema_name() -> Cow<'static, str> {
        "KindName".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "enum": KINDS.map(|kind| kind.name) })
    }
}

impl<'de> Deserialize<'de> for KindName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const NAMES: [&str; KINDS.len()] = {
            let mut names = [""; KINDS.len()];
            let mut k = 0;
            while k < KINDS.len() {
                names[k] = KINDS[k].name;
                k += 1;
            }
            names
        };
        let name = String::deserialize(deserializer)?;
        if NAMES.contains(&name.as_str()) { Ok(Self(name)) } else { Err(D::Error::unknown_variant(&name, &NAMES)) }
    }
}

/// A study and its cases.
#[derive(Clone, Debug)]
pub struct Study {
    pub name: String,
    pub file: PathBuf,
    pub record: StudyRecord,
    pub rules: RunRules,
    /// Family → columns its cases must record, where they are not those of the quantities of the variant
    pub columns: BTreeMap<String, Vec<String>>,
    pub cases: Vec<Case>,
    /// Case → its places
    places: HashMap<String, Vec<Place>>,
    /// Changes that were made to every case
    changes: Vec<(String, toml::Value)>,
    /// Digest of what cases that the study asks for later depend on
    pub source_sha256: String,
}

/// The text of a study file as its common keys and what its kind makes of the others.
pub fn parse(file: &Path, text: &str, extent: Extent) -> Result<(StudySpec, StoredExpansion), SceneError> {
    let spec: StudySpec = from_text(file, text, "")?;
    let kind = KINDS.iter().find(|k| k.name == spec.kind.0).expect("the name was read from the registry");
    let expansion = (kind.expand)(file, text, extent)?;
    Ok((spec, expansion))
}

impl Study {
    /// The name of the study of a file, that of its folder.
    pub fn name_of(file: &Path) -> String {
        let name = |path: PathBuf| path.parent()?.file_name().map(|n| n.to_string_lossy().into_owned());
        std::path::absolute(file).ok().and_then(name).unwrap_or_else(|| "study".into())
    }

    /// Reads `study.toml` and expands it. `changes` are made to every case, last.
    ///
    /// # Errors
    ///
    /// Where the file, or the scene that it varies, cannot be read, has a mistake, or makes a case that is refused.
    pub fn read(file: &Path, changes: &[(String, toml::Value)]) -> Result<Self, SceneError> {
        Self::read_extent(file, changes, Extent::Whole)
    }

    /// Reads `study.toml` and expands it with the meshes that were added to its results in `dir`.
    pub fn read_with_added(file: &Path, changes: &[(String, toml::Value)], dir: &Path) -> Result<Self, SceneError> {
        let (additions, rounds) = (AddedMeshes::read(dir)?, Rounds::read(dir));
        Self::expand(file, changes, Extent::Whole, |expansion, source| {
            rounds.add_to(&mut expansion.families, source);
            Ok(Added { file: AddedMeshes::file(dir), lines: additions.add_to(&mut expansion.families, dir)? })
        })
    }

    /// Reads `study.toml` and expands it to the cases of the results in `dir`: with the meshes that were added to them, and the cases that any build
    /// has asked for.
    pub fn read_as_stored(file: &Path, dir: &Path) -> Result<Self, SceneError> {
        let (additions, rounds) = (AddedMeshes::read(dir)?, Rounds::read(dir));
        Self::expand(file, &[], Extent::Whole, |expansion, _| {
            rounds.add_to(&mut expansion.families, &rounds.of);
            Ok(Added { file: AddedMeshes::file(dir), lines: additions.add_to(&mut expansion.families, dir)? })
        })
    }

    /// The same study, read again with what was added to its results in `dir`.
    pub fn again(&self, dir: &Path) -> Result<Self, SceneError> {
        Self::read_with_added(&self.file, &self.changes, dir)
    }

    /// Reads as much of `study.toml` as `extent` says, and expands it.
    pub fn read_extent(file: &Path, changes: &[(String, toml::Value)], extent: Extent) -> Result<Self, SceneError> {
        Self::expand(file, changes, extent, |_, _| Ok(Added::default()))
    }

    fn expand(
        file: &Path,
        changes: &[(String, toml::Value)],
        extent: Extent,
        add: impl FnOnce(&mut StoredExpansion, &str) -> Result<Added, SceneError>,
    ) -> Result<Self, SceneError> {
        let (text, table) = read_table(file)?;
        if table.contains_key("mesh") && !table.contains_key("family") {
            let (place, fact) = ("file".into(), "this is a scene, not a study".into());
            return Err(refuse(file, (place, fact, "run it with: durometer simulate".into())));
        }
        let (spec, mut expansion) = parse(file, &text, extent)?;
        let base = file.parent().unwrap_or(Path::new(""));
        let scene = base.join(&spec.scene);
        read_table(&scene).map_err(|e| SceneError::Part {
            file: file.into(),
            place: "scene".into(),
            source: e.into(),
        })?;
        let columns = expansion.variants.iter().flat_map(|v| &v.quantities).map(|q| q.name.as_str());
        let source = rounds::digest(&expansion.details, &columns.collect::<Vec<_>>(), &scene, changes)?;
        let added = add(&mut expansion, &source)?;
        let name = Self::name_of(file);
        let changes = Changes { given: changes, first: false, added };
        Ok(Self { source_sha256: source, ..Self::assemble(&name, file, &scene, spec, expansion, &changes)? })
    }

    /// The study around a scene of one's own, of the kind that offers one. It varies the scene with the changes.
    pub fn around(scene: &Path, changes: &[(String, toml::Value)]) -> Result<Self, SceneError> {
        // A mistake in the scene names the file as it was given
        read_scene(scene, changes)?;
        let scene = std::path::absolute(scene).unwrap_or_else(|_| scene.into());
        let offers = KINDS.iter().find_map(|kind| Some((kind.name, kind.around?)));
        let (kind, around) = offers.expect("a kind of study offers one around a scene");
        let expansion = (around.expand)(&scene, changes)?;
        let spec = StudySpec {
            kind: KindName(kind.into()),
            question: around.question.into(),
            expectation: around.expectation.into(),
            scene: scene.clone(),
            tolerance: around.tolerance.into(),
        };
        let stem = scene.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let changes = Changes { given: changes, first: true, added: Added::default() };
        Self::assemble(&format!("{kind}-{stem}"), &scene, &scene, spec, expansion, &changes)
    }

    fn assemble(
        name: &str,
        file: &Path,
        scene: &Path,
        spec: StudySpec,
        expansion: StoredExpansion,
        changes: &Changes,
    ) -> Result<Self, SceneError> {
        let tolerance = tolerance(&spec.tolerance).map_err(|mistake| refuse(file, mistake))?;
        let known: Vec<String> = expansion.variants.iter().map(|v| v.name.clone()).collect();
        let labels: Vec<String> = expansion.families.iter().map(|f| f.name.clone()).collect();
        for (what, names) in [("variant", &known), ("family", &labels)] {
            check_names(names)
                .map_err(|(k, fact, remedy)| refuse(file, (format!("{what} {}", k + 1), fact, remedy.into())))?;
        }
        check_number(file, &expansion)?;
        let (all, ids, scenes) = (vec![], HashSet::new(), HashMap::new());
        let differences = Differences::default();
        let mut cases = CaseList { file, scene, expansion: &expansion, changes, all, ids, scenes, differences };
        let mut families = expansion.families.iter().map(|f| cases.family(f)).collect::<Result<Vec<_>, _>>()?;
        let mut quantities: BTreeMap<String, Vec<Quantity>> =
            expansion.variants.iter().map(|v| (v.name.clone(), v.quantities.clone())).collect();
        if let Some(usage) = &expansion.usage {
            let more = uses(file, usage, &known, changes.given, &mut cases.differences)?;
            let (ids, formulation) = (more.iter().map(|c| c.id.clone()).collect(), more[0].spec.formulation());
            let member = |c: &Case| VariantMember { variant: c.variant.clone(), member: c.member.clone() };
            let members = more.iter().map(member).collect();
            families.push(FamilyRecord { name: "use".into(), role: Role::Use, formulation, cases: ids, members });
            quantities.extend(more.iter().map(|c| (c.variant.clone(), vec![usage.quantity.clone()])));
            cases.all.extend(more);
        }
        let CaseList { all: cases, differences, .. } = cases;
        if cases.is_empty() {
            let remedy = "a study needs a [[variant]] and a [[family]] with at least one member";
            return Err(refuse(file, ("study".into(), "it has no case".into(), remedy.into())));
        }
        let named = |v: &VariantSpec| Some((v.name.clone(), v.label.clone()?));
        let record = StudyRecord {
            schema: SCHEMA,
            study: name.into(),
            kind: spec.kind.0,
            question: spec.question,
            expectation: spec.expectation,
            tolerance,
            quantities,
            labels: expansion.variants.iter().filter_map(named).collect(),
            groups: expansion.variants.iter().filter_map(|v| Some((v.name.clone(), v.group.clone()?))).collect(),
            members: member_labels(&expansion.families, &families, &cases),
            variants: known,
            families,
            details: expansion.details,
            version: env!("CARGO_PKG_VERSION").into(),
            asks: Some(expansion.rules.asks()),
            inputs_sha256: BTreeMap::new(),
            overridden: differences.overridden(),
        };
        let StoredExpansion { rules, columns, .. } = expansion;
        let (changes, source_sha256, places) = (changes.given.to_vec(), String::new(), record.places(|_| None));
        let (name, file) = (name.into(), file.into());
        Ok(Self { name, file, record, rules, columns, cases, places, changes, source_sha256 })
    }

    /// Digest of the study with all changes of its cases.
    pub fn sha256(&self) -> String {
        let cases: Vec<(&str, &str)> = self.cases.iter().map(|c| (c.id.as_str(), c.text.as_str())).collect();
        storage::sha256(format!("{:?} {cases:?}", self.record))
    }

    /// Runs of a case. What is far finer than needed is a reference, whose cost is not asked for.
    pub fn repeats(&self, case: &Case) -> usize {
        if self.is_reference(case) { 1 } else { self.rules.repeats }
    }

    /// Whether the errors of a case are estimated from its own run.
    pub fn estimates_errors(&self, case: &Case) -> bool {
        self.rules.error_estimates && !self.is_reference(case)
    }

    /// Columns that are judged in a case, in any of its places.
    pub fn columns_of(&self, case: &Case) -> Vec<String> {
        let mut all: Vec<String> = vec![];
        for place in self.places_of(case) {
            let of_variant =
                || self.record.quantities.get(&place.variant).into_iter().flatten().map(|q| q.name.clone());
            let own = self.columns.get(&place.family).cloned().unwrap_or_else(|| of_variant().collect());
            all.extend(own.into_iter().filter(|name| !all.contains(name)).collect::<Vec<_>>());
        }
        all
    }

    fn places_of(&self, case: &Case) -> &[Place] {
        self.places.get(&case.id).map_or(&[], Vec::as_slice)
    }

    /// Whether a case is in families of references only.
    fn is_reference(&self, case: &Case) -> bool {
        let is_one = |p: &Place| self.record.families.iter().any(|f| f.name == p.family && f.role == Role::Reference);
        let places = self.places_of(case);
        !places.is_empty() && places.iter().all(is_one)
    }
}

/// Refuses a study of too many cases, before they are made.
fn check_number(file: &Path, expansion: &StoredExpansion) -> Result<(), SceneError> {
    let of_family = |family: &FamilySpec| {
        let wanted = |v: &&VariantSpec| family.variants.as_ref().is_none_or(|names| names.contains(&v.name));
        let own = |v: &VariantSpec| family.own.get(&v.name).map_or(0, toml::Table::len);
        expansion.variants.iter().filter(wanted).map(|v| family.members.len() + own(v)).sum::<usize>()
    };
    let number: usize = expansion.families.iter().map(of_family).sum();
    if number <= MOST_CASES {
        return Ok(());
    }
    let remedy =
        format!("take fewer values, members or variants, or divide the study: it has at most {MOST_CASES} cases");
    Err(refuse(file, ("study".into(), format!("its variants and families make {number} cases"), remedy)))
}

fn tolerance(text: &str) -> Result<f64, (String, String, String)> {
    let place = || "tolerance".to_string();
    let tolerance = units::parse(text, Dimension::NONE)
        .map_err(|e| (place(), e.to_string(), "write for example \"2 %\"".to_string()))?;
    if tolerance > 0.0 && tolerance < 1.0 {
        return Ok(tolerance);
    }
    Err((place(), format!("it is {tolerance}"), "it lies between 0 and 1; write for example \"2 %\"".into()))
}

/// Keys of a scene with the values that they are set to, in the order of their setting.
type Pairs = [(String, toml::Value)];

/// Changes of the command line, made before or after those of the study, and the members that were added to it.
struct Changes<'a> {
    given: &'a [(String, toml::Value)],
    first: bool,
    added: Added,
}

/// Members that another file has added to the study.
#[derive(Default)]
struct Added {
    file: PathBuf,
    lines: AddedLines,
}

/// The cases of a study as they are found, family after family.
struct CaseList<'a> {
    file: &'a Path,
    scene: &'a Path,
    expansion: &'a StoredExpansion,
    changes: &'a Changes<'a>,
    all: Vec<Case>,
    ids: HashSet<String>,
    /// Variant with what is asked of it, where it counts, and scene → id of the case that runs it
    scenes: HashMap<(String, String), String>,
    differences: Differences,
}

impl CaseList<'_> {
    /// The file that has a member of a family, and the place of the member there.
    fn origin(&self, family: &FamilySpec, label: &str, place: &str) -> (&Path, String) {
        let Added { file, lines } = &self.changes.added;
        match lines.get(&(family.name.clone(), label.into())) {
            Some(line) => (file, at_line(Some(line), place)),
            None => (self.file, place.into()),
        }
    }

    fn family(&mut self, family: &FamilySpec) -> Result<FamilyRecord, SceneError> {
        let file = self.file;
        let mistake = |place: String, fact: String, remedy: String| refuse(file, (place, fact, remedy));
        let base = file.parent().unwrap_or(Path::new(""));
        let expansion = self.expansion;
        let known: Vec<String> = expansion.variants.iter().map(|v| v.name.clone()).collect();
        let wanted = family.variants.as_ref().unwrap_or(&known);
        if let Some(unknown) = wanted.iter().find(|w| !known.contains(w)) {
            let fact = format!("there is no variant \"{unknown}\"");
            return Err(mistake(format!("family {}", family.name), fact, hint(unknown, &known)));
        }
        let (mut ids, mut places) = (Vec::new(), Vec::new());
        let mut formulation = String::new();
        for variant in expansion.variants.iter().filter(|v| wanted.contains(&v.name)) {
            let own = variant.scene.as_ref().or(family.scene.as_ref());
            let scene_file = own.map_or_else(|| self.scene.to_path_buf(), |own| base.join(own));
            // The changes of the members before, where they add up
            let mut before: Vec<(String, toml::Value)> = Vec::new();
            let members: Vec<(&String, &toml::Value)> =
                family.members.iter().chain(family.own.get(&variant.name).into_iter().flatten()).collect();
            let labels: Vec<String> = members.iter().map(|(label, _)| (*label).clone()).collect();
            let place = format!("family {}: members", family.name);
            check_names(&labels).map_err(|(k, fact, remedy)| {
                let (file, place) = self.origin(family, &labels[k], &place);
                refuse(file, (place, fact, remedy.into()))
            })?;
            for (label, member) in members {
                let place = format!("family {}, member {label}, variant {}", family.name, variant.name);
                let Some(member) = member.as_table() else {
                    let remedy = "write { \"mesh.cells\" = 4500 }".into();
                    let (file, place) = self.origin(family, label, &place);
                    return Err(refuse(file, (place, "it is not a table".into(), remedy)));
                };
                let pairs = |set: &toml::Table| set.clone().into_iter().collect::<Vec<_>>();
                let others = [pairs(&variant.set), pairs(&family.set), before.clone()].concat();
                if family.role == Role::Cumulative {
                    before.extend(pairs(member));
                }
                let (id, found) =
                    self.case((family, variant, label), &scene_file, (&others, &pairs(member)), &place)?;
                ids.push(id);
                places.push(VariantMember { variant: variant.name.clone(), member: label.clone() });
                formulation = found;
            }
        }
        Ok(FamilyRecord { name: family.name.clone(), role: family.role, formulation, cases: ids, members: places })
    }

    /// Id and formulation of a case, which is a new one unless the same scene is run already.
    fn case(
        &mut self,
        (family, variant, label): (&FamilySpec, &VariantSpec, &String),
        scene_file: &Path,
        (others, member): (&Pairs, &Pairs),
        place: &str,
    ) -> Result<(String, String), SceneError> {
        let (given, own) = (self.changes.given, &[others, member].concat()[..]);
        let all = if self.changes.first { [given, own] } else { [own, given] }.concat();
        let (spec, text) = read_scene(scene_file, &all).map_err(|e| {
            // The fault is that of the study if the scene alone is sound and the changes of the study are not, and that of the file which has the member
            // if the other changes are sound.
            let sound = |changes: &[_]| read_scene(scene_file, changes).is_ok();
            match sound(&[]) && !sound(own) {
                true if sound(others) => {
                    let (file, place) = self.origin(family, label, place);
                    e.caused_by(file, &place)
                }
                true => e.caused_by(self.file, place),
                false => e,
            }
        })?;
        if !self.changes.first {
            self.differences.add(scene_file, own, given);
        }
        let formulation = spec.formulation();
        let expansion = self.expansion;
        let plan = self.plan((family, variant, label), scene_file, member, place)?;
        let asked = plan.as_ref().map_or_else(String::new, |p| format!("{} {}", variant.name, p.sha256));
        let scene = (asked, text.clone());
        if let Some(same) = self.scenes.get(&scene).filter(|_| expansion.rules.share_cases) {
            return Ok((same.clone(), formulation));
        }
        let id = format!("{}-{}-{label}", family.name, variant.name);
        let derivatives = match family.role {
            Role::Design => expansion.derivatives.get(&variant.name).cloned().unwrap_or_default(),
            _ => vec![],
        };
        if !self.ids.insert(id.clone()) {
            let fact = format!("another case is called {id} too");
            let remedy = "rename the family, the variant or the member".into();
            let (file, place) = self.origin(family, label, place);
            return Err(refuse(file, (place, fact, remedy)));
        }
        if is_ambiguous(&id) {
            let fact = format!("the files of case {id} would have the names of files of another case");
            let remedy = "rename it without the end behind the last dot, or write a hyphen for the dot".into();
            let (file, place) = self.origin(family, label, place);
            return Err(refuse(file, (place, fact, remedy)));
        }
        self.scenes.entry(scene).or_insert_with(|| id.clone());
        self.all.push(Case {
            id: id.clone(),
            family: family.name.clone(),
            variant: variant.name.clone(),
            member: label.clone(),
            scene_file: scene_file.to_path_buf(),
            spec,
            text,
            plan,
            after: None,
            derivatives,
        });
        Ok((id, formulation))
    }

    /// The constants to be found in the case of a member.
    fn plan(
        &self,
        (family, variant, label): (&FamilySpec, &VariantSpec, &String),
        scene_file: &Path,
        own: &Pairs,
        place: &str,
    ) -> Result<Option<Arc<CalibrationPlan>>, SceneError> {
        let Some(plan) = self.expansion.plans.get(&variant.name) else { return Ok(None) };
        let set: Vec<_> = family.set.clone().into_iter().collect();
        let member = Member { scene_file, label, family: &set, own, given: self.changes.given };
        plan.of(&member).map(Some).map_err(|e| {
            let (file, place) = self.origin(family, label, place);
            SceneError::Part { file: file.into(), place, source: e.into() }
        })
    }
}

/// Cases of `[use]`, one per variant and member.
fn uses(
    file: &Path,
    usage: &UseSpec,
    variants: &[String],
    changes: &Pairs,
    differences: &mut Differences,
) -> Result<Vec<Case>, SceneError> {
    let content = |fact: String, remedy: &str| SceneError::Content {
        file: file.into(),
        place: "use".into(),
        fact,
        remedy: remedy.into(),
    };
    let scene_file = file.parent().unwrap_or(Path::new("")).join(&usage.scene);
    let members: Vec<String> = usage.members.keys().cloned().collect();
    check_names(&members).map_err(|(_, fact, remedy)| content(fact, remedy))?;
    let mut cases = vec![];
    for variant in variants {
        for (label, member) in &usage.members {
            let Some(member) = member.as_table() else {
                return Err(content(format!("member {label} is not a table"), "write { \"mesh.cells\" = 4500 }"));
            };
            let own = [&usage.set, member].into_iter().flatten().map(|(k, v)| (k.clone(), v.clone()));
            let own: Vec<_> = own.collect();
            let (spec, text) = read_scene(&scene_file, &[&own, changes].concat())?;
            differences.add(&scene_file, &own, changes);
            if !spec.laws.contains_key(&usage.law) {
                let known: Vec<&String> = spec.laws.keys().collect();
                return Err(content(format!("its scene has no law \"{}\"", usage.law), &hint(&usage.law, &known)));
            }
            let after = Some(After { variant: variant.clone(), law: usage.law.clone() });
            let (id, family, variant) = (format!("use-{variant}-{label}"), "use".into(), format!("use-{variant}"));
            if is_ambiguous(&id) {
                let fact = format!("the files of case {id} would have the names of files of another case");
                return Err(content(
                    fact,
                    "rename it without the end behind the last dot, or write a hyphen for the dot",
                ));
            }
            let (member, scene_file) = (label.clone(), scene_file.clone());
            let (plan, derivatives) = (None, vec![]);
            cases.push(Case { id, family, variant, member, scene_file, spec, text, plan, after, derivatives });
        }
    }
    match cases.is_empty() {
        true => Err(content("it has no member".into(), "add [use.members] with one mesh at least, two for its share")),
        false => Ok(cases),
    }
}

/// Labels of members: those that are given, and the plain names of members that are named like a law which the scene of a case of theirs has not, or
/// which every scene of the study has, so that the name is that of something else.
fn member_labels(given: &[FamilySpec], families: &[FamilyRecord], cases: &[Case]) -> BTreeMap<String, String> {
    let has = |case: &Case, law: &str| {
        case.spec.laws.values().any(|table| table.get("law").and_then(toml::Value::as_str) == Some(law))
    };
    let scenes: HashMap<&str, &Case> = cases.iter().map(|case| (case.id.as_str(), case)).collect();
    let members = families.iter().flat_map(|f| f.members.iter().zip(&f.cases));
    let misleading = members.filter_map(|(VariantMember { member, .. }, id)| {
        let plain = member.replace('_', " ");
        let is_law = has(scenes[id.as_str()], member) && !cases.iter().all(|case| has(case, member));
        (!is_law && material::title(member) != plain).then(|| (member.clone(), plain))
    });
    misleading.chain(given.iter().flat_map(|f| f.labels.clone())).collect()
}
