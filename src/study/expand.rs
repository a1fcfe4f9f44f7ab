//! A study file expanded into cases.

use crate::material;
use crate::scene::{SceneError, read_scene, read_table};
use crate::storage;
use crate::study::case::Case;
use crate::study::case_list::{Added, CaseList, Changes};
use crate::study::extension::AddedMeshes;
use crate::study::kind::{RunRules, StoredExpansion, StudyScope};
use crate::study::kinds::KINDS;
use crate::study::rounds::{self, Rounds};
use crate::study::spec::{FamilySpec, MOST_CASES, VariantSpec, check_names, refuse};
use crate::study::store::record::{FamilyRecord, Place, Role, SCHEMA, StudyQuantity, StudyRecord, VariantMember};
use crate::study::study_file::{KindName, StudySpec, parse};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

/// A study and its cases.
#[derive(Clone, Debug)]
pub struct Study {
    pub name: String,
    pub file: PathBuf,
    pub record: StudyRecord,
    pub rules: RunRules,
    /// Family → columns that its cases must record, if they are not those of the quantities of the variant
    pub columns: BTreeMap<String, Vec<String>>,
    pub cases: Vec<Case>,
    /// Case → its families and variants
    places: HashMap<String, Vec<Place>>,
    /// Changes made to every case
    changes: Vec<(String, toml::Value)>,
    /// Digest of the inputs of cases that the study requests later
    pub source_sha256: String,
}

impl Study {
    /// Name of the study in a file: the name of its folder.
    pub fn name_of(file: &Path) -> String {
        let name = |path: PathBuf| path.parent()?.file_name().map(|n| n.to_string_lossy().into_owned());
        std::path::absolute(file).ok().and_then(name).unwrap_or_else(|| "study".into())
    }

    /// Reads `study.toml` and expands it. `changes` are applied to every case, last.
    ///
    /// # Errors
    ///
    /// A file, or a scene that it varies, that cannot be read or has a mistake, or a case that is refused.
    pub fn read(file: &Path, changes: &[(String, toml::Value)]) -> Result<Self, SceneError> {
        Self::read_scope(file, changes, StudyScope::Whole)
    }

    /// Reads `study.toml` and expands it with the meshes that were added to its results in `dir`.
    pub fn read_with_added(file: &Path, changes: &[(String, toml::Value)], dir: &Path) -> Result<Self, SceneError> {
        let (meshes, rounds) = (AddedMeshes::read(dir)?, Rounds::read(dir));
        Self::expand(file, changes, StudyScope::Whole, |expansion, source| {
            rounds.add_to(&mut expansion.families, source);
            Ok(Added { file: AddedMeshes::file(dir), lines: meshes.add_to(&mut expansion.families, dir)? })
        })
    }

    /// Reads `study.toml` and expands it to the cases of the results in `dir`, including the meshes added to them and the cases that any build has
    /// requested.
    pub fn read_as_stored(file: &Path, dir: &Path) -> Result<Self, SceneError> {
        let (meshes, rounds) = (AddedMeshes::read(dir)?, Rounds::read(dir));
        Self::expand(file, &[], StudyScope::Whole, |expansion, _| {
            rounds.add_to(&mut expansion.families, &rounds.of);
            Ok(Added { file: AddedMeshes::file(dir), lines: meshes.add_to(&mut expansion.families, dir)? })
        })
    }

    /// Reads this study again, with what was added to its results in `dir`.
    pub fn again(&self, dir: &Path) -> Result<Self, SceneError> {
        Self::read_with_added(&self.file, &self.changes, dir)
    }

    /// Reads the part of `study.toml` that `scope` selects, and expands it.
    pub fn read_scope(file: &Path, changes: &[(String, toml::Value)], scope: StudyScope) -> Result<Self, SceneError> {
        Self::expand(file, changes, scope, |_, _| Ok(Added::default()))
    }

    fn expand(
        file: &Path,
        changes: &[(String, toml::Value)],
        scope: StudyScope,
        add: impl FnOnce(&mut StoredExpansion, &str) -> Result<Added, SceneError>,
    ) -> Result<Self, SceneError> {
        let (text, table) = read_table(file)?;
        if table.contains_key("mesh") && !table.contains_key("family") {
            let (place, fact) = ("file".into(), "this is a scene, not a study".into());
            return Err(refuse(file, (place, fact, "run it with: durometer simulate".into())));
        }
        let (spec, mut expansion) = parse(file, &text, scope)?;
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

    /// Builds a study around a single scene, of the kind that supports this. It varies the scene with the changes.
    pub fn around(scene: &Path, changes: &[(String, toml::Value)]) -> Result<Self, SceneError> {
        // Errors in the scene then name the file as it was given
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
        let tolerance = spec.tolerance().map_err(|mistake| refuse(file, mistake))?;
        let known: Vec<String> = expansion.variants.iter().map(|v| v.name.clone()).collect();
        let labels: Vec<String> = expansion.families.iter().map(|f| f.name.clone()).collect();
        for (what, names) in [("variant", &known), ("family", &labels)] {
            check_names(names)
                .map_err(|(k, fact, remedy)| refuse(file, (format!("{what} {}", k + 1), fact, remedy.into())))?;
        }
        check_number(file, &expansion)?;
        check_curves(file, &expansion)?;
        let mut cases = CaseList::new(file, scene, &expansion, changes);
        let mut families = expansion.families.iter().map(|f| cases.family(f)).collect::<Result<Vec<_>, _>>()?;
        let mut quantities: BTreeMap<String, Vec<StudyQuantity>> =
            expansion.variants.iter().map(|v| (v.name.clone(), v.quantities.clone())).collect();
        if let Some(usage) = &expansion.usage {
            let family = cases.uses(usage)?;
            quantities.extend(family.members.iter().map(|m| (m.variant.clone(), vec![usage.quantity.clone()])));
            families.push(family);
        }
        let (cases, overridden) = cases.end();
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
            overridden,
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

    /// Number of runs of a case. A case that is far finer than needed is a reference, whose cost is not measured.
    pub fn repeats(&self, case: &Case) -> usize {
        if self.is_reference(case) { 1 } else { self.rules.repeats }
    }

    /// Whether a case belongs to a design, for which derivatives are computed.
    pub fn is_of_design(&self, case: &Case) -> bool {
        self.record.families.iter().any(|f| f.name == case.family && f.role == Role::Design)
    }

    /// Whether the errors of a case are estimated from its own run.
    pub fn estimates_errors(&self, case: &Case) -> bool {
        self.rules.error_estimates && !self.is_reference(case)
    }

    /// Columns that are judged in a case, in any family and variant to which it belongs.
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

    /// Whether a case belongs to families of references only.
    fn is_reference(&self, case: &Case) -> bool {
        let is_one = |p: &Place| self.record.families.iter().any(|f| f.name == p.family && f.role == Role::Reference);
        let places = self.places_of(case);
        !places.is_empty() && places.iter().all(is_one)
    }
}

/// Refuses a study with too many cases before they are made.
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

/// Refuses changes of a further curve for a member that no family of its variant has.
fn check_curves(file: &Path, expansion: &StoredExpansion) -> Result<(), SceneError> {
    for (variant, plan) in &expansion.plans {
        let is_run = |f: &&FamilySpec| f.variants.as_ref().is_none_or(|names| names.contains(variant));
        let known: Vec<&String> = expansion.families.iter().filter(is_run).flat_map(|f| f.members.keys()).collect();
        plan.check_members(&known).map_err(|e| SceneError::Part {
            file: file.into(),
            place: format!("variant {variant}"),
            source: e.into(),
        })?;
    }
    Ok(())
}

/// Labels of members: the given labels, and the plain name of a member that is named after a law which one of its scenes lacks, or which every scene of
/// the study has, because the name then does not refer to that law.
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
